//! The bench with nothing to measure: the same runtime, logging, measuring and panic handler.
//!
//! `host-bench on-target` subtracts its size from that of `bench`; what is left is the model. It is
//! built and run just as `bench` is, and does nothing but calibrate.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    firmware_example::measure::run(|_| Some(()))
}

firmware_example::main_on_host!();
