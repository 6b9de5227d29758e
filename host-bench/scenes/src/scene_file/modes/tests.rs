//! Published eigenvalues, and closed sums over all modes. That the modes are those of the core, whose tests have their other
//! identities, is in the tests across crates.

use super::*;
use crate::test_support::{bump_stop, close};

/// The beam of the shipped scene.
fn parameters(beam_modes: usize) -> BumpStopParameters {
    BumpStopParameters { beam_modes, ..bump_stop().parameters }
}

/// The stop of the shipped scene.
fn stop(rod_modes: usize) -> StopParameters {
    StopParameters { rod_modes, ..bump_stop().stop.expect("there is a stop") }
}

#[test]
fn constants_of_the_beam() {
    let modes = BumpStopModes::new(&parameters(10), Some(&stop(10)));
    close(modes.bending_stiffness, 0.089_738_408_5, 1e-9);
    close(modes.beam_mass, 3.9125e-3, 1e-14);
    close(modes.capacitance, 15.93e-9, 1e-14);
    // λ, f in Hz, θ, γ; the first three roots are in every table of cos λ cosh λ = −1.
    let table = [
        [1.875_104_07, 239.705_436, 0.041_497_95, 0.048_976_12],
        [4.694_091_13, 1_502.208_328, -0.144_127_66, 0.027_142_68],
        [7.854_757_44, 4_206.226_816, 0.236_616_25, 0.015_914_30],
        [10.995_540_73, 8_242.525_797, -0.331_497_21, 0.011_377_72],
        [14.137_168_39, 13_625.485_738, 0.426_197_13, 0.008_849_00],
        [17.278_759_53, 20_354.116_348, -0.520_908_33, 0.007_240_10],
        [20.420_352_25, 28_428.476_765, 0.615_618_90, 0.006_126_24],
        [23.561_944_90, 37_848.563_731, -0.710_329_50, 0.005_309_41],
        [26.703_537_56, 48_614.377_414, 0.805_040_10, 0.004_684_77],
        [29.845_130_21, 60_725.917_808, -0.899_750_70, 0.004_191_64],
    ];
    for (mode, [eigenvalue, frequency, coupling, participation]) in modes.beam.iter().zip(table) {
        close(mode.eigenvalue, eigenvalue, 3e-9);
        close(mode.angular_frequency / TAU, frequency, 2e-9);
        close(mode.coupling, coupling, 2e-7);
        close(mode.participation, participation, 2e-6);
        let sign = mode.coupling.signum();
        close(mode.at_tip, sign * 31.974_430_7, 2e-9);
        assert_eq!(mode.at_tip, mode.at_stop);
    }
    for (index, mode) in modes.rod.iter().enumerate() {
        let quarters = (2 * index + 1) as f64;
        close(mode.angular_frequency / TAU, 63_646.885 * quarters, 1e-8);
        close(mode.at_face.abs(), 96.225_044_9, 1e-9);
        close(mode.participation, 0.013_231_89 / quarters, 3e-7);
    }
}

#[test]
fn shapes_at_mid_span() {
    let middle = StopParameters { position_m: 25e-3, ..stop(10) };
    let modes = BumpStopModes::new(&parameters(10), Some(&middle));
    let table = [
        10.856_058_2,
        22.819_058_7,
        0.629_499_6,
        -22.609_716_1,
        0.027_224_2,
        22.609_337_5,
        0.001_176_5,
        -22.609_336_8,
        0.000_050_8,
        22.609_336_8,
    ];
    for (mode, expected) in modes.beam.iter().zip(table) {
        assert!((mode.at_stop - expected).abs() < 6e-8, "{} {expected}", mode.at_stop);
    }
    close(modes.beam_residual, 4.0451e-9, 2e-5);
    close((modes.beam_residual + modes.rod_residual).recip(), 1.8210e8, 5e-5);
}

