//! A contact-separation run on the embedded core.

use std::marker::PhantomData;

use model_core::clock::Instant;
use model_core::energy::Residual;
use model_core::observer::{AcceptedStep, Outputs};
use model_core::part::VACUUM_PERMITTIVITY;
use model_core::part::load::AnyLoad;
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::{AnyRestitution, ConstantRestitution, VelocityDependentRestitution};
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::contact_separation::{
    self, AnyChoices, AnyForceLaw, Choices, ContactSeparation as Harvester, Parameters, STATES, Start,
};

use super::bridge::bridge;
use super::excitation::Setting;
use super::run::{Found, Report, refuse_parameter, step_control};
use super::triboelectric::{self, Prepared, behind_bridge, explicit_step_into, unit_of_charge};
use harvester_scene::method::Failure;
use harvester_scene::outcome::{
    self, CONTACT_SEPARATION_COLUMNS, ContactSeparationOutcome, Outcome, Particular,
};
use harvester_scene::scene_file::{ContactSeparation, ForceLaw, Load, Restitution, Scene, StickCharge};

/// The core's parameters of a scene.
#[must_use]
pub fn parameters<S: Scalar, M: Mathematics<S>>(
    model: &ContactSeparation,
    load: Load,
) -> Parameters<S, AnyChoices<S, M>> {
    let from = &model.parameters;
    let number = S::from_f64;
    Parameters {
        mass: number(from.mass_kg),
        stiffness: number(from.stiffness_n_per_m),
        damping_ratio: number(from.damping_ratio),
        initial_gap: number(from.initial_gap_m),
        electrode_area: number(from.electrode_area_m2),
        dielectric_thickness: number(from.dielectric_thickness_m),
        relative_permittivity: number(from.relative_permittivity),
        charge_density: number(from.charge_density_c_per_m2),
        choices: Choices {
            load: AnyLoad { resistance: number(load.resistance_ohm()) },
            restitution: match from.restitution {
                Restitution::Constant { coefficient } => {
                    AnyRestitution::Constant(ConstantRestitution { coefficient: number(coefficient) })
                }
                Restitution::VelocityDependent { at_rest, at_speed, reference_speed_m_per_s } => {
                    AnyRestitution::VelocityDependent(VelocityDependentRestitution {
                        at_rest: number(at_rest),
                        at_speed: number(at_speed),
                        reference_speed: number(reference_speed_m_per_s),
                        mathematics: PhantomData,
                    })
                }
            },
            force_law: force_law(from.force_law),
            parasitic: ParasiticCapacitance { capacitance: number(from.parasitic_capacitance_f) },
            sticking: sticking(from.stick_charge),
        },
    }
}

/// The core's name of a force law.
pub(super) fn force_law(law: ForceLaw) -> AnyForceLaw {
    match law {
        ForceLaw::TransferredCharge => AnyForceLaw::TransferredCharge,
        ForceLaw::GapField => AnyForceLaw::GapField,
    }
}

/// The core's name of what a charge does in stick.
pub(super) fn sticking(charge: StickCharge) -> contact_separation::StickCharge {
    match charge {
        StickCharge::Frozen => contact_separation::StickCharge::Frozen,
        StickCharge::Relaxing => contact_separation::StickCharge::Relaxing,
    }
}

/// The core's harvester of a scene.
pub(super) fn core<S: Scalar, M: Mathematics<S>>(
    scene: &Scene,
    model: &ContactSeparation,
) -> Result<Harvester<S, AnyChoices<S, M>>, Failure> {
    parameters::<S, M>(model, scene.load).build().map_err(|error| refuse_parameter(scene, &error))
}

/// Calls `with` with all that a run of the scene needs, and its initial values.
pub(super) fn prepared<S: Scalar, M: Mathematics<S>, R>(
    setting: Setting<'_, S>,
    model: &ContactSeparation,
    with: impl FnOnce(
        &Prepared<'_, S, Harvester<S, AnyChoices<S, M>>, ContactSeparationReport<'_>>,
        &Start<S>,
    ) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let Setting { scene, options, .. } = setting;
    let core = core::<S, M>(scene, model)?;
    let control = step_control(scene, options, explicit_step(model, scene.load))?;
    let report = ContactSeparationReport(model);
    with(&Prepared { setting, core: &core, report: &report, control }, &start(model))
}

