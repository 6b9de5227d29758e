//! Strategies beside each other: what each knows of its income, and how many actions it runs.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use harvester_scene::market::{Battery, Processor, Reservoir};

use super::Source;
use super::baseline::{Baseline, Rule};
use super::harvester::Kind;
use super::oracle::{Oracle, Planned};
use super::plant::{Hour, Parts, Run, World};
use super::settings::{INCOME, Settings, begin_v};
use super::timeline::{Course, Timeline};
use crate::method::Failure;
use crate::run::try_each;

/// How a node knows its income and decides on its actions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Name {
    Voltage,
    Map,
    Difference,
    Ewma,
    Fixed,
    Intermittent,
    Oracle,
}

impl Name {
    pub const ALL: [Self; 7] = {
        use Name::*;
        [Voltage, Map, Difference, Ewma, Fixed, Intermittent, Oracle]
    };
}

/// A storage: its capacitance in F, its leakage resistance in Ω, how far its capacitance or its charge may be off at most, and the mean
/// income in W of a node on it. One with the word of a battery has this battery beside the capacitor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Storage {
    pub name: &'static str,
    pub capacitance: f64,
    pub leakage: f64,
    pub of_capacitance: f64,
    pub income: f64,
    /// Shortest time in s from an action to the next.
    pub every: u32,
}

impl Storage {
    /// An exact capacitor without leakage, and an income of 2.9 µW.
    pub const fn capacitor(capacitance: f64) -> Self {
        Self {
            name: "capacitor",
            capacitance,
            leakage: f64::INFINITY,
            of_capacitance: 0.0,
            income: INCOME,
            every: 40,
        }
    }

    const fn supercapacitor(capacitance: f64, leakage: f64, income: f64) -> Self {
        Self { name: "supercapacitor", leakage, of_capacitance: 0.2, income, ..Self::capacitor(capacitance) }
    }

    const fn battery(name: &'static str, of_capacitance: f64, income: f64) -> Self {
        Self { name, of_capacitance, income, ..Self::capacitor(100e-6) }
    }

    /// Those of a node on it.
    pub(super) fn settings(&self, kind: Kind, processor: Processor, spread: f64) -> Settings {
        let Self { name, capacitance, leakage, of_capacitance, income, every } = *self;
        let base = Settings::new(kind, processor, capacitance, spread).with_income(income);
        let base = Settings { leakage, of_capacitance: of_capacitance / 3.0_f64.sqrt(), every, ..base };
        let base = Battery::named(name).map_or(base, |battery| base.with_battery(battery));
        // One that does not hold an action is a buffer.
        if base.room() > base.action { base } else { base.with_buffer() }
    }

    fn reservoir(&self) -> Reservoir {
        let Self { name, capacitance, leakage, .. } = *self;
        Reservoir { capacitance_f: capacitance, leakage_ohm: leakage, battery: Battery::named(name) }
    }
}

/// Those of the rows, each with an income above its leakage. The first six are those of years.
pub const STORAGES: [Storage; 11] = [
    Storage::capacitor(0.47e-3),
    Storage::capacitor(1e-3),
    Storage::capacitor(10e-3),
    Storage::capacitor(0.1),
    Storage::supercapacitor(0.2, 40e6, INCOME),
    Storage::supercapacitor(1.0, 10e6, INCOME),
    Storage::supercapacitor(10.0, 1e6, 10.0 * INCOME),
    // A ceramic capacitor of 500 Ω F, as the data sheets have it.
    Storage { name: "buffer", leakage: 30e6, of_capacitance: 0.2, ..Storage::capacitor(17e-6) },
    Storage::battery("slb12400l151", 0.1, 10.0 * INCOME),
    Storage::battery("apr18650m1b", 0.05, 100.0 * INCOME),
    // Actions take a sixth of the income: it is full for most of the time.
    Storage { name: "full", every: 600, ..Storage::capacitor(1e-3) },
];
/// Relative deviations of the standing power: measured, and by data sheets.
const SPREADS: [f64; 2] = [0.01, 0.2];
pub(crate) const PARTS: [&str; 3] = ["nrf52832", "stm32l051", "apollo3"];
/// Number of [`rows`] of a part with a storage.
pub(crate) const ROWS: usize = SPREADS.len() * Name::ALL.len();
/// How far a leakage may be off at most.
const OF_LEAKAGE: f64 = 0.5;
/// Standard deviation of the gain of the map of a harvester as designed.
const DESIGNED_GAIN: f64 = 0.1;
/// Seconds between the actions of `fixed`; where they may follow each other in less than the first, in proportion.
const PERIODS: [u32; 18] =
    [40, 50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 160, 180, 200, 240, 300, 600, 1200];

