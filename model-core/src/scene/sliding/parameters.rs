//! Parameters, and the coefficients derived from them.

use super::force_law::Surface;
use super::{Choices, Friction, Parts, Sliding};
use crate::bounds::{Bounds, ParameterError, parameters, with_choices};
use crate::part::beam::Cantilever;
use crate::part::load::{Load, Resistance};
use crate::part::{GRAVITY, VACUUM_PERMITTIVITY};
use crate::scalar::Scalar;
use crate::scene::NATURAL_FREQUENCY;

parameters! { $ sliding_numbers ""
/// Parameters of a sliding harvester, in SI units. Table 1 of Fu, Ouyang and Davis (2020).
///
/// The beam bends in the direction of its thickness. The natural frequency with the slider must be from 10⁻³ to 10⁴ Hz. A
/// negative density of the tribo-charge would reverse the signs of charge and voltage only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters<S, C> {
    {
        beam_length "`L`": beam_length_m "m" 1e-4..=10.0 "Length of the cantilever" "natural frequency 1e-3 to 1e4 Hz";
        beam_width "`b`": beam_width_m "m" 1e-5..=10.0 "Width of the cantilever";
        beam_thickness "`h`": beam_thickness_m "m" 1e-7..=1.0 "Thickness of the cantilever";
        young_modulus "`E`": young_modulus_pa "Pa" 1e5..=1e13 "Young's modulus of the cantilever";
        density "`ρ`": density_kg_per_m3 "kg/m³" 1.0..=1e5 "Density of the cantilever";
        damping_ratio "`ζ`": damping_ratio "1" 0.0..=10.0 "Damping ratio, without friction";
        slider_mass "`m`": slider_mass_kg "kg" 1e-12..=1e3 "Mass at the tip";
        patch_radius "`r`": patch_radius_m "m" 1e-6..=1.0 "Radius of the slider and of each patch";
        dielectric_thickness "`d`": dielectric_thickness_m "m" 1e-9..=0.1 "Thickness of the dielectric";
        relative_permittivity "`ε_r`": relative_permittivity "1" 1.0..=1e5 "Relative permittivity of the dielectric";
        charge_density "`σ`": charge_density_c_per_m2 "C/m²" 0.0..=1e-2 "Density of the tribo-charge";
    }
    /// The components: [`Choices`].
    pub choices: C,
} }

/// Relaxations at full overlap per radian between which the energies of steps are corrected: near the load that takes the most power.
///
/// In a slower circuit the errors of the steps cancel over a period, in a faster one the overlap changes the relaxation within a step:
/// both are more accurate without.
const HARMONIC: [f64; 2] = [0.32, 1.26];

impl<S: Scalar, C> Parameters<S, C> {
    sliding_numbers! { with_choices! {} }

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
        let mode = self.cantilever().mode(1);
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
        let relaxation = circuit_rate / angular_frequency;
        let [slowest, fastest] = HARMONIC.map(S::from_f64);
        let diameter = two * self.patch_radius;
        let patch_energy = modal_mass * self.dielectric_thickness * tribo_charge * tribo_charge;
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
            harmonic: relaxation > slowest && relaxation < fastest,
            field: charge_unit * elastance,
            // The acceleration at a release may have a rounding error, and so the wrong sign until the load has
            // grown: for much less than a hundredth of a radian.
            velocity_margin: S::from_f64(0.01 * GRAVITY) * S::EPSILON / angular_frequency,
            energy_floor: energy_floor(load.resistance(), angular_frequency, circuit_rate, patch_energy),
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

    fn cantilever(&self) -> Cantilever<S> {
        let section = self.beam_width * self.beam_thickness;
        let square = self.beam_thickness * self.beam_thickness;
        Cantilever {
            length: self.beam_length,
            bending_stiffness: self.young_modulus * section * square * S::from_f64(1.0 / 12.0),
            mass_per_length: self.density * section,
            tip_mass: self.slider_mass,
        }
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

/// Scale of the energy of a radian: the energy of the charge σS on the whole patch, (σS)²/2C = M d q², or with a small
/// resistance the dissipated part 2 ω τ of it. A slow motion of a hundredth of the diameter moves a ten-thousandth of it.
fn energy_floor<S: Scalar>(
    resistance: Resistance<S>,
    angular_frequency: S,
    circuit_rate: S,
    patch_energy: S,
) -> S {
    let share = match resistance {
        Resistance::Finite(_) => (S::from_f64(2.0) * angular_frequency / circuit_rate).min(S::ONE),
        Resistance::Short | Resistance::Open => S::ONE,
    };
    (S::from_f64(1e-8) * share * patch_energy).max(S::TINY)
}
