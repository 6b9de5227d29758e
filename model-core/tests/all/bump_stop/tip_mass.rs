//! The beam with a tip mass: static deflection, the linear response, bits, bounds.

use model_core::excitation::Sine;
use model_core::part::load::{Resistor, ShortCircuit};
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{
    AnyChoices, AnyCoupling, Choices, ClampBending, Parameters, Resistive, Start, Stepper, TipMass,
};

use super::setup::{baseline, block, close, measured, seconds, vibration, with_block};

/// Length in m, mass in kg and stiffness in N·m² of the beam.
const LENGTH: f64 = 0.05;
const BEAM_MASS: f64 = 0.078_25 * LENGTH;
const RIGIDITY: f64 = 0.089_738_408_5;

/// Other choices in place of those of the baseline.
fn chosen<C>(choices: C) -> Parameters<f64, C> {
    let Parameters {
        beam_length,
        beam_width,
        substrate,
        piezo,
        piezo_d31,
        piezo_permittivity,
        damping_ratio,
        ..
    } = baseline::<f64>();
    Parameters {
        beam_length,
        beam_width,
        substrate,
        piezo,
        piezo_d31,
        piezo_permittivity,
        damping_ratio,
        choices,
    }
}

/// A base that accelerates far below the first frequency bends the beam by the weight of beam and body: the tip by
/// `m_b L³/8EI + M (L³/3EI + d L²/2EI)` per acceleration, the clamp by `[m_b L/2 + M (L + d)]/EI`.
#[test]
fn a_slow_base_bends_the_beam_by_its_weight_and_that_of_the_body() {
    let body = block::<f64>();
    let parameters = chosen(Choices::new(ShortCircuit).tip_mass(body));
    let scene = parameters.build::<20, 0>().expect("valid");
    let found = scene.closed_form(1.0, 1e-2).amplitude;
    let cube = LENGTH.powi(3) / RIGIDITY;
    let tip =
        BEAM_MASS * cube / 8.0 + body.mass * (cube / 3.0 + body.offset * LENGTH.powi(2) / (2.0 * RIGIDITY));
    close(found, tip, 2e-8);
    // The modes and what the clamp adds for those left out, whatever their number.
    for kept in [1, 2, 5, 20] {
        let bending: ClampBending<f64, 20> = parameters.clamp_bending::<20, 0>(kept, 0).expect("valid");
        let mut state = [0.0; 40];
        for (number, at) in (1..).zip(state.iter_mut().step_by(2)).take(kept) {
            let mode = parameters.beam_mode(number);
            *at = -mode.base_coupling / mode.angular_frequency.powi(2);
        }
        let expected = -(0.5 * BEAM_MASS * LENGTH + body.mass * (LENGTH + body.offset)) / RIGIDITY;
        close(bending.curvature(&state, 0.0, 1.0, 0.0), expected, 1e-8);
    }
}

/// The deflection of a run under a constant acceleration, after the vibration has died away.
#[test]
fn a_run_comes_to_rest_at_the_static_deflection() {
    let body = block::<f64>();
    let mut parameters = chosen(Choices::new(ShortCircuit).tip_mass(body));
    parameters.damping_ratio = 0.5;
    let scene = parameters.build::<10, 0>().expect("valid");
    let stepper = Stepper::new(scene, 1e-6, 2e-5).expect("in bounds");
    let constant = Sine::<f64>::new(10.0, 0.0, core::f64::consts::FRAC_PI_2).expect("valid");
    let mut state = stepper.start(&Start::default(), &constant).expect("valid");
    stepper.advance(&mut state, &constant, seconds(0.3), u32::MAX, &mut ()).expect("runs");
    let outputs = stepper.outputs(&state);
    let cube = LENGTH.powi(3) / RIGIDITY;
    let tip =
        BEAM_MASS * cube / 8.0 + body.mass * (cube / 3.0 + body.offset * LENGTH.powi(2) / (2.0 * RIGIDITY));
    close(outputs.coordinate().value, -10.0 * tip, 1e-6);
}

