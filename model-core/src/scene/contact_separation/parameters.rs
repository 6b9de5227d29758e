//! Parameters, and the coefficients derived from them.

use super::{Choices, ContactSeparation, Parts};
use crate::bounds::{Bounds, ParameterError, bounded};
use crate::part::VACUUM_PERMITTIVITY;
use crate::part::load::{Load, Resistance};
use crate::part::parasitic::Parasitic;
use crate::part::restitution::Restitution;
use crate::scalar::Scalar;
use crate::scene::NATURAL_FREQUENCY;

/// Parameters of a contact-separation harvester, in SI units. Table 2 of Fu, Ouyang and Davis (2020).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters<S, C> {
    /// Moving mass `m` in kg, 10⁻¹² to 10³.
    pub mass: S,
    /// Stiffness `k` in N/m, 10⁻⁹ to 10⁹; `√(k/m)/2π` must be from 10⁻³ to 10⁴ Hz.
    pub stiffness: S,
    /// Damping ratio `ζ = c / (2 √(k m))`, 0 to 10.
    pub damping_ratio: S,
    /// Gap `d0` at rest in m, 10⁻⁹ to 1.
    pub initial_gap: S,
    /// Electrode area `S` in m², 10⁻¹² to 10.
    pub electrode_area: S,
    /// Thickness `d` of the dielectric in m, 10⁻⁹ to 0.1.
    pub dielectric_thickness: S,
    /// Relative permittivity `ε_r` of the dielectric, 1 to 10⁵.
    pub relative_permittivity: S,
    /// Magnitude of the tribo-charge surface density `σ` in C/m², 0 to 10⁻². A negative `σ` reverses the signs of
    /// charge and voltage only.
    pub charge_density: S,
    /// The components: [`Choices`].
    pub choices: C,
}

bounded! { Parameters<S, C>:
    "mass" = mass: 1e-12, 1e3;
    "stiffness" = stiffness: 1e-9, 1e9;
    "damping_ratio" = damping_ratio: 0.0, 10.0;
    "initial_gap" = initial_gap: 1e-9, 1.0;
    "electrode_area" = electrode_area: 1e-12, 10.0;
    "dielectric_thickness" = dielectric_thickness: 1e-9, 0.1;
    "relative_permittivity" = relative_permittivity: 1.0, 1e5;
    "charge_density" = charge_density: 0.0, 1e-2;
}

impl<S: Scalar, C> Parameters<S, C> {
    /// The same numbers with other components.
    #[must_use]
    pub fn with_choices<D>(self, choices: D) -> Parameters<S, D> {
        Parameters {
            mass: self.mass,
            stiffness: self.stiffness,
            damping_ratio: self.damping_ratio,
            initial_gap: self.initial_gap,
            electrode_area: self.electrode_area,
            dielectric_thickness: self.dielectric_thickness,
            relative_permittivity: self.relative_permittivity,
            charge_density: self.charge_density,
            choices,
        }
    }

    /// Checks the parameters and computes the coefficients.
    ///
    /// No operation cancels, so the coefficients are exact to a few roundings in `f32` too.
    ///
    /// # Errors
    /// The first field outside its bounds, with its value.
    pub fn build(&self) -> Result<ContactSeparation<S, C>, ParameterError<S>>
    where
        C: Parts<S>,
    {
        self.check()?;
        let &Choices { load, restitution, force_law, parasitic, sticking } = self.choices.choices();
        let two = S::from_f64(2.0);
        let stiffness_per_mass = self.stiffness / self.mass;
        let angular_frequency = stiffness_per_mass.sqrt();
        let frequency = angular_frequency * S::from_f64(0.5 * core::f64::consts::FRAC_1_PI);
        Bounds::of(NATURAL_FREQUENCY)
            .check("natural frequency sqrt(stiffness / mass) / (2 pi)", frequency)?;
        let permittivity_area = S::from_f64(VACUUM_PERMITTIVITY) * self.electrode_area;
        let charge_unit = (two * permittivity_area * self.mass).sqrt();
        let tribo_charge = self.charge_density * self.electrode_area / charge_unit;
        let dielectric = self.dielectric_thickness / self.relative_permittivity;
        let circuit_rate = match load.resistance() {
            Resistance::Finite(resistance) => S::ONE / resistance / permittivity_area,
            Resistance::Short | Resistance::Open => S::ZERO,
        };
        // A cycle delivers at most the energy of the charged dielectric, (σS)² d_e / (2 ε0 S); through a small
        // resistance, at most the energy of the current pulse of a contact, R (σS)² ω0 d0 / d_e.
        let square = tribo_charge * tribo_charge * self.mass;
        let dielectric_energy = square * dielectric;
        let pulse_energy = match load.resistance() {
            Resistance::Finite(_) => {
                two * square * angular_frequency * self.initial_gap / (circuit_rate * dielectric)
            }
            Resistance::Short | Resistance::Open => dielectric_energy,
        };
        let scene = ContactSeparation {
            mass: self.mass,
            stiffness: self.stiffness,
            initial_gap: self.initial_gap,
            stiffness_per_mass,
            damping_per_mass: two * self.damping_ratio * angular_frequency,
            angular_frequency,
            time_scale: S::ONE / angular_frequency,
            dielectric,
            charge_unit,
            permittivity_area,
            tribo_charge,
            per_tribo_charge: S::ONE / tribo_charge.max(S::from_f64(1e-12)),
            parasitic: parasitic.capacitance() / permittivity_area,
            circuit_rate,
            field: charge_unit / permittivity_area,
            stick_speed: S::from_f64(1e-4) * angular_frequency * self.initial_gap,
            energy_floor: (S::from_f64(1e-4) * dielectric_energy.min(pulse_energy)).max(S::TINY),
            load,
            force_law,
            restitution,
            sticking,
        };
        // The bounds above allow combinations that overflow single precision.
        for (field, value) in [
            ("1 / (permittivity * electrode area * resistance)", scene.circuit_rate),
            ("parasitic capacitance / (permittivity * electrode area)", scene.parasitic),
            ("charge density * sqrt(electrode area / (2 permittivity * mass))", scene.tribo_charge),
        ] {
            Bounds::new(0.0, 1e34).check(field, value)?;
        }
        Ok(scene)
    }

    fn check(&self) -> Result<(), ParameterError<S>>
    where
        C: Parts<S>,
    {
        let Choices { load, restitution, parasitic, .. } = self.choices.choices();
        self.check_numbers()?;
        parasitic.check()?;
        load.resistance().check()?;
        restitution.check()
    }
}
