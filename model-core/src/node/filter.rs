//! The income by the store's voltage and by what the node hears, joined.
//!
//! A Kalman filter for the stored energy `E`, the harvested power `P`, the gain `g` of the modelled power, the excess `d` of
//! the standing power over its stated value, and the income since the start of the hour and of the node, `H` and `T`. With
//! the closed form of the storage over an interval `t`, `w = e^(−x)`, `φ = (1 − w)/x`, the charging efficiency `η`, the
//! discharging efficiency `δ`, the standing power `s` and the energy of actions `u`,
//!
//! ```text
//! E ← w E + (η P t − ((s + d) t + u)/δ) φ,   H ← H + P t,   T ← T + P t,   P ← P + random walk.
//! ```
//!
//! A walk of variance `q` in a unit of time adds `q t`, `q t²/2` and `q t³/3` to the variance of `P`, to its covariance with
//! its integral, and to the variance of the integral. Between two known powers the integral is then the trapezoid, with
//! the variance `q t³/12`: that of one jump at an unknown time. So the filter interpolates between listens, and a reading of
//! the voltage corrects power and income of the whole interval before it. A reading is a measurement of `E`, within the cell
//! of the converter; a listen is one of `P = g m` with the modelled power `m`.
//!
//! A reading does not move the gain, which stays uncertain in what the reading tells (a consider state, or Schmidt filter):
//! between two listens the shaking may change, and a storage shows its end but not its beginning, since it is full by then.
//! The next listen then compares the power that the readings have told with that of the map.
//!
//! A reading that departs by more than three standard deviations says that the power has jumped: the walk of the interval
//! is widened, after the fact, until the departure is one standard deviation.

use core::f64::consts::PI;

use super::covariance::{ALL, Covariance, DRAW, Flow, GAIN, HOUR, POWER, STATES, STORE, Storing};
use crate::energy::{Relaxation, Storage};
use crate::scalar::{Mathematics, Scalar, add_increment};
use crate::snapshot::snapshot_fields;

/// Departure in standard deviations from which a jump is assumed.
pub(super) const JUMP: f64 = 3.0;
/// Departure from which a reading must be confirmed by the next one.
const DOUBTED: f64 = 12.0;
/// No code: the next reading needs no confirmation.
const CONFIRMED: u32 = u32::MAX;
/// Change of the power, relative, that is expected where a storage is no longer full.
const CHANGE_FROM_FULL: f64 = 2.0;
/// Usual power over the deviation before anything is known.
pub(super) const USUAL: f64 = 0.1;
/// Largest gain.
const HIGHEST_GAIN: f64 = 1e3;
/// Time in s in which the standing power changes by the deviation of its stated value.
pub(super) const DRAW_MEMORY: f64 = 864_000.0;
/// Least noise of a reading in cells.
const LEAST_NOISE: f64 = 0.2;

/// The constants of the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Filter<S> {
    pub(super) storage: Storage<S>,
    /// Standing power in W.
    pub(super) standing: S,
    /// Variance of the standing power in W².
    pub(super) standing_variance: S,
    /// Increase of that variance in a second.
    pub(super) draw_drift: S,
    /// Relative standard deviation of the energy of actions.
    pub(super) spent: S,
    /// Width of a cell of the converter in V, its noise in V, and its highest code.
    pub(super) cell: S,
    pub(super) noise: S,
    /// Variance of a reading in squares of the cell that is the same at the next reading of the same voltage.
    pub(super) lasting: S,
    pub(super) full_code: u32,
    /// Variance of the gain at the start, and its increase in a second.
    pub(super) gain_variance: S,
    pub(super) gain_drift: S,
    /// Standard deviation of the power before anything is known, in W.
    pub(super) power: S,
}

/// The state of the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct FilterState<S> {
    pub(super) mean: [S; STATES],
    /// What rounding removed from the stored energy and the income since the start.
    low: [S; 2],
    pub(super) covariance: Covariance<S>,
    /// Seconds since the last reading that was used, and since the start of the hour.
    pub(super) since: u32,
    pub(super) of_hour: u32,
    pub(super) located: bool,
    /// Whether the storage may have been full between the last two readings.
    pub(super) was_full: bool,
    /// Code of the last reading if the next one must confirm it, [`CONFIRMED`] if the next one needs no confirmation, else 0.
    doubted: u32,
}

/// Growth of variances in a second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Growth<S> {
    /// Of the power, in W²/s.
    pub(super) power: S,
    /// Of the income, in J²/s: by what changes within the time from listen to listen.
    pub(super) income: S,
}

