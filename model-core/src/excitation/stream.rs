//! An acceleration of samples that arrive one by one, linearly interpolated.

use super::sample_grid::{SampleGrid, between_samples, line_between_samples};
use super::{Excitation, ExcitationError, Line};
use crate::clock::Instant;
use crate::oscillator::{Kernel, Response};
use crate::scalar::Scalar;
use crate::snapshot::{Reader, Snapshot, Writer};

/// Leaps of [`Stream::restart`]. The number of missing intervals of at least 2²⁰ ticks is at most 2³² at
/// first, 2¹² after the first leap, and one after the second.
const LEAPS: u32 = 3;

/// The largest magnitude of a sample in m/s²: no sensor measures a hundred thousand times gravity.
pub(crate) const LARGEST_SAMPLE: f64 = 1e6;

/// Whether `sample` in m/s² is an acceleration: finite and within [`LARGEST_SAMPLE`].
#[inline]
pub(crate) fn is_acceleration<S: Scalar>(sample: S) -> bool {
    sample.abs() <= S::from_f64(LARGEST_SAMPLE)
}

/// The last three samples of a fixed-rate stream, linearly interpolated.
///
/// The first sample is at time zero. The acceleration has the same bits as that of a
/// [`Sampled`](super::Sampled) of the same samples and rate.
///
/// ```
/// use model_core::clock::{Instant, TICKS_PER_SECOND};
/// use model_core::excitation::{Excitation, Stream};
///
/// let mut stream = Stream::<f32>::new(4.0, 0.0)?; // samples per second, first sample in m/s²
/// stream.push(1.0)?;
/// assert_eq!(stream.known_until(), Instant::START);
/// stream.push(-2.0)?;
/// assert_eq!(stream.known_until(), Instant::from_ticks(TICKS_PER_SECOND / 4)); // a quarter of a second
/// assert_eq!(stream.acceleration(Instant::from_ticks(TICKS_PER_SECOND / 8)), 0.5);
/// # Ok::<(), model_core::excitation::StreamError>(())
/// ```
///
/// # End of the known acceleration
///
/// A run can be advanced to [`Stream::known_until`], the first tick at or after the last sample but one. That
/// tick lies up to one tick after this sample, between it and the last sample. So the stream lags one sample
/// behind, and it stores three samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stream<S> {
    grid: SampleGrid<S>,
    /// [`SampleGrid::whole_ticks_per_sample`].
    interval: u64,
    /// Index of the newest sample.
    newest: u64,
    /// The last three samples in m/s², the newest last. Before the third they repeat the first.
    samples: [S; 3],
    /// The first tick at or after the last sample but one.
    known_until: Instant,
}

/// The reason why a stream or a sample was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StreamError {
    /// The rate is not above zero, not finite, above 1 MHz, or below one sample in two years.
    Rate,
    /// The sample is not finite, or above 10⁶ m/s² in magnitude.
    Sample,
}

impl core::fmt::Display for StreamError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Rate => write!(f, "sample rate must be above 0 and at most 1e6 Hz"),
            Self::Sample => write!(f, "sample must be from -1e6 to 1e6 m/s²"),
        }
    }
}

impl core::error::Error for StreamError {}

impl<S: Scalar> Stream<S> {
    /// A stream of `rate` samples per second with its first sample in m/s².
    ///
    /// # Errors
    /// A rate that is out of range, or a sample that is not finite or above 10⁶ m/s².
    pub fn new(rate: S, first: S) -> Result<Self, StreamError> {
        let grid = SampleGrid::new(rate).map_err(|_: ExcitationError| StreamError::Rate)?;
        let interval = grid.whole_ticks_per_sample().ok_or(StreamError::Rate)?;
        if !is_acceleration(first) {
            return Err(StreamError::Sample);
        }
        Ok(Self { grid, interval, newest: 0, samples: [first; 3], known_until: Instant::START })
    }

    /// Takes the next sample in m/s².
    ///
    /// # Errors
    /// A sample that is not finite or above 10⁶ m/s²; the stream is then as before.
    #[inline]
    pub fn push(&mut self, sample: S) -> Result<(), StreamError> {
        if !is_acceleration(sample) {
            return Err(StreamError::Sample);
        }
        self.take(sample);
        Ok(())
    }

