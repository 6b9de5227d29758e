//! The registers of a microcontroller in memory: a clock, a converter, an ADXL362, two pages of flash. By them the program runs
//! through three days, each burst, action and image included, and its stack is measured.

use core::cell::UnsafeCell;
use core::hint::black_box;

use model_core::node::{Outage, Progress, Task, Tier, VoltageNode, Wake};
use model_core::snapshot::{image_size, newest_image, save_image};

use super::{BY_VOLTAGE, PAGE, Register, Registers, run};
use crate::measure::Counter;
use crate::node::IMAGE_BYTES;
use crate::node::parts::{ACTIONS, BURST, NODE, Part, RATE};
use crate::stop::{Code, stop};

/// Seconds of a life of the node; then it starts again from its image.
const LIFE: u32 = 130_000;
const LIVES: u32 = 2;
const VOLTAGE_BYTES: usize = image_size::<VoltageNode<ACTIONS>>();
/// Readings whose ticks are counted.
const READINGS: u32 = 500;
/// Counts of a line at a fifth of the rate.
const LINE: [i16; 5] = [1030, 1030, 1030, 955, 955];
/// Codes by which an action lowers the storage, some 0.3 and 7 mJ of 47 mF.
const DRAWN: [u32; ACTIONS] = [2, 36];
/// Codes of the lowest and of the full storage: 2.2 V and 4.5 V of 5 V.
const CODES: [u32; 2] = [1800, 3686];
/// Samples that the FIFO of the accelerometer holds.
const FIFO: u32 = 170;

/// What the registers act on.
struct Parts {
    milliseconds: u32,
    /// Code of the storage, and the second at which it rose.
    code: u32,
    rose: u32,
    /// Millisecond at which the accelerometer was started; `None` in standby.
    started: Option<u32>,
    /// Samples that were read since.
    taken: u32,
    /// Bytes of this transaction, and the first two of them.
    place: u32,
    command: [u8; 2],
    /// The byte that came in last.
    answer: u8,
    pages: [u8; 2 * PAGE],
}

struct Memory(UnsafeCell<Parts>);

// SAFETY: there is one core, no interrupt uses it, and each reference ends with the access to a register.
unsafe impl Sync for Memory {}

static MEMORY: Memory = Memory(UnsafeCell::new(Parts {
    milliseconds: 0,
    code: 2949,
    rose: 0,
    started: None,
    taken: 0,
    place: 0,
    command: [0; 2],
    answer: 0,
    pages: [0xFF; 2 * PAGE],
}));

impl Parts {
    fn second(&self) -> u32 {
        self.milliseconds / 1000
    }

    /// The storage rises by a code in twenty seconds, and by three in the last third of the time.
    fn charge(&mut self) -> u32 {
        let codes = (self.second() - self.rose) / 20;
        self.rose += 20 * codes;
        let speed = if self.second() > LIVES * LIFE / 3 * 2 { 3 } else { 1 };
        self.code = (self.code + speed * codes).min(CODES[1]);
        self.code
    }

    fn waiting(&self) -> u32 {
        let since = self.started.map_or(0, |started| self.milliseconds - started);
        (since * RATE / 1000).saturating_sub(self.taken)
    }

    /// A byte of the accelerometer.
    fn exchange(&mut self, byte: u8) -> u8 {
        let place = self.place;
        self.place += 1;
        if let Some(entry) = self.command.get_mut(place as usize) {
            *entry = byte;
        }
        let [command, register] = self.command;
        match (command, place) {
            // The mode of measurement, or standby.
            (0x0A, 2) if register == 0x2D => {
                self.started = (byte != 0).then_some(self.milliseconds);
                self.taken = 0;
                0
            }
            (0x0B, 2..) => self.value(u32::from(register) + place - 2),
            (0x0D, 1..) => self.entry(place - 1),
            _ => 0,
        }
    }

    /// A register of the accelerometer.
    fn value(&self, register: u32) -> u8 {
        let [low, high] = ((3 * self.waiting().min(FIFO)) as u16).to_le_bytes();
        match register {
            0x00 => 0xAD,
            0x01 => 0x1D,
            0x02 => 0xF2,
            0x0C => low,
            0x0D => high,
            _ => 0,
        }
    }

    /// A byte of the FIFO: gravity, and by turns of six hours a line at 20 Hz or noise.
    fn entry(&mut self, byte: u32) -> u8 {
        let (axis, is_high) = (byte / 2 % 3, byte % 2 == 1);
        let count = self.taken;
        if axis == 2 && is_high {
            self.taken += 1;
        }
        let vibration = if (self.second() / 21_600).is_multiple_of(2) {
            if count % 5 < 3 { 30 } else { -45 }
        } else {
            (count.wrapping_mul(2_654_435_769) >> 26) as i32 - 32
        };
        let value = if axis == 2 { 1000 + vibration } else { 0 };
        let entry = (axis << 14) as u16 | (value as u16 & 0x3FFF);
        let [low, high] = entry.to_le_bytes();
        if is_high { high } else { low }
    }
}

/// The registers of [`MEMORY`].
struct Simulated;

