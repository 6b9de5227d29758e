//! A battery beside the capacitor of a storage.
//!
//! The open-circuit voltage is a line between points over the state of charge. Where it rises by `ΔV` over the charge `ΔQ`, the
//! battery is a capacitor of `ΔQ/ΔV`. With a capacitor `C` beside it, the integral of the voltage over the charge is, from
//! the energy `E₀` and the voltage `V₀` at the beginning of such a piece,
//!
//! ```text
//! E = E₀ + h (V² − V₀²),   h = (ΔQ/ΔV + C)/2,   dE/dV = 2 h V.
//! ```
//!
//! Omitted: hysteresis and temperature of the open-circuit voltage, relaxation after a current, ageing, the heat `R I²` (a
//! millionth of the income at a µA through a few Ω).

use crate::bounds::{Bounds, ParameterError, first_outside};
use crate::scalar::Scalar;
use crate::snapshot::Fingerprint;

/// Most points of an open-circuit voltage.
const MOST_POINTS: usize = 16;
/// Pieces between them.
pub(crate) const PIECES: usize = MOST_POINTS - 1;
/// Least difference of the state of charge, and of the voltage in V, from one point to the next.
const LEAST: f32 = 1e-5;

/// A battery: parameters for [`VoltageParameters::build_with_battery`](crate::node::VoltageParameters::build_with_battery),
/// [`MapNode::with_battery`](crate::node::MapNode::with_battery) and [`Self::curve`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Battery {
    /// State of charge and open-circuit voltage in V, both rising by 10⁻⁵ at least: 2 to 16 points, from 0 to 1 and 0.01 V to 1000 V.
    pub points: &'static [[f32; 2]],
    /// Charge from the first to the last point in C, 10⁻⁶ to 10⁷.
    pub charge: f32,
    /// Internal resistance in Ω for currents of minutes, 0 to 10⁶.
    pub resistance: f32,
    /// Part of the charge into the battery that comes out again, 0.01 to 1; it counts with that of the converter.
    pub charging_efficiency: f32,
    /// Part of the stored energy that is lost in a second, 0 to 10⁻³.
    pub self_discharge: f32,
    /// Relative standard deviation of the charge, 0 to 0.3; in a node it counts in place of that of the capacitance.
    pub tolerance: f32,
}

/// Pieces of a curve, each with the energy in J and the square of the voltage in V² at its begin, and `h` in F. A piece beyond the
/// last one begins at an infinite energy.
pub(crate) type Pieces = [[f64; 3]; PIECES];

impl Battery {
    /// The pieces with a capacitance in F beside the battery.
    pub(crate) const fn pieces(&self, capacitance: f32) -> Result<Pieces, ParameterError<f32>> {
        let Self { points, charge, resistance, charging_efficiency, self_discharge, tolerance } = *self;
        let count = ("battery.points", points.len() as f32, 2.0, MOST_POINTS as f32);
        if let Some(error) = first_outside(&[count]) {
            return Err(error);
        }
        let Bounds { lowest, highest: _ } = self.voltages();
        if let Some(error) = first_outside(&[
            ("battery.charge", charge, 1e-6, 1e7),
            ("battery.resistance", resistance, 0.0, 1e6),
            ("battery.charging_efficiency", charging_efficiency, 0.01, 1.0),
            ("battery.self_discharge", self_discharge, 0.0, 1e-3),
            ("battery.tolerance", tolerance, 0.0, 0.3),
            ("battery.points.0.charge", points[0][0], 0.0, 0.0),
            ("battery.points.0.voltage", lowest, 0.01, 1e3),
            ("battery.points.last.charge", points[points.len() - 1][0], 1.0, 1.0),
        ]) {
            return Err(error);
        }
        let capacitance = capacitance as f64;
        let mut pieces = [[f64::INFINITY, f64::INFINITY, 0.0]; PIECES];
        let mut energy = 0.5 * capacitance * (lowest as f64 * lowest as f64);
        let mut index = 0;
        while index + 1 < points.len() {
            let ([from, low], [to, high]) = (points[index], points[index + 1]);
            if let Some(error) = first_outside(&[
                ("battery.points.charge", to, from + LEAST, 1.0),
                ("battery.points.voltage", high, low + LEAST, 1e3),
            ]) {
                return Err(error);
            }
            let (low, high) = (low as f64, high as f64);
            let moved = charge as f64 * (to as f64 - from as f64);
            let half = 0.5 * (moved / (high - low) + capacitance);
            pieces[index] = [energy, low * low, half];
            energy += half * (high * high - low * low);
            index += 1;
        }
        Ok(pieces)
    }

