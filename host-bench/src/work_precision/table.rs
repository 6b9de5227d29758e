//! A table of error against run time as text: the same columns for the terminal, CSV and HTML.

use comfy_table::presets;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::{Comparison, Omitted, Row};
use crate::method::{Math, Method, Options, Precision};
use crate::outcome::{Fields, csv_sections, fields, folded, name, rows_csv, table};
use crate::report::setting::with_unit;
use crate::rows::{Column, Digits, Rows, headings};

const ERROR: Digits = Digits::Exponent(1);
const RATIO: Digits = Digits::By(|value| ratio(Some(value)));

/// The column of an error.
pub(super) const fn error(heading: &'static str, name: &'static str) -> Column<'static> {
    (heading, name, ERROR)
}

/// The last columns of every table.
pub(super) const WORK: [Column<'_>; 5] = [
    ("steps per simulated s", "steps_per_s", Digits::By(grouped)),
    ("host µs per simulated s", "ns_per_s", Digits::By(|time| grouped(time / 1e3))),
    ("spread", "time_spread", RATIO),
    ("time ratio", "time_ratio", RATIO),
    ("energy residual", "energy_residual", ERROR),
];

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

/// A number of the reference with its unit.
pub(super) fn shown(value: Option<f64>, unit: &str) -> String {
    value.map_or_else(|| "none".to_owned(), |value| format!("{value:.6e} {unit}"))
}

/// What went wrong, without the state in which it did.
pub(crate) fn reason(failure: &str) -> String {
    failure.split(": ").next().unwrap_or(failure).to_owned()
}

impl Comparison {
    /// The numbers of a row with the cells that its kind has beside them.
    fn all_cells(&self, row: &Row) -> Fields {
        let own = (self.kind.cells)(self, row).into_iter();
        fields(row).into_iter().chain(own.map(|(name, value)| (name.to_owned(), value))).collect()
    }

    /// The cells of a row under the columns. A row that failed says so in place of its first error.
    pub(crate) fn cells(&self, row: &Row) -> Vec<String> {
        let (columns, mut cells) = (self.kind.columns, self.all_cells(row));
        let first = columns.iter().find(|(.., digits)| matches!(digits, Digits::Exponent(_)));
        if let (Some((_, name, _)), None) = (first, &row.found) {
            cells.insert((*name).to_owned(), "fails (1)".into());
        }
        if let Some(error) = self.shown_error(row) {
            cells.insert(self.kind.target.0.to_owned(), error.into());
        }
        Rows(vec![cells]).cells(columns).next().unwrap_or_default()
    }

    /// What is above the table.
    pub(crate) fn title(&self) -> String {
        (self.kind.title)(self)
    }

    /// What is below the table, one line each.
    pub(crate) fn notes(&self) -> Vec<String> {
        let mut notes = (self.kind.notes)(self);
        notes.extend(self.omitted.iter().filter(|entry| entry.rows > 0).map(Omitted::note));
        let failed = self.rows.iter().filter_map(|row| Some((row, row.failure.as_ref()?)));
        notes.extend(
            failed.map(|(row, failure)| {
                format!("(1) {}: {}.", (self.kind.label)(&row.variant), reason(failure))
            }),
        );
        notes
    }

    /// Title, table and notes for a terminal.
    pub(crate) fn text(&self) -> String {
        let cells = self.rows.iter().map(|row| self.cells(row));
        let table = table(presets::ASCII_MARKDOWN, headings(self.kind.columns), cells, self.kind.words);
        let notes: String = self.notes().iter().map(|note| folded(note, 2) + "\n").collect();
        format!("{}\n\n{table}\n{notes}", folded(&self.title(), 2))
    }
}

pub(crate) fn text(comparisons: &[Comparison]) -> String {
    comparisons.iter().map(Comparison::text).collect::<Vec<_>>().join("\n")
}

/// All tables as CSV, with a heading where the columns change.
pub(crate) fn csv(comparisons: &[Comparison]) -> String {
    let section = |comparison: &Comparison| {
        let columns: Vec<String> = comparison.kind.csv.split(',').map(str::to_owned).collect();
        let rows: Vec<Fields> = comparison.rows.iter().map(|row| comparison.all_cells(row)).collect();
        let text = rows_csv(&columns, &rows);
        text.split_once('\n').map(|(heading, rows)| (format!("{heading}\n"), rows.to_owned()))
    };
    csv_sections(comparisons.iter().filter_map(section))
}

