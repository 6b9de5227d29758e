//! `[node]`, which only the command `budget` uses.

mod parts;

use model_core::energy::{IncomeParameters, StorageParameters};

use self::parts::Parts;
use super::document::SceneError;
use super::key::{CoreTable, Table, Value, between, core, number, other, whole};
use super::load::{PRESET, preset};
use super::scene::{Action, Draw, EstimationCost, HOURS, Load, Node, Storage};
use super::section::Section;
use crate::market::{Battery, Preset};

const INCOME: CoreTable = IncomeParameters::<f64>::BOUNDS;
const STORE: CoreTable = StorageParameters::<f64>::BOUNDS;
const BY_PARTS: &str = "required; 0 with one of the last three keys";
const OF_PART: &str = "the preset's, else required";
const OF_BATTERY: &str = "the preset's or the battery's, else required";
const OF_LOAD: &str = "that of a rectified-store in `[load]`, else required";

pub(super) static TABLE: Table = Table::of(&[
    whole("update_s", "s", between(1.0, 3600.0), "Time between two updates of the energy budget")
        .limit("divides 86400"),
    whole("decision_s", "s", between(1.0, 3600.0), "Time between two decisions about actions")
        .limit("a multiple of `update_s` that divides 86400")
        .or_said("`update_s`"),
    other("slots_per_day", Value::Among(&SLOTS), "Slots of the day in which the income is remembered"),
    number(
        "standing_power_w",
        "W",
        between(0.0, 1e3),
        "Power that is always taken, without that of `parts`, upper bound",
    )
    .or_number(0.0),
    number("time_constant_s", "s", core(INCOME, "time_constant"), "Time constant of the mean of the income")
        .or_number(14_400.0),
    // What Kansal et al. (2007) find good.
    number("day_weight", "1", core(INCOME, "day_weight"), "Weight of the newest day in the mean of a slot")
        .or_number(0.5),
    other("storage", Value::Table(&STORAGE), "The storage of the node").or_said(OF_LOAD),
    other("day", Value::Table(&DAY_TABLE), "How the excitation changes over the day").or_said("it does not"),
    other("parts", Value::Table(&parts::PARTS), "Named parts, whose energies come from their figures")
        .or_said("none"),
    other("burst", Value::Table(&parts::BURST), "A burst of samples, the accelerometer off before and after")
        .limit("needs `parts`")
        .or_said("none"),
    other(
        "voltage_reading",
        Value::Table(&parts::READING),
        "A wake-up and a reading of the storage's voltage",
    )
    .limit("needs `parts`")
    .or_said("none"),
    other("actions", Value::Tables(&ACTIONS), "What the node does, the most important first"),
]);

static STORAGE: Table = Table::of(&[
    PRESET,
    other("battery", Value::Part(Battery::words), "Name of a battery beside the capacitor").or_said("none"),
    // The capacitance is also one of the core's capacitor behind a bridge.
    number("capacitance_f", "F", between(1e-9, 1e4), "Capacitance")
        .or_said("that of a rectified-store in `[load]`, 100e-6 beside a `battery`, else required"),
    number("leakage_ohm", "Ω", core(STORE, "leakage_resistance"), "Leakage resistance; inf: no leakage")
        .or_said("the preset's, that of `[load]`, inf beside a `battery`, else required"),
    number("initial_v", "V", between(0.0, 1e3), "Voltage at the start")
        .limit("at most `highest_v`")
        .or_said("that of a rectified-store in `[load]`, that of a half-charged `battery`, else required"),
    number(
        "charging_efficiency",
        "1",
        core(STORE, "charging_efficiency"),
        "Part of the income that is stored",
    )
    .or_said(OF_PART),
    number(
        "discharging_efficiency",
        "1",
        core(STORE, "discharging_efficiency"),
        "Part of the stored energy that reaches the node",
    )
    .or_said(OF_PART),
    number("highest_v", "V", core(STORE, "highest_voltage"), "Voltage at which further income is shunted")
        .or_said(OF_BATTERY),
    number("turn_on_v", "V", between(0.0, 1e3), "Voltage at which the node is switched on")
        .limit("below `highest_v`")
        .or_said(OF_BATTERY),
    number("turn_off_v", "V", between(0.0, 1e3), "Voltage at which the node is switched off")
        .limit("below `turn_on_v`")
        .or_said(OF_BATTERY),
]);

