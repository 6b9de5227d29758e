//! Computes the modes of a uniform cantilever with a tip mass.
//!
//! Euler–Bernoulli bending, clamped at one end, with a point mass `m` without rotary inertia at the other
//! end. With `s = z/L` along the beam, the beam mass `m_b` and `μ = m/m_b`, a mode has the shape `φ(s) = C
//! [cosh λs − cos λs − σ (sinh λs − sin λs)]`, where `λ` is a root of
//!
//! ```text
//! 1 + cos λ cosh λ + λ μ (cos λ sinh λ − sin λ cosh λ) = 0
//! ```
//!
//! and `C` makes the modal mass one: `∫ m' φ² dz + m φ(L)² = 1`. Both required integrals have a closed form,
//! from `φ'''' = λ⁴ φ` and the boundary conditions (primes: derivatives by `s`):
//!
//! ```text
//! ∫ φ² ds + μ φ(1)² = φ(1) [(1 + μ) φ(1) + 2 μ φ'(1)] / 4
//! ∫ φ ds + μ φ(1)   = −φ'''(0) / λ⁴ = 2 C σ / λ
//! ```
//!
//! The first integral uses the shear of the tip mass, `μ φ(1) = −φ'''(1)/λ⁴`: under a heavy mass the tip of a
//! higher mode hardly moves, and `φ(1)` is a small difference.
//!
//! No term cancels or overflows: below `λ = 2` the differences of hyperbolic and circular functions are
//! summed as series of one sign, and above it the hyperbolic functions are written in decaying exponentials.
//! So the result in `f32` is accurate to rounding.
//!
//! With a rigid body at the tip, which has a rotary inertia and an offset, the modes are those of
//! `Cantilever::mode_with`.

mod tip_mass;

pub use tip_mass::TipMass;

use crate::scalar::{Mathematics, Scalar, turns_of_radians};

/// A uniform cantilever with a tip mass.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cantilever<S> {
    /// Length `L` in m.
    pub length: S,
    /// Bending stiffness `EI` in N·m².
    pub bending_stiffness: S,
    /// Mass per length `m' = ρA` in kg/m.
    pub mass_per_length: S,
    /// Tip mass `m` in kg; 0 for a free end.
    pub tip_mass: S,
}

/// One mode of a [`Cantilever`], normalised to a modal mass of one.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BeamMode<S> {
    /// Eigenvalue `λ`, the wave number times the length.
    pub eigenvalue: S,
    /// Undamped angular frequency `ω = λ² √(EI / (m' L⁴))` in rad/s.
    pub angular_frequency: S,
    /// `Γ = ∫ m' φ dz + m φ(L)` in √kg: the modal force per negative base acceleration.
    pub base_coupling: S,
    /// `σ` of the shape.
    sigma: S,
    /// `(1 − σ) e^λ / 2`: the growing part of the shape at the tip.
    growing: S,
    /// `C` in 1/√kg.
    scale: S,
}

/// A mode shape and its derivatives by `s = z/L` at one position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape<S> {
    /// `φ` in 1/√kg; positive towards positive displacement.
    pub value: S,
    /// `dφ/ds` in 1/√kg.
    pub slope: S,
    /// `d²φ/ds²` in 1/√kg.
    pub curvature: S,
}

/// `λ` below which the functions are summed as series; above it they are computed from exponentials.
const SERIES_REACH: f64 = 2.0;
/// Number of terms of a series for arguments up to 2: the last is below 2⁻⁵³ of the first.
const SERIES_TERMS: u32 = 9;
/// Mode number above which the eigenvalues of a free end are `(i − ½) π` to a rounding of `f64`.
const ASYMPTOTIC: u32 = 12;
/// Most bisections from the initial bracket of a root to two neighbouring numbers.
const MOST_HALVINGS: u32 = 120;

/// Number of modes after the kept ones that the residual compliance sums one by one.
const SUMMED: u32 = 200;

