//! The smooth scene by the crate numeris beside ours.

use std::time::Duration;

use firmware_example::workload::contact_separation::scenes;

use super::table;
use crate::on_target::build::Binary;
use crate::on_target::core::Core;
use crate::on_target::{self, Error, accuracy, native};

/// Measures both and prints one table.
///
/// # Errors
///
/// If the firmware cannot be built, run, or trusted.
pub(super) fn report(core: Core, limit: Duration) -> Result<(), Error> {
    let scene = accuracy::contact_separation(&scenes::SMOOTH, 0.0, |_| {})?;
    let reference = accuracy::reference_power(&scene)?;
    let binary = Binary { name: "peer", feature: Some("peer") };
    let measurement = on_target::measure(core, binary, limit)?;
    let settings = settings();
    let ours = settings.iter().filter(|(_, _, peer)| !peer).count();
    scenes::with_smooth(|native| {
        let measured = measurement.workloads.get(..ours).unwrap_or_default();
        native::compare_all(core, measured, native::accepted(native)?)
    })?;
    let mut rows = Vec::new();
    for (workload, (method, setting, _)) in measurement.workloads.iter().zip(settings) {
        let whole = workload.whole();
        rows.push([
            method.to_owned(),
            setting,
            whole.steps.to_string(),
            accuracy::error(accuracy::mean_power(workload, None), reference),
            format!("{:.0}", whole.instructions_per_step()),
            format!("{:.0}", whole.instructions_per_second()),
        ]);
    }
    let header = ["method", "setting", "steps", "error", "instructions per step", "per simulated second"];
    println!("{}", table(header, rows, 2));
    println!(
        "{core}. Contact-separation without impacts, 22 Hz, 0.2 g, {} s from rest, both in f32.",
        scene.run.duration_s
    );
    println!("Error: of the mean power against the independent reference. numeris has the energy as a");
    println!("fourth state, and time as a fifth, in place of the time derivative that it has no term for.");
    println!("Instructions as QEMU executes them, which are not cycles.");
    Ok(())
}

/// Method, setting, and whether it is the peer's, in the firmware's order.
fn settings() -> Vec<(&'static str, String, bool)> {
    let tolerance = |tolerance: f32| format!("tolerance {tolerance:e}");
    let ours = scenes::SMOOTH_TOLERANCES.map(|value| ("model-core, TR-BDF2", tolerance(value), false));
    let step = format!("step {} ms", scenes::SMOOTH_STEP * 1e3);
    let peer = scenes::PEER_TOLERANCES.map(|value| ("numeris 0.6, RODAS4", tolerance(value), true));
    ours.into_iter().chain([("model-core, Runge-Kutta 4", step, false)]).chain(peer).collect()
}
