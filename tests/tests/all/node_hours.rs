//! Nodes over hours of random shaking: what they say of the income against what the true harvester yields.
//!
//! The truth is the full model: a trajectory in `f64` over every second of every hour, at a tolerance of 10⁻³, into a
//! resistor (the matched converter of `node.toml`). What it delivers in a minute flows evenly into the storage. The node has
//! the map of the harvester as designed, made by
//!
//! ```text
//! host-bench map node.toml --amplitude 0.1:4 --frequency 17:24 --output node.bin
//! host-bench map sliding.toml --amplitude 2:8 --frequency 16:21 --output sliding.bin
//! host-bench map bump-stop-none.toml --amplitude 1:50 --frequency 200:280 --output bump-stop-none.bin
//! ```
//!
//! and hears 16-bit samples of the shaking with gravity and noise. Energies are scaled so that the mean income is 2.9 µW.

mod beating;
mod below_the_map;
mod converter;
mod difference;
mod plant;
mod truth;
mod wavering;

use std::collections::BTreeMap;

use harvester_scene::market::Processor;
use model_core::snapshot::{self, image_size};
use plant::{AS_STATED, Build, Hour, OneNode, OneState, Plant, Run, Source, Strategy, World};
use truth::{AS_DESIGNED, KINDS, Kind, Off, Shaking, WEATHERS, Weather, hour};

/// Noises of the converter and the sensor, and true draws, with which each random timeline is run.
const NOISES: u64 = 4;

/// Standard deviation of the gain of a map of which nothing was measured.
const GAIN: f32 = 1.0;
/// Of a harvester as designed.
const DESIGNED_GAIN: f32 = 0.1;
/// Mean income in W to which a harvester is scaled.
const INCOME: f64 = 2.9e-6;

fn map(kind: Kind) -> &'static [u8] {
    match kind {
        Kind::ContactSeparation => include_bytes!("node_hours/node.bin"),
        Kind::Sliding => include_bytes!("node_hours/sliding.bin"),
        Kind::BumpStop => include_bytes!("node_hours/bump-stop-none.bin"),
    }
}

/// Some hours of a harvester.
struct Timeline {
    kind: Kind,
    /// Whether the harvester is the one of the map.
    as_designed: bool,
    weathers: Vec<Weather>,
    shaking: Vec<Shaking>,
    /// Energies in J.
    minutes: Vec<f64>,
}

impl Timeline {
    /// Random hours. A harvester that is not as designed is off in charge, damping, load and resonance, and its resonance
    /// drifts by 2 % in some hours.
    fn random(kind: Kind, as_designed: bool, hours: usize, seed: u64) -> Self {
        let mut random = Source(seed);
        let (mut shaking, mut weathers) = (Vec::new(), Vec::<Weather>::new());
        for _ in 0..hours {
            let weather = WEATHERS[(random.uniform() * 7.0) as usize % WEATHERS.len()];
            // Friction holds the slider under most noises.
            let still = kind == Kind::Sliding && weather == Weather::Broadband;
            let weather = if still { Weather::Tone } else { weather };
            // A tone goes on for some hours.
            let goes_on = weather == Weather::Tone && weathers.last() == Some(&Weather::Tone);
            if goes_on && random.uniform() < 0.6 {
                shaking.extend_from_within(shaking.len() - 60..);
            } else {
                shaking.extend(hour(kind, weather, &mut random));
            }
            weathers.push(weather);
        }
        let mut factor = |most: f64| most.powf(2.0 * random.uniform() - 1.0);
        let off = if as_designed {
            AS_DESIGNED
        } else {
            Off {
                charge: factor(1.41),
                damping: factor(1.7),
                resistance: factor(1.5),
                resonance: factor(1.005),
            }
        };
        let minutes = kind.minutes(&shaking, |minute| {
            let part = (minute % 60) as f64 / 60.0 - 0.5;
            let drifts = weathers[minute / 60] == Weather::Drift && !as_designed;
            Off { resonance: off.resonance * if drifts { 1.0 + 0.02 * part } else { 1.0 }, ..off }
        });
        Self { kind, as_designed, weathers, shaking, minutes }
    }

    /// A node on it, with random noise, and a standing power that is off by up to `spread`.
    fn run(&self, build: &Build, seed: u64) -> Run<OneState> {
        self.run_of(&self.node(build), build, 0.0, seed)
    }

