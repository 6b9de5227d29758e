//! Which column of a table has the samples, which the times.

use csv::StringRecord;

use super::super::clock::unit_of;
use super::super::{Asked, AskedClock, Column, SCALE, TraceFault};
use crate::input::repeated;
use crate::scene_file::GRAVITY;

/// The heading of a column of samples that is found without being named.
const ACCELERATION: &str = "acceleration_m_per_s2";
/// The heading that is preferred among those that name a time.
const TIME: &str = "time_s";

/// The columns of a table, from 0.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub(super) sample: usize,
    /// Acceleration in m/s² for each unit of the samples.
    pub(super) scale: f64,
    pub(super) clock: Option<Clock>,
    pub(super) has_heading: bool,
    /// Number of columns of the first row.
    width: usize,
}

/// A column that has times, or may have them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    pub(super) column: usize,
    /// Unit of the times in s.
    pub(super) unit_s: f64,
    /// Whether a heading or a key says that these are times.
    pub(super) is_named: bool,
    /// Whether a key says so.
    pub(super) is_stated: bool,
    /// The key to blame where a row lacks the column.
    pub(super) key: &'static str,
}

impl Clock {
    /// Says how to use the file, if no key says that the column has times.
    pub(super) fn with_way_out(self, fault: TraceFault) -> TraceFault {
        if self.is_stated {
            return fault;
        }
        let text =
            format!("{} (time_column = false ignores the times in column {})", fault.text, self.column + 1);
        TraceFault { text, ..fault }
    }
}

impl Layout {
    /// The columns that are asked for, by the first row of the table.
    pub(super) fn of(first: &StringRecord, line: u64, asked: &Asked) -> Result<Self, TraceFault> {
        let is_text = |cell: &str| cell.replace(',', ".").parse::<f64>().is_err();
        let named = |column: Option<&Column>| matches!(column, Some(Column::Name(_)));
        let has_heading = named(asked.column.as_ref())
            || named(asked.clock.column())
            || match asked.column {
                Some(Column::Number(number)) => first.get(number - 1).is_some_and(is_text),
                _ => first.iter().any(|cell| !cell.is_empty() && is_text(cell)),
            };
        let named = first.iter().filter(|cell| has_heading && !cell.is_empty());
        if let Some(name) = repeated(named) {
            return Err(TraceFault::new("path", format!("line {line}: column {name:?}: must be there once")));
        }
        let clock = clock(first, line, asked, has_heading)?;
        if let Some(clock) = clock.filter(|clock| clock.unit_s.is_nan()) {
            let heading = first.get(clock.column).unwrap_or_default();
            let text = format!("line {line}: column {heading:?}: its unit must be h, min, s, ms, us or ns");
            return Err(clock.with_way_out(TraceFault::new(clock.key, text)));
        }
        let sample = match &asked.column {
            Some(column) => place(column, "column", first, line)?,
            None => only_other(first, clock, has_heading)?,
        };
        let heading = first.get(sample).filter(|_| has_heading).unwrap_or_default();
        Ok(Self {
            sample,
            scale: scale(heading, asked.scale, line)?,
            clock,
            has_heading,
            width: width(first),
        })
    }

    /// Refuses a row with more columns than the first: the rest of a number with a decimal comma.
    pub(super) fn check_width(&self, record: &StringRecord, line: u64) -> Result<(), TraceFault> {
        let width = width(record);
        if width <= self.width {
            return Ok(());
        }
        let text = format!(
            "line {line}: there are {width} columns, must be at most {} as in the first row; decimal commas need \
             semicolons or tabs between the columns",
            self.width
        );
        Err(TraceFault::new("path", text))
    }

    /// Refuses samples that are the times, where the columns of times `are_times`; and the only other column as samples
    /// where they are not.
    pub(super) fn check_sample(&self, asked: &Asked, are_times: bool) -> Result<(), TraceFault> {
        let is_clock = self.clock.is_some_and(|clock| clock.column == self.sample);
        if is_clock && are_times {
            let text =
                "must be a column of samples, these are times; time_column = false if they are samples";
            return Err(TraceFault::new("column", text));
        }
        if asked.column.is_none() && !self.has_heading && !are_times {
            return Err(TraceFault::missing("column", Column::WANTED));
        }
        Ok(())
    }
}

