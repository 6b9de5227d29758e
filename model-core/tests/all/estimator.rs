//! The estimator: the bits of a whole trace, bounded work, gaps and saturation.

mod calibration;
mod inputs;
mod long_running;
mod uncertainty;

use crate::common::harvesters::{bump, contact, sine_samples, slide, sliding_parameters};
use crate::common::{Random, adaptive, finished, fixed};
use model_core::clock::Instant;
use model_core::energy::estimator::{EstimatorError, Interpolation, Sample, SampleFormat, Settings};
use model_core::energy::{Estimate, Estimator, PowerMeter};
use model_core::excitation::{AfterLastSample, Sampled, Stream};
use model_core::hybrid::{Driver, StepFailure};
use model_core::integrate::{Method, RungeKutta4, StepControl, TrBdf2};
use model_core::part::GRAVITY;
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::{self, AnyContact, Restitution};
use model_core::scene::sliding::PatchFriction;
use model_core::scene::{Harvester, Scene, Simulation};

const EVER: u32 = u32::MAX;

pub(crate) fn settings<S: Scalar>(rate: f64) -> Settings<S> {
    Settings {
        rate: S::from_f64(rate),
        format: SampleFormat::accelerations(S::INFINITY, S::ZERO),
        longest_gap: 4,
        settling_seconds: S::ZERO,
        rate_tolerance: S::ZERO,
        jitter: S::ZERO,
        interpolation: Interpolation::Linear,
        bias_seconds: None,
    }
}

fn hybrid<S: Scalar, A: Scene<S, 3, 1>, M: Method<S>, C: StepControl<S>>(
    scene: A,
    method: M,
    control: C,
) -> Simulation<A, M, C, 3, 1> {
    Simulation::new(scene, method, control)
}

/// The instants to which a stream of that many samples is known, one after the other.
fn known<S: Scalar>(rate: f64, samples: &[S]) -> Vec<Instant> {
    let mut stream = Stream::new(S::from_f64(rate), samples[0]).expect("valid");
    let mut known = Vec::new();
    for &sample in &samples[1..] {
        stream.push(sample).expect("finite");
        known.push(stream.known_until());
    }
    known
}

/// Follows all samples; gives the estimate.
pub(crate) fn follow<S: Scalar, H: Harvester<S>>(
    estimator: &mut Estimator<S, H>,
    samples: &[S],
) -> Estimate<S> {
    for &sample in samples {
        let progress = estimator.push_acceleration(sample, EVER).expect("runs");
        assert!(progress.finished);
    }
    estimator.estimate()
}

fn same_bits_as_a_trace<S: Scalar, A, M, C>(scene: A, method: M, control: C, rate: f64, samples: &[S])
where
    A: Scene<S, 3, 1> + Copy,
    M: Method<S> + Copy,
    C: StepControl<S> + Copy,
{
    let mut estimator = Estimator::new(hybrid(scene, method, control), settings(rate)).expect("valid");
    let estimate = follow(&mut estimator, samples);
    let trace = Sampled::new(samples, S::from_f64(rate), AfterLastSample::Silence).expect("valid");
    let driver = Driver::new(method, control);
    let mut state = scene.start(&Default::default(), &trace, &control).expect("starts");
    let mut meter = PowerMeter::<S>::new();
    for until in known(rate, samples) {
        driver.advance(&scene, &mut state, &trace, until, EVER, &mut meter).expect("runs");
    }
    assert_eq!(*estimator.harvester_state(), state);
    assert_eq!(estimate.energy, meter.delivered_energy());
    assert_eq!(estimate.mean_power, meter.mean_power());
    assert!(estimate.energy > S::ZERO);
    // What an undivided run finds differs by the cuts alone.
    let mut state = scene.start(&Default::default(), &trace, &control).expect("starts");
    let mut whole = PowerMeter::<S>::new();
    driver.advance(&scene, &mut state, &trace, estimator.known_until(), EVER, &mut whole).expect("runs");
    let difference = (whole.delivered_energy() / estimate.energy).to_f64() - 1.0;
    assert!(difference.abs() < 2e-2, "{difference}");
}

fn same_bits_of_the_hybrid_scenes<S: Scalar>() {
    for rate in [400.0, 333.3, 1600.0] {
        let count = rate as u32;
        let samples = sine_samples::<S>(1.962, 20.0, rate, count);
        let adaptive = adaptive(5e-2);
        same_bits_as_a_trace(contact::<S>(), TrBdf2, adaptive, rate, &samples);
        let samples = sine_samples::<S>(0.36 * GRAVITY, 18.373, rate, count);
        same_bits_as_a_trace(slide::<S>(), TrBdf2, adaptive, rate, &samples);
        let fixed = fixed(1e-3);
        same_bits_as_a_trace(slide::<S>(), RungeKutta4, fixed, rate, &samples);
    }
}

