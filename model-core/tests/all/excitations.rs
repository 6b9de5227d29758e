//! The bits of a run under each excitation do not depend on its division by budgets and pauses.

use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::{Burst, Excitation, Random, SpectralDensity, Sweep, SweepLaw};
use model_core::hybrid::Ended;
use model_core::integrate::ExponentialRadau;
use model_core::part::load::Resistor;
use model_core::part::restitution::ConstantRestitution;
use model_core::scalar::Scalar;
use model_core::scene::contact_separation::{Choices, Parameters, Start};
use model_core::scene::{Harvester, Simulation, bump_stop};

use crate::common::{adaptive, harvesters::bump_parameters};

/// Delivered energy and end of a run that is divided as told.
fn run<S: Scalar>(excitation: &dyn Excitation<S>, budget: u32, stops: &[f64]) -> (S, S) {
    let number = S::from_f64;
    let scene = Parameters {
        mass: number(5e-3),
        stiffness: number(80.0),
        damping_ratio: number(0.02),
        initial_gap: number(1e-3),
        electrode_area: number(4e-4),
        dielectric_thickness: number(5e-5),
        relative_permittivity: number(2.0),
        charge_density: number(5e-5),
        choices: Choices::new(
            Resistor { resistance: number(1e8) },
            ConstantRestitution { coefficient: number(0.75) },
        ),
    }
    .build()
    .expect("valid");
    let harvester = Simulation::new(scene, ExponentialRadau, adaptive(1e-3));
    let mut state = harvester.start(&Start::default(), &excitation).expect("starts");
    let mut meter = PowerMeter::new();
    for stop in stops {
        let until = Instant::from_seconds(*stop).expect("in range");
        loop {
            let advance =
                harvester.advance(&mut state, &excitation, until, budget, &mut meter).expect("runs");
            if advance.ended == Ended::Finished {
                break;
            }
        }
    }
    (meter.delivered_energy(), harvester.outputs(&state).voltage)
}

fn check<S: Scalar>(excitation: &dyn Excitation<S>, other: &dyn Excitation<S>) {
    let whole = run(excitation, u32::MAX, &[1.0]);
    assert!(whole.0 > S::ZERO);
    for budget in [0, 17, 100] {
        assert_eq!(run(excitation, budget, &[1.0]), whole);
    }
    // Steps end at the stops, so runs with the same stops are compared; the second excitation is in use between the calls.
    let stops = [0.1, 0.25, 0.3333, 1.0];
    let divided = run(excitation, u32::MAX, &stops);
    let _away = other.acceleration(Instant::from_whole_seconds(40));
    assert_eq!(run(other, 23, &stops), divided);
}

fn excitations<S: Scalar>() {
    let number = S::from_f64;
    let points = [[10.0, 0.5], [20.0, 0.5], [80.0, 0.05]].map(|point: [f64; 2]| point.map(number));
    let random = || {
        let density = SpectralDensity::new(&points).expect("valid");
        Random::<S, 64, S::Build>::new(&density, 64, 3).expect("valid")
    };
    check(&random(), &random());
    let burst = || {
        let burst = Burst::<S, S::Build>::cycles(number(4.0), number(20.0), 4).expect("valid");
        burst.every(number(0.3)).expect("valid")
    };
    check(&burst(), &burst());
    let sweep = || {
        let ends = [number(30.0), number(12.0)];
        Sweep::<S, S::Build>::new(number(4.0), ends, number(0.4), SweepLaw::Logarithmic, S::ZERO)
            .expect("valid")
    };
    check(&sweep(), &sweep());
}

#[test]
fn the_bits_of_a_run_do_not_depend_on_its_division() {
    excitations::<f64>();
    excitations::<f32>();
}

/// Energy delivered by a beam with three modes far from its stop, with a step in s.
fn delivered_by_a_beam(excitation: &impl Excitation<f64>, step: f64) -> f64 {
    let mut parameters = bump_parameters::<f64>();
    parameters.choices.stop.gap = 1e-2;
    let scene = parameters.build::<3, 1>().expect("in bounds");
    let beam = bump_stop::Stepper::new(scene, step.min(1e-5), step).expect("in bounds");
    let mut state = beam.start(&bump_stop::Start::default(), excitation).expect("starts");
    let mut meter = PowerMeter::new();
    let until = Instant::from_seconds(0.02).expect("in range");
    let advance = beam.advance(&mut state, excitation, until, u32::MAX, &mut meter).expect("runs");
    assert_eq!(advance.ended, Ended::Finished);
    meter.delivered_energy()
}

#[test]
fn a_long_step_of_a_beam_resolves_a_burst_at_its_third_mode() {
    let scene = bump_parameters::<f64>().build::<3, 1>().expect("in bounds");
    // The capacitance raises this mode by less than its bandwidth.
    let third = scene.open_circuit_angular_frequency(2).expect("a mode") / core::f64::consts::TAU;
    let burst =
        Burst::<f64>::cycles(300.0, third, 12).and_then(|burst| burst.starting_at(1e-3)).expect("valid");
    let [coarse, fine] = [180e-6, 2e-6].map(|step| delivered_by_a_beam(&burst, step));
    // A sine is resolved by steps of 0.9 radians too, over which the voltage is linear. Unresolved it is 31 % less.
    assert!((coarse / fine - 1.0).abs() < 0.2, "{coarse:e} {fine:e}");
}
