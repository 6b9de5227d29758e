//! The sensor node's log, beside the host's run of the same node.

use std::time::Duration;

use firmware_example::node::{FlashTrace, Node, Report};

use super::build::Binary;
use super::core::Core;
use super::size::Size;
use super::{Error, Firmware, decode, qemu};

/// Runs the node on `core` for at most `time_limit`, compares its log with the host's, and gives
/// the reports that both came to.
///
/// # Errors
///
/// When the node cannot be built or run, or its log differs.
pub fn follow(core: Core, time_limit: Duration) -> Result<(Vec<Report>, Size), Error> {
    let firmware = Firmware::build(core, Binary::new("node"))?;
    let size = firmware.check()?;
    let log = qemu::run(core, &firmware.path, time_limit)?;
    let found = decode::messages(&firmware.bytes, &log).map_err(|source| Error::Log { core, source })?;
    let expected = native()?;
    for second in 0..found.len().max(expected.len()) {
        let (found, expected) = (found.get(second), expected.get(second));
        // A number in the log is written with as many digits as tell it from its neighbours.
        if found.cloned() != expected.map(line) {
            let what = format!("node: logs {found:?}, on the host {:?}", expected.map(line));
            return Err(Error::Other { core, what });
        }
    }
    Ok((expected, size))
}

/// The node on the host.
fn native() -> Result<Vec<Report>, Error> {
    let fail = |error| Error::Host(format!("the node fails: {error:?}"));
    let mut node = Node::new(FlashTrace::default()).map_err(fail)?;
    (0..FlashTrace::SECONDS).map(|_| node.second().map_err(fail)).collect()
}

/// The line that the node logs.
fn line(report: &Report) -> String {
    format!("second {}: {} W in {} steps", report.second, report.mean_power, report.steps)
}
