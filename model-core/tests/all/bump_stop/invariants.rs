//! Properties at any step: energy, bits, counts, bounds.

use model_core::energy::{Ledger, RunMeter};
use model_core::excitation::Silence;
use model_core::observer::{AcceptedStep, Observer, PowerIndex};
use model_core::part::load::Resistor;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{
    AnyChoices, AnyContact, AnyCoupling, Choices, NoStop, OneWay, Parameters, ResidualFlexibility, Resistive,
    Restitution, Start, Stepper, Stop,
};

use super::setup::{Touches, baseline, seconds, vibration, with_block};

#[test]
fn energy_is_conserved_by_every_step_without_damping_and_load() {
    // Each step in s, and the seconds of its run.
    let steps = [(1e-7, 0.02), (1e-6, 0.05), (1e-5, 0.5), (1e-4, 0.5), (1e-3, 0.5)];
    let tips = [
        (baseline::<f64>(), 1.0, 12, 2e-11, &steps[..]),
        (with_block(), 1.0, 4, 4e-11, &steps[1..]),
        (with_block(), 0.5, 4, 4e-11, &steps[1..]),
    ];
    for (mut parameters, position, contacts, limit, steps) in tips {
        parameters.damping_ratio = 0.0;
        parameters.choices.load.0.resistance = f64::INFINITY;
        parameters.choices.stop.gap = 0.0;
        parameters.choices.stop.position = position * parameters.beam_length;
        let scene = parameters.build::<6, 2>().expect("valid");
        let tip = parameters.beam_mode(1).shape(1.0).value;
        for &(step, duration) in steps {
            let stepper = Stepper::with_all_powers(scene, step, step).expect("in bounds");
            // Bent back by 30 µm at the tip, and let go.
            let mut start = Start::default();
            start.beam[0] = [-30e-6 / tip, 0.0];
            let mut state = scene.start(&start, &Silence).expect("valid");
            let (mut ledger, mut meter) = (Ledger::open(&stepper.outputs(&state)), RunMeter::new());
            let before: f64 = stepper.outputs(&state).stored.total();
            stepper
                .advance(&mut state, &Silence, seconds(duration), u32::MAX, &mut (&mut ledger, &mut meter))
                .expect("runs");
            let after: f64 = stepper.outputs(&state).stored.total();
            assert!(meter.report().contacts >= contacts, "{step}: {} contacts", meter.report().contacts);
            assert!((after / before - 1.0).abs() < limit, "{position} {step}: {}", after / before - 1.0);
            assert!(ledger.residual().total().expect("energy") < limit);
        }
    }
}

#[test]
fn with_damping_load_and_shaking_the_ledger_closes() {
    for (step, contact) in [
        (1e-6, AnyContact::ResidualFlexibility),
        (1e-5, AnyContact::ResidualFlexibility),
        (1e-6, AnyContact::DisplacementConstraint),
        (1e-6, AnyContact::Restitution(Restitution { coefficient: 0.5 })),
    ] {
        let scenes = [baseline::<f64>(), with_block()]
            .map(|it| [(AnyCoupling::TwoWay, it), (AnyCoupling::OneWay, it)]);
        for (coupling, mut parameters) in scenes.into_iter().flatten() {
            parameters.choices.stop.contact = contact;
            parameters.choices.coupling = coupling;
            let scene = parameters.build::<6, 2>().expect("valid");
            let stepper = Stepper::with_all_powers(scene, step, step.max(2e-5)).expect("in bounds");
            let excitation = vibration();
            let mut state = scene.start(&Start::default(), &excitation).expect("valid");
            let (mut ledger, mut meter) = (Ledger::open(&stepper.outputs(&state)), RunMeter::new());
            stepper
                .advance(&mut state, &excitation, seconds(0.05), u32::MAX, &mut (&mut ledger, &mut meter))
                .expect("runs");
            let residual = ledger.residual().largest().expect("work");
            assert!(residual < 1e-13, "{step} {contact:?} {coupling:?}: {residual}");
            assert!(meter.report().contacts > 3, "{step} {contact:?}");
            let [base_work, damped] =
                [PowerIndex::Base, PowerIndex::Dissipation].map(|power| ledger.integrals().integral(power));
            assert!(base_work > 0.0 && damped > 0.0);
            if contact != AnyContact::DisplacementConstraint {
                assert!(ledger.lost_in_contact() >= -1e-12 * base_work);
            }
        }
    }
}

