//! The table as text: the same cells for the terminal, CSV and HTML.

use comfy_table::{CellAlignment, Table, presets};

use super::super::table::{grouped, name, ratio, reason, small};
use super::{BumpStopComparison, Found, LONG_STEP, Row, TARGET_ERROR, Variant};
use crate::method::Method;
use crate::outcome::number;

/// Headings of the table, units in them.
pub const HEADINGS: [&str; 12] = [
    "method",
    "precision",
    "step [us]",
    "error at the end",
    "of first contact",
    "of RMS voltage",
    "of mean force",
    "contacts",
    "steps per simulated s",
    "host ns per simulated s",
    "time ratio",
    "energy residual",
];

/// Columns at the left that hold words.
pub const WORDS: usize = 2;

/// Heading of [`BumpStopComparison::csv`].
pub const CSV_HEADING: &str = "scene,beam_modes,rod_modes,method,precision,step_s,long_step_s,end_error,\
    first_contact_error,rms_voltage_error,mean_force_error,contacts,steps_per_s,ns_per_s,time_ratio,\
    energy_residual,failure\n";

fn method_name(variant: &Variant) -> &'static str {
    match (variant.method, variant.long_step_s) {
        (Method::DiscreteGradient, None) => "discrete gradient",
        (Method::DiscreteGradient, Some(_)) => "discrete gradient, two rates",
        (Method::TrBdf2, _) => "TR-BDF2 (std)",
        (Method::Newmark, _) => "Newmark (std)",
        (Method::Rk4, _) => "explicit RK4 (std)",
        (Method::Auto | Method::Reference, _) => "reference",
    }
}

impl Row {
    /// The cells under [`HEADINGS`]. A row that failed has its reason below the table.
    #[must_use]
    pub fn cells(&self) -> Vec<String> {
        let variant = &self.variant;
        let mut cells = vec![
            method_name(variant).to_owned(),
            name(&variant.precision),
            format!("{}", (variant.step_s * 1e8).round() / 1e2),
        ];
        match &self.found {
            Some(found) => cells.extend([
                small(Some(found.end_error)),
                small(found.first_contact_error),
                small(found.rms_voltage_error),
                small(found.mean_force_error),
                found.contacts.to_string(),
                grouped(found.steps_per_s),
                grouped(found.ns_per_s),
                ratio(found.time_ratio),
                small(found.energy_residual),
            ]),
            None => {
                cells.push("fails (1)".to_owned());
                cells.extend(std::iter::repeat_n("-".to_owned(), HEADINGS.len() - WORDS - 2));
            }
        }
        cells
    }

    /// Whether the row meets [`TARGET_ERROR`].
    #[must_use]
    pub fn reaches_target(&self) -> bool {
        self.found.and_then(|found| found.rms_voltage_error).is_some_and(|error| error <= TARGET_ERROR)
    }
}

impl BumpStopComparison {
    /// What is above the table.
    #[must_use]
    pub fn title(&self) -> String {
        let [beam, rod] = self.modes;
        let stop = self.stop_m.map_or_else(
            || "no stop".to_owned(),
            |[position, gap]| {
                let micrometres = (gap * 1e9).round() / 1e3;
                format!("stop at {} mm, gap {micrometres} um", (position * 1e6).round() / 1e3)
            },
        );
        let shown = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| "none".to_owned(), |value| format!("{value:.6e} {unit}"))
        };
        format!(
            "{}, ({beam}, {rod}) modes, {stop}, {} s simulated, measured from {} s; by the reference: RMS voltage \
             {}, {} contacts, the first at {}, {} ns per simulated s",
            self.file,
            self.duration_s,
            self.settle_s,
            shown(self.rms_voltage_v, "V"),
            self.contacts,
            shown(self.first_contact_s, "s"),
            grouped(self.reference_ns_per_s),
        )
    }

    /// What is to be said below the table, one line each.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let mut notes = vec![format!(
            "Errors are relative to the reference; at the end: of the state, in the energy norm. Run times are those \
             of stepping and of the meters shown, without energy ledger. Two rates: {:.0} us in free flight. Time ratio is to the fastest row whose error of RMS \
             voltage is at most {TARGET_ERROR:.0e}. Where the motion is chaotic only statistics can agree.",
            LONG_STEP * 1e6
        )];
        notes.push(self.fastest());
        for row in &self.rows {
            if let Some(failure) = &row.failure {
                let cells = row.cells();
                notes.push(format!("(1) {}, {} us: {}.", cells[0], cells[WORDS], reason(failure)));
            }
        }
        notes
    }

    /// The fastest row of each method that meets the target.
    fn fastest(&self) -> String {
        let of = |told: &str, pick: &dyn Fn(&Variant) -> bool| {
            let rows = self.rows.iter().filter(|row| pick(&row.variant) && row.reaches_target());
            let found = rows.filter_map(|row| Some((row.found?, row.variant.step_s)));
            let fastest = found.min_by(|(one, _), (two, _)| one.ns_per_s.total_cmp(&two.ns_per_s));
            match fastest {
                Some((Found { ns_per_s, .. }, step)) => {
                    format!("{told} {:.0} us (step {:.2} us)", ns_per_s / 1e3, step * 1e6)
                }
                None => format!("{told} none"),
            }
        };
        let parts = [
            of("the core", &Variant::is_of_core),
            of("TR-BDF2", &|variant| variant.method == Method::TrBdf2),
            of("Newmark", &|variant| variant.method == Method::Newmark),
            of("RK4", &|variant| variant.method == Method::Rk4),
        ];
        format!("Host time per simulated second of the fastest rows within that: {}.", parts.join(", "))
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
        format!("{}\n\n{}\n\n{}\n", self.title(), table.trim_fmt(), self.notes().join("\n"))
    }

    /// One line of CSV for each row, without heading.
    #[must_use]
    pub fn csv(&self) -> String {
        let optional = |value: Option<f64>| value.map_or_else(String::new, number);
        let mut text = String::new();
        for Row { variant, found, failure } in &self.rows {
            let mut cells = vec![
                format!("\"{}\"", self.file),
                self.modes[0].to_string(),
                self.modes[1].to_string(),
                name(&variant.method),
                name(&variant.precision),
                number(variant.step_s),
                optional(variant.long_step_s),
            ];
            match found {
                Some(found) => cells.extend([
                    number(found.end_error),
                    optional(found.first_contact_error),
                    optional(found.rms_voltage_error),
                    optional(found.mean_force_error),
                    found.contacts.to_string(),
                    number(found.steps_per_s),
                    number(found.ns_per_s),
                    optional(found.time_ratio),
                    optional(found.energy_residual),
                ]),
                None => cells.extend(std::iter::repeat_n(String::new(), 9)),
            }
            let failure = failure.as_deref().map(reason).unwrap_or_default();
            cells.push(failure.replace([',', '"'], ";"));
            text.push_str(&cells.join(","));
            text.push('\n');
        }
        text
    }
}
