//! Computes the energy in a storage over time.
//!
//! A capacitor of capacitance `C` at voltage `V` holds `E = C V²/2`. Its leakage resistance `R` takes `V²/R =
//! 2 E/(R C)`. Between two updates, with constant income and load of the net power `p`,
//!
//! ```text
//! E' = p − λ E,   λ = 2/(R C):      E(h) = E₀ e^(−x) + p h (1 − e^(−x))/x,   x = λ h
//! ```
//!
//! which is exact for any interval `h`. Above the highest voltage the income is shunted; at the lock-out
//! voltage the load is disconnected until the voltage reaches the turn-on voltage. Converters lose a constant
//! part of the energy that they convert; their idle power belongs to the load.

use super::battery::BatteryCurve;
use crate::bounds::{Bounds, ParameterError, bounded};
use crate::part::storage::Capacitor;
use crate::scalar::{Mathematics, Scalar, horner};
use crate::snapshot::Fingerprint;

/// Parameters of a storage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StorageParameters<S> {
    /// Capacitance, 10⁻⁹ to 10⁵ F, and leakage resistance, 1 Ω or more.
    pub capacitor: Capacitor<S>,
    /// Part of the harvested energy that reaches the storage, 0.01 to 1.
    pub charging_efficiency: S,
    /// Part of the energy taken from the storage that reaches the load, 0.01 to 1.
    pub discharging_efficiency: S,
    /// Voltage in V at which further income is shunted, 0.01 to 1000.
    pub highest_voltage: S,
    /// Voltage in V at or below which the load is switched off, 0 to `highest_voltage`.
    pub lock_out_voltage: S,
    /// Voltage in V at which the load is switched on again, `lock_out_voltage` to `highest_voltage`. The
    /// budget does not depend on it: a running node has passed it.
    pub turn_on_voltage: S,
}

bounded! { StorageParameters<S>:
    "capacitance" = capacitor.capacitance: 1e-9, 1e5;
    "leakage_resistance" = capacitor.leakage_resistance: 1.0, f64::INFINITY;
    "charging_efficiency" = charging_efficiency: 0.01, 1.0;
    "discharging_efficiency" = discharging_efficiency: 0.01, 1.0;
    "highest_voltage" = highest_voltage: 0.01, 1e3;
}

impl<S: Scalar> StorageParameters<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first field outside its bounds.
    pub fn build(self) -> Result<Storage<S>, ParameterError<S>> {
        self.check()?;
        let half_capacitance = S::from_f64(0.5) * self.capacitor.capacitance;
        let energy = |voltage: S| half_capacitance * voltage * voltage;
        Ok(Storage {
            leakage_rate: S::ONE / (half_capacitance * self.capacitor.leakage_resistance),
            drawn_per_used: S::ONE / self.discharging_efficiency,
            capacity: energy(self.highest_voltage),
            lock_out: energy(self.lock_out_voltage),
            parameters: self,
            battery: None,
        })
    }

    /// Checks the parameters, with a battery beside the capacitor. The leakage resistance counts as at the highest voltage.
    ///
    /// # Errors
    /// The first field outside its bounds; the capacitance must be that of the curve, and lock-out and highest voltage must be
    /// within those of the battery.
    pub fn build_with_battery(
        self,
        battery: &'static BatteryCurve<S>,
    ) -> Result<Storage<S>, ParameterError<S>> {
        self.check()?;
        // The curve has the capacitance in f32.
        let [lowest, highest] = [1.0 - 1e-6, 1.0 + 1e-6].map(|part| S::from_f64(part) * battery.capacitance);
        Bounds { lowest, highest }.check("capacitance", self.capacitor.capacitance)?;
        battery.voltages.check("lock_out_voltage", self.lock_out_voltage)?;
        battery.voltages.check("highest_voltage", self.highest_voltage)?;
        let highest = self.highest_voltage;
        let capacity = battery.energy(highest);
        let leaking = highest * highest / (self.capacitor.leakage_resistance * capacity);
        Ok(Storage {
            leakage_rate: battery.self_discharge + leaking,
            drawn_per_used: S::ONE / self.discharging_efficiency,
            capacity,
            lock_out: battery.energy(self.lock_out_voltage),
            parameters: Self {
                charging_efficiency: battery.charging_efficiency * self.charging_efficiency,
                ..self
            },
            battery: Some(battery),
        })
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        self.check_numbers()?;
        let highest = self.highest_voltage;
        Bounds { lowest: S::ZERO, highest }.check("lock_out_voltage", self.lock_out_voltage)?;
        Bounds { lowest: self.lock_out_voltage, highest }.check("turn_on_voltage", self.turn_on_voltage)
    }
}

