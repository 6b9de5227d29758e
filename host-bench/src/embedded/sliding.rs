//! A sliding run on the embedded core.

use model_core::energy::Residual;
use model_core::hybrid::HybridState;
use model_core::part::VACUUM_PERMITTIVITY;
use model_core::part::load::AnyLoad;
use model_core::part::rectifier::FullBridge;
use model_core::part::storage::AnyStorage;
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::sliding::{
    AnyLateralForce, AnyParts, Mode, Parameters, PatchFriction, STATES, Sliding as Harvester, Start,
};

use super::contact_separation::{force_law, sticking};
use super::excitation::with_excitation;
use super::hybrid_run::{
    Found, HostedScene, Run, WHOLE, refuse_parameter, refuse_start, step_control, unit_of_charge,
};
use super::rectified;
use crate::method::{Failure, Options};
use crate::outcome::{self, Outcome, Particular, SLIDING_COLUMNS, SlidingOutcome};
use crate::scene_file::{Load, Scene, Sliding};

/// The core's parameters of a scene.
#[must_use]
pub fn parameters<S: Scalar>(model: &Sliding, load: Load) -> Parameters<S, AnyParts> {
    let from = &model.parameters;
    let number = S::from_f64;
    let resistance_ohm = load.resistance_ohm();
    Parameters {
        beam_length: number(from.beam_length_m),
        beam_width: number(from.beam_width_m),
        beam_thickness: number(from.beam_thickness_m),
        young_modulus: number(from.young_modulus_pa),
        density: number(from.density_kg_per_m3),
        damping_ratio: number(from.damping_ratio),
        slider_mass: number(from.slider_mass_kg),
        patch_radius: number(from.patch_radius_m),
        friction: PatchFriction {
            static_active: number(from.static_friction_active),
            static_inert: number(from.static_friction_inert),
            kinetic_active: number(from.kinetic_friction_active),
            kinetic_inert: number(from.kinetic_friction_inert),
        },
        dielectric_thickness: number(from.dielectric_thickness_m),
        relative_permittivity: number(from.relative_permittivity),
        charge_density: number(from.charge_density_c_per_m2),
        load: AnyLoad { ohms: number(resistance_ohm) },
        force_law: force_law(from.force_law),
        sticking: sticking(from.stick_charge),
        lateral_force: if from.lateral_force { AnyLateralForce::Field } else { AnyLateralForce::None },
    }
}

/// Calls `with` with all that a run of the scene needs, and the state it starts in.
pub(super) fn prepared<S: Scalar, M: Mathematics<S>, R>(
    scene: &Scene,
    model: &Sliding,
    options: &Options,
    with: impl FnOnce(
        &Run<'_, S, M, Hosted<'_, S>, STATES>,
        HybridState<S, Mode, STATES, WHOLE>,
    ) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let hosted = hosted::<S>(scene, model)?;
    let control = step_control(scene, options, explicit_step(&hosted.harvester, model, scene.load))?;
    with_excitation::<S, M, _>(scene, |excitation| {
        let state = hosted
            .harvester
            .start(&start(model), excitation, &control)
            .map_err(|error| refuse_start(scene, &error))?;
        with(&Run { scene, options, hosted: &hosted, excitation, control }, state)
    })
}

/// The outcome of the scene behind a bridge.
pub(super) fn rectified<S: Scalar, M: Mathematics<S>>(
    scene: &Scene,
    model: &Sliding,
    options: &Options,
    bridge: FullBridge<S, AnyStorage<S>>,
) -> Result<Outcome, Failure> {
    let hosted = hosted::<S>(scene, model)?;
    let motion_s = explicit_step(&hosted.harvester, model, scene.load);
    rectified::run::<S, M, _>(scene, options, hosted, &start(model), bridge, motion_s)
}

