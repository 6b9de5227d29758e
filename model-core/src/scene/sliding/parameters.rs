//! Parameters, and the coefficients derived from them.

use super::force_law::Surface;
use super::{Choices, Friction, Parts, Sliding};
use crate::bounds::{Bounds, ParameterError, bounded};
use crate::part::beam::Cantilever;
use crate::part::load::{Load, Resistance};
use crate::part::{GRAVITY, VACUUM_PERMITTIVITY};
use crate::scalar::Scalar;
use crate::scene::NATURAL_FREQUENCY;

/// Parameters of a sliding harvester, in SI units. Table 1 of Fu, Ouyang and Davis (2020).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters<S, C> {
    /// Length `L` of the beam in m, 10⁻⁴ to 10.
    pub beam_length: S,
    /// Width `b` of the beam in m, 10⁻⁵ to 10.
    pub beam_width: S,
    /// Thickness `h` of the beam, in the direction of bending, in m, 10⁻⁷ to 1; the natural frequency must be from
    /// 10⁻³ to 10⁴ Hz.
    pub beam_thickness: S,
    /// Young's modulus `E` in Pa, 10⁵ to 10¹³.
    pub young_modulus: S,
    /// Density `ρ` of the beam in kg/m³, 1 to 10⁵.
    pub density: S,
    /// Damping ratio `ζ` of the first mode, 0 to 10.
    pub damping_ratio: S,
    /// Mass `m` of the slider in kg, 10⁻¹² to 10³.
    pub slider_mass: S,
    /// Radius `r` of the slider and the active patch in m, 10⁻⁶ to 1.
    pub patch_radius: S,
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
    "beam_length" = beam_length: 1e-4, 10.0;
    "beam_width" = beam_width: 1e-5, 10.0;
    "beam_thickness" = beam_thickness: 1e-7, 1.0;
    "young_modulus" = young_modulus: 1e5, 1e13;
    "density" = density: 1.0, 1e5;
    "damping_ratio" = damping_ratio: 0.0, 10.0;
    "slider_mass" = slider_mass: 1e-12, 1e3;
    "patch_radius" = patch_radius: 1e-6, 1.0;
    "dielectric_thickness" = dielectric_thickness: 1e-9, 0.1;
    "relative_permittivity" = relative_permittivity: 1.0, 1e5;
    "charge_density" = charge_density: 0.0, 1e-2;
}

impl<S: Scalar, C> Parameters<S, C> {
    /// The same numbers with other components.
    #[must_use]
    pub fn with_choices<D>(self, choices: D) -> Parameters<S, D> {
        Parameters {
            beam_length: self.beam_length,
            beam_width: self.beam_width,
            beam_thickness: self.beam_thickness,
            young_modulus: self.young_modulus,
            density: self.density,
            damping_ratio: self.damping_ratio,
            slider_mass: self.slider_mass,
            patch_radius: self.patch_radius,
            dielectric_thickness: self.dielectric_thickness,
            relative_permittivity: self.relative_permittivity,
            charge_density: self.charge_density,
            choices,
        }
    }

    /// Checks the parameters and computes the coefficients.
    ///
    /// No operation cancels, so the coefficients are exact to some roundings in `f32` too.
    ///
    /// # Errors
    /// The first field outside its bounds, with its value.
    pub fn build(&self) -> Result<Sliding<S, C>, ParameterError<S>>
    where
        C: Parts<S>,
    {
        self.check()?;
        let &Choices { load, friction, force_law, sticking, lateral_force } = self.choices.choices();
        let two = S::from_f64(2.0);
        let section = self.beam_width * self.beam_thickness;
        let square = self.beam_thickness * self.beam_thickness;
        let mode = Cantilever {
            length: self.beam_length,
            bending_stiffness: self.young_modulus * section * square * S::from_f64(1.0 / 12.0),
            mass_per_length: self.density * section,
            tip_mass: self.slider_mass,
        }
        .mode(1);
        let angular_frequency = mode.angular_frequency;
        let frequency = angular_frequency * S::from_f64(0.5 * core::f64::consts::FRAC_1_PI);
        Bounds::of(NATURAL_FREQUENCY).check("natural frequency of the beam with the slider", frequency)?;
        let tip = mode.shape(S::ONE).value;
        let modal_mass = S::ONE / (tip * tip);
        let area = S::from_f64(core::f64::consts::PI) * self.patch_radius * self.patch_radius;
        let permittivity_area = S::from_f64(VACUUM_PERMITTIVITY) * self.relative_permittivity * area;
        let charge_unit = (two * permittivity_area * modal_mass).sqrt();
        let tribo_charge = self.charge_density * area / charge_unit;
        let elastance = self.dielectric_thickness / permittivity_area;
        let circuit_rate = match load.resistance() {
            Resistance::Finite(resistance) => elastance / resistance,
            Resistance::Short | Resistance::Open => S::ZERO,
        };
        let diameter = two * self.patch_radius;
        // Scale of the energy of a radian: the energy of the charge σS on the whole patch, (σS)²/2C = M d q², or with
        // a small resistance the dissipated part 2 ω τ of it. A slow motion of a hundredth of the diameter moves a
        // ten-thousandth of the energy.
        let patch_energy = modal_mass * self.dielectric_thickness * tribo_charge * tribo_charge;
        let share = match load.resistance() {
            Resistance::Finite(_) => (two * angular_frequency / circuit_rate).min(S::ONE),
            Resistance::Short | Resistance::Open => S::ONE,
        };
        let scene = Sliding {
            modal_mass,
            base_coupling: mode.base_coupling * tip,
            angular_frequency,
            stiffness_per_mass: angular_frequency * angular_frequency,
            damping_per_mass: two * self.damping_ratio * angular_frequency,
            time_scale: S::ONE / angular_frequency,
            weight_per_mass: self.slider_mass * S::from_f64(GRAVITY) / modal_mass,
            diameter,
            per_diameter: S::ONE / diameter,
            dielectric: self.dielectric_thickness,
            charge_unit,
            surface: Surface { tribo_charge, root_permittivity: self.relative_permittivity.sqrt() },
            per_tribo_charge: S::ONE / tribo_charge.max(S::from_f64(1e-12)),
            circuit_rate,
            field: charge_unit * elastance,
            // The acceleration at a release may have a rounding error, and so the wrong sign until the load has
            // grown: for much less than a hundredth of a radian.
            velocity_margin: S::from_f64(0.01 * GRAVITY) * S::EPSILON / angular_frequency,
            energy_floor: (S::from_f64(1e-8) * share * patch_energy).max(S::TINY),
            load,
            force_law,
            friction,
            sticking,
            lateral_force,
        };
        // The bounds above allow combinations that overflow single precision.
        Bounds::new(0.0, 1e34)
            .check("dielectric thickness / (permittivity * patch area * resistance)", scene.circuit_rate)?;
        Bounds::new(0.0, 1e12)
            .check("charge density * sqrt(patch area / (2 permittivity * modal mass))", tribo_charge)?;
        Ok(scene)
    }

    fn check(&self) -> Result<(), ParameterError<S>>
    where
        C: Parts<S>,
    {
        let Choices { load, friction, .. } = self.choices.choices();
        self.check_numbers()?;
        friction.check()?;
        load.resistance().check()
    }
}
