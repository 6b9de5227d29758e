//! One image of all that a node learns: budget with income by slot, estimator and bank of lines.

use crate::common::harvesters::{Contact, contact, sine_samples};
use crate::common::{Random, adaptive, finished};
use model_core::energy::estimator::{Interpolation, SampleFormat, Settings};
use model_core::energy::{
    Budget, BudgetParameters, BudgetState, Capacitor, Estimator, IncomeParameters, StorageParameters,
};
use model_core::excitation::{LineBank, LineBankState};
use model_core::integrate::{AnyStepControl, ExponentialRadau};
use model_core::scalar::Scalar;
use model_core::scene::Simulation;
use model_core::snapshot::{self, Image, SnapshotError};

const EVER: u32 = u32::MAX;
const RATE: f64 = 200.0;
/// Samples of the accelerometer in a minute: the node listens for a second.
const SAMPLES: u32 = 200;

type Harvester<S> = Simulation<Contact<S>, ExponentialRadau, AnyStepControl<S>, 3, 1>;

/// The configuration of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node<S: Scalar> {
    estimator: Estimator<S, Harvester<S>>,
    budget: Budget<S, 24>,
    bank: LineBank<32, 8>,
}

/// The settings that the tests change one by one.
#[derive(Clone, Copy)]
struct Numbers {
    tolerance: f64,
    capacitance: f64,
    leakage: f64,
    charging: f64,
    discharging: f64,
    highest: f64,
    lock_out: f64,
    turn_on: f64,
    time_constant: f64,
    day_weight: f64,
    standing_power: f64,
    longest_gap: u16,
    bank_rate: f32,
    unit: f32,
}

const NUMBERS: Numbers = Numbers {
    tolerance: 5e-2,
    capacitance: 220e-6,
    leakage: 10e6,
    charging: 0.8,
    discharging: 0.9,
    highest: 4.5,
    lock_out: 1.8,
    turn_on: 2.4,
    time_constant: 7200.0,
    day_weight: 0.5,
    standing_power: 1e-6,
    longest_gap: 4,
    bank_rate: RATE as f32,
    unit: 1e-3,
};

impl<S: Scalar> Node<S> {
    fn new(numbers: &Numbers) -> Self {
        let number = S::from_f64;
        let storage = StorageParameters {
            capacitor: Capacitor {
                capacitance: number(numbers.capacitance),
                leakage_resistance: number(numbers.leakage),
            },
            charging_efficiency: number(numbers.charging),
            discharging_efficiency: number(numbers.discharging),
            highest_voltage: number(numbers.highest),
            lock_out_voltage: number(numbers.lock_out),
            turn_on_voltage: number(numbers.turn_on),
        };
        let income = IncomeParameters {
            time_constant: number(numbers.time_constant),
            day_weight: number(numbers.day_weight),
        };
        let standing_power = number(numbers.standing_power);
        let budget = BudgetParameters { storage, income, standing_power }.build().expect("in bounds");
        let control = adaptive(numbers.tolerance);
        let settings = Settings {
            format: SampleFormat::accelerations(number(60.0), number(0.0)),
            longest_gap: numbers.longest_gap,
            interpolation: Interpolation::DroopCompensated,
            bias_seconds: Some(number(2.0)),
            ..crate::estimator::settings(RATE)
        };
        let harvester = Simulation::new(contact(), ExponentialRadau, control);
        Self {
            estimator: Estimator::new(harvester, settings).expect("in bounds"),
            budget,
            bank: LineBank::new(numbers.bank_rate, 20.0, 0.5, numbers.unit).expect("in bounds"),
        }
    }
}

/// All that the node has learnt.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Learnt<S: Scalar> {
    estimator: Estimator<S, Harvester<S>>,
    budget: BudgetState<S, 24>,
    lines: LineBankState<8>,
}

type Parts<'a, S> = (&'a Estimator<S, Harvester<S>>, &'a Budget<S, 24>, &'a LineBank<32, 8>);

impl<S: Scalar> Node<S> {
    fn start(&self) -> Learnt<S> {
        let mut budget = self.budget.start(9 * 3600 + 17);
        self.budget.correct_by_voltage(&mut budget, S::from_f64(3.0), S::from_f64(2e-3));
        Learnt { estimator: self.estimator, budget, lines: self.bank.start() }
    }

