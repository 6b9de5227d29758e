//! What the node is made of. A test compares its energies with the figures of the parts.

use model_core::energy::{Capacitor, ResponseMap, StorageParameters};
use model_core::excitation::LineBank;
use model_core::node::{
    Bursts, Converter, MapNode, MapParameters, MapState, Regular, Sensor, Tolerances, VoltageNode,
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

impl Part {
    /// The one for the core that this is compiled for.
    #[cfg(target_os = "none")]
    pub const TARGET: Self = if cfg!(target_abi = "eabihf") { Self::Nrf52832 } else { Self::Stm32l051 };

    /// The node with this processor, an ADXL362 and a storage of 47 mF, in flash. It measures and transmits each five minutes.
    #[must_use]
    pub fn node(self) -> &'static ExampleNode {
        static NRF52832: ExampleNode = with_map(Part::Nrf52832);
        static STM32L051: ExampleNode = with_map(Part::Stm32l051);
        match self {
            Self::Nrf52832 => &NRF52832,
            Self::Stm32l051 => &STM32L051,
        }
    }

    /// Standing power in W, and energies of a reading and a burst in J, by the figures of its parts.
    const fn figures(self) -> [f32; 3] {
        match self {
            Self::Nrf52832 => FIGURES[0],
            Self::Stm32l051 => FIGURES[1],
        }
    }
}

/// A node whose parameters do not fit does not compile.
const fn with_map(part: Part) -> ExampleNode {
    let [standing_power, reading, burst] = part.figures();
    let Ok(map) = ResponseMap::of_words(&map::MAP, map::FINGERPRINT) else { panic!("the map") };
    let bank = LineBank::new(RATE as f32, map::RESONANCE_HZ, map::HALF_BANDWIDTH_HZ, UNIT);
    let Ok(bank) = bank else { panic!("the bank of lines") };
    let parameters = MapParameters {
        voltage: by_voltage(reading, standing_power),
        // 12 bits.
        sensor: Sensor { rate: RATE as f32, start_up: START_UP, blocks: 1, clipped: 2040 },
        // Each hour, so that the day has bursts.
        bursts: Bursts { energy: burst, worth: 10.0, shortest: 60, check: 3600 },
        gain: 1.0,
        gain_drift: 0.1,
    };
    let Ok(node) = MapNode::new(map, bank, parameters) else { panic!("the parameters") };
    node
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

/// By part: [`Part::figures`].
const FIGURES: [[f32; 3]; 2] = [[5.7e-6, 0.293e-6, 44.2e-6], [2.4e-6, 2.02e-6, 60.9e-6]];
/// Samples of the accelerometer's start-up.
const START_UP: u32 = 4;

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

#[cfg(test)]
mod tests {
    use super::{BURST, Part, RATE, START_UP};
    use harvester_scene::market::{Accelerometer, Code, CostModel, Processor, node_instructions};

    #[test]
    fn the_energies_are_those_of_the_parts() {
        for (part, word) in [(Part::Nrf52832, "nrf52832"), (Part::Stm32l051, "stm32l051")] {
            let accelerometer = Accelerometer::named("adxl362").expect("a part");
            assert_eq!(accelerometer.start_up_samples, START_UP);
            let cost = CostModel::new(Processor::named(word).expect("a part"), accelerometer);
            let of = node_instructions(cost.processor.core);
            let computing = f64::from(BURST) * of.sample + of.block;
            let burst = cost.burst(BURST, RATE.into(), computing, Code::Filter).expect("a rate").total();
            let expected = [cost.standing_power().expect("known"), cost.reading(of.reading), burst];
            for (found, expected) in part.figures().into_iter().zip(expected) {
                assert!((f64::from(found) / expected - 1.0).abs() < 0.01, "{part:?}: {found:e} {expected:e}");
            }
        }
    }
}
