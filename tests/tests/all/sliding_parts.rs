//! The sliding harvester made of compile-time parts, as firmware has it, beside the run-time form that the
//! host uses: bit for bit; and parts left out beside parts that do nothing.

use cross_crate_tests::sliding;
use host_bench::embedded::sliding_parameters;
use host_bench::scene_file::{ForceLaw, Load, SlidingParameters, StickCharge};
use model_core::clock::Instant;
use model_core::excitation::Sine;
use model_core::hybrid::Driver;
use model_core::integrate::{
    Adaptive, ExponentialRadau, FixedStep, Method, RungeKutta4, StepControl, TrBdf2,
};
use model_core::part::load::{OpenCircuit, Resistor, ShortCircuit};
use model_core::scalar::{Mathematics, Polynomial, Scalar};
use model_core::scene::sliding::{
    AnyChoices, Choices, FieldLateralForce, Frictionless, Mode, NeverSticks, Parameters, Parts, Start,
    StickCharge as Charge, TransferredCharge,
};

/// How a motion begins and is shaken.
#[derive(Clone, Copy)]
struct Case {
    velocity: f64,
    acceleration: f64,
    frequency: f64,
}

/// From rest, with sticks.
const STICKING: Case = Case { velocity: 0.0, acceleration: 2.943, frequency: 10.0 };
/// At resonance, never at rest.
const SWINGING: Case = Case { velocity: -0.9, acceleration: 3.5316, frequency: 18.373 };

/// States every 10 ms of a second, and whether any is stuck.
fn states<S: Scalar, P: Parts<S>, I: Method<S>, C: StepControl<S>>(
    parameters: &Parameters<S, P>,
    integrator: I,
    control: C,
    case: Case,
) -> (Vec<[f64; 3]>, bool)
where
    Polynomial: Mathematics<S>,
{
    let harvester = parameters.build().expect("in bounds");
    let [acceleration, frequency] = [case.acceleration, case.frequency].map(S::from_f64);
    let vibration = Sine::<S, Polynomial>::new(acceleration, frequency, S::ZERO).expect("in bounds");
    let driver = Driver::new(integrator, control);
    let velocity = (case.velocity != 0.0).then(|| S::from_f64(case.velocity));
    let start = Start { velocity, ..Start::default() };
    let mut state = harvester.start::<_, _, 1>(&start, &vibration, &driver.control).expect("in bounds");
    let mut stuck = false;
    let states = (1..=100)
        .map(|hundredth| {
            let until = Instant::from_seconds(f64::from(hundredth) * 0.01).expect("a time");
            driver.advance(&harvester, &mut state, &vibration, until, u32::MAX, &mut ()).expect("runs");
            stuck |= state.mode == Mode::Stick;
            // Every single-precision number is a double-precision one: nothing is lost of the bits.
            state.point.state.map(S::to_f64)
        })
        .collect();
    (states, stuck)
}

/// The run-time form of the shipped scene.
fn any<S: Scalar>(
    resistance: f64,
    change: impl FnOnce(&mut SlidingParameters),
) -> Parameters<S, AnyChoices<S>> {
    let scene = sliding(|_, model| change(&mut model.parameters));
    let model = scene.sliding().expect("a sliding scene");
    sliding_parameters(model, Load::Resistor { resistance_ohm: resistance })
}

/// Both forms under each method; the parts are those of the run-time form.
fn same<S: Scalar, C: Parts<S>>(any: &Parameters<S, AnyChoices<S>>, choices: C, case: Case)
where
    Polynomial: Mathematics<S>,
{
    let chosen = any.with_choices(choices);
    let adaptive = Adaptive::new(S::from_f64(1e-4)).expect("in bounds");
    let fixed = FixedStep::of_seconds(S::from_f64(2e-4)).expect("in bounds");
    let (states_of_any, stuck) = states(any, TrBdf2, adaptive, case);
    assert_eq!(stuck, case.velocity == 0.0, "what sticks and what does not");
    assert!(states_of_any.iter().any(|state| state[0].abs() > 1e-4));
    assert_eq!(states(&chosen, TrBdf2, adaptive, case).0, states_of_any);
    let states_of_any = states(any, ExponentialRadau, adaptive, case);
    assert_eq!(states_of_any.1, stuck);
    assert_eq!(states(&chosen, ExponentialRadau, adaptive, case), states_of_any);
    assert_eq!(states(&chosen, RungeKutta4, fixed, case), states(any, RungeKutta4, fixed, case));
}

#[test]
fn parts_chosen_at_run_time_give_the_bits_of_those_chosen_at_compile_time() {
    let paper = any::<f32>(1e8, |_| ());
    let friction = paper.choices.friction;
    let resistor = Resistor { resistance: 1e8 };
    for case in [STICKING, SWINGING] {
        same(&paper, Choices::new(resistor, friction).force_law(TransferredCharge), case);
        let field = any::<f32>(1e8, |parameters| {
            parameters.force_law = ForceLaw::GapField;
            parameters.stick_charge = StickCharge::Relaxing;
            parameters.lateral_force = true;
            parameters.charge_density_c_per_m2 = 10e-6;
        });
        let choices = Choices::new(resistor, friction).sticking(Charge::Relaxing);
        same(&field, choices.lateral_force(FieldLateralForce), case);
        let shorted = any::<f32>(0.0, |_| ());
        same(&shorted, Choices::new(ShortCircuit, friction).force_law(TransferredCharge), case);
        let open = any::<f32>(f64::INFINITY, |parameters| parameters.lateral_force = true);
        let choices = Choices::new(OpenCircuit, friction).force_law(TransferredCharge);
        same(&open, choices.lateral_force(FieldLateralForce), case);
    }
    // Where it never comes to rest, the code for it is not missed.
    let choices = Choices::new(resistor, friction).force_law(TransferredCharge);
    same(&paper, choices.sticking(NeverSticks), SWINGING);
}

/// Without friction no reversal is an event: the steps are others, the motion is the same.
#[test]
fn no_friction_is_the_same_as_friction_of_nothing() {
    let none = any::<f64>(1e8, |parameters| cross_crate_tests::rub(parameters, 0.0));
    let resistor = Resistor { resistance: 1e8 };
    let choices = Choices::new(resistor, Frictionless).force_law(TransferredCharge);
    let free = none.with_choices(choices.sticking(NeverSticks));
    let choices = Choices::new(resistor, none.choices.friction).force_law(TransferredCharge);
    let rubbed = none.with_choices(choices);
    let fixed = FixedStep::of_seconds(1e-4).expect("in bounds");
    let case = Case { velocity: 0.3, acceleration: 1.0, frequency: 15.0 };
    let (free, rubbed) =
        (states(&free, RungeKutta4, fixed, case).0, states(&rubbed, RungeKutta4, fixed, case).0);
    for (free, rubbed) in free.iter().zip(&rubbed) {
        for ((free, rubbed), scale) in free.iter().zip(rubbed).zip([5e-3, 0.5, 0.5]) {
            assert!((free - rubbed).abs() < 1e-7 * scale, "{free:e} {rubbed:e}");
        }
    }
}