/// Sums over all modes are static solutions of the beam: the kept ones, and the rest with the asymptotic
/// `λ = (i − ½) π`, `σ = 1`, right to rounding from the twelfth on.
#[test]
fn all_modes_together_give_the_static_beam() {
    let from = parameters(20);
    let modes = BumpStopModes::new(&from, Some(&stop(20)));
    let (length, mass, stiffness) = (from.beam_length_m, modes.beam_mass, modes.bending_stiffness);
    let root_mass = mass.sqrt();
    let scale = (stiffness / (mass * length.powi(3))).sqrt();
    let moment = modes.beam[0].coupling * length * root_mass
        / (2.0 * modes.beam[0].eigenvalue * shape_ratio(modes.beam[0].eigenvalue));
    let asymptotic = (21..200_000).map(|i| {
        let eigenvalue = (f64::from(i) - 0.5) * PI;
        // Signs of θ and φ are the same, that of γ is always positive: only products of the first two and
        // squares keep it.
        let sign = if i % 2 == 1 { 1.0 } else { -1.0 };
        BeamMode {
            eigenvalue,
            angular_frequency: eigenvalue * eigenvalue * scale,
            participation: 2.0 * root_mass / eigenvalue,
            coupling: sign * moment * 2.0 * eigenvalue / (length * root_mass),
            clamp_curvature: 2.0 * eigenvalue * eigenvalue / (length * length * root_mass),
            at_tip: sign * 2.0 / root_mass,
            at_stop: sign * 2.0 / root_mass,
        }
    });
    let tail: Vec<BeamMode> = asymptotic.collect();
    let sum = |of: &dyn Fn(&BeamMode) -> f64| {
        tail.iter().rev().map(of).sum::<f64>() + modes.beam.iter().rev().map(of).sum::<f64>()
    };
    let square = |mode: &BeamMode| mode.angular_frequency * mode.angular_frequency;
    // What the tail leaves out of the sums that fall with 1/λ² only.
    let slow = 1e-5;
    close(sum(&|mode| mode.participation.powi(2)), mass, slow);
    close(sum(&|mode| mode.at_tip.powi(2) / square(mode)), length.powi(3) / (3.0 * stiffness), 1e-12);
    close(sum(&|mode| mode.at_tip * mode.participation / square(mode)), 6.812_335e-7, 1e-7);
    close(sum(&|mode| mode.coupling * mode.participation / square(mode)), 8.564_079e-10, 1e-7);
    close(sum(&|mode| mode.coupling * mode.at_tip / square(mode)), 6.566_71e-7, 1e-6);
    close(sum(&|mode| mode.coupling.powi(2) / square(mode)) / modes.capacitance, 0.077_733_4, slow);
    // The curvature at the clamp: of a force at the tip, a uniform load, and a moment at the tip.
    let clamp = |of: &dyn Fn(&BeamMode) -> f64| sum(&|mode| mode.clamp_curvature * of(mode) / square(mode));
    close(clamp(&|mode| mode.at_stop), length / stiffness, 1e-7);
    close(clamp(&|mode| mode.participation), 0.5 * mass * length / stiffness, 1e-7);
    close(clamp(&|mode| mode.coupling), moment / stiffness, slow);
    for (residual, of) in modes.clamp_residual.into_iter().zip([
        (|mode| mode.at_stop) as fn(&BeamMode) -> f64,
        |mode| mode.participation,
        |mode| mode.coupling,
    ]) {
        let left: f64 = tail.iter().rev().map(|mode| mode.clamp_curvature * of(mode) / square(mode)).sum();
        close(residual, left, 1e-3);
    }
    let ten = BumpStopModes::new(&parameters(10), None);
    let modal: f64 = ten.beam.iter().map(|mode| mode.coupling.powi(2) / square(mode)).sum();
    close(modal / ten.capacitance, 0.074_585_6, 1e-6);
    // The residual is the sum of the tail.
    let left: f64 = tail.iter().rev().map(|mode| mode.at_tip.powi(2) / square(mode)).sum();
    close(modes.beam_residual, left, 1e-6);
    let rod = modes.rod.iter().map(|mode| (mode.at_face / mode.angular_frequency).powi(2)).sum::<f64>();
    close(rod + modes.rod_residual, 1.0 / 1.4e7, 1e-12);
    let mass: f64 = 2700.0 * 20e-3 * 4e-6;
    let speed = (70e9 / 2700.0f64).sqrt();
    let left: f64 = (20..200_000)
        .rev()
        .map(|j| {
            let frequency = f64::from(2 * j + 1) * PI * speed / 40e-3;
            2.0 / mass / (frequency * frequency)
        })
        .sum();
    close(modes.rod_residual, left, 2e-4);
}
