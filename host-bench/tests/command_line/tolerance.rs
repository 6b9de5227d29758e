//! Tolerances.

use std::fs::{self, read_to_string};
use std::process::{Command, Stdio};

use serde_json::Value;

// A beam without a stop: its power is proportional to the square of the acceleration.
use super::tool::{BEAM as LINEAR, accepted, file, folder, json as any_json, json_and_told, refused, rows};

const FAST: [&str; 4] = ["--no-accuracy", "--steady-state", "--set", "parameters.beam_modes=1"];
const AMPLITUDE: &str = "excitation.amplitude_m_per_s2";

fn tolerance<'a>(options: &[&'a str]) -> Vec<&'a str> {
    [&["tolerance", LINEAR], &FAST[..], options].concat()
}

fn json(options: &[&str]) -> Value {
    any_json(&tolerance(options))
}

/// A column of the samples, behind the row of the scene itself.
fn column(text: &str, name: &str) -> Vec<f64> {
    rows(text).iter().skip(1).map(|row| row[name].parse().expect("a number")).collect()
}

fn named<'a>(list: &'a Value, name: &str) -> &'a Value {
    list.as_array().expect("a list").iter().find(|one| one["name"] == name).expect(name)
}

#[test]
fn percentiles_of_a_square_are_those_of_its_closed_form() {
    let folder = folder("tolerance-square");
    let path = folder.to_str().expect("a plain path");
    // At 20 m/s² ± 10 %, evenly: the power at a part p of the samples is P (0.9 + 0.2 p)².
    let nominal = json(&["--vary", &format!("{AMPLITUDE}=±10%"), "--samples", "2"]);
    let nominal = named(&nominal["statistics"], "nominal")["value"].as_f64().expect("a power");
    let wish = format!("{nominal:e}");
    let vary = format!("{AMPLITUDE}=+-10%");
    let found = json(&["--vary", &vary, "--at-least", &wish, "--output", path]);
    for (name, expected) in [
        ("percentile_5", 0.91_f64.powi(2) * nominal),
        ("median", nominal),
        ("percentile_95", 1.09_f64.powi(2) * nominal),
        ("mean", (1.0 + 0.01 / 3.0) * nominal),
        ("yield", 0.5),
    ] {
        let row = named(&found["statistics"], name);
        let [low, value, high] = ["confidence_low", "value", "confidence_high"].map(|key| row[key].as_f64());
        assert!(low <= value && value <= high && low < high, "{row}");
        assert!(low < Some(expected) && Some(expected) < high, "{expected}: {row}");
    }
    // Standard errors of 400 samples, by hand: 0.2 sqrt(0.25 / 400) / 1 of the median's amplitude, twice for the power.
    let median = named(&found["statistics"], "median")["value"].as_f64().expect("a power");
    assert!((median / nominal - 1.0).abs() < 4.0 * 0.01, "{median} {nominal}");
    let text = read_to_string(folder.join("tolerance.csv")).expect("the samples");
    let powers = column(&text, "mean_power_w");
    assert_eq!(powers.len(), 400);
    for (amplitude, power) in column(&text, AMPLITUDE).iter().zip(powers) {
        assert!((18.0..=22.0).contains(amplitude));
        assert!((power / nominal / (amplitude / 20.0).powi(2) - 1.0).abs() < 1e-6, "{amplitude} {power}");
    }
    assert!(
        found["linear_r_squared"].as_f64() > Some(0.99)
            && found["generator"].to_string().contains("SplitMix64")
    );
    let picture = read_to_string(folder.join("tolerance.svg")).expect("the picture");
    let texts = "mean power [|share of the samples|percentile 5: |nominal: |wished: |\
                 excitation amplitude, deviation from 20 m/s² [%]";
    for text in texts.split('|') {
        assert!(picture.contains(text), "{text}");
    }
    assert!(folder.join("tolerance.html").is_file() && !picture.contains("NaN"));
    for (quantity, samples, reason) in [
        ("mean_power_w", "40", "a linear fit explains 99.9 % of the variance"),
        ("mean_power_w", "3", "a linear fit has too few samples"),
        ("events", "40", "a linear fit fails: all values are equal"),
    ] {
        let few = ["--vary", &vary, "--samples", samples, "--quantity", quantity];
        let table = accepted(&tolerance(&few));
        assert!(table.lines().all(|line| line.chars().count() <= 100) && table.contains(reason), "{table}");
    }
}

