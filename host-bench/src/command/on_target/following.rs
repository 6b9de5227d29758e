//! The log of the node that follows its harvester.

use std::time::Duration;

use serde_json::json;

use super::estimate_energy::{self, Estimate, mean_income};
use super::output::Output;
use crate::on_target::core::Core;
use crate::on_target::{Bench, Error, following};

/// Runs the node and prints its log, the energy of its estimate and the share of its income.
///
/// # Errors
///
/// If the firmware does not build or run, or the host's run logs anything else.
pub(super) fn report(core: Core, limit: Duration, output: &mut Output) -> Result<(), Error> {
    let (reports, size) = following::follow(core, limit)?;
    let rows = reports.iter().map(|report| {
        let [harvested, stored] = report.microjoules();
        vec![
            report.second.to_string(),
            report.decision.name().to_owned(),
            format!("{harvested:.4}"),
            format!("{stored:.3}"),
            report.steps.to_string(),
        ]
    });
    let note = format!(
        "{core}. The model of the harvester follows 400 samples a second from flash.
Each logged value has the host's bits. The whole firmware, trace and log included: {} bytes of flash.",
        size.flash
    );
    let header = vec!["second", "decision", "harvested in uJ", "stored in uJ", "steps"];
    let income = mean_income(&reports);
    output.table(header, rows.collect(), 2, &note);
    output.object(json!({
        "core": core.to_string(),
        "variant": "node_following",
        "scene": "node_following",
        "load_ohm": null,
        "method": super::rows::RADAU,
        "instructions_per_simulated_second": null,
        "mean_power_error": null,
        "flash_bytes": size.flash,
        "ram_bytes": size.static_ram,
        "income_w": income,
    }));
    let estimate = Estimate::of_node(&Bench::new(core, limit)?)?;
    estimate_energy::report(core, &[estimate], income, output);
    Ok(())
}