/// Units of acceleration, in lower case with `2` for a square, and their size in m/s².
const UNITS: [(&str, f64); 11] = [
    ("m/s2", 1.0),
    ("m_per_s2", 1.0),
    ("cm/s2", 1e-2),
    ("cm_per_s2", 1e-2),
    ("mm/s2", 1e-3),
    ("mm_per_s2", 1e-3),
    ("ft/s2", 0.3048),
    ("g", GRAVITY),
    ("mg", 1e-3 * GRAVITY),
    ("g0", GRAVITY),
    ("gn", GRAVITY),
];
/// Ends of what a sensor has for each g or m/s², in lower case; and what is no unit in brackets.
const SENSITIVITIES: [&str; 9] = ["v", "lsb", "count", "counts", "pc", "digit", "digits", "raw", "adc"];
const NO_UNITS: [&str; 4] = ["x", "y", "z", ""];
/// First words of the name of an acceleration, behind which `G` without brackets is g; and beginnings of longer ones.
const ACCELERATIONS: [&str; 5] = ["a", "ax", "ay", "az", "acc"];
const LONG_ACCELERATIONS: [&str; 2] = ["accel", "beschl"];
/// Relative difference of a stated scale from the unit of the heading up to which both are the same: other values of g.
const SAME: f64 = 1e-3;

/// The unit in m/s² of the accelerations in a column with this heading: in brackets, or as its last word. Not-a-number where
/// what is in brackets is a unit neither of acceleration nor of a sensor.
fn unit(heading: &str) -> Option<f64> {
    let lower = heading.to_lowercase().replace("**2", "2").replace("^2", "2").replace('²', "2");
    let lower = lower.replace("/s/s", "/s2");
    let size = |name: &str| UNITS.iter().find(|(unit, _)| *unit == name).map(|(_, size)| *size);
    // What is counted in something for each g is no acceleration.
    let is_sensor = |name: &str| {
        name.split('/').any(|part| SENSITIVITIES.iter().any(|word| part.trim_end().ends_with(word)))
    };
    let is_sensitivity = |before: &str| before.trim_end().strip_suffix('/').is_some_and(is_sensor);
    let bracketed = lower.match_indices(['(', '[']).filter_map(|(at, _)| {
        let name = lower[at + 1..].split(['(', '[', ')', ']']).next().map(str::trim)?;
        (!NO_UNITS.contains(&name)).then_some((&lower[..at], name))
    });
    let bracketed: Vec<Option<f64>> = bracketed
        .map(|(before, name)| match size(name) {
            _ if is_sensitivity(before) || is_sensor(name) => None,
            size => size.or(Some(f64::NAN)),
        })
        .collect();
    let known = bracketed.iter().find(|found| !found.is_some_and(f64::is_nan));
    if let Some(found) = known.or(bracketed.first()) {
        return *found;
    }
    // A capital G at the end may be the name of a channel, unless it is behind that of an acceleration.
    let is_capital = heading.trim_end_matches('0').ends_with('G');
    let first = lower.split([' ', '_', '/']).next().unwrap_or("");
    let is_named =
        ACCELERATIONS.contains(&first) || LONG_ACCELERATIONS.iter().any(|begin| first.starts_with(begin));
    UNITS.iter().find_map(|(name, size)| {
        // `g0` alone is the name of a column, as `g1` is.
        let is_alone = lower == *name && *name != "g0";
        let before =
            lower.strip_suffix(name).filter(|before| is_alone || before.ends_with(['_', ' ', '/']))?;
        let is_other = is_sensitivity(before) || is_capital && !is_named && name.starts_with('g');
        (!is_other).then_some(*size)
    })
}

/// The acceleration in m/s² for each unit of a column with this heading, of which one or the `stated` scale says it.
fn scale(heading: &str, stated: Option<f64>, line: u64) -> Result<f64, TraceFault> {
    match (unit(heading), stated) {
        (Some(unit), _) if unit.is_nan() => {
            let text = format!(
                "line {line}: column {heading:?}: its unit in brackets must be g, mg, m/s², cm/s², mm/s² or ft/s²; with {SCALE} \
                 also V, pC, LSB, counts, digits or raw of a sensor, or none"
            );
            Err(TraceFault::new("path", text))
        }
        (Some(unit), Some(stated)) if !((stated.abs() / unit - 1.0).abs() <= SAME) => {
            let unit: f64 = format!("{unit:.6e}").parse().unwrap_or(unit);
            let text = format!(
                "line {line}: must be {unit} by the unit in the heading {heading:?}, or left out, or the heading be without a unit"
            );
            Err(TraceFault::new(SCALE, text))
        }
        (unit, stated) => stated.or(unit).ok_or_else(|| {
            let wanted = "a number of m/s², or the heading of the column have a unit such as (g) or (m/s²)";
            TraceFault::missing(SCALE, wanted)
        }),
    }
}

