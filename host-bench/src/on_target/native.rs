//! The firmware's workloads run on the host, and their bits beside the core's.

use firmware_example::workload::{Progress, Workload as Native};

use super::core::Core;
use super::{Error, Workload};

/// Runs a workload to its end, and gives the states in which it was sampled.
///
/// # Errors
///
/// When it fails.
pub fn run(workload: &mut dyn Native) -> Result<Vec<Vec<u32>>, Error> {
    let mut samples = Vec::new();
    loop {
        match workload.advance() {
            Progress::Sample { .. } => samples.push(workload.state().to_vec()),
            Progress::Finished => return Ok(samples),
            Progress::Failed => return Err(Error::Host(format!("{} cannot go on", workload.name()))),
        }
    }
}

/// Runs `native` on the host and compares every bit that `measured` has logged.
///
/// # Errors
///
/// At the first difference.
pub fn compare(core: Core, measured: &Workload, native: &mut dyn Native) -> Result<(), Error> {
    let expected = run(native)?;
    if expected.len() != measured.samples.len() || measured.name != native.name() {
        let what = format!(
            "{} of {} samples, on the host {} of {}",
            measured.name,
            measured.samples.len(),
            native.name(),
            expected.len()
        );
        return Err(Error::Other { core, what });
    }
    for (sample, (found, expected)) in measured.samples.iter().zip(&expected).enumerate() {
        let numbers = found.bits.len().max(expected.len());
        for number in 0..numbers {
            let bits = |words: &[u32]| words.get(number).copied();
            let (found, expected) = (bits(&found.bits), bits(expected));
            if found != expected {
                let workload = measured.name.clone();
                let (found, expected) = (found.unwrap_or_default(), expected.unwrap_or_default());
                return Err(Error::Bits { core, workload, sample, number, found, expected });
            }
        }
    }
    Ok(())
}

/// Compares each of several workloads, in their order.
///
/// # Errors
///
/// At the first difference.
pub fn compare_all(core: Core, measured: &[Workload], native: &mut [&mut dyn Native]) -> Result<(), Error> {
    if measured.len() != native.len() {
        let what = format!("{} workloads, on the host {}", measured.len(), native.len());
        return Err(Error::Other { core, what });
    }
    measured.iter().zip(native).try_for_each(|(measured, native)| compare(core, measured, *native))
}

/// The workload, unless the host refuses it, which would be a fault of the workload.
///
/// # Errors
///
/// When it is refused.
pub fn accepted<W>(workload: Option<W>) -> Result<W, Error> {
    workload.ok_or_else(|| Error::Host("the workload's parameters are refused".to_owned()))
}
