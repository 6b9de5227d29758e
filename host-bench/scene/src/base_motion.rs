//! Base acceleration as a function of time, for the reference and the peers.

use std::f64::consts::TAU;

mod sweep;

use self::sweep::LocalSweep;
use crate::scene_file::{Burst, Excitation, Tone, Trace};

/// Knots in a period of the highest frequency where a cubic joins them. Its error is 4·10⁻⁶ of the amplitude.
const KNOTS: f64 = 32.0;

/// Base acceleration over the whole run.
#[derive(Debug, Clone, Copy)]
pub struct Base<'a>(pub &'a Excitation);

impl Base<'_> {
    /// The acceleration from `start` in s on, valid for the seconds of [`LocalBase::smooth_for`].
    pub fn from(&self, start: f64) -> LocalBase {
        match self.0 {
            Excitation::Silence => LocalBase::default(),
            Excitation::Sine(tone) => LocalBase::of_tones(std::slice::from_ref(tone), start),
            Excitation::Sines(tones) => LocalBase::of_tones(tones, start),
            Excitation::File(trace) => LocalBase::of_trace(trace, start),
            Excitation::Burst(burst) => LocalBase::of_burst(burst, start),
            Excitation::Sweep(sweep) => {
                let sweep = LocalSweep::new(sweep, start);
                LocalBase { smooth_for: sweep.left(), sweep: Some(sweep), ..LocalBase::default() }
            }
            Excitation::Random(random) => LocalBase::of_tones(&random.tones, start),
        }
    }

    /// As [`Base::from`], for a system that is linear in a few sines and a cubic: of many sines and of a sweep the cubic
    /// with their values and rates at the ends of a short stretch.
    pub fn pieces_from(&self, start: f64) -> LocalBase {
        match self.0 {
            Excitation::Random(_) | Excitation::Sweep(_) => self.from(start).cubic(),
            _ => self.from(start),
        }
    }
}

/// Base acceleration in a local time that starts at zero with a stretch of motion.
///
/// Local time keeps the rounding of absolute time out of the events.
#[derive(Debug, Clone)]
pub struct LocalBase {
    /// Amplitude in m/s², angular frequency in rad/s and phase in rad at the local origin of each sine.
    sines: Vec<[f64; 3]>,
    sweep: Option<LocalSweep>,
    /// Coefficients of the powers of local time.
    cubic: [f64; 4],
    is_cubic: bool,
    smooth_for: f64,
    highest_frequency: f64,
}

impl Default for LocalBase {
    fn default() -> Self {
        Self {
            sines: Vec::new(),
            sweep: None,
            cubic: [0.0; 4],
            is_cubic: false,
            smooth_for: f64::INFINITY,
            highest_frequency: 0.0,
        }
    }
}

impl LocalBase {
    fn of_tones(tones: &[Tone], start: f64) -> Self {
        let local = |tone: &Tone| {
            // Turns since time zero. The rounding of the product is added again, so that a long run keeps its
            // phase.
            let turns = tone.frequency_hz * start;
            let rest = tone.frequency_hz.mul_add(start, -turns);
            let phase = TAU * (turns.fract() + rest) + tone.phase_rad;
            [tone.amplitude_m_per_s2, TAU * tone.frequency_hz, phase]
        };
        let highest_frequency = tones.iter().fold(0.0, |highest, tone| f64::max(highest, tone.frequency_hz));
        Self { sines: tones.iter().map(local).collect(), highest_frequency, ..Self::default() }
    }

    fn of_burst(burst: &Burst, start: f64) -> Self {
        // Rounding may place the time of a corner just before it.
        let tiny = 4.0 * f64::EPSILON * start.max(burst.start_s);
        let since = start - burst.start_s;
        let sine = |amplitude_m_per_s2, elapsed, smooth_for| {
            let tone = Tone { amplitude_m_per_s2, frequency_hz: burst.frequency_hz(), phase_rad: 0.0 };
            Self { smooth_for, ..Self::of_tones(&[tone], elapsed) }
        };
        // Without an amplitude: the number of sines must not change within a run.
        let silence = |smooth_for| sine(0.0, 0.0, smooth_for);
        if since < -tiny {
            return silence(-since);
        }
        let number = burst.period_s.map_or(0.0, |period| ((since + tiny) / period).floor().max(0.0));
        let elapsed = since - number * burst.period_s.unwrap_or(0.0);
        let left = burst.length_s() - elapsed;
        if left <= tiny {
            return silence(burst.period_s.map_or(f64::INFINITY, |period| period - elapsed));
        }
        sine(burst.amplitude_m_per_s2, elapsed, left)
    }

