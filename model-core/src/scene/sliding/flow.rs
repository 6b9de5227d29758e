//! The flow of each mode, its iteration matrix, and the powers along it.

use super::circuit::Circuit;
use super::force_law::ForceLaw;
use super::force_law::LateralForce;
use super::state::Mode;
use super::{CHARGE, DISPLACEMENT, Friction, Parts, STATES, Sliding, Sticking, VELOCITY};
use crate::integrate::{Base, BoundaryLayer, CircuitEquation, Point, Stage, System};
use crate::observer::{ALL_POWERS, PowerIndex, first_powers};
use crate::oscillator::Oscillator;
use crate::part::disc_overlap::DiscOverlap;
use crate::part::load::{Load, Resistance};
use crate::scalar::{Scalar, sum};
use crate::scene::coupled::{self, Derivatives, ModeFactor, POSITION};
use crate::scene::electrical_port::{ElectricalPort, PortVoltage, port_items};

/// The flow of one mode.
#[derive(Debug, Clone, Copy)]
pub struct Flow<'a, S: Scalar, P: Parts<S>> {
    scene: &'a Sliding<S, P>,
    mode: Mode,
    /// Rate of the charge per unit of voltage: 0 unless a resistor carries current in this mode.
    circuit_rate: S,
    /// The sign of the velocity.
    direction: S,
}

impl<'a, S: Scalar, P: Parts<S>> Flow<'a, S, P> {
    #[inline]
    pub(super) fn new(scene: &'a Sliding<S, P>, mode: Mode) -> Self {
        let frozen = Sliding::<S, P>::STICKS && matches!(mode, Mode::Stick) && !scene.sticking.relaxes();
        let circuit_rate = match scene.load.resistance() {
            Resistance::Finite(_) if !frozen => scene.circuit_rate,
            _ => S::ZERO,
        };
        let backward = matches!(mode, Mode::Sliding { forward: false, .. });
        Self { scene, mode, circuit_rate, direction: if backward { -S::ONE } else { S::ONE } }
    }

    /// Whether the slider sticks; if it never does, the compiler removes the code of the stick.
    #[inline]
    fn is_stick(&self) -> bool {
        Sliding::<S, P>::STICKS && matches!(self.mode, Mode::Stick)
    }

    /// Friction and lateral force per modal mass while the slider slides: coefficients of 1, `Δq` and `Δq²`.
    #[inline]
    fn force(&self, ahead: bool, displacement: S, circuit: &Circuit<S>) -> [S; 3] {
        let scene = self.scene;
        let mut force = [S::ZERO; 3];
        if scene.lateral_force.acts() {
            // d (ds1/dx) V (V + 2t) with V = V₀ − Δq/s1.
            let active_by_displacement = scene.active_by_displacement(ahead, displacement);
            let weight = scene.dielectric * active_by_displacement;
            let tribo = scene.surface.tribo_charge;
            let [voltage, slope] = [circuit.voltage, -circuit.per_active];
            let twice = S::from_f64(2.0) * (voltage + tribo);
            let slope = if scene.is_shorted() { S::ZERO } else { slope };
            force = [
                scene.field_force(circuit, active_by_displacement),
                weight * slope * twice,
                weight * slope * slope,
            ];
        }
        if <P::Friction as Friction<S>>::PRESENT {
            let coefficient = self.direction * scene.friction.kinetic_coefficient(circuit.overlap.active);
            let [constant, linear, quadratic] = scene.normal(circuit);
            force[0] -= coefficient * constant;
            force[1] -= coefficient * linear;
            force[2] -= coefficient * quadratic;
        }
        force
    }

