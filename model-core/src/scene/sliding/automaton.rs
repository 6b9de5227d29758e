//! Modes, guards and jumps: reversal, stick and release, and the corner of the overlap.

use super::flow::Flow;
use super::state::Mode;
use super::{CHARGE, DISPLACEMENT, Friction, Parts, STATES, Sliding, Sticking, VELOCITY};
use crate::excitation::Excitation;
use crate::hybrid::{Automaton, Guard, InputAt, Jump};
use crate::integrate::{BoundaryLayer, ErrorScale, Point, System};
use crate::observer::{Motion, Outputs, StoredEnergy};
use crate::part::load::{Load, Resistance};
use crate::scalar::Scalar;

/// Guard of [`Mode::Sliding`] for the corner of the overlap, zero displacement; the other guard is zero velocity.
const CORNER: usize = 0;
/// Guard of [`Mode::Stick`] for a release towards positive displacement; the other guard, 0, is for one towards negative.
const FORWARD: usize = 1;

impl<S: Scalar, P: Parts<S>> Sliding<S, P> {
    /// Whether the slider can stick at all.
    pub(super) const STICKS: bool = <P::Friction as Friction<S>>::PRESENT && P::Sticking::POSSIBLE;

    /// The load on a slider at rest per modal mass, `ω² x + κ a − F_lat/M`, and the limit of static friction, both in
    /// m/s² with their derivatives by the charge.
    #[inline(never)]
    pub(super) fn balance(&self, displacement: S, charge: S, acceleration: S) -> [[S; 2]; 2] {
        let ahead = displacement >= S::ZERO;
        let circuit = self.circuit(ahead, displacement, charge);
        let [lateral, lateral_by_charge] = self.lateral(ahead, displacement, &circuit);
        let pull = self.stiffness_per_mass * displacement + self.base_coupling * acceleration - lateral;
        [[pull, -lateral_by_charge], self.static_friction(&circuit)]
    }

    /// The mode of a slider at rest: stick if static friction suffices, otherwise sliding against the load.
    #[inline]
    pub(super) fn mode_from_rest(&self, state: &[S; STATES], acceleration: S) -> Mode {
        let [[pull, _], [hold, _]] = self.balance(state[DISPLACEMENT], state[CHARGE], acceleration);
        if Self::STICKS && pull.abs() <= hold {
            Mode::Stick
        } else {
            Mode::sliding(pull < S::ZERO, state[DISPLACEMENT])
        }
    }

    /// The margins of static friction over the load, against a release backward and forward, and their rates.
    ///
    /// Outlined: the compiler would otherwise evaluate the excitation for it in a slide too.
    #[cold]
    #[inline(never)]
    fn release_guards<E: Excitation<S>, const POWERS: usize>(
        &self,
        point: &Point<S, STATES, POWERS>,
        input: &InputAt<'_, E>,
    ) -> [Guard<S>; 2] {
        let [displacement, _, charge] = point.state;
        let [[pull, pull_by_charge], [hold, hold_by_charge]] =
            self.balance(displacement, charge, input.acceleration());
        let pull_rate = self.base_coupling * input.jerk() + pull_by_charge * point.derivative[CHARGE];
        let hold_rate = hold_by_charge * point.derivative[CHARGE];
        [
            Guard { value: hold - pull, rate: hold_rate - pull_rate },
            Guard { value: hold + pull, rate: hold_rate + pull_rate },
        ]
    }

    /// The jump to `mode` with unchanged displacement.
    #[inline(always)]
    fn jump_to<const POWERS: usize>(
        &self,
        mode: Mode,
        velocity: S,
        charge_rate: S,
        point: &Point<S, STATES, POWERS>,
        acceleration: S,
    ) -> Jump<S, Mode, STATES> {
        let [displacement, reached, charge] = point.state;
        let state = [displacement, velocity, charge];
        let flow = Flow::new(self, mode);
        let mut derivative = System::<S, STATES, POWERS>::flow(&flow, &state, acceleration);
        derivative[CHARGE] = charge_rate;
        let half_mass = S::from_f64(0.5) * self.modal_mass;
        let loss = half_mass * (reached - velocity) * (reached + velocity);
        Jump {
            mode,
            state,
            remainder: [S::ZERO; STATES],
            derivative,
            loss,
            armed: velocity != S::ZERO || matches!(mode, Mode::Stick),
        }
    }

    /// The boundary layer of the circuit at a state; `None` without a resistor.
    #[inline]
    pub(super) fn boundary_layer(&self, mode: Mode, state: &[S; STATES]) -> Option<BoundaryLayer<S>> {
        matches!(self.load.resistance(), Resistance::Finite(_)).then(|| self.layer(mode, *state))
    }

