//! The node with a map on a storage whose energy is counted in double precision, second by second.

use super::*;
use crate::energy::response_map::test_map::{FINGERPRINT, factors, head};
use crate::energy::response_map::{COLUMNS, LOWER, PARTS, ROWS, TAIL, UPPER, seal};
use crate::energy::{Capacitor, StorageParameters};
use crate::node::voltage::tests::normal;
use crate::node::{Converter, Regular, Tolerances, Verdict, VoltageParameters};
use crate::snapshot::{self, SnapshotError};
use core::f64::consts::PI;

const RATE: u32 = 100;
const UNIT: f64 = 9.806_65 / 1024.0;
const CELL: f64 = 5.0 / 4096.0;
/// Output powers in W of the smaller and the larger motion by the map.
const YIELDS: [f64; 2] = [8e-6, 24e-6];
/// Amplitudes in m/s² at which the map has the smaller motion, both, and the larger one.
const LOW: f64 = 0.8;
const BOTH: f64 = 1.5;
const HIGH: f64 = 3.0;

type OneNode<'a> = MapNode<&'a [u16], 20, 32, 1>;
type OneState = MapState<32, 1>;

/// A map of the same output powers at all places, of the smaller motion below 2 m/s² and of the larger one above 1 m/s², each from 0.4 %
/// below to 0.8 % above.
fn map() -> Vec<u16> {
    let mut words = head(LOWER | UPPER, [ROWS as u16 / 2; 2], 1);
    words.push(0);
    let levels = YIELDS.map(|power| ((power.log2() + 20.0) * 2048.0).round() as u16);
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

const STATED: MapParameters<1> = MapParameters {
    voltage: VoltageParameters {
        storage: StorageParameters {
            capacitor: Capacitor { capacitance: 1e-3, leakage_resistance: f32::INFINITY },
            charging_efficiency: 0.8,
            discharging_efficiency: 1.0,
            highest_voltage: 4.5,
            lock_out_voltage: 1.8,
            turn_on_voltage: 2.2,
        },
        converter: Converter { bits: 12, full_scale: 5.0, noise: 0.6e-3 },
        standing_power: 2e-6,
        reading: 0.3e-6,
        intervals: [60, 300],
        tolerances: Tolerances { standing: 0.01, ..Tolerances::EXACT },
        largest_power: 100e-6,
        reserve: 1e-3,
        actions: [Regular { energy: 1.0, every: 60 }],
    },
    sensor: Sensor { rate: RATE as f32, start_up: 4, blocks: 1, clipped: 2040 },
    bursts: Bursts { energy: 20e-6, worth: 10.0, shortest: 60, check: 86_400 },
    gain: 0.3,
    gain_drift: 0.01,
};

fn with(change: impl FnOnce(&mut MapParameters<1>)) -> MapParameters<1> {
    let mut parameters = STATED;
    change(&mut parameters);
    parameters
}

fn node(words: &[u16], parameters: MapParameters<1>) -> OneNode<'_> {
    let map = ResponseMap::new(words, FINGERPRINT).expect("a map");
    let bank = LineBank::new(RATE as f32, 20.0, 0.1, UNIT as f32).expect("fits");
    MapNode::new(map, bank, parameters).expect("valid")
}

/// A node, its storage and its machine.
struct Plant<'a, F> {
    node: OneNode<'a>,
    state: OneState,
    wake: Wake,
    /// Amplitude in m/s² of a line at 20 Hz, and output power in W, by the second.
    machine: F,
    second: u32,
    energy: f64,
    harvested: f64,
    shunted: f64,
    random: u64,
    findings: Vec<Finding>,
    /// Of each hour what was told and its bound, and the truth.
    hours: Vec<[f64; 3]>,
    begun: f64,
}

impl<'a, F: Fn(u32) -> (f64, f64)> Plant<'a, F> {
    fn new(node: OneNode<'a>, voltage: f64, machine: F) -> Self {
        let state = node.start(0);
        let wake = Wake { task: Task::Sleep, again_in: 0, read: true };
        let (findings, hours) = (vec![], vec![]);
        let mut plant = Self {
            node,
            state,
            wake,
            machine,
            second: 0,
            energy: 0.0,
            harvested: 0.0,
            shunted: 0.0,
            random: 5,
            findings,
            hours,
            begun: 0.0,
        };
        plant.energy = plant.at(voltage);
        plant
    }

