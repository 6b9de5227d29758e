//! The flow of each mode, its iteration matrix, and the powers along it.

use super::force_law::ForceLaw;
use super::lateral_force::LateralForce;
use super::mode::Mode;
use super::{CHARGE, DISPLACEMENT, Friction, Parts, STATES, Sliding, Sticking, VELOCITY};
use crate::integrate::{Base, BoundaryLayer, CircuitEquation, Point, Stage, System};
use crate::observer::{ALL_POWERS, PowerIndex, first_powers};
use crate::oscillator::Oscillator;
use crate::part::disc_overlap::DiscOverlap;
use crate::part::load::{Load, Resistance};
use crate::scalar::Scalar;
use crate::scene::coupled::{self, Derivatives, ModeFactor, POSITION};

/// The electrical quantities at a displacement and a charge: charges in charge units, voltages relative to the
/// voltage of one charge unit at full overlap.
pub(super) struct Circuit<S> {
    overlap: DiscOverlap<S>,
    /// `1/s1`.
    pub(super) per_active: S,
    /// Transferred charge: the state, or in a short circuit a function of the displacement.
    transferred: S,
    pub(super) voltage: S,
}

/// Fourth power of the longest `ξ` of Simpson's rule, in roundings: its error is then below a rounding of the slope.
const SHORT: f64 = 64.0;
/// Largest `ξ` of Simpson's rule: the slope of the overlap has a branch point at 1.
const CURVED: f64 = 0.8;

/// Derivatives of the circuit by the displacement.
struct Slope<S> {
    /// `ds1/dx` in 1/m.
    active: S,
    /// `∂V/∂x` at constant charge.
    voltage: S,
}

impl<S: Scalar, P: Parts<S>> Sliding<S, P> {
    /// `1/2r` on the side `ahead`, `−1/2r` on the other. The sign is exact in every product, and the compiler finds it
    /// once a step.
    #[inline(always)]
    fn per_diameter(&self, ahead: bool) -> S {
        if ahead { self.per_diameter } else { -self.per_diameter }
    }

    /// `ξ = x/2r` on the side `ahead`, `−ξ` on the other.
    #[inline(always)]
    fn xi(&self, ahead: bool, displacement: S) -> S {
        self.per_diameter(ahead) * displacement
    }

    /// Parts of the slider's face on the patches, by the formula of the side `ahead`.
    #[inline(always)]
    pub(super) fn overlap(&self, ahead: bool, displacement: S) -> DiscOverlap<S> {
        DiscOverlap::at(self.xi(ahead, displacement))
    }

    #[inline(always)]
    pub(super) fn circuit(&self, ahead: bool, displacement: S, charge: S) -> Circuit<S> {
        self.circuit_of(self.overlap(ahead, displacement), charge)
    }

    /// The circuit for a known overlap.
    #[inline(always)]
    pub(super) fn circuit_of(&self, overlap: DiscOverlap<S>, charge: S) -> Circuit<S> {
        let per_active = S::ONE / overlap.active;
        let relaxed = self.surface.tribo_charge * overlap.inert;
        if self.is_shorted() {
            return Circuit { overlap, per_active, transferred: relaxed, voltage: S::ZERO };
        }
        Circuit { overlap, per_active, transferred: charge, voltage: (relaxed - charge) * per_active }
    }

    /// `ds1/dx` in 1/m, by the formula of the side `ahead`.
    #[inline(always)]
    pub(super) fn active_by_displacement(&self, ahead: bool, displacement: S) -> S {
        self.per_diameter(ahead) * DiscOverlap::active_by_xi(self.xi(ahead, displacement))
    }

    /// The change of `s2` over a short displacement, by Simpson's rule for its slope; `None` if the displacement is long.
    ///
    /// A difference of overlaps would have the rounding of an overlap.
    #[inline]
    fn short_rise(&self, ahead: bool, from: S, displacement: S) -> Option<S> {
        let middle = self.xi(ahead, from + S::from_f64(0.5) * displacement);
        let length = self.xi(ahead, displacement);
        let square = length * length;
        if !(square * square <= S::EPSILON * S::from_f64(SHORT) && middle.abs() <= S::from_f64(CURVED)) {
            return None;
        }
        let ends = [from, from + displacement].map(|at| DiscOverlap::active_by_xi(self.xi(ahead, at)));
        let slope = ends[0] + ends[1] + S::from_f64(4.0) * DiscOverlap::active_by_xi(middle);
        Some(-length * slope * S::from_f64(1.0 / 6.0))
    }

