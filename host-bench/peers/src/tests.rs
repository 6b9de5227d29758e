//! Each method against the reference, the Jacobians against differences, and what is refused.

use harvester_reference::ReferenceOptions;
use harvester_scene::scene_file::{Scene, read_shipped};

use super::scene::{Base, Harvester, Mode};
use crate::load::{Transducer, WithBridge, WithResistor};
use crate::scene::bump_stop::BumpStop;
use crate::scene::contact_separation::ContactSeparation;
use crate::scene::sliding::Sliding;
use crate::{CASES, Method, Stop, fits, run};

fn scene(file: &str, overrides: &[&str]) -> Scene {
    let changes: Vec<(&str, &str)> = overrides.iter().filter_map(|pair| pair.split_once('=')).collect();
    read_shipped(file, &changes).expect("a shipped scene with good values")
}

/// Asserts that every method but `slow` finds the mean power of the reference.
#[track_caller]
fn agree(scene: &Scene, slow: &[Method], bound: f64) {
    let reference = harvester_reference::run(scene, &ReferenceOptions::default()).expect("a reference");
    let expected = reference.mean_power_w.expect("a mean power");
    assert!(expected > 0.0);
    for method in Method::all().filter(|method| fits(scene, *method) && !slow.contains(method)) {
        let setting = match method {
            Method::ExponentialRadau | Method::TrBdf2 => 1e-6,
            Method::Rk4 => 4000.0,
            Method::DiscreteGradient => 2e5,
            Method::DiffsolTrBdf2 => 1e-9,
            Method::Dop853 => 1e-11,
            _ => 1e-10,
        };
        let found = run(scene, method, setting).unwrap_or_else(|stop| panic!("{}: {stop}", method.name()));
        let error = found.mean_power_w / expected - 1.0;
        assert!(error.abs() < bound, "{}: {error:e}", method.name());
        assert!(found.steps_per_simulated_second > 0.0 && found.seconds_per_simulated_second > 0.0);
    }
}

const CORE: [Method; 3] = [Method::ExponentialRadau, Method::TrBdf2, Method::Rk4];
const EXPLICIT: [Method; 3] = [Method::Rk4, Method::Dopri5, Method::Dop853];

#[test]
fn contact_separation_with_impacts() {
    let run = ["excitation.amplitude_g=0.6", "run.duration_s=0.3", "run.settle_s=0.1"];
    let hits = harvester_reference::run(&scene("contact-separation", &run), &ReferenceOptions::default());
    let hits = hits.expect("a reference").contact_separation().map(|outcome| outcome.impacts);
    assert!(hits > Some(2), "{hits:?}");
    for (load, slow) in [("1e8", &EXPLICIT[..0]), ("1e6", &EXPLICIT[..1]), ("1e3", &EXPLICIT)] {
        let load = format!("load.resistance_ohm={load}");
        agree(&scene("contact-separation", &[&run[..], &[&load]].concat()), slow, 2e-5);
    }
    // The core of this comparison has the force law of the first paper.
    let changes =
        ["load.initial_v=4.4", "excitation.frequency_hz=20.0", "parameters.force_law=transferred-charge"];
    agree(&scene("rectified", &[&run[..], &changes].concat()), &[], 2e-5);
}

#[test]
fn the_law_of_the_field_and_a_constant_restitution() {
    let changes = [
        "parameters.force_law=gap-field",
        "parameters.restitution={kind=\"constant\", coefficient=0.6}",
        "excitation.amplitude_g=0.6",
        "run.duration_s=0.3",
        "run.settle_s=0.1",
    ];
    // The core of this comparison has the parts of the shipped scene.
    agree(&scene("contact-separation", &changes), &CORE, 2e-5);
    let changes = ["parameters.force_law=gap-field", "run.duration_s=0.3", "run.settle_s=0.1"];
    // The force of the field holds a slider with more charge.
    let changes = [&changes[..], &["parameters.charge_density_c_per_m2=10e-6"]].concat();
    agree(&scene("sliding", &changes), &CORE, 2e-5);
}

#[test]
fn sliding_with_reversals_and_stick() {
    let run = ["run.duration_s=0.4", "run.settle_s=0.1"];
    agree(&scene("sliding", &run), &[], 2e-5);
    let slow_base = ["excitation.amplitude_g=0.30", "excitation.frequency_hz=6"];
    let sticks = scene("sliding", &[&run[..], &slow_base].concat());
    let found = harvester_reference::run(&sticks, &ReferenceOptions::default()).expect("a reference");
    assert!(found.sliding().and_then(|outcome| outcome.stick_fraction) > Some(0.2));
    agree(&sticks, &[], 2e-5);
    let bridge = "load={kind=\"rectified-store\", capacitance_f=1e-6, diode_drop_v=0.3, leakage_ohm=1e7, \
                  initial_v=1.0, draw={kind=\"none\"}}";
    agree(&scene("sliding", &[&run[..], &[bridge]].concat()), &[], 2e-5);
}

#[test]
fn bump_stop_behind_a_bridge_until_after_some_contacts() {
    let case = CASES.iter().find(|case| case.file == "bump-stop").expect("there is one");
    let overrides = [case.overrides, &["run.duration_s=6e-3", "run.settle_s=0"]].concat();
    agree(&scene(case.file, &overrides), &[Method::DiffsolBdf, Method::DiffsolTrBdf2], 1e-4);
}

