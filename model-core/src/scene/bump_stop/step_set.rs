//! The coefficients for one step length.

use super::choices::Coupling;
use super::circuit::Circuit;
use super::{BumpStop, Parts};
use crate::clock::seconds_of_ticks;
use crate::integrate::modal::ModalStep;
use crate::part::circuit::CircuitStep;
use crate::scalar::Scalar;

/// The linear map of a step for one mode, `[displacement, velocity]`. The map gives increments, which a short step in
/// `f32` does not round away.
///
/// These are the coefficients of [`ModalStep`], multiplied by the mode's factors for the base acceleration and the
/// voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ModeStep<S> {
    by_displacement: [S; 2],
    by_velocity: [S; 2],
    /// Per base acceleration at the start, and per rise of the base acceleration over the step.
    by_base: [S; 2],
    by_rise: [S; 2],
    /// Per constant modal force over the step.
    pub(super) by_force: [S; 2],
    /// Per negative constant voltage over the step.
    pub(super) by_voltage: [S; 2],
}

impl<S: Scalar> ModeStep<S> {
    /// For a mode with the modal force `base` per negative base acceleration and `voltage` per negative voltage.
    fn new(modal: &ModalStep<S>, base: S, voltage: S) -> Self {
        let by_force = [modal.response, modal.displacement_by_velocity];
        Self {
            by_displacement: [modal.displacement_by_displacement, modal.velocity_by_displacement],
            by_velocity: [modal.displacement_by_velocity, modal.velocity_by_velocity],
            by_base: by_force.map(|per_force| -base * per_force),
            by_rise: [-base * modal.response_to_end, -base * modal.velocity_to_end],
            by_force,
            by_voltage: by_force.map(|per_force| voltage * per_force),
        }
    }

    /// The end without contact force and voltage, for the base acceleration `from` at the start and `from + rise` at
    /// the end.
    #[inline(always)]
    pub(super) fn free(&self, [displacement, velocity]: [S; 2], from: S, rise: S) -> [S; 2] {
        let increment = |row: usize| {
            self.by_displacement[row] * displacement
                + self.by_velocity[row] * velocity
                + self.by_base[row] * from
                + self.by_rise[row] * rise
        };
        [displacement + increment(0), velocity + increment(1)]
    }
}

/// The coefficients of a step, which depend on its length and the parameters only; `K` are those of the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepSet<S, const B: usize, const R: usize, K = CircuitStep<S>> {
    pub(super) ticks: u32,
    /// Length of the step in s.
    pub(super) step: S,
    pub(super) beam: [ModeStep<S>; B],
    pub(super) rod: [ModeStep<S>; R],
    pub(super) circuit: K,
    /// `H` in m/N: displacement of the gap per contact force, with the response of the circuit's first linear
    /// relation.
    pub(super) flexibility: S,
    /// `Σ φ θ s`: displacement of the gap per voltage in m/V, and strain charge per contact force in C/N.
    pub(super) gap_by_voltage: S,
    /// `Σ θ² s` in C/V: strain charge per voltage.
    pub(super) charge_by_voltage: S,
    /// `1/(1 + χ e1 Σ θ² s)`.
    pub(super) per_circuit: S,
    /// Mean voltage per negative contact force in V/N.
    pub(super) voltage_by_force: S,
    /// Rate of the gap per voltage in m/(s V).
    pub(super) rate_by_voltage: S,
}

/// The coefficients of a harvester with the components `P`.
pub(crate) type StepSetOf<S, P, const B: usize, const R: usize> =
    StepSet<S, B, R, <<P as Parts<S>>::Load as Circuit<S>>::Step>;

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// The coefficients of a step of `ticks` clock ticks, at least 1.
    pub(crate) fn step_set(&self, ticks: u32) -> StepSetOf<S, P, B, R> {
        let ticks = ticks.max(1);
        let step = seconds_of_ticks::<S>(ticks);
        let of = |angular_frequency, base, voltage| {
            ModeStep::new(&ModalStep::new(angular_frequency, self.damping_ratio, step), base, voltage)
        };
        let (beam, rod) = (
            self.beam.map(|mode| of(mode.angular_frequency, mode.base, mode.voltage)),
            self.rod.map(|mode| of(mode.angular_frequency, mode.base, S::ZERO)),
        );
        let circuit = self.load.step(self.capacitance, step);
        let mean_by_charge = P::Load::line(&circuit).mean_by_charge;
        let mut flexibility = S::ZERO;
        let (mut gap_by_voltage, mut rate_by_voltage, mut charge_by_voltage) = (S::ZERO, S::ZERO, S::ZERO);
        for (mode, modal) in self.beam.iter().zip(&beam) {
            flexibility += mode.contact * mode.contact * modal.by_force[0];
            gap_by_voltage += mode.contact * mode.voltage * modal.by_force[0];
            rate_by_voltage += mode.contact * mode.voltage * modal.by_force[1];
            charge_by_voltage += mode.voltage * mode.voltage * modal.by_force[0];
        }
        for (mode, modal) in self.rod.iter().zip(&rod) {
            flexibility += mode.contact * mode.contact * modal.by_force[0];
        }
        let two_way = self.coupling.is_two_way();
        let back = if two_way { mean_by_charge * charge_by_voltage } else { S::ZERO };
        let per_circuit = S::ONE / (S::ONE + back);
        let voltage_by_force = mean_by_charge * gap_by_voltage * per_circuit;
        if two_way {
            flexibility -= gap_by_voltage * voltage_by_force;
        }
        StepSet {
            ticks,
            step,
            beam,
            rod,
            circuit,
            flexibility,
            gap_by_voltage,
            charge_by_voltage,
            per_circuit,
            voltage_by_force,
            rate_by_voltage,
        }
    }
}