/// What rows are of.
#[derive(Debug, Clone, PartialEq)]
pub struct Extent {
    pub kinds: Vec<Kind>,
    pub courses: Vec<Course>,
    /// Names of market parts.
    pub parts: Vec<&'static str>,
    pub storages: Vec<Storage>,
    /// Whether only harvesters as designed count.
    pub as_designed: bool,
    /// Of a timeline.
    pub hours: usize,
    /// Noises of the converter and true parts with which each timeline is run.
    pub seeds: u64,
}

/// Whether a course moves a harvester: friction holds a slider under random vibration and under steps.
pub(super) fn moves(kind: Kind, course: Course) -> bool {
    !kind.is_slider() || !matches!(course, Course::Truck | Course::Rail | Course::Walking)
}

/// The timelines of an extent that move it, as designed and off. Refuses energies for which no node can be built.
pub(crate) fn timelines(extent: &Extent) -> Result<Vec<Timeline>, Failure> {
    let mut all = Vec::new();
    for &kind in &extent.kinds {
        for &course in &extent.courses {
            let seed = 17 * kind as u64 + 1000 * course as u64;
            all.extend(
                [(kind, true, course, seed + 1), (kind, false, course, seed)].into_iter().filter(
                    |&(_, as_designed, ..)| moves(kind, course) && (as_designed || !extent.as_designed),
                ),
            );
        }
    }
    let of_course = |&(kind, as_designed, course, seed): &_| {
        let line = Timeline::new(kind, as_designed, course, extent.hours, seed)?;
        let settings = Settings::new(kind, Processor::named(PARTS[0]).expect("a part"), 1e-3, 0.2);
        let built = settings.scaled(&line.minutes).try_map().map(|_| line);
        built.map_err(|reason| Failure::Input(format!("no node has such a harvester: {reason}")))
    };
    try_each(&all, of_course)
}

/// Errors of hours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    pub hours: usize,
    /// Share of hours inside their bound.
    pub inside: f64,
    /// Medians of the error and of the bound over the truth, of hours with an income.
    pub median: f64,
    pub bound: f64,
}

impl Errors {
    pub fn of<'a>(hours: impl Iterator<Item = &'a Hour>) -> Self {
        let hours: Vec<&Hour> = hours.collect();
        let median = |of: fn(&Hour) -> f64| {
            let mut values: Vec<f64> =
                hours.iter().filter(|hour| hour.truth > 0.0).map(|hour| of(hour) / hour.truth).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
        };
        let inside = hours.iter().filter(|hour| hour.is_inside()).count();
        Self {
            hours: hours.len(),
            inside: inside as f64 / hours.len() as f64,
            median: median(|hour| (hour.estimated - hour.truth).abs()),
            bound: median(|hour| hour.bound),
        }
    }
}

/// What a strategy came to on some timelines.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Totals {
    /// Hours by timeline, noise, and end.
    pub hours: BTreeMap<[usize; 3], Hour>,
    pub runs: u32,
    /// Means over the runs.
    pub share: f64,
    pub shunted: f64,
    pub actions: u32,
    /// Of an oracle that ends each run with as much, up to the reserve; `None` if one of the runs has no schedule without a lock-out.
    pub actions_of_oracle: Option<u32>,
    pub lock_outs: u32,
}

impl Totals {
    /// Errors of the hours that another strategy knows with the same begin and end, without a full storage or a silent reading of either.
    fn paired(&self, other: &Self) -> Errors {
        let is_known = |hour: &Hour| hour.full + hour.silent == 0.0;
        let is_same = |one: &Hour, of: &Hour| one.truth == of.truth && is_known(one) && is_known(of);
        let is_paired = |(at, one): &(&_, &Hour)| other.hours.get(*at).is_some_and(|of| is_same(one, of));
        Errors::of(self.hours.iter().filter(is_paired).map(|(_, hour)| hour))
    }
}

/// A market part with a storage, and how far the standing power may be off at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    pub processor: Processor,
    pub storage: Storage,
    pub spread: f64,
    pub seeds: u64,
}

impl Setup {
    pub(super) fn settings(&self, line: &Timeline) -> Settings {
        let gain = if line.as_designed { DESIGNED_GAIN } else { 1.0 };
        let base = self.storage.settings(line.kind, self.processor, self.spread);
        Settings { gain, ..base }.scaled(&line.minutes)
    }

