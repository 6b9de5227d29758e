//! Every output that names numbers of runs has their accuracy statement and their warnings, in each format.

use super::tool::{NODE, SHIPPED, TRUCK, accepted, file, folder, json, place};

#[track_caller]
fn states(arguments: &[&str]) {
    let of = |format| accepted(&[arguments, &["--format", format]].concat());
    let found = json(arguments);
    assert!(found["accuracy"]["total"].as_f64().is_some_and(|total| total > 0.0), "{}", found["accuracy"]);
    // The force law of the shipped scene creates energy, or loses it.
    assert!(found["warnings"].to_string().contains("s energy: created_energy_j"), "{}", found["warnings"]);
    let csv = of("csv");
    assert!(csv.contains("accuracy_total") && csv.contains("s energy: created_energy_j"), "{csv}");
    assert!(of("table").contains("accuracy"));
}

#[test]
fn an_optimum_a_tolerance_a_resonance_and_seeds_have_a_statement() {
    let short = ["--set", "run={duration_s=2,settle_s=1}", "--set", "excitation.amplitude_g=0.05"];
    let over =
        ["optimise", SHIPPED, "--maximise", "mean_power_w", "--over", "load.resistance_ohm=1e7:1e9:log"];
    states(&[&over[..], &["--grid", "3"], &short].concat());
    let vary = ["tolerance", SHIPPED, "--vary", "load.resistance_ohm=±5%", "--samples", "3"];
    states(&[&vary[..], &short].concat());
    let range = ["resonance", SHIPPED, "--from", "19", "--to", "21", "--points", "5"];
    states(&[&range[..], &["--set", "excitation.amplitude_g=0.02"]].concat());
    let few = ["--set", "excitation.lines=64", "--set", "run={duration_s=2,settle_s=1}"];
    states(&[&["run", TRUCK, "--seeds", "3"], &few[..]].concat());
}

#[test]
fn a_day_a_map_and_a_fit_have_a_statement() {
    let law = ["--set", "parameters.force_law=transferred-charge"];
    let folder = folder("statements");
    let picture = place(&folder, "day.svg");
    let day = ["budget", NODE, "--svg", &picture];
    states(&[&day[..], &["--set", "run={duration_s=3,settle_s=2}"], &law].concat());
    let map = ["map", SHIPPED, "--amplitude", "0.5:0.55", "--frequency", "25:25.5", "--places", "30"];
    states(&[&map[..], &["--error", "0.5"]].concat());
    let data = file(&folder, "data.csv", "frequency_hz,rms_voltage_v\n18,0.5\n21,1\n");
    let free = "--free=parameters.charge_density_c_per_m2";
    states(&["fit", SHIPPED, "--data", &data, free, "--starts=0"]);
}