static DAY_TABLE: Table = Table::of(&[other(
    "hours",
    Value::Numbers(between(0.0, 1e3), "hour from midnight"),
    "Factors of the amplitude, 24, one for each hour from midnight",
)
.unit("1")]);

static ACTIONS: Table = Table::of(&[
    other("name", Value::Text, "Its name").limit("unique, not empty, not `burst` or `voltage_reading`"),
    number("energy_j", "J", between(1e-12, 1e3), "What it takes at the node, upper bound").or_said(BY_PARTS),
    number("duration_s", "s", between(0.0, 86_400.0), "How long it takes, upper bound").or_said(BY_PARTS),
    number("every_s", "s", between(1.0, 86_400.0), "Time from one to the next that is wished for"),
    whole("packet_bytes", "", between(0.0, 255.0), "Payload of a packet of the radio")
        .limit("at most that of the radio; needs `parts`")
        .or_said("none"),
    whole("adc_readings", "", between(1.0, 65_536.0), "Readings of the ADC")
        .limit("needs `parts`")
        .or_said("none"),
    number("instructions", "", between(0.0, 1e9), "Instructions, of the kind `filter`")
        .limit("needs `parts`")
        .or_said("none"),
]);

/// What a node does to know its income, by its tables.
const ESTIMATION: [&str; 2] = ["burst", "voltage_reading"];
/// Seconds in a day.
const DAY: usize = 86_400;
/// Slots that the core's budget is compiled for here.
const SLOTS: [usize; 4] = [24, 48, 96, 144];
/// Capacitance in F beside a battery.
const BESIDE_F: f64 = 100e-6;

/// Reads `[node]` of a scene whose load is `load`, with the part that `[load]` names.
pub(super) fn node(mut section: Section<'_>, load: Load, part: Option<Preset>) -> Result<Node, SceneError> {
    let update_s = divisor_of(&mut section, "update_s", DAY)?;
    let decision_s = if section.has("decision_s") {
        let seconds = divisor_of(&mut section, "decision_s", DAY)?;
        if seconds % update_s != 0 {
            return Err(section.refuse("decision_s", format!("must be a multiple of update_s = {update_s}")));
        }
        seconds
    } else {
        update_s
    };
    let slots_per_day = section.whole_number("slots_per_day")?;
    let parts = parts::parts(&mut section)?;
    let asleep_power_w = parts.as_ref().map(Parts::asleep);
    let stated_power_w = section.number("standing_power_w")?;
    let node = Node {
        update_s: update_s as u32,
        decision_s: decision_s as u32,
        slots_per_day,
        standing_power_w: stated_power_w + asleep_power_w.unwrap_or(0.0),
        asleep_power_w,
        time_constant_s: section.number("time_constant_s")?,
        day_weight: section.number("day_weight")?,
        storage: storage(&mut section, load, part)?,
        hours: section.optional_table("day")?.map_or(Ok([1.0; HOURS]), hours)?,
        actions: actions(&mut section, parts.as_ref())?,
        estimation: estimation(&mut section, parts.as_ref())?,
        figures: parts.as_ref().map_or_else(Vec::new, Parts::figures),
    };
    section.finish()?;
    Ok(node)
}

/// A whole number that divides another.
fn divisor_of(section: &mut Section<'_>, key: &'static str, whole: usize) -> Result<usize, SceneError> {
    let value = section.whole_number(key)?;
    if !whole.is_multiple_of(value) {
        return Err(section.refuse(key, format!("must divide {whole}, the seconds of a day")));
    }
    Ok(value)
}