    /// `d²s1/dx²` in 1/m², by the formula of the side `ahead`.
    #[inline(always)]
    pub(super) fn active_curvature(&self, ahead: bool, displacement: S) -> S {
        // d²s1/dξ² = (16/π²) ξ / −(ds1/dξ), with a pole at |ξ| = 1.
        let xi = self.xi(ahead, displacement);
        let by_xi = DiscOverlap::active_by_xi(xi).abs().max(S::from_f64(1e-3));
        S::from_f64(16.0 / (core::f64::consts::PI * core::f64::consts::PI)) * xi / by_xi
            * self.per_diameter
            * self.per_diameter
    }

    #[inline(always)]
    fn slope(&self, ahead: bool, displacement: S, circuit: &Circuit<S>) -> Slope<S> {
        let active = self.active_by_displacement(ahead, displacement);
        // V = (t s2 − q)/s1, and t s2 − q + t s1 = t − q.
        let opposite = self.surface.tribo_charge - circuit.transferred;
        let voltage = -active * opposite * circuit.per_active * circuit.per_active;
        Slope { active, voltage: if self.is_shorted() { S::ZERO } else { voltage } }
    }

    /// The rate of a charge that follows the displacement, `dq/dt = −t (ds1/dx) v`.
    #[inline(always)]
    pub(super) fn following_current(&self, ahead: bool, displacement: S, velocity: S) -> S {
        -self.surface.tribo_charge * self.active_by_displacement(ahead, displacement) * velocity
    }

    /// Rate in 1/s at which the charge relaxes at a displacement; 0 without a resistor.
    #[inline(always)]
    pub(super) fn relaxation(&self, circuit: &Circuit<S>) -> S {
        self.circuit_rate * circuit.per_active
    }

    /// Normal force per modal mass `(m g + F_e)/M` in m/s²: coefficients of 1, `Δq` and `Δq²`.
    #[inline(always)]
    pub(super) fn normal(&self, circuit: &Circuit<S>) -> [S; 3] {
        let [acting, by_charge] = self.force_law.acting_charge(circuit.transferred, &self.surface);
        let per_charge = acting * circuit.per_active;
        let constant = self.weight_per_mass + acting * per_charge;
        if self.is_shorted() {
            return [constant, S::ZERO, S::ZERO];
        }
        [constant, (per_charge + per_charge) * by_charge, by_charge * by_charge * circuit.per_active]
    }

    /// Derivative of the normal force per modal mass by the displacement.
    #[inline(always)]
    fn normal_by_displacement(&self, circuit: &Circuit<S>, slope: &Slope<S>) -> S {
        let [acting, by_charge] = self.force_law.acting_charge(circuit.transferred, &self.surface);
        let per_charge = acting * circuit.per_active;
        let at_charge = -per_charge * per_charge * slope.active;
        // In a short circuit the charge follows: dq/dx = −t ds1/dx.
        let along = -self.surface.tribo_charge * slope.active * (per_charge + per_charge) * by_charge;
        if self.is_shorted() { at_charge + along } else { at_charge }
    }

    /// The limit of static friction per modal mass in m/s², and its derivative by the charge.
    #[inline(always)]
    pub(super) fn static_friction(&self, circuit: &Circuit<S>) -> [S; 2] {
        let coefficient = self.friction.static_coefficient(circuit.overlap.active);
        let [normal, by_charge, _] = self.normal(circuit);
        [coefficient * normal, coefficient * by_charge]
    }

    /// Lateral force of the field per modal mass, `d (ds1/dx) V (V + 2t)` in these units.
    #[inline(always)]
    fn field_force(&self, circuit: &Circuit<S>, active_by_displacement: S) -> S {
        let tribo = self.surface.tribo_charge;
        self.dielectric * active_by_displacement * circuit.voltage * (circuit.voltage + tribo + tribo)
    }

    /// Lateral force on the slider per modal mass, and its derivative by the charge.
    #[inline(always)]
    pub(super) fn lateral(&self, ahead: bool, displacement: S, circuit: &Circuit<S>) -> [S; 2] {
        if !self.lateral_force.acts() {
            return [S::ZERO; 2];
        }
        let slope = self.active_by_displacement(ahead, displacement);
        let twice = S::from_f64(2.0) * (circuit.voltage + self.surface.tribo_charge);
        let by_charge = -self.dielectric * slope * twice * circuit.per_active;
        [self.field_force(circuit, slope), by_charge]
    }

