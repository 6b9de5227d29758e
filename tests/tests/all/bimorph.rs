//! The bimorph: the core against the reference, its connections against each other, and what the host makes of it.

use cross_crate_tests::{assert_close, fixed, outcome, reference, shipped, single, value};
use host_bench::closed_form::estimate;
use host_bench::method::{Options, Precision};
use host_bench::scene_file::Scene;

/// Erturk and Inman's bimorph with these keys changed.
fn bimorph(changes: &[(&str, &str)]) -> Scene {
    shipped("bimorph-erturk-inman", changes)
}

const BRIDGE: [(&str, &str); 3] =
    [("load.kind", "dc-bus"), ("load.voltage_v", "1.0"), ("load.diode_drop_v", "0.1")];
const STOP: [(&str, &str); 2] = [
    (
        "stop",
        "{length_m=20e-3, width_m=2e-3, thickness_m=2e-3, young_modulus_pa=70e9, density_kg_per_m3=2700.0, \
         position_m=50.8e-3, gap_m=0.1e-3, rod_modes=1, contact='residual-flexibility'}",
    ),
    ("excitation.amplitude_g", "0.3"),
];

/// Without a stop to 10⁻³, over the first contacts to a hundredth; the stress is that of the outer, piezoelectric fibre.
#[test]
fn the_core_is_the_reference() {
    let short = [("run.settle_s", "0.02"), ("run.duration_s", "0.08")];
    for connection in ["bimorph-series", "bimorph-parallel"] {
        let with = |more: &[(&'static str, &'static str)]| {
            bimorph(&[&short[..], &[("parameters.transducer", connection)], more].concat())
        };
        for (what, scene, options, tolerance) in [
            ("resistor", with(&[]), Options::default(), 1e-3),
            ("one-way", with(&[("parameters.coupling", "one-way")]), Options::default(), 1e-3),
            ("bridge", with(&BRIDGE), Options::default(), 3e-3),
            ("f32", with(&[]), single(fixed(1e-5)), 1e-3),
            ("stop", with(&STOP), fixed(5e-7), 1e-2),
        ] {
            let (found, exact) = (outcome(&scene, &options), outcome(&scene, &reference()));
            let clamps = [&found, &exact].map(|outcome| {
                let beam = outcome.bump_stop().expect("a bump-stop run");
                assert_eq!(beam.contacts > 0, what == "stop", "{what}");
                let clamp = beam.clamp.expect("measured");
                assert_close(
                    what,
                    clamp.piezo_clamp_stress_peak_pa,
                    66e9 * clamp.piezo_clamp_strain_peak,
                    1e-6,
                );
                let ratio = clamp.clamp_stress_peak_pa / clamp.piezo_clamp_stress_peak_pa;
                assert_close(what, ratio, 105.0 * 0.07 / (66.0 * 0.33), 1e-5);
                clamp
            });
            let what = format!("{connection}, {what}");
            let [core, derived_again] = [&found, &exact].map(|outcome| outcome.bump_stop().expect("a beam"));
            let pairs =
                core.beam_natural_frequencies_hz.iter().zip(&derived_again.beam_natural_frequencies_hz);
            let rounding = if what.ends_with("f32") { 1e-5 } else { 1e-11 };
            pairs.for_each(|(one, other)| assert_close(&what, *one, *other, rounding));
            assert_close(&what, value(found.mean_power_w), value(exact.mean_power_w), tolerance);
            assert_close(&what, value(found.rms_voltage_v), value(exact.rms_voltage_v), tolerance);
            let [one, other] = clamps.map(|clamp| clamp.piezo_clamp_stress_peak_pa);
            assert_close(&what, one, other, tolerance);
        }
    }
}

/// A parallel connection has half the voltage of a series one into a quarter of the resistance, and the same power and motion.
#[test]
fn the_connections_deliver_the_same_power_at_loads_of_four_to_one() {
    for resistance in [1e3, 33e3, 470e3] {
        let [series, parallel] = [("bimorph-series", resistance), ("bimorph-parallel", 0.25 * resistance)]
            .map(|(connection, load)| {
                let load = load.to_string();
                let scene =
                    bimorph(&[("parameters.transducer", connection), ("load.resistance_ohm", load.as_str())]);
                [Precision::F64, Precision::F32].map(|of| {
                    let found = estimate(&scene, of).expect("a closed form");
                    assert!(found.holds);
                    found
                })
            });
        for ((series, parallel), tolerance) in series.iter().zip(&parallel).zip([1e-12, 2e-5]) {
            assert_close("power", parallel.mean_power_w, series.mean_power_w, tolerance);
            assert_close("voltage", 2.0 * parallel.rms_voltage_v, series.rms_voltage_v, tolerance);
            assert_close("amplitude", parallel.amplitude_m, series.amplitude_m, tolerance);
        }
    }
}

/// Peak voltages of an independent program at 1 g and 45.7 Hz with four modes; the trajectory has them too.
#[test]
fn voltages_are_those_of_an_independent_program() {
    let at = [("excitation.amplitude_g", "1"), ("excitation.frequency_hz", "45.7")];
    for (resistance, one_mode, four_modes) in
        [("1e3", 1.559_170, 1.559_153), ("33e3", 28.309_411, 28.266_467), ("470e3", 54.146_220, 53.850_663)]
    {
        for (modes, expected) in [("1", one_mode), ("4", four_modes)] {
            let keys = [("parameters.beam_modes", modes), ("load.resistance_ohm", resistance)];
            let scene = bimorph(&[&at[..], &keys].concat());
            let found = estimate(&scene, Precision::F64).expect("a closed form").rms_voltage_v;
            assert_close(resistance, 2f64.sqrt() * found, expected, 1e-5);
            let steady = outcome(&scene, &Options { steady_state: true, ..Options::default() });
            assert_close(resistance, value(steady.rms_voltage_v), found, 1e-3);
        }
    }
}

/// Half the terminal voltage is across each of two layers in series.
#[test]
fn the_field_is_that_of_each_layer() {
    let field = |connection: &str| {
        let scene = bimorph(&[
            ("parameters.transducer", connection),
            ("load.resistance_ohm", "inf"),
            ("run.settle_s", "0"),
        ]);
        let outcome = outcome(&scene, &Options::default());
        let found = outcome.margins.limits.iter().find(|margin| margin.name == "piezo_field_v_per_m");
        found.expect("a limit of the scene").value / value(outcome.peak_voltage_v)
    };
    assert_close("series", field("bimorph-series"), 0.5 / 0.26e-3, 1e-2);
    assert_close("parallel", field("bimorph-parallel"), 1.0 / 0.26e-3, 1e-2);
}
