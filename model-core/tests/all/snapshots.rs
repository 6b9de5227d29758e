//! Power-down and wake-up: a snapshot resumes with the same bits, and any other content of the flash is refused.

use crate::common::harvesters::{
    ContactChoices, bump, bump_parameters, contact, contact_parameters, sine_samples, slide,
    sliding_parameters,
};
use crate::common::{Random, adaptive, finished, fixed};
use model_core::energy::estimator::{Sample, SampleFormat, Settings};
use model_core::energy::{
    Budget, BudgetParameters, Capacitor, Estimator, IncomeParameters, PowerMeter, StorageParameters,
};
use model_core::excitation::{LineBank, Sine, Stream};
use model_core::hybrid::Driver;
use model_core::integrate::{AnyStepControl, RungeKutta4, TrBdf2};
use model_core::part::restitution::{AnyRestitution, ConstantRestitution};
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::{self, AnyContact, AnyCoupling, Restitution, Stepper};
use model_core::scene::{Harvester, Simulation, contact_separation, sliding};
use model_core::snapshot::{self, Reader, Snapshot, SnapshotError, Writer};

const EVER: u32 = u32::MAX;

fn settings<S: Scalar>(rate: f64) -> Settings<S> {
    Settings {
        format: SampleFormat::accelerations(S::from_f64(60.0), S::ZERO),
        longest_gap: 3,
        settling_seconds: S::from_f64(0.1),
        ..crate::estimator::settings(rate)
    }
}

fn hybrid<S: Scalar, A>(scene: A, tolerance: f64) -> Simulation<A, TrBdf2, AnyStepControl<S>, 3, 1> {
    Simulation::new(scene, TrBdf2, adaptive(tolerance))
}

/// Samples with gaps of both kinds and shocks beyond the range, the same on every machine.
fn rough<S: Scalar>(samples: &[S], seed: u64) -> Vec<Sample<S>> {
    let mut random = Random(seed);
    let mut lost = 0;
    let rough = |&sample: &S| {
        let choice = random.next() % 200;
        if lost == 0 && choice < 3 {
            lost = [1, 2, 8][choice as usize];
        }
        if lost > 0 {
            lost -= 1;
            return Sample::Missing;
        }
        if choice == 3 { Sample::Saturated(S::from_f64(60.0)) } else { Sample::Good(sample) }
    };
    samples.iter().map(rough).collect()
}

/// Follows the samples with small budgets; every few of them, in the middle of one too, the estimator is saved,
/// and its twin goes on from the snapshot. Gives how many snapshots were made, and of which states.
fn resume_from_images<S: Scalar, H: Harvester<S> + Copy + PartialEq + core::fmt::Debug>(
    harvester: H,
    settings: Settings<S>,
    samples: &[Sample<S>],
) -> Vec<H::State> {
    let mut uninterrupted = Estimator::new(harvester, settings).expect("valid");
    let mut interrupted = uninterrupted;
    let mut random = Random(3);
    let mut states = Vec::new();
    let mut in_the_middle = 0;
    for &sample in samples {
        let mut flash = [0xff; 1024];
        let mut progress = uninterrupted.push(sample, 1).expect("runs");
        let mut same = interrupted.push(sample, 1).expect("runs");
        loop {
            assert_eq!(progress, same);
            if random.next().is_multiple_of(4) {
                let used = interrupted.save(&mut flash).expect("room");
                assert_eq!(used, Estimator::<S, H>::SNAPSHOT_BYTES);
                interrupted = Estimator::new(harvester, settings).expect("valid");
                interrupted.restore(&flash).expect("its own snapshot");
                assert_eq!(interrupted, uninterrupted);
                states.push(*interrupted.harvester_state());
                in_the_middle += u32::from(!progress.finished);
            }
            if progress.finished {
                break;
            }
            progress = uninterrupted.resume(1).expect("runs");
            same = interrupted.resume(1).expect("runs");
        }
    }
    assert_eq!(interrupted.estimate(), uninterrupted.estimate());
    assert!(in_the_middle > 10, "{in_the_middle}");
    let uncertainty = interrupted.estimate().uncertainty;
    assert!(uncertainty.missing_samples > 8 && uncertainty.unknown_seconds > S::ZERO);
    states
}

