//! Statistics over the seeds of a random excitation.

use super::tool::{SHIPPED, TRUCK, accepted, json, number, outcome, refused};

const SHORT: [&str; 4] =
    ["--set=run.duration_s=0.6", "--set=run.settle_s=0.2", "--set=excitation.lines=64", "--tolerance=1e-4"];

fn seeds<'a>(options: &[&'a str]) -> Vec<&'a str> {
    [&["run", TRUCK], &SHORT[..], options].concat()
}

#[test]
fn the_statistics_are_those_of_the_runs_of_the_seeds() {
    let found = json(&seeds(&["--seeds=3", "--no-accuracy", "--set=excitation.seed=5"]));
    assert_eq!(found["seeds"], serde_json::json!([5, 7]));
    assert!((number(&found, "base_rms_m_per_s2") / 9.81 - 1.04).abs() < 0.005);
    let alone = |seed: &str| number(&json(&seeds(&["--no-accuracy", "--set", seed])), "mean_power_w");
    let values = ["excitation.seed=5", "excitation.seed=6", "excitation.seed=7"].map(alone);
    let mean = values.iter().sum::<f64>() / 3.0;
    let deviation = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 2.0).sqrt();
    let power = &found["statistics"]["mean_power_w"];
    let close = |key: &str, expected: f64| {
        let value = number(power, key);
        assert!((value - expected).abs() < 1e-12 * mean, "{key}: {value} {expected}");
    };
    close("mean", mean);
    close("standard_deviation", deviation);
    close("largest", values.iter().copied().fold(0.0, f64::max));
    // Student's t of two degrees of freedom: 4.3027.
    let half = number(power, "confidence_high") - mean;
    assert!((half / (4.302_653 * deviation / 3f64.sqrt()) - 1.0).abs() < 1e-6);
    assert_eq!(power["count"], 3);
    for key in ["rms_voltage_v", "peak_gap_m", "impacts"] {
        assert!(found["statistics"][key]["mean"].is_f64(), "{key}");
    }
    for key in ["steps", "processor_s", "duration_s"] {
        assert!(found["statistics"][key].is_null(), "{key}");
    }
}

#[test]
fn tables_have_a_row_for_each_quantity() {
    let text = accepted(&seeds(&["--seeds", "2", "--no-accuracy", "--format", "csv"]));
    assert!(text.starts_with(
        "quantity,count,mean,standard_deviation,confidence_low,confidence_high,least,largest,accuracy_chaos,accuracy_step,"
    ));
    assert!(text.contains("\nmean_power_w,2,"));
    let text = accepted(&seeds(&["--seeds", "2"]));
    for part in ["seeds 1 to 2", "m/s² RMS", "mean_power_w", "95 % from"] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
}

#[test]
fn what_has_no_seed_is_refused() {
    refused(&["run", SHIPPED, "--seeds", "20"], &["excitation.kind", "must be \"random\" with --seeds"]);
    refused(&seeds(&["--seeds", "1"]), &["--seeds", "'1'", "a whole number from 2 to 100000"]);
    refused(&seeds(&["--seeds", "-3"]), &["--seeds", "'-3'", "a whole number from 2 to 100000"]);
    refused(&seeds(&["--seeds", "2", "--steady-state"]), &["--seeds", "--steady-state"]);
    refused(
        &seeds(&["--seeds", "2", "--set", "excitation.seed=4294967295"]),
        &["--seeds 2", "the last seed must be at most 4294967295"],
    );
}

#[test]
fn a_band_with_too_few_lines_is_warned_about() {
    let warned = outcome(TRUCK, &["run.duration_s=0.1", "run.settle_s=0", "excitation.lines=64"]);
    let text = warned["warnings"].to_string();
    assert!(text.contains("excitation.lines = 64") && text.contains("half-power bandwidth"), "{text}");
    let quiet = outcome(TRUCK, &["run.duration_s=0.1", "run.settle_s=0"]);
    assert!(!quiet["warnings"].to_string().contains("excitation.lines"));
}
