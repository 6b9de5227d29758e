//! Computes the modes of a cantilever with a rigid body at its tip.
//!
//! The body has the mass `M`, the rotary inertia `I` about its own centre, and its centre at the distance `d` beyond the
//! tip, on the axis of the beam. Its centre moves by `y(L) + d y'(L)` and it turns by `y'(L)`. Shear and moment at the
//! tip follow, with `μ = M/m_b`, `e = d/L`, `ι = I/(m_b L²)` and `j = ι + μ e²`, the inertia about the tip (primes:
//! derivatives by `s = z/L`):
//!
//! ```text
//! φ'''(1) = −λ⁴ μ [φ(1) + e φ'(1)]          φ''(1) = λ⁴ [j φ'(1) + μ e φ(1)]
//! ```
//!
//! With `φ = C [cosh λs − cos λs − σ (sinh λs − sin λs)]` the two conditions have a solution where
//!
//! ```text
//! 0 = 1 + cos λ cosh λ + λ μ (cos λ sinh λ − sin λ cosh λ) − 2 λ² μ e sin λ sinh λ
//!       − λ³ j (cos λ sinh λ + sin λ cosh λ) + λ⁴ μ ι (1 − cos λ cosh λ)
//! ```
//!
//! For `e = 0` this is the characteristic equation of Erturk and Inman, Smart Mater. Struct. 18 (2009) 025009; with an
//! offset it is derived here. The modal mass `∫ m' φ² dz + M [φ(L) + d φ'(L)/L]² + I φ'(L)²/L²` is one. Both integrals
//! have a closed form; `φ`, `φ_1`, `φ_2`, `φ_3` are the shape and its derivatives by `λs` at the tip:
//!
//! ```text
//! modal mass / m_b = [φ² + φ_2² − 2 φ_1 φ_3 + (3 φ_1 φ_2 − φ φ_3)/λ] / 4
//! Γ = ∫ m' φ dz + M [φ(L) + d φ'(L)/L] = 2 C m_b σ / λ
//! ```
//!
//! # Roots
//!
//! Roots may be close to each other, so they are counted, not searched for by sign (Wittrick and Williams, Q. J. Mech.
//! Appl. Math. 24 (1971) 263): the number of roots below `λ` is that of the beam clamped at both ends, `cos λ cosh λ =
//! 1`, and the number of negative eigenvalues of the dynamic stiffness at the tip. This stiffness is a matrix of two
//! rows, for displacement and slope; its determinant is the equation above over `1 − cos λ cosh λ`.

use super::{BeamMode, Cantilever, MOST_HALVINGS, SERIES_REACH, SUMMED, fourth_series, sine_and_cosine};
use crate::bounds::{Bounds, ParameterError, parameters};
use crate::scalar::{Mathematics, Scalar};

parameters! { $ tip_mass_numbers "tip_mass."
/// A rigid body at the tip of a [`Cantilever`].
///
/// The flexible length of the beam ends where the body begins: a block of the length `l` beyond this end has an offset of
/// `l/2`, and a rotary inertia of `M (l² + h²)/12`. The largest ratios to the beam are [`TipMass::LARGEST_RATIOS`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TipMass<S> {
    {
        mass "`M`": mass_kg "kg" 0.0..=1e3 "Mass" "at most 1e6 masses of the beam; mode frequencies 1e-2 to 1e8 Hz";
        rotary_inertia "`I`": rotary_inertia_kg_m2 "kg·m²" 0.0..=1e3
            "Moment of inertia about the body's own centre of mass, in the plane of bending"
            "at most 1e6 masses of the beam times the square of its length";
        offset "`d`": offset_m "m" 0.0..=10.0 "Centre of mass beyond the end of the cantilever"
            "at most 10 lengths of the beam";
    }
} }

impl<S: Scalar> TipMass<S> {
    /// Largest mass over that of the beam, rotary inertia over the beam's mass times its length squared, and offset over
    /// the length: with larger ones products of them overflow `f32`.
    pub const LARGEST_RATIOS: [f64; 3] = [1e6, 1e6, 10.0];

    /// Checks the body for a beam.
    pub(crate) fn check(&self, beam: &Cantilever<S>) -> Result<(), ParameterError<S>> {
        self.check_numbers()?;
        let ratios = Ratios::new(self, beam);
        let [mass, inertia, offset] = Self::LARGEST_RATIOS.map(|largest| Bounds::new(0.0, largest));
        mass.check("tip_mass.mass / mass of the beam", ratios.mass)?;
        inertia
            .check("tip_mass.rotary_inertia / (mass of the beam * beam_length^2)", ratios.rotary_inertia)?;
        offset.check("tip_mass.offset / beam_length", ratios.offset)
    }
}