    /// The cubic with the values and the rates at both ends of a short stretch.
    fn cubic(&self) -> Self {
        let span = self.smooth_for.min(1.0 / (KNOTS * self.highest_frequency()));
        let [[from, rate], [to, last_rate]] = [0.0, span].map(|t| [self.at(t), self.rate_at(t)]);
        let mean_rate = (to - from) / span;
        let square = (3.0 * mean_rate - 2.0 * rate - last_rate) / span;
        let cube = (rate + last_rate - 2.0 * mean_rate) / (span * span);
        Self {
            cubic: [from, rate, square, cube],
            is_cubic: true,
            smooth_for: span,
            highest_frequency: self.highest_frequency(),
            ..Self::default()
        }
    }

    fn of_trace(trace: &Trace, start: f64) -> Self {
        let count = trace.samples_m_per_s2.len();
        let position = start * trace.rate_hz;
        // Rounding may place the time of a sample just before it.
        let index = (position + 1e-6).floor();
        let wrapped = if trace.repeat { index % count as f64 } else { index };
        let left = wrapped as usize;
        let right = if trace.repeat { (left + 1) % count } else { left + 1 };
        let sample = |at: usize| trace.samples_m_per_s2.get(at).copied();
        match (sample(left), sample(right)) {
            (Some(from), Some(to)) => {
                let slope = (to - from) * trace.rate_hz;
                Self {
                    cubic: [from + (to - from) * (position - index), slope, 0.0, 0.0],
                    smooth_for: (index + 1.0) / trace.rate_hz - start,
                    ..Self::default()
                }
            }
            // The base is at rest from the last sample on.
            _ => Self::default(),
        }
    }

    /// Acceleration in m/s² at local time `t` in s.
    pub fn at(&self, t: f64) -> f64 {
        let sines = self.sines.iter();
        let sum: f64 =
            sines.map(|[amplitude, frequency, phase]| amplitude * (frequency * t + phase).sin()).sum();
        let [value, slope, square, cube] = self.cubic;
        let sweep = self.sweep.as_ref().map_or(0.0, |sweep| sweep.at(t)[0]);
        sum + sweep + value + t * (slope + t * (square + t * cube))
    }

    /// Its rate in m/s³.
    fn rate_at(&self, t: f64) -> f64 {
        let sines = self.sines.iter();
        let sum: f64 = sines
            .map(|[amplitude, frequency, phase]| amplitude * frequency * (frequency * t + phase).cos())
            .sum();
        let [_, slope, square, cube] = self.cubic;
        let sweep = self.sweep.as_ref().map_or(0.0, |sweep| sweep.at(t)[1]);
        sum + sweep + slope + t * (2.0 * square + t * 3.0 * cube)
    }

    /// Amplitude in m/s², angular frequency in rad/s and phase in rad at the local origin of each sine.
    pub fn sines(&self) -> &[[f64; 3]] {
        &self.sines
    }

    /// Whether the acceleration has a part besides the sines that is no straight line.
    pub fn is_cubic(&self) -> bool {
        self.is_cubic
    }

    /// The cubic that adds to the sines: coefficients of the powers of local time, in m/s² per power of a second.
    pub fn powers(&self) -> [f64; 4] {
        self.cubic
    }

    /// Seconds from the local origin to the next kink; infinite if there is none.
    pub fn smooth_for(&self) -> f64 {
        self.smooth_for
    }

