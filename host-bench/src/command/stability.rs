//! `stability`: the stiff and extreme table.

use rayon::prelude::*;

use super::{print, progress, work_precision};
use crate::method::Failure;
use crate::outcome::Format;
use crate::scene_file;
use crate::stability::{Class, Finding, Grid, Kind, Setting, examine, table};

/// Arguments of `stability`.
#[derive(Debug, Clone, clap::Args)]
pub struct StabilityArguments {
    /// Which cases
    #[arg(long, value_enum, default_value_t)]
    grid: Grid,
    /// Of which scene only
    #[arg(long, value_enum, value_name = "SCENE")]
    scene: Option<Kind>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs all cases, on all cores, and prints what became of them.
///
/// # Errors
/// If a shipped scene cannot be read, or if a case is off without an explanation.
pub fn run(arguments: &StabilityArguments) -> Result<(), Failure> {
    let kinds = arguments.scene.map_or(vec![Kind::ContactSeparation, Kind::Sliding], |kind| vec![kind]);
    let mut settings: Vec<(usize, Setting)> = Vec::new();
    let mut bases = Vec::new();
    for (index, kind) in kinds.into_iter().enumerate() {
        let name = match kind {
            Kind::ContactSeparation => "contact-separation.toml",
            Kind::Sliding => "sliding.toml",
        };
        bases.push(scene_file::read(&work_precision::shipped_file(name), &[])?);
        settings.extend(arguments.grid.settings(kind).into_iter().map(|setting| (index, setting)));
    }
    let bar = progress(settings.len());
    let findings: Vec<Finding> = settings
        .into_par_iter()
        .flat_map_iter(|(index, setting)| {
            let findings = examine(&bases[index], setting, setting.is_for_reference());
            bar.inc(1);
            findings
        })
        .collect();
    bar.finish_and_clear();
    print(&match arguments.format {
        Format::Table => {
            let (sliding, contact): (Vec<Finding>, Vec<Finding>) =
                findings.iter().cloned().partition(|finding| matches!(finding.setting, Setting::Sliding(_)));
            let named = [("Contact-separation", contact), ("Sliding", sliding)];
            let there = named.iter().filter(|(_, findings)| !findings.is_empty());
            there.map(|(name, findings)| format!("{name}\n\n{}\n", table::text(findings))).collect()
        }
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
