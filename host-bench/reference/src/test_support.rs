//! What the tests of this crate share: the shipped scenes, and comparisons of numbers.

use harvester_scene::scene_file::{
    self, BumpStop, ContactSeparationParameters, Model, Scene, SlidingParameters,
};

/// A shipped scene, by its name.
fn shipped(name: &str) -> Scene {
    scene_file::read_shipped(name, &[]).expect("the shipped scene is valid")
}

/// The contact-separation harvester of Table 2.
pub(crate) fn contact_separation() -> ContactSeparationParameters {
    shipped("contact-separation").contact_separation().expect("contact-separation").parameters
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

/// The number, or not-a-number, which fails every comparison.
pub(crate) fn number(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

/// Asserts that a number is there and within `relative` of what is expected.
#[track_caller]
pub(crate) fn close(found: impl Into<Option<f64>>, expected: f64, relative: f64) {
    let found = number(found.into());
    let error = (found - expected).abs();
    assert!(
        error <= relative * expected.abs(),
        "{found:e} is not {expected:e}: off by {:.1e}",
        error / expected
    );
}
