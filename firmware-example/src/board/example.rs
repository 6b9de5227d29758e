//! A node with an nRF52832, its radio and an ADXL362, on a storage of 10 mF that supplies it directly. A test compares its
//! energies with the figures of the parts.

use model_core::energy::{Capacitor, ResponseMap, StorageParameters};
use model_core::excitation::LineBank;
use model_core::node::{
    Bursts, Converter, MapNode, MapParameters, Regular, Sensor, Tolerances, VoltageParameters,
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

/// Highest voltage of the storage, which supplies the parts.
const HIGHEST_VOLTAGE: f32 = 3.3;
/// Asleep in W: 1.9 µA of the processor at 3 V, and 10 nA of the ADXL362 at the highest voltage.
const STANDING_POWER: f32 = 5.733e-6;
/// Energy in J of a reading, of a burst of 1280 samples, and of a packet of 20 bytes with its wake-up.
const READING: f32 = 0.2928e-6;
const BURST: f32 = 59.32e-6;
const PACKET: f32 = 16.82e-6;

/// The node, in flash. One whose parameters do not fit does not compile.
pub static NODE: ExampleNode = {
    let Ok(map) = ResponseMap::of_words(&contact_separation::MAP, contact_separation::FINGERPRINT) else {
        panic!("the map")
    };
    let Ok(bank) = LineBank::new(RATE.hertz() as f32, 20.13, 0.1, UNIT) else { panic!("the bank of lines") };
    let Ok(node) = MapNode::new(map, bank, PARAMETERS) else { panic!("the parameters") };
    node
};

const PARAMETERS: MapParameters<ACTIONS> = MapParameters {
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
        standing_power: STANDING_POWER,
        reading: READING,
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
        reserve: 1800.0 * STANDING_POWER,
        actions: [Regular { energy: 300e-6, every: 600 }, Regular { energy: PACKET, every: 900 }],
    },
    // 12 bits.
    sensor: Sensor { rate: RATE.hertz() as f32, start_up: 4, blocks: 1, clipped: 2040 },
    bursts: Bursts { energy: BURST, worth: 10.0, shortest: 60, check: 80_000 },
    gain: 0.5,
    gain_drift: 0.05,
};