/// Asserts that the derivative is that of central differences.
#[track_caller]
fn derivative<H: Harvester<N>, const N: usize>(harvester: &H, mode: &Mode<H::Branch>, state: [f64; N]) {
    let sizes = harvester.sizes();
    for column in 0..N {
        let mut change = [0.0; N];
        change[column] = 1e-6 * sizes[column];
        let shifted = |sign: f64| {
            let state = std::array::from_fn(|row| state[row] + sign * change[row]);
            harvester.rates(mode, 0.01, &state)
        };
        let (ahead, behind) = (shifted(1.0), shifted(-1.0));
        let along = harvester.rates_along(mode, 0.01, &state, &change);
        let rates = harvester.rates(mode, 0.01, &state);
        for row in 0..N {
            let difference = 0.5 * (ahead[row] - behind[row]);
            let noise = 1e-9 * (along[row].abs() + rates[row].abs()) + 1e-300;
            let close = (difference - along[row]).abs() < 1e-4 * along[row].abs() + noise;
            assert!(close, "rate {row} by state {column}: {difference:e} {:e}", along[row]);
        }
    }
}

/// Checks the derivatives of a motion with both loads, in every regime of the bridge.
#[track_caller]
fn derivatives<T: Transducer + Copy, const R: usize, const B: usize>(
    transducer: T,
    branch: T::Branch,
    motion: &[f64],
) {
    let mode = |sign, connected| Mode { branch, stuck: false, sign, connected };
    let mut state = [0.0; R];
    state[..R - 2].copy_from_slice(motion);
    state[R - 2] = 7.0;
    derivative::<_, R>(&WithResistor { transducer, conductance: 1e-7 }, &mode(0.0, false), state);
    let harvester_scene::scene_file::Load::RectifiedStore(store) = scene("rectified", &[]).load else {
        panic!("a rectified store");
    };
    let mut state = [0.0; B];
    state[..B - 3].copy_from_slice(motion);
    (state[B - 3], state[B - 2]) = (3.6, 3.0);
    for (sign, connected) in [(0.0, false), (0.0, true), (1.0, true), (-1.0, false)] {
        derivative::<_, B>(&WithBridge { transducer, store }, &mode(sign, connected), state);
    }
}

#[test]
fn jacobians_are_those_of_differences() {
    use harvester_scene::scene_file::Model;

    let base = Base { amplitude: 2.0, angular_frequency: 120.0, phase: 0.3 };
    for law in ["transferred-charge", "gap-field"] {
        let law = format!("parameters.force_law={law}");
        if let Model::ContactSeparation(model) = scene("contact-separation", &[&law]).model {
            let transducer = ContactSeparation::new(&model.parameters, base);
            // Open, nearly closed, and beyond the dielectric, where the function is continued.
            for gap in [2e-3, 2e-5, -2e-5] {
                derivatives::<_, 4, 5>(transducer, (), &[gap, -0.05]);
            }
        }
        if let Ok(model) = scene("sliding", &[&law]).sliding() {
            let transducer = Sliding::new(&model.parameters, base);
            for motion in [[4e-3, 0.3], [-6e-3, 0.2]] {
                let branch = transducer.released(0.0, &motion, 0.0);
                derivatives::<_, 4, 5>(transducer, branch, &motion);
            }
        }
    }
    let modes = ["parameters.beam_modes=2", "stop.rod_modes=1"];
    let Model::BumpStop(model) = scene("bump-stop", &modes).model else { panic!("bump-stop") };
    let transducer = BumpStop::<3>::new(&model, base).expect("three modes");
    let motion = [1e-5, 2e-3, -3e-6, 1e-2, 1e-8, -3e-3];
    for closed in [false, true] {
        derivatives::<_, 8, 9>(transducer, closed, &motion);
    }
}

#[test]
fn names_and_settings_are_in_order() {
    for method in Method::all() {
        assert_eq!(Method::named(method.name()), Some(method), "{}", method.name());
        let tightens = |pair: &[f64]| (pair[0] < pair[1]) == method.is_fixed();
        assert!(method.settings().windows(2).all(tightens), "{}", method.name());
    }
    // The core stands above its peers.
    assert!(Method::all().is_sorted_by_key(|method| method.peer().is_some()));
    for case in CASES {
        let scene = case.scene().expect("a scene");
        assert!(Method::all().filter(|method| fits(&scene, *method)).count() > 5, "{}", case.name);
    }
}

#[test]
fn what_the_peers_do_not_have_is_refused() {
    let silent = "excitation={kind=\"silence\"}";
    let storage = "load={kind=\"rectified-store\", capacitance_f=1e-6, diode_drop_v=0.3, leakage_ohm=1e9, \
                   initial_v=1.0, draw={kind=\"resistor\", value=1e6}}";
    for (file, change, part) in [
        ("contact-separation", silent, "excitation.kind"),
        ("contact-separation", "parameters.stick_charge=relaxing", "parameters.stick_charge"),
        ("contact-separation", "initial={gap_m=1e-3}", "initial"),
        ("contact-separation", "load.resistance_ohm=0", "load"),
        ("contact-separation", storage, "load.draw"),
        ("sliding", "parameters.lateral_force=true", "parameters.lateral_force"),
        ("sliding", storage, "load.draw"),
        ("bump-stop", "parameters.beam_modes=3", "parameters.beam_modes"),
    ] {
        let stop = run(&scene(file, &[change]), Method::Dopri5, 1e-3).expect_err(change);
        let Stop::Refused(reason) = &stop else { panic!("{change}: {stop:?}") };
        assert!(reason.starts_with(part), "{change}: {reason}");
    }
}

#[test]
fn a_stiff_circuit_is_given_up_by_explicit_methods() {
    let stiff = scene("contact-separation", &["load.resistance_ohm=1"]);
    let stop = run(&stiff, Method::Dopri5, 1e-3).expect_err("too many steps");
    assert!(matches!(stop, Stop::TooManySteps { .. } | Stop::Integrator(_)), "{stop:?}");
}
