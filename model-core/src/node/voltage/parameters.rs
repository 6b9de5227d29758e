//! Parameters of the node by the voltage alone.

use super::{BatteryElement, CapacitorElement, Element, VoltageNode};
use crate::bounds::{Bounds, ParameterError, first_outside};
use crate::energy::battery::{PIECES, energy_at};
use crate::energy::{Battery, StorageParameters};
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
    /// Of the efficiency of charging, 0 to 1: of charging and discharging where the capacitance is [learnt](super::LearntCapacitance).
    pub charging: f32,
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
        charging: 0.0,
        leakage: 0.0,
        reference: 0.0,
        highest_voltage: 0.0,
    };
}

/// What a node has of its element: the variance of an energy over that of the voltage and the square of the slope, the variance of
/// the drop over a resistance in V², energies in J, the leaking part in 1/s, and the relative deviation of all energies.
struct Numbers {
    of_variance: f32,
    of_drop: f32,
    full: f32,
    lock_out: f32,
    leakage_rate: f32,
    capacitance: f32,
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
        let StorageParameters { capacitor, lock_out_voltage, .. } = self.storage;
        let (half, lowest_full, cell) = (0.5 * capacitor.capacitance, self.lowest_full(), self.cell());
        let numbers = Numbers {
            of_variance: 4.0 * half,
            of_drop: 0.0,
            full: half * lowest_full * lowest_full,
            lock_out: half * lock_out_voltage * lock_out_voltage,
            leakage_rate: 1.0 / (half * capacitor.leakage_resistance),
            capacitance: self.tolerances.capacitance,
        };
        Ok(self.node(CapacitorElement { per_code: half * cell * cell }, numbers))
    }

    /// As [`Self::build`], with a battery beside the capacitor.
    ///
    /// The drop over the internal resistance counts as by the standing power and half of the largest one, with the variance of a power
    /// between 0 and the largest; the capacitor delivers what actions take at once. The leakage of the capacitor counts as at the
    /// highest voltage. [`VoltageNode::parameters`] then has the charging efficiency of both.
    ///
    /// # Errors
    /// The first parameter outside its bounds; lock-out and highest voltage must be within those of the battery.
    pub const fn build_with_battery(
        mut self,
        battery: Battery,
    ) -> Result<VoltageNode<ACTIONS, BatteryElement>, ParameterError<f32>> {
        if let Some(error) = self.first_outside() {
            return Err(error);
        }
        let StorageParameters { capacitor, highest_voltage, lock_out_voltage, .. } = self.storage;
        let volts = match battery.pieces(capacitor.capacitance) {
            Ok(pieces) => pieces,
            Err(error) => return Err(error),
        };
        let Bounds { lowest, highest } = battery.voltages();
        if let Some(error) = first_outside(&[
            ("lock_out_voltage", lock_out_voltage, lowest, highest),
            ("highest_voltage", highest_voltage, lowest, highest),
        ]) {
            return Err(error);
        }
        self.storage.charging_efficiency *= battery.charging_efficiency;
        let (cell, ohm_per_volt) =
            (self.cell(), battery.resistance / (0.5 * (lock_out_voltage + highest_voltage)));
        let square = (cell as f64) * (cell as f64);
        let mut pieces = [[f32::INFINITY, f32::INFINITY, 0.0]; PIECES];
        let mut index = 0;
        while index < PIECES {
            let [energy, begin, half] = volts[index];
            pieces[index] = [energy as f32, (begin / square) as f32, (half * square) as f32];
            index += 1;
        }
        let largest = self.largest_power * self.storage.charging_efficiency;
        let drop = self.standing_power / self.storage.discharging_efficiency - 0.5 * largest;
        let varies = ohm_per_volt * largest;
        let full_energy = energy_at(&volts, highest_voltage);
        let leaking = highest_voltage * highest_voltage / (capacitor.leakage_resistance * full_energy);
        let numbers = Numbers {
            of_variance: 4.0 / (cell * cell),
            of_drop: varies * varies / 12.0,
            full: energy_at(&volts, self.lowest_full()),
            lock_out: energy_at(&volts, lock_out_voltage),
            leakage_rate: battery.self_discharge + leaking,
            capacitance: battery.tolerance,
        };
        Ok(self.node(BatteryElement { pieces, drop: ohm_per_volt * drop / cell, cell }, numbers))
    }

    /// Voltage of a code in V.
    pub(super) const fn cell(&self) -> f32 {
        self.converter.full_scale / 1_u32.wrapping_shl(self.converter.bits) as f32
    }

    /// Variances in V² of a reading, and of the part of its error that lasts from reading to reading.
    pub(super) const fn of_reading(&self) -> [f32; 2] {
        let (cell, noise) = (self.cell(), self.converter.noise * self.converter.noise);
        let width = cell * cell / 12.0;
        // The error of rounding lasts as far as noise does not smooth it: by the first harmonic of a normal noise,
        // exp(−4π² noise²), of which this is an upper bound.
        let smooth = 39.48 * noise / (cell * cell);
        [noise + width, width / (1.0 + smooth * (1.0 + smooth * (0.5 + smooth * (1.0 / 6.0))))]
    }

    /// Voltage in V from which on the storage may be full.
    const fn lowest_full(&self) -> f32 {
        let (cell, Tolerances { highest_voltage, .. }) = (self.cell(), self.tolerances);
        let below = self.storage.highest_voltage * (1.0 - highest_voltage)
            - (0.5 + 2.0 * self.converter.noise / cell) * cell;
        if below > 0.0 { below } else { 0.0 }
    }

    const fn node<E: Element>(self, element: E, numbers: Numbers) -> VoltageNode<ACTIONS, E> {
        let Self { storage, converter, tolerances, .. } = self;
        let Numbers { of_variance, of_drop, full, lock_out, leakage_rate, capacitance } = numbers;
        let [noise, lasting] = self.of_reading();
        let scale = capacitance * capacitance + 4.0 * tolerances.reference * tolerances.reference;
        let reference = 2.0 * tolerances.reference;
        // A drop of the energy by an action is another one than expected, for half of the time to the next reading.
        let of_drops = capacitance / 16.0;
        VoltageNode {
            element,
            full_code: 1_u32.wrapping_shl(converter.bits).wrapping_sub(1),
            noise: of_variance * (noise + of_drop),
            lasting: of_variance * (lasting + of_drop),
            full,
            lock_out,
            leakage_rate,
            drawn_per_used: 1.0 / storage.discharging_efficiency,
            per_stored: 1.0 / storage.charging_efficiency,
            standing: self.standing_power / storage.discharging_efficiency,
            largest: self.largest_power * storage.charging_efficiency,
            scale,
            leakage: tolerances.leakage * tolerances.leakage + reference * reference + of_drops * of_drops,
            parameters: self,
        }
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
            ("tolerances.charging", tolerances.charging, 0.0, 1.0),
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
