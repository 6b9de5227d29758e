//! Bump-stop with checks of its steps: the bits of the run, of the checks, and the statement.

mod calibration;

use crate::bridged::{AnyBridge, baseline, resistor, storage, vibration};
use crate::common::Random;
use crate::common::harvesters::{bump_parameters, sine_samples};
use crate::estimator::{follow, settings};
use core::fmt::Debug;
use model_core::clock::{Instant, TICKS_PER_SECOND};
use model_core::energy::PowerMeter;
use model_core::excitation::{Silence, Stream};
use model_core::hybrid::Ended;
use model_core::part::load::AnyLoad;
use model_core::scalar::Scalar;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{
    AnyChoices, AnyContact, Circuit, Parts, Resistive, Restitution, StepDoubling, Stepper,
};
use model_core::snapshot::{self, SnapshotError};

const EVER: u32 = u32::MAX;

fn contacts<S: Scalar>() -> [AnyContact<S>; 4] {
    [
        AnyContact::ResidualFlexibility,
        AnyContact::DisplacementConstraint,
        AnyContact::Restitution(Restitution { coefficient: S::from_f64(0.7) }),
        AnyContact::NoStop,
    ]
}

fn stepper<S: Scalar, L: Circuit<S> + Copy>(
    load: L,
    contact: AnyContact<S>,
) -> Stepper<S, AnyChoices<S, L>, 4, 1>
where
    AnyChoices<S, L>: Parts<S>,
{
    let mut parameters = baseline(load);
    parameters.choices.stop.contact = contact;
    Stepper::new(parameters.build().expect("in bounds"), S::from_f64(13e-6), S::from_f64(180e-6))
        .expect("in bounds")
}

fn resistive<S: Scalar>() -> Resistive<AnyLoad<S>> {
    Resistive(AnyLoad { resistance: S::from_f64(1e6) })
}

fn bridge<S: Scalar>() -> AnyBridge<S> {
    storage(0.2e-6, 0.2, resistor(2e6), 0.05)
}

/// Runs a stepper bare and with checks to the same instants, in pieces of random length and with random budgets; the checks
/// of two runs in different pieces are the same. `checks` is whether the contact law allows them.
fn same_bits<S: Scalar, P: Parts<S> + Copy, const ALL: usize>(stepper: Stepper<S, P, 4, 1, ALL>, checks: bool)
where
    Stepper<S, P, 4, 1, ALL>: Copy + Debug,
{
    let excitation = vibration::<S>(220.0);
    let checked = StepDoubling::new(stepper, 3);
    let mut random = Random(11);
    let mut bare = stepper.start(&Default::default(), &excitation).expect("starts");
    let mut states = [checked.start(&Default::default(), &excitation).expect("starts"); 2];
    let mut meters = [PowerMeter::<S>::new(); 3];
    let [alone, meters @ ..] = &mut meters;
    let mut until = 0;
    for _ in 0..40 {
        until += (random.between_logarithmic(1e-6, 0.2) * TICKS_PER_SECOND as f64) as u64;
        let until = Instant::from_ticks(until);
        stepper.advance(&mut bare, &excitation, until, EVER, alone).expect("runs");
        for (number, (state, meter)) in states.iter_mut().zip(meters.iter_mut()).enumerate() {
            loop {
                let budget = if number == 0 { EVER } else { random.next() as u32 % 2000 };
                let advance = checked.advance(state, &excitation, until, budget, meter).expect("runs");
                assert!(
                    number == 0
                        || advance.work.attempts()
                            <= budget.max(StepDoubling::<S, P, 4, 1, ALL>::LEAST_BUDGET)
                );
                if advance.ended == Ended::Finished {
                    break;
                }
            }
            assert_eq!((state.run(), meter.delivered_energy()), (&bare, alone.delivered_energy()));
        }
        assert_eq!(states[0], states[1]);
    }
    let is_checked = checked.checks(&states[0]).count() > 2;
    assert_eq!(is_checked, checks, "{:?}", checked.checks(&states[0]));
    // In the samples of a stream.
    let samples = sine_samples::<S>(20.0, 220.0, 3520.0, 4000);
    let mut stream = Stream::new(S::from_f64(3520.0), samples[0]).expect("valid");
    let mut bare = stepper.start(&Default::default(), &stream).expect("starts");
    let mut state = checked.start(&Default::default(), &stream).expect("starts");
    for &sample in &samples[1..] {
        stream.push(sample).expect("finite");
        let (until, ticks) = (stream.known_until(), TICKS_PER_SECOND / 3520);
        stepper.advance_past(&mut bare, &stream, until, ticks, EVER, &mut ()).expect("runs");
        checked.advance_past(&mut state, &stream, until, ticks, EVER, &mut ()).expect("runs");
        assert_eq!(state.run(), &bare);
    }
    assert_eq!(checked.checks(&state).count() > 2, checks);
}

