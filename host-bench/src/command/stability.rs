//! `stability`: the stiff and extreme table.

use rayon::prelude::*;

use super::{one_more, print, progress, work_precision};
use crate::method::Failure;
use crate::outcome::Format;
use crate::scene_file;
use crate::stability::bump_stop::{self, BumpStopFinding};
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
    let kinds = arguments
        .scene
        .map_or(vec![Kind::ContactSeparation, Kind::Sliding, Kind::BumpStop], |kind| vec![kind]);
    let has_stop = kinds.contains(&Kind::BumpStop);
    let mut settings: Vec<(usize, Setting)> = Vec::new();
    let mut bases = Vec::new();
    for (index, kind) in kinds.into_iter().enumerate() {
        let name = match kind {
            Kind::ContactSeparation => "contact-separation.toml",
            Kind::Sliding => "sliding.toml",
            Kind::BumpStop => "bump-stop.toml",
        };
        bases.push(scene_file::read(&work_precision::shipped_file(name), &[])?);
        settings.extend(arguments.grid.settings(kind).into_iter().map(|setting| (index, setting)));
    }
    let bar = progress(settings.len());
    let findings: Vec<Finding> = settings
        .into_par_iter()
        .flat_map_iter(|(index, setting)| {
            let findings = examine(&bases[index], setting, setting.is_for_reference());
            one_more(&bar);
            findings
        })
        .collect();
    bar.finish_and_clear();
    let with_stop = if has_stop { with_stop(arguments.grid)? } else { Vec::new() };
    print(&match arguments.format {
        Format::Table => {
            let (sliding, contact): (Vec<Finding>, Vec<Finding>) =
                findings.iter().cloned().partition(|finding| matches!(finding.setting, Setting::Sliding(_)));
            let named = [("Contact-separation", contact), ("Sliding", sliding)];
            let there = named.iter().filter(|(_, findings)| !findings.is_empty());
            let mut text: String =
                there.map(|(name, findings)| format!("{name}\n\n{}\n", table::text(findings))).collect();
            if has_stop {
                text.push_str(&format!("Bump-stop\n\n{}", bump_stop::table::text(&with_stop)));
            }
            text
        }
        Format::Csv => {
            // The kinds have columns of their own.
            let triboelectric = if findings.is_empty() { String::new() } else { table::csv(&findings) };
            let gap = if has_stop && !findings.is_empty() { "\n" } else { "" };
            let with_stop = if has_stop { bump_stop::table::csv(&with_stop) } else { String::new() };
            triboelectric + gap + &with_stop
        }
        Format::Json => match json(&findings, &with_stop) {
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

/// The findings of all kinds, in one list.
fn json(findings: &[Finding], with_stop: &[BumpStopFinding]) -> serde_json::Result<String> {
    let findings = findings.iter().map(serde_json::to_value);
    let all = findings.chain(with_stop.iter().map(serde_json::to_value));
    serde_json::to_string_pretty(&all.collect::<serde_json::Result<Vec<_>>>()?)
}

/// Runs all bump-stop cases.
fn with_stop(grid: Grid) -> Result<Vec<BumpStopFinding>, Failure> {
    let base = scene_file::read(&work_precision::shipped_file("bump-stop.toml"), &[])?;
    let settings = bump_stop::settings();
    let bar = progress(settings.len());
    let findings = settings
        .into_par_iter()
        .flat_map_iter(|setting| {
            let findings = bump_stop::examine(&base, setting, bump_stop::steps(grid));
            one_more(&bar);
            findings
        })
        .collect();
    bar.finish_and_clear();
    Ok(findings)
}
