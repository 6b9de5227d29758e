//! What shakes the base.

use std::sync::Arc;

use model_core::excitation::{ExcitationError, SpectralDensity, SpectralLine};

/// What shakes the base.
#[derive(Debug, Clone, PartialEq)]
pub enum Excitation {
    Sine(Tone),
    /// A sum of sines.
    Sines(Vec<Tone>),
    /// A recorded acceleration.
    File(Trace),
    /// Shocks of half a sine, or bursts of sines.
    Burst(Burst),
    /// A sine of changing frequency.
    Sweep(Sweep),
    /// A random acceleration with a spectral density.
    Random(Random),
    /// A base at rest.
    Silence,
}

impl Excitation {
    /// Frequency in Hz if the excitation is one sine that is not constant.
    pub fn single_frequency(&self) -> Option<f64> {
        match self {
            Self::Sine(tone) if tone.frequency_hz > 0.0 => Some(tone.frequency_hz),
            _ => None,
        }
    }

    /// The highest frequency in Hz of its sines; 0 of samples and at rest.
    pub fn highest_hz(&self) -> f64 {
        match self {
            Self::Sine(tone) => tone.frequency_hz,
            Self::Sines(tones) => tones.iter().map(|tone| tone.frequency_hz).fold(0.0, f64::max),
            Self::Burst(burst) => burst.frequency_hz(),
            Self::Sweep(sweep) => sweep.from_hz.max(sweep.to_hz),
            Self::Random(random) => random.density.last().map_or(0.0, |point| point[0]),
            Self::File(_) | Self::Silence => 0.0,
        }
    }

    /// The excitation with accelerations times `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        let larger = |tone: &Tone| Tone { amplitude_m_per_s2: tone.amplitude_m_per_s2 * factor, ..*tone };
        match self {
            Self::Sine(tone) => Self::Sine(larger(tone)),
            Self::Sines(tones) => Self::Sines(tones.iter().map(larger).collect()),
            Self::File(trace) => {
                let samples = trace.samples_m_per_s2.iter().map(|sample| sample * factor);
                Self::File(Trace { samples_m_per_s2: samples.collect(), ..trace.clone() })
            }
            Self::Burst(burst) => {
                Self::Burst(Burst { amplitude_m_per_s2: burst.amplitude_m_per_s2 * factor, ..*burst })
            }
            Self::Sweep(sweep) => {
                Self::Sweep(Sweep { amplitude_m_per_s2: sweep.amplitude_m_per_s2 * factor, ..*sweep })
            }
            Self::Random(random) => Self::Random(random.scaled(factor)),
            Self::Silence => Self::Silence,
        }
    }

    /// The random acceleration, if it is one.
    pub fn random(&self) -> Option<&Random> {
        if let Self::Random(random) = self { Some(random) } else { None }
    }

    /// Whether it is random or recorded: no period repeats.
    pub fn is_irregular(&self) -> bool {
        matches!(self, Self::File(_) | Self::Random(_))
    }

    /// Whether it is recorded, and not given by a few numbers.
    pub fn is_recorded(&self) -> bool {
        matches!(self, Self::File(_))
    }
}

/// One sine: `a(t) = amplitude · sin(2π · frequency · t + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Amplitude in m/s².
    pub amplitude_m_per_s2: f64,
    /// Frequency in Hz.
    pub frequency_hz: f64,
    /// Phase in rad.
    pub phase_rad: f64,
}

/// A recorded base acceleration: samples at a fixed rate, the first at time zero, joined by straight lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Samples in m/s², scale applied; at least two.
    pub samples_m_per_s2: Arc<[f64]>,
    /// Samples per second.
    pub rate_hz: f64,
    /// Whether it starts again one sample interval after its last sample; if not, it is at least as long as the run.
    pub repeat: bool,
    /// Where it is resampled to even times: how many samples lie between those of the recording, and in its gaps.
    pub resampled: Option<[usize; 2]>,
}

/// Whole half cycles of a sine, once or again and again; the base is at rest otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Burst {
    /// Amplitude in m/s²; a shock may have a negative one.
    pub amplitude_m_per_s2: f64,
    /// Half a sine, or whole cycles.
    pub shape: BurstShape,
    /// Start of the first in s.
    pub start_s: f64,
    /// Time in s from one start to the next; `None`: there is one only.
    pub period_s: Option<f64>,
}

