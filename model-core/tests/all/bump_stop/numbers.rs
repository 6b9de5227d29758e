//! Closed forms, and the numbers of two other programs.
//!
//! The other programs are not in this repository: one is event-driven, in NumPy, by the eigenvectors of each state of
//! contact; the other has the same method and step as the library.

use model_core::excitation::Silence;
use model_core::observer::{AcceptedStep, Observer, PowerIndex};
use model_core::scalar::Scalar;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{AnyChoices, AnyCoupling, BumpStop, Parameters, Start, Stepper};

use super::setup::{Touches, baseline, close, measured, seconds, vibration};

/// The first modes of the beam and of the rod.
fn first_modes<const B: usize, const R: usize>(
    parameters: Parameters<f64, AnyChoices<f64>>,
    beam: usize,
    rod: usize,
) -> BumpStop<f64, AnyChoices<f64>, B, R> {
    parameters.build_first(beam, rod).expect("valid")
}

#[test]
fn contact_stiffness_is_that_of_the_modes_left_out() {
    // N/m at the tip, by numbers of beam and rod modes; and at mid-span: sums over modes in the other programs.
    let tip = |b, r| first_modes::<10, 10>(baseline(), b, r).contact_stiffness();
    for (beam, rod, stiffness) in [
        (3, 0, 1.348e6),
        (4, 0, 2.774e6),
        (4, 1, 3.305e6),
        (6, 1, 9.940e6),
        (6, 2, 1.0619e7),
        (8, 3, 2.396e7),
        (10, 3, 4.210e7),
        (10, 10, 4.8976e7),
    ] {
        close(tip(beam, rod), stiffness, 4e-4);
    }
    let mut middle = baseline::<f64>();
    middle.choices.stop.position = 0.025;
    close(middle.build::<10, 10>().expect("valid").contact_stiffness(), 1.8210e8, 1e-3);
    let single = baseline::<f32>().build::<10, 10>().expect("valid");
    close(single.contact_stiffness().into(), tip(10, 10), 2e-5);
}

#[test]
fn the_golden_trajectory_is_met_and_approached_beyond_second_order() {
    // Event-driven, (6, 2) modes, from rest: times of contact in s, and the state at 6 ms.
    let contacts = [3.306_469_272e-3, 3.344_968_680e-3, 3.385_140_677e-3];
    let (tip, volts) = (-1.509_803_342e-5, -0.701_496_050_4);
    let scene = baseline::<f64>().build::<6, 2>().expect("valid");
    let run = |step: f64| {
        let stepper = Stepper::with_all_powers(scene, step, step).expect("in bounds");
        let excitation = vibration();
        let mut state = scene.start(&Start::default(), &excitation).expect("valid");
        let mut touches = Touches::default();
        stepper.advance(&mut state, &excitation, seconds(6e-3), u32::MAX, &mut touches).expect("runs");
        assert!(!touches.negative && !touches.pulled_open);
        (touches, stepper.outputs(&state).coordinate().value, scene.voltage(&state))
    };
    let (touches, at_end, voltage) = run(1e-6);
    assert_eq!(touches.at.len(), 8);
    for (at, expected) in touches.at.iter().zip(contacts) {
        assert!((at - expected).abs() < 1e-6, "{at} {expected}");
    }
    close(at_end, tip, 2e-5);
    close(voltage, volts, 5e-5);
    // The largest force is that at the end of a step.
    let (shorter, ..) = run(1e-7);
    close(touches.impulse, shorter.impulse, 2e-5);
    close(touches.largest, shorter.largest, 5e-3);
    // Another program, by a constant force in each step of 1 µs: its own error is 5e-4.
    close(touches.impulse, 7.701_610_553e-5, 1e-3);
    let errors = [4e-7, 2e-7, 1e-7, 5e-8].map(|step| {
        let (_, at_end, voltage) = run(step);
        ((at_end - tip) / tip).abs().max(((voltage - volts) / volts).abs())
    });
    let order = (errors[0] / errors[3]).log2() / 3.0;
    assert!((2.5..3.5).contains(&order), "{errors:?}: order {order}");
    assert!(errors[3] < 1e-8, "{errors:?}");
    println!("order {order:.2}, errors {errors:?}");
}

#[test]
fn one_way_coupling_has_its_own_contacts() {
    let mut parameters = baseline::<f64>();
    parameters.choices.coupling = AnyCoupling::OneWay;
    let scene = parameters.build::<6, 2>().expect("valid");
    let stepper = Stepper::with_all_powers(scene, 1e-7, 1e-7).expect("in bounds");
    let excitation = vibration();
    let mut state = scene.start(&Start::default(), &excitation).expect("valid");
    let mut touches = Touches::default();
    stepper.advance(&mut state, &excitation, seconds(6e-3), u32::MAX, &mut touches).expect("runs");
    for (at, expected) in touches.at.iter().zip([3.333_173_400e-3, 3.371_875_227e-3, 3.411_967_571e-3]) {
        assert!((at - expected).abs() < 2e-8, "{at} {expected}");
    }
    close(scene.voltage(&state), -0.682_948_187_4, 1e-3);
    close(stepper.outputs(&state).coordinate().value, -1.644_225_653e-5, 1e-3);
}

