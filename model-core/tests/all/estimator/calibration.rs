//! The stated uncertainty against the true error, on random inputs: tones, noise and bursts at random sampling rates.
//!
//! The truth is the energy in `f64` at a tolerance of 10⁻⁷ under the input sampled 16 384 times a second, with the
//! filter of [`Interpolation::DroopCompensated`] at its limit for many samples in a period: its amplitude is off by
//! 10⁻⁹.
//!
//! The two factors of coverage and the number of periods after an impact in `estimator/sampling.rs` and
//! `estimator/response.rs` were fitted on the inputs of the seed [`FITTED`] and of two more. [`TESTED`] was not used.

use super::{follow, settings};
use crate::common::harvesters::{Contact, Slide, contact_parameters, sliding_parameters};
use crate::common::{Random, adaptive};
use core::f64::consts::TAU;
use model_core::clock::Instant;
use model_core::energy::estimator::{Interpolation, Settings};
use model_core::energy::{Estimator, PowerMeter};
use model_core::excitation::{AfterLastSample, Sampled};
use model_core::integrate::{AnyStepControl, ExponentialRadau};
use model_core::scalar::Scalar;
use model_core::scene::{Harvester, Scene, Simulation};

/// Samples per second of the truth.
pub(super) const DENSE: f64 = 16_384.0;
/// A seed on whose inputs the statement was fitted.
const FITTED: u64 = 5;
/// The seed on whose inputs it is tested.
const TESTED: u64 = 3_000_017;
const INTERPOLATIONS: [Interpolation; 2] = [Interpolation::Linear, Interpolation::DroopCompensated];
/// Energy in J below which an input brings nothing.
const LEAST_ENERGY: f64 = 1e-10;

/// A base acceleration: sines with a Gaussian envelope, or without one.
pub(super) struct Vibration {
    /// Amplitude, frequency in Hz, phase, centre in s and width in s.
    parts: Vec<[f64; 5]>,
    /// m/s² for a unit of amplitude.
    scale: f64,
}

impl Vibration {
    /// Tones, noise or bursts by turns, of a root mean square in m/s², below 0.35 of the rate.
    pub(super) fn new(
        random: &mut Random,
        kind: u32,
        resonance: f64,
        rate: f64,
        rms: f64,
        seconds: f64,
    ) -> Self {
        let top = (0.35 * rate).min(4.0 * resonance);
        let phase = |random: &mut Random| random.between(0.0, TAU);
        let parts: Vec<[f64; 5]> = match kind {
            0 => (0..1 + random.next() % 4)
                .map(|n| {
                    let near = resonance * random.between(0.85, 1.15);
                    let any = random.between(3.0, top);
                    let frequency = if n == 0 { near } else { any };
                    [random.between(0.3, 1.0), frequency, phase(random), 0.0, f64::INFINITY]
                })
                .collect(),
            1 => {
                (0..60).map(|_| [1.0, random.between(3.0, top), phase(random), 0.0, f64::INFINITY]).collect()
            }
            _ => (0..(seconds * random.between(1.0, 5.0)) as u32 + 1)
                .map(|_| {
                    let frequency = random.between(0.5 * resonance, 0.6 * top);
                    let centre = random.between(0.0, seconds);
                    let width = random.between_logarithmic(0.02, 0.3);
                    [random.between(0.3, 1.0), frequency, phase(random), centre, width]
                })
                .collect(),
        };
        let mut vibration = Self { parts, scale: 1.0 };
        let dense = (8.0 * resonance).max(800.0);
        let squares = vibration.samples::<f64>(dense, seconds).iter().map(|a| a * a).sum::<f64>();
        vibration.scale = rms / (squares / (dense * seconds)).sqrt();
        vibration
    }

    /// The acceleration in m/s² at a time in s.
    pub(super) fn at(&self, time: f64) -> f64 {
        let part = |&[amplitude, frequency, phase, centre, width]: &[f64; 5]| {
            let away = (time - centre) / width;
            amplitude * (-0.5 * away * away).exp() * (TAU * frequency * (time - centre) + phase).sin()
        };
        self.scale * self.parts.iter().map(part).sum::<f64>()
    }