/// What a reading of the voltage was good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreReading {
    /// It corrected the income.
    Used,
    /// It corrected the income, which must have jumped since the reading before.
    Jump,
    /// The storage may have been full since the reading before, or its energy was not known: the reading says nothing about
    /// the income.
    #[default]
    Silent,
    /// At the ends of the converter, or so far off that the next reading must confirm it.
    Refused,
}

/// A quantity with its variance.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Known<S> {
    pub(super) mean: S,
    pub(super) variance: S,
}

impl<S: Scalar> Known<S> {
    /// Its standard deviation. One square root.
    #[inline(never)]
    pub(super) fn deviation(&self) -> S {
        self.variance.sqrt()
    }
}

impl<S: Scalar> FilterState<S> {
    #[inline(always)]
    fn known(&self, index: usize) -> Known<S> {
        let mean = self.mean.get(index).copied().unwrap_or(S::ZERO);
        Known { mean, variance: self.covariance.variance(index) }
    }

    pub(super) fn store(&self) -> Known<S> {
        self.known(STORE)
    }

    pub(super) fn power(&self) -> Known<S> {
        self.known(POWER)
    }

    pub(super) fn gain(&self) -> Known<S> {
        self.known(GAIN)
    }

    pub(super) fn draw(&self) -> Known<S> {
        self.known(DRAW)
    }

    pub(super) fn hour(&self) -> Known<S> {
        self.known(HOUR)
    }

    pub(super) fn all(&self) -> Known<S> {
        self.known(ALL)
    }

    /// Whether the next reading must confirm the last one.
    pub(super) fn is_doubted(&self) -> bool {
        self.doubted != 0
    }

    /// A reading that was to confirm the last one did not come.
    pub(super) fn miss_confirmation(&mut self) {
        self.doubted = 0;
    }

    /// The next reading needs no confirmation.
    pub(super) fn confirm(&mut self) {
        self.doubted = CONFIRMED;
    }

    /// Whether the stored energy is known.
    pub(super) fn is_located(&self) -> bool {
        self.located
    }

    /// Whether the storage may have been full between the last two readings.
    pub(super) fn was_full(&self) -> bool {
        self.was_full
    }

    /// Begins another hour.
    pub(super) fn close_hour(&mut self) {
        self.of_hour = 0;
        self.mean[HOUR] = S::ZERO;
        self.covariance.limit_correlations();
        self.covariance.clear(HOUR, S::ZERO);
    }

    /// The stored energy is unknown, as before the first reading. The other states keep what they know.
    pub(super) fn lose_store(&mut self) {
        (self.located, self.was_full) = (false, false);
        (self.doubted, self.since) = (0, 0);
    }

    /// Takes in a measurement: `along` are the covariances of the states with the measured quantity, `shift` how far it
    /// is moved in its variance, `removed` one over that variance with the noise. The gain moves by the part `of_gain` of
    /// what would be best.
    pub(super) fn update(&mut self, along: [S; STATES], shift: S, removed: S, of_gain: S) {
        let gain = self.mean[GAIN] + of_gain * along[GAIN] * shift;
        for (mean, &along) in self.mean.iter_mut().zip(&along) {
            *mean += along * shift;
        }
        self.mean[GAIN] = gain;
        self.covariance.remove(along, removed);
        let kept = (S::ONE - of_gain) * along[GAIN];
        self.covariance.widen(GAIN, kept * kept * removed);
    }

    /// Adds to the variance of the stored energy.
    pub(super) fn widen_store(&mut self, variance: S) {
        self.covariance.widen(STORE, variance);
    }

    /// Adds to the variance of the power.
    pub(super) fn widen_power(&mut self, variance: S) {
        self.covariance.widen(POWER, variance);
    }
}

impl<S: Scalar> Filter<S> {
    /// The state before any reading.
    pub(super) fn start(&self) -> FilterState<S> {
        let capacity = self.storage.capacity();
        let covariance = Covariance::new([
            capacity * capacity,
            self.power * self.power,
            self.gain_variance,
            self.standing_variance,
        ]);
        let half = S::from_f64(0.5) * capacity;
        FilterState {
            mean: [half, S::ZERO, S::ONE, S::ZERO, S::ZERO, S::ZERO],
            low: [S::ZERO; 2],
            covariance,
            since: 0,
            of_hour: 0,
            located: false,
            was_full: false,
            doubted: 0,
        }
    }

    /// Variance in squares of the cell of what a converter with a normal noise in cells rounds, in the mean over many readings
    /// of one voltage. The first harmonic of the error falls with the noise as `exp(−2π² noise²)`.
    pub(super) fn lasting_variance(noise: S) -> S {
        let harmonic = S::Build::exponential(S::from_f64(-2.0 * PI * PI) * noise * noise);
        S::from_f64(1.0 / 12.0) * harmonic * harmonic
    }

