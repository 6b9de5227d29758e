//! What the firmware binaries have in common: workloads, measuring, logging, and ending.
//!
//! Only the workloads, the node and the boards exist on the host too, which runs them to compare the bits. All
//! else is for bare metal, so that `cargo build --workspace` needs no microcontroller.
//!
//! | module | subject |
//! | --- | --- |
//! | `measure` | one workload measured: what it cost by SysTick, how deep the stack went, and its states, in the log |
//! | `workload` | the variants of the bench by name, and their workloads: scenes whole, with parts left out, at several settings |
//! | `node` | a node of `model_core::node` on a simulated plant: a day with losses of power |
//! | `board` | boards of `model_core::node` over `embedded-hal`: an accelerometer's driver, slots in flash |
//! | `stop` | defmt frames over semihosting; panics and faults end the run with a code |

#![no_std]

pub mod board;
#[cfg(target_os = "none")]
pub mod measure;
pub mod node;
#[cfg(target_os = "none")]
pub mod stop;
pub mod workload;

/// What a binary says when it was built for the host.
pub const HOW_TO_BUILD: &str = "\
This is firmware, and this was built for the host. To build it for the default board:
    rustup target add thumbv7em-none-eabihf
    cargo build --release -p firmware-example --target thumbv7em-none-eabihf
To build and run it on every core under QEMU:
    cargo run --release -p host-bench -- on-target";

/// Puts `arithmetic/armv6m.s` in the place of the compiler's functions in a binary of this package for ARMv6-M; nothing on other
/// cores.
///
/// Arithmetic of `f32` for a core without floating point and without a long multiplication: Cortex-M0 and M0+.
///
/// The compiler's functions are written once for all cores. On ARMv6-M they take 115 instructions for a product, since they
/// multiply numbers of 64 bits, 95 to 130 for a sum, and 23 for a comparison. Those of `arithmetic/armv6m.s` take 53, 60,
/// and 15 to 24, and have the same bits, except of what is not a number.
///
/// A firmware of your own needs the file, and one line in its `main.rs`:
///
/// ```text
/// core::arch::global_asm!(include_str!("armv6m.s"));
/// ```
#[macro_export]
macro_rules! cortex_m0_arithmetic {
    () => {
        #[cfg(armv6m)]
        core::arch::global_asm!(include_str!(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/src/arithmetic/armv6m.s"
        )));
    };
}

#[cfg(test)]
mod tests;