#[test]
fn mean_deflections_are_those_of_the_mean_force() {
    // <y(X_c)> = −<F> Σ φ²/ω² over some hundred cycles.
    let mut parameters = baseline::<f64>();
    parameters.choices.stop.gap = 0.0;
    let scene = parameters.build::<4, 1>().expect("valid");
    let stepper = Stepper::with_all_powers(scene, 2e-6, 2e-5).expect("in bounds");
    let excitation = vibration();
    let mut state = scene.start(&Start::default(), &excitation).expect("valid");
    struct Mean(f64, f64);
    impl Observer<f64> for Mean {
        fn step(&mut self, step: &AcceptedStep<'_, f64>) {
            // Simpson's rule would need the middle; the corrected trapezium has the rates.
            let [a, b] = [step.start, step.end].map(|outputs| outputs.motions[1]);
            self.0 += step.step * (0.5 * (a.value + b.value) + step.step / 12.0 * (a.rate - b.rate));
            self.1 += step.energy(PowerIndex::ContactForce);
        }
    }
    let mut mean = Mean(0.0, 0.0);
    stepper.advance(&mut state, &excitation, seconds(0.5), u32::MAX, &mut ()).expect("runs");
    stepper.advance(&mut state, &excitation, seconds(2.5), u32::MAX, &mut mean).expect("runs");
    let compliance = 0.05f64.powi(3) / (3.0 * 0.089_738_408_5) - 2.891e-7;
    close(mean.0, -mean.1 * compliance, 2e-3);
}

/// RMS voltage in V and mean force in N from 0.5 s to `end`, with the stop at a position and a gap in m: within 5 %.
fn statistics<const B: usize, const R: usize>(
    [position, gap]: [f64; 2],
    end: f64,
    [volts, newtons]: [f64; 2],
) {
    let mut parameters = baseline::<f64>();
    (parameters.choices.stop.position, parameters.choices.stop.gap) = (position, gap);
    let scene = parameters.build::<B, R>().expect("valid");
    let stepper = Stepper::with_all_powers(scene, 1e-6, 2e-5).expect("in bounds");
    let meter = measured(&stepper, &vibration(), 0.5, end);
    close(meter.report().rms_voltage.expect("all powers"), volts, 0.05);
    close(meter.integrals().mean(PowerIndex::ContactForce), newtons, 0.05);
}

#[test]
fn statistics_are_those_of_the_event_driven_reference() {
    statistics::<6, 2>([0.05, 10e-6], 1.5, [0.694, 12.97e-3]);
    statistics::<6, 2>([0.025, 0.0], 1.5, [0.810, 45.5e-3]);
    // It depends on the modes.
    statistics::<10, 10>([0.05, 0.0], 1.0, [0.4329, 15.28e-3]);
}

#[test]
fn single_precision_has_the_statistics_of_double() {
    // Five seconds. With four beam modes the motion at the tip is weakly chaotic, and two runs of one
    // precision differ by as much; with six it is not.
    fn run<S: Scalar>(position: f64, gap: f64) -> [f64; 3] {
        let mut parameters = baseline::<S>();
        let stop = &mut parameters.choices.stop;
        (stop.position, stop.gap) = (S::from_f64(position), S::from_f64(gap));
        let scene = parameters.build::<6, 2>().expect("valid");
        let stepper =
            Stepper::with_all_powers(scene, S::from_f64(2e-6), S::from_f64(5e-5)).expect("in bounds");
        let meter = measured(&stepper, &vibration(), 0.5, 5.5);
        let force = meter.integrals().mean(PowerIndex::ContactForce);
        [meter.report().rms_voltage.expect("all powers"), force, meter.mean_power()].map(S::to_f64)
    }
    for (position, gap) in [(0.05, 0.0), (0.025, 10e-6)] {
        let (coarse, fine) = (run::<f32>(position, gap), run::<f64>(position, gap));
        println!("{position} {gap}: {coarse:?} {fine:?}");
        for ((coarse, fine), allowed) in coarse.into_iter().zip(fine).zip([0.02, 0.02, 0.04]) {
            close(coarse, fine, allowed);
        }
    }
}

#[test]
fn the_impulse_of_the_first_impact_is_that_of_the_continuum() {
    // F(t) = Z v e^τ erfc √τ, τ = (a Z)² t, until the wave comes back through the rod: 6.631e-6 N·s in
    // 7.8 µs at 0.05 m/s. The modes that are kept come within some per cent of it.
    let impulse = |scene: BumpStop<f64, AnyChoices<f64>, 20, 20>| {
        let stepper = Stepper::with_all_powers(scene, 1e-8, 1e-8).expect("in bounds");
        let mut start = Start::<f64, 20, 20>::default();
        // The beam moves as a whole: ṙ = γ v, and γ = ∫ m' φ is what the base couples by.
        let beam = model_core::part::beam::Cantilever {
            length: baseline::<f64>().beam_length,
            bending_stiffness: 0.089_738_408_5,
            mass_per_length: 0.078_25,
            tip_mass: 0.0,
        };
        for (number, coordinate) in (1..).zip(&mut start.beam) {
            coordinate[1] = 0.05 * beam.mode(number).base_coupling;
        }
        let mut state = scene.start(&start, &Silence).expect("valid");
        let mut touches = Touches::default();
        stepper.advance(&mut state, &Silence, seconds(7.8e-6), u32::MAX, &mut touches).expect("runs");
        touches.impulse
    };
    let mut parameters = baseline::<f64>();
    parameters.choices.stop.gap = 0.0;
    let of = |beam, rod| impulse(first_modes(parameters, beam, rod));
    println!("{:e} {:e} {:e}", of(6, 2), of(10, 10), of(20, 20));
    close(of(10, 10), 6.631e-6, 0.06);
    close(of(20, 20), 6.631e-6, 0.03);
}