#[test]
fn a_stream_gives_the_bits_of_a_whole_trace() {
    same_bits_of_the_hybrid_scenes::<f32>();
    same_bits_of_the_hybrid_scenes::<f64>();
}

fn same_bits_of_bump_stop<S: Scalar>() {
    let contacts = [
        AnyContact::ResidualFlexibility,
        AnyContact::Restitution(Restitution { coefficient: S::from_f64(0.6) }),
    ];
    // At 200 kHz a short step is longer than a sample, and is cut.
    for (rate, seconds) in [(3200.0, 0.1), (4800.0, 0.1), (200_000.0, 0.01)] {
        for contact in contacts {
            let stepper = bump::<S, 4, 1>(contact);
            let short_ticks = Instant::from_seconds(S::from_f64(9e-6)).expect("in range").ticks() as u32;
            let samples = sine_samples::<S>(20.0, 220.0, rate, (seconds * rate) as u32);
            let mut estimator = Estimator::new(stepper, settings(rate)).expect("valid");
            let estimate = follow(&mut estimator, &samples);
            let trace = Sampled::new(&samples, S::from_f64(rate), AfterLastSample::Silence).expect("valid");
            let mut state = stepper.scene().start(&bump_stop::Start::default(), &trace).expect("valid");
            let mut meter = PowerMeter::<S>::new();
            for until in known(rate, &samples) {
                let beyond = rate < 100_000.0;
                let ended = if beyond {
                    stepper.advance_past(&mut state, &trace, until, u64::MAX, EVER, &mut meter)
                } else {
                    stepper.advance(&mut state, &trace, until, EVER, &mut meter)
                };
                ended.expect("runs");
                let late = state.clock.ticks().saturating_sub(until.ticks());
                assert!(state.clock >= until && (late == 0 || beyond && late < u64::from(short_ticks)));
            }
            assert_eq!(*estimator.harvester_state(), state);
            assert_eq!(estimate.energy, meter.delivered_energy());
            assert!(estimate.energy > S::ZERO);
            assert_eq!(estimate.uncertainty.step, None);
        }
    }
}

#[test]
fn a_stream_gives_the_bits_of_a_whole_trace_in_bump_stop() {
    same_bits_of_bump_stop::<f32>();
    same_bits_of_bump_stop::<f64>();
}

/// Pushes each sample with a budget of its own, and resumes until it is finished.
fn by_budgets<H: Harvester<f32>>(
    harvester: H,
    rate: f64,
    samples: &[f32],
    seed: u64,
) -> (Estimator<f32, H>, usize) {
    let mut estimator = Estimator::new(harvester, settings(rate)).expect("valid");
    let mut random = Random(seed);
    let mut resumed = 0;
    for &sample in samples {
        let budget = |random: &mut Random| (random.next() % 120) as u32;
        let limit = |budget: u32| budget.max(H::LEAST_BUDGET);
        let given = budget(&mut random);
        let mut progress = estimator.push_acceleration(sample, given).expect("runs");
        assert!(progress.work.attempts() <= limit(given));
        while !progress.finished {
            let refused = estimator.push_acceleration(9.0, EVER);
            assert_eq!(refused, Err(EstimatorError::Unfinished));
            let given = budget(&mut random);
            progress = estimator.resume(given).expect("runs");
            assert!(progress.work.attempts() <= limit(given));
            resumed += 1;
        }
    }
    (estimator, resumed)
}

#[test]
fn budgets_change_no_bit_and_are_kept() {
    let samples = sine_samples::<f32>(1.962, 20.0, 100.0, 300);
    let harvester = hybrid(contact::<f32>(), TrBdf2, adaptive(1e-3));
    let mut whole = Estimator::new(harvester, settings(100.0)).expect("valid");
    follow(&mut whole, &samples);
    let (divided, resumed) = by_budgets(harvester, 100.0, &samples, 5);
    assert_eq!(divided, whole);
    assert!(resumed > 100, "{resumed}");

    let samples = sine_samples::<f32>(20.0, 220.0, 1600.0, 600);
    let stepper = bump::<f32, 4, 1>(AnyContact::ResidualFlexibility);
    let mut whole = Estimator::new(stepper, settings(1600.0)).expect("valid");
    follow(&mut whole, &samples);
    let (divided, resumed) = by_budgets(stepper, 1600.0, &samples, 7);
    assert_eq!(divided, whole);
    assert!(resumed > 100, "{resumed}");
}

