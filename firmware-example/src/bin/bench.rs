//! The on-target bench: what a model costs on a microcontroller, and the bits it comes to there.
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
//! cargo build --profile firmware -p firmware-example --target thumbv7em-none-eabihf
//! openocd -f interface/stlink.cfg -f target/stm32f4x.cfg \
//!     -c "program target/thumbv7em-none-eabihf/firmware/bench" \
//!     -c "arm semihosting enable" -c "reset run" \
//!   | defmt-print -e target/thumbv7em-none-eabihf/firmware/bench
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

firmware_example::measuring_main!(firmware_example::workload::contact_separation::scenes::bench);
