//! The loop of a node over its board: power-downs, torn images, and a sensor that fails.

use firmware_example::workload::response_map::contact_separation::{FINGERPRINT, MAP};
use model_core::energy::{
    Action, BudgetParameters, Capacitor, CorrectionParameters, IncomeParameters, ListeningParameters,
    ResponseMap, StorageParameters,
};
use model_core::excitation::LineBank;
use model_core::node::{
    Board, Fault, Hearing, KnowingCost, Node, NodeParameters, Regular, Runner, Sensor, Spread, Step,
};
use model_core::snapshot::SnapshotError;

const RATE: f32 = 100.0;
const UNIT: f32 = 9.806_65 / 1024.0;
const SLOT_BYTES: usize = 1024;

type OneNode = Node<&'static [u16], 20, 32, 24, 2>;
type OneRunner = Runner<Bench, &'static [u16], 20, 32, 24, 2, 128>;

fn node() -> OneNode {
    let map = ResponseMap::new(&MAP[..], FINGERPRINT).expect("a map");
    let bank = LineBank::new(RATE, 20.13, 0.1, UNIT).expect("fits");
    let regular =
        |name, energy, every| Regular { action: Action::new(name, energy, 0.1).expect("valid"), every };
    let parameters = NodeParameters {
        budget: BudgetParameters {
            storage: StorageParameters {
                capacitor: Capacitor { capacitance: 1e-3, leakage_resistance: 1e8 },
                charging_efficiency: 0.9,
                discharging_efficiency: 0.9,
                highest_voltage: 4.5,
                lock_out_voltage: 1.8,
                turn_on_voltage: 2.2,
            },
            income: IncomeParameters { time_constant: 14_400.0, day_weight: 0.5 },
            standing_power: 0.3e-6,
        },
        converter: CorrectionParameters {
            bits: 12,
            full_scale: 5.0,
            noise: 0.6e-3,
            gain_deviation: 1.0,
            gain_drift: 0.1,
        },
        listening: ListeningParameters {
            share: 0.01,
            error: 0.02,
            horizon: 3600.0,
            shortest: 300,
            doublings: 4,
        },
        sensor: Sensor { rate: RATE, start_up: 4, blocks: 1, clipped: 32_000 },
        cost: KnowingCost {
            listen: 20e-6,
            reading: 1e-6,
            reading_share: 0.01,
            shortest_reading: 60,
            reading_doublings: 4,
        },
        spread: Spread { standing: 0.2, action: 0.02, income: 0.5, gain_by_place: 0.5, power: 100e-6 },
        reserve: 1e-3,
        actions: [regular("measure", 50e-6, 60), regular("transmit", 300e-6, 300)],
    };
    Node::new(map, bank, parameters).expect("valid")
}

/// A board with a storage that is charged by 8 µW, in a vibration of 0.2 m/s² at 19.7 Hz, and a memory of two slots.
#[derive(Debug, Clone)]
struct Bench {
    second: u32,
    energy: f64,
    /// Samples in the FIFO, and since the sensor was switched on, and when that was.
    samples: u32,
    taken: u32,
    started: u32,
    is_on: bool,
    fails: bool,
    ran: [u32; 2],
    slots: [Vec<u8>; 2],
}

impl Bench {
    fn new() -> Self {
        let slots = [vec![0xff; SLOT_BYTES], vec![0xff; SLOT_BYTES]];
        Self {
            second: 0,
            energy: 4.5e-3,
            samples: 0,
            taken: 0,
            started: 0,
            is_on: false,
            fails: false,
            ran: [0; 2],
            slots,
        }
    }
}

impl Board for Bench {
    fn sleep(&mut self, seconds: u32, samples: u32) -> u32 {
        // A sensor that fails fills no FIFO.
        let seconds = if samples > 0 && self.is_on {
            self.taken += samples;
            self.samples += samples;
            self.started + self.taken / RATE as u32 - self.second
        } else {
            seconds
        };
        self.second += seconds;
        self.energy = (self.energy + 7.7e-6 * f64::from(seconds)).min(0.5e-3 * 4.5 * 4.5);
        self.second
    }

    fn storage_code(&mut self) -> Option<u32> {
        Some(((2e3 * self.energy).sqrt() * 4096.0 / 5.0).round() as u32)
    }

    fn start_sensor(&mut self) -> Result<(), Fault> {
        assert!(!self.is_on);
        if self.fails {
            return Err(Fault);
        }
        (self.is_on, self.taken, self.started) = (true, 0, self.second);
        Ok(())
    }

    fn stop_sensor(&mut self) {
        (self.is_on, self.samples) = (false, 0);
    }