    /// The bounds of a voltage of the storage in V: its first and its last point.
    pub(crate) const fn voltages(&self) -> Bounds<f32> {
        Bounds { lowest: self.points[0][1], highest: self.points[self.points.len() - 1][1] }
    }

    /// The stored energy over the voltage, with a capacitance in F beside the battery, 0 to 10⁵.
    ///
    /// # Errors
    /// The first parameter outside its bounds; of `battery.points.charge` and `battery.points.voltage` the bounds are those by the
    /// point before.
    pub fn curve<S: Scalar>(&self, capacitance: f32) -> Result<BatteryCurve<S>, ParameterError<f32>> {
        if let Some(error) = first_outside(&[("capacitance", capacitance, 0.0, 1e5)]) {
            return Err(error);
        }
        Ok(BatteryCurve {
            capacitance: S::from_f64(capacitance.into()),
            pieces: self.pieces(capacitance)?.map(|piece| piece.map(S::from_f64)),
            voltages: Bounds::new(self.voltages().lowest.into(), self.voltages().highest.into()),
            charging_efficiency: S::from_f64(self.charging_efficiency.into()),
            self_discharge: S::from_f64(self.self_discharge.into()),
        })
    }
}

/// A checked [`Battery`] with the capacitor beside it, for
/// [`BudgetParameters::build_with_battery`](crate::energy::BudgetParameters::build_with_battery).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BatteryCurve<S> {
    pieces: [[S; 3]; PIECES],
    /// Of the capacitor beside the battery, in F.
    pub(super) capacitance: S,
    pub(super) voltages: Bounds<S>,
    pub(super) charging_efficiency: S,
    pub(super) self_discharge: S,
}

/// Energy in J at a voltage in V.
pub(crate) const fn energy_at(pieces: &Pieces, voltage: f32) -> f32 {
    let square = voltage as f64 * voltage as f64;
    let mut index = 0;
    while index + 1 < PIECES && square >= pieces[index + 1][1] {
        index += 1;
    }
    let [energy, begin, half] = pieces[index];
    (energy + half * (square - begin)) as f32
}

/// The piece in which an energy, or the square of a voltage, is; the first or the last one beyond.
pub(crate) fn piece_at<S: Scalar>(pieces: &[[S; 3]; PIECES], column: usize, value: S) -> [S; 3] {
    let [first, others @ ..] = pieces;
    let is_reached = |piece: &&[S; 3]| piece.get(column).is_some_and(|begin| value >= *begin);
    *others.iter().take_while(is_reached).last().unwrap_or(first)
}

impl<S: Scalar> BatteryCurve<S> {
    /// Stored energy in J at an open-circuit voltage in V, above that of the battery at its first point.
    #[must_use]
    pub fn energy(&self, voltage: S) -> S {
        let square = voltage * voltage;
        let [energy, begin, half] = piece_at(&self.pieces, 1, square);
        energy + half * (square - begin)
    }

    /// Open-circuit voltage in V at a stored energy in J; 0 where the line has none.
    #[must_use]
    pub fn voltage(&self, energy: S) -> S {
        let [from, begin, half] = piece_at(&self.pieces, 0, energy);
        (begin + (energy - from) / half).max(S::ZERO).sqrt()
    }

