//! The cross-section of a monomorph or bimorph: a substrate and one or two piezoelectric layers, bonded over the whole length.

use core::fmt::Debug;

use crate::forward;
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
pub struct Section<S> {
    /// Bending stiffness `EI` about the neutral axis with short-circuited electrodes, in N·m².
    pub bending_stiffness: S,
    /// Mass per length in kg/m.
    pub mass_per_length: S,
    /// `ν` in N·m/V: bending moment per voltage, and charge per slope; of one layer `|e31| w h_pc`.
    pub coupling: S,
    /// Capacitance per length at constant strain in F/m; of one layer `ε33 w / h_p`.
    pub capacitance_per_length: S,
}

/// The piezoelectric layers and their connection.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not say which piezoelectric layers there are",
    note = "a transducer is `Monomorph`, `Bimorph` or `Option<Bimorph>`"
)]
pub(crate) trait Transducer<S: Scalar>: Copy + Debug + PartialEq {
    /// From the layers, the width `w` in m, `|d31|` in m/V and `ε33` at constant strain in F/m.
    fn section(&self, layers: [&Layer<S>; 2], width: S, d31: S, permittivity: S) -> Section<S>;

    /// Distances in m of the outer faces of substrate and piezoelectric layer from the neutral axis.
    fn outer_distances(&self, layers: [&Layer<S>; 2]) -> [S; 2];
}

/// One piezoelectric layer on one side of the substrate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Monomorph;

impl<S: Scalar> Transducer<S> for Monomorph {
    /// Distances are measured from the interface, to avoid cancellation.
    fn section(&self, [substrate, piezo]: [&Layer<S>; 2], width: S, d31: S, permittivity: S) -> Section<S> {
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
        Section {
            bending_stiffness: width * (own(substrate, to_substrate) + own(piezo, to_piezo)),
            mass_per_length: width
                * (substrate.density * substrate.thickness + piezo.density * piezo.thickness),
            coupling: piezo.young_modulus * d31.abs() * width * to_piezo,
            capacitance_per_length: permittivity * width / piezo.thickness,
        }
    }

    fn outer_distances(&self, [substrate, piezo]: [&Layer<S>; 2]) -> [S; 2] {
        let half = S::from_f64(0.5);
        let [below, above] = [substrate, piezo].map(|layer| layer.young_modulus * layer.thickness);
        let distance = half * (substrate.thickness + piezo.thickness) / (below + above);
        [half * substrate.thickness + distance * above, half * piezo.thickness + distance * below]
    }
}

/// Two piezoelectric layers, by the connection of their electrodes. Each has the properties of the one layer of a [`Monomorph`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Bimorph {
    /// In series: poled oppositely, with half the terminal voltage across each layer.
    Series,
    /// In parallel: poled alike, with the terminal voltage across each layer.
    Parallel,
}

impl<S: Scalar> Transducer<S> for Bimorph {
    /// The neutral axis is the middle of the substrate.
    fn section(&self, [substrate, piezo]: [&Layer<S>; 2], width: S, d31: S, permittivity: S) -> Section<S> {
        let [half, two] = [0.5, 2.0].map(S::from_f64);
        let arm = half * (substrate.thickness + piezo.thickness);
        let twelfth = S::from_f64(1.0 / 12.0);
        let own = |layer: &Layer<S>, square: S| {
            layer.young_modulus * layer.thickness * (twelfth * layer.thickness * layer.thickness + square)
        };
        let coupling = piezo.young_modulus * d31.abs() * width * arm;
        let capacitance = permittivity * width / piezo.thickness;
        let (coupling, capacitance_per_length) = match self {
            Self::Series => (coupling, half * capacitance),
            Self::Parallel => (two * coupling, two * capacitance),
        };
        Section {
            bending_stiffness: width * (own(substrate, S::ZERO) + two * own(piezo, arm * arm)),
            mass_per_length: width
                * (substrate.density * substrate.thickness + two * piezo.density * piezo.thickness),
            coupling,
            capacitance_per_length,
        }
    }

    fn outer_distances(&self, [substrate, piezo]: [&Layer<S>; 2]) -> [S; 2] {
        let interface = S::from_f64(0.5) * substrate.thickness;
        [interface, interface + piezo.thickness]
    }
}

/// Layers chosen at run time. `None` gives the bits of [`Monomorph`].
impl<S: Scalar> Transducer<S> for Option<Bimorph> {
    forward! {
        match { Some(bimorph) => bimorph, None => Monomorph }
        fn section(&self, layers: [&Layer<S>; 2], width: S, d31: S, permittivity: S) -> Section<S>;
        fn outer_distances(&self, layers: [&Layer<S>; 2]) -> [S; 2];
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
        let section = Monomorph.section([&substrate, &piezo], 10e-3, -190e-12, 15.93e-9);
        close(section.bending_stiffness, 0.089_738_408_5, 1e-9);
        close(section.mass_per_length, 0.078_25, 1e-12);
        close(section.coupling, 4.714_285_71e-5, 1e-9);
        close(section.capacitance_per_length * 0.05, 15.93e-9, 1e-12);
        // The neutral axis is 0.374060150 mm above the lower face.
        let [below, above] = Monomorph.outer_distances([&substrate, &piezo]);
        close(below, 0.374_060_150e-3, 1e-8);
        close(above, 0.625_939_850e-3, 1e-8);
    }

