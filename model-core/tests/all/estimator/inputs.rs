//! The stated uncertainty against the true error where the samples are not those of an exact sensor: few bits, jitter of
//! the clock, a rate off its nominal, lost samples.
//!
//! The truth is the energy in `f64` of the same harvester under the continuous acceleration, at the true instants. The error
//! is the larger one of the energy and the mean power, relative to the estimate.

use super::calibration::{DENSE, Vibration, contact_scenes, exact, quantile, sliding_scenes};
use super::settings;
use crate::common::harvesters::bump_parameters;
use crate::common::{Random, adaptive};
use model_core::clock::Instant;
use model_core::energy::estimator::{Interpolation, Sample, SampleFormat, Settings};
use model_core::energy::{Estimator, PowerMeter};
use model_core::excitation::{AfterLastSample, Sampled};
use model_core::integrate::ExponentialRadau;
use model_core::part::GRAVITY;
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::{AnyChoices, StepDoubling, Stepper};
use model_core::scene::{Harvester, Scene, Simulation};

/// A seed on whose inputs the factors of coverage in `estimator/sampling.rs` were fitted, with two more.
const FITTED: u64 = 11;
/// The seed on whose inputs the statement is tested.
const TESTED: u64 = 5_000_011;
/// Energy in J below which an input brings nothing.
const LEAST_ENERGY: f64 = 1e-10;

/// What is wrong with the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Flaw {
    None,
    /// Counts of so many bits, to the nearest.
    Rounded(u32),
    /// Counts of so many bits, towards zero.
    CutOff(u32),
    /// Standard deviation of the instants, in intervals.
    Jitter(f64),
    /// Deviation of the rate, relative.
    Rate(f64),
    /// 150 ms of lost samples, with so many seconds of settling.
    Lost(f64),
}

const FLAWS: [Flaw; 12] = [
    Flaw::None,
    Flaw::Rounded(8),
    Flaw::CutOff(8),
    Flaw::Rounded(10),
    Flaw::Rounded(12),
    Flaw::Jitter(0.1),
    Flaw::Jitter(0.3),
    Flaw::Rate(0.05),
    Flaw::Rate(0.01),
    Flaw::Rate(0.002),
    Flaw::Lost(0.0),
    Flaw::Lost(1.0),
];

/// An input to a harvester.
struct Input {
    harvester: &'static str,
    vibration: Vibration,
    rate: f64,
    seconds: f64,
    random: Random,
}

/// The readings of an input, and the true time in s of the last but one.
struct Readings {
    settings: Settings<f32>,
    /// In m/s² or counts; `None` where lost.
    values: Vec<Option<f64>>,
    counts: bool,
    until: f64,
}

/// The true error and the stated one of a run.
struct Run {
    harvester: &'static str,
    flaw: Flaw,
    error: f64,
    stated: Option<f64>,
}

impl Input {
    fn readings(&self, flaw: Flaw) -> Readings {
        let mut random = Random(self.random.0);
        let Self { vibration, rate, seconds, .. } = self;
        let mut true_rate = *rate;
        let mut settings =
            Settings { interpolation: Interpolation::DroopCompensated, ..settings::<f32>(*rate) };
        match flaw {
            Flaw::Jitter(part) => settings.jitter = part as f32,
            Flaw::Lost(settling) => settings.settling_seconds = settling as f32,
            Flaw::Rate(part) => {
                settings.rate_tolerance = part as f32;
                true_rate *= if random.next().is_multiple_of(2) { 1.0 + part } else { 1.0 - part };
            }
            _ => {}
        }
        let count = (seconds * true_rate) as u32;
        let mut at = |n: u32| match flaw {
            Flaw::Jitter(part) => vibration.at((f64::from(n) + part * random.normal()) / true_rate),
            _ => vibration.at(f64::from(n) / true_rate),
        };
        let mut values: Vec<Option<f64>> = (0..count).map(|n| Some(at(n))).collect();
        if let Flaw::Rounded(bits) | Flaw::CutOff(bits) = flaw {
            let peak = values.iter().flatten().fold(0.0_f64, |peak, a| peak.max(a.abs()));
            let range = (1..10).map(|n| f64::from(1 << n) * GRAVITY).find(|range| *range > peak);
            // The range of the peak, or the next one.
            let range = range.expect("a range") * if random.next().is_multiple_of(3) { 2.0 } else { 1.0 };
            let half = 1_u16 << (bits - 1);
            let scale = range / f64::from(half);
            settings.format = SampleFormat::counts(scale as f32, half - 1);
            let count = |a: f64| {
                if matches!(flaw, Flaw::CutOff(_)) { (a / scale).trunc() } else { (a / scale).round() }
            };
            values = values.iter().map(|a| a.map(count)).collect();
        }
        if let Flaw::Lost(_) = flaw {
            let first = (random.between(0.2, 0.8) * seconds * true_rate) as usize;
            let lost = (0.15 * true_rate).ceil() as usize;
            values.iter_mut().skip(first).take(lost).for_each(|value| *value = None);
        }
        let counts = matches!(flaw, Flaw::Rounded(_) | Flaw::CutOff(_));
        Readings { settings, values, counts, until: f64::from(count - 2) / true_rate }
    }

