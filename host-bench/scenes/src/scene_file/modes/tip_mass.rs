//! Modes of a clamped beam with a rigid body at its free end.
//!
//! With `u = λ x/L` the shape is `p f(u) + q g(u)`, of two solutions of `φ'''' = φ` (by `u`) that are clamped at 0. The
//! body's centre, at the distance `d` beyond the tip, moves by `φ(L) + d φ'(L)`. The beam carries its inertia, the shear
//! force `E I φ''' = −ω² M (φ + d φ')` and the moment `E I φ'' = ω² (I φ' + M d (φ + d φ'))` at the tip, with `I` about the
//! body's own centre. A root is where the two conditions have the determinant 0.
//!
//! Of small `λ` the solutions are the power series of `(cosh u − cos u)/2` and `(sinh u − sin u)/2`, else `e^−u` and
//! `e^(u − λ)` with the circular functions that clamp them. The integrals are by Gauss's rule.

use super::cantilever::series;
use super::{BeamMode, Section, eigenvalue as eigenvalue_of_a_free_end, means};
use crate::root::far_side;
use crate::scene_file::TipMassParameters;

/// `λ` below which the solutions are power series.
const SERIES: f64 = 3.0;
/// Smallest `λ`: a body of a million beams has 0.03.
const LEAST: f64 = 1e-3;
/// First step of the search for sign changes, and how often it is halved while a root is missed.
const STEP: f64 = 0.02;
const HALVINGS: u32 = 10;
/// Pieces of the quadrature: on each the argument of the highest mode grows by 0.5.
const PIECES: u32 = 128;

/// The body in masses and lengths of the beam.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    mass: f64,
    inertia: f64,
    offset: f64,
}

/// `f` and `g` and their first three derivatives by `u`, at `u`.
fn solutions(eigenvalue: f64, u: f64) -> [[f64; 4]; 2] {
    if eigenvalue < SERIES {
        let [zero, one, two, three] = [0, 1, 2, 3].map(|order| series(order, 1.0, u));
        return [[two, one, zero, three], [three, two, one, zero]];
    }
    let (sine, cosine) = u.sin_cos();
    let (falling, rising, edge) = ((-u).exp(), (u - eigenvalue).exp(), (-eigenvalue).exp());
    let falls = [
        falling - cosine + sine,
        -falling + sine + cosine,
        falling + cosine - sine,
        -falling - sine - cosine,
    ];
    let rises = [
        rising - edge * (cosine + sine),
        rising + edge * (sine - cosine),
        rising + edge * (cosine + sine),
        rising - edge * (sine - cosine),
    ];
    [falls, rises]
}

impl Body {
    pub(super) fn new(body: &TipMassParameters, beam_mass: f64, length: f64) -> Self {
        Self {
            mass: body.mass_kg / beam_mass,
            inertia: body.rotary_inertia_kg_m2 / (beam_mass * length * length),
            offset: body.offset_m / length,
        }
    }

    /// What is missing at the tip in shear and in moment, for each solution.
    fn missing(&self, eigenvalue: f64) -> [[f64; 2]; 2] {
        solutions(eigenvalue, eigenvalue).map(|[value, slope, curvature, shear]| {
            let turn = eigenvalue * slope;
            let centre = value + self.offset * turn;
            let moment = self.inertia * turn + self.mass * self.offset * centre;
            [shear + eigenvalue * self.mass * centre, curvature - eigenvalue.powi(2) * moment]
        })
    }

    fn determinant(&self, eigenvalue: f64) -> f64 {
        let [[a, b], [c, d]] = self.missing(eigenvalue);
        a * d - b * c
    }

    /// The first `count` roots.
    ///
    /// A body lowers every frequency: root `i` is not above that of the free end. If a pair of roots between two steps
    /// is missed, a later one is, and the step is halved.
    pub(super) fn eigenvalues(&self, count: usize) -> Vec<f64> {
        let mut step = STEP;
        let mut roots = self.search(count, step);
        for _ in 0..HALVINGS {
            let missed =
                |(index, root): (usize, &f64)| *root > eigenvalue_of_a_free_end(index) * (1.0 + 1e-9);
            if roots.len() == count && !roots.iter().enumerate().any(missed) {
                break;
            }
            step *= 0.5;
            roots = self.search(count, step);
        }
        roots
    }

    fn search(&self, count: usize, step: f64) -> Vec<f64> {
        let last = eigenvalue_of_a_free_end(count.saturating_sub(1)) + STEP;
        let mut roots = Vec::new();
        // Not across the change of the solutions, where the determinant jumps.
        for (from, to) in [(LEAST, SERIES.next_down()), (SERIES, last)] {
            let mut at = from;
            let mut before = self.determinant(at);
            while at < to && roots.len() < count {
                let next = (at + step).min(to);
                let after = self.determinant(next);
                if (before > 0.0) != (after > 0.0) {
                    roots.push(far_side(|u| self.determinant(u), at, next));
                }
                (at, before) = (next, after);
            }
        }
        roots
    }

    /// The mode of a root; `place` is the point of contact over the length.
    pub(super) fn mode(
        &self,
        eigenvalue: f64,
        section: &Section,
        length: f64,
        place: Option<f64>,
    ) -> BeamMode {
        let [[a, b], [c, d]] = self.missing(eigenvalue);
        // Both conditions give the ratio of the two solutions; the larger coefficients give it better.
        let [p, q] = if a.hypot(c) > b.hypot(d) { [c, -a] } else { [d, -b] };
        let shape = |place: f64| {
            let [one, other] = solutions(eigenvalue, eigenvalue * place);
            [0, 1, 2, 3].map(|derivative| p * one[derivative] + q * other[derivative])
        };
        let [mean, mean_square] = means(PIECES, |place| shape(place)[0]);
        let [value, slope, ..] = shape(1.0);
        let turn = eigenvalue * slope;
        let centre = value + self.offset * turn;
        let beam_mass = section.mass_per_length * length;
        let modal = beam_mass * (mean_square + self.mass * centre * centre + self.inertia * turn * turn);
        let [_, _, bend, _] = shape(0.0);
        let scale = modal.sqrt().recip().copysign(bend);
        let wave_number = eigenvalue / length;
        BeamMode {
            eigenvalue,
            angular_frequency: wave_number.powi(2)
                * (section.bending_stiffness / section.mass_per_length).sqrt(),
            participation: scale * beam_mass * (mean + self.mass * centre),
            coupling: section.moment_per_volt * scale * wave_number * slope,
            clamp_curvature: scale * wave_number.powi(2) * bend,
            at_tip: scale * value,
            at_stop: place.map_or(0.0, |place| scale * shape(place)[0]),
        }
    }
}
