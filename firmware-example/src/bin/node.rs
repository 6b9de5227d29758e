//! A node that knows its income, on a simulated plant: logs a day with ten losses of power.
//!
//! Under QEMU, with each logged value compared with the host's, to the bit:
//!
//! ```text
//! cargo run --release -p host-bench -- on-target --node
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

use cortex_m0_arithmetic as _;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    firmware_example::node::target::run()
}

firmware_example::main_on_host!();