    /// Derivatives of force and current while the slider slides.
    #[inline]
    pub(super) fn derivatives(&self, state: &[S; STATES]) -> Derivatives<S> {
        let scene = self.scene;
        let [displacement, _, charge] = *state;
        let ahead = self.mode.is_ahead(displacement);
        let circuit = scene.circuit(ahead, displacement, charge);
        let rate = self.circuit_rate;
        let slope = scene.slope(ahead, displacement, &circuit);
        let coefficient = self.direction * scene.friction.kinetic_coefficient(circuit.overlap.active);
        let by_share = self.direction * scene.friction.kinetic_by_share();
        let [normal, normal_by_charge, _] = scene.normal(&circuit);
        let [_, lateral_by_charge] = scene.lateral(ahead, displacement, &circuit);
        let friction_by_displacement =
            by_share * slope.active * normal + coefficient * scene.normal_by_displacement(&circuit, &slope);
        let lateral_by_displacement = scene.lateral_by_displacement(ahead, displacement, &circuit, &slope);
        Derivatives {
            stiffness: scene.stiffness_per_mass + friction_by_displacement - lateral_by_displacement,
            damping: scene.damping_per_mass,
            force_by_charge: coefficient * normal_by_charge - lateral_by_charge,
            current_by_position: rate * slope.voltage,
            current_by_charge: -rate * circuit.per_active,
        }
    }

    /// The equation of the circuit at a displacement from `start`, also for short steps: the rise of the overlap is no
    /// difference of overlaps.
    #[inline]
    fn equation<const POWERS: usize>(
        &self,
        start: &Point<S, STATES, POWERS>,
        displacement: S,
    ) -> Option<CircuitEquation<S>> {
        let scene = self.scene;
        let from = start.state[DISPLACEMENT];
        let ahead = self.mode.is_ahead(from);
        let reached = scene.overlap(ahead, from + displacement);
        let before = scene.overlap(ahead, from);
        let rise = match scene.short_rise(ahead, from, displacement) {
            Some(rise) => rise,
            None => reached.inert - before.inert,
        };
        self.equation_at([&before, &reached], start.derivative[CHARGE], rise)
    }

    /// `s1 q' = Λ (t s2 − q)` at the second of two overlaps, from the rate of the charge at the first, with the rise of `s2`;
    /// `None` without a current through a resistor. The voltage at the start is that of the carried rate.
    #[inline]
    fn equation_at(
        &self,
        [before, reached]: [&DiscOverlap<S>; 2],
        charge_rate: S,
        rise: S,
    ) -> Option<CircuitEquation<S>> {
        let rate = self.circuit_rate;
        if !(rate > S::ZERO) {
            return None;
        }
        let drive = before.active * charge_rate + rate * self.scene.surface.tribo_charge * rise;
        Some(CircuitEquation { inertia: reached.active, stiffness: rate, drive })
    }

    /// All powers; see [`PowerIndex`].
    #[inline(always)]
    pub(super) fn all_powers(
        &self,
        state: &[S; STATES],
        rate: &[S; STATES],
        acceleration: S,
    ) -> [S; ALL_POWERS] {
        let scene = self.scene;
        let [displacement, velocity, charge] = *state;
        let (voltage, current) = scene.voltage_and_current(self.mode, state, rate);
        let momentum = scene.modal_mass * velocity;
        let base = -scene.base_coupling * momentum * acceleration;
        let ahead = self.mode.is_ahead(displacement);
        let circuit = scene.circuit(ahead, displacement, charge);
        let coefficient = scene.friction.kinetic_coefficient(circuit.overlap.active);
        let [normal, ..] = scene.normal(&circuit);
        let slope = scene.active_by_displacement(ahead, displacement);
        let field_work = -scene.field_force(&circuit, slope) * momentum;
        let mut powers = [S::ZERO; ALL_POWERS];
        // Written out: the compiler cannot remove a floating-point `0 · i`.
        powers[PowerIndex::Load as usize] = match scene.load.resistance() {
            Resistance::Finite(_) => voltage * current,
            Resistance::Short | Resistance::Open => S::ZERO,
        };
        powers[PowerIndex::VoltageSquared as usize] = voltage * voltage;
        powers[PowerIndex::Voltage as usize] = voltage;
        powers[PowerIndex::CurrentMagnitude as usize] = current.abs();
        powers[PowerIndex::Base as usize] = base;
        powers[PowerIndex::BaseMagnitude as usize] = base.abs();
        powers[PowerIndex::Dissipation as usize] =
            momentum * (scene.damping_per_mass * velocity + self.direction * coefficient * normal);
        powers[PowerIndex::ElectrostaticWork as usize] =
            if scene.lateral_force.acts() { field_work } else { S::ZERO };
        powers[PowerIndex::FieldWork as usize] = field_work;
        powers
    }
}