    /// As [`Timeline::run`] of any node, with a capacitance that is off by up to `capacitance`.
    fn run_of<N: Strategy>(&self, node: &N, build: &Build, capacitance: f64, seed: u64) -> Run<N::State> {
        let mut random = Source(seed);
        let standing = 1.0 + build.spread * (2.0 * random.uniform() - 1.0);
        let capacitance = 1.0 + capacitance * (2.0 * random.uniform() - 1.0);
        let plant = Plant { standing, capacitance, ..AS_STATED };
        World::new(build, node, (&self.minutes, &self.shaking), plant, seed).run(|state| state)
    }

    /// What the energies of a node are scaled by.
    fn scale(&self, build: &Build) -> f64 {
        build.income / (self.minutes.iter().sum::<f64>() / (60.0 * self.minutes.len() as f64))
    }

    fn node(&self, build: &Build) -> OneNode {
        build.node(map(self.kind), self.scale(build), 0.0, GAIN)
    }
}

/// A node with an action of 0.3 mJ as often as the income allows, and a third of its storage as reserve.
fn build(kind: Kind, processor: Processor, capacitance: f64, spread: f64) -> Build {
    Build {
        kind,
        capacitance,
        processor,
        income: INCOME,
        standing: 0.3e-6,
        spread,
        of_action: 0.0,
        of_highest: 0.0,
        action: 0.3e-3,
        every: 40,
        reserve: 0.3 * 0.5 * capacitance * (4.5 * 4.5 - 1.8 * 1.8),
    }
}

/// Errors of hours.
struct Errors {
    hours: usize,
    /// Share of hours inside their bound.
    inside: f64,
    /// Medians of the error and of the bound over the truth.
    median: f64,
    bound: f64,
}

impl Errors {
    fn of<'a>(hours: impl Iterator<Item = &'a Hour>) -> Self {
        let hours: Vec<&Hour> = hours.collect();
        let sorted = |of: fn(&Hour) -> f64| {
            let mut values: Vec<f64> = hours.iter().map(|hour| of(hour)).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let at = |values: &[f64], part: f64| {
            values.get((values.len() as f64 * part) as usize).copied().unwrap_or(f64::NAN)
        };
        let errors = sorted(|hour| (hour.told - hour.truth).abs() / hour.truth);
        let inside = hours.iter().filter(|hour| (hour.told - hour.truth).abs() <= hour.bound).count();
        Self {
            hours: hours.len(),
            inside: inside as f64 / hours.len() as f64,
            median: at(&errors, 0.5),
            bound: at(&sorted(|hour| hour.bound / hour.truth), 0.5),
        }
    }
}

#[test]
fn hours_of_a_small_storage_are_known_for_a_hundredth_of_the_income() {
    let line = Timeline::random(Kind::ContactSeparation, true, 4, 3);
    let run = line.run(&build(line.kind, Processor::named("nrf52832").expect("a part"), 1e-3, 0.01), 5);
    assert!(run.share < 0.01 && run.lock_outs == 0 && run.actions > 10, "{run:?}");
    assert_eq!(run.hours.len(), 4);
    let errors = Errors::of(run.hours.iter());
    assert!(errors.median < 0.02, "{:?}", run.hours);
    for hour in run.hours.iter().filter(|hour| hour.silent == 0.0) {
        assert!((hour.told - hour.truth).abs() <= hour.bound, "{hour:?}");
        // Of 2.9 µW.
        assert!(hour.bound < 0.1 * run.hours.iter().map(|hour| hour.truth).sum::<f64>() / 4.0, "{hour:?}");
    }
    // The hours and the whole are the same income, up to what was heard later.
    let told: f64 = run.hours.iter().map(|hour| hour.told).sum();
    let all = line
        .node(&build(line.kind, Processor::named("nrf52832").expect("a part"), 1e-3, 0.01))
        .overall(&run.state);
    assert!((f64::from(all.energy) / told - 1.0).abs() < 0.02, "{all:?} {told}");
}

#[test]
fn a_node_that_is_restored_from_its_image_after_each_sleep_ends_with_the_same_bits() {
    let line = Timeline::random(Kind::ContactSeparation, true, 1, 4);
    let build = build(line.kind, Processor::named("nrf52832").expect("a part"), 1e-3, 0.2);
    let node = line.node(&build);
    let world = || {
        let plant = Plant { standing: 1.1, ..AS_STATED };
        World::new(&build, &node, (&line.minutes, &line.shaking), plant, 9)
    };
    let whole = world().run(|state| state);
    let (mut slots, mut sequence) = ([vec![0xff_u8; 1024], vec![0xff; 1024]], 0);
    let restored = world().run(|state| {
        sequence += 1;
        let size = snapshot::save_image(&node, &state, sequence, &mut slots[sequence as usize % 2]);
        assert_eq!(size, Ok(image_size::<OneNode>()));
        let image = snapshot::newest_image(&node, [&slots[0], &slots[1]]).expect("whole");
        assert_eq!(image.sequence, sequence);
        image.state
    });
    assert!(sequence > 20, "{sequence}");
    assert_eq!(whole, restored);
    // An image of a node with another storage is foreign.
    let other = line.node(&Build { capacitance: 1.01e-3, ..build });
    let foreign = snapshot::newest_image(&other, [&slots[0], &slots[1]]);
    assert_eq!(foreign.err(), Some(snapshot::SnapshotError::ForeignModel));
}

