//! Runs of one scene to compare with.

use rayon::prelude::*;

use crate::method::{Options, Precision};
use crate::outcome::Outcome;
use crate::run::run_scene;
use crate::scene_file::Scene;
use crate::shift::shifted;

/// Most attempted steps of a comparison, where the run itself has no limit.
pub(crate) const MOST_ATTEMPTS: u64 = 1 << 26;
/// Most attempted steps of a comparison over those of the run.
const MORE_ATTEMPTS: u64 = 4;

/// What runs a scene to compare with.
pub(super) struct Runs<'a> {
    pub(super) scene: &'a Scene,
    /// Steps of all runs so far.
    pub(super) steps: u64,
}

impl Runs<'_> {
    /// The run of the scene; `None` if it cannot be run to its end.
    pub(super) fn get(&mut self, options: &Options) -> Option<Outcome> {
        self.at(options, &[0.0]).pop()
    }

    /// The runs of displaced starts, on all cores: the base acceleration, or the start where the base is at rest, is changed by
    /// such parts. Runs that do not come to their end are left out.
    pub(super) fn at(&mut self, options: &Options, shifts: &[f64]) -> Vec<Outcome> {
        let scene = self.scene;
        let run = |shift: &f64| run_scene(&shifted(scene, *shift)?, options).ok();
        let found: Vec<Outcome> = shifts.par_iter().filter_map(run).collect();
        self.steps += found.iter().map(|run| run.steps).sum::<u64>();
        found
    }
}

/// The options of a run to compare with, in double precision.
pub(super) fn in_double_precision(options: &Options) -> Options {
    to_compare(&Options { precision: Some(Precision::F64), math: None, ..*options })
}

/// The options of a run to compare with.
pub(super) fn to_compare(options: &Options) -> Options {
    let most = options.most_attempts.map_or(MOST_ATTEMPTS, |most| most.saturating_mul(MORE_ATTEMPTS));
    Options {
        precision: Some(options.chosen_precision()),
        blocks: true,
        trace_every_s: None,
        most_attempts: Some(most),
        ..*options
    }
}
