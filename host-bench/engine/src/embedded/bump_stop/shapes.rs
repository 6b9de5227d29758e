//! The shape of the beam at some instants of a run.

use model_core::observer::{AcceptedStep, Observer};
use model_core::part::beam::{BeamMode, Shape};

use super::observed::{model_of, observed};
use super::parameters;
use harvester_scene::method::{Failure, Options};
use harvester_scene::scene_file::Scene;

/// The beam at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapePoint {
    /// Distance from the clamp in m.
    pub distance_m: f64,
    /// Displacement relative to the base in m, positive towards the stop.
    pub displacement_m: f64,
    /// Slope `dy/dx`.
    pub slope: f64,
    /// Curvature `d²y/dx²` in 1/m.
    pub curvature_per_m: f64,
}

/// The deflected beam at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct DeflectedShape {
    /// Time in s: the end of the step that holds the instant.
    pub time_s: f64,
    /// Terminal voltage in V at this time.
    pub voltage_v: f64,
    /// The places, from the clamp to the tip.
    pub points: Vec<ShapePoint>,
}

/// The beam at each of the `instants`, in s and rising, at `stations` places besides the clamp, by the sum
/// of its modes, on the embedded core in double precision.
pub fn deflected_shapes(
    scene: &Scene,
    options: &Options,
    instants: &[f64],
    stations: usize,
) -> Result<Vec<DeflectedShape>, Failure> {
    let model = model_of(scene)?;
    let core = parameters::<f64>(model, scene.load);
    let modes: Vec<BeamMode<f64>> =
        (1..).take(model.parameters.beam_modes).map(|number| core.beam_mode(number)).collect();
    let station = |station: usize| {
        let place = station as f64 / stations as f64;
        (place * core.beam_length, modes.iter().map(|mode| mode.shape(place)).collect())
    };
    let mut shapes = Shapes {
        length: core.beam_length,
        stations: (0..=stations).map(station).collect(),
        instants,
        found: Vec::new(),
    };
    let last = instants.last().copied().unwrap_or(0.0);
    // To the end of the last step that is wanted, and no step is cut short for it.
    let until = last.max(scene.run.duration_s);
    observed(scene, options, until, &mut shapes, |shapes| shapes.found.len() == instants.len())?;
    Ok(shapes.found)
}

/// Takes the shape at the end of the step that holds each instant.
struct Shapes<'a> {
    length: f64,
    /// Distance from the clamp in m, and the shape of each mode there.
    stations: Vec<(f64, Vec<Shape<f64>>)>,
    instants: &'a [f64],
    found: Vec<DeflectedShape>,
}

impl Shapes<'_> {
    /// The beam at a station for the state of the modes: displacement and velocity of each in turn.
    fn point(&self, (distance_m, modes): &(f64, Vec<Shape<f64>>), state: &[f64]) -> ShapePoint {
        let sum = |weight: fn(&Shape<f64>) -> f64| {
            let terms = modes.iter().zip(state.iter().step_by(2));
            terms.map(|(mode, coordinate)| weight(mode) * coordinate).sum::<f64>()
        };
        ShapePoint {
            distance_m: *distance_m,
            displacement_m: sum(|shape| shape.value),
            slope: sum(|shape| shape.slope) / self.length,
            curvature_per_m: sum(|shape| shape.curvature) / (self.length * self.length),
        }
    }
}

impl Observer<f64> for Shapes<'_> {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        let time_s = step.until().seconds::<f64>();
        while self.instants.get(self.found.len()).is_some_and(|instant| *instant <= time_s) {
            let points = self.stations.iter().map(|station| self.point(station, step.end.state));
            let points = points.collect();
            self.found.push(DeflectedShape { time_s, voltage_v: step.end.voltage, points });
        }
    }
}