fn resume_contact_separation<S: Scalar>() {
    let mut parameters = contact_parameters::<S>();
    // Heavily charged and not rebounding: the mass sticks now and then.
    parameters.charge_density = S::from_f64(120e-6);
    parameters.choices.restitution = AnyRestitution::Constant(ConstantRestitution { coefficient: S::ZERO });
    let harvester = hybrid(parameters.build().expect("in bounds"), 1e-3);
    let samples = rough(&sine_samples::<S>(30.0, 15.0, 400.0, 800), 1);
    let states = resume_from_images(harvester, settings(400.0), &samples);
    let stuck = states.iter().filter(|state| state.mode == contact_separation::Mode::Stick).count();
    assert!(stuck > 10 && stuck + 10 < states.len(), "{stuck} of {}", states.len());
}

fn resume_sliding<S: Scalar>() {
    let harvester = hybrid(slide::<S>(), 1e-3);
    let samples = rough(&sine_samples::<S>(3.0, 6.0, 400.0, 800), 2);
    let states = resume_from_images(harvester, settings(400.0), &samples);
    let stuck = states.iter().filter(|state| state.mode == sliding::Mode::Stick).count();
    assert!(stuck > 10 && stuck + 10 < states.len(), "{stuck} of {}", states.len());
    // Every mode has been in a snapshot.
    for forward in [false, true] {
        for ahead in [false, true] {
            let mode = sliding::Mode::Sliding { forward, ahead };
            assert!(states.iter().any(|state| state.mode == mode), "{mode:?}");
        }
    }
}

fn resume_bump_stop<S: Scalar>(contact: AnyContact<S>) {
    let samples = rough(&sine_samples::<S>(20.0, 220.0, 800.0, 300), 3);
    let states = resume_from_images(bump::<S, 4, 1>(contact), settings(800.0), &samples);
    let touching = states.iter().filter(|state| state.gap() >= S::ZERO).count();
    assert!(states.len() > 100);
    assert!(touching > 3 || !matches!(contact, AnyContact::ResidualFlexibility), "{touching}");
}

#[test]
fn a_run_goes_on_from_its_image_with_the_same_bits() {
    resume_contact_separation::<f32>();
    resume_contact_separation::<f64>();
    resume_sliding::<f32>();
    resume_sliding::<f64>();
    resume_bump_stop::<f32>(AnyContact::ResidualFlexibility);
    resume_bump_stop::<f64>(AnyContact::ResidualFlexibility);
    resume_bump_stop::<f32>(AnyContact::Restitution(Restitution { coefficient: 0.5 }));
    resume_bump_stop::<f64>(AnyContact::NoStop);
}

/// An estimator in the middle of a run, and its snapshot.
fn saved<S: Scalar, H: Harvester<S> + Copy>(
    harvester: H,
    settings: Settings<S>,
) -> (Estimator<S, H>, Vec<u8>) {
    let mut estimator = Estimator::new(harvester, settings).expect("valid");
    for sample in rough(&sine_samples::<S>(20.0, 20.0, 400.0, 120), 4) {
        finished(estimator.push(sample, EVER));
    }
    let mut bytes = vec![0; Estimator::<S, H>::SNAPSHOT_BYTES];
    assert_eq!(estimator.save(&mut bytes), Ok(bytes.len()));
    (estimator, bytes)
}

fn every_flip_and_cut_is_refused<S: Scalar, H>(harvester: H)
where
    H: Harvester<S> + Copy + PartialEq + core::fmt::Debug,
{
    let (estimator, bytes) = saved(harvester, settings(400.0));
    let mut awake = estimator;
    for bit in 0..bytes.len() * 8 {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(awake.restore(&flipped).is_err(), "bit {bit}");
    }
    for length in 0..bytes.len() {
        let needed = bytes.len();
        assert_eq!(awake.restore(&bytes[..length]), Err(SnapshotError::TooShort { needed, given: length }));
        let mut room = vec![0; length];
        assert_eq!(awake.save(&mut room), Err(SnapshotError::NoRoom { needed, given: length }));
    }
    // What was refused has changed nothing.
    assert_eq!(awake, estimator);
    assert_eq!(awake.restore(&bytes), Ok(()));
}

#[test]
fn every_flipped_bit_and_every_cut_is_refused() {
    every_flip_and_cut_is_refused::<f32, _>(hybrid(contact(), 1e-2));
    every_flip_and_cut_is_refused::<f64, _>(hybrid(slide(), 1e-2));
    every_flip_and_cut_is_refused::<f32, _>(bump::<f32, 4, 1>(AnyContact::ResidualFlexibility));
}

