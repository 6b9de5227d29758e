//! Commands that are killed, that meet another command at their files, and whose files cannot be written.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::tool::{MEASURED, NODE, SHIPPED, accepted, file, folder, host_bench, place, refused};

const SHORT: [&str; 4] = ["--set", "run.duration_s=0.3", "--set", "run.settle_s=0.2"];

/// A row of a file of rows with its checksum, FNV-1a of 64 bits.
pub(super) fn with_checksum(row: &str) -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in row.bytes() {
        hash ^= u64::from(byte);
        hash = hash.wrapping_mul(0x0100_0000_01b3);
    }
    format!("{row},{hash:016x}")
}

pub(super) fn text(path: &Path) -> &str {
    path.to_str().expect("a plain path")
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).replace("\n  ", " ")
}

/// The binary in a folder, with files of at most so many kilobytes: the system kills it at the write that goes beyond.
fn killed_at(folder: &Path, kilobytes: Option<u64>, arguments: &[&str]) -> Output {
    let limit = kilobytes.map_or_else(String::new, |most| format!("ulimit -f {most};"));
    let script = format!("ulimit -c 0; {limit} exec \"$@\"");
    let mut command = Command::new("bash");
    command.args(["-c", &script, "bash", env!("CARGO_BIN_EXE_host-bench")]).args(arguments);
    command.env("RAYON_NUM_THREADS", "1").current_dir(folder).output().expect("bash is there")
}

/// The files under a folder with their content.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("the folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(name, content)| (path.join(name), content)));
        } else {
            found.insert(path.clone(), fs::read(&path).expect("the file"));
        }
    }
    let below = |(path, content): (PathBuf, _)| {
        (path.strip_prefix(folder).map(Path::to_owned).unwrap_or(path), content)
    };
    found.into_iter().map(below).collect()
}

/// Kills a command within each of the files that it writes whole, and runs it again until it ends.
#[cfg(unix)]
fn kill_at_each_file(name: &str, arguments: &[&str]) {
    let [whole, killed] = ["whole", "killed"].map(|kind| folder(&format!("{kind}-{name}")));
    let uninterrupted = killed_at(&whole, None, arguments);
    assert_eq!(uninterrupted.status.code(), Some(0), "{name}: {}", told(&uninterrupted));
    let whole = files(&whole);
    assert!(!whole.is_empty(), "{name} writes no file");
    let sizes = whole.values().map(|content| content.len() as u64);
    let limits: BTreeSet<u64> = sizes.flat_map(|size| [0, size / 2048, (size - 1) / 1024]).collect();
    for limit in &limits {
        let output = killed_at(&killed, Some(*limit), arguments);
        assert_eq!(output.status.code(), None, "{name} at {limit} kB: {}", told(&output));
        let mut left = files(&killed);
        left.retain(|path, _| !text(path).ends_with(".host-bench.part"));
        for (path, content) in left {
            assert!(whole.get(&path) == Some(&content), "{name} at {limit} kB: {path:?}");
            // As it was before the command.
            fs::remove_file(killed.join(path)).expect("my own file");
        }
    }
    let last = killed_at(&killed, None, arguments);
    assert_eq!(last.status.code(), Some(0), "{name}: {}", told(&last));
    assert!(told(&last).contains("is taken over"), "{name}: {}", told(&last));
    let killed = files(&killed);
    assert!(whole.keys().eq(killed.keys()), "{name}: {:?}", killed.keys());
    assert!(whole == killed, "{name} wrote other bits");
}

