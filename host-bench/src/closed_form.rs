//! The closed forms of the core on the host: what they say of a scene, and how far they are from it.

pub mod map;

use model_core::part::bounds::ParameterError;
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::{AnyChoices, BumpStop as Beam};
use model_core::scene::closed_form::{ClosedForm, Reason, Validity};
use serde_json::Value;

use crate::embedded::{bump_stop_parameters, contact_separation_parameters, sliding_parameters};
use crate::method::{Failure, Precision};
use crate::scene_file::{BumpStop, Draw, Excitation, Load, Model, RectifiedStore, Scene};

/// What the closed form of a scene says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Mean power in the load in W.
    pub mean_power_w: f64,
    /// Root mean square of the terminal voltage in V.
    pub rms_voltage_v: f64,
    /// Amplitude of the motion in m.
    pub amplitude_m: f64,
    /// Why a trajectory is needed; `None` where the closed form holds.
    pub reason: Option<&'static str>,
    /// The requirement that is nearest to being missed, or missed by most, as a part of its limit.
    pub margin: f64,
}

impl Estimate {
    /// Whether the closed form holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.reason.is_none()
    }

    /// Names and values, as the command line prints them.
    #[must_use]
    pub fn fields(&self) -> Vec<(String, Value)> {
        let fields: [(&str, Value); 6] = [
            ("mean_power_w", self.mean_power_w.into()),
            ("rms_voltage_v", self.rms_voltage_v.into()),
            ("amplitude_m", self.amplitude_m.into()),
            ("holds", self.holds().into()),
            ("reason", self.reason.into()),
            ("margin", self.margin.into()),
        ];
        fields.map(|(name, value)| (name.to_owned(), value)).to_vec()
    }
}

/// The closed form of a scene under one sine, in a precision.
///
/// # Errors
/// [`Failure::Input`] if the scene is not under one sine, or the core refuses it.
pub fn estimate(scene: &Scene, precision: Precision) -> Result<Estimate, Failure> {
    match precision {
        Precision::F32 => estimate_as::<f32>(scene),
        Precision::F64 => estimate_as::<f64>(scene),
    }
}

fn estimate_as<S: Scalar>(scene: &Scene) -> Result<Estimate, Failure> {
    let Excitation::Sine(tone) = &scene.excitation else { return Err(no_sine(scene)) };
    if !(tone.frequency_hz > 0.0) {
        return Err(no_sine(scene));
    }
    let (amplitude, hertz) = (S::from_f64(tone.amplitude_m_per_s2), S::from_f64(tone.frequency_hz));
    if !matches!(scene.model, Model::BumpStop(_)) && !matches!(scene.load, Load::Resistor { .. }) {
        return Err(Failure::Input(format!(
            "{}: load.kind: must be \"resistor\" for a closed form of this scene",
            scene.file.display()
        )));
    }
    let refused =
        |error: ParameterError<S>| Failure::Input(format!("{}: parameters.{error}", scene.file.display()));
    let found = match &scene.model {
        Model::ContactSeparation(model) => contact_separation_parameters::<S, S::Build>(model, scene.load)
            .build()
            .map_err(refused)?
            .closed_form(amplitude, hertz),
        Model::Sliding(model) => {
            sliding_parameters::<S>(model, scene.load).build().map_err(refused)?.closed_form(amplitude, hertz)
        }
        Model::BumpStop(model) => {
            let terminals = Terminals::of(scene)?;
            of_bump_stop(scene, model, terminals, amplitude, hertz).map_err(refused)?
        }
    };
    Ok(Estimate::new(&found))
}

/// What is at the terminals of a beam, as its closed forms have it.
#[derive(Debug, Clone, Copy)]
enum Terminals {
    /// The load of the scene itself.
    Resistor,
    /// A bus of so many volts behind diodes of so many.
    Bus(f64, f64),
    /// A store behind diodes of so many volts, with so many ohms across it.
    Store(f64, f64),
}

impl Terminals {
    fn of(scene: &Scene) -> Result<Self, Failure> {
        match scene.load {
            Load::Resistor { .. } => Ok(Self::Resistor),
            Load::DcBus { voltage_v, diode_drop_v } => Ok(Self::Bus(voltage_v, diode_drop_v)),
            Load::RectifiedStore(RectifiedStore {
                diode_drop_v,
                leakage_ohm,
                draw: Draw::Resistor { resistance_ohm, lockout: None },
                ..
            }) => Ok(Self::Store(diode_drop_v, 1.0 / (1.0 / resistance_ohm + 1.0 / leakage_ohm))),
            Load::RectifiedStore(_) => Err(Failure::Input(format!(
                "{}: load.draw: must be a resistor that is always connected for a closed form",
                scene.file.display()
            ))),
        }
    }

    fn ask<S: Scalar, const B: usize, const R: usize>(
        self,
        beam: &Beam<S, AnyChoices<S>, B, R>,
        amplitude: S,
        hertz: S,
    ) -> ClosedForm<S> {
        let number = S::from_f64;
        match self {
            Self::Resistor => beam.closed_form(amplitude, hertz),
            Self::Bus(volts, drop) => {
                beam.closed_form_into_bus(amplitude, hertz, number(volts), number(drop))
            }
            Self::Store(drop, ohms) => {
                beam.closed_form_into_store(amplitude, hertz, number(ohms), number(drop))
            }
        }
    }
}

/// With the capacities that a run has.
fn of_bump_stop<S: Scalar>(
    scene: &Scene,
    model: &BumpStop,
    terminals: Terminals,
    amplitude: S,
    hertz: S,
) -> Result<ClosedForm<S>, ParameterError<S>> {
    let parameters = bump_stop_parameters::<S>(model, scene.load);
    let (beam, rod) = (model.parameters.beam_modes, model.stop.as_ref().map_or(0, |stop| stop.rod_modes));
    Ok(match (beam, rod) {
        (..=4, ..=2) => terminals.ask(&parameters.build::<4, 2>()?, amplitude, hertz),
        (..=10, ..=10) => terminals.ask(&parameters.build::<10, 10>()?, amplitude, hertz),
        _ => terminals.ask(&parameters.build::<20, 20>()?, amplitude, hertz),
    })
}

fn no_sine(scene: &Scene) -> Failure {
    Failure::Input(format!(
        "{}: excitation.kind: must be \"sine\" with a frequency_hz above 0 for a closed form",
        scene.file.display()
    ))
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
            reason,
            margin: margin.to_f64(),
        }
    }
}

/// A reason, as the command line writes it.
fn name(reason: Reason) -> &'static str {
    match reason {
        Reason::Impacts => "impacts",
        Reason::ImpactsInTransient => "impacts-in-transient",
        Reason::LeavesOverlap => "leaves-overlap",
        Reason::Sticks => "sticks",
        Reason::ReachesStop => "reaches-stop",
        Reason::HigherHarmonics => "higher-harmonics",
        Reason::StrongCoupling => "strong-coupling",
        Reason::Overdamped => "overdamped",
        Reason::NotBalanced => "not-balanced",
    }
}
