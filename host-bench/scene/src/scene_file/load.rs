//! `[load]`.
//!
//! A `preset` names a part and gives what the table does not: the diode drop, its quiescent current as leakage, the
//! thresholds of the draw. A constant power is then what the node consumes, and the draw what leaves the store for
//! it; a resistor or a current is at the store, with or without a preset.

use model_core::part::draw::{CurrentDraw, Lockout as CoreLockout, PowerDraw, ResistiveDraw};
use model_core::part::load::Resistor;
use model_core::part::preset::Preset;
use model_core::part::rectifier::FullBridge;
use model_core::part::storage::{DcBus, StorageCapacitor};

use super::bounds::{Short, Table};
use super::document::SceneError;
use super::preset;
use super::scene::{Draw, Load, Lockout, RectifiedStore};
use super::section::{Reader, Section};

/// Bounds of `[load]`.
const LOAD: &[Table] = &[
    Resistor::<f64>::BOUNDS,
    FullBridge::<f64, ()>::BOUNDS,
    StorageCapacitor::<f64, ()>::BOUNDS,
    DcBus::<f64>::BOUNDS,
];

/// The number of a draw, by its kind, and the thresholds.
const RESISTIVE_DRAW: &[Table] =
    &[&[("value", ResistiveDraw::<f64>::BOUNDS[0].1)], CoreLockout::<f64>::BOUNDS];
const CURRENT_DRAW: &[Table] = &[&[("value", CurrentDraw::<f64>::BOUNDS[0].1)], CoreLockout::<f64>::BOUNDS];
const POWER_DRAW: &[Table] =
    &[&[("value", PowerDraw::<f64>::BOUNDS[0].1)], PowerDraw::<f64>::BOUNDS, CoreLockout::<f64>::BOUNDS];

/// A part that a table may name.
type Part = Option<Preset<f64>>;
type DrawReader = fn(&mut Section<'_>, Part) -> Result<Draw, SceneError>;

/// Reads `[load]`, and the part that it names.
pub(super) fn load(mut section: Section<'_>) -> Result<(Load, Part), SceneError> {
    section.bounded_by(LOAD);
    let kinds: [(&str, Reader<(Load, Part)>); 3] =
        [("resistor", resistor), ("rectified-store", rectified_store), ("dc-bus", dc_bus)];
    let found = section.choice("kind", &kinds)?(&mut section)?;
    section.finish()?;
    Ok(found)
}

fn resistor(section: &mut Section<'_>) -> Result<(Load, Part), SceneError> {
    Ok((Load::Resistor { resistance_ohm: section.number("resistance_ohm")? }, None))
}

fn rectified_store(section: &mut Section<'_>) -> Result<(Load, Part), SceneError> {
    let part = preset::preset(section)?;
    let store = RectifiedStore {
        capacitance_f: section.number("capacitance_f")?,
        diode_drop_v: section.number_or("diode_drop_v", part.map(|part| part.diode_drop))?,
        leakage_ohm: section.number_or("leakage_ohm", part.map(|part| part.leakage_resistance()))?,
        initial_v: section.number("initial_v")?,
        draw: match section.optional_table("draw")? {
            Some(table) => draw(table, part)?,
            None => Draw::None,
        },
    };
    Ok((Load::RectifiedStore(store), part))
}

fn dc_bus(section: &mut Section<'_>) -> Result<(Load, Part), SceneError> {
    let part = preset::preset(section)?;
    let voltage_v = section.number("voltage_v")?;
    // A charger holds its input at a voltage from which it starts.
    if let Some(part) = part
        && let Some(lowest) = part.cold_start.filter(|lowest| voltage_v < *lowest)
    {
        let reason = format!("must be at least {} for a cold start of {:?}", Short(lowest), part.name);
        return Err(section.refuse("voltage_v", reason));
    }
    let diode_drop_v = section.number_or("diode_drop_v", part.map(|part| part.diode_drop))?;
    Ok((Load::DcBus { voltage_v, diode_drop_v }, part))
}

/// Reads `[load.draw]`.
fn draw(mut section: Section<'_>, part: Part) -> Result<Draw, SceneError> {
    let kinds: [(&str, DrawReader); 4] =
        [("none", |_, _| Ok(Draw::None)), ("resistor", resistive), ("current", current), ("power", power)];
    let draw = section.choice("kind", &kinds)?(&mut section, part)?;
    section.finish()?;
    Ok(draw)
}

fn resistive(section: &mut Section<'_>, part: Part) -> Result<Draw, SceneError> {
    section.bounded_by(RESISTIVE_DRAW);
    let resistance_ohm = section.number("value")?;
    // A resistor may stay connected down to an empty store: no thresholds, or both 0.
    let given = section.has("turn_on_v") || section.has("turn_off_v");
    let of_part = part.and_then(|part| part.lockout);
    let lockout = if given || of_part.is_some() { Some(thresholds(section, part)?) } else { None };
    let lockout = lockout.filter(|lockout| lockout.turn_on_v > 0.0 || lockout.turn_off_v > 0.0);
    let lockout = lockout.map(|lockout| check(section, lockout)).transpose()?;
    Ok(Draw::Resistor { resistance_ohm, lockout })
}

fn current(section: &mut Section<'_>, part: Part) -> Result<Draw, SceneError> {
    section.bounded_by(CURRENT_DRAW);
    let current_a = section.number("value")?;
    let lockout = thresholds(section, part)?;
    Ok(Draw::Current { current_a, lockout: check(section, lockout)? })
}

fn power(section: &mut Section<'_>, part: Part) -> Result<Draw, SceneError> {
    section.bounded_by(POWER_DRAW);
    let node_w = section.number("value")?;
    let power_w = part.map_or(node_w, |part| part.power_at_store(node_w));
    let lockout = thresholds(section, part)?;
    Ok(Draw::Power { power_w, lockout: check(section, lockout)? })
}

fn thresholds(section: &mut Section<'_>, part: Part) -> Result<Lockout, SceneError> {
    let of_part = part.and_then(|part| part.lockout);
    Ok(Lockout {
        turn_on_v: section.number_or("turn_on_v", of_part.map(|lockout| lockout.turn_on))?,
        turn_off_v: section.number_or("turn_off_v", of_part.map(|lockout| lockout.turn_off))?,
    })
}

/// Refuses thresholds without hysteresis.
fn check(section: &Section<'_>, lockout: Lockout) -> Result<Lockout, SceneError> {
    let Lockout { turn_on_v, turn_off_v } = lockout;
    if turn_off_v >= turn_on_v {
        return Err(section.refuse("turn_off_v", format!("must be below turn_on_v = {}", Short(turn_on_v))));
    }
    Ok(lockout)
}
