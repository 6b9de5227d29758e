//! Modes, guards and jumps: reversal, stick and release, and the corner of the overlap.

use super::flow::Flow;
use super::{CHARGE, DISPLACEMENT, Friction, Parts, STATES, Sliding, Sticking, VELOCITY};
use crate::excitation::Excitation;
use crate::hybrid::{Automaton, Guard, Jump, Moment};
use crate::integrate::step_control::ErrorScale;
use crate::integrate::{Point, System};
use crate::part::load::{Load, Resistance};
use crate::scalar::Scalar;
use crate::scene::{Harvester, StoredEnergy, coupled};

/// The modes of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// The slider slides.
    Sliding {
        /// Whether towards positive displacement: the sign against which friction acts.
        forward: bool,
        /// Whether the displacement is positive: the side of the overlap's corner.
        ahead: bool,
    },
    /// Friction holds the slider.
    Stuck,
}

/// Guard of [`Mode::Sliding`] at which the displacement comes to the corner of the overlap; at the
/// other the velocity comes to zero.
const CORNER: usize = 0;
/// Guards of [`Mode::Stuck`]: friction fails to hold the slider back from negative displacement.
const BACKWARD: usize = 0;
/// And from positive.
const FORWARD: usize = 1;

impl Mode {
    /// Sliding from `displacement`; from the corner itself to the side it slides to.
    #[inline(always)]
    pub(super) fn sliding<S: Scalar>(forward: bool, displacement: S) -> Self {
        let ahead = if displacement == S::ZERO { forward } else { displacement > S::ZERO };
        Self::Sliding { forward, ahead }
    }

    /// The side of the overlap's corner: in a slide that of the mode, which a step may end a little
    /// beyond.
    #[inline(always)]
    pub(super) fn is_ahead<S: Scalar>(self, displacement: S) -> bool {
        match self {
            Self::Sliding { ahead, .. } => ahead,
            Self::Stuck => displacement >= S::ZERO,
        }
    }
}

impl<S: Scalar, P: Parts<S>> Sliding<S, P> {
    /// Whether the slider can be held at all.
    pub(super) const STICKS: bool = <P::Friction as Friction<S>>::PRESENT && P::Sticking::POSSIBLE;

    /// What pulls a slider at rest back, per modal mass: `ω² x + κ a − F_lat/M`; with the most that
    /// static friction can hold, and the derivatives of both by the charge.
    #[inline(always)]
    fn balance(&self, [displacement, _, charge]: &[S; STATES], acceleration: S) -> [[S; 2]; 2] {
        let ahead = *displacement >= S::ZERO;
        let circuit = self.circuit(ahead, *displacement, *charge);
        let [lateral, lateral_by_charge] = self.lateral(ahead, *displacement, &circuit);
        let pull = self.stiffness_per_mass * *displacement + self.base_coupling * acceleration - lateral;
        [[pull, -lateral_by_charge], self.static_friction(&circuit)]
    }

    /// The mode of a slider without speed: held if static friction can, or off against the pull.
    #[inline(always)]
    pub(super) fn mode_from_rest(&self, state: &[S; STATES], acceleration: S) -> Mode {
        let [[pull, _], [hold, _]] = self.balance(state, acceleration);
        if Self::STICKS && pull.absolute() <= hold {
            Mode::Stuck
        } else {
            Mode::sliding(pull < S::ZERO, state[DISPLACEMENT])
        }
    }

    /// Friction that holds the slider in newtons, positive towards positive displacement; 0 in a
    /// slide. Equation (10) in its consistent form.
    pub fn holding_friction<const POWERS: usize>(
        &self,
        mode: Mode,
        point: &Point<S, STATES, POWERS>,
        acceleration: S,
    ) -> S {
        let [[pull, _], _] = self.balance(&point.state, acceleration);
        if mode == Mode::Stuck { self.modal_mass * pull } else { S::ZERO }
    }

    /// What friction can hold beyond what it must, towards either side, and its rate.
    ///
    /// Out of line, or the compiler would evaluate the excitation for it in a slide too.
    #[cold]
    #[inline(never)]
    fn release_guard<E: Excitation<S>, const POWERS: usize>(
        &self,
        index: usize,
        point: &Point<S, STATES, POWERS>,
        moment: &Moment<'_, E>,
    ) -> Guard<S> {
        let charge_rate = point.derivative[CHARGE];
        let [[pull, pull_by_charge], [hold, hold_by_charge]] =
            self.balance(&point.state, moment.acceleration());
        let pull_rate = self.base_coupling * moment.jerk() + pull_by_charge * charge_rate;
        let hold_rate = hold_by_charge * charge_rate;
        if index == BACKWARD {
            Guard { value: hold - pull, rate: hold_rate - pull_rate }
        } else {
            Guard { value: hold + pull, rate: hold_rate + pull_rate }
        }
    }

    /// The jump to `mode` with the displacement as it is.
    #[inline(always)]
    fn go_on<const POWERS: usize>(
        &self,
        mode: Mode,
        velocity: S,
        charge_rate: S,
        point: &Point<S, STATES, POWERS>,
        acceleration: S,
    ) -> Jump<S, Mode, STATES> {
        let [displacement, reached, charge] = point.state;
        let state = [displacement, velocity, charge];
        let flow = Flow { scene: self, mode };
        let mut derivative = System::<S, STATES, POWERS>::flow(&flow, &state, acceleration);
        derivative[CHARGE] = charge_rate;
        let half_mass = S::literal(0.5) * self.modal_mass;
        let loss = half_mass * (reached - velocity) * (reached + velocity);
        Jump { mode, state, derivative, loss, armed: velocity != S::ZERO || mode == Mode::Stuck }
    }

