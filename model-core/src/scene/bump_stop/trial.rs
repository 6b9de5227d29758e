//! Computes one step: modes, circuit and contact in one scalar equation.
//!
//! With the linear mean voltage `e0 + e1 Δq` of a circuit the equation has a closed form. The mean voltage of a
//! bridge is a curve if conduction begins within the step: the step is then solved again with the tangent at the last
//! charge, up to [`MOST_REPETITIONS`] times, until the charge converges. The repetitions use only sums over the modes.

use super::choices::{ContactOf, Coupling};
use super::circuit::{Circuit, StepCurrent};
use super::contact_law::{ContactKind, ContactLaw};
use super::state::StateOf;
use super::step_set::StepSetOf;
use super::{BumpStop, Parts, State};
use crate::integrate::discrete_gradient::{ContactStep, contact_step};
use crate::part::storage_step::StorageAccount;
use crate::scalar::{Scalar, add_increment};

/// The result of a step.
pub(super) struct Trial<S, const B: usize, const R: usize, C> {
    pub(super) end: State<S, B, R, C>,
    /// Rate of the gap coordinate in m/s at the end of a step without contact force.
    pub(super) gap_rate: S,
    /// Contact force in N, constant over the step.
    pub(super) force: S,
    /// Mean terminal voltage in V, and mean of its square in V².
    pub(super) mean_voltage: S,
    pub(super) mean_square_voltage: S,
    /// Energy delivered to the load in J; behind a bridge, into the storage.
    pub(super) delivered: S,
    pub(super) account: StorageAccount<S>,
}

/// The trial of a harvester with the components `P`.
pub(super) type TrialOf<S, P, const B: usize, const R: usize> =
    Trial<S, B, R, <<P as Parts<S>>::Load as Circuit<S>>::State>;

/// Most repetitions of a step.
///
/// The charges converge monotonically, and each repetition at least squares their relative error: from one half,
/// beyond the coupling of any material, five repetitions reach a rounding of `f64`.
const MOST_REPETITIONS: u32 = 8;

/// The end of a step of all modes without contact force and voltage.
#[derive(Clone, Copy)]
struct Unloaded<S> {
    /// Strain charge in C, gap coordinate in m, and its rate in m/s.
    strain: S,
    gap: S,
    rate: S,
}

/// A linear circuit relation, solved for the unknowns of a step.
struct AffineCircuit<S> {
    /// Mean voltage in V without contact force.
    mean_voltage: S,
    /// Mean voltage per negative contact force in V/N.
    voltage_by_force: S,
    /// Displacement of the gap per contact force in m/N.
    flexibility: S,
}

/// The solution of the scalar equation.
struct Solution<S> {
    strain: S,
    /// Rate of the gap coordinate in m/s without contact force.
    rate: S,
    mean_voltage: S,
    contact: ContactStep<S>,
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Takes the step `set` from `start`; `acceleration` in m/s² is that of the base at the end.
    #[inline(always)]
    pub(super) fn trial(
        &self,
        set: &StepSetOf<S, P, B, R>,
        start: &StateOf<S, P, B, R>,
        acceleration: S,
    ) -> TrialOf<S, P, B, R> {
        let mut end = *start;
        end.clock = start.clock.after(set.ticks);
        end.acceleration = acceleration;
        // The modes without contact force and voltage.
        let rise = acceleration - start.acceleration;
        let mut unloaded = Unloaded { strain: S::ZERO, gap: -self.gap - start.drift, rate: S::ZERO };
        for ((coordinate, mode), modal) in end.beam.iter_mut().zip(&self.beam).zip(&set.beam) {
            *coordinate = modal.free(*coordinate, start.acceleration, rise);
            unloaded.strain += mode.voltage * coordinate[0];
            unloaded.gap += mode.contact * coordinate[0];
            unloaded.rate += mode.contact * coordinate[1];
        }
        if ContactOf::<S, P>::POSSIBLE {
            for ((coordinate, mode), modal) in end.rod.iter_mut().zip(&self.rod).zip(&set.rod) {
                *coordinate = modal.free(*coordinate, start.acceleration, rise);
                unloaded.gap -= mode.contact * coordinate[0];
                unloaded.rate -= mode.contact * coordinate[1];
            }
        }
        // The circuit and the contact.
        let mut account = StorageAccount::default();
        if P::Load::SWITCHES {
            let voltage = self.voltage(&end);
            let moved = self.load.begin(&set.circuit, voltage, &mut end.circuit, &mut account);
            (end.moved_charge, end.charge_remainder) =
                add_increment(end.moved_charge, end.charge_remainder, moved);
        }
        let start_voltage = self.voltage(&end);
        let solution = self.solution(set, start, &end.circuit, start_voltage, unloaded);
        let Solution { strain, rate, mean_voltage, contact } = solution;
        // The effect of contact force and voltage on the modes.
        let force = contact.force;
        end.gap = contact.gap;
        end.closed = start.closed && force > S::ZERO;
        self.load_modes(set, &mut end, force, mean_voltage);
        end.strain_charge = strain;
        let flow = StepCurrent { voltage: start_voltage, charge: strain - start.strain_charge, mean_voltage };
        let passed = self.load.conclude(&set.circuit, &flow, &mut end.circuit, &mut account);
        if self.load.is_short() {
            end.moved_charge = strain;
        } else {
            (end.moved_charge, end.charge_remainder) =
                add_increment(end.moved_charge, end.charge_remainder, passed.charge);
        }
        let change = self.voltage(&end) - start_voltage;
        let of_line =
            mean_voltage * mean_voltage + P::Load::line(&set.circuit).square_by_change * change * change;
        let mean_square_voltage = passed.mean_square_voltage.unwrap_or(of_line);
        Trial {
            end,
            gap_rate: rate,
            force,
            mean_voltage,
            mean_square_voltage,
            delivered: P::Load::delivered(&set.circuit, mean_square_voltage, &account),
            account,
        }
    }

