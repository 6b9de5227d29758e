//! The board against the bytes of the data sheets, and a node on a simulated sensor, clock and flash.

extern crate std;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::vec;
use std::vec::Vec;

use core::convert::Infallible;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use embedded_hal_mock::eh1::delay::NoopDelay;
use embedded_hal_mock::eh1::spi::{Mock as Spi, Transaction};
use embedded_storage::nor_flash::{
    NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use harvester_scene::market::{Accelerometer, Code, CostModel, Processor, Radio, node_instructions};
use model_core::node::{Board, Fault, Finding, Outage, Step, Tier};

use super::adxl362::{Adxl362, Adxl362Error, Axis, Range, Rate};
use super::example::{self, Runner};
use super::{HalBoard, Slots};

fn written(bytes: &[u8]) -> Vec<Transaction<u8>> {
    vec![
        Transaction::transaction_start(),
        Transaction::write_vec(bytes.to_vec()),
        Transaction::transaction_end(),
    ]
}

fn read(command: &[u8], answer: &[u8]) -> Vec<Transaction<u8>> {
    vec![
        Transaction::transaction_start(),
        Transaction::write_vec(command.to_vec()),
        Transaction::read_vec(answer.to_vec()),
        Transaction::transaction_end(),
    ]
}

/// What the driver sends to start at ±4 g and 200 Hz, by the register map.
fn starting() -> Vec<Transaction<u8>> {
    [
        read(&[0x0B, 0x00], &[0xAD, 0x1D, 0xF2]),
        written(&[0x0A, 0x1F, 0x52]),
        written(&[0x0A, 0x2C, 0b0100_0100]),
        written(&[0x0A, 0x28, 0b0000_0010]),
        written(&[0x0A, 0x2D, 0b0000_0010]),
    ]
    .concat()
}

/// An entry of the FIFO: the axis in bits 15 and 14, the value of 12 bits with its sign in bits 13 to 0.
fn entry(tag: u16, value: i16) -> [u8; 2] {
    (tag << 14 | (value as u16 & 0x3FFF)).to_le_bytes()
}

fn sensor(spi: Spi<u8>) -> Adxl362<Spi<u8>> {
    Adxl362::new(spi, Axis::Z, Range::G4, Rate::Hz200)
}

/// The result of a future that waits for nothing.
fn ready<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => result,
        Poll::Pending => panic!("it waits"),
    }
}

type Error = Adxl362Error<ErrorKind>;

/// What reading up to so many samples gives, over the blocking and over the asynchronous traits.
fn samples(bytes: &[Transaction<u8>], room: usize) -> Result<Vec<i16>, Error> {
    let mut spi = Spi::new(&[bytes, bytes].concat());
    let mut sensor = sensor(spi.clone());
    let [mut found, mut later] = [0; 2].map(|zero| vec![zero; room]);
    let count = sensor.read(&mut found);
    assert_eq!(ready(sensor.read_async(&mut later)), count);
    assert_eq!(found, later);
    spi.done();
    Ok(found[..count?].to_vec())
}

/// Time in ns that was waited for.
struct Waited(u64);

impl DelayNs for Waited {
    fn delay_ns(&mut self, ns: u32) {
        self.0 += u64::from(ns);
    }
}

impl embedded_hal_async::delay::DelayNs for Waited {
    async fn delay_ns(&mut self, ns: u32) {
        self.0 += u64::from(ns);
    }
}

#[test]
fn the_sensor_is_started_and_stopped_by_the_register_map_and_waited_for_once() {
    let stopping = written(&[0x0A, 0x2D, 0x00]);
    let bytes = [starting(), stopping.clone(), starting(), stopping].concat();
    let mut spi = Spi::new(&[&bytes[..], &bytes].concat());
    let (mut blocking, mut later) = (sensor(spi.clone()), sensor(spi.clone()));
    // 5 ms from the supply and 0.5 ms from a reset; then the reset only, because the part keeps its supply.
    let expected = [5_500_000, 500_000];
    for expected in expected {
        let mut waited = Waited(0);
        blocking.start(&mut waited).and_then(|()| blocking.stop()).expect("it answers");
        assert_eq!(waited.0, expected);
    }
    for expected in expected {
        let mut waited = Waited(0);
        ready(later.start_async(&mut waited)).and_then(|()| ready(later.stop_async())).expect("it answers");
        assert_eq!(waited.0, expected);
    }
    spi.done();
}

