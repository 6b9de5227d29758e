//! The accelerometer ADXL362 over SPI, as far as a node needs it: one axis out of its FIFO.
//!
//! Registers and commands are those of the data sheet of the ADXL362: "Serial communications", "Register map" and
//! "FIFO". An own driver, because no crate for this part is in the registry.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{Operation, SpiDevice};
use embedded_hal_async::delay::DelayNs as AsyncDelay;
use embedded_hal_async::spi::SpiDevice as AsyncSpiDevice;

/// Commands: "SPI commands".
const WRITE: u8 = 0x0A;
const READ: u8 = 0x0B;
const READ_FIFO: u8 = 0x0D;

/// Registers: "Register map".
const DEVICE_IDENTITY: u8 = 0x00;
const STATUS: u8 = 0x0B;
const SOFT_RESET: u8 = 0x1F;
const FIFO_CONTROL: u8 = 0x28;
const FILTER_CONTROL: u8 = 0x2C;
const POWER_CONTROL: u8 = 0x2D;

/// `DEVID_AD`, `DEVID_MST` and `PARTID`.
const IDENTITY: [u8; 3] = [0xAD, 0x1D, 0xF2];
/// What `SOFT_RESET` takes, the letter R.
const RESET: u8 = 0x52;
/// Time after a reset until the part answers.
const RESET_US: u32 = 500;
/// Time from the supply to the first answer.
const POWER_UP_US: u32 = 5_000;
/// `FIFO_CONTROL`: stream mode, and the ninth bit of the watermark.
const STREAM: u8 = 0b10;
/// `POWER_CONTROL`: measurement mode.
const MEASURE: u8 = 0b10;
/// What stops the part.
const STANDBY: [u8; 3] = [WRITE, POWER_CONTROL, 0];
/// `STATUS`: the FIFO lost samples.
const OVERRUN: u8 = 0b1000;

/// Entries of the FIFO, of 16 bits; a sample of three axes takes three.
const ENTRIES: usize = 512;
/// Entries that are read in one go.
const BLOCK: usize = 48;

/// The axis of the harvester.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Entries with the tag 0.
    X,
    /// 1.
    Y,
    /// 2.
    Z,
}

/// The range, by the bits of `FILTER_CONTROL`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// ±2 g, 1 mg a count.
    G2 = 0b00,
    /// ±4 g, 2 mg a count.
    G4 = 0b01,
    /// ±8 g, 4 mg a count.
    G8 = 0b10,
}

/// Samples in a second, by the bits of `FILTER_CONTROL`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rate {
    /// 100 a second.
    Hz100 = 0b011,
    /// 200 a second.
    Hz200 = 0b100,
    /// 400 a second.
    Hz400 = 0b101,
}

impl Rate {
    /// Samples in a second.
    #[must_use]
    pub const fn hertz(self) -> u32 {
        match self {
            Self::Hz100 => 100,
            Self::Hz200 => 200,
            Self::Hz400 => 400,
        }
    }
}

/// Why there are no samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Adxl362Error<E> {
    Bus(E),
    /// Something else answers: the first three registers.
    Identity([u8; 3]),
    /// The FIFO lost samples.
    Overrun,
    /// The FIFO gave something that is not three axes in turn.
    Misaligned,
}

/// An ADXL362 on an SPI bus of up to 8 MHz, mode 0: by [`Adxl362::start`], [`Adxl362::stop`] and [`Adxl362::read`] over the
/// blocking traits, by [`Adxl362::start_async`] and its like over those of `embedded-hal-async`.
#[derive(Debug)]
pub struct Adxl362<SPI> {
    spi: SPI,
    axis: Axis,
    range: Range,
    rate: Rate,
    /// Whether it has answered since the supply came on.
    is_up: bool,
}

impl<SPI> Adxl362<SPI> {
    /// The part on its bus; nothing is sent before it is started.
    pub const fn new(spi: SPI, axis: Axis, range: Range, rate: Rate) -> Self {
        Self { spi, axis, range, rate, is_up: false }
    }

    /// The sample rate.
    pub const fn rate(&self) -> Rate {
        self.rate
    }

    /// Whole samples that the FIFO holds.
    #[must_use]
    pub const fn fifo_samples() -> usize {
        ENTRIES / 3
    }

    /// What is written after a reset, to measure.
    const fn settings(&self) -> [[u8; 3]; 3] {
        [
            [WRITE, FILTER_CONTROL, (self.range as u8) << 6 | self.rate as u8],
            [WRITE, FIFO_CONTROL, STREAM],
            [WRITE, POWER_CONTROL, MEASURE],
        ]
    }

    /// Takes in who answers.
    fn identify<E>(&mut self, identity: [u8; 3]) -> Result<(), Adxl362Error<E>> {
        self.is_up = identity == IDENTITY;
        if self.is_up { Ok(()) } else { Err(Adxl362Error::Identity(identity)) }
    }

    /// Moves whole samples of the axis, as the FIFO gave them, to `block`.
    fn unpack<E>(&self, bytes: &[u8], block: &mut [i16]) -> Result<(), Adxl362Error<E>> {
        for (sample, axes) in block.iter_mut().zip(bytes.chunks_exact(6)) {
            for (tag, entry) in axes.chunks_exact(2).enumerate() {
                let &[low, high] = entry else { return Err(Adxl362Error::Misaligned) };
                // Bits 15 and 14 are the axis, 13 to 0 the value with its sign extended.
                let entry = u16::from_le_bytes([low, high]);
                if usize::from(entry >> 14) != tag {
                    return Err(Adxl362Error::Misaligned);
                }
                if tag == self.axis as usize {
                    *sample = (entry << 2) as i16 >> 2;
                }
            }
        }
        Ok(())
    }
}