#[test]
#[ignore = "nightly: trajectories over 240 hours, minutes"]
fn random_hours_of_three_harvesters() {
    let mut lines = Vec::new();
    for kind in KINDS {
        for as_designed in [true, false] {
            for case in 0..4 {
                let seed = 1000 * case + 17 * kind as u64 + u64::from(as_designed);
                lines.push(Timeline::random(kind, as_designed, 10, seed));
            }
        }
    }
    println!(
        "| part | storage | draw | harvester | share, mean | largest | hours | inside | error, median | bound, median \
         | storage told: hours | inside | error, median | lock-outs |"
    );
    println!("{}|", "| --- ".repeat(14));
    let mut all_hours = Vec::new();
    for processor in [
        Processor::named("nrf52832").expect("a part"),
        Processor::named("apollo3").expect("a part"),
        Processor::named("stm32l051").expect("a part"),
    ] {
        for capacitance in [0.47e-3, 1e-3, 10e-3, 0.1] {
            for spread in [0.2, 0.01] {
                for as_designed in [true, false] {
                    let (share, hours) = row(&lines, &processor, capacitance, spread, as_designed);
                    assert!(share <= 0.01, "{share}");
                    let errors = Errors::of(hours.iter().map(|(_, hour)| hour));
                    assert!(errors.inside >= 0.95, "{}", errors.inside);
                    all_hours.extend(hours);
                }
            }
        }
    }
    by_weather(&all_hours);
    let all = Errors::of(all_hours.iter().map(|(_, hour)| hour));
    assert!(all.inside >= 0.99, "{}", all.inside);
}

/// What a strategy came to on some timelines.
#[derive(Default)]
struct Came {
    /// Hours by timeline, noise, and end.
    hours: BTreeMap<[usize; 3], Hour>,
    share: f64,
    actions: u32,
    lock_outs: u32,
    shunted: f64,
}

/// A storage with a market part: capacitance in F, and how far it and the standing power may be off at most.
struct Part {
    processor: Processor,
    capacitance: f64,
    spread: f64,
    of_capacitance: f64,
    /// Noises of the converter with which each timeline is run.
    noises: u64,
}

impl Part {
    fn run<N: Strategy>(&self, lines: &[Timeline], node: impl Fn(&Build, &Timeline, f32) -> N) -> Came {
        let mut came = Came::default();
        let runs = lines.len() as f64 * self.noises as f64;
        for (number, line) in lines.iter().enumerate() {
            let build = build(line.kind, self.processor, self.capacitance, self.spread);
            let node = node(&build, line, (self.of_capacitance / 3.0_f64.sqrt()) as f32);
            for noise in 0..self.noises {
                let run = line.run_of(&node, &build, self.of_capacitance, number as u64 + 1000 * noise);
                came.share += run.share / runs;
                came.shunted += run.shunted / runs;
                came.actions += run.actions;
                came.lock_outs += run.lock_outs;
                let places = run.hours.iter().map(|hour| ([number, noise as usize, hour.index], *hour));
                came.hours.extend(places);
            }
        }
        came
    }

    /// Prints a row of a strategy: its errors in the hours that are `paired`, and what it came to in all.
    fn row(&self, name: &str, came: &Came, is_paired: impl Fn(&[usize; 3]) -> bool) -> [Errors; 2] {
        let paired = came.hours.iter().filter(|(place, _)| is_paired(place)).map(|(_, hour)| hour);
        let (errors, all) = (Errors::of(paired), Errors::of(came.hours.values()));
        println!(
            "| {} | {} mF ±{:.0} % | ±{:.0} % | {name} | {:.3} % | {:.3} % | {:.2} % | {:.1} % of {} | {:.3} % | {:.1} % \
             | {:.1} % | {} | {} | {:.1} % |",
            self.processor.name,
            1e3 * self.capacitance,
            100.0 * self.of_capacitance,
            100.0 * self.spread,
            100.0 * came.share,
            100.0 * errors.median,
            100.0 * errors.bound,
            100.0 * errors.inside,
            errors.hours,
            100.0 * all.median,
            100.0 * all.bound,
            100.0 * all.inside,
            came.actions,
            came.lock_outs,
            100.0 * came.shunted
        );
        [errors, all]
    }