#[test]
fn the_steady_run_is_the_closed_form() {
    let bodies = [Some(block()), None];
    for (coupling, body) in
        [AnyCoupling::TwoWay, AnyCoupling::OneWay].map(|it| bodies.map(|body| (it, body))).concat()
    {
        let choices = Choices::new(Resistor { resistance: 1e5 }).coupling(coupling).tip_mass(body);
        let mut parameters = chosen(choices);
        parameters.damping_ratio = 0.05;
        let scene = parameters.build::<6, 0>().expect("valid");
        let stepper = Stepper::with_all_powers(scene, 1e-5, 1e-5).expect("in bounds");
        for frequency in [60.0, 130.0, 150.0, 900.0] {
            let exact = scene.closed_form(20.0, frequency);
            let vibration = Sine::<f64>::new(20.0, frequency, 0.0).expect("valid");
            let end = 0.35 + 20.0 / frequency;
            let found = measured(&stepper, &vibration, 0.35, end);
            close(found.mean_power(), exact.mean_power, 1e-4);
            close(found.report().coordinate.magnitude(), exact.amplitude, 1e-4);
        }
    }
}

/// A body without mass and inertia changes nothing but roundings; none at all changes no bit.
#[test]
fn no_body_is_a_free_end() {
    let excitation = vibration::<f64>();
    let power = |parameters: Parameters<f64, AnyChoices<f64>>| {
        let stepper = Stepper::with_all_powers(parameters.build::<4, 1>().expect("valid"), 2e-6, 2e-5);
        measured(&stepper.expect("in bounds"), &excitation, 0.0, 0.01).mean_power()
    };
    let free = baseline::<f64>();
    let mut massless = free;
    massless.choices.tip_mass = Some(TipMass { mass: 0.0, rotary_inertia: 0.0, offset: 0.0 });
    close(power(massless), power(free), 1e-6);

    let load = Resistor { resistance: 1e6 };
    let stop = free.choices.stop;
    let typed = chosen(Choices::new(load).stop(stop)).build::<4, 1>().expect("valid");
    let any = free.build::<4, 1>().expect("valid");
    for index in 0..4 {
        assert_eq!(typed.beam_angular_frequency(index), any.beam_angular_frequency(index));
    }
    assert_eq!(typed.contact_stiffness(), any.contact_stiffness());
    let typed = chosen(Choices::new(load).stop(stop).tip_mass(block())).build::<4, 1>().expect("valid");
    let any = with_block::<f64>().build::<4, 1>().expect("valid");
    for index in 0..4 {
        assert_eq!(typed.beam_angular_frequency(index), any.beam_angular_frequency(index));
    }
    assert_eq!(typed.contact_stiffness(), any.contact_stiffness());
    // The body is in the coefficients, so the harvester is not larger.
    type Free = Choices<Resistive<Resistor<f64>>>;
    type Loaded = Choices<
        Resistive<Resistor<f64>>,
        model_core::scene::bump_stop::NoStop,
        model_core::scene::bump_stop::TwoWay,
        TipMass<f64>,
    >;
    assert_eq!(size_of::<Stepper<f64, Free, 4, 0>>(), size_of::<Stepper<f64, Loaded, 4, 0>>());
}

#[test]
fn single_precision_has_the_same_first_contacts_and_power() {
    let excitation = (vibration::<f64>(), vibration::<f32>());
    let fine = Stepper::with_all_powers(with_block::<f64>().build::<6, 2>().expect("valid"), 1e-6, 2e-5);
    let coarse = Stepper::with_all_powers(with_block::<f32>().build::<6, 2>().expect("valid"), 1e-6, 2e-5);
    let (fine, coarse) = (fine.expect("in bounds"), coarse.expect("in bounds"));
    close(coarse.scene().contact_stiffness().into(), fine.scene().contact_stiffness(), 1e-4);
    let fine = measured(&fine, &excitation.0, 0.0, 0.01);
    let coarse = measured(&coarse, &excitation.1, 0.0, 0.01);
    assert!(fine.report().contacts > 0);
    close(coarse.mean_power().into(), fine.mean_power(), 1e-2);
}

#[test]
fn bodies_out_of_bounds_are_named() {
    let refused = |body: TipMass<f64>| {
        let mut parameters = baseline::<f64>();
        parameters.choices.tip_mass = Some(body);
        parameters.build::<2, 1>().err().map(|error| error.to_string())
    };
    assert_eq!(refused(block()), None);
    let error = refused(TipMass { mass: -1.0, ..block() });
    assert_eq!(error.as_deref(), Some("tip_mass.mass = -1.0 must be from 0.0 to 1000.0"));
    let error = refused(TipMass { offset: 0.75, ..block() });
    assert_eq!(error.as_deref(), Some("tip_mass.offset / beam_length = 15.0 must be from 0.0 to 10.0"));
    let error = refused(TipMass { rotary_inertia: f64::NAN, ..block() });
    assert_eq!(error.as_deref(), Some("tip_mass.rotary_inertia = NaN must be from 0.0 to 1000.0"));
}
