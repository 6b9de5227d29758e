//! The loop of a node over its board: power-downs, torn images, a memory and a sensor that fail.

mod own_loop;
mod power_downs;

use firmware_example::workload::response_map::contact_separation::{FINGERPRINT, MAP};
use model_core::energy::{Capacitor, ResponseMap, StorageParameters};
use model_core::excitation::LineBank;
use model_core::node::{
    Board, Bursts, Converter, Fault, Finding, IncomeOfTime, MapNode, MapParameters, MapState, NodeError,
    Outage, Regular, Runner, SaveError, Sensor, Status, Step, Tier, Tolerances, VoltageParameters,
};
use model_core::snapshot::SnapshotError;

const RATE: f32 = 100.0;
const UNIT: f32 = 9.806_65 / 1024.0;
const SLOT_BYTES: usize = 1024;

type OneNode = MapNode<&'static [u16], 20, 32, 2>;
type OneState = MapState<32, 2>;
type OneRunner = Runner<'static, Bench, OneNode>;

/// A burst each hour, though the storage tells.
const PARAMETERS: MapParameters<2> = MapParameters {
    voltage: VoltageParameters {
        storage: StorageParameters {
            capacitor: Capacitor { capacitance: 1e-3, leakage_resistance: 1e8 },
            charging_efficiency: 0.9,
            discharging_efficiency: 0.9,
            highest_voltage: 4.5,
            lock_out_voltage: 1.8,
            turn_on_voltage: 2.2,
        },
        converter: Converter { bits: 12, full_scale: 5.0, noise: 0.6e-3 },
        standing_power: 0.3e-6,
        reading: 1e-6,
        intervals: [60, 300],
        tolerances: Tolerances { standing: 0.2, action: 0.02, ..Tolerances::EXACT },
        largest_power: 100e-6,
        reserve: 1e-3,
        actions: [Regular { energy: 50e-6, every: 60 }, Regular { energy: 300e-6, every: 300 }],
    },
    sensor: Sensor { rate: RATE, start_up: 4, blocks: 1, clipped: 32_000 },
    bursts: Bursts { energy: 20e-6, worth: 10.0, shortest: 60, check: 3600 },
    gain: 1.0,
    gain_drift: 0.1,
};

/// A node with a bank for the rate and the resonance given in Hz.
fn built(parameters: MapParameters<2>, rate: f32, resonance: f32) -> Result<OneNode, NodeError> {
    let map = ResponseMap::new(&MAP[..], FINGERPRINT).expect("a map");
    let bank = LineBank::new(rate, resonance, 0.1, UNIT).expect("fits");
    MapNode::new(map, bank, parameters)
}

fn node() -> &'static OneNode {
    Box::leak(Box::new(built(PARAMETERS, RATE, 20.13).expect("valid")))
}

/// What a write to the memory of a [`Bench`] does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Memory {
    Works,
    /// Erases the slot, and says that it failed.
    Fails,
    /// Erases the slot, and does not notice that the bytes are not there.
    Forgets,
    /// Takes the bytes, and gives others back.
    Garbles,
    /// Does nothing.
    Ignores,
}

/// Power in W that a [`Bench`] stores, the standing power off, and the power in W that is harvested for it.
const STORED: f64 = 7.7e-6;
const POWER: f64 = STORED / 0.9 + 0.3e-6 / 0.81;
/// Energies of the actions in J.
const ACTIONS: [f64; 2] = [50e-6, 300e-6];

/// A board with a storage that is charged by 8 µW, in a vibration of 0.2 m/s² at 19.7 Hz, and a memory of two slots.
#[derive(Debug, Clone)]
struct Bench {
    second: u32,
    energy: f64,
    /// Amplitude of the vibration in m/s².
    vibration: f64,
    /// Energies of the actions in J at the load.
    actions: [f64; 2],
    /// Samples in the FIFO, and since the sensor was switched on, and when that was.
    samples: u32,
    taken: u32,
    started: u32,
    is_on: bool,
    fails: bool,
    memory: Memory,
    ran: [u32; 2],
    slots: [Vec<u8>; 2],
}

impl Bench {
    fn new() -> Self {
        let slots = [vec![0xff; SLOT_BYTES], vec![0xff; SLOT_BYTES]];
        Self {
            second: 0,
            energy: 4.5e-3,
            vibration: 0.2,
            actions: ACTIONS,
            samples: 0,
            taken: 0,
            started: 0,
            is_on: false,
            fails: false,
            memory: Memory::Works,
            ran: [0; 2],
            slots,
        }
    }
}