    fn at(&self, voltage: f64) -> f64 {
        0.5 * f64::from(self.node.parameters().voltage.storage.capacitor.capacitance) * voltage * voltage
    }

    fn code(&mut self) -> u32 {
        let voltage = 4.5 * (self.energy / self.at(4.5)).sqrt() + 0.6e-3 * normal(&mut self.random);
        (voltage / CELL).round() as u32
    }

    fn live(&mut self, seconds: u32) {
        for _ in 0..seconds {
            let (_, power) = (self.machine)(self.second);
            self.harvested += power;
            self.energy += 0.8 * power - 2e-6;
            self.shunted += (self.energy - self.at(4.5)).max(0.0);
            self.energy = self.energy.min(self.at(4.5));
            self.second += 1;
        }
    }

    fn burst(&mut self, samples: u32) {
        let mut counts = vec![];
        for n in 0..samples {
            let (amplitude, _) = (self.machine)(self.second + n / RATE);
            let phase = core::f64::consts::TAU * 20.0 * f64::from(n) / f64::from(RATE);
            // Without vibration the counts are exactly the same.
            let noise = if amplitude > 0.0 { 0.3 * normal(&mut self.random) } else { 0.0 };
            counts.push(((9.81 + amplitude * phase.sin()) / UNIT + noise).round() as i16);
        }
        let mut taken = 0;
        while let Progress::More(missing) =
            self.node.samples(&mut self.state, &counts[taken..counts.len().min(taken + 128)])
        {
            // A part of an evaluation, or samples: the work of a call is bounded.
            taken = counts.len() - missing as usize;
        }
        while let Progress::Done(finding) = self.node.samples(&mut self.state, &[]) {
            self.findings.extend(finding);
        }
        self.live(samples.div_ceil(RATE));
    }

    fn run(&mut self, until: u32) {
        while self.second < until || self.wake.task != Task::Sleep {
            let spent = self.node.spent_on_estimation(&self.state);
            let last = self.state.last_hour();
            let mut code = None;
            match self.wake.task {
                Task::Run(_) => {
                    self.energy -= f64::from(self.node.parameters().voltage.actions[0].energy);
                }
                Task::Burst { samples } => self.burst(samples),
                Task::Sleep => {
                    self.live(self.wake.again_in);
                    code = self.wake.read.then(|| self.code());
                }
            }
            self.wake = self.node.wake(&mut self.state, self.second, code);
            self.energy -= f64::from(self.node.spent_on_estimation(&self.state) - spent);
            if self.state.last_hour() != last {
                let estimated = self.state.last_hour().expect("an hour");
                self.hours.push([
                    estimated.energy.into(),
                    estimated.bound.into(),
                    self.harvested - self.begun,
                ]);
                self.begun = self.harvested;
            }
        }
    }