#[cfg(unix)]
#[test]
fn a_command_that_is_killed_within_a_file_leaves_no_part_of_it_and_ends_when_it_is_run_again() {
    let short = |arguments: &[&'static str]| [arguments, &SHORT[..]].concat();
    let map = ["map", SHIPPED, "--amplitude", "0.5:0.55", "--frequency", "10:10.5", "--places", "30"];
    let commands: [(&str, Vec<&str>); 4] = [
        ("run", short(&["run", SHIPPED, "--no-accuracy", "--trace", "t.csv", "--trace-every", "1e-2"])),
        ("map", [&map[..], &["--error", "0.5", "--output", "m.rs", "--picture", "page.html"]].concat()),
        ("budget", vec!["budget", NODE, "--learning-days", "0"]),
        ("new", vec!["new", "contact-separation", "--output", "new.toml"]),
    ];
    for (name, arguments) in commands {
        kill_at_each_file(name, &arguments);
    }
}

#[cfg(unix)]
#[test]
#[ignore = "nightly: two minutes"]
fn other_commands_and_figures_that_are_killed_within_a_file_leave_no_part_of_it() {
    let short = |arguments: &[&'static str]| [arguments, &SHORT[..]].concat();
    let over = "load.resistance_ohm=1e6:1e8:log";
    let best = ["optimise", SHIPPED, "--maximise", "mean_power_w", "--over", over, "--grid", "3"];
    let figures = ["figures", "--only", "sliding", "--single-start", "--output", "figures"];
    let commands: [(&str, Vec<&str>); 7] = [
        ("figures", figures.to_vec()),
        ("plot", short(&["plot", SHIPPED, "--output", "plot.svg"])),
        ("fit", vec!["fit", MEASURED, "--starts", "0", "--output", "f.toml", "--picture", "page.html"]),
        ("needs", vec!["needs", SHIPPED, "--emit", "n.rs"]),
        ("optimise", [&best[..], &SHORT, &["--output", "o.toml", "--picture", "page.html"]].concat()),
        ("attractors", short(&["attractors", SHIPPED, "--starts", "4", "--picture", "a.svg"])),
        ("picture", short(&["run", SHIPPED, "--no-accuracy", "--format", "csv", "--picture", "p.svg"])),
    ];
    for (name, arguments) in commands {
        kill_at_each_file(name, &arguments);
    }
}

/// The rows of CSV without the columns that differ from run to run.
pub(super) fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut rows = super::tool::rows(text);
    for row in &mut rows {
        row.retain(|name, _| !["processor_s", "checksum_fnv1a"].contains(&name.as_str()));
    }
    rows
}

/// Those of stability stand in the order in which they were judged.
pub(super) fn sorted_rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut rows = rows(text);
    rows.sort();
    rows
}

#[cfg(unix)]
#[test]
fn a_command_that_is_killed_at_each_of_its_writes_ends_as_one_that_is_not() {
    let over = ["sweep", SHIPPED, "--over", "load.resistance_ohm=1e6:1e8:3:log", "--no-accuracy"];
    let commands: [(&str, Vec<&str>, &str); 2] = [
        ("sweep", [&over[..], &SHORT, &["--format", "csv", "--output", "."]].concat(), "sweep.csv"),
        ("stability", vec!["stability", "--random", "5", "--seed", "3", "--output", "rows.csv"], "rows.csv"),
    ];
    for (name, arguments, table) in commands {
        let [whole, killed] = ["whole", "killed"].map(|kind| folder(&format!("{kind}-{name}")));
        let uninterrupted = killed_at(&whole, None, &arguments);
        let mut kills = 0;
        // Each run goes on from the rows of the one before, which is killed within a row.
        let last = loop {
            let output = killed_at(&killed, Some(kills + 1), &arguments);
            assert!(kills < 400, "{name} does not end");
            // A file that may grow no more ends a command by a signal.
            if output.status.code().is_some() {
                break output;
            }
            kills += 1;
        };
        assert!(kills > 1, "{name} was killed {kills} times");
        assert_eq!(last.status.code(), uninterrupted.status.code(), "{name}: {}", told(&last));
        assert!(told(&last).contains("is taken over"), "{name}: {}", told(&last));
        let [one, other] = [whole, killed].map(|folder| {
            let entries = fs::read_dir(&folder).expect("the folder");
            let mut names: Vec<_> = entries.map(|entry| entry.expect("an entry").file_name()).collect();
            names.sort();
            (names, sorted_rows(&fs::read_to_string(folder.join(table)).expect("the table")))
        });
        assert_eq!(one, other, "{name}");
    }
}

