//! The program of a node on [`crate::board`], on a microcontroller whose peripherals are a register each: what a user would
//! flash, without the layers of a crate for a part.

pub mod simulated;

use core::convert::Infallible;
use core::marker::PhantomData;

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use embedded_storage::nor_flash::{
    ErrorType as FlashErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use model_core::node::{Board, Fault, Outage, Runner, Tier, VoltageNode};
use model_core::snapshot::image_size;

use super::parts::{ACTIONS, NODE, Part};
use super::{IMAGE_BYTES, IMAGE_EVERY};
use crate::board::adxl362::{Adxl362, Axis, Range, Rate};
use crate::board::{HalBoard, Slots};
use crate::stop::{Code, stop};

/// The registers of a microcontroller.
pub trait Registers {
    /// The value of a register.
    fn read(register: Register) -> u32;

    /// Sets a register.
    fn write(register: Register, value: u32);

    /// Address of the two pages of flash that hold the images.
    fn pages() -> usize;
}

/// What a register does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Register {
    /// Gives the second of the clock.
    Second,
    /// Sleeps for so many milliseconds.
    Sleep,
    /// Waits for so many nanoseconds.
    Wait,
    /// Gives the code of the converter.
    Converter,
    /// Selects the accelerometer.
    Select,
    /// Takes a byte, and gives the one that came in.
    Spi,
    /// Erases the page that begins at an offset.
    Erase,
    /// Carries an action out.
    Action,
}

/// Bytes of a page of the flash.
pub const PAGE: usize = 1024;

struct Spi<R>(PhantomData<R>);

impl<R> ErrorType for Spi<R> {
    type Error = Infallible;
}

impl<R: Registers> SpiDevice for Spi<R> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let exchange = |byte: u8| {
            R::write(Register::Spi, byte.into());
            R::read(Register::Spi) as u8
        };
        R::write(Register::Select, 1);
        for operation in operations {
            match operation {
                Operation::Read(bytes) => bytes.iter_mut().for_each(|byte| *byte = exchange(0)),
                Operation::Write(bytes) => {
                    for &byte in *bytes {
                        exchange(byte);
                    }
                }
                Operation::Transfer(to, from) => {
                    let from = from.iter().copied().chain(core::iter::repeat(0));
                    to.iter_mut().zip(from).for_each(|(to, from)| *to = exchange(from));
                }
                Operation::TransferInPlace(bytes) => {
                    bytes.iter_mut().for_each(|byte| *byte = exchange(*byte));
                }
                Operation::DelayNs(nanoseconds) => R::write(Register::Wait, *nanoseconds),
            }
        }
        R::write(Register::Select, 0);
        Ok(())
    }
}

struct Wait<R>(PhantomData<R>);

impl<R: Registers> DelayNs for Wait<R> {
    fn delay_ns(&mut self, nanoseconds: u32) {
        R::write(Register::Wait, nanoseconds);
    }
}

/// The two pages of the images.
struct Flash<R>(PhantomData<R>);

#[derive(Debug)]
struct Outside;

