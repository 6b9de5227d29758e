//! The on-target bench: what a model costs on a microcontroller, and the bits it comes to there.
//!
//! The environment variable `HARVESTER_VARIANT` chooses at build what is measured: a name of
//! `firmware_example::workload::VARIANTS`, `contact_separation::bench` if it is not set.
//!
//! Under QEMU, on every core, with the log decoded, the bits checked and a table at the end:
//!
//! ```text
//! cargo run --release -p host-bench -- on-target
//! ```
//!
//! On the board itself (an STM32F405; `HARVESTER_BOARD` chooses another, see the build script),
//! through a debug probe that serves semihosting; the ticks are then cycles of the core:
//!
//! ```text
//! HARVESTER_VARIANT=sliding::bench cargo build --profile firmware -p firmware-example --target thumbv7em-none-eabihf
//! openocd -f interface/stlink.cfg -f target/stm32f4x.cfg \
//!     -c "program target/thumbv7em-none-eabihf/firmware/bench" \
//!     -c "arm semihosting enable" -c "reset run" \
//!   | defmt-print -e target/thumbv7em-none-eabihf/firmware/bench
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

use cortex_m0_arithmetic as _;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use firmware_example::workload::{VARIANTS, Variant, named};

    const VARIANT: Variant = match option_env!("HARVESTER_VARIANT") {
        Some(name) => named(name),
        None => VARIANTS[0],
    };
    firmware_example::measure::run(VARIANT.workloads)
}

firmware_example::main_on_host!();