    /// The boundary layer of a circuit with a resistor.
    #[inline(never)]
    fn layer(&self, mode: Mode, [displacement, velocity, charge]: [S; STATES]) -> BoundaryLayer<S> {
        let ahead = mode.is_ahead(displacement);
        let relaxation = self.relaxation(&self.circuit(ahead, displacement, charge));
        let following = self.following_current(ahead, displacement, velocity);
        BoundaryLayer { relaxation, following, scale: self.surface.tribo_charge }
    }

    /// The rate of the charge after an event, for a step of length `step` in s, from the rate `before` the event; of length 0,
    /// inside the boundary layer.
    #[inline]
    fn charge_rate_from(&self, before: S, mode: Mode, state: &[S; STATES], step: S) -> S {
        if step == S::ZERO && matches!(self.load.resistance(), Resistance::Finite(_)) {
            return before;
        }
        self.boundary_layer(mode, state).map_or(S::ZERO, |layer| layer.settled(before, step))
    }
}

/// The margin of a guard's number, by an index that cannot be out of range.
#[inline]
fn of_release<S: Scalar>([backward, forward]: &[Guard<S>; 2], index: usize) -> Guard<S> {
    if index == FORWARD { *forward } else { *backward }
}

impl<S: Scalar, P: Parts<S>, const POWERS: usize> Automaton<S, STATES, POWERS> for Sliding<S, P> {
    type Mode = Mode;
    type Flow<'a>
        = Flow<'a, S, P>
    where
        Self: 'a;

