//! Each method against the reference, and where it must fail.

use crate::method::{Failure, Method, Options};
use crate::outcome::{BumpStopOutcome, Outcome, Particular};
use crate::run::run_scene;
use crate::scene_file::{Scene, read_shipped};

fn shipped(overrides: &[(&str, &str)]) -> Scene {
    let first = [("parameters.beam_modes", "6"), ("stop.rod_modes", "2"), ("run.settle_s", "0")];
    read_shipped("bump-stop", &[&first[..], overrides].concat()).expect("the shipped scene is valid")
}

fn options(method: Method, step: f64) -> Options {
    Options { method, step_s: Some(step), ..Options::default() }
}

fn without_step(method: Method) -> Options {
    Options { method, ..Options::default() }
}

fn run(scene: &Scene, options: &Options) -> (Outcome, BumpStopOutcome) {
    let outcome = run_scene(scene, options).unwrap_or_else(|failure| panic!("{failure}"));
    let Particular::BumpStop(particular) = outcome.particular.clone() else { panic!("another scene") };
    (outcome, particular)
}

const METHODS: [Method; 3] = [Method::TrBdf2, Method::Rk4, Method::Newmark];

/// Error of the state at the end in the energy norm, over the state's own.
fn error(found: &BumpStopOutcome, exact: &BumpStopOutcome) -> f64 {
    assert_eq!(found.end_state.len(), exact.end_state.len());
    let pairs = found.end_state.iter().zip(&exact.end_state);
    let difference: f64 = pairs.map(|(one, other)| (one - other).powi(2)).sum();
    (difference / exact.end_state.iter().map(|entry| entry * entry).sum::<f64>()).sqrt()
}

#[test]
fn without_contact_the_order_is_the_methods_own() {
    // Open for 3 ms, at steps that resolve the highest mode.
    let scene =
        shipped(&[("run.duration_s", "3e-3"), ("parameters.beam_modes", "3"), ("stop.rod_modes", "0")]);
    let (_, exact) = run(&scene, &without_step(Method::Reference));
    for (method, order) in METHODS.into_iter().zip([2.0, 4.0, 2.0]) {
        let errors = [8e-6, 4e-6].map(|step| error(&run(&scene, &options(method, step)).1, &exact));
        let measured = (errors[0] / errors[1]).log2();
        println!("{method:?}: {errors:?}, order {measured:.2}");
        assert!((measured - order).abs() < 0.2, "{method:?}: order {measured}");
    }
}

#[test]
fn with_contacts_all_approach_the_reference() {
    for changes in [
        [("load.resistance_ohm", "1e6"), ("parameters.coupling", "two-way")],
        [("load.resistance_ohm", "1e4"), ("parameters.coupling", "one-way")],
        [("load.resistance_ohm", "0"), ("parameters.coupling", "two-way")],
        [("load.resistance_ohm", "inf"), ("parameters.coupling", "two-way")],
    ] {
        let scene = shipped(&[&changes[..], &[("run.duration_s", "6e-3")]].concat());
        let (exact, contacts) = run(&scene, &without_step(Method::Reference));
        assert!(contacts.contacts > 5, "{changes:?}");
        for method in METHODS {
            let (found, particular) = run(&scene, &options(method, 5e-8));
            let error = error(&particular, &contacts);
            println!("{method:?} {changes:?}: {error:.1e}");
            assert!(error < 5e-4, "{method:?} {changes:?}: {error}");
            assert_eq!(particular.contacts, contacts.contacts, "{method:?} {changes:?}");
            let close = |found: Option<f64>, exact: Option<f64>, tolerance: f64| {
                let (found, exact) = (found.expect("a number"), exact.expect("a number"));
                assert!((found - exact).abs() <= tolerance * exact.abs(), "{method:?}: {found} {exact}");
            };
            close(particular.first_contact_s, contacts.first_contact_s, 1e-6);
            close(particular.mean_force_n, contacts.mean_force_n, 1e-3);
            close(particular.peak_force_n, contacts.peak_force_n, 2e-3);
            close(particular.contact_fraction, contacts.contact_fraction, 5e-3);
            close(particular.peak_tip_displacement_m, contacts.peak_tip_displacement_m, 1e-4);
            close(found.rms_voltage_v, exact.rms_voltage_v, 1e-4);
            close(found.peak_voltage_v, exact.peak_voltage_v, 1e-3);
            close(found.mean_power_w, exact.mean_power_w, 2e-4);
        }
    }
}

#[test]
fn a_step_that_is_not_stable_is_a_named_error() {
    let scene = shipped(&[("run.duration_s", "0.05")]);
    let failure = run_scene(&scene, &options(Method::Rk4, 1e-5)).expect_err("unstable");
    assert!(matches!(&failure, Failure::Step(text) if text.contains("not finite")), "{failure}");
    // The step that is taken where none is given is stable, and the implicit methods are at any.
    run(&scene, &without_step(Method::Rk4));
    for method in [Method::TrBdf2, Method::Newmark] {
        run(&scene, &options(method, 1e-3));
    }
}

#[test]
fn what_the_methods_do_not_have_is_refused() {
    let scene = shipped(&[]);
    let refused = |scene: &Scene, options: Options, word: &str| {
        let failure = run_scene(scene, &options).expect_err("refused");
        assert!(matches!(&failure, Failure::Input(text) if text.contains(word)), "{failure}");
    };
    for method in METHODS {
        let plain = Options { method, ..Options::default() };
        refused(&scene, Options { tolerance: Some(1e-3), ..plain }, "--tolerance");
        refused(&scene, Options { long_step_s: Some(1e-5), ..plain }, "--long-step");
        refused(&scene, Options { precision: Some(crate::method::Precision::F32), ..plain }, "--precision");
        refused(&scene, Options { math: Some(crate::method::Math::Libm), ..plain }, "--math");
        refused(&scene, Options { steady_state: true, ..plain }, "scene");
        let rigid = shipped(&[("stop.contact", "displacement-constraint")]);
        refused(&rigid, plain, "stop.contact");
    }
    let another = read_shipped("contact-separation", &[]).expect("valid");
    refused(&another, Options { method: Method::Newmark, ..Options::default() }, "--method newmark");
}
