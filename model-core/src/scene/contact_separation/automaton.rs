//! Modes, guards and jumps: impact, stick and release.

use super::circuit::Circuit;
use super::flow::Flow;
use super::force_law::ForceLaw;
use super::state::Mode;
use super::{CHARGE, ContactSeparation, GAP, Parts, STATES, Sticking, VELOCITY};
use crate::excitation::Excitation;
use crate::hybrid::{Automaton, Guard, InputAt, Jump};
use crate::integrate::{ErrorScale, Point, System};
use crate::observer::{Motion, Outputs, StoredEnergy};
use crate::part::restitution::Restitution;
use crate::scalar::Scalar;

/// Margin in roundings of the initial gap within which a released mass still counts as in contact.
const RELEASE_ROUNDINGS: f64 = 64.0;

impl<S: Scalar, P: Parts<S>> ContactSeparation<S, P> {
    /// Contact force per mass in stick, in m/s²: `a + (F_e − k d0) / m`.
    ///
    /// Equation (22) of the paper, derived here; contact lasts while it is positive.
    #[inline]
    pub(super) fn contact_force_per_mass(&self, charge: S, acceleration: S) -> S {
        let attraction = self.attraction(&self.circuit(S::ZERO, charge));
        acceleration + attraction - self.stiffness_per_mass * self.initial_gap
    }

    #[inline]
    fn stored_energy(&self, circuit: &Circuit<S>, gap: S, velocity: S) -> StoredEnergy<S> {
        let half = S::from_f64(0.5);
        let deflection = gap - self.initial_gap;
        let opposite = self.tribo_charge - circuit.transferred;
        // In charge units q²/(2 ε0 S) is m q²; the last term is C_p V²/2.
        let electrical = opposite * opposite * gap
            + circuit.transferred * circuit.transferred * self.dielectric
            + self.parasitic * circuit.voltage * circuit.voltage;
        StoredEnergy {
            mechanical: half * (self.mass * velocity * velocity + self.stiffness * deflection * deflection),
            electrical: self.mass * electrical,
        }
    }

    /// The contact force per mass in stick, and its rate.
    ///
    /// Outlined: the compiler would otherwise evaluate the excitation for it in flight too. Its arguments are values, so
    /// that the points of a flight need not be in memory.
    #[cold]
    #[inline(never)]
    fn release_guard<E: Excitation<S>>(&self, charge: S, charge_rate: S, input: &InputAt<'_, E>) -> Guard<S> {
        let circuit = self.circuit(S::ZERO, charge);
        let [_, by_charge] = self.force_law.derivatives(&circuit, self.tribo_charge);
        Guard {
            value: self.contact_force_per_mass(charge, input.acceleration()),
            rate: input.jerk() + by_charge * charge_rate,
        }
    }

    /// Smallest gap in m that counts as open after a release.
    #[inline]
    pub(super) fn release_margin(&self) -> S {
        S::from_f64(RELEASE_ROUNDINGS) * S::EPSILON * self.initial_gap
    }

    /// The jump to `mode` at contact with the speed `speed` in m/s after the jump.
    #[inline]
    fn leave_contact<const POWERS: usize>(
        &self,
        mode: Mode,
        speed: S,
        point: &Point<S, STATES, POWERS>,
        acceleration: S,
        loss: S,
    ) -> Jump<S, Mode, STATES> {
        let state = [S::ZERO, speed, point.state[CHARGE]];
        let flow = Flow::new(self, mode);
        let derivative = System::<S, STATES, POWERS>::flow(&flow, &state, acceleration);
        Jump {
            mode,
            state,
            remainder: [S::ZERO; STATES],
            derivative,
            loss,
            armed: mode == Mode::Stick || speed > S::ZERO,
        }
    }
}

