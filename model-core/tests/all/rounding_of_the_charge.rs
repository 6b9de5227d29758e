//! A fast circuit in single precision: the rounding of the charge, divided by a step, is the noise of its current,
//! and must not shorten the step.

use crate::common::adaptive;
use model_core::clock::Instant;
use model_core::excitation::Sine;
use model_core::hybrid::{Driver, Ended};
use model_core::integrate::TrBdf2;
use model_core::scalar::{Mathematics, Polynomial, Scalar};
use model_core::scene::sliding::{PatchFriction, Start};

use crate::common::harvesters::sliding_parameters;

/// Attempted steps of a slider with 1 Ω, 20 µC/m² and little friction, shaken at `frequency` for `seconds`.
fn attempts<S: Scalar>(acceleration: f64, frequency: f64, seconds: f64) -> u32
where
    Polynomial: Mathematics<S>,
{
    let number = S::from_f64;
    let mut parameters = sliding_parameters::<S>();
    parameters.charge_density = number(20e-6);
    parameters.choices.load.resistance = S::ONE;
    parameters.choices.friction = PatchFriction {
        static_active: number(0.06),
        static_inert: number(0.06),
        kinetic_active: number(0.05),
        kinetic_inert: number(0.04),
    };
    let scene = parameters.build().expect("in bounds");
    let sine = Sine::<S>::new(number(acceleration), number(frequency), S::ZERO).expect("valid");
    let driver = Driver::new(TrBdf2, adaptive(1e-4));
    let mut state = scene.start::<_, _, 1>(&Start::default(), &sine, &driver.control).expect("in bounds");
    let end = Instant::from_seconds(seconds).expect("a time");
    // Ten times what double precision takes for the longest.
    let advance = driver.advance(&scene, &mut state, &sine, end, 200_000, &mut ()).expect("runs");
    assert_eq!(advance.ended, Ended::Finished, "{frequency} Hz: at {} s", state.clock.seconds::<f64>());
    advance.work.steps + advance.work.rejected + advance.work.locating
}

#[test]
fn single_precision_takes_no_more_steps_than_double() {
    for (acceleration, frequency, seconds) in [(300.0, 1e4, 1e-3), (60.0, 1e3, 0.02), (30.0, 0.01, 2.0)] {
        let single = attempts::<f32>(acceleration, frequency, seconds);
        let double = attempts::<f64>(acceleration, frequency, seconds);
        println!("{frequency} Hz: {single} attempts in single precision, {double} in double");
        assert!(
            single <= double,
            "{frequency} Hz: {single} attempts in single precision, {double} in double"
        );
    }
}
