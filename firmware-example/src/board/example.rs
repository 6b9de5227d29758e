//! The parameters of a node on a board with an ADXL362, and its energies by the figures of `energy::cost`.

use model_core::bounds::ParameterError;
use model_core::energy::cost::{
    Accelerometer, Code, CostModel, Instructions, Processor, Radio, node_instructions,
};
use model_core::energy::response_map::MapError;
use model_core::energy::{Capacitor, ResponseMap, StorageParameters};
use model_core::excitation::{ExcitationError, LineBank};
use model_core::node::{
    Bursts, Converter, MapNode, MapParameters, NodeError, Regular, Sensor, Tolerances, VoltageParameters,
};

use super::adxl362::{Range, Rate};
use crate::workload::response_map::contact_separation;

/// Samples of a section of the bank of lines, and sections of a block: 3.2 s at 400 Hz.
const SECTION: usize = 80;
const SECTIONS: usize = 16;
/// Number of actions.
const ACTIONS: usize = 2;

/// The node of this board.
pub type ExampleNode = MapNode<&'static [u16], SECTION, SECTIONS, ACTIONS>;
/// The node with its board.
pub type Runner<'a, B> = model_core::node::Runner<'a, B, ExampleNode>;

/// Range of the accelerometer.
pub const RANGE: Range = Range::G2;
/// Rate of the accelerometer.
pub const RATE: Rate = Rate::Hz400;
/// m/s² of a count in that range: 1 mg.
pub const UNIT: f32 = 1e-3 * model_core::part::GRAVITY as f32;
/// Voltage of the full code of a converter of 12 bits.
pub const FULL_SCALE: f32 = 3.6;
/// What the node can do, by its index.
pub const MEASURE: usize = 0;
/// The index of a transmission.
pub const TRANSMIT: usize = 1;

/// Power of the ADXL362 in standby in W: 10 nA by the first page of its data sheet, at the highest voltage.
const STANDBY: f32 = 10e-9 * HIGHEST_VOLTAGE;
/// Highest voltage of the storage, which supplies the parts.
const HIGHEST_VOLTAGE: f32 = 3.3;

/// Why there is no node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExampleError {
    /// A parameter outside its bounds.
    Node(NodeError),
    /// The map is not whole.
    Map(MapError),
    /// The bank of lines does not fit.
    Bank(ExcitationError),
    /// A part has no figure for this use.
    Figure,
}

impl From<ParameterError<f32>> for ExampleError {
    fn from(error: ParameterError<f32>) -> Self {
        Self::Node(error.into())
    }
}

/// A node with an nRF52832, its radio and an ADXL362, on a storage of 10 mF that supplies it directly.
///
/// # Errors
/// If a parameter is outside its bounds, or the map does not belong to this version.
pub fn node() -> Result<ExampleNode, ExampleError> {
    let accelerometer = Accelerometer::adxl362();
    let cost = CostModel::<f32>::new(Processor::nrf52832(), accelerometer);
    let rate = RATE.hertz() as f32;
    let block = (SECTION * SECTIONS) as u32;
    let Instructions { reading, sample, block: of_block } = node_instructions(cost.processor.core);
    let computing = block as f32 * sample + of_block;
    let burst = cost.listen(block, rate, computing, Code::Filter).ok_or(ExampleError::Figure)?;
    let reading =
        cost.voltage_reading.value + cost.start_energy() + cost.processor.computing(reading, Code::Filter);
    let packet = Radio::<f32>::nrf52832();
    let sent = packet.packet(20).ok_or(ExampleError::Figure)?;
    let standing_power = cost.standing_power().ok_or(ExampleError::Figure)? + STANDBY;
    let parameters = MapParameters {
        voltage: VoltageParameters {
            storage: StorageParameters {
                capacitor: Capacitor { capacitance: 10e-3, leakage_resistance: 5e6 },
                charging_efficiency: 0.8,
                discharging_efficiency: 1.0,
                highest_voltage: HIGHEST_VOLTAGE,
                lock_out_voltage: 1.9,
                turn_on_voltage: 2.2,
            },
            converter: Converter { bits: 12, full_scale: FULL_SCALE, noise: 1e-3 },
            standing_power,
            reading,
            intervals: [60, 300],
            tolerances: Tolerances {
                standing: 0.2,
                action: 0.1,
                capacitance: 0.115,
                leakage: 0.5,
                highest_voltage: 0.03,
                ..Tolerances::EXACT
            },
            largest_power: 1e-4,
            // Half an hour asleep.
            reserve: 1800.0 * standing_power,
            actions: [
                Regular { energy: 300e-6, every: 600 },
                Regular { energy: sent + cost.start_energy(), every: 900 },
            ],
        },
        sensor: Sensor {
            rate,
            start_up: accelerometer.start_up_samples,
            blocks: 1,
            // 12 bits.
            clipped: 2040,
        },
        bursts: Bursts { energy: burst.total(), worth: 10.0, shortest: 60, check: 80_000 },
        gain: 0.5,
        gain_drift: 0.05,
    };
    let map = ResponseMap::new(&contact_separation::MAP[..], contact_separation::FINGERPRINT)
        .map_err(ExampleError::Map)?;
    let bank = LineBank::new(rate, 20.13, 0.1, UNIT).map_err(ExampleError::Bank)?;
    MapNode::new(map, bank, parameters).map_err(ExampleError::Node)
}
