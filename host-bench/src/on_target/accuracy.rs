//! How far a workload's mean power is from the independent reference.

use std::path::Path;

use firmware_example::workload::contact_separation::{ENERGY, Plan};

use super::{Error, Workload};
use crate::reference::{self, ReferenceOptions};
use crate::scene_file::{self, ContactSeparationParameters, Excitation, RunSpan, Scene, Tone};

/// The shipped scene shaken as `plan` says, measured from `settle_s` to the plan's end, with other
/// parameters where `change` says so.
///
/// # Errors
///
/// When the shipped scene cannot be read.
pub fn scene(
    plan: &Plan,
    settle_s: f64,
    change: impl FnOnce(&mut ContactSeparationParameters),
) -> Result<Scene, Error> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/contact-separation.toml");
    let mut scene = scene_file::read(&file, &[]).map_err(|error| Error::Host(error.to_string()))?;
    let model = scene.contact_separation_mut().map_err(|error| Error::Host(error.to_string()))?;
    change(&mut model.parameters);
    scene.excitation = Excitation::Sine(Tone {
        amplitude_m_per_s2: f64::from(plan.amplitude),
        frequency_hz: f64::from(plan.frequency),
        phase_rad: 0.0,
    });
    scene.run = RunSpan { duration_s: f64::from(plan.quarters * plan.samples) * 0.25, settle_s };
    Ok(scene)
}

/// Mean power of `scene` by the reference, in watts.
///
/// # Errors
///
/// When the reference cannot finish.
pub fn reference_power(scene: &Scene) -> Result<f64, Error> {
    let outcome = reference::run(scene, &ReferenceOptions::default())
        .map_err(|failure| Error::Host(failure.to_string()))?;
    outcome.mean_power_w.ok_or_else(|| Error::Host("the reference has no mean power".to_owned()))
}

/// Mean power of a workload from sample `after` (or the start) to its last sample, in watts.
#[must_use]
pub fn mean_power(workload: &Workload, after: Option<usize>) -> f64 {
    let energy = |index: usize| {
        let bits = workload.samples.get(index).and_then(|sample| sample.bits.get(ENERGY));
        bits.map_or(f64::NAN, |&bits| f64::from(f32::from_bits(bits)))
    };
    let last = energy(workload.samples.len().wrapping_sub(1));
    match after {
        Some(first) => (last - energy(first)) / workload.after(first).seconds,
        None => last / workload.whole().seconds,
    }
}

/// Relative error of a power, as a table shows it.
#[must_use]
pub fn error(power: f64, reference: f64) -> String {
    format!("{:.3} %", (power / reference - 1.0).abs() * 100.0)
}