    /// Includes the curve in a fingerprint.
    pub(super) fn identify(&self, fingerprint: &mut Fingerprint) {
        for [_, begin, half] in &self.pieces {
            fingerprint.numbers(&[*begin, *half]);
        }
        fingerprint.numbers(&[self.charging_efficiency, self.self_discharge]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::{BudgetParameters, Capacitor, IncomeParameters, StorageParameters};

    /// A steep, a flat and a steep piece.
    const POINTS: &[[f32; 2]] = &[[0.0, 2.0], [0.1, 3.2], [0.9, 3.3], [1.0, 3.6]];
    const BATTERY: Battery = Battery {
        points: POINTS,
        charge: 14.4,
        resistance: 10.0,
        charging_efficiency: 0.98,
        self_discharge: 1e-8,
        tolerance: 0.05,
    };

    /// Charge in C of battery and capacitor at a voltage.
    fn charge_at(voltage: f64, capacitance: f64) -> f64 {
        let after = POINTS.iter().position(|point| voltage < f64::from(point[1])).unwrap_or(POINTS.len() - 1);
        let [[from, low], [to, high]] = [POINTS[after - 1], POINTS[after]].map(|point| point.map(f64::from));
        f64::from(14.4_f32) * (from + (to - from) * (voltage - low) / (high - low)) + capacitance * voltage
    }

    #[test]
    fn the_energy_is_the_integral_of_the_voltage_over_the_charge() {
        for capacitance in [0.0_f32, 0.1] {
            let curve = BATTERY.curve::<f64>(capacitance).expect("valid");
            let single = BATTERY.curve::<f32>(capacitance).expect("valid");
            let beside = f64::from(capacitance);
            let (steps, mut energy, mut voltage) = (32_000, 0.5 * beside * 4.0, 2.0);
            for step in 1..=steps {
                let next = 2.0 + 1.6 * f64::from(step) / f64::from(steps);
                let moved = charge_at(next, beside) - charge_at(voltage, beside);
                energy += 0.5 * (voltage + next) * moved;
                voltage = next;
                assert!((curve.energy(voltage) / energy - 1.0).abs() < 1e-6, "{voltage}: {energy}");
                assert!((curve.voltage(curve.energy(voltage)) - voltage).abs() < 1e-9, "{voltage}");
                assert!((f64::from(single.energy(voltage as f32)) - energy).abs() < 1e-4, "{voltage}");
            }
            assert!((energy - 14.4 * (0.26 + 0.8 * 3.25 + 0.345) - 0.5 * beside * 3.6 * 3.6).abs() < 1e-5);
        }
    }

    #[test]
    fn a_curve_that_does_not_rise_and_numbers_out_of_bounds_are_named() {
        let refused = |battery: Battery| {
            let error = battery.curve::<f32>(0.0).expect_err("refused");
            (error.field, error.value, error.bounds.lowest)
        };
        let points = |points: &'static [[f32; 2]]| refused(Battery { points, ..BATTERY });
        assert_eq!(points(&[]), ("battery.points", 0.0, 2.0));
        assert_eq!(points(&[[0.0, 3.0]; 17]), ("battery.points", 17.0, 2.0));
        assert_eq!(points(&[[0.1, 3.0], [1.0, 3.1]]), ("battery.points.0.charge", 0.1, 0.0));
        assert_eq!(points(&[[0.0, 0.0], [1.0, 3.1]]), ("battery.points.0.voltage", 0.0, 0.01));
        assert_eq!(points(&[[0.0, 3.0], [0.9, 3.1]]), ("battery.points.last.charge", 0.9, 1.0));
        let flat = points(&[[0.0, 3.0], [0.5, 3.0], [1.0, 3.1]]);
        assert_eq!(flat, ("battery.points.voltage", 3.0, 3.0 + LEAST));
        let falling = points(&[[0.0, 3.0], [0.5, f32::NAN], [1.0, 3.1]]);
        assert!(falling.0 == "battery.points.voltage" && falling.1.is_nan());
        let back = points(&[[0.0, 3.0], [0.5, 3.1], [0.4, 3.2], [1.0, 3.3]]);
        assert_eq!(back, ("battery.points.charge", 0.4, 0.5 + LEAST));
        assert_eq!(refused(Battery { charge: f32::NAN, ..BATTERY }).0, "battery.charge");
        assert_eq!(refused(Battery { resistance: -1.0, ..BATTERY }).0, "battery.resistance");
        assert_eq!(refused(Battery { charging_efficiency: 1.1, ..BATTERY }).0, "battery.charging_efficiency");
        assert_eq!(refused(Battery { self_discharge: 0.1, ..BATTERY }).0, "battery.self_discharge");
        assert_eq!(refused(Battery { tolerance: 0.4, ..BATTERY }).0, "battery.tolerance");
        assert_eq!(BATTERY.curve::<f32>(-1.0).err().map(|error| error.field), Some("capacitance"));
    }

    #[test]
    fn a_budget_on_a_battery_charges_and_discharges_by_the_balance_of_its_energy() {
        let curve: &'static BatteryCurve<f64> = Box::leak(Box::new(BATTERY.curve(1e-4).expect("valid")));
        let storage = StorageParameters {
            capacitor: Capacitor { capacitance: 1e-4, leakage_resistance: f64::INFINITY },
            charging_efficiency: 0.9,
            discharging_efficiency: 0.8,
            highest_voltage: 3.5,
            lock_out_voltage: 2.5,
            turn_on_voltage: 2.7,
        };
        let other = Capacitor { capacitance: 2e-4, ..storage.capacitor };
        let other = StorageParameters { capacitor: other, ..storage }.build_with_battery(curve);
        assert_eq!(other.err().map(|error| error.field), Some("capacitance"));
        let income = IncomeParameters { time_constant: 14_400.0, day_weight: 0.5 };
        let parameters = BudgetParameters { storage, income, standing_power: 10e-6 };
        let budget = parameters.build_with_battery::<48>(curve).expect("valid");
        let mut state = budget.start(0);
        budget.correct_by_voltage(&mut state, 3.25, 1e-3);
        let begun = budget.storage().energy(3.25);
        assert!((state.energy() - begun).abs() < 1e-12);
        // Readings to 1 mV are good to dE/dV = 14.4 C · 8/V · 3.25 V.
        let uncertain = begun - state.certain_energy();
        assert!((uncertain / (1e-3 * 14.4 * 8.0 * 3.25) - 1.0).abs() < 1e-3, "{uncertain}");
        // Ten hours of 0.3 mW, and as many of an action of 20 mJ each minute.
        let mut energy = begun;
        for minute in 0..1200 {
            let (harvested, spent) = if minute < 600 { (18e-3, 0.0) } else { (0.0, 20e-3) };
            budget.update(&mut state, 60, harvested, spent);
            for _ in 0..600 {
                // Explicit, in tenths of a second.
                energy +=
                    (f64::from(0.98_f32) * 0.9 * harvested - (spent + 600e-6) / 0.8) / 600.0 - 1e-9 * energy;
            }
        }
        assert!((state.energy() / energy - 1.0).abs() < 1e-9, "{} {energy}", state.energy());
        let found = budget.storage().voltage(state.energy());
        assert!((budget.storage().energy(found) - energy).abs() < 1e-6 * energy);
        let outside = StorageParameters { lock_out_voltage: 1.9, ..storage };
        assert_eq!(
            outside.build_with_battery(curve).err().map(|error| error.field),
            Some("lock_out_voltage")
        );
        let outside = StorageParameters { highest_voltage: 3.7, ..storage };
        assert_eq!(outside.build_with_battery(curve).err().map(|error| error.field), Some("highest_voltage"));
    }
}
