//! An estimator that runs for years: the end of the clock, sums, samples that are none, and a sensor off its rate.

use super::{EVER, follow, hybrid, settings};
use crate::common::harvesters::{bump, contact, sine_samples, slide};
use crate::common::{adaptive, finished, fixed};
use model_core::clock::Instant;
use model_core::energy::Estimator;
use model_core::energy::estimator::{EstimatorError, Interpolation, Sample, Settings};
use model_core::integrate::{ExponentialRadau, RungeKutta4};
use model_core::scalar::Scalar;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::AnyContact;

/// Half a year in s, after which the clock restarts.
const HALF_A_YEAR: u32 = 1 << 24;

/// Follows samples across the restart of the clock, and the same samples from time zero.
fn across_the_restart<S: Scalar, H: Harvester<S> + Copy>(harvester: H, samples: &[S]) {
    let rate = 256.0;
    let mut young = Estimator::new(harvester, settings(rate)).expect("valid");
    let expected = follow(&mut young, samples);
    let mut old = Estimator::new(harvester, settings(rate)).expect("valid");
    follow(&mut old, &samples[..3]);
    // A gap that ends two seconds before the half-year.
    finished(old.push_missing((HALF_A_YEAR - 2) * 256, EVER));
    // The gap integrates the last interval before it.
    let before = old.estimate();
    let found = follow(&mut old, samples);
    assert!(old.known_until() < Instant::from_whole_seconds(8), "the clock has restarted");
    assert!(found.energy > before.energy);
    let energy = found.energy.to_f64() - before.energy.to_f64();
    assert!((energy / expected.energy.to_f64() - 1.0).abs() < 2.0 * S::EPSILON.to_f64());
    assert_eq!(found.seconds.to_f64(), before.seconds.to_f64() + expected.seconds.to_f64());
    // On a binary grid of samples the state is the same to the bit, but for the clock.
    let mut state = *old.harvester_state();
    harvester.set_clock(&mut state, harvester.clock(young.harvester_state()));
    assert_eq!(state, *young.harvester_state());
}

#[test]
fn the_clock_restarts_before_it_ends() {
    let control = adaptive(5e-2);
    across_the_restart(
        hybrid(slide::<f64>(), ExponentialRadau, control),
        &sine_samples(3.53, 18.37, 256.0, 1500),
    );
    let control = adaptive(5e-2);
    across_the_restart(
        hybrid(contact::<f32>(), ExponentialRadau, control),
        &sine_samples(1.96, 20.0, 256.0, 1500),
    );
    let stepper = bump::<f64, 1, 1>(AnyContact::ResidualFlexibility);
    across_the_restart(stepper, &sine_samples(2.0, 40.0, 256.0, 1000));
}

#[test]
fn gaps_longer_than_the_clock_are_unknown_time_and_nothing_stops() {
    let harvester = hybrid(contact::<f32>(), ExponentialRadau, adaptive(5e-2));
    let mut estimator = Estimator::new(harvester, settings(64.0)).expect("valid");
    let samples = sine_samples::<f32>(1.96, 20.0, 64.0, 200);
    let mut seconds = 0.0;
    // The first gap alone is as long as the clock, and all together 21 years.
    for _ in 0..10 {
        let estimate = follow(&mut estimator, &samples);
        assert!(estimate.seconds > seconds);
        seconds = estimate.seconds;
        finished(estimator.push_missing(u32::MAX, EVER));
    }
    let unknown = estimator.estimate().uncertainty.unknown_seconds;
    assert!((unknown / (10.0 * (u32::MAX as f32 / 64.0)) - 1.0).abs() < 1e-5, "{unknown}");
}

