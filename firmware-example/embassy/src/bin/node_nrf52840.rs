//! The node on an nRF52840 with an ADXL362, by the crate `embassy-nrf`. It is built in CI and was not run on hardware.
//!
//! ```text
//! cargo build --profile node -p firmware-embassy --no-default-features --features nrf52840 \
//!     --bin node_nrf52840 --target thumbv7em-none-eabihf
//! ```
//!
//! Chip select, MISO, MOSI and clock of the ADXL362 are on P0.22 to P0.25. P0.13 and P0.14 are low during a measurement and a
//! transmission: in their place come a sensor and the radio. The storage is the supply. The clock is the RTC from the crystal. The
//! energies of the node are those with an nRF52832: state your own. Panics and faults end by semihosting; a product would reset.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board {
    use core::future::poll_fn;
    use core::pin::pin;

    use embassy_embedded_hal::adapter::BlockingAsync;
    use embassy_executor::Spawner;
    use embassy_nrf::config::{Config, LfclkSource};
    use embassy_nrf::gpio::{AnyPin, Level, Output, OutputDrive};
    use embassy_nrf::interrupt::{self, InterruptExt};
    use embassy_nrf::saadc::{self, ChannelConfig, Saadc, VddInput};
    use embassy_nrf::spim::{self, Spim};
    use embassy_nrf::{Peri, bind_interrupts, nvmc::Nvmc, peripherals};
    use embassy_time::{Delay, Timer};
    use embedded_hal_bus::spi::ExclusiveDevice;
    use firmware_embassy::{Order, Parts, keep_books};
    use firmware_example::board::adxl362::{Adxl362, Axis};
    use firmware_example::board::example::{MEASURE, NODE, RANGE, RATE};
    use sequential_storage::cache::Cache;
    use sequential_storage::map::{MapConfig, MapStorage};

    /// The last four pages of the flash, for the images; the linker script ends before them. Each bears 10 000 erasures.
    const PAGES: core::ops::Range<u32> = 0xF_C000..0x10_0000;
    const IMAGE_EVERY: u32 = 3600;

    bind_interrupts!(struct Irqs {
        SPIM3 => spim::InterruptHandler<peripherals::SPI3>;
        SAADC => saadc::InterruptHandler;
    });

    #[embassy_executor::main]
    async fn main(_spawner: Spawner) {
        let mut config = Config::default();
        config.lfclk_source = LfclkSource::ExternalXtal;
        let chip = embassy_nrf::init(config);
        let mut config = spim::Config::default();
        config.frequency = spim::Frequency::M4;
        let spi = Spim::new(chip.SPI3, Irqs, chip.P0_25, chip.P0_23, chip.P0_24, config);
        let select = Output::new(chip.P0_22, Level::High, OutputDrive::Standard);
        // The error is that of the pin, which cannot fail.
        let Ok(spi) = ExclusiveDevice::new(spi, select, Delay);
        // 12 bits; 0.6 V at a gain of a sixth: 3.6 V of full scale.
        let channel = ChannelConfig::single_ended(VddInput);
        let mut converter = Saadc::new(chip.SAADC, Irqs, saadc::Config::default(), [channel]);
        let light = |pin: Peri<'static, AnyPin>| Output::new(pin, Level::High, OutputDrive::Standard);
        let mut lights = [light(chip.P0_13.into()), light(chip.P0_14.into())];
        let flash = BlockingAsync::new(Nvmc::new(chip.NVMC));
        let parts = Parts {
            sensor: Adxl362::new(spi, Axis::Z, RANGE, RATE),
            convert: async || {
                let mut code = [0];
                converter.sample(&mut code).await;
                u32::try_from(code[0]).ok()
            },
            act: async |order: Order| {
                let Some(light) = lights.get_mut(order.action) else { return };
                light.set_low();
                Timer::after_millis(if order.action == MEASURE { 100 } else { 1 }).await;
                light.set_high();
            },
            images: MapStorage::new(flash, const { MapConfig::new(PAGES) }, Cache::new_uncached()),
            image_every: IMAGE_EVERY,
        };
        let mut node = pin!(keep_books(&NODE, parts));
        poll_fn(|context| {
            let poll = node.as_mut().poll(context);
            clear_float_exceptions();
            poll
        })
        .await
    }

    /// Clears the flags of the floating-point unit, and its interrupt. Anomaly 87 of the nRF52: a rounding leaves the interrupt
    /// pending, and the processor then does not sleep.
    fn clear_float_exceptions() {
        // SAFETY: the instructions clear exception flags, which no code reads.
        unsafe {
            core::arch::asm!("vmrs {0}, fpscr", "bic {0}, {0}, #0x9f", "vmsr fpscr, {0}", out(reg) _);
        }
        interrupt::FPU.unpend();
    }
}

firmware_example::main_on_host!();
