//! The margins to the limits of the models, against closed forms; what is told beyond them.

use std::f64::consts::{E, PI};

use super::tool::{BEAM, accepted, json, number, refused};
use host_bench::method::Options;
use host_bench::outcome::{Margin, Outcome};
use host_bench::run::run_scene;
use host_bench::scene_file::{self, Override, breakdown_voltage_v, fringing, shipped};

/// Runs a shipped scene with overrides `key=value`.
#[track_caller]
fn run(name: &str, overrides: &[&str]) -> Outcome {
    let of = |text: &&str| text.split_once('=').map(|(key, value)| Override::new(key, value));
    let overrides: Vec<Override> = overrides.iter().filter_map(of).collect();
    let scene = scene_file::read(&shipped(name), &overrides).expect("a valid scene");
    run_scene(&scene, &Options::default()).expect("it runs")
}

fn margin(outcome: &Outcome, name: &str) -> Margin {
    *outcome.margins.limits.iter().find(|limit| limit.name == name).expect("a limit of this scene")
}

fn warns(outcome: &Outcome, beginning: &str) -> bool {
    outcome.warnings.iter().any(|warning| warning.starts_with(beginning))
}

#[track_caller]
fn close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() < relative, "{value} instead of {expected}");
}

/// Paschen's curve has its minimum `e B ln(1 + 1/γ)/A`; from 0.1 to 10 mm it is at most a fifth above the measured voltages of
/// uniform fields in air, `24.22 d + 6.08 √d` in kV and cm.
#[test]
fn the_air_breaks_down_as_in_its_minimum_and_as_measured() {
    let minimum = E * 101f64.ln() / 11.25;
    close(breakdown_voltage_v(minimum * (1.0 + 1e-9)), 273.8 * minimum, 1e-6);
    assert_eq!(breakdown_voltage_v(0.999 * minimum), f64::INFINITY);
    assert_eq!(breakdown_voltage_v(0.0), f64::INFINITY);
    for gap_m in [1e-4, 3e-4, 1e-3, 3e-3, 1e-2] {
        let gap_cm: f64 = 100.0 * gap_m;
        let ratio = breakdown_voltage_v(101_325.0 * gap_m) / (24_220.0 * gap_cm + 6080.0 * gap_cm.sqrt());
        assert!((0.95..1.2).contains(&ratio), "{gap_m} m: {ratio}");
    }
}

/// The capacitance of two discs by Love's integral equation, solved by Gauss's quadrature with 160 points.
#[test]
fn the_fringing_field_is_that_of_loves_equation() {
    let exact =
        [(0.05, 0.097_033), (0.1, 0.175_592), (0.27, 0.411_945), (1.0, 1.318_295), (20.0, 25.300_574)];
    for (distance_over_radius, expected) in exact {
        close(fringing(distance_over_radius * 0.01, PI * 1e-4), expected, 0.04);
    }
    let rising = (1..2000).map(|step| fringing(1e-4 * 1.01f64.powi(step), 1e-4)).collect::<Vec<_>>();
    assert!(rising.is_sorted() && fringing(0.0, 1e-4) == 0.0);
}

/// 50 µC/m² over 3 mm without charge on the electrodes are 16.9 kV, beside any parasitic capacitance and at any load; half the
/// pressure nearly halves what the air holds.
#[test]
fn an_uncharged_electrode_over_a_charged_dielectric_is_beyond_paschens_curve() {
    let still = ["excitation={kind='silence'}", "load.resistance_ohm=inf", "initial.charge_c=0"];
    let short = ["run={duration_s=0.1, settle_s=0.05}", "parameters.parasitic_capacitance_f=0"];
    let at_start = [&still[..], &short].concat();
    let outcome = run("contact-separation-passive", &at_start);
    let found = margin(&outcome, "gap_voltage_v");
    let volts = 50e-6 * 3e-3 / 8.854_187_8e-12;
    for beside in ["parameters.parasitic_capacitance_f=1e-11", "load.resistance_ohm=1e8"] {
        // Without a force the gap stays.
        let held = [beside, "parameters.force_law=none"];
        let outcome = run("contact-separation-passive", &[&at_start[..], &held].concat());
        close(margin(&outcome, "gap_voltage_v").value, volts, 1e-6);
    }
    close(found.value, volts, 1e-6);
    close(found.limit, 12_595.0, 1e-3);
    close(found.margin.expect("a margin"), 12_595.0 / 16_941.0, 1e-3);
    assert_eq!((found.at_s, outcome.margins.impossible_margin), (0.0, found.margin));
    assert!(warns(&outcome, "limit: gap_voltage_v"), "{:?}", outcome.warnings);
    let thin = run("contact-separation-passive", &[&at_start[..], &["limits.pressure_pa=50662.5"]].concat());
    close(margin(&thin, "gap_voltage_v").limit, 0.55 * found.limit, 0.02);
    // Without charge there is no field and no margin.
    let none = run(
        "contact-separation-passive",
        &[&at_start[..], &["parameters.charge_density_c_per_m2=0"]].concat(),
    );
    let found = margin(&none, "gap_voltage_v");
    assert_eq!((found.value, found.margin, none.margins.impossible_margin), (0.0, None, None));
}

