//! Voltages that are small differences of the open-circuit voltage and that of the charge, in both triboelectric scenes:
//! a start charge into a small load, small motions, loads of a few ohms. Every method against the reference.

use cross_crate_tests::{
    adaptive, assert_close, contact_separation, fixed, periods, reference, resistor, rub, run, sine, single,
    sliding, value,
};
use host_bench::method::{Method, Options};
use host_bench::run::run_scene;
use host_bench::scene_file::{ForceLaw, Restitution, RunSpan, Scene, StickCharge};

fn seconds(duration_s: f64) -> RunSpan {
    RunSpan { duration_s, settle_s: 0.0 }
}

fn tr_bdf2(tolerance: f64) -> Options {
    Options { method: Method::TrBdf2, ..adaptive(tolerance) }
}

fn rk4(step_s: f64) -> Options {
    Options { method: Method::Rk4, ..fixed(step_s) }
}

fn delivered(scene: &Scene, options: &Options) -> f64 {
    value(run_scene(scene, options).unwrap_or_else(|failure| panic!("{failure}")).delivered_energy_j)
}

/// Holds the delivered energy of each method against the reference: within 1 % in double precision, 2 % in single.
fn hold(what: &str, scene: &Scene, methods: &[Options]) {
    let expected = delivered(scene, &reference());
    for options in methods {
        let name = format!("{what}, {:?}", options.method);
        assert_close(&name, delivered(scene, options), expected, 0.01);
        assert_close(&format!("{name} in f32"), delivered(scene, &single(*options)), expected, 0.02);
    }
}

/// The charge relaxes within a fraction of a step, while nothing moves.
#[test]
fn a_start_charge_delivers_its_energy_into_a_small_load() {
    for (charge, ohms) in [(1e-8, 0.1), (-4e-9, 20.0), (1e-9, 3e3)] {
        let scene = sliding(|scene, model| {
            model.initial.charge_c = Some(charge);
            scene.load = resistor(ohms);
            scene.run = seconds(0.1);
        });
        hold(&format!("sliding, {charge} C, {ohms} ohm"), &scene, &[adaptive(1e-2), tr_bdf2(1e-3)]);
    }
    for (charge, ohms) in [(1e-8, 1e3), (-3e-9, 0.5), (5e-9, 3e4)] {
        let scene = contact_separation(|scene, model| {
            model.initial.charge_c = Some(charge);
            scene.load = resistor(ohms);
            scene.run = seconds(0.1);
        });
        hold(&format!("contact, {charge} C, {ohms} ohm"), &scene, &[adaptive(1e-2), tr_bdf2(1e-3)]);
    }
}

/// A slider that sticks with a relaxing charge has the same layer.
#[test]
fn a_stuck_slider_delivers_its_start_charge() {
    let scene = sliding(|scene, model| {
        model.initial.charge_c = Some(7e-10);
        model.parameters.stick_charge = StickCharge::Relaxing;
        scene.load = resistor(17.0);
        scene.excitation = sine(0.07, 17.8);
        scene.run = seconds(0.1);
    });
    hold("stuck", &scene, &[adaptive(1e-2), tr_bdf2(1e-3)]);
}

/// An explicit step as long as the layer's time constant.
#[test]
fn an_explicit_method_delivers_a_start_charge() {
    let scene = contact_separation(|scene, model| {
        model.initial.charge_c = Some(1e-8);
        scene.load = resistor(1e5);
        scene.run = seconds(0.02);
    });
    hold("contact", &scene, &[rk4(2.2e-7)]);
}

/// The voltage of a small motion is below a rounding of the open-circuit voltage in single precision.
#[test]
fn a_small_motion_in_single_precision_delivers_no_rounding() {
    for (gravities, hertz, ohms) in [(1e-3, 5.0, 1e6), (1e-6, 11.0, 1e5), (1.0, 1e3, 1.0)] {
        let scene = contact_separation(|scene, model| {
            model.parameters.force_law = ForceLaw::GapField;
            scene.load = resistor(ohms);
            scene.excitation = sine(gravities, hertz);
            scene.run = seconds(0.2);
        });
        let what = format!("contact, {gravities} g, {hertz} Hz, {ohms} ohm");
        hold(&what, &scene, &[adaptive(1e-2), tr_bdf2(1e-3)]);
        if ohms == 1e6 {
            hold(&what, &scene, &[rk4(2e-6)]);
        }
        let scene = sliding(|scene, model| {
            rub(&mut model.parameters, 0.0);
            scene.load = resistor(ohms);
            scene.excitation = sine(gravities, hertz);
            scene.run = seconds(0.2);
        });
        let what = format!("sliding, {gravities} g, {hertz} Hz, {ohms} ohm");
        hold(&what, &scene, &[adaptive(1e-2), tr_bdf2(1e-3)]);
    }
}

/// Many steps in single precision: what each is allowed for rounding stays below its tolerance.
#[test]
fn the_rounding_that_steps_are_allowed_does_not_add_up() {
    let scene = contact_separation(|scene, model| {
        model.parameters.force_law = ForceLaw::GapField;
        model.parameters.charge_density_c_per_m2 = 5e-6;
        model.parameters.parasitic_capacitance_f = 0.0;
        model.parameters.restitution = Restitution::Constant { coefficient: 0.99 };
        scene.load = resistor(1.0);
        scene.run = periods(20.0, 60, 20);
    });
    let options = tr_bdf2(1e-4);
    let (double, _) = run(&scene, &options);
    let (float, _) = run(&scene, &single(options));
    assert_close("f32 beside f64", value(float.mean_power_w), value(double.mean_power_w), 0.01);
    hold("contact", &scene, &[adaptive(1e-3)]);
}
