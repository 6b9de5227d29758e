//! `[load]`.
//!
//! A `preset` names a part and gives what the table does not: the diode drop, its quiescent current as leakage, the
//! thresholds of the draw. A constant power is then what the node consumes, and the draw what leaves the store for
//! it; a resistor or a current is at the store, with or without a preset.

use model_core::part::preset::Preset;

use super::bounds::{self, Short};
use super::document::SceneError;
use super::preset;
use super::scene::{Draw, Load, Lockout, RectifiedStore};
use super::section::Section;

#[derive(Debug, Clone, Copy)]
enum Kind {
    Resistor,
    RectifiedStore,
    DcBus,
}

#[derive(Debug, Clone, Copy)]
enum DrawKind {
    None,
    Resistor,
    Current,
    Power,
}

/// Reads `[load]`, and the part that it names.
pub(super) fn load(mut section: Section<'_>) -> Result<(Load, Option<Preset<f64>>), SceneError> {
    let kinds =
        [("resistor", Kind::Resistor), ("rectified-store", Kind::RectifiedStore), ("dc-bus", Kind::DcBus)];
    let kind = section.choice("kind", &kinds)?;
    let part = match kind {
        Kind::Resistor => None,
        Kind::RectifiedStore | Kind::DcBus => preset::preset(&mut section)?,
    };
    let of_part = |value: fn(&Preset<f64>) -> f64| part.as_ref().map(value);
    let load = match kind {
        Kind::Resistor => Load::Resistor { resistance_ohm: number(&mut section, "resistance_ohm")? },
        Kind::RectifiedStore => Load::RectifiedStore(RectifiedStore {
            capacitance_f: number(&mut section, "capacitance_f")?,
            diode_drop_v: number_or(&mut section, "diode_drop_v", of_part(|part| part.diode_drop))?,
            leakage_ohm: number_or(&mut section, "leakage_ohm", of_part(Preset::leakage_resistance))?,
            initial_v: number(&mut section, "initial_v")?,
            draw: match section.optional_table("draw")? {
                Some(table) => draw(table, part.as_ref())?,
                None => Draw::None,
            },
        }),
        Kind::DcBus => Load::DcBus {
            voltage_v: bus_voltage(&mut section, part.as_ref())?,
            diode_drop_v: number_or(&mut section, "diode_drop_v", of_part(|part| part.diode_drop))?,
        },
    };
    section.finish()?;
    Ok((load, part))
}

/// The voltage of a bus; one that a charger holds at its input is at least its cold-start voltage.
fn bus_voltage(section: &mut Section<'_>, part: Option<&Preset<f64>>) -> Result<f64, SceneError> {
    let voltage = number(section, "voltage_v")?;
    match part
        .and_then(|part| part.cold_start.filter(|lowest| voltage < *lowest).map(|lowest| (part, lowest)))
    {
        Some((part, lowest)) => {
            let reason = format!("must be at least {} for a cold start of {:?}", Short(lowest), part.name);
            Err(section.refuse("voltage_v", reason))
        }
        None => Ok(voltage),
    }
}

/// Reads `[load.draw]`.
fn draw(mut section: Section<'_>, part: Option<&Preset<f64>>) -> Result<Draw, SceneError> {
    let kinds = [
        ("none", DrawKind::None),
        ("resistor", DrawKind::Resistor),
        ("current", DrawKind::Current),
        ("power", DrawKind::Power),
    ];
    let draw = match section.choice("kind", &kinds)? {
        DrawKind::None => Draw::None,
        DrawKind::Resistor => {
            let resistance_ohm = section.number("value", &bounds::of("draw.value of a resistor"))?;
            // A resistor may stay connected down to an empty store: no thresholds, or both 0.
            let absent = !section.has("turn_on_v") && !section.has("turn_off_v");
            let of_part = part.and_then(|part| part.lockout);
            let lockout =
                if absent && of_part.is_none() { None } else { Some(thresholds(&mut section, part)?) };
            let lockout = lockout.filter(|lockout| lockout.turn_on_v > 0.0 || lockout.turn_off_v > 0.0);
            if let Some(lockout) = lockout {
                check(&section, lockout, 0.0)?;
            }
            Draw::Resistor { resistance_ohm, lockout }
        }
        DrawKind::Current => {
            let current_a = section.number("value", &bounds::of("draw.value of a current"))?;
            let lockout = thresholds(&mut section, part)?;
            Draw::Current { current_a, lockout: check(&section, lockout, 0.0)? }
        }
        DrawKind::Power => {
            let node_w = section.number("value", &bounds::of("draw.value of a power"))?;
            let power_w = part.map_or(node_w, |part| part.power_at_store(node_w));
            let lockout = thresholds(&mut section, part)?;
            Draw::Power { power_w, lockout: check(&section, lockout, LOWEST_POWER_VOLTAGE)? }
        }
    };
    section.finish()?;
    Ok(draw)
}

/// A constant power from a store below this voltage would be a current without bound.
const LOWEST_POWER_VOLTAGE: f64 = 1e-3;

fn thresholds(section: &mut Section<'_>, part: Option<&Preset<f64>>) -> Result<Lockout, SceneError> {
    let of_part = part.and_then(|part| part.lockout);
    Ok(Lockout {
        turn_on_v: number_or(section, "turn_on_v", of_part.map(|lockout| lockout.turn_on))?,
        turn_off_v: number_or(section, "turn_off_v", of_part.map(|lockout| lockout.turn_off))?,
    })
}

/// Refuses thresholds without hysteresis, and a turn-off voltage below `lowest`.
fn check(section: &Section<'_>, lockout: Lockout, lowest: f64) -> Result<Lockout, SceneError> {
    let Lockout { turn_on_v, turn_off_v } = lockout;
    if turn_off_v < lowest {
        return Err(section.refuse("turn_off_v", format!("must be at least {}", Short(lowest))));
    }
    if turn_off_v >= turn_on_v {
        return Err(section.refuse("turn_off_v", format!("must be below turn_on_v = {}", Short(turn_on_v))));
    }
    Ok(lockout)
}

fn number(section: &mut Section<'_>, key: &'static str) -> Result<f64, SceneError> {
    section.number(key, &bounds::of(key))
}

/// A number that a part gives where the key does not.
fn number_or(section: &mut Section<'_>, key: &'static str, of_part: Option<f64>) -> Result<f64, SceneError> {
    section.number_or(key, &bounds::of(key), of_part)
}