impl NorFlashError for Outside {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

impl<R> FlashErrorType for Flash<R> {
    type Error = Outside;
}

/// An offset into the two pages with `length` bytes from it on.
fn within(offset: u32, length: usize) -> Result<usize, Outside> {
    let offset = offset as usize;
    let end = offset.checked_add(length).filter(|&end| end <= 2 * PAGE);
    end.map(|_| offset).ok_or(Outside)
}

impl<R: Registers> ReadNorFlash for Flash<R> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Outside> {
        let start = R::pages() + within(offset, bytes.len())?;
        for (index, byte) in bytes.iter_mut().enumerate() {
            // SAFETY: a byte of the two pages.
            *byte = unsafe { core::ptr::with_exposed_provenance::<u8>(start + index).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * PAGE
    }
}

impl<R: Registers> NorFlash for Flash<R> {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Outside> {
        let length = to.checked_sub(from).ok_or(Outside)? as usize;
        let start = within(from, length)?;
        (start..start + length).step_by(PAGE).for_each(|page| R::write(Register::Erase, page as u32));
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Outside> {
        let start = R::pages() + within(offset, bytes.len())?;
        let (words, _) = bytes.as_chunks::<4>();
        for (index, &word) in words.iter().enumerate() {
            let to = core::ptr::without_provenance_mut::<u32>(start + 4 * index);
            // SAFETY: a word of the two pages, which nothing else refers to.
            unsafe { to.write_volatile(u32::from_le_bytes(word)) };
        }
        Ok(())
    }
}

/// Whether the program is that of the node by the voltage alone: the only variant of this binary.
const BY_VOLTAGE: bool = option_env!("HARVESTER_VARIANT").is_some();

/// Runs the node until `is_over` at a second of the clock.
pub fn run<R: Registers>(is_over: impl Fn(u32) -> bool) {
    if BY_VOLTAGE {
        const IMAGE: usize = image_size::<VoltageNode<ACTIONS>>();
        live::<R, _, _, IMAGE>(VoltageBoard(slots::<R>()), &NODE, is_over);
    } else {
        live::<R, _, _, IMAGE_BYTES>(with_sensor::<R>(), Part::TARGET.node(), is_over);
    }
}

fn slots<R: Registers>() -> Slots<Flash<R>> {
    match Slots::new(Flash(PhantomData), PAGE) {
        Some(slots) => slots,
        None => stop(Code::WorkloadFailed),
    }
}

/// A board without a sensor.
struct VoltageBoard<R>(Slots<Flash<R>>);

impl<R: Registers> Board for VoltageBoard<R> {
    fn sleep(&mut self, seconds: u32, _samples: u32) -> u32 {
        R::write(Register::Sleep, 1000 * seconds);
        R::read(Register::Second)
    }

    fn storage_code(&mut self) -> Option<u32> {
        Some(R::read(Register::Converter))
    }

    fn run(&mut self, action: usize) {
        R::write(Register::Action, action as u32);
    }

    fn read_slot(&mut self, slot: usize, bytes: &mut [u8]) {
        self.0.read(slot, bytes);
    }

    fn write_slot(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault> {
        self.0.write(slot, bytes)
    }
}

fn with_sensor<R: Registers>() -> impl Board {
    let mut board = HalBoard {
        sensor: Adxl362::new(Spi::<R>(PhantomData), Axis::Z, Range::G2, Rate::Hz100),
        delay: Wait::<R>(PhantomData),
        sleep: |milliseconds: u32| {
            R::write(Register::Sleep, milliseconds);
            R::read(Register::Second)
        },
        convert: || Some(R::read(Register::Converter)),
        act: |action: usize| R::write(Register::Action, action as u32),
        slots: slots::<R>(),
    };
    // A reset of the processor may have come in a burst.
    board.stop_sensor();
    board
}

fn live<R: Registers, B: Board, N: Tier<State: Copy>, const IMAGE: usize>(
    board: B,
    node: &N,
    is_over: impl Fn(u32) -> bool,
) {
    let mut runner = started::<_, _, IMAGE>(board, node, R::read(Register::Second));
    let mut saved = N::second(runner.state());
    while !is_over(N::second(runner.state())) {
        runner.step();
        let second = N::second(runner.state());
        if runner.is_idle() && second.saturating_sub(saved) >= IMAGE_EVERY {
            saved = second;
            save::<_, _, IMAGE>(&mut runner);
        }
    }
}

/// The node on its board, which goes on from the newest image; without one it begins anew.
#[inline(never)]
fn started<B: Board, N: Tier<State: Copy>, const IMAGE: usize>(
    board: B,
    node: &N,
    second: u32,
) -> Runner<'_, B, N> {
    let mut runner = Runner::new(board, node, second);
    let _ = runner.resume(&mut [0; IMAGE], Outage::OnUntil(second));
    runner
}

/// Writes an image, whose buffer is free again afterwards. A failure of the flash leaves the image before it.
#[inline(never)]
fn save<B: Board, N: Tier<State: Copy>, const IMAGE: usize>(runner: &mut Runner<'_, B, N>) {
    let _ = runner.save(&mut [0; IMAGE]);
}
