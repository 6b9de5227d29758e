//! A contact-separation run on the embedded core.

use std::marker::PhantomData;

use model_core::bounds::ParameterError;
use model_core::clock::Instant;
use model_core::energy::Residual;
use model_core::observer::AcceptedStep;
use model_core::part::VACUUM_PERMITTIVITY;
use model_core::part::load::AnyLoad;
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::{
    AnyRestitution, ConstantRestitution, Restitution as Law, VelocityDependentRestitution,
};
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::contact_separation::{
    AnyChoices, Choices, ContactSeparation as Harvester, Parameters, Start,
};
use model_core::snapshot::Fingerprint;

use super::limits::{Gauge, UNUSED, limits};
use super::report::{RunSummary, dense};
use super::run::refuse_parameter;
use super::triboelectric::{PARTS, STATES, Triboelectric, explicit_step_into, unit_of_charge};
use harvester_scene::method::Failure;
use harvester_scene::outcome::{CONTACT_SEPARATION_COLUMNS, ContactSeparationOutcome, Particular};
use harvester_scene::scene_file::{
    ContactSeparation, ForceLaw, Load, Restitution, Scene, StickCharge, breakdown_voltage_v, fringing,
};

/// The core's parameters of a scene.
pub fn parameters<S: Scalar, M: Mathematics<S>>(
    model: &ContactSeparation,
    load: Load,
) -> Parameters<S, AnyChoices<S, M>> {
    parameters_with(model, load, restitution(model.parameters.restitution))
}

/// The core's parameters of a scene with a law of restitution of the core.
fn parameters_with<S: Scalar, L>(
    model: &ContactSeparation,
    load: Load,
    restitution: L,
) -> Parameters<S, HostChoices<S, L>> {
    let from = &model.parameters;
    let number = S::from_f64;
    model_core::contact_separation_numbers!(harvester_scene::of_rows! { core from Parameters {
        choices: Choices {
            load: AnyLoad { resistance: number(load.resistance_ohm()) },
            restitution,
            force_law: from.force_law,
            parasitic: ParasiticCapacitance { capacitance: number(from.parasitic_capacitance_f) },
            sticking: from.stick_charge,
        },
    } })
}

fn restitution<S: Scalar, M: Mathematics<S>>(law: Restitution) -> AnyRestitution<S, M> {
    let number = S::from_f64;
    match law {
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
    }
}

/// A law of restitution with elementary functions that are chosen at run time: an impact calls them once, and the harvester
/// is compiled once for all of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct HostRestitution<S> {
    law: Restitution,
    /// The coefficient of the law at a speed in m/s.
    coefficient: fn(Restitution, S) -> S,
}

impl<S: Scalar> HostRestitution<S> {
    fn new<M: Mathematics<S>>(law: Restitution) -> Self {
        Self { law, coefficient: |law, speed| restitution::<S, M>(law).coefficient(speed) }
    }
}

/// By the law alone: a comparison of functions says nothing.
impl<S> PartialEq for HostRestitution<S> {
    fn eq(&self, other: &Self) -> bool {
        self.law == other.law
    }
}

impl<S: Scalar> Law<S> for HostRestitution<S> {
    fn coefficient(&self, speed: S) -> S {
        (self.coefficient)(self.law, speed)
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        restitution::<S, S::Build>(self.law).check()
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        restitution::<S, S::Build>(self.law).identify(fingerprint);
    }
}

/// The choices of a scene file with a law of restitution of the core.
type HostChoices<S, L> = Choices<AnyLoad<S>, L, ForceLaw, ParasiticCapacitance<S>, StickCharge>;

impl Triboelectric for ContactSeparation {
    type Core<S: Scalar> = Harvester<S, HostChoices<S, HostRestitution<S>>>;
    type Start<S: Scalar> = Start<S>;
    const COLUMNS: [&'static str; 7] = CONTACT_SEPARATION_COLUMNS;

    fn core<S: Scalar, M: Mathematics<S>>(&self, scene: &Scene) -> Result<Self::Core<S>, Failure> {
        parameters_with(self, scene.load, HostRestitution::new::<M>(self.parameters.restitution))
            .build()
            .map_err(|error| refuse_parameter(scene, &error))
    }

    fn start<S: Scalar>(&self) -> Start<S> {
        Start {
            gap: self.initial.position_m.map(S::from_f64),
            velocity: self.initial.velocity_m_per_s.map(S::from_f64),
            charge: self.initial.charge_c.map(S::from_f64),
        }
    }

    /// With the capacitance C + C_p, and C at three times the initial gap.
    fn explicit_step<S: Scalar>(&self, _core: &Self::Core<S>, load: Load) -> f64 {
        let from = &self.parameters;
        let period = std::f64::consts::TAU * (from.mass_kg / from.stiffness_n_per_m).sqrt();
        let distance = 3.0 * from.initial_gap_m + from.dielectric_thickness_m / from.relative_permittivity;
        let capacitance =
            VACUUM_PERMITTIVITY * from.electrode_area_m2 / distance + from.parasitic_capacitance_f;
        explicit_step_into(load, period, capacitance)
    }

    /// In a motion that uses the whole gap.
    fn typical<S: Scalar>(&self, core: &Self::Core<S>) -> [f64; STATES] {
        let from = &self.parameters;
        let tribo_charge = from.charge_density_c_per_m2 * from.electrode_area_m2;
        [
            from.initial_gap_m,
            from.initial_gap_m * core.angular_frequency().to_f64(),
            unit_of_charge(tribo_charge, core.charge_unit().to_f64()),
        ]
    }

    fn residual<S: Scalar>(&self, residual: &Residual<S>) -> Option<S> {
        match self.parameters.force_law {
            ForceLaw::GapField => residual.total(),
            ForceLaw::TransferredCharge | ForceLaw::None => residual.largest(),
        }
    }

    fn gauge<'a, S: Scalar>(&'a self, scene: &'a Scene) -> Gauge<'a, S> {
        let from = &self.parameters;
        let [pressure, fringe, speed] = limits(scene);
        let dielectric = from.dielectric_thickness_m / from.relative_permittivity;
        let at = move |step: &AcceptedStep<'_, S>, fraction| {
            let [gap, charge] =
                [[step.start.coordinate(), step.end.coordinate()], [step.start.charge, step.end.charge]]
                    .map(|[start, end]| dense(start, end, step.step, fraction).to_f64());
            // A step that ends in an impact ends up to a tick beyond contact.
            let gap = gap.max(0.0);
            let density = from.charge_density_c_per_m2 - charge / from.electrode_area_m2;
            let voltage = (density * gap / VACUUM_PERMITTIVITY).abs();
            let edges = fringing(gap + dielectric, from.electrode_area_m2);
            [[voltage, breakdown_voltage_v(pressure * gap)], [edges, fringe], [0.0, speed], UNUSED, UNUSED]
        };
        (Box::new(at), PARTS)
    }

    fn particular<S: Scalar>(
        &self,
        _harvester: &impl model_core::scene::Harvester<S>,
        found: &RunSummary<'_, S>,
    ) -> Particular {
        let window = found.window;
        let number = |value: S| Some(value.to_f64());
        let impacts = u64::from(window.report().impacts);
        Particular::ContactSeparation(ContactSeparationOutcome {
            natural_frequency_hz: Some(self.parameters.natural_frequency_hz()),
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
}
