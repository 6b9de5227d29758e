//! Options that make no sense.

use host_bench::embedded;
use host_bench::method::Precision;
use host_bench::reference::ReferenceOptions;
use host_bench::scene_file::{read, shipped};

use super::tool::{BUMP_STOP, MEASURED, NODE, SHIPPED, accepted, folder, refused};

#[test]
fn of_the_command_line_itself() {
    refused(&["frobnicate"], &["frobnicate"]);
    refused(&["run"], &["SCENE.toml"]);
    refused(&["run", SHIPPED, "--frobnicate"], &["--frobnicate"]);
    refused(&["run", SHIPPED, "another.toml"], &["another.toml"]);
    refused(
        &["stability", "--output", "/nowhere/cases.csv"],
        &["--output /nowhere/cases.csv", "/nowhere must be a folder"],
    );
    refused(&["stability", "--random", "1", "--grid", "coarse"], &["--random", "--grid"]);
}

#[test]
fn of_a_run() {
    let folder = folder("bad-options");
    let itself = folder.to_str().expect("a plain path");
    let nowhere = format!("{itself}/absent/trace.csv");
    let trace = format!("{itself}/trace.csv");
    for (options, parts) in [
        (vec!["--method", "euler"], vec!["--method", "euler", "reference"]),
        (vec!["--precision", "f16"], vec!["--precision", "f16", "f32"]),
        (vec!["--math", "std"], vec!["--math", "std", "libm"]),
        (vec!["--format", "xml"], vec!["--format", "xml", "json"]),
        (vec!["--step", "small"], vec!["--step", "small"]),
        (vec!["--method", "rk4", "--step", "0"], vec!["--step 0", "1e-9 to 1e0"]),
        (vec!["--method", "rk4", "--step", "-1e-3"], vec!["--step -0.001", "1e-9 to 1e0"]),
        (vec!["--method", "rk4", "--step", "nan"], vec!["--step", "nan", "must be a finite number"]),
        (vec!["--method", "rk4", "--step", "inf"], vec!["--step", "inf", "must be a finite number"]),
        (vec!["--tolerance", "0"], vec!["--tolerance 0", "1e-13 to 1e-1"]),
        (vec!["--tolerance", "-1e-3"], vec!["--tolerance -0.001", "1e-13 to 1e-1"]),
        (vec!["--tolerance", "nan"], vec!["--tolerance", "nan", "must be a finite number"]),
        (vec!["--step", "1e-4", "--tolerance", "1e-4"], vec!["--step", "--tolerance"]),
        (vec!["--method", "reference", "--precision", "f32"], vec!["--precision f32", "f64"]),
        (vec!["--method", "reference", "--math", "libm"], vec!["--math", "reference"]),
        (vec!["--method", "reference", "--step", "1e-4"], vec!["--step", "reference"]),
        (vec!["--math", "micromath", "--precision", "f64"], vec!["micromath", "f32"]),
        (vec!["--trace", &trace], vec!["--trace-every"]),
        (vec!["--trace-every", "0.1"], vec!["--trace"]),
        (vec!["--trace", &trace, "--trace-every", "0"], vec!["--trace-every 0", "1e-9 to 1e7"]),
        (vec!["--trace", &trace, "--trace-every", "-1"], vec!["--trace-every -1", "1e-9 to 1e7"]),
        (vec!["--trace", &trace, "--trace-every", "nan"], vec!["--trace-every", "a finite number"]),
        (
            vec!["--method", "reference", "--trace", &trace, "--trace-every", "1e-8"],
            vec!["--trace-every 0.00000001", "at least"],
        ),
        (vec!["--trace", &nowhere, "--trace-every", "1"], vec![nowhere.as_str(), "must be a folder"]),
        (vec!["--trace", itself, "--trace-every", "1"], vec![itself, "must be a file"]),
    ] {
        let mut arguments = vec!["run", SHIPPED];
        arguments.extend(options);
        refused(&arguments, &parts);
    }
    let left = std::fs::read_dir(&folder).expect("the folder").count();
    assert_eq!(left, 0, "nothing is written");
}