/// Reads `[node.storage]`. What it does not give is that of its own part, then that of `[load]`.
fn storage(
    section: &mut Section<'_>,
    load: Load,
    part_of_load: Option<Preset>,
) -> Result<Storage, SceneError> {
    let of_load = if let Load::RectifiedStore(store) = load { Some(store) } else { None };
    let mut table = match (section.optional_table("storage")?, of_load) {
        (Some(table), _) => table,
        (None, Some(_)) => section.empty("storage"),
        (None, None) => section.table("storage")?,
    };
    if let Some(store) = of_load {
        one_storage(&mut table, store.draw)?;
    }
    let own = preset(&mut table)?;
    let named = table.has("battery").then(|| table.part("battery", Battery::words, Battery::named));
    let battery = named.transpose()?;
    let part = own.or(part_of_load);
    let lockout = own
        .and_then(|part| part.lockout)
        .or(battery.and_then(|part| part.lockout))
        .or(of_load.and_then(|store| store.draw.lockout()))
        .or(part.and_then(|part| part.lockout));
    let leakage_ohm = own
        .map(|part| part.leakage_ohm())
        .or(battery.map(|_| f64::INFINITY))
        .or(of_load.map(|store| store.leakage_ohm))
        .or(part.map(|part| part.leakage_ohm()));
    let highest = part.and_then(|part| part.highest_v).or(battery.map(|part| part.highest_v));
    let capacitance_f = of_load.map(|store| store.capacitance_f).or(battery.map(|_| BESIDE_F));
    let initial_v = of_load.map(|store| store.initial_v).or(battery.map(|part| part.half_v.0));
    let storage = Storage {
        battery,
        capacitance_f: table.number_or("capacitance_f", capacitance_f)?,
        leakage_ohm: table.number_or("leakage_ohm", leakage_ohm)?,
        initial_v: table.number_or("initial_v", initial_v)?,
        charging_efficiency: table
            .number_or("charging_efficiency", part.map(|part| part.charging_efficiency))?,
        discharging_efficiency: table
            .number_or("discharging_efficiency", part.map(|part| part.discharging_efficiency))?,
        highest_v: table.number_or("highest_v", highest)?,
        turn_off_v: table.number_or("turn_off_v", lockout.map(|lockout| lockout.turn_off_v))?,
        turn_on_v: table.number_or("turn_on_v", lockout.map(|lockout| lockout.turn_on_v))?,
        own_power_w: part.map_or(0.0, |part| part.power_at_store(0.0)),
    };
    in_order(&table, &storage)?;
    table.finish()?;
    Ok(storage)
}

/// Refuses keys that state a storage beside the one in `[load]`, which has this draw.
fn one_storage(section: &mut Section<'_>, draw: Draw) -> Result<(), SceneError> {
    let of_draw = draw.lockout().map_or(&[][..], |_| &["turn_on_v", "turn_off_v"]);
    let of_storage = ["preset", "battery", "capacitance_f", "leakage_ohm", "initial_v"];
    for key in of_storage.iter().chain(of_draw) {
        if section.has(key) {
            let table = if of_draw.contains(key) { "load.draw" } else { "load" };
            let other = if *key == "battery" { String::new() } else { format!("; give {table}.{key}") };
            let reason = format!("must not be given beside the storage in [load]{other}");
            return Err(section.refuse(key, reason));
        }
    }
    Ok(())
}

