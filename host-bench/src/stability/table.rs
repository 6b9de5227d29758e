//! The findings as tables.

use comfy_table::{CellAlignment, Table, presets};

use super::grid::law_name;
use super::{AGREEMENT, Class, Finding, LEDGER, MOST_ATTEMPTS, Setting, TIGHT, TOLERANCE};
use crate::method::Precision;
use crate::outcome::number;
use crate::scene_file::ForceLaw;
use crate::work_precision::table::resistance;

pub(super) fn precision_name(precision: Precision) -> &'static str {
    match precision {
        Precision::F32 => "f32",
        Precision::F64 => "f64",
    }
}

pub(super) fn small(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.1e}"))
}

/// The largest of what there is.
pub(super) fn largest(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    values.flatten().fold(None, |largest: Option<f64>, value| Some(largest.map_or(value, |l| l.max(value))))
}

/// Counts of each class by resistance and precision, what was found worst, and every case that is not
/// converged.
#[must_use]
pub fn text(findings: &[Finding]) -> String {
    let mut text = counts(findings);
    text.push('\n');
    for note in notes(findings) {
        text.push_str(&note);
        text.push('\n');
    }
    let left: Vec<&Finding> = findings.iter().filter(|finding| finding.class != Class::Converged).collect();
    if !left.is_empty() {
        text.push_str("\nCases that are not converged:\n\n");
        text.push_str(&list(&left));
    }
    text
}

