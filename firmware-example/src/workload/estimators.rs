//! What an estimate costs for each sample of an accelerometer, scene by scene.
//!
//! Here a step of the log is a *sample*, so that instructions per step are instructions per sample; in the two
//! closed forms, which need no samples, it is a call.

use core::hint::black_box;

use model_core::energy::Estimator;
use model_core::energy::estimator::{SampleFormat, Settings};
use model_core::excitation::{Excitation, Sine, ToneMeter, ToneMeterState};
use model_core::integrate::{Adaptive, FixedStep, RungeKutta4, TrBdf2};
use model_core::scalar::Polynomial;
use model_core::scene::bump_stop::Stepper;
use model_core::scene::closed_form::ClosedForm;
use model_core::scene::{Harvester, Simulation, contact_separation, sliding};

use super::bump_stop::parts as bump_stop_parts;
use super::bump_stop::scenes as bump_stop_scenes;
use super::contact_separation::{parts as contact_parts, scenes as contact_scenes};
use super::sliding::{parts as sliding_parts, scenes as sliding_scenes};
use super::{Progress, Workload};

/// Metres per second squared in a raw count: a range of 4 g in 16 bits.
const SCALE: f32 = 9.81 / 8192.0;
/// Most samples in a period of the sine that is played.
const LONGEST: usize = 32;

/// What is played: a sine with a whole number of samples in a period.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Played {
    name: &'static str,
    amplitude: f32,
    frequency: f32,
    /// Samples in a period.
    period: u32,
    /// Periods from one entry of the log to the next, and how many entries there are.
    periods: u32,
    entries: u32,
}

impl Played {
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
            let at = model_core::clock::Instant::from_seconds(turn)?;
            let rounded: f32 = sine.acceleration(at) / SCALE;
            *count = rounded as i16;
        }
        Some(counts)
    }

    fn progress(&self) -> Progress {
        let samples = self.period * self.periods;
        Progress::Sample { steps: samples, simulated_us: (1e6 * samples as f32 / self.rate()) as u32 }
    }
}

/// An estimator that is fed a sine.
#[derive(Debug)]
struct Fed<H: Harvester<f32>> {
    played: Played,
    counts: [i16; LONGEST],
    estimator: Estimator<f32, H>,
    entries: u32,
    bits: [u32; 3],
}

impl<H: Harvester<f32>> Fed<H> {
    fn new(played: Played, harvester: H) -> Option<Self> {
        let settings = Settings {
            rate: black_box(played.rate()),
            format: SampleFormat::counts(SCALE, i16::MAX.unsigned_abs()),
            longest_gap: 4,
            settling_seconds: 0.0,
        };
        let estimator = Estimator::new(harvester, settings).ok()?;
        Some(Self { counts: played.counts()?, played, estimator, entries: 0, bits: [0; 3] })
    }
}

impl<H: Harvester<f32>> Workload for Fed<H> {
    fn name(&self) -> &'static str {
        self.played.name
    }

    fn advance(&mut self) -> Progress {
        if self.entries == self.played.entries {
            return Progress::Finished;
        }
        self.entries += 1;
        for _ in 0..self.played.periods {
            for (_, &count) in (0..self.played.period).zip(&self.counts) {
                if self.estimator.push_count(count, u32::MAX).is_err() {
                    return Progress::Failed;
                }
            }
        }
        let estimate = self.estimator.estimate();
        self.bits = [estimate.energy, estimate.mean_power, estimate.uncertainty.relative].map(f32::to_bits);
        self.played.progress()
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}

/// A tone meter that is fed a sine.
#[derive(Debug)]
struct Heard {
    played: Played,
    counts: [i16; LONGEST],
    meter: ToneMeter<f32>,
    tone: ToneMeterState<f32>,
    entries: u32,
    bits: [u32; 3],
}

impl Workload for Heard {
    fn name(&self) -> &'static str {
        self.played.name
    }

    fn advance(&mut self) -> Progress {
        if self.entries == self.played.entries {
            return Progress::Finished;
        }
        self.entries += 1;
        for _ in 0..self.played.periods {
            for (_, &count) in (0..self.played.period).zip(&self.counts) {
                if let Some(line) = self.meter.push::<Polynomial>(&mut self.tone, SCALE * f32::from(count)) {
                    self.bits = [line.amplitude, line.frequency, line.purity].map(f32::to_bits);
                }
            }
        }
        self.played.progress()
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}

/// A closed form, called at several frequencies.
struct Called<F> {
    name: &'static str,
    form: F,
    amplitude: f32,
    frequencies: [f32; 4],
    calls: u32,
    bits: [u32; 3],
}

