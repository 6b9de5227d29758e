//! Options that make no sense.

use super::tool::{SHIPPED, folder, refused};

#[test]
fn of_the_command_line_itself() {
    refused(&["frobnicate"], &["frobnicate"]);
    refused(&["run"], &["SCENE.toml"]);
    refused(&["run", SHIPPED, "--frobnicate"], &["--frobnicate"]);
    refused(&["run", SHIPPED, "another.toml"], &["another.toml"]);
    refused(
        &["stability", "--known", "/nowhere/known.csv"],
        &["--known /nowhere/known.csv", "cannot be read"],
    );
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
        (vec!["--method", "rk4", "--step", "nan"], vec!["--step NaN", "1e-9 to 1e0"]),
        (vec!["--method", "rk4", "--step", "inf"], vec!["--step inf", "1e-9 to 1e0"]),
        (vec!["--tolerance", "0"], vec!["--tolerance 0", "1e-13 to 1e-1"]),
        (vec!["--tolerance", "-1e-3"], vec!["--tolerance -0.001", "1e-13 to 1e-1"]),
        (vec!["--tolerance", "nan"], vec!["--tolerance NaN", "1e-13 to 1e-1"]),
        (vec!["--step", "1e-4", "--tolerance", "1e-4"], vec!["--step", "--tolerance"]),
        (vec!["--method", "reference", "--precision", "f32"], vec!["--precision f32", "f64"]),
        (vec!["--method", "reference", "--math", "libm"], vec!["--math", "reference"]),
        (vec!["--method", "reference", "--step", "1e-4"], vec!["--step", "reference"]),
        (vec!["--math", "micromath", "--precision", "f64"], vec!["micromath", "f32"]),
        (vec!["--trace", &trace], vec!["--trace-every"]),
        (vec!["--trace-every", "0.1"], vec!["--trace"]),
        (vec!["--trace", &trace, "--trace-every", "0"], vec!["--trace-every 0", "1e-9 to 1e7"]),
        (vec!["--trace", &trace, "--trace-every", "-1"], vec!["--trace-every -1", "1e-9 to 1e7"]),
        (vec!["--trace", &trace, "--trace-every", "nan"], vec!["--trace-every NaN", "1e-9 to 1e7"]),
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
fn of_the_comparison_with_peers() {
    let absent =
        if cfg!(feature = "peers") { "must be all or one of contact-100M" } else { "--features peers" };
    refused(&["work-precision", "--peers", "contact"], &["--peers", absent]);
    refused(&["work-precision", "--csv", "rows.csv"], &["--peers"]);
    refused(&["work-precision", "--peers", "all", "--set", "run.duration_s=1"], &["--peers", "--set"]);
}
