//! Known values, and the identities that a mode shape obeys.

use super::*;
use crate::test_support::{close, sliding};

fn beam(slider_mass_kg: f64) -> SlidingParameters {
    SlidingParameters { slider_mass_kg, ..sliding() }
}

/// The beam of the shipped scene, by an independent computation to ten digits.
#[test]
fn the_shipped_beam_has_its_known_mode() {
    let mode = Cantilever::new(&beam(8e-3));
    close(mode.eigenvalue, 1.2415397869, 1e-10);
    close(mode.angular_frequency, 115.4417790, 1e-9);
    close(mode.modal_mass, 9.858671590e-3, 1e-9);
    close(mode.participation, 1.1105632698, 1e-10);
}

/// A bare beam: λ = 1.875104068711961 (textbooks), modal mass a quarter of the beam's, and the mean of
/// the shape 0.7829917 of the end's half (2 · 0.7340955 / λ for the shape of unit mean square).
#[test]
fn a_bare_beam_has_the_mode_of_the_textbooks() {
    let mode = Cantilever::new(&beam(1e-12));
    // The tip mass that the scene file allows at least moves it by 4 m / ρAL · λ / 4 = 1e-10.
    close(mode.eigenvalue, 1.875_104_068_711_961, 3e-10);
    close(mode.modal_mass, 7.8e-3 / 4.0, 1e-9);
    close(mode.participation, 4.0 * 0.5 * 0.782_991_756, 1e-8);
}

/// Far heavier than the beam the mass hangs on a massless spring, `ω² = 3EI / (M L³)`, with 33/140 of
/// the beam in `M` and 3/8 of it in `κ M` (both exact to first order in the beam's mass).
#[test]
fn under_a_heavy_mass_the_beam_is_a_spring() {
    for mass in [1.0, 1e3] {
        let parameters = beam(mass);
        let mode = Cantilever::new(&parameters);
        let stiffness = 3.0 * 210e9 * 20e-3 * 0.5e-3f64.powi(3) / 12.0 / 1e-3;
        close(mode.angular_frequency.powi(2) * mode.modal_mass, stiffness, 1e-4 / mass.powi(2) + 1e-12);
        close(mode.modal_mass, mass + 33.0 / 140.0 * 7.8e-3, 1e-4 / mass.powi(2) + 1e-12);
        close(mode.participation * mode.modal_mass, mass + 0.375 * 7.8e-3, 1e-4 / mass.powi(2) + 1e-12);
    }
}

/// `E I φ'''(L) = −ω² m φ(L)` with the third derivative taken by the series, and
/// `E I ∫ φ''² = ω² (ρA ∫ φ² + m φ(L)²)`, the mode's two energies.
#[test]
fn the_mode_obeys_its_identities() {
    let tip = 8e-3 / 7.8e-3;
    let lambda = eigenvalue(tip);
    let shape = Shape::new(lambda);
    let third = shape.bend * series(3, 1.0, lambda) - shape.shear * series(0, 1.0, lambda);
    close(third, -lambda * tip * shape.at(lambda), 1e-13);
    // φ'' in units of (λ/L)² is bend · K0 − shear · K1.
    let curvature = |u: f64| shape.bend * series(0, 1.0, u) - shape.shear * series(1, 1.0, u);
    let count = 2000;
    let sum: f64 = (0..=count)
        .map(|index| {
            let weight = if index == 0 || index == count { 1.0 } else { 2.0 + 2.0 * f64::from(index % 2) };
            weight * curvature(lambda * f64::from(index) / f64::from(count)).powi(2)
        })
        .sum();
    let [_, mean_square] = shape.means(lambda);
    close(sum / 3.0 / f64::from(count), mean_square + tip * shape.at(lambda).powi(2), 1e-12);
}

#[test]
fn krylov_functions_are_their_closed_forms() {
    for u in [0.3f64, 1.2, 1.9] {
        close(series(0, 1.0, u), 0.5 * (u.cosh() + u.cos()), 1e-14);
        close(series(1, 1.0, u), 0.5 * (u.sinh() + u.sin()), 1e-14);
        close(series(2, 1.0, u), 0.5 * (u.cosh() - u.cos()), 1e-13);
        close(series(3, 1.0, u), 0.5 * (u.sinh() - u.sin()), 1e-12);
        close(4.0 * series(3, -4.0, u), u.sin() * u.cosh() - u.cos() * u.sinh(), 1e-12);
    }
}