    fn world<'a>(&self, line: &'a Timeline, seed: u64) -> World<'a> {
        let mut random = Source::of_seed(seed);
        let mut off = |most: f64| 1.0 + most * (2.0 * random.uniform(0.0, 1.0) - 1.0);
        let (standing, capacitance) = (off(self.spread), off(self.storage.of_capacitance));
        let parts = Parts { standing, capacitance, leakage: off(OF_LEAKAGE), ..Parts::AS_STATED };
        World::new(&self.settings(line), (&line.minutes, &line.vibration), parts, seed)
    }

    /// A run of a strategy on a timeline; `period` in s is of `fixed`.
    pub fn run(&self, name: Name, line: &Timeline, seed: u64, period: u32) -> Run {
        let (world, settings) = (self.world(line, seed), self.settings(line));
        let baseline = |rule| Baseline::new(&settings, rule);
        match name {
            Name::Voltage => match settings.battery {
                Some(battery) => world.run(&mut settings.voltage_on(battery), |_| {}),
                None => world.run(&mut settings.voltage(), |_| {}),
            },
            Name::Map => match settings.battery {
                Some(battery) => world.run(&mut settings.map_on(battery), |_| {}),
                None => world.run(&mut settings.map(), |_| {}),
            },
            Name::Difference => world.run(&mut baseline(Rule::Difference), |_| {}),
            Name::Ewma => world.run(&mut baseline(Rule::ewma()), |_| {}),
            Name::Fixed => {
                world.run(&mut baseline(Rule::Fixed(period * settings.every / PERIODS[0])), |_| {})
            }
            Name::Intermittent => world.run(&mut baseline(Rule::Fixed(settings.every)), |_| {}),
            Name::Oracle => {
                let seconds = 60 * line.minutes.len();
                let schedule = |end| Oracle::new(&world, seconds, end).schedule();
                let acted = schedule(f64::INFINITY).or_else(|| schedule(0.0)).unwrap_or_default();
                world.run(&mut Planned::new(acted), |_| {})
            }
        }
    }

    /// Runs a strategy on all timelines with each noise.
    pub fn run_all(&self, name: Name, lines: &[Timeline]) -> Totals {
        let runs = lines.len() as u32 * self.seeds as u32;
        let mut totals = Totals { runs, actions_of_oracle: Some(0), ..Totals::default() };
        let periods = if name == Name::Fixed { self.periods(lines) } else { vec![0; lines.len()] };
        for (number, (line, period)) in lines.iter().zip(periods).enumerate() {
            for noise in 0..self.seeds {
                let seed = number as u64 + 1000 * noise;
                let run = self.run(name, line, seed, period);
                let end = run.stored.last().copied().unwrap_or(0.0);
                let oracle = Oracle::new(&self.world(line, seed), run.stored.len() - 1, end).schedule();
                let both = totals.actions_of_oracle.zip(oracle);
                totals.actions_of_oracle = both.map(|(sum, acted)| sum + acted.len() as u32);
                totals.share += run.share / f64::from(runs);
                totals.shunted += run.shunted / f64::from(runs);
                totals.actions += run.actions;
                totals.lock_outs += run.lock_outs;
                let places = run.hours.iter().map(|hour| ([number, noise as usize, hour.index], *hour));
                totals.hours.extend(places);
            }
        }
        totals
    }

    /// For each timeline the period in s that has most actions on the others, among those with the fewest lock-outs.
    fn periods(&self, lines: &[Timeline]) -> Vec<u32> {
        let tried = |(number, line): (usize, &Timeline)| {
            PERIODS.map(|period| {
                let run = self.run(Name::Fixed, line, number as u64, period);
                [run.lock_outs, run.actions]
            })
        };
        let tried: Vec<_> = lines.iter().enumerate().map(tried).collect();
        let best = |left_out: usize| {
            let others = |index: usize| {
                let others = tried.iter().enumerate().filter(|(at, _)| *at != left_out);
                others.map(|(_, of)| of[index]).fold([0; 2], |sum, of| [sum[0] + of[0], sum[1] + of[1]])
            };
            let order = |index: &usize| (others(*index)[0], Reverse(others(*index)[1]));
            PERIODS[(0..PERIODS.len()).min_by_key(order).unwrap_or(0)]
        };
        (0..lines.len()).map(best).collect()
    }
}

/// What a strategy came to with a part and a storage.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Row {
    pub strategy: Name,
    pub part: &'static str,
    pub storage: &'static str,
    /// Of a battery its charge over the voltage, at half charge.
    pub capacitance_f: f64,
    /// Mean income and leakage at the start.
    pub income_w: f64,
    pub leakage_w: f64,
    pub draw_spread: f64,
    pub share: f64,
    pub error_median: f64,
    pub bound_median: f64,
    pub inside: f64,
    pub hours: usize,
    /// Medians over those of `difference`, of the same hours of both.
    pub error_over_difference: f64,
    pub bound_over_difference: f64,
    pub actions: u32,
    pub actions_of_oracle: Option<u32>,
    pub lock_outs: u32,
    pub shunted: f64,
    /// Of the hours in which the storage was full for more than half of the time.
    pub error_full: f64,
    pub bound_full: f64,
    pub inside_full: f64,
    pub hours_full: usize,
}

