//! Known values. That the mode is that of the core is in the tests across crates.

use super::*;
use crate::test_support::{close, sliding};

/// The beam of the shipped scene, by an independent computation to ten digits.
#[test]
fn the_shipped_beam_has_its_known_mode() {
    let mode = Cantilever::new(&sliding());
    close(mode.eigenvalue, 1.2415397869, 1e-10);
    close(mode.angular_frequency, 115.4417790, 1e-9);
    close(mode.modal_mass, 9.858671590e-3, 1e-9);
    close(mode.participation, 1.1105632698, 1e-10);
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
