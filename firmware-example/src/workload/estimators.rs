//! The cost of an estimate: the estimator of each scene by sample.
//!
//! A step in the log of these workloads is a sample, so that instructions per step are instructions per sample.

use core::hint::black_box;

use model_core::clock::Instant;
use model_core::energy::Estimator;
use model_core::energy::estimator::{Interpolation, SampleFormat, Settings};
use model_core::excitation::{Excitation, Sine};
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::scene::bump_stop::{BumpStop, Stepper};
use model_core::scene::{Harvester, Simulation};

use super::bump_stop::{BEAM_MODES, LONG, ROD_MODES, SHORT};
use super::{Progress, Visit, Workload, bump_stop, contact_separation, show, sliding};

/// Metres per second squared in a raw count: a range of 4 g in 16 bits.
const SCALE: f32 = model_core::part::GRAVITY as f32 / 8192.0;
/// Most samples in a period of the sine.
const LONGEST: usize = 32;

/// The contact-separation scene at 0.2 g and 20 Hz, with impacts; 400 samples a second.
const CONTACT: Tone =
    Tone { name: "contact-separation", amplitude: 1.962, frequency: 20.0, period: 20, periods: 10 };
/// The sliding scene at 0.36 g and near 18.373 Hz; 367 samples a second.
const SLIDING: Tone = Tone { name: "sliding", amplitude: 3.5316, frequency: 18.373, period: 20, periods: 9 };
/// The bump-stop scene at 20 m/s² and 220 Hz; 3520 samples a second.
const BUMP_STOP: Tone =
    Tone { name: "bump-stop", amplitude: 20.0, frequency: 220.0, period: 16, periods: 22 };
/// Entries of each estimator in the log.
const ENTRIES: u32 = 4;

/// The estimators of the three scenes.
pub fn all(visit: Visit<'_>) -> Option<()> {
    let contact = black_box(contact_separation::whole()).build().ok()?;
    let slide = black_box(sliding::whole()).build().ok()?;
    let bump: BumpStop<f32, _, BEAM_MODES, ROD_MODES> =
        black_box(bump_stop::whole(bump_stop::GAP)).build().ok()?;

    let control = Adaptive::new(contact_separation::TOLERANCE).ok()?;
    show(visit, estimator(CONTACT, Simulation::new(contact, ExponentialRadau, control)))?;
    let control = Adaptive::new(sliding::TOLERANCE).ok()?;
    show(visit, estimator(SLIDING, Simulation::new(slide, ExponentialRadau, control)))?;
    show(visit, estimator(BUMP_STOP, Stepper::new(bump, black_box(SHORT), black_box(LONG)).ok()?))?;
    Some(())
}

/// A sine with a whole number of samples in a period.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tone {
    name: &'static str,
    /// Amplitude of the base acceleration in m/s².
    amplitude: f32,
    /// Frequency in Hz.
    frequency: f32,
    /// Samples in a period.
    period: u32,
    /// Periods from one entry of the log to the next.
    periods: u32,
}

impl Tone {
    /// Samples per second.
    fn rate(&self) -> f32 {
        self.frequency * self.period as f32
    }

    /// One period as raw counts.
    fn counts(&self) -> Option<[i16; LONGEST]> {
        // Turns of a unit frequency at so many samples a turn.
        let sine = Sine::<f32>::new(black_box(self.amplitude), 1.0, 0.0).ok()?;
        let mut counts = [0; LONGEST];
        for (place, count) in (0..self.period).zip(&mut counts) {
            let turn = place as f32 / self.period as f32;
            let rounded: f32 = sine.acceleration(Instant::from_seconds(turn)?) / SCALE;
            *count = rounded as i16;
        }
        Some(counts)
    }
}

/// An estimator that is fed a sine.
#[derive(Debug)]
struct Fed<H: Harvester<f32>> {
    tone: Tone,
    counts: [i16; LONGEST],
    estimator: Estimator<f32, H>,
    entries: u32,
    bits: [u32; 3],
}

#[inline(never)]
fn estimator<H: Harvester<f32>>(tone: Tone, harvester: H) -> Option<Fed<H>> {
    let settings = Settings {
        rate: black_box(tone.rate()),
        format: SampleFormat::counts(SCALE, i16::MAX.unsigned_abs()),
        longest_gap: 4,
        settling_seconds: 0.0,
        rate_tolerance: 0.0,
        jitter: 0.0,
        interpolation: Interpolation::Linear,
        bias_seconds: None,
    };
    let estimator = Estimator::new(harvester, settings).ok()?;
    Some(Fed { tone, counts: tone.counts()?, estimator, entries: 0, bits: [0; 3] })
}

impl<H: Harvester<f32>> Workload for Fed<H> {
    fn name(&self) -> &'static str {
        self.tone.name
    }

    fn advance(&mut self) -> Progress {
        if self.entries == ENTRIES {
            return Progress::Finished;
        }
        self.entries = self.entries.wrapping_add(1);
        for _ in 0..self.tone.periods {
            for (_, &count) in (0..self.tone.period).zip(&self.counts) {
                if self.estimator.push_count(count, u32::MAX).is_err() {
                    return Progress::Failed;
                }
            }
        }
        let estimate = self.estimator.estimate();
        let relative = estimate.uncertainty.relative.unwrap_or(f32::INFINITY);
        self.bits = [estimate.energy, estimate.mean_power, relative].map(f32::to_bits);
        let samples = self.tone.period.wrapping_mul(self.tone.periods);
        Progress::Sample { steps: samples, simulated_us: (1e6 * samples as f32 / self.tone.rate()) as u32 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
