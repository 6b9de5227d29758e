//! Estimates amplitude and frequency of the strongest sine in an accelerometer's samples, with two
//! multiplications a sample: the input of a closed-form estimate of the harvested power.
//!
//! The samples are taken in windows. A first frequency follows from the interpolated upward zero crossings of
//! a window, with a hysteresis against noise. The recursion of Goertzel,
//!
//! ```text
//! s_n = x_n + 2 cos(ω) s_{n−1} − s_{n−2},
//! ```
//!
//! at that frequency gives the amplitude of the sine and its phase in the middle of the window (G. Goertzel,
//! Amer. Math. Monthly 65, 1958). The difference of the phases of two successive windows corrects the
//! frequency. Other sines shift zero crossings by per cents, but the phase much less. The mean of one window,
//! mostly gravity, is subtracted from the samples of the next.

use super::{ExcitationError, is_acceleration};
use crate::clock::{Frequency, Instant};
use crate::scalar::{Mathematics, Scalar, arcsine};
use crate::snapshot::{Configuration, Fingerprint, snapshot_fields};

/// A sample must be below zero by this part of the RMS acceleration before the next upward crossing counts.
const HYSTERESIS: f64 = 0.5;
/// Most samples in a window.
const MOST_SAMPLES: u32 = 1 << 12;

/// The strongest sine of one window.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SpectralPeak<S> {
    /// Amplitude in m/s².
    pub amplitude: S,
    /// Frequency in Hz.
    pub frequency: S,
    /// The share of the sine in the mean square of the signal, 0 to 1; near 1 for a pure sine.
    pub purity: S,
}

/// Finds the strongest sine of each window of samples, at a fixed rate and window length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToneMeter<S> {
    samples_per_second: S,
    per_window: S,
    window: u32,
}

/// The state of a [`ToneMeter`] between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ToneMeterState<S> {
    /// Number of samples of this window so far.
    count: u32,
    /// Mean of the previous window, in m/s².
    offset: S,
    /// Sum over this window of the samples less the offset.
    sum: S,
    /// Sum over this window of the squares of the samples less the offset.
    squares: S,
    /// A sample below minus this threshold in m/s² arms the next upward crossing.
    hysteresis: S,
    /// Whether the next upward crossing counts.
    armed: bool,
    /// The last sample less the offset.
    last: S,
    /// Position of the first upward crossing, in samples from the start of the window.
    first_crossing: S,
    /// Position of the last upward crossing.
    last_crossing: S,
    /// Number of upward crossings.
    crossings: u32,
    /// Frequency of the recursion in Hz; 0 if unknown.
    frequency: S,
    /// Cosine and sine of the phase of that frequency per sample.
    per_sample: [S; 2],
    /// `s_n` and `s_{n−1}` of the recursion.
    sums: [S; 2],
    /// Complex amplitude in the middle of the previous window, times half its length; 0 if there was none.
    before: [S; 2],
    /// Whether `offset` is the mean of a whole window.
    offset_known: bool,
}

impl<S: Scalar> ToneMeterState<S> {
    /// Whether all numbers have magnitudes that samples, rates and windows within their bounds can give, so that all
    /// later ones are finite in `f32`.
    fn is_bounded(&self) -> bool {
        let within =
            |numbers: &[S], largest: f64| numbers.iter().all(|number| number.abs() <= S::from_f64(largest));
        // The deviation of a sample from the offset is at most 2·10⁶ m/s², here 10⁷; a window has 4096 samples.
        let signal = within(&[self.offset, self.hysteresis, self.last], 1e7)
            && within(&[self.sum], 1e11)
            && within(&[self.squares], 1e18);
        // A sum of the recursion grows with the square of the window at a low frequency.
        let recursion =
            within(&self.sums, 1e15) && within(&self.before, 1e15) && within(&self.per_sample, 1.01);
        // Two upward crossings are more than a sample apart.
        let crossings = within(&[self.first_crossing, self.last_crossing], f64::from(MOST_SAMPLES));
        let apart = self.last_crossing - self.first_crossing;
        let spaced = self.crossings < 2 || apart >= S::from_f64(0.5) * S::from_u32(self.crossings - 1);
        let frequency = self.frequency >= S::ZERO && self.frequency <= S::from_f64(1e6);
        signal && recursion && crossings && spaced && frequency
    }
}

impl<S: Scalar> ToneMeter<S> {
    /// A meter for `rate` samples per second, 1 to 10⁵, in windows of `window` samples, 16 to 4096.
    ///
    /// A sine is found if a window holds two of its periods and a period holds three samples.
    ///
    /// # Errors
    /// A rate or a window outside its bounds.
    pub fn new(rate: S, window: u32) -> Result<Self, ExcitationError> {
        let in_bounds = rate >= S::ONE && rate <= S::from_f64(1e5);
        if !in_bounds {
            return Err(ExcitationError::Frequency);
        }
        if !(16..=MOST_SAMPLES).contains(&window) {
            return Err(ExcitationError::TooFewSamples);
        }
        Ok(Self { samples_per_second: rate, per_window: S::ONE / S::from_u32(window), window })
    }

