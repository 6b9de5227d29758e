//! The first bending mode of a clamped beam with a mass at its tip.
//!
//! Euler-Bernoulli beam without rotary inertia of the mass: equations (1) to (4) of Fu, Ouyang and Davis, J.
//! Phys. D 53 (2020). With `u = λ z / L` the mode shape is written in Krylov's functions
//!
//! ```text
//! K0 = (cosh u + cos u)/2,  K1 = (sinh u + sin u)/2,  K2 = (cosh u − cos u)/2,  K3 = (sinh u − sin u)/2
//! ```
//!
//! each the derivative of the next. `K1(λ) K2(u) − K0(λ) K3(u)` satisfies the clamped end and the free end
//! without moment. The shear force of the tip mass, `E I φ''' = −ω² m φ`, then gives
//!
//! ```text
//! 1 + cos λ cosh λ = λ (m / ρAL) (sin λ cosh λ − cos λ sinh λ)
//! ```
//!
//! Power series replace the differences that would cancel, so a tip mass far heavier or far lighter than the beam costs no digits.

use std::f64::consts::TAU;

use super::means;
use crate::root::far_side;
use crate::scene_file::SlidingParameters;

/// The first mode in the displacement of the tip: `x'' + 2ζω x' + ω² x = −κ a + F / M`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cantilever {
    /// Natural angular frequency `ω` in rad/s.
    pub angular_frequency: f64,
    /// Modal mass `M = 1 / φ(L)²` in kg.
    pub modal_mass: f64,
    /// `κ = Γ φ(L)`: participation factor of the base acceleration.
    pub participation: f64,
    /// First root `λ` of the characteristic equation.
    pub eigenvalue: f64,
}

impl SlidingParameters {
    /// Natural frequency in Hz of the first bending mode with the slider, undamped and without friction.
    pub fn natural_frequency_hz(&self) -> f64 {
        Cantilever::new(self).angular_frequency / TAU
    }
}

impl Cantilever {
    /// The first mode of the beam with the slider at its tip.
    pub fn new(parameters: &SlidingParameters) -> Self {
        let p = parameters;
        let section = p.beam_width_m * p.beam_thickness_m;
        let beam_mass = p.density_kg_per_m3 * section * p.beam_length_m;
        let tip = p.slider_mass_kg / beam_mass;
        let eigenvalue = eigenvalue(tip);
        let shape = Shape::new(eigenvalue);
        // With φ = c · shape: c² (ρAL ∫ shape² + m shape(1)²) = 1.
        let end = shape.at(eigenvalue);
        let [mean, mean_square] = shape.means(eigenvalue);
        let modal_mass = beam_mass * (mean_square / (end * end) + tip);
        let moving_mass = beam_mass * (mean / end + tip);
        // ω² = λ⁴ E I / (ρ A L⁴), I = b h³ / 12.
        let radius_of_gyration = p.beam_thickness_m / 12f64.sqrt();
        let speed_of_sound = (p.young_modulus_pa / p.density_kg_per_m3).sqrt();
        let wave_number = eigenvalue / p.beam_length_m;
        Self {
            angular_frequency: wave_number * wave_number * radius_of_gyration * speed_of_sound,
            modal_mass,
            participation: moving_mass / modal_mass,
            eigenvalue,
        }
    }
}

/// `Σ u^(4k+n) / (4k+n)! · ratio^k`: Krylov's function `Kn` for a ratio of 1.
pub(super) fn series(n: u32, ratio: f64, u: f64) -> f64 {
    let fourth = ratio * u * u * u * u;
    let mut term = (1..=n).fold(1.0, |term, k| term * u / f64::from(k));
    let (mut sum, mut k) = (term, n);
    while term.abs() > 0.1 * f64::EPSILON * sum.abs() {
        term *= fourth / (f64::from(k + 1) * f64::from(k + 2) * f64::from(k + 3) * f64::from(k + 4));
        sum += term;
        k += 4;
    }
    sum
}

/// First root of the characteristic equation for a tip mass of `tip` beam masses.
fn eigenvalue(tip: f64) -> f64 {
    // A beam without tip mass has 1.8751.
    const ABOVE: f64 = 1.9;
    // sin u cosh u − cos u sinh u = 4 Σ (−4)^k u^(4k+3) / (4k+3)!: its fourth derivative is −4 times it.
    far_side(|u| u * tip * 4.0 * series(3, -4.0, u) - (1.0 + u.cos() * u.cosh()), 0.0, ABOVE)
}

/// `K1(λ) K2(u) − K0(λ) K3(u)`.
#[derive(Debug, Clone, Copy)]
struct Shape {
    bend: f64,
    shear: f64,
}

impl Shape {
    fn new(eigenvalue: f64) -> Self {
        Self { bend: series(1, 1.0, eigenvalue), shear: series(0, 1.0, eigenvalue) }
    }

    fn at(&self, u: f64) -> f64 {
        self.bend * series(2, 1.0, u) - self.shear * series(3, 1.0, u)
    }

    /// Means over the length of the shape and of its square; eight pieces are exact to rounding for so smooth a function.
    fn means(&self, eigenvalue: f64) -> [f64; 2] {
        means(8, |place| self.at(eigenvalue * place))
    }
}
