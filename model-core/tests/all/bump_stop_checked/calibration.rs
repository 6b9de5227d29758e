//! The stated error of the steps against the true one, on the shipped scenes and on random ones.
//!
//! The truth is the energy in `f64` with steps of 0.25 and 5 µs under the same samples. The factors of the statement were
//! fitted on scenes of another generator.

use super::{EVER, follow, settings};
use crate::bridged::{AnyBridge, resistor, storage};
use crate::common::Random;
use crate::common::harvesters::bump_parameters_into;
use core::f64::consts::TAU;
use model_core::clock::Instant;
use model_core::energy::{Estimator, PowerMeter};
use model_core::excitation::{AfterLastSample, Sampled};
use model_core::part::load::AnyLoad;
use model_core::part::monomorph::Layer;
use model_core::scalar::Scalar;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{
    AnyChoices, AnyContact, Circuit, Parameters, Parts, Resistive, StepDoubling, Stepper, TipMass,
};

/// Steps near contact and in flight, in s.
const STEPS: [[f64; 2]; 5] =
    [[1e-6, 20e-6], [2.5e-6, 40e-6], [6e-6, 80e-6], [13e-6, 180e-6], [26e-6, 360e-6]];
/// Those of the truth.
const EXACT: [f64; 2] = [0.25e-6, 5e-6];
/// Energy in J below which an input brings nothing.
const LEAST_ENERGY: f64 = 1e-12;

/// The load of a case.
#[derive(Debug, Clone, Copy)]
enum Into {
    /// A resistance in Ω.
    Resistor(f64),
    /// A capacitance in F that a resistance in Ω discharges, behind a bridge.
    Store(f64, f64),
}

/// A scene and its input.
#[derive(Debug, Clone)]
struct Case {
    name: String,
    gap: f64,
    position: f64,
    compliance: f64,
    damping: f64,
    contact: AnyContact<f64>,
    load: Into,
    /// Of a beam of 30 mm with a tip mass.
    heavy: bool,
    rate: f64,
    samples: Vec<f64>,
}

/// What a run states and how far off it is, relative to its mean power.
#[derive(Debug, Clone, Copy)]
struct Judged {
    error: f64,
    step: f64,
    irregularity: f64,
}

impl Judged {
    fn stated(&self) -> f64 {
        self.step + self.irregularity
    }
}

impl Case {
    /// Of a shipped scene: distance of the rod in m, its place in m, the load, amplitude in m/s² and frequency in Hz.
    fn shipped(name: &str, [gap, position]: [f64; 2], load: Into, [a, f]: [f64; 2], seconds: f64) -> Self {
        let rate = 48.0 * f.max(200.0);
        let samples = (0..(seconds * rate) as u32).map(|n| a * (TAU * f * f64::from(n) / rate).sin());
        Self {
            name: name.to_owned(),
            gap,
            position,
            compliance: 0.0,
            damping: 0.01,
            contact: AnyContact::ResidualFlexibility,
            load,
            heavy: false,
            rate,
            samples: samples.collect(),
        }
    }