    /// The runs under each flaw; `truth` gives the energies in J at instants in s in ascending order.
    fn runs<H: Harvester<f32> + Copy>(
        &self,
        harvester: H,
        flaws: &[Flaw],
        truth: impl FnOnce(&[f64]) -> Vec<f64>,
    ) -> Vec<Run> {
        let readings: Vec<Readings> = flaws.iter().map(|&flaw| self.readings(flaw)).collect();
        let mut times: Vec<f64> = readings.iter().map(|readings| readings.until).collect();
        times.sort_by(f64::total_cmp);
        let energies = truth(&times);
        let run = |(&flaw, readings): (&Flaw, &Readings)| {
            let Readings { settings, values, counts, until } = readings;
            let mut estimator = Estimator::new(harvester, *settings).expect("valid");
            for value in values {
                let pushed = match *value {
                    None => estimator.push(Sample::Missing, u32::MAX),
                    Some(value) if *counts => estimator.push_count(value as i16, u32::MAX),
                    Some(value) => estimator.push_acceleration(value as f32, u32::MAX),
                };
                assert!(pushed.expect("runs").finished);
            }
            let found = estimator.estimate();
            let exact = energies[times.iter().position(|time| time == until)?];
            let errors = [exact / f64::from(found.energy), exact / until / f64::from(found.mean_power)];
            let [by_energy, by_power] = errors.map(|ratio| (ratio - 1.0).abs());
            let stated = found.uncertainty.relative.map(f64::from);
            let run = Run { harvester: self.harvester, flaw, error: by_energy.max(by_power), stated };
            (exact > LEAST_ENERGY).then_some(run)
        };
        flaws.iter().zip(&readings).filter_map(run).collect()
    }
}

/// The energies in J of a harvester at instants in s, in ascending order.
fn energies<H: Harvester<f64>>(harvester: H, vibration: &Vibration, dense: f64, times: &[f64]) -> Vec<f64> {
    let last = times.last().copied().unwrap_or(0.0);
    let samples = vibration.dense(dense, last + 0.1);
    let trace = Sampled::new(&samples, dense, AfterLastSample::Silence).expect("valid");
    let mut state = harvester.start(&Default::default(), &trace).expect("starts");
    let mut meter = PowerMeter::<f64>::new();
    let to = |&time: &f64| {
        let until = Instant::from_seconds(time).expect("in range");
        harvester.advance(&mut state, &trace, until, u32::MAX, &mut meter).expect("runs");
        meter.delivered_energy()
    };
    times.iter().map(to).collect()
}

