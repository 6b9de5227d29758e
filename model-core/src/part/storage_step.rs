//! Steps a storage over a part of a step without income: leakage and draw.
//!
//! `C V' = −I(V)` is solved by the exponential Rosenbrock rule
//!
//! ```text
//! ΔV = −(h/C) I(V) φ(−h I'(V)/C),      φ(z) = (e^z − 1)/z,
//! ```
//!
//! which is exact for an outflow that is affine in the voltage (leakage, a resistor, a constant current) and
//! of second order otherwise (a constant power). The outgoing energy `½ C (V² − V⁺²)` is divided between
//! leakage and draw in the ratio of their currents at the mean voltage.
//!
//! A draw with a lock-out takes the voltage down to its turn-off voltage and no further; what leaks in the rest of that step is left
//! out. It is connected again at the end of a step: in 80 µs at 100 µA the voltage of a storage of 1 µF rises by 8 mV, and that of 1 mF
//! by 8 µV.

use super::storage::StorageElement;
use crate::scalar::{Mathematics, Scalar, add_increment};
use crate::snapshot::snapshot_fields;

/// The state of a storage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StorageState<S> {
    /// Voltage in V.
    pub voltage: S,
    /// The part of the voltage that rounding removed.
    pub(crate) remainder: S,
    /// Whether the draw is connected.
    pub connected: bool,
}

snapshot_fields!(impl [S: Scalar] StorageState<S> { voltage, remainder, connected });

/// Energies of a step in J, none negative.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StorageAccount<S> {
    /// Into the storage: the integral of its voltage times the rectified current.
    pub delivered: S,
    /// Lost in the diodes.
    pub diodes: S,
    /// Leaked from the storage.
    pub leaked: S,
    /// Drawn from the storage.
    pub drawn: S,
}

impl<S: Scalar> StorageState<S> {
    /// The state before the first step.
    pub(crate) fn of<R: StorageElement<S>>(storage: &R) -> Self {
        Self { voltage: storage.initial_voltage(), remainder: S::ZERO, connected: storage.starts_connected() }
    }

    /// Raises the voltage in V.
    #[inline]
    pub(crate) fn rise(&mut self, increase: S) {
        (self.voltage, self.remainder) = add_increment(self.voltage, self.remainder, increase);
    }

    /// Applies leakage and draw for `seconds`; `elastance` in 1/F is that of the storage, or of the storage and all that
    /// falls with it. Returns the fall of the voltage in V.
    #[inline]
    pub(crate) fn drain<R: StorageElement<S>>(
        &mut self,
        storage: &R,
        elastance: S,
        seconds: S,
        account: &mut StorageAccount<S>,
    ) -> S {
        if !R::CHARGES {
            return S::ZERO;
        }
        let outflow = storage.outflow(self.voltage, self.connected);
        let per_current = elastance * seconds;
        if !(outflow > S::ZERO) || per_current == S::ZERO {
            return S::ZERO;
        }
        let growth = -per_current * storage.outflow_by_voltage(self.voltage, self.connected);
        let mut charge = seconds * outflow * mean_growth(growth);
        let mut fall = elastance * charge;
        // A current that does not fall with the voltage empties the storage within the step, or down to its lock-out.
        let most = self.voltage - self.lowest(storage);
        if fall > most {
            (charge, fall) = (most / elastance, most);
        }
        let mean = self.voltage - S::from_f64(0.5) * fall;
        self.rise(-fall);
        let energy = charge * mean;
        let (leakage, total) = (storage.leakage(mean), storage.outflow(mean, self.connected));
        let leaked = if total > S::ZERO { energy * (leakage / total) } else { S::ZERO };
        account.leaked += leaked;
        account.drawn += energy - leaked;
        fall
    }

    /// The voltage in V that the outflow does not fall below: where the draw is disconnected.
    #[inline]
    fn lowest<R: StorageElement<S>>(&self, storage: &R) -> S {
        match storage.lockout() {
            Some(lockout) if R::SWITCHES && self.connected => lockout.turn_off.max(S::ZERO).min(self.voltage),
            _ => S::ZERO,
        }
    }

