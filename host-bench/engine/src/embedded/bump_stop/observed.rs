//! Runs of a bump-stop scene for an observer of the host, in double precision.

use model_core::observer::{AcceptedStep, Event, Observer};
use model_core::part::beam::{BeamMode, Shape};
use model_core::scalar::Polynomial;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{Circuit, Stepper};

use super::super::excitation::with_setting;
use super::super::run::instant;
use super::{METHOD, Run, bridge, parameters, prepared, refuse_start, refuse_step, resistance};
use harvester_scene::method::{Failure, Options};
use harvester_scene::scene_file::{BumpStop, Scene};

/// Runs the scene from its start until `until` in s, or until the observer has `enough`.
pub(super) fn observed<O: Observer<f64>>(
    scene: &Scene,
    options: &Options,
    until: f64,
    observer: &mut O,
    enough: impl Fn(&O) -> bool,
) -> Result<(), Failure> {
    let model = scene.bump_stop()?;
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
    let end = instant(scene, until)?;
    with_setting::<f64, Polynomial, _>(scene, options, |setting| {
        let excitation = setting.excitation;
        let run = Run { setting, harvester: &stepper, report: model, method: METHOD };
        let mut state = stepper.start(&start, &excitation).map_err(|error| refuse_start(scene, &error))?;
        while state.clock < end && !enough(observer) {
            let advanced = stepper.advance(&mut state, &excitation, end, 1 << 12, observer);
            advanced.map_err(|error| run.step_failure(error, &state))?;
        }
        Ok(())
    })
}

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
    let model = scene.bump_stop()?;
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

/// An interval of the run in which beam and stop touch, in s; of no length for a rigid impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactInterval {
    /// Time in s at which the contact begins.
    pub begins_s: f64,
    /// Time in s at which it ends.
    pub ends_s: f64,
}

impl ContactInterval {
    pub fn length_s(&self) -> f64 {
        self.ends_s - self.begins_s
    }
}

/// Longest pause within a chattering phase, in periods of the base.
const PAUSE: f64 = 0.125;

/// The chattering phases of some contacts in order of time: contacts less than an eighth of the period in s apart.
pub fn chattering_phases(
    contacts: &[ContactInterval],
    period_s: f64,
) -> impl Iterator<Item = &[ContactInterval]> {
    contacts.chunk_by(move |one, next| next.begins_s - one.ends_s < PAUSE * period_s)
}

/// The contacts of a bump-stop scene that begin in its measuring window, in order of time, on the embedded core in double precision.
pub fn contact_intervals(scene: &Scene, options: &Options) -> Result<Vec<ContactInterval>, Failure> {
    let mut contacts = Contacts { from_s: scene.run.settle_s, closed: false, found: Vec::new() };
    observed(scene, options, scene.run.duration_s, &mut contacts, |_| false)?;
    Ok(contacts.found)
}

/// Collects the contacts that begin after an instant.
struct Contacts {
    from_s: f64,
    /// Whether the last step ended in contact.
    closed: bool,
    found: Vec<ContactInterval>,
}

impl Contacts {
    /// A contact from one instant to another, both in s; `continues` the last one.
    fn add(&mut self, begins_s: f64, ends_s: f64, continues: bool) {
        match self.found.last_mut() {
            Some(last) if continues => last.ends_s = ends_s,
            _ if begins_s >= self.from_s && !continues => {
                self.found.push(ContactInterval { begins_s, ends_s })
            }
            _ => {}
        }
    }
}

impl Observer<f64> for Contacts {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        let touches = step.contact.force > 0.0;
        if touches {
            let from_s = step.from.seconds::<f64>();
            let at = |fraction: f64| from_s + fraction * step.step;
            self.add(at(step.contact.begins), at(step.contact.ends), self.closed);
        }
        self.closed = touches && step.end.in_contact;
    }

    fn event(&mut self, event: &Event<'_, f64>) {
        if event.impact_speed.is_some() {
            let at = event.at.seconds::<f64>();
            self.add(at, at, false);
            // A contact that begins with the impact is the same contact.
            self.closed = true;
        }
    }
}