/// The runs of a triboelectric scene under an input of a kind and a root mean square in m/s².
fn simulated<A: Scene<f32, 3, 1> + Copy, B: Scene<f64, 3, 1> + Copy>(
    (harvester, mut random): (&'static str, Random),
    (single, double): (A, B),
    (kind, rms): (u32, f64),
    flaws: &[Flaw],
) -> Vec<Run> {
    let control = adaptive(2e-2);
    let model: Simulation<_, _, _, 3, 1> = Simulation::new(single, ExponentialRadau, control);
    let resonance = exact(double).resonance_frequency();
    let rate = random.between_logarithmic((5.0 * resonance).max(100.0), 1000.0);
    let seconds = 5.0;
    let vibration = Vibration::new(&mut random, kind, resonance, rate, rms, seconds);
    let input = Input { harvester, vibration, rate, seconds, random };
    input.runs(model, flaws, |times| energies(exact(double), &input.vibration, DENSE, times))
}

/// A bump-stop scene of a gap in m, a damping ratio and a load in Ω, with a short and a long step in s.
fn stepper<S: Scalar>([gap, damping, load]: [f64; 3], steps: [f64; 2]) -> Stepper<S, AnyChoices<S>, 4, 1> {
    let mut parameters = bump_parameters::<S>();
    parameters.choices.stop.gap = S::from_f64(gap);
    parameters.damping_ratio = S::from_f64(damping);
    parameters.choices.load.0.resistance = S::from_f64(load);
    let [short, long] = steps.map(S::from_f64);
    Stepper::new(parameters.build().expect("in bounds"), short, long).expect("in bounds")
}

/// The runs of a bump-stop with checks.
fn stepped(mut random: Random, (kind, rms): (u32, f64), flaws: &[Flaw]) -> Vec<Run> {
    let parts =
        [(3e-6, 1e-3), (0.004, 0.03), (1e4, 3e6)].map(|(low, high)| random.between_logarithmic(low, high));
    let model = StepDoubling::new(stepper::<f32>(parts, [6e-6, 80e-6]), 4);
    let resonance = f64::from(model.resonance_frequency());
    let rate = random.between_logarithmic(5.0 * resonance, 40.0 * resonance);
    let seconds = 1.5;
    let vibration = Vibration::new(&mut random, kind, resonance, rate, rms, seconds);
    let input = Input { harvester: "bump-stop", vibration, rate, seconds, random };
    input.runs(model, flaws, |times| {
        energies(stepper::<f64>(parts, [1e-6, 20e-6]), &input.vibration, 3.0 * DENSE, times)
    })
}

/// Runs of random inputs, tones, noise and bursts, to contact-separation under weak and strong inputs, sliding and
/// bump-stop by turns.
fn runs(seed: u64, count: u32, flaws: &[Flaw]) -> Vec<Run> {
    let of = |number: u32| {
        let mut random = Random(u64::from(number) * 7919 + seed);
        let kind = number / 4 % 3;
        let load = random.between_logarithmic(1e6, 1e9);
        match number % 4 {
            0 | 1 => {
                let scenes = contact_scenes(random.between(80.0, 250.0), load);
                let (name, [low, high]) = if number.is_multiple_of(4) {
                    ("contact, weak", [0.3, 3.0])
                } else {
                    ("contact, strong", [3.0, 20.0])
                };
                let rms = random.between_logarithmic(low, high);
                simulated((name, random), scenes, (kind, rms), flaws)
            }
            2 => {
                let scenes = sliding_scenes(random.between(2e-3, 8e-3), load);
                let rms = random.between(1.5, 4.0);
                simulated(("sliding", random), scenes, (kind, rms), flaws)
            }
            _ => {
                let rms = random.between_logarithmic(1.0, 100.0);
                stepped(random, (kind, rms), flaws)
            }
        }
    };
    (0..count).flat_map(of).collect()
}

/// Prints a row for each flaw, with the parts inside and unknown of all runs and by harvester, where an unknown statement is
/// outside; gives the parts of all, the least part inside of a harvester, and the median statement in percent.
fn table(runs: &[Run], flaws: &[Flaw]) -> Vec<([f64; 3], f64)> {
    const HARVESTERS: [&str; 4] = ["contact, weak", "contact, strong", "sliding", "bump-stop"];
    println!("| flaw | runs | error | stated | inside, unknown | {} |", HARVESTERS.join(" | "));
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let row = |&flaw: &Flaw| {
        let of = |name: &str| -> Vec<&Run> {
            runs.iter().filter(|run| run.flaw == flaw && run.harvester.contains(name)).collect()
        };
        let part = |rows: &[&Run], is: fn(&Run) -> bool| {
            rows.iter().filter(|run| is(run)).count() as f64 / rows.len() as f64
        };
        let parts = |rows: &[&Run]| {
            let inside = part(rows, |run| run.stated.is_some_and(|stated| run.error <= stated));
            [inside, part(rows, |run| run.stated.is_none())]
        };
        let shown = |[inside, unknown]: [f64; 2]| format!("{:.1}, {:.1} %", 100.0 * inside, 100.0 * unknown);
        let rows = of("");
        let median = |of: fn(&Run) -> f64| 100.0 * quantile(rows.iter().map(|run| of(run)).collect(), 0.5);
        let (error, stated) = (median(|run| run.error), median(|run| run.stated.unwrap_or(f64::INFINITY)));
        let (all, count) = (parts(&rows), rows.len());
        let cells = HARVESTERS.map(|name| parts(&of(name)));
        let [of_all, of_cells] =
            [vec![all], cells.to_vec()].map(|all| all.into_iter().map(shown).collect::<Vec<_>>());
        let (of_all, of_cells) = (of_all.join(""), of_cells.join(" | "));
        println!("| {flaw:?} | {count} | {error:.2} % | {stated:.1} % | {of_all} | {of_cells} |");
        let least = cells.iter().fold(1.0_f64, |least, [inside, _]| least.min(*inside));
        ([all[0], all[1], least], stated)
    };
    flaws.iter().map(row).collect()
}

#[test]
fn the_error_by_a_few_flawed_samples_is_stated() {
    let flaws = [
        Flaw::Rounded(8),
        Flaw::CutOff(8),
        Flaw::Jitter(0.1),
        Flaw::Jitter(0.3),
        Flaw::Rate(0.05),
        Flaw::Lost(0.0),
    ];
    for (flaw, ([inside, unknown, _], stated)) in flaws.iter().zip(table(&runs(TESTED, 28, &flaws), &flaws)) {
        assert!(inside >= 0.85 && unknown <= 0.2, "{flaw:?}: {inside} {unknown}");
        // A rate that is 5 % off may miss a resonance altogether, and nothing bounds that.
        assert!(stated <= 100.0 || matches!(flaw, Flaw::Rate(_)), "{flaw:?}: {stated} %");
    }
}

#[test]
#[ignore = "four minutes"]
fn the_error_by_flawed_samples_is_stated_in_95_of_100_inputs() {
    for (seed, count) in [(FITTED, 192), (TESTED, 1152)] {
        println!("\nseed {seed}");
        for ([inside, unknown, least], _) in table(&runs(seed, count, &FLAWS), &FLAWS) {
            let of_harvester = if seed == TESTED { 0.95 } else { 0.85 };
            let holds = inside >= 0.95 && unknown <= 0.2 && least >= of_harvester;
            assert!(holds, "seed {seed}: {inside} {unknown} {least}");
        }
    }
}
