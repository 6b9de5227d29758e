//! The bump-stop beam with a tip mass: the core against finite elements and against the reference.

use std::f64::consts::TAU;

use cross_crate_tests::{assert_close, fixed, on_all_cores, reference, run_beam, shipped};
use host_bench::method::Options;
use host_bench::outcome::Outcome;
use host_bench::scene_file::Scene;
use model_core::part::load::Resistor;
use model_core::part::monomorph::Layer;
use model_core::scene::bump_stop::{Choices, NoStop, Parameters, Resistive, TipMass, TwoWay};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

type Loaded = Choices<Resistive<Resistor<f64>>, NoStop, TwoWay, TipMass<f64>>;

/// 50 × 10 mm of 0.5 mm steel and 0.5 mm PZT-5A, with a body at its tip.
fn parameters(body: TipMass<f64>, resistance: f64) -> Parameters<f64, Loaded> {
    Parameters {
        beam_length: 0.05,
        beam_width: 0.01,
        substrate: Layer { thickness: 5e-4, young_modulus: 200e9, density: 7850.0 },
        piezo: Layer { thickness: 5e-4, young_modulus: 66e9, density: 7800.0 },
        piezo_d31: -190e-12,
        piezo_permittivity: 15.93e-9,
        damping_ratio: 0.01,
        choices: Choices::new(Resistor { resistance }).tip_mass(body),
    }
}

/// A point, a block behind the end, a long arm, and a light plate: mass in kg, radius of gyration and offset in m.
fn bodies() -> [TipMass<f64>; 4] {
    [[4e-3, 0.0, 0.0], [3e-3, 2.7e-3, 4e-3], [8e-3, 15e-3, 20e-3], [4e-4, 10e-3, 5e-3]]
        .map(|[mass, gyration, offset]| TipMass { mass, rotary_inertia: mass * gyration * gyration, offset })
}

/// The modes of Hermite beam elements with consistent masses, clamped at the first node, with a rigid body at the last.
struct Elements {
    angular_frequencies: Vec<f64>,
    /// Participation of the base acceleration in √kg, slope and displacement at the tip, by mode.
    participations: Vec<f64>,
    tip_slopes: Vec<f64>,
    tips: Vec<f64>,
}

impl Elements {
    fn new(parameters: &Parameters<f64, Loaded>, count: usize) -> Self {
        let section = parameters.section();
        let body = parameters.choices.tip_mass;
        let h = parameters.beam_length / count as f64;
        let size = 2 * (count + 1);
        let mut stiffness = DMatrix::<f64>::zeros(size, size);
        let mut mass = DMatrix::<f64>::zeros(size, size);
        let bending = section.bending_stiffness / h.powi(3);
        let inertia = section.mass_per_length * h / 420.0;
        let (h2, h4) = (h * h, 4.0 * h * h);
        let own_stiffness = [
            [12.0, 6.0 * h, -12.0, 6.0 * h],
            [6.0 * h, h4, -6.0 * h, 2.0 * h2],
            [-12.0, -6.0 * h, 12.0, -6.0 * h],
            [6.0 * h, 2.0 * h2, -6.0 * h, h4],
        ];
        let own_mass = [
            [156.0, 22.0 * h, 54.0, -13.0 * h],
            [22.0 * h, h4, 13.0 * h, -3.0 * h2],
            [54.0, 13.0 * h, 156.0, -22.0 * h],
            [-13.0 * h, -3.0 * h2, -22.0 * h, h4],
        ];
        for element in 0..count {
            for row in 0..4 {
                for column in 0..4 {
                    let place = (2 * element + row, 2 * element + column);
                    stiffness[place] += bending * own_stiffness[row][column];
                    mass[place] += inertia * own_mass[row][column];
                }
            }
        }
        let (end, turn) = (size - 2, size - 1);
        mass[(end, end)] += body.mass;
        mass[(end, turn)] += body.mass * body.offset;
        mass[(turn, end)] += body.mass * body.offset;
        mass[(turn, turn)] += body.rotary_inertia + body.mass * body.offset.powi(2);
        // The base moves every node by the same displacement.
        let together = DVector::from_fn(size, |row, _| if row % 2 == 0 { 1.0 } else { 0.0 });
        let free = size - 2;
        let load = (&mass * together).rows(2, free).into_owned();
        let stiffness = stiffness.view((2, 2), (free, free)).into_owned();
        let mass = mass.view((2, 2), (free, free)).into_owned();
        // 1/ω² are the eigenvalues of K^(-1/2) M K^(-1/2): of the low modes, which are wanted, the large ones.
        let factor = stiffness.cholesky().expect("positive definite").l();
        let half = factor.solve_lower_triangular(&mass).expect("regular");
        let whole = factor.solve_lower_triangular(&half.transpose()).expect("regular");
        let SymmetricEigen { eigenvalues, eigenvectors } =
            SymmetricEigen::new(0.5 * (&whole + whole.transpose()));
        let mut order: Vec<usize> = (0..free).collect();
        order.sort_by(|a, b| eigenvalues[*b].total_cmp(&eigenvalues[*a]));
        let mut found =
            Self { angular_frequencies: vec![], participations: vec![], tip_slopes: vec![], tips: vec![] };
        let back = factor.transpose();
        for index in order {
            let omega = eigenvalues[index].max(f64::MIN_POSITIVE).sqrt().recip();
            // A modal mass of one: Φ = K^(-T/2) z ω.
            let mode = back.solve_upper_triangular(&eigenvectors.column(index)).expect("regular") * omega;
            // The core's shapes begin with a positive curvature: the first node moves up.
            let mode = if mode[0] < 0.0 { -mode } else { mode };
            found.angular_frequencies.push(omega);
            found.participations.push(mode.dot(&load));
            found.tip_slopes.push(mode[free - 1]);
            found.tips.push(mode[free - 2]);
        }
        found
    }
}