/// Asserts that an estimator of this harvester and settings does not take the snapshot.
#[track_caller]
fn assert_foreign<S: Scalar, H: Harvester<S>>(
    harvester: H,
    settings: Settings<S>,
    bytes: &[u8],
    change: usize,
) {
    let taken = Estimator::new(harvester, settings).expect("valid").restore(bytes);
    assert_eq!(taken, Err(SnapshotError::ForeignModel), "change {change}");
}

/// A change of one parameter.
type Change<P> = fn(&mut P);

/// Asserts that each change of the parameters makes a harvester that does not take the snapshot of the one without a change.
fn each_is_foreign<S: Scalar, P, H: Harvester<S> + Copy>(
    parameters: fn() -> P,
    built: fn(P) -> H,
    changes: &[Change<P>],
) {
    let (mut estimator, bytes) = saved(built(parameters()), settings(400.0));
    assert_eq!(estimator.restore(&bytes), Ok(()));
    for (index, change) in changes.iter().enumerate() {
        let mut parameters = parameters();
        change(&mut parameters);
        assert_foreign(built(parameters), settings(400.0), &bytes, index);
    }
}

#[test]
fn an_image_of_other_parameters_is_foreign() {
    let changes: [Change<contact_separation::Parameters<f32, ContactChoices<f32>>>; 13] = [
        |p| p.mass *= 1.000_001,
        |p| p.stiffness = 80.001,
        |p| p.damping_ratio = 0.006,
        |p| p.initial_gap = 3.1e-3,
        |p| p.electrode_area = 4.1e-4,
        |p| p.dielectric_thickness = 5.1e-5,
        |p| p.relative_permittivity = 2.1,
        |p| p.charge_density = 51e-6,
        |p| p.choices.parasitic.capacitance = 2e-12,
        |p| p.choices.load.resistance = 0.0,
        |p| p.choices.force_law = contact_separation::AnyForceLaw::GapField,
        |p| p.choices.restitution = AnyRestitution::Constant(ConstantRestitution { coefficient: 0.8 }),
        |p| p.choices.sticking = contact_separation::StickCharge::Relaxing,
    ];
    each_is_foreign(contact_parameters, |p| hybrid(p.build().expect("in bounds"), 1e-2), &changes);

    let changes: [Change<sliding::Parameters<f64, sliding::AnyChoices<f64>>>; 15] = [
        |p| p.beam_length = 0.101,
        |p| p.beam_width = 0.021,
        |p| p.beam_thickness = 5.01e-4,
        |p| p.damping_ratio = 0.0036,
        |p| p.slider_mass = 8.1e-3,
        |p| p.patch_radius = 0.0101,
        |p| p.dielectric_thickness = 5.1e-5,
        |p| p.relative_permittivity = 2.1,
        |p| p.charge_density = 81e-6,
        |p| p.choices.load.resistance = f64::INFINITY,
        |p| p.choices.friction.static_inert = 0.26,
        |p| p.choices.friction.kinetic_active = 0.31,
        |p| p.choices.force_law = sliding::AnyForceLaw::GapField,
        |p| p.choices.sticking = sliding::StickCharge::Relaxing,
        |p| p.choices.lateral_force = sliding::AnyLateralForce::Field,
    ];
    each_is_foreign(sliding_parameters, |p| hybrid(p.build().expect("in bounds"), 1e-2), &changes);

    let changes: [Change<bump_stop::Parameters<f32, bump_stop::AnyChoices<f32>>>; 10] = [
        |p| p.beam_length = 0.0501,
        |p| p.piezo_d31 = -191e-12,
        |p| p.choices.transducer = Some(bump_stop::Bimorph::Series),
        |p| p.piezo_permittivity = 16e-9,
        |p| p.damping_ratio = 0.011,
        |p| p.choices.stop.gap = 11e-6,
        |p| p.choices.stop.contact_compliance = 1e-9,
        |p| p.choices.load.0.resistance = 2e6,
        |p| p.choices.coupling = AnyCoupling::OneWay,
        |p| p.choices.stop.contact = AnyContact::DisplacementConstraint,
    ];
    let built = |p: bump_stop::Parameters<f32, _>| {
        Stepper::<_, _, 4, 1>::new(p.build().expect("in bounds"), 9e-6, 80e-6).expect("in bounds")
    };
    each_is_foreign(bump_parameters, built, &changes);
}

