//! Base acceleration as a function of time, for the reference and the peers.

use std::f64::consts::TAU;

use crate::scene_file::{Excitation, Tone, Trace};

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
    value: f64,
    slope: f64,
    smooth_for: f64,
}

impl Default for LocalBase {
    fn default() -> Self {
        Self { sines: Vec::new(), value: 0.0, slope: 0.0, smooth_for: f64::INFINITY }
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
        Self { sines: tones.iter().map(local).collect(), ..Self::default() }
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
                    value: from + (to - from) * (position - index),
                    slope,
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
        sum + self.value + self.slope * t
    }

    /// Amplitude in m/s², angular frequency in rad/s and phase in rad at the local origin of each sine.
    pub fn sines(&self) -> &[[f64; 3]] {
        &self.sines
    }

    /// The straight line that adds to the sines: value in m/s² at the local origin, and slope in m/s³.
    pub fn line(&self) -> [f64; 2] {
        [self.value, self.slope]
    }

    /// Seconds from the local origin to the next kink; infinite if there is none.
    pub fn smooth_for(&self) -> f64 {
        self.smooth_for
    }

    /// Highest frequency in Hz; 0 if the acceleration is a straight line.
    pub fn highest_frequency(&self) -> f64 {
        self.sines.iter().fold(0.0, |highest, [_, frequency, _]| f64::max(highest, frequency / TAU))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
