//! The bench on each core.

use std::time::Duration;

use firmware_example::workload::Workload as Native;
use firmware_example::workload::contact_separation::scenes as contact_separation;
use firmware_example::workload::sliding::scenes as sliding;

use super::{announce, table};
use crate::on_target::build::Binary;
use crate::on_target::core::Core;
use crate::on_target::{self, Error, Workload, accuracy, native};

/// Measures the benches on `cores` and prints their tables.
///
/// # Errors
///
/// At the first core whose firmware cannot be built, run, or trusted.
pub(super) fn report(cores: &[Core], limit: Duration) -> Result<(), Error> {
    let powers = Powers {
        contact_separation: accuracy::reference_power(&accuracy::contact_separation(
            &contact_separation::IMPACTING,
            0.0,
            |_| {},
        )?)?,
        sliding: accuracy::reference_power(&accuracy::sliding(&sliding::SLIDING, 0.0, |_, _| {})?)?,
        stick_slip: accuracy::reference_power(&accuracy::sliding(&sliding::STICK_SLIP, 0.0, |_, _| {})?)?,
    };
    let (mut benches, mut others) = (Vec::new(), Vec::new());
    let mut samples = 0;
    for &core in cores {
        announce(core);
        let contact = native::accepted(contact_separation::bench())?;
        let slide = native::accepted(sliding::bench())?;
        let both: [(&str, Box<dyn Native>, f64); 2] = [
            ("bench", Box::new(contact), powers.contact_separation),
            ("sliding", Box::new(slide), powers.sliding),
        ];
        for (binary, mut expected, power) in both {
            let measurement = on_target::measure(core, Binary::new(binary), limit)?;
            native::compare_all(core, &measurement.workloads, &mut [&mut *expected])?;
            for workload in &measurement.workloads {
                let whole = workload.whole();
                samples += workload.samples.len();
                benches.push([
                    core.to_string(),
                    core.hardware().board.to_owned(),
                    workload.name.clone(),
                    format!("{:.0}", whole.instructions_per_step()),
                    format!("{:.0}", whole.instructions_per_second()),
                    accuracy::error(accuracy::mean_power(workload, None), power),
                    measurement.flash.to_string(),
                    measurement.size.static_ram.to_string(),
                    workload.stack.to_string(),
                ]);
            }
        }
        let workloads = measure_others(core, limit)?;
        samples += workloads.iter().map(|workload| workload.samples.len()).sum::<usize>();
        others.push(other_row(core, &workloads, &powers)?);
    }
    let header = [
        "core",
        "board in QEMU",
        "scene",
        "instructions per step",
        "per simulated second",
        "error",
        "flash",
        "static RAM",
        "stack",
    ];
    println!("{}", table(header, benches, 3));
    println!();
    let header = [
        "core",
        "stick-slip by Runge-Kutta 4",
        "error",
        "sliding by TR-BDF2",
        "error",
        "stick-slip by TR-BDF2",
        "error",
        "build",
    ];
    println!("{}", table(header, others, 1));
    println!("{samples} sampled states, each bit-identical to the host's f32 run.");
    println!(
        "Contact-separation: TR-BDF2 with tolerance {}, 20 Hz, 0.2 g, 3 s from rest, with impacts.",
        contact_separation::TOLERANCE
    );
    println!(
        "Sliding: Runge-Kutta 4 with a step of {} ms, TR-BDF2 with tolerance {}; 18.373 Hz, 0.36 g,",
        sliding::STEP * 1e3,
        sliding::TOLERANCE
    );
    println!(
        "3 s from rest; stick-slip at 6 Hz, 0.30 g. The second table has instructions per simulated second,"
    );
    println!("and for one build of the coefficients from the parameters, the beam's eigenvalue included.");
    println!("Error: of this run's mean power over the same time, against the independent reference.");
    println!("Instructions as QEMU executes them, which are not");
    println!("cycles. Flash: what is added to an empty firmware with the same runtime and logging. Stack:");
    println!("from the top of RAM. Sizes in bytes.");
    Ok(())
}

/// What the runs should have delivered on average, in watts.
struct Powers {
    contact_separation: f64,
    sliding: f64,
    stick_slip: f64,
}

/// What the sliding bench leaves out, on one core, with the bits compared.
fn measure_others(core: Core, limit: Duration) -> Result<Vec<Workload>, Error> {
    let measurement = on_target::measure(core, Binary::new("sliding_others"), limit)?;
    sliding::with_others(|native| {
        native::compare_all(core, &measurement.workloads, native::accepted(native)?)
    })?;
    Ok(measurement.workloads)
}

fn other_row(core: Core, workloads: &[Workload], powers: &Powers) -> Result<[String; 8], Error> {
    let [explicit, sliding, stick_slip, build] = workloads else {
        let what = format!("{} workloads beside the sliding bench, not 4", workloads.len());
        return Err(Error::Other { core, what });
    };
    let cost = |workload: &Workload| format!("{:.0}", workload.whole().instructions_per_second());
    let error = |workload, power| accuracy::error(accuracy::mean_power(workload, None), power);
    Ok([
        core.to_string(),
        cost(explicit),
        error(explicit, powers.stick_slip),
        cost(sliding),
        error(sliding, powers.sliding),
        cost(stick_slip),
        error(stick_slip, powers.stick_slip),
        format!("{:.0}", build.whole().instructions_per_step()),
    ])
}
