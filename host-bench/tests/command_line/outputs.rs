//! Where a command writes, and what it must not replace.

use std::fs;
use std::path::Path;
use std::process::Command;

use super::interrupted::text;
use super::tool::{NODE, SHIPPED, accepted, file, folder, refused, unfolded};

/// A hundredth of a second of a scene.
fn run<'a>(scene: &'a str, trace: &'a str) -> Vec<&'a str> {
    let short = ["--set", "run.duration_s=0.01", "--set", "run.settle_s=0"];
    [&["run", scene, "--trace", trace, "--trace-every", "1e-3"], &short[..]].concat()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("the folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn an_output_never_replaces_an_input_of_the_command() {
    let folder = folder("own-input");
    let shipped = fs::read_to_string(SHIPPED).expect("the shipped scene");
    let (before, _) = shipped.split_once("[excitation]").expect("the table is there");
    let shaken = format!(
        "{before}[excitation]\nkind = \"file\"\npath = \"sweep.csv\"\ncolumn = \"x\"\nrate_hz = 100\n\
         scale_m_per_s2 = 1.0\n[run]\nduration_s = 0.01\n"
    );
    let samples = "x\n0\n1\n0\n";
    let scene = file(&folder, "scene.toml", &shaken);
    let trace = file(&folder, "sweep.csv", samples);
    let again = format!("{}/../own-input/scene.toml", text(&folder));
    refused(&run(&scene, &scene), &["--trace", "scene.toml", "which this command reads"]);
    refused(&run(&scene, &again), &["--trace", "which this command reads"]);
    refused(&run(&scene, &trace), &["--trace", "sweep.csv", "which this command reads"]);
    let sweep = ["sweep", &scene, "--over", "load.resistance_ohm=1e6:1e8:2", "--output", text(&folder)];
    refused(&sweep, &["--output", "sweep.csv", "which this command reads"]);
    let node = file(&folder, "node.toml", fs::read_to_string(NODE).expect("the shipped scene"));
    refused(&["budget", &node, "--svg", &node], &["--svg", "which this command reads"]);
    #[cfg(unix)]
    {
        let link = folder.join("link.toml");
        std::os::unix::fs::symlink(&scene, &link).expect("a link");
        refused(&run(&scene, text(&link)), &["--trace", "which this command reads"]);
        refused(&run(text(&link), &scene), &["--trace", "which this command reads"]);
        let hard = folder.join("hard.toml");
        fs::hard_link(&scene, &hard).expect("a link");
        refused(&run(&scene, text(&hard)), &["--trace", "which this command reads"]);
    }
    assert_eq!(fs::read_to_string(&scene).expect("it is there"), shaken);
    assert_eq!(fs::read_to_string(&trace).expect("it is there"), samples);
}

#[test]
fn a_read_only_file_is_kept_and_a_writable_one_is_replaced() {
    let folder = folder("replaced");
    let kept = file(&folder, "kept.csv", "mine");
    let mut permissions = fs::metadata(&kept).expect("it is there").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&kept, permissions).expect("my own file");
    refused(&run(SHIPPED, &kept), &["--trace", "kept.csv", "read-only"]);
    assert_eq!(fs::read_to_string(&kept).expect("it is there"), "mine");
    let old = file(&folder, "old.csv", "mine");
    accepted(&run(SHIPPED, &old));
    assert!(fs::read_to_string(&old).expect("it is there").starts_with("time_s,"));
    assert_eq!(names(&folder), ["kept.csv", "old.csv"], "no parts are left");
}

#[cfg(unix)]
#[test]
fn what_is_no_file_stays_as_it_is() {
    use std::os::unix::fs::FileTypeExt;
    let folder = folder("kinds");
    let pipe = folder.join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo is there").success());
    refused(&run(SHIPPED, text(&pipe)), &["--trace", "pipe", "must be a file"]);
    assert!(fs::symlink_metadata(&pipe).expect("it is there").file_type().is_fifo());
    let null = folder.join("null");
    std::os::unix::fs::symlink("/dev/null", &null).expect("a link");
    refused(&run(SHIPPED, text(&null)), &["--trace", "null", "a device"]);
    refused(&run(SHIPPED, "/dev/null"), &["--trace /dev/null", "a device"]);
}

#[test]
fn a_path_is_checked_before_the_runs() {
    let folder = folder("checked-first");
    let taken = file(&folder, "taken", "");
    let inside = folder.join("taken/deeper");
    // Hours, if it were run.
    let long = ["--set", "run.duration_s=1e6", "--set", "run.settle_s=0"];
    let over = ["--over", "load.resistance_ohm=1e6:1e8:9"];
    for output in [taken.as_str(), text(&inside)] {
        let sweep = [&["sweep", SHIPPED, "--output", output], &long[..], &over[..]].concat();
        refused(&sweep, &["--output", "must be a folder"]);
        refused(&["figures", "--output", output], &["taken"]);
    }
    fs::create_dir(folder.join("sweep.csv")).expect("a folder");
    let sweep = [&["sweep", SHIPPED, "--output", text(&folder)], &long[..], &over[..]].concat();
    refused(&sweep, &["--output", "sweep.csv", "must be a file"]);
}

#[test]
fn reports_go_to_the_folder_of_the_caller() {
    let folder = folder("caller");
    let budget = |folder: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-bench"));
        command.current_dir(folder).args(["budget", NODE]);
        command.args(["--set", "run.duration_s=3", "--set", "run.settle_s=2"]).output().expect("it starts")
    };
    let told = unfolded(budget(&folder).stderr);
    assert!(told.ends_with("written: report/budget.svg, report/budget.html\n"), "{told}");
    assert_eq!(names(&folder.join("report")), ["budget.html", "budget.svg"]);
    let taken = super::tool::folder("caller-taken");
    file(&taken, "report", "mine");
    let refusal = budget(&taken);
    let told = String::from_utf8(refusal.stderr).expect("text");
    assert_eq!((refusal.status.code(), told.as_str()), (Some(2), "error: report: must be a folder\n"));
}
