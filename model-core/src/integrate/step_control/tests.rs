//! The controller's verdicts and lengths of step.

use super::*;

#[test]
fn logarithm_and_its_inverse_agree() {
    for ratio in [1e-6_f32, 0.3, 1.0, 7.5, 1e4] {
        let exact = ratio.log2();
        assert!((log2(ratio) as f32 / 8_388_608.0 - exact).abs() < 0.09, "{ratio}");
        let change = log2(ratio).clamp(SMALLEST_CHANGE, LARGEST_CHANGE);
        let expected = ratio.clamp(0.2, 4.0) * 1e6;
        assert!((scaled(1_000_000, change) as f32 / expected - 1.0).abs() < 0.06, "{ratio}");
    }
    assert_eq!(scaled(u32::MAX, LARGEST_CHANGE), u32::MAX);
    assert_eq!(scaled(1, SMALLEST_CHANGE), 1);
}

#[test]
fn settles_where_the_error_meets_the_tolerance() {
    let scale = ErrorScale { angular_frequency: 100.0_f64, decay_rate: 0.0, energy_floor: 1e-12 };
    let control = Adaptive::new(1e-4).expect("in bounds");
    let mut memory = control.start(&scale);
    // A model error of 0.04 (ω h)³ per step: the allowed 1e-4 ω h / 20 gives ω h = 0.0112.
    let mut radians = 0.0;
    let mut rejections = 0;
    for _ in 0..60 {
        radians = seconds_of_ticks::<f64>(memory.ticks) * 100.0;
        let errors = StepErrors {
            ticks: memory.ticks,
            order: 2,
            longest_ticks: scale.ticks_of_radians(0.4),
            time_scale_ratio: 1.0,
            state: 0.04 * radians.powi(3),
            energy: 0.0,
            delivered: 0.0,
            carried: false,
        };
        rejections += u32::from(control.judge(&mut memory, &errors, &scale, || 0.0) == Verdict::Reject);
    }
    assert!((0.0094..0.0112).contains(&radians), "{radians}");
    assert!(rejections <= 2, "{rejections}");
}

#[test]
fn a_rejected_step_shrinks_and_the_next_does_not_grow() {
    let scale = ErrorScale { angular_frequency: 100.0_f32, decay_rate: 0.0, energy_floor: 1e-12 };
    let control = Adaptive::new(1e-4).expect("in bounds");
    let mut memory = control.start(&scale);
    let before = memory.ticks;
    let bad = StepErrors {
        ticks: before,
        order: 2,
        longest_ticks: scale.ticks_of_radians(0.4),
        time_scale_ratio: 1.0,
        state: 1.0,
        energy: 0.0,
        delivered: 0.0,
        carried: false,
    };
    assert_eq!(control.judge(&mut memory, &bad, &scale, || 0.0), Verdict::Reject);
    assert!(memory.ticks < before);
    let retried = memory.ticks;
    let good = StepErrors { ticks: retried, state: 0.0, ..bad };
    assert_eq!(control.judge(&mut memory, &good, &scale, || 0.0), Verdict::Accept);
    assert!(memory.ticks <= retried);
}

#[test]
fn an_error_of_the_energy_that_is_rounding_is_no_reason_to_reject() {
    let scale = ErrorScale { angular_frequency: 100.0_f32, decay_rate: 0.0, energy_floor: 1e-12 };
    let control = Adaptive::new(1e-4).expect("in bounds");
    let start = control.start(&scale);
    let noisy = StepErrors {
        ticks: start.ticks,
        order: 2,
        longest_ticks: scale.ticks_of_radians(0.4),
        time_scale_ratio: 1.0,
        state: 0.0,
        energy: 2e-9,
        delivered: 1e-8,
        carried: false,
    };
    let judge =
        |errors: &StepErrors<f32>, rounding: f32| control.judge(&mut { start }, errors, &scale, || rounding);
    assert_eq!(judge(&noisy, 0.0), Verdict::Reject);
    assert_eq!(judge(&noisy, 1e-9), Verdict::Reject);
    assert_eq!(judge(&noisy, 2e-9), Verdict::Accept);
    // The error of the state is not excused by it.
    assert_eq!(judge(&StepErrors { state: 1.0, ..noisy }, 2e-9), Verdict::Reject);
}

#[test]
fn the_unit_of_time_is_that_of_the_faster_motion_at_any_frequency() {
    use crate::excitation::{Excitation, Silence, Sine};
    let scale = ErrorScale { angular_frequency: 126.0_f64, decay_rate: 0.0, energy_floor: 1e-12 };
    let at = |frequency: f64| {
        let sine = Sine::<f64>::new(1.0, frequency, 0.0).expect("valid");
        scale.of_the_faster(sine.angular_frequency()).angular_frequency
    };
    assert_eq!(at(20.0), 126.0);
    for frequency in [20.1, 31.999, 32.001, 1e4] {
        assert_eq!(at(frequency), core::f64::consts::TAU * frequency);
    }
    assert_eq!(scale.of_the_faster(Excitation::<f64>::angular_frequency(&Silence)), scale);
}

#[test]
fn lengths_and_tolerances_that_are_not_positive_finite_numbers_are_refused() {
    for bad in [f64::NAN, 0.0, -1e-3, f64::INFINITY, 1.0] {
        let error = Adaptive::new(bad).expect_err("out of bounds");
        assert_eq!(error.field, "tolerance");
        assert_eq!(FixedStep::of_seconds(bad).expect_err("out of bounds").field, "step");
    }
    assert!(Adaptive::new(f32::EPSILON).is_ok() && Adaptive::new(0.1_f64).is_ok());
    assert!(FixedStep::of_seconds(1e-12_f64).is_ok() && FixedStep::of_seconds(15.6e-3_f32).is_ok());
}
