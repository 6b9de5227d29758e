//! A node on a plant of a steady income: two motions, listens without a value, readings that fall due during a listen.

use super::{
    Converter, Hearing, IncomeOfTime, KnowingCost, Node, NodeParameters, NodeState, Progress, Regular,
    Sensor, Spread, Task, Tier, Wake,
};
use crate::energy::response_map::test_map::{FINGERPRINT, factors, head};
use crate::energy::response_map::{COLUMNS, LOWER, PARTS, ROWS, TAIL, UPPER, seal};
use crate::energy::{
    BudgetParameters, Capacitor, IncomeParameters, ListeningParameters, ResponseMap, StorageParameters,
};
use crate::excitation::LineBank;

const RATE: f32 = 100.0;
const RESONANCE: f32 = 20.0;
pub(super) const UNIT: f64 = 9.806_65 / 1024.0;
const CELL: f64 = 5.0 / 4096.0;
/// Amplitudes in m/s² with one motion and with two, by the boundaries of the map.
pub(super) const LINE: f64 = 0.8;
const BETWEEN: f64 = 1.5;
const HOURS: u32 = 3600;

/// A map of the same yields in W at all places, of the smaller motion below 2 m/s² and of the larger one above 1 m/s², each
/// from 0.4 % below to 0.8 % above.
pub(super) fn map(yields: [f64; 2]) -> Vec<u16> {
    let rows = ROWS as u16 / 2;
    let mut words = head(LOWER | UPPER, [rows; 2], 1);
    words.push(0);
    let levels = yields.map(|power| ((power.log2() + 20.0) * 2048.0).round() as u16);
    for _ in 0..COLUMNS {
        words.extend([17 * 2048, 16 * 2048]);
        words.extend(levels.iter().flat_map(|&level| [level; ROWS / 2]));
    }
    // Two for near and far rows of either branch.
    words.extend(factors([255.0 / 256.0, 129.0 / 128.0]).repeat(2 * 2 * PARTS));
    words.extend([0; TAIL]);
    seal(&mut words);
    words
}

pub(super) type OneNode<'a> = Node<&'a [u16], 20, 32, 24, 1>;

/// What a run is of.
#[derive(Clone, Copy)]
pub(super) struct Case {
    /// Yields of both motions by the map, and the true power, in W: that of the load too, so that the storage stays.
    pub(super) yields: [f64; 2],
    pub(super) power: f64,
    pub(super) gain_deviation: f32,
    /// Blocks of 6.4 s in a listen, and shortest time between readings in s.
    pub(super) blocks: u32,
    pub(super) shortest_reading: u32,
    /// Doublings from the shortest time between readings, and from that between listens, a minute.
    pub(super) reading_doublings: u32,
    pub(super) doublings: u32,
    /// Storage in F and ohm, and converter: range and noise in V.
    pub(super) capacitance: f32,
    pub(super) leakage: f32,
    pub(super) full_scale: f32,
    pub(super) noise: f32,
    /// An action in J, and its interval in s.
    pub(super) action: f32,
    pub(super) every: u32,
}

pub(super) const CASE: Case = Case {
    yields: [8e-6, 24e-6],
    power: 8e-6,
    gain_deviation: 0.1,
    blocks: 1,
    shortest_reading: 60,
    reading_doublings: 6,
    doublings: 8,
    capacitance: 10e-3,
    leakage: f32::INFINITY,
    full_scale: 5.0,
    noise: 0.6e-3,
    action: 1.0,
    every: 1800,
};

