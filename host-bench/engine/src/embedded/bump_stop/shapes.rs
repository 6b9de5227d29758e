//! The shape of the beam at some instants of a run.

use model_core::clock::Instant;
use model_core::observer::{AcceptedStep, Observer};
use model_core::part::beam::{BeamMode, Cantilever};
use model_core::part::monomorph::Monomorph;
use model_core::scalar::Polynomial;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{AnyChoices, Circuit, Stepper};

use super::{Report, bridge, parameters, prepared, refuse_start, refuse_step, resistance};
use crate::embedded::excitation::with_setting;
use harvester_scene::method::{Failure, Options};
use harvester_scene::scene_file::{BumpStop, Model, Scene};

/// The deflected beam at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct DeflectedShape {
    /// Time in s: the end of the step that holds the instant.
    pub time_s: f64,
    /// Distance from the clamp in m, displacement relative to the base towards the stop in m.
    pub points: Vec<[f64; 2]>,
}

/// The beam at each of the `instants`, in s and rising, at `stations` places besides the clamp, by the sum
/// of its modes, on the embedded core in double precision.
pub fn deflected_shapes(
    scene: &Scene,
    options: &Options,
    instants: &[f64],
    stations: usize,
) -> Result<Vec<DeflectedShape>, Failure> {
    let Model::BumpStop(model) = &scene.model else {
        return Err(Failure::of_file(
            scene,
            format!("scene = {:?}: must be \"bump-stop\" here", scene.name()),
        ));
    };
    let core = parameters::<f64>(model, scene.load);
    let section = Monomorph::new(
        &core.substrate,
        &core.piezo,
        core.beam_width,
        core.piezo_d31,
        core.piezo_permittivity,
    );
    let beam = Cantilever {
        length: core.beam_length,
        bending_stiffness: section.bending_stiffness,
        mass_per_length: section.mass_per_length,
        tip_mass: 0.0,
    };
    let modes: Vec<BeamMode<f64>> =
        (1..).take(model.parameters.beam_modes).map(|number| beam.mode(number)).collect();
    let mut shapes = Shapes { modes, length: core.beam_length, stations, instants, found: Vec::new() };
    match bridge(scene.load) {
        Some(bridge) => shapes.take((scene, model, options), bridge)?,
        None => shapes.take((scene, model, options), resistance(scene.load))?,
    }
    Ok(shapes.found)
}

/// Takes the shape at the end of the step that holds each instant.
struct Shapes<'a> {
    modes: Vec<BeamMode<f64>>,
    length: f64,
    stations: usize,
    instants: &'a [f64],
    found: Vec<DeflectedShape>,
}

impl Shapes<'_> {
    /// Runs the scene until all are taken.
    fn take<L: Circuit<f64>>(&mut self, what: (&Scene, &BumpStop, &Options), load: L) -> Result<(), Failure> {
        let (scene, instants) = (what.0, self.instants);
        let (harvester, start, [short, long]) = prepared::<f64, L, 20, 20>(what, load)?;
        let stepper = Stepper::new(harvester, short, long).map_err(refuse_step)?;
        with_setting::<f64, Polynomial, _>(scene, what.2, |setting| {
            let excitation = setting.excitation;
            let mut state =
                stepper.start(&start, &excitation).map_err(|error| refuse_start(scene, &error))?;
            let last = instants.last().copied().unwrap_or(0.0);
            let end = Instant::from_seconds(last.max(scene.run.duration_s))
                .ok_or_else(|| Failure::of_file(scene, format!("run: {last} s, must be below 16777216")))?;
            // To the end of the last step that is wanted, and no step is cut short for it.
            while state.clock < end && self.found.len() < instants.len() {
                stepper.advance(&mut state, &excitation, end, 1 << 12, self).map_err(|error| {
                    let described = Report::<f64, Stepper<f64, AnyChoices<f64, L>, 20, 20>>::describe(
                        what.1,
                        &stepper.outputs(&state),
                    );
                    Failure::Step(format!("{error}: {described}"))
                })?;
            }
            Ok(())
        })
    }
}

impl Observer<f64> for Shapes<'_> {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        let time_s = step.until().seconds::<f64>();
        while self.instants.get(self.found.len()).is_some_and(|instant| *instant <= time_s) {
            let points = (0..=self.stations).map(|station| {
                let place = station as f64 / self.stations as f64;
                // The state has displacement and velocity of each mode in turn.
                let modes = self.modes.iter().zip(step.end.state.iter().step_by(2));
                let displacement = modes.map(|(mode, coordinate)| mode.shape(place).value * coordinate);
                [place * self.length, displacement.sum()]
            });
            self.found.push(DeflectedShape { time_s, points: points.collect() });
        }
    }
}
