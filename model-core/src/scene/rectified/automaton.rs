//! Modes, guards and jumps of the harvester, the bridge and the lock-out.

use super::electrics::Electrics;
use super::flow::Flow;
use super::{BridgeRegime, CHARGE, ElectricalPort, POSITION, Rectified, STATES, STORAGE, VELOCITY};
use crate::excitation::Excitation;
use crate::hybrid::{Automaton, Guard, InputAt, Jump};
use crate::integrate::{ErrorScale, Point, System};
use crate::observer::{ALL_POWERS, Outputs, PowerIndex, StorageOutput, first_powers};
use crate::part::storage::StorageElement;
use crate::scalar::{Scalar, add_increment};

/// The modes: the harvester's, the bridge's regime, and whether the draw is connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mode<M> {
    /// The mode of the harvester.
    pub inner: M,
    /// The regime of the bridge.
    pub regime: BridgeRegime,
    /// Whether the draw is connected to the storage.
    pub connected: bool,
}

/// The subject of a guard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GuardKind {
    /// A guard of the harvester, by its number.
    Harvester(usize),
    /// The voltage reaches the threshold at which conduction begins in this regime.
    Begin(BridgeRegime),
    /// The current through the bridge ends.
    End,
    /// The storage voltage reaches a voltage of the lock-out.
    Lockout,
}

/// Roundings of a voltage within which the voltage counts as below the threshold at which conduction has just ended.
const THRESHOLD_ROUNDINGS: f64 = 8.0;

impl<S: Scalar, H: ElectricalPort<S>, R: StorageElement<S>> Rectified<S, H, R> {
    /// Numbers of guards of the harvester and of the bridge in a mode.
    #[inline]
    fn counts(&self, mode: Mode<H::Mode>) -> [usize; 2] {
        let own = self.harvester.guards(mode.inner);
        let bridge = match mode.regime {
            BridgeRegime::Blocked if self.harvester.charge_is_frozen(mode.inner) => 0,
            BridgeRegime::Blocked => 2,
            BridgeRegime::Forward | BridgeRegime::Backward => 1,
        };
        [own, bridge]
    }

    /// The subject of guard number `index` of `mode`: first those of the harvester, then those of the bridge.
    #[inline]
    fn guard_kind(&self, mode: Mode<H::Mode>, index: usize) -> GuardKind {
        let [own, bridge] = self.counts(mode);
        if index < own {
            GuardKind::Harvester(index)
        } else if index >= own + bridge {
            GuardKind::Lockout
        } else if mode.regime != BridgeRegime::Blocked {
            GuardKind::End
        } else if index == own {
            GuardKind::Begin(BridgeRegime::Forward)
        } else {
            GuardKind::Begin(BridgeRegime::Backward)
        }
    }

    /// The point of the harvester alone, for a known circuit.
    #[inline]
    fn own_point<const POWERS: usize>(
        &self,
        mode: Mode<H::Mode>,
        at: &Electrics<S>,
        point: &Point<S, STATES, POWERS>,
    ) -> Point<S, 3, 0> {
        let sign: S = mode.regime.sign();
        let velocity = point.state[VELOCITY];
        Point {
            state: [point.state[POSITION], velocity, at.charge],
            remainder: [point.remainder[POSITION], point.remainder[VELOCITY], S::ZERO],
            derivative: [
                point.derivative[POSITION],
                point.derivative[VELOCITY],
                sign * at.rectified(sign, velocity),
            ],
            powers: [],
        }
    }

    /// Margin of the voltage in V below the threshold at which conduction in the direction of `regime` begins.
    ///
    /// The margin is raised by the roundings of a voltage: when conduction has ended, the voltage is at the
    /// threshold.
    ///
    /// A draw that empties the storage within a step leaves a voltage of the size of the step's error, of either sign. The
    /// threshold is that of an empty storage then: below zero it would let both directions conduct at once.
    ///
    /// At a turn of the velocity the voltage rests while the leakage lowers the threshold. Until the guards are `armed`, a margin whose
    /// parabola stays above zero does not approach an event.
    #[inline]
    fn begin_guards(
        &self,
        at: &Electrics<S>,
        own: &Point<S, 3, 0>,
        mode: H::Mode,
        armed: bool,
    ) -> [Guard<S>; 2] {
        let [position, velocity, charge] = own.state;
        let terminal = self.harvester.port_voltage(mode, position, charge);
        let threshold = self.bridge.threshold(at.storage_voltage.max(S::ZERO));
        let margin = S::from_f64(THRESHOLD_ROUNDINGS) * S::EPSILON * (terminal.magnitude + threshold);
        let bend = terminal.by_position * own.derivative[VELOCITY];
        [S::ONE, -S::ONE].map(|sign| {
            let value = threshold - sign * terminal.value + margin;
            let rate = -at.fall - sign * terminal.by_position * velocity;
            let stays = !armed && value > S::ZERO && rate * rate < -(sign + sign) * bend * value;
            Guard { value, rate: if stays && rate < S::ZERO { S::ZERO } else { rate } }
        })
    }

