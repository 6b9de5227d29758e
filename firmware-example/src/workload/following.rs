//! The node that follows its harvester, second by second: instructions of the whole loop with estimate, storage and budget.
//!
//! A step in the log is a second.

use super::{Progress, Visit, Workload};
use crate::following::{self, FlashBoard, Following, Report};

/// Seconds that it runs.
const SECONDS: u32 = 16;

/// The node that follows its harvester.
pub fn node(visit: Visit<'_>) -> Option<()> {
    let mut node = Following::new(FlashBoard::default(), following::following().ok()?).ok()?;
    visit(&mut BySecond { name: "node-following", second: || node.second().ok(), seconds: 0, bits: [0; 2] });
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
