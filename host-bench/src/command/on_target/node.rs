//! The sensor node's log.

use std::time::Duration;

use serde_json::json;

use super::announce;
use super::estimate_energy::{self, Estimate, mean_income};
use super::output::Output;
use crate::on_target::core::Core;
use crate::on_target::node::Kind;
use crate::on_target::{Bench, Error, node};

/// Runs the node of each core and prints its log, the energy of its estimate and the share of its income.
///
/// # Errors
///
/// If the firmware does not build or run, or the host's run logs anything else.
pub(super) fn report(cores: &[Core], limit: Duration, output: &mut Output) -> Result<(), Error> {
    cores.iter().try_for_each(|&core| report_one(core, limit, output))
}

fn report_one(core: Core, limit: Duration, output: &mut Output) -> Result<(), Error> {
    announce(core);
    let (reports, size) = node::follow(core, limit)?;
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
    let (scene, method, how) = match Kind::of(core) {
        Kind::Following => (
            "node",
            super::rows::RADAU,
            "The model of the harvester follows 400 samples a second from flash.",
        ),
        Kind::Listening => (
            "node-listening",
            "closed form",
            "A closed form is evaluated at the strongest sine of 400 samples a second from flash.",
        ),
    };
    let note = format!(
        "{core}. {how}
Each logged value has the host's bits. The whole firmware, trace and log included: {} bytes of flash.",
        size.flash
    );
    let header = vec!["second", "decision", "harvested in uJ", "stored in uJ", "steps"];
    let income = mean_income(&reports);
    output.table(header, rows.collect(), 2, &note);
    output.object(json!({
        "core": core.to_string(),
        "variant": scene,
        "scene": scene,
        "load_ohm": null,
        "method": method,
        "instructions_per_simulated_second": null,
        "mean_power_error": null,
        "flash_bytes": size.flash,
        "ram_bytes": size.static_ram,
        "income_w": income,
    }));
    let estimate = Estimate::of_node(&Bench::new(core, limit)?, Kind::of(core))?;
    estimate_energy::report(core, &[estimate], income, output);
    Ok(())
}
