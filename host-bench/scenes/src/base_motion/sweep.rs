//! A sine whose frequency changes, in local time.

use std::f64::consts::TAU;

use crate::scene_file::Sweep;

/// One way of a sweep from a local origin on.
#[derive(Debug, Clone)]
pub(super) struct LocalSweep {
    amplitude: f64,
    /// Phase in rad at the local origin.
    phase: f64,
    /// Angular frequency in rad/s at the local origin.
    frequency: f64,
    /// Rate of the frequency in rad/s², or of its logarithm in 1/s.
    rate: f64,
    logarithmic: bool,
    /// Seconds until the frequency turns.
    left: f64,
    highest: f64,
}

impl LocalSweep {
    pub(super) fn new(sweep: &Sweep, start: f64) -> Self {
        let Sweep { from_hz, to_hz, sweep_s, .. } = *sweep;
        // Rounding may place the time of a turn just before it.
        let number = (start / sweep_s + 1e-12).floor();
        let elapsed = (start - number * sweep_s).max(0.0);
        let turned = number.rem_euclid(2.0) == 1.0;
        let (first, last) = if turned { (to_hz, from_hz) } else { (from_hz, to_hz) };
        let rate = if sweep.logarithmic { (last / first).ln() / sweep_s } else { (last - first) / sweep_s };
        let whole = turns(from_hz, to_hz, sweep, sweep_s);
        let within = turns(first, last, sweep, elapsed);
        let frequency =
            if sweep.logarithmic { first * (rate * elapsed).exp() } else { first + rate * elapsed };
        Self {
            amplitude: sweep.amplitude_m_per_s2,
            phase: TAU * ((number * whole).fract() + within.fract()) + sweep.phase_rad,
            frequency: TAU * frequency,
            rate: if sweep.logarithmic { rate } else { TAU * rate },
            logarithmic: sweep.logarithmic,
            left: sweep_s - elapsed,
            highest: from_hz.max(to_hz),
        }
    }

    /// Acceleration in m/s² at local time `t` in s.
    pub(super) fn at(&self, t: f64) -> f64 {
        self.amplitude * self.turn(t)[0].sin()
    }

    /// Phase in rad and angular frequency in rad/s at local time `t` in s.
    fn turn(&self, t: f64) -> [f64; 2] {
        let Self { phase, frequency, rate, .. } = *self;
        if self.logarithmic {
            let grown = (rate * t).exp_m1();
            [phase + frequency / rate * grown, frequency * (1.0 + grown)]
        } else {
            [phase + t * (frequency + 0.5 * rate * t), frequency + rate * t]
        }
    }

    /// Coefficients of the powers of the time since the local time `t` in s.
    pub(super) fn taylor<const N: usize>(&self, t: f64) -> [f64; N] {
        let [phase, mut frequency] = self.turn(t);
        let (mut rates, mut sines, mut cosines) = ([0.0; N], [0.0; N], [0.0; N]);
        for (n, rate) in rates.iter_mut().enumerate() {
            *rate = frequency;
            let linear = if n == 0 { self.rate } else { 0.0 };
            frequency = if self.logarithmic { frequency * self.rate / (n + 1) as f64 } else { linear };
        }
        (sines[0], cosines[0]) = (self.amplitude * phase.sin(), self.amplitude * phase.cos());
        for n in 1..N {
            // Of the derivatives `φ' cos φ` and `−φ' sin φ`.
            let product = |of: &[f64; N]| (0..n).map(|k| rates[k] * of[n - 1 - k]).sum::<f64>() / n as f64;
            (sines[n], cosines[n]) = (product(&cosines), -product(&sines));
        }
        sines
    }

    pub(super) fn left(&self) -> f64 {
        self.left
    }

    /// Highest frequency of the sweep in Hz.
    pub(super) fn highest_frequency(&self) -> f64 {
        self.highest
    }
}

/// Turns after so many seconds of a way between two frequencies in Hz.
fn turns(first: f64, last: f64, sweep: &Sweep, seconds: f64) -> f64 {
    if sweep.logarithmic {
        let logarithm = (last / first).ln();
        first * sweep.sweep_s / logarithm * (logarithm * seconds / sweep.sweep_s).exp_m1()
    } else {
        seconds * (first + 0.5 * (last - first) * seconds / sweep.sweep_s)
    }
}