#[test]
fn what_no_sensor_reads_is_a_lost_sample() {
    let harvester = hybrid(contact::<f32>(), ExponentialRadau, adaptive(5e-2));
    let samples = sine_samples::<f32>(1.962, 20.0, 400.0, 900);
    let mut told = Estimator::new(harvester, settings(400.0)).expect("valid");
    let mut shown = told;
    let absurd = [1e30, -1e30, 1.1e6, f32::NAN, f32::INFINITY, f32::MIN];
    for (n, &sample) in samples.iter().enumerate() {
        match absurd.get(n / 100) {
            Some(&reading) if n % 100 == 50 => {
                finished(told.push_missing(1, EVER));
                let sample = [Sample::Good(reading), Sample::Saturated(reading)][n / 100 % 2];
                finished(shown.push(sample, EVER));
            }
            _ => {
                finished(told.push_acceleration(sample, EVER));
                finished(shown.push_acceleration(sample, EVER));
            }
        }
    }
    assert_eq!(shown, told);
    assert_eq!(shown.estimate().uncertainty.missing_samples, 6);
}

#[test]
fn a_sensor_off_its_rate_is_followed_at_its_rate() {
    let harvester = hybrid(contact::<f64>(), ExponentialRadau, adaptive(1e-3));
    let nominal = Settings { interpolation: Interpolation::DroopCompensated, ..settings(400.0) };
    // The sensor takes 420 samples in what it calls 400.
    let samples = sine_samples::<f64>(1.962, 20.0, 420.0, 4200);
    let true_rate = Settings { rate: 420.0, ..nominal };
    let expected = follow(&mut Estimator::new(harvester, true_rate).expect("valid"), &samples);
    let uncorrected = follow(&mut Estimator::new(harvester, nominal).expect("valid"), &samples);
    assert!((uncorrected.energy / expected.energy - 1.0).abs() > 0.1, "the error of the rate matters");
    let mut estimator = Estimator::new(harvester, nominal).expect("valid");
    estimator.set_rate(420.0, 0.0).expect("in bounds");
    let corrected = follow(&mut estimator, &samples);
    assert_eq!(corrected.energy, expected.energy);

    // Set while running, and kept by a snapshot.
    let mut running = Estimator::new(harvester, nominal).expect("valid");
    follow(&mut running, &samples[..1000]);
    let before = running.estimate();
    running.set_rate(420.0, 0.0).expect("in bounds");
    let mut bytes = [0; 640];
    running.save(&mut bytes).expect("fits");
    let mut woken = Estimator::new(harvester, nominal).expect("valid");
    woken.restore(&bytes).expect("sound");
    assert_eq!(woken, running);
    assert_eq!(woken.rate(), 420.0);
    let after = follow(&mut woken, &samples[1000..]);
    assert_eq!(after.energy, follow(&mut running, &samples[1000..]).energy);
    let seconds = after.seconds - before.seconds;
    assert!((seconds - 3200.0 / 420.0).abs() < 1e-8, "{seconds}");
    let late = (after.energy - before.energy) / seconds;
    assert!((late / expected.mean_power - 1.0).abs() < 0.1, "{late} {}", expected.mean_power);

    let refused = |rate: f64| woken.clone().set_rate(rate, 0.0);
    for rate in [0.0, -400.0, f64::NAN, f64::INFINITY, 1.1e6] {
        assert!(matches!(refused(rate), Err(EstimatorError::Parameter(error)) if error.field == "rate"));
    }
}