impl Case {
    pub(super) fn node<'a>(&self, words: &'a [u16]) -> OneNode<'a> {
        let map = ResponseMap::new(words, FINGERPRINT).expect("a map");
        let bank = LineBank::new(RATE, RESONANCE, 0.1, UNIT as f32).expect("fits");
        let parameters = NodeParameters {
            budget: BudgetParameters {
                storage: StorageParameters {
                    capacitor: Capacitor { capacitance: self.capacitance, leakage_resistance: self.leakage },
                    charging_efficiency: 1.0,
                    discharging_efficiency: 1.0,
                    highest_voltage: 4.5,
                    lock_out_voltage: 1.8,
                    turn_on_voltage: 2.2,
                },
                income: IncomeParameters { time_constant: 14_400.0, day_weight: 0.5 },
                standing_power: self.power as f32,
            },
            converter: Converter { bits: 12, full_scale: self.full_scale, noise: self.noise },
            listening: ListeningParameters {
                share: 8e-3,
                error: 1e-3,
                horizon: 3600.0,
                shortest: 60,
                doublings: self.doublings,
            },
            sensor: Sensor { rate: RATE, start_up: 4, blocks: self.blocks, clipped: 2040 },
            cost: KnowingCost {
                listen: 5e-6,
                reading: 0.3e-6,
                reading_share: 2e-3,
                shortest_reading: self.shortest_reading,
                reading_doublings: self.reading_doublings,
            },
            spread: Spread {
                gain: self.gain_deviation,
                gain_drift: 0.02,
                standing: 0.02,
                action: 0.1,
                income: 0.3,
                gain_by_place: 0.1,
                highest_voltage: 0.03,
                power: 1e-4,
            },
            reserve: 1e-4,
            actions: [Regular { energy: self.action, every: self.every }],
        };
        Node::new(map, bank, parameters).expect("valid")
    }
}

/// A node with its plant, from 3 V on.
struct Plant<'a> {
    node: OneNode<'a>,
    state: NodeState<32, 24, 1>,
    wake: Wake,
    power: f64,
    energy: f64,
    second: u32,
    samples: u32,
    /// Whether the converter answers.
    answers: bool,
    /// What was heard, and when the voltage was read.
    heard: Vec<Hearing>,
    read: Vec<u32>,
    hours: Vec<IncomeOfTime>,
}

impl<'a> Plant<'a> {
    fn new(case: &Case, words: &'a [u16]) -> Self {
        let node = case.node(words);
        let mut state = node.start(0);
        let energy = 0.5 * 10e-3 * 9.0_f64;
        let wake = node.wake(&mut state, 0, Some(code(energy, 0)));
        let (heard, read, hours) = (vec![], vec![0], vec![]);
        Self {
            node,
            state,
            wake,
            power: case.power,
            energy,
            second: 0,
            samples: 0,
            answers: true,
            heard,
            read,
            hours,
        }
    }

    fn pass(&mut self, seconds: u32) {
        let standing = f64::from(self.node.parameters().budget.standing_power);
        self.energy += (self.power - standing) * f64::from(seconds);
        self.second += seconds;
    }

    /// Runs for some seconds in a vibration of an acceleration in m/s² by the number of the sample; calls `each` after each
    /// wake.
    fn run(
        &mut self,
        seconds: u32,
        acceleration: impl Fn(f64) -> f64,
        mut each: impl FnMut(&NodeState<32, 24, 1>),
    ) {
        let end = self.second + seconds;
        while self.second < end {
            let mut read = None;
            match self.wake.task {
                Task::Run(_) => panic!("1 J is more than the storage holds"),
                Task::Sleep => {
                    self.pass(self.wake.again_in);
                    if self.wake.read {
                        self.energy -= f64::from(self.node.parameters().cost.reading);
                        self.read.push(self.second);
                        read = self.answers.then(|| code(self.energy, self.second));
                    }
                }
                Task::Listen { samples } => {
                    let of = |n: u32| (acceleration(f64::from(n)) / UNIT + dither(n)).round() as i16;
                    let counts: Vec<i16> = (self.samples..).take(samples as usize).map(of).collect();
                    self.samples += samples;
                    self.energy -= f64::from(self.node.parameters().cost.listen);
                    self.pass(samples.div_ceil(RATE as u32));
                    let Progress::Heard(heard) = self.node.samples(&mut self.state, &counts) else {
                        panic!("all samples");
                    };
                    self.heard.push(heard);
                }
            }
            let hour = self.state.last_hour();
            self.wake = self.node.wake(&mut self.state, self.second, read);
            if self.state.last_hour() != hour {
                self.hours.extend(self.state.last_hour());
            }
            each(&self.state);
        }
    }

    fn assert_hours(&self) {
        assert!(!self.hours.is_empty());
        for hour in &self.hours {
            let truth = self.power * f64::from(hour.seconds);
            assert!((f64::from(hour.energy) - truth).abs() <= f64::from(hour.bound), "{hour:?} {truth}");
        }
    }
}

