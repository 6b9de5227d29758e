//! The node on the plant of `firmware-example` in three lives, from an image after each loss of power: under QEMU by SysTick, on the
//! host by a clock that is set. Both print the same lines.

#![cfg_attr(target_os = "none", no_std, no_main)]

use core::cell::{RefCell, RefMut};

use embassy_time::{Duration, Instant, Timer, with_deadline};
use embedded_hal_async::spi::{self, Operation, SpiDevice};
use embedded_storage_async::nor_flash::{self, NorFlash, NorFlashErrorKind, ReadNorFlash};
use firmware_embassy::{Order, Parts, keep_books};
use firmware_example::board::adxl362::{Adxl362, Axis, Range, Rate};
use firmware_example::node::parts::{Part, RATE};
use firmware_example::node::plant::{Draws, Plant};
use sequential_storage::cache::Cache;
use sequential_storage::map::{MapConfig, MapStorage};

/// Ends of the lives in s, seconds from one image to the next, and milliseconds of an action.
const ENDS: [u64; 3] = [25_000, 50_000, 75_000];
const IMAGE_EVERY: u32 = 3600;
const ACTION: u64 = 100;
/// Samples that the FIFO of the accelerometer holds, and bytes of a page of the flash.
const FIFO: u32 = 170;
const PAGE: usize = 1024;
/// Time from one interrupt of the clock to the next.
const TICK: Duration = Duration::from_millis(250);

/// The plant, with its accelerometer.
struct World {
    plant: Plant,
    draws: Draws,
    /// When it was started, how often, samples since, and those in its FIFO.
    started: Instant,
    bursts: u32,
    sampled: u32,
    waiting: u32,
}

impl World {
    fn measure(&mut self, is_on: bool) {
        (self.started, self.sampled, self.waiting) = (Instant::now(), 0, 0);
        self.bursts += u32::from(is_on);
        if is_on { self.plant.start_sensor(&self.draws) } else { self.plant.stop_sensor() }
    }

    /// Status and entries of the FIFO.
    fn fill(&mut self) -> [u8; 3] {
        let more = (self.started.elapsed().as_millis() * u64::from(RATE) / 1000) as u32 - self.sampled;
        self.plant.fill(more);
        self.sampled += more;
        self.waiting += more;
        let [low, high] = (3 * self.waiting.min(FIFO) as u16).to_le_bytes();
        [u8::from(self.waiting > FIFO) << 3, low, high]
    }

    /// Reads entries: three axes in turn.
    fn empty(&mut self, entries: &mut [u8]) {
        for entry in entries.chunks_exact_mut(6) {
            let mut sample = [0];
            self.waiting -= self.plant.take(&mut sample) as u32;
            let axes = [0, 1 << 14, 2 << 14 | sample[0] as u16 & 0x3FFF].map(u16::to_le_bytes);
            entry.copy_from_slice(axes.as_flattened());
        }
    }
}

/// The world at the present time.
fn now(world: &RefCell<World>) -> RefMut<'_, World> {
    let mut world = world.borrow_mut();
    let World { plant, draws, .. } = &mut *world;
    plant.advance(draws, Instant::now().as_secs() as u32);
    world
}

struct Bus<'a>(&'a RefCell<World>);

impl spi::ErrorType for Bus<'_> {
    type Error = spi::ErrorKind;
}

impl SpiDevice for Bus<'_> {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), spi::ErrorKind> {
        let mut world = now(self.0);
        match operations {
            [Operation::Write([0x0A, 0x2D, mode])] => world.measure(*mode != 0),
            [Operation::Write([0x0A, ..])] => {}
            [Operation::Write([0x0B, 0x00]), Operation::Read(answer)] => {
                answer.copy_from_slice(&[0xAD, 0x1D, 0xF2]);
            }
            [Operation::Write([0x0B, 0x0B]), Operation::Read(answer)] => {
                answer.copy_from_slice(&world.fill())
            }
            [Operation::Write([0x0D]), Operation::Read(answer)] => world.empty(answer),
            _ => return Err(spi::ErrorKind::Other),
        }
        Ok(())
    }
}

struct Flash([u8; 2 * PAGE]);

impl Flash {
    fn bytes(&mut self, from: u32, length: usize) -> Result<&mut [u8], NorFlashErrorKind> {
        let bytes = self.0.get_mut(from as usize..).and_then(|bytes| bytes.get_mut(..length));
        bytes.ok_or(NorFlashErrorKind::OutOfBounds)
    }
}

impl nor_flash::ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        self.bytes(offset, bytes.len()).map(|flash| bytes.copy_from_slice(flash))
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = PAGE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.bytes(from, (to - from) as usize).map(|flash| flash.fill(0xFF))
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let flash = self.bytes(offset, bytes.len())?;
        // A write clears bits.
        flash.iter_mut().zip(bytes).for_each(|(to, from)| *to &= *from);
        Ok(())
    }
}

/// An order with the truth, and the bursts so far.
type Entry = (Order, Plant, u32);

