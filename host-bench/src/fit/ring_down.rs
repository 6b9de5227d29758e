//! The displacement at the start of a ring-down, which is free.

use super::data::Data;
use super::free::{Free, Place};
use super::model::{Interpolation, displace, origin, record, with_trace};
use crate::method::{Failure, Options};
use crate::name::Name;
use crate::scene_file::{Scene, Summary};

/// Displacement of the first mode in √kg·m by which its displacement at the tip is measured.
const PROBE: f64 = 1e-6;
/// Displacement of the tip in m that a ring-down without a displacement begins with.
const TIP: f64 = 1e-4;
/// Factor from the start to the bounds.
const FARTHEST: f64 = 20.0;

/// Adds the displacement at the start of each ring-down, unless a displacement at the start is free already.
pub(super) fn free_starts(
    scene: &Scene,
    data: &[Data],
    options: &Options,
    free: &mut Vec<Free>,
) -> Result<(), Failure> {
    const KEYS: [&str; 4] = [
        "initial.gap_m",
        "initial.displacement_m",
        "initial.modal_displacement",
        "initial.rod_modal_displacement",
    ];
    if free.iter().any(|free| KEYS.iter().any(|key| free.name.starts_with(key))) {
        return Ok(());
    }
    let count = data.iter().filter(|data| data.is_ring_down()).count();
    let key = scene.model.summary().start_key;
    for (index, data) in data.iter().enumerate().filter(|(_, data)| data.is_ring_down()) {
        let start = start(scene, data, options)?;
        let of_file = Name::of_file(&data.file).line();
        let is_gap = scene.contact_separation().is_ok();
        let reach = FARTHEST * start.abs();
        free.push(Free {
            name: if count == 1 { key.to_owned() } else { format!("{key} of {of_file}") },
            place: Place::StartOf(index),
            start,
            low: if is_gap { 0.0 } else { -reach },
            high: reach,
            is_bounded: false,
            unit: Some(start.abs()),
        });
    }
    Ok(())
}

/// The first displacement of the data as the scene has it.
fn start(scene: &Scene, data: &Data, options: &Options) -> Result<f64, Failure> {
    let column = data.columns.iter().find(|column| column.name != "voltage_v");
    let first = column.and_then(|column| column.values.first()).copied();
    let with_default = |value: f64, default: f64| if value == 0.0 { default } else { value };
    if scene.bump_stop().is_err() {
        let Summary { rest_m, length_m, .. } = scene.model.summary();
        let usual = rest_m + 0.5 * length_m;
        return Ok(with_default(first.map_or(usual, |first| first + origin(scene, data)), usual));
    }
    let mut probed = with_trace(scene, data, Interpolation::Smooth);
    displace(&mut probed, PROBE);
    let tip = record(&probed, data, options)?.and_then(|rows| rows.first().map(|row| row[0]));
    let tip = tip.filter(|tip| *tip != 0.0).unwrap_or(PROBE);
    Ok(PROBE / tip * with_default(first.unwrap_or(TIP), TIP))
}
