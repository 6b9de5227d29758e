//! Near pull-in, steps longer than the series allows, and long runs in single precision.

use super::run;
use crate::bridge::sine;
use crate::common::harvesters::contact_parameters;
use crate::common::{adaptive, fixed};
use model_core::clock::LONGEST_STEP_S;
use model_core::excitation::Sine;
use model_core::integrate::{ExponentialRadau, TrBdf2};
use model_core::part::force_law::AnyForceLaw;
use model_core::part::restitution::{AnyRestitution, ConstantRestitution};
use model_core::scalar::{Mathematics, Polynomial, Scalar};
use model_core::scene::contact_separation::Start;
use model_core::scene::{Harvester, Simulation, contact_separation};

/// A soft spring beside a strong charge: the attraction of the whole charge is `part` of the force that closes the gap.
fn soft(part: f64, resistance: f64) -> crate::common::harvesters::Contact<f64> {
    let mut parameters = contact_parameters::<f64>();
    parameters.stiffness = 10.0;
    parameters.damping_ratio = 0.05;
    let area = parameters.electrode_area;
    let force = part * parameters.stiffness * parameters.initial_gap;
    parameters.charge_density = (2.0 * crate::bridge::VACUUM_PERMITTIVITY * force / area).sqrt();
    parameters.choices.force_law = AnyForceLaw::GapField;
    parameters.choices.load.resistance = resistance;
    parameters.choices.restitution = AnyRestitution::Constant(ConstantRestitution { coefficient: 0.5 });
    parameters.build().expect("in bounds")
}

#[test]
fn near_pull_in_the_run_is_that_of_tr_bdf2() {
    for part in [0.5, 0.9, 1.5] {
        for resistance in [1e4, 1e7, 1e9] {
            let scene = soft(part, resistance);
            let vibration = sine(0.02, 6.0);
            let tight = adaptive(1e-7);
            let exact = run(scene, &Start::default(), TrBdf2, tight, &vibration, 0.5);
            for (tolerance, allowed) in [(1e-3, 1e-2), (1e-6, 2e-5)] {
                let control = adaptive(tolerance);
                let found = run(scene, &Start::default(), ExponentialRadau, control, &vibration, 0.5);
                let off = (found.power / exact.power - 1.0).abs();
                println!(
                    "{part} of the pull-in force, {resistance:e} Ω, {tolerance:e}: off by {off:.1e}, {} attempts, {} and {} events",
                    found.attempts, found.events, exact.events
                );
                assert!(off < allowed, "{part} {resistance} {tolerance}: {off}");
            }
        }
    }
}

/// Steps of 15.6 ms are 98 radians of the excitation at 1 kHz, and 20 of the damping: they are shortened to 0.9.
#[test]
fn a_fixed_step_longer_than_the_series_allows_is_shortened() {
    for (ratio, frequency) in [(5.0, 20.0), (0.005, 1000.0), (5.0, 1000.0)] {
        let mut parameters = contact_parameters::<f64>();
        parameters.damping_ratio = ratio;
        let scene = parameters.build().expect("in bounds");
        let vibration = sine(1.0, frequency);
        let control = fixed(LONGEST_STEP_S);
        let found = run(scene, &Start::default(), ExponentialRadau, control, &vibration, 0.3);
        let exact = run(scene, &Start::default(), TrBdf2, adaptive(1e-5), &vibration, 0.3);
        let off = (found.power / exact.power - 1.0).abs();
        println!("damping ratio {ratio}, {frequency} Hz: {} attempts, off by {off:.1e}", found.attempts);
        let fastest = (2.0 * ratio * 126.5).max(core::f64::consts::TAU * frequency);
        assert!(f64::from(found.attempts) > 0.99 * 0.3 * fastest / 0.9, "{} attempts", found.attempts);
        assert!(off < 2e-3, "{ratio} {frequency}: {off}");
    }
}

/// Mean power of the last five seconds of 200, below impact.
fn long<S: Scalar>() -> [f64; 2]
where
    Polynomial: Mathematics<S>,
{
    let number = S::from_f64;
    let scene = contact_parameters::<S>().build().expect("in bounds");
    let harvester = Simulation::new(scene, ExponentialRadau, adaptive(0.01));
    let vibration = Sine::<S>::new(number(0.2 * 9.81), number(22.0), S::ZERO).expect("in bounds");
    let mut state = harvester.start(&contact_separation::Start::default(), &vibration).expect("in bounds");
    [[15, 20], [195, 200]].map(|[from, until]| {
        let mut meter = model_core::energy::PowerMeter::new();
        let at = model_core::clock::Instant::from_whole_seconds;
        harvester.advance(&mut state, &vibration, at(from), u32::MAX, &mut ()).expect("runs");
        harvester.advance(&mut state, &vibration, at(until), u32::MAX, &mut meter).expect("runs");
        meter.mean_power().to_f64()
    })
}

#[test]
fn the_power_does_not_drift_in_single_precision() {
    let [early, late] = long::<f32>();
    let [exact, _] = long::<f64>();
    println!("{early:e} W after 15 s, {late:e} W after 195 s, {exact:e} W in double precision");
    assert!((late / early - 1.0).abs() < 5e-4 && (late / exact - 1.0).abs() < 5e-4);
}
