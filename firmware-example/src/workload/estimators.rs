//! The cost of an estimate: the estimator of each scene and the tone meter by sample, the closed forms by call.
//!
//! A step in the log of these workloads is a sample or a call, so that instructions per step are instructions per
//! sample or per call.

use core::hint::black_box;

use model_core::clock::Instant;
use model_core::energy::Estimator;
use model_core::energy::estimator::{Interpolation, SampleFormat, Settings};
use model_core::excitation::{Excitation, Sine, ToneMeter, ToneMeterState};
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::scalar::Polynomial;
use model_core::scene::bump_stop::{BumpStop, Stepper};
use model_core::scene::closed_form::ClosedForm;
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
/// The input of a closed form: the strongest sine of the samples.
const LINE: Tone = Tone { name: "strongest-sine", periods: 20, ..CONTACT };
/// Entries of each estimator in the log.
const ENTRIES: u32 = 4;

/// The estimators of the three scenes, the tone meter, and the closed forms of the three scenes.
pub fn all(visit: Visit<'_>) -> Option<()> {
    let contact = black_box(contact_separation::parts::whole()).build().ok()?;
    let slide = black_box(sliding::parts::whole()).build().ok()?;
    let bump: BumpStop<f32, _, BEAM_MODES, ROD_MODES> =
        black_box(bump_stop::parts::whole(bump_stop::parts::GAP)).build().ok()?;

    let control = Adaptive::new(contact_separation::TOLERANCE).ok()?;
    show(visit, estimator(CONTACT, Simulation::new(contact, ExponentialRadau, control)))?;
    let control = Adaptive::new(sliding::TOLERANCE).ok()?;
    show(visit, estimator(SLIDING, Simulation::new(slide, ExponentialRadau, control)))?;
    show(visit, estimator(BUMP_STOP, Stepper::new(bump, black_box(SHORT), black_box(LONG)).ok()?))?;

    let meter = ToneMeter::new(black_box(LINE.rate()), LINE.period * LINE.periods).ok()?;
    show(visit, Fed::new(LINE, Line { state: meter.start(), meter }))?;

    let form = |amplitude, frequency| contact.closed_form(amplitude, frequency);
    visit(&mut Called::new("closed form, contact-separation", form, 0.5, [17.0, 19.0, 21.0, 23.0]));
    let form = |amplitude, frequency| slide.closed_form(amplitude, frequency);
    visit(&mut Called::new("closed form, sliding", form, 3.5316, [17.5, 18.2, 18.373, 18.6]));
    let form = |amplitude, frequency| bump.closed_form(amplitude, frequency);
    visit(&mut Called::new("closed form, bump-stop", form, 1.0, [150.0, 200.0, 220.0, 300.0]));
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

/// What is fed with samples.
trait Listener {
    /// Takes in a raw count; `None` if that fails. May write its result.
    fn push(&mut self, count: i16, result: &mut [u32; 3]) -> Option<()>;

    /// Writes the result of an entry of the log.
    fn finish(&self, _result: &mut [u32; 3]) {}
}

impl<H: Harvester<f32>> Listener for Estimator<f32, H> {
    #[inline]
    fn push(&mut self, count: i16, _: &mut [u32; 3]) -> Option<()> {
        self.push_count(count, u32::MAX).ok().map(|_| ())
    }

    fn finish(&self, result: &mut [u32; 3]) {
        let estimate = self.estimate();
        let unknown = f32::INFINITY;
        let relative = estimate.uncertainty.relative.unwrap_or(unknown);
        *result = [estimate.energy, estimate.mean_power, relative].map(f32::to_bits);
    }
}

/// A tone meter with its state.
#[derive(Debug)]
struct Line {
    meter: ToneMeter<f32>,
    state: ToneMeterState<f32>,
}

impl Listener for Line {
    #[inline]
    fn push(&mut self, count: i16, result: &mut [u32; 3]) -> Option<()> {
        if let Some(line) = self.meter.push::<Polynomial>(&mut self.state, SCALE * f32::from(count)) {
            *result = [line.amplitude, line.frequency, line.purity].map(f32::to_bits);
        }
        Some(())
    }
}

/// A listener that is fed a sine.
#[derive(Debug)]
struct Fed<L> {
    tone: Tone,
    counts: [i16; LONGEST],
    listener: L,
    entries: u32,
    bits: [u32; 3],
}

#[inline(never)]
fn estimator<H: Harvester<f32>>(tone: Tone, harvester: H) -> Option<Fed<Estimator<f32, H>>> {
    let settings = Settings {
        rate: black_box(tone.rate()),
        format: SampleFormat::counts(SCALE, i16::MAX.unsigned_abs()),
        longest_gap: 4,
        settling_seconds: 0.0,
        interpolation: Interpolation::Linear,
        bias_seconds: None,
    };
    Fed::new(tone, Estimator::new(harvester, settings).ok()?)
}

impl<L> Fed<L> {
    fn new(tone: Tone, listener: L) -> Option<Self> {
        Some(Self { tone, counts: tone.counts()?, listener, entries: 0, bits: [0; 3] })
    }
}

impl<L: Listener> Workload for Fed<L> {
    fn name(&self) -> &'static str {
        self.tone.name
    }

    fn advance(&mut self) -> Progress {
        if self.entries == ENTRIES {
            return Progress::Finished;
        }
        self.entries += 1;
        for _ in 0..self.tone.periods {
            for (_, &count) in (0..self.tone.period).zip(&self.counts) {
                if self.listener.push(count, &mut self.bits).is_none() {
                    return Progress::Failed;
                }
            }
        }
        self.listener.finish(&mut self.bits);
        let samples = self.tone.period * self.tone.periods;
        Progress::Sample { steps: samples, simulated_us: (1e6 * samples as f32 / self.tone.rate()) as u32 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}

/// A closed form of amplitude in m/s² and frequency in Hz, called once a simulated second.
struct Called<F> {
    name: &'static str,
    form: F,
    amplitude: f32,
    frequencies: [f32; 4],
    calls: usize,
    bits: [u32; 3],
}

impl<F: Fn(f32, f32) -> ClosedForm<f32>> Called<F> {
    fn new(name: &'static str, form: F, amplitude: f32, frequencies: [f32; 4]) -> Self {
        Self { name, form, amplitude, frequencies, calls: 0, bits: [0; 3] }
    }
}

impl<F: Fn(f32, f32) -> ClosedForm<f32>> Workload for Called<F> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn advance(&mut self) -> Progress {
        let Some(&frequency) = self.frequencies.get(self.calls) else { return Progress::Finished };
        self.calls += 1;
        let found = (self.form)(black_box(self.amplitude), black_box(frequency));
        let holds = u32::from(found.validity.holds());
        self.bits = [found.mean_power.to_bits(), found.amplitude.to_bits(), holds];
        Progress::Sample { steps: 1, simulated_us: 1_000_000 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