impl<S: Scalar> Cantilever<S> {
    /// Mode `number`, from 1, in order of frequency, with `body` at the tip in place of the point mass [`Cantilever::tip_mass`].
    #[must_use]
    pub(crate) fn mode_with(&self, body: &TipMass<S>, number: u32) -> BeamMode<S> {
        let ratios = Ratios::new(body, self);
        let eigenvalue = ratios.eigenvalue(number.max(1));
        let (sigma, growing) = ratios.shape_constants(eigenvalue);
        let unscaled = BeamMode {
            eigenvalue,
            angular_frequency: S::ONE,
            base_coupling: S::ONE,
            sigma,
            growing,
            scale: S::ONE,
        };
        let [tip, slope, curvature, shear] = unscaled.derivatives(S::ONE);
        let [two, three] = [2.0, 3.0].map(S::from_f64);
        let beam_mass = self.mass_per_length * self.length;
        let body_and_end = (three * slope * curvature - tip * shear) / eigenvalue;
        let modal_mass =
            S::from_f64(0.25) * (tip * tip + curvature * curvature - two * slope * shear + body_and_end);
        let scale = S::ONE / (beam_mass * modal_mass).sqrt();
        let rate = (self.bending_stiffness / (beam_mass * self.length)).sqrt() / self.length;
        BeamMode {
            angular_frequency: eigenvalue * eigenvalue * rate,
            base_coupling: two * beam_mass * scale * sigma / eigenvalue,
            scale,
            ..unscaled
        }
    }

    /// As `Cantilever::residual_compliance`, of the modes with `body` at the tip: all of them together have the same
    /// compliance `(s L)³/3EI`, which does not depend on masses.
    pub(crate) fn residual_compliance_with(&self, body: &TipMass<S>, place: S, modes: u32) -> S {
        let last = modes + SUMMED;
        let beam_mass = self.mass_per_length * self.length;
        let mut sum = S::ZERO;
        let mut weight = S::ONE;
        for number in (modes + 1..=last).rev() {
            let mode = self.mode_with(body, number);
            let shape = mode.shape(place).value;
            let ratio = shape / mode.angular_frequency;
            sum += ratio * ratio;
            // The tip of a high mode hardly moves under a heavy body, and ever less.
            if number == last && place >= S::ONE {
                weight = beam_mass * shape * shape;
            }
        }
        sum + self.remaining_compliance(last, weight)
    }
}

/// The body in units of the beam's mass and length.
#[derive(Debug, Clone, Copy)]
struct Ratios<S> {
    /// `μ`.
    mass: S,
    /// `ι`.
    rotary_inertia: S,
    /// `e`.
    offset: S,
}

/// The terms of the conditions at the tip for one `λ`: `p = λ μ`, `q = λ² μ e`, `r = λ³ j`, and `p r − q²`.
struct Weights<S> {
    shear: S,
    cross: S,
    moment: S,
    both: S,
}

impl<S: Scalar> Ratios<S> {
    fn new(body: &TipMass<S>, beam: &Cantilever<S>) -> Self {
        let beam_mass = beam.mass_per_length * beam.length;
        Self {
            mass: body.mass / beam_mass,
            rotary_inertia: body.rotary_inertia / beam_mass / (beam.length * beam.length),
            offset: body.offset / beam.length,
        }
    }

    fn weights(&self, lambda: S) -> Weights<S> {
        let Self { mass, rotary_inertia, offset } = *self;
        let shear = lambda * mass;
        let cross = lambda * shear * offset;
        let own = lambda * lambda * lambda * rotary_inertia;
        Weights { shear, cross, moment: own + lambda * cross * offset, both: shear * own }
    }

    /// Root `number`, from 1, to neighbouring numbers.
    ///
    /// The body has two freedoms, so a root is not above that of the same number of the free end, and not below that
    /// of the number less two. Bisection by the count goes on until one root is left; then the secant through the
    /// determinants at both ends, in the Illinois variant, needs fewer evaluations.
    fn eigenvalue(&self, number: u32) -> S {
        let pi = S::from_f64(core::f64::consts::PI);
        let count = S::from_u32(number);
        let mut low = if number > 2 { pi * (count - S::from_f64(2.52)) } else { S::ZERO };
        let mut high = if number == 1 { S::from_f64(1.9) } else { pi * (count - S::from_f64(0.48)) };
        // Determinants at the ends with no other root between them.
        let (mut below, mut above) = (None, None);
        let mut raised = None;
        for attempt in 0..MOST_HALVINGS {
            let middle = S::from_f64(0.5) * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            let trial = match (below, above) {
                (Some(below), Some(above)) if attempt < MOST_SECANTS => {
                    secant([low, high], [below, above]).unwrap_or(middle)
                }
                _ => middle,
            };
            let (roots, determinant) = self.roots_below(trial);
            // An end that stays twice counts for half, so that a secant moves it too.
            let raises = roots < number;
            let weight = if raised == Some(raises) { S::from_f64(0.5) } else { S::ONE };
            if raises {
                (low, below) = (trial, (roots + 1 == number).then_some(determinant));
                above = above.map(|above| weight * above);
            } else {
                (high, above) = (trial, (roots == number).then_some(determinant));
                below = below.map(|below| weight * below);
            }
            raised = Some(raises);
        }
        low
    }

