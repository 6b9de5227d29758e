//! The coefficients for one step length.

use super::choices::Coupling;
use super::circuit::Circuit;
use super::mode_step::ModeStep;
use super::{BumpStop, Parts};
use crate::clock::seconds_of_ticks;
use crate::integrate::discrete_gradient::Flexibility;
use crate::integrate::modal::ModalStep;
use crate::part::circuit::{CircuitStep, LinearCircuitStep};
use crate::scalar::{Scalar, zip_with};

/// The coefficients of a step, which depend on its length and the parameters only; `K` are those of the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepSet<S, const B: usize, const R: usize, K = CircuitStep<S>> {
    pub(super) ticks: u32,
    /// Length of the step in s.
    pub(super) step: S,
    pub(super) beam: [ModeStep<S>; B],
    pub(super) rod: [ModeStep<S>; R],
    pub(super) circuit: K,
    /// Of the gap by the contact force, with the voltage fixed, in m/N.
    pub(super) gap_by_force: Flexibility<S>,
    /// Of the gap by the voltage in m/V, and of the strain charge by the contact force in C/N.
    pub(super) gap_by_voltage: Flexibility<S>,
    /// Of the strain charge by the voltage in C/V.
    pub(super) charge_by_voltage: Flexibility<S>,
    /// Of the gap in m and of the strain charge in C, each by the base acceleration in m/s².
    pub(super) gap_by_base: Flexibility<S>,
    pub(super) charge_by_base: Flexibility<S>,
    /// `1/(1 + χ e1 Σ θ² s)`.
    pub(super) per_circuit: S,
    /// `e1/(1 + χ e1 Σ θ² s)` in V/C: mean voltage per charge that the contact force moves.
    pub(super) slope: S,
    /// In free flight: the circuit with the motion that its voltage acts back on. The charge and its moment are those without voltage.
    pub(super) flight: LinearCircuitStep<S>,
}

/// The circuit of a step in free flight with the motion that its voltage acts back on, from that of the circuit alone.
fn coupled<S: Scalar>(
    alone: &LinearCircuitStep<S>,
    charge_by_voltage: &Flexibility<S>,
) -> LinearCircuitStep<S> {
    let Flexibility { constant, tilted, moment } = *charge_by_voltage;
    let (mean, tilt) = (alone.mean, alone.tilt);
    // The charges are m0 − T00 V0 − T01 V1 and m1 + T01 V0 − T11 V1: two equations for V0 and V1.
    let a = S::ONE + mean[1] * constant - mean[2] * tilted;
    let b = mean[1] * tilted + mean[2] * moment;
    let c = tilt[1] * constant - tilt[2] * tilted;
    let d = S::ONE + tilt[1] * tilted + tilt[2] * moment;
    let per = S::ONE / (a * d - b * c);
    LinearCircuitStep {
        mean: zip_with(mean, &tilt, |mean, tilt| (d * mean - b * *tilt) * per),
        tilt: zip_with(tilt, &mean, |tilt, mean| (a * tilt - c * *mean) * per),
        square_by_bend: alone.square_by_bend,
    }
}

/// The coefficients of a harvester with the components `P`.
pub(crate) type StepSetOf<S, P, const B: usize, const R: usize> =
    StepSet<S, B, R, <<P as Parts<S>>::Load as Circuit<S>>::Step>;

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// The coefficients of a step of `ticks` clock ticks, at least 1.
    pub(crate) fn step_set(&self, ticks: u32) -> StepSetOf<S, P, B, R> {
        let ticks = ticks.max(1);
        let step = seconds_of_ticks::<S>(ticks);
        let of = |omega, contact, voltage| {
            let modal = ModalStep::new(omega, self.damping_ratio, step);
            (ModeStep::new(&modal, omega, [contact, voltage]), modal)
        };
        let beam = self.beam.map(|mode| of(mode.angular_frequency, mode.contact, mode.voltage));
        let rod = self.rod.map(|mode| of(mode.angular_frequency, -mode.contact, S::ZERO));
        let zero = Flexibility { constant: S::ZERO, tilted: S::ZERO, moment: S::ZERO };
        let (mut gap_by_force, mut gap_by_voltage, mut charge_by_voltage) = (zero, zero, zero);
        let (mut gap_by_base, mut charge_by_base) = (zero, zero);
        for (mode, (_, modal)) in self.beam.iter().zip(&beam) {
            gap_by_force.add(modal, mode.contact * mode.contact);
            gap_by_voltage.add(modal, mode.contact * mode.voltage);
            charge_by_voltage.add(modal, mode.voltage * mode.voltage);
            gap_by_base.add(modal, mode.contact * mode.base);
            charge_by_base.add(modal, mode.voltage * mode.base);
        }
        for (mode, (_, modal)) in self.rod.iter().zip(&rod) {
            gap_by_force.add(modal, mode.contact * mode.contact);
            gap_by_base.add(modal, -mode.contact * mode.base);
        }
        let circuit = self.load.step(self.capacitance, step);
        let mean_by_charge = P::Load::line(&circuit).mean_by_charge;
        let two_way = self.coupling.is_two_way();
        let back = if two_way { mean_by_charge * charge_by_voltage.constant } else { S::ZERO };
        let per_circuit = S::ONE / (S::ONE + back);
        let alone = self.load.linear_step(self.capacitance, step);
        StepSet {
            ticks,
            step,
            beam: beam.map(|(mode, _)| mode),
            rod: rod.map(|(mode, _)| mode),
            circuit,
            gap_by_force,
            gap_by_voltage,
            charge_by_voltage,
            gap_by_base,
            charge_by_base,
            per_circuit,
            slope: mean_by_charge * per_circuit,
            flight: if two_way { coupled(&alone, &charge_by_voltage) } else { alone },
        }
    }
}
