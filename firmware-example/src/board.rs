//! Boards of [`model_core::node`] over the traits of `embedded-hal` 1.0: a board of any microcontroller whose crate implements
//! them, with two slots for images in NOR flash.
//!
//! | module | subject |
//! | --- | --- |
//! | `adxl362` | the registers of an accelerometer with a FIFO, over SPI |
//! | `example` | the parameters of a node on such a board |

pub mod adxl362;
pub mod example;

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;
use embedded_storage::nor_flash::NorFlash;
use model_core::node::{Board, Fault};

use adxl362::Adxl362;

/// Longest unit that the flash may read or write, in bytes.
const UNIT: usize = 32;

/// Two slots of whole erasable units, one after the other from the start of a flash.
#[derive(Debug)]
pub struct Slots<F> {
    flash: F,
    /// Bytes of a slot.
    size: u32,
}

impl<F: NorFlash> Slots<F> {
    /// Slots of at least `bytes` each; `None` if the flash is too small or its units are longer than 32 bytes.
    pub fn new(flash: F, bytes: usize) -> Option<Self> {
        const { assert!(F::WRITE_SIZE <= UNIT && F::READ_SIZE <= UNIT, "units of up to 32 bytes") };
        let size = bytes.div_ceil(F::ERASE_SIZE).checked_mul(F::ERASE_SIZE)?;
        (size.checked_mul(2)? <= flash.capacity()).then_some(())?;
        Some(Self { flash, size: u32::try_from(size).ok()? })
    }

    pub fn into_flash(self) -> F {
        self.flash
    }

    /// The first byte of a slot; any number but 0 is the second.
    fn start(&self, slot: usize) -> u32 {
        if slot == 0 { 0 } else { self.size }
    }

    /// Copies the front of a slot to `bytes`, all of them `0xFF` where it cannot be read.
    pub fn read(&mut self, slot: usize, bytes: &mut [u8]) {
        let start = self.start(slot);
        let whole = bytes.len() / F::READ_SIZE * F::READ_SIZE;
        let (front, rest) = bytes.split_at_mut(whole);
        let mut unit = [0xFF; UNIT];
        let unit = unit.get_mut(..F::READ_SIZE).unwrap_or(&mut []);
        let mut read = self.flash.read(start, front);
        if !rest.is_empty() {
            read = read.and_then(|()| self.flash.read(start + whole as u32, unit));
            rest.iter_mut().zip(unit).for_each(|(to, from)| *to = *from);
        }
        if read.is_err() {
            bytes.fill(0xFF);
        }
    }

    /// Erases a slot and writes `bytes` to its front.
    ///
    /// # Errors
    /// If the bytes are more than a slot holds, which is then as it was, or the flash reports a failure: the slot then holds
    /// no valid image.
    pub fn write(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault> {
        if bytes.len() > self.size as usize {
            return Err(Fault);
        }
        let start = self.start(slot);
        self.flash.erase(start, start + self.size).map_err(|_| Fault)?;
        let whole = bytes.len() / F::WRITE_SIZE * F::WRITE_SIZE;
        let (front, rest) = bytes.split_at(whole);
        self.flash.write(start, front).map_err(|_| Fault)?;
        if rest.is_empty() {
            return Ok(());
        }
        let mut unit = [0xFF; UNIT];
        unit.iter_mut().zip(rest).for_each(|(to, from)| *to = *from);
        let unit = unit.get(..F::WRITE_SIZE).unwrap_or(&[]);
        self.flash.write(start + whole as u32, unit).map_err(|_| Fault)
    }
}

/// A [`Board`] of an ADXL362, a flash, and three functions of the microcontroller.
///
/// The accelerometer keeps its supply and is in standby between bursts. A pin that took its supply away would leave the
/// chip select high, which feeds the part through its protection diode beyond its absolute maximum ratings. After a reset
/// of the processor the part may still measure: call [`Board::stop_sensor`] before the first burst.
///
/// Samples are waited for by the clock, not by an interrupt of the sensor: the FIFO holds 0.4 s at 400 Hz.
#[derive(Debug)]
pub struct HalBoard<SPI, DELAY, SLEEP, CONVERT, ACT, FLASH> {
    /// The accelerometer.
    pub sensor: Adxl362<SPI>,
    /// Short waits while the accelerometer starts.
    pub delay: DELAY,
    /// Sleeps for so many milliseconds, or less, and gives the second of the clock.
    pub sleep: SLEEP,
    /// The code of the converter for the storage's voltage.
    pub convert: CONVERT,
    /// Carries out the action with this index.
    pub act: ACT,
    /// Where images are kept.
    pub slots: Slots<FLASH>,
}

/// Part of the FIFO that is left free for the delay of a wake-up: an eighth.
const MARGIN: usize = 8;

impl<SPI, DELAY, SLEEP, CONVERT, ACT, FLASH> Board for HalBoard<SPI, DELAY, SLEEP, CONVERT, ACT, FLASH>
where
    SPI: SpiDevice,
    DELAY: DelayNs,
    SLEEP: FnMut(u32) -> u32,
    CONVERT: FnMut() -> Option<u32>,
    ACT: FnMut(usize),
    FLASH: NorFlash,
{
    fn sleep(&mut self, seconds: u32, samples: u32) -> u32 {
        let longest = seconds.saturating_mul(1000);
        if samples == 0 {
            return (self.sleep)(longest);
        }
        let fifo = Adxl362::<SPI>::fifo_samples();
        let samples = samples.min((fifo - fifo / MARGIN) as u32);
        (self.sleep)((samples * 1000).div_ceil(self.sensor.rate().hertz()).min(longest))
    }

    fn storage_code(&mut self) -> Option<u32> {
        (self.convert)()
    }

    fn start_sensor(&mut self) -> Result<(), Fault> {
        self.sensor.start(&mut self.delay).map_err(|_| Fault)
    }

    fn stop_sensor(&mut self) {
        // A part that does not answer is reset before the next burst.
        let _ = self.sensor.stop();
    }

    fn read_samples(&mut self, samples: &mut [i16]) -> Result<usize, Fault> {
        self.sensor.read(samples).map_err(|_| Fault)
    }

    fn run(&mut self, action: usize) {
        (self.act)(action);
    }

    fn read_slot(&mut self, slot: usize, bytes: &mut [u8]) {
        self.slots.read(slot, bytes);
    }

    fn write_slot(&mut self, slot: usize, bytes: &[u8]) -> Result<(), Fault> {
        self.slots.write(slot, bytes)
    }
}

#[cfg(test)]
mod tests;