    /// Tones, noise and bursts on rods anywhere under the outer half of the beam, touching it or up to 1 mm away.
    fn random(random: &mut Random, number: u32, seconds: f64) -> Self {
        let rate = 48.0 * 239.7;
        let amplitude = random.between_logarithmic(2.0, 200.0);
        let mut part =
            |low: f64, high: f64, size: f64| [size, random.between(low, high), random.between(0.0, TAU)];
        let kind = number % 4;
        let parts: Vec<[f64; 3]> = match kind {
            0 => vec![part(40.0, 320.0, 1.0)],
            1 => (0..4).map(|n| part(20.0, 700.0, if n == 0 { 1.0 } else { 0.4 })).collect(),
            _ => (0..60).map(|_| part(20.0, 600.0, 0.18)).collect(),
        };
        let at = |time: f64| {
            let sum =
                parts.iter().map(|[size, frequency, phase]| size * (TAU * frequency * time + phase).sin());
            let away = (4.0 * time / seconds).fract() - 0.4;
            let burst = if kind == 3 { (-80.0 * away * away).exp() } else { 1.0 };
            amplitude * burst * sum.sum::<f64>()
        };
        let samples = (0..(seconds * rate) as u32).map(|n| at(f64::from(n) / rate)).collect();
        let contact = match random.next() % 10 {
            0 => AnyContact::NoStop,
            1 => AnyContact::DisplacementConstraint,
            _ => AnyContact::ResidualFlexibility,
        };
        let load = match random.next() % 4 {
            0 => Into::Store(random.between_logarithmic(1e-7, 1e-5), random.between_logarithmic(1e4, 1e7)),
            _ => Into::Resistor(random.between_logarithmic(1e4, 3e6)),
        };
        let gap =
            [0.0, 10e-6, random.between_logarithmic(3e-6, 1e-4), random.between_logarithmic(1e-5, 1e-3)];
        let position = [50e-3, 25e-3, random.between(20e-3, 50e-3)];
        let compliance = [0.0, random.between_logarithmic(1e-7, 1e-4)];
        Self {
            name: format!("{number} ({kind})"),
            gap: gap[random.next() as usize % 4],
            position: position[random.next() as usize % 3],
            compliance: compliance[random.next() as usize % 2],
            damping: random.between_logarithmic(0.004, 0.03),
            contact,
            load,
            heavy: false,
            rate,
            samples,
        }
    }

    fn parameters<S: Scalar, L>(&self, load: L) -> Parameters<S, AnyChoices<S, L>> {
        let number = S::from_f64;
        let mut parameters = bump_parameters_into(load);
        parameters.damping_ratio = number(self.damping);
        let stop = &mut parameters.choices.stop;
        stop.gap = number(self.gap);
        stop.position = number(self.position);
        stop.contact_compliance = number(self.compliance);
        stop.contact = match self.contact {
            AnyContact::NoStop => AnyContact::NoStop,
            AnyContact::ResidualFlexibility => AnyContact::ResidualFlexibility,
            AnyContact::Restitution(_) => unreachable!("not checked"),
            AnyContact::DisplacementConstraint => AnyContact::DisplacementConstraint,
        };
        if self.heavy {
            parameters.beam_length = number(30e-3);
            parameters.beam_width = number(20e-3);
            let layer = |young_modulus, density| Layer {
                thickness: number(0.2e-3),
                young_modulus: number(young_modulus),
                density: number(density),
            };
            (parameters.substrate, parameters.piezo) = (layer(200e9, 7850.0), layer(60.6e9, 7500.0));
            parameters.piezo_d31 = number(-274e-12);
            parameters.piezo_permittivity = number(25.55e-9);
            parameters.choices.tip_mass = Some(TipMass {
                mass: number(6.28e-3),
                rotary_inertia: number(6.07e-8),
                offset: number(5e-3),
            });
        }
        parameters
    }

    /// The statements with each of `steps`, in `f32` with (4, 1) modes if `single`; `None` if the input brings nothing.
    fn judged<const B: usize, const R: usize>(
        &self,
        steps: &[[f64; 2]],
        exact: [f64; 2],
        single: bool,
        every: u32,
    ) -> Option<Vec<Judged>> {
        match self.load {
            Into::Resistor(resistance) => {
                let load = Resistive(AnyLoad { resistance });
                let small = Resistive(AnyLoad { resistance: resistance as f32 });
                self.compared::<_, _, B, R>(load, small, steps, exact, single, every)
            }
            Into::Store(capacitance, resistance) => {
                let load: AnyBridge<f64> = storage(capacitance, 0.2, resistor(resistance), 0.05);
                let small: AnyBridge<f32> = storage(capacitance, 0.2, resistor(resistance), 0.05);
                self.compared::<_, _, B, R>(load, small, steps, exact, single, every)
            }
        }
    }

