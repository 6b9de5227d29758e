//! Parameters, what can be left out of them, and the coefficients made of them.

use core::fmt::Debug;

use super::circuit::Circuit;
use super::contact_law::{AnyContact, ContactLaw};
use super::{BeamCoefficients, BumpStop, RodCoefficients};
use crate::part::beam::Cantilever;
use crate::part::bounds::{Bounds, ParameterError};
use crate::part::load::AnyLoad;
use crate::part::monomorph::{Layer, Monomorph};
use crate::part::rectifier::FullBridge;
use crate::part::rod::Rod;
use crate::part::storage::AnyStorage;
use crate::scalar::Scalar;

/// Whether the voltage acts back on the beam.
pub trait Coupling: Copy + Debug + PartialEq {
    /// Whether it does.
    fn is_two_way(&self) -> bool;
}

/// It does: what is harvested is taken from the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TwoWay;

impl Coupling for TwoWay {
    #[inline]
    fn is_two_way(&self) -> bool {
        true
    }
}

/// It does not: the paper's model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OneWay;

impl Coupling for OneWay {
    #[inline]
    fn is_two_way(&self) -> bool {
        false
    }
}

/// A coupling chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyCoupling {
    /// As [`TwoWay`].
    TwoWay,
    /// As [`OneWay`].
    OneWay,
}

impl Coupling for AnyCoupling {
    #[inline]
    fn is_two_way(&self) -> bool {
        *self == Self::TwoWay
    }
}

/// The parts a bump-stop harvester is made of: one type for each choice.
pub trait Parts<S: Scalar>: Copy + Debug + PartialEq {
    /// The load: a resistance, or a [`FullBridge`] and what it charges.
    type Load: Circuit<S>;
    /// Whether the voltage acts back.
    type Coupling: Coupling;
    /// How beam and rod touch, if they can.
    type Contact: ContactLaw<S>;
}

/// Every choice at run time, with a resistance as the load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AnyParts;

impl<S: Scalar> Parts<S> for AnyParts {
    type Load = AnyLoad<S>;
    type Coupling = AnyCoupling;
    type Contact = AnyContact<S>;
}

/// Every choice at run time, with a bridge as the load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AnyBridgedParts;

impl<S: Scalar> Parts<S> for AnyBridgedParts {
    type Load = FullBridge<S, AnyStorage<S>>;
    type Coupling = AnyCoupling;
    type Contact = AnyContact<S>;
}

/// The stop: a rod that stands on the base, its free face beside the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stop<S> {
    /// Length of the rod in m, 10⁻⁴ to 10.
    pub length: S,
    /// Cross section of the rod in m², 10⁻¹² to 1.
    pub section: S,
    /// Young's modulus of the rod in Pa, 10⁵ to 10¹⁵.
    pub young_modulus: S,
    /// Density of the rod in kg/m³, 1 to 10⁵.
    pub density: S,
    /// Place `X_c` of the contact in m from the clamp, above 0 and at most the length of the beam.
    pub position: S,
    /// Distance `Δ` of beam and rod at rest in m, 0 to 1.
    pub gap: S,
    /// Compliance of the contact itself in m/N, 0 to 1, in series with that of the modes left out.
    pub contact_compliance: S,
}

/// Parameters of a bump-stop harvester, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters<S: Scalar, P: Parts<S>> {
    /// Length `L_b` of the beam in m, 10⁻⁴ to 10.
    pub beam_length: S,
    /// Width of the beam in m, 10⁻⁵ to 10.
    pub beam_width: S,
    /// Substrate; thickness 10⁻⁷ to 1 m, modulus 10⁵ to 10¹⁵ Pa, density 1 to 10⁵ kg/m³.
    pub substrate: Layer<S>,
    /// Piezoelectric layer of the same length and width, with the same bounds.
    pub piezo: Layer<S>,
    /// Piezoelectric constant `d31` in m/V, at most 10⁻⁸ in magnitude.
    pub piezo_d31: S,
    /// Permittivity `ε33` at constant strain in F/m, 10⁻¹² to 10⁻⁶.
    pub piezo_permittivity: S,
    /// Damping ratio `ζ` of every mode, 0 to 0.9: the modes swing.
    pub damping_ratio: S,
    /// The stop; not looked at where the contact law is [`super::NoStop`].
    pub stop: Stop<S>,
    /// Load; a finite resistance must be from 10⁻⁹ to 10³⁰ Ω.
    pub load: P::Load,
    /// Whether the voltage acts back on the beam.
    pub coupling: P::Coupling,
    /// How beam and rod touch.
    pub contact: P::Contact,
}

impl<S: Scalar, P: Parts<S>> Parameters<S, P> {
    /// Checks the parameters and makes the coefficients of `B` beam and `R` rod modes.
    ///
    /// # Errors
    /// The first field that is out of its bounds, with its value.
    pub fn build<const B: usize, const R: usize>(&self) -> Result<BumpStop<S, P, B, R>, ParameterError<S>> {
        self.build_first(B, R)
    }

