//! Computes the overlap of two discs of equal radius.
//!
//! Discs of radius `r` with centres at the distance `x` share a lens of area `S1 = 2 r² arccos(|x|/2r) − (|x|/2)
//! √(4r² − x²)` (equation (6) of Fu, Ouyang and Davis 2020, as derived from the geometry). Areas are relative to the
//! disc, `s1 = S1/(π r²)` and `s2 = 1 − s1`, as functions of `ξ = x/2r` on one side of the centre:
//!
//! ```text
//! s2 = (2/π) (arcsin ξ + ξ √(1 − ξ²))          ds1/dξ = −(4/π) √(1 − ξ²)
//! ```
//!
//! The area has a corner at `x = 0`. The formula of each side is analytic through `x = 0`, with `s2` odd in
//! `ξ`: a step that ends slightly beyond the centre has no corner.

#[cfg(test)]
use crate::scalar::arcsine;
use crate::scalar::{Scalar, horner};

/// Parts of a disc's face over the active disc and beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DiscOverlap<S> {
    /// `s1 = S1/(π r²)`, over the active disc: 1 for coinciding discs, 0 for separate discs.
    pub active: S,
    /// `s2 = 1 − s1`, beside the active disc.
    pub inert: S,
}

/// Below this `ξ²`, the terms of `s2/ξ` beyond the first five are below a rounding of `f64`.
const NARROW: f64 = 1e-3;
/// Up to this `ξ`, `s2/ξ` is a polynomial in `ξ²`; beyond it, `s1/(1 − ξ)^{3/2}` is a polynomial in `1 − ξ`,
/// because `s1` has a branch point at `ξ = 1` that a plain polynomial does not follow.
const JOINT_F32: f64 = 0.8;
/// `s2/ξ` in `ξ²`, `ξ ≤ 0.8`: relative error 7.7e-8.
const INNER_F32: [f64; 7] = [
    1.273_239_446_918_015_5,
    -0.212_193_080_127_217_91,
    -0.032_135_557_479_860_604,
    -0.008_822_996_737_382_160_9,
    -0.015_374_313_764_700_239,
    0.015_210_057_824_473_464,
    -0.016_356_405_419_960_041,
];
/// `s1/(1 − ξ)^{3/2}` in `1 − ξ ≤ 0.2`: relative error 1e-8.
const OUTER_F32: [f64; 4] = [
    1.200_421_766_708_020_6,
    -0.180_065_115_057_942_99,
    -0.016_031_806_605_457_848,
    -0.003_476_187_440_326_967_4,
];
/// The joint in double precision: a larger `ξ` would need twice the terms.
const JOINT_F64: f64 = 0.5;
/// `s2/ξ` in `ξ²`, `ξ ≤ 0.5`: relative error 5.2e-19.
const INNER_F64: [f64; 13] = [
    1.273_239_544_735_162_685_5,
    -0.212_206_590_789_192_900_2,
    -0.031_830_988_618_572_390_98,
    -0.011_368_210_204_189_131_662,
    -0.005_526_214_046_735_037_903_7,
    -0.003_164_993_297_437_642_713_6,
    -0.002_008_901_732_023_943_987_3,
    -0.001_363_939_039_566_899_845,
    -0.001_009_720_947_170_145_332_7,
    -0.000_579_332_666_990_159_131_18,
    -0.001_083_171_704_490_261_132_4,
    0.000_657_994_112_553_914_745_6,
    -0.001_559_407_196_284_648_242,
];
/// `s1/(1 − ξ)^{3/2}` in `1 − ξ ≤ 0.5`: relative error 2.5e-17.
const OUTER_F64: [f64; 12] = [
    1.200_421_754_876_141_456_6,
    -0.180_063_263_231_438_337_4,
    -0.016_077_077_072_640_884_874,
    -0.003_126_098_378_014_754_789_9,
    -0.000_799_285_412_070_473_126_81,
    -0.000_236_723_824_002_605_463_92,
    -0.000_076_847_242_999_160_888_285,
    -0.000_027_050_739_561_540_335_413,
    -8.541_054_906_070_514_051e-6,
    -5.893_457_458_391_934_946_2e-6,
    1.226_160_428_708_894_293_2e-6,
    -2.166_779_630_309_654_658_8e-6,
];

