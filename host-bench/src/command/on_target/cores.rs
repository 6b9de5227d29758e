//! The bench on each core.

use std::time::Duration;

use firmware_example::workload::Workload as Native;
use firmware_example::workload::bump_stop::{parts::GAP, scenes as bump_stop};
use firmware_example::workload::contact_separation::scenes as contact_separation;
use firmware_example::workload::sliding::scenes as sliding;

use super::{announce, table};
use crate::on_target::accuracy::{self, Yardstick};
use crate::on_target::build::Binary;
use crate::on_target::core::Core;
use crate::on_target::{self, Error, Workload, native};

/// Measures the benches on `cores` and prints their tables.
///
/// # Errors
///
/// At the first core whose firmware cannot be built, run, or trusted.
pub(super) fn report(cores: &[Core], limit: Duration) -> Result<(), Error> {
    let yardsticks = Yardsticks::new()?;
    let (mut benches, mut others, mut touching) = (Vec::new(), Vec::new(), Vec::new());
    let mut samples = 0;
    for &core in cores {
        announce(core);
        let contact = native::accepted(contact_separation::bench())?;
        let slide = native::accepted(sliding::bench())?;
        let bump = native::accepted(bump_stop::bench())?;
        let scenes: [(&str, Box<dyn Native>, &Yardstick); 3] = [
            ("bench", Box::new(contact), &yardsticks.contact_separation),
            ("sliding", Box::new(slide), &yardsticks.sliding),
            ("bump_stop", Box::new(bump), &yardsticks.bump_stop),
        ];
        for (binary, mut expected, yardstick) in scenes {
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
                    yardstick.error(workload),
                    measurement.flash.to_string(),
                    measurement.size.static_ram.to_string(),
                    workload.stack.to_string(),
                ]);
            }
        }
        let workloads = measure_others(core, limit)?;
        samples += workloads.iter().map(|workload| workload.samples.len()).sum::<usize>();
        others.push(other_row(core, &workloads, &yardsticks)?);
        let workloads = measure_other_gap(core, limit)?;
        samples += workloads.iter().map(|workload| workload.samples.len()).sum::<usize>();
        touching.push(other_gap_row(core, &workloads, &yardsticks)?);
    }
    print_tables(benches, others, touching);
    print_legend(samples);
    Ok(())
}

/// Prints the tables: the bench on each core, what it leaves out, and bump-stop without a gap.
fn print_tables(benches: Vec<[String; 9]>, others: Vec<[String; 8]>, touching: Vec<[String; 4]>) {
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
    println!();
    println!("{}", table(["core", "bump-stop without a gap", "error", "build"], touching, 1));
}

/// Prints what the tables hold.
fn print_legend(samples: usize) {
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
    println!("3 s from rest; stick-slip at 6 Hz, 0.30 g. The second and third tables have instructions per");
    println!(
        "simulated second, and for one build of the coefficients from the parameters, the beam's eigenvalue included."
    );
    println!(
        "Bump-stop: four modes of the beam and one of the rod, steps of {} and {} us, 220 Hz, 20 m/s2, 2 s from",
        bump_stop::SHORT * 1e6,
        bump_stop::LONG * 1e6
    );
    println!("rest; with a gap of 10 um and, in the third table, without one.");
    println!("Error: of this run's mean power over the same time, against the independent reference; in");
    println!(
        "bump-stop of the RMS voltage from {SETTLED_S} s on, against the reference with the same modes."
    );
    println!("Instructions as QEMU executes them, which are not");
    println!("cycles. Flash: what is added to an empty firmware with the same runtime and logging. Stack:");
    println!("from the top of RAM. Sizes in bytes.");
}

/// Where the bump-stop runs count as settled, in seconds: at their first sample.
const SETTLED_S: f64 = 0.5;

/// What the runs are judged by.
struct Yardsticks {
    contact_separation: Yardstick,
    sliding: Yardstick,
    stick_slip: Yardstick,
    bump_stop: Yardstick,
    touching: Yardstick,
}

impl Yardsticks {
    fn new() -> Result<Self, Error> {
        let contact_separation = accuracy::contact_separation(&contact_separation::IMPACTING, 0.0, |_| {})?;
        let slide = |plan| Yardstick::mean_power(&accuracy::sliding(plan, 0.0, |_, _| {})?);
        let bump = |plan, gap| Yardstick::rms_voltage(&accuracy::bump_stop(plan, gap, SETTLED_S, |_, _| {})?);
        Ok(Self {
            contact_separation: Yardstick::mean_power(&contact_separation)?,
            sliding: slide(&sliding::SLIDING)?,
            stick_slip: slide(&sliding::STICK_SLIP)?,
            bump_stop: bump(&bump_stop::IMPACTING, GAP)?,
            touching: bump(&bump_stop::TOUCHING, 0.0)?,
        })
    }
}

/// What the sliding bench leaves out, on one core, with the bits compared.
fn measure_others(core: Core, limit: Duration) -> Result<Vec<Workload>, Error> {
    let measurement = on_target::measure(core, Binary::new("sliding_others"), limit)?;
    sliding::with_others(|native| {
        native::compare_all(core, &measurement.workloads, native::accepted(native)?)
    })?;
    Ok(measurement.workloads)
}

fn other_row(core: Core, workloads: &[Workload], yardsticks: &Yardsticks) -> Result<[String; 8], Error> {
    let [explicit, sliding, stick_slip, build] = workloads else {
        let what = format!("{} workloads beside the sliding bench, not 4", workloads.len());
        return Err(Error::Other { core, what });
    };
    Ok([
        core.to_string(),
        per_second(explicit),
        yardsticks.stick_slip.error(explicit),
        per_second(sliding),
        yardsticks.sliding.error(sliding),
        per_second(stick_slip),
        yardsticks.stick_slip.error(stick_slip),
        per_step(build),
    ])
}

/// What the bump-stop bench leaves out, on one core, with the bits compared.
fn measure_other_gap(core: Core, limit: Duration) -> Result<Vec<Workload>, Error> {
    let measurement = on_target::measure(core, Binary::new("bump_stop_others"), limit)?;
    bump_stop::with_others(|native| {
        native::compare_all(core, &measurement.workloads, native::accepted(native)?)
    })?;
    Ok(measurement.workloads)
}

fn other_gap_row(core: Core, workloads: &[Workload], yardsticks: &Yardsticks) -> Result<[String; 4], Error> {
    let [touching, build] = workloads else {
        let what = format!("{} workloads beside the bump-stop bench, not 2", workloads.len());
        return Err(Error::Other { core, what });
    };
    Ok([core.to_string(), per_second(touching), yardsticks.touching.error(touching), per_step(build)])
}

fn per_second(workload: &Workload) -> String {
    format!("{:.0}", workload.whole().instructions_per_second())
}

fn per_step(workload: &Workload) -> String {
    format!("{:.0}", workload.whole().instructions_per_step())
}
