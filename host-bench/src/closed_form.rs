//! Mean power, RMS voltage and amplitude of a beam that does not reach its stop, by the core's closed forms.

use model_core::bounds::ParameterError;
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::{ClosedForm, Reason, Validity};

use crate::embedded::bump_stop_parameters;
use crate::method::{Failure, Precision};
use crate::scene_file::{BumpStop, Draw, Excitation, Load, Model, RectifiedStore, Scene};

/// The closed form of a scene.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// Mean power in the load in W.
    pub mean_power_w: f64,
    /// Root mean square of the terminal voltage in V.
    pub rms_voltage_v: f64,
    /// Amplitude of the tip in m.
    pub amplitude_m: f64,
    /// Mean current in A into the storage or bus behind a bridge, its charge per second; `None` without one, and at 0 V.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_store_current_a: Option<f64>,
    /// Whether the closed form holds.
    pub holds: bool,
    /// Why a trajectory is needed; `None` where the closed form holds.
    pub reason: Option<&'static str>,
    /// The requirement with the least margin, as a part of its limit; above 1 the requirement is not met.
    pub margin: f64,
}

/// The closed form of a scene under one sine, in a precision.
pub fn estimate(scene: &Scene, precision: Precision) -> Result<Estimate, Failure> {
    match precision {
        Precision::F32 => estimate_as::<f32>(scene),
        Precision::F64 => estimate_as::<f64>(scene),
    }
}

fn estimate_as<S: Scalar>(scene: &Scene) -> Result<Estimate, Failure> {
    let Model::BumpStop(model) = &scene.model else {
        return Err(Failure::of_file(
            scene,
            "scene: must be \"bump-stop\" for a closed form; run --steady-state and map have the other scenes",
        ));
    };
    let tone = match &scene.excitation {
        Excitation::Sine(tone) if tone.frequency_hz > 0.0 => tone,
        _ => {
            let text = "excitation.kind: must be \"sine\" with a frequency_hz above 0 for a closed form";
            return Err(Failure::of_file(scene, text));
        }
    };
    let (amplitude, frequency) = (S::from_f64(tone.amplitude_m_per_s2), S::from_f64(tone.frequency_hz));
    // The mode capacities of a run.
    let found = match model.modes() {
        [..=4, ..=2] => of_beam::<S, 4, 2>(scene, model, amplitude, frequency)?,
        [..=10, ..=10] => of_beam::<S, 10, 10>(scene, model, amplitude, frequency)?,
        _ => of_beam::<S, 20, 20>(scene, model, amplitude, frequency)?,
    };
    let mut estimate = Estimate::new(&found);
    if let Load::DcBus { voltage_v, .. } = scene.load
        && voltage_v > 0.0
    {
        estimate.mean_store_current_a = Some(estimate.mean_power_w / voltage_v);
    }
    Ok(estimate)
}

/// Undamped frequencies in Hz of the first mode with short and open terminals; `None` for a triboelectric scene.
pub(crate) fn undamped_frequencies(scene: &Scene) -> Result<Option<[f64; 2]>, Failure> {
    let Model::BumpStop(model) = &scene.model else { return Ok(None) };
    let modes = model.parameters.beam_modes;
    let beam = bump_stop_parameters::<f64>(model, scene.load)
        .build_first::<20, 20>(modes, 0)
        .map_err(|error| refused(scene, error))?;
    let found = beam.beam_angular_frequency(0).zip(beam.open_circuit_angular_frequency(0));
    Ok(found.map(|(short, open)| [short, open].map(|omega| omega / std::f64::consts::TAU)))
}

/// The closed form of a beam with the load of a scene.
fn of_beam<S: Scalar, const B: usize, const R: usize>(
    scene: &Scene,
    model: &BumpStop,
    amplitude: S,
    frequency: S,
) -> Result<ClosedForm<S>, Failure> {
    let [beam_modes, rod_modes] = model.modes();
    let beam = bump_stop_parameters::<S>(model, scene.load)
        .build_first::<B, R>(beam_modes, rod_modes)
        .map_err(|error| refused(scene, error))?;
    let number = S::from_f64;
    match scene.load {
        Load::Resistor { .. } => Ok(beam.closed_form(amplitude, frequency)),
        Load::DcBus { voltage_v, diode_drop_v } => {
            Ok(beam.closed_form_into_bus(amplitude, frequency, number(voltage_v), number(diode_drop_v)))
        }
        Load::RectifiedStore(RectifiedStore {
            diode_drop_v,
            leakage_ohm,
            draw: Draw::Resistor { resistance_ohm, lockout: None },
            ..
        }) => {
            let across = number(1.0 / (1.0 / resistance_ohm + 1.0 / leakage_ohm));
            Ok(beam.closed_form_into_store(amplitude, frequency, across, number(diode_drop_v)))
        }
        Load::RectifiedStore(_) => Err(Failure::of_file(
            scene,
            "load.draw: must be a resistor that is always connected for a closed form; --storage-voltage holds the \
             voltage of a storage",
        )),
    }
}

fn refused<S: Scalar>(scene: &Scene, error: ParameterError<S>) -> Failure {
    Failure::of_file(scene, format!("parameters.{error}"))
}

impl Estimate {
    fn new<S: Scalar>(found: &ClosedForm<S>) -> Self {
        let (reason, margin) = match found.validity {
            Validity::Holds { margin } => (None, margin),
            Validity::NeedsTrajectory { reason, margin } => (Some(name(reason)), margin),
        };
        Self {
            mean_power_w: found.mean_power.to_f64(),
            rms_voltage_v: found.rms_voltage.to_f64(),
            amplitude_m: found.amplitude.to_f64(),
            mean_store_current_a: None,
            holds: reason.is_none(),
            reason,
            margin: margin.to_f64(),
        }
    }
}

/// A reason, as the command line writes it.
fn name(reason: Reason) -> &'static str {
    match reason {
        Reason::ImpactsInTransient => "impacts-in-transient",
        Reason::ReachesStop => "reaches-stop",
        Reason::StrongCoupling => "strong-coupling",
        Reason::NotBalanced => "not-balanced",
        _ => "other",
    }
}