#[test]
fn an_image_of_another_scene_precision_method_or_rate_is_foreign() {
    let (usual, usual_in_double) = (settings::<f32>(400.0), settings::<f64>(400.0));
    let harvester = hybrid(contact::<f32>(), 1e-2);
    let (_, bytes) = saved(harvester, usual);
    assert_foreign(hybrid(slide::<f32>(), 1e-2), usual, &bytes, 0);
    assert_foreign(hybrid(contact::<f64>(), 1e-2), usual_in_double, &bytes, 1);
    assert_foreign(hybrid(contact::<f32>(), 1.1e-2), usual, &bytes, 2);
    let (_, accurate) = saved(hybrid(contact::<f32>(), 1e-5), usual);
    assert_foreign(hybrid(contact::<f32>(), 1.1e-5), usual, &accurate, 3);
    let fixed = fixed(1e-3);
    assert_foreign(Simulation::<_, _, _, 3, 1>::new(contact::<f32>(), TrBdf2, fixed), usual, &bytes, 4);
    assert_foreign(harvester, settings(401.0), &bytes, 5);
    assert_foreign(harvester, Settings { longest_gap: 2, ..usual }, &bytes, 6);

    let explicit = Simulation::<_, _, _, 3, 1>::new(slide::<f32>(), RungeKutta4, fixed);
    let (_, bytes) = saved(explicit, usual);
    assert_foreign(Simulation::<_, _, _, 3, 1>::new(slide::<f32>(), TrBdf2, fixed), usual, &bytes, 7);

    let stepper = bump::<f32, 4, 1>(AnyContact::ResidualFlexibility);
    let (_, bytes) = saved(stepper, usual);
    // The same number of modes in all, and so of bytes.
    assert_foreign(bump::<f32, 3, 2>(AnyContact::ResidualFlexibility), usual, &bytes, 8);
    let longer = Stepper::<_, _, 4, 1>::new(*stepper.scene(), 9e-6, 81e-6).expect("in bounds");
    assert_foreign(longer, usual, &bytes, 9);
}

/// One value into a snapshot and back.
fn round_trip<T: Snapshot + PartialEq + core::fmt::Debug>(value: &T) {
    let mut bytes = vec![0; snapshot::size_of::<T>()];
    assert_eq!(snapshot::save(value, 7, &mut bytes), Ok(bytes.len()));
    assert_eq!(&snapshot::restore::<T>(7, &bytes).expect("sound"), value);
    assert_eq!(snapshot::restore::<T>(8, &bytes), Err(SnapshotError::ForeignModel));
}

#[test]
fn states_meters_and_streams_have_images_of_their_own() {
    let sine = Sine::<f32>::new(1.962, 20.0, 0.0).expect("valid");
    let scene = contact::<f32>();
    let driver = Driver::new(TrBdf2, adaptive(1e-2));
    let mut state = scene.start::<_, _, 1>(&Default::default(), &sine, &driver.control).expect("starts");
    let mut meter = PowerMeter::<f32>::new();
    let until = model_core::clock::Instant::from_whole_seconds(1);
    driver.advance(&scene, &mut state, &sine, until, EVER, &mut meter).expect("runs");
    round_trip(&state);
    round_trip(&meter);
    let mut stream = Stream::<f64>::new(400.0, 0.5).expect("valid");
    round_trip(&stream);
    stream.push(-1.0).expect("finite");
    stream.restart(5, 2.0).expect("finite");
    round_trip(&stream);
}

const BUDGET: BudgetParameters<f32> = BudgetParameters {
    storage: StorageParameters {
        capacitor: Capacitor { capacitance: 220e-6, leakage_resistance: 10e6 },
        charging_efficiency: 0.8,
        discharging_efficiency: 0.9,
        highest_voltage: 4.5,
        lock_out_voltage: 1.8,
        turn_on_voltage: 2.4,
    },
    income: IncomeParameters { time_constant: 7200.0, day_weight: 0.5 },
    standing_power: 1e-6,
};

fn budget<const SLOTS: usize>(change: Change<BudgetParameters<f32>>) -> Budget<f32, SLOTS> {
    let mut parameters = BUDGET;
    change(&mut parameters);
    parameters.build().expect("in bounds")
}

fn bank(rate: f32, unit: f32) -> LineBank<32, 8> {
    LineBank::new(rate, 20.0, 0.5, unit).expect("in bounds")
}