/// A cantilever of steel and PZT-5A in its first mode: clamp curvature `2 λ² r/(L² √m)`, slope at the tip `1.3765 y/L`.
#[test]
fn a_deflected_beam_has_the_strain_and_the_slope_of_its_mode() {
    let start = "initial={modal_displacement=[-1e-5, 0, 0, 0, 0, 0, 0, 0, 0, 0], voltage_v=-250}";
    let outcome = run(
        "bump-stop-none",
        &[
            "excitation={kind='silence'}",
            "run={duration_s=1e-3, settle_s=0}",
            "parameters.coupling='one-way'",
            start,
        ],
    );
    let (lambda, length, mass) = (1.875_104_07_f64, 50e-3, 0.078_25_f64 * 50e-3);
    let tip = 2.0 * 1e-5 / mass.sqrt();
    let expected =
        [("piezo_field_v_per_m", 250.0 / 0.5e-3, 0.6e6), ("slope_rad", 1.376_506 * tip / length, 0.1)];
    for (name, value, limit) in expected {
        let found = margin(&outcome, name);
        close(found.value, value, 2e-3);
        assert_eq!(
            (found.limit, found.at_s, found.margin),
            (limit, 0.0, Some(limit / found.value)),
            "{name}"
        );
    }
    let curvature = lambda * lambda * tip / (length * length);
    close(margin(&outcome, "strain").value, 0.374_060_150e-3 * curvature, 2e-2);
    close(margin(&outcome, "piezo_strain").value, 0.625_939_850e-3 * curvature, 2e-2);
}

/// The slider at 8 mm bends its beam nearly as a force at the tip: strain `3 h y/(2 L²)`, slope `3 y/(2 L)`. Beyond the limit
/// the relative error is half the square of the slope.
#[test]
fn a_held_slider_has_the_strain_and_the_slope_of_a_force_at_the_tip() {
    let still =
        ["excitation={kind='silence'}", "run={duration_s=0.1, settle_s=0.05}", "initial.displacement_m=8e-3"];
    let outcome = run("sliding", &still);
    close(margin(&outcome, "strain").value, 1.5 * 0.5e-3 * 8e-3 / 0.01, 0.05);
    let slope = margin(&outcome, "slope_rad");
    close(slope.value, 0.12, 0.02);
    let note = outcome.warnings.iter().find(|text| text.starts_with("model: slope_rad")).expect("a note");
    assert!(note.ends_with(&format!("relative error about {:.1e}", 0.5 * slope.value.powi(2))), "{note}");
    assert!(!warns(&outcome, "limit:"), "{:?}", outcome.warnings);
}

#[test]
fn what_cannot_be_is_told_and_what_can_is_not() {
    let beyond =
        run("bump-stop", &["excitation.amplitude_m_per_s2=1e5", "run={duration_s=0.1, settle_s=0.05}"]);
    for name in ["strain", "piezo_strain", "piezo_field_v_per_m"] {
        assert!(warns(&beyond, &format!("limit: {name}")), "{name}: {:?}", beyond.warnings);
    }
    let thrown = run(
        "contact-separation-passive",
        &["excitation.amplitude_g=1e4", "run={duration_s=1, settle_s=0.5}"],
    );
    assert!(
        warns(&thrown, "model: fringing") && warns(&thrown, "model: contact_speed_m_per_s"),
        "{:?}",
        thrown.warnings
    );
    assert_eq!(thrown.margins.smallest_margin, margin(&thrown, "fringing").margin);
    let speed = margin(&thrown, "contact_speed_m_per_s").value;
    let fastest =
        thrown.contact_separation().and_then(|found| found.max_impact_speed_m_per_s).expect("impacts");
    assert!(speed >= fastest && speed < 10.0 * fastest, "{speed} {fastest}");
    let shipped = run("bump-stop", &["run={duration_s=0.2, settle_s=0.1}"]);
    assert!(!warns(&shipped, "limit:") && !warns(&shipped, "model:"), "{:?}", shipped.warnings);
    assert!(shipped.margins.smallest_margin.is_some_and(|margin| margin > 1.0), "{shipped:?}");
    assert_eq!(margin(&shipped, "contact_speed_m_per_s").limit, 1.0);
    assert!(margin(&shipped, "contact_speed_m_per_s").value > 1e-3, "it hits its stop");
}

/// The margins are in the objects and in columns of their own; an optimum keeps them if it is asked to.
#[test]
fn rows_have_the_margins_and_an_optimum_keeps_them() {
    let short = ["--set", "run={duration_s=0.1, settle_s=0.05}"];
    let over = "excitation.amplitude_m_per_s2=10:2000";
    let csv = accepted(&[&["run", BEAM, "--no-accuracy", "--format", "csv"][..], &short].concat());
    let heading: Vec<&str> = csv.lines().next().expect("a heading").split(',').collect();
    for column in
        ["limits_strain_value", "limits_piezo_strain_margin", "limits_slope_rad_at_s", "smallest_margin"]
    {
        assert!(heading.contains(&column), "{csv}");
    }
    let search = ["optimise", BEAM, "--maximise", "mean_power_w", "--over", over, "--grid", "5"];
    let margin =
        |more: &[&str]| number(&json(&[&search[..], &short, more].concat())["result"], "impossible_margin");
    assert!(margin(&[]) < 1.0);
    let smallest = margin(&["--keep-margins"]);
    assert!((1.0..1.1).contains(&smallest), "{smallest}");
    refused(&["run", BEAM, "--set", "limits.pressure_pa=1e5"], &["limits.pressure_pa", "strain"]);
}

/// The event comes before the first step.
#[test]
fn an_impact_at_the_start_has_its_speed() {
    let start = ["initial={gap_m=0,velocity_m_per_s=-3}", "run={duration_s=0.01,settle_s=0}"];
    let found = run("contact-separation-passive", &start);
    assert_eq!(margin(&found, "contact_speed_m_per_s").value, 3.0);
}