    /// The state before the first sample.
    #[must_use]
    pub fn start(&self) -> ToneMeterState<S> {
        ToneMeterState::default()
    }

    /// Takes a sample in m/s². From the third window on, the last sample of a window returns the strongest
    /// sine, if there is one. A sample that is not finite, or above [`LARGEST_SAMPLE`](super::LARGEST_SAMPLE) in
    /// magnitude, counts as the sample before it.
    #[inline]
    pub fn push<M: Mathematics<S>>(
        &self,
        state: &mut ToneMeterState<S>,
        sample: S,
    ) -> Option<SpectralPeak<S>> {
        let value = if is_acceleration(sample) { sample - state.offset } else { state.last };
        state.sum += value;
        state.squares += value * value;
        let [previous, before] = state.sums;
        let turned = state.per_sample[0] * previous;
        state.sums = [value + (turned + turned) - before, previous];
        if value < -state.hysteresis {
            state.armed = true;
        } else if state.armed && value >= S::ZERO {
            // Linear interpolation; the previous sample may be above zero too.
            let back = if state.last < S::ZERO { value / (value - state.last) } else { S::ZERO };
            let place = S::from_u32(state.count) - back;
            if state.crossings == 0 {
                state.first_crossing = place;
            }
            state.last_crossing = place;
            state.crossings += 1;
            state.armed = false;
        }
        state.last = value;
        state.count += 1;
        if state.count < self.window { None } else { self.close::<M>(state) }
    }

    /// Ends a window: returns its strongest sine, and prepares the state of the next window.
    #[cold]
    #[inline(never)]
    fn close<M: Mathematics<S>>(&self, state: &mut ToneMeterState<S>) -> Option<SpectralPeak<S>> {
        let mean = state.sum * self.per_window;
        let variance = (state.squares * self.per_window - mean * mean).max(S::ZERO);
        // y = s_{N−1} − e^(−jω) s_{N−2} = Σ x_n e^(jω(N−1−n)). Rotated back by half a window, y has the phase
        // of the sine in the middle of the window even if ω is slightly off, and the magnitude A N/2.
        let [last, previous] = state.sums;
        let [cosine, sine] = state.per_sample;
        let raw = [last - cosine * previous, sine * previous];
        let half_window = self.phase_after::<M>(S::from_f64(0.5) * state.frequency, self.window - 1);
        let middle = turned_back(raw, half_window);
        let square = middle[0] * middle[0] + middle[1] * middle[1];
        let amplitude = S::from_f64(2.0) * square.sqrt() * self.per_window;
        let peak = (state.frequency > S::ZERO && variance > S::ZERO).then(|| SpectralPeak {
            amplitude,
            frequency: state.frequency,
            purity: (S::from_f64(0.5) * amplitude * amplitude / variance).min(S::ONE),
        });
        let frequency = self.next_frequency::<M>(state, middle, square);
        *state = ToneMeterState {
            offset: state.offset + mean,
            hysteresis: S::from_f64(HYSTERESIS) * variance.sqrt(),
            // The last sample less the offset of the next window.
            last: state.last - mean,
            frequency,
            per_sample: self.phase_after::<M>(frequency, 1),
            before: if peak.is_some() { middle } else { [S::ZERO; 2] },
            offset_known: true,
            ..self.start()
        };
        peak
    }

    /// The frequency in Hz for the next window, from the complex amplitude in the middle of this one and the
    /// square of its magnitude.
    fn next_frequency<M: Mathematics<S>>(&self, state: &ToneMeterState<S>, middle: [S; 2], square: S) -> S {
        if !state.offset_known {
            return S::ZERO;
        }
        let between = state.last_crossing - state.first_crossing;
        if state.crossings < 2 || !(between > S::ZERO) {
            return S::ZERO;
        }
        let crossing = S::from_u32(state.crossings - 1) / between * self.samples_per_second;
        // The rotation of the phase since the previous window, less the rotation that the frequency predicts.
        let predicted = turned_back(middle, self.phase_after::<M>(state.frequency, self.window));
        let [ahead, across] = turned_back(predicted, state.before);
        let [real, imaginary] = state.before;
        let magnitudes = (square * (real * real + imaginary * imaginary)).sqrt();
        let turns_per_window = S::from_f64(0.5 * core::f64::consts::FRAC_1_PI) * arcsine(across / magnitudes);
        let windows_per_second = self.samples_per_second * self.per_window;
        let corrected = state.frequency + turns_per_window * windows_per_second;
        // At a phase difference of more than a quarter of a turn the zero crossings are more reliable.
        let off = (corrected - crossing).abs();
        let locked = ahead > S::ZERO && off < windows_per_second;
        if locked && corrected > S::ZERO { corrected } else { crossing }
    }