impl<S: Scalar> DiscOverlap<S> {
    /// The overlap for a step: `s2` to 1.5e-7 relative in `f32` up to `ξ = 0.8` and `s1` to 3e-7 beyond, both
    /// to a few roundings in `f64`. No square root up to the joint.
    ///
    /// `xi` is `x/2r` on the side in question, −0.8 to 1. Beyond 1, where the discs are separate, `s1` has
    /// the smallest value that is a valid divisor.
    #[inline]
    pub(crate) fn at(xi: S) -> Self {
        if S::IS_DOUBLE {
            Self::in_two_pieces(xi, JOINT_F64, (&INNER_F64, 5), &OUTER_F64)
        } else {
            Self::in_two_pieces(xi, JOINT_F32, (&INNER_F32, 0), &OUTER_F32)
        }
    }

    #[inline]
    fn in_two_pieces<const I: usize, const O: usize>(
        xi: S,
        joint: f64,
        (inner, narrow): (&[f64; I], usize),
        outer: &[f64; O],
    ) -> Self {
        if xi > S::from_f64(joint) {
            Self::outer_piece(xi, outer)
        } else {
            let (terms, square) = (inner.map(S::from_f64), xi * xi);
            let (lower, higher) = terms.split_at_checked(narrow).unwrap_or_default();
            let is_narrow = narrow > 0 && square < S::from_f64(NARROW);
            let higher = if is_narrow { S::ZERO } else { horner(higher, square) };
            let inert = xi * lower.iter().rev().fold(higher, |sum, &term| sum * square + term);
            Self { active: S::ONE - inert, inert }
        }
    }

    /// Outlined: a wide motion is rare, and the compiler would otherwise evaluate this square root for every motion.
    #[cold]
    #[inline(never)]
    fn outer_piece<const O: usize>(xi: S, outer: &[f64; O]) -> Self {
        let rest = (S::ONE - xi).max(S::EPSILON);
        let active = rest * rest.sqrt() * horner(&outer.map(S::from_f64), rest);
        Self { active, inert: S::ONE - active }
    }

    /// The exact overlap, to a few roundings of both parts, in about a hundred operations. `xi` is clamped to 0 … 1.
    #[cfg(test)]
    pub(crate) fn exact(xi: S) -> Self {
        let xi = xi.max(S::ZERO).min(S::ONE);
        let half = S::from_f64(0.5);
        let two_over_pi = S::from_f64(core::f64::consts::FRAC_2_PI);
        let chord = ((S::ONE - xi) * (S::ONE + xi)).sqrt();
        if xi <= half {
            let inert = two_over_pi * (arcsine(xi) + xi * chord);
            return Self { active: S::ONE - inert, inert };
        }
        // s1 = (φ − sin φ)/π with φ = 2 arccos ξ and sin φ = 2 ξ √(1 − ξ²). The difference cancels for small
        // φ; its series is summed there.
        let angle = S::from_f64(4.0) * arcsine((half * (S::ONE - xi)).sqrt());
        let difference = if angle > S::ONE {
            angle - S::from_f64(2.0) * xi * chord
        } else {
            let square = angle * angle;
            let mut term = angle * square * S::from_f64(1.0 / 6.0);
            let mut sum = term;
            for n in 2..12_u32 {
                term = -term * square / S::from_u32(2 * n * (2 * n + 1));
                sum += term;
            }
            sum
        };
        let active = half * two_over_pi * difference;
        Self { active, inert: S::ONE - active }
    }

    /// [`DiscOverlap::active_by_xi`] by three terms of its series: without a square root, to 4 % up to `ξ = 0.8`.
    #[inline]
    pub(crate) fn rough_active_by_xi(xi: S) -> S {
        let square = xi * xi;
        let root = S::ONE - square * (S::from_f64(0.5) + S::from_f64(0.125) * square);
        S::from_f64(-2.0 * core::f64::consts::FRAC_2_PI) * root
    }