    /// The current through the bridge in the scale of [`Electrics::drive`], and its rate.
    #[inline]
    fn end_guard<const POWERS: usize>(
        &self,
        mode: Mode<H::Mode>,
        at: &Electrics<S>,
        point: &Point<S, STATES, POWERS>,
    ) -> Guard<S> {
        let sign: S = mode.regime.sign();
        let velocity = point.state[VELOCITY];
        let rectified = at.rectified(sign, velocity);
        let slope_rate = at.curvature * velocity + at.by_both * sign * rectified;
        let voltage_rate = slope_rate * velocity + at.voltage_by_position * point.derivative[VELOCITY];
        let store_rate = self.elastance * rectified - at.fall;
        Guard {
            value: at.drive(sign, velocity),
            rate: sign * voltage_rate + self.fall_by_voltage(mode, at) * store_rate,
        }
    }

    /// Distance of the storage voltage in V from the next voltage of the lock-out.
    #[inline]
    fn lockout_guard<const POWERS: usize>(
        &self,
        mode: Mode<H::Mode>,
        at: &Electrics<S>,
        point: &Point<S, STATES, POWERS>,
    ) -> Guard<S> {
        let Some(lockout) = self.bridge.storage.lockout() else {
            return Guard { value: S::ONE, rate: S::ZERO };
        };
        let rise = self.elastance * at.rectified(mode.regime.sign(), point.state[VELOCITY]) - at.fall;
        // With the remainder: near the level the first difference is exact.
        let above = |level: S| (point.state[STORAGE] - level) + (point.remainder[STORAGE] + at.gained);
        if mode.connected {
            Guard { value: above(lockout.turn_off), rate: rise }
        } else {
            Guard { value: -above(lockout.turn_on), rate: -rise }
        }
    }

    /// Seconds to the end of conduction by its guard, and the rise of the voltage in V until then: the current is linear in the
    /// time. With it the voltage does not reach the threshold again. After the end nothing remains: a conduction from a start
    /// above the threshold may be against the motion, and ends at once.
    #[inline]
    fn remaining(&self, guard: &Guard<S>) -> [S; 2] {
        if !(guard.rate < S::ZERO && guard.value > S::ZERO) {
            return [S::INFINITY, S::ZERO];
        }
        let seconds = guard.value / -guard.rate;
        [seconds, S::from_f64(0.5) * guard.value * seconds]
    }

    /// The jump to `mode` at a state of `mode.regime`; with a voltage that [remains](Self::remaining), conduction ends.
    #[inline]
    fn jump_to<const POWERS: usize>(
        &self,
        mode: Mode<H::Mode>,
        leaving: Option<S>,
        mut state: [S; STATES],
        mut remainder: [S; STATES],
        acceleration: S,
    ) -> Jump<S, Mode<H::Mode>, STATES> {
        let mut mode = mode;
        if let Some(remaining) = leaving {
            let at = self.electrics(mode, &state);
            let rest = remaining * at.charge_by_voltage;
            let (gained, storage_voltage) = (at.gained + rest * self.elastance, at.storage_voltage);
            let mut transferred = at.transferred + mode.regime.sign::<S>() * rest;
            if storage_voltage < S::ZERO {
                // Emptied to within the error of the step: conduction ends at no voltage, and at the threshold of that.
                let terminal = self.harvester.port_voltage(mode.inner, state[POSITION], state[CHARGE]);
                let threshold = mode.regime.sign::<S>() * self.bridge.threshold(S::ZERO);
                transferred = (threshold - terminal.value) / terminal.by_charge;
                (state[STORAGE], remainder[STORAGE]) = (S::ZERO, S::ZERO);
            } else {
                (state[STORAGE], remainder[STORAGE]) =
                    add_increment(state[STORAGE], remainder[STORAGE], gained);
            }
            (state[CHARGE], remainder[CHARGE]) = add_increment(state[CHARGE], remainder[CHARGE], transferred);
            mode.regime = BridgeRegime::Blocked;
        }
        let flow = Flow { scene: self, mode };
        let derivative = System::<S, STATES, POWERS>::flow(&flow, &state, acceleration);
        let own = [state[POSITION], state[VELOCITY], state[CHARGE]];
        let armed = self.harvester.is_clear(mode.inner, &own);
        Jump { mode, state, remainder, derivative, loss: S::ZERO, armed }
    }
}