    /// Width of a cell in V, with the least noise of a reading.
    pub(super) fn least_noise(cell: S) -> S {
        S::from_f64(LEAST_NOISE) * cell
    }

    /// Advances the time by `seconds` in which the node spent `spent` J beside its standing power, while the variances grow by
    /// `growth`. Gives the relaxation of the storage over that time.
    pub(super) fn predict(
        &self,
        state: &mut FilterState<S>,
        seconds: u32,
        is_on: bool,
        spent: S,
        growth: Growth<S>,
    ) -> Relaxation<S> {
        let time = S::from_u32(seconds);
        let storage = &self.storage;
        let relaxation = storage.relaxation(time);
        let [_, power, _, draw, ..] = state.mean;
        let income = power * time;
        let asleep = if is_on { (self.standing + draw) * time } else { S::ZERO };
        let outgo = storage.drawn(asleep + spent).max(S::ZERO);
        let change = storage.step(state.mean[STORE], &relaxation, storage.stored(income), outgo).change;
        (state.mean[STORE], state.low[0]) = add_increment(state.mean[STORE], state.low[0], change);
        (state.mean[ALL], state.low[1]) = add_increment(state.mean[ALL], state.low[1], income);
        state.mean[HOUR] += income;

        let storing = self.storing(&relaxation);
        let flow = Flow {
            time,
            kept: relaxation.kept,
            of_power: storing.stored * time,
            of_draw: if is_on { storage.drawn(relaxation.of_income) * time } else { S::ZERO },
        };
        state.covariance.advance(flow);
        state.covariance.walk(time, growth.power, storing);
        state.covariance.widen_income([growth.income * time; 3], storing.stored);
        if spent > S::ZERO {
            let deviation = self.spent * storage.drawn(spent);
            state.covariance.widen(STORE, deviation * deviation);
        }
        self.widen_gain(state, self.gain_drift * time);
        state.covariance.widen(DRAW, self.draw_drift * time);
        state.covariance.limit_variances();
        state.since = state.since.saturating_add(seconds);
        state.of_hour = state.of_hour.saturating_add(seconds);
        relaxation
    }

    /// What becomes of the income over a time in s.
    pub(super) fn storing_over(&self, time: S) -> Storing<S> {
        self.storing(&self.storage.relaxation(time))
    }

    fn storing(&self, relaxation: &Relaxation<S>) -> Storing<S> {
        let lost = S::ONE - relaxation.kept;
        Storing {
            stored: self.storage.stored(relaxation.of_income),
            uneven: S::from_f64(1.0 / 12.0) * lost * lost,
        }
    }

    /// Adds to the variance of the gain, which is never known less than by the order of magnitude.
    fn widen_gain(&self, state: &mut FilterState<S>, variance: S) {
        state.covariance.widen_to(GAIN, variance, self.gain_variance.max(S::ONE));
    }

    /// Widens the gain by the square of a relative change.
    pub(super) fn widen_gain_by(&self, state: &mut FilterState<S>, relative_variance: S) {
        let gain = state.mean[GAIN];
        self.widen_gain(state, gain * gain * relative_variance);
    }

    /// The energies at both edges of the cell of a code, and the noise of a reading there, in J.
    fn cell(&self, code: u32) -> (S, S, S) {
        let (half, voltage) = (S::from_f64(0.5) * self.cell, S::from_u32(code) * self.cell);
        let low = self.storage.energy((voltage - half).max(S::ZERO));
        let high = self.storage.energy(voltage + half);
        (low, high, (high - low) * (self.noise / self.cell))
    }

    /// Standard deviation of an income in J that two readings near a code show, as well as they resolve the energy.
    pub(super) fn resolution(&self, code: u32) -> S {
        let (low, high, noise) = self.cell(code);
        let width = high - low;
        let of_two = S::from_f64(2.0) * (noise * noise + width * width * S::from_f64(1.0 / 12.0));
        of_two.sqrt() / self.storage.stored(S::ONE)
    }

    /// Whether a reading of an energy in J confirms the one before, or needs no confirmation: it is nearer to that one than to
    /// what is expected. Two glitches are most often not.
    fn confirms(&self, state: &FilterState<S>, energy: S) -> bool {
        let (low, high, _) = self.cell(state.doubted.min(self.full_code));
        let before = S::from_f64(0.5) * (low + high);
        let is_near = (energy - before).abs() < (energy - state.mean[STORE]).abs();
        state.doubted == CONFIRMED || (state.doubted > 0 && is_near)
    }

    /// Takes in that the voltage is at the end of the converter or above: the storage may be full at any voltage from there on.
    fn locate_above(&self, state: &mut FilterState<S>) {
        let (low, high, noise) = self.cell(self.full_code);
        let capacity = self.storage.capacity();
        let half = S::from_f64(0.5) * (capacity.max(high) - low);
        state.mean[STORE] = (low + half).min(capacity);
        state.low[0] = S::ZERO;
        state.covariance.clear(STORE, noise * noise + half * half * S::from_f64(1.0 / 3.0));
        (state.located, state.was_full) = (true, true);
        (state.doubted, state.since) = (0, 0);
    }