#[test]
fn a_file_that_another_command_writes_is_refused_and_that_of_one_that_is_gone_is_taken_over() {
    let folder = folder("locked");
    let rows = folder.join("rows.csv");
    let trace = folder.join("trace.csv");
    let run = [&["run", SHIPPED, "--trace", text(&trace), "--trace-every", "1e-2"], &SHORT[..]].concat();
    let stability = ["stability", "--random", "1", "--output", text(&rows)];
    let sweep = ["sweep", SHIPPED, "--over", "load.resistance_ohm=1e6:1e8:2", "--output", text(&folder)];
    let sweep = [&sweep[..], &SHORT, &["--no-accuracy"]].concat();
    for (arguments, name) in
        [(&run[..], "trace.csv"), (&stability[..], "rows.csv"), (&sweep[..], "sweep.rows.jsonl")]
    {
        let part = folder.join(format!("{name}.host-bench.part"));
        let held = File::create(&part).expect("a file");
        held.try_lock().expect("my own file");
        refused(arguments, &["--", name, "is being written by another command"]);
        drop(held);
        let output = host_bench(arguments);
        assert_eq!(output.status.code(), Some(0), "{}", told(&output));
        assert!(told(&output).contains(&format!("{name}.host-bench.part: was left")), "{}", told(&output));
        assert!(!part.exists(), "{name}: the lock is left");
    }
}

