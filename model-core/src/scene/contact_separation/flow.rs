//! The flow of each mode, its iteration matrix, and the powers along it.

use super::circuit::Circuit;
use super::force_law::ForceLaw;
use super::state::Mode;
use super::{CHARGE, ContactSeparation, GAP, Parts, STATES, Sticking, VELOCITY};
use crate::integrate::{Base, BoundaryLayer, CircuitEquation, Point, Stage, System};
use crate::observer::{ALL_POWERS, PowerIndex, first_powers};
use crate::oscillator::Oscillator;
use crate::part::load::{Load, Resistance};
use crate::part::parasitic::Parasitic;
use crate::scalar::Scalar;
use crate::scene::coupled::{self, Derivatives, ModeFactor, POSITION};
use crate::scene::electrical_port::{ElectricalPort, PortVoltage, port_items};

impl<S: Scalar, P: Parts<S>> ContactSeparation<S, P> {
    /// Attraction per mass, in m/s².
    #[inline]
    pub(super) fn attraction(&self, circuit: &Circuit<S>) -> S {
        self.force_law.attraction(circuit, self.tribo_charge)
    }

    /// Terminal voltage in V and load current in A.
    ///
    /// With a resistor both come from the rate of the charge. The voltage as the difference `V_oc − q/C` would be 17
    /// kV less 17 kV at a small resistance.
    #[inline]
    pub(super) fn voltage_and_current(&self, mode: Mode, state: &[S; STATES], rate: &[S; STATES]) -> (S, S) {
        if mode == Mode::Stick && !self.sticking.relaxes() {
            return (S::ZERO, S::ZERO);
        }
        match self.load.resistance() {
            Resistance::Finite(resistance) => {
                let current = self.charge_unit * rate[CHARGE];
                (resistance * current, current)
            }
            Resistance::Short => {
                let circuit = self.circuit(state[GAP], state[CHARGE]);
                (S::ZERO, self.charge_unit * circuit.transferred_by_gap * state[VELOCITY])
            }
            Resistance::Open => (self.field * self.circuit(state[GAP], state[CHARGE]).voltage, S::ZERO),
        }
    }
}

/// The flow of one mode.
#[derive(Debug, Clone, Copy)]
pub struct Flow<'a, S: Scalar, P: Parts<S>> {
    scene: &'a ContactSeparation<S, P>,
    mode: Mode,
    /// Rate of the charge per voltage in units of the circuit; 0 unless a resistor carries current in this mode.
    circuit_rate: S,
}

impl<'a, S: Scalar, P: Parts<S>> Flow<'a, S, P> {
    #[inline]
    pub(super) fn new(scene: &'a ContactSeparation<S, P>, mode: Mode) -> Self {
        // If the mass never sticks, the compiler knows the mode and removes the other one.
        let mode = if P::Sticking::POSSIBLE { mode } else { Mode::Free };
        let frozen = mode == Mode::Stick && !scene.sticking.relaxes();
        let circuit_rate = match scene.load.resistance() {
            Resistance::Finite(_) if !frozen => scene.circuit_rate,
            _ => S::ZERO,
        };
        Self { scene, mode, circuit_rate }
    }

    /// Whether the mass sticks.
    #[inline]
    fn is_stick(&self) -> bool {
        self.mode == Mode::Stick
    }

    /// The force per mass against the opening gap, without that of the base: damping, spring and attraction.
    #[inline]
    fn pull(&self, deflection: S, velocity: S, circuit: &Circuit<S>) -> S {
        let scene = self.scene;
        let restoring = scene.stiffness_per_mass * deflection;
        scene.damping_per_mass * velocity + restoring + scene.attraction(circuit)
    }

    /// Derivatives of force and current in flight.
    #[inline]
    pub(super) fn derivatives(&self, state: &[S; STATES]) -> Derivatives<S> {
        let scene = self.scene;
        let circuit = scene.circuit(state[GAP], state[CHARGE]);
        let rate = self.circuit_rate;
        let [by_gap, force_by_charge] = scene.force_law.derivatives(&circuit, scene.tribo_charge);
        Derivatives {
            stiffness: scene.stiffness_per_mass + by_gap,
            damping: scene.damping_per_mass,
            force_by_charge,
            current_by_position: rate * circuit.voltage_by_gap,
            current_by_charge: rate * circuit.voltage_by_charge,
        }
    }

