//! Error against instructions, on the settled scenes.

use std::time::Duration;

use firmware_example::workload::bump_stop::modal_run::REJECTED;
use firmware_example::workload::bump_stop::scenes as bump_stop;
use firmware_example::workload::contact_separation::scenes as contact_separation;
use firmware_example::workload::sliding::scenes as sliding;

use super::table;
use crate::embedded;
use crate::method::{Method, Options, Precision};
use crate::on_target::accuracy::{self, Yardstick};
use crate::on_target::build::Binary;
use crate::on_target::core::Core;
use crate::on_target::{self, Error, native};

/// The sample at which the measured window starts, and its time in seconds.
const SETTLED: usize = 1;
const SETTLED_S: f64 = 10.0;

/// Measures the scenes with each setting and prints a table of each.
///
/// # Errors
///
/// If the firmware cannot be built, run, or trusted.
pub(super) fn report(core: Core, limit: Duration) -> Result<(), Error> {
    report_contact_separation(core, limit)?;
    println!();
    report_sliding(core, limit)?;
    println!();
    report_bump_stop(core, limit)
}

fn report_contact_separation(core: Core, limit: Duration) -> Result<(), Error> {
    let scene = accuracy::contact_separation(&contact_separation::SETTLING, SETTLED_S, |_| {})?;
    let reference = accuracy::reference_power(&scene)?;
    let measurement = on_target::measure(core, Binary::new("precision"), limit)?;
    contact_separation::with_precision(|native| {
        native::compare_all(core, &measurement.workloads, native::accepted(native)?)
    })?;
    let settings = settings(
        &contact_separation::TOLERANCES,
        &contact_separation::STEPS,
        &contact_separation::EXPLICIT_STEPS,
    );
    let mut rows = Vec::new();
    for (workload, (method, setting, options)) in measurement.workloads.iter().zip(settings) {
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

fn report_sliding(core: Core, limit: Duration) -> Result<(), Error> {
    let measurement = on_target::measure(core, Binary::new("sliding_precision"), limit)?;
    sliding::with_precision(|native| {
        native::compare_all(core, &measurement.workloads, native::accepted(native)?)
    })?;
    let settings = settings(&sliding::TOLERANCES, &sliding::STEPS, &sliding::EXPLICIT_STEPS);
    // Beside the resonance the host runs alone: the bits at resonance are the core's.
    let mut errors = Vec::new();
    for plan in [sliding::BELOW, sliding::SETTLING, sliding::ABOVE] {
        let reference = accuracy::reference_power(&accuracy::sliding(&plan, SETTLED_S, |_, _| {})?)?;
        errors.push(sliding::with_precision_of(plan, |native| {
            let runs = native::accepted(native)?.iter_mut().map(|run| native::run(*run));
            let power = |states: Vec<_>| accuracy::native_power(&states, SETTLED, &plan);
            runs.map(|states| Ok(accuracy::error(power(states?), reference)))
                .collect::<Result<Vec<_>, Error>>()
        })?);
    }
    let mut rows = Vec::new();
    for (index, (workload, (method, setting, _))) in measurement.workloads.iter().zip(settings).enumerate() {
        let settled = workload.after(SETTLED);
        let error = |frequency: usize| errors.get(frequency)?.get(index).cloned();
        rows.push([
            method.to_owned(),
            setting,
            format!("{:.0}", settled.steps as f64 / settled.seconds),
            error(1).unwrap_or_default(),
            error(0).unwrap_or_default(),
            error(2).unwrap_or_default(),
            format!("{:.0}", settled.instructions_per_step()),
            format!("{:.0}", settled.instructions_per_second()),
        ]);
    }
    let header = [
        "method",
        "setting",
        "steps per second",
        "error at 18.373 Hz",
        "at 18.303 Hz",
        "at 18.443 Hz",
        "instructions per step",
        "per simulated second",
    ];
    println!("{}", table(header, rows, 2));
    println!(
        "{core}. Sliding, 0.36 g, from {SETTLED_S} s to {} s. Error: of the f32 mean power, with this",
        sliding::SETTLING.seconds()
    );
    println!("core's bits, against the independent reference. Steps and instructions at 18.373 Hz, four");
    println!("events a period included. Instructions as QEMU executes them, which are not cycles.");
    Ok(())
}

fn report_bump_stop(core: Core, limit: Duration) -> Result<(), Error> {
    let measurement = on_target::measure(core, Binary::new("bump_stop_precision"), limit)?;
    bump_stop::with_precision(|native| {
        native::compare_all(core, &measurement.workloads, native::accepted(native)?)
    })?;
    let mut workloads = measurement.workloads.iter();
    let mut rows = Vec::new();
    for gap in bump_stop::GAPS {
        let scene = accuracy::bump_stop(&bump_stop::SETTLING, gap, 0.5, |_, _| {})?;
        let yardstick = Yardstick::rms_voltage(&scene)?;
        for ([short, long], workload) in bump_stop::STEPS.into_iter().zip(&mut workloads) {
            let whole = workload.whole();
            let rejected = workload.samples.last().and_then(|sample| sample.bits.get(REJECTED));
            rows.push([
                format!("{}", gap * 1e6),
                format!("{}", short * 1e6),
                format!("{}", long * 1e6),
                format!("{:.0}", whole.steps as f64 / whole.seconds),
                rejected
                    .map_or_else(String::new, |&count| format!("{:.0}", f64::from(count) / whole.seconds)),
                yardstick.error(workload),
                format!("{:.0}", whole.instructions_per_step()),
                format!("{:.0}", whole.instructions_per_second()),
            ]);
        }
    }
    let header = [
        "gap in um",
        "short step in us",
        "long step in us",
        "steps per second",
        "not taken",
        "error",
        "instructions per step",
        "per simulated second",
    ];
    println!("{}", table(header, rows, 0));
    println!(
        "{core}. Bump-stop, four modes of the beam and one of the rod, 20 m/s2 at 220 Hz, from rest to {} s.",
        bump_stop::SETTLING.seconds()
    );
    println!(
        "Error: of the RMS voltage from 0.5 s on, against the reference with the same modes; the motion"
    );
    println!(
        "is weakly chaotic, and a few per cent are scatter. Not taken: long steps that were tried where"
    );
    println!("a contact might have been. Instructions as QEMU executes them, which are not cycles.");
    Ok(())
}

/// Name, setting, and the options of the same run in double precision, in the firmware's order.
fn settings(
    tolerances: &[f32],
    steps: &[f32],
    explicit_steps: &[f32],
) -> Vec<(&'static str, String, Options)> {
    let double = Options { precision: Some(Precision::F64), ..Options::default() };
    let tolerances = tolerances.iter().map(|&tolerance| {
        // The largest tolerance in `f32` is by a rounding more than the largest one in `f64`.
        let options = Options { tolerance: Some(f64::from(tolerance).min(0.1)), ..double };
        ("TR-BDF2", format!("tolerance {tolerance}"), options)
    });
    let step = |name, method, step: f32| {
        let options = Options { method, step_s: Some(f64::from(step)), ..double };
        (name, format!("step {} ms", step * 1e3), options)
    };
    let fixed = steps.iter().map(|&length| step("TR-BDF2", Method::TrBdf2, length));
    let explicit = explicit_steps.iter().map(|&length| step("Runge-Kutta 4", Method::Rk4, length));
    tolerances.chain(fixed).chain(explicit).collect()
}