impl<S: Scalar, P: Parts<S>, const POWERS: usize> Automaton<S, STATES, POWERS> for ContactSeparation<S, P> {
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
        1
    }

    #[inline]
    fn guard<E: Excitation<S>>(
        &self,
        mode: Mode,
        _index: usize,
        armed: bool,
        point: &Point<S, STATES, POWERS>,
        input: &InputAt<'_, E>,
    ) -> Guard<S> {
        if P::Sticking::POSSIBLE && mode == Mode::Stick {
            return self.release_guard(point.state[CHARGE], point.derivative[CHARGE], input);
        }
        // After a release the gap starts at zero with zero rate: the guard is lowered by the margin.
        let lowered = if armed { S::ZERO } else { self.release_margin() };
        Guard { value: point.state[GAP] + lowered, rate: point.state[VELOCITY] }
    }

    #[inline]
    fn rearms(&self, mode: Mode, point: &Point<S, STATES, POWERS>) -> bool {
        mode == Mode::Stick || point.state[VELOCITY] > S::ZERO && point.state[GAP] > self.release_margin()
    }

    fn jump<E: Excitation<S>>(
        &self,
        mode: Mode,
        _index: usize,
        point: &Point<S, STATES, POWERS>,
        input: &InputAt<'_, E>,
        step: S,
    ) -> Jump<S, Mode, STATES> {
        let acceleration = input.acceleration();
        if P::Sticking::POSSIBLE && mode == Mode::Stick {
            return self.leave_contact(Mode::Free, S::ZERO, point, acceleration, S::ZERO);
        }
        let impact_speed = point.state[VELOCITY].abs();
        let rebound = self.restitution.coefficient(impact_speed) * impact_speed;
        let charge = point.state[CHARGE];
        let sticks = P::Sticking::POSSIBLE
            && rebound < self.stick_speed
            && self.contact_force_per_mass(charge, acceleration) > S::ZERO;
        let (mode, speed) = if sticks { (Mode::Stick, S::ZERO) } else { (Mode::Free, rebound) };
        let half_mass = S::from_f64(0.5) * self.mass;
        let loss = half_mass * (impact_speed - speed) * (impact_speed + speed);
        let mut jump = self.leave_contact(mode, speed, point, acceleration, loss);
        if step > S::ZERO && (mode == Mode::Free || self.sticking.relaxes()) {
            // The rate is continuous, since it depends on gap and charge only, and the value of the previous stage is
            // more accurate than the flow's difference. But the rate `∂Q_eq/∂g · v` of a charge that follows the gap
            // changes its sign with the velocity.
            let layer = System::<S, STATES, POWERS>::boundary_layer(&Flow::new(self, mode), &jump.state);
            let before = point.derivative[CHARGE];
            jump.derivative[CHARGE] = layer.map_or(before, |layer| layer.settled(before, step));
        }
        jump
    }

    #[inline]
    fn error_scale(&self) -> ErrorScale<S> {
        let Self { angular_frequency, energy_floor, .. } = *self;
        ErrorScale { angular_frequency, decay_rate: S::from_f64(0.5) * self.damping_per_mass, energy_floor }
    }

    #[inline]
    fn is_impact(&self, mode: Mode, _guard: usize) -> bool {
        mode == Mode::Free
    }

    #[inline]
    fn outputs<'a>(&self, mode: Mode, point: &'a Point<S, STATES, POWERS>) -> Outputs<'a, S> {
        let [gap, velocity, charge] = point.state;
        let mut outputs = Outputs::of_state(&point.state);
        outputs.motions[0] = Motion { value: gap, rate: velocity };
        let circuit = self.circuit(gap, charge);
        let (voltage, _) = self.voltage_and_current(mode, &point.state, &point.derivative);
        let current =
            circuit.transferred_by_gap * velocity + circuit.transferred_by_charge * point.derivative[CHARGE];
        outputs.charge =
            Motion { value: self.charge_unit * circuit.transferred, rate: self.charge_unit * current };
        outputs.voltage = voltage;
        outputs.stored = self.stored_energy(&circuit, gap, velocity);
        outputs.stick = mode == Mode::Stick;
        outputs.mode = u8::from(outputs.stick);
        outputs
    }
}

