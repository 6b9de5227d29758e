//! The example nodes, second by second: instructions of the whole loop with estimate, storage and budget.
//!
//! A step in the log of these workloads is a second.

use super::{Progress, Visit, Workload};
use crate::node::{self, FlashBoard, Following, Listening, Report};

/// Seconds that a workload runs.
const SECONDS: u32 = 16;

/// The node that follows its harvester.
pub fn following(visit: Visit<'_>) -> Option<()> {
    let mut node = Following::new(FlashBoard::default(), node::following().ok()?).ok()?;
    visit(&mut BySecond { name: "node-following", second: || node.second().ok(), seconds: 0, bits: [0; 2] });
    Some(())
}

/// The node that asks a closed form about the strongest sine.
pub fn listening(visit: Visit<'_>) -> Option<()> {
    let mut node = Listening::new(FlashBoard::default(), node::listening().ok()?).ok()?;
    visit(&mut BySecond { name: "node-listening", second: || Some(node.second()), seconds: 0, bits: [0; 2] });
    Some(())
}

/// A node by the function that runs it for a second.
#[derive(Debug)]
struct BySecond<F> {
    name: &'static str,
    second: F,
    seconds: u32,
    bits: [u32; 2],
}

impl<F: FnMut() -> Option<Report>> Workload for BySecond<F> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn advance(&mut self) -> Progress {
        if self.seconds == SECONDS {
            return Progress::Finished;
        }
        self.seconds += 1;
        let Some(report) = (self.second)() else { return Progress::Failed };
        self.bits = [report.harvested, report.stored].map(f32::to_bits);
        Progress::Sample { steps: 1, simulated_us: 1_000_000 }
    }

    fn state(&self) -> &[u32] {
        &self.bits
    }
}