impl<S: Scalar, H: ElectricalPort<S>, R: StorageElement<S>, const POWERS: usize> Automaton<S, STATES, POWERS>
    for Rectified<S, H, R>
{
    type Mode = Mode<H::Mode>;
    type Flow<'a>
        = Flow<'a, S, H, R, H::Mode>
    where
        Self: 'a;

    #[inline]
    fn flow(&self, mode: Self::Mode) -> Flow<'_, S, H, R, H::Mode> {
        Flow { scene: self, mode }
    }

    const KEEPS_GUARDS: bool = true;

    #[inline]
    fn guards(&self, mode: Self::Mode) -> usize {
        let [own, bridge] = self.counts(mode);
        let switches = R::SWITCHES && self.bridge.storage.lockout().is_some();
        own + bridge + usize::from(switches)
    }

    #[inline]
    fn guard<E: Excitation<S>>(
        &self,
        mode: Self::Mode,
        index: usize,
        armed: bool,
        point: &Point<S, STATES, POWERS>,
        input: &InputAt<'_, E>,
    ) -> Guard<S> {
        let kind = self.guard_kind(mode, index);
        if let GuardKind::Harvester(index) = kind {
            // The guards of a moving part read position and velocity, for which a blocked bridge needs no circuit; a release reads the charge.
            let moves = !self.harvester.is_stick(mode.inner);
            let mode = if moves { Mode { regime: BridgeRegime::Blocked, ..mode } } else { mode };
            let own_point = self.own_point(mode, &self.electrics(mode, &point.state), point);
            return self.harvester.guard(mode.inner, index, armed, &own_point, input);
        }
        let at = self.electrics(mode, &point.state);
        match kind {
            GuardKind::Begin(regime) => {
                let own_point = self.own_point(mode, &at, point);
                let [forward, backward] = self.begin_guards(&at, &own_point, mode.inner, armed);
                if regime == BridgeRegime::Forward { forward } else { backward }
            }
            GuardKind::Lockout => self.lockout_guard(mode, &at, point),
            GuardKind::End | GuardKind::Harvester(_) => self.end_guard(mode, &at, point),
        }
    }

    /// The circuit is evaluated once.
    #[inline]
    fn each_guard<E: Excitation<S>>(
        &self,
        mode: Self::Mode,
        armed: bool,
        point: &Point<S, STATES, POWERS>,
        input: &InputAt<'_, E>,
        mut take: impl FnMut(usize, Guard<S>),
    ) {
        let at = self.electrics(mode, &point.state);
        let own_point = self.own_point(mode, &at, point);
        self.harvester.each_guard(mode.inner, armed, &own_point, input, &mut take);
        let [own, bridge] = self.counts(mode);
        if bridge == 1 {
            take(own, self.end_guard(mode, &at, point));
        } else if bridge == 2 {
            let [forward, backward] = self.begin_guards(&at, &own_point, mode.inner, armed);
            take(own, forward);
            take(own + 1, backward);
        }
        if R::SWITCHES && self.bridge.storage.lockout().is_some() {
            take(own + bridge, self.lockout_guard(mode, &at, point));
        }
    }

    #[inline]
    fn rearms(&self, mode: Self::Mode, point: &Point<S, STATES, POWERS>) -> bool {
        let at = self.electrics(mode, &point.state);
        self.harvester.rearms(mode.inner, &self.own_point(mode, &at, point))
    }

    fn jump<E: Excitation<S>>(
        &self,
        mode: Self::Mode,
        index: usize,
        point: &Point<S, STATES, POWERS>,
        input: &InputAt<'_, E>,
        step: S,
    ) -> Jump<S, Self::Mode, STATES> {
        let acceleration = input.acceleration();
        let (Point { state, remainder, .. }, at) = (*point, self.electrics(mode, &point.state));
        let kind = self.guard_kind(mode, index);
        let GuardKind::Harvester(index) = kind else {
            let (regime, connected) = match kind {
                GuardKind::Begin(regime) => (regime, mode.connected),
                GuardKind::Lockout => (mode.regime, !mode.connected),
                GuardKind::End | GuardKind::Harvester(_) => (mode.regime, mode.connected),
            };
            let mode = Mode { regime, connected, ..mode };
            let leaving =
                (kind == GuardKind::End).then(|| self.remaining(&self.end_guard(mode, &at, point))[1]);
            return self.jump_to::<POWERS>(mode, leaving, state, remainder, acceleration);
        };
        let own = self.harvester.jump(mode.inner, index, &self.own_point(mode, &at, point), input, step);
        let mode = Mode { inner: own.mode, ..mode };
        let state = [own.state[POSITION], own.state[VELOCITY], state[CHARGE], state[STORAGE]];
        let remainder =
            [own.remainder[POSITION], own.remainder[VELOCITY], remainder[CHARGE], remainder[STORAGE]];
        // An impact reverses the rate of the voltage with the velocity, and stick makes the rate zero.
        let leaving = match mode.regime {
            BridgeRegime::Blocked => None,
            _ if self.harvester.charge_is_frozen(mode.inner) => Some(S::ZERO),
            _ => {
                let mut after = *point;
                (after.state, after.derivative[VELOCITY]) = (state, own.derivative[VELOCITY]);
                let guard = self.end_guard(mode, &self.electrics(mode, &state), &after);
                let [seconds, remaining] = self.remaining(&guard);
                let radians = seconds * self.harvester.error_scale().angular_frequency;
                let ended = (!(guard.value > S::ZERO)).then_some(S::ZERO);
                ended.or((radians * radians * radians <= S::EPSILON).then_some(remaining))
            }
        };
        let jump = self.jump_to::<POWERS>(mode, leaving, state, remainder, acceleration);
        Jump { loss: own.loss, armed: own.armed, ..jump }
    }

    /// If conduction begins above the threshold, with open terminals before, the excess drives a charge through the
    /// bridge instantaneously, and half of the excess times the charge is lost in the diodes. If it ends with a charge that
    /// remains, that charge passes at the storage voltage.
    fn jump_energies(
        &self,
        mode: Self::Mode,
        index: usize,
        point: &Point<S, STATES, POWERS>,
        after: &Jump<S, Self::Mode, STATES>,
    ) -> [S; POWERS] {
        let mut energies = [S::ZERO; ALL_POWERS];
        if let GuardKind::Begin(regime) = self.guard_kind(mode, index) {
            let sign: S = regime.sign();
            let at = self.electrics(after.mode, &after.state);
            let transferred = sign * self.harvester.coulombs() * (at.charge - after.state[CHARGE]);
            let base = point.state[STORAGE];
            let drop = self.bridge.diode_drop;
            let half = S::from_f64(0.5);
            // V(x, Q0) − s (B + 2 V_D), which falls to the rise of the storage voltage as the charge passes.
            let excess = sign * (at.charge - after.state[CHARGE]) / at.charge_by_voltage;
            energies[PowerIndex::Load as usize] = transferred * (base + half * at.gained);
            energies[PowerIndex::CurrentMagnitude as usize] = transferred;
            energies[PowerIndex::Diodes as usize] = transferred * (drop + drop + half * excess);
        } else if mode.regime != BridgeRegime::Blocked && after.mode.regime == BridgeRegime::Blocked {
            let at = self.electrics(mode, &point.state);
            let sign: S = mode.regime.sign();
            let remaining = sign * self.harvester.coulombs() * (after.state[CHARGE] - at.charge);
            let drop = self.bridge.diode_drop;
            energies[PowerIndex::Load as usize] = remaining * at.storage_voltage;
            energies[PowerIndex::CurrentMagnitude as usize] = remaining;
            energies[PowerIndex::Diodes as usize] = remaining * (drop + drop);
        }
        first_powers(&energies)
    }

    #[inline]
    fn error_scale(&self) -> ErrorScale<S> {
        self.harvester.error_scale()
    }

    #[inline]
    fn is_impact(&self, mode: Self::Mode, guard: usize) -> bool {
        match self.guard_kind(mode, guard) {
            GuardKind::Harvester(index) => self.harvester.is_impact(mode.inner, index),
            GuardKind::Begin(_) | GuardKind::End | GuardKind::Lockout => false,
        }
    }

    /// The stored energy is that of the harvester alone.
    #[inline(always)]
    fn outputs<'a>(&self, mode: Self::Mode, point: &'a Point<S, STATES, POWERS>) -> Outputs<'a, S> {
        let at = self.electrics(mode, &point.state);
        let own = self.own_point(mode, &at, point);
        let mut outputs = self.harvester.outputs(mode.inner, &own).with_state(&point.state);
        let (voltage, remainder) = add_increment(point.state[STORAGE], point.remainder[STORAGE], at.gained);
        let threshold = self.bridge.threshold(voltage);
        if mode.regime != BridgeRegime::Blocked {
            outputs.voltage = mode.regime.sign::<S>() * threshold;
        }
        outputs.storage = Some(StorageOutput {
            voltage,
            remainder,
            capacitance: self.bridge.storage.capacitance(),
            threshold,
            connected: mode.connected,
        });
        outputs.mode = mode.number(outputs.mode);
        outputs
    }

    #[inline]
    fn check(&self, mode: Self::Mode, state: &[S; STATES]) -> Result<(), (&'static str, S)> {
        self.harvester.check(mode.inner, &[state[POSITION], state[VELOCITY], state[CHARGE]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::Instant;
    use crate::excitation::Sine;
    use crate::part::draw::{Lockout, PowerDraw};
    use crate::part::load::OpenCircuit;
    use crate::part::rectifier::FullBridge;
    use crate::part::restitution::ConstantRestitution;
    use crate::part::storage::{Capacitor, StorageCapacitor};
    use crate::scene::contact_separation::{Choices, Mode as Contact, Parameters};

    #[test]
    fn the_guards_together_are_those_one_by_one() {
        let harvester = Parameters {
            mass: 5e-3,
            stiffness: 80.0,
            damping_ratio: 0.005,
            initial_gap: 3e-3,
            electrode_area: 4e-4,
            dielectric_thickness: 5e-5,
            relative_permittivity: 2.0,
            charge_density: 50e-6,
            choices: Choices::new(OpenCircuit, ConstantRestitution { coefficient: 0.75 }),
        };
        let storage = StorageCapacitor {
            capacitor: Capacitor { capacitance: 1e-9, leakage_resistance: 1e9 },
            initial_voltage: 2.0,
            draw: PowerDraw { power: 1e-6, lockout: Lockout { turn_on: 4.5, turn_off: 3.0 } },
        };
        let bridge = FullBridge { diode_drop: 0.3, storage };
        let scene = Rectified::new(harvester.build().expect("in bounds"), bridge).expect("in bounds");
        let vibration = Sine::<f64>::new(2.0, 20.0, 0.3).expect("in bounds");
        let input = InputAt::new(&vibration, Instant::from_ticks(1 << 30));
        let regimes = [BridgeRegime::Blocked, BridgeRegime::Forward, BridgeRegime::Backward];
        for (regime, inner) in
            regimes.map(|regime| [Contact::Free, Contact::Stick].map(|inner| (regime, inner))).as_flattened()
        {
            for (connected, armed) in [(false, false), (false, true), (true, false), (true, true)] {
                let mode = Mode { inner: *inner, regime: *regime, connected };
                let mut point = Point {
                    state: [1e-3, -0.1, 0.2, 2.5],
                    remainder: [0.0; 4],
                    derivative: [0.0; 4],
                    powers: [0.0; 1],
                };
                point.derivative = System::<f64, STATES, 1>::flow(
                    &Automaton::<f64, STATES, 1>::flow(&scene, mode),
                    &point.state,
                    0.4,
                );
                let mut count = 0;
                scene.each_guard(mode, armed, &point, &input, |index, guard| {
                    let alone = scene.guard(mode, index, armed, &point, &input);
                    assert_eq!(
                        [guard.value, guard.rate].map(f64::to_bits),
                        [alone.value, alone.rate].map(f64::to_bits)
                    );
                    assert_eq!(index, count);
                    count += 1;
                });
                assert_eq!(count, Automaton::<f64, STATES, 1>::guards(&scene, mode));
            }
        }
    }
}
