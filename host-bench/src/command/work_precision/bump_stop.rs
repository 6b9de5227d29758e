//! The bump-stop scenes of `work-precision`.

use std::path::PathBuf;

use super::super::progress;
use crate::method::Failure;
use crate::scene_file::{self, Override, Scene};
use crate::work_precision::Extent;
use crate::work_precision::bump_stop::{self, BumpStopComparison};

/// What is run of the shipped scene: in the first cases until after some contacts with the stop at the tip,
/// where the trajectory is compared; in the others for a second with the stop at mid-span, where the motion
/// settles, and statistics are.
const CASES: [&[(&str, &str)]; 4] = [
    &[
        ("parameters.beam_modes", "6"),
        ("stop.rod_modes", "2"),
        ("stop.gap_m", "5e-6"),
        ("run.duration_s", "5.67e-3"),
        ("run.settle_s", "0"),
    ],
    &[("stop.gap_m", "5e-6"), ("run.duration_s", "5.67e-3"), ("run.settle_s", "0")],
    &[
        ("parameters.beam_modes", "4"),
        ("stop.rod_modes", "1"),
        ("stop.position_m", "25e-3"),
        ("run.duration_s", "1.5"),
        ("run.settle_s", "0.5"),
    ],
    &[
        ("stop.rod_modes", "3"),
        ("stop.position_m", "25e-3"),
        ("run.duration_s", "1.5"),
        ("run.settle_s", "0.5"),
    ],
];

/// The first `most` cases of the shipped scene.
pub(crate) fn shipped(overrides: &[Override], most: usize) -> Result<Vec<Scene>, Failure> {
    let file = super::shipped_file("bump-stop.toml");
    let read = |case: &&[(&str, &str)]| {
        let mut all: Vec<Override> = case.iter().map(|(key, value)| Override::new(key, value)).collect();
        all.extend_from_slice(overrides);
        let mut scene = scene_file::read(&file, &all)?;
        // Its name without the place where it was built.
        scene.file = PathBuf::from("bump-stop.toml");
        Ok(scene)
    };
    CASES.iter().take(most).map(read).collect()
}

/// Runs the comparison on each scene, with a progress bar.
pub(crate) fn compare(scenes: &[Scene], extent: &Extent) -> Result<Vec<BumpStopComparison>, Failure> {
    let bar = progress(scenes.iter().map(|scene| bump_stop::length(scene, extent)).sum());
    let comparisons =
        scenes.iter().map(|scene| bump_stop::compare(scene, extent, |steps| bar.inc(steps))).collect();
    bar.finish_and_clear();
    comparisons
}

/// All tables as text.
pub(crate) fn text(comparisons: &[BumpStopComparison]) -> String {
    comparisons.iter().map(BumpStopComparison::text).collect::<Vec<_>>().join("\n")
}