fn hosted<'a, S: Scalar>(scene: &Scene, model: &'a Sliding) -> Result<Hosted<'a, S>, Failure> {
    let harvester =
        parameters::<S>(model, scene.load).build().map_err(|error| refuse_parameter(scene, &error))?;
    Ok(Hosted { harvester, model })
}

/// The core's harvester of a scene.
pub(super) fn core<S: Scalar>(scene: &Scene, model: &Sliding) -> Result<Harvester<S, AnyParts>, Failure> {
    hosted(scene, model).map(|hosted| hosted.harvester)
}

/// The core's initial values of a scene.
pub(super) fn start<S: Scalar>(model: &Sliding) -> Start<S> {
    Start {
        displacement: model.initial.displacement_m.map(S::from_f64),
        velocity: model.initial.velocity_m_per_s.map(S::from_f64),
        charge: model.initial.charge_c.map(S::from_f64),
    }
}

/// A step at which the explicit method is stable and accurate: an 800th of the natural period, and
/// 2 over the circuit's rate, 1/(R C), at a fiftieth of the overlap.
fn explicit_step<S: Scalar>(harvester: &Harvester<S, AnyParts>, model: &Sliding, load: Load) -> f64 {
    let from = &model.parameters;
    let resistance_ohm = load.resistance_ohm();
    let period = std::f64::consts::TAU / harvester.angular_frequency().to_f64();
    let area = std::f64::consts::PI * from.patch_radius_m.powi(2);
    let permittivity = VACUUM_PERMITTIVITY * from.relative_permittivity;
    let capacitance = permittivity * 0.02 * area / from.dielectric_thickness_m;
    let circuit = if resistance_ohm == 0.0 { f64::INFINITY } else { 2.0 * resistance_ohm * capacitance };
    (period / 800.0).min(circuit)
}

/// The core's harvester with what a report asks beside.
pub(super) struct Hosted<'a, S: Scalar> {
    harvester: Harvester<S, AnyParts>,
    model: &'a Sliding,
}

impl<S: Scalar> HostedScene<S, STATES> for Hosted<'_, S> {
    type Core = Harvester<S, AnyParts>;

    fn core(&self) -> &Self::Core {
        &self.harvester
    }

    fn columns(&self, with_store: bool) -> &'static [&'static str] {
        const WITH_STORE: [&str; 8] = outcome::with_store(SLIDING_COLUMNS);
        if with_store { &WITH_STORE } else { &SLIDING_COLUMNS }
    }

    fn coulombs(&self, _displacement: S, charge: S) -> S {
        self.harvester.charge_unit() * charge
    }

    /// Displacement, velocity and charge as large as they are in a motion over half the patch.
    fn typical(&self) -> [f64; STATES] {
        let from = &self.model.parameters;
        let tribo_charge =
            from.charge_density_c_per_m2 * std::f64::consts::PI * from.patch_radius_m * from.patch_radius_m;
        [
            from.patch_radius_m,
            from.patch_radius_m * self.harvester.angular_frequency().to_f64(),
            unit_of_charge(tribo_charge, self.harvester.charge_unit().to_f64()),
        ]
    }

    /// Without the lateral force what the field takes from the motion is not debited there: each
    /// ledger closes by itself only.
    fn residual(&self, residual: &Residual<S>) -> Option<S> {
        if self.model.parameters.lateral_force { residual.total() } else { residual.largest() }
    }

    fn particular(&self, found: &Found<S>) -> Particular {
        let number = |value: S| Some(value.to_f64());
        let displacement = found.coordinate;
        let half = S::from_f64(0.5);
        let hertz = self.harvester.angular_frequency().to_f64() / std::f64::consts::TAU;
        Particular::Sliding(SlidingOutcome {
            natural_frequency_hz: Some(hertz),
            peak_displacement_m: number(displacement.magnitude()),
            amplitude_m: number(half * (displacement.highest - displacement.lowest)),
            stick_fraction: number(found.stick_fraction),
            sticks_per_period: found.periods.map(|periods| f64::from(found.sticks) / periods),
        })
    }
}