#[test]
fn another_part_is_refused() {
    let bytes = read(&[0x0B, 0x00], &[0xAD, 0x1D, 0xF7]);
    let mut spi = Spi::new(&[&bytes[..], &bytes].concat());
    let mut sensor = sensor(spi.clone());
    let found = [sensor.start(&mut Waited(0)), ready(sensor.start_async(&mut Waited(0)))];
    assert_eq!(found, [Err(Adxl362Error::Identity([0xAD, 0x1D, 0xF7])); 2]);
    spi.done();
}

#[test]
fn one_axis_is_taken_from_whole_samples() {
    // Eight entries are two samples and two entries of the third, which stay in the FIFO.
    let values = [-2048_i16, 2047];
    let bytes: Vec<u8> =
        values.iter().flat_map(|&z| [entry(0, 5), entry(1, -6), entry(2, z)].concat()).collect();
    let bytes = [read(&[0x0B, 0x0B], &[0b0001, 8, 0]), read(&[0x0D], &bytes)].concat();
    assert_eq!(samples(&bytes, 10), Ok(values.to_vec()));
}

#[test]
fn a_short_buffer_and_a_long_fifo_are_read_in_blocks() {
    // 510 entries wait, 0x1FE; there is room for 20 samples, which are read as 16 and 4.
    let sample = |z: i16| [entry(0, 0), entry(1, 0), entry(2, z)].concat();
    let block = |range: core::ops::Range<i16>| read(&[0x0D], &range.flat_map(sample).collect::<Vec<u8>>());
    let bytes = [read(&[0x0B, 0x0B], &[0, 0xFE, 0x01]), block(0..16), block(16..20)].concat();
    assert_eq!(samples(&bytes, 20), Ok((0..20).collect()));
}

#[test]
fn lost_and_misaligned_samples_are_errors() {
    assert_eq!(samples(&read(&[0x0B, 0x0B], &[0b1000, 0, 2]), 4), Err(Adxl362Error::Overrun));
    let shifted = [entry(1, 0), entry(2, 0), entry(0, 0)].concat();
    let bytes = [read(&[0x0B, 0x0B], &[0, 3, 0]), read(&[0x0D], &shifted)].concat();
    assert_eq!(samples(&bytes, 4), Err(Adxl362Error::Misaligned));
}

/// NOR flash of four pages of 64 bytes: erased to ones, written once in words of 4 bytes.
#[derive(Debug, Clone)]
struct Flash {
    bytes: Vec<u8>,
    /// Erasures and writes that still succeed.
    left: usize,
}

#[derive(Debug)]
struct FlashError(NorFlashErrorKind);

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        self.0
    }
}

impl Flash {
    fn new(pages: usize) -> Self {
        Self { bytes: vec![0; Self::ERASE_SIZE * pages], left: usize::MAX }
    }

    fn work(&mut self) -> Result<(), FlashError> {
        self.left = self.left.checked_sub(1).ok_or(FlashError(NorFlashErrorKind::Other))?;
        Ok(())
    }
}

impl embedded_storage::nor_flash::ErrorType for Flash {
    type Error = FlashError;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 4;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        check_read(self, offset, bytes.len()).map_err(FlashError)?;
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 64;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        check_erase(self, from, to).map_err(FlashError)?;
        self.work()?;
        self.bytes[from as usize..to as usize].fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        check_write(self, offset, bytes.len()).map_err(FlashError)?;
        self.work()?;
        for (to, from) in self.bytes[offset as usize..].iter_mut().zip(bytes) {
            assert_eq!(*to, 0xFF, "a byte is written once");
            *to = *from;
        }
        Ok(())
    }
}

#[test]
fn slots_keep_bytes_of_any_number_and_one_slot_leaves_the_other() {
    let mut slots = Slots::new(Flash::new(4), 100).expect("two slots of two pages");
    for length in [1, 3, 4, 5, 63, 64, 99, 128] {
        let [first, second]: [Vec<u8>; 2] =
            [1, 2].map(|seed| (0..length).map(|k| (k * seed) as u8 ^ 0x5A).collect());
        slots.write(0, &first).expect("room");
        slots.write(1, &second).expect("room");
        let (mut one, mut other) = (vec![0; length], vec![0; length]);
        slots.read(0, &mut one);
        slots.read(1, &mut other);
        assert_eq!((one, other), (first, second), "{length}");
    }
    assert!(Slots::new(Flash::new(4), 129).is_none(), "no room for two");
    // More than a slot is not written, and what cannot be read is all ones.
    assert_eq!(slots.write(0, &[0; 129]), Err(Fault));
    let mut beyond = vec![0; 300];
    slots.read(0, &mut beyond);
    assert!(beyond.iter().all(|&byte| byte == 0xFF));
    // A failure of the erasure, of the whole words or of the last bytes is told, and leaves the other slot.
    let mut flash = slots.into_flash();
    for left in 0..3 {
        flash.left = left;
        let mut slots = Slots::new(flash, 100).expect("as before");
        let mut before = vec![0; 128];
        slots.read(1, &mut before);
        assert_eq!(slots.write(0, &[7; 99]), Err(Fault), "{left}");
        let mut after = vec![0; 128];
        slots.read(1, &mut after);
        assert_eq!(before, after);
        flash = slots.into_flash();
    }
}

