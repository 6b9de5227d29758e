//! The findings as a table.

use super::grid::{LAWS, law_name};
use super::{AGREEMENT, BumpStopFinding, LEDGER, RESOLVING_STEP};
use crate::method::Precision;
use crate::outcome::{name, small};
use crate::stability::Finding;
use crate::stability::table::{Largest, counts};

/// Counts of each verdict by contact law, precision and step, a note, and every run that nothing explains.
pub(super) fn text(findings: &[BumpStopFinding]) -> String {
    let [double, single] = LEDGER;
    let mut text = format!(
        "{}\nEvery run has finite numbers and no pulling force; under residual-flexibility the energy \
         ledger closes to {double:.0e} in f64 and {single:.0e} in f32. Agrees: the RMS voltage from rest is within \
         {AGREEMENT} of the reference, asked at steps up to {RESOLVING_STEP:.0e} s. Sensitive: the reference's \
         changes by more than a hundredth when the gap is shifted by a thousandth.\n",
        counted(findings)
    );
    for finding in findings.iter().filter(|finding| finding.verdict.is_failure()) {
        text.push_str(&format!(
            "{}: {}, RMS voltage off by {}, ledger {}: {}\n",
            name(&finding.verdict),
            finding.reason,
            small(finding.voltage_difference),
            small(finding.energy_residual),
            finding.options()
        ));
    }
    text
}

fn counted(findings: &[BumpStopFinding]) -> String {
    let mut steps: Vec<f64> = findings.iter().map(|finding| finding.step_s).collect();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    let mut groups = Vec::new();
    for contact in LAWS {
        for precision in [Precision::F32, Precision::F64] {
            for &step in &steps {
                let these = findings.iter().filter(|finding| {
                    finding.setting.contact == contact
                        && finding.precision == precision
                        && finding.step_s == step
                });
                let words = [law_name(contact).to_owned(), precision.name().to_owned(), format!("{step:e}")];
                groups.push((words, these.collect()));
            }
        }
    }
    let residual: Largest<BumpStopFinding> =
        ("worst ledger residual", |finding| finding.energy_residual, small);
    let voltage: Largest<BumpStopFinding> = ("worst RMS V", |finding| finding.voltage_difference, small);
    counts(["contact", "precision", "step [s]"], groups, |finding| finding.verdict, [residual, voltage])
}