    fn parts(&self) -> Parts<'_, S> {
        (&self.estimator, &self.budget, &self.bank)
    }

    fn save(&self, learnt: &Learnt<S>, sequence: u32, bytes: &mut [u8]) -> Result<usize, SnapshotError> {
        let states = (*learnt.estimator.state(), learnt.budget, learnt.lines);
        snapshot::save_image(&self.parts(), &states, sequence, bytes)
    }

    fn restore(&self, slots: [&[u8]; 2]) -> Result<(Learnt<S>, u32), SnapshotError> {
        let Image { state, sequence, .. } = snapshot::newest_image(&self.parts(), slots)?;
        let (state, budget, lines) = state;
        let mut estimator = self.estimator;
        estimator.set_state(state);
        Ok((Learnt { estimator, budget, lines }, sequence))
    }

    /// A minute: a second of samples, some lost, then the rest of the minute as that second; a reading of the voltage.
    fn minute(&self, learnt: &mut Learnt<S>, random: &mut Random, minute: u32) {
        let rms = 0.5 + f64::from(minute / 60 % 5);
        for n in 0..SAMPLES {
            let sample = S::from_f64(0.3 + rms * (0.62 * f64::from(n)).sin() + 0.2 * random.normal());
            if random.next().is_multiple_of(97) {
                finished(learnt.estimator.push_missing(1, EVER));
            } else {
                finished(learnt.estimator.push_acceleration(sample, EVER));
            }
            self.bank.take(&mut learnt.lines, &[(1e3 * sample.to_f64()) as i16]);
        }
        let estimate = learnt.estimator.estimate();
        learnt.estimator.clear();
        let minute_energy = |of_second: S| of_second * S::from_f64(60.0);
        let harvested = minute_energy(estimate.energy);
        let relative = estimate.uncertainty.relative.unwrap_or(S::ONE);
        let spent = if random.next().is_multiple_of(7) { S::from_f64(4e-5) } else { S::ZERO };
        self.budget.spend(&mut learnt.budget, spent);
        self.budget.update(&mut learnt.budget, 60, harvested, S::ZERO);
        learnt.budget.raise_uncertainty(relative * harvested);
        if minute.is_multiple_of(240) {
            self.budget.gap(&mut learnt.budget, 1800);
        }
    }
}

/// Size of an image of the node.
fn size<S: Scalar>() -> usize {
    snapshot::image_size::<Parts<'static, S>>()
}

/// A node that loses its power again and again in a day and a half, beside one that never does.
fn resumes_in_the_middle_of_a_day<S: Scalar>() {
    let node = Node::<S>::new(&NUMBERS);
    let (mut steady, mut interrupted) = (node.start(), node.start());
    let (mut random, mut twin) = (Random(5), Random(5));
    let mut power = Random(6);
    let mut slots = [vec![0xff; size::<S>()], vec![0xff; size::<S>()]];
    let mut images = 0_u32;
    for minute in 0..2200 {
        node.minute(&mut steady, &mut random, minute);
        node.minute(&mut interrupted, &mut twin, minute);
        if power.next().is_multiple_of(10) {
            images += 1;
            let slot = &mut slots[images as usize % 2];
            assert_eq!(node.save(&interrupted, images, slot), Ok(size::<S>()));
            // Another node object: all that it knows is in the image.
            let (awake, sequence) =
                Node::new(&NUMBERS).restore([&slots[0], &slots[1]]).expect("its own image");
            assert_eq!(sequence, images);
            assert_eq!(awake, interrupted);
            interrupted = awake;
        }
    }
    assert_eq!(interrupted, steady);
    assert_eq!(saved(&node, &interrupted), saved(&node, &steady), "every bit");
    assert!(images > 100, "{images}");
    // It has learnt something of each kind.
    assert!(steady.budget.mean_power() > S::ZERO);
    assert!(steady.estimator.estimate().bias.is_some_and(|bias| bias != S::ZERO));
    assert!(steady.budget.account().drawn > S::ZERO && steady.lines != node.bank.start());
}

fn saved<S: Scalar>(node: &Node<S>, learnt: &Learnt<S>) -> Vec<u8> {
    let mut bytes = vec![0; size::<S>()];
    node.save(learnt, 1, &mut bytes).expect("room");
    bytes
}

