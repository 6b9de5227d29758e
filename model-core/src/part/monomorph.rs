//! The cross-section of a monomorph: a substrate and one piezoelectric layer, bonded over the whole length.

use crate::scalar::Scalar;

/// One layer of the cross-section.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Layer<S> {
    /// Thickness `h` in m.
    pub thickness: S,
    /// Young's modulus `E` in Pa, for a piezoelectric layer at constant field.
    pub young_modulus: S,
    /// Density `ρ` in kg/m³.
    pub density: S,
}

/// The properties of the cross-section for beam and circuit.
///
/// The two-way model bends with the short-circuit stiffness; the effect of the field enters by the coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Monomorph<S> {
    /// Bending stiffness `EI` about the neutral axis with short-circuited electrodes, in N·m².
    pub bending_stiffness: S,
    /// Mass per length in kg/m.
    pub mass_per_length: S,
    /// `ν = |e31| w h_pc` in N·m/V: bending moment per voltage, and charge per slope.
    pub coupling: S,
    /// Capacitance per length at constant strain, `ε33 w / h_p`, in F/m.
    pub capacitance_per_length: S,
}

impl<S: Scalar> Monomorph<S> {
    /// From the layers, the width `w` in m, `|d31|` in m/V and `ε33` at constant strain in F/m.
    ///
    /// Distances are measured from the interface, to avoid cancellation.
    #[must_use]
    pub fn new(substrate: &Layer<S>, piezo: &Layer<S>, width: S, d31: S, permittivity: S) -> Self {
        let half = S::from_f64(0.5);
        let stiffness = |layer: &Layer<S>| layer.young_modulus * layer.thickness;
        let (below, above) = (stiffness(substrate), stiffness(piezo));
        // The neutral axis divides the distance of the mid-planes in proportion to the stiffnesses.
        let distance = half * (substrate.thickness + piezo.thickness);
        let per_total = S::ONE / (below + above);
        let (to_piezo, to_substrate) = (distance * below * per_total, distance * above * per_total);
        let twelfth = S::from_f64(1.0 / 12.0);
        let own = |layer: &Layer<S>, arm: S| {
            stiffness(layer) * (twelfth * layer.thickness * layer.thickness + arm * arm)
        };
        Self {
            bending_stiffness: width * (own(substrate, to_substrate) + own(piezo, to_piezo)),
            mass_per_length: width
                * (substrate.density * substrate.thickness + piezo.density * piezo.thickness),
            coupling: piezo.young_modulus * d31.abs() * width * to_piezo,
            capacitance_per_length: permittivity * width / piezo.thickness,
        }
    }

    /// Distances in m of the outer faces of substrate and piezoelectric layer from the neutral axis.
    #[must_use]
    pub(crate) fn outer_distances(substrate: &Layer<S>, piezo: &Layer<S>) -> [S; 2] {
        let half = S::from_f64(0.5);
        let [below, above] = [substrate, piezo].map(|layer| layer.young_modulus * layer.thickness);
        let distance = half * (substrate.thickness + piezo.thickness) / (below + above);
        [half * substrate.thickness + distance * above, half * piezo.thickness + distance * below]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::beam::Cantilever;

    fn close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() < relative, "{value} is not {expected} within {relative}");
    }

    #[test]
    fn steel_and_pzt_5a_have_their_known_section() {
        let substrate = Layer { thickness: 0.5e-3, young_modulus: 200e9, density: 7850.0 };
        let piezo = Layer { thickness: 0.5e-3, young_modulus: 66e9, density: 7800.0 };
        let section = Monomorph::new(&substrate, &piezo, 10e-3, -190e-12, 15.93e-9);
        close(section.bending_stiffness, 0.089_738_408_5, 1e-9);
        close(section.mass_per_length, 0.078_25, 1e-12);
        close(section.coupling, 4.714_285_71e-5, 1e-9);
        close(section.capacitance_per_length * 0.05, 15.93e-9, 1e-12);
        // The neutral axis is 0.374060150 mm above the lower face.
        let [below, above] = Monomorph::outer_distances(&substrate, &piezo);
        close(below, 0.374_060_150e-3, 1e-8);
        close(above, 0.625_939_850e-3, 1e-8);
    }

    #[test]
    fn the_unimorph_of_erturk_and_inman_has_its_published_frequencies() {
        // Erturk and Inman 2008: 100 × 20 mm, 0.5 mm substrate, 0.4 mm PZT-5A; short circuit 47.8, 299.6 Hz.
        let substrate = Layer { thickness: 0.5e-3, young_modulus: 100e9, density: 7165.0 };
        let piezo = Layer { thickness: 0.4e-3, young_modulus: 66e9, density: 7800.0 };
        let section = Monomorph::new(&substrate, &piezo, 20e-3, -190e-12, 15.93e-9);
        close(section.bending_stiffness, 0.097_847, 1e-5);
        close(section.capacitance_per_length * 0.1, 79.65e-9, 1e-9);
        let beam = Cantilever {
            length: 0.1,
            bending_stiffness: section.bending_stiffness,
            mass_per_length: section.mass_per_length,
            tip_mass: 0.0,
        };
        for (number, published) in [(1, 47.8), (2, 299.6)] {
            let frequency = beam.mode(number).angular_frequency / core::f64::consts::TAU;
            assert!((frequency - published).abs() < 0.05, "{number} {frequency}");
        }
    }
}
