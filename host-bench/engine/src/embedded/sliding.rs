//! A sliding run on the embedded core.

use model_core::energy::Residual;
use model_core::observer::AcceptedStep;
use model_core::part::VACUUM_PERMITTIVITY;
use model_core::part::beam::Cantilever;
use model_core::part::load::AnyLoad;
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::sliding::{
    AnyChoices, AnyLateralForce, Choices, Parameters, PatchFriction, Sliding as Harvester, Start,
};

use super::limits::{Gauge, UNUSED, limits};
use super::report::{RunSummary, dense};
use super::run::refuse_parameter;
use super::triboelectric::{PARTS, STATES, Triboelectric, explicit_step_into, unit_of_charge};
use harvester_scene::method::Failure;
use harvester_scene::outcome::{Particular, SLIDING_COLUMNS, SlidingOutcome};
use harvester_scene::scene_file::{Load, Scene, Sliding};

/// The core's parameters of a scene.
pub fn parameters<S: Scalar>(model: &Sliding, load: Load) -> Parameters<S, AnyChoices<S>> {
    let from = &model.parameters;
    let number = S::from_f64;
    model_core::sliding_numbers!(harvester_scene::of_rows! { core from Parameters {
        choices: Choices {
            load: AnyLoad { resistance: number(load.resistance_ohm()) },
            friction: PatchFriction {
                static_active: number(from.static_friction_active),
                static_inert: number(from.static_friction_inert),
                kinetic_active: number(from.kinetic_friction_active),
                kinetic_inert: number(from.kinetic_friction_inert),
            },
            force_law: from.force_law,
            sticking: from.stick_charge,
            lateral_force: if from.lateral_force { AnyLateralForce::Field } else { AnyLateralForce::None },
        },
    } })
}

impl Triboelectric for Sliding {
    type Core<S: Scalar> = Harvester<S, AnyChoices<S>>;
    type Start<S: Scalar> = Start<S>;
    const COLUMNS: [&'static str; 7] = SLIDING_COLUMNS;

    fn core<S: Scalar, M: Mathematics<S>>(&self, scene: &Scene) -> Result<Self::Core<S>, Failure> {
        parameters::<S>(self, scene.load).build().map_err(|error| refuse_parameter(scene, &error))
    }

    fn start<S: Scalar>(&self) -> Start<S> {
        Start {
            displacement: self.initial.position_m.map(S::from_f64),
            velocity: self.initial.velocity_m_per_s.map(S::from_f64),
            charge: self.initial.charge_c.map(S::from_f64),
        }
    }

    /// With the capacitance at a fiftieth of the overlap.
    fn explicit_step<S: Scalar>(&self, core: &Self::Core<S>, load: Load) -> f64 {
        let from = &self.parameters;
        let period = std::f64::consts::TAU / core.angular_frequency().to_f64();
        let area = std::f64::consts::PI * from.patch_radius_m.powi(2);
        let permittivity = VACUUM_PERMITTIVITY * from.relative_permittivity;
        let capacitance = permittivity * 0.02 * area / from.dielectric_thickness_m;
        explicit_step_into(load, period, capacitance)
    }

    /// In a motion over half the patch.
    fn typical<S: Scalar>(&self, core: &Self::Core<S>) -> [f64; STATES] {
        let from = &self.parameters;
        let tribo_charge =
            from.charge_density_c_per_m2 * std::f64::consts::PI * from.patch_radius_m * from.patch_radius_m;
        [
            from.patch_radius_m,
            from.patch_radius_m * core.angular_frequency().to_f64(),
            unit_of_charge(tribo_charge, core.charge_unit().to_f64()),
        ]
    }

    /// Without the lateral force what the field takes from the motion is not debited there: each ledger closes by itself only.
    fn residual<S: Scalar>(&self, residual: &Residual<S>) -> Option<S> {
        if self.parameters.lateral_force { residual.total() } else { residual.largest() }
    }

    /// In the first mode of the beam with the slider.
    fn gauge<'a, S: Scalar>(&'a self, scene: &'a Scene) -> Gauge<'a, S> {
        let from = &self.parameters;
        let [strain, slope] = limits(scene);
        let (length, thickness) = (from.beam_length_m, from.beam_thickness_m);
        let section = from.beam_width_m * thickness;
        let beam = Cantilever {
            length,
            bending_stiffness: from.young_modulus_pa * section * thickness * thickness / 12.0,
            mass_per_length: from.density_kg_per_m3 * section,
            tip_mass: from.slider_mass_kg,
        };
        let mode = beam.mode(1);
        let (clamp, tip) = (mode.shape(0.0), mode.shape(1.0));
        let strain_by_tip = 0.5 * thickness * clamp.curvature / (length * length * tip.value);
        let slope_by_tip = tip.slope / (length * tip.value);
        let at = move |step: &AcceptedStep<'_, S>, fraction| {
            let [start, end] = [step.start, step.end].map(|outputs| outputs.coordinate());
            let tip = dense(start, end, step.step, fraction).to_f64().abs();
            [[strain_by_tip * tip, strain], [slope_by_tip * tip, slope], UNUSED, UNUSED, UNUSED]
        };
        (Box::new(at), PARTS)
    }

    fn particular<S: Scalar>(
        &self,
        harvester: &impl model_core::scene::Harvester<S>,
        found: &RunSummary<'_, S>,
    ) -> Particular {
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
}