    #[inline]
    fn flow(&self, mode: Mode) -> Flow<'_, S, P> {
        Flow::new(self, mode)
    }

    #[inline]
    fn guards(&self, _mode: Mode) -> usize {
        if <P::Friction as Friction<S>>::PRESENT { 2 } else { 1 }
    }

    #[inline]
    fn guard<E: Excitation<S>>(
        &self,
        mode: Mode,
        index: usize,
        armed: bool,
        point: &Point<S, STATES, POWERS>,
        input: &InputAt<'_, E>,
    ) -> Guard<S> {
        let (forward, ahead) = match mode {
            Mode::Sliding { forward, ahead } => (forward, ahead),
            Mode::Stick if Self::STICKS => return of_release(&self.release_guards(point, input), index),
            Mode::Stick => (true, true),
        };
        let [displacement, velocity, _] = point.state;
        let (value, rate, positive, margin) = if index == CORNER {
            (displacement, velocity, ahead, S::TINY)
        } else {
            (velocity, point.derivative[VELOCITY], forward, self.velocity_margin)
        };
        // After a rest the velocity starts at zero, and perhaps the displacement: the guards are lowered by the
        // margin.
        let lowered = if armed { S::ZERO } else { margin };
        if positive {
            Guard { value: value + lowered, rate }
        } else {
            Guard { value: lowered - value, rate: -rate }
        }
    }

    #[inline(always)]
    fn each_guard<E: Excitation<S>>(
        &self,
        mode: Mode,
        armed: bool,
        point: &Point<S, STATES, POWERS>,
        input: &InputAt<'_, E>,
        mut take: impl FnMut(usize, Guard<S>),
    ) {
        let is_stick = Self::STICKS && matches!(mode, Mode::Stick);
        let releases = is_stick.then(|| self.release_guards(point, input));
        for index in 0..Automaton::<S, STATES, POWERS>::guards(self, mode) {
            let alone = || self.guard(mode, index, armed, point, input);
            take(index, releases.map_or_else(alone, |releases| of_release(&releases, index)));
        }
    }

    #[inline]
    fn rearms(&self, mode: Mode, point: &Point<S, STATES, POWERS>) -> bool {
        match mode {
            Mode::Sliding { forward: true, .. } => point.state[VELOCITY] > self.velocity_margin,
            Mode::Sliding { forward: false, .. } => point.state[VELOCITY] < -self.velocity_margin,
            Mode::Stick => true,
        }
    }

    fn jump<E: Excitation<S>>(
        &self,
        mode: Mode,
        index: usize,
        point: &Point<S, STATES, POWERS>,
        input: &InputAt<'_, E>,
        step: S,
    ) -> Jump<S, Mode, STATES> {
        let acceleration = input.acceleration();
        let [displacement, velocity, charge] = point.state;
        let rate = point.derivative[CHARGE];
        let rest = [displacement, S::ZERO, charge];
        match mode {
            Mode::Stick if Self::STICKS => {
                let mode = Mode::sliding(index == FORWARD, displacement);
                // A frozen charge starts to flow.
                let circuit = self.circuit(mode.is_ahead(displacement), displacement, charge);
                let flowing = self.circuit_rate * circuit.voltage;
                let before = if self.sticking.relaxes() { rate } else { flowing };
                let after = self.charge_rate_from(before, mode, &rest, step);
                self.jump_to(mode, S::ZERO, after, point, acceleration)
            }
            Mode::Sliding { forward, ahead } if index == CORNER => {
                let mode = Mode::Sliding { forward, ahead: !ahead };
                // At the corner nothing cancels in the voltage of the charge.
                let circuit = self.circuit(!ahead, displacement, charge);
                let flowing = self.circuit_rate * circuit.voltage;
                let before = if step > S::ZERO { rate } else { flowing };
                let after = self.charge_rate_from(before, mode, &point.state, step);
                let mut jump = self.jump_to(mode, velocity, after, point, acceleration);
                // On the far side of the corner the guard then rises from zero.
                jump.state[DISPLACEMENT] = S::ZERO;
                jump
            }
            Mode::Sliding { .. } | Mode::Stick => {
                let mode = self.mode_from_rest(&rest, acceleration);
                let frozen = matches!(mode, Mode::Stick) && !self.sticking.relaxes();
                let after = if frozen { S::ZERO } else { self.charge_rate_from(rate, mode, &rest, step) };
                self.jump_to(mode, S::ZERO, after, point, acceleration)
            }
        }
    }

    #[inline]
    fn error_scale(&self) -> ErrorScale<S> {
        let Self { angular_frequency, energy_floor, .. } = *self;
        ErrorScale { angular_frequency, decay_rate: S::from_f64(0.5) * self.damping_per_mass, energy_floor }
    }

    #[inline(always)]
    fn outputs<'a>(&self, mode: Mode, point: &'a Point<S, STATES, POWERS>) -> Outputs<'a, S> {
        let [displacement, velocity, charge] = point.state;
        let mut outputs = Outputs::of_state(&point.state);
        outputs.motions[0] = Motion { value: displacement, rate: velocity };
        let (voltage, current) = self.voltage_and_current(mode, &point.state, &point.derivative);
        // In a short circuit the charge follows the overlap, and the state does not.
        let transferred = self.circuit(mode.is_ahead(displacement), displacement, charge).transferred;
        outputs.charge = Motion { value: self.charge_unit * transferred, rate: current };
        outputs.voltage = voltage;
        let [mechanical, electrical] = self.energies(mode, point.state);
        outputs.stored = StoredEnergy { mechanical, electrical };
        outputs.stick = matches!(mode, Mode::Stick);
        outputs.mode = mode.number();
        outputs
    }

    #[inline]
    fn check(&self, _mode: Mode, state: &[S; STATES]) -> Result<(), (&'static str, S)> {
        let displacement = state[DISPLACEMENT];
        if displacement.abs() < self.diameter { Ok(()) } else { Err(("displacement", displacement)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::Instant;
    use crate::excitation::Sine;
    use crate::hybrid::{Driver, Ended, HybridState};
    use crate::integrate::{Adaptive, TrBdf2};
    use crate::part::GRAVITY;
    use crate::part::load::AnyLoad;
    use crate::scene::sliding::{
        AnyChoices, AnyForceLaw, AnyLateralForce, Choices, Parameters, PatchFriction, Start, StickCharge,
    };

    fn parameters() -> Parameters<f64, AnyChoices<f64>> {
        Parameters {
            beam_length: 0.1,
            beam_width: 0.02,
            beam_thickness: 5e-4,
            young_modulus: 210e9,
            density: 7800.0,
            damping_ratio: 0.0035,
            slider_mass: 8e-3,
            patch_radius: 0.01,
            dielectric_thickness: 5e-5,
            relative_permittivity: 2.0,
            charge_density: 80e-6,
            choices: Choices {
                load: AnyLoad { resistance: 1e8 },
                friction: PatchFriction {
                    static_active: 0.35,
                    static_inert: 0.25,
                    kinetic_active: 0.30,
                    kinetic_inert: 0.20,
                },
                force_law: AnyForceLaw::TransferredCharge,
                sticking: StickCharge::Frozen,
                lateral_force: AnyLateralForce::Field,
            },
        }
    }

    #[test]
    fn coefficients_are_those_of_the_published_beam() {
        let scene = parameters().build().expect("in bounds");
        assert!((scene.modal_mass() / 9.858_671_590e-3 - 1.0).abs() < 1e-9);
        assert!((scene.base_coupling() / 1.110_563_269_8 - 1.0).abs() < 1e-9);
    }

    /// Time in s until the slider is released with a frozen charge under the load `constant + amplitude sin φ`: the sine
    /// rises through `(hold − constant)/amplitude` or falls through `(−hold − constant)/amplitude`.
    fn release_in(
        scene: &Sliding<f64, AnyChoices<f64>>,
        state: &HybridState<f64, Mode, STATES, 1>,
        [amplitude, frequency]: [f64; 2],
    ) -> Option<f64> {
        let [[constant, _], [hold, _]] =
            scene.balance(state.point.state[DISPLACEMENT], state.point.state[CHARGE], 0.0);
        let amplitude = scene.base_coupling * amplitude;
        let phase = (state.clock.seconds::<f64>() * frequency).fract();
        let ahead = |angle: f64| (angle / core::f64::consts::TAU - phase).rem_euclid(1.0);
        let up = ((hold - constant) / amplitude).asin();
        let down = core::f64::consts::PI - ((-hold - constant) / amplitude).asin();
        [up, down]
            .into_iter()
            .filter(|angle| angle.is_finite())
            .map(ahead)
            .reduce(f64::min)
            .map(|turns| turns / frequency)
    }

    #[test]
    fn the_driver_locates_releases_where_the_closed_form_has_them() {
        let scene = parameters().build().expect("in bounds");
        let vibration = [0.30 * GRAVITY, 6.0];
        let sine = Sine::<f64>::new(vibration[0], vibration[1], 0.0).expect("valid");
        let driver =
            Driver { pause_at_events: true, ..Driver::new(TrBdf2, Adaptive::new(1e-6).expect("in bounds")) };
        let mut state = scene.start::<_, _, 1>(&Start::default(), &sine, &driver.control).expect("in bounds");
        let mut releases = 0;
        let end = Instant::from_whole_seconds(3);
        loop {
            let expected = release_in(&scene, &state, vibration);
            let (before, since) = (state.mode, state.clock.seconds::<f64>());
            let advance = driver.advance(&scene, &mut state, &sine, end, u32::MAX, &mut ()).expect("runs");
            if advance.ended == Ended::Finished {
                break;
            }
            if before == Mode::Stick {
                let expected = since + expected.expect("friction fails");
                let error = state.clock.seconds::<f64>() - expected;
                assert!(error.abs() < 1e-9, "{error}");
                releases += 1;
            }
        }
        assert!(releases > 30, "{releases}");
    }

    #[test]
    fn after_every_event_the_slider_accelerates_the_way_it_goes() {
        for (amplitude, frequency) in [(0.30, 6.0), (0.28, 14.0), (0.36, 18.373), (0.26, 3.0)] {
            let scene = parameters().build().expect("in bounds");
            let sine = Sine::<f64>::new(amplitude * GRAVITY, frequency, 0.0).expect("valid");
            let driver = Driver {
                pause_at_events: true,
                ..Driver::new(TrBdf2, Adaptive::new(1e-4).expect("in bounds"))
            };
            let mut state =
                scene.start::<_, _, 1>(&Start::default(), &sine, &driver.control).expect("in bounds");
            let end = Instant::from_whole_seconds(2);
            while state.clock < end {
                driver.advance(&scene, &mut state, &sine, end, u32::MAX, &mut ()).expect("runs");
                let [_, velocity, _] = state.point.state;
                if velocity == 0.0
                    && let Mode::Sliding { forward, .. } = state.mode
                {
                    let along = if forward { 1.0 } else { -1.0 };
                    let pull = 0.01 * GRAVITY;
                    assert!(
                        along * state.point.derivative[VELOCITY] > -1e-9 * pull,
                        "{amplitude} {frequency}"
                    );
                }
            }
        }
    }

    #[test]
    fn parameters_out_of_bounds_and_starts_apart_are_named() {
        let refused = |change: fn(&mut Parameters<f64, AnyChoices<f64>>)| {
            let mut changed = parameters();
            change(&mut changed);
            changed.build().err().map(|error| error.field)
        };
        assert_eq!(refused(|_| ()), None);
        assert_eq!(refused(|p| p.beam_length = f64::NAN), Some("beam_length"));
        assert_eq!(refused(|p| p.slider_mass = 0.0), Some("slider_mass"));
        assert_eq!(refused(|p| p.choices.friction.kinetic_inert = 0.3), Some("kinetic_friction_inert"));
        assert_eq!(refused(|p| p.charge_density = -1e-6), Some("charge_density"));
        assert_eq!(refused(|p| p.choices.load.resistance = -1.0), Some("resistance"));
        let stiff =
            |p: &mut Parameters<f64, AnyChoices<f64>>| (p.beam_length, p.beam_thickness) = (1e-3, 1e-2);
        assert_eq!(refused(stiff), Some("natural frequency of the beam with the slider"));
        let scene = parameters().build().expect("in bounds");
        let sine = Sine::<f64>::new(1.0, 6.0, 0.0).expect("valid");
        let apart = Start { displacement: Some(-0.02), ..Start::default() };
        let error = scene
            .start::<_, _, 1>(&apart, &sine, &Adaptive::new(1e-4).expect("in bounds"))
            .expect_err("apart");
        assert_eq!((error.field, error.value), ("displacement", -0.02));
    }
}