/// A simulated ADXL362 on a simulated clock: registers, and a FIFO that fills as time passes.
#[derive(Debug, Default)]
struct World {
    /// Time in ms.
    now: u64,
    /// Start of measuring in ms, if it measures.
    measuring: Option<u64>,
    /// Samples since that were put into the FIFO or lost.
    produced: u64,
    fifo: VecDeque<[u8; 2]>,
    overrun: bool,
    /// Energy in the storage in J.
    stored: f64,
    ran: [u32; 2],
}

/// Vibration of the line of the resonance, in m/s² and Hz.
const SHAKING: [f64; 2] = [1.9, 20.4];
/// Income and draw of the simulated node in W.
const NET: f64 = 4e-6;
const CAPACITANCE: f64 = 10e-3;

impl World {
    fn pass(&mut self, milliseconds: u64) {
        self.now += milliseconds;
        self.stored = (self.stored + NET * milliseconds as f64 * 1e-3).min(0.5 * CAPACITANCE * 3.3 * 3.3);
        let Some(start) = self.measuring else { return };
        let due = (self.now - start) * u64::from(example::RATE.hertz()) / 1000;
        while self.produced < due {
            let time = start as f64 * 1e-3 + self.produced as f64 / f64::from(example::RATE.hertz());
            let acceleration = SHAKING[0] * (core::f64::consts::TAU * SHAKING[1] * time).sin();
            let count = (acceleration / f64::from(example::UNIT)).round() as i16;
            for (tag, value) in [count, 0, 1000].into_iter().enumerate() {
                if self.fifo.len() == 512 {
                    self.fifo.pop_front();
                    self.overrun = true;
                }
                self.fifo.push_back(entry(tag as u16, value));
            }
            self.produced += 1;
        }
    }

    fn command(&mut self, command: &[u8], answer: &mut [u8]) {
        match *command {
            [0x0B, 0x00] => answer.copy_from_slice(&[0xAD, 0x1D, 0xF2]),
            [0x0B, 0x0B] => {
                let [low, high] = (self.fifo.len() as u16).to_le_bytes();
                answer.copy_from_slice(&[u8::from(self.overrun) << 3, low, high]);
                self.overrun = false;
            }
            [0x0D] => {
                for pair in answer.chunks_mut(2) {
                    pair.copy_from_slice(&self.fifo.pop_front().expect("an entry"));
                }
            }
            [0x0A, 0x2D, 0x02] => (self.measuring, self.produced) = (Some(self.now), 0),
            [0x0A, 0x2D, 0x00] => self.measuring = None,
            [0x0A, 0x1F, 0x52] => {
                self.measuring = None;
                self.fifo.clear();
            }
            [0x0A, 0x28 | 0x2C, _] => {}
            _ => panic!("no such command: {command:?}"),
        }
    }
}

type Shared = Rc<RefCell<World>>;

struct Chip(Shared);

impl ErrorType for Chip {
    type Error = Infallible;
}

impl SpiDevice for Chip {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut world = self.0.borrow_mut();
        match operations {
            [Operation::Write(command), Operation::Read(answer)] => world.command(command, answer),
            [Operation::Write(command)] => world.command(command, &mut []),
            _ => panic!("no such transaction"),
        }
        Ok(())
    }
}

fn board(world: &Shared, flash: Flash) -> impl Board + use<> {
    let [sleeping, converting, acting] = [world, world, world].map(Rc::clone);
    HalBoard {
        sensor: Adxl362::new(Chip(Rc::clone(world)), Axis::X, example::RANGE, example::RATE),
        delay: NoopDelay::new(),
        sleep: move |milliseconds: u32| {
            let mut world = sleeping.borrow_mut();
            world.pass(u64::from(milliseconds));
            (world.now / 1000) as u32
        },
        convert: move || {
            let voltage = (2.0 * converting.borrow().stored / CAPACITANCE).sqrt();
            Some((voltage / f64::from(example::FULL_SCALE) * 4096.0).round() as u32)
        },
        act: move |action: usize| acting.borrow_mut().ran[action] += 1,
        slots: Slots::new(flash, 4096).expect("two slots"),
    }
}