fn counts(findings: &[Finding]) -> String {
    let mut table = Table::new();
    let heading = ["resistance", "precision"].into_iter().chain(Class::ALL.map(Class::name));
    table
        .load_style(presets::ASCII_MARKDOWN)
        .set_header(heading.chain(["worst ledger residual", "most steps per simulated s"]));
    let mut resistances: Vec<f64> = findings.iter().map(|finding| finding.setting.resistance_ohm()).collect();
    resistances.sort_by(f64::total_cmp);
    resistances.dedup();
    let mut row = |name: String, precision: Precision, these: &[&Finding]| {
        let of = |class: Class| these.iter().filter(|finding| finding.class == class).count().to_string();
        let cells = [name, precision_name(precision).to_owned()].into_iter().chain(Class::ALL.map(of));
        table.add_row(
            cells.chain([
                small(largest(these.iter().map(|finding| finding.energy_residual))),
                largest(these.iter().map(|finding| finding.steps_per_s))
                    .map_or_else(|| "-".to_owned(), |steps| format!("{steps:.0}")),
            ]),
        );
    };
    let precisions = [Precision::F32, Precision::F64];
    for ohms in resistances {
        for precision in precisions {
            let these: Vec<&Finding> = findings
                .iter()
                .filter(|finding| finding.setting.resistance_ohm() == ohms && finding.precision == precision)
                .collect();
            row(resistance(ohms), precision, &these);
        }
    }
    for precision in precisions {
        let these: Vec<&Finding> = findings.iter().filter(|finding| finding.precision == precision).collect();
        row("all".to_owned(), precision, &these);
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt() + "\n"
}

fn notes(findings: &[Finding]) -> Vec<String> {
    let asked = findings.iter().filter(|finding| finding.reference_agrees.is_some()).count();
    let agreed = findings.iter().filter(|finding| finding.reference_agrees == Some(true)).count();
    vec![
        format!(
            "Converged: at a tolerance of {TOLERANCE:.0e} the mean power and the peak gap (of a slider, the amplitude) of the last third \
             of the run agree to {AGREEMENT:.0e} with a run in f64 at {:.0e} (where that fails with a named error: at {:.0e}, \
             or with the reference), and the energy ledger closes to {LEDGER:.0e}.",
            TIGHT[0], TIGHT[1]
        ),
        "Chaotic: the run at the tighter tolerance disagrees with itself when the starting gap (of a slider, the displacement in patch radii) is \
         shifted by 1e-6 to 1e-4, or the stiffness by 1e-5 to 3e-5; mean power and motion are within four standard deviations of the mean of the \
         shifted runs, and the ledger closes."
            .to_owned(),
        "Converging: off by more, but no further than f64 at ten times the tolerance, and in f64 the difference \
         falls with the tolerance to runs that agree: a graze makes more of the tolerance."
            .to_owned(),
        format!("Too dear: given up after {MOST_ATTEMPTS:e} attempted steps."),
        format!("The reference was asked in {asked} of {} cases, and agrees in {agreed}.", findings.len()),
    ]
}

fn list(findings: &[&Finding]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header([
        "class",
        "precision",
        "R",
        "sigma [uC/m^2]",
        "law",
        "others",
        "power off by",
        "motion off by",
        "ledger",
        "reason",
    ]);
    let mut sorted = findings.to_vec();
    sorted.sort_by_key(|finding| std::cmp::Reverse(finding.class));
    for finding in sorted {
        let setting = &finding.setting;
        let (density, law, others) = named(setting);
        table.add_row([
            finding.class.name().to_owned(),
            precision_name(finding.precision).to_owned(),
            resistance(setting.resistance_ohm()),
            format!("{}", (density * 1e9).round() / 1e3),
            law_name(law).to_owned(),
            others,
            small(finding.power_difference),
            small(finding.motion_difference),
            small(finding.energy_residual),
            finding.reason.clone(),
        ]);
    }
    table.trim_fmt() + "\n"
}

/// Charge density, force law, and what else a case is made of.
fn named(setting: &Setting) -> (f64, ForceLaw, String) {
    match setting {
        Setting::ContactSeparation(setting) => (
            setting.charge_density_c_per_m2,
            setting.force_law,
            format!("Cp = {:e} F, e = {}", setting.parasitic_capacitance_f, setting.restitution),
        ),
        Setting::Sliding(setting) => (
            setting.charge_density_c_per_m2,
            setting.force_law,
            format!(
                "mu = {}, {} m/s^2 at {} Hz, {}",
                setting.friction,
                setting.amplitude_m_per_s2,
                setting.frequency_hz,
                if setting.relaxing { "relaxing" } else { "frozen" }
            ),
        ),
    }
}

/// One line of CSV for each case, heading first.
#[must_use]
pub fn csv(findings: &[Finding]) -> String {
    let optional = |value: Option<f64>| value.map_or_else(String::new, number);
    let mut text =
        "scene,resistance_ohm,charge_density_c_per_m2,force_law,parasitic_capacitance_f,restitution,\
                    relaxing,friction,amplitude_m_per_s2,frequency_hz,precision,class,power_difference,\
                    motion_difference,energy_residual,steps_per_s,reference_agrees,reason,options\n"
            .to_owned();
    for finding in findings {
        let own = match &finding.setting {
            Setting::ContactSeparation(setting) => format!(
                "contact-separation,{},{},{},{},{},,,,",
                number(setting.resistance_ohm),
                number(setting.charge_density_c_per_m2),
                law_name(setting.force_law),
                number(setting.parasitic_capacitance_f),
                number(setting.restitution),
            ),
            Setting::Sliding(setting) => format!(
                "sliding,{},{},{},,,{},{},{},{}",
                number(setting.resistance_ohm),
                number(setting.charge_density_c_per_m2),
                law_name(setting.force_law),
                setting.relaxing,
                number(setting.friction),
                number(setting.amplitude_m_per_s2),
                number(setting.frequency_hz),
            ),
        };
        let cells = [
            own,
            precision_name(finding.precision).to_owned(),
            finding.class.name().to_owned(),
            optional(finding.power_difference),
            optional(finding.motion_difference),
            optional(finding.energy_residual),
            optional(finding.steps_per_s),
            finding.reference_agrees.map_or_else(String::new, |agrees| agrees.to_string()),
            format!("\"{}\"", finding.reason.replace('"', "'")),
            format!("\"{}\"", finding.setting.overrides().replace('"', "\"\"")),
        ];
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}