/// A third of a count, even.
fn dither(n: u32) -> f64 {
    (f64::from(n * 7919 % 13) - 6.0) / 18.0
}

fn code(energy: f64, second: u32) -> u32 {
    ((200.0 * energy).sqrt() / CELL + dither(second)).round() as u32
}

pub(super) fn line(amplitude: f64) -> impl Fn(f64) -> f64 {
    move |n| amplitude * (std::f64::consts::TAU * f64::from(RESONANCE) * n / f64::from(RATE)).sin()
}

/// Two strong lines, which no map knows.
fn beat(n: f64) -> f64 {
    line(3.0)(n) + 2.7 * (std::f64::consts::TAU * 20.6 * n / f64::from(RATE)).sin()
}

fn assert_power(state: &NodeState<32, 24, 1>, truth: f64) {
    let [power, bound] = state.power().map(f64::from);
    assert!((power - truth).abs() <= bound, "{power} ± {bound} W, {truth} W at {}", state.second());
}

#[test]
fn the_storage_decides_between_two_motions_again_and_again() {
    for power in [8e-6, 24e-6] {
        for gain in [0.9, 1.0, 1.15] {
            let case = Case { power: gain * power, doublings: 4, ..CASE };
            let words = map(case.yields);
            let mut plant = Plant::new(&case, &words);
            plant.run(24 * HOURS, line(BETWEEN), |state| assert_power(state, case.power));
            let (first, others) = plant.heard.split_first().expect("listens");
            assert_eq!(*first, Hearing::TwoMotions, "nothing was seen before");
            let seen = others.iter().filter(|&&heard| heard == Hearing::TwoMotionsOneSeen).count();
            assert!(others.len() > 20 && 20 * seen >= 19 * others.len(), "{seen} of {}", others.len());
            let share = plant.state.share_spent_on_knowing();
            assert!(share < 3e-3, "{share}");
            let [learnt, bound] = plant.state.gain();
            assert!((learnt - gain as f32).abs() <= bound && bound < 0.1, "{learnt} ± {bound}, {gain}");
            plant.assert_hours();
        }
    }
}

#[test]
fn a_gain_that_leaves_two_motions_possible_covers_both_and_costs_few_listens() {
    for (ratio, gain_deviation) in [(2.0, 0.5), (2.0, 1.0), (3.0, 0.5), (3.0, 1.0)] {
        let case = Case { yields: [8e-6, ratio * 8e-6], gain_deviation, ..CASE };
        let words = map(case.yields);
        let mut plant = Plant::new(&case, &words);
        plant.run(24 * HOURS, line(BETWEEN), |state| assert_power(state, case.power));
        plant.assert_hours();
        assert!(plant.heard.iter().all(|&heard| heard == Hearing::TwoMotions), "{:?}", plant.heard);
        // Eight doublings, and then each four hours.
        assert!(plant.heard.len() <= 8 + 6, "{}", plant.heard.len());
        let [gain, bound] = plant.state.gain().map(f64::from);
        for possible in [1.0, 1.0 / ratio] {
            assert!((gain - possible).abs() <= bound, "{gain} ± {bound}, {possible}");
        }
        assert!(bound < 0.8 * 2.5 * f64::from(gain_deviation), "{gain} ± {bound}");
    }
}

#[test]
fn two_motions_that_are_far_apart_tell_an_uncertain_gain() {
    for (power, gain) in [(8e-6, 0.7), (160e-6, 0.7), (8e-6, 1.4)] {
        let case = Case { yields: [8e-6, 160e-6], power: gain * power, gain_deviation: 0.5, ..CASE };
        let words = map(case.yields);
        let mut plant = Plant::new(&case, &words);
        plant.run(24 * HOURS, line(BETWEEN), |state| assert_power(state, case.power));
        let [learnt, bound] = plant.state.gain();
        assert!((learnt - gain as f32).abs() <= bound && bound < 0.2, "{learnt} ± {bound}, {gain}");
    }
}

