//! The log of the node that follows its harvester, beside the host's run of the same node.

use std::time::Duration;

use firmware_example::following::{
    FlashBoard, Following, IMAGE_EVERY, ImageReport, NodeError, Report, SECONDS, SLOT_BYTES, following,
};

use super::build::Binary;
use super::core::Core;
use super::size::Size;
use super::{Error, Firmware, decode, decoder, qemu};

fn fail(error: NodeError) -> Error {
    Error::Host(format!("the node fails: {error:?}"))
}

/// What the host's run of the node brought.
#[derive(Debug, Clone)]
pub struct Native {
    /// A report a second.
    pub reports: Vec<Report>,
    /// The log of the firmware, if it resumes with the same bits after each power-down.
    log: Vec<String>,
}

/// The node on the host, without a power-down.
///
/// # Errors
/// If it cannot go on.
pub fn native() -> Result<Native, Error> {
    let model = following().map_err(fail)?;
    let mut node = Following::new(FlashBoard::default(), model).map_err(fail)?;
    let mut recorded = Native { reports: Vec::new(), log: Vec::new() };
    let mut slot = [0xff; SLOT_BYTES];
    for number in 1..=SECONDS {
        let report = node.second().map_err(fail)?;
        recorded.reports.push(report);
        recorded.log.push(report.to_string());
        if number.is_multiple_of(IMAGE_EVERY) {
            let sequence = number / IMAGE_EVERY;
            let bytes = node.save(sequence, &mut slot).map_err(|_| fail(NodeError::Image))?;
            recorded.log.push(ImageReport::new(sequence, bytes, &slot).to_string());
        }
    }
    Ok(recorded)
}

/// Runs the node on `core` for at most `time_limit`, compares its log with the host's, and gives
/// the reports that both came to.
///
/// # Errors
///
/// When the node cannot be built or run, or its log differs.
pub fn follow(core: Core, time_limit: Duration) -> Result<(Vec<Report>, Size), Error> {
    let firmware = Firmware::build(core, Binary::new("node_following"))?;
    let size = firmware.check()?;
    let log = qemu::run(core, &firmware.path, time_limit)?;
    let found = decoder::messages(&firmware.path, &log).map_err(|error| Error::on(core, error))?;
    let expected = native()?;
    decode::same(&found, &expected.log).map_err(|what| Error::on(core, what))?;
    Ok((expected.reports, size))
}
