//! What the tests of contact-separation and sliding share.

use super::Motion;
use super::harvester::Harvester;
use crate::ReferenceOptions;
use crate::test_support::number;
use harvester_scene::outcome::Outcome;
use harvester_scene::scene_file::{Draw, Excitation, Load, Lockout, Model, RectifiedStore, RunSpan, Scene};

/// A scene with a resistor, measured between two times in s.
pub(crate) fn with_resistor(
    model: Model,
    resistance_ohm: f64,
    excitation: Excitation,
    [settle_s, duration_s]: [f64; 2],
) -> Scene {
    let (load, run) = (Load::Resistor { resistance_ohm }, RunSpan { duration_s, settle_s });
    Scene { file: "test".into(), model, load, excitation, run, limits: Vec::new() }
}

/// Asserts that [`Harvester::rates_along`] is the derivative of [`Harvester::rates`], by central differences.
#[track_caller]
pub(crate) fn check_jacobian(harvester: &impl Harvester, at: &Motion, case: &str) {
    for (position, velocity, voltage) in [(1e-7, 0.0, 0.0), (0.0, 1e-5, 0.0), (0.0, 0.0, 1e-3)] {
        let shifted = |sign: f64| {
            let motion = Motion {
                position: at.position + sign * position,
                velocity: at.velocity + sign * velocity,
                voltage: at.voltage + sign * voltage,
                ..*at
            };
            harvester.rates(&motion, 0.0)
        };
        let (ahead, behind) = (shifted(1.0), shifted(-1.0));
        let along = harvester.rates_along(at, &Motion { position, velocity, voltage, ..*at });
        for row in 0..3 {
            let difference = 0.5 * (ahead[row] - behind[row]);
            let scale = along.iter().fold(1e-12, |m: f64, x| m.max(x.abs()));
            assert!(
                (difference - along[row]).abs() < 1e-5 * difference.abs() + 1e-9 * scale,
                "{case} row {row}: {difference} {}",
                along[row]
            );
        }
    }
}

/// Runs a scene with the default options.
pub(crate) fn run(scene: &Scene) -> Outcome {
    crate::run(scene, &ReferenceOptions::default()).expect("the reference gets to the end")
}

/// Every draw of a node.
pub(crate) fn draws(lockout: Lockout) -> [Draw; 4] {
    [
        Draw::None,
        Draw::Resistor { resistance_ohm: 1e7, lockout: Some(lockout) },
        Draw::Current { current_a: 1e-6, lockout },
        Draw::Power { power_w: 5e-6, lockout },
    ]
}

/// Runs a scene with a storage of 0.2 µF and asserts that its ledgers close.
#[track_caller]
pub(crate) fn ledgers_close_with_storage(
    mut scene: Scene,
    [initial_v, diode_drop_v]: [f64; 2],
    draw: Draw,
) -> Outcome {
    let (capacitance_f, leakage_ohm) = (2e-7, 1e8);
    scene.load =
        Load::RectifiedStore(RectifiedStore { capacitance_f, diode_drop_v, leakage_ohm, initial_v, draw });
    let outcome = run(&scene);
    let residual = number(outcome.energy_residual);
    assert!(residual < 1e-9, "{:?} {draw:?}: {residual:e}", scene.model);
    let storage = outcome.store.expect("there is a storage");
    assert!(storage.leaked_energy_j > Some(0.0) && storage.diode_loss_j > Some(0.0));
    assert_eq!(storage.drawn_energy_j > Some(0.0), draw != Draw::None);
    outcome
}
