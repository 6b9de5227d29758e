//! Computes one step: modes, circuit and contact in one scalar equation, and a step in free flight.
//!
//! In free flight the voltage of a step is linear in time, and two equations for its mean and its rise have constant
//! coefficients. In a step that may touch, the voltage is constant and the contact force linear in time. With the linear
//! mean voltage `e0 + e1 Δq` of a circuit the equation has a closed form. The mean voltage of a bridge is a curve if
//! conduction begins within the step: the step is then solved again with the tangent at the last charge, up to
//! [`MOST_REPETITIONS`] times, until the charge converges. The repetitions use only sums over the modes.

use super::choices::{ContactOf, Coupling};
use super::circuit::{Circuit, StepCurrent};
use super::contact_law::{ContactKind, ContactLaw};
use super::mode_step::{self, Sums};
use super::state::StateOf;
use super::step_set::StepSetOf;
use super::{BumpStop, Parts};
use crate::excitation::Line;
use crate::integrate::discrete_gradient::{Approach, ContactStep, Flexibility, constant_force, contact_step};
use crate::part::storage_step::StorageAccount;
use crate::scalar::{Scalar, add_increment, zip_with};

/// The result of a step, beside the state at its end.
#[derive(Clone, Copy)]
pub(super) struct Trial<S> {
    /// Mean contact force in N, and half its rise over the step.
    pub(super) force: S,
    pub(super) force_tilt: S,
    /// Mean terminal voltage in V, half its rise over the step, and mean of its square in V².
    pub(super) mean_voltage: S,
    pub(super) voltage_tilt: S,
    pub(super) mean_square_voltage: S,
    /// First moment of the strain charge in C, if the voltage has a rise.
    pub(super) charge_moment: S,
    /// Energy delivered to the load in J; behind a bridge, into the storage.
    pub(super) delivered: S,
    pub(super) account: StorageAccount<S>,
    /// Base acceleration in m/s²: mean and half its rise over the step.
    pub(super) base: [S; 2],
}

impl<S: Scalar> Trial<S> {
    /// No step.
    pub(super) fn none() -> Self {
        Self {
            force: S::ZERO,
            force_tilt: S::ZERO,
            mean_voltage: S::ZERO,
            voltage_tilt: S::ZERO,
            mean_square_voltage: S::ZERO,
            charge_moment: S::ZERO,
            delivered: S::ZERO,
            account: StorageAccount::default(),
            base: [S::ZERO; 2],
        }
    }
}

/// Most repetitions of a step.
///
/// The charges converge monotonically, and each repetition at least squares their relative error: from one half,
/// beyond the coupling of any material, five repetitions reach a rounding of `f64`.
const MOST_REPETITIONS: u32 = 8;

/// A linear circuit relation, solved for the unknowns of a step.
struct AffineCircuit<S> {
    /// Mean voltage in V without contact force.
    mean_voltage: S,
    /// Mean voltage in V/C per charge that the contact force moves.
    slope: S,
}