    /// Derivative of the lateral force per modal mass by the displacement.
    #[inline(always)]
    fn lateral_by_displacement(
        &self,
        ahead: bool,
        displacement: S,
        circuit: &Circuit<S>,
        slope: &Slope<S>,
    ) -> S {
        if !self.lateral_force.acts() {
            return S::ZERO;
        }
        let curvature = self.active_curvature(ahead, displacement);
        let tribo = self.surface.tribo_charge;
        let voltage = circuit.voltage;
        self.dielectric
            * (curvature * voltage * (voltage + tribo + tribo)
                + S::from_f64(2.0) * slope.active * slope.voltage * (voltage + tribo))
    }

    /// Terminal voltage in V and load current in A.
    ///
    /// With a resistor both come from the rate of the charge, because the voltage as a difference is a small part of
    /// `V_oc` at a small resistance.
    #[inline(always)]
    pub(super) fn voltage_and_current(&self, mode: Mode, state: &[S; STATES], rate: &[S; STATES]) -> (S, S) {
        if Self::STICKS && matches!(mode, Mode::Stick) && !self.sticking.relaxes() {
            return (S::ZERO, S::ZERO);
        }
        let [displacement, velocity, charge] = *state;
        let ahead = mode.is_ahead(displacement);
        match self.load.resistance() {
            Resistance::Finite(resistance) => {
                let current = self.charge_unit * rate[CHARGE];
                (resistance * current, current)
            }
            Resistance::Short => {
                (S::ZERO, self.charge_unit * self.following_current(ahead, displacement, velocity))
            }
            // Behind a bridge the charge of an open harvester moves.
            Resistance::Open => {
                let voltage = self.field * self.circuit(ahead, displacement, charge).voltage;
                (voltage, self.charge_unit * rate[CHARGE])
            }
        }
    }

    /// Mechanical and electrical energy in J.
    #[inline(always)]
    pub(super) fn energies(&self, mode: Mode, [displacement, velocity, charge]: [S; STATES]) -> [S; 2] {
        let circuit = self.circuit(mode.is_ahead(displacement), displacement, charge);
        let elastic = self.stiffness_per_mass * displacement * displacement;
        let mechanical = S::from_f64(0.5) * self.modal_mass * (velocity * velocity + elastic);
        // (q − σS2)² d / (2 ε0 ε_r S1) is M d V² s1 in these units.
        let electrical =
            self.modal_mass * self.dielectric * circuit.voltage * circuit.voltage * circuit.overlap.active;
        [mechanical, electrical]
    }
}

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
    #[inline(always)]
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
    #[inline(always)]
    fn is_stick(&self) -> bool {
        Sliding::<S, P>::STICKS && matches!(self.mode, Mode::Stick)
    }

    /// Friction and lateral force per modal mass while the slider slides: coefficients of 1, `Δq` and `Δq²`.
    #[inline(always)]
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
    #[inline(always)]
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
    #[inline(always)]
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
    #[inline(always)]
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

    #[inline(always)]
    fn flow_from(
        &self,
        start: &Point<S, STATES, POWERS>,
        change: &[S; STATES],
        acceleration: S,
    ) -> [S; STATES] {
        let state = core::array::from_fn(|i| start.state[i] + change[i]);
        let mut rate = System::<S, STATES, POWERS>::flow(self, &state, acceleration);
        if let Some(equation) = self.equation(start, change[DISPLACEMENT]) {
            rate[CHARGE] = equation.rate(change[CHARGE]);
        }
        rate
    }

    #[inline(always)]
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
    #[inline(always)]
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
        self.scene.boundary_layer(self.mode, state)
    }

    /// Mechanical changes are relative to the present amplitude of the motion (at least 10⁻⁶ of the patch's
    /// diameter, because a sine resolves 10⁻⁹ of its amplitude), charges to the tribo-charge.
    #[inline(always)]
    fn error_norm(&self, state: &[S; STATES], change: &[S; STATES]) -> S {
        let scene = self.scene;
        let least = S::from_f64(1e-6) * scene.diameter;
        let motion = [state[DISPLACEMENT], state[VELOCITY]];
        coupled::error_norm(motion, change, scene.time_scale, least, scene.per_tribo_charge)
    }
}