/// A storage with checked parameters. Energies are in J at the storage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Storage<S: 'static> {
    parameters: StorageParameters<S>,
    /// `λ` in 1/s.
    leakage_rate: S,
    /// Energy from the storage per energy used by the load.
    drawn_per_used: S,
    capacity: S,
    lock_out: S,
    battery: Option<&'static BatteryCurve<S>>,
}

impl<S: Scalar> Storage<S> {
    /// The parameters; of a storage with a battery the charging efficiency is that of both.
    #[must_use]
    pub fn parameters(&self) -> &StorageParameters<S> {
        &self.parameters
    }

    /// Stored energy in J at a voltage in V, of a battery the open-circuit voltage, without the limit of the highest voltage.
    #[must_use]
    pub fn energy(&self, voltage: S) -> S {
        if let Some(battery) = self.battery {
            return battery.energy(voltage);
        }
        S::from_f64(0.5) * self.parameters.capacitor.capacitance * voltage * voltage
    }

    /// Voltage in V at a stored energy in J; 0 for an energy at or below 0. One square root.
    #[must_use]
    #[inline(never)]
    pub fn voltage(&self, energy: S) -> S {
        if let Some(battery) = self.battery {
            return battery.voltage(energy);
        }
        (S::from_f64(2.0) * energy / self.parameters.capacitor.capacitance).sqrt()
    }

    /// Includes all parameters in a fingerprint.
    pub(crate) fn identify(&self, fingerprint: &mut Fingerprint) {
        let StorageParameters { capacitor, .. } = self.parameters;
        fingerprint.numbers(&[
            capacitor.capacitance,
            capacitor.leakage_resistance,
            self.parameters.charging_efficiency,
            self.parameters.discharging_efficiency,
            self.parameters.highest_voltage,
            self.parameters.lock_out_voltage,
            self.parameters.turn_on_voltage,
        ]);
        if let Some(battery) = self.battery {
            battery.identify(fingerprint);
        }
    }

    /// Energy in J at the highest voltage.
    pub(crate) fn capacity(&self) -> S {
        self.capacity
    }

    /// Energy in J at the lock-out voltage, not available to the load.
    pub(crate) fn lock_out(&self) -> S {
        self.lock_out
    }

    /// Energy in J into the storage for a harvested energy in J.
    #[must_use]
    #[inline]
    pub fn stored(&self, harvested: S) -> S {
        harvested * self.parameters.charging_efficiency
    }

    /// Energy in J from the storage for an energy in J used by the load.
    #[inline]
    pub(crate) fn drawn(&self, used: S) -> S {
        used * self.drawn_per_used
    }

    /// The relaxation of the storage over an interval in s, at or above 0. At most one exponential.
    pub(super) fn relaxation(&self, seconds: S) -> Relaxation<S> {
        Relaxation::new(self.leakage_rate * seconds)
    }

    /// Advances a stored `energy` over the interval of `relaxation`, with the evenly distributed energies
    /// `income` and `outgo`, all in J at the storage.
    ///
    /// The load can discharge the storage to its lock-out, and only leakage goes below. The energy at the end
    /// is exact. For a full storage the leakage is computed as if nothing were shunted before the end, so
    /// that up to `x/2` of the shunted energy may be counted as leakage.
    pub(super) fn step(&self, energy: S, relaxation: &Relaxation<S>, income: S, outgo: S) -> StorageStep<S> {
        let net = income - outgo;
        let leaked = relaxation.leaked(energy, net);
        let change = net - leaked;
        let end = energy + change;
        if end > self.capacity {
            let shunted = end - self.capacity;
            return StorageStep { end: self.capacity, change, leaked, shunted, unserved: S::ZERO };
        }
        if end < self.lock_out {
            let without_load = energy + (income - relaxation.leaked(energy, income));
            let floor = self.lock_out.min(without_load);
            if !(end < floor) {
                return StorageStep { end, change, leaked, shunted: S::ZERO, unserved: S::ZERO };
            }
            let unserved = ((floor - end) / relaxation.of_income).min(outgo);
            let leaked = leaked + unserved * relaxation.lost_of_income();
            return StorageStep { end: floor, change, leaked, shunted: S::ZERO, unserved };
        }
        StorageStep { end, change, leaked, shunted: S::ZERO, unserved: S::ZERO }
    }
}

/// The result of an interval, in J at the storage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StorageStep<S> {
    /// Energy at the end.
    pub end: S,
    /// Change of a storage without limits: `end` less the start if nothing was shunted or left unserved, and
    /// not rounded to the size of the storage.
    pub change: S,
    /// Leaked energy.
    pub leaked: S,
    /// Income for which there was no room.
    pub shunted: S,
    /// Requested energy that the load did not get.
    pub unserved: S,
}

