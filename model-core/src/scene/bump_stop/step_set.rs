//! The coefficients of one length of step.

use super::parameters::Coupling;
use super::{BumpStop, Parts};
use crate::clock::seconds_of_ticks;
use crate::integrate::modal::ModalStep;
use crate::part::circuit::CircuitStep;
use crate::part::load::Load;
use crate::scalar::Scalar;

/// Everything about a step that depends on its length and the parameters only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSet<S, const B: usize, const R: usize> {
    pub(super) ticks: u32,
    /// Its length in s.
    pub(super) step: S,
    pub(super) beam: [ModalStep<S>; B],
    pub(super) rod: [ModalStep<S>; R],
    pub(super) circuit: CircuitStep<S>,
    /// `H`: how far a unit force moves the gap, the circuit's answer included, in m/N.
    pub(super) flexibility: S,
    /// `Σ φ θ s`: how far a unit voltage moves the gap, and a unit force the strain charge.
    pub(super) gap_by_voltage: S,
    /// `Σ θ² s`: how far a unit voltage moves the strain charge.
    pub(super) charge_by_voltage: S,
    /// `1/(1 + χ e1 Σ θ² s)`.
    pub(super) per_circuit: S,
    /// Mean voltage per unit force, negated.
    pub(super) voltage_by_force: S,
    /// How much a unit voltage changes the rate of the gap.
    pub(super) rate_by_voltage: S,
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// The coefficients of a step of `ticks` clock ticks, at least 1.
    #[must_use]
    pub fn step_set(&self, ticks: u32) -> StepSet<S, B, R> {
        let ticks = ticks.max(1);
        let step = seconds_of_ticks::<S>(ticks);
        let of = |angular_frequency| ModalStep::new(angular_frequency, self.damping_ratio, step);
        let (beam, rod) = (
            self.beam.map(|mode| of(mode.angular_frequency)),
            self.rod.map(|mode| of(mode.angular_frequency)),
        );
        let circuit = CircuitStep::new(self.capacitance, self.load.resistance(), step);
        let mut flexibility = S::ZERO;
        let (mut gap_by_voltage, mut rate_by_voltage, mut charge_by_voltage) = (S::ZERO, S::ZERO, S::ZERO);
        for (mode, modal) in self.beam.iter().zip(&beam) {
            flexibility += mode.contact * mode.contact * modal.response;
            gap_by_voltage += mode.contact * mode.voltage * modal.response;
            rate_by_voltage += mode.contact * mode.voltage * modal.displacement_by_velocity;
            charge_by_voltage += mode.voltage * mode.voltage * modal.response;
        }
        for (mode, modal) in self.rod.iter().zip(&rod) {
            flexibility += mode.contact * mode.contact * modal.response;
        }
        let two_way = self.coupling.is_two_way();
        let back = if two_way { circuit.mean_by_charge * charge_by_voltage } else { S::ZERO };
        let per_circuit = S::ONE / (S::ONE + back);
        let voltage_by_force = circuit.mean_by_charge * gap_by_voltage * per_circuit;
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