#[test]
fn gravity_is_tracked_removed_and_reported() {
    let harvester = hybrid(slide::<f64>(), ExponentialRadau, adaptive(1e-3));
    let samples = sine_samples::<f64>(3.53, 18.37, 400.0, 8000);
    let tilted: Vec<f64> = samples.iter().map(|sample| sample + 9.81).collect();
    let tracking = Settings { bias_seconds: Some(1.0), ..settings(400.0) };
    let level = follow(&mut Estimator::new(harvester, settings(400.0)).expect("valid"), &samples);
    let forgotten = follow(&mut Estimator::new(harvester, settings(400.0)).expect("valid"), &tilted);
    assert!(
        (forgotten.energy / level.energy - 1.0).abs() > 0.02,
        "gravity matters: {} {}",
        forgotten.energy,
        level.energy
    );
    let mut estimator = Estimator::new(harvester, tracking).expect("valid");
    let tracked = follow(&mut estimator, &tilted);
    // Until the mean has settled the motion differs: one second of twenty, which counts as uncertain.
    let difference = (tracked.energy / level.energy - 1.0).abs();
    assert!(difference < 0.02 && difference < tracked.uncertainty.relative.expect("known"), "{difference}");
    // A high-pass of one second passes this amplitude of the sine into the mean.
    let ripple = 3.53 / (core::f64::consts::TAU * 18.37);
    assert!((tracked.bias.expect("tracked") - 9.81).abs() < 1.1 * ripple);
    assert!((tracked.uncertainty.uncertain_seconds - 1.0).abs() < 1e-8);
    assert_eq!(level.bias, None);
    let refused = Estimator::new(harvester, Settings { bias_seconds: Some(1e-3), ..tracking });
    assert!(matches!(refused, Err(EstimatorError::Parameter(error)) if error.field == "bias_seconds"));
}

#[test]
fn what_is_not_estimated_is_unknown() {
    let samples = sine_samples::<f32>(3.53, 18.37, 400.0, 800);
    let fixed = fixed(2e-3);
    let explicit = follow(
        &mut Estimator::new(hybrid(slide::<f32>(), RungeKutta4, fixed), settings(400.0)).expect("valid"),
        &samples,
    );
    assert!(explicit.energy > 0.0);
    assert_eq!((explicit.uncertainty.step, explicit.uncertainty.relative), (None, None));
    let stepper = bump::<f32, 4, 1>(AnyContact::ResidualFlexibility);
    let modal = follow(&mut Estimator::new(stepper, settings(3520.0)).expect("valid"), &samples);
    assert_eq!((modal.uncertainty.step, modal.uncertainty.relative), (None, None));
    assert!(modal.uncertainty.sampling.is_some());
    // 3.9 and 4.1 samples in a resonance period.
    let harvester = hybrid(slide::<f32>(), ExponentialRadau, adaptive(5e-2));
    let resonance = f64::from(harvester.resonance_frequency());
    for (per_period, known) in [(3.9, false), (4.1, true)] {
        let mut estimator = Estimator::new(harvester, settings(per_period * resonance)).expect("valid");
        let slow =
            follow(&mut estimator, &sine_samples(3.53, 18.37, per_period * resonance, 200)).uncertainty;
        assert!(slow.step.is_some());
        assert_eq!((slow.sampling.is_some(), slow.relative.is_some()), (known, known));
    }
}

#[test]
#[ignore = "a minute in the release profile"]
fn a_day_without_clearing_is_the_sum_of_its_hours_in_single_precision() {
    let harvester = hybrid(contact::<f32>(), ExponentialRadau, adaptive(5e-2));
    let mut whole = Estimator::new(harvester, settings(256.0)).expect("valid");
    let mut hourly = whole;
    // A second of a sine, again and again: twenty periods.
    let second = sine_samples::<f32>(1.962, 20.0, 256.0, 256);
    let (mut energy, mut seconds) = (0.0, 0.0);
    for _hour in 0..24 {
        for _second in 0..3600 {
            follow(&mut whole, &second);
            follow(&mut hourly, &second);
        }
        let estimate = hourly.estimate();
        energy += f64::from(estimate.energy);
        seconds += f64::from(estimate.seconds);
        hourly.clear();
    }
    let day = whole.estimate();
    assert_eq!(whole.harvester_state(), hourly.harvester_state());
    // The last two samples are not yet integrated.
    assert!((seconds - (86_400.0 - 2.0 / 256.0)).abs() < 1e-3, "{seconds}");
    assert_eq!(day.seconds, seconds as f32);
    assert!((f64::from(day.energy) / energy - 1.0).abs() < 4e-7, "{} {energy}", day.energy);
    // The scatter of the mean of a day is a fifth of that of an hour; the motion is the same.
    let relative = day.uncertainty.relative.expect("known");
    assert!(relative < 0.3 && day.uncertainty.irregularity < 1e-3, "{:?}", day.uncertainty);
}