#[test]
fn an_image_of_budget_and_bank_comes_back_and_is_foreign_to_those_with_another_number() {
    let (own, lines) = (budget::<24>(|_| ()), bank(200.0, 1e-3));
    let mut states = (own.start(9 * 3600 + 17), lines.start());
    own.correct_by_voltage(&mut states.0, 3.0, 2e-3);
    own.spend(&mut states.0, 4e-5);
    for minute in 0..90_u8 {
        own.update(&mut states.0, 60, 1e-5 * f32::from(minute), 1e-6);
    }
    lines.take(&mut states.1, &[1000, -200, 30]);
    let mut bytes = [0; 2048];
    let size = snapshot::save_image(&(&own, &lines), &states, 7, &mut bytes).expect("room");
    let mut awake = (own.start(0), lines.start());
    assert_eq!(snapshot::read_image(&(&own, &lines), &bytes[..size], &mut awake), Ok(7));
    assert_eq!(awake, states);
    for byte in 0..size {
        let mut damaged = bytes;
        damaged[byte] ^= 0x10;
        assert!(snapshot::read_image(&(&own, &lines), &damaged[..size], &mut awake).is_err(), "byte {byte}");
    }
    let foreign = Some(SnapshotError::ForeignModel);
    let changes: [Change<BudgetParameters<f32>>; 10] = [
        |p| p.storage.capacitor.capacitance = 221e-6,
        |p| p.storage.capacitor.leakage_resistance = f32::INFINITY,
        |p| p.storage.charging_efficiency = 0.81,
        |p| p.storage.discharging_efficiency = 0.91,
        |p| p.storage.highest_voltage = 4.51,
        |p| p.storage.lock_out_voltage = 1.81,
        |p| p.storage.turn_on_voltage = 2.41,
        |p| p.income.time_constant = 7201.0,
        |p| p.income.day_weight = 0.51,
        |p| p.standing_power = 1.01e-6,
    ];
    for (index, change) in changes.into_iter().enumerate() {
        let refused = snapshot::newest_image(&(&budget::<24>(change), &lines), [&bytes, &bytes]).err();
        assert_eq!(refused, foreign, "change {index}");
    }
    for other in [bank(201.0, 1e-3), bank(200.0, 1.1e-3)] {
        assert_eq!(snapshot::newest_image(&(&own, &other), [&bytes, &bytes]).err(), foreign);
    }
    // The number of slots of the day is a part of the fingerprint, which stands before the states.
    let [mut hours, mut half_hours] = [[0; 2048]; 2];
    let finer = budget::<48>(|_| ());
    snapshot::save_image(&own, &own.start(0), 0, &mut hours).expect("room");
    snapshot::save_image(&finer, &finer.start(0), 0, &mut half_hours).expect("room");
    assert_ne!(hours[8..12], half_hours[8..12]);
}

#[test]
fn images_in_single_precision_are_a_few_hundred_bytes() {
    type Contact = Simulation<crate::common::harvesters::Contact<f32>, TrBdf2, AnyStepControl<f32>, 3, 1>;
    type Bump = crate::common::harvesters::Bump<f32, 4, 1>;
    // What a firmware reserves; a change of the layout is another version.
    assert_eq!(Estimator::<f32, Contact>::SNAPSHOT_BYTES, 387);
    assert_eq!(Estimator::<f32, Bump>::SNAPSHOT_BYTES, 384);
    assert_eq!(snapshot::size_of::<<Contact as Harvester<f32>>::State>(), 92);
    assert_eq!(snapshot::size_of::<<Bump as Harvester<f32>>::State>(), 89);
}

/// The mode of a user's own scene.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Left,
    Right,
}

impl Snapshot for Side {
    const BYTES: usize = u8::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        (*self as u8).write(out);
    }

    fn read(from: &mut Reader<'_>) -> Self {
        let number = u8::read(from);
        from.require(number <= 1);
        if number == 0 { Self::Left } else { Self::Right }
    }
}

#[test]
fn a_mode_of_a_user_refuses_numbers_that_it_does_not_know() {
    let mut bytes = [0; snapshot::size_of::<Side>()];
    for (number, side) in [(0_u8, Ok(Side::Left)), (1, Ok(Side::Right)), (2, Err(SnapshotError::NoState))] {
        snapshot::save(&number, 5, &mut bytes).expect("room");
        assert_eq!(snapshot::restore::<Side>(5, &bytes), side);
    }
    snapshot::save(&Side::Right, 5, &mut bytes).expect("room");
    assert_eq!(snapshot::restore(5, &bytes), Ok(Side::Right));
}
