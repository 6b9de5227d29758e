//! The firmware's workloads on the host, and the comparison of their bits with a core's.

use firmware_example::variant::Variant;
use firmware_example::workload::{Progress, Visit, Workload as Native};

use super::core::Core;
use super::decode::Sample;
use super::{Error, Workload};

/// Runs a workload to its end and gives its samples. A host's run has no ticks.
///
/// # Errors
///
/// If the model cannot be stepped.
pub fn run(workload: &mut dyn Native) -> Result<Vec<Sample>, Error> {
    let mut samples: Vec<Sample> = Vec::new();
    loop {
        match workload.advance() {
            Progress::Sample { steps, simulated_us } => {
                let (time, count) = samples.last().map_or((0, 0), |last| (last.simulated_us, last.steps));
                samples.push(Sample {
                    simulated_us: time + u64::from(simulated_us),
                    steps: count + u64::from(steps),
                    ticks: 0,
                    bits: workload.state().to_vec(),
                });
            }
            Progress::Finished => return Ok(samples),
            Progress::Failed => return Err(Error::Host(format!("{} cannot go on", workload.name()))),
        }
    }
}

/// Runs each of `workloads` and gives the results of `run`, in order.
///
/// # Errors
///
/// The first error of `run`, or if the parameters of a workload are refused.
pub fn each<T>(
    workloads: impl FnOnce(Visit<'_>) -> Option<()>,
    mut run: impl FnMut(&mut dyn Native) -> Result<T, Error>,
) -> Result<Vec<T>, Error> {
    let mut results = Vec::new();
    workloads(&mut |workload| {
        if !results.last().is_some_and(Result::is_err) {
            results.push(run(workload));
        }
    })
    .ok_or_else(|| Error::Host("the parameters of a workload are refused".to_owned()))?;
    results.into_iter().collect()
}

/// Runs `variant` on the host and compares every bit that `measured` has logged. Gives the number of workloads of
/// `variant`; `measured` may have more.
///
/// # Errors
///
/// At the first difference.
pub fn compare(core: Core, measured: &[Workload], variant: &Variant) -> Result<usize, Error> {
    let mut measured = measured.iter();
    let compared = each(variant.workloads, |native| match measured.next() {
        Some(measured) => compare_one(core, measured, native),
        None => Err(Error::on(core, format!("no workload {}", native.name()))),
    });
    Ok(compared?.len())
}

fn compare_one(core: Core, measured: &Workload, native: &mut dyn Native) -> Result<(), Error> {
    let expected = run(native)?;
    if expected.len() != measured.samples.len() || measured.name != native.name() {
        let what = format!(
            "{} of {} samples, on the host {} of {}",
            measured.name,
            measured.samples.len(),
            native.name(),
            expected.len()
        );
        return Err(Error::on(core, what));
    }
    for (number, (found, expected)) in measured.samples.iter().zip(&expected).enumerate() {
        if found.bits != expected.bits {
            let Sample { bits, .. } = found;
            let name = &measured.name;
            let what = format!(
                "{name}: sample {number}: the bits are {bits:08x?}, on the host {:08x?}",
                expected.bits
            );
            return Err(Error::on(core, what));
        }
    }
    Ok(())
}