    fn compared<L, M, const B: usize, const R: usize>(
        &self,
        load: L,
        small: M,
        steps: &[[f64; 2]],
        [short, long]: [f64; 2],
        single: bool,
        every: u32,
    ) -> Option<Vec<Judged>>
    where
        L: Circuit<f64> + Copy,
        M: Circuit<f32> + Copy,
        AnyChoices<f64, L>: Parts<f64>,
        AnyChoices<f32, M>: Parts<f32>,
    {
        let found: Vec<Found> = steps
            .iter()
            .map(|&pair| match single {
                true => self.found::<f32, M, 4, 1>(small, pair, every),
                false => self.found::<f64, L, B, R>(load, pair, every),
            })
            .collect();
        let scene = self.parameters(load).build::<B, R>().expect("in bounds");
        let stepper = Stepper::new(scene, short, long).expect("in bounds");
        let trace = Sampled::new(&self.samples, self.rate, AfterLastSample::Silence).expect("valid");
        let mut state = stepper.start(&Default::default(), &trace).expect("starts");
        let mut meter = PowerMeter::<f64>::new();
        let to = |state: &mut _, meter: &mut PowerMeter<f64>, seconds: f64| {
            let until = Instant::from_seconds(seconds).expect("in range");
            stepper.advance(state, &trace, until, EVER, meter).expect("runs");
        };
        // The runs end within a step of each other.
        let first = found.iter().map(|found| found.seconds).fold(f64::INFINITY, f64::min);
        to(&mut state, &mut meter, first - 1e-6);
        let judged = found.iter().zip(steps).map(|(found, pair)| {
            let (mut state, mut meter) = (state, meter);
            to(&mut state, &mut meter, found.seconds);
            let judged = Judged {
                error: (found.energy / meter.delivered_energy() - 1.0).abs(),
                step: found.step / found.energy.abs(),
                irregularity: found.irregularity,
            };
            if judged.error > judged.stated() {
                println!("{}, {:?}, {:?}, {pair:?}: {judged:?}", self.name, self.contact, self.load);
            }
            judged
        });
        let judged = judged.collect();
        (meter.delivered_energy() > LEAST_ENERGY).then_some(judged)
    }

    fn found<S: Scalar, L: Circuit<S> + Copy, const B: usize, const R: usize>(
        &self,
        load: L,
        pair: [f64; 2],
        every: u32,
    ) -> Found
    where
        AnyChoices<S, L>: Parts<S>,
    {
        let scene = self.parameters(load).build::<B, R>().expect("in bounds");
        let [short, long] = pair.map(S::from_f64);
        let checked = StepDoubling::new(Stepper::new(scene, short, long).expect("in bounds"), every);
        let mut estimator = Estimator::new(checked, settings(self.rate)).expect("valid");
        let samples: Vec<S> = self.samples.iter().map(|sample| S::from_f64(*sample)).collect();
        let found = follow(&mut estimator, &samples);
        let uncertainty = found.uncertainty;
        Found {
            energy: found.energy.to_f64(),
            seconds: found.seconds.to_f64(),
            // Not-a-number if it is unknown.
            step: uncertainty.step.map_or(f64::NAN, |step| (step + uncertainty.rounding).to_f64()),
            irregularity: uncertainty.irregularity.to_f64(),
        }
    }
}