#[test]
fn two_outputs_of_a_command_are_two_files() {
    let folder = folder("same-output");
    let [drawing, again, drawn, map, module] =
        ["x.svg", "../same-output/x.svg", "fitted.svg", "x.bin", "x.toml"].map(|name| place(&folder, name));
    let scene = file(&folder, "fitted.toml", "");
    let of_map = ["map", SHIPPED, "--amplitude", "1:2", "--frequency", "19:20", "--output", &map];
    for (arguments, picture) in [
        (&["run", SHIPPED, "--trace-every=1e-3", "--trace", &drawing][..], &again),
        (&["fit", MEASURED, "--output", &module], &drawing),
        (&["fit", MEASURED, "--output", &scene], &drawn),
        (&of_map, &drawing),
    ] {
        let told = match arguments[0] {
            "map" => "--output writes this picture: leave --picture out",
            _ => "must not be the file of another output of this command",
        };
        refused(&[arguments, &["--picture", picture]].concat(), &["--picture", told]);
        assert!(!folder.join("x.svg").exists());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_result_is_printed_where_its_files_cannot_be_written() {
    let folder = folder("full-disk");
    let full = |script: &str, arguments: &[&str]| {
        // A program that ignores the signal of a limit has an error at the write, as on a full disk.
        let script = format!("trap '' XFSZ; {script}");
        let mut command = Command::new("bash");
        command.args(["-c", &script, "bash", env!("CARGO_BIN_EXE_host-bench")]).args(arguments);
        command.output().expect("bash is there")
    };
    let picture = folder.join("run.svg");
    let run = [&["run", SHIPPED, "--no-accuracy", "--picture", text(&picture)], &SHORT[..]].concat();
    let output = full("ulimit -f 1; exec \"$@\"", &run);
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    assert!(String::from_utf8_lossy(&output.stdout).contains("mean_power_w"), "{}", told(&output));
    assert!(told(&output).contains("run.svg: cannot be written"), "{}", told(&output));
    assert_eq!(fs::read_dir(&folder).expect("the folder").count(), 0, "nothing is left");
    let output = full("exec \"$@\" > /dev/full", &["completions", "bash"]);
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    // What a full disk left of a file of rows.
    for left in ["", "number,sc"] {
        let rows = file(&folder, "rows.csv", left);
        accepted(&["stability", "--random", "1", "--output", &rows]);
        assert_eq!(fs::read_to_string(&rows).expect("rows").lines().count(), 2);
    }
}

/// The modes of a folder do not hold for a superuser; in these none can make a file.
#[cfg(target_os = "linux")]
#[test]
fn an_output_in_a_folder_in_which_no_file_can_be_made_is_refused() {
    use std::os::unix::fs::PermissionsExt;

    let own = folder("read-only");
    fs::set_permissions(&own, fs::Permissions::from_mode(0o555)).expect("my own folder");
    let mut folders = vec![Path::new("/proc/self")];
    folders.extend(File::create(own.join("trial")).is_err().then_some(own.as_path()));
    for folder in folders {
        for (name, arguments) in [
            ("x.csv", &["run", SHIPPED, "--trace-every", "1e-3", "--trace"][..]),
            ("x.rs", &["needs", SHIPPED, "--emit"]),
            ("x.csv", &["stability", "--random", "1", "--output"]),
            ("", &["sweep", SHIPPED, "--over", "load.resistance_ohm=1e6:1e8:2", "--output"]),
        ] {
            let path = folder.join(name);
            refused(&[arguments, &[text(&path)]].concat(), &[text(&path), "cannot be written"]);
        }
    }
    let below = Path::new(&file(&folder("below-a-file"), "file", "")).join("x.csv");
    refused(&["stability", "--random", "1", "--output", text(&below)], &[text(&below), "must be a folder"]);
}

#[cfg(unix)]
#[test]
fn an_output_through_a_link_goes_to_where_the_link_leads() {
    use std::os::unix::fs::symlink;

    let folder = folder("linked");
    fs::create_dir_all(folder.join("far")).expect("a folder");
    let link = |name: &str| {
        let link = folder.join(name);
        symlink(Path::new("far").join(name), &link).expect("a link");
        link
    };
    let is_link = |path: &Path| fs::symlink_metadata(path).expect("it is there").is_symlink();
    // A link that leads nowhere is refused.
    let module = link("n.rs");
    let needs = ["needs", SHIPPED, "--emit", text(&module)];
    refused(&needs, &["--emit", "n.rs", "is a link that leads nowhere"]);
    fs::write(folder.join("far/n.rs"), "old").expect("a file");
    accepted(&needs);
    let written = fs::read_to_string(folder.join("far/n.rs")).expect("the module");
    assert!(is_link(&module) && written.contains("host-bench needs"), "{written}");
    // Rows are appended there, and a file that loses a damaged row is replaced there.
    let rows = link("rows.csv");
    fs::write(folder.join("far/rows.csv"), "").expect("a file");
    let stability = ["stability", "--random", "2", "--output", text(&rows)];
    accepted(&stability);
    let whole = fs::read_to_string(folder.join("far/rows.csv")).expect("the rows");
    fs::write(folder.join("far/rows.csv"), &whole[..whole.len() - 9]).expect("the rows");
    let output = host_bench(&stability);
    assert!(told(&output).contains("1 rows that are damaged"), "{}", told(&output));
    let again = fs::read_to_string(folder.join("far/rows.csv")).expect("the rows");
    assert!(is_link(&rows) && sorted_rows(&again) == sorted_rows(&whole), "{again}");
    // The same file by two names.
    let trace = link("t.svg");
    fs::write(folder.join("far/t.svg"), "old").expect("a file");
    let far = folder.join("far/t.svg");
    let run = ["run", SHIPPED, "--trace-every", "1e-3", "--trace", text(&trace), "--picture", text(&far)];
    refused(&run, &["--picture", "must not be the file of another output of this command"]);
    assert_eq!(fs::read_dir(folder.join("far")).expect("the folder").count(), 3, "a lock is left");
}

#[cfg(target_os = "linux")]
#[test]
fn rows_in_what_is_no_file_are_refused_at_once() {
    let folder = folder("no-file");
    let pipe = folder.join("sweep.rows.jsonl");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo is there").success());
    let zero = folder.join("zero.csv");
    std::os::unix::fs::symlink("/dev/zero", &zero).expect("a link");
    let sweep = ["sweep", SHIPPED, "--over", "load.resistance_ohm=1e6:1e8:2", "--output", text(&folder)];
    for arguments in [&sweep[..], &["stability", "--random", "1", "--output", text(&pipe)]] {
        let mut command = Command::new("timeout");
        let output = command.arg("20").arg(env!("CARGO_BIN_EXE_host-bench")).args(arguments).output();
        let output = output.expect("timeout is there");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", told(&output));
        assert!(
            told(&output).contains("is a device, a pipe or a socket, must be a file"),
            "{}",
            told(&output)
        );
    }
    for path in [text(&zero), "/dev/zero"] {
        refused(&["stability", "--random", "1", "--output", path], &[path, "is a device"]);
    }
}
