//! A sensor node that listens to the vibration: logs each second what came in, what is stored, and what it does. Now
//! and then it saves all of its states, powers down, and resumes.
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
    use firmware_example::node::{
        Flash, FlashBoard, IMAGE_EVERY, ImageReport, Listening, SECONDS, listening, log, log_image,
    };
    use firmware_example::stop::{Code, stop};

    let Ok(beam) = listening() else { stop(Code::WorkloadFailed) };
    let Ok(mut node) = Listening::new(FlashBoard::default(), beam) else { stop(Code::WorkloadFailed) };
    let mut flash = Flash::new();
    for second in 1..=SECONDS {
        log(&node.second());
        if second % IMAGE_EVERY == 0 {
            // A power-down: nothing remains but the board and the flash.
            let sequence = second / IMAGE_EVERY;
            let Ok(bytes) = node.save(sequence, flash.slot(sequence)) else { stop(Code::WorkloadFailed) };
            log_image(&ImageReport::new(sequence, bytes, flash.slot(sequence)));
            let Ok(beam) = listening() else { stop(Code::WorkloadFailed) };
            let Ok(awake) = Listening::new(node.into_board(), beam) else { stop(Code::WorkloadFailed) };
            node = awake;
            if node.resume(flash.slots()) != Ok(sequence) {
                stop(Code::WorkloadFailed)
            }
        }
    }
    stop(Code::Done)
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", firmware_example::HOW_TO_BUILD);
}