    /// Highest frequency in Hz; 0 if the acceleration is a straight line.
    pub fn highest_frequency(&self) -> f64 {
        self.sweep.as_ref().map_or(self.highest_frequency, LocalSweep::highest_frequency)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::{BurstShape, Random, Sweep};

    fn trace(repeat: bool) -> Excitation {
        Excitation::File(Trace { samples_m_per_s2: [0.0, 1.0, -2.0, 0.5].into(), rate_hz: 4.0, repeat })
    }

    #[test]
    fn a_trace_is_joined_by_lines_and_ends_or_repeats() {
        for (repeat, time, expected) in [
            (false, 0.125, 0.5),
            (false, 0.25, 1.0),
            (false, 0.375, -0.5),
            (false, 0.75, 0.0),
            (false, 9.0, 0.0),
            (true, 0.75, 0.5),
            (true, 0.875, 0.25),
            (true, 101.375, -0.5),
        ] {
            let excitation = trace(repeat);
            let here = Base(&excitation).from(time);
            assert!((here.at(0.0) - expected).abs() < 1e-12, "{repeat} {time}");
        }
        let excitation = trace(true);
        let here = Base(&excitation).from(0.3);
        assert!((here.smooth_for() - 0.2).abs() < 1e-15);
        assert!((here.at(0.1) - here.at(0.0) + 1.2).abs() < 1e-12);
    }

    #[test]
    fn bursts_end_and_begin_again() {
        let shape = BurstShape::Cycles { frequency_hz: 50.0, cycles: 2 };
        let burst = Burst { amplitude_m_per_s2: 3.0, shape, start_s: 0.1, period_s: Some(0.25) };
        let excitation = Excitation::Burst(burst);
        for (time, expected, left) in [
            (0.0, 0.0, 0.1),
            (0.1, 0.0, 0.04),
            (0.105, 3.0, 0.035),
            (0.14, 0.0, 0.21),
            (0.2, 0.0, 0.15),
            (0.35, 0.0, 0.04),
            (25.105, 3.0, 0.035),
        ] {
            let here = Base(&excitation).from(time);
            assert!((here.at(0.0) - expected).abs() < 1e-11, "{time}");
            assert!((here.smooth_for() - left).abs() < 1e-12, "{time}: {}", here.smooth_for());
        }
        let shape = BurstShape::HalfSine { duration_s: 0.01 };
        let shock = Burst { amplitude_m_per_s2: 3.0, shape, start_s: 0.0, period_s: None };
        let excitation = Excitation::Burst(shock);
        assert!((Base(&excitation).from(0.0).at(0.005) - 3.0).abs() < 1e-14);
        let after = Base(&excitation).from(0.02);
        assert_eq!((after.at(0.3), after.smooth_for()), (0.0, f64::INFINITY));
    }

    #[test]
    fn cubics_join_many_sines_and_sweeps() {
        let random = Random::new(vec![[10.0, 1.0], [200.0, 0.1]], 64, 3).expect("valid");
        let rms = random.rms_m_per_s2();
        let sweep = |logarithmic, [from_hz, to_hz]: [f64; 2]| {
            let sweep_s = 3.0;
            Excitation::Sweep(Sweep {
                amplitude_m_per_s2: 2.0,
                from_hz,
                to_hz,
                sweep_s,
                logarithmic,
                phase_rad: 0.3,
            })
        };
        for (excitation, size) in [
            (Excitation::Random(random), rms),
            (sweep(true, [5.0, 90.0]), 2.0),
            (sweep(false, [90.0, 5.0]), 2.0),
        ] {
            let base = Base(&excitation);
            for k in 0..200 {
                let start = f64::from(k) * 0.041;
                let (exact, piece) = (base.from(start), base.pieces_from(start));
                for part in [0.0, 0.25, 0.5, 1.0] {
                    let t = part * piece.smooth_for();
                    assert!((piece.at(t) - exact.at(t)).abs() < 1.2e-5 * size, "{k} {part}");
                }
                // The same instant from another origin.
                let late = base.from(start + 0.001);
                let within = exact.smooth_for() > 0.002;
                assert!(!within || (late.at(0.001) - exact.at(0.002)).abs() < 1e-9 * size, "{k}");
            }
        }
    }

    #[test]
    fn tones_keep_their_phase_over_a_day() {
        let excitation =
            Excitation::Sine(Tone { amplitude_m_per_s2: 2.0, frequency_hz: 20.3, phase_rad: 0.5 });
        // 86 400 s are a whole number of periods of 20.3 Hz.
        let late = Base(&excitation).from(86_400.0);
        let early = Base(&excitation).from(0.0);
        for t in [0.0, 0.01, 0.02] {
            assert!((late.at(t) - early.at(t)).abs() < 1e-9);
        }
    }
}