/// The solution of the scalar equation.
struct Solution<S> {
    strain: S,
    mean_voltage: S,
    contact: ContactStep<S>,
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Takes the step `set` from `start` under the base acceleration `base`.
    // Inlined, its coefficients would compete for registers with those of a flight.
    #[inline(never)]
    pub(super) fn trial(
        &self,
        set: &StepSetOf<S, P, B, R>,
        start: &StateOf<S, P, B, R>,
        base: &Line<S>,
        end: &mut StateOf<S, P, B, R>,
        trial: &mut Trial<S>,
    ) {
        let sums = self.free(set, start, base, end);
        let base = [base.mean, base.tilt];
        // The circuit and the contact.
        let mut account = StorageAccount::default();
        let moved = self.begin(set, start, &mut end.circuit, &mut account);
        let start_voltage = (start.strain_charge - moved[0]) * self.elastance;
        let solution = self.solution(set, start, &end.circuit, start_voltage, &sums);
        let Solution { strain, mean_voltage, contact } = solution;
        // The effect of the forces on the modes.
        end.gap = contact.gap;
        if self.is_impulsive() {
            end.closed = start.closed && contact.force > S::ZERO;
        }
        let acting = if self.coupling.is_two_way() { mean_voltage } else { S::ZERO };
        let force = [contact.force, contact.tilt];
        mode_step::push((&set.beam, &self.beam), &mut end.beam, |mode| {
            let [mean, tilt] = zip_with(base, &force, |base, force| mode.base * base + mode.contact * *force);
            [mean + mode.voltage * acting, tilt]
        });
        if ContactOf::<S, P>::POSSIBLE {
            mode_step::push((&set.rod, &self.rod), &mut end.rod, |mode| {
                zip_with(base, &force, |base, force| mode.base * base - mode.contact * *force)
            });
        }
        end.strain_charge = strain;
        let flow = StepCurrent { voltage: start_voltage, charge: strain - start.strain_charge, mean_voltage };
        let of_bridge = self.conclude(set, &flow, moved, end, &mut account);
        let change = self.voltage(end) - start_voltage;
        let of_line =
            mean_voltage * mean_voltage + P::Load::line(&set.circuit).square_by_change * change * change;
        let mean_square_voltage = of_bridge.unwrap_or(of_line);
        *trial = Trial {
            force: contact.force,
            force_tilt: contact.tilt,
            mean_voltage,
            mean_square_voltage,
            delivered: P::Load::delivered(&set.circuit, mean_square_voltage, &account),
            account,
            base,
            ..Trial::none()
        };
    }

    /// Takes the step `set` from `start` in free flight, without contact force, under the base acceleration `base`. A
    /// bridge blocks throughout.
    #[inline(never)]
    pub(super) fn flight<const ALL: usize>(
        &self,
        set: &StepSetOf<S, P, B, R>,
        start: &StateOf<S, P, B, R>,
        base: &Line<S>,
        end: &mut StateOf<S, P, B, R>,
    ) -> Trial<S> {
        let sums = self.free(set, start, base, end);
        let base = [base.mean, base.tilt];
        let mut account = StorageAccount::default();
        let moved = self.begin(set, start, &mut end.circuit, &mut account);
        let start_voltage = (start.strain_charge - moved[0]) * self.elastance;
        let charge = sums.charge - start.strain_charge;
        let of = |[by_start, by_charge, by_moment]: [S; 3]| {
            by_start * start_voltage + by_charge * charge + by_moment * sums.charge_moment
        };
        let voltage = [of(set.flight.mean), of(set.flight.tilt)];
        let [mean, tilt] = voltage;
        (end.gap, end.strain_charge) = (sums.gap, sums.charge);
        let two_way = self.coupling.is_two_way();
        if two_way {
            end.gap -= set.gap_by_voltage.fall(voltage);
            end.strain_charge -= set.charge_by_voltage.fall(voltage);
        }
        mode_step::push((&set.beam, &self.beam), &mut end.beam, |mode| {
            zip_with(base, &voltage, |base, voltage| {
                let by_base = mode.base * base;
                if two_way { by_base + mode.voltage * *voltage } else { by_base }
            })
        });
        if ContactOf::<S, P>::POSSIBLE {
            mode_step::push((&set.rod, &self.rod), &mut end.rod, |mode| base.map(|base| mode.base * base));
        }
        let charge = end.strain_charge - start.strain_charge;
        let flow = StepCurrent { voltage: start_voltage, charge, mean_voltage: mean };
        self.conclude(set, &flow, moved, end, &mut account);
        let bend = start_voltage + self.voltage(end) - mean - mean;
        let mean_square_voltage =
            mean * mean + S::from_f64(1.0 / 3.0) * tilt * tilt + set.flight.square_by_bend * bend * bend;
        let back = if ALL > 0 && two_way { set.charge_by_voltage.fall_of_moment(voltage) } else { S::ZERO };
        Trial {
            mean_voltage: mean,
            voltage_tilt: tilt,
            mean_square_voltage,
            charge_moment: if ALL > 0 { sums.charge_moment - back } else { S::ZERO },
            delivered: P::Load::delivered(&set.circuit, mean_square_voltage, &account),
            account,
            base,
            ..Trial::none()
        }
    }