    /// The rate of the charge after an event, as a step of length `step` needs it, where it was
    /// `before`.
    #[inline(always)]
    fn charge_rate_from(&self, before: S, mode: Mode, state: &[S; STATES], step: S) -> S {
        if !matches!(self.load.resistance(), Resistance::Finite(_)) {
            return S::ZERO;
        }
        let [displacement, velocity, charge] = *state;
        let ahead = mode.is_ahead(displacement);
        let relaxation = self.relaxation(&self.circuit(ahead, displacement, charge));
        let following = self.following_current(ahead, displacement, velocity);
        coupled::beyond_boundary_layer(before, following, relaxation, step)
    }
}

impl<S: Scalar, P: Parts<S>, const POWERS: usize> Automaton<S, STATES, POWERS> for Sliding<S, P> {
    type Mode = Mode;
    type Flow<'a>
        = Flow<'a, S, P>
    where
        Self: 'a;

    #[inline(always)]
    fn flow(&self, mode: Mode) -> Flow<'_, S, P> {
        Flow { scene: self, mode }
    }

    #[inline(always)]
    fn guards(&self, _mode: Mode) -> usize {
        if <P::Friction as Friction<S>>::PRESENT { 2 } else { 1 }
    }

    #[inline(always)]
    fn guard<E: Excitation<S>>(
        &self,
        mode: Mode,
        index: usize,
        armed: bool,
        point: &Point<S, STATES, POWERS>,
        moment: &Moment<'_, E>,
    ) -> Guard<S> {
        let (forward, ahead) = match mode {
            Mode::Sliding { forward, ahead } => (forward, ahead),
            Mode::Stuck if Self::STICKS => return self.release_guard(index, point, moment),
            Mode::Stuck => (true, true),
        };
        let [displacement, velocity, _] = point.state;
        let (value, rate, positive, margin) = if index == CORNER {
            (displacement, velocity, ahead, S::TINY)
        } else {
            (velocity, point.derivative[VELOCITY], forward, self.velocity_margin)
        };
        // After a rest the velocity starts at zero, and perhaps the displacement: they are let sink by
        // the margin.
        let lowered = if armed { S::ZERO } else { margin };
        if positive {
            Guard { value: value + lowered, rate }
        } else {
            Guard { value: lowered - value, rate: -rate }
        }
    }

    #[inline(always)]
    fn rearms(&self, mode: Mode, point: &Point<S, STATES, POWERS>) -> bool {
        match mode {
            Mode::Sliding { forward: true, .. } => point.state[VELOCITY] > self.velocity_margin,
            Mode::Sliding { forward: false, .. } => point.state[VELOCITY] < -self.velocity_margin,
            Mode::Stuck => true,
        }
    }

    fn jump<E: Excitation<S>>(
        &self,
        mode: Mode,
        index: usize,
        point: &Point<S, STATES, POWERS>,
        moment: &Moment<'_, E>,
        step: S,
    ) -> Jump<S, Mode, STATES> {
        let acceleration = moment.acceleration();
        let [displacement, velocity, charge] = point.state;
        let rate = point.derivative[CHARGE];
        let rest = [displacement, S::ZERO, charge];
        match mode {
            Mode::Stuck if Self::STICKS => {
                let mode = Mode::sliding(index == FORWARD, displacement);
                // A frozen charge starts to flow.
                let circuit = self.circuit(mode.is_ahead(displacement), displacement, charge);
                let flowing = self.circuit_rate * circuit.voltage;
                let before = if self.sticking.relaxes() { rate } else { flowing };
                let after = self.charge_rate_from(before, mode, &rest, step);
                self.go_on(mode, S::ZERO, after, point, acceleration)
            }
            Mode::Sliding { forward, ahead } if index == CORNER => {
                let mode = Mode::Sliding { forward, ahead: !ahead };
                let after = self.charge_rate_from(rate, mode, &point.state, step);
                self.go_on(mode, velocity, after, point, acceleration)
            }
            Mode::Sliding { .. } | Mode::Stuck => {
                let mode = self.mode_from_rest(&rest, acceleration);
                let frozen = mode == Mode::Stuck && !self.sticking.relaxes();
                let after = if frozen { S::ZERO } else { self.charge_rate_from(rate, mode, &rest, step) };
                self.go_on(mode, S::ZERO, after, point, acceleration)
            }
        }
    }

    #[inline(always)]
    fn error_scale(&self) -> ErrorScale<S> {
        ErrorScale { angular_frequency: self.angular_frequency, energy_floor: self.energy_floor }
    }

    #[inline(always)]
    fn check(&self, _mode: Mode, state: &[S; STATES]) -> Result<(), (&'static str, S)> {
        let displacement = state[DISPLACEMENT];
        if displacement.absolute() < self.diameter { Ok(()) } else { Err(("displacement", displacement)) }
    }
}

impl<S: Scalar, P: Parts<S>, const POWERS: usize> Harvester<S, STATES, POWERS> for Sliding<S, P> {
    fn coordinate(&self, point: &Point<S, STATES, POWERS>) -> Guard<S> {
        Guard { value: point.state[DISPLACEMENT], rate: point.state[VELOCITY] }
    }

    fn voltage(&self, mode: Mode, point: &Point<S, STATES, POWERS>) -> S {
        self.voltage_and_current(mode, &point.state, &point.derivative).0
    }

    fn stored_energy(&self, mode: Mode, point: &Point<S, STATES, POWERS>) -> StoredEnergy<S> {
        let [mechanical, electrical] = self.energies(mode, point.state);
        StoredEnergy { mechanical, electrical }
    }

    fn is_held(&self, mode: Mode) -> bool {
        mode == Mode::Stuck
    }

    fn is_impact(&self, _mode: Mode, _guard: usize) -> bool {
        false
    }
}