    pub(super) fn samples<S: Scalar>(&self, rate: f64, seconds: f64) -> Vec<S> {
        (0..(rate * seconds) as u32).map(|n| S::from_f64(self.at(f64::from(n) / rate))).collect()
    }

    /// The samples at a rate for [`Sampled`], with the filter of [`Interpolation::DroopCompensated`] at its limit for
    /// many samples in a period.
    pub(super) fn dense(&self, rate: f64, seconds: f64) -> Vec<f64> {
        let raw = self.samples::<f64>(rate, seconds);
        let mut dense = raw.clone();
        for (sample, window) in dense[1..].iter_mut().zip(raw.windows(3)) {
            *sample -= (window[0] - 2.0 * window[1] + window[2]) / 12.0;
        }
        dense
    }
}

/// The true error and the stated one of the mean power, relative to the estimate.
#[derive(Debug, Clone, Copy)]
struct Compared {
    error: f64,
    stated: f64,
}

/// An input, with the comparison for each of [`INTERPOLATIONS`].
#[derive(Debug, Clone)]
struct Input {
    name: String,
    samples_per_period: f64,
    compared: [Compared; 2],
}

/// What is compared: both scenes, the tolerance, the samples per second, and the duration in s.
struct Case<A, B> {
    single: A,
    double: B,
    tolerance: f64,
    rate: f64,
    seconds: f64,
}

impl<A: Scene<f32, 3, 1> + Copy, B: Scene<f64, 3, 1> + Copy> Case<A, B> {
    /// The statement against the truth for each interpolation; `None` if the input brings nothing.
    fn compare(&self, vibration: &Vibration) -> Option<[Compared; 2]> {
        let control = adaptive(self.tolerance);
        let harvester: Simulation<_, _, _, 3, 1> = Simulation::new(self.single, ExponentialRadau, control);
        let found = INTERPOLATIONS.map(|interpolation| {
            let settings = Settings { interpolation, ..settings::<f32>(self.rate) };
            let mut estimator = Estimator::new(harvester, settings).expect("valid");
            follow(&mut estimator, &vibration.samples(self.rate, self.seconds))
        });
        let truth = self.truth(vibration, found[0].seconds.into());
        let compared = found.map(|found| Compared {
            error: (truth / f64::from(found.energy) - 1.0).abs(),
            stated: found.uncertainty.relative.expect("known").into(),
        });
        let brings = truth > LEAST_ENERGY && found.iter().all(|found| f64::from(found.energy) > LEAST_ENERGY);
        brings.then_some(compared)
    }

    /// The energy in J that is delivered in so many seconds.
    fn truth(&self, vibration: &Vibration, seconds: f64) -> f64 {
        let dense = vibration.dense(DENSE, self.seconds);
        let trace = Sampled::new(&dense, DENSE, AfterLastSample::Silence).expect("valid");
        let exact = exact(self.double);
        let mut state = exact.start(&Default::default(), &trace).expect("starts");
        let mut meter = PowerMeter::<f64>::new();
        let until = Instant::from_seconds(seconds).expect("in range");
        exact.advance(&mut state, &trace, until, u32::MAX, &mut meter).expect("runs");
        meter.delivered_energy()
    }
}

pub(super) fn exact<B: Scene<f64, 3, 1>>(
    scene: B,
) -> Simulation<B, ExponentialRadau, AnyStepControl<f64>, 3, 1> {
    Simulation::new(scene, ExponentialRadau, adaptive(1e-7))
}

/// One random input of a kind and a root mean square in m/s².
fn random_input<A: Scene<f32, 3, 1> + Copy, B: Scene<f64, 3, 1> + Copy>(
    random: &mut Random,
    (single, double): (A, B),
    (kind, rms, seconds): (u32, f64, f64),
) -> Option<(f64, [Compared; 2])> {
    let tolerance = random.between_logarithmic(1e-3, 1e-1);
    let resonance = exact(double).resonance_frequency();
    let rate = random.between_logarithmic((4.2 * resonance).max(100.0), 1000.0);
    let vibration = Vibration::new(random, kind, resonance, rate, rms, seconds);
    let case = Case { single, double, tolerance, rate, seconds };
    case.compare(&vibration).map(|compared| (rate / resonance, compared))
}