/// A resistance in Ω with its unit.
pub(crate) fn resistance(value: f64) -> String {
    if value.is_infinite() { "infinite".to_owned() } else { with_unit(value, "Ω") }
}

impl Omitted {
    fn note(&self) -> String {
        let (precision, math) = (name(&self.precision), name(&self.math));
        format!(
            "{precision} with {math}: {} of {} rows have the errors of the polynomial rows (to a tenth) and are \
             not repeated; {math} takes {:.2} times their run time (median).",
            self.rows, self.of, self.time_ratio
        )
    }
}

/// How a row's step is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Control {
    /// Fixed, a period of the excitation over this number.
    PerPeriod {
        steps: u32,
        /// The period in s.
        period_s: f64,
    },
    /// Fixed.
    Step {
        /// The step in s; of two rates, the step near contact.
        step_s: f64,
        /// The step in s in free flight, of two rates.
        long_step_s: Option<f64>,
    },
    /// Adaptive with this relative tolerance.
    Tolerance(f64),
    /// The method's own.
    Default,
}

impl std::fmt::Display for Control {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::PerPeriod { steps, .. } => write!(f, "T/{steps}"),
            Self::Step { step_s, .. } => write!(f, "{} us", microseconds(*step_s)),
            Self::Tolerance(tolerance) => write!(f, "{tolerance:.0e}"),
            Self::Default => write!(f, "default"),
        }
    }
}

/// A time in µs, to a hundredth.
pub(super) fn microseconds(seconds: f64) -> f64 {
    (seconds * 1e8).round() / 1e2
}

impl Serialize for Control {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        match self {
            Self::Step { step_s, long_step_s } => {
                map.serialize_entry("step_s", step_s)?;
                map.serialize_entry("long_step_s", long_step_s)?;
            }
            other => map.serialize_entry("control", &other.to_string())?,
        }
        map.end()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Variant {
    pub(crate) method: Method,
    pub(crate) precision: Precision,
    /// Elementary functions of the core; `None` for those of the host, and for the core's own choice.
    pub(crate) math: Option<Math>,
    #[serde(flatten)]
    pub(crate) control: Control,
}

impl Variant {
    pub(super) fn reference(control: Control) -> Self {
        Self { method: Method::Reference, precision: Precision::F64, math: None, control }
    }

    pub(super) fn options(&self) -> Options {
        let mut options = Options {
            method: self.method,
            precision: (self.method != Method::Reference).then_some(self.precision),
            math: self.math,
            ..Options::default()
        };
        match self.control {
            Control::PerPeriod { steps, period_s } => options.step_s = Some(period_s / f64::from(steps)),
            Control::Step { step_s, long_step_s } => {
                (options.step_s, options.long_step_s) = (Some(step_s), long_step_s);
            }
            Control::Tolerance(tolerance) => options.tolerance = Some(tolerance),
            Control::Default => {}
        }
        options
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extent {
    /// Most timed runs of each row.
    pub(crate) runs: usize,
    /// Seconds of processor time after which a row that was timed twice is not run again.
    pub(crate) seconds_per_row: f64,
    /// Of how many pairs of a precision and elementary functions, the polynomials in both precisions first.
    pub(crate) backends: usize,
    /// Whether all methods are run with all math backends, all peers and all steps.
    pub(crate) whole: bool,
}

impl Extent {
    pub(crate) const WHOLE: Self = Self { runs: 5, seconds_per_row: 3.0, backends: usize::MAX, whole: true };
    /// What fits in half a minute.
    pub(crate) const SHORT: Self = Self { seconds_per_row: 0.3, backends: 2, whole: false, ..Self::WHOLE };
    /// What fits in some seconds for one scene.
    pub(crate) const FIRST: Self = Self { seconds_per_row: 0.1, backends: 1, ..Self::SHORT };
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
        assert_eq!(resistances, ["100 MΩ", "1000 TΩ", "1 mΩ", "4.7 kΩ", "0 Ω", "infinite"]);
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
