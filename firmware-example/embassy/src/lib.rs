//! A node of `model_core::node` as a task of Embassy, [`keep_books`], over the traits of `embedded-hal-async` and
//! `embedded-storage-async`. The binary `node_nrf52840` runs it on an nRF52840, `node_simulated` under QEMU and on the host.

#![no_std]

use embassy_time::{Delay, Duration, Instant, TICK_HZ, Timer, with_deadline};
use embedded_hal_async::spi::SpiDevice;
use embedded_storage_async::nor_flash::NorFlash;
use firmware_example::board::adxl362::{Adxl362, Adxl362Error};
use model_core::node::{Outage, Progress, Status, Task, TickClock, Tier, Wake};
use model_core::snapshot::{image_size, read_image, save_image};
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapStorage, SerializationError, Value};

/// An action that the node allows, and what it knows then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Second of the clock of the node.
    pub second: u32,
    /// Index of the action.
    pub action: usize,
    /// For a packet or a log.
    pub status: Status,
}

/// Where the images of a node are: `sequential-storage` spreads them over the pages.
pub type Images<FLASH> = MapStorage<u8, FLASH, Cache<Uncached, Uncached, Uncached, u8>>;

/// The parts of a board.
#[expect(missing_debug_implementations, reason = "`MapStorage` has none")]
pub struct Parts<SPI, CONVERT, ACT, FLASH: NorFlash> {
    /// The accelerometer.
    pub sensor: Adxl362<SPI>,
    /// The code of the converter for the storage's voltage; `None` if it cannot be read.
    pub convert: CONVERT,
    /// Carries an order out, or leaves it to another task and waits for that.
    pub act: ACT,
    pub images: Images<FLASH>,
    /// Seconds from one image to the next.
    pub image_every: u32,
}

const CLOCK: TickClock = TickClock(core::num::NonZero::new(TICK_HZ).expect("a clock has ticks"));
/// The only key of the images, and bytes of a buffer for any of them.
const KEY: u8 = 0;
const ROOM: usize = 384;
/// Samples that are taken out of the FIFO at once; it holds 170.
const BURST: usize = 128;

/// The node, from its newest image if there is one. The future may be dropped at any time, as by a loss of power.
pub async fn keep_books<N, SPI, CONVERT, ACT, FLASH>(
    node: &N,
    mut parts: Parts<SPI, CONVERT, ACT, FLASH>,
) -> !
where
    N: Tier,
    SPI: SpiDevice,
    CONVERT: AsyncFnMut() -> Option<u32>,
    ACT: AsyncFnMut(Order),
    FLASH: NorFlash,
{
    const { assert!(image_size::<N>() + FLASH::WRITE_SIZE < ROOM, "an image in the buffer") };
    // A reset of the processor may have come in a burst. A part that does not answer is reset before the next one.
    let _ = parts.sensor.stop_async().await;
    let mut state = node.start(0);
    let has_image = read_newest(node, &mut state, &mut parts.images).await;
    if !has_image {
        state = node.start(0);
    }
    // The clock goes on from the image: without one of its own supply no one knows how long the power-down was.
    let uptime = || CLOCK.second(Instant::now().as_ticks());
    let start = N::second(&state).wrapping_sub(uptime());
    let code = (parts.convert)().await;
    let mut wake = match has_image {
        true => node.wake_after(&mut state, Outage::Unknown, code),
        false => node.wake(&mut state, start.wrapping_add(uptime()), code),
    };
    let mut saved = N::second(&state);
    loop {
        let second = N::second(&state);
        let code = match wake.task {
            Task::Run(action) => {
                (parts.act)(Order { second, action, status: node.status(&state) }).await;
                None
            }
            Task::Sleep => {
                // Without a wait the evaluation of a burst goes on, whose result an image would not have.
                if wake.again_in > 0 && second.saturating_sub(saved) >= parts.image_every {
                    saved = second;
                    // A failure of the flash leaves the image before it.
                    let _ = parts.images.store_item(&mut [0; ROOM], &KEY, &Image(node, &state)).await;
                }
                Timer::at(Instant::from_ticks(CLOCK.due(second.wrapping_sub(start), &wake))).await;
                if wake.read { (parts.convert)().await } else { None }
            }
            Task::Burst { samples } => {
                burst(node, &mut state, wake, samples, &mut parts.sensor).await;
                None
            }
        };
        wake = node.wake(&mut state, start.wrapping_add(uptime()), code);
    }
}

/// Takes a burst in the time of `wake`. One that fails waits for the end of this time, at which the node gives it up.
async fn burst<N: Tier, SPI: SpiDevice>(
    node: &N,
    state: &mut N::State,
    wake: Wake,
    samples: u32,
    sensor: &mut Adxl362<SPI>,
) {
    let end = Instant::now() + Duration::from_secs(wake.again_in.into());
    let taken = with_deadline(end, sample(node, state, samples, sensor)).await;
    let _ = sensor.stop_async().await;
    if !matches!(taken, Ok(Ok(()))) {
        node.samples_lost(state);
        Timer::at(end).await;
    }
}

/// Gives the node the samples of the sensor, until it has enough.
async fn sample<N: Tier, SPI: SpiDevice>(
    node: &N,
    state: &mut N::State,
    mut missing: u32,
    sensor: &mut Adxl362<SPI>,
) -> Result<(), Adxl362Error<SPI::Error>> {
    sensor.start_async(&mut Delay).await?;
    let mut samples = [0; BURST];
    loop {
        // In the time of so many samples the FIFO has about as many.
        let time = 1_000_000 * u64::from(missing.min(BURST as u32)) / u64::from(sensor.rate().hertz());
        Timer::after_micros(time).await;
        let (count, mut from) = (sensor.read_async(&mut samples).await?, 0);
        while let Some(left @ [_, ..]) = samples.get(from..count) {
            let Progress::More(more) = node.samples(state, left) else { return Ok(()) };
            (from, missing) = (from + missing.saturating_sub(more) as usize, more);
        }
    }
}

/// Reads the newest image to the state; without one, which it says, the state has no meaning. The future holds no second state.
async fn read_newest<N: Tier, F: NorFlash>(node: &N, state: &mut N::State, images: &mut Images<F>) -> bool {
    let mut buffer = [0; ROOM];
    let image = images.fetch_item::<&[u8]>(&mut buffer, &KEY).await;
    image.is_ok_and(|image| image.is_some_and(|image| read_image(node, image, state).is_ok()))
}

/// What the map writes: the state of a node, and no number, because the map has the newest image.
struct Image<'a, N: Tier>(&'a N, &'a N::State);

impl<N: Tier> Value<'_> for Image<'_, N> {
    fn serialize_into(&self, buffer: &mut [u8]) -> Result<usize, SerializationError> {
        save_image(self.0, self.1, 0, buffer).map_err(|_| SerializationError::BufferTooSmall)
    }

    fn deserialize_from(_: &[u8]) -> Result<(Self, usize), SerializationError> {
        Err(SerializationError::InvalidFormat)
    }
}
