//! The firmware's workloads on the host, and the comparison of their bits with a core's.

use firmware_example::workload::bump_stop::{BEAM_MODES, ROD_MODES};
use firmware_example::workload::run::{ENERGY, Plan};
use firmware_example::workload::{Progress, Variant, Visit, Workload as Native};

use super::decode::Sample;
use super::qemu::Core;
use super::{Error, Workload};
use crate::reference::{self, ReferenceOptions};
use crate::scene_file::{self, Excitation, RunSpan, Scene, Tone};

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
pub(crate) fn each_workload<T>(
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
    let compared = each_workload(variant.workloads, |native| match measured.next() {
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

/// A shipped scene under the excitation and from the velocity of `plan`, measured from `settle_s` to the plan's end.
///
/// # Errors
///
/// If the shipped scene cannot be read.
pub fn scene(name: &str, plan: &Plan, settle_s: f64) -> Result<Scene, Error> {
    let mut scene = scene_file::read_shipped(name, &[]).map_err(|error| Error::Host(error.to_string()))?;
    scene.excitation = Excitation::Sine(Tone {
        amplitude_m_per_s2: f64::from(plan.amplitude),
        frequency_hz: f64::from(plan.frequency),
        phase_rad: 0.0,
    });
    scene.run = RunSpan { duration_s: plan.seconds(), settle_s };
    if let Some([_, velocity_m_per_s, _]) = scene.model.start_mut() {
        *velocity_m_per_s = Some(f64::from(plan.velocity));
    }
    Ok(scene)
}

/// The shipped bump-stop scene, as in [`scene`], with the firmware's numbers of modes and a gap in m between beam and rod.
///
/// # Errors
///
/// If the shipped scene cannot be read.
pub fn bump_stop(plan: &Plan, gap: f32, settle_s: f64) -> Result<Scene, Error> {
    let mut scene = scene("bump-stop", plan, settle_s)?;
    if let Ok(model) = scene.bump_stop_mut() {
        model.parameters.beam_modes = BEAM_MODES;
        if let Some(stop) = &mut model.stop {
            (stop.rod_modes, stop.gap_m) = (ROD_MODES, f64::from(gap));
        }
    }
    Ok(scene)
}

/// The mean power of the reference of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Reference {
    /// Mean power from the settling time on, in W.
    pub(crate) power: f64,
    /// The settling time in microseconds.
    pub(crate) settle_us: u64,
}

impl Reference {
    /// Runs the reference of `scene`.
    ///
    /// # Errors
    ///
    /// If the run fails.
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let outcome = reference::run(scene, &ReferenceOptions::default())
            .map_err(|failure| Error::Host(failure.to_string()))?;
        let power = outcome.mean_power_w;
        let power = power.ok_or_else(|| Error::Host("the reference has no mean power".to_owned()))?;
        Ok(Self { power, settle_us: (scene.run.settle_s * 1e6).round() as u64 })
    }

    /// Relative error of the mean power of a workload with these samples; `None` where no power is delivered.
    pub fn power_error(&self, samples: &[Sample]) -> Option<f64> {
        self.error_of(mean_power(samples, self.settle_us))
    }

    /// Relative error of a mean power in W; `None` where no power is delivered.
    pub fn error_of(&self, power: f64) -> Option<f64> {
        self.ratio(power).map(|ratio| (ratio - 1.0).abs())
    }

    /// Relative error of the RMS voltage, whose square is the mean power times the load's resistance.
    pub fn voltage_error(&self, samples: &[Sample]) -> Option<f64> {
        self.ratio(mean_power(samples, self.settle_us)).map(|ratio| (ratio.sqrt() - 1.0).abs())
    }

    fn ratio(&self, power: f64) -> Option<f64> {
        (self.power != 0.0 || power != 0.0).then(|| power / self.power)
    }
}

/// Mean power in W from the sample at `from_us`, or from the start at 0, to the last sample.
fn mean_power(samples: &[Sample], from_us: u64) -> f64 {
    let energy =
        |sample: &Sample| sample.bits.get(ENERGY).map_or(f64::NAN, |&bits| f64::from(f32::from_bits(bits)));
    let start = samples.iter().find(|sample| sample.simulated_us == from_us).map_or(0.0, energy);
    let end = samples.last().map_or((f64::NAN, 0), |sample| (energy(sample), sample.simulated_us));
    (end.0 - start) / (end.1.saturating_sub(from_us) as f64 * 1e-6)
}
