//! Parameters, and the coefficients derived from them.

use super::circuit::Circuit;
use super::stop::StopChoice;
use super::tip_mass::TipMassChoice;
use super::{BeamCoefficients, BumpStop, Choices, Parts, RodCoefficients};
use crate::bounds::{Bounds, ParameterError, parameters};
use crate::part::beam::{BeamMode, Cantilever};
use crate::part::monomorph::{Layer, Section, Transducer as _};
use crate::part::rod::Rod;
use crate::scalar::Scalar;

/// Parameters of a bump-stop harvester, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters<S, C> {
    /// Length `L_b` of the beam in m, 10⁻⁴ to 10.
    pub beam_length: S,
    /// Width of the beam in m, 10⁻⁵ to 10.
    pub beam_width: S,
    /// Substrate; thickness 10⁻⁷ to 1 m, modulus 10⁵ to 10¹⁵ Pa, density 1 to 10⁵ kg/m³.
    pub substrate: Layer<S>,
    /// Piezoelectric layer, of a bimorph each of the two, of the same length and width, with the same bounds.
    pub piezo: Layer<S>,
    /// Piezoelectric constant `d31` in m/V, at most 10⁻⁸ in magnitude.
    pub piezo_d31: S,
    /// Permittivity `ε33` at constant strain in F/m, 10⁻¹² to 10⁻⁶.
    pub piezo_permittivity: S,
    /// Damping ratio `ζ` of every mode, 0 to 0.9 (underdamped).
    pub damping_ratio: S,
    /// The components: [`Choices`].
    pub choices: C,
}

/// Checks that a natural frequency is from 10⁻³ to 10⁸ Hz.
fn check_frequency<S: Scalar>(field: &'static str, angular_frequency: S) -> Result<(), ParameterError<S>> {
    let frequency = angular_frequency * S::from_f64(0.5 * core::f64::consts::FRAC_1_PI);
    Bounds::new(1e-3, 1e8).check(field, frequency)
}

parameters! { $ bump_stop_numbers for Parameters<S, C> {
    "beam_length" = beam_length: beam_length_m "m" 1e-4..=10.0
        "Flexible length: to the tip mass where there is one" "mode frequencies 1e-2 to 1e8 Hz";
    "beam_width" = beam_width: beam_width_m "m" 1e-5..=10.0 "Width of the cantilever";
    "substrate_thickness" = substrate.thickness: substrate_thickness_m "m" 1e-7..=1.0 "Thickness of the substrate";
    "substrate_young_modulus" = substrate.young_modulus: substrate_young_modulus_pa "Pa" 1e5..=1e15
        "Young's modulus of the substrate";
    "substrate_density" = substrate.density: substrate_density_kg_per_m3 "kg/m³" 1.0..=1e5 "Density of the substrate";
    "piezo_thickness" = piezo.thickness: piezo_thickness_m "m" 1e-7..=1.0 "Thickness of the piezoelectric layer";
    "piezo_young_modulus" = piezo.young_modulus: piezo_young_modulus_pa "Pa" 1e5..=1e15
        "Young's modulus of the layer, short circuit";
    "piezo_density" = piezo.density: piezo_density_kg_per_m3 "kg/m³" 1.0..=1e5 "Density of the piezoelectric layer";
    "piezo_d31" = piezo_d31: piezo_d31_m_per_v "m/V" -1e-8..=1e-8 "Piezoelectric constant d31; its sign does not matter";
    "piezo_permittivity" = piezo_permittivity: piezo_permittivity_f_per_m "F/m" 1e-12..=1e-6
        "Permittivity ε33 at constant strain";
    "damping_ratio" = damping_ratio: damping_ratio "1" 0.0..=0.9 "Damping ratio of every mode of cantilever and rod";
} }

impl<S: Scalar, C> Parameters<S, C> {
    /// Checks the parameters and computes the coefficients of `B` beam modes, at least 1, and `R` rod modes.
    ///
    /// # Errors
    /// The first field outside its bounds, with its value.
    pub fn build<const B: usize, const R: usize>(&self) -> Result<BumpStop<S, C, B, R>, ParameterError<S>>
    where
        C: Parts<S>,
    {
        self.build_modes(None)
    }

    /// As [`Parameters::build`] with the first `beam` and `rod` modes only, for mode counts known at run time.
    /// Further modes have zero coefficients and stay at rest; the bits are those of a type with exactly these modes.
    ///
    /// # Errors
    /// As [`Parameters::build`].
    pub fn build_first<const B: usize, const R: usize>(
        &self,
        beam: usize,
        rod: usize,
    ) -> Result<BumpStop<S, C, B, R>, ParameterError<S>>
    where
        C: Parts<S>,
    {
        self.build_modes(Some([beam, rod]))
    }

