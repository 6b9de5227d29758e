//! A table of error against run time as text: the same cells for the terminal, CSV and HTML.

use clap::ValueEnum;
use comfy_table::{CellAlignment, Table, presets};

use super::{Comparison, Omitted, Row, TARGET_ERROR};
use crate::outcome::number;

/// Headings of the table, units in them.
pub const HEADINGS: [&str; 11] = [
    "method",
    "precision",
    "math",
    "step or tolerance",
    "error of mean power",
    "of RMS voltage",
    "of first impact or amplitude",
    "steps per simulated s",
    "host ns per simulated s",
    "time ratio",
    "energy residual",
];

/// Columns at the left that hold words.
pub const WORDS: usize = 4;

/// The name that the command line has for a value.
pub(super) fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

pub(super) fn small(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.1e}"))
}

/// An integer in groups of three digits.
pub(super) fn grouped(value: f64) -> String {
    let digits = format!("{value:.0}");
    let first = digits.len() % 3;
    let mut text = digits.get(..first).unwrap_or_default().to_owned();
    for group in (first..digits.len()).step_by(3) {
        if !text.is_empty() {
            text.push(' ');
        }
        text.push_str(digits.get(group..group + 3).unwrap_or_default());
    }
    text
}

/// Three significant digits below a hundred, none after the point above.
pub(super) fn ratio(value: Option<f64>) -> String {
    value.map_or_else(
        || "-".to_owned(),
        |value| if value < 100.0 { format!("{value:.2}") } else { format!("{value:.0}") },
    )
}

/// What went wrong, without the state in which it did.
pub(super) fn reason(failure: &str) -> String {
    failure.split(": ").next().unwrap_or(failure).to_owned()
}

impl Row {
    /// The cells under [`HEADINGS`]. A row that failed has its reason where the errors are.
    #[must_use]
    pub fn cells(&self) -> Vec<String> {
        let variant = &self.variant;
        let mut cells = vec![
            variant.method_name().to_owned(),
            name(&variant.precision),
            variant.math.as_ref().map_or_else(|| "std".to_owned(), name),
            variant.control.to_string(),
        ];
        match &self.found {
            Some(found) => cells.extend([
                small(found.errors.mean_power_error),
                small(found.errors.rms_voltage_error),
                small(found.errors.first_impact_error.or(found.errors.amplitude_error)),
                grouped(found.steps_per_s),
                grouped(found.ns_per_s),
                ratio(found.time_ratio),
                small(found.energy_residual),
            ]),
            None => {
                cells.push(format!("fails{}", if self.failure.is_some() { " (1)" } else { "" }));
                cells.extend(std::iter::repeat_n("-".to_owned(), HEADINGS.len() - WORDS - 1));
            }
        }
        cells
    }
}

