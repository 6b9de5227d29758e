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

/// The `main` of a binary for bare metal where it was built for the host: it says how to build it.
#[macro_export]
macro_rules! main_on_host {
    () => {
        #[cfg(not(target_os = "none"))]
        fn main() {
            println!(
                "\
This is firmware, and this was built for the host. To build it for the default board:
    rustup target add thumbv7em-none-eabihf
    cargo build --release -p firmware-example --target thumbv7em-none-eabihf
To build and run it on every core under QEMU:
    cargo run --release -p host-bench -- on-target"
            );
        }
    };
}

#[cfg(test)]
mod tests;