    /// The time in s in which leakage and draw lower the voltage by `fall` in V, at most `longest` in s.
    ///
    /// Newton's iteration from zero. The fall is concave in time for an outflow that falls with the voltage, and convex for
    /// a constant power: it then comes from above.
    #[inline]
    pub(crate) fn time_to_fall<R: StorageElement<S>>(
        &self,
        storage: &R,
        elastance: S,
        fall: S,
        longest: S,
    ) -> S {
        let rate = elastance * storage.outflow(self.voltage, self.connected);
        let decay = elastance * storage.outflow_by_voltage(self.voltage, self.connected);
        let mut time = S::ZERO;
        for _ in 0..NEWTON_STEPS {
            let fallen = time * rate * mean_growth(-time * decay);
            let (left, slope) = (fall - fallen, rate - decay * fallen);
            if left.abs() <= S::EPSILON * fall {
                break;
            }
            if !(slope > S::ZERO) {
                return longest;
            }
            time = (time + left / slope).max(S::ZERO).min(longest);
        }
        time
    }

    /// Connects or disconnects the draw.
    #[inline]
    pub(crate) fn switch<R: StorageElement<S>>(&mut self, storage: &R) {
        if R::SWITCHES
            && let Some(lockout) = storage.lockout()
        {
            let threshold = if self.connected { lockout.turn_off } else { lockout.turn_on };
            self.connected =
                if self.connected { self.voltage > threshold } else { self.voltage >= threshold };
        }
    }
}

/// Most iterations of [`StorageState::time_to_fall`]: each advances by at least nearly a time constant.
const NEWTON_STEPS: u32 = 40;

/// Magnitude up to which the series is summed, because the closed form cancels.
const SERIES_GROWTH: f64 = 0.0625;

/// `φ(z) = (e^z − 1)/z`.
#[inline]
fn mean_growth<S: Scalar>(z: S) -> S {
    if z.abs() <= S::from_f64(SERIES_GROWTH) {
        // 1 + z/2 (1 + z/3 (1 + …)): the first omitted term is below 2⁻⁵³.
        let next = |inner: S, part: S| S::ONE + z * part * inner;
        let sum = next(S::ONE, S::from_f64(1.0 / 9.0));
        let sum = next(sum, S::from_f64(1.0 / 8.0));
        let sum = next(sum, S::from_f64(1.0 / 7.0));
        let sum = next(sum, S::from_f64(1.0 / 6.0));
        let sum = next(sum, S::from_f64(1.0 / 5.0));
        let sum = next(sum, S::from_f64(1.0 / 4.0));
        let sum = next(sum, S::from_f64(1.0 / 3.0));
        next(sum, S::from_f64(1.0 / 2.0))
    } else {
        far_growth(z)
    }
}