/// Elements of cubic shape have a frequency error of the fourth order in their length.
#[test]
fn finite_elements_converge_to_the_frequencies_at_order_four() {
    for body in bodies() {
        let parameters = parameters(body, 1e5);
        let counts = [8, 16, 32];
        let elements = counts.map(|count| Elements::new(&parameters, count));
        for number in 1..=4 {
            let exact = parameters.beam_mode(number as u32).angular_frequency;
            let errors = elements.each_ref().map(|found| found.angular_frequencies[number - 1] / exact - 1.0);
            println!("{body:?} {number}: {exact} {errors:?}");
            // The elements are stiffer, by (λ h/L)⁴/1440 of a free end.
            assert!(errors[0] > 0.0 && errors[1] > 0.0, "{body:?} {number} {errors:?}");
            assert!(errors[1] < 1e-3);
            let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
            // Below 1e-9 the eigenvalues of the matrices are rounded.
            for (order, error) in orders.into_iter().zip(&errors[1..]) {
                assert!(*error < 1e-9 || (order - 4.0).abs() < 0.15, "{body:?} {number} {orders:?}");
            }
        }
    }
}

#[test]
fn finite_elements_have_the_same_participations_slopes_and_response() {
    let resistance = 3e4;
    for body in bodies() {
        let parameters = parameters(body, resistance);
        let elements = Elements::new(&parameters, 64);
        let section = parameters.section();
        let whole = (section.mass_per_length * parameters.beam_length + body.mass).sqrt();
        for number in 1..=6 {
            let mode = parameters.beam_mode(number as u32);
            let found = elements.participations[number - 1];
            assert!((found - mode.base_coupling).abs() < 1e-6 * whole, "{body:?} {number} {found}");
            let tip = mode.shape(1.0);
            let clamp = mode.shape(0.0).curvature / mode.eigenvalue.powi(2);
            let slope = elements.tip_slopes[number - 1] * parameters.beam_length;
            assert!((elements.tips[number - 1] - tip.value).abs() < 1e-5 * clamp, "{body:?} {number}");
            assert!((slope - tip.slope).abs() < 1e-5 * clamp * mode.eigenvalue, "{body:?} {number}");
        }
        // v (jωC + 1/R + Σ jωθ²/D) = −B Σ jωθγ/D, with six modes.
        let scene = parameters.build::<6, 0>().expect("valid");
        let capacitance = section.capacitance_per_length * parameters.beam_length;
        let first = elements.angular_frequencies[0] / TAU;
        for frequency in [
            0.3 * first,
            0.97 * first,
            first,
            1.02 * first,
            3.0 * first,
            0.9 * elements.angular_frequencies[1] / TAU,
        ] {
            let omega = TAU * frequency;
            let mut driven = nalgebra::Complex::new(0.0, 0.0);
            let mut admittance = nalgebra::Complex::new(resistance.recip(), omega * capacitance);
            for mode in 0..6 {
                let natural = elements.angular_frequencies[mode];
                let theta = section.coupling * elements.tip_slopes[mode];
                let denominator =
                    nalgebra::Complex::new(natural * natural - omega * omega, 2.0 * 0.01 * natural * omega);
                let current = nalgebra::Complex::new(0.0, omega * theta) / denominator;
                driven -= current * elements.participations[mode];
                admittance += current * theta;
            }
            let expected = (driven / admittance).norm() / 2f64.sqrt();
            let found = scene.closed_form(1.0, frequency).rms_voltage;
            assert!((found / expected - 1.0).abs() < 2e-5, "{body:?} {frequency} Hz: {found} {expected}");
        }
    }
}

