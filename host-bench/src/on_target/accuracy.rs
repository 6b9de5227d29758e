//! How far a workload's mean power or voltage is from what it should be.

use std::path::Path;

use firmware_example::workload::bump_stop::modal_run;
use firmware_example::workload::bump_stop::scenes::{BEAM_MODES, ROD_MODES};
use firmware_example::workload::hybrid_run::{ENERGY, Plan};

use super::{Error, Workload};
use crate::reference::{self, ReferenceOptions};
use crate::scene_file::{
    self, BumpStop, ContactSeparationParameters, Excitation, Load, Model, RunSpan, Scene, SlidingParameters,
    Tone,
};

/// The shipped contact-separation scene shaken as `plan` says, measured from `settle_s` to the plan's
/// end, with other parameters where `change` says so.
///
/// # Errors
///
/// When the shipped scene cannot be read.
pub fn contact_separation(
    plan: &Plan,
    settle_s: f64,
    change: impl FnOnce(&mut ContactSeparationParameters),
) -> Result<Scene, Error> {
    let mut scene = shaken("contact-separation.toml", plan, settle_s)?;
    if let Model::ContactSeparation(model) = &mut scene.model {
        model.initial.velocity_m_per_s = Some(f64::from(plan.velocity));
        change(&mut model.parameters);
    }
    Ok(scene)
}

/// The same of the shipped sliding scene, whose load may be another one too.
///
/// # Errors
///
/// When the shipped scene cannot be read.
pub fn sliding(
    plan: &Plan,
    settle_s: f64,
    change: impl FnOnce(&mut SlidingParameters, &mut Load),
) -> Result<Scene, Error> {
    let mut scene = shaken("sliding.toml", plan, settle_s)?;
    if let Model::Sliding(model) = &mut scene.model {
        model.initial.velocity_m_per_s = Some(f64::from(plan.velocity));
        change(&mut model.parameters, &mut scene.load);
    }
    Ok(scene)
}

/// The same of the shipped bump-stop scene, with the firmware's numbers of modes and `gap` metres between
/// beam and rod.
///
/// # Errors
///
/// When the shipped scene cannot be read.
pub fn bump_stop(
    plan: &modal_run::Plan,
    gap: f32,
    settle_s: f64,
    change: impl FnOnce(&mut BumpStop, &mut Load),
) -> Result<Scene, Error> {
    let run = RunSpan { duration_s: plan.seconds(), settle_s };
    let mut scene = shipped("bump-stop.toml", [plan.amplitude, plan.frequency], run)?;
    if let Model::BumpStop(model) = &mut scene.model {
        model.parameters.beam_modes = BEAM_MODES;
        if let Some(stop) = &mut model.stop {
            (stop.rod_modes, stop.gap_m) = (ROD_MODES, f64::from(gap));
        }
        change(model, &mut scene.load);
    }
    Ok(scene)
}

fn shaken(name: &str, plan: &Plan, settle_s: f64) -> Result<Scene, Error> {
    let run = RunSpan { duration_s: plan.seconds(), settle_s };
    shipped(name, [plan.amplitude, plan.frequency], run)
}

/// A shipped scene with the amplitude in m/s² and the frequency in hertz of a firmware's plan.
fn shipped(name: &str, [amplitude, frequency]: [f32; 2], run: RunSpan) -> Result<Scene, Error> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let mut scene = scene_file::read(&file, &[]).map_err(|error| Error::Host(error.to_string()))?;
    scene.excitation = Excitation::Sine(Tone {
        amplitude_m_per_s2: f64::from(amplitude),
        frequency_hz: f64::from(frequency),
        phase_rad: 0.0,
    });
    scene.run = run;
    Ok(scene)
}

/// A figure by which a workload is judged.
#[derive(Debug, Clone, Copy)]
pub struct Yardstick {
    of: fn(&Workload) -> f64,
    reference: f64,
}

impl Yardstick {
    /// The mean power of the whole run of `scene`.
    ///
    /// # Errors
    ///
    /// When the reference run cannot be finished.
    pub fn mean_power(scene: &Scene) -> Result<Self, Error> {
        Ok(Self { of: |workload| mean_power(workload, None), reference: reference_power(scene)? })
    }

    /// The RMS voltage of `scene` from the first sample of a workload on, per root of the load's resistance:
    /// the root of the mean power.
    ///
    /// # Errors
    ///
    /// When the reference run cannot be finished.
    pub fn rms_voltage(scene: &Scene) -> Result<Self, Error> {
        Ok(Self {
            of: |workload| mean_power(workload, Some(0)).sqrt(),
            reference: reference_power(scene)?.sqrt(),
        })
    }

    /// The relative error of `workload`, as a table shows it.
    #[must_use]
    pub fn error(&self, workload: &Workload) -> String {
        error((self.of)(workload), self.reference)
    }
}

/// Mean power of `scene` in watts, of the reference.
///
/// # Errors
///
/// When the run cannot be finished.
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

/// Mean power from the states that the host logs, from sample `after` to the last one, for a plan.
///
/// On a core they are the same: each bit is compared.
#[must_use]
pub fn native_power(states: &[Vec<u32>], after: usize, plan: &Plan) -> f64 {
    let energy = |state: Option<&Vec<u32>>| {
        let bits = state.and_then(|state| state.get(ENERGY));
        bits.map_or(f64::NAN, |&bits| f64::from(f32::from_bits(bits)))
    };
    let seconds = (states.len().saturating_sub(1 + after)) as f64 * f64::from(plan.quarters) * 0.25;
    (energy(states.last()) - energy(states.get(after))) / seconds
}

/// Relative error of a power, as a table shows it; nothing where no power is delivered.
#[must_use]
pub fn error(power: f64, reference: f64) -> String {
    if reference == 0.0 && power == 0.0 {
        return "-".to_owned();
    }
    format!("{:.3} %", (power / reference - 1.0).abs() * 100.0)
}
