//! Steps a capacitance behind a full bridge under a constant current.
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `w` | voltage of the capacitance at the start, positive in the direction of the current | V |
//! | `x = abs(Δq) ≥ 0` | charge of the step | C |
//! | `U = V + 2 V_D` | threshold voltage, `≥ abs(w)` | V |
//! | `C_p`, `C` | the capacitance, and that of the storage | F |
//! | `C_t = C_p + C` | total capacitance while the bridge conducts | F |
//! | `x_c = C_p (U − w)` | charge at which conduction begins | C |
//! | `f = x_c/x` | fraction of the step before conduction | 1 |
//!
//! The voltage rises at `1/C_p` per charge up to `U`, and then at `1/C_t`, while a part `C/C_t` of the charge
//! passes into the storage. Its mean over the step is
//!
//! ```text
//! m(x) = w + x/(2 C_p)                                                x ≤ x_c : blocked
//! m(x) = U + ½ [x (1 − f)²/C_t − f (U − w)]                           x > x_c
//! m'(x) = ½ [(1 − f²)/C_t + f²/C_p]
//! ```
//!
//! (derived here). The work `m x` equals the energy stored in the capacitance, delivered to the storage and
//! lost in the diodes: `m` is the discrete gradient of a convex potential of the charge, so a step of any
//! length is passive. `m` increases and, for a current in one direction, is concave with a continuous slope.
//! Newton's iteration for a scalar equation in `m` starts from the blocked line, which is the tangent at `x =
//! 0`: the iterates converge quadratically from one side.
//!
//! # Limits
//!
//! In a step that reverses the current, `x` is the difference of the charges in the two directions, and the
//! smaller of them is not rectified. This error is of second order in the step, like the error of the run.
//!
//! # Outflow of the storage
//!
//! Half of the outflow is taken at the start of the step and half at its end, so the composition is of second
//! order. Each half is the exact motion without current: the storage falls alone until the bridge conducts, and from then
//! on together with the capacitance. So a storage that is far smaller than the capacitance does not empty within a step.

use super::circuit::CircuitStep;
use super::load::Resistance;
use super::rectifier::FullBridge;
use super::storage::StorageElement;
use super::storage_step::{StorageAccount, StorageState};
use crate::scalar::Scalar;

/// The coefficients for one step length.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BridgeStep<S> {
    /// While the bridge blocks.
    pub blocked: CircuitStep<S>,
    /// Half the step in s.
    half: S,
    /// `C_p` in F.
    capacitance: S,
    /// `1/C_p`, the storage's `1/C`, and `1/C_t`, in 1/F.
    own: S,
    storage: S,
    together: S,
    /// `C/C_t`: part of a charge that passes the bridge.
    share: S,
}

/// The result of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BridgeCharge<S> {
    /// Charge in C that leaves the electrodes.
    pub charge: S,
    /// Mean square in V² of the terminal voltage if the bridge conducts.
    pub mean_square_voltage: Option<S>,
}

/// The threshold in terms of the charge of a step.
struct Approach<S> {
    /// Direction of the current.
    sign: S,
    /// `U`, and `U − w`, in V.
    threshold: S,
    room: S,
    /// `x_c`, and `x − x_c`, in C.
    before: S,
    beyond: S,
}

impl<S: Scalar> Approach<S> {
    /// `f`, for `x > x_c` only.
    #[inline]
    fn part_before(&self) -> S {
        self.before / (self.before + self.beyond)
    }
}

impl<S: Scalar> BridgeStep<S> {
    /// For a capacitance in F above 0, the storage behind the bridge, and a step in s above 0.
    pub(crate) fn new<R: StorageElement<S>>(capacitance: S, storage: &R, step: S) -> Self {
        let (own, storage) = (S::ONE / capacitance, storage.elastance());
        let share = own / (own + storage);
        Self {
            blocked: CircuitStep::new(capacitance, Resistance::Open, step),
            half: S::from_f64(0.5) * step,
            capacitance,
            own,
            storage,
            together: share * storage,
            share,
        }
    }

    #[inline]
    fn approach(&self, threshold: S, voltage: S, charge: S) -> Approach<S> {
        let sign = if charge < S::ZERO { -S::ONE } else { S::ONE };
        let room = (threshold - sign * voltage).max(S::ZERO);
        let before = room * self.capacitance;
        Approach { sign, threshold, room, before, beyond: sign * charge - before }
    }

