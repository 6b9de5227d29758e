//! A sensor node: logs each second what its harvester delivered.
//!
//! Under QEMU, with each logged value compared with the host's, to the bit:
//!
//! ```text
//! cargo run --release -p host-bench -- on-target --node
//! ```

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use firmware_example::node::{FlashTrace, Node};
    use firmware_example::stop::{Code, stop};

    let Ok(mut node) = Node::new(FlashTrace::default()) else { stop(Code::WorkloadFailed) };
    for _ in 0..FlashTrace::SECONDS {
        let Ok(report) = node.second() else { stop(Code::WorkloadFailed) };
        defmt::info!(
            "second {=u32}: {=f32} W in {=u32} steps",
            report.second,
            report.mean_power,
            report.steps
        );
    }
    stop(Code::Done)
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", firmware_example::HOW_TO_BUILD);
}