/// The scene in both precisions.
pub(super) type Both<A, B> = (A, B);

/// Contact-separation with a stiffness in N/m and a load in Ω.
pub(super) fn contact_scenes(stiffness: f64, resistance: f64) -> Both<Contact<f32>, Contact<f64>> {
    let (mut single, mut double) = (contact_parameters::<f32>(), contact_parameters::<f64>());
    (single.stiffness, double.stiffness) = (stiffness as f32, stiffness);
    (single.choices.load.resistance, double.choices.load.resistance) = (resistance as f32, resistance);
    (single.build().expect("in bounds"), double.build().expect("in bounds"))
}

/// Sliding with a mass in kg and a load in Ω.
pub(super) fn sliding_scenes(mass: f64, resistance: f64) -> Both<Slide<f32>, Slide<f64>> {
    let (mut single, mut double) = (sliding_parameters::<f32>(), sliding_parameters::<f64>());
    (single.slider_mass, double.slider_mass) = (mass as f32, mass);
    (single.choices.load.resistance, double.choices.load.resistance) = (resistance as f32, resistance);
    (single.build().expect("in bounds"), double.build().expect("in bounds"))
}

/// Random inputs, by turns to contact-separation and sliding with random loads and resonances of 15 to 36 Hz, without
/// those that bring nothing.
fn random_inputs(seed: u64, count: u32, seconds: f64) -> Vec<Input> {
    let kinds = ["tones", "noise", "bursts"];
    let input = |number: u32| {
        let mut random = Random(u64::from(number) * 7919 + seed);
        let kind = number / 2 % 3;
        let resistance = random.between_logarithmic(1e6, 1e9);
        let (name, found) = if number.is_multiple_of(2) {
            let scenes = contact_scenes(random.between(80.0, 250.0), resistance);
            let rms = random.between_logarithmic(1.0, 20.0);
            ("contact-separation", random_input(&mut random, scenes, (kind, rms, seconds)))
        } else {
            let scenes = sliding_scenes(random.between(2e-3, 8e-3), resistance);
            let rms = random.between(1.5, 4.0);
            ("sliding", random_input(&mut random, scenes, (kind, rms, seconds)))
        };
        let name = format!("{name}, {}", kinds[kind as usize]);
        found.map(|(samples_per_period, compared)| Input { name, samples_per_period, compared })
    };
    (0..count).filter_map(input).collect()
}

/// The part of numbers that lies below the quantile.
pub(super) fn quantile(mut numbers: Vec<f64>, part: f64) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[((numbers.len() - 1) as f64 * part).round() as usize]
}

/// The part of the inputs whose error is inside the stated one, and the median of stated over true.
fn judged(rows: &[Compared]) -> (f64, f64) {
    let inside = rows.iter().filter(|row| row.error <= row.stated).count() as f64 / rows.len() as f64;
    (inside, quantile(rows.iter().map(|row| row.stated / row.error).collect(), 0.5))
}

/// Prints a row, and gives the part inside and the median ratio.
fn print(name: &str, rows: &[Compared]) -> (f64, f64) {
    let (inside, ratio) = judged(rows);
    let error = 100.0 * quantile(rows.iter().map(|row| row.error).collect(), 0.5);
    let stated = 100.0 * quantile(rows.iter().map(|row| row.stated).collect(), 0.5);
    let (count, inside) = (rows.len(), 100.0 * inside);
    println!("| {name} | {count} | {error:.2} % | {stated:.2} % | {inside:.1} % | {ratio:.1} |");
    (inside / 100.0, ratio)
}