    /// Hours, those inside their bounds, and the medians of error and bound over the truth, from an hour on.
    fn judge(&self, from: usize) -> (usize, usize, f64, f64) {
        let hours = self.hours.get(from..).expect("so many hours");
        let median = |of: &dyn Fn(&[f64; 3]) -> f64| {
            let mut values: Vec<f64> = hours.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        let inside =
            hours.iter().filter(|[estimated, bound, truth]| (estimated - truth).abs() <= *bound).count();
        let error = median(&|[estimated, _, truth]| (estimated - truth).abs() / truth);
        (hours.len(), inside, error, median(&|[_, bound, truth]| bound / truth))
    }
}

/// A machine that runs in turns of some minutes, with a harvester of 0.8 of what the map says.
fn turns(second: u32) -> (f64, f64) {
    match second / 1380 % 5 {
        0 | 3 => (HIGH, 0.8 * YIELDS[1]),
        1 => (0.0, 0.0),
        _ => (LOW, 0.8 * YIELDS[0]),
    }
}

#[test]
fn what_a_full_storage_shunts_is_told_by_the_map() {
    let words = map();
    let mut plant = Plant::new(node(&words, with(|of| of.gain = 0.05)), 4.4, |second| {
        let (amplitude, power) = turns(second);
        (amplitude, power / 0.8)
    });
    plant.run(3 * 86_400);
    let (hours, inside, error, bound) = plant.judge(1);
    assert!(plant.shunted > 0.5 * plant.harvested);
    assert!(inside * 100 >= 97 * hours && error < 0.05 && bound < 0.4);
    let share = f64::from(plant.node.spent_on_estimation(&plant.state)) / plant.harvested;
    assert!(share < 0.02, "{share}");
    let sum = plant.node.overall(&plant.state);
    assert!((f64::from(sum.energy) - plant.harvested).abs() < f64::from(sum.bound), "{sum:?}");
}

#[test]
fn where_the_voltage_tells_a_burst_a_day_is_taken() {
    let words = map();
    let parameters = with(|of| {
        of.voltage.storage.capacitor.capacitance = 10e-3;
        of.voltage.actions = [Regular { energy: 500e-6, every: 60 }];
    });
    let mut plant = Plant::new(node(&words, parameters), 3.0, turns);
    plant.run(10 * 86_400);
    let (hours, inside, error, _) = plant.judge(0);
    assert!(inside * 100 >= 97 * hours && error < 0.01);
    assert!(plant.state.bursts() <= 11);
    let [gain, bound] = plant.state.gain();
    assert!((gain - 0.8).abs() < bound && bound < 0.4, "{gain} {bound}");
}

#[test]
fn an_hour_that_the_voltage_does_not_resolve_is_told_by_the_map() {
    let words = map();
    // A cell of 12 bits is 37 mJ of it.
    let parameters = with(|of| {
        of.voltage.storage.capacitor.capacitance = 10.0;
        (of.gain, of.gain_drift) = (0.02, 0.0);
    });
    let mut plant = Plant::new(node(&words, parameters), 3.0, |second| {
        let (amplitude, power) = turns(second);
        (amplitude, power * (0.99 / 0.8))
    });
    plant.run(3 * 86_400);
    let (hours, inside, error, bound) = plant.judge(1);
    let by_voltage =
        f64::from(plant.state.voltage().last_hour().expect("an hour").bound) / plant.hours[10][2];
    assert!(
        inside * 100 >= 97 * hours && bound < by_voltage / 2.0 && error < 0.06,
        "{inside} {error} {bound} {by_voltage}"
    );
    let share = f64::from(plant.node.spent_on_estimation(&plant.state)) / plant.harvested;
    assert!(share < 0.02, "{share}");
}

#[test]
fn the_storage_decides_which_of_two_motions_goes_on() {
    let words = map();
    let parameters = with(|of| {
        of.voltage.storage.capacitor.capacitance = 10e-3;
        of.bursts.check = 3600;
        of.gain = 0.1;
    });
    for (power, motion) in [(YIELDS[0], 0), (YIELDS[1], 1)] {
        let mut plant = Plant::new(node(&words, parameters), 2.5, |_| (BOTH, power));
        plant.state.ask_for_burst();
        plant.run(3 * 3600);
        assert_eq!(plant.findings.first(), Some(&Finding::TwoMotions));
        assert_eq!(plant.findings.last(), Some(&Finding::TwoMotionsOneSeen));
        plant.state.voltage = plant.node.voltage.start(plant.second);
        // The map alone.
        let Status { power: estimated, power_bound: bound, power_age, source, verdict, .. } =
            plant.node.status(&plant.state);
        assert_eq!((source, verdict), (PowerSource::Map, Verdict::Open), "the energy is unknown");
        assert!(power_age <= 3900, "a burst an hour: {power_age}");
        assert!((f64::from(estimated) - power).abs() < f64::from(bound), "{motion}: {estimated} {bound}");
        assert!(f64::from(bound) < 0.4 * power);
    }
}

/// The power is then that of neither motion.
#[test]
fn a_motion_that_the_storage_contradicts_has_no_power_by_the_map_and_a_full_storage_asks_for_a_burst() {
    let words = map();
    let parameters = with(|of| {
        of.voltage.storage.capacitor.capacitance = 10e-3;
        of.bursts = Bursts { worth: 1000.0, check: 7200, ..of.bursts };
        of.gain = 0.1;
    });
    let power = |second: u32| if second < 8000 { YIELDS[0] } else { 14e-6 };
    let mut plant = Plant::new(node(&words, parameters), 2.5, |second| (BOTH, power(second)));
    plant.state.ask_for_burst();
    plant.run(8000);
    plant.state.ask_for_burst();
    plant.run(9000);
    assert_eq!(plant.findings.last(), Some(&Finding::TwoMotionsOneSeen));
    // The voltage tells: no other burst.
    let (bursts, status) = (plant.state.bursts(), plant.node.status(&plant.state));
    let Status { power, power_bound, source, .. } = status;
    assert_eq!((plant.state.motion, source, bursts), (None, PowerSource::Voltage, 3));
    assert!((power - 14e-6).abs() < power_bound, "{power} {power_bound}");
    plant.energy = plant.at(4.5);
    plant.run(9700);
    assert_eq!(plant.state.bursts(), 4);
}

#[test]
fn an_image_with_more_contradictions_than_are_counted_is_refused() {
    let mut state = node(&map(), STATED).start(0);
    let mut bytes = [0; 1000];
    for (contradictions, is_sound) in [(5, true), (6, false), (u32::MAX, false)] {
        state.contradictions = contradictions;
        snapshot::save(&state, 0, &mut bytes).expect("room");
        let restored = snapshot::restore::<OneState>(0, &bytes);
        assert_eq!(restored, if is_sound { Ok(state) } else { Err(SnapshotError::NoState) });
    }
}

#[test]
fn each_block_of_a_burst_is_evaluated_in_calls_that_take_no_samples() {
    let words = map();
    let node = node(&words, with(|of| of.sensor.blocks = 2));
    let mut state = node.start(0);
    state.ask_for_burst();
    assert_eq!(node.wake(&mut state, 0, Some(3000)).task, Task::Burst { samples: 1284 });
    let line = |n: usize| (1000.0 + HIGH / UNIT * (0.4 * PI * n as f64).sin()).round() as i16;
    let samples: Vec<i16> = (0..1284).map(line).collect();
    let mut missing = vec![];
    let mut taken = 0;
    while let Progress::More(left) = node.samples(&mut state, &samples[taken..(taken + 500).min(1284)]) {
        missing.push(left);
        taken = 1284 - left as usize;
    }
    assert_eq!(missing, [784, 640, 640, 640, 140]);
    let parts = [(); 3].map(|()| node.samples(&mut state, &[]));
    assert_eq!(parts, [None, None, Some(Finding::Line)].map(Progress::Done));
}

#[test]
fn a_harvester_that_has_aged_makes_the_map_doubtful_and_its_gain_is_learnt_anew() {
    let words = map();
    let parameters = with(|of| {
        of.voltage.storage.capacitor.capacitance = 10e-3;
        of.voltage.actions = [Regular { energy: 500e-6, every: 60 }];
        of.bursts.check = 7200;
        (of.gain, of.gain_drift) = (0.1, 0.002);
    });
    let aged = 5 * 86_400;
    let mut plant = Plant::new(node(&words, parameters), 3.0, |second| {
        let (amplitude, power) = turns(second);
        (amplitude, if second < aged { power / 0.8 } else { 0.7 * power / 0.8 })
    });
    plant.run(aged);
    assert!(!plant.state.is_map_doubtful(), "{:?}", plant.state.gain());
    plant.run(aged + 2 * 86_400);
    let [gain, bound] = plant.state.gain();
    assert!(plant.state.is_map_doubtful() && (gain - 0.7).abs() < bound.min(0.1), "{gain} {bound}");
}

#[test]
fn a_sensor_that_is_exactly_still_is_a_rest() {
    let words = map();
    let mut plant = Plant::new(node(&words, STATED), 4.49, |_| (0.0, 3e-6));
    plant.run(8 * 3600);
    assert!(plant.findings.len() > 3 && plant.findings.iter().all(|finding| *finding == Finding::Rest));
}

#[test]
fn a_burst_that_is_lost_or_damaged_has_no_value_and_the_next_one_waits() {
    let words = map();
    let node = node(&words, STATED);
    let mut state = node.start(0);
    state.ask_for_burst();
    let wake = node.wake(&mut state, 0, Some(3000));
    let Task::Burst { samples } = wake.task else { panic!("{wake:?}") };
    assert_eq!(samples, 644);
    assert_eq!(node.samples(&mut state, &[1000; 100]), Progress::More(544));
    // A code has no use here, and is booked.
    assert_eq!(node.wake(&mut state, 2, Some(3000)).task, Task::Burst { samples: 544 });
    assert_eq!(state.voltage.readings(), 2);
    // Later than its end.
    let wake = node.wake(&mut state, 60, Some(3000));
    assert_eq!((wake.task, node.samples(&mut state, &[1000; 100])), (Task::Sleep, Progress::Idle));
    assert!(!state.latest.is_known && state.misses == 1);
    state.ask_for_burst();
    let Task::Burst { samples } = node.wake(&mut state, 120, Some(3001)).task else { panic!("no burst") };
    node.samples_lost(&mut state);
    assert_eq!(node.samples(&mut state, &vec![1000; samples as usize]), Progress::Done(None));
    // Each call does a part, and a wake as well as one of samples.
    let (mut woken, mut read, parts) = (state, state, [None, None, Some(Finding::Damaged)]);
    assert_eq!(parts.map(|_| node.samples(&mut state, &[])), parts.map(Progress::Done));
    let wakes = parts.map(|_| node.wake(&mut woken, 130, None));
    assert_eq!(wakes.map(|wake| wake.again_in > 0), parts.map(|part| part.is_some()));
    let asks = parts.map(|_| node.wake(&mut read, 130, Some(3001)).read);
    let spent = [&read, &woken].map(|state| node.spent_on_estimation(state));
    assert_eq!((asks[..2].to_vec(), read.voltage.readings()), (vec![true; 2], woken.voltage.readings() + 3));
    assert!((spent[0] - spent[1] - 3.0 * STATED.voltage.reading).abs() < 1e-10, "{spent:?}");
    // A reset within a burst.
    assert_eq!((node.wake(&mut state, 130, None), state), (wakes[2], woken));
    state.ask_for_burst();
    assert!(matches!(node.wake(&mut state, 240, Some(3002)).task, Task::Burst { .. }));
    let wake = node.wake_after(&mut state, Outage::OnUntil(241), None);
    assert_eq!((wake.task, node.samples(&mut state, &[1000; 100])), (Task::Sleep, Progress::Idle));
}

#[test]
fn parameters_are_refused_by_name() {
    let words = map();
    let refused = |change: fn(&mut MapParameters<1>)| {
        let map = ResponseMap::new(&words[..], FINGERPRINT).expect("a map");
        let bank = LineBank::<20, 32>::new(RATE as f32, 20.0, 0.1, UNIT as f32).expect("fits");
        MapNode::new(map, bank, with(change)).expect_err("out of bounds").to_string()
    };
    for (change, begin) in [
        ((|of| of.sensor.blocks = 65) as fn(&mut MapParameters<1>), "sensor.blocks"),
        (|of| of.sensor.rate = 101.0, "sensor.rate"),
        (|of| of.bursts.worth = f32::NAN, "bursts.worth"),
        (|of| of.bursts.check = 3599, "bursts.check"),
        (|of| of.gain = 0.0, "gain"),
        (|of| of.voltage.reading = -1.0, "reading"),
    ] {
        let text = refused(change);
        assert!(text.starts_with(begin), "{text}");
    }
}

/// Bursts shorter than a beat see one or the other line, and the power between them contradicts both.
#[test]
fn vibration_that_beats_asks_for_no_more_bursts_than_checks() {
    let words = map();
    let parameters = with(|of| {
        of.voltage.storage.capacitor.capacitance = 10e-3;
        of.voltage.actions = [Regular { energy: 700e-6, every: 60 }];
        of.bursts = Bursts { energy: 100e-6, worth: 1000.0, shortest: 60, check: 7200 };
        (of.gain, of.gain_drift) = (0.05, 0.0005);
    });
    let beats = |second: u32| if (second / 20).wrapping_mul(2_654_435_761) >> 31 == 0 { LOW } else { HIGH };
    let mut plant = Plant::new(node(&words, parameters), 3.0, |second| (beats(second), 14e-6));
    while plant.second < 5 * 86_400 {
        plant.run(plant.second + 1);
    }
    assert!((50..70).contains(&plant.state.bursts()), "{}", plant.state.bursts());
}