    /// Prints the rows of the strategies, the first errors over the hours that all know, and compares them.
    fn compare(&self, lines: &[Timeline]) {
        let voltage = self.run(lines, |build, line, of| build.voltage_node(line.scale(build), of));
        let difference = self.run(lines, |build, line, of| build.difference(line.scale(build), of));
        let by_map = self.run(lines, |build, line, of| {
            let gain = if line.as_designed { DESIGNED_GAIN } else { GAIN };
            build.node(map(line.kind), line.scale(build), of, gain)
        });
        let is_paired = |place: &[usize; 3]| {
            let hours = voltage.hours.get(place).zip(difference.hours.get(place));
            hours.is_some_and(|(one, other)| one.silent == 0.0 && one.truth == other.truth)
        };
        let [by_difference, _] = self.row("difference", &difference, is_paired);
        let [by_voltage, all] = self.row("voltage", &voltage, is_paired);
        let [of_map, all_of_map] = self.row("map", &by_map, is_paired);
        assert!(all.inside >= 0.95 && by_voltage.inside >= 0.95 && by_voltage.hours > 0);
        assert!(all_of_map.inside >= 0.95 && of_map.inside >= 0.95);
        // Medians of runs whose actions fall at other times scatter by some hundredths.
        let most = 1.1;
        assert!(by_voltage.median <= most * by_difference.median);
        let is_told = all.hours == all_of_map.hours && voltage.shunted == 0.0;
        assert!(!is_told || by_map.share <= 1.3 * voltage.share, "{} {}", by_map.share, voltage.share);
        assert!(by_voltage.bound <= 1.06 * by_difference.bound);
        // What is stored at the end is up to an action more or less.
        assert!(voltage.actions + (lines.len() as u32 * self.noises as u32) >= difference.actions);
        assert!(voltage.lock_outs <= difference.lock_outs);
    }
}

#[test]
fn the_voltage_alone_is_as_good_as_the_difference_of_two_readings() {
    let lines = [Timeline::random(Kind::ContactSeparation, true, 4, 3)];
    for (capacitance, spread) in [(10e-3, 0.01), (0.1, 0.2)] {
        Part {
            processor: Processor::named("nrf52832").expect("a part"),
            capacitance,
            spread,
            of_capacitance: 0.0,
            noises: 40,
        }
        .compare(&lines);
    }
}

#[test]
#[ignore = "nightly: trajectories over 60 hours, a minute"]
fn the_voltage_alone_is_as_good_as_the_difference_on_each_storage() {
    let lines = KINDS.map(|kind| {
        [true, false].map(|as_designed| {
            Timeline::random(kind, as_designed, 10, 17 * kind as u64 + u64::from(as_designed))
        })
    });
    println!(
        "| part | storage | draw | | share | error | bound | inside | error of all | bound | inside | actions | lock-outs | shunted |"
    );
    println!("{}|", "| --- ".repeat(14));
    for processor in [
        Processor::named("nrf52832").expect("a part"),
        Processor::named("apollo3").expect("a part"),
        Processor::named("stm32l051").expect("a part"),
    ] {
        for (capacitance, of_capacitance) in
            [(0.47e-3, 0.0), (1e-3, 0.0), (10e-3, 0.0), (10e-3, 0.2), (0.1, 0.0)]
        {
            for spread in [0.2, 0.01] {
                Part { processor, capacitance, spread, of_capacitance, noises: NOISES }
                    .compare(lines.as_flattened());
            }
        }
    }
}

