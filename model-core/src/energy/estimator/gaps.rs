//! Takes samples one by one and handles missing ones: interpolation, loss and restart of the harvester.

use super::sampling::Interpolation;
use super::state::{Phase, Queue};
use super::{Estimator, EstimatorError, Sample};
use crate::clock::Instant;
use crate::excitation::is_acceleration;
use crate::scalar::Scalar;
use crate::scene::Harvester;

/// Decay times after which the power of a motion from rest is nearly that of the motion without a gap.
const SETTLING_DECAYS: f64 = 3.0;

/// The instant from which the clock restarts: half a year.
const LATEST: Instant = Instant::from_whole_seconds(1 << 24);

impl<S: Scalar, H: Harvester<S>> Estimator<S, H> {
    /// Queues a sample, with the samples lost before it.
    pub(super) fn take(&mut self, sample: Sample<S>) {
        let (target, saturated) = match sample {
            Sample::Good(acceleration) if is_acceleration(acceleration) => (acceleration, false),
            Sample::Saturated(acceleration) if is_acceleration(acceleration) => (acceleration, true),
            Sample::Good(_) | Sample::Saturated(_) | Sample::Missing => return self.lose(1),
        };
        let target = self.without_bias(target, saturated);
        let state = &mut self.state;
        state.saturated_samples = state.saturated_samples.saturating_add(u32::from(saturated));
        let restarts = state.phase != Phase::Following;
        let length = if restarts { 1 } else { core::mem::take(&mut state.missing).saturating_add(1) };
        let from = state.stream.newest_sample();
        state.queue = Queue { from, target, saturated, restarts, length, left: length };
    }

    /// Counts `count` lost samples; the state of the harvester becomes unknown after too many in a row.
    pub(super) fn lose(&mut self, count: u32) {
        let longest = u32::from(self.settings.longest_gap);
        let state = &mut self.state;
        state.missing_samples = state.missing_samples.saturating_add(count);
        if state.phase != Phase::Waiting {
            state.missing = state.missing.saturating_add(count);
        }
        if state.phase != Phase::Following {
            state.add_unknown(count);
        } else if state.missing > longest {
            state.add_unknown(state.missing);
            // The newest sample replaces its successor, so that the interval up to the newest sample can be integrated.
            state.missing = state.missing.saturating_sub(1);
            state.phase = Phase::Lost;
            let newest = state.stream.newest_sample();
            self.feed(newest, false);
        }
    }

    /// Makes the state of the harvester unknown after a failed step, and discards the queued samples.
    #[cold]
    pub(super) fn lose_harvester(&mut self) {
        let state = &mut self.state;
        let queued = core::mem::take(&mut state.queue.left);
        // The interval of the step, the interval up to the newest sample unless this sample is a replacement,
        // and the queued intervals.
        let to_newest = u32::from(state.phase == Phase::Following);
        state.add_unknown(queued.saturating_add(1 + to_newest));
        state.missing = state.missing.saturating_add(queued);
        state.phase = Phase::Lost;
        state.pending = false;
    }

    /// Takes the next sample into the stream.
    #[inline]
    pub(super) fn feed(&mut self, sample: S, uncertain: bool) {
        if self.state.stream.known_until() >= LATEST {
            self.restart_clock();
        }
        let velocity = self.harvester.velocity(&self.state.harvester);
        let state = &mut self.state;
        let before = state.stream.known_until();
        state.stream.take(sample);
        state.uncertain = (state.uncertain << 1) | u8::from(uncertain);
        let [older, old] = state.unfiltered;
        state.unfiltered = [old, sample];
        if state.stream.known_until() == before {
            return;
        }
        state.pending = true;
        let bend = (sample - old) - (old - older);
        let samples = [sample, sample - old];
        let in_period = (self.droop.samples, state.settling > 0);
        state.response.add(velocity, samples, in_period, &mut state.accumulator);
        // The interval that is now known lies between the oldest sample and the middle one. The filter includes the
        // samples on either side.
        let mut touched = 0b110;
        if self.settings.interpolation == Interpolation::DroopCompensated {
            state.stream.replace_last_but_one(self.droop.compensate(old, bend));
            touched = 0b1111;
        }
        if state.uncertain & touched != 0 || state.settling > 0 {
            state.uncertain_time.add_intervals(1, state.stream.ticks_per_sample());
        }
        state.settling = state.settling.saturating_sub(1);
    }

    /// Restarts the harvester at a sample.
    #[cold]
    pub(super) fn restart(&mut self, sample: S, uncertain: bool) -> Result<(), EstimatorError<S>> {
        let state = &mut self.state;
        let mut stream = state.stream;
        // The mean is that of the samples so far, and a bias only after its time constant.
        let mut settling = self.settings.settling_seconds.max(self.settings.bias_seconds.unwrap_or(S::ZERO));
        let before = if state.phase == Phase::Waiting {
            stream.begin_with(sample);
            None
        } else {
            if stream.reaches(state.missing) {
                stream.restart_with(state.missing, sample);
            } else {
                stream.begin_with(sample);
            }
            state.add_unknown(1);
            settling = settling.max(S::from_f64(SETTLING_DECAYS) / self.harvester.decay_rate());
            Some(&state.harvester)
        };
        match self.harvester.restart(before, &stream, stream.known_until()) {
            Ok(harvester) => state.harvester = harvester,
            Err(error) => {
                state.missing = state.missing.saturating_add(1);
                return Err(EstimatorError::Parameter(error));
            }
        }
        state.stream = stream;
        state.uncertain = u8::from(uncertain);
        state.settling = (settling * state.stream.rate()).to_u32();
        state.unfiltered = [sample; 2];
        if state.phase != Phase::Waiting {
            let seconds = |samples: u32| S::from_u32(samples) / state.stream.rate();
            state.response.lose(seconds(state.missing.saturating_add(1)), seconds(self.droop.samples));
        }
        state.missing = 0;
        state.phase = Phase::Following;
        Ok(())
    }
}