    /// Takes the next sample, which must be finite.
    #[inline]
    pub(crate) fn take(&mut self, sample: S) {
        let [_, middle, last] = self.samples;
        self.samples = [middle, last, sample];
        self.newest = self.newest.wrapping_add(1);
        let last_but_one = self.newest.saturating_sub(1);
        // False for the first sample, and for the first one after a restart.
        if self.grid.sample_before(self.known_until) < last_but_one {
            self.known_until = self.tick_of_next(self.known_until, last_but_one);
        }
    }

    /// Begins again with `sample` in m/s² after a gap of `missed` samples.
    ///
    /// [`Stream::known_until`] is then the time of this sample.
    ///
    /// # Errors
    /// A sample that is not finite or above 10⁶ m/s²; the stream is then as before.
    pub fn restart(&mut self, missed: u32, sample: S) -> Result<(), StreamError> {
        if !is_acceleration(sample) {
            return Err(StreamError::Sample);
        }
        self.restart_with(missed, sample);
        Ok(())
    }

    /// [`Stream::restart`] with a sample that must be finite.
    pub(crate) fn restart_with(&mut self, missed: u32, sample: S) {
        let index = self.newest.wrapping_add(u64::from(missed)).wrapping_add(1);
        self.known_until = self.first_tick_beyond(self.known_until, index);
        (self.newest, self.samples) = (index, [sample; 3]);
    }

    /// Begins at time zero with `sample`, which must be finite.
    pub(crate) fn begin_with(&mut self, sample: S) {
        (self.newest, self.samples, self.known_until) = (0, [sample; 3], Instant::START);
    }

    /// Moves time zero to [`Stream::known_until`] and changes the rate from there on.
    ///
    /// The samples stay. The last one but one, or the only one since a restart, is then at time zero: it moves by less
    /// than a tick.
    ///
    /// # Errors
    /// A rate that is out of range; the stream is then as before.
    pub(crate) fn set_origin(&mut self, rate: S) -> Result<(), StreamError> {
        let ahead = self.newest.wrapping_sub(self.grid.sample_before(self.known_until));
        let Self { grid, interval, .. } = Self::new(rate, S::ZERO)?;
        *self = Self { grid, interval, newest: ahead, samples: self.samples, known_until: Instant::START };
        Ok(())
    }

    /// Samples per second.
    #[must_use]
    pub fn rate(&self) -> S {
        self.grid.samples_per_second
    }

    /// Replaces the last sample but one, to which the acceleration is known, in m/s².
    #[inline]
    pub(crate) fn replace_last_but_one(&mut self, sample: S) {
        let [_, middle, _] = &mut self.samples;
        *middle = sample;
    }

    /// Whether the time of a sample `missed + 1` intervals on is in the first half of the clock.
    pub(crate) fn reaches(&self, missed: u32) -> bool {
        let ticks =
            (u128::from(missed) + 1) * u128::from(self.interval) + u128::from(self.known_until.ticks());
        ticks < 1 << 63
    }

    /// The instant to which a run can be advanced: that of the last sample but one, rounded up to a tick.
    #[must_use]
    pub fn known_until(&self) -> Instant {
        self.known_until
    }

    pub(crate) fn newest_sample(&self) -> S {
        let [_, _, last] = self.samples;
        last
    }

    /// Ticks from one sample to the next, rounded down.
    pub(crate) fn ticks_per_sample(&self) -> u64 {
        self.interval
    }

    /// The first tick at or after sample `index`, from the first tick at or after the previous sample.
    #[inline]
    fn tick_of_next(&self, before: Instant, index: u64) -> Instant {
        // `before` is less than a tick late, and the interval is less than a tick too short. So the sum is
        // the tick just before or just after the sample.
        let near = Instant::from_ticks(before.ticks().wrapping_add(self.interval));
        if self.grid.sample_before(near) >= index { near } else { near.after(1) }
    }

    /// The first tick at or after sample `index`, from an instant any number of intervals earlier.
    #[cold]
    fn first_tick_beyond(&self, before: Instant, index: u64) -> Instant {
        let mut before = before.ticks();
        for _ in 0..LEAPS {
            // All missing intervals except the last one; each is less than a tick too short.
            let missing = index.saturating_sub(self.grid.sample_before(Instant::from_ticks(before)));
            before = before.wrapping_add(missing.saturating_sub(1).wrapping_mul(self.interval));
        }
        let mut beyond = before.wrapping_add(self.interval).wrapping_add(1);
        while beyond.wrapping_sub(before) > 1 {
            let middle = before.wrapping_add(beyond.wrapping_sub(before) / 2);
            if self.grid.sample_before(Instant::from_ticks(middle)) < index {
                before = middle;
            } else {
                beyond = middle;
            }
        }
        Instant::from_ticks(beyond)
    }