#[test]
fn a_normal_bound_is_two_standard_deviations_and_correlated_keys_correlate() {
    let folder = folder("tolerance-correlated");
    let path = folder.to_str().expect("a plain path");
    let other = "parameters.damping_ratio";
    let [one_key, other_key] = [format!("{AMPLITUDE}=±2:normal"), format!("{other}=±20%:normal")];
    let pair = format!("{AMPLITUDE},{other}=0.8");
    let vary = ["--vary", &other_key, "--vary", &one_key, "--correlate", &pair];
    let found = json(&[&vary[..], &["--output", path, "--seed=3"]].concat());
    let text = read_to_string(folder.join("tolerance.csv")).expect("the samples");
    let [one, two] = [AMPLITUDE, other].map(|key| column(&text, key));
    let deviations =
        |values: &[f64], about: f64| values.iter().map(|value| value - about).collect::<Vec<_>>();
    let [one, two] = [deviations(&one, 20.0), deviations(&two, 0.01)];
    let product = |one: &[f64], two: &[f64]| one.iter().zip(two).map(|(a, b)| a * b).sum::<f64>() / 400.0;
    let correlation = product(&one, &two) / (product(&one, &one) * product(&two, &two)).sqrt();
    // Three standard errors: (1 − 0.8²) / 20.
    assert!((correlation - 0.8).abs() < 0.054, "{correlation}");
    for (values, sigma) in [(&one, 1.0), (&two, 0.001)] {
        assert!((product(values, values).sqrt() / sigma - 1.0).abs() < 3.0 / 800_f64.sqrt(), "{sigma}");
        let beyond = values.iter().filter(|value| value.abs() > 2.0 * sigma).count();
        // 4.55 % of 400.
        assert!((6..=31).contains(&beyond), "{beyond}");
    }
    assert_eq!(found["seed"], 3);
}

#[test]
fn keys_stand_in_the_order_in_which_they_matter() {
    let weak = "parameters.damping_ratio=±20%";
    let vary = format!("{AMPLITUDE}=10%");
    let found = json(&["--vary", weak, "--vary", &vary]);
    let keys = found["keys"].as_array().expect("a list");
    assert_eq!((&keys[0]["name"], &keys[1]["name"]), (&AMPLITUDE.into(), &"parameters.damping_ratio".into()));
    let of = |index: usize, name: &str| keys[index][name].as_f64().expect("a number");
    assert!(of(0, "variance_share") > 0.95 && of(1, "variance_share") < 0.05, "{keys:?}");
    assert!(of(0, "standardised_coefficient") > 0.98 && of(1, "standardised_coefficient") < 0.0, "{keys:?}");
    // A resonance in the middle of its tolerance: the power falls to both sides, which no line explains.
    let tuned = ["--set", "excitation.frequency_hz=245.3", "--vary", "excitation.frequency_hz=±1.5%"];
    let message = "warning: sensitivities: a linear fit explains";
    let (found, printed) = json_and_told(&tolerance(&tuned));
    assert!(printed.contains(message), "{printed}");
    assert!(found["keys"][0]["variance_share"].as_f64() > Some(0.7), "{}", found["keys"]);
    assert!(
        named(&found["statistics"], "median")["value"].as_f64()
            < named(&found["statistics"], "nominal")["value"].as_f64()
    );
}

#[test]
fn samples_depend_on_seed_and_number_alone_and_an_interrupted_tolerance_goes_on() {
    let [whole, resumed, short] =
        ["whole", "resumed", "short"].map(|name| folder(&format!("tolerance-{name}")));
    let vary = format!("{AMPLITUDE}=±10%");
    let run = |folder: &std::path::Path, samples: &str, threads: &str| {
        let path = folder.to_str().expect("a plain path");
        let mut options = vec!["--vary", &vary, "--output", path, "--format", "json", "--samples"];
        options.extend(samples.split(' '));
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-bench"));
        command.args(tolerance(&options)).env("RAYON_NUM_THREADS", threads).stderr(Stdio::null());
        command
    };
    let printed = |mut command: Command| command.output().expect("the binary starts").stdout;
    let expected = printed(run(&whole, "300", "1"));
    assert!(!expected.is_empty());
    let rows =
        |folder: &std::path::Path| read_to_string(folder.join("tolerance.rows.jsonl")).unwrap_or_default();
    let mut child = run(&resumed, "300", "2").stdout(Stdio::null()).spawn().expect("the binary starts");
    let began = std::time::Instant::now();
    while rows(&resumed).lines().count() < 4 && began.elapsed().as_secs() < 60 {
        std::thread::yield_now();
    }
    // It may have ended meanwhile.
    let _ = child.kill();
    child.wait().expect("it is stopped");
    assert!(rows(&resumed).lines().count() > 3, "points are kept");
    assert_eq!(printed(run(&resumed, "300", "2")), expected);
    for name in ["tolerance.svg", "tolerance.html"] {
        assert_eq!(
            fs::read(resumed.join(name)).expect("a file"),
            fs::read(whole.join(name)).expect("a file")
        );
    }
    assert!(rows(&resumed).is_empty(), "nothing is left of a whole one");
    let expected = printed(run(&short, "20", "2"));
    assert!(!expected.is_empty());
    for part in ["20 --part 2/2", "20 --part 1/2"] {
        assert!(printed(run(&short, part, "2")).is_empty());
    }
    assert_eq!(printed(run(&short, "20 --merge 2", "1")), expected);
    let [whole, resumed, short] = [&whole, &resumed, &short].map(|folder| {
        let text = read_to_string(folder.join("tolerance.csv")).expect("the samples");
        ["mean_power_w", AMPLITUDE].map(|name| column(&text, name))
    });
    assert_eq!(whole, resumed);
    assert_eq!(whole.map(|values| values[..20].to_vec()), short);
}

