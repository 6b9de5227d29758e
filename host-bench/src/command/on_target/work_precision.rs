//! Error against instructions, on the settled impacting scene.

use std::time::Duration;

use firmware_example::workload::scenes;

use super::table;
use crate::embedded;
use crate::method::{Method, Options, Precision};
use crate::on_target::build::Binary;
use crate::on_target::core::Core;
use crate::on_target::{self, Error, accuracy, native};

/// The sample at which the measured window starts, and its time in seconds.
const SETTLED: usize = 1;
const SETTLED_S: f64 = 10.0;

/// Measures the scene with each setting and prints one table.
///
/// # Errors
///
/// If the firmware cannot be built, run, or trusted.
pub(super) fn report(core: Core, limit: Duration) -> Result<(), Error> {
    let scene = accuracy::scene(&scenes::SETTLING, SETTLED_S, |_| {})?;
    let reference = accuracy::reference_power(&scene)?;
    let measurement = on_target::measure(core, Binary::new("precision"), limit)?;
    scenes::with_precision(|native| {
        native::compare_all(core, &measurement.workloads, native::accepted(native)?)
    })?;
    let mut rows = Vec::new();
    for (workload, (method, setting, options)) in measurement.workloads.iter().zip(settings()) {
        let settled = workload.after(SETTLED);
        let double = embedded::run(&scene, &options).map_err(|error| Error::Host(error.to_string()))?;
        rows.push([
            method.to_owned(),
            setting,
            format!("{:.0}", settled.steps as f64 / settled.seconds),
            accuracy::error(accuracy::mean_power(workload, Some(SETTLED)), reference),
            accuracy::error(double.mean_power_w.unwrap_or(f64::NAN), reference),
            format!("{:.0}", settled.instructions_per_step()),
            format!("{:.0}", settled.instructions_per_second()),
        ]);
    }
    let header = [
        "method",
        "setting",
        "steps per second",
        "error f32",
        "error f64",
        "instructions per step",
        "per simulated second",
    ];
    println!("{}", table(header, rows, 2));
    println!(
        "{core}. Contact-separation, 20 Hz, 0.2 g, from {SETTLED_S} s to {} s. Error: of the mean power",
        scene.run.duration_s
    );
    println!("against the independent reference; f32 is this core's run, with the host's bits, f64 the");
    println!("host's. Instructions as QEMU executes them, which are not cycles.");
    Ok(())
}

/// Name, setting, and the options of the same run in double precision, in the firmware's order.
fn settings() -> impl Iterator<Item = (&'static str, String, Options)> {
    let double = Options { precision: Some(Precision::F64), ..Options::default() };
    let tolerances = scenes::TOLERANCES.into_iter().map(move |tolerance| {
        let options = Options { tolerance: Some(f64::from(tolerance)), ..double };
        ("TR-BDF2", format!("tolerance {tolerance}"), options)
    });
    let step = move |name, method, step: f32| {
        let options = Options { method, step_s: Some(f64::from(step)), ..double };
        (name, format!("step {} ms", step * 1e3), options)
    };
    let fixed = scenes::STEPS.into_iter().map(move |length| step("TR-BDF2", Method::TrBdf2, length));
    let explicit =
        scenes::EXPLICIT_STEPS.into_iter().map(move |length| step("Runge-Kutta 4", Method::Rk4, length));
    tolerances.chain(fixed).chain(explicit)
}
