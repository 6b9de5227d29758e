//! What the voltage of a storage tells at rest, of rare shaking, after gaps with leakage, by coarse converters and by one that
//! ends below the full storage.

use super::plant_tests::{CASE, Case, LINE, OneNode, UNIT, line, map};
use super::{Gap, NodeState, Progress, Task, Tier};

/// A storage with an income by the second, a converter with normal noise, and the node, whose sensor hears a line while there is
/// an income.
struct Tank<'a, F> {
    case: Case,
    node: OneNode<'a>,
    income: F,
    energy: f64,
    second: u32,
    harvested: f64,
    random: u64,
    ran: u32,
    /// Income that was told of an hour, its bound and the truth.
    hours: Vec<[f64; 3]>,
}

impl<'a, F: Fn(u32) -> f64> Tank<'a, F> {
    fn new(case: Case, words: &'a [u16], voltage: f64, random: u64, income: F) -> Self {
        let energy = 0.5 * f64::from(case.capacitance) * voltage * voltage;
        let (node, hours) = (case.node(words), vec![]);
        Self { case, node, income, energy, second: 0, harvested: 0.0, random, ran: 0, hours }
    }

    /// Even from 0 to 1, by SplitMix64.
    fn uniform(&mut self) -> f64 {
        self.random = self.random.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.random;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn code(&mut self) -> u32 {
        // A sum of twelve has tails to six deviations.
        let normal = (0..12).map(|_| self.uniform() - 0.5).sum::<f64>();
        let voltage = (2.0 * self.energy / f64::from(self.case.capacitance)).sqrt();
        let cells =
            (voltage + f64::from(self.case.noise) * normal) / (f64::from(self.case.full_scale) / 4096.0);
        cells.round().clamp(0.0, 4095.0) as u32
    }

    fn pass(&mut self, seconds: u32, is_on: bool) {
        let [capacitance, leakage] = [self.case.capacitance, self.case.leakage].map(f64::from);
        let full = 0.5 * capacitance * 4.5 * 4.5;
        let standing = if is_on { self.case.power } else { 0.0 };
        for _ in 0..seconds {
            let income = (self.income)(self.second);
            let leaked = 2.0 * self.energy / capacitance / leakage;
            self.energy = (self.energy + income - standing - leaked).min(full);
            self.harvested += income;
            self.second += 1;
        }
    }

    /// Runs up to a second; off in the seconds of `off`. The state at the end.
    fn run(&mut self, until: u32, off: core::ops::Range<u32>) -> NodeState<32, 24, 1> {
        let mut state = self.node.start(0);
        let code = self.code();
        let mut wake = self.node.wake(&mut state, 0, Some(code));
        let mut before = 0.0;
        while self.second < until {
            let (spent, hour) = (state.spent_on_knowing(), state.last_hour());
            if off.contains(&self.second) {
                self.pass(off.end - self.second, false);
                let code = self.code();
                wake = self.node.wake_after(&mut state, Gap::OffUntil(self.second), Some(code));
            } else {
                let mut read = None;
                match wake.task {
                    Task::Run(_) => {
                        self.ran += 1;
                        self.energy -= f64::from(self.case.action);
                    }
                    Task::Sleep => {
                        self.pass(wake.again_in, true);
                        read = wake.read.then(|| self.code());
                    }
                    Task::Listen { samples } => {
                        let amplitude = if (self.income)(self.second) > 0.0 { LINE } else { 0.0 };
                        let of = |n: u32| (line(amplitude)(f64::from(n)) / UNIT).round() as i16;
                        let counts: Vec<i16> = (0..samples).map(of).collect();
                        assert!(matches!(self.node.samples(&mut state, &counts), Progress::Heard(_)));
                        self.pass(samples.div_ceil(100), true);
                    }
                }
                wake = self.node.wake(&mut state, self.second, read);
            }
            if let Some(told) = state.last_hour()
                && state.last_hour() != hour
            {
                let truth = self.harvested - before;
                self.hours.push([told.energy.into(), told.bound.into(), truth]);
                before = self.harvested;
            }
            self.energy -= f64::from(state.spent_on_knowing() - spent);
        }
        state
    }

    /// Number of hours outside their bounds.
    fn outside(&self) -> usize {
        self.hours.iter().filter(|[told, bound, truth]| (told - truth).abs() > *bound).count()
    }

    /// The income since the start is inside its bound.
    fn assert_overall(&self, state: &NodeState<32, 24, 1>) {
        let told = state.overall();
        let departure = (f64::from(told.energy) - self.harvested).abs();
        assert!(departure <= told.bound.into(), "{told:?}, {} J", self.harvested);
    }
}

const HOURS: u32 = 3600;

#[test]
fn the_noise_of_the_converter_makes_no_income() {
    let words = map(CASE.yields);
    for (capacitance, shortest_reading) in [(10e-3, 10), (47e-3, 10), (0.2, 10), (0.2, 60)] {
        let case = Case { power: 1e-8, capacitance, shortest_reading, reading_doublings: 0, ..CASE };
        let mut tank = Tank::new(case, &words, 3.5, 1, |_| 0.0);
        let state = tank.run(48 * HOURS, 0..0);
        assert!(tank.hours.len() >= 40 && tank.outside() <= 1, "{capacitance} F: {:?}", tank.hours);
        tank.assert_overall(&state);
    }
}

#[test]
fn readings_within_a_cell_are_no_more_exact_than_the_cell() {
    let words = map([1e-6, 3e-6]);
    for (noise, full_scale) in [(0.05e-3, 5.0), (0.2e-3, 5.0), (0.6e-3, 20.0)] {
        let case = Case {
            power: 0.3e-6,
            capacitance: 0.5,
            noise,
            full_scale,
            shortest_reading: 10,
            reading_doublings: 0,
            ..CASE
        };
        let mut tank = Tank::new(case, &words, 3.5, 2, |_| 1e-6);
        let state = tank.run(48 * HOURS, 0..0);
        assert!(tank.hours.len() >= 40 && tank.outside() <= 2, "{noise} V: {:?}", tank.hours);
        tank.assert_overall(&state);
    }
}

#[test]
fn the_hour_in_which_shaking_begins_after_a_long_rest_is_inside_its_bound() {
    for (capacitance, power, minutes) in
        [(47e-3, 0.5e-6, 10), (47e-3, 2e-6, 5), (0.2, 0.5e-6, 30), (0.2, 2e-6, 10)]
    {
        let words = map([power, 3.0 * power]);
        // Each eight hours.
        let income = |second: u32| if second % (8 * HOURS) >= 8 * HOURS - 60 * minutes { power } else { 0.0 };
        let case = Case { power: 1e-8, capacitance, ..CASE };
        let (mut shaken, mut outside, mut worst) = (0, 0, 0.0_f64);
        for random in 0..8 {
            let mut tank = Tank::new(case, &words, 3.5, random, income);
            tank.run(72 * HOURS, 0..0);
            shaken += tank.hours.iter().filter(|[_, _, truth]| *truth > 0.0).count();
            outside += tank.outside();
            let bounds = tank.hours.iter().map(|[told, bound, truth]| (told - truth).abs() / bound);
            worst = bounds.fold(worst, f64::max);
        }
        println!(
            "{capacitance} F, {power} W for {minutes} min: {outside} of {shaken} outside, worst {worst:.2} bounds"
        );
        // All of it may be between two listens, and is then known as well as the storage resolves it. A sum over days is not.
        assert!(shaken >= 56 && outside * 4 <= shaken && worst < 2.0, "{capacitance} F: {outside}, {worst}");
    }
}

#[test]
fn of_a_gap_with_leakage_the_income_is_uncertain_by_when_it_came() {
    let words = map([0.6e-6, 1.8e-6]);
    let gap = 2 * HOURS..14 * HOURS;
    // Evenly, in the first hour, and in the last.
    for hours in [2..14, 2..3, 13..14] {
        let power = 1.8e-6 * 12.0 / f64::from(hours.end - hours.start);
        let income = |second: u32| match second / HOURS {
            hour if hours.contains(&hour) => power,
            hour if gap.contains(&(hour * HOURS)) => 0.0,
            _ => 0.6e-6,
        };
        let case = Case { power: 0.5e-6, capacitance: 47e-3, leakage: 4e6, ..CASE };
        let mut tank = Tank::new(case, &words, 2.3, 4, income);
        let state = tank.run(20 * HOURS, gap.clone());
        assert_eq!(tank.outside(), 0, "{hours:?}: {:?}", tank.hours);
        tank.assert_overall(&state);
    }
}

#[test]
fn a_node_that_begins_with_a_storage_above_the_range_of_its_converter_acts() {
    let words = map(CASE.yields);
    for full_scale in [4.4, 4.48, 4.5] {
        // The income pays for an action of 1 mJ in 250 s.
        let case = Case { power: 4e-6, full_scale, action: 1e-3, every: 600, ..CASE };
        let mut tank = Tank::new(case, &words, 4.5, 5, |_| 8e-6);
        let state = tank.run(24 * HOURS, 0..0);
        assert!(tank.ran > 130, "{full_scale} V: {}", tank.ran);
        tank.assert_overall(&state);
    }
}
