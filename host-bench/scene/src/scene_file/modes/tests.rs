//! Published eigenvalues, closed sums over all modes, and the modes of a published unimorph.

use super::*;
use crate::scene_file::TipMassParameters;
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

/// The form without overflow is the textbook's where that can be computed, and orthonormal where not.
#[test]
fn shapes_are_the_textbooks_and_orthonormal() {
    for index in 0..4 {
        let eigenvalue = eigenvalue(index);
        let ratio = shape_ratio(eigenvalue);
        for place in [0.0, 0.1, 0.37, 0.5, 0.82, 1.0] {
            let u = eigenvalue * place;
            let textbook = u.cosh() - u.cos() - ratio * (u.sinh() - u.sin());
            assert!((shape(eigenvalue, place) - textbook).abs() < 1e-9, "{index} {place}");
        }
    }
    // Simpson's rule on 4000 pieces.
    let mean = |f: &dyn Fn(f64) -> f64| {
        let weight = |k: u32| if k == 0 || k == 4000 { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
        (0..=4000).map(|k| weight(k) * f(f64::from(k) / 4000.0)).sum::<f64>() / 12_000.0
    };
    for (one, other) in [(0, 0), (0, 1), (4, 4), (9, 9), (9, 8), (19, 19), (19, 17)] {
        let (first, second) = (eigenvalue(one), eigenvalue(other));
        let found = mean(&|place| shape(first, place) * shape(second, place));
        let expected = if one == other { 1.0 } else { 0.0 };
        assert!((found - expected).abs() < 1e-6, "{one} {other}: {found}");
    }
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

#[test]
fn compliance_of_the_modes_left_out() {
    for (beam, rod, beam_residual, rod_residual, stiffness) in [
        (3, 0, 6.703e-7, 7.143e-8, 1.348e6),
        (4, 0, 2.891e-7, 7.143e-8, 2.774e6),
        (4, 1, 2.891e-7, 1.353e-8, 3.305e6),
        (6, 1, 8.707e-8, 1.353e-8, 9.940e6),
        (6, 2, 8.707e-8, 7.098e-9, 1.0619e7),
        (8, 3, 3.695e-8, 4.782e-9, 2.396e7),
        (10, 3, 1.897e-8, 4.782e-9, 4.210e7),
        (10, 10, 1.8972e-8, 1.4462e-9, 4.8976e7),
    ] {
        let modes = BumpStopModes::new(&parameters(beam), Some(&stop(rod)));
        close(modes.beam_residual, beam_residual, 2e-4);
        close(modes.rod_residual, rod_residual, 1e-4);
        close((modes.beam_residual + modes.rod_residual).recip(), stiffness, 3e-4);
    }
}

/// Erturk and Inman, J. Vib. Acoust. 130 (2008): 47.8 and 299.6 Hz short-circuit, 48.8 and 301.5 Hz open.
#[test]
fn the_published_unimorph() {
    let unimorph = BumpStopParameters {
        beam_length_m: 100e-3,
        beam_width_m: 20e-3,
        substrate_thickness_m: 0.5e-3,
        substrate_young_modulus_pa: 100e9,
        substrate_density_kg_per_m3: 7165.0,
        piezo_thickness_m: 0.4e-3,
        ..parameters(10)
    };
    let modes = BumpStopModes::new(&unimorph, None);
    close(modes.capacitance, 79.65e-9, 1e-12);
    close(modes.bending_stiffness, 0.097_847, 1e-5);
    // With the load open, v = Σθr/C: the stiffness rises by θθᵀ/C.
    let size = modes.beam.len();
    let stiffness = nalgebra::DMatrix::from_fn(size, size, |row, column| {
        let (one, other) = (&modes.beam[row], &modes.beam[column]);
        let own = if row == column { one.angular_frequency.powi(2) } else { 0.0 };
        own + one.coupling * other.coupling / modes.capacitance
    });
    let mut open: Vec<f64> =
        stiffness.symmetric_eigenvalues().iter().map(|square| square.sqrt() / TAU).collect();
    open.sort_by(f64::total_cmp);
    let [short, _] = modes.natural_frequencies_hz();
    for (found, published) in [(short[0], 47.8), (short[1], 299.6), (open[0], 48.8), (open[1], 301.5)] {
        assert!((found - published).abs() < 0.1, "{found} {published}");
    }
    for (found, expected) in [(short[0], 47.809), (short[1], 299.615), (short[2], 838.931)] {
        close(found, expected, 2e-5);
    }
}

/// The beam of the shipped scene with a body of so many beam masses, a radius of gyration and an offset in lengths.
fn with_body(beam_modes: usize, [mass, gyration, offset]: [f64; 3]) -> BumpStopParameters {
    let free = parameters(beam_modes);
    let (length, mass) = (free.beam_length_m, mass * 3.9125e-3);
    let body = TipMassParameters {
        mass_kg: mass,
        rotary_inertia_kg_m2: mass * (gyration * length).powi(2),
        offset_m: offset * length,
    };
    BumpStopParameters { tip_mass: Some(body), ..free }
}

/// `λ²` of a point mass of the beam's mass: Math. Probl. Eng. (2017) 1568019, table 1, without rotary inertia.
#[test]
fn a_tip_mass_has_its_published_eigenvalues() {
    let modes = BumpStopModes::new(&with_body(5, [1.0, 0.0, 0.0]), None);
    for (mode, square) in modes.beam.iter().zip([1.557_298, 16.250_09, 50.895_84, 105.198_3, 179.232_0]) {
        close(mode.eigenvalue.powi(2), square, 4e-7);
    }
    // Without mass it is the free end, in every number.
    let (none, free) = (with_body(20, [0.0; 3]), parameters(20));
    let middle = StopParameters { position_m: 20e-3, ..stop(2) };
    let [none, free] = [none, free].map(|from| BumpStopModes::new(&from, Some(&middle)));
    for (found, mode) in none.beam.iter().zip(&free.beam) {
        close(found.angular_frequency, mode.angular_frequency, 1e-12);
        close(found.participation, mode.participation, 1e-10);
        close(found.coupling, mode.coupling, 1e-10);
        close(found.clamp_curvature, mode.clamp_curvature, 1e-10);
        close(found.at_tip, mode.at_tip, 1e-10);
        assert!((found.at_stop - mode.at_stop).abs() < 1e-10 * mode.at_tip.abs());
    }
}

/// Of all modes together mass, static deflection and static curvature are known; of twenty nearly all is there.
#[test]
fn the_modes_with_a_tip_mass_make_the_static_beam() {
    for shape in [[0.01, 0.1, 0.1], [1.0, 0.0, 0.0], [2.0, 0.05, 0.08], [10.0, 0.3, 0.4], [300.0, 0.1, 0.2]] {
        let from = with_body(20, shape);
        let modes = BumpStopModes::new(&from, Some(&stop(2)));
        assert_eq!(modes.beam.len(), 20);
        let (length, rigidity) = (from.beam_length_m, modes.bending_stiffness);
        let body = from.tip_mass.expect("there is a body");
        let sum = |of: &dyn Fn(&BeamMode) -> f64| modes.beam.iter().map(of).sum::<f64>();
        let square = |mode: &BeamMode| mode.angular_frequency.powi(2);
        let whole = modes.beam_mass + body.mass_kg;
        let mass = sum(&|mode| mode.participation.powi(2));
        assert!(mass < whole * (1.0 + 1e-12) && mass > 0.97 * whole, "{shape:?} {}", mass / whole);
        let cube = length.powi(3) / rigidity;
        close(sum(&|mode| mode.at_tip.powi(2) / square(mode)), cube / 3.0, 1e-4);
        let arm = length / 3.0 + 0.5 * body.offset_m;
        let weight = modes.beam_mass * cube / 8.0 + body.mass_kg * length.powi(2) * arm / rigidity;
        close(sum(&|mode| mode.at_tip * mode.participation / square(mode)), weight, 1e-6);
        let moment = 0.5 * modes.beam_mass * length + body.mass_kg * (length + body.offset_m);
        let bent = sum(&|mode| mode.clamp_curvature * mode.participation / square(mode));
        close(bent, moment / rigidity, 1e-3);
        close(bent + modes.clamp_residual[1], moment / rigidity, 1e-12);
    }
}
