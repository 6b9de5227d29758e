//! The start of a run.

use super::mode::Mode;
use super::{CHARGE, Parts, STATES, Sliding};
use crate::bounds::{Bounds, ParameterError, bounded};
use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::hybrid::HybridState;
use crate::integrate::{Point, StepControl};
use crate::scalar::Scalar;

/// Initial values; a `None` is at rest at the centre, electrically relaxed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Start<S> {
    /// Displacement of the tip in m, less than `2r` in magnitude; by default 0.
    pub displacement: Option<S>,
    /// Velocity of the tip relative to the base in m/s, at most 10³ in magnitude; by default 0.
    pub velocity: Option<S>,
    /// Transferred charge `q` in C, at most 1 in magnitude; by default the charge at zero voltage.
    pub charge: Option<S>,
}

bounded! { Start<S>:
    "velocity" = velocity: -1e3, 1e3;
    "charge" = charge: -1.0, 1.0;
}

impl<S: Scalar, P: Parts<S>> Sliding<S, P> {
    /// The state of this harvester at time zero.
    ///
    /// With zero speed the slider sticks if static friction suffices.
    ///
    /// # Errors
    /// A displacement at which slider and active patch are separate, or another value outside its bounds.
    pub fn start<E: Excitation<S>, C: StepControl<S>, const POWERS: usize>(
        &self,
        start: &Start<S>,
        excitation: &E,
        control: &C,
    ) -> Result<HybridState<S, Mode, STATES, POWERS>, ParameterError<S>> {
        start.check_numbers()?;
        let displacement = start.displacement.unwrap_or(S::ZERO);
        let velocity = start.velocity.unwrap_or(S::ZERO);
        // The largest number below 2r.
        let highest = self.diameter * (S::ONE - S::EPSILON);
        Bounds { lowest: -highest, highest }.check("displacement", displacement)?;
        let charge = match start.charge {
            None => self.relaxed_charge(displacement),
            Some(coulombs) => coulombs / self.charge_unit,
        };
        let state = [displacement, velocity, charge];
        let acceleration = excitation.acceleration(Instant::START);
        let mode = if velocity == S::ZERO {
            self.mode_from_rest(&state, acceleration)
        } else {
            Mode::sliding(velocity > S::ZERO, displacement)
        };
        let mut start_state = HybridState::start(self, mode, state, excitation, control);
        if start.charge.is_none() {
            // The voltage is exactly zero. Computed as a difference it would be a rounding error, which a small
            // resistance turns into a current.
            let mut derivative = start_state.point.derivative;
            derivative[CHARGE] = S::ZERO;
            let flow = crate::hybrid::Automaton::<S, STATES, POWERS>::flow(self, mode);
            start_state.point = Point::with_derivative(&flow, state, derivative, acceleration);
        }
        Ok(if mode == Mode::Stick { start_state } else { start_state.disarmed() })
    }
}