    /// `ds1/dξ = −(4/π) √(1 − ξ²)` on the side in question; 0 for separate discs.
    #[inline]
    pub(crate) fn active_by_xi(xi: S) -> S {
        S::from_f64(-2.0 * core::f64::consts::FRAC_2_PI) * ((S::ONE - xi) * (S::ONE + xi)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lens by the standard library's arccosine; it loses digits of `s1` towards `ξ = 1`.
    fn lens(xi: f64) -> f64 {
        core::f64::consts::FRAC_2_PI * (xi.acos() - xi * (1.0 - xi * xi).sqrt())
    }

    #[test]
    fn the_exact_form_is_the_lens() {
        for k in 0..=4000 {
            let xi = f64::from(k) / 4000.0;
            let exact = DiscOverlap::<f64>::exact(xi);
            assert!((exact.active - lens(xi)).abs() < 1e-15, "{xi}");
            assert!((exact.active + exact.inert - 1.0).abs() < 1e-15);
        }
        // Published: at x = r the lens is 0.391002 of the disc.
        assert!((DiscOverlap::<f64>::exact(0.5).active - 0.391_002).abs() < 5e-7);
        assert_eq!(DiscOverlap::<f64>::exact(0.0).active, 1.0);
        assert_eq!(DiscOverlap::<f64>::exact(1.0).active, 0.0);
        assert_eq!(DiscOverlap::<f64>::exact(1.5).active, 0.0);
    }

    #[test]
    fn towards_parting_the_exact_form_follows_its_own_expansion() {
        // s1 = (8 √2/3π) w^{3/2} (1 − 3w/20 − …) with w = 1 − ξ.
        for w in [1e-3_f64, 1e-5, 1e-8] {
            let leading = 8.0 * 2f64.sqrt() / (3.0 * core::f64::consts::PI) * w.powf(1.5);
            let expected = leading * (1.0 - 0.15 * w);
            let exact = DiscOverlap::<f64>::exact(1.0 - w).active;
            // 1 − w itself has a rounding error of 1.
            let tolerance = 0.02 * w * w + 3e-16 / w;
            assert!((exact / expected - 1.0).abs() < tolerance, "{w}: {exact} {expected}");
        }
    }

    #[test]
    fn the_form_of_a_step_is_exact_to_its_stated_error_over_the_whole_domain() {
        let (mut single, mut double) = (0.0_f64, 0.0_f64);
        for k in 1..20_000 {
            let xi = f64::from(k as f32 / 20_000.0);
            let exact = DiscOverlap::<f64>::exact(xi);
            let small = DiscOverlap::<f32>::at(xi as f32);
            let large = DiscOverlap::<f64>::at(xi);
            let relative = |value: f64, expected: f64| (value / expected - 1.0).abs();
            single = single.max(relative(f64::from(small.inert), exact.inert)).max(
                if xi > f64::from(JOINT_F32 as f32) {
                    relative(f64::from(small.active), exact.active)
                } else {
                    0.0
                },
            );
            double = double.max(relative(large.inert, exact.inert)).max(if xi > 0.5 {
                relative(large.active, exact.active)
            } else {
                0.0
            });
        }
        assert!(single < 3e-7, "{single}");
        assert!(double < 1e-14, "{double}");
    }

    #[test]
    fn each_side_is_odd_through_the_centre_and_its_slope_is_the_chord() {
        let (ahead, behind) = (DiscOverlap::<f64>::at(0.01), DiscOverlap::<f64>::at(-0.01));
        assert_eq!(ahead.inert, -behind.inert);
        for xi in [-0.1_f64, 0.0, 0.3, 0.49, 0.51, 0.9, 0.99] {
            let step = 1e-6;
            let slope =
                (DiscOverlap::at(xi + step).active - DiscOverlap::at(xi - step).active) / (2.0 * step);
            assert!((slope - DiscOverlap::active_by_xi(xi)).abs() < 2e-9, "{xi}");
        }
    }

    #[test]
    fn apart_there_is_nothing_left_but_it_can_be_divided_by() {
        let apart = DiscOverlap::<f32>::at(3.0);
        assert!(apart.active > 0.0 && apart.active < 1e-9);
        assert_eq!(DiscOverlap::<f32>::active_by_xi(3.0), 0.0);
    }
}