fn parts<T>(access: impl FnOnce(&mut Parts) -> T) -> T {
    // SAFETY: `access` is one of those below, none of which calls this function.
    access(unsafe { &mut *MEMORY.0.get() })
}

impl Registers for Simulated {
    #[inline(never)]
    fn read(register: Register) -> u32 {
        parts(|parts| match register {
            Register::Second => parts.second(),
            Register::Converter => parts.charge(),
            Register::Spi => parts.answer.into(),
            _ => 0,
        })
    }

    #[inline(never)]
    fn write(register: Register, value: u32) {
        parts(|parts| match register {
            Register::Sleep => parts.milliseconds += value,
            Register::Select => parts.place = 0,
            Register::Spi => parts.answer = parts.exchange(value as u8),
            Register::Erase => {
                let from = (value as usize).min(PAGE);
                parts.pages.iter_mut().skip(from).take(PAGE).for_each(|byte| *byte = 0xFF);
            }
            Register::Action => {
                let drawn = DRAWN.get(value as usize).copied().unwrap_or(0);
                parts.code = parts.code.saturating_sub(drawn).max(CODES[0]);
            }
            Register::Second | Register::Wait | Register::Converter => {}
        });
    }

    fn pages() -> usize {
        // SAFETY: an address only; the reference is not kept.
        unsafe { (&raw const (*MEMORY.0.get()).pages).expose_provenance() }
    }
}

/// Runs the program, and logs its deepest stack and what of it is known by its type, in bytes; then each kind of call.
pub fn measure() -> ! {
    crate::measure::paint_stack();
    for life in 1..=LIVES {
        run::<Simulated>(|second| second >= life * LIFE);
    }
    let stack = crate::measure::deepest_stack();
    if BY_VOLTAGE {
        calls::<_, VOLTAGE_BYTES>(&NODE, stack);
    } else {
        calls::<_, IMAGE_BYTES>(Part::TARGET.node(), stack);
    }
    stop(Code::Done)
}

/// Calls of a kind.
#[derive(Clone, Copy, Default)]
struct Calls {
    number: u32,
    ticks: u64,
    largest: u64,
    stack: u32,
}

impl Calls {
    fn time(&mut self, counter: &Counter, mut call: impl FnMut()) {
        crate::measure::paint_stack();
        let before = counter.ticks();
        call();
        let ticks = counter.ticks() - before;
        self.number += 1;
        self.ticks += ticks;
        self.largest = self.largest.max(ticks);
        self.stack = self.stack.max(crate::measure::deepest_stack());
    }
}

/// Logs the sizes of the node, and what each call that a firmware makes of it takes: number, ticks of all, ticks of the largest, and
/// stack. What it takes itself is not of the program.
#[inline(never)]
fn calls<N: Tier<State: Copy>, const IMAGE: usize>(node: &N, stack: u32) {
    let Some(peripherals) = cortex_m::Peripherals::take() else { stop(Code::Faulted) };
    let counter = &Counter::start(peripherals.SYST);
    for (name, bytes) in [("stack", stack as usize), ("state", size_of::<N::State>()), ("image", IMAGE)] {
        defmt::info!("bytes {=str} {=usize}", name, bytes);
    }
    let [mut nothing, mut boot, mut reading, mut other, mut samples, mut block, mut image] =
        [Calls::default(); 7];
    nothing.time(counter, || ());
    let (mut state, mut bytes, mut second) = (node.start(0), [0; IMAGE], 0);
    let mut wake = Wake { task: Task::Sleep, again_in: 0, read: true };
    while reading.number < READINGS {
        if let Task::Burst { samples: mut left } = wake.task {
            let mut progress = Progress::Idle;
            while left > 0 {
                let line = core::array::from_fn::<_, 128, _>(|n| LINE[(n + left as usize) % LINE.len()]);
                samples.time(counter, || progress = node.samples(&mut state, black_box(&line)));
                left = left.saturating_sub(128);
            }
            while progress == Progress::Done(None) {
                block.time(counter, || progress = node.samples(&mut state, black_box(&[])));
            }
            second += BURST / RATE;
        }
        second += if let Task::Burst { .. } = wake.task { 0 } else { wake.again_in };
        let code = wake.read.then(|| 2600 + second / 100 % 1200);
        let kind = if code.is_some() { &mut reading } else { &mut other };
        kind.time(counter, || wake = node.wake(&mut state, second, black_box(code)));
    }
    image.time(counter, || _ = black_box(save_image(node, &state, 1, &mut bytes)));
    boot.time(counter, || {
        let resumed = newest_image(node, [&bytes, &bytes]);
        state = resumed.map_or(node.start(second), |image| image.state);
        wake = node.wake_after(&mut state, Outage::OnUntil(second), None);
    });
    let names = ["boot", "reading", "wake", "samples", "block", "image"];
    for (name, of) in names.into_iter().zip([boot, reading, other, samples, block, image]) {
        let stack = of.stack.saturating_sub(nothing.stack);
        defmt::info!("call {=str} {=u32} {=u64} {=u64} {=u32}", name, of.number, of.ticks, of.largest, stack);
    }
}