#[test]
fn a_long_step_is_only_taken_where_no_contact_can_be() {
    // The same run with long steps and without touches at the same times.
    let scene = baseline::<f64>().build::<6, 2>().expect("valid");
    let excitation = vibration();
    let run = |long: f64| {
        let stepper = Stepper::with_all_powers(scene, 5e-7, long).expect("in bounds");
        let mut state = scene.start(&Start::default(), &excitation).expect("valid");
        let mut touches = Touches::default();
        let advance =
            stepper.advance(&mut state, &excitation, seconds(5e-3), u32::MAX, &mut touches).expect("runs");
        (touches.at, advance.work.steps)
    };
    let ((every, many), (few_at, few)) = (run(5e-7), run(2e-5));
    assert!(few * 2 < many, "{few} {many}");
    assert!(every.len() >= 3);
    for (a, b) in every.iter().zip(&few_at).take(3) {
        assert!((a - b).abs() < 2e-7, "{a} {b}");
    }
    // The event-driven NumPy program.
    assert!((every[0] - 3.306_469_272e-3).abs() < 5e-7);
}

#[test]
fn bits_do_not_depend_on_capacity_budget_or_run_time_choice() {
    let any = baseline::<f32>();
    let Stop { length, section, young_modulus, density, position, gap, contact_compliance, .. } =
        any.choices.stop;
    let contact = ResidualFlexibility;
    let stop = Stop { length, section, young_modulus, density, position, gap, contact_compliance, contact };
    let fixed = Parameters {
        beam_length: any.beam_length,
        beam_width: any.beam_width,
        substrate: any.substrate,
        piezo: any.piezo,
        piezo_d31: any.piezo_d31,
        piezo_permittivity: any.piezo_permittivity,
        damping_ratio: any.damping_ratio,
        choices: Choices::new(Resistor { resistance: 1e6 }).stop(stop),
    };
    let excitation = vibration::<f32>();
    let exact = Stepper::new(fixed.build::<4, 1>().expect("valid"), 2e-6, 5e-5).expect("in bounds");
    let roomy = Stepper::new(any.build_first::<10, 10>(4, 1).expect("valid"), 2e-6, 5e-5).expect("in bounds");
    let mut one = exact.scene().start(&Start::default(), &excitation).expect("valid");
    let mut other = roomy.scene().start(&Start::default(), &excitation).expect("valid");
    exact.advance(&mut one, &excitation, seconds(0.03), u32::MAX, &mut ()).expect("runs");
    while other.clock < seconds(0.03) {
        roomy.advance(&mut other, &excitation, seconds(0.03), 50, &mut ()).expect("runs");
    }
    assert_eq!(one.beam[..], other.beam[..4]);
    assert_eq!(one.rod[..], other.rod[..1]);
    assert_eq!(exact.scene().voltage(&one), roomy.scene().voltage(&other));
    assert_eq!(other.beam[4..], [[0.0; 2]; 6]);
}

#[test]
fn without_a_stop_nothing_of_it_is_there() {
    type Free = Choices<Resistive<Resistor<f64>>, NoStop, OneWay>;
    let with = size_of::<Stepper<f64, AnyChoices<f64>, 4, 10>>();
    assert!(size_of::<Stepper<f64, Free, 4, 0>>() < with / 2);
    assert!(size_of::<model_core::scene::bump_stop::State<f64, 4, 0>>() <= 4 * 16 + 64);
}

#[test]
fn impacts_and_closed_contacts_make_no_energy() {
    let mut parameters = baseline::<f64>();
    parameters.damping_ratio = 0.0;
    parameters.choices.load.0.resistance = f64::INFINITY;
    parameters.choices.stop.gap = 0.0;
    struct Highest(f64);
    impl Observer<f64> for Highest {
        fn step(&mut self, step: &AcceptedStep<'_, f64>) {
            self.0 = self.0.max(step.end.stored.total());
        }
    }
    for coefficient in [0.0, 0.5, 1.0] {
        for (step, short_rod) in [(1e-6, false), (1e-5, false), (1e-6, true)] {
            parameters.choices.stop.contact = AnyContact::Restitution(Restitution { coefficient });
            // A short thin rod: its modes turn many times in a step.
            (parameters.choices.stop.length, parameters.choices.stop.section) =
                if short_rod { (2e-3, 1e-6) } else { (0.02, 4e-6) };
            let scene = parameters.build::<6, 2>().expect("valid");
            let stepper = Stepper::new(scene, step, step).expect("in bounds");
            let mut start = Start::default();
            start.beam[0] = [-30e-6 / 31.974_430_7, 0.0];
            let mut state = scene.start(&start, &Silence).expect("valid");
            let before: f64 = stepper.outputs(&state).stored.total();
            let mut highest = Highest(before);
            stepper.advance(&mut state, &Silence, seconds(1e-3), u32::MAX, &mut highest).expect("runs");
            assert!(highest.0 < before * (1.0 + 1e-9), "{coefficient} {step}: {}", highest.0 / before);
        }
    }
}

