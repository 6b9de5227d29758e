//! The program of `node_bare` on registers in memory: logs how deep its stack goes.
//!
//! ```text
//! cargo run --release -p host-bench -- on-target --node
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

use cortex_m0_arithmetic as _;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    firmware_example::node::bare::simulated::measure()
}

firmware_example::main_on_host!();