    /// The tangent `[e0, e1]` of the mean voltage, `e0 + e1 Δq`, at a charge Δq in C for which the bridge
    /// conducts; `None` if the bridge blocks.
    ///
    /// `voltage` in V at the start of the step is within `±threshold`.
    #[inline]
    pub(crate) fn tangent(&self, threshold: S, voltage: S, charge: S) -> Option<[S; 2]> {
        let at = self.approach(threshold, voltage, charge);
        if !(at.beyond > S::ZERO) {
            return None;
        }
        let part = at.part_before();
        let square = part * part;
        let slope = S::from_f64(0.5) * ((S::ONE - square) * self.together + square * self.own);
        let start = at.threshold - part * (at.room + at.beyond * self.together);
        Some([at.sign * start, slope])
    }

    /// Applies a charge Δq from a voltage v within the threshold, `[v, Δq]`, then the second half of the outflow.
    #[inline]
    pub(crate) fn conclude<R: StorageElement<S>>(
        &self,
        bridge: &FullBridge<S, R>,
        [voltage, charge]: [S; 2],
        storage: &mut StorageState<S>,
        account: &mut StorageAccount<S>,
    ) -> BridgeCharge<S> {
        let (transferred, mean_square_voltage) = self.pass(bridge, [voltage, charge], storage, account);
        let end = voltage + (charge - transferred) * self.own;
        let late = self.drain(bridge, end, storage, account);
        storage.switch(&bridge.storage);
        BridgeCharge { charge: transferred + late, mean_square_voltage }
    }

    /// Applies the charge without outflow. Returns the signed charge in C that passes into the storage, and
    /// the mean square of the terminal voltage if the bridge conducts.
    #[inline]
    fn pass<R: StorageElement<S>>(
        &self,
        bridge: &FullBridge<S, R>,
        [voltage, charge]: [S; 2],
        storage: &mut StorageState<S>,
        account: &mut StorageAccount<S>,
    ) -> (S, Option<S>) {
        let at = self.approach(bridge.threshold(storage.voltage), voltage, charge);
        if !(at.beyond > S::ZERO) {
            return (S::ZERO, None);
        }
        let part = at.part_before();
        let (from, to) = (at.threshold - at.room, at.threshold + at.beyond * self.together);
        let square = |a: S, b: S| S::from_f64(1.0 / 3.0) * (a * a + a * b + b * b);
        let mean_square = part * square(from, at.threshold) + (S::ONE - part) * square(at.threshold, to);
        let transferred = self.share * at.beyond;
        self.receive(bridge, transferred, S::ZERO, storage, account);
        (at.sign * transferred, Some(mean_square))
    }

    /// Applies half of the outflow of the storage. The capacitance falls with the storage from the instant at which the
    /// bridge conducts. Returns the signed charge in C that passes the bridge.
    #[inline]
    pub(crate) fn drain<R: StorageElement<S>>(
        &self,
        bridge: &FullBridge<S, R>,
        voltage: S,
        storage: &mut StorageState<S>,
        account: &mut StorageAccount<S>,
    ) -> S {
        let (mut alone, mut of_alone) = (*storage, *account);
        alone.drain(&bridge.storage, self.storage, self.half, &mut of_alone);
        if !(voltage.abs() > bridge.threshold(alone.voltage)) {
            (*storage, *account) = (alone, of_alone);
            return S::ZERO;
        }
        let transferred = self.drain_together(bridge, voltage.abs(), storage, account);
        if voltage < S::ZERO { -transferred } else { transferred }
    }

    /// Applies half of the outflow to the storage until its threshold falls to a magnitude of the voltage, and then to the
    /// storage and the capacitance together.
    #[cold]
    fn drain_together<R: StorageElement<S>>(
        &self,
        bridge: &FullBridge<S, R>,
        magnitude: S,
        storage: &mut StorageState<S>,
        account: &mut StorageAccount<S>,
    ) -> S {
        let excess = magnitude - bridge.threshold(storage.voltage);
        let (mut transferred, mut alone) = (S::ZERO, S::ZERO);
        if excess > S::ZERO {
            transferred = self.share * excess * self.capacitance;
            self.receive(bridge, transferred, excess, storage, account);
        } else {
            alone = storage.time_to_fall(&bridge.storage, self.storage, -excess, self.half);
            storage.drain(&bridge.storage, self.storage, alone, account);
        }
        let fall = storage.drain(&bridge.storage, self.together, self.half - alone, account);
        let following = self.capacitance * fall;
        account.delivered += following * (storage.voltage + S::from_f64(0.5) * fall);
        account.diodes += following * (bridge.diode_drop + bridge.diode_drop);
        transferred + following
    }