impl Bench {
    /// Charges the storage by a power in W while it leaks through 100 MΩ, up to 4.5 V.
    fn charge(&mut self, power: f64, seconds: u32) {
        let kept = (-f64::from(seconds) / 0.5e5).exp();
        let balance = 0.5e5 * power;
        self.energy = (balance + (self.energy - balance) * kept).min(0.5e-3 * 4.5 * 4.5);
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
        self.charge(STORED, seconds);
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
        self.energy -= 20e-6 / 0.9;
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
            *sample = (1024.0 + self.vibration / f64::from(UNIT) * (std::f64::consts::TAU * turns).sin())
                .round() as i16;
        }
        self.samples -= count as u32;
        Ok(count)
    }

    fn run(&mut self, action: usize) {
        self.ran[action] += 1;
        self.energy -= self.actions[action] / 0.9;
    }

    fn read_slot(&mut self, slot: usize, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.slots[slot][..bytes.len()]);
        if self.memory == Memory::Garbles {
            bytes[bytes.len() / 2] ^= 1;
        }
    }

    fn write_slot(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault> {
        if self.memory == Memory::Ignores {
            return Ok(());
        }
        self.slots[slot].fill(0xff);
        match self.memory {
            Memory::Works | Memory::Garbles => self.slots[slot][..bytes.len()].copy_from_slice(bytes),
            Memory::Fails => return Err(Fault),
            Memory::Forgets | Memory::Ignores => {}
        }
        Ok(())
    }
}

fn resumed(board: Bench) -> OneRunner {
    resumed_on(node(), board, Outage::OnUntil)
}

fn resumed_on(node: &'static OneNode, mut board: Bench, outage: fn(u32) -> Outage) -> OneRunner {
    // What was in the memory of the sensor and of the processor is lost.
    board.stop_sensor();
    let second = board.second;
    let mut runner = OneRunner::new(board, node, second);
    runner.resume(&mut [0; SLOT_BYTES], outage(second)).expect("an image");
    runner
}

/// Steps to the next time at which the node is idle after a sleep.
fn step(runner: &mut OneRunner) {
    let mut has_slept = false;
    while !(has_slept && runner.is_idle()) {
        has_slept |= runner.step() == Step::Slept;
    }
}

fn assert_inside(hour: IncomeOfTime) {
    let truth = POWER * f64::from(hour.seconds);
    assert!((f64::from(hour.energy) - truth).abs() < f64::from(hour.bound), "{hour:?} {truth}");
}

#[test]
fn a_node_that_loses_its_power_each_few_steps_ends_with_the_same_bits() {
    let day = |every: u32| {
        let mut runner = OneRunner::new(Bench::new(), node(), 0);
        let (mut bursts, mut slept) = (0, 0);
        while OneNode::second(runner.state()) < 86_400 {
            match runner.step() {
                Step::Burst(finding) => {
                    assert_eq!(finding, Finding::Line);
                    bursts += 1;
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
        (state, runner.into_board().ran, bursts)
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
        if whole {
            board.second = written.second;
        }
        assert_eq!(*resumed(board).state(), if whole { after } else { before }, "{torn}");
    }
    // Without any image there is nothing to continue, and the node begins.
    let mut runner = OneRunner::new(Bench::new(), node(), 0);
    let mut buffer = [0; SLOT_BYTES];
    assert_eq!(runner.resume(&mut buffer, Outage::OffUntil(0)), Err(SnapshotError::NotASnapshot));
    assert_eq!(OneNode::second(runner.state()), 0);
}

#[test]
fn a_sensor_that_fails_costs_no_more_than_its_bursts_and_the_storage_tells_the_income() {
    let mut runner = OneRunner::new(Bench { fails: true, ..Bench::new() }, node(), 0);
    while OneNode::second(runner.state()) < 43_200 {
        assert!(!matches!(runner.step(), Step::Burst(_)));
    }
    assert_inside(runner.state().last_hour().expect("hours"));
    let spent = f64::from(node().spent_on_estimation(runner.state()));
    assert!(runner.state().bursts() > 5 && spent < 0.01 * POWER * 43_200.0, "{spent}");
}

#[test]
fn a_memory_that_fails_is_told_and_leaves_the_only_image() {
    for memory in [Memory::Fails, Memory::Forgets] {
        let mut runner = OneRunner::new(Bench::new(), node(), 0);
        for number in 1..=2 {
            step(&mut runner);
            assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Ok(number));
        }
        let saved = *runner.state();
        let mut runner = resumed(Bench { memory, ..runner.into_board() });
        for _ in 0..3 {
            step(&mut runner);
            assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Err(SaveError::Memory), "{memory:?}");
        }
        // The first slot has lost its image, and the second one was not touched.
        let board = Bench { memory: Memory::Works, ..runner.into_board() };
        let mut runner = resumed(Bench { second: OneNode::second(&saved), ..board });
        assert_eq!(*runner.state(), saved, "{memory:?}");
        step(&mut runner);
        assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Ok(3));
    }
}

