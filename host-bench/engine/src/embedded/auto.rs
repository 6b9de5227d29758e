//! What `--method auto` chooses for a triboelectric scene: exponential Radau, and the tolerance for a stated accuracy.
//!
//! In contact-separation the tolerance is a factor times the square root of the accuracy. The factor depends on the circuit:
//!
//! | circuit | factor | why |
//! | --- | --- | --- |
//! | any, and a bridge | 0.6 | |
//! | a time constant as long as the motion within the dielectric's thickness | 0.45 | the charge follows the impact half way |
//! | a time constant longer than a period | 0.8 | the charge hardly flows |
//!
//! In sliding with a resistor it is 4.5 times the accuracy to the power of 3/4. The longest step of the method keeps the
//! error small at loose tolerances, and the error falls more slowly than the square of the tolerance.
//!
//! No tolerance is looser than 0.05. Above it steps are rejected too late, and the mean power jumps.
//!
//! A run without options aims at 10⁻⁶, of a slider in single precision at 3·10⁻⁶: one that is pushed at 0.01 Hz with 1 Ω takes
//! 1.1·10⁷ attempts at 10⁻⁶, of a mean power without a correct digit, and 5·10⁴ at 3·10⁻⁶ with an error below 2·10⁻⁶.

use std::f64::consts::TAU;

use harvester_scene::method::Precision;
use harvester_scene::scene_file::{ContactSeparationParameters, Load, Scene};
use model_core::part::VACUUM_PERMITTIVITY;

/// Relative error of the mean power that a run without options aims at.
const DEFAULT_ACCURACY: f64 = 1e-6;
/// The same of a slider in single precision.
const SINGLE_SLIDING_ACCURACY: f64 = 3e-6;
/// Tolerance over the square root of the accuracy.
const USUAL: f64 = 0.6;
/// The same where the charge follows the impact half way.
const HALF_WAY: f64 = 0.45;
/// The same where the charge hardly flows within a period.
const NEARLY_OPEN: f64 = 0.8;
/// Tolerance over the accuracy to the power of 3/4, for sliding.
const SLIDING: f64 = 4.5;
/// Within which factor a time constant is as long as the motion within the dielectric's thickness.
const AS_LONG: f64 = 10.0;
/// The loosest tolerance that is chosen.
const LOOSEST: f64 = 5e-2;
/// The tightest tolerance that is chosen: both precisions accept it.
const TIGHTEST: f64 = f32::EPSILON as f64;

/// The relative error of the mean power that a run without options aims at, in single or in double precision.
pub fn default_accuracy(scene: &Scene, precision: Precision) -> f64 {
    let is_single_slider = precision == Precision::F32 && scene.sliding().is_ok();
    if is_single_slider { SINGLE_SLIDING_ACCURACY } else { DEFAULT_ACCURACY }
}

/// The tolerance of exponential Radau for a relative error of the mean power of `accuracy`.
pub(super) fn tolerance(scene: &Scene, accuracy: f64) -> f64 {
    let root = accuracy.sqrt();
    let tolerance = match (scene.load, scene.contact_separation()) {
        (Load::Resistor { resistance_ohm }, Ok(model)) => {
            by_time_constant(&model.parameters, resistance_ohm) * root
        }
        (Load::Resistor { .. }, _) if scene.sliding().is_ok() => SLIDING * (accuracy * root).sqrt(),
        _ => USUAL * root,
    };
    tolerance.clamp(TIGHTEST, LOOSEST)
}

/// The factor for contact-separation with a resistor in Ω.
fn by_time_constant(from: &ContactSeparationParameters, resistance_ohm: f64) -> f64 {
    let thickness = from.dielectric_thickness_m / from.relative_permittivity;
    let capacitance = VACUUM_PERMITTIVITY * from.electrode_area_m2 / thickness + from.parasitic_capacitance_f;
    let time_constant = resistance_ohm * capacitance;
    let angular_frequency = (from.stiffness_n_per_m / from.mass_kg).sqrt();
    // At the speed of a free motion as wide as the gap.
    let within_thickness = thickness / (angular_frequency * from.initial_gap_m);
    if time_constant > TAU / angular_frequency {
        NEARLY_OPEN
    } else if (within_thickness / AS_LONG..within_thickness * AS_LONG).contains(&time_constant) {
        HALF_WAY
    } else {
        USUAL
    }
}

#[cfg(test)]
mod tests {
    use harvester_scene::scene_file::{Override, read, shipped};
    use model_core::integrate::Adaptive;

    use super::*;

    fn scene(name: &str, load_ohm: &str) -> Scene {
        read(&shipped(name), &[Override::new("load.resistance_ohm", load_ohm)]).expect("a shipped scene")
    }

    #[test]
    fn a_tighter_accuracy_never_has_a_looser_tolerance_and_both_precisions_accept_it() {
        for name in ["contact-separation", "sliding"] {
            for load_ohm in ["0", "1", "1e5", "1e6", "1e8", "1e9", "inf"] {
                let scene = scene(name, load_ohm);
                let mut last = f64::INFINITY;
                // The bounds of `--accuracy`, and between.
                for accuracy in [0.1, 1e-2, 1e-3, 1e-5, 1e-6, 1e-9, 1e-12] {
                    let own = tolerance(&scene, accuracy);
                    assert!(own <= last, "{name} {load_ohm} {accuracy}");
                    assert!(Adaptive::new(own).is_ok() && Adaptive::new(own as f32).is_ok(), "{own}");
                    last = own;
                }
            }
        }
    }

    #[test]
    fn the_factor_follows_the_time_constant() {
        let factor = |name, load_ohm| tolerance(&scene(name, load_ohm), 1e-6) * 1e3;
        let loads = ["1e4", "1e5", "3e6", "1e8", "1e9"];
        let expected = [USUAL, HALF_WAY, HALF_WAY, USUAL, NEARLY_OPEN];
        for (load_ohm, expected) in loads.into_iter().zip(expected) {
            assert!((factor("contact-separation", load_ohm) - expected).abs() < 1e-12, "{load_ohm}");
        }
        let sliding = scene("sliding", "1e6");
        assert!((tolerance(&sliding, 1e-8) / SLIDING - 1e-6).abs() < 1e-15);
        assert_eq!(tolerance(&sliding, 1e-2), LOOSEST);
    }
}
