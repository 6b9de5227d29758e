//! Parameters of the node by the voltage alone.

use super::VoltageNode;
use crate::bounds::{ParameterError, first_outside};
use crate::energy::StorageParameters;
use crate::node::{Converter, Regular};

/// Parameters of a [`VoltageNode`]. [`VoltageParameters::build`] is `const`: the node is a constant in flash.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VoltageParameters<const ACTIONS: usize> {
    /// The storage.
    pub storage: StorageParameters<f32>,
    /// The converter that reads its voltage.
    pub converter: Converter,
    /// Power in W at the load with everything asleep, 0 to 10³.
    pub standing_power: f32,
    /// Energy of a reading in J at the load, with its wake-up and the computing after it, 0 to 10.
    pub reading: f32,
    /// Shortest and longest time between readings in s, 1 to 3600. A storage that fills up sooner is read sooner.
    pub intervals: [u32; 2],
    /// How far the stated figures may be off.
    pub tolerances: Tolerances,
    /// The largest power of such a harvester in W, 10⁻⁹ to 10³: the income while the storage is full is bounded by it.
    pub largest_power: f32,
    /// Energy in J at the load that actions leave in the storage above the lock-out, 0 to 10⁶.
    pub reserve: f32,
    /// What the node does, the most important first.
    pub actions: [Regular; ACTIONS],
}

/// Relative standard deviations of stated figures, each the same at all times; 0 is exact. A part within ± a limit counts by its
/// 0.58: 0.115 for ±20 %.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tolerances {
    /// Of the standing power, 0 to 1, with the efficiency of discharging.
    pub standing: f32,
    /// Of the energy of actions, 0 to 1, with the efficiency of discharging.
    pub action: f32,
    /// Of the capacitance, 0 to 0.3.
    pub capacitance: f32,
    /// Of the leakage, 0 to 10.
    pub leakage: f32,
    /// Of the converter's reference with its divider, 0 to 0.1.
    pub reference: f32,
    /// How far the voltage at which the storage is full may be below the stated one, as the converter reads it, 0 to 0.1: a limit.
    pub highest_voltage: f32,
}

impl Tolerances {
    /// All is as stated.
    pub const EXACT: Self = Self {
        standing: 0.0,
        action: 0.0,
        capacitance: 0.0,
        leakage: 0.0,
        reference: 0.0,
        highest_voltage: 0.0,
    };
}

impl<const ACTIONS: usize> VoltageParameters<ACTIONS> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first parameter outside its bounds.
    pub const fn build(self) -> Result<VoltageNode<ACTIONS>, ParameterError<f32>> {
        if let Some(error) = self.first_outside() {
            return Err(error);
        }
        let Self { storage, converter, tolerances, .. } = self;
        let half = 0.5 * storage.capacitor.capacitance;
        let codes = 1_u32 << converter.bits;
        let cell = converter.full_scale / codes as f32;
        let (noise, width) = (converter.noise * converter.noise, cell * cell / 12.0);
        // The error of rounding lasts from reading to reading as far as noise does not smooth it: by the first harmonic of a
        // normal noise, exp(−4π² noise²), of which this is an upper bound.
        let smooth = 39.48 * noise / (cell * cell);
        let lasting = width / (1.0 + smooth * (1.0 + smooth * (0.5 + smooth * (1.0 / 6.0))));
        let below = storage.highest_voltage * (1.0 - tolerances.highest_voltage)
            - (0.5 + 2.0 * converter.noise / cell) * cell;
        let lowest_full = if below > 0.0 { below } else { 0.0 };
        let scale = tolerances.capacitance * tolerances.capacitance
            + 4.0 * tolerances.reference * tolerances.reference;
        let reference = 2.0 * tolerances.reference;
        // A drop of the energy by an action is another one than expected, for half of the time to the next reading.
        let of_drops = tolerances.capacitance / 16.0;
        Ok(VoltageNode {
            per_code: half * cell * cell,
            full_code: codes - 1,
            noise: 4.0 * half * (noise + width),
            lasting: 4.0 * half * lasting,
            full: half * lowest_full * lowest_full,
            lock_out: half * storage.lock_out_voltage * storage.lock_out_voltage,
            leakage_rate: 1.0 / (half * storage.capacitor.leakage_resistance),
            drawn_per_used: 1.0 / storage.discharging_efficiency,
            per_stored: 1.0 / storage.charging_efficiency,
            standing: self.standing_power / storage.discharging_efficiency,
            largest: self.largest_power * storage.charging_efficiency,
            scale,
            leakage: tolerances.leakage * tolerances.leakage + reference * reference + of_drops * of_drops,
            parameters: self,
        })
    }

    const fn first_outside(&self) -> Option<ParameterError<f32>> {
        let Self { storage, converter, tolerances, intervals: [shortest, longest], .. } = self;
        let highest = storage.highest_voltage;
        if let Some(error) = first_outside(&[
            ("capacitance", storage.capacitor.capacitance, 1e-9, 1e5),
            ("leakage_resistance", storage.capacitor.leakage_resistance, 1.0, f32::INFINITY),
            ("charging_efficiency", storage.charging_efficiency, 0.01, 1.0),
            ("discharging_efficiency", storage.discharging_efficiency, 0.01, 1.0),
            ("highest_voltage", highest, 0.01, 1e3),
            ("lock_out_voltage", storage.lock_out_voltage, 0.0, highest),
            ("turn_on_voltage", storage.turn_on_voltage, storage.lock_out_voltage, highest),
            ("bits", converter.bits as f32, 4.0, 16.0),
            ("full_scale", converter.full_scale, 0.01, 1e3),
            ("noise", converter.noise, 0.0, converter.full_scale),
            ("standing_power", self.standing_power, 0.0, 1e3),
            ("reading", self.reading, 0.0, 10.0),
            ("intervals.0", *shortest as f32, 1.0, 3600.0),
            ("intervals.1", *longest as f32, *shortest as f32, 3600.0),
            ("tolerances.standing", tolerances.standing, 0.0, 1.0),
            ("tolerances.action", tolerances.action, 0.0, 1.0),
            ("tolerances.capacitance", tolerances.capacitance, 0.0, 0.3),
            ("tolerances.leakage", tolerances.leakage, 0.0, 10.0),
            ("tolerances.reference", tolerances.reference, 0.0, 0.1),
            ("tolerances.highest_voltage", tolerances.highest_voltage, 0.0, 0.1),
            ("largest_power", self.largest_power, 1e-9, 1e3),
            ("reserve", self.reserve, 0.0, 1e6),
        ]) {
            return Some(error);
        }
        let mut index = 0;
        while index < ACTIONS {
            if let Some(error) = self.actions[index].outside(index) {
                return Some(error);
            }
            index += 1;
        }
        None
    }
}
