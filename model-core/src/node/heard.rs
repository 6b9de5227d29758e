//! What a listen moves in the filter: the power, the gain of the map, and by their covariances all else.
//!
//! What was heard is the measurement `P = g m` of the modelled power `m`. It also holds for a power and a gain of 0. Therefore
//!
//! * the power moves with the gain times the change of `m`, and what walks is the difference `P − g m`: a power that was
//!   taken to stay while `m` changes would explain each change by a smaller gain;
//! * what changes from listen to listen and does not last is noise: it moves neither the power nor the slope of the
//!   measurement;
//! * the gain moves by a listen of steady shaking only, after readings that have told the power of the same shaking
//!   ([`PowerMeasurement::of_gain`]).

use super::covariance::{GAIN, POWER, STORE};
use super::filter::{Filter, FilterState, JUMP};
use crate::scalar::Scalar;

/// What a listen says of the power.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PowerMeasurement<S> {
    /// The modelled power in W.
    pub(super) modelled: S,
    /// The part of it that lasts, in W: without what changes from listen to listen.
    pub(super) lasting: S,
    /// Change of that part since the listen before, in W.
    pub(super) change: S,
    /// Variance of the power times the gain by noise and by what does not last, in W².
    pub(super) variance: S,
    /// Part of what it says of the gain that is believed, 0 to 1.
    pub(super) of_gain: S,
}

/// One of two steady motions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Motion {
    /// That of the smaller yield.
    Lower,
    /// That of the larger yield.
    Upper,
}

impl<S: Scalar> Filter<S> {
    /// Takes in a modelled power in W, `elapsed` s after the one before.
    pub(super) fn hear(&self, state: &mut FilterState<S>, elapsed: u32, measurement: PowerMeasurement<S>) {
        let PowerMeasurement { modelled, lasting, change, variance: of_noise, of_gain } = measurement;
        self.follow(state, elapsed, modelled, change);
        let measured = |state: &FilterState<S>| {
            let (power, gain) = (state.covariance.row(POWER), state.covariance.row(GAIN));
            let mut along = power;
            for (entry, gain) in along.iter_mut().zip(gain) {
                *entry -= lasting * gain;
            }
            (along, along[POWER] - lasting * along[GAIN] + of_noise)
        };
        let departure = state.mean[GAIN] * modelled - state.mean[POWER];
        let (mut along, mut variance) = measured(state);
        if departure * departure > variance {
            // The power has jumped, or the map is wrong here.
            let time = S::from_u32(self.unseen(state, elapsed, departure).min(state.of_hour).max(1));
            state.covariance.walk(time, departure * departure / time, self.storing_over(time));
            (along, variance) = measured(state);
        }
        if variance > S::ZERO {
            state.update(along, departure / variance, S::ONE / variance, of_gain);
        }
        self.limit(state);
    }

    /// Moves the power with the gain times a change of the modelled power, at an unknown time since the listen before,
    /// where the power has not moved already.
    ///
    /// The difference `P − g m` then walks, not the power. A power that walked while `m` changed would explain each change by a
    /// smaller gain: `P = g m` also holds for a power and a gain of 0.
    fn follow(&self, state: &mut FilterState<S>, elapsed: u32, modelled: S, change: S) {
        let gain = state.mean[GAIN];
        let moved = gain * change;
        let departure = gain * modelled - state.mean[POWER];
        if !((departure - moved).abs() < departure.abs()) {
            return;
        }
        let time = self.unseen(state, elapsed, moved);
        let jump = Jump::new(S::from_u32(time), S::from_u32(time.min(state.of_hour)));
        let [of_hour, of_all] = jump.means;
        let stored = self.storing_over(S::from_u32(time)).stored;
        let along = [stored * of_all, S::ONE, S::ZERO, S::ZERO, of_hour, of_all];
        let along = along.map(|part| change * part);
        for (mean, along) in state.mean.iter_mut().zip(along) {
            *mean += gain * along;
        }
        state.covariance.add_gain(along);
        let variances = jump.variances.map(|variance| moved * moved * variance);
        state.covariance.widen_income(variances, stored);
        self.limit(state);
    }