#[test]
fn counts_are_the_accelerations_they_stand_for() {
    let scale = GRAVITY as f32 / 16_384.0;
    let counts: Vec<i16> = sine_samples::<f64>(3277.0, 20.0, 400.0, 800).iter().map(|&a| a as i16).collect();
    let harvester = hybrid(contact::<f32>(), TrBdf2, adaptive(5e-2));
    let format = SampleFormat::counts(scale, 32_767);
    let mut raw = Estimator::new(harvester, Settings { format, ..settings(400.0) }).expect("valid");
    let format = SampleFormat::accelerations(f32::INFINITY, scale);
    let mut si = Estimator::new(harvester, Settings { format, ..settings(400.0) }).expect("valid");
    for &count in &counts {
        finished(raw.push_count(count, EVER));
        finished(si.push_acceleration(f32::from(count) * scale, EVER));
    }
    assert_eq!(raw.estimate(), si.estimate());
    assert_eq!(raw.harvester_state(), si.harvester_state());
}

#[test]
fn a_short_gap_is_a_straight_line() {
    // A zigzag whose corners are eight samples apart, on binary fractions: what is lost lies on the line exactly.
    let zigzag = |n: u32| f64::from(4 - (n % 16).abs_diff(8) as i32) * 0.5;
    let harvester = hybrid(contact::<f64>(), TrBdf2, adaptive(1e-2));
    let mut whole = Estimator::new(harvester, settings(256.0)).expect("valid");
    let mut gappy = Estimator::new(harvester, settings(256.0)).expect("valid");
    let (mut lost, mut gaps) = (0, 0);
    for n in 0..1024 {
        finished(whole.push_acceleration(zigzag(n), EVER));
        if (100..800).contains(&n) && [1, 2, 3].contains(&(n % 8)) {
            finished(gappy.push_missing(1, EVER));
            lost += 1;
            gaps += u32::from(n % 8 == 1);
        } else {
            finished(gappy.push_acceleration(zigzag(n), EVER));
        }
    }
    assert_eq!(gappy.harvester_state(), whole.harvester_state());
    let [gappy, whole] = [gappy, whole].map(|estimator| estimator.estimate());
    assert_eq!(gappy.energy, whole.energy);
    assert_eq!(gappy.uncertainty.missing_samples, lost);
    assert_eq!(gappy.uncertainty.unknown_seconds, 0.0);
    // Each gap makes one interval more than samples.
    assert_eq!(gappy.uncertainty.uncertain_seconds, f64::from(lost + gaps) / 256.0);
    assert_eq!(whole.uncertainty.uncertain_seconds, 0.0);
    let relative = |estimate: Estimate<f64>| estimate.uncertainty.relative.expect("known");
    let added = relative(gappy) - relative(whole);
    let uncertain = f64::from(lost + gaps);
    assert!((added - uncertain / (1022.0 - 0.5 * uncertain)).abs() < 1e-12, "{added}");
}

#[test]
fn a_long_gap_is_unknown_and_the_harvester_starts_anew() {
    let samples = sine_samples::<f64>(1.962, 20.0, 256.0, 1000);
    let harvester = hybrid(contact::<f64>(), TrBdf2, adaptive(1e-2));
    let settled = Settings { settling_seconds: 0.5, ..settings(256.0) };
    let mut estimator = Estimator::new(harvester, settled).expect("valid");
    let before = follow(&mut estimator, &samples[..500]);
    assert_eq!(before.uncertainty.uncertain_seconds, 0.5);
    // Samples 500 to 599 are lost: with the last before them its interval is integrated at once.
    finished(estimator.push_missing(4, EVER));
    assert_eq!(estimator.known_until(), Instant::from_ticks(498 << 30));
    finished(estimator.push_missing(96, EVER));
    assert_eq!(estimator.known_until(), Instant::from_ticks(499 << 30));
    let inside = estimator.estimate();
    assert_eq!((inside.seconds, inside.uncertainty.unknown_seconds), (499.0 / 256.0, 100.0 / 256.0));
    let energy_before = inside.energy;
    let after = follow(&mut estimator, &samples[600..]);
    assert_eq!(estimator.known_until(), Instant::from_ticks(998 << 30));
    assert_eq!(after.uncertainty.missing_samples, 100);
    assert_eq!(after.uncertainty.unknown_seconds, 101.0 / 256.0);
    // Three decay times, 4.7 s, are longer than what follows the gap.
    assert_eq!(after.uncertainty.uncertain_seconds, 0.5 + 398.0 / 256.0);
    assert_eq!(after.seconds, 897.0 / 256.0);
    // After the gap everything is as in a run that begins there; on a binary grid to the bit.
    let mut fresh = Estimator::new(harvester, settled).expect("valid");
    let anew = follow(&mut fresh, &samples[600..]);
    let mut moved = *fresh.harvester_state();
    moved.clock = Instant::from_ticks(moved.clock.ticks() + (600 << 30));
    assert_eq!(*estimator.harvester_state(), moved);
    assert!((after.energy - energy_before - anew.energy).abs() < 1e-15 * after.energy);
    assert!(after.uncertainty.relative.expect("known") > (1.0 + 101.0 / 256.0) / (998.0 / 256.0));
}