    /// `(1 + c D) Q' = Λ (σ S g − Q D)` with `D = g + d_e`, at a displacement from `start`; `None` without a current
    /// through a resistor. The voltage at the start is that of the carried rate.
    #[inline(always)]
    fn equation<const POWERS: usize>(
        &self,
        start: &Point<S, STATES, POWERS>,
        displacement: S,
    ) -> Option<CircuitEquation<S>> {
        let scene = self.scene;
        let [gap, _, charge] = start.state;
        let rate = self.circuit_rate;
        if !(rate > S::ZERO) {
            return None;
        }
        let distance = gap + scene.dielectric;
        let inertia = |distance: S| {
            if <P::Parasitic as Parasitic<S>>::PRESENT { S::ONE + scene.parasitic * distance } else { S::ONE }
        };
        // By the small opposite charge: the rounding of the total charge would add up.
        let opposite = (scene.tribo_charge - charge) - start.remainder[CHARGE];
        let reached = distance + displacement;
        Some(CircuitEquation {
            inertia: inertia(reached),
            stiffness: rate * reached,
            drive: inertia(distance) * start.derivative[CHARGE] + rate * opposite * displacement,
        })
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
        let (voltage, current) = scene.voltage_and_current(self.mode, state, rate);
        let velocity = state[VELOCITY];
        let momentum = scene.mass * velocity;
        let base = -momentum * acceleration;
        let circuit = scene.circuit(state[GAP], state[CHARGE]);
        let opposite = scene.tribo_charge - circuit.transferred;
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
        powers[PowerIndex::Dissipation as usize] = scene.damping_per_mass * momentum * velocity;
        powers[PowerIndex::ElectrostaticWork as usize] = scene.attraction(&circuit) * momentum;
        powers[PowerIndex::FieldWork as usize] = opposite * opposite * momentum;
        powers
    }
}