    /// Number of roots below `lambda`, above 0, and the determinant over `cosh λ`.
    fn roots_below(&self, lambda: S) -> (u32, S) {
        let weights = self.weights(lambda);
        let two = S::from_f64(2.0);
        let (sine, cosine) = sine_and_cosine(lambda);
        let decay = S::Build::exponential(-lambda);
        let square = decay * decay;
        let sech = two * decay / (S::ONE + square);
        let tanh = (S::ONE - square) / (S::ONE + square);
        // 1 − cos cosh and sin cosh − cos sinh, over cosh.
        let (clamped, bending) = if lambda < S::from_f64(SERIES_REACH) {
            let four = S::from_f64(4.0);
            // 4 Σ (−4)ᵏ x^(4k+4) / (4k+4)! and 4 Σ (−4)ᵏ x^(4k+3) / (4k+3)!
            [4, 3].map(|order| four * sech * fourth_series(lambda, order, -four)).into()
        } else {
            (sech - cosine, sine - cosine * tanh)
        };
        let turning = sine + cosine * tanh;
        let determinant = sech + cosine
            - weights.shear * bending
            - two * weights.cross * sine * tanh
            - weights.moment * turning
            + weights.both * clamped;
        let negative_clamped = clamped < S::ZERO;
        // Negative eigenvalues of the dynamic stiffness: one for a negative determinant, else none or two by the sign
        // of the stiffness against displacement.
        let negative = if (determinant < S::ZERO) != negative_clamped {
            1
        } else if turning / clamped < weights.shear {
            2
        } else {
            0
        };
        // Root k of the clamped ends is between k π and (k + 1) π, and at each the sign changes.
        let turns = (lambda * S::from_f64(core::f64::consts::FRAC_1_PI)).to_u32();
        let below = turns.saturating_sub(1);
        let clamped_roots = if (below % 2 == 1) == negative_clamped { below } else { below + 1 };
        (clamped_roots + negative, determinant)
    }

    /// `σ`, from the shear at the tip, and `(1 − σ) e^λ / 2`. No term of the denominator is negative.
    fn shape_constants(&self, lambda: S) -> (S, S) {
        let weights = self.weights(lambda);
        let two = S::from_f64(2.0);
        if lambda < S::from_f64(SERIES_REACH) {
            // cosh + cos, sinh + sin, cosh − cos, sinh − sin.
            let [a, b, c, d] = [0, 1, 2, 3].map(|order| two * fourth_series(lambda, order, S::ONE));
            let numerator = d + weights.shear * c + weights.cross * b;
            return (numerator / (a + weights.shear * d + weights.cross * c), S::ZERO);
        }
        let half = S::from_f64(0.5);
        let decay = S::Build::exponential(-lambda);
        let square = decay * decay;
        let (sine, cosine) = sine_and_cosine(lambda);
        // The same four over e^λ.
        let [a, c] = [decay, -decay].map(|sign| half * (S::ONE + square) + cosine * sign);
        let [b, d] = [decay, -decay].map(|sign| half * (S::ONE - square) + sine * sign);
        let denominator = a + weights.shear * d + weights.cross * c;
        let rest = (decay + cosine + sine)
            + weights.shear * (cosine - sine - decay)
            + weights.cross * (decay - cosine - sine);
        ((d + weights.shear * c + weights.cross * b) / denominator, half * rest / denominator)
    }
}

/// Attempts at a root after which it is bisected.
const MOST_SECANTS: u32 = 40;

/// Where the straight line through the values at two ends is zero, some roundings within the ends; `None` if the values
/// have the same sign or the ends are as close.
fn secant<S: Scalar>([low, high]: [S; 2], [below, above]: [S; 2]) -> Option<S> {
    if (below < S::ZERO) == (above < S::ZERO) {
        return None;
    }
    let within = S::from_f64(4.0) * S::EPSILON * high;
    let (first, last) = (low + within, high - within);
    let zero = low + (high - low) * (below / (below - above));
    (first < last && zero.is_finite()).then(|| zero.max(first).min(last))
}

#[cfg(test)]
mod tests;