    /// Adds the effect of contact force and voltage on the modes over a step.
    #[inline(always)]
    fn load_modes(
        &self,
        set: &StepSetOf<S, P, B, R>,
        end: &mut StateOf<S, P, B, R>,
        force: S,
        mean_voltage: S,
    ) {
        if ContactOf::<S, P>::POSSIBLE && force != S::ZERO {
            for ((coordinate, mode), modal) in end.rod.iter_mut().zip(&self.rod).zip(&set.rod) {
                let push = mode.contact * force;
                coordinate[0] += modal.by_force[0] * push;
                coordinate[1] += modal.by_force[1] * push;
            }
            for ((coordinate, mode), modal) in end.beam.iter_mut().zip(&self.beam).zip(&set.beam) {
                let push = mode.contact * force;
                coordinate[0] -= modal.by_force[0] * push;
                coordinate[1] -= modal.by_force[1] * push;
            }
        }
        if self.coupling.is_two_way() {
            for (coordinate, modal) in end.beam.iter_mut().zip(&set.beam) {
                coordinate[0] -= modal.by_voltage[0] * mean_voltage;
                coordinate[1] -= modal.by_voltage[1] * mean_voltage;
            }
        }
    }

    /// Solves the scalar equation of a step from a start voltage.
    #[inline(always)]
    fn solution(
        &self,
        set: &StepSetOf<S, P, B, R>,
        start: &StateOf<S, P, B, R>,
        circuit: &<P::Load as Circuit<S>>::State,
        start_voltage: S,
        unloaded: Unloaded<S>,
    ) -> Solution<S> {
        let unloaded_charge = unloaded.strain - start.strain_charge;
        let first = P::Load::line(&set.circuit);
        let line = AffineCircuit {
            mean_voltage: set.per_circuit
                * (first.mean_by_voltage * start_voltage + first.mean_by_charge * unloaded_charge),
            voltage_by_force: set.voltage_by_force,
            flexibility: set.flexibility,
        };
        let mut solution = self.solve_affine(set, start, &line, unloaded);
        if !P::Load::SWITCHES {
            return solution;
        }
        let two_way = self.coupling.is_two_way();
        let without_circuit = if two_way {
            set.flexibility + set.gap_by_voltage * set.voltage_by_force
        } else {
            set.flexibility
        };
        let mut charge = solution.strain - start.strain_charge;
        for _ in 0..MOST_REPETITIONS {
            let Some([at_zero, slope]) = self.load.tangent(&set.circuit, start_voltage, charge, circuit)
            else {
                break;
            };
            let back = if two_way { slope * set.charge_by_voltage } else { S::ZERO };
            let per_circuit = S::ONE / (S::ONE + back);
            let voltage_by_force = slope * set.gap_by_voltage * per_circuit;
            let by_circuit = if two_way { set.gap_by_voltage * voltage_by_force } else { S::ZERO };
            let line = AffineCircuit {
                mean_voltage: per_circuit * (at_zero + slope * unloaded_charge),
                voltage_by_force,
                flexibility: without_circuit - by_circuit,
            };
            solution = self.solve_affine(set, start, &line, unloaded);
            let found = solution.strain - start.strain_charge;
            let apart = found - charge;
            charge = found;
            // The remaining relative error is below the square of this change.
            if apart * apart <= S::EPSILON * charge * charge {
                break;
            }
        }
        solution
    }

    /// Solves the scalar equation for a linear mean voltage.
    #[inline(always)]
    fn solve_affine(
        &self,
        set: &StepSetOf<S, P, B, R>,
        start: &StateOf<S, P, B, R>,
        line: &AffineCircuit<S>,
        unloaded: Unloaded<S>,
    ) -> Solution<S> {
        let Unloaded { mut strain, mut gap, mut rate } = unloaded;
        let two_way = self.coupling.is_two_way();
        let mut mean_voltage = line.mean_voltage;
        if two_way {
            gap -= set.gap_by_voltage * mean_voltage;
            rate -= set.rate_by_voltage * mean_voltage;
            strain -= set.charge_by_voltage * mean_voltage;
        }
        let contact = self.touch(line.flexibility, start, gap);
        if ContactOf::<S, P>::POSSIBLE && contact.force != S::ZERO {
            let by_force = line.voltage_by_force * contact.force;
            mean_voltage -= by_force;
            strain -= set.gap_by_voltage * contact.force;
            if two_way {
                strain += set.charge_by_voltage * by_force;
            }
        }
        Solution { strain, rate, mean_voltage, contact }
    }

    /// Contact force and gap at the end of a step that would reach `gap` without contact force.
    #[inline(always)]
    fn touch(&self, flexibility: S, start: &StateOf<S, P, B, R>, gap: S) -> ContactStep<S> {
        let open = ContactStep { force: S::ZERO, gap };
        if !ContactOf::<S, P>::POSSIBLE {
            return open;
        }
        match self.contact.kind() {
            ContactKind::None => open,
            ContactKind::Compliant => contact_step(start.gap, gap, flexibility, self.stiffness),
            // The force that makes the gap zero; it does no work if the gap was zero before.
            ContactKind::Constrained if gap > S::ZERO && flexibility > S::ZERO => {
                ContactStep { force: gap / flexibility, gap: S::ZERO }
            }
            ContactKind::Impulsive { .. } if start.closed && gap > S::ZERO && flexibility > S::ZERO => {
                ContactStep { force: gap / flexibility, gap: S::ZERO }
            }
            ContactKind::Constrained | ContactKind::Impulsive { .. } => open,
        }
    }
}