impl<S: Scalar, P: Parts<S>, const POWERS: usize> System<S, STATES, POWERS> for Flow<'_, S, P> {
    coupled::flow_items!();

    #[inline(always)]
    fn flow(&self, state: &[S; STATES], acceleration: S) -> [S; STATES] {
        let scene = self.scene;
        let [gap, velocity, charge] = *state;
        let circuit = scene.circuit(gap, charge);
        let charge_rate = self.circuit_rate * circuit.voltage;
        match self.mode {
            Mode::Free => {
                let force = self.pull(gap - scene.initial_gap, velocity, &circuit);
                [velocity, -force - acceleration, charge_rate]
            }
            Mode::Stick => [S::ZERO, S::ZERO, charge_rate],
        }
    }

    /// The deflection includes the rounding remainder of the gap: a small motion is a small difference of gaps.
    #[inline]
    fn flow_from(
        &self,
        start: &Point<S, STATES, POWERS>,
        change: &[S; STATES],
        acceleration: S,
    ) -> [S; STATES] {
        let scene = self.scene;
        let [displacement, _, transferred] = *change;
        let charge_rate =
            self.equation(start, displacement).map_or(S::ZERO, |equation| equation.rate(transferred));
        if self.is_stick() {
            return [S::ZERO, S::ZERO, charge_rate];
        }
        let velocity = start.state[VELOCITY] + change[VELOCITY];
        let deflection = ((start.state[GAP] - scene.initial_gap) + start.remainder[GAP]) + displacement;
        let circuit = scene.circuit(start.state[GAP] + displacement, start.state[CHARGE] + transferred);
        let force = self.pull(deflection, velocity, &circuit);
        [velocity, -force - acceleration, charge_rate]
    }

    #[inline]
    fn oscillator(&self) -> Option<Oscillator<S>> {
        let scene = self.scene;
        (!self.is_stick()).then_some(Oscillator {
            stiffness: scene.stiffness_per_mass,
            damping: scene.damping_per_mass,
            rest: scene.initial_gap,
            base_coupling: S::ONE,
        })
    }

    #[inline]
    fn force_rate(&self, state: &[S; STATES], rate: &[S; STATES]) -> S {
        let scene = self.scene;
        let circuit = scene.circuit(state[GAP], state[CHARGE]);
        let [by_gap, by_charge] = scene.force_law.derivatives(&circuit, scene.tribo_charge);
        -(by_gap * state[VELOCITY] + by_charge * rate[CHARGE])
    }

    #[inline(always)]
    fn stage(&self, start: &Point<S, STATES, POWERS>, displacement: S, _velocity: S) -> Stage<S> {
        let scene = self.scene;
        let [gap, _, charge] = start.state;
        let at = scene.circuit(gap + displacement, charge);
        let force = scene.force_law.expansion(&at, scene.tribo_charge);
        Stage { circuit: self.equation(start, displacement), force }
    }

    /// Voltage and current change with the relative distance of the electrodes.
    #[inline]
    fn time_scale_ratio(&self, start: &[S; STATES], end: &[S; STATES]) -> S {
        let distance = |gap: S| gap.max(S::ZERO) + self.scene.dielectric;
        distance(end[GAP]) / distance(start[GAP])
    }

    #[inline]
    fn boundary_layer(&self, state: &[S; STATES]) -> Option<BoundaryLayer<S>> {
        if !matches!(self.scene.load.resistance(), Resistance::Finite(_)) {
            return None;
        }
        let circuit = self.scene.circuit(state[GAP], state[CHARGE]);
        let following = -circuit.voltage_by_gap / circuit.voltage_by_charge * state[VELOCITY];
        let relaxation = -self.circuit_rate * circuit.voltage_by_charge;
        Some(BoundaryLayer { relaxation, following, scale: self.scene.tribo_charge })
    }

    /// Mechanical changes are relative to the present amplitude of the motion (at least a thousandth of the initial
    /// gap), charges to the tribo-charge.
    #[inline]
    fn error_norm(&self, state: &[S; STATES], change: &[S; STATES]) -> S {
        let scene = self.scene;
        let least = S::from_f64(1e-3) * scene.initial_gap;
        let motion = [state[GAP] - scene.initial_gap, state[VELOCITY]];
        coupled::error_norm(motion, change, scene.time_scale, least, scene.per_tribo_charge)
    }
}

impl<S: Scalar, P: Parts<S>> ElectricalPort<S> for ContactSeparation<S, P> {
    port_items!();

    fn typical_voltage(&self) -> S {
        self.field * self.tribo_charge * self.initial_gap
    }

    /// `V = (σ S g − Q (g + d_e)) / (ε0 S + C_p (g + d_e))`.
    #[inline]
    fn port_voltage(&self, _mode: Mode, gap: S, charge: S) -> PortVoltage<S> {
        let circuit = self.circuit(gap, charge);
        let sharing = self.field * circuit.sharing;
        let by_gap = self.field * circuit.voltage_by_gap;
        // ∂V/∂g = field (σ S (1 + c d_e) − Q) s², with s = 1/(1 + c (g + d_e)).
        PortVoltage {
            value: self.field * circuit.voltage,
            by_position: by_gap,
            by_charge: self.field * circuit.voltage_by_charge,
            curvature: -S::from_f64(2.0) * circuit.parasitic * circuit.sharing * by_gap,
            by_both: -sharing * circuit.sharing,
            magnitude: sharing * self.tribo_charge.max(charge.abs()) * (gap + self.dielectric),
        }
    }

    #[inline]
    fn charge_is_frozen(&self, mode: Mode) -> bool {
        P::Sticking::POSSIBLE && mode == Mode::Stick && !self.sticking.relaxes()
    }

    #[inline]
    fn is_clear(&self, mode: Mode, state: &[S; STATES]) -> bool {
        mode == Mode::Stick || state[GAP] > self.release_margin()
    }
}
