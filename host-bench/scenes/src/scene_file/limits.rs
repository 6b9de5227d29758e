//! The limits of the models: the table of their keys, `[limits]`, with what is beyond each. Their sources are in docs/limits.md.

use super::document::SceneError;
use super::key::{Key, Table, between, number};
use super::section::Section;

/// Key in `[limits]`, what happens beyond the limit, and the estimated relative error of the result at a value above a limit;
/// `None` where nothing real is beyond it.
pub(crate) type Limit = (Key, &'static str, Option<fn(f64, f64) -> f64>);

const PRESSURE: Limit = (
    number("pressure_pa", "Pa", between(1.0, 1e7), "Pressure of the air in the gap").or_number(101_325.0),
    "the air in the gap breaks down",
    None,
);
const FRINGING: Limit = (
    number("fringing", "1", between(1e-4, 10.0), "Part of the capacitance beyond the edges").or_number(0.1),
    "the plates are small, and the capacitance at the largest gap is above that of a uniform field",
    Some(|value, _| value),
);
const CONTACT_SPEED: Limit = (
    number("contact_speed_m_per_s", "m/s", between(1e-6, 1e4), "Speed of elastic contacts").or_number(1.0),
    "contacts are plastic, and restitution falls as the fourth root of the speed",
    Some(|value, limit| 1.0 - (limit / value).powf(0.25)),
);
const STRAIN: Limit = (
    number("strain", "1", between(1e-6, 1.0), "Strain that the beam bears; spring steel").or_number(5e-3),
    "the beam yields or breaks",
    None,
);
const PIEZO_STRAIN: Limit = (
    number("piezo_strain", "1", between(1e-6, 1.0), "Strain that the layer bears; PZT-5A").or_number(2.1e-3),
    "the piezoelectric layer breaks",
    None,
);
const PIEZO_FIELD: Limit = (
    number("piezo_field_v_per_m", "V/m", between(1.0, 1e9), "Field that depoles; PZT-5A").or_number(6e5),
    "the piezoelectric layer is depoled",
    None,
);
const SLOPE: Limit = (
    number("slope_rad", "rad", between(1e-4, 1.5), "Slope of the tip in linear bending").or_number(0.1),
    "bending is not linear",
    Some(|value, _| 0.5 * value * value),
);
const ALL: [Limit; 7] = [PRESSURE, FRINGING, CONTACT_SPEED, STRAIN, PIEZO_STRAIN, PIEZO_FIELD, SLOPE];

pub(super) static CONTACT_SEPARATION: Table = Table::of(&[PRESSURE.0, FRINGING.0, CONTACT_SPEED.0]);
pub(super) static SLIDING: Table = Table::of(&[STRAIN.0, SLOPE.0]);
pub(super) static BUMP_STOP: Table =
    Table::of(&[STRAIN.0, PIEZO_STRAIN.0, PIEZO_FIELD.0, SLOPE.0, CONTACT_SPEED.0]);

/// Name of the quantity that a key of `[limits]` limits.
fn compared(key: &'static str) -> &'static str {
    if key == "pressure_pa" { "gap_voltage_v" } else { key }
}

pub(crate) fn of_name(name: &str) -> Option<Limit> {
    ALL.into_iter().find(|(key, ..)| compared(key.name) == name)
}

/// Reads `[limits]`: the name of each compared quantity, and its limit.
pub(super) fn limits(mut section: Section<'_>) -> Result<Vec<(&'static str, f64)>, SceneError> {
    let keys = section.table.keys.iter();
    let read =
        keys.map(|key| Ok((compared(key.name), section.number(key.name)?))).collect::<Result<_, _>>()?;
    section.finish().map(|()| read)
}

/// Breakdown voltage in V of air by Paschen's curve at a product of pressure and gap in Pa·m, with Townsend's constants
/// 15 /(cm·Torr), 365 V/(cm·Torr), and 0.01 electrons per ion; infinite below that of the minimum, 305 V at 1.115 Pa·m.
pub fn breakdown_voltage_v(pressure_gap_pa_m: f64) -> f64 {
    let logarithm = (11.25 * pressure_gap_pa_m / 101f64.ln()).ln();
    if logarithm < 1.0 { f64::INFINITY } else { 273.8 * pressure_gap_pa_m / logarithm }
}

/// Part of the capacitance of two round plates that the field beyond their edges adds, with the `distance_m` of the plates in
/// vacuum and their area: Kirchhoff's formula with its next term for near plates, and 4 ε0 R as of two far ones.
pub fn fringing(distance_m: f64, area_m2: f64) -> f64 {
    let distance = distance_m / (std::f64::consts::PI * area_m2).sqrt();
    let logarithm = (16.0 / distance).ln().max(std::f64::consts::SQRT_2);
    let near = distance * (logarithm - 1.0 + 0.25 * distance * (logarithm * logarithm - 2.0));
    if distance > 0.0 { near.max(4.0 * distance - 1.0) } else { 0.0 }
}
