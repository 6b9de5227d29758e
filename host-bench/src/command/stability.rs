//! `stability`: the stiff and extreme table.

use rayon::prelude::*;

use super::{print, progress, work_precision};
use crate::method::Failure;
use crate::outcome::Format;
use crate::scene_file;
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
/// If the shipped scene cannot be read, or if a case is off without an explanation.
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
    print(&match arguments.format {
        Format::Table => table::text(&findings),
        Format::Csv => table::csv(&findings),
        Format::Json => match serde_json::to_string_pretty(&findings) {
            Ok(text) => text + "\n",
            Err(error) => return Err(Failure::Input(format!("--format json: {error}"))),
        },
    })?;
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
