//! The registers of a microcontroller in memory: a clock, a converter, an ADXL362, two pages of flash. By them the program runs
//! through three days, each listen, action and image included, and its stack is measured.

use core::cell::UnsafeCell;

use super::{PAGE, Register, Registers, run};
use crate::node::IMAGE_BYTES;
use crate::node::parts::{ACTIONS, BURST, ExampleNode, ExampleState, RATE};
use crate::stack;
use crate::stop::{Code, stop};

/// Seconds of a life of the node; then it starts again from its image.
const LIFE: u32 = 130_000;
const LIVES: u32 = 2;
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
        let shaking = if (self.second() / 21_600).is_multiple_of(2) {
            if count % 5 < 3 { 30 } else { -45 }
        } else {
            (count.wrapping_mul(2_654_435_769) >> 26) as i32 - 32
        };
        let value = if axis == 2 { 1000 + shaking } else { 0 };
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

/// Runs the program, and logs its deepest stack and what of it is known by its type, in bytes.
pub fn measure() -> ! {
    stack::paint();
    for life in 1..=LIVES {
        run::<Simulated>(|second| second >= life * LIFE);
    }
    let deepest = stack::deepest() as usize;
    for (name, bytes) in [
        ("stack", deepest),
        ("node", size_of::<ExampleNode>()),
        ("state", size_of::<ExampleState>()),
        ("burst", size_of::<[i16; BURST]>()),
        ("image", IMAGE_BYTES),
    ] {
        defmt::info!("bytes {=str} {=usize}", name, bytes);
    }
    stop(Code::Done)
}