    /// Cosine and sine of the phase of `frequency`, in Hz, after `samples` samples.
    fn phase_after<M: Mathematics<S>>(&self, frequency: S, samples: u32) -> [S; 2] {
        let phase = Frequency::from_hertz(frequency)
            .zip(Instant::from_seconds(S::from_u32(samples) / self.samples_per_second))
            .map_or(0, |(frequency, at)| frequency.phase(at));
        [M::sine_of_turns(phase.wrapping_add(1 << 62)), M::sine_of_turns(phase)]
    }
}

snapshot_fields!(impl [S: Scalar] ToneMeterState<S> {
    count, offset, sum, squares, hysteresis, armed, last, first_crossing, last_crossing, crossings, frequency,
    per_sample, sums, before, offset_known,
} if |state| state.count < MOST_SAMPLES && state.crossings <= state.count && state.is_bounded());

impl<S: Scalar> Configuration for ToneMeter<S> {
    type State = ToneMeterState<S>;

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("tone meter");
        fingerprint.numbers(&[self.samples_per_second]);
        fingerprint.count(self.window);
    }
}

/// The product of one complex number with the conjugate of another.
fn turned_back<S: Scalar>([a, b]: [S; 2], [c, d]: [S; 2]) -> [S; 2] {
    [a * c + b * d, b * c - a * d]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Polynomial;

    fn peaks(rate: f64, window: u32, signal: impl Fn(f64) -> f64) -> Vec<SpectralPeak<f32>> {
        let meter = ToneMeter::<f32>::new(rate as f32, window).expect("in bounds");
        let mut state = meter.start();
        let count = 8 * window;
        (0..count)
            .filter_map(|k| meter.push::<Polynomial>(&mut state, signal(f64::from(k) / rate) as f32))
            .collect()
    }

    #[test]
    fn a_sine_on_gravity_is_found_to_its_leakage() {
        for (frequency, amplitude) in [(5.3, 0.4), (20.0, 1.962), (37.77, 12.0), (120.9, 0.05)] {
            let found = peaks(400.0, 400, |t| 9.81 + amplitude * (TAU * frequency * t + 0.3).sin());
            assert_eq!(found.len(), 6);
            for peak in &found {
                // The other sideband leaks at most 1/(2π f T) into the peak.
                let leak = 1.0 / (std::f64::consts::TAU * frequency);
                let close = |a: f32, b: f64, part: f64| ((f64::from(a) / b) - 1.0).abs() < part;
                assert!(close(peak.amplitude, amplitude, 1.2 * leak + 2e-3), "{frequency} {peak:?}");
                assert!(close(peak.frequency, frequency, 3e-3), "{frequency} {peak:?}");
                assert!(peak.purity > 0.9, "{frequency} {peak:?}");
            }
            let last = found.last().map_or(f32::NAN, |peak| peak.frequency);
            let leak = 1.0 / (TAU * frequency);
            assert!((f64::from(last) / frequency - 1.0).abs() < 0.03 * leak + 5e-5, "{frequency} {last}");
        }
    }

    const TAU: f64 = std::f64::consts::TAU;

    #[test]
    fn the_strongest_of_two_sines_is_found_and_is_not_taken_as_pure() {
        let found = peaks(400.0, 400, |t| 2.0 * (TAU * 20.05 * t).sin() + 1.0 * (TAU * 61.3 * t + 1.0).sin());
        // The first frequency comes from the crossings, which the other sine shifts; two windows later it
        // comes from the phase.
        assert!((found[0].frequency - 20.05).abs() < 0.2, "{found:?}");
        for peak in &found[2..] {
            assert!((peak.frequency - 20.05).abs() < 0.01, "{peak:?}");
            assert!((peak.amplitude / 2.0 - 1.0).abs() < 0.02, "{peak:?}");
            // 2²/(2² + 1²).
            assert!((peak.purity - 0.8).abs() < 0.05, "{peak:?}");
        }
    }

    #[test]
    fn silence_has_no_peak_and_a_gap_does_no_harm() {
        assert!(peaks(400.0, 400, |_| 9.81).is_empty());
        let found =
            peaks(400.0, 400, |t| if (t * 400.0) as u32 == 1000 { f64::NAN } else { (TAU * 20.0 * t).sin() });
        assert!(found.iter().all(|peak| (peak.amplitude - 1.0).abs() < 0.03), "{found:?}");
    }

    #[test]
    fn rates_and_windows_out_of_bounds_are_refused() {
        assert_eq!(ToneMeter::<f32>::new(0.0, 400).err(), Some(ExcitationError::Frequency));
        assert_eq!(ToneMeter::<f32>::new(f32::NAN, 400).err(), Some(ExcitationError::Frequency));
        assert_eq!(ToneMeter::<f32>::new(400.0, 15).err(), Some(ExcitationError::TooFewSamples));
        assert_eq!(ToneMeter::<f32>::new(400.0, 4097).err(), Some(ExcitationError::TooFewSamples));
    }
}