/// The closed forms of an interval of ratio `x = λ h`; `x = 0` without leakage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Relaxation<S> {
    ratio: S,
    /// `e^(−x)`: remaining part of the initial energy.
    pub remaining: S,
    /// `(1 − e^(−x))/x`: remaining part of an even income.
    pub of_income: S,
    /// `(1 − (1 − e^(−x))/x)/x`.
    second: S,
}

/// Ratio below which the closed forms cancel and their series are used.
const SERIES_RATIO: f64 = 0.5;

/// The coefficients of `Σ (−x)ⁿ/(n+2)!` up to the rounding of `f64` at [`SERIES_RATIO`].
fn second<S: Scalar>() -> [S; 14] {
    // Each by itself: a loop over a table of `f64` would be converted by the firmware.
    macro_rules! over {
        ($($product:literal)+) => { [$(S::from_f64(1.0 / $product)),+] };
    }
    over!(2.0 -6.0 24.0 -120.0 720.0 -5040.0 40_320.0 -362_880.0 3_628_800.0 -39_916_800.0 479_001_600.0
        -6_227_020_800.0 87_178_291_200.0 -1_307_674_368_000.0)
}

impl<S: Scalar> Relaxation<S> {
    /// Over an interval of `ratio` times the time constant. A function of its own: a node calls it from several places.
    #[inline(never)]
    pub(super) fn new(ratio: S) -> Self {
        if ratio < S::from_f64(SERIES_RATIO) {
            let second = if ratio * ratio * ratio < S::from_f64(15.0) * S::EPSILON {
                // The next term is below a quarter of a rounding.
                let [first, second, third, ..] = second();
                first + ratio * (second + ratio * third)
            } else {
                horner(&second(), ratio)
            };
            let of_income = S::ONE - ratio * second;
            Self { ratio, remaining: S::ONE - ratio * of_income, of_income, second }
        } else {
            let remaining = S::Build::exponential(-ratio);
            let of_income = (S::ONE - remaining) / ratio;
            Self { ratio, remaining, of_income, second: (S::ONE - of_income) / ratio }
        }
    }

    /// Leakage in J of `energy` at the start and an even net income `net`, both in J, without cancellation.
    #[inline]
    fn leaked(&self, energy: S, net: S) -> S {
        self.ratio * (energy * self.of_income + net * self.second)
    }

    /// `1 − e^(−x)`: leaked part of the initial energy.
    #[inline]
    pub(super) fn lost(&self) -> S {
        self.ratio * self.of_income
    }

    /// Leaked part of an even income.
    #[inline]
    pub(super) fn lost_of_income(&self) -> S {
        self.ratio * self.second
    }

