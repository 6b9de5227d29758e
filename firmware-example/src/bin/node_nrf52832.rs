//! The node of the library on an nRF52832 with an ADXL362, by the crate `nrf52832-hal`. It is built in CI and was not run
//! on hardware.
//!
//! ```text
//! HARVESTER_BOARD=nrf52832 cargo build --profile firmware -p firmware-example --features nrf52832 \
//!     --bin node_nrf52832 --target thumbv7em-none-eabihf
//! ```
//!
//! | pin | use |
//! | --- | --- |
//! | P0.22 to P0.25 | chip select, MISO, MOSI and clock of the ADXL362 |
//! | P0.17, P0.18 | high during a measurement, a transmission: in their place come a sensor and the radio |
//!
//! Panics and faults end by semihosting as in the other binaries, which needs a debugger; a product would reset.
//! The ADXL362 has its supply always, and is in standby between bursts. The storage supplies the parts directly, so that its voltage is that of the supply. The clock is the RTC from the
//! crystal; the processor sleeps in System ON while it waits.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board {
    use core::cell::RefCell;

    use cortex_m::peripheral::NVIC;
    use firmware_example::board::adxl362::{Adxl362, Axis};
    use firmware_example::board::example::{ExampleNode, MEASURE, NODE, RANGE, RATE, Runner};
    use firmware_example::board::{HalBoard, Slots};
    use firmware_example::stop::{Code, stop};
    use model_core::node::{Board, Outage, Tier};
    use model_core::snapshot::image_size;
    use nrf52832_hal::gpio::{Level, p0};
    use nrf52832_hal::nvmc::Nvmc;
    use nrf52832_hal::pac::{Interrupt, Peripherals, RTC0, interrupt};
    use nrf52832_hal::rtc::{Rtc, RtcCompareReg, RtcInterrupt};
    use nrf52832_hal::saadc::{
        Gain, InternalVdd, Oversample, Reference, Resistor, Resolution, Saadc, SaadcConfig, Time,
    };
    use nrf52832_hal::spim::{self, Frequency, Spim};
    use nrf52832_hal::{Clocks, clocks::LfOscConfiguration};

    /// Ticks of the RTC in a second: 32 768 Hz by 32.
    const TICKS: u32 = 1024;
    /// Least number of ticks to a compare that is certain to happen.
    const LEAST: u32 = 3;
    /// Values of its counter.
    const WRAP: u32 = 1 << 24;
    /// The last two pages of the flash, for the images of the node; the linker script ends before them.
    const SLOTS: usize = 0x7_E000;
    /// Bytes of a page.
    const PAGE: usize = 4096;
    /// Seconds from one image to the next: the flash bears 10 000 erasures of a page.
    const IMAGE_EVERY: u32 = 6 * 3600;

    /// 0.6 V at a gain of a sixth: 3.6 V of full scale.
    const CONVERTER: SaadcConfig = SaadcConfig {
        resolution: Resolution::_12BIT,
        oversample: Oversample::BYPASS,
        reference: Reference::INTERNAL,
        gain: Gain::GAIN1_6,
        resistor: Resistor::BYPASS,
        time: Time::_20US,
    };

    /// The RTC: the time since the start, and sleep.
    struct Clock {
        rtc: Rtc<RTC0>,
        /// The counter at the last look.
        last: u32,
        /// Ticks until then.
        ticks: u64,
    }

    impl Clock {
        /// Sleeps for so many ticks, and gives the second of the time.
        fn sleep(&mut self, ticks: u64) -> u32 {
            let ticks = ticks.clamp(u64::from(LEAST), u64::from(WRAP / 2));
            let end = self.look() + ticks;
            let compare = (self.last + ticks as u32) % WRAP;
            self.rtc.reset_event(RtcInterrupt::Compare0);
            NVIC::unpend(Interrupt::RTC0);
            // The value is below 2²⁴.
            let _ = self.rtc.set_compare(RtcCompareReg::Compare0, compare);
            // SAFETY: the handler of this interrupt touches nothing that is used here.
            unsafe { NVIC::unmask(Interrupt::RTC0) };
            while self.look() < end {
                clear_float_exceptions();
                // The interrupt sets the event if it comes before this instruction.
                cortex_m::asm::wfe();
            }
            NVIC::mask(Interrupt::RTC0);
            (self.ticks / u64::from(TICKS)) as u32
        }

        /// Ticks since the start.
        fn look(&mut self) -> u64 {
            let counter = self.rtc.get_counter();
            self.ticks += u64::from(counter.wrapping_sub(self.last) % WRAP);
            self.last = counter;
            self.ticks
        }
    }

    /// Clears the flags of the floating-point unit, and its interrupt. Anomaly 87 of the nRF52832: a rounding leaves the interrupt
    /// pending, and the processor then sleeps at milliamperes.
    fn clear_float_exceptions() {
        // SAFETY: the instructions clear exception flags, which no code reads.
        unsafe {
            core::arch::asm!("vmrs {0}, fpscr", "bic {0}, {0}, #0x9f", "vmsr fpscr, {0}", out(reg) _);
        }
        NVIC::unpend(Interrupt::FPU);
    }

    /// Waits of the accelerometer's start, asleep.
    struct Wait<'a>(&'a RefCell<Clock>);

    impl embedded_hal::delay::DelayNs for Wait<'_> {
        fn delay_ns(&mut self, ns: u32) {
            let ticks = (u64::from(ns) * u64::from(TICKS)).div_ceil(1_000_000_000);
            // One more, because the present one has begun.
            self.0.borrow_mut().sleep(ticks + 1);
        }
    }

    /// Ends the sleep.
    #[interrupt]
    fn RTC0() {
        NVIC::mask(Interrupt::RTC0);
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let Some(parts) = Peripherals::take() else { stop(Code::WorkloadFailed) };
        run(parts)
    }

    fn run(parts: Peripherals) -> ! {
        let clocks = Clocks::new(parts.CLOCK).set_lfclk_src_external(LfOscConfiguration::NoExternalNoBypass);
        clocks.start_lfclk();
        let Ok(mut rtc) = Rtc::new(parts.RTC0, 32_768 / TICKS - 1) else { stop(Code::WorkloadFailed) };
        rtc.enable_interrupt(RtcInterrupt::Compare0, None);
        rtc.enable_counter();
        let clock = RefCell::new(Clock { rtc, last: 0, ticks: 0 });

        let pins = p0::Parts::new(parts.P0);
        let spi = Spim::new(
            parts.SPIM0,
            spim::Pins {
                sck: Some(pins.p0_25.into_push_pull_output(Level::Low).degrade()),
                mosi: Some(pins.p0_24.into_push_pull_output(Level::Low).degrade()),
                miso: Some(pins.p0_23.into_floating_input().degrade()),
            },
            Frequency::M4,
            spim::MODE_0,
            0,
        );
        let select = pins.p0_22.into_push_pull_output(Level::High);
        // The error is that of the pin, which cannot fail.
        let Ok(spi) = embedded_hal_bus::spi::ExclusiveDevice::new_no_delay(spi, select);
        let mut converter = Saadc::new(parts.SAADC, CONVERTER);
        let mut lights = [
            pins.p0_17.into_push_pull_output(Level::Low).degrade(),
            pins.p0_18.into_push_pull_output(Level::Low).degrade(),
        ];
        // SAFETY: the linker script ends before these two pages, and nothing else refers to them.
        let pages = unsafe { core::slice::from_raw_parts_mut(SLOTS as *mut u8, 2 * PAGE) };
        let Some(slots) = Slots::new(Nvmc::new(parts.NVMC, pages), PAGE) else { stop(Code::WorkloadFailed) };

        let board = HalBoard {
            sensor: Adxl362::new(spi, Axis::Z, RANGE, RATE),
            delay: Wait(&clock),
            sleep: |milliseconds: u32| {
                let ticks = u64::from(milliseconds) * u64::from(TICKS) / 1000;
                clock.borrow_mut().sleep(ticks)
            },
            convert: || {
                let code = converter.read_channel(&mut InternalVdd).ok()?;
                u32::try_from(code).ok()
            },
            act: |action: usize| {
                use embedded_hal::digital::OutputPin;
                let Some(light) = lights.get_mut(action) else { return };
                let milliseconds = if action == MEASURE { 100 } else { 1 };
                let _ = light.set_high();
                clock.borrow_mut().sleep(milliseconds * u64::from(TICKS) / 1000);
                let _ = light.set_low();
            },
            slots,
        };
        live(board, &clock)
    }

    /// Runs the node on its board, from the image if there is one.
    fn live(mut board: impl Board, clock: &RefCell<Clock>) -> ! {
        // A reset of the processor may have come in a burst.
        board.stop_sensor();
        let mut runner: Runner<_> = Runner::new(board, &NODE, 0);
        let mut image = [0; image_size::<ExampleNode>()];
        // Without an image the node begins anew. Without a clock of its own supply no one knows how long the power-down was.
        if runner.resume(&mut image, Outage::Unknown).is_ok() {
            clock.borrow_mut().ticks = u64::from(ExampleNode::second(runner.state())) * u64::from(TICKS);
        }
        let mut saved = ExampleNode::second(runner.state());
        loop {
            runner.step();
            if runner.is_idle() && ExampleNode::second(runner.state()).saturating_sub(saved) >= IMAGE_EVERY {
                saved = ExampleNode::second(runner.state());
                // A failure of the flash leaves the image before it; the next attempt is in six hours.
                let _ = runner.save(&mut image);
            }
        }
    }
}

firmware_example::main_on_host!();