impl<S: Scalar, P: Parts<S>, const POWERS: usize> System<S, STATES, POWERS> for Flow<'_, S, P> {
    coupled::flow_items!();

    #[inline]
    fn is_harmonic(&self) -> bool {
        self.scene.harmonic
    }

    #[inline(always)]
    fn flow(&self, state: &[S; STATES], acceleration: S) -> [S; STATES] {
        let scene = self.scene;
        let [displacement, velocity, charge] = *state;
        let ahead = self.mode.is_ahead(displacement);
        let circuit = scene.circuit(ahead, displacement, charge);
        let charge_rate = self.circuit_rate * circuit.voltage;
        if self.is_stick() {
            return [S::ZERO, S::ZERO, charge_rate];
        }
        let linear = scene.damping_per_mass * velocity + scene.stiffness_per_mass * displacement;
        let [force, ..] = self.force(ahead, displacement, &circuit);
        let force = force - linear;
        [velocity, force - scene.base_coupling * acceleration, charge_rate]
    }

    #[inline]
    fn flow_from(
        &self,
        start: &Point<S, STATES, POWERS>,
        change: &[S; STATES],
        acceleration: S,
    ) -> [S; STATES] {
        let state = sum(&start.state, change);
        let mut rate = System::<S, STATES, POWERS>::flow(self, &state, acceleration);
        if let Some(equation) = self.equation(start, change[DISPLACEMENT]) {
            rate[CHARGE] = equation.rate(change[CHARGE]);
        }
        rate
    }

    #[inline]
    fn oscillator(&self) -> Option<Oscillator<S>> {
        let scene = self.scene;
        (!self.is_stick()).then_some(Oscillator {
            stiffness: scene.stiffness_per_mass,
            damping: scene.damping_per_mass,
            rest: S::ZERO,
            base_coupling: scene.base_coupling,
        })
    }

    /// Of the friction, to a few per cent: it only predicts the force, which is then evaluated. The lateral force is
    /// small and not predicted.
    #[inline]
    fn force_rate(&self, state: &[S; STATES], rate: &[S; STATES]) -> S {
        let scene = self.scene;
        if !<P::Friction as Friction<S>>::PRESENT {
            return S::ZERO;
        }
        let [displacement, velocity, charge] = *state;
        let ahead = self.mode.is_ahead(displacement);
        let circuit = scene.circuit(ahead, displacement, charge);
        let by_xi = DiscOverlap::rough_active_by_xi(scene.xi(ahead, displacement));
        let active_rate = by_xi * scene.per_diameter(ahead) * velocity;
        let coefficient = scene.friction.kinetic_coefficient(circuit.overlap.active);
        let [acting, by_charge] = scene.force_law.acting_charge(circuit.transferred, &scene.surface);
        let per_charge = acting * circuit.per_active;
        // In a short circuit the charge follows: dq/dt = −t ds1/dt.
        let current =
            if scene.is_shorted() { -scene.surface.tribo_charge * active_rate } else { rate[CHARGE] };
        let attraction_rate = per_charge * ((by_charge + by_charge) * current - per_charge * active_rate);
        let normal = scene.weight_per_mass + acting * per_charge;
        let by_share = scene.friction.kinetic_by_share() * active_rate;
        -self.direction * (by_share * normal + coefficient * attraction_rate)
    }

    #[inline(always)]
    fn stage(&self, start: &Point<S, STATES, POWERS>, displacement: S, _velocity: S) -> Stage<S> {
        let scene = self.scene;
        let [from, _, charge] = start.state;
        let ahead = self.mode.is_ahead(from);
        let position = from + displacement;
        let at = scene.circuit(ahead, position, charge);
        let force = self.force(ahead, position, &at);
        if !(self.circuit_rate > S::ZERO) {
            return Stage { circuit: None, force };
        }
        let (before, reached) = (scene.overlap(ahead, from), &at.overlap);
        let rise = reached.inert - before.inert;
        Stage { circuit: self.equation_at([&before, reached], start.derivative[CHARGE], rise), force }
    }

    #[inline]
    fn boundary_layer(&self, state: &[S; STATES]) -> Option<BoundaryLayer<S>> {
        let is_slow = S::IS_DOUBLE && self.scene.harmonic;
        if is_slow { None } else { self.scene.boundary_layer(self.mode, state) }
    }

    /// Mechanical changes are relative to the present amplitude of the motion (at least 10⁻⁶ of the patch's
    /// diameter, because a sine resolves 10⁻⁹ of its amplitude), charges to the tribo-charge.
    #[inline]
    fn error_norm(&self, state: &[S; STATES], change: &[S; STATES]) -> S {
        let scene = self.scene;
        let least = S::from_f64(1e-6) * scene.diameter;
        let motion = [state[DISPLACEMENT], state[VELOCITY]];
        coupled::error_norm(motion, change, scene.time_scale, least, scene.per_tribo_charge)
    }
}