/// Prints the table of each interpolation, with a row for each harvester and kind, each harvester, and all; gives the
/// part inside and the median ratio of all.
fn tables(inputs: &[Input]) -> [(f64, f64); 2] {
    [0, 1].map(|place| {
        println!("| `{:?}` | inputs | error | stated | inside | stated/error |", INTERPOLATIONS[place]);
        println!("| --- | --- | --- | --- | --- | --- |");
        let of = |part: &str| -> Vec<Compared> {
            let chosen = inputs.iter().filter(|input| input.name.starts_with(part));
            chosen.map(|input| input.compared[place]).collect()
        };
        for harvester in ["contact-separation", "sliding"] {
            for kind in ["tones", "noise", "bursts", "all"] {
                let name = format!("{harvester}, {kind}");
                print(&name, &of(if kind == "all" { harvester } else { &name }));
            }
        }
        print("all", &of(""))
    })
}

/// Prints the errors of both interpolations, median and 90th percentile, by samples in a resonance period.
fn print_errors_by_rate(inputs: &[Input]) {
    println!("| samples in a period | inputs | linear | filter |\n| --- | --- | --- | --- |");
    for [low, high] in [[4.0, 6.0], [6.0, 10.0], [10.0, 20.0], [20.0, 70.0]] {
        let within = |input: &&Input| (low..high).contains(&input.samples_per_period);
        let chosen: Vec<&Input> = inputs.iter().filter(within).collect();
        let errors = |place: usize| -> Vec<f64> {
            chosen.iter().map(|input| 100.0 * input.compared[place].error).collect()
        };
        let of = |place| [0.5, 0.9].map(|part| quantile(errors(place), part));
        let ([linear, most_linear], [filter, most_filter]) = (of(0), of(1));
        let count = chosen.len();
        println!(
            "| {low} to {high} | {count} | {linear:.2} %, {most_linear:.1} % | {filter:.2} %, {most_filter:.1} % |"
        );
    }
}

#[test]
fn the_stated_uncertainty_covers_the_error_of_a_few_random_inputs_and_is_not_much_larger() {
    // Two seconds, in which most motions are still rising.
    for (inside, ratio) in tables(&random_inputs(TESTED, 24, 2.0)) {
        assert!(inside >= 0.85 && (1.0..10.0).contains(&ratio), "{inside} {ratio}");
    }
}

#[test]
#[ignore = "takes minutes"]
fn the_stated_uncertainty_covers_the_error_in_95_of_100_random_inputs() {
    let mut all = Vec::new();
    for seed in [FITTED, TESTED] {
        let inputs = random_inputs(seed, 480, 5.0);
        println!("\nseed {seed}");
        for (inside, ratio) in tables(&inputs) {
            assert!(inside >= 0.95 && (1.0..5.0).contains(&ratio), "seed {seed}: {inside} {ratio}");
        }
        all.extend(inputs);
    }
    print_errors_by_rate(&all);
}

/// Two tones of equal strength in sliding, one at the resonance and one at 0.3 of the rate. With the filter the stated
/// error can be too small: the harvester takes up little of the fast tone, but by friction that tone acts on the slow one.
#[test]
fn the_error_of_two_tones_is_inside_without_the_filter_and_small_with_it() {
    for rate in [150.0, 400.0] {
        let (single, double) = sliding_scenes(5e-3, 1e8);
        let tone = |frequency: f64, phase: f64| [1.0, frequency, phase, 0.0, f64::INFINITY];
        let parts = vec![tone(exact(double).resonance_frequency(), 0.0), tone(0.3 * rate, 1.0)];
        let case = Case { single, double, tolerance: 1e-2, rate, seconds: 2.5 };
        let [linear, filter] = case.compare(&Vibration { parts, scale: 4.0 }).expect("brings something");
        println!("{rate} Hz: linear {linear:?}, filter {filter:?}");
        assert!(linear.error <= linear.stated && linear.stated < 30.0 * linear.error, "{linear:?}");
        assert!(filter.error < 0.02 * linear.error && filter.error < 5e-3, "{filter:?}");
    }
}
