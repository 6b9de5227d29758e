//! A sliding run on the embedded core.

use model_core::energy::Residual;
use model_core::observer::{AcceptedStep, Outputs};
use model_core::part::VACUUM_PERMITTIVITY;
use model_core::part::load::AnyLoad;
use model_core::scalar::Scalar;
use model_core::scene::sliding::{
    AnyChoices, AnyLateralForce, Choices, Parameters, PatchFriction, STATES, Sliding as Harvester, Start,
};

use super::bridge::bridge;
use super::contact_separation::{force_law, sticking};
use super::excitation::Setting;
use super::run::{Found, Report, refuse_parameter, step_control};
use super::triboelectric::{self, Prepared, behind_bridge, explicit_step_into, unit_of_charge};
use harvester_scene::method::Failure;
use harvester_scene::outcome::{self, Outcome, Particular, SLIDING_COLUMNS, SlidingOutcome};
use harvester_scene::scene_file::{Load, Scene, Sliding};

/// The core's parameters of a scene.
#[must_use]
pub fn parameters<S: Scalar>(model: &Sliding, load: Load) -> Parameters<S, AnyChoices<S>> {
    let from = &model.parameters;
    let number = S::from_f64;
    Parameters {
        beam_length: number(from.beam_length_m),
        beam_width: number(from.beam_width_m),
        beam_thickness: number(from.beam_thickness_m),
        young_modulus: number(from.young_modulus_pa),
        density: number(from.density_kg_per_m3),
        damping_ratio: number(from.damping_ratio),
        slider_mass: number(from.slider_mass_kg),
        patch_radius: number(from.patch_radius_m),
        dielectric_thickness: number(from.dielectric_thickness_m),
        relative_permittivity: number(from.relative_permittivity),
        charge_density: number(from.charge_density_c_per_m2),
        choices: Choices {
            load: AnyLoad { resistance: number(load.resistance_ohm()) },
            friction: PatchFriction {
                static_active: number(from.static_friction_active),
                static_inert: number(from.static_friction_inert),
                kinetic_active: number(from.kinetic_friction_active),
                kinetic_inert: number(from.kinetic_friction_inert),
            },
            force_law: force_law(from.force_law),
            sticking: sticking(from.stick_charge),
            lateral_force: if from.lateral_force { AnyLateralForce::Field } else { AnyLateralForce::None },
        },
    }
}

/// The core's harvester of a scene.
pub(super) fn core<S: Scalar>(
    scene: &Scene,
    model: &Sliding,
) -> Result<Harvester<S, AnyChoices<S>>, Failure> {
    parameters::<S>(model, scene.load).build().map_err(|error| refuse_parameter(scene, &error))
}

/// Calls `with` with all that a run of the scene needs, and its initial values.
pub(super) fn prepared<S: Scalar, R>(
    setting: Setting<'_, S>,
    model: &Sliding,
    with: impl FnOnce(
        &Prepared<'_, S, Harvester<S, AnyChoices<S>>, SlidingReport<'_>>,
        &Start<S>,
    ) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let Setting { scene, options, .. } = setting;
    let core = core::<S>(scene, model)?;
    let control = step_control(scene, options, explicit_step(&core, model, scene.load))?;
    let report = SlidingReport(model);
    with(&Prepared { setting, core: &core, report: &report, control }, &start(model))
}

/// Runs the scene from its start to its end.
pub(super) fn run<S: Scalar>(setting: Setting<'_, S>, model: &Sliding) -> Result<Outcome, Failure> {
    let scene = setting.scene;
    let Some(bridge) = bridge(scene.load) else {
        return prepared(setting, model, |prepared, start| prepared.to_end(start));
    };
    let core = core::<S>(scene, model)?;
    let motion_s = explicit_step(&core, model, scene.load);
    let inner = (core, &SlidingReport(model));
    behind_bridge(setting, inner, &start(model), bridge, motion_s)
}

/// The core's initial values of a scene.
pub(super) fn start<S: Scalar>(model: &Sliding) -> Start<S> {
    Start {
        displacement: model.initial.displacement_m.map(S::from_f64),
        velocity: model.initial.velocity_m_per_s.map(S::from_f64),
        charge: model.initial.charge_c.map(S::from_f64),
    }
}

/// A step at which the explicit method is stable and accurate: see [`explicit_step_into`], with the capacitance at a
/// fiftieth of the overlap.
fn explicit_step<S: Scalar>(harvester: &Harvester<S, AnyChoices<S>>, model: &Sliding, load: Load) -> f64 {
    let from = &model.parameters;
    let period = std::f64::consts::TAU / harvester.angular_frequency().to_f64();
    let area = std::f64::consts::PI * from.patch_radius_m.powi(2);
    let permittivity = VACUUM_PERMITTIVITY * from.relative_permittivity;
    let capacitance = permittivity * 0.02 * area / from.dielectric_thickness_m;
    explicit_step_into(load, period, capacitance)
}

/// Displacement, velocity and charge as large as they are in a motion over half the patch.
pub(super) fn typical<S: Scalar>(model: &Sliding, core: &Harvester<S, AnyChoices<S>>) -> [f64; STATES] {
    let from = &model.parameters;
    let tribo_charge =
        from.charge_density_c_per_m2 * std::f64::consts::PI * from.patch_radius_m * from.patch_radius_m;
    [
        from.patch_radius_m,
        from.patch_radius_m * core.angular_frequency().to_f64(),
        unit_of_charge(tribo_charge, core.charge_unit().to_f64()),
    ]
}

/// The report of a sliding scene.
pub(super) struct SlidingReport<'a>(&'a Sliding);

impl<S: Scalar, H: model_core::scene::Harvester<S>> Report<S, H> for SlidingReport<'_> {
    fn columns(&self, with_storage: bool) -> &'static [&'static str] {
        const WITH_STORAGE: [&str; 8] = outcome::with_store(SLIDING_COLUMNS);
        if with_storage { &WITH_STORAGE } else { &SLIDING_COLUMNS }
    }

    fn row(&self, step: &AcceptedStep<'_, S>, fraction: S, acceleration: S) -> [S; 6] {
        triboelectric::row(step, fraction, acceleration)
    }

    /// Without the lateral force what the field takes from the motion is not debited there: each
    /// ledger closes by itself only.
    fn residual(&self, residual: &Residual<S>) -> Option<S> {
        if self.0.parameters.lateral_force { residual.total() } else { residual.largest() }
    }

    fn particular(&self, harvester: &H, found: &Found<'_, S>, _end: &H::State) -> Particular {
        let window = found.window;
        let number = |value: S| Some(value.to_f64());
        let displacement = window.report().coordinate;
        let half = S::from_f64(0.5);
        let frequency = harvester.angular_frequency().to_f64() / std::f64::consts::TAU;
        Particular::Sliding(SlidingOutcome {
            natural_frequency_hz: Some(frequency),
            peak_displacement_m: number(displacement.magnitude()),
            amplitude_m: number(half * (displacement.highest - displacement.lowest)),
            stick_fraction: number(window.report().stick_fraction),
            sticks_per_period: found.periods.map(|periods| f64::from(window.report().sticks) / periods),
        })
    }

    fn describe(&self, outputs: &Outputs<'_, S>) -> String {
        triboelectric::describe("displacement_m", outputs)
    }
}