#[test]
fn listens_without_a_value_become_rare_after_one_with_a_value_too() {
    let words = map(CASE.yields);
    let mut plant = Plant::new(&CASE, &words);
    plant.run(2 * HOURS, line(LINE), |_| {});
    assert!(plant.heard.iter().all(|&heard| heard == Hearing::Line), "{:?}", plant.heard);
    plant.run(24 * HOURS, beat, |_| {});
    let before = plant.heard.len();
    plant.run(24 * HOURS, beat, |_| {});
    let heard = &plant.heard[before..];
    let has_no_value = |heard: &Hearing| matches!(heard, Hearing::Unclear | Hearing::BroadbandBeyond);
    assert!(heard.iter().all(has_no_value), "{heard:?}");
    // Of 15 360 s.
    assert!((4..=7).contains(&heard.len()), "{}", heard.len());
    assert!(plant.state.share_spent_on_knowing() < 5e-3, "{}", plant.state.share_spent_on_knowing());
}

#[test]
fn a_listen_that_tells_an_order_of_magnitude_makes_nothing_more_certain() {
    let words = map(CASE.yields);
    let mut plant = Plant::new(&CASE, &words);
    plant.run(2 * HOURS, line(LINE), |_| {});
    for _ in 0..4 {
        let listens = plant.heard.len();
        let [mut before, mut after] = [plant.state; 2];
        while plant.heard.len() == listens {
            before = plant.state;
            plant.run(1, beat, |state| after = *state);
        }
        let known = |state: &NodeState<32, 24, 1>| {
            [state.power(), state.gain(), state.excess_draw()].map(|[value, bound]| (value, bound))
        };
        for ((value, bound), (value_after, bound_after)) in known(&before).into_iter().zip(known(&after)) {
            assert!(bound_after >= bound, "{bound} {bound_after}");
            assert_eq!(value, value_after);
        }
    }
}

#[test]
fn a_storage_that_is_not_read_tells_nothing_of_the_gain() {
    let case = Case { power: 1.2 * 8e-6, ..CASE };
    let words = map(case.yields);
    let mut plant = Plant::new(&case, &words);
    plant.run(200, line(LINE), |_| {});
    plant.answers = false;
    // The readings so far are in the next listen.
    let heard = plant.heard.len();
    while plant.heard.len() == heard {
        plant.run(1, line(LINE), |_| {});
    }
    let [gain, _] = plant.state.gain();
    assert!(gain > 1.0 && gain < 1.2, "{gain}");
    plant.run(20 * HOURS, line(LINE), |_| {});
    assert!(plant.state.store_tells() && plant.heard.len() > heard + 3, "{:?}", plant.heard);
    assert_eq!(plant.state.gain()[0], gain);
}

#[test]
fn a_reading_that_falls_due_during_a_listen_is_made_after_it() {
    // Listens take 52 s.
    let case = Case { blocks: 8, shortest_reading: 30, ..CASE };
    let words = map(case.yields);
    let mut plant = Plant::new(&case, &words);
    plant.run(2 * HOURS, line(LINE), |_| {});
    assert!(plant.heard.len() > 5, "{}", plant.heard.len());
    let longest = plant.read.windows(2).map(|pair| pair[1] - pair[0]).max();
    assert!(longest.is_some_and(|longest| longest <= 60), "{longest:?}");
    // Nothing is booked that was not spent.
    let cost = plant.node.parameters().cost;
    let spent = cost.reading * plant.read.len() as f32 + cost.listen * plant.heard.len() as f32;
    assert!((plant.state.spent_on_knowing() / spent - 1.0).abs() < 1e-4, "{spent}");
}

#[test]
fn a_wake_that_was_not_asked_to_read_misses_no_reading() {
    let words = map(CASE.yields);
    let mut plant = Plant::new(&CASE, &words);
    plant.run(HOURS, line(LINE), |_| {});
    while plant.wake.task != Task::Sleep {
        plant.run(1, line(LINE), |_| {});
    }
    // An interrupt, before the reading that was asked for.
    assert!(plant.wake.read && plant.wake.again_in > 10, "{:?}", plant.wake);
    let spent = plant.state.spent_on_knowing();
    plant.pass(5);
    let again = plant.node.wake(&mut plant.state, plant.second, None);
    assert_eq!((again.again_in, again.read), (plant.wake.again_in - 5, true));
    assert_eq!(plant.state.spent_on_knowing(), spent);
    // The converter does not answer.
    plant.pass(again.again_in);
    let missed = plant.node.wake(&mut plant.state, plant.second, None);
    assert!(plant.state.spent_on_knowing() > spent && missed.again_in > 1, "{missed:?}");
}
