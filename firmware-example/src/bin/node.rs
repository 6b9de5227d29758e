//! A sensor node that follows its harvester: logs each second what came in, what is stored, and what it does.
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
    use firmware_example::node::{FlashBoard, Following, SECONDS, following, log};
    use firmware_example::stop::{Code, stop};

    let Ok(model) = following() else { stop(Code::WorkloadFailed) };
    let Ok(mut node) = Following::new(FlashBoard::default(), model) else { stop(Code::WorkloadFailed) };
    for _ in 0..SECONDS {
        let Ok(report) = node.second() else { stop(Code::WorkloadFailed) };
        log(&report);
    }
    stop(Code::Done)
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", firmware_example::HOW_TO_BUILD);
}
