//! The findings as tables.

use comfy_table::presets;

use super::judge::{AGREEMENT, LEDGER, MOST_ATTEMPTS, TIGHT, TOLERANCE};
use super::{Class, Finding, Setting, law_name};
use crate::method::Precision;
use crate::outcome::{name, small, table};
use crate::stability::table::{Largest, counts};
use crate::work_precision::table::resistance;

/// Counts of each class by resistance and precision, notes, and every case that is not converged.
pub(super) fn text<T: Setting>(findings: &[Finding<T>]) -> String {
    let mut text = format!("{}\n{}\n", counted(findings), notes(findings).join("\n"));
    let left: Vec<&Finding<T>> =
        findings.iter().filter(|finding| finding.class != Class::Converged).collect();
    if !left.is_empty() {
        text.push_str("\nCases that are not converged:\n\n");
        text.push_str(&list(left));
    }
    text + "\n"
}

fn counted<T: Setting>(findings: &[Finding<T>]) -> String {
    let mut resistances: Vec<f64> =
        findings.iter().map(|finding| finding.setting.common().resistance_ohm).collect();
    resistances.sort_by(f64::total_cmp);
    resistances.dedup();
    let mut groups = Vec::new();
    for ohms in resistances.into_iter().map(Some).chain([None]) {
        for precision in [Precision::F32, Precision::F64] {
            let these = findings.iter().filter(|finding| {
                finding.precision == precision
                    && ohms.is_none_or(|ohms| finding.setting.common().resistance_ohm == ohms)
            });
            let name = ohms.map_or_else(|| "all".to_owned(), resistance);
            groups.push(([name, precision.name().to_owned()], these.collect()));
        }
    }
    let whole = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.0}"));
    let residual: Largest<Finding<T>> = ("worst ledger residual", |finding| finding.energy_residual, small);
    let steps: Largest<Finding<T>> = ("most steps per simulated s", |finding| finding.steps_per_s, whole);
    counts(["resistance", "precision"], groups, |finding| finding.class, [residual, steps])
}

fn notes<T>(findings: &[Finding<T>]) -> Vec<String> {
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
         falls with the tolerance to runs that agree: grazing amplifies the error."
            .to_owned(),
        format!("Step limit: stopped after {MOST_ATTEMPTS:e} attempted steps."),
        format!("The reference was asked in {asked} of {} cases, and agrees in {agreed}.", findings.len()),
    ]
}

fn list<T: Setting>(mut findings: Vec<&Finding<T>>) -> String {
    let headings = [
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
    ];
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.class));
    let rows = findings.iter().map(|finding| {
        let common = finding.setting.common();
        [
            name(&finding.class),
            finding.precision.name().to_owned(),
            resistance(common.resistance_ohm),
            format!("{}", (common.charge_density_c_per_m2 * 1e9).round() / 1e3),
            law_name(common.force_law).to_owned(),
            finding.setting.others(),
            small(finding.power_difference),
            small(finding.motion_difference),
            small(finding.energy_residual),
            finding.reason.clone(),
        ]
    });
    table(presets::NOTHING, headings, rows, headings.len())
}
