//! Figures 7 and 10: one cluster of contacts, larger, and the deflected beam during contact.

use plotters::style::RGBColor;

use super::motion::{CONTACT_FORCE, Motion, ROD, STOP_POINT, options, spanned};
use super::{Figure, Panel, try_each_counted};
use crate::embedded::{DeflectedShape, ShapePoint, deflected_shapes};
use crate::method::Failure;
use crate::outcome::{csv, number};
use crate::report::chart::{Axis, Chart, Curve, FITTING, Mark};
use crate::report::svg::{BLACK, BLUE, GREEN, ORANGE, VERMILION};
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
    try_each_counted(&motions, done, |&(scene, motion)| {
        let [first, last] =
            motion.longest_cluster().ok_or_else(|| Failure::of_file(scene, "there must be a contact"))?;
        let instants = PARTS.map(|part| first + part * (last - first));
        let (scene, _) = spanned(scene)?;
        Ok(Cluster { first, last, shapes: deflected_shapes(&scene, &options(), &instants, STATIONS)? })
    })
}

pub(super) fn ten(clusters: &[Cluster], [base, note]: [&str; 2]) -> Figure {
    let drawn = |(letter, place): (char, &str), cluster: &Cluster| {
        let named = cluster.shapes.iter().map(|shape| {
            let points =
                shape.points.iter().map(|point| (1e3 * point.distance_m, 1e6 * point.displacement_m));
            (format!("{:.0} µs", 1e6 * (shape.time_s - cluster.first)), points)
        });
        let curves = Curve::distinct(&COLOURS, (Mark::line, 1.6), named);
        let length = curves.first().and_then(|curve| curve.points.last()).map_or(1.0, |point| point.0);
        let plot = Chart::new(
            format!("Figure 10 ({letter}): stop at {place}, {base}"),
            Axis::linear("distance from the clamp [mm]", [0.0, length], 6),
            Axis::linear("displacement towards the stop [µm]", FITTING, 8),
            curves,
        );
        Panel::new(format!("figure-10{letter}"), SIZE, [plot])
    };
    let places = [('a', "the tip"), ('b', "mid-span")];
    let lengths: Vec<String> =
        clusters.iter().map(|cluster| format!("{:.0}", 1e6 * (cluster.last - cluster.first))).collect();
    Figure {
        label: "Figure 10",
        title: "Deflected shapes of the beam during contact",
        caption: format!(
            "The beam from the first to the last contact of a cluster, of {} µs, with the stop (a) at the tip and (b) at \
             mid-span; the sum of its modes, relative to the base. At the tip the beam is clamped and pinned, and \
             bends between its ends. At mid-span its free half swings beyond the stop, and the slope of the tip, \
             with which the voltage goes, is larger. {note}",
            lengths.join(" and of ")
        ),
        panels: places.into_iter().zip(clusters).map(|(place, cluster)| drawn(place, cluster)).collect(),
        table: Vec::new(),
        csv: numbers(places.map(|(_, place)| place), clusters),
    }
}

fn numbers(places: [&str; 2], clusters: &[Cluster]) -> String {
    let rows = places.iter().zip(clusters).flat_map(|(place, cluster)| {
        cluster.shapes.iter().flat_map(move |shape| {
            let cells =
                move |point: &ShapePoint| [shape.time_s, point.distance_m, point.displacement_m].map(number);
            shape.points.iter().map(move |point| std::iter::once((*place).to_owned()).chain(cells(point)))
        })
    });
    csv("stop,time_s,distance_m,displacement_m", rows)
}

const CHATTER_SIZE: (u32, u32) = (900, 560);
/// Time in s that is shown before the longest contact and after its begin.
const BEFORE_S: f64 = 1.6e-3;
const AFTER_S: f64 = 1e-4;
/// Displacement in µm down to which the beam is shown.
const LOWEST: f64 = -0.6;

/// Figure 7; `gap` is that at rest in m.
pub(super) fn seven(tip: &Motion, gap: f64, [base, note]: [&str; 2]) -> Result<Figure, Failure> {
    let missing = |text: &str| Failure::Input(text.to_owned());
    let [first, last] =
        tip.longest_cluster().ok_or_else(|| missing("no contact with the stop at the tip"))?;
    let [rests, leaves] =
        tip.longest_contact([first, last]).ok_or_else(|| missing("no contact in the cluster"))?;
    let span = [rests - BEFORE_S, rests + AFTER_S];
    let curve = |name, colour, width, column, scale| {
        Curve::new(name, colour, Mark::line(0, width), tip.within(span, column, scale))
    };
    let mut beam = curve("tip of the beam", BLUE, 1.2, STOP_POINT, 1e6);
    beam.points.iter_mut().for_each(|point| point.1 -= 1e6 * gap);
    let places = vec![curve("rod", ORANGE, 2.6, ROD, 1e6), beam];
    let force = curve("", VERMILION, 1.2, CONTACT_FORCE, 1.0);
    let contacts = force.points.windows(2).filter(|pair| pair[0].1 == 0.0 && pair[1].1 > 0.0).count();
    let rows = places[1].points.iter().zip(&places[0].points).zip(&force.points);
    let csv = csv(
        "time_s,stop_point_beyond_the_gap_m,rod_tip_displacement_m,contact_force_n",
        rows.map(|((beam, rod), force)| {
            [span[0] + 1e-6 * beam.0, 1e-6 * beam.1, 1e-6 * rod.1, force.1].map(number)
        }),
    );
    let plot = |title: &str, up, lowest, ticks, curves: Vec<Curve>| {
        Chart::new(
            title,
            Axis::linear("time [µs]", [0.0, 1e6 * (span[1] - span[0])], 12),
            Axis::linear(up, [lowest, f64::NAN], ticks),
            curves,
        )
    };
    let plots = [
        plot(&format!("Figure 7: {base}"), "displacement [µm]", LOWEST, 7, places),
        plot("", "contact force [N]", 0.0, 6, vec![force]),
    ];
    Ok(Figure {
        label: "Figure 7",
        title: "Chattering impact between the beam and the stop",
        caption: format!(
            "From one of the contact phases of figure 6, of {:.1} ms: displacement of the beam's tip beyond the gap and \
             of the rod's face, and the force between them. {contacts} contacts in {:.1} ms, most of a few microseconds; \
             then the beam rests on the rod for {:.1} ms, and leaves it after more contacts. Between two contacts the \
             rod rings on. Where the force is not 0 the tip is a little beyond the rod's face, by the compliance of the \
             modes left out. The force is ours: the paper shows the displacements. {note}",
            1e3 * (last - first),
            1e3 * (BEFORE_S + AFTER_S),
            1e3 * (leaves - rests)
        ),
        panels: vec![Panel::new("figure-7", CHATTER_SIZE, plots)],
        table: Vec::new(),
        csv,
    })
}