    /// The same for the first `beam_modes` and `rod_modes` of the capacities `B` and `R`: for a host that
    /// learns the counts at run time. A mode beyond them has coefficients of zero and stays at rest, so the
    /// bits are those of exact capacities.
    ///
    /// # Errors
    /// The first field that is out of its bounds, with its value.
    pub fn build_first<const B: usize, const R: usize>(
        &self,
        beam_modes: usize,
        rod_modes: usize,
    ) -> Result<BumpStop<S, P, B, R>, ParameterError<S>> {
        self.check()?;
        let (beam_modes, rod_modes) = (count(beam_modes, B), count(rod_modes, R));
        let section = Monomorph::new(
            &self.substrate,
            &self.piezo,
            self.beam_width,
            self.piezo_d31,
            self.piezo_permittivity,
        );
        let beam = Cantilever {
            length: self.beam_length,
            bending_stiffness: section.bending_stiffness,
            mass_per_length: section.mass_per_length,
            tip_mass: S::ZERO,
        };
        let possible = P::Contact::POSSIBLE;
        let place = if possible { self.stop.position / self.beam_length } else { S::ONE };
        let mut number = 0;
        let beam_coefficients = [(); B].map(|()| {
            number += 1;
            let mode = beam.mode(number.min(beam_modes.max(1)));
            let tip = mode.shape(S::ONE);
            let taken = if number <= beam_modes { S::ONE } else { S::ZERO };
            BeamCoefficients {
                angular_frequency: mode.angular_frequency,
                base: taken * mode.base_coupling,
                contact: taken * if possible { mode.shape(place).value } else { S::ZERO },
                tip: taken * tip.value,
                voltage: taken * section.coupling * tip.slope / self.beam_length,
            }
        });
        let rod = Rod {
            length: self.stop.length,
            axial_stiffness: self.stop.young_modulus * self.stop.section,
            mass_per_length: self.stop.density * self.stop.section,
        };
        let mut number = 0;
        let rod_coefficients = [(); R].map(|()| {
            number += 1;
            let mode = rod.mode(number.min(rod_modes.max(1)));
            let taken = if number <= rod_modes { S::ONE } else { S::ZERO };
            RodCoefficients {
                angular_frequency: mode.angular_frequency,
                base: taken * mode.base_coupling,
                contact: taken * mode.tip,
            }
        });
        let hertz = |angular: S| angular * S::from_f64(0.5 * core::f64::consts::FRAC_1_PI);
        let frequency = Bounds::new(1e-3, 1e8);
        for mode in &beam_coefficients {
            frequency.check("natural frequency of a beam mode", hertz(mode.angular_frequency))?;
        }
        if possible {
            for mode in &rod_coefficients {
                frequency.check("natural frequency of a rod mode", hertz(mode.angular_frequency))?;
            }
        }
        let (stiffness, gap) = if possible {
            let residual = beam.residual_compliance(place, beam_modes) + rod.residual_compliance(rod_modes);
            (S::ONE / (residual + self.stop.contact_compliance), self.stop.gap)
        } else {
            (S::ZERO, S::ZERO)
        };
        let inverse_mass = beam_coefficients
            .iter()
            .map(|mode| mode.contact)
            .chain(rod_coefficients.iter().map(|mode| mode.contact))
            .fold(S::ZERO, |sum, shape| sum + shape * shape);
        let capacitance = section.capacitance_per_length * self.beam_length;
        Ok(BumpStop {
            beam: beam_coefficients,
            rod: rod_coefficients,
            damping_ratio: self.damping_ratio,
            capacitance,
            elastance: S::ONE / capacitance,
            gap,
            stiffness,
            inverse_mass,
            load: self.load,
            coupling: self.coupling,
            contact: self.contact,
        })
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        Bounds::new(1e-4, 10.0).check("beam_length", self.beam_length)?;
        Bounds::new(1e-5, 10.0).check("beam_width", self.beam_width)?;
        let (thickness, modulus, density) =
            (Bounds::new(1e-7, 1.0), Bounds::new(1e5, 1e15), Bounds::new(1.0, 1e5));
        thickness.check("substrate_thickness", self.substrate.thickness)?;
        modulus.check("substrate_young_modulus", self.substrate.young_modulus)?;
        density.check("substrate_density", self.substrate.density)?;
        thickness.check("piezo_thickness", self.piezo.thickness)?;
        modulus.check("piezo_young_modulus", self.piezo.young_modulus)?;
        density.check("piezo_density", self.piezo.density)?;
        Bounds::new(-1e-8, 1e-8).check("piezo_d31", self.piezo_d31)?;
        Bounds::new(1e-12, 1e-6).check("piezo_permittivity", self.piezo_permittivity)?;
        Bounds::new(0.0, 0.9).check("damping_ratio", self.damping_ratio)?;
        self.load.check()?;
        if !P::Contact::POSSIBLE {
            return Ok(());
        }
        let stop = &self.stop;
        Bounds::new(1e-4, 10.0).check("stop.length", stop.length)?;
        Bounds::new(1e-12, 1.0).check("stop.section", stop.section)?;
        modulus.check("stop.young_modulus", stop.young_modulus)?;
        density.check("stop.density", stop.density)?;
        Bounds { lowest: S::from_f64(1e-4), highest: self.beam_length }
            .check("stop.position", stop.position)?;
        Bounds::new(0.0, 1.0).check("stop.gap", stop.gap)?;
        Bounds::new(0.0, 1.0).check("stop.contact_compliance", stop.contact_compliance)?;
        self.contact.check()
    }
}

/// A number of modes within a capacity.
fn count(modes: usize, capacity: usize) -> u32 {
    u32::try_from(modes.min(capacity)).unwrap_or(u32::MAX)
}
