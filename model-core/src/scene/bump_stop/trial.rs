//! One step: modes, circuit and contact in one scalar equation.

use super::contact_law::{ContactKind, ContactLaw};
use super::observer::ModalSpan;
use super::parameters::Coupling;
use super::step_set::StepSet;
use super::{BumpStop, Parts, State};
use crate::integrate::discrete_gradient::{ContactStep, contact_step};
use crate::part::load::{Load, Resistance};
use crate::scalar::{Scalar, add_increment};

/// The end of a step and what happened in it.
pub(super) struct Trial<S, const B: usize, const R: usize> {
    pub(super) end: State<S, B, R>,
    /// Rate of the gap coordinate at the end of a step without contact force.
    pub(super) gap_rate: S,
    force: S,
    pub(super) mean_voltage: S,
    mean_square_voltage: S,
    delivered: S,
}

impl<S: Scalar, const B: usize, const R: usize> Trial<S, B, R> {
    /// What a meter sees of it.
    pub(super) fn span<'a>(
        &'a self,
        start: &'a State<S, B, R>,
        set: &StepSet<S, B, R>,
    ) -> ModalSpan<'a, S, B, R> {
        ModalSpan {
            ticks: set.ticks,
            step: set.step,
            start,
            end: &self.end,
            force: self.force,
            mean_voltage: self.mean_voltage,
            mean_square_voltage: self.mean_square_voltage,
            delivered: self.delivered,
        }
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Takes the step `set` from `start`; `acceleration` is the base's at its end.
    #[inline(always)]
    pub(super) fn trial(
        &self,
        set: &StepSet<S, B, R>,
        start: &State<S, B, R>,
        acceleration: S,
    ) -> Trial<S, B, R> {
        let mut end = *start;
        end.clock = start.clock.after(set.ticks);
        end.acceleration = acceleration;
        // The modes without contact force and voltage.
        let rise = acceleration - start.acceleration;
        let (mut strain, mut gap, mut rate) = (S::ZERO, -self.gap - start.drift, S::ZERO);
        for ((coordinate, mode), modal) in end.beam.iter_mut().zip(&self.beam).zip(&set.beam) {
            *coordinate = modal.free(*coordinate, start.acceleration, rise);
            strain += mode.voltage * coordinate[0];
            gap += mode.contact * coordinate[0];
            rate += mode.contact * coordinate[1];
        }
        if P::Contact::POSSIBLE {
            for ((coordinate, mode), modal) in end.rod.iter_mut().zip(&self.rod).zip(&set.rod) {
                *coordinate = modal.free(*coordinate, start.acceleration, rise);
                gap -= mode.contact * coordinate[0];
                rate -= mode.contact * coordinate[1];
            }
        }
        // The circuit without contact force.
        let two_way = self.coupling.is_two_way();
        let start_voltage = self.voltage(start);
        let circuit = &set.circuit;
        let mut mean_voltage = set.per_circuit
            * (circuit.mean_by_voltage * start_voltage
                + circuit.mean_by_charge * (strain - start.strain_charge));
        if two_way {
            gap -= set.gap_by_voltage * mean_voltage;
            rate -= set.rate_by_voltage * mean_voltage;
            strain -= set.charge_by_voltage * mean_voltage;
        }
        // The contact, and what it does to both.
        let contact = self.touch(set, start, gap);
        let force = contact.force;
        end.gap = contact.gap;
        end.closed = start.closed && force > S::ZERO;
        if P::Contact::POSSIBLE && force != S::ZERO {
            let by_force = set.voltage_by_force * force;
            mean_voltage -= by_force;
            strain -= set.gap_by_voltage * force;
            if two_way {
                strain += set.charge_by_voltage * by_force;
            }
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
        if two_way {
            for (coordinate, modal) in end.beam.iter_mut().zip(&set.beam) {
                coordinate[0] -= modal.by_voltage[0] * mean_voltage;
                coordinate[1] -= modal.by_voltage[1] * mean_voltage;
            }
        }
        end.strain_charge = strain;
        if matches!(self.load.resistance(), Resistance::Short) {
            end.moved_charge = strain;
        } else {
            (end.moved_charge, end.charge_remainder) = add_increment(
                start.moved_charge,
                start.charge_remainder,
                circuit.charge_by_mean * mean_voltage,
            );
        }
        let change = self.voltage(&end) - start_voltage;
        let mean_square_voltage = mean_voltage * mean_voltage + circuit.square_by_change * change * change;
        Trial {
            end,
            gap_rate: rate,
            force,
            mean_voltage,
            mean_square_voltage,
            delivered: circuit.charge_by_mean * mean_square_voltage,
        }
    }

    /// The contact force and the gap at the end of a step that without it would come to `gap`.
    #[inline(always)]
    fn touch(&self, set: &StepSet<S, B, R>, start: &State<S, B, R>, gap: S) -> ContactStep<S> {
        let open = ContactStep { force: S::ZERO, gap };
        if !P::Contact::POSSIBLE {
            return open;
        }
        match self.contact.kind() {
            ContactKind::None => open,
            ContactKind::Compliant => contact_step(start.gap, gap, set.flexibility, self.stiffness),
            // The force that makes the gap zero; it does no work on a gap that was zero before.
            ContactKind::Constrained if gap > S::ZERO && set.flexibility > S::ZERO => {
                ContactStep { force: gap / set.flexibility, gap: S::ZERO }
            }
            ContactKind::Impulsive { .. } if start.closed && gap > S::ZERO && set.flexibility > S::ZERO => {
                ContactStep { force: gap / set.flexibility, gap: S::ZERO }
            }
            ContactKind::Constrained | ContactKind::Impulsive { .. } => open,
        }
    }
}