#[test]
fn saturated_samples_are_cut_off_counted_and_uncertain() {
    let harvester = hybrid(contact::<f64>(), TrBdf2, adaptive(1e-2));
    let limited = Settings { format: SampleFormat::accelerations(1.5, 0.0), ..settings(256.0) };
    let mut estimator = Estimator::new(harvester, limited).expect("valid");
    let mut clipped = Estimator::new(harvester, settings(256.0)).expect("valid");
    let samples = sine_samples::<f64>(1.962, 20.0, 256.0, 700);
    let estimate = follow(&mut estimator, &samples);
    let limits: Vec<f64> = samples.iter().map(|a| a.clamp(-1.5, 1.5)).collect();
    assert_eq!(estimate.energy, follow(&mut clipped, &limits).energy);
    let saturated = |n: usize| samples[n].abs() >= 1.5;
    let count = (0..700).filter(|&n| saturated(n)).count();
    assert_eq!(estimate.uncertainty.saturated_samples as usize, count);
    let intervals = (0..698).filter(|&n| saturated(n) || saturated(n + 1)).count();
    assert_eq!(estimate.uncertainty.uncertain_seconds, intervals as f64 / 256.0);
    assert!(count > 200 && intervals < 690, "{count} {intervals}");
}

#[test]
fn sequence_numbers_find_what_was_lost() {
    let samples = sine_samples::<f32>(1.962, 20.0, 400.0, 900);
    let harvester = hybrid(contact::<f32>(), TrBdf2, adaptive(5e-2));
    let mut numbered = Estimator::new(harvester, settings(400.0)).expect("valid");
    let mut told = Estimator::new(harvester, settings(400.0)).expect("valid");
    // Starts near the end of the numbers, so that they wrap.
    let first = u32::MAX - 100;
    for (n, &sample) in (0_u32..).zip(&samples) {
        let lost = [50, 51, 120, 300, 301, 302, 303, 304, 305].contains(&n);
        if lost {
            finished(told.push_missing(1, EVER));
        } else {
            finished(told.push_acceleration(sample, EVER));
            let number = first.wrapping_add(n);
            let sample = if n == 400 { Sample::Good(f32::NAN) } else { Sample::Good(sample) };
            finished(numbered.push_at(number, sample, EVER));
        }
        if n == 400 {
            // A value that is none is lost as well.
            assert_eq!(numbered.estimate().uncertainty.missing_samples, 10);
            let again = numbered.push_at(first.wrapping_add(n), Sample::Good(0.0), EVER);
            let expected = first.wrapping_add(401);
            assert_eq!(again, Err(EstimatorError::OutOfOrder { expected, given: first.wrapping_add(400) }));
            break;
        }
    }
    // Up to there they are one.
    let [numbered, told] = [numbered, told].map(|estimator| estimator.estimate());
    assert_eq!(told.uncertainty.missing_samples, 9);
    assert_eq!(numbered.uncertainty.unknown_seconds, told.uncertainty.unknown_seconds);
    assert!((told.uncertainty.unknown_seconds - 7.0 / 400.0).abs() < 1e-6);
    assert!(numbered.seconds < told.seconds);
}