    fn read_samples(&mut self, samples: &mut [i16]) -> Result<usize, Fault> {
        if self.fails {
            return Err(Fault);
        }
        let count = samples.len().min(self.samples as usize);
        for (n, sample) in samples[..count].iter_mut().enumerate() {
            let turns = 19.7 * f64::from(self.taken - self.samples + n as u32) / f64::from(RATE);
            *sample = (1024.0 + 0.2 / f64::from(UNIT) * (std::f64::consts::TAU * turns).sin()).round() as i16;
        }
        self.samples -= count as u32;
        Ok(count)
    }

    fn run(&mut self, action: usize) {
        self.ran[action] += 1;
        self.energy -= [50e-6, 300e-6][action] / 0.9;
    }

    fn read_slot(&mut self, slot: usize, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.slots[slot][..bytes.len()]);
    }

    fn write_slot(&mut self, slot: usize, bytes: &[u8]) {
        self.slots[slot][..bytes.len()].copy_from_slice(bytes);
    }
}

fn resumed(mut board: Bench) -> OneRunner {
    // What was in the memory of the sensor and of the processor is lost.
    board.stop_sensor();
    let second = board.second;
    let mut runner = OneRunner::new(board, node(), second);
    let (mut first, mut other) = ([0; SLOT_BYTES], [0; SLOT_BYTES]);
    runner.resume([&mut first, &mut other], second, true).expect("an image");
    runner
}

#[test]
fn a_node_that_loses_its_power_each_few_steps_ends_with_the_same_bits() {
    let day = |every: u32| {
        let mut runner = OneRunner::new(Bench::new(), node(), 0);
        let (mut heard, mut slept) = (0, 0);
        while runner.state().second() < 86_400 {
            match runner.step() {
                Step::Heard(hearing) => {
                    assert_eq!(hearing, Hearing::Line);
                    heard += 1;
                }
                Step::Slept => {
                    slept += 1;
                    if slept % every == 0 && runner.is_idle() {
                        runner.save(&mut [0; SLOT_BYTES]).expect("room");
                        runner = resumed(runner.into_board());
                    }
                }
                Step::Sampled | Step::Ran(_) => {}
            }
        }
        let state = *runner.state();
        (state, runner.into_board().ran, heard)
    };
    let whole = day(u32::MAX);
    assert!(whole.1[0] > 300 && whole.1[1] > 50 && whole.2 > 5, "{:?} {}", whole.1, whole.2);
    for every in [1, 7, 50] {
        assert_eq!(day(every), whole, "{every}");
    }
}

#[test]
fn a_write_that_is_torn_at_any_byte_leaves_the_image_before_it() {
    let mut runner = OneRunner::new(Bench::new(), node(), 0);
    let step = |runner: &mut OneRunner| while runner.step() != Step::Slept || !runner.is_idle() {};
    step(&mut runner);
    assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Ok(1));
    step(&mut runner);
    assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Ok(2));
    let before = *runner.state();
    let board = runner.into_board();
    let mut runner = resumed(board.clone());
    assert_eq!(*runner.state(), before);
    step(&mut runner);
    assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Ok(3));
    let after = *runner.state();
    let written = runner.into_board();
    for torn in (0..=OneRunner::image_bytes()).step_by(7).chain([OneRunner::image_bytes()]) {
        let mut board = board.clone();
        board.slots[0][..torn].copy_from_slice(&written.slots[0][..torn]);
        let whole = torn == OneRunner::image_bytes();
        assert_eq!(*resumed(board).state(), if whole { after } else { before }, "{torn}");
    }
    // Without any image there is nothing to continue, and the node begins.
    let mut runner = OneRunner::new(Bench::new(), node(), 0);
    let (mut first, mut other) = ([0; SLOT_BYTES], [0; SLOT_BYTES]);
    assert_eq!(runner.resume([&mut first, &mut other], 0, false), Err(SnapshotError::NotASnapshot));
    assert_eq!(runner.state().second(), 0);
}

#[test]
fn a_sensor_that_fails_costs_no_more_than_its_listens_and_the_storage_tells_the_income() {
    let mut runner = OneRunner::new(Bench { fails: true, ..Bench::new() }, node(), 0);
    while runner.state().second() < 43_200 {
        assert!(!matches!(runner.step(), Step::Heard(_)));
    }
    let state = *runner.state();
    assert_eq!(state.instruments()[1], 0);
    let hour = state.last_hour().expect("hours");
    // 8 µW times the charging efficiency, less the standing power, is what the bench stores.
    let truth = (7.7e-6 / 0.9 + 0.3e-6 / 0.81) * f64::from(hour.seconds);
    let leaked = 3600.0 * 9.0 / 1e8;
    let error = (f64::from(hour.energy) - truth).abs();
    assert!(error < f64::from(hour.bound) + leaked, "{hour:?} {truth}");
    assert!(state.share_spent_on_knowing() < 0.05, "{}", state.share_spent_on_knowing());
}
