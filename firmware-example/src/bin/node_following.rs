//! A sensor node that follows its harvester: logs each second what came in, what is stored, and what it does. Now and
//! then it saves all of its states, powers down, and resumes.
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
    use firmware_example::following::{
        Flash, FlashBoard, Following, IMAGE_EVERY, ImageReport, SECONDS, following, log, log_image,
    };
    use firmware_example::stop::{Code, stop};

    let Ok(model) = following() else { stop(Code::WorkloadFailed) };
    let Ok(mut node) = Following::new(FlashBoard::default(), model) else { stop(Code::WorkloadFailed) };
    let mut flash = Flash::new();
    // In real flash an image outlasts a reset, and the sequence numbers continue. Here the flash is RAM, erased.
    let mut newest = node.resume(flash.slots()).ok();
    for second in 1..=SECONDS {
        let Ok(report) = node.second() else { stop(Code::WorkloadFailed) };
        log(&report);
        if second % IMAGE_EVERY == 0 {
            // A power-down: nothing remains but the board and the flash.
            let (sequence, slot) = flash.next(newest);
            let Ok(bytes) = node.save(sequence, slot) else { stop(Code::WorkloadFailed) };
            log_image(&ImageReport::new(sequence, bytes, slot));
            let Ok(model) = following() else { stop(Code::WorkloadFailed) };
            let Ok(awake) = Following::new(node.into_board(), model) else { stop(Code::WorkloadFailed) };
            node = awake;
            newest = node.resume(flash.slots()).ok();
            if newest.is_none_or(|image| image.sequence != sequence) {
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
