//! The bending of the beam at its clamp: the core against the reference, and its closed forms.

use std::path::Path;

use cross_crate_tests::{assert_close, fixed, on_all_cores, reference};
use host_bench::method::Options;
use host_bench::outcome::ClampOutcome;
use host_bench::run::run_scene;
use host_bench::scene_file::{self, Override, Scene};

/// A shipped scene with these keys changed.
fn shipped(name: &str, changes: &[(&str, &str)]) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-bench/scenes").join(name);
    let overrides: Vec<Override> = changes.iter().map(|(key, value)| Override::new(key, value)).collect();
    scene_file::read(&file.with_extension("toml"), &overrides).expect("the scene is valid")
}

fn clamp(scene: &Scene, options: &Options) -> ClampOutcome {
    let outcome = run_scene(scene, options).unwrap_or_else(|failure| panic!("{failure}"));
    outcome.bump_stop().and_then(|found| found.clamp).expect("a bump-stop run has it")
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

/// The statistics of a long run; a stop near the resonance halves the peak.
#[test]
#[ignore = "half a minute"]
fn the_statistics_at_the_clamp_are_those_of_the_reference() {
    let scenes = ["bump-stop-tip", "bump-stop-mid-span", "bump-stop-paper"];
    on_all_cores(&scenes, |name| {
        let scene = shipped(name, &[("run.settle_s", "0.5"), ("run.duration_s", "1.0")]);
        compare(name, &scene, &Options::default(), [0.1, 0.03]);
    });
}
