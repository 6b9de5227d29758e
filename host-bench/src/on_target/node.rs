//! The sensor node's log, beside the host's run of the same node.

use std::time::Duration;

use firmware_example::node::{
    FlashBoard, Following, Listening, NodeError, Report, SECONDS, following, listening,
};

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

    fn binary(self) -> Binary {
        Binary::new(match self {
            Self::Following => "node",
            Self::Listening => "node_listening",
        })
    }

    /// The node on the host for `seconds`: its reports, and what its account of the store leaves unexplained
    /// at the end, in joules.
    ///
    /// # Errors
    /// If it cannot go on.
    pub fn native(self, seconds: u32) -> Result<(Vec<Report>, f32), Error> {
        let fail = |error: NodeError| Error::Host(format!("the node fails: {error:?}"));
        match self {
            Self::Following => {
                let model = following().map_err(fail)?;
                let mut node = Following::new(FlashBoard::default(), model).map_err(fail)?;
                let reports = (0..seconds).map(|_| node.second().map_err(fail)).collect::<Result<_, _>>()?;
                Ok((reports, node.power_manager().unexplained()))
            }
            Self::Listening => {
                let mut node =
                    Listening::new(FlashBoard::default(), listening().map_err(fail)?).map_err(fail)?;
                let reports = (0..seconds).map(|_| node.second()).collect();
                Ok((reports, node.power_manager().unexplained()))
            }
        }
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
    let (expected, _) = kind.native(SECONDS)?;
    for second in 0..found.len().max(expected.len()) {
        let (found, expected) = (found.get(second), expected.get(second));
        // A number in the log is written with as many digits as tell it from its neighbours.
        if found.cloned() != expected.map(Report::to_string) {
            let what = format!("node: logs {found:?}, on the host {:?}", expected.map(Report::to_string));
            return Err(Error::on(core, what));
        }
    }
    Ok((expected, size))
}
