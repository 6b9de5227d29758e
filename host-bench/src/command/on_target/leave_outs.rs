//! What each part of the scene costs: the bench without it.

use std::time::Duration;

use firmware_example::workload::{Workload, parts, scenes};

use super::table;
use crate::on_target::build::Binary;
use crate::on_target::core::Core;
use crate::on_target::{self, Error, accuracy, native};
use crate::scene_file::{ContactSeparationParameters, Restitution};

/// A change of the scene.
type Change = fn(&mut ContactSeparationParameters);

/// Measures each variant and prints one table.
///
/// # Errors
///
/// If a firmware cannot be built, run, or trusted.
pub(super) fn report(core: Core, limit: Duration) -> Result<(), Error> {
    let no_capacitance: Change = |parameters| parameters.parasitic_capacitance_f = 0.0;
    let one_coefficient: Change = |parameters| {
        let coefficient = f64::from(parts::CONSTANT.coefficient);
        parameters.restitution = Restitution::Constant { coefficient };
    };
    let both: Change = |parameters| {
        parameters.parasitic_capacitance_f = 0.0;
        let coefficient = f64::from(parts::CONSTANT.coefficient);
        parameters.restitution = Restitution::Constant { coefficient };
    };
    let same: Change = |_| {};
    let mut rows = Vec::new();
    let mut whole = None;
    let mut add = |left_out: &str, binary, native: Box<dyn Workload>, change: Change| {
        let row = measure(core, limit, binary, native, change)?;
        let base = *whole.get_or_insert(row.flash);
        rows.push([
            left_out.to_owned(),
            row.flash.to_string(),
            format!("{:+}", row.flash.cast_signed() - base.cast_signed()),
            row.steps.to_string(),
            format!("{:.0}", row.per_step),
            format!("{:.0}", row.per_second),
            row.error,
        ]);
        Ok::<_, Error>(())
    };
    add("nothing", "bench", boxed(scenes::bench())?, same)?;
    add("parasitic capacitance", "without_parasitic", boxed(scenes::without_parasitic())?, no_capacitance)?;
    add("sticking", "without_sticking", boxed(scenes::without_sticking())?, same)?;
    add(
        "velocity-dependent restitution",
        "without_law_of_speed",
        boxed(scenes::without_law_of_speed())?,
        one_coefficient,
    )?;
    add("error control", "without_error_control", boxed(scenes::without_error_control())?, same)?;
    add("all of these", "without_any", boxed(scenes::without_any())?, both)?;
    let header = [
        "left out",
        "flash",
        "difference",
        "steps",
        "instructions per step",
        "per simulated second",
        "error",
    ];
    println!("{}", table(header, rows, 1));
    println!("{core}. The bench's run, 3 s with impacts; without error control a fixed step of");
    println!(
        "{} ms. Error: of the mean power against the reference of the same variant.",
        scenes::FIXED_STEP * 1e3
    );
    println!("The law of restitution works at impacts only, so a step without it costs the same.");
    println!(
        "Instructions as QEMU executes them, which are not cycles. Flash in bytes, over an empty firmware."
    );
    Ok(())
}

/// One row of the table.
struct Row {
    flash: u64,
    steps: u64,
    per_step: f64,
    per_second: f64,
    error: String,
}

fn measure(
    core: Core,
    limit: Duration,
    binary: &'static str,
    mut native: Box<dyn Workload>,
    change: Change,
) -> Result<Row, Error> {
    let reference = accuracy::reference_power(&accuracy::scene(&scenes::IMPACTING, 0.0, change)?)?;
    let measurement = on_target::measure(core, Binary::new(binary), limit)?;
    native::compare_all(core, &measurement.workloads, &mut [&mut *native])?;
    let Some(workload) = measurement.workloads.first() else {
        return Err(Error::Other { core, what: format!("{binary} has no workload") });
    };
    let whole = workload.whole();
    Ok(Row {
        flash: measurement.flash,
        steps: whole.steps,
        per_step: whole.instructions_per_step(),
        per_second: whole.instructions_per_second(),
        error: accuracy::error(accuracy::mean_power(workload, None), reference),
    })
}

fn boxed(workload: Option<impl Workload + 'static>) -> Result<Box<dyn Workload>, Error> {
    native::accepted(workload).map(|workload| Box::new(workload) as _)
}
