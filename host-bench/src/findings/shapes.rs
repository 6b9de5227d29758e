//! The deflected beam of the second paper: findings 14 to 17.

use super::phases::Phases;
use super::runs::{Changes, Loader, NEAR_RESONANCE, OFF_RESONANCE, bump_stop, each_of, value};
use super::statistics::{largest, mean};
use super::{Bound::*, Measured, check};
use crate::embedded::{DeflectedShape, ShapePoint, bump_stop_parameters, deflected_shapes};
use crate::method::{Failure, Options};
use crate::scene_file::Scene;

/// Places along the beam besides the clamp; a multiple of 4.
const STATIONS: usize = 60;
/// Distance of the shapes in s.
const EVERY_S: f64 = 5e-5;
/// The window: 22 periods of 44 Hz after 22, 110 of 220 Hz after 110.
const WINDOW: Changes<'static> = &[("run.settle_s", "0.5"), ("run.duration_s", "1.0")];

/// The shapes of a scene over its measuring window, `every_s` seconds apart.
fn shapes(scene: &Scene, every_s: f64, stations: usize) -> Result<Vec<DeflectedShape>, Failure> {
    let count = (scene.run.window_s() / every_s).round() as usize;
    let instants: Vec<f64> = (1..=count).map(|index| scene.run.settle_s + every_s * index as f64).collect();
    deflected_shapes(scene, &Options::default(), &instants, stations)
}

/// The beam of a scene with a stop, in contact.
struct InContact {
    /// Means over the chattering phases: curvature in 1/m at the clamp and at three quarters of the length, slope of the tip.
    clamp: f64,
    outside: f64,
    tip_slope: f64,
    /// Mean magnitude of the curvature in 1/m over the contact phases and the length.
    bending: f64,
}

impl InContact {
    fn of(scene: &Scene) -> Result<Self, Failure> {
        let phases = Phases::new(scene)?;
        let shapes = shapes(scene, EVERY_S, STATIONS)?;
        let spans = phases.spans();
        let is_chattering = |shape: &&DeflectedShape| {
            spans.iter().any(|[begins, ends]| (*begins..=*ends).contains(&shape.time_s))
        };
        let at = |station: usize, pick: fn(&ShapePoint) -> f64| {
            mean(
                shapes
                    .iter()
                    .filter(is_chattering)
                    .map(|shape| shape.points.get(station).map_or(f64::NAN, pick)),
            )
        };
        let near = phases.contains(shapes.iter().map(|shape| shape.time_s));
        let touching = shapes.iter().zip(near).filter(|(_, near)| *near);
        Ok(Self {
            clamp: at(0, |point| point.curvature_per_m),
            outside: at(3 * STATIONS / 4, |point| point.curvature_per_m),
            tip_slope: at(STATIONS, |point| point.slope),
            bending: mean(
                touching.map(|(shape, _)| mean(shape.points.iter().map(|point| point.curvature_per_m.abs()))),
            ),
        })
    }
}

/// Findings 14, 15 and 17.
pub(super) fn measure(loader: Loader<'_>) -> Result<Measured, Failure> {
    let [tip, mid] = with_stop(loader, OFF_RESONANCE)?;
    let [near_tip, near_mid] = with_stop(loader, NEAR_RESONANCE)?;
    let (paper, near) =
        rayon::join(|| clamp_ratios(loader, OFF_RESONANCE), || clamp_ratios(loader, NEAR_RESONANCE));
    Ok(vec![
        check("14", "tip stop: curvature at 3L/4 / at the clamp", [tip.outside / tip.clamp], Below(0.0)),
        check(
            "14",
            "slope of the tip, tip stop / mid-span",
            [(tip.tip_slope / mid.tip_slope).abs()],
            Reported,
        ),
        check("15", "mean curvature in contact, tip / mid-span", [tip.bending / mid.bending], Below(0.85)),
        check("15", "at 220 Hz", [near_tip.bending / near_mid.bending], Reported),
        check("17", "at 220 Hz: peak curvature at the clamp / none, tip and mid-span", near?, Below(0.7)),
        check("17", "at 44 Hz", paper?, Reported),
    ])
}

fn with_stop(loader: Loader<'_>, [tip, mid, _]: [&str; 3]) -> Result<[InContact; 2], Failure> {
    each_of([tip, mid], |name| InContact::of(&loader.scene(name, WINDOW)?))
}

/// Largest curvature at the clamp with the stop at the tip and at mid-span over that without a stop.
fn clamp_ratios(loader: Loader<'_>, names: [&str; 3]) -> Result<[f64; 2], Failure> {
    let [tip, mid, none] = each_of(names, |name| {
        let outcome = loader.run(name, WINDOW)?;
        Ok(value(bump_stop(&outcome)?.clamp.map(|clamp| clamp.clamp_curvature_peak_per_m)))
    })?;
    Ok([tip / none, mid / none])
}

/// Finding 16: the voltage of the open circuit is that of the charge by the slope of the tip, `ν y'(L)/C`.
pub(super) fn measure_charge(loader: Loader<'_>) -> Result<Measured, Failure> {
    let [tip, mid, none] = each_of(OFF_RESONANCE, |name| {
        let scene = loader.scene(
            name,
            &[("load.resistance_ohm", "inf"), ("run.settle_s", "0"), ("run.duration_s", "0.05")],
        )?;
        let core = bump_stop_parameters::<f64>(scene.bump_stop()?, scene.load);
        let section = core.section();
        let per_slope = section.coupling / (section.capacitance_per_length * core.beam_length);
        let shapes = shapes(&scene, EVERY_S, 1)?;
        let voltage =
            |shape: &DeflectedShape| shape.points.last().map_or(f64::NAN, |tip| per_slope * tip.slope);
        let error = largest(shapes.iter().map(|shape| (shape.voltage_v - voltage(shape)).abs()));
        Ok(error / largest(shapes.iter().map(|shape| shape.voltage_v.abs())))
    })?;
    Ok(vec![check(
        "16",
        "open circuit: largest |v − ν y'(L)/C| / peak voltage",
        [tip, mid, none],
        Below(1e-9),
    )])
}