/// Runs the scene from its start to its end.
pub(super) fn run<S: Scalar, M: Mathematics<S>>(
    setting: Setting<'_, S>,
    model: &ContactSeparation,
) -> Result<Outcome, Failure> {
    let scene = setting.scene;
    let Some(bridge) = bridge(scene.load) else {
        return prepared::<S, M, _>(setting, model, |prepared, start| prepared.to_end(start));
    };
    let core = core::<S, M>(scene, model)?;
    let motion_s = explicit_step(model, scene.load);
    let inner = (core, &ContactSeparationReport(model));
    behind_bridge(setting, inner, &start(model), bridge, motion_s)
}

/// The core's initial values of a scene.
pub(super) fn start<S: Scalar>(model: &ContactSeparation) -> Start<S> {
    Start {
        gap: model.initial.gap_m.map(S::from_f64),
        velocity: model.initial.velocity_m_per_s.map(S::from_f64),
        charge: model.initial.charge_c.map(S::from_f64),
    }
}

/// A step at which the explicit method is stable and accurate: see [`explicit_step_into`], with the capacitance C + C_p
/// and C at three times the initial gap.
fn explicit_step(model: &ContactSeparation, load: Load) -> f64 {
    let from = &model.parameters;
    let period = std::f64::consts::TAU * (from.mass_kg / from.stiffness_n_per_m).sqrt();
    let distance = 3.0 * from.initial_gap_m + from.dielectric_thickness_m / from.relative_permittivity;
    let capacitance = VACUUM_PERMITTIVITY * from.electrode_area_m2 / distance + from.parasitic_capacitance_f;
    explicit_step_into(load, period, capacitance)
}

/// Gap, velocity and charge as large as they are in a motion that uses the whole gap.
pub(super) fn typical<S: Scalar, M: Mathematics<S>>(
    model: &ContactSeparation,
    core: &Harvester<S, AnyChoices<S, M>>,
) -> [f64; STATES] {
    let from = &model.parameters;
    let tribo_charge = from.charge_density_c_per_m2 * from.electrode_area_m2;
    [
        from.initial_gap_m,
        from.initial_gap_m * core.angular_frequency().to_f64(),
        unit_of_charge(tribo_charge, core.charge_unit().to_f64()),
    ]
}

/// The report of a contact-separation scene.
pub(super) struct ContactSeparationReport<'a>(&'a ContactSeparation);

impl<S: Scalar, H: model_core::scene::Harvester<S>> Report<S, H> for ContactSeparationReport<'_> {
    fn columns(&self, with_storage: bool) -> &'static [&'static str] {
        const WITH_STORAGE: [&str; 8] = outcome::with_store(CONTACT_SEPARATION_COLUMNS);
        if with_storage { &WITH_STORAGE } else { &CONTACT_SEPARATION_COLUMNS }
    }

    fn row(&self, step: &AcceptedStep<'_, S>, fraction: S, acceleration: S) -> [S; 6] {
        triboelectric::row(step, fraction, acceleration)
    }

    fn residual(&self, residual: &Residual<S>) -> Option<S> {
        match self.0.parameters.force_law {
            ForceLaw::GapField => residual.total(),
            ForceLaw::TransferredCharge => residual.largest(),
        }
    }

    fn particular(&self, _harvester: &H, found: &Found<'_, S>, _end: &H::State) -> Particular {
        let window = found.window;
        let number = |value: S| Some(value.to_f64());
        let impacts = u64::from(window.report().impacts);
        Particular::ContactSeparation(ContactSeparationOutcome {
            peak_gap_m: number(window.report().coordinate.highest),
            // A step that ends in an impact ends up to a tick beyond contact.
            min_gap_m: number(window.report().coordinate.lowest.max(S::ZERO)),
            impacts,
            impacts_per_period: found.periods.map(|periods| impacts as f64 / periods),
            max_impact_speed_m_per_s: (impacts > 0).then(|| window.report().fastest_impact.to_f64()),
            first_impact_s: found.first_contact.map(Instant::seconds),
            stuck_fraction: number(window.report().stick_fraction),
        })
    }

    fn describe(&self, outputs: &Outputs<'_, S>) -> String {
        triboelectric::describe("gap_m", outputs)
    }
}