#[test]
fn a_node_on_the_board_takes_bursts_acts_and_resumes() {
    let world: Shared = Rc::new(RefCell::new(World { stored: 0.5 * CAPACITANCE * 7.0, ..World::default() }));
    let node = &example::NODE;
    let mut runner: Runner<_> = Runner::new(board(&world, Flash::new(128)), node, 0);
    let (mut found, mut end) = (Vec::new(), Step::Sampled);
    while world.borrow().now < 4 * 3600 * 1000 || !runner.is_idle() {
        // The storage tells the income, and no burst is worth it.
        if world.borrow().now < 4 * 3600 * 1000 && end == Step::Slept {
            runner.state_mut().ask_for_burst();
        }
        end = runner.step();
        if let Step::Burst(finding) = end {
            found.push(finding);
        }
    }
    assert_eq!(world.borrow().measuring, None, "the sensor is in standby between bursts");
    assert!(found.len() >= 3, "{found:?}");
    // The map has two motions at this line: the samples came through the FIFO whole.
    let is_line = |finding: &Finding| {
        matches!(finding, Finding::Line | Finding::TwoMotions | Finding::TwoMotionsOneSeen)
    };
    assert!(found.iter().all(is_line), "{found:?}");
    let ran = world.borrow().ran;
    assert!(ran[example::MEASURE] >= 4 && ran[example::TRANSMIT] >= 4, "{ran:?}");
    let mut buffer = [0; 4096];
    let sequence = runner.save(&mut buffer).expect("room");
    let before = *runner.state();
    // The same flash after a power-down.
    let mut images = [[0; 4096]; 2];
    let mut board = runner.into_board();
    images.iter_mut().enumerate().for_each(|(slot, image)| board.read_slot(slot, image));
    let mut flash = Flash::new(128);
    for (slot, image) in images.iter().enumerate() {
        flash.bytes[slot * 4096..][..4096].copy_from_slice(image);
    }
    let now = (world.borrow().now / 1000) as u32;
    let mut again: Runner<_> = Runner::new(self::board(&world, flash), node, now);
    assert_eq!(again.resume(&mut images[0], Outage::OnUntil(now)), Ok(sequence));
    assert_eq!(example::ExampleNode::second(again.state()), example::ExampleNode::second(&before));
}

#[test]
fn the_energies_of_the_example_are_those_of_its_parts() {
    let parameters = example::NODE.parameters();
    let processor = Processor::named("nrf52832").expect("a part");
    let accelerometer = Accelerometer::named("adxl362").expect("a part");
    let model = CostModel::new(processor, accelerometer);
    let of = node_instructions(processor.core);
    let burst =
        model.burst(1280, 400.0, 1280.0 * of.sample + of.block, Code::Filter).expect("a rate").total();
    let packet = Radio::named("nrf52832-0-dbm").and_then(|radio| radio.packet(20)).expect("20 bytes");
    let standby = 10e-9 * 3.3;
    let pairs = [
        (parameters.voltage.reading, model.reading(of.reading)),
        (parameters.bursts.energy, burst),
        (parameters.voltage.actions[example::TRANSMIT].energy, packet + model.start_energy()),
        (parameters.voltage.standing_power, model.standing_power().expect("known") + standby),
    ];
    for (found, expected) in pairs {
        assert!((f64::from(found) / expected - 1.0).abs() < 1e-3, "{found:e} {expected:e}");
    }
    assert_eq!(parameters.sensor.start_up, accelerometer.start_up_samples);
}

#[test]
fn a_sensor_that_does_not_answer_is_a_fault() {
    let mut spi = Spi::new(&[read(&[0x0B, 0x00], &[0, 0, 0]), written(&[0x0A, 0x2D, 0x00])].concat());
    let mut board = HalBoard {
        sensor: sensor(spi.clone()),
        delay: NoopDelay::new(),
        sleep: |milliseconds: u32| milliseconds,
        convert: || None,
        act: |_: usize| {},
        slots: Slots::new(Flash::new(4), 64).expect("two slots"),
    };
    assert_eq!(board.start_sensor(), Err(Fault));
    board.stop_sensor();
    assert_eq!(board.storage_code(), None);
    // 200 samples a second; at most 149 of the 170 that the FIFO holds.
    assert_eq!((board.sleep(2, 0), board.sleep(2, 100), board.sleep(2, 1000)), (2000, 500, 745));
    assert_eq!(board.sleep(0, 100), 0);
    spi.done();
}