#[test]
fn every_interval_is_integrated_or_unknown() {
    let harvester = hybrid(contact::<f64>(), TrBdf2, adaptive(5e-2));
    let mut random = Random(11);
    for _ in 0..40 {
        let mut estimator = Estimator::new(harvester, settings(256.0)).expect("valid");
        let length = 20 + (random.next() % 200) as u32;
        let (mut first, mut missing) = (None, 0);
        let mut n = 0;
        while n < length {
            let choice = random.next() % 20;
            let sample = 2.0 * (f64::from(n) * 0.49).sin();
            if choice == 0 {
                let count = (random.next() % 12) as u32;
                finished(estimator.push_missing(count, EVER));
                (n, missing) = (n + count, missing + count);
                continue;
            }
            finished(
                estimator
                    .push(if choice == 1 { Sample::Saturated(sample) } else { Sample::Good(sample) }, EVER),
            );
            first = first.or(Some(n));
            n += 1;
        }
        // Two more samples, so that all up to here is known.
        for _ in 0..2 {
            finished(estimator.push(Sample::Good(0.0), EVER));
        }
        let estimate = estimator.estimate();
        assert_eq!(estimate.uncertainty.missing_samples, missing);
        let first = first.expect("a good sample");
        // Before the first sample nothing runs, and what is missing there is unknown.
        let all = f64::from(n) / 256.0;
        let sum = estimate.seconds + estimate.uncertainty.unknown_seconds;
        assert!((sum - all).abs() < 1e-12, "{sum} of {all}");
        assert_eq!(estimator.known_until(), Instant::from_ticks(u64::from(n - first) << 30));
        assert!(estimate.uncertainty.uncertain_seconds <= estimate.seconds + 1e-12);
    }
}

#[test]
fn a_step_that_cannot_be_taken_is_an_error_once() {
    let mut parameters = sliding_parameters::<f64>();
    parameters.choices.friction =
        PatchFriction { static_active: 0.0, static_inert: 0.0, kinetic_active: 0.0, kinetic_inert: 0.0 };
    let scene = parameters.build().expect("in bounds");
    let harvester = hybrid(scene, TrBdf2, adaptive(1e-2));
    let mut estimator = Estimator::new(harvester, settings(256.0)).expect("valid");
    let samples = sine_samples::<f64>(0.5, 17.0, 256.0, 600);
    let before = follow(&mut estimator, &samples[..300]);
    // A shock that takes the slider off its patch.
    let mut errors = 0;
    for (n, &sample) in samples.iter().enumerate().skip(300) {
        let sample = if n == 300 { 1e4 } else { sample };
        match estimator.push_acceleration(sample, EVER) {
            Ok(progress) => assert!(progress.finished),
            Err(EstimatorError::Step(error)) => {
                assert!(matches!(error.failure, StepFailure::OutsideDomain { .. }));
                errors += 1;
            }
            Err(other) => panic!("{other}"),
        }
    }
    let estimate = estimator.estimate();
    assert_eq!(errors, 1);
    let unknown = estimate.uncertainty.unknown_seconds * 256.0;
    assert_eq!(unknown, 3.0);
    assert_eq!(estimator.known_until(), Instant::from_ticks(598 << 30));
    assert!(estimate.seconds > before.seconds + 290.0 / 256.0 && estimate.energy > before.energy);
}

#[test]
fn clearing_begins_a_new_account_and_leaves_the_motion() {
    let samples = sine_samples::<f64>(1.962, 20.0, 256.0, 1200);
    let harvester = hybrid(contact::<f64>(), TrBdf2, adaptive(1e-2));
    let mut estimator = Estimator::new(harvester, settings(256.0)).expect("valid");
    let mut whole = estimator;
    let first = follow(&mut estimator, &samples[..600]);
    estimator.clear();
    assert_eq!((estimator.estimate().energy, estimator.estimate().seconds), (0.0, 0.0));
    let second = follow(&mut estimator, &samples[600..]);
    let both = follow(&mut whole, &samples);
    assert_eq!(estimator.harvester_state(), whole.harvester_state());
    assert_eq!(first.seconds + second.seconds, both.seconds);
    assert!((first.energy + second.energy - both.energy).abs() < 1e-14 * both.energy);
}

#[test]
fn settings_out_of_bounds_are_named() {
    let harvester = hybrid(contact::<f64>(), TrBdf2, adaptive(1e-2));
    let refused = |settings: Settings<f64>| match Estimator::new(harvester, settings) {
        Err(EstimatorError::Parameter(error)) => Some(error.field),
        _ => None,
    };
    assert_eq!(refused(settings(400.0)), None);
    for rate in [0.0, -1.0, f64::NAN, 1e7, f64::INFINITY] {
        assert_eq!(refused(settings(rate)), Some("rate"));
    }
    assert_eq!(refused(Settings { settling_seconds: -1.0, ..settings(400.0) }), Some("settling_seconds"));
    let format = SampleFormat::counts(0.0, 1);
    assert_eq!(refused(Settings { format, ..settings(400.0) }), Some("magnitude of scale"));
}
