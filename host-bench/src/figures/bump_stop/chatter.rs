//! Figure 7: one cluster of contacts, larger.

use std::fmt::Write;

use super::motion::{CONTACT_FORCE, Motion, ROD, STOP_POINT};
use super::{Figure, Panel};
use crate::outcome::number;
use crate::report::plot::{self, Axis, Curve, Mark, Plot};
use crate::report::svg::{BLUE, ORANGE, VERMILION, range};

const SIZE: (u32, u32) = (900, 560);
/// Time in s that is shown before the first contact and after the last.
const BESIDE_S: f64 = 3e-5;
/// Displacement in µm down to which the beam is shown.
const LOWEST: f64 = -0.15;

/// Figure 7.
pub(super) fn seven(tip: &Motion, note: &str) -> Result<Figure, String> {
    let [first, last] = tip.longest_cluster().ok_or("no contact with the stop at the tip")?;
    let span = [first - BESIDE_S, last + BESIDE_S];
    let points = |column, scale| tip.within(span, column, scale);
    let (beam, rod, force) = (points(STOP_POINT, 1e6), points(ROD, 1e6), points(CONTACT_FORCE, 1.0));
    let contacts = force.windows(2).filter(|pair| pair[0].1 == 0.0 && pair[1].1 > 0.0).count();
    let across = || Axis::linear("time [µs]", [0.0, 1e6 * (span[1] - span[0])], 12);
    let (_, high) = range(beam.iter().chain(&rod).map(|point| point.1));
    let (_, most) = range(force.iter().map(|point| point.1));
    let curve = |name: &str, colour, width, points: &[(f64, f64)]| Curve {
        name: name.to_owned(),
        colour,
        mark: Mark::Line(width),
        points: points.to_vec(),
    };
    let plots = [
        Plot {
            title: "Figure 7: displacement".to_owned(),
            across: across(),
            up: Axis::linear("displacement [µm]", [LOWEST, high], 7),
            curves: vec![curve("rod", ORANGE, 2.6, &rod), curve("tip of the beam", BLUE, 1.2, &beam)],
        },
        Plot {
            title: "Contact force".to_owned(),
            across: across(),
            up: Axis::linear("contact force [N]", [0.0, most], 6),
            curves: vec![curve("", VERMILION, 1.2, &force)],
        },
    ];
    let mut csv = String::from("time_s,stop_point_displacement_m,rod_tip_displacement_m,contact_force_n\n");
    for ((beam, rod), force) in beam.iter().zip(&rod).zip(&force) {
        let cells = [span[0] + 1e-6 * beam.0, 1e-6 * beam.1, 1e-6 * rod.1, force.1].map(number);
        let _ = writeln!(csv, "{}", cells.join(","));
    }
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
        panels: vec![Panel { name: "figure-7".to_owned(), svg: plot::draw(SIZE, &plots)? }],
        table: Vec::new(),
        csv,
    })
}
