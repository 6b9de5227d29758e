//! Names with line breaks, markup, formulas and control characters stay names in every output.

use std::fs;

use super::tool::{NODE, SHIPPED, accepted, file, folder, place};

const SHORT: [&str; 4] = ["--set", "run.duration_s=0.3", "--set", "run.settle_s=0.2"];
/// The smallest map.
const SMALL_MAP: [&str; 8] =
    ["--amplitude", "0.5:0.55", "--frequency", "10:10.5", "--places", "30", "--error", "0.5"];

#[cfg(unix)]
#[test]
fn a_name_of_a_scene_puts_no_line_into_a_generated_module() {
    let folder = folder("hostile-modules");
    let shipped = fs::read_to_string(SHIPPED).expect("the shipped scene");
    let module = place(&folder, "m.rs");
    let output = module.as_str();
    for (name, word) in [
        ("a\ncompile_error!(\"injected\");\n--.toml", r#"$'a\012compile_error!("injected");\012--.toml'"#),
        ("a b;$(touch x).toml", "'a b;$(touch x).toml'"),
        ("a\u{202e}b\u{2028}.toml", r"$'a\342\200\256b\342\200\250.toml'"),
    ] {
        let scene = file(&folder, name, &shipped);
        let needs = [&["needs", &scene, "--emit", output], &SHORT[..]].concat();
        let map = [&["map", &scene, "--output", output], &SMALL_MAP[..]].concat();
        // A map takes seconds; quoting is the same for all names.
        let is_mapped = name.contains("injected");
        for arguments in [Some(needs), is_mapped.then_some(map)].into_iter().flatten() {
            accepted(&arguments);
            let text = fs::read_to_string(&module).expect("the module");
            let is_code = |line: &&str| line.contains("injected") && !line.starts_with("//");
            assert_eq!(text.lines().find(is_code), None, "{name:?}");
            assert!(!text.contains(['\u{202e}', '\u{2028}']), "{name:?}");
            let word =
                if arguments[0] == "needs" { word.trim_start_matches("$'").trim_matches('\'') } else { word };
            let command = text.lines().find(|line| line.contains("host-bench ")).expect("the command");
            assert!(command.contains(word), "{command}");
        }
    }
}

#[cfg(unix)]
#[test]
fn names_of_actions_and_traces_stay_names() {
    let folder = folder("hostile-names");
    let node = fs::read_to_string(NODE).expect("shipped");
    let named = node.replacen("\"measure\"", r#""=1+1\u001b[31m\n<!--<script>""#, 1);
    assert_ne!(named, node);
    let scene = file(&folder, "node.toml", named);
    let short = ["--set", "run.duration_s=3", "--set", "run.settle_s=2"];
    let budget = |format: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_host-bench"));
        command.current_dir(&folder).args(["budget", &scene, "--format", format]).args(short);
        let output = command.output().expect("it starts");
        String::from_utf8(output.stdout).expect("text")
    };
    for (format, heading) in [
        ("table", "=1+1\\u{1b}[31m\\u{a}<!--<script>_runs"),
        ("csv", ",'=1+1\\u{1b}[31m\\u{a}<!--<script>_runs,"),
    ] {
        let told = budget(format);
        assert!(!told.contains('\u{1b}') && told.contains(heading), "{told}");
    }
    let [trace, page] = &["<!--<script>.csv", "page.html"].map(|name| place(&folder, name));
    accepted(&[&["run", SHIPPED, "--trace", trace, "--trace-every", "1e-3"], &SHORT[..]].concat());
    accepted(&[&["plot", SHIPPED, trace, "--output", page], &SHORT[..]].concat());
    for page in [folder.join("report/budget.html"), page.into()] {
        let text = fs::read_to_string(page).expect("the page");
        // The charts and their library are scripts; a browser ends no script within a comment that one of them opens.
        assert!(!text.contains("<!--") && text.contains("\\u003c!--\\u003cscript>"), "a comment in the page");
    }
}
