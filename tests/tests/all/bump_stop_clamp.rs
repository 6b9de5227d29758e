//! The bending of the beam at its clamp: the core against the reference, and its closed forms.

use cross_crate_tests::{assert_close, fixed, on_all_cores, reference, run_beam, shipped};
use host_bench::method::Options;
use host_bench::outcome::ClampOutcome;
use host_bench::scene_file::Scene;

fn clamp(scene: &Scene, options: &Options) -> ClampOutcome {
    run_beam(scene, options).1.clamp.expect("a bump-stop run has it")
}

fn compare(what: &str, scene: &Scene, options: &Options, tolerances: [f64; 2]) {
    let (found, exact) = (clamp(scene, options), clamp(scene, &reference()));
    println!("{what}: {found:?}\n{exact:?}");
    let [peak, rms] = tolerances;
    for (quantity, found, exact, tolerance) in [
        ("peak", found.clamp_curvature_peak_per_m, exact.clamp_curvature_peak_per_m, peak),
        ("RMS", found.clamp_curvature_rms_per_m, exact.clamp_curvature_rms_per_m, rms),
        ("stress", found.clamp_stress_peak_pa, exact.clamp_stress_peak_pa, peak),
        ("stress of the piezo", found.piezo_clamp_stress_rms_pa, exact.piezo_clamp_stress_rms_pa, rms),
        ("strain of the piezo", found.piezo_clamp_strain_peak, exact.piezo_clamp_strain_peak, peak),
        (
            "largest range",
            found.clamp_stress_largest_range_pa,
            exact.clamp_stress_largest_range_pa,
            2.0 * peak,
        ),
    ] {
        assert_close(&format!("{what}: {quantity}"), found, exact, tolerance);
    }
}

/// Without a stop to 10⁻³, over the first contacts to a hundredth: before the motion depends on every rounding.
#[test]
fn the_curvature_at_the_clamp_is_that_of_the_reference() {
    let short = [("run.settle_s", "0.02"), ("run.duration_s", "0.04")];
    compare("no stop", &shipped("bump-stop-none", &short), &Options::default(), [1e-3, 1e-3]);
    for (name, position) in [("tip", "50e-3"), ("mid-span", "25e-3")] {
        let changes = [
            ("stop.position_m", position),
            ("parameters.beam_modes", "6"),
            ("stop.rod_modes", "2"),
            ("run.settle_s", "0"),
            ("run.duration_s", "6e-3"),
        ];
        compare(name, &shipped("bump-stop", &changes), &fixed(2e-7), [1e-2, 1e-2]);
    }
}

/// A base acceleration far below the first frequency bends the clamp as a uniform load: `m' L² a/2EI`, times
/// `1/(1 − (f/f₁)²)` of the first mode, which has nearly all of it.
#[test]
fn a_slow_base_bends_the_clamp_as_a_uniform_load() {
    let changes = [
        ("excitation.frequency_hz", "5"),
        ("load.resistance_ohm", "0"),
        ("run.settle_s", "0.6"),
        ("run.duration_s", "1.0"),
    ];
    let found = clamp(&shipped("bump-stop-none", &changes), &Options::default());
    let (mass_per_length, length, rigidity) = (0.078_25, 50e-3_f64, 0.089_738_408_5);
    let still = 0.5 * mass_per_length * length * length * 20.0 / rigidity;
    let expected = still / (1.0 - (5.0_f64 / 239.705_436).powi(2));
    assert_close("peak", found.clamp_curvature_peak_per_m, expected, 1e-3);
    assert_close("RMS", found.clamp_curvature_rms_per_m, expected / 2.0_f64.sqrt(), 1e-3);
    assert_close("stress", found.clamp_stress_peak_pa, 200e9 * 0.374_060_150e-3 * expected, 1e-3);
    assert_close("piezo", found.piezo_clamp_stress_peak_pa, 66e9 * 0.625_939_850e-3 * expected, 1e-3);
    // Two periods of a sine.
    assert!((found.clamp_stress_cycles - 2.0).abs() <= 0.5, "{}", found.clamp_stress_cycles);
}

