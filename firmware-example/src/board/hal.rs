//! A board of any microcontroller whose crate implements `embedded-hal` 1.0 and `embedded-storage`.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;
use embedded_storage::nor_flash::NorFlash;
use model_core::node::{Board, Fault};

use super::adxl362::Adxl362;
use super::flash::Slots;

/// A [`Board`] of an ADXL362, a flash, and three functions of the microcontroller.
///
/// The accelerometer keeps its supply and is in standby between listens. A pin that took its supply away would leave the
/// chip select high, which feeds the part through its protection diode beyond its absolute maximum ratings. After a reset
/// of the processor the part may still measure: call [`Board::stop_sensor`] before the first listen.
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
        // A part that does not answer is reset before the next listen.
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