#[test]
fn measured_parts_are_taken_in_turn() {
    let folder = folder("tolerance-parts");
    let path = folder.to_str().expect("a plain path");
    let parts =
        file(&folder, "parts.csv", format!("{AMPLITUDE},load.resistance_ohm\n19,1e6\n20,1.1e6\n21,0.9e6\n"));
    let found = json(&["--parts", &parts, "--output", path, "--quantity", "rms_voltage_v"]);
    assert_eq!((&found["samples"], &found["quantity"]), (&3.into(), &"rms_voltage_v".into()));
    let text = read_to_string(folder.join("tolerance.csv")).expect("the samples");
    assert_eq!(column(&text, AMPLITUDE), [19.0, 20.0, 21.0]);
    assert_eq!(column(&text, "load.resistance_ohm"), [1e6, 1.1e6, 0.9e6]);
    let voltages = column(&text, "rms_voltage_v");
    let mean = named(&found["statistics"], "mean")["value"].as_f64().expect("a voltage");
    assert!((mean / (voltages.iter().sum::<f64>() / 3.0) - 1.0).abs() < 1e-12);
    let vary = "parameters.damping_ratio=±10%";
    let more = json(&["--parts", &parts, "--vary", vary, "--samples", "7", "--output", path]);
    assert_eq!(more["samples"], 7);
    let text = read_to_string(folder.join("tolerance.csv")).expect("the samples");
    assert_eq!(column(&text, AMPLITUDE), [19.0, 20.0, 21.0, 19.0, 20.0, 21.0, 19.0]);
}

#[test]
fn bad_tolerances_are_refused() {
    let folder = folder("tolerance-refused");
    let unknown = file(&folder, "unknown.csv", "no.key\n1\n");
    let words = file(&folder, "words.csv", "load.resistance_ohm\n1e6\nmuch\n");
    let ratio = "parameters.damping_ratio";
    let load = "--vary load.resistance_ohm=±5%";
    for (options, parts) in [
        ("", ["--vary", ""]),
        ("--vary excitation.amplitude_g", ["--vary", "KEY=±BOUND"]),
        ("--vary load.resistance_ohm=5", ["KEY=±BOUND", ""]),
        (&format!("{load}:even"), ["BOUND = \"5%:even\"", ""]),
        ("--vary load.resistance_ohm=±-5%", ["BOUND = \"-5%\"", "above 0"]),
        (
            "--vary load.resistance_ohm=±5V",
            ["BOUND = \"5V\" must be", "in Ω with a prefix or without, not in V"],
        ),
        ("--vary no.key=±5", ["--vary no.key: unknown key", ""]),
        ("--vary parameters.beam_lenght_m=±2%", ["beam_lenght_m: unknown key", "probably beam_length_m"]),
        ("--vary excitation.phase_rad=±5% --set excitation.phase_rad=0", ["another value than 0", ""]),
        // A damping ratio is at least 0.
        ("--vary parameters.damping_ratio=±150%", ["--vary parameters.damping_ratio = -0.0", "from 0 to"]),
        (&format!("{load} --vary load.resistance_ohm=±2%"), ["must not be given after", ""]),
        (&format!("{load} --set load.resistance_ohm=inf"), ["must have a finite value", ""]),
        (&format!("{load} --correlate load.resistance_ohm,a=0.5"), ["two keys of --vary", ""]),
        (&format!("{load} --correlate a,b=1.5"), ["between -1 and 1", ""]),
        (&format!("{load} --quantity mean_pwr_w"), ["--quantity mean_pwr_w", "probably mean_power_w; run"]),
        (&format!("{load} --at-least nan"), ["--at-least", "finite"]),
        (&format!("{load} --samples 1"), ["from 2 to 999999", ""]),
        (&format!("--parts {unknown}"), ["no.key", ""]),
        (&format!("--parts {words}"), ["words.csv:3", "much"]),
    ] {
        refused(&tolerance(&options.split_whitespace().collect::<Vec<_>>()), &parts);
    }
    // No three numbers have these correlations.
    let keys = [AMPLITUDE, ratio, "load.resistance_ohm"].map(|key| format!("{key}=±1%"));
    let pairs = [
        (AMPLITUDE, ratio, 0.9),
        (AMPLITUDE, "load.resistance_ohm", 0.9),
        (ratio, "load.resistance_ohm", -0.9),
    ]
    .map(|(one, other, value)| format!("{one},{other}={value}"));
    let keys = keys.iter().flat_map(|key| ["--vary", key]);
    let all: Vec<&str> = keys.chain(pairs.iter().flat_map(|pair| ["--correlate", pair])).collect();
    refused(&tolerance(&all), &["--correlate", "not positive definite"]);
}