#[test]
fn a_constrained_contact_is_counted_once() {
    let mut parameters = baseline::<f64>();
    parameters.choices.stop.contact = AnyContact::DisplacementConstraint;
    let scene = parameters.build::<6, 2>().expect("valid");
    let stepper = Stepper::new(scene, 1e-6, 1e-6).expect("in bounds");
    let excitation = vibration();
    let mut state = scene.start(&Start::default(), &excitation).expect("valid");
    struct Intervals(u32, bool);
    impl Observer<f64> for Intervals {
        fn step(&mut self, step: &AcceptedStep<'_, f64>) {
            let touches = step.contact.force > 0.0;
            self.0 += u32::from(touches && !self.1);
            self.1 = touches;
        }
    }
    let mut intervals = Intervals(0, false);
    let mut meter = RunMeter::new();
    let observer = &mut (&mut intervals, &mut meter);
    stepper.advance(&mut state, &excitation, seconds(12e-3), u32::MAX, observer).expect("runs");
    assert!(intervals.0 > 10);
    assert_eq!(meter.report().contacts, intervals.0);
}

#[test]
fn parameters_out_of_bounds_and_starts_in_penetration_are_named() {
    let refused = |change: fn(&mut Parameters<f64, AnyChoices<f64>>)| {
        let mut changed = baseline();
        change(&mut changed);
        changed.build::<2, 1>().err().map(|error| error.field)
    };
    assert_eq!(refused(|_| ()), None);
    assert_eq!(refused(|p| p.beam_length = 0.0), Some("beam_length"));
    assert_eq!(refused(|p| p.substrate.density = f64::NAN), Some("substrate_density"));
    assert_eq!(refused(|p| p.damping_ratio = 1.0), Some("damping_ratio"));
    assert_eq!(refused(|p| p.choices.stop.position = 0.06), Some("stop.position"));
    assert_eq!(refused(|p| p.choices.stop.gap = -1e-9), Some("stop.gap"));
    assert_eq!(refused(|p| p.choices.load.0.resistance = -1.0), Some("resistance"));
    let modes = |beam, rod| baseline::<f64>().build_first::<2, 1>(beam, rod).err().map(|error| error.field);
    assert_eq!([modes(1, 0), modes(2, 1)], [None; 2]);
    assert_eq!([modes(0, 1), modes(3, 1)], [Some("beam_modes"); 2]);
    assert_eq!(modes(2, 2), Some("rod_modes"));
    assert_eq!(baseline::<f64>().build::<0, 0>().err().map(|error| error.field), Some("beam_modes"));
    let elastic = |p: &mut Parameters<f64, AnyChoices<f64>>| {
        p.choices.stop.contact = AnyContact::Restitution(Restitution { coefficient: 1.1 });
    };
    assert_eq!(refused(elastic), Some("restitution"));
    let scene = baseline::<f64>().build::<2, 1>().expect("valid");
    let mut start = Start::default();
    start.beam[0][0] = 1e-6;
    let error = scene.start(&start, &Silence).expect_err("inside the stop");
    assert_eq!(error.field, "penetration at the start");
}

#[test]
fn lengths_of_step_that_are_not_positive_finite_numbers_are_refused() {
    let scene = baseline::<f64>().build::<4, 1>().expect("valid");
    for bad in [f64::NAN, 0.0, -1e-6, f64::INFINITY, 1.0] {
        assert_eq!(Stepper::new(scene, bad, 1e-5).map_err(|error| error.field).err(), Some("short_step"));
        assert_eq!(Stepper::new(scene, 1e-6, bad).map_err(|error| error.field).err(), Some("long_step"));
    }
}
