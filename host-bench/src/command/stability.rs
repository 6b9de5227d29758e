//! `stability`: the stiff and extreme table.

use rayon::prelude::*;

use super::{print, progress, work_precision};
use crate::method::Failure;
use crate::outcome::Format;
use crate::scene_file;
use crate::stability::bump_stop::{self, BumpStopFinding};
use crate::stability::{Class, Finding, Grid, examine, table};

/// Arguments of `stability`.
#[derive(Debug, Clone, clap::Args)]
pub struct StabilityArguments {
    /// Which cases
    #[arg(long, value_enum, default_value_t)]
    grid: Grid,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs all cases, on all cores, and prints what became of them.
///
/// # Errors
/// If a shipped scene cannot be read, or if a case is off without an explanation.
pub fn run(arguments: &StabilityArguments) -> Result<(), Failure> {
    let base = scene_file::read(&work_precision::shipped_file(), &[])?;
    let settings = arguments.grid.settings();
    let bar = progress(settings.len());
    let findings: Vec<Finding> = settings
        .into_par_iter()
        .flat_map_iter(|setting| {
            let findings = examine(&base, setting, setting.is_for_reference());
            bar.inc(1);
            findings
        })
        .collect();
    bar.finish_and_clear();
    let with_stop = with_stop(arguments.grid)?;
    print(&match arguments.format {
        Format::Table => table::text(&findings) + "\n" + &bump_stop::table::text(&with_stop),
        Format::Csv => table::csv(&findings) + "\n" + &bump_stop::table::csv(&with_stop),
        Format::Json => match serde_json::to_string_pretty(&(&findings, &with_stop)) {
            Ok(text) => text + "\n",
            Err(error) => return Err(Failure::Input(format!("--format json: {error}"))),
        },
    })?;
    let off = with_stop.iter().filter(|finding| finding.verdict.is_failure());
    if let Some(first) = off.clone().next() {
        return Err(Failure::Step(format!(
            "{} of {} bump-stop runs are off without an explanation, the first with --step {:e} {}",
            off.count(),
            with_stop.len(),
            first.step_s,
            first.setting.overrides(),
        )));
    }
    let silent: Vec<&Finding> = findings.iter().filter(|finding| finding.class == Class::Silent).collect();
    match silent.first() {
        None => Ok(()),
        Some(first) => Err(Failure::Step(format!(
            "{} of {} cases are off without an explanation, the first with {}",
            silent.len(),
            findings.len(),
            first.setting.overrides(),
        ))),
    }
}

/// Runs all bump-stop cases.
fn with_stop(grid: Grid) -> Result<Vec<BumpStopFinding>, Failure> {
    let base = scene_file::read(&work_precision::bump_stop::shipped_file(), &[])?;
    let settings = bump_stop::settings();
    let bar = progress(settings.len());
    let findings = settings
        .into_par_iter()
        .flat_map_iter(|setting| {
            let findings = bump_stop::examine(&base, setting, bump_stop::steps(grid));
            bar.inc(1);
            findings
        })
        .collect();
    bar.finish_and_clear();
    Ok(findings)
}