    /// The samples on either side of `at`, and the position of `at` between them, 0 to 1.
    #[inline]
    fn bracket(&self, at: Instant) -> (S, S, S) {
        let (whole, theta) = self.grid.place(at);
        let [first, middle, last] = self.samples;
        // Outside the three samples the acceleration is that of the nearest one.
        match self.newest.wrapping_sub(whole).cast_signed() {
            ..=0 => (last, last, theta),
            1 => (middle, last, theta),
            2 => (first, middle, theta),
            _ => (first, first, theta),
        }
    }
}

impl<S: Scalar> Excitation<S> for Stream<S> {
    between_samples!();
}

impl<S: Scalar> Snapshot for Stream<S> {
    const BYTES: usize = 4 * S::BYTES + 2 * u64::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.grid.samples_per_second.write(out);
        self.newest.write(out);
        self.samples.write(out);
        self.known_until.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Self {
        let rate = S::read(from);
        let (newest, samples, known_until) =
            (Snapshot::read(from), Snapshot::read(from), Snapshot::read(from));
        let grid = SampleGrid::new(rate).ok();
        let interval = grid.as_ref().and_then(SampleGrid::whole_ticks_per_sample);
        let (Some(grid), Some(interval)) = (grid, interval) else {
            from.require(false);
            let grid = SampleGrid::without_rate();
            return Self { grid, interval: 0, newest, samples, known_until };
        };
        let stream = Self { grid, interval, newest, samples, known_until };
        let ahead = newest.checked_sub(stream.grid.sample_before(known_until));
        from.require(ahead.is_some_and(|samples| samples <= 1));
        stream
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{AfterLastSample, Sampled};

    fn has_the_bits_of_a_whole_trace<S: Scalar>() {
        let samples: Vec<S> = (0..300).map(|n| S::from_f64((f64::from(n) * 0.7).sin() * 3.0)).collect();
        for rate in [0.3, 100.0, 128.0, 333.3, 400.0, 1600.0, 26_667.0].map(S::from_f64) {
            let whole = Sampled::new(&samples, rate, AfterLastSample::Silence).expect("valid");
            let mut stream = Stream::new(rate, samples[0]).expect("valid");
            for (n, &sample) in samples.iter().enumerate().skip(1) {
                let from = stream.known_until();
                stream.push(sample).expect("finite");
                let until = stream.known_until();
                assert_eq!(n > 1, until > from);
                let seventh = (until.ticks() - from.ticks()) / 7;
                let parts = (0..7).map(|part| Instant::from_ticks(from.ticks() + seventh * part));
                let last = Instant::from_ticks(until.ticks().saturating_sub(1)).max(from);
                for at in parts.chain([last, until]) {
                    assert_eq!(stream.acceleration(at), whole.acceleration(at), "{rate} Hz, sample {n}");
                    assert_eq!(stream.jerk(at), whole.jerk(at));
                    assert_eq!(stream.smooth_ticks(at), whole.smooth_ticks(at));
                }
            }
        }
    }

    #[test]
    fn has_the_bits_of_a_whole_trace_at_every_tick_asked_for() {
        has_the_bits_of_a_whole_trace::<f32>();
        has_the_bits_of_a_whole_trace::<f64>();
    }

    #[test]
    fn is_known_until_the_first_tick_of_the_last_sample_but_one() {
        for rate in [0.3, 99.9, 400.0, 1e6] {
            let mut stream = Stream::<f64>::new(rate, 0.0).expect("valid");
            for n in 1..2000_u64 {
                stream.push(0.0).expect("finite");
                let (tick, sample) = (stream.known_until(), n - 1);
                assert_eq!(stream.grid.sample_before(tick), sample, "{rate} Hz");
                if sample > 0 {
                    let before = Instant::from_ticks(tick.ticks() - 1);
                    assert_eq!(stream.grid.sample_before(before), sample - 1, "{rate} Hz");
                }
            }
        }
    }

    #[test]
    fn a_restart_stands_where_the_samples_would_have_led() {
        for rate in [0.3, 99.9, 400.0, 26_667.0] {
            for missed in [0, 1, 2, 17, 1000] {
                let start = Stream::<f64>::new(rate, 0.0).expect("valid");
                let (mut jumped, mut walked) = (start, start);
                for stream in [&mut jumped, &mut walked] {
                    stream.push(1.0).expect("finite");
                    stream.push(2.0).expect("finite");
                }
                jumped.restart(missed, 5.0).expect("finite");
                assert_eq!(jumped.acceleration(jumped.known_until()), 5.0);
                for _ in 0..missed {
                    walked.push(0.0).expect("finite");
                }
                for sample in [5.0, 6.0] {
                    walked.push(sample).expect("finite");
                }
                // The restart computes the time of its sample; the first interval needs two more samples.
                assert_eq!(jumped.known_until(), walked.known_until(), "{rate} Hz, {missed} missed");
                jumped.push(6.0).expect("finite");
                assert_eq!(jumped.known_until(), walked.known_until());
                for sample in [7.0, 8.0] {
                    jumped.push(sample).expect("finite");
                    walked.push(sample).expect("finite");
                    assert_eq!(jumped.known_until(), walked.known_until());
                    assert_eq!(jumped.newest, walked.newest);
                }
                assert_eq!(jumped, walked);
            }
        }
        // A gap of a hundred days at 400 Hz.
        let mut stream = Stream::<f32>::new(400.0, 0.0).expect("valid");
        stream.restart(100 * 86_400 * 400 - 1, 1.0).expect("finite");
        assert_eq!(stream.known_until(), Instant::from_whole_seconds(100 * 86_400));
    }

    #[test]
    fn a_new_origin_moves_time_and_nothing_else() {
        for rate in [0.3, 99.9, 400.0, 26_667.0] {
            for samples in 1..5 {
                let mut stream = Stream::<f64>::new(rate, 1.0).expect("valid");
                for n in 1..samples {
                    stream.push(f64::from(n * n)).expect("finite");
                }
                let mut moved = stream;
                moved.set_origin(rate).expect("valid");
                assert_eq!((moved.known_until(), moved.rate()), (Instant::START, rate));
                for n in samples..samples + 40 {
                    let from = stream.known_until().ticks().wrapping_sub(moved.known_until().ticks());
                    for part in 0..3 {
                        let after = part * (stream.ticks_per_sample() / 4);
                        let at = moved.known_until().ticks() + after;
                        let [one, other] = [
                            stream.acceleration(Instant::from_ticks(at + from)),
                            moved.acceleration(Instant::from_ticks(at)),
                        ];
                        // A tick or two of a slope of at most 100 m/s² in an interval.
                        let bound = 200.0 / stream.ticks_per_sample() as f64;
                        assert!((one - other).abs() <= bound, "{rate} Hz, sample {n}: {one} {other}");
                    }
                    stream.push(f64::from(n % 11)).expect("finite");
                    moved.push(f64::from(n % 11)).expect("finite");
                    let drift = stream.known_until().ticks() - moved.known_until().ticks();
                    assert!(drift.abs_diff(from) <= 1, "{rate} Hz, sample {n}");
                }
            }
        }
        // A faster rate: the next interval is shorter.
        let mut stream = Stream::<f32>::new(256.0, 0.0).expect("valid");
        for sample in [1.0, 2.0, 3.0] {
            stream.push(sample).expect("finite");
        }
        stream.set_origin(512.0).expect("valid");
        assert_eq!(stream.acceleration(Instant::from_ticks(1 << 28)), 2.5);
        stream.push(4.0).expect("finite");
        assert_eq!(stream.known_until(), Instant::from_ticks(1 << 29));
    }

    #[test]
    fn bad_rates_and_samples_are_refused() {
        for sample in [1.1e6, -1e30] {
            assert_eq!(Stream::new(400.0, sample).err(), Some(StreamError::Sample), "{sample}");
        }
        for rate in [0.0, -1.0, f32::NAN, f32::INFINITY, 1.1e6, 1e-9] {
            assert_eq!(Stream::new(rate, 0.0).err(), Some(StreamError::Rate), "{rate}");
        }
        assert_eq!(Stream::new(400.0, f32::NAN).err(), Some(StreamError::Sample));
        let mut stream = Stream::new(400.0, 1.0_f32).expect("valid");
        let before = stream;
        assert_eq!(stream.push(f32::INFINITY), Err(StreamError::Sample));
        assert_eq!(stream.push(-1e30), Err(StreamError::Sample));
        assert_eq!(stream.restart(3, f32::NAN), Err(StreamError::Sample));
        assert_eq!(stream.set_origin(0.0), Err(StreamError::Rate));
        assert_eq!(stream, before);
    }
}
