//! A search for a steady state ends at a number of attempted steps.

use harvester_engine::embedded::steady_state;
use harvester_scene::method::{Failure, Options};
use harvester_scene::scene_file::read_shipped;

/// A period of 10⁶ s has more steps than a day computes.
#[test]
fn a_search_over_a_long_period_is_given_up() {
    for name in ["contact-separation", "bump-stop"] {
        let scene = read_shipped(name, &[("excitation.frequency_hz", "1e-6")]).expect("a valid scene");
        let options = Options { steady_state: true, most_attempts: Some(100_000), ..Options::default() };
        let found = steady_state(&scene, &options);
        let Err(Failure::StepLimitExceeded(told)) = found else { panic!("{name}: {found:?}") };
        assert!(told.contains("given up after 100000 attempted steps"), "{name}: {told}");
    }
}