/// The node in all of its lives.
async fn live(log: &mut dyn FnMut(Entry)) {
    let draws = Draws::new(Part::Nrf52832.node());
    let (plant, started) = (Plant::at_midnight(), Instant::now());
    let world = &RefCell::new(World { plant, draws, started, bursts: 0, sampled: 0, waiting: 0 });
    let mut flash = Flash([0xFF; 2 * PAGE]);
    for end in ENDS {
        let config = const { MapConfig::new(0..2 * PAGE as u32) };
        let parts = Parts {
            sensor: Adxl362::new(Bus(world), Axis::Z, Range::G2, Rate::Hz100),
            convert: async || {
                let World { plant, draws, .. } = &mut *now(world);
                plant.know(draws, 1);
                Some(plant.read())
            },
            act: async |order: Order| {
                let World { plant, bursts, .. } = *now(world);
                log((order, plant, bursts));
                Timer::after_millis(ACTION).await;
                let World { plant, draws, .. } = &mut *now(world);
                plant.run(draws, order.action);
            },
            images: MapStorage::new(&mut flash, config, Cache::new_uncached()),
            image_every: IMAGE_EVERY,
        };
        let _ = with_deadline(Instant::from_secs(end), keep_books(Part::Nrf52832.node(), parts)).await;
    }
}

#[cfg(target_os = "none")]
mod target {
    use core::ptr::null_mut;
    use core::sync::atomic::{AtomicBool, Ordering::SeqCst};

    use cortex_m::peripheral::syst::SystClkSource;
    use embassy_executor::raw::Executor;
    use embassy_time::MockDriver;
    use firmware_example::measure;
    use firmware_example::stop::{Code, stop};
    use static_cell::StaticCell;

    use super::TICK;

    /// The clock of SysTick in Hz: an eighth of that of the core.
    const CLOCK: u64 = 21_000_000;

    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    static IS_PENDING: AtomicBool = AtomicBool::new(false);

    #[unsafe(export_name = "__pender")]
    fn pender(_: *mut ()) {
        IS_PENDING.store(true, SeqCst);
    }

    #[cortex_m_rt::exception]
    fn SysTick() {
        MockDriver::get().advance(TICK);
    }

    #[embassy_executor::task]
    async fn node() {
        super::live(&mut |entry| semihosting::println!("{entry:?}")).await;
        semihosting::println!("stack {} bytes", measure::deepest_stack());
        stop(Code::Done)
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let Some(mut peripherals) = cortex_m::Peripherals::take() else { stop(Code::Faulted) };
        peripherals.SYST.set_clock_source(SystClkSource::External);
        peripherals.SYST.set_reload((CLOCK * TICK.as_millis() / 1000 - 1) as u32);
        peripherals.SYST.enable_interrupt();
        peripherals.SYST.enable_counter();
        let executor: &'static Executor = EXECUTOR.init(Executor::new(null_mut()));
        let Ok(node) = node() else { stop(Code::Faulted) };
        executor.spawner().spawn(node);
        measure::paint_stack();
        loop {
            IS_PENDING.store(false, SeqCst);
            // SAFETY: no task calls this function.
            unsafe { executor.poll() };
            cortex_m::interrupt::free(|_| {
                // QEMU lets the time pass while the core waits for an interrupt, but not while it waits for an event.
                if !IS_PENDING.load(SeqCst) {
                    cortex_m::asm::wfi();
                }
            });
        }
    }
}

/// Runs the node on the host: time passes when it waits.
#[cfg(not(target_os = "none"))]
fn run(log: &mut dyn FnMut(Entry)) {
    let (mut node, waker) = (core::pin::pin!(live(log)), core::task::Waker::noop());
    while node.as_mut().poll(&mut core::task::Context::from_waker(waker)).is_pending() {
        embassy_time::MockDriver::get().advance(TICK);
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    run(&mut |entry| println!("{entry:?}"));
}

#[cfg(test)]
mod tests {
    use super::{ENDS, IMAGE_EVERY};

    #[test]
    fn through_losses_of_power_the_node_knows_its_storage_and_its_income() {
        let mut entries = Vec::new();
        super::run(&mut |entry| entries.push(entry));
        let (mut all, mut inside) = (0, 0);
        for pair in entries.windows(2) {
            let [(_, before, _), (order, plant, _)] = pair else { panic!("two of them") };
            let off = 1e-12 * plant.stored as f64 - f64::from(order.status.energy);
            assert!(off.abs() <= order.status.energy_bound.into(), "{off} {order:?}");
            // Without an image the clock of a life would begin at 0.
            let missing = plant.second - order.second;
            assert!(missing < (ENDS.len() as u32 - 1) * (IMAGE_EVERY + 600), "{missing} {order:?}");
            let seconds = plant.second - before.second;
            if seconds >= 60 {
                let power = 1e-12 * (plant.income - before.income) as f64 / f64::from(seconds);
                let off = power - f64::from(order.status.power);
                inside += usize::from(off.abs() <= order.status.power_bound.into());
                all += 1;
            }
        }
        // Some of these times are not those between the readings by which the node knows the power.
        assert!(all > 100 && 20 * inside > 19 * all, "{inside} of {all}");
        assert!(entries.last().is_some_and(|(_, _, bursts)| *bursts > 10));
    }
}
