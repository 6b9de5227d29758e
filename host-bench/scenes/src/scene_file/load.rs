//! `[load]`.
//!
//! A `preset` names a part and gives what the table does not: the diode drop, its quiescent current as leakage, the
//! thresholds of the draw. A constant power is then what the node consumes, and the draw what leaves the store for
//! it; a resistor or a current is at the store, with or without a preset.

use model_core::part::draw::{CurrentDraw, Lockout as CoreLockout, PowerDraw, ResistiveDraw};
use model_core::part::load::Resistor;
use model_core::part::rectifier::FullBridge;
use model_core::part::storage::{DcBus, StorageCapacitor};

use super::document::SceneError;
use super::key::{CoreTable, Default, Key, Kind, Short, Table, Value, core, number, other};
use super::scene::{Draw, Load, Lockout, RectifiedStore};
use super::section::{Reader, Section};
use crate::market::Preset;

const STORE: CoreTable = StorageCapacitor::<f64, ()>::BOUNDS;
const OF_PART: &str = "the preset's, else required";

pub(super) static TABLE: Table = Table::of_kinds(&[&RESISTOR, &DC_BUS, &RECTIFIED_STORE]);

static RESISTOR: Kind = Kind {
    word: "resistor",
    meaning: "A resistor",
    keys: &[other(
        "resistance_ohm",
        Value::NumberOrLimits(core(Resistor::<f64>::BOUNDS, "resistance")),
        "Resistance; 0: short circuit, inf: open circuit",
    )
    .unit("Ω")],
};
static DC_BUS: Kind = Kind {
    word: "dc-bus",
    meaning: "A full bridge into a bus of constant voltage",
    keys: &[
        number("voltage_v", "V", core(DcBus::<f64>::BOUNDS, "bus.voltage"), "Voltage of the bus")
            .limit("at least the preset's cold-start voltage"),
        DIODE_DROP,
        PRESET,
    ],
};
static RECTIFIED_STORE: Kind = Kind {
    word: "rectified-store",
    meaning: "A full bridge into a storage capacitor",
    keys: &[
        number("capacitance_f", "F", core(STORE, "storage.capacitance"), "Capacitance of the storage"),
        DIODE_DROP,
        number(
            "leakage_ohm",
            "Ω",
            core(STORE, "storage.leakage_resistance"),
            "Leakage resistance; inf: no leakage",
        )
        .or_said(OF_PART),
        number(
            "initial_v",
            "V",
            core(STORE, "storage.initial_voltage"),
            "Voltage of the storage at the start",
        ),
        PRESET,
        other("draw", Value::Table(&DRAW), "What the node draws from the storage").or_said("no draw"),
    ],
};
const DIODE_DROP: Key = number(
    "diode_drop_v",
    "V",
    core(FullBridge::<f64, ()>::BOUNDS, "diode_drop"),
    "Forward voltage of each of the two diodes that conduct at a time",
)
.or_said(OF_PART);

static DRAW: Table = Table::of_kinds(&[&NO_DRAW, &RESISTIVE_DRAW, &CURRENT_DRAW, &POWER_DRAW]);
static NO_DRAW: Kind = Kind { word: "none", meaning: "No draw", keys: &[] };
static RESISTIVE_DRAW: Kind = Kind {
    word: "resistor",
    meaning: "A resistor, connected always or between thresholds",
    keys: &[
        number("value", "Ω", core(ResistiveDraw::<f64>::BOUNDS, "draw.resistance"), "Resistance"),
        TURN_ON.or_said("the preset's, else always connected"),
        TURN_OFF.or_said("the preset's, else always connected"),
    ],
};
static CURRENT_DRAW: Kind = Kind {
    word: "current",
    meaning: "A constant current",
    keys: &[
        number("value", "A", core(CurrentDraw::<f64>::BOUNDS, "draw.current"), "Current"),
        TURN_ON,
        TURN_OFF,
    ],
};
static POWER_DRAW: Kind = Kind {
    word: "power",
    meaning: "A constant power",
    keys: &[
        number(
            "value",
            "W",
            core(PowerDraw::<f64>::BOUNDS, "draw.power"),
            "Power; with a preset that of the node",
        ),
        TURN_ON,
        number("turn_off_v", "V", core(PowerDraw::<f64>::BOUNDS, "draw.turn_off"), TURN_OFF_MEANING)
            .limit("below `turn_on_v`")
            .or_said(OF_PART),
    ],
};
const TURN_ON: Key = number(
    "turn_on_v",
    "V",
    core(CoreLockout::<f64>::BOUNDS, "draw.turn_on"),
    "The draw is connected where the storage rises to this voltage",
)
.or_said(OF_PART);
const TURN_OFF_MEANING: &str = "The draw is disconnected where the storage falls to this voltage";
// This has the bounds of what it may at most be; the reader compares the two.
const TURN_OFF: Key =
    number("turn_off_v", "V", core(CoreLockout::<f64>::BOUNDS, "draw.turn_on"), TURN_OFF_MEANING)
        .limit("below `turn_on_v`")
        .or_said(OF_PART);