#[test]
fn an_image_of_a_save_that_failed_is_not_taken_for_a_later_one() {
    let mut runner = OneRunner::new(Bench::new(), node(), 0);
    step(&mut runner);
    assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Ok(1));
    // The second image is whole in its slot, and the node does not know it.
    for memory in [Memory::Garbles, Memory::Ignores] {
        runner.board_mut().memory = memory;
        while OneNode::second(runner.state()) < 28_800 {
            step(&mut runner);
        }
        assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Err(SaveError::Memory), "{memory:?}");
        step(&mut runner);
    }
}

#[test]
fn what_was_learnt_survives_an_update_of_all_but_map_bank_and_storage() {
    let mut runner = OneRunner::new(Bench::new(), node(), 0);
    step(&mut runner);
    runner.save(&mut [0; SLOT_BYTES]).expect("room");
    let board = runner.into_board();
    let resumed = |change: fn(&mut MapParameters<2>)| {
        let mut parameters = PARAMETERS;
        change(&mut parameters);
        let node = built(parameters, RATE, 20.13).expect("valid");
        let mut runner = OneRunner::new(board.clone(), Box::leak(Box::new(node)), board.second);
        runner.resume(&mut [0; SLOT_BYTES], Outage::OnUntil(board.second))
    };
    let changes: [fn(&mut MapParameters<2>); 9] = [
        |of| of.voltage.reserve *= 1.01,
        |of| of.voltage.actions[0].every += 1,
        |of| of.voltage.actions[1].energy = 303e-6,
        |of| of.voltage.reading *= 1.01,
        |of| of.voltage.standing_power *= 1.01,
        |of| of.bursts.energy *= 1.01,
        |of| of.bursts.worth *= 1.01,
        |of| of.bursts.shortest += 1,
        |of| of.gain *= 1.01,
    ];
    for (index, change) in changes.into_iter().enumerate() {
        assert_eq!(resumed(change), Ok(1), "{index}");
    }
    let other = |of: &mut MapParameters<2>| of.voltage.storage.capacitor.capacitance *= 1.01;
    assert_eq!(resumed(other), Err(SnapshotError::ForeignModel));
}

#[test]
fn an_image_is_saved_by_an_idle_node_only_and_needs_room() {
    let mut runner = OneRunner::new(Bench::new(), node(), 0);
    runner.state_mut().ask_for_burst();
    while runner.is_idle() {
        runner.step();
    }
    assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Err(SaveError::NotIdle));
    step(&mut runner);
    let needed = OneRunner::image_bytes();
    let short = SnapshotError::NoRoom { needed, given: needed - 1 };
    assert_eq!(runner.save(&mut vec![0; needed - 1]), Err(SaveError::Buffer(short)));
    assert_eq!(runner.save(&mut vec![0; needed]), Ok(1));
}

#[test]
fn an_image_of_a_node_that_begins_anew_is_newer_than_those_of_its_former_life() {
    for former in 1..=4 {
        let mut runner = OneRunner::new(Bench::new(), node(), 0);
        for number in 1..=former {
            step(&mut runner);
            assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Ok(number));
        }
        let before = *runner.state();
        // The same memory and configuration; no image is asked for.
        let board = Bench { slots: runner.into_board().slots, ..Bench::new() };
        let mut runner = OneRunner::new(board, node(), 0);
        step(&mut runner);
        assert_eq!(runner.save(&mut [0; SLOT_BYTES]), Ok(former + 1));
        let after = *runner.state();
        assert!(former == 1 || after != before);
        assert_eq!(*resumed(runner.into_board()).state(), after, "{former}");
    }
}

#[test]
fn parameters_that_do_not_fit_are_refused_with_their_name_and_value() {
    let refused = |change: fn(&mut MapParameters<2>)| {
        let mut parameters = PARAMETERS;
        change(&mut parameters);
        built(parameters, RATE, 20.13).expect_err("refused").to_string()
    };
    assert_eq!(
        refused(|p| p.sensor.start_up = 70_000),
        "sensor.start_up = 70000.0 must be from 0.0 to 10000.0"
    );
    let every = refused(|p| p.voltage.actions[1].every = 0);
    assert_eq!(every, "actions.1.every = 0.0 must be from 1.0 to 10000000.0");
    let bits = refused(|p| p.voltage.converter.bits = 40);
    assert_eq!(bits, "bits = 40.0 must be from 4.0 to 16.0");
    assert_eq!(
        refused(|p| p.sensor.rate = 1600.0),
        "sensor.rate = 1600.0 must be 100.0, the rate of the bank of lines"
    );
    let mut day = PARAMETERS;
    day.voltage.actions[1].every = 86_400;
    assert!(built(day, RATE, 20.13).is_ok());
    // A bank whose rate is a rounding off, and one for another resonance than that of the map.
    assert!(built(PARAMETERS, f32::from_bits(RATE.to_bits() + 1), 20.13).is_ok());
    let other = built(PARAMETERS, RATE, 35.0).expect_err("refused");
    assert!(matches!(other, NodeError::Band { band: [low, high] } if low < 35.0 && high > 35.0), "{other:?}");
}