impl<S: Scalar> Cantilever<S> {
    /// Mode `number`, from 1, in order of frequency.
    #[must_use]
    pub fn mode(&self, number: u32) -> BeamMode<S> {
        let beam_mass = self.mass_per_length * self.length;
        let ratio = self.tip_mass / beam_mass;
        let eigenvalue = eigenvalue(number.max(1), ratio);
        let (sigma, growing) = shape_constants(eigenvalue, ratio);
        let unscaled = BeamMode {
            eigenvalue,
            angular_frequency: S::ONE,
            base_coupling: S::ONE,
            sigma,
            growing,
            scale: S::ONE,
        };
        let [tip, slope, _, shear] = unscaled.derivatives(S::ONE);
        let two = S::from_f64(2.0);
        let slope = eigenvalue * slope;
        let inertia = if eigenvalue < S::from_f64(SERIES_REACH) { ratio * tip } else { -shear / eigenvalue };
        let modal_mass = S::from_f64(0.25) * beam_mass * (tip * tip + inertia * (tip + two * slope));
        let scale = S::ONE / modal_mass.sqrt();
        let rate = (self.bending_stiffness / (beam_mass * self.length)).sqrt() / self.length;
        BeamMode {
            angular_frequency: eigenvalue * eigenvalue * rate,
            base_coupling: two * beam_mass * scale * sigma / eigenvalue,
            scale,
            ..unscaled
        }
    }

    /// Static compliance in m/N, at the position `s = z/L` above 0, of all modes after the first `kept`: `Σ
    /// φ_i(s)²/ω_i²`, of the modes without tip mass.
    ///
    /// All modes together have `(s L)³/3EI`. The omitted modes are summed directly, because the difference of
    /// the total and the kept modes cancels: with ten modes in `f32` it has an error of 10⁻³.
    pub(crate) fn residual_compliance(&self, place: S, modes: u32) -> S {
        let free = Self { tip_mass: S::ZERO, ..*self };
        let last = modes.saturating_add(SUMMED);
        let mut sum = S::ZERO;
        for number in (modes.wrapping_add(1)..=last).rev() {
            let mode = free.mode(number);
            let ratio = mode.shape(place).value / mode.angular_frequency;
            sum += ratio * ratio;
        }
        // φ² of the remaining modes is on average 1/m_b, at the tip 4/m_b.
        let weight = if place >= S::ONE { S::from_f64(4.0) } else { S::ONE };
        sum + self.remaining_compliance(last, weight)
    }

    /// Static compliance in m/N of the modes after `last`, with `λ = (i − ½)π` and `φ²` of `weight/m_b`: `Σ (i − ½)⁻⁴`
    /// by the Euler–Maclaurin formula at the midpoints.
    #[inline]
    fn remaining_compliance(&self, last: u32, weight: S) -> S {
        let n = S::from_u32(last);
        let cube = n * n * n;
        let fourths = S::from_f64(1.0 / 3.0) / cube - S::from_f64(1.0 / 6.0) / (cube * n * n);
        let cube_of_length = self.length * self.length * self.length;
        let fourth_of_pi = S::from_f64(97.409_091_034_002_43);
        weight / fourth_of_pi * fourths * cube_of_length / self.bending_stiffness
    }
}

impl<S: Scalar> BeamMode<S> {
    /// The shape at the position `s = z/L`, 0 at the clamp and 1 at the tip.
    #[must_use]
    pub fn shape(&self, s: S) -> Shape<S> {
        let [value, slope, curvature, _] = self.derivatives(s);
        let (scale, lambda) = (self.scale, self.eigenvalue);
        Shape {
            value: scale * value,
            slope: scale * lambda * slope,
            curvature: scale * lambda * lambda * curvature,
        }
    }

    /// The shape without its scale, and its first three derivatives by `λs`.
    fn derivatives(&self, s: S) -> [S; 4] {
        let (lambda, sigma) = (self.eigenvalue, self.sigma);
        let argument = lambda * s;
        if lambda < S::from_f64(SERIES_REACH) {
            // cosh + cos, sinh + sin, cosh − cos, sinh − sin.
            let [a, b, c, d] =
                [0, 1, 2, 3].map(|order| S::from_f64(2.0) * fourth_series(argument, order, S::ONE));
            return [c - sigma * d, b - sigma * c, a - sigma * b, d - sigma * a];
        }
        let growing = self.growing * S::Build::exponential(argument - lambda);
        let decaying = S::from_f64(0.5) * (S::ONE + sigma) * S::Build::exponential(-argument);
        let (sine, cosine) = sine_and_cosine(argument);
        [
            growing + decaying - cosine + sigma * sine,
            growing - decaying + sine + sigma * cosine,
            growing + decaying + cosine - sigma * sine,
            growing - decaying - sine - sigma * cosine,
        ]
    }
}

