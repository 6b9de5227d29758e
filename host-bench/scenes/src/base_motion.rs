//! Base acceleration as a function of time, for the reference and the peers.

use std::cell::Cell;
use std::f64::consts::TAU;

mod sweep;

use self::sweep::LocalSweep;
use crate::scene_file::{Burst, Excitation, Tone, Trace};

/// Pieces in a period of the highest frequency, in each of which a Taylor polynomial about its middle stands for many sines
/// or a sweep. Its error is 3·10⁻¹⁴ of the amplitude.
const PIECES: f64 = 8.0;
/// Coefficients of the polynomial.
const POWERS: usize = 12;

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
            Excitation::Random(random) => {
                let sum = LocalBase::of_tones(&random.tones, start);
                LocalBase { in_pieces: true, ..sum }
            }
        }
    }

    /// As [`Base::from`], for a system that is linear in a few sines and a polynomial: of many sines and of a sweep the
    /// polynomial of a short stretch.
    pub fn pieces_from(&self, start: f64) -> LocalBase {
        match self.0 {
            Excitation::Random(_) | Excitation::Sweep(_) => self.from(start).polynomial(),
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
    /// Whether the sines are added up for each piece of local time, not for each time.
    in_pieces: bool,
    /// Numbers and coefficients of the last even and odd piece.
    pieces: [Cell<(f64, [f64; POWERS])>; 2],
    /// Coefficients of the powers of local time.
    powers: Vec<f64>,
    smooth_for: f64,
    highest_frequency: f64,
}

impl Default for LocalBase {
    fn default() -> Self {
        Self {
            sines: Vec::new(),
            sweep: None,
            in_pieces: false,
            pieces: [const { Cell::new((f64::NAN, [0.0; POWERS])) }; 2],
            powers: vec![0.0; 2],
            smooth_for: f64::INFINITY,
            highest_frequency: 0.0,
        }
    }
}

impl LocalBase {
    fn of_tones(tones: &[Tone], start: f64) -> Self {
        let local = |tone: &Tone| {
            // Turns since time zero. The rounding of the product is added again, so that a long run keeps its phase.
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

    fn polynomial(&self) -> Self {
        let span = self.smooth_for.min(self.piece_s());
        Self {
            powers: self.taylor(0.0, span).to_vec(),
            smooth_for: span,
            highest_frequency: self.highest_frequency(),
            ..Self::default()
        }
    }

    /// Length in s of a piece.
    fn piece_s(&self) -> f64 {
        1.0 / (PIECES * self.highest_frequency())
    }

    /// Coefficients of the powers of the time since `from`, by the Taylor polynomial half a span later.
    fn taylor(&self, from: f64, span: f64) -> [f64; POWERS] {
        let middle = from + 0.5 * span;
        let mut powers = self.sweep.as_ref().map_or([0.0; POWERS], |sweep| sweep.taylor(middle));
        for [amplitude, frequency, phase] in &self.sines {
            let (sine, cosine) = (frequency * middle + phase).sin_cos();
            let (mut value, mut slope) = (amplitude * sine, amplitude * cosine);
            for (n, power) in powers.iter_mut().enumerate() {
                *power += value;
                let turn = frequency / (n + 1) as f64;
                (value, slope) = (turn * slope, -turn * value);
            }
        }
        for first in 0..POWERS {
            for n in (first..POWERS - 1).rev() {
                powers[n] -= 0.5 * span * powers[n + 1];
            }
        }
        powers
    }

    fn in_piece(&self, t: f64) -> f64 {
        let span = self.piece_s();
        let number = (t / span).floor();
        let from = number * span;
        let piece = &self.pieces[usize::from(number.rem_euclid(2.0) == 1.0)];
        if piece.get().0 != number {
            piece.set((number, self.taylor(from, span)));
        }
        horner(&piece.get().1, t - from)
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
                    powers: vec![from + (to - from) * (position - index), slope],
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
        if self.in_pieces {
            return self.in_piece(t);
        }
        let sines = self.sines.iter();
        let sum: f64 =
            sines.map(|[amplitude, frequency, phase]| amplitude * (frequency * t + phase).sin()).sum();
        sum + self.sweep.as_ref().map_or(0.0, |sweep| sweep.at(t)) + horner(&self.powers, t)
    }

    /// Amplitude in m/s², angular frequency in rad/s and phase in rad at the local origin of each sine.
    pub fn sines(&self) -> &[[f64; 3]] {
        &self.sines
    }

    /// The polynomial that adds to the sines: coefficients of the powers of local time, as many in the whole run.
    pub fn powers(&self) -> &[f64] {
        &self.powers
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

fn horner(powers: &[f64], t: f64) -> f64 {
    powers.iter().rev().fold(0.0, |sum, power| sum * t + power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::{BurstShape, Random, Sweep};

    fn trace(repeat: bool) -> Excitation {
        let samples_m_per_s2 = [0.0, 1.0, -2.0, 0.5].into();
        Excitation::File(Trace { samples_m_per_s2, rate_hz: 4.0, repeat, resampled: None })
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
    fn polynomials_follow_many_sines_and_sweeps() {
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
                let (given, piece) = (base.from(start), base.pieces_from(start));
                let exact = LocalBase { in_pieces: false, ..given.clone() };
                for part in [0.0, 0.25, 0.5, 1.0] {
                    let t = part * piece.smooth_for();
                    assert!((piece.at(t) - exact.at(t)).abs() < 1e-12 * size, "{k} {part}");
                }
                assert!((given.at(0.37) - exact.at(0.37)).abs() < 1e-12 * size, "{k}");
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
