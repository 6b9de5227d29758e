//! What a node that knows more than the voltage asks of it and hands it: none of it is in the binary of a [`VoltageNode`] alone.

use super::{Element, VoltageNode, VoltageState};
use crate::node::tier::{BOUND, IncomeOfTime, StoreReading};
use crate::node::{HOUR, real};
use crate::scalar::Scalar;
use crate::snapshot::snapshot_fields;

/// What says something of the income since the last reading beside the voltage: an energy in J at the storage, the variance of
/// its error, and a bound of an error that is the same at all times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::node) struct Beside {
    pub(in crate::node) energy: f32,
    pub(in crate::node) variance: f32,
    pub(in crate::node) bound: f32,
}

/// A harvested power in W by the voltage of the storage, the variance of its error, and the part of that which is the same at all times.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(in crate::node) struct VoltageEstimate {
    pub(in crate::node) power: f32,
    pub(in crate::node) variance: f32,
    pub(in crate::node) lasting: f32,
}

snapshot_fields!(impl [] VoltageEstimate { power, variance, lasting });

impl<const ACTIONS: usize, E: Element> VoltageNode<ACTIONS, E> {
    /// A stored energy in J of a harvested one.
    pub(in crate::node) fn stored_of(&self, harvested: f32) -> f32 {
        self.parameters.storage.charging_efficiency * harvested
    }

    /// Voltage of the storage in V.
    pub(in crate::node) fn voltage(&self, state: &VoltageState<ACTIONS>) -> f32 {
        let storage = &self.parameters.storage;
        let voltage = self.element.voltage(state.energy(), storage.capacitor.capacitance);
        Scalar::min(voltage, storage.highest_voltage)
    }

    /// The estimate by the last two readings.
    pub(in crate::node) fn estimated(&self, state: &VoltageState<ACTIONS>) -> VoltageEstimate {
        let per_time = self.per_stored / real(state.over.max(1));
        let of_charging = self.parameters.tolerances.charging * state.income;
        let of_charging = of_charging * of_charging;
        let lasting = self.lasting_error(state.income, self.standing * real(state.over)) + of_charging;
        VoltageEstimate {
            power: state.income * per_time,
            variance: (state.of_income + of_charging) * per_time * per_time,
            lasting: lasting * per_time * per_time,
        }
    }

    /// Variance in W² of the standing power at the storage.
    pub(in crate::node) const fn of_standing(&self) -> f32 {
        let deviation = self.parameters.tolerances.standing * self.standing;
        deviation * deviation
    }

    /// Takes in that the standing power is larger by so much, in W at the storage.
    pub(in crate::node) fn draw_more(&self, state: &mut VoltageState<ACTIONS>, power: f32) {
        state.excess = Scalar::max(state.excess + power, -self.standing);
    }

    /// Square of the bound in J of the error of an hour by the voltage alone: of the last one, or of two readings.
    pub(in crate::node) fn square_of_bound(&self, state: &VoltageState<ACTIONS>) -> f32 {
        match state.last_hour {
            Some(IncomeOfTime { bound, silent: 0, .. }) => bound * bound,
            _ => self.square_of_two_readings(state),
        }
    }

    /// Square of the bound in J of the error of an income by two readings.
    #[inline]
    fn square_of_two_readings(&self, state: &VoltageState<ACTIONS>) -> f32 {
        let of_a_reading = self.noise * self.element.square_of_slope(state.read);
        self.per_stored * self.per_stored * BOUND * BOUND * 2.0 * of_a_reading
    }

    /// Whether an hour of readings says less than what is known before them: an income up to half of the largest one.
    pub(in crate::node) fn is_mute(&self, state: &VoltageState<ACTIONS>) -> bool {
        let half = 0.5 * self.parameters.largest_power * real(HOUR);
        E::IS_FLAT && self.square_of_two_readings(state) > half * half
    }

    /// Whether an energy in J at the load leaves the lock-out.
    pub(in crate::node) fn affords(&self, state: &VoltageState<ACTIONS>, energy: f32) -> bool {
        state.is_located && state.energy() - self.drawn_per_used * energy > self.lock_out
    }

    /// Whether the storage is full after the next readings, and not yet.
    pub(in crate::node) fn fills_up(&self, state: &VoltageState<ACTIONS>) -> bool {
        let [_, longest] = self.parameters.intervals;
        state.reading == Some(StoreReading::Used) && self.interval(state) < longest
    }
}