#[test]
fn checks_do_not_change_the_bits_of_a_run_and_do_not_depend_on_its_pieces() {
    for (single, double) in contacts::<f32>().into_iter().zip(contacts::<f64>()) {
        let checks = !matches!(single, AnyContact::Restitution(_));
        same_bits(stepper::<f32, _>(resistive(), single), checks);
        same_bits(stepper::<f32, _>(bridge(), single), checks);
        same_bits(stepper::<f64, _>(bridge(), double), checks);
    }
    let scene = bump_parameters::<f64>().build().expect("in bounds");
    same_bits(Stepper::with_all_powers(scene, 13e-6, 180e-6).expect("in bounds"), true);
}

#[test]
fn at_rest_the_statement_is_zero() {
    let checked = StepDoubling::new(stepper::<f32, _>(resistive(), AnyContact::ResidualFlexibility), 4);
    let mut state = checked.start(&Default::default(), &Silence).expect("starts");
    assert_eq!(checked.step_doubling_error(&state), None);
    let until = Instant::from_whole_seconds(1);
    checked.advance(&mut state, &Silence, until, EVER, &mut ()).expect("runs");
    let error = checked.step_doubling_error(&state).expect("checked");
    assert_eq!((error.relative, error.irregular), (0.0, 0.0));
}

#[test]
fn the_error_of_a_linear_motion_is_stated() {
    let excitation = vibration::<f64>(235.0);
    let scene = *stepper::<f64, _>(resistive(), AnyContact::NoStop).scene();
    let until = Instant::from_whole_seconds(2);
    let run = |short: f64, long: f64| {
        let checked = StepDoubling::new(Stepper::new(scene, short, long).expect("in bounds"), 4);
        let mut state = checked.start(&Default::default(), &excitation).expect("starts");
        let mut meter = PowerMeter::<f64>::new();
        checked.advance(&mut state, &excitation, until, EVER, &mut meter).expect("runs");
        (meter.mean_power(), checked.step_doubling_error(&state).expect("checked"))
    };
    let (truth, _) = run(1e-6, 1e-5);
    for long in [90e-6, 180e-6, 360e-6] {
        let (power, stated) = run(13e-6, long);
        let error = (power / truth - 1.0).abs();
        println!("{long:e} s: error {error:.2e}, stated {:.2e}", stated.relative);
        assert!(error > 1e-7 && stated.relative > error && stated.relative < 6.0 * error);
        assert_eq!(stated.irregular, 0.0);
        // Steps chosen by the estimate hold what was asked for.
        let tolerance = 0.3 * stated.relative;
        let factor = stated.step_factor(tolerance);
        let (power, _) = run(13e-6 * factor, long * factor);
        assert!(factor < 1.0 && (power / truth - 1.0).abs() < tolerance);
    }
}

#[test]
fn a_run_with_checks_resumes_from_its_image() {
    fn resumes<S: Scalar, L: Circuit<S> + Copy + Debug>(load: L)
    where
        AnyChoices<S, L>: Parts<S>,
    {
        let harvester = StepDoubling::new(stepper::<S, L>(load, AnyContact::ResidualFlexibility), 2);
        let other = StepDoubling::new(*harvester.stepper(), 3);
        let excitation = vibration::<S>(220.0);
        let mut state = harvester.start(&Default::default(), &excitation).expect("starts");
        let mut image = [0; 2048];
        for piece in 1..200_u64 {
            // Checks run in half of the pieces.
            let until = Instant::from_ticks(piece * TICKS_PER_SECOND / 500);
            harvester.advance(&mut state, &excitation, until, EVER, &mut ()).expect("runs");
            snapshot::save(&state, harvester.fingerprint(), &mut image).expect("room");
            let awake = snapshot::restore(harvester.fingerprint(), &image).expect("its own image");
            assert_eq!(state, awake);
            let refused = snapshot::restore::<<StepDoubling<S, AnyChoices<S, L>, 4, 1> as Harvester<S>>::State>(
                other.fingerprint(),
                &image,
            );
            assert!(matches!(refused, Err(SnapshotError::ForeignModel)), "{refused:?}");
            state = awake;
        }
    }
    resumes::<f32, _>(resistive());
    resumes::<f64, _>(bridge());
}