impl<S: Scalar, P: Parts<S>> Sliding<S, P> {
    /// The terminal voltage in V, and `1/s1`.
    #[inline(never)]
    fn port_value(&self, ahead: bool, displacement: S, charge: S) -> [S; 2] {
        let circuit = self.circuit(ahead, displacement, charge);
        [self.field * circuit.voltage, circuit.per_active]
    }

    /// Logarithmic derivative of `1/s1` by the displacement in 1/m, from `1/s1`.
    #[inline(never)]
    fn port_growth(&self, ahead: bool, displacement: S, per_active: S) -> S {
        -self.active_by_displacement(ahead, displacement) * per_active
    }

    /// `d²s1/dx²/s1` in 1/m², from `1/s1`.
    #[inline(never)]
    fn port_bend(&self, ahead: bool, displacement: S, per_active: S) -> S {
        self.active_curvature(ahead, displacement) * per_active
    }
}

impl<S: Scalar, P: Parts<S>> ElectricalPort<S> for Sliding<S, P> {
    port_items!();

    fn typical_voltage(&self) -> S {
        self.field * self.surface.tribo_charge
    }

    /// `V = (σ S2 − q) d / (ε0 ε_r S1)`. The calls are removed where nothing of their results is read.
    #[inline]
    fn port_voltage(&self, mode: Mode, displacement: S, charge: S) -> PortVoltage<S> {
        let ahead = mode.is_ahead(displacement);
        let [value, share] = self.port_value(ahead, displacement, charge);
        let growth = self.port_growth(ahead, displacement, share);
        let bend = self.port_bend(ahead, displacement, share);
        // With s2 = 1 − s1 the voltage is field ((t − q)/s1 − t), so the derivative of its first part is that part
        // times −s1'/s1.
        let per_active = self.field * share;
        let first = per_active * (self.surface.tribo_charge - charge);
        PortVoltage {
            value,
            by_position: first * growth,
            by_charge: -per_active,
            curvature: first * (S::from_f64(2.0) * growth * growth - bend),
            by_both: -per_active * growth,
            magnitude: per_active * self.surface.tribo_charge.max(charge.abs()),
        }
    }

    #[inline]
    fn charge_is_frozen(&self, mode: Mode) -> bool {
        Self::STICKS && matches!(mode, Mode::Stick) && !self.sticking.relaxes()
    }

    #[inline]
    fn is_clear(&self, mode: Mode, state: &[S; STATES]) -> bool {
        matches!(mode, Mode::Stick) || state[VELOCITY].abs() > self.velocity_margin
    }
}