    /// Advances the modes without contact force, voltage and base acceleration, and what does not depend on them.
    /// Returns the sums at the end without contact force and voltage: the gap coordinate, the strain charge and the
    /// moments of their rates.
    #[inline(always)]
    fn free(
        &self,
        set: &StepSetOf<S, P, B, R>,
        start: &StateOf<S, P, B, R>,
        base: &Line<S>,
        end: &mut StateOf<S, P, B, R>,
    ) -> Sums<S> {
        end.clock = start.clock.after(set.ticks);
        end.acceleration = base.end;
        end.circuit = start.circuit;
        let base = [base.mean, base.tilt];
        let mut sums = mode_step::advance((&set.beam, &self.beam), &start.beam, &mut end.beam, |mode| {
            [mode.contact, mode.voltage]
        });
        sums.gap -= self.gap;
        if self.is_impulsive() {
            (end.drift, end.closed) = (start.drift, start.closed);
            sums.gap -= start.drift;
        }
        if ContactOf::<S, P>::POSSIBLE {
            let rod = mode_step::advance((&set.rod, &self.rod), &start.rod, &mut end.rod, |mode| {
                [-mode.contact, S::ZERO]
            });
            sums.gap += rod.gap;
            sums.gap_moment += rod.gap_moment;
        }
        sums.gap -= set.gap_by_base.fall(base);
        sums.gap_moment -= set.gap_by_base.fall_of_moment(base);
        sums.charge -= set.charge_by_base.fall(base);
        sums.charge_moment -= set.charge_by_base.fall_of_moment(base);
        sums
    }

    /// Applies the outflow of a storage before the current. Returns the charge that has left the electrodes, and its
    /// rounding remainder, in C.
    #[inline]
    fn begin(
        &self,
        set: &StepSetOf<S, P, B, R>,
        start: &StateOf<S, P, B, R>,
        circuit: &mut <P::Load as Circuit<S>>::State,
        account: &mut StorageAccount<S>,
    ) -> [S; 2] {
        let moved = [start.moved_charge, start.charge_remainder];
        if !P::Load::SWITCHES {
            return moved;
        }
        let by_storage = self.load.begin(&set.circuit, self.voltage(start), circuit, account);
        add_increment(moved[0], moved[1], by_storage).into()
    }

    /// Applies the current of a step to the circuit, after `moved` has left the electrodes. Returns the mean square of
    /// the voltage in V² if a bridge conducts.
    #[inline]
    fn conclude(
        &self,
        set: &StepSetOf<S, P, B, R>,
        flow: &StepCurrent<S>,
        moved: [S; 2],
        end: &mut StateOf<S, P, B, R>,
        account: &mut StorageAccount<S>,
    ) -> Option<S> {
        let transferred = self.load.conclude(&set.circuit, flow, &mut end.circuit, account);
        (end.moved_charge, end.charge_remainder) = if self.load.is_short() {
            (end.strain_charge, moved[1])
        } else {
            add_increment(moved[0], moved[1], transferred.charge)
        };
        transferred.mean_square_voltage
    }

    /// Whether impacts are located: only then does the state keep a closed contact and a drift.
    #[inline]
    fn is_impulsive(&self) -> bool {
        matches!(self.contact.kind(), ContactKind::Impulsive { .. })
    }