    /// Remaining part of an even income less that of an income at the start.
    #[inline]
    pub(super) fn lost_by_early_income(&self) -> S {
        self.ratio * (self.of_income - self.second)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// 220 µF with 10 MΩ across it, efficiencies 0.8 and 0.9, from 1.8 V to 4.5 V, turned on at 2.4 V.
    pub(crate) fn example<S: Scalar>() -> StorageParameters<S> {
        StorageParameters {
            capacitor: Capacitor { capacitance: S::from_f64(220e-6), leakage_resistance: S::from_f64(10e6) },
            charging_efficiency: S::from_f64(0.8),
            discharging_efficiency: S::from_f64(0.9),
            highest_voltage: S::from_f64(4.5),
            lock_out_voltage: S::from_f64(1.8),
            turn_on_voltage: S::from_f64(2.4),
        }
    }

    #[test]
    fn energy_and_voltage_are_inverse() {
        let storage = example::<f64>().build().expect("within bounds");
        for voltage in [0.0, 1e-3, 1.8, 4.5, 100.0] {
            assert!((storage.voltage(storage.energy(voltage)) - voltage).abs() <= 1e-15 * voltage);
        }
        assert!((storage.capacity() - 2.2275e-3).abs() < 1e-15);
    }

    #[test]
    fn closed_form_is_the_solution_of_the_differential_equation() {
        // RK4 with steps of a thousandth of the interval, or of the time constant.
        for resistance in [f64::INFINITY, 1e9, 10e6, 1.2e6, 1e5, 3e3] {
            // With a lock-out, the storages with more leakage would reach it.
            let parameters = StorageParameters {
                capacitor: Capacitor { leakage_resistance: resistance, ..example::<f64>().capacitor },
                lock_out_voltage: 0.0,
                ..example::<f64>()
            };
            let storage = parameters.build().expect("within bounds");
            let (start, income, outgo, seconds) = (1e-3, 4e-5, 1e-5, 60.0);
            let rate = 2.0 / (resistance * 220e-6);
            let slope = |energy: f64| (income - outgo) / seconds - rate * energy;
            let count = 1000.0 * (rate * seconds).max(1.0).ceil();
            let step = seconds / count;
            let (mut energy, mut leaked) = (start, 0.0);
            for _ in 0..count as usize {
                let k1 = slope(energy);
                let k2 = slope(energy + 0.5 * step * k1);
                let k3 = slope(energy + 0.5 * step * k2);
                let k4 = slope(energy + step * k3);
                let next = energy + step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
                leaked += (income - outgo) / count - (next - energy);
                energy = next;
            }
            let relaxation = storage.relaxation(seconds);
            let step = storage.step(start, &relaxation, income, outgo);
            assert!((step.end / energy - 1.0).abs() < 1e-11, "{resistance}: {} {energy}", step.end);
            assert!((step.leaked - leaked).abs() < 1e-11 * start, "{resistance}");
            let single = StorageParameters {
                capacitor: Capacitor { leakage_resistance: resistance as f32, ..example::<f32>().capacitor },
                lock_out_voltage: 0.0,
                ..example::<f32>()
            };
            let single = single.build().expect("within bounds");
            let step = single.step(1e-3, &single.relaxation(60.0), 4e-5, 1e-5);
            // The rounding of x is a relative error of its exponential; changes are rounded like the start.
            let allowed = 4e-7 * (1.0 + rate * seconds) * energy + 2e-7 * start;
            assert!((f64::from(step.end) - energy).abs() < allowed, "{resistance}");
        }
    }

    #[test]
    fn series_and_exponential_meet() {
        for x in [0.499_999_f64, 0.500_001, 1e-9, 3.0, 800.0] {
            let relaxation = Relaxation::new(x);
            assert!((relaxation.remaining - (-x).exp()).abs() < 3e-16);
            assert!((relaxation.of_income + (-x).exp_m1() / x).abs() < 3e-16);
            assert!((relaxation.lost_of_income() - (1.0 + (-x).exp_m1() / x)).abs() < 3e-16);
            let early = -(-x).exp_m1() / x - (-x).exp();
            assert!((relaxation.lost_by_early_income() - early).abs() < 3e-16, "{x}");
        }
    }

    #[test]
    fn a_full_store_shunts_and_an_empty_one_leaves_the_load_unserved() {
        let storage = example::<f64>().build().expect("within bounds");
        let relaxation = storage.relaxation(60.0);
        let balance = |start: f64, income: f64, outgo: f64| {
            let step = storage.step(start, &relaxation, income, outgo);
            let residual =
                (step.end - start) - (income - step.shunted - step.leaked - (outgo - step.unserved));
            assert!(residual.abs() < 1e-17, "{residual}");
            step
        };
        let full = balance(storage.capacity() * 0.999, 1e-3, 0.0);
        assert!(full.end == storage.capacity() && full.shunted > 8e-4);
        let empty = balance(storage.lock_out() + 5e-5, 0.0, 1e-4);
        assert!(empty.end == storage.lock_out() && empty.unserved > 5e-5);
        // Below the lock-out the storage only leaks.
        let below = balance(storage.lock_out() * 0.5, 0.0, 1e-4);
        assert!((below.unserved - 1e-4).abs() < 1e-17);
        assert!((below.end - storage.lock_out() * 0.5 * relaxation.remaining).abs() < 1e-18);
    }

    #[test]
    fn parameters_are_refused_by_name() {
        let refused = |change: fn(&mut StorageParameters<f32>)| {
            let mut parameters = example();
            change(&mut parameters);
            parameters.build().expect_err("out of bounds").field
        };
        assert_eq!(refused(|p| p.capacitor.capacitance = 0.0), "capacitance");
        assert_eq!(refused(|p| p.capacitor.leakage_resistance = f32::NAN), "leakage_resistance");
        assert_eq!(refused(|p| p.charging_efficiency = 1.1), "charging_efficiency");
        assert_eq!(refused(|p| p.discharging_efficiency = 0.0), "discharging_efficiency");
        assert_eq!(refused(|p| p.highest_voltage = -1.0), "highest_voltage");
        assert_eq!(refused(|p| p.lock_out_voltage = 4.6), "lock_out_voltage");
        assert_eq!(refused(|p| p.turn_on_voltage = 1.7), "turn_on_voltage");
    }
}
