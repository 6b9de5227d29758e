//! `[load]`.

use super::bounds::{self, Short};
use super::document::SceneError;
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

/// Reads `[load]`.
pub(super) fn load(mut section: Section<'_>) -> Result<Load, SceneError> {
    let kinds =
        [("resistor", Kind::Resistor), ("rectified-store", Kind::RectifiedStore), ("dc-bus", Kind::DcBus)];
    let load = match section.choice("kind", &kinds)? {
        Kind::Resistor => Load::Resistor { resistance_ohm: number(&mut section, "resistance_ohm")? },
        Kind::RectifiedStore => Load::RectifiedStore(RectifiedStore {
            capacitance_f: number(&mut section, "capacitance_f")?,
            diode_drop_v: number(&mut section, "diode_drop_v")?,
            leakage_ohm: number(&mut section, "leakage_ohm")?,
            initial_v: number(&mut section, "initial_v")?,
            draw: section.optional_table("draw")?.map_or(Ok(Draw::None), draw)?,
        }),
        Kind::DcBus => Load::DcBus {
            voltage_v: number(&mut section, "voltage_v")?,
            diode_drop_v: number(&mut section, "diode_drop_v")?,
        },
    };
    section.finish()?;
    Ok(load)
}

/// Reads `[load.draw]`.
fn draw(mut section: Section<'_>) -> Result<Draw, SceneError> {
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
            let lockout = if absent { None } else { Some(thresholds(&mut section)?) };
            let lockout = lockout.filter(|lockout| lockout.turn_on_v > 0.0);
            if let Some(lockout) = lockout {
                check(&section, lockout, 0.0)?;
            }
            Draw::Resistor { resistance_ohm, lockout }
        }
        DrawKind::Current => {
            let current_a = section.number("value", &bounds::of("draw.value of a current"))?;
            let lockout = thresholds(&mut section)?;
            Draw::Current { current_a, lockout: check(&section, lockout, 0.0)? }
        }
        DrawKind::Power => {
            let power_w = section.number("value", &bounds::of("draw.value of a power"))?;
            let lockout = thresholds(&mut section)?;
            Draw::Power { power_w, lockout: check(&section, lockout, LOWEST_POWER_VOLTAGE)? }
        }
    };
    section.finish()?;
    Ok(draw)
}

/// A constant power from a store below this voltage would be a current without bound.
const LOWEST_POWER_VOLTAGE: f64 = 1e-3;

fn thresholds(section: &mut Section<'_>) -> Result<Lockout, SceneError> {
    Ok(Lockout { turn_on_v: number(section, "turn_on_v")?, turn_off_v: number(section, "turn_off_v")? })
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