#[cold]
fn far_growth<S: Scalar>(z: S) -> S {
    (S::Build::exponential(z) - S::ONE) / z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::draw::{AnyDraw, CurrentDraw, Lockout, NoDraw, PowerDraw, ResistiveDraw};
    use crate::part::storage::{Capacitor, DcBus, StorageCapacitor};

    const LOCKOUT: Lockout<f64> = Lockout { turn_on: 3.0, turn_off: 1.0 };

    fn storage(leakage_resistance: f64, draw: AnyDraw<f64>) -> StorageCapacitor<f64, AnyDraw<f64>> {
        StorageCapacitor {
            capacitor: Capacitor { capacitance: 1e-6, leakage_resistance },
            initial_voltage: 3.5,
            draw,
        }
    }

    /// Voltage after `seconds` in `count` steps, and the energies of these steps.
    fn after(
        storage: &StorageCapacitor<f64, AnyDraw<f64>>,
        seconds: f64,
        count: u32,
    ) -> (f64, StorageAccount<f64>) {
        let (mut state, mut account) = (StorageState::of(storage), StorageAccount::default());
        for _ in 0..count {
            state.drain(storage, 1e6, seconds / f64::from(count), &mut account);
        }
        (state.voltage, account)
    }

    #[test]
    fn affine_outflow_is_exact_in_a_step_of_any_length() {
        let resistor = AnyDraw::Resistor(ResistiveDraw { resistance: 3e4, lockout: None });
        let current = AnyDraw::Current(CurrentDraw { current: 2e-5, lockout: LOCKOUT });
        for seconds in [1e-6_f64, 1e-3, 0.02, 0.3] {
            for count in [1, 7] {
                let decay = |ohms: f64| (-seconds / (ohms * 1e-6)).exp();
                let (leaked, _) = after(&storage(1e5, AnyDraw::None), seconds, count);
                assert!((leaked - 3.5 * decay(1e5)).abs() < 1e-14, "{seconds} {leaked}");
                let (both, account) = after(&storage(1e5, resistor), seconds, count);
                let parallel = 1.0 / (1.0 / 1e5 + 1.0 / 3e4);
                assert!((both - 3.5 * decay(parallel)).abs() < 1e-14, "{seconds} {both}");
                // A leakage of 3/13 of the conductance takes 3/13 of the energy.
                let gone = 0.5e-6 * (3.5 * 3.5 - both * both);
                assert!((account.leaked / gone - 3.0 / 13.0).abs() < 1e-8, "{}", account.leaked / gone);
                assert!(((account.leaked + account.drawn) / gone - 1.0).abs() < 1e-8);
                // C V' = −V/R − I: towards −R I, down to the lock-out.
                let (fed, _) = after(&storage(1e5, current), seconds, count);
                let exact = (-2.0 + (3.5 + 2.0) * decay(1e5)).max(LOCKOUT.turn_off);
                assert!((fed - exact).abs() < 1e-12, "{seconds} {fed} {exact}");
            }
        }
    }

    #[test]
    fn constant_power_is_taken_in_second_order() {
        let watts = 2e-5;
        let storage = storage(f64::INFINITY, AnyDraw::Power(PowerDraw { power: watts, lockout: LOCKOUT }));
        // ½ C V² falls by P t.
        let exact = (3.5_f64 * 3.5 - 2.0 * watts * 0.1 / 1e-6).sqrt();
        let error = |count| (after(&storage, 0.1, count).0 - exact).abs();
        let (coarse, fine) = (error(20), error(40));
        assert!(coarse < 1e-3 && (coarse / fine - 4.0).abs() < 0.3, "{coarse} {fine}");
        let (_, account) = after(&storage, 0.1, 4000);
        assert!((account.drawn / (watts * 0.1) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_draw_is_connected_with_hysteresis() {
        let storage =
            storage(f64::INFINITY, AnyDraw::Current(CurrentDraw { current: 1e-5, lockout: LOCKOUT }));
        let mut state = StorageState::of(&storage);
        let mut seen = Vec::new();
        for voltage in [3.5, 1.5, 1.0, 1.5, 2.9, 3.0, 1.1] {
            state.voltage = voltage;
            state.switch(&storage);
            seen.push(state.connected);
        }
        assert_eq!(seen, [true, true, false, false, false, true, true]);
        // A bus has no switch, and a storage without outflow keeps its charge.
        let mut account = StorageAccount::default();
        let bus = DcBus { voltage: 2.0 };
        let mut state = StorageState::of(&bus);
        state.drain(&bus, 0.0, 1.0, &mut account);
        let sealed = StorageCapacitor {
            capacitor: Capacitor { capacitance: 1e-6, leakage_resistance: f64::INFINITY },
            initial_voltage: 2.0,
            draw: NoDraw,
        };
        state.drain(&sealed, 1e6, 1.0, &mut account);
        assert_eq!((state.voltage, account), (2.0, StorageAccount::default()));
    }

    #[test]
    fn growth_is_right_on_both_sides_of_the_series() {
        for z in [-40.0_f64, -1.0, -0.07, -0.062, -1e-3, 0.0, 1e-9, 0.06, 0.07, 3.0] {
            let exact = if z == 0.0 { 1.0 } else { z.exp_m1() / z };
            assert!((mean_growth(z) / exact - 1.0).abs() < 4e-15, "{z}");
            assert!((f64::from(mean_growth(z as f32)) / exact - 1.0).abs() < 3e-6, "{z}");
        }
    }

    #[test]
    fn a_draw_that_empties_the_store_at_once_takes_what_is_above_its_lock_out() {
        // The exponential of the growth of the current overflows single precision.
        let lockout = Lockout { turn_on: 0.9_f32, turn_off: 0.5 };
        let draw = AnyDraw::Power(PowerDraw { power: 5e-3, lockout });
        let storage = StorageCapacitor {
            capacitor: Capacitor { capacitance: 1e-7, leakage_resistance: 1e9 },
            initial_voltage: 1.0,
            draw,
        };
        let (mut state, mut account) = (StorageState::of(&storage), StorageAccount::<f32>::default());
        state.drain(&storage, storage.elastance(), 15.6e-3, &mut account);
        assert_eq!(state.voltage, lockout.turn_off);
        let above = 0.5e-7 * (1.0 - 0.5 * 0.5);
        assert!(((account.drawn + account.leaked) / above - 1.0).abs() < 1e-6, "{account:?}");
        state.switch(&storage);
        assert!(!state.connected);
    }
}
