//! What a reading of the voltage says of the stored energy: of a capacitor, or of a battery beside one.

use core::fmt::Debug;

use crate::energy::battery::{PIECES, piece_at};
use crate::node::real;
use crate::scalar::Scalar;
use crate::snapshot::Fingerprint;

/// The element that holds the energy of a node, in codes of its converter: a [`CapacitorElement`] or a [`BatteryElement`].
pub trait Element: Copy + Debug + PartialEq {
    /// Whether an hour of readings may say next to nothing.
    const IS_FLAT: bool;

    /// Stored energy in J at a code.
    fn energy(&self, code: u32) -> f32;

    /// Square of the derivative of the energy by the code, over the constant that the node's variances have beside it, at a stored
    /// energy in J.
    fn square_of_slope(&self, energy: f32) -> f32;

    /// Voltage in V at a stored energy in J, of a capacitor of this capacitance in F.
    fn voltage(&self, energy: f32, capacitance: f32) -> f32;

    /// Another number for another element.
    fn identity(&self) -> f32;
}

/// A capacitor, whose energy goes with the square of the code.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CapacitorElement {
    /// Energy over the square of the code.
    pub(super) per_code: f32,
}

impl Element for CapacitorElement {
    const IS_FLAT: bool = false;

    #[inline]
    fn energy(&self, code: u32) -> f32 {
        self.per_code * real(code.wrapping_mul(code))
    }

    /// The constant is four times the energy over the square of the code.
    #[inline]
    fn square_of_slope(&self, energy: f32) -> f32 {
        energy
    }

    #[inline]
    fn voltage(&self, energy: f32, capacitance: f32) -> f32 {
        Scalar::sqrt(2.0 * Scalar::max(energy, 0.0) / capacitance)
    }

    #[inline]
    fn identity(&self) -> f32 {
        self.per_code
    }
}

/// A battery beside a capacitor.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BatteryElement {
    /// Energy in J and square of the code at the beginning of each piece of the curve, and energy over the square of the code.
    pub(super) pieces: [[f32; 3]; PIECES],
    /// What the open-circuit voltage is above that of a reading, in codes.
    pub(super) drop: f32,
    /// Voltage of a code in V.
    pub(super) cell: f32,
}

impl Element for BatteryElement {
    const IS_FLAT: bool = true;

    fn energy(&self, code: u32) -> f32 {
        let open = Scalar::max(real(code) + self.drop, 0.0);
        let square = open * open;
        let [energy, begin, per_code] = piece_at(&self.pieces, 1, square);
        Scalar::max(energy + per_code * (square - begin), 0.0)
    }

    /// The constant is 4.
    fn square_of_slope(&self, energy: f32) -> f32 {
        let [from, begin, per_code] = piece_at(&self.pieces, 0, energy);
        per_code * Scalar::max(per_code * begin + (energy - from), 0.0)
    }

    fn voltage(&self, energy: f32, _: f32) -> f32 {
        let [from, begin, per_code] = piece_at(&self.pieces, 0, energy);
        self.cell * Scalar::sqrt(Scalar::max(begin + (energy - from) / per_code, 0.0))
    }

