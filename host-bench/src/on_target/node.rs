//! The sensor node's log, beside the host's run of the same node.

use std::time::Duration;

use firmware_example::node::{
    FlashBoard, Following, IMAGE_EVERY, ImageReport, Listening, NodeError, Report, SECONDS, SLOT_BYTES,
    following, listening,
};
use model_core::snapshot::SnapshotError;

use super::build::Binary;
use super::core::Core;
use super::size::Size;
use super::{Error, Firmware, decode, qemu};

/// Which node a core can afford.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// It steps the harvester's model along the samples.
    Following,
    /// It asks a closed form about the strongest sine.
    Listening,
}

impl Kind {
    /// The one for `core`: without floating point in hardware a trajectory costs too much.
    #[must_use]
    pub fn of(core: Core) -> Self {
        match core {
            Core::M0 | Core::M3 => Self::Listening,
            _ => Self::Following,
        }
    }

    fn binary(self) -> Binary<'static> {
        Binary::new(match self {
            Self::Following => "node",
            Self::Listening => "node_listening",
        })
    }

    /// The node on the host for `seconds`, without a power-down.
    ///
    /// # Errors
    /// If it cannot go on.
    pub fn native(self, seconds: u32) -> Result<Native, Error> {
        match self {
            Self::Following => {
                let model = following().map_err(fail)?;
                let mut node = Following::new(FlashBoard::default(), model).map_err(fail)?;
                Native::record(seconds, &mut node, Following::second, Following::save)
            }
            Self::Listening => {
                let model = listening().map_err(fail)?;
                let mut node = Listening::new(FlashBoard::default(), model).map_err(fail)?;
                Native::record(seconds, &mut node, |node| Ok(node.second()), Listening::save)
            }
        }
    }
}

fn fail(error: NodeError) -> Error {
    Error::Host(format!("the node fails: {error:?}"))
}

/// What the host's run of a node brought.
#[derive(Debug, Clone)]
pub struct Native {
    /// A report a second.
    pub reports: Vec<Report>,
    /// The log of the firmware, if it resumes with the same bits after each power-down.
    log: Vec<String>,
}

impl Native {
    /// Runs a node by its functions for a second and for an image.
    fn record<N>(
        seconds: u32,
        node: &mut N,
        second: impl Fn(&mut N) -> Result<Report, NodeError>,
        save: impl Fn(&N, u32, &mut [u8]) -> Result<usize, SnapshotError>,
    ) -> Result<Self, Error> {
        let mut recorded = Self { reports: Vec::new(), log: Vec::new() };
        let mut slot = [0xff; SLOT_BYTES];
        for number in 1..=seconds {
            let report = second(node).map_err(fail)?;
            recorded.reports.push(report);
            recorded.log.push(report.to_string());
            if number.is_multiple_of(IMAGE_EVERY) {
                let sequence = number / IMAGE_EVERY;
                let bytes = save(node, sequence, &mut slot).map_err(|_| fail(NodeError::Image))?;
                recorded.log.push(ImageReport::new(sequence, bytes, &slot).to_string());
            }
        }
        Ok(recorded)
    }
}

/// Runs the node on `core` for at most `time_limit`, compares its log with the host's, and gives
/// the reports that both came to.
///
/// # Errors
///
/// When the node cannot be built or run, or its log differs.
pub fn follow(core: Core, time_limit: Duration) -> Result<(Vec<Report>, Size), Error> {
    let kind = Kind::of(core);
    let firmware = Firmware::build(core, kind.binary())?;
    let size = firmware.check()?;
    let log = qemu::run(core, &firmware.path, time_limit)?;
    let found = decode::messages(&firmware.bytes, &log).map_err(|error| Error::on(core, error))?;
    let expected = kind.native(SECONDS)?;
    for line in 0..found.len().max(expected.log.len()) {
        let (found, expected) = (found.get(line), expected.log.get(line));
        // A number in the log is written with as many digits as tell it from its neighbours.
        if found != expected {
            return Err(Error::on(core, format!("node: logs {found:?}, on the host {expected:?}")));
        }
    }
    Ok((expected.reports, size))
}