#[test]
fn that_the_method_or_the_scene_does_not_use() {
    for (scene, options, parts) in [
        (BUMP_STOP, "--method exponential-radau", ["--method exponential-radau", "triboelectric"]),
        (BUMP_STOP, "--method reference --tolerance 1e-3", ["--tolerance", "exact"]),
        (BUMP_STOP, "--method reference --long-step 1e-5", ["--long-step", "reference"]),
        (BUMP_STOP, "--method tr-bdf2 --long-step 1e-5", ["--long-step", "discrete-gradient"]),
        (
            BUMP_STOP,
            "--method newmark --trace t.csv --trace-every 1e-3",
            ["--method", "discrete-gradient or reference"],
        ),
        (BUMP_STOP, "--method newmark --precision f32", ["--precision f32", "must be f64"]),
        (BUMP_STOP, "--method rk4 --math libm", ["--math", "host"]),
        (BUMP_STOP, "--no-accuracy --accuracy=1e-3", ["--accuracy", "with run"]),
        (BUMP_STOP, "--method newmark --accuracy 1e-3", ["--accuracy", "discrete-gradient"]),
        (BUMP_STOP, "--step 1e-6 --long-step 1e-7", ["--long-step 0.0000001", "at least 0.000001 s"]),
        (BUMP_STOP, "--long-step 1e-7", ["--long-step 0.0000001", "at least 0.000001 s"]),
        (SHIPPED, "--method discrete-gradient", ["--method discrete-gradient", "bump-stop"]),
        (SHIPPED, "--method newmark", ["--method newmark", "bump-stop"]),
        (SHIPPED, "--long-step 1e-3", ["--long-step", "bump-stop"]),
        (SHIPPED, "--method reference --long-step 1e-3", ["--long-step", "reference"]),
        (SHIPPED, "--method reference --accuracy 1e-3", ["--accuracy", "give --tolerance"]),
        (SHIPPED, "--method tr-bdf2 --accuracy 1e-3", ["--accuracy", "exponential-radau"]),
        (SHIPPED, "--method rk4 --tolerance 1e-3", ["--tolerance", "rk4"]),
    ] {
        let short = ["--set", "run.duration_s=0.01", "--set", "run.settle_s=0"];
        let arguments: Vec<&str> =
            ["run", scene].into_iter().chain(options.split(' ')).chain(short).collect();
        refused(&arguments, &parts);
    }
}

#[test]
fn help_names_the_defaults_that_hold() {
    let help = accepted(&["run", "--help"]);
    let lines: Vec<&str> = help.lines().map(str::trim).collect();
    let slider = read(&shipped("sliding"), &[]).expect("a shipped scene");
    for (option, default) in [
        ("--accuracy", format!("default: {:e}", embedded::default_accuracy(&slider, Precision::F64))),
        (
            "--accuracy",
            format!("{:e} of a slider in f32", embedded::default_accuracy(&slider, Precision::F32)),
        ),
        ("--tolerance", format!("{:e} with tr-bdf2", embedded::DEFAULT_TOLERANCE)),
        ("--tolerance", format!("{:e} with the reference", ReferenceOptions::default().tolerance)),
        ("--precision", "default: f64; f32 with micromath".to_owned()),
        ("--math", "default: polynomial".to_owned()),
        ("--step", "1e-6 near contact".to_owned()),
        ("--long-step", "2e-5".to_owned()),
    ] {
        let place =
            lines.iter().position(|line| line.starts_with(&format!("{option} <"))).expect("an option");
        let text = lines[place + 1..].split(|line| line.is_empty()).next().unwrap_or_default().join(" ");
        assert!(text.contains(&default), "{option}: {default} is not in {text}");
    }
}

#[test]
fn of_the_comparison_with_peers() {
    let absent =
        if cfg!(feature = "peers") { "must be all or one of contact-100M" } else { "--features peers" };
    refused(&["work-precision", "--peers", "contact"], &["--peers", absent]);
    refused(&["work-precision", "--csv", "rows.csv"], &["--peers"]);
    refused(&["work-precision", "--peers", "all", "--set", "run.duration_s=1"], &["--peers", "--set"]);
}

#[test]
fn counts_have_bounds() {
    let map = ["map", SHIPPED, "--amplitude", "1:2", "--frequency", "19:20"];
    let best = ["optimise", SHIPPED, "--maximise", "mean_power_w", "--over", "load.resistance_ohm=1e6:1e8"];
    let resonance = ["resonance", SHIPPED, "--from", "10", "--to", "20"];
    for count in ["-1", "1000001", "1000000000000", "18446744073709551615", "18446744073709551616"] {
        let options: [(&[&str], &str, &str); 12] = [
            (&["attractors", SHIPPED], "--starts", "100000"),
            (&["budget", NODE], "--learning-days", "366"),
            (&["fit", MEASURED], "--iterations", "1000"),
            (&["fit", MEASURED], "--starts", "1000"),
            (&map, "--inputs", "100000"),
            (&map, "--places", "10000"),
            (&["on-target"], "--time-limit", "86400"),
            (&best, "--grid", "100000"),
            (&resonance, "--points", "100000"),
            (&["run", SHIPPED], "--seeds", "100000"),
            (&["stability"], "--random", "1000000"),
            (&["sweep", SHIPPED], "--over", "100000"),
        ];
        for (command, option, bound) in options {
            let axis = format!("load.resistance_ohm=1e6:1e8:{count}");
            let value = if option == "--over" { &axis } else { count };
            let argument = format!("{option}={value}");
            refused(&[command, &[&argument]].concat(), &[option, count, bound]);
        }
    }
}