/// Refuses voltages that are not in their order.
fn in_order(section: &Section<'_>, storage: &Storage) -> Result<(), SceneError> {
    let Storage { initial_v, highest_v, turn_off_v, turn_on_v, .. } = *storage;
    for (is_wrong, key, bound) in [
        (turn_off_v >= turn_on_v, "turn_off_v", format!("below turn_on_v = {turn_on_v}")),
        (turn_on_v >= highest_v, "turn_on_v", format!("below highest_v = {highest_v}")),
        (initial_v > highest_v, "initial_v", format!("at most highest_v = {highest_v}")),
    ] {
        if is_wrong {
            return Err(section.refuse(key, format!("must be {bound}")));
        }
    }
    if let Some([lowest, highest]) = storage.battery.map(|battery| battery.ends()) {
        for (key, voltage) in [("turn_off_v", turn_off_v), ("initial_v", initial_v), ("highest_v", highest_v)]
        {
            // The voltages of a battery are those of the core, in f32.
            if !(lowest..=highest).contains(&f64::from(voltage as f32)) {
                let range = format!("must be from {lowest:.4} to {highest:.4}, the voltages of the battery");
                return Err(section.refuse(key, range));
            }
        }
    }
    Ok(())
}

/// Reads `[node.day]`.
fn hours(mut section: Section<'_>) -> Result<[f64; HOURS], SceneError> {
    let factors = section.optional_numbers("hours", HOURS)?;
    let Some(factors) = factors.and_then(|factors| <[f64; HOURS]>::try_from(factors).ok()) else {
        return Err(section.must_be("hours", &format!("{HOURS} numbers")));
    };
    section.finish()?;
    Ok(factors)
}

/// Reads what the node does to know its income, which its named parts must pay for.
fn estimation(section: &mut Section<'_>, parts: Option<&Parts>) -> Result<Vec<EstimationCost>, SceneError> {
    type Read = fn(&Parts, &mut Section<'_>) -> Result<EstimationCost, SceneError>;
    let kinds: [Read; 2] = [Parts::burst, Parts::voltage_reading];
    let mut all = Vec::new();
    for (key, read) in ESTIMATION.into_iter().zip(kinds) {
        let Some(mut table) = section.optional_table(key)? else { continue };
        let Some(parts) = parts else {
            return Err(section.refuse(key, "needs node.parts, which is missing"));
        };
        all.push(read(parts, &mut table)?);
        table.finish()?;
    }
    Ok(all)
}

/// Reads `[[node.actions]]`.
fn actions(section: &mut Section<'_>, parts: Option<&Parts>) -> Result<Vec<Action>, SceneError> {
    let mut actions: Vec<Action> = Vec::new();
    for mut table in section.tables("actions")? {
        let Some(name) = table.text("name").map(str::to_owned).filter(|name| !name.trim().is_empty()) else {
            return Err(table.must_be("name", "a text that is not empty"));
        };
        if actions.iter().any(|action| action.name == name) {
            return Err(table.refuse("name", "must not be that of another action"));
        }
        if ESTIMATION.contains(&name.as_str()) {
            return Err(table.refuse("name", format!("must not be {}", ESTIMATION.join(" or "))));
        }
        let [energy_j, duration_s] = energy_and_duration(&mut table, parts)?;
        actions.push(Action { name, energy_j, duration_s, every_s: table.number("every_s")? });
        table.finish()?;
    }
    Ok(actions)
}

/// Energy in J and duration in s of an action: what is stated, and what the named parts take beside.
fn energy_and_duration(table: &mut Section<'_>, parts: Option<&Parts>) -> Result<[f64; 2], SceneError> {
    let of_parts = match parts {
        Some(parts) => parts.action(table)?,
        None => ["packet_bytes", "adc_readings", "instructions"]
            .into_iter()
            .find(|&key| table.has(key))
            .map_or(Ok(None), |key| Err(table.refuse(key, "needs node.parts, which is missing")))?,
    };
    let default = of_parts.map(|_| 0.0);
    let stated = [table.number_or("energy_j", default)?, table.number_or("duration_s", default)?];
    let [energy_j, duration_s] = of_parts.unwrap_or([0.0; 2]);
    Ok([stated[0] + energy_j, stated[1] + duration_s])
}