/// Driven at its first natural frequency, short-circuited, the beam has `r = γ₁ A/2ζω₁²` of its first mode, and the
/// curvature `2 λ² r/(L² √m_b)`, a quarter of a period behind what the other modes have.
#[test]
fn at_the_first_resonance_the_clamp_has_the_bending_of_the_first_mode() {
    let (length, mass, frequency, participation) = (50e-3_f64, 3.9125e-3_f64, 239.705_436, 0.048_976_12);
    let changes = [
        ("excitation.frequency_hz", "239.705436"),
        ("load.resistance_ohm", "0"),
        ("run.settle_s", "0.6"),
        ("run.duration_s", "0.8"),
    ];
    let found = clamp(&shipped("bump-stop-none", &changes), &Options::default());
    let omega = std::f64::consts::TAU * frequency;
    let displacement = participation * 20.0 / (2.0 * 0.01 * omega * omega);
    let expected = 2.0 * 1.875_104_07_f64.powi(2) / (length * length * mass.sqrt()) * displacement;
    let steel = 200e9 * 0.374_060_150e-3 * expected;
    assert_close("peak", found.clamp_curvature_peak_per_m, expected, 1e-3);
    assert_close("RMS", found.clamp_curvature_rms_per_m, expected / 2.0_f64.sqrt(), 1e-3);
    assert_close("stress", found.clamp_stress_peak_pa, steel, 1e-3);
    assert_close("range", found.clamp_stress_largest_range_pa, 2.0 * steel, 1e-3);
    assert_close("strain of the piezo", found.piezo_clamp_strain_peak, 0.625_939_850e-3 * expected, 1e-3);
    // A cycle in each of 48 periods; the first and the last are cut.
    assert!((found.clamp_stress_cycles - 0.2 * frequency).abs() <= 1.0, "{}", found.clamp_stress_cycles);
    let equivalent = 2.0 * steel * frequency.powf(0.2);
    assert_close("equivalent range", found.clamp_stress_equivalent_range_pa, equivalent, 1e-2);
}

/// With a tip mass `M` and its centre at `d` beyond the tip the load has the moment `[m_b L/2 + M (L + d)] a`.
#[test]
fn a_slow_base_bends_the_clamp_by_the_weight_of_beam_and_tip_mass() {
    let changes = [
        ("excitation.frequency_hz", "2"),
        ("load.resistance_ohm", "0"),
        ("stop.gap_m", "0.01"),
        ("parameters.damping_ratio", "0.1"),
        ("run.settle_s", "1.0"),
        ("run.duration_s", "2.0"),
    ];
    let scene = shipped("bump-stop-tip-mass", &changes);
    let (_, found) = run_beam(&scene, &Options::default());
    let clamp = found.clamp.expect("measured");
    // Steel and PZT-5H of 0.2 mm each, 20 mm wide: the neutral axis is as far from the middle as the stiffnesses differ.
    let (width, thickness, length) = (20e-3, 0.2e-3, 30e-3);
    let (steel, piezo) = (200e9, 60.6e9);
    let neutral = 0.5 * thickness + thickness * piezo / (steel + piezo);
    let own = thickness * thickness / 12.0;
    let [to_steel, to_piezo] = [neutral - 0.5 * thickness, 1.5 * thickness - neutral];
    let rigidity =
        width * thickness * (steel * (own + to_steel * to_steel) + piezo * (own + to_piezo * to_piezo));
    let beam = width * thickness * (7850.0 + 7500.0) * length;
    let moment = 5.0 * (0.5 * beam * length + 6.28e-3 * (length + 5e-3));
    let first = found.beam_natural_frequencies_hz[0];
    let expected = moment / rigidity / (1.0 - (2.0 / first).powi(2));
    assert_close("peak", clamp.clamp_curvature_peak_per_m, expected, 1e-3);
    assert_close("stress", clamp.clamp_stress_peak_pa, steel * neutral * expected, 1e-3);
    assert_close(
        "piezo",
        clamp.piezo_clamp_stress_peak_pa,
        piezo * (2.0 * thickness - neutral) * expected,
        1e-3,
    );
}

/// A free oscillation of one mode turns at `−e^(−πζ/√(1−ζ²))` of the turn before.
#[test]
fn the_largest_range_at_the_clamp_is_between_turning_points() {
    let changes = [
        ("parameters.beam_modes", "1"),
        ("parameters.damping_ratio", "0.236"),
        ("load.resistance_ohm", "0"),
        ("excitation", "{kind=\"silence\"}"),
        ("initial.modal_velocity", "[1e-3]"),
        ("run", "{settle_s=0,duration_s=0.05}"),
    ];
    let ratio = 1.0 + (-std::f64::consts::PI * 0.236 / (1.0_f64 - 0.236 * 0.236).sqrt()).exp();
    for (options, tolerance) in [(Options::default(), 1e-6), (reference(), 1e-5)] {
        let found = clamp(&shipped("bump-stop-none", &changes), &options);
        let (range, peak) = (found.clamp_stress_largest_range_pa, found.clamp_stress_peak_pa);
        assert_close("range", range, ratio * peak, tolerance);
    }
}

/// The statistics of a long run; a stop near the resonance halves the peak.
#[test]
#[ignore = "half a minute"]
fn the_statistics_at_the_clamp_are_those_of_the_reference() {
    let scenes = ["bump-stop-tip", "bump-stop-mid-span", "bump-stop-below-resonance"];
    on_all_cores(&scenes, |name| {
        let scene = shipped(name, &[("run.settle_s", "0.5"), ("run.duration_s", "1.0")]);
        compare(name, &scene, &Options::default(), [0.1, 0.03]);
    });
}