#[test]
fn a_node_resumes_in_the_middle_of_a_day_with_the_same_bits() {
    resumes_in_the_middle_of_a_day::<f32>();
    resumes_in_the_middle_of_a_day::<f64>();
}

/// A node in the middle of a morning, and its image.
fn morning<S: Scalar>() -> (Node<S>, Vec<u8>) {
    let node = Node::new(&NUMBERS);
    let (mut learnt, mut random) = (node.start(), Random(8));
    for minute in 0..200 {
        node.minute(&mut learnt, &mut random, minute);
    }
    // In the middle of a block.
    for sample in sine_samples::<S>(9.0, 20.0, RATE, 33) {
        node.bank.take(&mut learnt.lines, &[(1e3 * sample.to_f64()) as i16]);
    }
    let bytes = saved(&node, &learnt);
    (node, bytes)
}

fn every_flip_and_cut_is_refused<S: Scalar>() {
    let (node, bytes) = morning::<S>();
    let erased = vec![0xff; bytes.len()];
    for bit in 0..bytes.len() * 8 {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(node.restore([&flipped, &erased]).is_err(), "bit {bit}");
    }
    for length in 0..bytes.len() {
        let short = SnapshotError::TooShort { needed: bytes.len(), given: length };
        assert_eq!(node.restore([&bytes[..length], &erased]).err(), Some(short));
        // Torn: what was not written is erased.
        let mut torn = bytes.clone();
        torn[length..].fill(0xff);
        assert!(node.restore([&torn, &erased]).is_err(), "{length}");
    }
    let (learnt, _) = node.restore([&erased, &bytes]).expect("whole");
    assert_eq!(saved(&node, &learnt), bytes);
}

#[test]
fn every_flipped_bit_and_every_cut_of_a_node_is_refused() {
    every_flip_and_cut_is_refused::<f32>();
    every_flip_and_cut_is_refused::<f64>();
}

fn foreign_settings_are_refused<S: Scalar>() {
    let (node, bytes) = morning::<S>();
    assert!(node.restore([&bytes, &bytes]).is_ok());
    let changes: [fn(&mut Numbers); 14] = [
        |n| n.tolerance = 5.1e-2,
        |n| n.capacitance = 221e-6,
        |n| n.leakage = f64::INFINITY,
        |n| n.charging = 0.81,
        |n| n.discharging = 0.91,
        |n| n.highest = 4.51,
        |n| n.lock_out = 1.81,
        |n| n.turn_on = 2.41,
        |n| n.time_constant = 7201.0,
        |n| n.day_weight = 0.51,
        |n| n.standing_power = 1.01e-6,
        |n| n.longest_gap = 5,
        |n| n.bank_rate = 201.0,
        |n| n.unit = 1.1e-3,
    ];
    for (index, change) in changes.into_iter().enumerate() {
        let mut numbers = NUMBERS;
        change(&mut numbers);
        let refused = Node::<S>::new(&numbers).restore([&bytes, &bytes]).err();
        assert_eq!(refused, Some(SnapshotError::ForeignModel), "change {index}");
    }
}

#[test]
fn an_image_of_a_node_with_one_other_setting_is_foreign() {
    foreign_settings_are_refused::<f32>();
    foreign_settings_are_refused::<f64>();
    let (_, single) = morning::<f32>();
    let double = Node::<f64>::new(&NUMBERS).restore([&single, &single]).err();
    assert_eq!(double, Some(SnapshotError::ForeignModel));
}

/// Fingerprint in an image of a budget that has learnt nothing.
fn fingerprint<const SLOTS: usize>() -> u32 {
    let parameters = BudgetParameters {
        storage: *Node::<f32>::new(&NUMBERS).budget.storage().parameters(),
        income: IncomeParameters { time_constant: 7200.0, day_weight: 0.5 },
        standing_power: 1e-6,
    };
    let budget: Budget<f32, SLOTS> = parameters.build().expect("in bounds");
    let mut bytes = [0; 2048];
    snapshot::save_image(&budget, &budget.start(0), 0, &mut bytes).expect("room");
    u32::from_le_bytes([8, 9, 10, 11].map(|place| bytes[place]))
}

#[test]
fn the_number_of_slots_of_the_day_is_part_of_the_fingerprint() {
    assert_ne!(fingerprint::<24>(), fingerprint::<48>());
}