    /// Takes in a reading of the voltage; also gives its departure from what was expected in standard deviations, 0 up to
    /// three. `full` is whether the storage may have been full since the reading before.
    pub(super) fn observe(&self, state: &mut FilterState<S>, code: u32, full: bool) -> (StoreReading, S) {
        if code == 0 || code >= self.full_code {
            let is_above = code > 0;
            if is_above && (state.doubted >= self.full_code || state.was_full) {
                self.locate_above(state);
                return (StoreReading::Silent, S::ZERO);
            }
            // Code 0 confirms nothing, and the next reading may be no better.
            state.doubted = if is_above { self.full_code } else { 0 };
            return (StoreReading::Refused, S::ZERO);
        }
        let (low, high, noise) = self.cell(code);
        let (middle, width) = (S::from_f64(0.5) * (low + high), high - low);
        let distance = (low - state.mean[STORE]).max(state.mean[STORE] - high).max(S::ZERO);
        let of_reading = noise * noise + width * width * S::from_f64(1.0 / 12.0);
        let variance = state.covariance.variance(STORE) + noise * noise;
        let departure = distance * distance / variance;
        // Shunted income does not appear in a reading, and the expected energy may exceed it by any amount.
        let square = |deviations: f64| S::from_f64(deviations * deviations);
        let rises = !state.was_full && distance * distance > square(JUMP) * of_reading;
        let limited = full && (state.mean[STORE] >= low || !rises);
        if !state.located || limited {
            state.mean[STORE] = middle.min(self.storage.capacity());
            state.low[0] = S::ZERO;
            state.covariance.clear(STORE, of_reading);
            (state.located, state.was_full) = (true, full);
            (state.doubted, state.since) = (0, 0);
            return (StoreReading::Silent, S::ZERO);
        }
        if departure > square(DOUBTED) && !self.confirms(state, middle) {
            state.doubted = code;
            return (StoreReading::Refused, departure.sqrt());
        }
        if state.was_full && !full && state.since > 0 {
            // What ends a full storage is most often another power, of which the time before says nothing.
            let change = S::from_f64(CHANGE_FROM_FULL) * state.mean[POWER];
            let time = S::from_u32(state.since);
            state.covariance.walk(time, change * change / time, self.storing_over(time));
        }
        let jump = departure > square(JUMP) && state.since > 0;
        if jump {
            let time = S::from_u32(state.since);
            let storing = self.storing_over(time);
            let scale = storing.stored * time;
            let walk = S::from_f64(3.0) * (distance / scale) * (distance / scale) / time;
            state.covariance.walk(time, walk, storing);
        }
        // A cell of even density, as wide as the noise or less, counts by its variance.
        let variance = state.covariance.variance(STORE) + of_reading;
        let removed = S::ONE / variance;
        let shift = (middle - state.mean[STORE]) * removed;
        state.update(state.covariance.row(STORE), shift, removed, S::ZERO);
        let rounding = S::from_f64(4.0) * S::EPSILON * self.storage.capacity();
        state.covariance.raise(STORE, rounding * rounding + self.lasting * width * width);
        self.limit(state);
        if full && state.since > 0 {
            // The income may have been larger by what was shunted.
            let power = state.mean[POWER].max(self.power * S::from_f64(USUAL));
            let time = S::from_u32(state.since);
            state.covariance.walk(time, S::from_f64(3.0) * power * power / time, Storing::NOTHING);
        }
        (state.was_full, state.doubted, state.since) = (full, 0, 0);
        let surprise = if jump { departure.sqrt() } else { S::ZERO };
        (if jump { StoreReading::Jump } else { StoreReading::Used }, surprise)
    }

    /// Keeps gain and draw within what they can be.
    ///
    /// Not so the energy, the power and the incomes: noise takes each below 0, and what is cut off there the next reading takes
    /// back from the others. [`NodeState`](super::NodeState) tells them from 0 on.
    pub(super) fn limit(&self, state: &mut FilterState<S>) {
        let [_, _, gain, draw, ..] = &mut state.mean;
        *gain = gain.max(S::ZERO).min(S::from_f64(HIGHEST_GAIN));
        *draw = draw.max(-self.standing);
    }
}

snapshot_fields!(impl [S: Scalar] FilterState<S> {
    mean, low, covariance, since, of_hour, located, was_full, doubted,
} if |state| {
    let [_, _, gain, ..] = state.mean;
    gain >= S::ZERO
});