/// The rows of all strategies, parts and storages on some timelines; `done` is called after each.
pub fn rows(extent: &Extent, lines: &[Timeline], done: impl Fn()) -> Vec<Row> {
    let mut rows = Vec::new();
    for processor in extent.parts.iter().filter_map(|part| Processor::named(part)) {
        for &storage in &extent.storages {
            for spread in SPREADS {
                let setup = Setup { processor, storage, spread, seeds: extent.seeds };
                let all = Name::ALL.map(|name| {
                    done();
                    setup.run_all(name, lines)
                });
                let difference = &all[Name::Difference as usize];
                rows.extend(
                    Name::ALL.into_iter().zip(&all).map(|(name, of)| Row::new(name, &setup, of, difference)),
                );
            }
        }
    }
    rows
}

/// A number of a row, of which the smaller is the better, and its name.
type Judged = (&'static str, fn(&Row) -> f64);
const JUDGED: [Judged; 5] = [
    ("error", |row| row.error_over_difference),
    ("bound", |row| row.bound_over_difference),
    ("hours inside", |row| -row.inside),
    ("actions", |row| -f64::from(row.actions)),
    ("lock-outs", |row| f64::from(row.lock_outs)),
];

/// In how many of the [`rows`] each tier is at least as good as the difference of two readings, as a sentence.
pub(crate) fn summary(rows: &[Row]) -> String {
    let of = |tier: Name| {
        let judged = JUDGED.map(|(name, number)| {
            let both = rows
                .chunks(Name::ALL.len())
                .map(|all| [tier, Name::Difference].map(|of| number(&all[of as usize])));
            let known: Vec<[f64; 2]> = both.filter(|both| both.iter().all(|one| one.is_finite())).collect();
            format!("{name} {} of {}", known.iter().filter(|[own, other]| own <= other).count(), known.len())
        });
        format!("{} in {}", format!("{tier:?}").to_lowercase(), judged.join(", "))
    };
    let tiers = [Name::Voltage, Name::Map].map(of).join("; ");
    format!("Rows in which a tier is at least as good as the difference of two readings: {tiers}.")
}

impl Row {
    fn new(strategy: Name, setup: &Setup, totals: &Totals, difference: &Totals) -> Self {
        let errors = Errors::of(totals.hours.values().filter(|hour| hour.full == 0.0));
        let of_full = Errors::of(totals.hours.values().filter(|hour| hour.full > 0.5));
        let [own, other] = [totals.paired(difference), difference.paired(totals)];
        let reservoir = setup.storage.reservoir();
        let begin = begin_v(reservoir.battery);
        let stored = reservoir.energy_j(begin);
        Self {
            strategy,
            part: setup.processor.name,
            storage: setup.storage.name,
            capacitance_f: reservoir.differential_f(begin),
            income_w: setup.storage.income,
            leakage_w: reservoir.leaking(stored) * stored,
            draw_spread: setup.spread,
            share: totals.share,
            error_median: errors.median,
            bound_median: errors.bound,
            inside: errors.inside,
            hours: errors.hours,
            error_over_difference: own.median / other.median,
            bound_over_difference: own.bound / other.bound,
            actions: totals.actions,
            actions_of_oracle: totals.actions_of_oracle,
            lock_outs: totals.lock_outs,
            shunted: totals.shunted,
            error_full: of_full.median,
            bound_full: of_full.bound,
            inside_full: of_full.inside,
            hours_full: of_full.hours,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_counts_the_rows_in_which_a_tier_is_no_worse() {
        let setup = Setup {
            processor: Processor::named(PARTS[0]).expect("a part"),
            storage: STORAGES[0],
            spread: 0.01,
            seeds: 1,
        };
        let row = |name: Name, actions, lock_outs| {
            let totals = Totals { actions, lock_outs, ..Totals::default() };
            let known = Row::new(name, &setup, &totals, &totals);
            Row { inside: 1.0, error_over_difference: f64::from(lock_outs), ..known }
        };
        let others = |name: Name| row(name, 5, 5);
        let of = |voltage: Row, map: Row| {
            let mut all = Name::ALL.map(others);
            (all[0], all[1]) = (voltage, map);
            all
        };
        let [voltage, map] = [Name::Voltage, Name::Map];
        let rows = [of(row(voltage, 6, 5), row(map, 4, 6)), of(row(voltage, 5, 4), row(map, 5, 9))].concat();
        let text = summary(&rows);
        // The bound of no row is known.
        let counts = "voltage in error 2 of 2, bound 0 of 0, hours inside 2 of 2, actions 2 of 2, lock-outs 2 of 2; \
                      map in error 0 of 2, bound 0 of 0, hours inside 2 of 2, actions 1 of 2, lock-outs 0 of 2.";
        assert!(text.ends_with(counts), "{text}");
    }
}
