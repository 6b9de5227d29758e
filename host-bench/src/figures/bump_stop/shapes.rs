//! Figure 10: the deflected beam during contact.

use std::fmt::Write;

use plotters::style::RGBColor;
use rayon::prelude::*;

use super::motion::{Motion, options, spanned};
use super::{Figure, Panel};
use crate::embedded::{DeflectedShape, deflected_shapes};
use crate::method::Failure;
use crate::outcome::number;
use crate::report::plot::{self, Axis, Curve, Mark, Plot};
use crate::report::svg::{BLACK, BLUE, GREEN, ORANGE, VERMILION, range};
use crate::scene_file::Scene;

const SIZE: (u32, u32) = (560, 430);
const COLOURS: [RGBColor; 5] = [BLACK, GREEN, BLUE, ORANGE, VERMILION];
/// Places along the beam.
const STATIONS: usize = 100;
/// Parts of a cluster of contacts at which the beam is shown.
const PARTS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// The beam at some instants of the longest cluster of contacts.
pub(super) struct Cluster {
    first: f64,
    last: f64,
    shapes: Vec<DeflectedShape>,
}

/// With the stop at the tip and at mid-span.
pub(super) fn of(motions: [(&Scene, &Motion); 2], done: &(dyn Fn() + Sync)) -> Result<Vec<Cluster>, Failure> {
    let cluster = |&(scene, motion): &(&Scene, &Motion)| {
        let [first, last] =
            motion.longest_cluster().ok_or_else(|| Failure::of_file(scene, "there must be a contact"))?;
        let instants = PARTS.map(|part| first + part * (last - first));
        let (scene, _) = spanned(scene)?;
        let shapes = deflected_shapes(&scene, &options(), &instants, STATIONS);
        done();
        Ok(Cluster { first, last, shapes: shapes? })
    };
    motions.par_iter().map(cluster).collect()
}

/// Figure 10.
pub(super) fn ten(clusters: &[Cluster], note: &str) -> Result<Figure, String> {
    let drawn = |(letter, place): (char, &str), cluster: &Cluster| {
        let curves: Vec<Curve> = cluster
            .shapes
            .iter()
            .zip(COLOURS)
            .map(|(shape, colour)| Curve {
                name: format!("{:.0} µs", 1e6 * (shape.time_s - cluster.first)),
                colour,
                mark: Mark::Line(1.6),
                points: shape.points.iter().map(|[place, height]| (1e3 * place, 1e6 * height)).collect(),
            })
            .collect();
        let (low, high) = range(curves.iter().flat_map(|curve| &curve.points).map(|point| point.1));
        let length = curves.first().and_then(|curve| curve.points.last()).map_or(1.0, |point| point.0);
        let plot = Plot {
            title: format!("Figure 10 ({letter}): stop at {place}"),
            across: Axis::linear("distance from the clamp [mm]", [0.0, length], 6),
            up: Axis::linear("displacement towards the stop [µm]", [low, high], 8),
            curves,
        };
        Ok::<_, String>(Panel { name: format!("figure-10{letter}"), svg: plot::draw(SIZE, &[plot])? })
    };
    let places = [('a', "the tip"), ('b', "mid-span")];
    let panels: Result<Vec<Panel>, String> =
        places.into_iter().zip(clusters).map(|(place, cluster)| drawn(place, cluster)).collect();
    let lengths: Vec<String> =
        clusters.iter().map(|cluster| format!("{:.0}", 1e6 * (cluster.last - cluster.first))).collect();
    Ok(Figure {
        label: "Figure 10",
        title: "Deflected shapes of the beam during contact",
        caption: format!(
            "The beam from the first to the last contact of a cluster, of {} µs, with the stop (a) at the tip and (b) at \
             mid-span; the sum of its modes, relative to the base. At the tip the beam is clamped and pinned, and \
             bends between its ends. At mid-span its free half swings beyond the stop, and the slope of the tip, \
             with which the voltage goes, is larger. {note}",
            lengths.join(" and of ")
        ),
        panels: panels?,
        table: Vec::new(),
        csv: csv(places.map(|(_, place)| place), clusters),
    })
}

fn csv(places: [&str; 2], clusters: &[Cluster]) -> String {
    let mut text = String::from("stop,time_s,distance_m,displacement_m\n");
    for (place, cluster) in places.iter().zip(clusters) {
        for shape in &cluster.shapes {
            for point in &shape.points {
                let cells = [shape.time_s, point[0], point[1]].map(number);
                let _ = writeln!(text, "{place},{}", cells.join(","));
            }
        }
    }
    text
}