/// Whole samples in the FIFO, by the status and the number of its entries with the low byte first.
fn waiting<E>([status, low, high]: [u8; 3]) -> Result<usize, Adxl362Error<E>> {
    if status & OVERRUN != 0 {
        return Err(Adxl362Error::Overrun);
    }
    Ok(usize::from(u16::from_le_bytes([low, high & 0b11])) / 3)
}

impl<SPI: SpiDevice> Adxl362<SPI> {
    /// Starts measuring into the FIFO, from standby; the first time it waits until the part is up.
    ///
    /// # Errors
    /// The bus, or another part.
    pub fn start(&mut self, delay: &mut impl DelayNs) -> Result<(), Adxl362Error<SPI::Error>> {
        if !self.is_up {
            delay.delay_us(POWER_UP_US);
        }
        let mut identity = [0; 3];
        self.read_registers(DEVICE_IDENTITY, &mut identity)?;
        self.identify::<SPI::Error>(identity)?;
        self.write(&[WRITE, SOFT_RESET, RESET])?;
        delay.delay_us(RESET_US);
        self.settings().iter().try_for_each(|setting| self.write(setting))
    }

    /// Stops measuring: standby.
    ///
    /// # Errors
    /// The bus.
    pub fn stop(&mut self) -> Result<(), Adxl362Error<SPI::Error>> {
        self.write(&STANDBY)
    }

    /// Moves the samples of the axis from the FIFO to the front of `samples`, the oldest first, and returns their number.
    ///
    /// # Errors
    /// The bus; samples that were lost since the last call.
    pub fn read(&mut self, samples: &mut [i16]) -> Result<usize, Adxl362Error<SPI::Error>> {
        let mut state = [0; 3];
        self.read_registers(STATUS, &mut state)?;
        let wanted = waiting::<SPI::Error>(state)?.min(samples.len());
        let mut taken = 0;
        for block in samples.get_mut(..wanted).unwrap_or(&mut []).chunks_mut(BLOCK / 3) {
            self.read_block(block)?;
            taken += block.len();
        }
        Ok(taken)
    }

    /// Reads as many whole samples from the FIFO as `block` holds, at most a third of [`BLOCK`].
    fn read_block(&mut self, block: &mut [i16]) -> Result<(), Adxl362Error<SPI::Error>> {
        let mut bytes = [0; 2 * BLOCK];
        let bytes = bytes.get_mut(..6 * block.len()).unwrap_or(&mut []);
        self.spi
            .transaction(&mut [Operation::Write(&[READ_FIFO]), Operation::Read(bytes)])
            .map_err(Adxl362Error::Bus)?;
        self.unpack(bytes, block)
    }

    fn read_registers(&mut self, first: u8, values: &mut [u8]) -> Result<(), Adxl362Error<SPI::Error>> {
        self.spi
            .transaction(&mut [Operation::Write(&[READ, first]), Operation::Read(values)])
            .map_err(Adxl362Error::Bus)
    }

    fn write(&mut self, command: &[u8]) -> Result<(), Adxl362Error<SPI::Error>> {
        self.spi.write(command).map_err(Adxl362Error::Bus)
    }
}

/// The same over the traits of `embedded-hal-async`.
impl<SPI: AsyncSpiDevice> Adxl362<SPI> {
    /// As [`Adxl362::start`].
    ///
    /// # Errors
    /// The bus, or another part.
    pub async fn start_async(&mut self, delay: &mut impl AsyncDelay) -> Result<(), Adxl362Error<SPI::Error>> {
        if !self.is_up {
            delay.delay_us(POWER_UP_US).await;
        }
        let identity = self.registers(DEVICE_IDENTITY).await?;
        self.identify::<SPI::Error>(identity)?;
        self.command(&[WRITE, SOFT_RESET, RESET]).await?;
        delay.delay_us(RESET_US).await;
        for setting in self.settings() {
            self.command(&setting).await?;
        }
        Ok(())
    }

    /// As [`Adxl362::stop`].
    ///
    /// # Errors
    /// The bus.
    pub async fn stop_async(&mut self) -> Result<(), Adxl362Error<SPI::Error>> {
        self.command(&STANDBY).await
    }

    /// As [`Adxl362::read`].
    ///
    /// # Errors
    /// The bus; samples that were lost since the last call.
    pub async fn read_async(&mut self, samples: &mut [i16]) -> Result<usize, Adxl362Error<SPI::Error>> {
        let wanted = waiting::<SPI::Error>(self.registers(STATUS).await?)?.min(samples.len());
        for block in samples.get_mut(..wanted).unwrap_or(&mut []).chunks_mut(BLOCK / 3) {
            let mut bytes = [0; 2 * BLOCK];
            let bytes = bytes.get_mut(..6 * block.len()).unwrap_or(&mut []);
            self.exchange(&[READ_FIFO], bytes).await?;
            self.unpack::<SPI::Error>(bytes, block)?;
        }
        Ok(wanted)
    }

    async fn registers(&mut self, first: u8) -> Result<[u8; 3], Adxl362Error<SPI::Error>> {
        let mut values = [0; 3];
        self.exchange(&[READ, first], &mut values).await?;
        Ok(values)
    }

    async fn exchange(&mut self, command: &[u8], answer: &mut [u8]) -> Result<(), Adxl362Error<SPI::Error>> {
        let mut operations = [Operation::Write(command), Operation::Read(answer)];
        self.spi.transaction(&mut operations).await.map_err(Adxl362Error::Bus)
    }

    async fn command(&mut self, command: &[u8]) -> Result<(), Adxl362Error<SPI::Error>> {
        self.spi.write(command).await.map_err(Adxl362Error::Bus)
    }
}
