//! Figure 7: one cluster of contacts, larger.

use super::motion::{CONTACT_FORCE, Motion, ROD, STOP_POINT};
use super::{Figure, Panel};
use crate::method::Failure;
use crate::outcome::{csv, number};
use crate::report::chart::{Axis, Chart, Curve, Mark};
use crate::report::svg::{BLUE, ORANGE, VERMILION};

const SIZE: (u32, u32) = (900, 560);
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
        Curve::new(name, colour, Mark::Line(width), tip.within(span, column, scale))
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
        plot(&format!("Figure 7, displacement: {base}"), "displacement [µm]", LOWEST, 7, places),
        plot(&format!("Figure 7, contact force: {base}"), "contact force [N]", 0.0, 6, vec![force]),
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
        panels: vec![Panel::new("figure-7", SIZE, plots)],
        table: Vec::new(),
        csv,
    })
}
