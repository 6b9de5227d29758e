//! The node of [`firmware_example::node`] on the board of [`firmware_example::board`], on a microcontroller whose
//! peripherals are a register each: the firmware that a user would flash, without the layers of a crate for a part.
//!
//! `host-bench on-target --node` builds it for each core for its size. It is not run: no part has these registers.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod target {
    use core::convert::Infallible;

    use embedded_hal::delay::DelayNs;
    use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
    use embedded_storage::nor_flash::{
        ErrorType as FlashErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
    };
    use firmware_example::board::adxl362::{Adxl362, Axis, Range, Rate};
    use firmware_example::board::flash::Slots;
    use firmware_example::board::hal::HalBoard;
    use firmware_example::node::parts::{Part, Runner};
    use firmware_example::node::{IMAGE_BYTES, IMAGE_EVERY};
    use firmware_example::stop::{Code, stop};
    use model_core::node::{Board, Gap, Step};

    /// Registers, and what they do.
    const REGISTERS: usize = 0x4000_0000;
    /// The second of the clock.
    const SECOND: usize = 0;
    /// Sleeps for so many milliseconds.
    const SLEEP: usize = 1;
    /// Waits for so many nanoseconds.
    const WAIT: usize = 2;
    /// The code of the converter.
    const CONVERTER: usize = 3;
    /// Selects the accelerometer.
    const SELECT: usize = 4;
    /// A byte out, and the one that came in.
    const SPI: usize = 5;
    /// Erases the page of an address.
    const ERASE: usize = 6;
    /// The action that runs.
    const ACTION: usize = 7;

    /// Bytes of a page of the flash, and the address of the two that hold the images.
    const PAGE: usize = 1024;
    const SLOTS: usize = 0x0003_f800;

    fn register(number: usize) -> *mut u32 {
        core::ptr::without_provenance_mut(REGISTERS + 4 * number)
    }

    fn read(number: usize) -> u32 {
        // SAFETY: the address of a register, which only this program uses.
        unsafe { register(number).read_volatile() }
    }

    fn write(number: usize, value: u32) {
        // SAFETY: as above.
        unsafe { register(number).write_volatile(value) }
    }

    struct Spi;

    impl ErrorType for Spi {
        type Error = Infallible;
    }

    impl SpiDevice for Spi {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
            let exchange = |byte: u8| {
                write(SPI, byte.into());
                read(SPI) as u8
            };
            write(SELECT, 1);
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
                    Operation::DelayNs(nanoseconds) => write(WAIT, *nanoseconds),
                }
            }
            write(SELECT, 0);
            Ok(())
        }
    }

    struct Wait;

    impl DelayNs for Wait {
        fn delay_ns(&mut self, nanoseconds: u32) {
            write(WAIT, nanoseconds);
        }
    }

    /// The two pages of the images.
    struct Flash;

    #[derive(Debug)]
    struct Outside;

    impl NorFlashError for Outside {
        fn kind(&self) -> NorFlashErrorKind {
            NorFlashErrorKind::OutOfBounds
        }
    }

    impl FlashErrorType for Flash {
        type Error = Outside;
    }

    /// The address of `length` bytes from an offset on.
    fn within(offset: u32, length: usize) -> Result<usize, Outside> {
        let offset = offset as usize;
        let end = offset.checked_add(length).filter(|&end| end <= 2 * PAGE);
        end.map(|_| SLOTS + offset).ok_or(Outside)
    }

    impl ReadNorFlash for Flash {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Outside> {
            let start = within(offset, bytes.len())?;
            for (index, byte) in bytes.iter_mut().enumerate() {
                // SAFETY: a byte of the two pages.
                *byte = unsafe { core::ptr::without_provenance::<u8>(start + index).read_volatile() };
            }
            Ok(())
        }

        fn capacity(&self) -> usize {
            2 * PAGE
        }
    }

    impl NorFlash for Flash {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = PAGE;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), Outside> {
            let length = to.checked_sub(from).ok_or(Outside)? as usize;
            let start = within(from, length)?;
            (start..start + length).step_by(PAGE).for_each(|page| write(ERASE, page as u32));
            Ok(())
        }

        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Outside> {
            let start = within(offset, bytes.len())?;
            let (words, _) = bytes.as_chunks::<4>();
            for (index, &word) in words.iter().enumerate() {
                let to = core::ptr::without_provenance_mut::<u32>(start + 4 * index);
                // SAFETY: a word of the two pages, which nothing else refers to.
                unsafe { to.write_volatile(u32::from_le_bytes(word)) };
            }
            Ok(())
        }
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let (Ok(node), Some(slots)) = (Part::TARGET.node(), Slots::new(Flash, PAGE)) else {
            stop(Code::WorkloadFailed)
        };
        let mut board = HalBoard {
            sensor: Adxl362::new(Spi, Axis::Z, Range::G2, Rate::Hz100),
            delay: Wait,
            sleep: |milliseconds: u32| {
                write(SLEEP, milliseconds);
                read(SECOND)
            },
            convert: || Some(read(CONVERTER)),
            act: |action: usize| write(ACTION, action as u32),
            slots,
        };
        // A reset of the processor may have come in a listen.
        board.stop_sensor();
        let mut runner: Runner<_> = Runner::new(board, node, read(SECOND));
        let mut image = [0; IMAGE_BYTES];
        // Without an image the node begins anew.
        let _ = runner.resume(&mut image, Gap::OnUntil(read(SECOND)));
        let mut saved = runner.state().second();
        loop {
            let step = runner.step();
            let second = runner.state().second();
            if step == Step::Slept && runner.is_idle() && second.saturating_sub(saved) >= IMAGE_EVERY {
                saved = second;
                // A failure of the flash leaves the image before it.
                let _ = runner.save(&mut image);
            }
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", firmware_example::HOW_TO_BUILD);
}