/// What a burst consists of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BurstShape {
    HalfSine {
        /// Its length in s.
        duration_s: f64,
    },
    /// Cycles of a sine.
    Cycles {
        /// Frequency in Hz.
        frequency_hz: f64,
        /// Number of cycles.
        cycles: u32,
    },
}

impl Burst {
    /// Frequency of the sine in Hz.
    pub fn frequency_hz(&self) -> f64 {
        match self.shape {
            BurstShape::HalfSine { duration_s } => 0.5 / duration_s,
            BurstShape::Cycles { frequency_hz, .. } => frequency_hz,
        }
    }

    /// Length in s of one burst.
    pub fn length_s(&self) -> f64 {
        match self.shape {
            BurstShape::HalfSine { duration_s } => duration_s,
            BurstShape::Cycles { frequency_hz, cycles } => f64::from(cycles) / frequency_hz,
        }
    }
}

/// A sine whose frequency goes from one frequency to another, back, and so on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// Amplitude in m/s².
    pub amplitude_m_per_s2: f64,
    /// Frequency in Hz at time zero.
    pub from_hz: f64,
    /// Frequency in Hz at the other end.
    pub to_hz: f64,
    /// Time in s from one end to the other.
    pub sweep_s: f64,
    /// Whether the logarithm of the frequency, not the frequency, changes at a constant rate.
    pub logarithmic: bool,
    /// Phase in rad at time zero.
    pub phase_rad: f64,
}

/// A random acceleration with a spectral density.
#[derive(Debug, Clone, PartialEq)]
pub struct Random {
    /// Frequency in Hz and one-sided spectral density in (m/s²)²/Hz of each point.
    pub density: Vec<[f64; 2]>,
    /// Number of lines.
    pub lines: u32,
    /// The seed of frequencies and phases.
    pub seed: u64,
    /// The lines that the library draws in double precision.
    pub tones: Arc<[Tone]>,
}

impl Random {
    pub const MOST_LINES: usize = 4096;

    /// Draws the lines.
    ///
    /// # Errors
    /// A density or a number of lines that the library refuses.
    pub fn new(density: Vec<[f64; 2]>, lines: u32, seed: u64) -> Result<Self, ExcitationError> {
        let drawn = drawn(&density, lines, seed)?;
        let tone = |line: SpectralLine<f64>| Tone {
            amplitude_m_per_s2: line.amplitude,
            frequency_hz: line.frequency,
            phase_rad: line.phase,
        };
        let tones = drawn.lines().map(tone).collect();
        Ok(Self { density, lines, seed, tones })
    }

    /// Root mean square of the acceleration in m/s²: the root of the integral over the density.
    pub fn rms_m_per_s2(&self) -> f64 {
        let density = SpectralDensity::new(&self.density);
        density.map_or(f64::NAN, |density| density.mean_square().sqrt())
    }

    /// Distance of the lines in Hz near a frequency in Hz; `None` outside the band.
    pub fn spacing_hz(&self, frequency_hz: f64) -> Option<f64> {
        let ends = [self.density.first()?[0], self.density.last()?[0]];
        let drawn = drawn(&self.density, self.lines, self.seed).ok()?;
        (ends[0]..=ends[1]).contains(&frequency_hz).then(|| drawn.spacing(frequency_hz))
    }

    /// The same with another seed.
    ///
    /// # Errors
    /// None that [`Random::new`] did not return before.
    pub fn with_seed(&self, seed: u64) -> Result<Self, ExcitationError> {
        Self::new(self.density.clone(), self.lines, seed)
    }

    fn scaled(&self, factor: f64) -> Self {
        let tone = |tone: &Tone| Tone { amplitude_m_per_s2: tone.amplitude_m_per_s2 * factor, ..*tone };
        Self {
            density: self.density.iter().map(|[at, density]| [*at, density * factor * factor]).collect(),
            tones: self.tones.iter().map(tone).collect(),
            ..self.clone()
        }
    }
}

/// The library's random acceleration in double precision, on the heap: its capacity is that of the most lines.
fn drawn(
    density: &[[f64; 2]],
    lines: u32,
    seed: u64,
) -> Result<Box<model_core::excitation::Random<f64, { Random::MOST_LINES }>>, ExcitationError> {
    let density = SpectralDensity::new(density)?;
    model_core::excitation::Random::new(&density, lines, seed).map(Box::new)
}
