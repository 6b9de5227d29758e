//! Overlap of two equal discs: how much of the active patch the slider covers.
//!
//! Equations (6) and (7) of Fu, Ouyang and Davis: with `c = |x| / 2r` the covered part of the area is
//! `s1 = (2/π)(arccos c − c √(1−c²))`, the area of the lens over that of a disc, and the rest is
//! `s2 = 1 − s1`. Both have a kink at `x = 0`. So they are taken on one *side* of it, in `y = ± x`, and go
//! on smoothly where `y` is slightly negative: a motion is cut where it passes the middle.

use std::f64::consts::PI;

/// Parts of the area and their change with the displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Overlap {
    /// Part on the active patch, `S1 / S`.
    pub(super) active: f64,
    /// Part on the inert patch, `S2 / S`.
    pub(super) inert: f64,
    /// `d(S1/S)/dx` in 1/m.
    pub(super) slope: f64,
    /// `d²(S1/S)/dx²` in 1/m².
    pub(super) curvature: f64,
}

impl Overlap {
    /// At the displacement `x` in m of discs of the given radius in m; `side` is 1 or −1, the sign of the
    /// displacements that the motion has until it is cut.
    pub(super) fn at(displacement: f64, radius: f64, side: f64) -> Self {
        // The iteration of an implicit step may look past the end of the overlap; what it finds there is
        // finite, and a motion that gets there is refused.
        const END: f64 = 1.0 - 1e-12;
        let ratio = (side * displacement / (2.0 * radius)).min(END);
        let root = ((1.0 - ratio) * (1.0 + ratio)).sqrt();
        Self {
            active: 2.0 / PI * (ratio.acos() - ratio * root),
            // Not as 1 − active, which cancels near the middle.
            inert: 2.0 / PI * (ratio.asin() + ratio * root),
            slope: -side * 2.0 * root / (PI * radius),
            curvature: ratio / (root * PI * radius * radius),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lens_has_its_known_areas_and_slopes() {
        let radius = 10e-3;
        let middle = Overlap::at(0.0, radius, 1.0);
        assert_eq!((middle.active, middle.inert), (1.0, 0.0));
        // Two discs, the centre of one on the edge of the other: 2/3 − √3/(2π) of a disc.
        let edge = Overlap::at(-radius, radius, -1.0);
        assert!((edge.active - (2.0 / 3.0 - 3f64.sqrt() / (2.0 * PI))).abs() < 1e-15);
        let step = 1e-7;
        for (displacement, side) in [(3e-3, 1.0), (-12e-3, -1.0), (19e-3, 1.0), (-1e-4, 1.0)] {
            let [behind, here, ahead] =
                [-step, 0.0, step].map(|shift| Overlap::at(displacement + shift, radius, side));
            let slope = (ahead.active - behind.active) / (2.0 * step);
            let curvature = (ahead.slope - behind.slope) / (2.0 * step);
            assert!((slope / here.slope - 1.0).abs() < 1e-7, "{displacement}");
            assert!((curvature - here.curvature).abs() < 1e-6 * here.curvature.abs() + 1e-4);
            assert!((here.active + here.inert - 1.0).abs() < 1e-15);
        }
    }
}
