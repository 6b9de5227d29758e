//! What the tests of this crate share: the shipped scenes, and a comparison of numbers.

use crate::scene_file::{self, BumpStop, Model, Scene, SlidingParameters};

fn shipped(name: &str) -> Scene {
    scene_file::read_shipped(name, &[]).expect("the shipped scene is valid")
}

/// The sliding harvester of Table 1.
pub(crate) fn sliding() -> SlidingParameters {
    shipped("sliding").sliding().expect("sliding").parameters
}

/// The bump-stop harvester with its stop.
pub(crate) fn bump_stop() -> BumpStop {
    let Model::BumpStop(model) = shipped("bump-stop").model else { panic!("another scene") };
    model
}

/// Asserts that a number is within `relative` of what is expected.
#[track_caller]
pub(crate) fn close(found: f64, expected: f64, relative: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= relative * expected.abs(),
        "{found:e} is not {expected:e}: off by {:.1e}",
        error / expected
    );
}