impl Comparison {
    /// What is above the table.
    #[must_use]
    pub fn title(&self) -> String {
        let shown = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| "none".to_owned(), |value| format!("{value:.6e} {unit}"))
        };
        let motion = match self.amplitude_m {
            Some(amplitude) => format!("amplitude {}", shown(Some(amplitude), "m")),
            None => format!("first impact {}", shown(self.first_impact_s, "s")),
        };
        format!(
            "{}, R = {}, {} s simulated; by the reference: mean power {}, RMS voltage {}, {motion}",
            self.file,
            resistance(self.resistance_ohm),
            (self.duration_s * 1e3).round() / 1e3,
            shown(self.mean_power_w, "W"),
            shown(self.rms_voltage_v, "V"),
        )
    }

    /// What is to be said below the table, one line each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let mut notes = vec![format!(
            "Errors are relative to the reference; time ratio is to the fastest row whose error of mean power \
             is at most {TARGET_ERROR:.0e}. Times are medians of up to {} runs in one process on one thread.",
            self.rows.iter().filter_map(|row| row.found.as_ref()).map(|found| found.runs).max().unwrap_or(0)
        )];
        notes.extend(self.omitted.iter().filter(|entry| entry.rows > 0).map(Omitted::note));
        for row in &self.rows {
            if let Some(failure) = &row.failure {
                let Row { variant, .. } = row;
                let control = variant.control;
                notes.push(format!(
                    "(1) {}, {}, {control}: {}.",
                    variant.method_name(),
                    name(&variant.precision),
                    reason(failure)
                ));
            }
        }
        notes
    }

    /// Title, table and notes for a terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let mut table = Table::new();
        table.load_style(presets::ASCII_MARKDOWN).set_header(HEADINGS);
        for row in &self.rows {
            table.add_row(row.cells());
        }
        for column in table.column_iter_mut().skip(WORDS) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        let mut text = format!("{}\n\n{}\n\n", self.title(), table.trim_fmt());
        for note in self.notes() {
            text.push_str(&note);
            text.push('\n');
        }
        text
    }

    /// One line of CSV for each row, without heading.
    #[must_use]
    pub fn csv(&self) -> String {
        let optional = |value: Option<f64>| value.map_or_else(String::new, number);
        let mut text = String::new();
        for row in &self.rows {
            let mut cells = vec![format!("\"{}\"", self.file), number(self.resistance_ohm)];
            cells.extend(row.cells().into_iter().take(WORDS));
            match &row.found {
                Some(found) => cells.extend([
                    optional(found.errors.mean_power_error),
                    optional(found.errors.rms_voltage_error),
                    optional(found.errors.first_impact_error),
                    optional(found.errors.amplitude_error),
                    number(found.steps_per_s),
                    number(found.ns_per_s),
                    optional(found.time_ratio),
                    optional(found.energy_residual),
                    found.runs.to_string(),
                    String::new(),
                ]),
                None => {
                    cells.extend(std::iter::repeat_n(String::new(), 9));
                    cells.push(format!("\"{}\"", row.failure.clone().unwrap_or_default().replace('"', "'")));
                }
            }
            for cell in cells.iter_mut().filter(|cell| cell.contains(',') && !cell.starts_with('"')) {
                *cell = format!("\"{cell}\"");
            }
            text.push_str(&cells.join(","));
            text.push('\n');
        }
        text
    }
}

/// Heading of [`Comparison::csv`].
pub const CSV_HEADING: &str = "scene,resistance_ohm,method,precision,math,step_or_tolerance,\
    mean_power_error,rms_voltage_error,first_impact_error,amplitude_error,steps_per_s,ns_per_s,time_ratio,\
    energy_residual,runs,failure\n";

/// A resistance with its unit.
#[must_use]
pub fn resistance(ohms: f64) -> String {
    const PREFIXES: [(f64, &str); 7] =
        [(1e15, "P"), (1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m")];
    if ohms.is_infinite() {
        return "infinite".to_owned();
    }
    match PREFIXES.iter().find(|(unit, _)| ohms >= 0.9999 * unit && ohms < 1e18) {
        // Six digits, without those that are zero.
        Some((unit, prefix)) => format!("{} {prefix}Ω", (ohms / unit * 1e6).round() / 1e6),
        None => format!("{ohms:e} Ω"),
    }
}

impl Omitted {
    /// That these rows are left out, and why.
    #[must_use]
    pub fn note(&self) -> String {
        let (precision, math) = (name(&self.precision), name(&self.math));
        format!(
            "{precision} with {math}: {} of {} rows have the errors of the polynomial rows (to a tenth) and are \
             not repeated; {math} takes {:.2} times their run time (median).",
            self.rows, self.of, self.time_ratio
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_for_people() {
        assert_eq!(grouped(12.0), "12");
        assert_eq!(grouped(123_456.4), "123 456");
        assert_eq!(grouped(1_234_567.0), "1 234 567");
        let resistances = [1e8, 1e15, 1e-3, 4700.0, 0.0, f64::INFINITY].map(resistance);
        assert_eq!(resistances, ["100 MΩ", "1 PΩ", "1 mΩ", "4.7 kΩ", "0e0 Ω", "infinite"]);
        assert_eq!(
            (ratio(Some(1.234)), ratio(Some(123.4)), ratio(None)),
            ("1.23".into(), "123".into(), "-".into())
        );
        assert_eq!(
            reason("the step shrank to nothing at 1 s: gap 0e0 m"),
            "the step shrank to nothing at 1 s"
        );
    }
}