    /// Adds a charge in C to the storage, from a terminal voltage that exceeds the threshold by `excess` at
    /// the start and by 0 at the end.
    #[inline]
    fn receive<R: StorageElement<S>>(
        &self,
        bridge: &FullBridge<S, R>,
        charge: S,
        excess: S,
        storage: &mut StorageState<S>,
        account: &mut StorageAccount<S>,
    ) {
        let rise = charge * self.storage;
        let half = S::from_f64(0.5);
        account.delivered += charge * (storage.voltage + half * rise);
        account.diodes += charge * (bridge.diode_drop + bridge.diode_drop + half * excess);
        storage.rise(rise);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::draw::{Lockout, NoDraw, PowerDraw};
    use crate::part::storage::{Capacitor, DcBus, StorageCapacitor};

    const CAPACITANCE: f64 = 16e-9;
    const STEP: f64 = 1e-5;

    fn bridge(capacitance: f64, voltage: f64) -> FullBridge<f64, StorageCapacitor<f64, NoDraw>> {
        let storage = StorageCapacitor {
            capacitor: Capacitor { capacitance, leakage_resistance: f64::INFINITY },
            initial_voltage: voltage,
            draw: NoDraw,
        };
        FullBridge { diode_drop: 0.3, storage }
    }

    /// Reference by small increments of charge: mean voltage, mean square, charge that has passed, and energy delivered to the storage.
    fn walked(capacitance: f64, voltage: f64, start: f64, charge: f64) -> [f64; 4] {
        let count = 400_000;
        let piece = charge / f64::from(count);
        let (mut v, mut storage) = (start, voltage);
        let (mut mean, mut square, mut transferred, mut delivered) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..count {
            let before = v;
            v += piece / CAPACITANCE;
            let excess = v.abs() - storage - 0.6;
            if excess > 0.0 {
                let through = excess / (1.0 / CAPACITANCE + 1.0 / capacitance);
                delivered += through * (storage + 0.5 * through / capacitance);
                storage += through / capacitance;
                transferred += through * v.signum();
                v -= through / CAPACITANCE * v.signum();
            }
            let middle = 0.5 * (before + v);
            mean += middle / f64::from(count);
            square += middle * middle / f64::from(count);
        }
        [mean, square, transferred, delivered]
    }

    #[test]
    fn mean_and_charge_are_those_of_the_polyline() {
        for capacitance in [2e-9, 16e-9, 1e-6] {
            for (start, charge) in [(0.2, 5e-8), (2.5, 1e-8), (2.6, 4e-9), (-2.0, 9e-8), (0.5, -6e-8)] {
                let bridge = bridge(capacitance, 2.0);
                let step = BridgeStep::new(CAPACITANCE, &bridge.storage, STEP);
                let [mean, square, transferred, delivered] = walked(capacitance, 2.0, start, charge);
                let mut storage = StorageState::of(&bridge.storage);
                let mut account = StorageAccount::default();
                let Some([e0, e1]) = step.tangent(2.6, start, charge) else { panic!("it conducts") };
                let (through, found) = step.pass(&bridge, [start, charge], &mut storage, &mut account);
                let close = |what: &str, a: f64, b: f64| {
                    assert!((a / b - 1.0).abs() < 1e-4, "{what} {capacitance} {start} {charge}: {a} {b}");
                };
                close("mean", e0 + e1 * charge, mean);
                close("passed", through, transferred);
                close("mean square", found.expect("it conducts"), square);
                close("delivered", account.delivered, delivered);
                // The slope is the derivative of the mean.
                let mean_at = |charge: f64| {
                    let [e0, e1] = step.tangent(2.6, start, charge).expect("it conducts");
                    e0 + e1 * charge
                };
                let small = 1e-5 * charge;
                let slope = (mean_at(charge + small) - mean_at(charge - small)) / (2.0 * small);
                assert!((slope / e1 - 1.0).abs() < 1e-4, "{slope} {e1}");
                // The whole work is stored, delivered or lost in the diodes.
                let end = start + (charge - through) / CAPACITANCE;
                let stored = 0.5 * CAPACITANCE * (end * end - start * start);
                let work = (e0 + e1 * charge) * charge;
                let out = stored + account.delivered + account.diodes;
                assert!((work - out).abs() < 1e-14 * (work.abs() + stored.abs()), "{work} {out}");
                assert!((end.abs() - storage.voltage - 0.6).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn it_blocks_up_to_the_threshold_and_a_bus_holds_the_voltage_there() {
        let bus = FullBridge { diode_drop: 0.25, storage: DcBus { voltage: 1.5 } };
        let step = BridgeStep::new(CAPACITANCE, &bus.storage, STEP);
        let to_threshold = 1.0 * CAPACITANCE;
        assert_eq!(step.tangent(2.0, 1.0, 0.999 * to_threshold), None);
        assert_eq!(step.tangent(2.0, 1.0, -2.999 * to_threshold), None);
        let mut storage = StorageState::of(&bus.storage);
        let mut account = StorageAccount::default();
        let (transferred, _) = step.pass(&bus, [1.0, 3.0 * to_threshold], &mut storage, &mut account);
        assert!((transferred / (2.0 * to_threshold) - 1.0).abs() < 1e-14);
        assert_eq!(storage.voltage, 1.5);
        assert!((account.delivered / (transferred * 1.5) - 1.0).abs() < 1e-14);
        assert!((account.diodes / (transferred * 0.5) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_small_storage_falls_alone_and_then_with_the_capacitance() {
        let (leakage_resistance, capacitance, half) = (1e4, 1e-9, 0.5 * STEP);
        let storage = StorageCapacitor {
            capacitor: Capacitor { capacitance, leakage_resistance },
            initial_voltage: 2.0,
            draw: NoDraw,
        };
        let bridge = FullBridge { diode_drop: 0.3, storage };
        let step = BridgeStep::new(CAPACITANCE, &bridge.storage, STEP);
        for start in [0.5, 2.2, -2.5, 2.6] {
            let (mut state, mut account) = (StorageState::of(&bridge.storage), StorageAccount::default());
            let transferred = step.drain(&bridge, start, &mut state, &mut account);
            // By closed forms: C V' = −V/R up to the threshold, then (C + C_p) V' = −V/R.
            let level = f64::abs(start) - 0.6;
            let alone = (leakage_resistance * capacitance * (2.0 / level).ln()).min(half);
            let alone = if level > 0.0 { alone } else { half };
            let together = leakage_resistance * (capacitance + CAPACITANCE);
            let before = 2.0 * (-alone / (leakage_resistance * capacitance)).exp();
            let end = before * (-(half - alone) / together).exp();
            assert!((state.voltage / end - 1.0).abs() < 1e-12, "{start}: {} {end}", state.voltage);
            let following = CAPACITANCE * (before - end) * f64::signum(start);
            assert!((transferred - following).abs() < 1e-12 * 2e-8, "{start}: {transferred} {following}");
            // What the storage and the capacitance lose leaks, or is lost in the diodes.
            let after = f64::abs(start) - transferred.abs() / CAPACITANCE;
            let lost =
                0.5 * capacitance * (4.0 - end * end) + 0.5 * CAPACITANCE * (start * start - after * after);
            assert!(((account.leaked + account.diodes) / lost - 1.0).abs() < 1e-12, "{start}");
        }
    }

    #[test]
    fn a_constant_power_leaves_a_conducting_bridge_level() {
        let lockout = Lockout { turn_on: 1.0, turn_off: 0.1 };
        let storage = StorageCapacitor {
            capacitor: Capacitor { capacitance: 1e-9, leakage_resistance: f64::INFINITY },
            initial_voltage: 2.0,
            draw: PowerDraw { power: 2e-4, lockout },
        };
        let bridge = FullBridge { diode_drop: 0.3, storage };
        let step = BridgeStep::new(CAPACITANCE, &bridge.storage, STEP);
        for start in [2.3, 2.5, 2.599] {
            let (mut state, mut account) = (StorageState::of(&bridge.storage), StorageAccount::default());
            let transferred = step.drain(&bridge, start, &mut state, &mut account);
            let end = start - transferred / CAPACITANCE;
            assert!(
                transferred > 0.0 && (end - 0.6 - state.voltage).abs() < 1e-9,
                "{start}: {end} {}",
                state.voltage
            );
        }
    }

    #[test]
    fn a_store_that_is_too_low_is_brought_level_and_energy_is_conserved() {
        let bridge = bridge(1e-7, 2.0);
        let step = BridgeStep::new(CAPACITANCE, &bridge.storage, STEP);
        let (mut storage, mut account) = (StorageState::of(&bridge.storage), StorageAccount::default());
        let transferred = step.drain(&bridge, -4.0, &mut storage, &mut account);
        let end = -4.0 - transferred / CAPACITANCE;
        assert!(transferred < 0.0 && (-end - storage.voltage - 0.6).abs() < 1e-14);
        let given = 0.5 * CAPACITANCE * (16.0 - end * end);
        let gained = 0.5e-7 * (storage.voltage * storage.voltage - 4.0);
        assert!((account.delivered / gained - 1.0).abs() < 1e-13);
        assert!(((account.delivered + account.diodes) / given - 1.0).abs() < 1e-13);
        // After levelling no more charge passes.
        assert!(step.drain(&bridge, end, &mut storage, &mut account).abs() < 1e-22);
    }
}