/// What an estimator found: energy, integrated time, error of the energy by steps and rounding, relative irregularity.
#[derive(Debug, Clone, Copy)]
struct Found {
    energy: f64,
    seconds: f64,
    step: f64,
    irregularity: f64,
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The part of the runs whose error is inside the statement, the median of statement over error, and that without irregularity;
/// prints them.
fn summed_up(what: &str, all: &[Judged]) -> [f64; 3] {
    let runs: Vec<Judged> = all.iter().filter(|run| !run.step.is_nan()).copied().collect();
    let inside = |stated: fn(&Judged) -> f64| {
        runs.iter().filter(|run| run.error <= stated(run)).count() as f64 / runs.len() as f64
    };
    let ratio = |stated: fn(&Judged) -> f64| {
        median(runs.iter().map(|run| stated(run) / run.error.max(1e-12)).collect())
    };
    let coverage = inside(Judged::stated);
    println!(
        "{what:>12} | {:4} | unknown {:3} | median error {:.1e} | inside {:.3}, without irregularity {:.3} | median of statement over error {:.2}, \
         without irregularity {:.2}",
        all.len(),
        all.len() - runs.len(),
        median(runs.iter().map(|run| run.error).collect()),
        coverage,
        inside(|run| run.step),
        ratio(Judged::stated),
        ratio(|run| run.step),
    );
    [coverage, ratio(Judged::stated), ratio(|run| run.step)]
}

fn summed_up_by_steps(all: &[Vec<Judged>], steps: &[[f64; 2]]) -> [f64; 3] {
    for (place, [short, long]) in steps.iter().enumerate() {
        let runs: Vec<Judged> = all.iter().filter_map(|runs| runs.get(place).copied()).collect();
        summed_up(&format!("{}/{} µs", 1e6 * short, 1e6 * long), &runs);
    }
    summed_up("all", &all.concat())
}

#[test]
fn the_error_of_some_random_scenes_is_stated() {
    let mut random = Random(20_261_123);
    let steps = [STEPS[2], STEPS[3]];
    let cases = (0..12).filter_map(|number| {
        let case = Case::random(&mut random, number, 1.5);
        case.judged::<4, 1>(&steps, [1e-6, 20e-6], number % 2 == 0, 4)
    });
    let all: Vec<Vec<Judged>> = cases.collect();
    let [inside, _, of_steps] = summed_up_by_steps(&all, &steps);
    // Of so few and short runs, with five checks each, both numbers scatter.
    assert!(all.len() > 8 && inside >= 0.85 && of_steps < 20.0);
}

#[test]
#[ignore = "nightly: 200 random scenes with five lengths of steps, five minutes"]
fn the_error_of_random_scenes_is_stated() {
    for (every, seconds) in [(32, 12.0), (4, 4.0)] {
        println!("a check in {every}, {seconds} s");
        let mut random = Random(7_000_003 + u64::from(every));
        let cases = (0..104).filter_map(|number| {
            Case::random(&mut random, number, seconds).judged::<4, 1>(&STEPS, EXACT, number % 8 < 4, every)
        });
        let all: Vec<Vec<Judged>> = cases.collect();
        let [inside, ratio, of_steps] = summed_up_by_steps(&all, &STEPS);
        assert!(all.len() >= 100 && inside >= 0.95 && of_steps <= 8.0 && ratio <= 20.0);
    }
}

#[test]
#[ignore = "nightly: the shipped scenes with ten modes each, some minutes"]
fn the_error_of_the_shipped_scenes_is_stated() {
    const TIP: f64 = 50e-3;
    let (light, heavy) = (Into::Resistor(1e6), Into::Resistor(1e5));
    let charging = Into::Store(4.7e-6, 1e12);
    let seconds = 6.0;
    let cases = [
        Case::shipped("bump-stop", [10e-6, TIP], light, [20.0, 220.0], seconds),
        Case::shipped("tip", [0.0, TIP], light, [20.0, 220.0], seconds),
        Case::shipped("mid-span", [0.0, 0.5 * TIP], light, [20.0, 220.0], seconds),
        Case {
            contact: AnyContact::NoStop,
            ..Case::shipped("none", [0.0, TIP], light, [20.0, 220.0], seconds)
        },
        Case::shipped("paper", [10e-6, TIP], heavy, [200.0, 44.0], seconds),
        Case::shipped("paper-mid-span", [10e-6, 0.5 * TIP], heavy, [200.0, 44.0], seconds),
        Case {
            contact: AnyContact::NoStop,
            ..Case::shipped("paper-none", [0.0, TIP], heavy, [200.0, 44.0], seconds)
        },
        Case::shipped("paper-charging", [10e-6, TIP], charging, [200.0, 44.0], seconds),
        Case {
            heavy: true,
            ..Case::shipped("tip-mass", [0.3e-3, 30e-3], Into::Resistor(40e3), [5.0, 55.0], seconds)
        },
    ];
    let mut all = Vec::new();
    for case in &cases {
        let runs = case.judged::<10, 10>(&STEPS, EXACT, false, 8).expect("brings energy");
        summed_up(&case.name, &runs);
        all.push(runs);
    }
    let [inside, ratio, of_steps] = summed_up_by_steps(&all, &STEPS);
    assert!(inside >= 0.95 && of_steps <= 8.0 && ratio <= 40.0);
}
