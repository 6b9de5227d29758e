//! What the node is made of. Energies are those of `energy::cost` for its processor.

use model_core::bounds::ParameterError;
use model_core::energy::cost::{Accelerometer, Code, CostModel, Instructions, Processor, node_instructions};
use model_core::energy::response_map::MapError;
use model_core::energy::{Capacitor, ResponseMap, StorageParameters};
use model_core::excitation::{ExcitationError, LineBank};
use model_core::node::{
    Bursts, Converter, MapNode, MapParameters, MapState, NodeError, Regular, Sensor, Tolerances, VoltageNode,
    VoltageParameters,
};

/// The map of `node.toml`: contact-separation under the force of the field, 20 g on 320 N/m, with impacts.
#[path = "../../map/node.rs"]
pub mod map;

/// Samples of a section of the bank of lines, and sections of a block: 6.4 s.
const SECTION: usize = 20;
const SECTIONS: usize = 32;
/// Number of actions.
pub const ACTIONS: usize = 2;
/// Samples of a burst.
pub const BURST: u32 = (SECTION * SECTIONS) as u32;

/// The node.
pub type ExampleNode = MapNode<&'static [u16], SECTION, SECTIONS, ACTIONS>;
/// What it has learnt.
pub type ExampleState = MapState<SECTIONS, ACTIONS>;
/// The node with its board.
pub type Runner<'a, B> = model_core::node::Runner<'a, B, ExampleNode>;

/// Samples of the accelerometer in a second.
pub const RATE: u32 = 100;
/// m/s² of a count: 1 mg.
const UNIT: f32 = 1e-3 * model_core::part::GRAVITY as f32;
/// Bits of the converter, and voltage of its full scale.
pub const BITS: u32 = 12;
pub const FULL_SCALE: f32 = 5.0;
/// Noise of the converter in V.
const CONVERTER_NOISE: f32 = 0.6e-3;

/// Capacitance of the storage in F, and its leakage in Ω.
pub const CAPACITANCE: f32 = 47e-3;
pub const LEAKAGE: f32 = 4e6;
/// Voltages in V: of the full storage, of the lock-out, and with which the day begins.
pub const HIGHEST: f32 = 4.5;
pub const LOCK_OUT: f32 = 1.8;
pub const FIRST: f32 = 3.6;
/// Efficiencies in per cent: into the storage, and out of it.
pub const INTO_STORAGE: u8 = 80;
pub const OUT_OF_STORAGE: u8 = 90;

/// A processor of the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// A Cortex-M4F; it stands for the cores with single-precision floating point.
    Nrf52832,
    /// A Cortex-M0+; it stands for the cores without.
    Stm32l051,
}

/// Why there is no node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PartsError {
    /// A parameter outside its bounds.
    Node(NodeError),
    /// The map is not whole.
    Map(MapError),
    /// The bank of lines does not fit.
    Bank(ExcitationError),
    /// A part has no figure for this use.
    Figure,
}

impl From<ParameterError<f32>> for PartsError {
    fn from(error: ParameterError<f32>) -> Self {
        Self::Node(error.into())
    }
}

impl Part {
    /// The one for the core that this is compiled for.
    #[cfg(target_os = "none")]
    pub const TARGET: Self = if cfg!(target_abi = "eabihf") { Self::Nrf52832 } else { Self::Stm32l051 };

    fn processor(self) -> Processor<f32> {
        match self {
            Self::Nrf52832 => Processor::nrf52832(),
            Self::Stm32l051 => Processor::stm32l051(),
        }
    }

    /// The node with this processor, an ADXL362 and a storage of 47 mF. It measures and transmits each five minutes.
    ///
    /// # Errors
    /// If a parameter is outside its bounds, or the map does not belong to this version.
    #[inline(never)]
    pub fn node(self) -> Result<ExampleNode, PartsError> {
        let map = ResponseMap::new(&map::MAP[..], map::FINGERPRINT).map_err(PartsError::Map)?;
        let bank = LineBank::new(RATE as f32, map::RESONANCE_HZ, map::HALF_BANDWIDTH_HZ, UNIT)
            .map_err(PartsError::Bank)?;
        MapNode::new(map, bank, self.parameters()?).map_err(PartsError::Node)
    }

    /// The parameters of the node. A call of its own: what the figures of the parts take on the stack is free again afterwards.
    #[inline(never)]
    fn parameters(self) -> Result<MapParameters<ACTIONS>, PartsError> {
        let accelerometer = Accelerometer::adxl362();
        let cost = CostModel::<f32>::new(self.processor(), accelerometer);
        let Instructions { reading, sample, block } = node_instructions(cost.processor.core);
        let instructions = BURST as f32 * sample + block;
        let burst = cost.listen(BURST, RATE as f32, instructions, Code::Filter).ok_or(PartsError::Figure)?;
        let reading = cost.voltage_reading.value
            + cost.start_energy()
            + cost.processor.computing(reading, Code::Filter);
        Ok(MapParameters {
            voltage: by_voltage(reading, cost.standing_power().ok_or(PartsError::Figure)?),
            sensor: Sensor {
                rate: RATE as f32,
                start_up: accelerometer.start_up_samples,
                blocks: 1,
                // 12 bits.
                clipped: 2040,
            },
            // Each hour, so that the day has bursts.
            bursts: Bursts { energy: burst.total(), worth: 10.0, shortest: 60, check: 3600 },
            gain: 1.0,
            gain_drift: 0.1,
        })
    }
}

/// The node by the voltage alone: the same storage and actions, in flash.
pub static NODE: VoltageNode<ACTIONS> = match by_voltage(0.3e-6, 1e-6).build() {
    Ok(node) => node,
    Err(error) => panic!("{}", error.field),
};

/// Its parameters, with the energy of a reading in J and the standing power in W.
const fn by_voltage(reading: f32, standing_power: f32) -> VoltageParameters<ACTIONS> {
    VoltageParameters {
        storage: STORAGE,
        converter: Converter { bits: BITS, full_scale: FULL_SCALE, noise: CONVERTER_NOISE },
        standing_power,
        reading,
        intervals: [60, 300],
        tolerances: Tolerances {
            standing: 0.2,
            action: 0.02,
            capacitance: 0.115,
            highest_voltage: 0.03,
            ..Tolerances::EXACT
        },
        largest_power: 300e-6,
        reserve: 36_000.0 * standing_power,
        actions: REGULAR,
    }
}

/// A measurement and a transmission.
const REGULAR: [Regular; ACTIONS] =
    [Regular { energy: 300e-6, every: 300 }, Regular { energy: 6.6e-3, every: 300 }];

const STORAGE: StorageParameters<f32> = StorageParameters {
    capacitor: Capacitor { capacitance: CAPACITANCE, leakage_resistance: LEAKAGE },
    charging_efficiency: 0.01 * INTO_STORAGE as f32,
    discharging_efficiency: 0.01 * OUT_OF_STORAGE as f32,
    highest_voltage: HIGHEST,
    lock_out_voltage: LOCK_OUT,
    turn_on_voltage: 2.2,
};