    // Inlined: firmware, which uses all modes, then compiles no code for fewer.
    #[inline]
    fn build_modes<const B: usize, const R: usize>(
        &self,
        modes: Option<[usize; 2]>,
    ) -> Result<BumpStop<S, C, B, R>, ParameterError<S>>
    where
        C: Parts<S>,
    {
        self.check()?;
        let &Choices { load, stop, coupling, tip_mass, .. } = self.choices.choices();
        let [beam_modes, rod_modes] = mode_counts(modes, [B, R])?;
        let section = self.section();
        let beam = self.cantilever(&section);
        let (contact, stop) = (stop.contact(), stop.stop());
        let place = stop.map(|stop| stop.position / self.beam_length);
        let rod = stop.map(|stop| stop.rod());
        let beam_coefficients = beam_coefficients(&beam, &tip_mass, section.coupling, place, beam_modes);
        let rod_coefficients = rod_coefficients(rod.as_ref(), rod_modes);
        for mode in &beam_coefficients {
            check_frequency("natural frequency of a beam mode", mode.angular_frequency)?;
        }
        for mode in rod_coefficients.iter().filter(|_| rod.is_some()) {
            check_frequency("natural frequency of a rod mode", mode.angular_frequency)?;
        }
        let stiffness = match (stop, place, rod) {
            (Some(stop), Some(place), Some(rod)) => {
                let residual = tip_mass.residual_compliance(&beam, place, beam_modes)
                    + rod.residual_compliance(rod_modes);
                S::ONE / (residual + stop.contact_compliance)
            }
            _ => S::ZERO,
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
            gap: stop.map_or(S::ZERO, |stop| stop.gap),
            stiffness,
            inverse_mass,
            load,
            coupling,
            contact,
        })
    }

    /// The cross-section of the beam.
    #[must_use]
    pub fn section(&self) -> Section<S>
    where
        C: Parts<S>,
    {
        let Self { substrate, piezo, beam_width, piezo_d31, piezo_permittivity, .. } = self;
        let transducer = self.choices.choices().transducer;
        transducer.section([substrate, piezo], *beam_width, *piezo_d31, *piezo_permittivity)
    }

    /// The beam with a free end.
    #[inline]
    pub(super) fn cantilever(&self, section: &Section<S>) -> Cantilever<S> {
        Cantilever {
            length: self.beam_length,
            bending_stiffness: section.bending_stiffness,
            mass_per_length: section.mass_per_length,
            tip_mass: S::ZERO,
        }
    }

    /// Mode `number` of the beam with its tip mass, from 1, for parameters that [`Parameters::build`] accepts.
    #[must_use]
    pub fn beam_mode(&self, number: u32) -> BeamMode<S>
    where
        C: Parts<S>,
    {
        self.choices.choices().tip_mass.mode(&self.cantilever(&self.section()), number)
    }

    fn check(&self) -> Result<(), ParameterError<S>>
    where
        C: Parts<S>,
    {
        let Choices { load, stop, tip_mass, .. } = self.choices.choices();
        self.check_numbers()?;
        load.check()?;
        tip_mass.check(&self.cantilever(&self.section()))?;
        stop.stop().map_or(Ok(()), |stop| stop.check(self.beam_length))
    }
}

/// The numbers of beam and rod modes, at most those of the harvester's type.
#[inline]
fn mode_counts<S: Scalar>(
    modes: Option<[usize; 2]>,
    room: [usize; 2],
) -> Result<[u32; 2], ParameterError<S>> {
    let [beam_room, rod_room] = room.map(|count| u32::try_from(count).unwrap_or(u32::MAX));
    let [beam, rod] = modes.unwrap_or(room).map(|count| u32::try_from(count).unwrap_or(u32::MAX));
    let number = S::from_u32;
    Bounds { lowest: S::ONE, highest: number(beam_room.max(1)) }.check("beam_modes", number(beam))?;
    Bounds { lowest: S::ZERO, highest: number(rod_room) }.check("rod_modes", number(rod))?;
    Ok([beam, rod])
}

/// Coefficients of the first `count` modes, at least one; `place` is the position of the stop over the length.
#[inline(always)]
fn beam_coefficients<S: Scalar, M: TipMassChoice<S>, const B: usize>(
    beam: &Cantilever<S>,
    tip_mass: &M,
    coupling: S,
    place: Option<S>,
    count: u32,
) -> [BeamCoefficients<S>; B] {
    let zero = BeamCoefficients {
        angular_frequency: S::ONE,
        base: S::ZERO,
        contact: S::ZERO,
        tip: S::ZERO,
        voltage: S::ZERO,
    };
    let mut coefficients = [zero; B];
    for (number, coefficient) in (1..=B as u32).zip(&mut coefficients) {
        let mode = tip_mass.mode(beam, number.min(count));
        let tip = mode.shape(S::ONE);
        let taken = if number <= count { S::ONE } else { S::ZERO };
        *coefficient = BeamCoefficients {
            angular_frequency: mode.angular_frequency,
            base: taken * mode.base_coupling,
            contact: taken * place.map_or(S::ZERO, |place| mode.shape(place).value),
            tip: taken * tip.value,
            voltage: taken * coupling * tip.slope / beam.length,
        };
    }
    coefficients
}

/// Coefficients of the first `count` modes; zeros without a rod.
#[inline(always)]
fn rod_coefficients<S: Scalar, const R: usize>(rod: Option<&Rod<S>>, count: u32) -> [RodCoefficients<S>; R] {
    let absent = RodCoefficients { angular_frequency: S::ONE, base: S::ZERO, contact: S::ZERO };
    let mut coefficients = [absent; R];
    let Some(rod) = rod else { return coefficients };
    for (number, coefficient) in (1..=R as u32).zip(&mut coefficients) {
        let mode = rod.mode(number.min(count));
        let taken = if number <= count { S::ONE } else { S::ZERO };
        *coefficient = RodCoefficients {
            angular_frequency: mode.angular_frequency,
            base: taken * mode.base_coupling,
            contact: taken * mode.tip,
        };
    }
    coefficients
}