    fn identity(&self) -> f32 {
        let mut fingerprint = Fingerprint::new();
        for piece in &self.pieces {
            fingerprint.numbers(piece);
        }
        fingerprint.numbers(&[self.drop]);
        f32::from_bits(fingerprint.value())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::{Battery, Capacitor, StorageParameters};
    use crate::node::{Converter, Tolerances, VoltageNode, VoltageParameters};

    const BATTERY: Battery = Battery {
        points: &[[0.0, 2.0], [0.1, 3.2], [0.9, 3.3], [1.0, 3.6]],
        charge: 14.4,
        resistance: 0.0,
        charging_efficiency: 0.98,
        self_discharge: 1e-8,
        tolerance: 0.05,
    };
    const STATED: VoltageParameters<0> = VoltageParameters {
        storage: StorageParameters {
            capacitor: Capacitor { capacitance: 1e-3, leakage_resistance: 1e9 },
            charging_efficiency: 0.5,
            discharging_efficiency: 0.8,
            highest_voltage: 3.5,
            lock_out_voltage: 2.5,
            turn_on_voltage: 2.7,
        },
        converter: Converter { bits: 12, full_scale: 5.0, noise: 1e-3 },
        standing_power: 8e-6,
        reading: 0.3e-6,
        intervals: [60, 300],
        tolerances: Tolerances::EXACT,
        largest_power: 100e-6,
        reserve: 0.0,
        actions: [],
    };
    static NODE: VoltageNode<0, BatteryElement> = built(BATTERY);

    const fn built(battery: Battery) -> VoltageNode<0, BatteryElement> {
        match STATED.build_with_battery(battery) {
            Ok(node) => node,
            Err(_) => panic!("within bounds"),
        }
    }

    #[test]
    fn a_reading_is_as_uncertain_as_the_slope_makes_it() {
        // Piecewise a capacitor of the moved charge over the risen voltage, with 1 mF beside it.
        let capacitance = |voltage: f64| match voltage {
            ..3.2 => 1.44 / 1.2 + 1e-3,
            ..3.3 => 11.52 / 0.1 + 1e-3,
            _ => 1.44 / 0.3 + 1e-3,
        };
        let (cell, mut energy) = (5.0 / 4096.0, 0.5e-3 * 4.0);
        let mut voltage = 2.0_f64;
        for code in 1639..2867 {
            while voltage < cell * f64::from(code) {
                energy += 1e-6 * (voltage + 0.5e-6) * capacitance(voltage);
                voltage += 1e-6;
            }
            let estimated = f64::from(NODE.element.energy(code));
            assert!((estimated - energy).abs() < 1e-3 + 4e-5 * energy, "{code}: {estimated} {energy}");
            let slope = f64::from(NODE.noise * NODE.element.square_of_slope(NODE.element.energy(code)));
            let expected = (1e-6 + cell * cell / 12.0) * (capacitance(voltage) * voltage).powi(2);
            let is_corner = [3.2, 3.3].iter().any(|corner| (voltage - corner).abs() < cell);
            assert!(is_corner || (slope / expected - 1.0).abs() < 1e-3, "{code}: {slope} {expected}");
            let back = NODE.element.voltage(NODE.element.energy(code), 0.0);
            assert!((f64::from(back) - voltage).abs() < 1e-4, "{code}: {back}");
        }
        assert!((f64::from(NODE.parameters().storage.charging_efficiency) - 0.49).abs() < 1e-6);
    }

    #[test]
    fn the_drop_over_the_resistance_is_that_of_the_standing_power_and_half_of_the_largest() {
        let node = built(Battery { resistance: 3000.0, ..BATTERY });
        // 10 µW at the storage less 24.5 µW, at 3 V: 14.5 mV above the open-circuit voltage.
        let code = (3.1145 * 4096.0 / 5.0_f32).round() as u32;
        let open = (3.1 * 4096.0 / 5.0_f32).round() as u32;
        let [estimated, expected] = [node.element.energy(code), NODE.element.energy(open)];
        // 14.5 mV are 54 mJ, a half of a code 2 mJ.
        assert!((estimated - expected).abs() < 5e-3, "{estimated} {expected}");
        // 49 µW through 3 kΩ at 3 V, evenly between 0 and that.
        let of_drop = (0.049_f32 * 0.049) / 12.0;
        assert!((node.noise / NODE.noise - 1.0 - of_drop / (1e-6 + 1.242e-7)).abs() < 1.0, "{}", node.noise);
        let outside = VoltageParameters {
            storage: StorageParameters { highest_voltage: 3.7, ..STATED.storage },
            ..STATED
        };
        let field =
            outside.build_with_battery(BATTERY).err().map(|error| (error.field, error.bounds.highest));
        assert_eq!(field, Some(("highest_voltage", 3.6)));
    }
}
