//! What the tests of contact-separation and sliding share.

use crate::ReferenceOptions;
use crate::test_support::number;
use harvester_scene::outcome::Outcome;
use harvester_scene::scene_file::{Draw, Load, Lockout, RectifiedStore, Scene};

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
