//! The findings as tables.

use comfy_table::{CellAlignment, Table, presets};

use super::grid::{LAWS, law_name};
use super::{AGREEMENT, BumpStopFinding, LEDGER, RESOLVING_STEP, Verdict};
use crate::method::Precision;
use crate::outcome::number;
use crate::stability::table::{largest, precision_name, small};

/// Counts of each verdict by contact law, precision and step, what is meant, and every run that nothing
/// explains.
#[must_use]
pub fn text(findings: &[BumpStopFinding]) -> String {
    let mut table = Table::new();
    let heading = ["contact", "precision", "step [s]"].into_iter().chain(Verdict::ALL.map(Verdict::name));
    table
        .load_style(presets::ASCII_MARKDOWN)
        .set_header(heading.chain(["worst ledger residual", "worst RMS V"]));
    let mut steps: Vec<f64> = findings.iter().map(|finding| finding.step_s).collect();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    for contact in LAWS {
        for precision in [Precision::F32, Precision::F64] {
            for step in &steps {
                let these: Vec<&BumpStopFinding> = findings
                    .iter()
                    .filter(|finding| {
                        finding.setting.contact == contact
                            && finding.precision == precision
                            && finding.step_s == *step
                    })
                    .collect();
                let count = |verdict: Verdict| {
                    these.iter().filter(|finding| finding.verdict == verdict).count().to_string()
                };
                let words =
                    [law_name(contact).to_owned(), precision_name(precision).to_owned(), format!("{step:e}")];
                table.add_row(words.into_iter().chain(Verdict::ALL.map(count)).chain([
                    small(largest(these.iter().map(|finding| finding.energy_residual))),
                    small(largest(these.iter().map(|finding| finding.voltage_difference))),
                ]));
            }
        }
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let [double, single] = LEDGER;
    let mut text = format!(
        "{}\n\nEvery run has finite numbers and no pulling force; under residual-flexibility the energy \
         ledger closes to {double:.0e} in f64 and {single:.0e} in f32. Agrees: the RMS voltage from rest is within \
         {AGREEMENT} of the reference, asked at steps up to {RESOLVING_STEP:.0e} s. Sensitive: the reference's \
         changes by more than a hundredth when the gap is shifted by a thousandth.\n",
        table.trim_fmt()
    );
    for finding in findings.iter().filter(|finding| finding.verdict.is_failure()) {
        text.push_str(&format!(
            "{}: {}, RMS voltage off by {}, ledger {}: --precision {} --step {:e} {}\n",
            finding.verdict.name(),
            finding.reason,
            small(finding.voltage_difference),
            small(finding.energy_residual),
            precision_name(finding.precision),
            finding.step_s,
            finding.setting.overrides()
        ));
    }
    text
}

/// One line of CSV for each run, heading first.
#[must_use]
pub fn csv(findings: &[BumpStopFinding]) -> String {
    let optional = |value: Option<f64>| value.map_or_else(String::new, number);
    let mut text =
        "contact,beam_modes,rod_modes,gap_m,resistance_ohm,rod_young_modulus_pa,damping_ratio,precision,\
                    step_s,verdict,voltage_difference,energy_residual,contacts,reason,options\n"
            .to_owned();
    for finding in findings {
        let setting = &finding.setting;
        let cells = [
            law_name(setting.contact).to_owned(),
            setting.beam_modes.to_string(),
            setting.rod_modes.to_string(),
            number(setting.gap_m),
            number(setting.resistance_ohm),
            number(setting.rod_young_modulus_pa),
            number(setting.damping_ratio),
            precision_name(finding.precision).to_owned(),
            number(finding.step_s),
            finding.verdict.name().to_owned(),
            optional(finding.voltage_difference),
            optional(finding.energy_residual),
            finding.contacts.map_or_else(String::new, |contacts| contacts.to_string()),
            format!("\"{}\"", finding.reason.replace('"', "'")),
            format!("\"{}\"", setting.overrides()),
        ];
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}
