//! Figure 11: charging a storage capacitor through a full bridge.

use super::{Figure, Panel, try_each_counted};
use crate::method::{Failure, Options};
use crate::outcome::{csv, number};
use crate::report::chart::{Axis, Chart, Curve, Mark};
use crate::report::svg::{BLACK, BLUE, VERMILION};
use crate::run::run_scene;
use crate::scene_file::{Load, Scene};

const SIZE: (u32, u32) = (900, 420);
/// Distance of the points of a curve in s.
const EVERY_S: f64 = 0.02;
/// Instants of the table in s.
const INSTANTS_S: [f64; 4] = [0.5, 1.0, 2.0, 5.0];

/// The voltage of the storage over time.
pub(super) struct Charging {
    /// Capacitance in F.
    capacitance: f64,
    /// Time in s, voltage in V.
    points: Vec<(f64, f64)>,
}

/// Charges the storage of `charging` over its run, in each of the scenes.
pub(super) fn of(
    charging: &Scene,
    scenes: &[Scene],
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Charging>, Failure> {
    let Load::RectifiedStore(store) = charging.load else {
        return Err(Failure::of_file(charging, "load.kind must be \"rectified-store\""));
    };
    try_each_counted(scenes, done, |scene| {
        let scene = Scene { load: charging.load, run: charging.run, ..scene.clone() };
        let outcome = run_scene(&scene, &Options { trace_every_s: Some(EVERY_S), ..Options::default() })?;
        let rows = outcome.trace.map(|trace| trace.rows).unwrap_or_default();
        let point = |row: &Vec<f64>| Some((*row.first()?, *row.last()?));
        Ok(Charging { capacitance: store.capacitance_f, points: rows.iter().filter_map(point).collect() })
    })
}

impl Charging {
    /// The voltage in V at an instant in s that has a point.
    fn at(&self, instant: f64) -> Option<f64> {
        let near = |point: &&(f64, f64)| (point.0 - instant).abs() < 0.5 * EVERY_S;
        self.points.iter().find(near).map(|(_, voltage)| *voltage)
    }
}

/// Figure 11, of the storage with the stop at the tip, at mid-span, and without one.
pub(super) fn eleven([tip, mid, none]: [&Charging; 3], [base, note]: [&str; 2]) -> Figure {
    let cases = [("no stop", none), ("stop at mid-span", mid), ("stop at the tip", tip)];
    let named = cases.map(|(name, of)| (name, of.points.iter().copied()));
    let curves = Curve::distinct(&[BLUE, BLACK, VERMILION], (Mark::line, 1.6), named);
    let last = curves.iter().flat_map(|curve| &curve.points).map(|point| point.0).fold(0.0, f64::max);
    let plot = Chart::new(
        format!("Figure 11: {base}"),
        Axis::linear("time since the start [s]", [0.0, last], 6),
        Axis::linear("voltage of the storage [V]", [0.0, f64::NAN], 6),
        curves,
    );
    let row = |(name, of): &(&str, &Charging)| {
        let [half, one, two, five] = INSTANTS_S.map(|instant| of.at(instant).unwrap_or(f64::NAN));
        let energy = 0.5e6 * of.capacitance * five * five;
        let [half, one, two, five] = [half, one, two, five].map(|voltage| format!("{voltage:.3}"));
        [(*name).to_owned(), half, one, two, five, format!("{energy:.0}")]
    };
    let headings = ["stop", "0.5 s [V]", "1 s [V]", "2 s [V]", "5 s [V]", "stored after 5 s [µJ]"];
    let rows = cases.iter().flat_map(|(name, of)| {
        of.points.iter().map(|(time, voltage)| [(*name).to_owned(), number(*time), number(*voltage)])
    });
    Figure {
        label: "Figure 11",
        title: "Storage capacitor behind a full bridge",
        caption: format!(
            "Voltage of a storage capacitor of {:.1} µF that is charged from 0 through a full bridge, in place of the \
             resistor. The paper shows the circuit and proposes the energy stored in a given time as a measure; the curves \
             are of this library. {note}",
            1e6 * tip.capacitance
        ),
        panels: vec![Panel::new("figure-11", SIZE, [plot])],
        table: crate::figures::table(headings, cases.iter().map(row)),
        csv: csv("stop,time_s,store_voltage_v", rows),
    }
}
