//! Figure 7: one cluster of contacts, larger.

use super::motion::{CONTACT_FORCE, Motion, ROD, STOP_POINT};
use super::{Figure, Panel};
use crate::outcome::{csv, number};
use crate::report::plot::{Axis, Curve, Mark, Plot, height};
use crate::report::svg::{BLUE, ORANGE, VERMILION};

const SIZE: (u32, u32) = (900, 560);
/// Time in s that is shown before the first contact and after the last.
const BESIDE_S: f64 = 3e-5;
/// Displacement in µm down to which the beam is shown.
const LOWEST: f64 = -0.15;

/// Figure 7.
pub(super) fn seven(tip: &Motion, note: &str) -> Result<Figure, String> {
    let [first, last] = tip.longest_cluster().ok_or("no contact with the stop at the tip")?;
    let span = [first - BESIDE_S, last + BESIDE_S];
    let curve = |name, colour, width, column, scale| {
        Curve::new(name, colour, Mark::Line(width), tip.within(span, column, scale))
    };
    let places =
        vec![curve("rod", ORANGE, 2.6, ROD, 1e6), curve("tip of the beam", BLUE, 1.2, STOP_POINT, 1e6)];
    let force = curve("", VERMILION, 1.2, CONTACT_FORCE, 1.0);
    let contacts = force.points.windows(2).filter(|pair| pair[0].1 == 0.0 && pair[1].1 > 0.0).count();
    let rows = places[1].points.iter().zip(&places[0].points).zip(&force.points);
    let csv = csv(
        "time_s,stop_point_displacement_m,rod_tip_displacement_m,contact_force_n",
        rows.map(|((beam, rod), force)| {
            [span[0] + 1e-6 * beam.0, 1e-6 * beam.1, 1e-6 * rod.1, force.1].map(number)
        }),
    );
    let plot = |title: &str, up, lowest, ticks, curves: Vec<Curve>| Plot {
        title: title.to_owned(),
        across: Axis::linear("time [µs]", [0.0, 1e6 * (span[1] - span[0])], 12),
        up: Axis::linear(up, [lowest, height(&curves)[1]], ticks),
        curves,
    };
    let plots = [
        plot("Figure 7: displacement", "displacement [µm]", LOWEST, 7, places),
        plot("Contact force", "contact force [N]", 0.0, 6, vec![force]),
    ];
    Ok(Figure {
        label: "Figure 7",
        title: "Chattering impact between the beam and the stop",
        caption: format!(
            "One of the clusters of figure 6: displacement of the beam's tip and of the rod's face, and the force \
             between them. {contacts} contacts in {:.0} µs, of a few microseconds each; in between the beam leaves \
             the rod by a tenth of a micrometre to one, where it moves by eighteen in a period, and the rod rings on. \
             Where the force is not 0 the tip is a little beyond the rod's face, by the compliance of the modes left \
             out. The force is ours: \
             the paper shows the displacements. {note}",
            1e6 * (last - first)
        ),
        panels: vec![Panel::new("figure-7", SIZE, &plots)?],
        table: Vec::new(),
        csv,
    })
}
