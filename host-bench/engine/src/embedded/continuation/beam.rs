//! A bump-stop harvester under a sine of a held frequency, and its fingerprint.

use model_core::scene::Harvester as _;
use model_core::scene::bump_stop::{Circuit, Stepper};
use model_core::snapshot::Fingerprint;

use super::super::bump_stop::{parameters, prepared, refuse_step, resistance};
use super::super::excitation::{Setting, bridge};
use super::super::run::{refuse_parameter, refuse_start};
use super::{Sweep, With};
use harvester_scene::method::Failure;
use harvester_scene::scene_file::{BumpStop, Scene};

/// Calls `with` with the harvester, with its resistor or behind its bridge.
pub(super) fn continuation(
    setting: Setting<'_, f64>,
    model: &BumpStop,
    frequency_hz: f64,
    with: With<'_>,
) -> Result<(), Failure> {
    match bridge(setting.scene.load) {
        Some(bridge) => with_load(setting, model, frequency_hz, with, bridge),
        None => with_load(setting, model, frequency_hz, with, resistance(setting.scene.load)),
    }
}

fn with_load<L: Circuit<f64>>(
    setting: Setting<'_, f64>,
    model: &BumpStop,
    frequency_hz: f64,
    with: With<'_>,
    load: L,
) -> Result<(), Failure> {
    match model.modes() {
        [..=4, ..=2] => with_modes::<L, 4, 2>(setting, model, frequency_hz, with, load),
        [..=10, ..=10] => with_modes::<L, 10, 10>(setting, model, frequency_hz, with, load),
        _ => with_modes::<L, 20, 20>(setting, model, frequency_hz, with, load),
    }
}

fn with_modes<L: Circuit<f64>, const B: usize, const R: usize>(
    setting: Setting<'_, f64>,
    model: &BumpStop,
    frequency_hz: f64,
    with: With<'_>,
    load: L,
) -> Result<(), Failure> {
    let (scene, start, [short, long]) =
        prepared::<f64, L, B, R>((setting.scene, model, setting.options), load)?;
    let stepper = Stepper::with_all_powers(scene, short, long).map_err(refuse_step)?;
    let state =
        stepper.start(&start, &setting.excitation).map_err(|error| refuse_start(setting.scene, &error))?;
    with(&mut Sweep::new(setting, &stepper, state, frequency_hz, false))
}

/// Includes the harvester in `f32` with the modes of its scene, behind a bridge with open terminals.
pub(super) fn identify(
    scene: &Scene,
    model: &BumpStop,
    fingerprint: &mut Fingerprint,
) -> Result<(), Failure> {
    let [beam, rod] = model.modes();
    let core = parameters::<f32>(model, scene.load)
        .build_first::<20, 20>(beam, rod)
        .map_err(|error| refuse_parameter(scene, &error))?;
    core.identify_first([beam, rod], fingerprint);
    Ok(())
}
