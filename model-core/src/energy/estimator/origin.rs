//! The origin of the clock, the sampling rate while running, and the bias of the samples.

use super::sampling::Droop;
use super::{Estimator, EstimatorError, RATE, Settings};
use crate::bounds::{Bounds, ParameterError};
use crate::clock::Instant;
use crate::scalar::Scalar;
use crate::scene::Harvester;

impl<S: Scalar, H: Harvester<S>> Estimator<S, H> {
    /// Sets the sampling rate in Hz, 10⁻³ to 10⁶, as measured against the clock of the node: that of a MEMS sensor is a
    /// few per cent off. `tolerance` is the largest relative error of that measurement, for the whole of the uncertainty: call
    /// [`Estimator::clear`] too. The rate holds from the newest sample but one on. Snapshots contain it: [`Settings::rate`] stays
    /// the nominal rate, by which a snapshot is accepted.
    ///
    /// [`Settings::rate`]: super::Settings::rate
    ///
    /// # Errors
    /// [`EstimatorError::Unfinished`], or [`EstimatorError::Parameter`] for a rate or a tolerance outside its bounds;
    /// both are then as before.
    pub fn set_rate(&mut self, rate: S, tolerance: S) -> Result<(), EstimatorError<S>> {
        self.refuse_unfinished()?;
        Settings { rate, rate_tolerance: tolerance, ..self.settings }
            .check_numbers()
            .and_then(|()| self.move_origin(rate))
            .map_err(EstimatorError::Parameter)?;
        self.state.rate_tolerance = tolerance;
        Ok(())
    }

    /// The sampling rate in Hz: that of the settings, or the last one set.
    #[must_use]
    pub fn rate(&self) -> S {
        self.state.stream.rate()
    }

    /// Restarts the clock at zero, at the end of the known acceleration.
    #[cold]
    pub(super) fn restart_clock(&mut self) {
        // The stream has accepted this rate before.
        let _accepted = self.move_origin(self.state.stream.rate());
    }

    fn move_origin(&mut self, rate: S) -> Result<(), ParameterError<S>> {
        let state = &mut self.state;
        let origin = state.stream.known_until().ticks();
        state.stream.set_origin(rate).map_err(|_| out_of_bounds(rate))?;
        let clock = self.harvester.clock(&state.harvester).ticks().saturating_sub(origin);
        self.harvester.set_clock(&mut state.harvester, Instant::from_ticks(clock));
        self.droop = Droop::new(self.harvester.angular_frequency(), rate);
        Ok(())
    }

    /// A sample in m/s² without the bias, if that is removed. A saturated one says nothing of it.
    #[inline]
    pub(super) fn without_bias(&mut self, sample: S, saturated: bool) -> S {
        let Some(seconds) = self.settings.bias_seconds else { return sample };
        let state = &mut self.state;
        if !saturated {
            state.bias.track(sample, (seconds * state.stream.rate()).to_u32());
        }
        sample - state.bias.mean
    }
}

/// A rate outside its bounds.
pub(super) fn out_of_bounds<S: Scalar>(rate: S) -> ParameterError<S> {
    ParameterError { field: "rate", value: rate, bounds: Bounds::new(RATE.lowest, RATE.highest) }
}