/// Prints a row of the table: the mean share, and the hours.
fn row(
    lines: &[Timeline],
    processor: &Processor,
    capacitance: f64,
    spread: f64,
    as_designed: bool,
) -> (f64, Vec<(Weather, Hour)>) {
    let (mut shares, mut hours, mut lock_outs) = (Vec::new(), Vec::new(), 0);
    for (number, line) in lines.iter().enumerate().filter(|(_, line)| line.as_designed == as_designed) {
        for noise in 0..NOISES {
            let seed = number as u64 + 1000 * noise;
            let run = line.run(&build(line.kind, *processor, capacitance, spread), seed);
            shares.push(run.share);
            lock_outs += run.lock_outs;
            let last = line.weathers.len() - 1;
            hours.extend(run.hours.iter().map(|hour| (line.weathers[hour.index.min(last)], *hour)));
        }
    }
    let share = shares.iter().sum::<f64>() / shares.len() as f64;
    let all = Errors::of(hours.iter().map(|(_, hour)| hour));
    let told = Errors::of(hours.iter().map(|(_, hour)| hour).filter(|hour| hour.silent == 0.0));
    println!(
        "| {} | {} mF | {} | {} | {:.2} % | {:.2} % | {} | {:.1} % | {:.2} % | {:.1} % | {} | {:.1} % | {:.2} % \
         | {lock_outs} |",
        processor.name,
        1e3 * capacitance,
        if spread < 0.1 { "known" } else { "±20 %" },
        if as_designed { "as designed" } else { "off" },
        100.0 * share,
        100.0 * shares.iter().copied().fold(0.0, f64::max),
        all.hours,
        100.0 * all.inside,
        100.0 * all.median,
        100.0 * all.bound,
        told.hours,
        100.0 * told.inside,
        100.0 * told.median,
    );
    (share, hours)
}

/// Prints the errors by what shook the harvester.
fn by_weather(hours: &[(Weather, Hour)]) {
    for weather in WEATHERS {
        let of = Errors::of(hours.iter().filter(|(at, _)| *at == weather).map(|(_, hour)| hour));
        println!(
            "| {weather:?} | {} | {:.1} % | {:.2} % | {:.1} % |",
            of.hours,
            100.0 * of.inside,
            100.0 * of.median,
            100.0 * of.bound
        );
    }
}

#[test]
fn a_week_of_the_larger_harvester_costs_less_than_a_hundredth_and_never_locks_out() {
    // The hours of node.toml, at a line that wanders from hour to hour; two minutes of a trajectory for each hour.
    let day = [
        0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 0.7, 1.0, 1.0, 0.5, 1.0, 1.0, 1.0, 0.7, 1.0, 1.0, 1.0,
        0.5, 0.0, 0.0, 0.0,
    ];
    let kind = Kind::ContactSeparation;
    let mut random = Source(11);
    let hours: Vec<Shaking> = (0..7 * 24)
        .map(|hour| truth::tone(1.962 * day[hour % 24], 20.5 + 0.2 * (random.uniform() - 0.5)))
        .collect();
    let short: Vec<Shaking> = hours.iter().flat_map(|shaking| [shaking.clone(), shaking.clone()]).collect();
    let energies = kind.minutes(&short, |_| AS_DESIGNED);
    let minutes: Vec<f64> = (0..60 * hours.len()).map(|minute| energies[2 * (minute / 60) + 1]).collect();
    let shaking: Vec<Shaking> = (0..60 * hours.len()).map(|minute| hours[minute / 60].clone()).collect();
    let income = minutes.iter().sum::<f64>() / (60.0 * minutes.len() as f64);
    for processor in [
        Processor::named("nrf52832").expect("a part"),
        Processor::named("stm32l051").expect("a part"),
        Processor::named("apollo3").expect("a part"),
    ] {
        let build = Build {
            income,
            // Asleep with the clock running by the preset, and 1 µW of a converter.
            standing: processor.sleep_a.map_or(0.0, |sleep| sleep.0 * processor.supply_v) + 1e-6,
            // A measurement and a transmission of 6.6 mJ.
            action: 6.9e-3,
            every: 300,
            reserve: 0.3,
            of_action: 0.02,
            ..build(kind, processor, 0.2, 0.2)
        };
        let node = build.node(map(kind), 1.0, 0.0, GAIN);
        let plant = Plant { standing: 1.1, action: 0.98, ..AS_STATED };
        let run = World::new(&build, &node, (&minutes, &shaking), plant, 1).run(|state| state);
        let errors = Errors::of(run.hours.iter().filter(|hour| hour.truth > 1e-6 * 3600.0));
        println!(
            "{}: {income:.3e} W, {:.3} % on knowing, {} actions, {:.1} % shunted, {} readings, {} bursts, hours: \
             inside {:.1} %, median error {:.2} %",
            processor.name,
            100.0 * run.share,
            run.actions,
            100.0 * run.shunted,
            run.state.voltage().readings(),
            run.state.bursts(),
            100.0 * errors.inside,
            100.0 * errors.median,
        );
        assert!(run.share < 0.01 && run.lock_outs == 0, "{} {}", run.share, run.lock_outs);
        assert!(
            run.actions > 7 * 24 && errors.median < 0.05 && errors.inside > 0.9,
            "{errors:?}",
            errors = run.hours
        );
    }
}