#[cfg(test)]
mod tests {
    use crate::excitation::Silence;
    use crate::integrate::Adaptive;
    use crate::part::load::AnyLoad;
    use crate::part::parasitic::ParasiticCapacitance;
    use crate::part::restitution::{AnyRestitution, ConstantRestitution};
    use crate::scene::contact_separation::{
        AnyChoices, AnyForceLaw, Choices, Parameters, Start, StickCharge,
    };

    fn parameters(charge_density: f64) -> Parameters<f64, AnyChoices<f64>> {
        Parameters {
            mass: 5e-3,
            stiffness: 80.0,
            damping_ratio: 0.005,
            initial_gap: 3e-3,
            electrode_area: 4e-4,
            dielectric_thickness: 5e-5,
            relative_permittivity: 2.0,
            charge_density,
            choices: Choices {
                load: AnyLoad { resistance: 1e8 },
                restitution: AnyRestitution::Constant(ConstantRestitution { coefficient: 0.5 }),
                force_law: AnyForceLaw::GapField,
                parasitic: ParasiticCapacitance { capacitance: 1e-12 },
                sticking: StickCharge::Frozen,
            },
        }
    }

    #[test]
    fn a_start_in_penetration_or_out_of_bounds_is_refused() {
        let scene = parameters(50e-6).build().expect("in bounds");
        let refused = |start: Start<f64>| {
            scene
                .start::<_, _, 1>(&start, &Silence, &Adaptive::new(1e-3).expect("in bounds"))
                .err()
                .map(|error| error.field)
        };
        assert_eq!(refused(Start { gap: Some(-1e-9), ..Start::default() }), Some("gap"));
        assert_eq!(refused(Start { velocity: Some(f64::NAN), ..Start::default() }), Some("velocity"));
        assert_eq!(refused(Start { charge: Some(f64::INFINITY), ..Start::default() }), Some("charge"));
        assert_eq!(refused(Start::default()), None);
    }

    #[test]
    fn parameters_out_of_bounds_are_named() {
        let refused = |change: fn(&mut Parameters<f64, AnyChoices<f64>>)| {
            let mut changed = parameters(50e-6);
            change(&mut changed);
            changed.build().err().map(|error| error.field)
        };
        assert_eq!(refused(|p| p.mass = 0.0), Some("mass"));
        assert_eq!(refused(|p| p.stiffness = f64::NAN), Some("stiffness"));
        assert_eq!(refused(|p| p.damping_ratio = -1e-9), Some("damping_ratio"));
        assert_eq!(refused(|p| p.initial_gap = f64::INFINITY), Some("initial_gap"));
        assert_eq!(refused(|p| p.electrode_area = -4e-4), Some("electrode_area"));
        assert_eq!(refused(|p| p.dielectric_thickness = 1.0), Some("dielectric_thickness"));
        assert_eq!(refused(|p| p.relative_permittivity = 0.5), Some("relative_permittivity"));
        assert_eq!(refused(|p| p.charge_density = -5e-5), Some("charge_density"));
        assert_eq!(refused(|p| p.choices.parasitic.capacitance = -1e-12), Some("parasitic_capacitance"));
        assert_eq!(refused(|p| p.choices.load.resistance = -1.0), Some("resistance"));
        let elastic = |p: &mut Parameters<f64, AnyChoices<f64>>| {
            p.choices.restitution = AnyRestitution::Constant(ConstantRestitution { coefficient: 1.1 });
        };
        assert_eq!(refused(elastic), Some("restitution.coefficient"));
        let slow = |p: &mut Parameters<f64, AnyChoices<f64>>| (p.mass, p.stiffness) = (1e3, 1e-9);
        assert_eq!(refused(slow), Some("natural frequency sqrt(stiffness / mass) / (2 pi)"));
        assert_eq!(refused(|p| p.choices.load.resistance = f64::INFINITY), None);
    }
}