/// The shipped scene with a tip mass, with these keys changed.
fn loaded(changes: &[(&str, &str)]) -> Scene {
    shipped("bump-stop-tip-mass", changes)
}

fn compare(what: &str, scene: &Scene, options: &Options, tolerance: f64) {
    let ((found, core), (exact, by_reference)) = (run_beam(scene, options), run_beam(scene, &reference()));
    println!("{what}: {core:?}\n{by_reference:?}");
    let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let (clamp, exact_clamp) = (core.clamp.expect("measured"), by_reference.clamp.expect("measured"));
    for (quantity, found, exact) in [
        ("power", number(found.mean_power_w), number(exact.mean_power_w)),
        ("voltage", number(found.peak_voltage_v), number(exact.peak_voltage_v)),
        ("tip", number(core.peak_tip_displacement_m), number(by_reference.peak_tip_displacement_m)),
        ("curvature", clamp.clamp_curvature_peak_per_m, exact_clamp.clamp_curvature_peak_per_m),
        ("RMS of the stress", clamp.piezo_clamp_stress_rms_pa, exact_clamp.piezo_clamp_stress_rms_pa),
    ] {
        assert_close(&format!("{what}: {quantity}"), found, exact, tolerance);
    }
    assert_eq!(core.contacts, by_reference.contacts, "{what}");
    let bound = number(exact.energy_residual).max(number(found.energy_residual));
    assert!(bound < 1e-9, "{what}: {bound}");
}

/// The reference derives the modes again. Before the stop is reached to 10⁻³, over the first contacts to a hundredth.
#[test]
fn the_core_is_the_reference() {
    let few = [("parameters.beam_modes", "5"), ("stop.rod_modes", "2")];
    let with = |more: &[(&'static str, &'static str)]| [&few[..], more].concat();
    let free = with(&[("stop.gap_m", "1e-2"), ("run.settle_s", "0.05"), ("run.duration_s", "0.15")]);
    compare("free", &loaded(&free), &Options::default(), 1e-3);
    for (name, position) in [("tip", "30e-3"), ("mid-span", "15e-3")] {
        let gap = if name == "tip" { "60e-6" } else { "15e-6" };
        let changes = with(&[
            ("stop.position_m", position),
            ("stop.gap_m", gap),
            ("run.settle_s", "0"),
            ("run.duration_s", "25e-3"),
        ]);
        compare(name, &loaded(&changes), &fixed(2e-7), 1e-2);
    }
    let one_way = with(&[
        ("parameters.coupling", "one-way"),
        ("stop.gap_m", "60e-6"),
        ("run.settle_s", "0"),
        ("run.duration_s", "25e-3"),
    ]);
    compare("one-way", &loaded(&one_way), &fixed(2e-7), 1e-2);
}

/// The statistics of the shipped scene as it is.
#[test]
#[ignore = "nightly: half a minute"]
fn the_statistics_of_the_shipped_scene_are_those_of_the_reference() {
    on_all_cores(&["bump-stop-tip-mass"], |_| {
        let scene = loaded(&[]);
        let ((found, _), (exact, _)) =
            (run_beam(&scene, &Options::default()), run_beam(&scene, &reference()));
        let power = |outcome: &Outcome| outcome.mean_power_w.expect("measured");
        assert_close("power", power(&found), power(&exact), 0.03);
    });
}