impl<F: Fn(f32, f32) -> ClosedForm<f32>> Workload for Called<F> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn advance(&mut self) -> Progress {
        let Some(&frequency) = self.frequencies.get(self.calls as usize) else { return Progress::Finished };
        self.calls += 1;
        let found = (self.form)(black_box(self.amplitude), black_box(frequency));
        let held = if found.validity.holds() { 1 } else { 0 };
        self.bits = [found.mean_power.to_bits(), found.amplitude.to_bits(), held];
        // As once a second.
        Progress::Sample { steps: 1, simulated_us: 1_000_000 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}

/// The contact-separation scene at 0.2 g and 20 Hz, with impacts; 400 samples a second.
const CONTACT: Played = Played {
    name: "contact-separation",
    amplitude: 1.962,
    frequency: 20.0,
    period: 20,
    periods: 10,
    entries: 4,
};
/// The sliding scene at 0.36 g and near 18.373 Hz; 367 samples a second.
const SLIDING: Played =
    Played { name: "sliding", amplitude: 3.5316, frequency: 18.373, period: 20, periods: 9, entries: 4 };
/// The bump-stop scene at 20 m/s² and 220 Hz; 3520 samples a second.
const BUMP_STOP: Played =
    Played { name: "bump-stop", amplitude: 20.0, frequency: 220.0, period: 16, periods: 22, entries: 4 };
/// What a closed form needs of the samples: the strongest line.
const TONE: Played = Played { name: "strongest-line", periods: 20, ..CONTACT };

/// Gives `work` the estimators and the closed forms of all scenes; `None` if one is refused.
pub fn with_all<R>(work: impl FnOnce(Option<&mut [&mut dyn Workload]>) -> R) -> R {
    let Some((contact, slide, bump)) = scenes() else { return work(None) };
    let meter = ToneMeter::new(black_box(TONE.rate()), TONE.period * TONE.periods).ok();
    let steps = (
        Adaptive::new(contact_scenes::TOLERANCE),
        FixedStep::of_seconds(black_box(sliding_scenes::STEP)),
        Stepper::new(bump, black_box(bump_stop_scenes::SHORT), black_box(bump_stop_scenes::LONG)),
    );
    let (Ok(tolerance), Ok(step), Ok(stepper)) = steps else { return work(None) };
    let estimators = (
        Fed::new(CONTACT, Simulation::new(contact, TrBdf2, tolerance)),
        Fed::new(SLIDING, Simulation::new(slide, RungeKutta4, step)),
        Fed::new(BUMP_STOP, stepper),
    );
    let (Some(counts), Some(meter), (Some(mut a), Some(mut b), Some(mut c))) =
        (TONE.counts(), meter, estimators)
    else {
        return work(None);
    };
    let mut heard = Heard { played: TONE, counts, tone: meter.start(), meter, entries: 0, bits: [0; 3] };
    let called = |name, amplitude, frequencies| (name, amplitude, frequencies);
    let (name, amplitude, frequencies) =
        called("closed form, contact-separation", 0.5, [17.0, 19.0, 21.0, 23.0]);
    let mut of_contact = Called {
        name,
        form: |a: f32, f: f32| contact.closed_form(a, f),
        amplitude,
        frequencies,
        calls: 0,
        bits: [0; 3],
    };
    let mut of_sliding = Called {
        name: "closed form, sliding",
        form: |a: f32, f: f32| slide.closed_form(a, f),
        amplitude: 3.5316,
        frequencies: [17.5, 18.2, 18.373, 18.6],
        calls: 0,
        bits: [0; 3],
    };
    let mut of_bump = Called {
        name: "closed form, bump-stop",
        form: |a: f32, f: f32| bump.closed_form(a, f),
        amplitude: 1.0,
        frequencies: [150.0, 200.0, 220.0, 300.0],
        calls: 0,
        bits: [0; 3],
    };
    work(Some(&mut [&mut a, &mut b, &mut c, &mut heard, &mut of_contact, &mut of_sliding, &mut of_bump]))
}

type Scenes = (
    contact_separation::ContactSeparation<f32, contact_parts::Whole>,
    sliding::Sliding<f32, sliding_parts::Whole>,
    model_core::scene::bump_stop::BumpStop<
        f32,
        bump_stop_parts::Whole,
        { bump_stop_scenes::BEAM_MODES },
        { bump_stop_scenes::ROD_MODES },
    >,
);

/// The default scenes.
fn scenes() -> Option<Scenes> {
    Some((
        black_box(contact_parts::whole()).build().ok()?,
        black_box(sliding_parts::whole()).build().ok()?,
        black_box(bump_stop_parts::whole(bump_stop_parts::GAP)).build().ok()?,
    ))
}