    /// Solves the scalar equation of a step from a start voltage.
    #[inline(always)]
    fn solution(
        &self,
        set: &StepSetOf<S, P, B, R>,
        start: &StateOf<S, P, B, R>,
        circuit: &<P::Load as Circuit<S>>::State,
        start_voltage: S,
        unloaded: &Sums<S>,
    ) -> Solution<S> {
        let unloaded_charge = unloaded.charge - start.strain_charge;
        let first = P::Load::line(&set.circuit);
        let line = AffineCircuit {
            mean_voltage: set.per_circuit
                * (first.mean_by_voltage * start_voltage + first.mean_by_charge * unloaded_charge),
            slope: set.slope,
        };
        let solution = self.solve_affine::<true>(set, start, &line, unloaded);
        if !P::Load::SWITCHES {
            return solution;
        }
        let mut charge = solution.strain - start.strain_charge;
        if self.load.tangent(&set.circuit, start_voltage, charge, circuit).is_none() {
            return solution;
        }
        // The charge is continuous and monotonic in the mean voltage only with a constant contact force.
        let mut solution = self.solve_affine::<false>(set, start, &line, unloaded);
        charge = solution.strain - start.strain_charge;
        for _ in 0..MOST_REPETITIONS {
            let Some([at_zero, slope]) = self.load.tangent(&set.circuit, start_voltage, charge, circuit)
            else {
                break;
            };
            let back =
                if self.coupling.is_two_way() { slope * set.charge_by_voltage.constant } else { S::ZERO };
            let per_circuit = S::ONE / (S::ONE + back);
            let line = AffineCircuit {
                mean_voltage: per_circuit * (at_zero + slope * unloaded_charge),
                slope: slope * per_circuit,
            };
            solution = self.solve_affine::<false>(set, start, &line, unloaded);
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

    /// Solves the scalar equation for a linear mean voltage. The contact force is linear over the step, or constant.
    #[inline(always)]
    fn solve_affine<const LINEAR: bool>(
        &self,
        set: &StepSetOf<S, P, B, R>,
        start: &StateOf<S, P, B, R>,
        line: &AffineCircuit<S>,
        unloaded: &Sums<S>,
    ) -> Solution<S> {
        let Sums { charge: mut strain, mut gap, gap_moment: mut moment, .. } = *unloaded;
        let two_way = self.coupling.is_two_way();
        let mut mean_voltage = line.mean_voltage;
        if two_way {
            gap -= set.gap_by_voltage.constant * mean_voltage;
            strain -= set.charge_by_voltage.constant * mean_voltage;
            moment += set.gap_by_voltage.tilted * mean_voltage;
        }
        let open = ContactStep { force: S::ZERO, tilt: S::ZERO, gap };
        if !ContactOf::<S, P>::POSSIBLE || !(start.gap > S::ZERO || gap > S::ZERO) {
            return Solution { strain, mean_voltage, contact: open };
        }
        let contact = self.touch::<LINEAR>(set, start, line.slope, [gap, moment]).unwrap_or(open);
        let by_force = set.gap_by_voltage.fall([contact.force, contact.tilt]);
        let back = line.slope * by_force;
        mean_voltage -= back;
        strain -= by_force;
        if two_way {
            strain += set.charge_by_voltage.constant * back;
        }
        Solution { strain, mean_voltage, contact }
    }

    /// Contact force and gap at the end of a step that would reach a gap, with a first moment, without contact force,
    /// and is closed at the start or at that gap.
    #[inline]
    fn touch<const LINEAR: bool>(
        &self,
        set: &StepSetOf<S, P, B, R>,
        start: &StateOf<S, P, B, R>,
        slope: S,
        [gap, free]: [S; 2],
    ) -> Option<ContactStep<S>> {
        let Flexibility { mut constant, mut tilted, mut moment } = set.gap_by_force;
        let by_voltage = &set.gap_by_voltage;
        let back = if self.coupling.is_two_way() { slope } else { S::ZERO };
        constant -= back * by_voltage.constant * by_voltage.constant;
        // The force that makes the gap zero; it does no work if the gap was zero before.
        let zeroes = gap > S::ZERO && constant > S::ZERO;
        let to_zero = || ContactStep { force: gap / constant, tilt: S::ZERO, gap: S::ZERO };
        match self.contact.kind() {
            ContactKind::Compliant => {}
            ContactKind::Constrained => return zeroes.then(to_zero),
            ContactKind::Impulsive { .. } => return (zeroes && start.closed).then(to_zero),
            ContactKind::None => return None,
        }
        tilted -= back * by_voltage.constant * by_voltage.tilted;
        moment += back * by_voltage.tilted * by_voltage.tilted;
        if !LINEAR {
            return Some(constant_force(start.gap, gap, constant, self.stiffness));
        }
        let approach = Approach { gap: start.gap, predicted: gap, moment: free };
        Some(contact_step(&approach, &Flexibility { constant, tilted, moment }, self.stiffness))
    }
}