    #[test]
    fn the_unimorph_of_erturk_and_inman_has_its_published_frequencies() {
        // Erturk and Inman 2008: 100 × 20 mm, 0.5 mm substrate, 0.4 mm PZT-5A; short circuit 47.8, 299.6 Hz.
        let substrate = Layer { thickness: 0.5e-3, young_modulus: 100e9, density: 7165.0 };
        let piezo = Layer { thickness: 0.4e-3, young_modulus: 66e9, density: 7800.0 };
        let section = Monomorph.section([&substrate, &piezo], 20e-3, -190e-12, 15.93e-9);
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

    const BRASS: Layer<f64> = Layer { thickness: 0.14e-3, young_modulus: 105e9, density: 9000.0 };
    const PZT_5A: Layer<f64> = Layer { thickness: 0.26e-3, young_modulus: 66e9, density: 7800.0 };

    fn of<T: Transducer<f64>>(transducer: T, substrate: Layer<f64>, piezo: Layer<f64>) -> Section<f64> {
        transducer.section([&substrate, &piezo], 31.8e-3, -190e-12, 13.281_281_719e-9)
    }

    /// The numbers of an independent program with the parameters of Erturk and Inman, Smart Mater. Struct. 18 (2009) 025009.
    #[test]
    fn the_bimorph_of_erturk_and_inman_has_its_known_section_and_frequencies() {
        let [series, parallel] = [Bimorph::Series, Bimorph::Parallel].map(|of_two| of(of_two, BRASS, PZT_5A));
        close(series.capacitance_per_length * 50.8e-3, 41.259_83e-9, 1e-6);
        close(series.coupling, 7.975_44e-5, 1e-9);
        close(parallel.capacitance_per_length, 4.0 * series.capacitance_per_length, 1e-15);
        close(parallel.coupling, 2.0 * series.coupling, 1e-15);
        let [outer, inner] = [0.33e-3_f64, 0.07e-3].map(|distance| distance.powi(3));
        close(
            series.bending_stiffness,
            2.0 / 3.0 * 31.8e-3 * (105e9 * inner + 66e9 * (outer - inner)),
            1e-13,
        );
        close(series.mass_per_length, 31.8e-3 * (9000.0 * 0.14e-3 + 2.0 * 7800.0 * 0.26e-3), 1e-15);
        let beam = Cantilever {
            length: 50.8e-3,
            bending_stiffness: series.bending_stiffness,
            mass_per_length: series.mass_per_length,
            tip_mass: 12e-3,
        };
        for (number, expected) in [(1, 45.7032), (2, 540.855), (3, 1708.265), (4, 3539.568)] {
            close(beam.mode(number).angular_frequency / core::f64::consts::TAU, expected, 1e-6);
        }
        assert_eq!(Bimorph::Series.outer_distances([&BRASS, &PZT_5A]), [0.07e-3, 0.33e-3]);
    }

    /// Two layers without a substrate are one of twice the thickness.
    #[test]
    fn without_a_substrate_it_is_a_plate_of_both_layers() {
        let section = of(Bimorph::Parallel, Layer { thickness: 1e-15, ..BRASS }, PZT_5A);
        close(section.bending_stiffness, 66e9 * 31.8e-3 * 0.52e-3_f64.powi(3) / 12.0, 1e-9);
        close(section.coupling, 66e9 * 190e-12 * 31.8e-3 * 0.26e-3, 1e-9);
    }

    /// Thin layers add to the substrate: two in parallel have twice the stiffness, coupling and capacitance of one, in
    /// series half of what is electric, and of the capacitance a quarter.
    #[test]
    fn thin_layers_are_those_of_a_monomorph() {
        let thin = Layer { thickness: 1e-10, ..PZT_5A };
        let [one, series, parallel] = [None, Some(Bimorph::Series), Some(Bimorph::Parallel)];
        let [one, series, parallel] = [one, series, parallel].map(|layers| of(layers, BRASS, thin));
        let bare = 105e9 * 31.8e-3 * BRASS.thickness.powi(3) / 12.0;
        close(parallel.bending_stiffness - bare, 2.0 * (one.bending_stiffness - bare), 1e-5);
        close(parallel.coupling, 2.0 * one.coupling, 1e-5);
        close(series.coupling, one.coupling, 1e-5);
        close(parallel.capacitance_per_length, 2.0 * one.capacitance_per_length, 1e-15);
        close(series.capacitance_per_length, 0.5 * one.capacitance_per_length, 1e-15);
    }
}
