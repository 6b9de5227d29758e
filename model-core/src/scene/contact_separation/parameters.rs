//! Parameters, and the coefficients derived from them.

use super::{Choices, ContactSeparation, Parts};
use crate::bounds::{Bounds, ParameterError, parameters, with_choices};
use crate::part::VACUUM_PERMITTIVITY;
use crate::part::load::{Load, Resistance};
use crate::part::parasitic::Parasitic;
use crate::part::restitution::Restitution;
use crate::scalar::Scalar;
use crate::scene::NATURAL_FREQUENCY;

parameters! { $ contact_separation_numbers ""
/// Parameters of a contact-separation harvester, in SI units. Table 2 of Fu, Ouyang and Davis (2020).
///
/// The natural frequency `√(k/m)/2π` must be from 10⁻³ to 10⁴ Hz. A negative density of the tribo-charge would reverse the
/// signs of charge and voltage only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters<S, C> {
    {
        mass "`m`": mass_kg "kg" 1e-12..=1e3 "Moving mass";
        stiffness "`k`": stiffness_n_per_m "N/m" 1e-9..=1e9 "Stiffness of the spring" "natural frequency 1e-3 to 1e4 Hz";
        damping_ratio "`ζ`": damping_ratio "1" 0.0..=10.0 "Damping ratio, c / (2 √(k m))";
        initial_gap "`d0`": initial_gap_m "m" 1e-9..=1.0 "Gap at which the spring is unstretched";
        electrode_area "`S`": electrode_area_m2 "m²" 1e-12..=10.0 "Area of the electrode";
        dielectric_thickness "`d`": dielectric_thickness_m "m" 1e-9..=0.1 "Thickness of the dielectric";
        relative_permittivity "`ε_r`": relative_permittivity "1" 1.0..=1e5 "Relative permittivity of the dielectric";
        charge_density "`σ`": charge_density_c_per_m2 "C/m²" 0.0..=1e-2 "Density of the tribo-charge";
    }
    /// The components: [`Choices`].
    pub choices: C,
} }

impl<S: Scalar, C> Parameters<S, C> {
    contact_separation_numbers! { with_choices! {} }

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
        ContactSeparation {
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
        }
        .check_range()
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

impl<S: Scalar, C: Parts<S>> ContactSeparation<S, C> {
    /// Refuses what overflows single precision: the bounds of the single parameters allow such combinations.
    fn check_range(self) -> Result<Self, ParameterError<S>> {
        for (field, value) in [
            ("1 / (permittivity * electrode area * resistance)", self.circuit_rate),
            ("parasitic capacitance / (permittivity * electrode area)", self.parasitic),
            ("charge density * sqrt(electrode area / (2 permittivity * mass))", self.tribo_charge),
        ] {
            Bounds::new(0.0, 1e34).check(field, value)?;
        }
        Ok(self)
    }
}
