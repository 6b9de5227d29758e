//! The release of a slider from rest whose pull exceeds the static friction for a part of a step only.
//!
//! At rest at the centre the pull is the base acceleration times a constant, so that every release has the same
//! acceleration. A large amplitude tells it; one that exceeds it by a two-thousandth then has its release in closed form,
//! and both ends of a step around the crest are below static friction.

use core::f64::consts::{FRAC_PI_2, TAU};

use crate::bridge::{GRAVITY, adaptive, fixed, slider};
use model_core::clock::Instant;
use model_core::excitation::Sine;
use model_core::hybrid::{Driver, Ended};
use model_core::integrate::{AnyStepControl, ExponentialRadau, Method, TrBdf2};
use model_core::scene::sliding;

const FREQUENCY: f64 = 6.0;
/// An amplitude in m/s² far above that of a release.
const LARGE: f64 = 2.0 * GRAVITY;
const EXCESS: f64 = 5e-4;

/// The phase in rad of the base at the first release.
fn release(amplitude: f64, phase: f64, method: impl Method<f64>, control: AnyStepControl<f64>) -> f64 {
    let scene = slider::<f64>(f64::INFINITY);
    let vibration = Sine::<f64>::new(amplitude, FREQUENCY, phase).expect("in bounds");
    let driver = Driver { pause_at_events: true, ..Driver::new(method, control) };
    let mut state =
        scene.start::<_, _, 0>(&sliding::Start::default(), &vibration, &control).expect("in bounds");
    let end = Instant::from_seconds(1.0 / FREQUENCY).expect("in range");
    let advance = driver.advance(&scene, &mut state, &vibration, end, u32::MAX, &mut ()).expect("runs");
    assert_eq!(advance.ended, Ended::Event, "no release");
    phase + TAU * FREQUENCY * state.clock.seconds::<f64>()
}

/// Releases at the crest in steps that begin at many phases before it.
fn is_on_time(method: impl Method<f64> + Copy, long: AnyStepControl<f64>) {
    let acceleration = LARGE * release(LARGE, 0.0, method, fixed(1e-5)).sin();
    let expected = (1.0 / (1.0 + EXCESS)).asin();
    for part in 1..40 {
        let phase = expected - f64::from(part) * 0.01;
        let found = release(acceleration * (1.0 + EXCESS), phase, method, long);
        assert!(
            (found - expected).abs() < 1e-6,
            "from {phase}: {found} is not {expected}, crest at {FRAC_PI_2}"
        );
    }
}

#[test]
fn a_release_within_a_step_is_at_the_first_excess() {
    // The crest is above static friction for 1.7 ms.
    is_on_time(ExponentialRadau, fixed(12e-3));
    is_on_time(TrBdf2, fixed(12e-3));
    is_on_time(ExponentialRadau, adaptive(1e-2));
}