    /// Time in s in which the power may have moved by `moved` unseen: since the last reading, if that would have shown it.
    fn unseen(&self, state: &FilterState<S>, elapsed: u32, moved: S) -> u32 {
        let energy = self.storage.stored(moved) * S::from_u32(elapsed);
        let tells = state.located
            && !state.was_full
            && energy * energy > S::from_f64(JUMP * JUMP) * state.covariance.variance(STORE);
        if tells { state.since.min(elapsed) } else { elapsed }.max(1)
    }

    /// Takes in that the power has become one of two, by modelled powers whose middle is `middle` and whose distance is twice
    /// `half`, both in W, `elapsed` s after the listen before. The power is then known to cover both, and the gain stays.
    pub(super) fn hear_either(&self, state: &mut FilterState<S>, elapsed: u32, [middle, half]: [S; 2]) {
        let gain = state.gain();
        let departure = gain.mean * middle - state.mean[POWER];
        let between = gain.mean * half;
        // What is known of the power is of another shaking, and may be near one of both by chance.
        let unknown = departure * departure + between * between + half * half * gain.variance;
        let time = S::from_u32(self.unseen(state, elapsed, departure).min(state.of_hour).max(1));
        state.covariance.walk(time, unknown / time, self.storing_over(time));
        let measurement = PowerMeasurement {
            modelled: middle,
            lasting: middle,
            change: S::ZERO,
            variance: between * between,
            of_gain: S::ZERO,
        };
        self.hear(state, elapsed, measurement);
    }

    /// Which of two modelled powers in W the storage has seen, each uncertain by a relative variance in `spread`: the power is
    /// within two standard deviations of one, and beyond four of the other.
    ///
    /// It is the ratio `x` of the expected power to that seen that counts, as `(x − 1)/√x`, which is `ln x` up to its third
    /// power: the gain is a factor. By its difference a motion that yields more could not be excluded where the gain is
    /// uncertain by a quarter or more, since a gain near 0 would explain whatever was seen.
    pub(super) fn decide(&self, state: &FilterState<S>, modelled: [S; 2], spread: [S; 2]) -> Option<Motion> {
        let [far, near] = [S::from_f64(16.0), S::from_f64(4.0)];
        let (power, gain) = (state.mean[POWER], state.mean[GAIN]);
        if !(power > S::ZERO && gain > S::ZERO) {
            return None;
        }
        let row = state.covariance.row(POWER);
        let of_power = (row[POWER] / power - (row[GAIN] + row[GAIN]) / gain) / power;
        let of_ratio = (of_power + state.covariance.variance(GAIN) / gain / gain).max(S::ZERO);
        let [lower, upper] = modelled.map(|modelled| {
            let ratio = gain * modelled / power;
            (ratio - S::ONE) * (ratio - S::ONE) / ratio
        });
        let [of_lower, of_upper] = spread.map(|spread| (of_ratio + spread).max(S::EPSILON));
        match [lower / of_lower, upper / of_upper] {
            [lower, upper] if lower < near && upper > far => Some(Motion::Lower),
            [lower, upper] if upper < near && lower > far => Some(Motion::Upper),
            _ => None,
        }
    }
}

/// The time in s after one jump at an unknown time, even within an interval: of the whole interval and of the hour that ends
/// with it.
struct Jump<S> {
    /// Means of the hour and of the interval.
    means: [S; 2],
    /// Variance of the hour, covariance, and variance of the interval, in s².
    variances: [S; 3],
}

impl<S: Scalar> Jump<S> {
    fn new(interval: S, hour: S) -> Self {
        let number = S::from_f64;
        let part = hour / interval;
        // Of the integrals of min(v, hour), its square and its product with v over v from 0 to the interval.
        let mean = hour * (S::ONE - number(0.5) * part);
        let square = hour * hour * (S::ONE - number(2.0 / 3.0) * part);
        let product = hour * interval * (number(0.5) - number(1.0 / 6.0) * part * part);
        let half = number(0.5) * interval;
        let whole = number(1.0 / 12.0) * interval * interval;
        Self { means: [mean, half], variances: [square - mean * mean, product - mean * half, whole] }
    }
}