/// Root `number` of the characteristic equation, divided by `cosh λ`, for the mass ratio `ratio`.
///
/// Each root lies between that of a pinned end (infinite tip mass) and that of a free end. Bisection to neighbouring numbers.
fn eigenvalue<S: Scalar>(number: u32, ratio: S) -> S {
    let pi = S::from_f64(core::f64::consts::PI);
    let count = S::from_u32(number);
    if ratio == S::ZERO && number > ASYMPTOTIC {
        return pi * (count - S::from_f64(0.5));
    }
    let (mut low, mut high) = if number == 1 {
        (S::ZERO, S::from_f64(1.9))
    } else {
        (pi * (count - S::from_f64(0.76)), pi * (count - S::from_f64(0.48)))
    };
    let falls = characteristic(low, ratio) > S::ZERO;
    for _ in 0..MOST_HALVINGS {
        let middle = S::from_f64(0.5) * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if (characteristic(middle, ratio) > S::ZERO) == falls {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// `sech λ + cos λ + λ μ (cos λ tanh λ − sin λ)`.
fn characteristic<S: Scalar>(lambda: S, ratio: S) -> S {
    let decay = S::Build::exponential(-lambda);
    let square = decay * decay;
    let sech = S::from_f64(2.0) * decay / (S::ONE + square);
    let (sine, cosine) = sine_and_cosine(lambda);
    let bending = if lambda < S::from_f64(SERIES_REACH) {
        // sin cosh − cos sinh = 4 Σ (−4)ᵏ x^(4k+3) / (4k+3)!
        -S::from_f64(4.0) * fourth_series(lambda, 3, S::from_f64(-4.0)) * sech
    } else {
        cosine * (S::ONE - square) / (S::ONE + square) - sine
    };
    sech + cosine + lambda * ratio * bending
}

/// `σ`, from the boundary conditions at the tip, and `(1 − σ) e^λ / 2`.
fn shape_constants<S: Scalar>(lambda: S, ratio: S) -> (S, S) {
    let two = S::from_f64(2.0);
    let weight = lambda * ratio;
    if lambda < S::from_f64(SERIES_REACH) {
        let [sum, _, cosines, sines] = [0, 1, 2, 3].map(|order| two * fourth_series(lambda, order, S::ONE));
        // The growing part is 0 here, because the shape is summed as series too.
        return ((sines + weight * cosines) / (sum + weight * sines), S::ZERO);
    }
    let half = S::from_f64(0.5);
    let decay = S::Build::exponential(-lambda);
    let square = decay * decay;
    let (sine, cosine) = sine_and_cosine(lambda);
    // cosh + cos, cosh − cos and sinh − sin over e^λ.
    let sum = half * (S::ONE + square) + cosine * decay;
    let cosines = half * (S::ONE + square) - cosine * decay;
    let sines = half * (S::ONE - square) - sine * decay;
    let denominator = sum + weight * sines;
    let rest = decay + cosine + sine + weight * (cosine - sine - decay);
    ((sines + weight * cosines) / denominator, half * rest / denominator)
}

/// `Σ factorᵏ x^(4k+order) / (4k+order)!`.
fn fourth_series<S: Scalar>(x: S, order: u32, factor: S) -> S {
    let mut term = (1..=order).fold(S::ONE, |term, n| term * x / S::from_u32(n));
    let fourth = x * x * x * x * factor;
    let mut sum = term;
    for k in 0..SERIES_TERMS {
        let n = S::from_u32(order.wrapping_add(4 * k));
        let next = [1, 2, 3, 4].map(|i| n + S::from_u32(i));
        term = term * fourth / (next[0] * next[1] * next[2] * next[3]);
        sum += term;
    }
    sum
}

/// Sine and cosine of an angle in radians.
#[inline(never)]
fn sine_and_cosine<S: Scalar>(angle: S) -> (S, S) {
    let phase = turns_of_radians(angle).unwrap_or(0);
    (S::Build::sine_of_turns(phase), S::Build::cosine_of_turns(phase))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The beam of the sliding harvester: 100 × 20 × 0.5 mm of steel, 8 g at its tip.
    fn slider(tip_mass: f64) -> Cantilever<f64> {
        Cantilever {
            length: 0.1,
            bending_stiffness: 210e9 * 0.02 * 0.0005f64.powi(3) / 12.0,
            mass_per_length: 7800.0 * 0.02 * 0.0005,
            tip_mass,
        }
    }

    fn single(beam: Cantilever<f64>) -> Cantilever<f32> {
        Cantilever {
            length: beam.length as f32,
            bending_stiffness: beam.bending_stiffness as f32,
            mass_per_length: beam.mass_per_length as f32,
            tip_mass: beam.tip_mass as f32,
        }
    }

    fn close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() < relative, "{value} is not {expected} within {relative}");
    }

    /// The integral over the length by Simpson's rule.
    fn integral(integrand: impl Fn(f64) -> f64) -> f64 {
        let intervals = 2000;
        (0..=intervals).fold(0.0, |sum, k| {
            let weight = if k == 0 || k == intervals { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
            sum + weight * integrand(f64::from(k) / f64::from(intervals))
        }) / f64::from(3 * intervals)
    }

    #[test]
    fn the_beam_of_the_sliding_harvester_has_its_known_mode() {
        let mode = slider(8e-3).mode(1);
        close(mode.eigenvalue, 1.241_539_786_9, 1e-10);
        close(mode.angular_frequency, 115.441_779_0, 1e-9);
        close(mode.shape(1.0).value, 10.071_422_2, 1e-8);
        close(mode.base_coupling, 0.110_268_763_7, 1e-9);
    }

    #[test]
    fn a_free_end_has_the_eigenvalues_of_the_textbook() {
        let known = [1.875_104_07, 4.694_091_13, 7.854_757_44, 10.995_540_73, 14.137_168_39, 17.278_759_53];
        for (number, known) in (1..).zip(known) {
            let mode = slider(0.0).mode(number);
            assert!((mode.eigenvalue - known).abs() < 6e-9, "{number}");
            // The exact value at a free tip: φ = ±2/√m_b.
            let mass = slider(0.0).mass_per_length * 0.1;
            let sign = if number % 2 == 1 { 2.0 } else { -2.0 };
            close(mode.shape(1.0).value, sign / mass.sqrt(), 1e-12);
        }
        let high = slider(0.0).mode(20);
        close(high.eigenvalue, 19.5 * core::f64::consts::PI, 1e-15);
        assert!(high.shape(1.0).value.is_finite() && high.shape(0.37).curvature.is_finite());
    }

    #[test]
    fn modes_are_orthonormal_and_carry_the_whole_mass() {
        for tip_mass in [0.0, 1e-3, 8e-3, 0.5] {
            let beam = slider(tip_mass);
            let beam_mass = beam.mass_per_length * beam.length;
            let mut coupled = 0.0;
            for i in 1..=6 {
                let one = beam.mode(i);
                for j in 1..=i {
                    let other = beam.mode(j);
                    let product = beam_mass * integral(|s| one.shape(s).value * other.shape(s).value)
                        + tip_mass * one.shape(1.0).value * other.shape(1.0).value;
                    assert!(
                        (product - f64::from(u8::from(i == j))).abs() < 2e-9,
                        "{tip_mass} {i} {j} {product}"
                    );
                }
                let moment = beam_mass * integral(|s| one.shape(s).value) + tip_mass * one.shape(1.0).value;
                assert!((one.base_coupling - moment).abs() < 1e-10, "{tip_mass} {i}");
                coupled += one.base_coupling.powi(2);
            }
            // Σ Γ² over all modes is the whole mass.
            assert!(coupled < beam_mass + tip_mass && coupled > 0.93 * (beam_mass + tip_mass), "{tip_mass}");
        }
    }

    #[test]
    fn strain_energy_and_shear_at_the_tip_are_those_of_the_frequency() {
        for tip_mass in [0.0, 8e-3, 0.5] {
            let beam = slider(tip_mass);
            for number in 1..=4 {
                let mode = beam.mode(number);
                let square = mode.angular_frequency.powi(2);
                // EI ∫ φ''² dz = ω², with derivatives by s = z/L.
                let stiffness = beam.bending_stiffness / beam.length.powi(3);
                let strain = stiffness * integral(|s| mode.shape(s).curvature.powi(2));
                close(strain, square, 1e-8);
                // EI φ'''(L) = −ω² m φ(L); the third derivative by differences of the second.
                let step = 1e-4;
                let [a, b, c] = [1.0, 1.0 - step, 1.0 - 2.0 * step].map(|s| mode.shape(s).curvature);
                let shear = stiffness * (1.5 * a - 2.0 * b + 0.5 * c) / step;
                let tip = mode.shape(1.0).value;
                let scale = stiffness * mode.eigenvalue.powi(3) * mode.scale;
                let expected = -square * tip_mass * tip;
                assert!((shear - expected).abs() < 1e-5 * scale, "{tip_mass} {number} {shear} {expected}");
            }
        }
    }

    #[test]
    fn rules_of_thumb_hold_for_the_first_mode() {
        let beam = slider(8e-3);
        let (mode, beam_mass) = (beam.mode(1), 7.8e-3);
        let tip = mode.shape(1.0).value;
        let modal_mass = 1.0 / (tip * tip);
        close(modal_mass, 8e-3 + 33.0 / 140.0 * beam_mass, 3e-3);
        close(mode.base_coupling / tip, 8e-3 + 0.375 * beam_mass, 3e-3);
        close(mode.angular_frequency.powi(2) * modal_mass, 3.0 * beam.bending_stiffness / 1e-3, 2e-3);
        // A tip mass of a million beam masses: a massless spring.
        let heavy = slider(7.8e3).mode(1);
        close(heavy.angular_frequency.powi(2), 3.0 * beam.bending_stiffness / 1e-3 / 7.8e3, 1e-6);
        close(heavy.base_coupling, 7.8e3f64.sqrt(), 1e-6);
    }

    #[test]
    fn retained_and_residual_modes_make_the_whole_compliance() {
        let beam = slider(0.0);
        for place in [1.0, 0.5, 0.3] {
            let whole = (place * beam.length).powi(3) / (3.0 * beam.bending_stiffness);
            for modes in [0_u32, 1, 4, 10, 20] {
                let modal_part: f64 = (1..=modes)
                    .map(|i| (beam.mode(i).shape(place).value / beam.mode(i).angular_frequency).powi(2))
                    .sum();
                let rest = beam.residual_compliance(place, modes);
                // Relative to the residual compliance, of which the difference keeps some digits.
                assert!((modal_part + rest - whole).abs() < 2e-4 * rest + 1e-13 * whole, "{place} {modes}");
                let coarse = f64::from(single(beam).residual_compliance(place as f32, modes));
                assert!((coarse / rest - 1.0).abs() < 2e-5, "{place} {modes} {coarse} {rest}");
            }
        }
    }

    #[test]
    fn single_precision_is_as_good_as_its_rounding() {
        for tip_mass in [0.0, 8e-3, 0.5, 7.8e3] {
            for number in 1..=10 {
                let (fine, coarse) = (slider(tip_mass).mode(number), single(slider(tip_mass)).mode(number));
                close(coarse.eigenvalue.into(), fine.eigenvalue, 5e-7);
                close(coarse.angular_frequency.into(), fine.angular_frequency, 2e-6);
                for s in [0.2, 0.5, 0.83, 1.0] {
                    let difference = f64::from(coarse.shape(s as f32).value) - fine.shape(s).value;
                    assert!(difference.abs() < 1e-5 * fine.scale, "{tip_mass} {number} {s} {difference}");
                }
            }
        }
    }
}
