//! Runs of a bump-stop scene for an observer of the host, in double precision.

use model_core::clock::Instant;
use model_core::observer::Observer;
use model_core::scalar::Polynomial;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{AnyChoices, Circuit, Stepper};

use super::{Report, bridge, prepared, refuse_start, refuse_step, resistance};
use crate::embedded::excitation::with_setting;
use harvester_scene::method::{Failure, Options};
use harvester_scene::scene_file::{BumpStop, Model, Scene};

/// The harvester of a bump-stop scene.
pub(super) fn model_of(scene: &Scene) -> Result<&BumpStop, Failure> {
    match &scene.model {
        Model::BumpStop(model) => Ok(model),
        Model::ContactSeparation(_) | Model::Sliding(_) => {
            Err(Failure::of_file(scene, format!("scene = {:?}: must be \"bump-stop\" here", scene.name())))
        }
    }
}

/// Runs the scene from its start until `until` in s, or until the observer has `enough`.
pub(super) fn observed<O: Observer<f64>>(
    scene: &Scene,
    options: &Options,
    until: f64,
    observer: &mut O,
    enough: impl Fn(&O) -> bool,
) -> Result<(), Failure> {
    let model = model_of(scene)?;
    match bridge(scene.load) {
        Some(bridge) => with_load((scene, model, options), bridge, until, observer, enough),
        None => with_load((scene, model, options), resistance(scene.load), until, observer, enough),
    }
}

fn with_load<L: Circuit<f64>, O: Observer<f64>>(
    what: (&Scene, &BumpStop, &Options),
    load: L,
    until: f64,
    observer: &mut O,
    enough: impl Fn(&O) -> bool,
) -> Result<(), Failure> {
    let (scene, model, options) = what;
    let (harvester, start, [short, long]) = prepared::<f64, L, 20, 20>(what, load)?;
    let stepper = Stepper::new(harvester, short, long).map_err(refuse_step)?;
    let end = Instant::from_seconds(until)
        .ok_or_else(|| Failure::of_file(scene, format!("run: {until} s, must be below 16777216")))?;
    with_setting::<f64, Polynomial, _>(scene, options, |setting| {
        let excitation = setting.excitation;
        let mut state = stepper.start(&start, &excitation).map_err(|error| refuse_start(scene, &error))?;
        while state.clock < end && !enough(observer) {
            stepper.advance(&mut state, &excitation, end, 1 << 12, observer).map_err(|error| {
                let described = Report::<f64, Stepper<f64, AnyChoices<f64, L>, 20, 20>>::describe(
                    model,
                    &stepper.outputs(&state),
                );
                Failure::Step(format!("{error}: {described}"))
            })?;
        }
        Ok(())
    })
}