pub(super) const PRESET: Key = other(
    "preset",
    Value::Part(Preset::words),
    "Name of a commercial part that supplies the missing keys of the table",
)
.or(Default::Said("none"));

/// The part that the table names, if it names one.
pub(super) fn preset(section: &mut Section<'_>) -> Result<Option<Preset>, SceneError> {
    section.has("preset").then(|| section.part("preset", Preset::words, Preset::named)).transpose()
}

/// A part that a table may name.
type Part = Option<Preset>;
type DrawReader = fn(&mut Section<'_>, Part) -> Result<Draw, SceneError>;

/// Reads `[load]`, and the part that it names.
pub(super) fn load(mut section: Section<'_>) -> Result<(Load, Part), SceneError> {
    let kinds: [(&Kind, Reader<(Load, Part)>); 3] =
        [(&RESISTOR, resistor), (&RECTIFIED_STORE, rectified_store), (&DC_BUS, dc_bus)];
    let found = section.kind(&kinds)?(&mut section)?;
    section.finish()?;
    Ok(found)
}

fn resistor(section: &mut Section<'_>) -> Result<(Load, Part), SceneError> {
    Ok((Load::Resistor { resistance_ohm: section.number("resistance_ohm")? }, None))
}

fn rectified_store(section: &mut Section<'_>) -> Result<(Load, Part), SceneError> {
    let part = preset(section)?;
    let store = RectifiedStore {
        capacitance_f: section.number("capacitance_f")?,
        diode_drop_v: section.number_or("diode_drop_v", part.map(|part| part.diode_drop_v))?,
        leakage_ohm: section.number_or("leakage_ohm", part.map(|part| part.leakage_ohm()))?,
        initial_v: section.number("initial_v")?,
        draw: section.optional_table("draw")?.map_or(Ok(Draw::None), |table| draw(table, part))?,
    };
    Ok((Load::RectifiedStore(store), part))
}

fn dc_bus(section: &mut Section<'_>) -> Result<(Load, Part), SceneError> {
    let part = preset(section)?;
    let voltage_v = section.number("voltage_v")?;
    // A charger holds its input at a voltage from which it starts.
    if let Some(part) = part
        && let Some(lowest) = part.cold_start_v.filter(|lowest| voltage_v < *lowest)
    {
        let reason = format!("must be at least {} for a cold start of {:?}", Short(lowest), part.word);
        return Err(section.refuse("voltage_v", reason));
    }
    let diode_drop_v = section.number_or("diode_drop_v", part.map(|part| part.diode_drop_v))?;
    Ok((Load::DcBus { voltage_v, diode_drop_v }, part))
}

/// Reads `[load.draw]`.
fn draw(mut section: Section<'_>, part: Part) -> Result<Draw, SceneError> {
    let kinds: [(&Kind, DrawReader); 4] = [
        (&NO_DRAW, |_, _| Ok(Draw::None)),
        (&RESISTIVE_DRAW, resistive),
        (&CURRENT_DRAW, current),
        (&POWER_DRAW, power),
    ];
    let draw = section.kind(&kinds)?(&mut section, part)?;
    section.finish()?;
    Ok(draw)
}

fn resistive(section: &mut Section<'_>, part: Part) -> Result<Draw, SceneError> {
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
    let current_a = section.number("value")?;
    let lockout = thresholds(section, part)?;
    Ok(Draw::Current { current_a, lockout: check(section, lockout)? })
}

fn power(section: &mut Section<'_>, part: Part) -> Result<Draw, SceneError> {
    let node_w = section.number("value")?;
    let power_w = part.map_or(node_w, |part| part.power_at_store(node_w));
    let lockout = thresholds(section, part)?;
    Ok(Draw::Power { power_w, lockout: check(section, lockout)? })
}

fn thresholds(section: &mut Section<'_>, part: Part) -> Result<Lockout, SceneError> {
    let of_part = part.and_then(|part| part.lockout);
    Ok(Lockout {
        turn_on_v: section.number_or("turn_on_v", of_part.map(|lockout| lockout.turn_on_v))?,
        turn_off_v: section.number_or("turn_off_v", of_part.map(|lockout| lockout.turn_off_v))?,
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