/// Number of columns, without empty ones at the end.
fn width(record: &StringRecord) -> usize {
    (0..record.len()).rfind(|column| !record[*column].is_empty()).map_or(0, |last| last + 1)
}

fn place(column: &Column, key: &'static str, first: &StringRecord, line: u64) -> Result<usize, TraceFault> {
    match column {
        Column::Number(number) => Ok(number - 1),
        Column::Name(name) => first.iter().position(|cell| cell == name).ok_or_else(|| {
            TraceFault::new(key, format!("line {line}: no such column in {:?}", headings(first)))
        }),
    }
}

fn headings(first: &StringRecord) -> Vec<&str> {
    first.iter().take(20).collect()
}

/// The column of times: as stated, or the heading that names a time, or without headings the first of several.
fn clock(
    first: &StringRecord,
    line: u64,
    asked: &Asked,
    has_heading: bool,
) -> Result<Option<Clock>, TraceFault> {
    let unit_of = |column: usize, is_stated: bool| {
        first.get(column).filter(|_| has_heading).and_then(|heading| unit_of(heading, is_stated))
    };
    match &asked.clock {
        AskedClock::Ignored => Ok(None),
        AskedClock::Column(stated) => {
            let column = place(stated, "time_column", first, line)?;
            let unit_s = unit_of(column, true).unwrap_or(1.0);
            Ok(Some(Clock { column, unit_s, is_named: true, is_stated: true, key: "time_column" }))
        }
        AskedClock::Unset if has_heading => {
            let preferred = first.iter().position(|cell| cell == TIME);
            let column =
                preferred.or_else(|| (0..first.len()).find(|column| unit_of(*column, false).is_some()));
            Ok(column.map(|column| {
                let unit_s = unit_of(column, false).unwrap_or(1.0);
                Clock { column, unit_s, is_named: true, is_stated: false, key: "path" }
            }))
        }
        AskedClock::Unset => {
            let several = first.len() > 1;
            Ok(several.then_some(Clock {
                column: 0,
                unit_s: 1.0,
                is_named: false,
                is_stated: false,
                key: "path",
            }))
        }
    }
}

/// The column of samples where none is asked for: by its heading, or the only one beside the times.
fn only_other(first: &StringRecord, clock: Option<Clock>, has_heading: bool) -> Result<usize, TraceFault> {
    let by_heading = first.iter().position(|cell| has_heading && cell == ACCELERATION);
    let beside = clock.filter(|_| first.len() == 2).map(|clock| 1 - clock.column.min(1));
    by_heading.or(beside).ok_or_else(|| {
        let wanted = if has_heading {
            format!("{} of {:?}", Column::WANTED, headings(first))
        } else {
            Column::WANTED.to_owned()
        };
        TraceFault::missing("column", wanted)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_names_the_unit_of_an_acceleration() {
        for (heading, expected) in [
            ("Acceleration (g)", Some(9.81)),
            ("Beschleunigung [g]", Some(9.81)),
            ("acc_x_g", Some(9.81)),
            ("Acceleration/g", Some(9.81)),
            ("a (mg)", Some(9.81e-3)),
            ("acceleration_m_per_s2", Some(1.0)),
            ("Acceleration (m/s²)", Some(1.0)),
            ("acc in m/s^2", Some(1.0)),
            ("a [mm/s2]", Some(1e-3)),
            ("Sensor (mV/g)", None),
            ("sensor mV/g", None),
            ("Sensor mV/(m/s²)", None),
            ("counts / g", None),
            ("LSB/g", None),
            ("Channel G", None),
            ("acc G", Some(9.81)),
            ("g", Some(9.81)),
            ("m/s²", Some(1.0)),
            ("acc furlong", None),
            ("Acceleration (G)", Some(9.81)),
            ("a (gn)", Some(9.81)),
            ("a (cm/s^2)", Some(1e-2)),
            ("a [ft/s²] filtered", Some(0.3048)),
            ("a (x) [m/s/s]", Some(1.0)),
            ("Acceleration (V)", None),
            ("Acceleration (mV) (filtered)", None),
            ("Acceleration (X)", None),
            ("Acceleration (g RMS)", Some(f64::NAN)),
            ("velocity (m/s)", Some(f64::NAN)),
            ("jogging", None),
            ("x", None),
            ("", None),
        ] {
            let found = unit(heading);
            let is_same = match (found, expected) {
                (Some(found), Some(expected)) if expected.is_nan() => found.is_nan(),
                (Some(found), Some(expected)) => (found / expected - 1.0_f64).abs() < 1e-12,
                (found, expected) => found.is_none() && expected.is_none(),
            };
            assert!(is_same, "{heading:?}: {found:?}");
        }
    }
}
