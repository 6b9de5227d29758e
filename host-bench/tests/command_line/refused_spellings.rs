//! Keys that are misspelt, given twice, or of no use to the command; and files that are not TOML.

use super::tool::{NODE, SHIPPED, accepted, file, folder, refused, set};

#[test]
fn a_misspelt_required_key_is_told_with_its_line() {
    let shipped = std::fs::read_to_string(SHIPPED).expect("the shipped scene");
    let folder = folder("misspelt");
    for (right, wrong, table) in [
        ("mass_kg", "mas_kg", "parameters."),
        ("mass_kg", "mass", "parameters."),
        ("mass_kg", "mass_g", "parameters."),
        ("stiffness_n_per_m", "stifness_n_per_m", "parameters."),
        ("relative_permittivity", "relative_permitivitty", "parameters."),
        ("force_law", "forcelaw", "parameters."),
        ("restitution", "restituton", "parameters."),
        ("resistance_ohm", "resistance", "load."),
        ("resistance_ohm", "Resistance_Ohm", "load."),
        ("amplitude_g", "amplitud_g", "excitation."),
        ("frequency_hz", "frequenzy_hz", "excitation."),
        ("duration_s", "duraton_s", "run."),
        ("scene", "scen", ""),
    ] {
        let line =
            1 + shipped.lines().position(|line| line.starts_with(&format!("{right} ="))).expect("is there");
        let misspelt = shipped.replacen(&format!("\n{right} ="), &format!("\n{wrong} ="), 1);
        let misspelt = if misspelt == shipped { shipped.replacen(right, wrong, 1) } else { misspelt };
        let scene = file(&folder, "scene.toml", misspelt);
        let place = format!("{scene}:{line}: {table}{wrong} = ");
        refused(&["run", &scene], &[&place, &format!("probably {right} misspelt"), "must be"]);
    }
    // The value is that of another unit.
    let scene = file(&folder, "scene.toml", shipped.replace("mass_kg = 5e-3", "mass_g = 5"));
    refused(&["run", &scene], &["probably mass_kg misspelt, in kg and not in g: 5e-3, which is missing"]);
    let scene = file(&folder, "scene.toml", shipped.replace("[excitation]", "[exitation]"));
    refused(&["run", &scene], &[&format!("{scene}:"), "exitation", "probably excitation misspelt"]);
    // A missing key beside one of another quantity with a like name.
    let node = std::fs::read_to_string(NODE).expect("the shipped scene");
    let without = file(&folder, "node.toml", node.replace("preset = \"bq25504\"", "turn_on_v = 2.8"));
    refused(&["budget", &without], &["node.storage.charging_efficiency: is missing"]);
    let thresholds = "load={kind='rectified-store',capacitance_f=1e-6,diode_drop_v=0.3,leakage_ohm=inf,initial_v=0.0,\
                      draw={kind='power',value=1e-6,turn_on_v=3.0}}";
    refused(&["run", SHIPPED, "--set", thresholds], &["load.draw.turn_off_v: is missing"]);
}

#[test]
fn what_is_not_toml_is_shown_with_its_line() {
    let shipped = std::fs::read_to_string(SHIPPED).expect("the shipped scene");
    let folder = folder("no-toml");
    let line = 1 + shipped.lines().position(|line| line.starts_with("damping_ratio")).expect("is there");
    for bad in ["damping_ratio = ", "damping_ratio 0.005", "damping_ratio = 5 %", "damping_ratio = 0,005"] {
        let scene = file(&folder, "scene.toml", shipped.replace("damping_ratio = 0.005", bad));
        refused(&["run", &scene], &[&format!("{scene}:{line}: is not TOML"), bad.trim()]);
    }
    let twice = shipped.replace("damping_ratio = 0.005", "damping_ratio = 0.005\ndamping_ratio = 0.01");
    let scene = file(&folder, "scene.toml", twice);
    refused(
        &["run", &scene],
        &[&format!("{scene}:{}: is not TOML: duplicate key", line + 1), "damping_ratio = 0.01"],
    );
}

#[test]
fn a_key_with_line_breaks_and_escape_sequences_is_told_in_one_line() {
    let key = "parameters.ma\r\nss\u{1b}[31m_kg";
    refused(
        &["run", SHIPPED, "--set", &format!("{key}=1")],
        &["parameters.ma\\u{d}\\u{a}ss\\u{1b}[31m_kg = 1: unknown key"],
    );
}

#[test]
fn a_key_that_another_option_replaces() {
    let over = ["--over", "load.resistance_ohm=1e6:1e8:2"];
    for (command, options, parts) in [
        ("run", "run.settle_s=0 run.settle_s=1", ["--set run.settle_s", "after --set run.settle_s"]),
        (
            "run",
            "run.settle_s=0 run.settle_periods=1",
            ["--set run.settle_periods", "after --set run.settle_s"],
        ),
        ("run", "run.settle_s=0 run={duration_s=2}", ["--set run:", "after --set run.settle_s"]),
        (
            "closed-form",
            "load.resistance_ohm=1 load.resistance_ohm=1",
            ["--set load.resistance_ohm", "after"],
        ),
        ("sweep", "load.resistance_ohm=1", ["--over load.resistance_ohm", "after --set load.resistance_ohm"]),
    ] {
        let of_sweep = if command == "sweep" { &over[..] } else { &[] };
        let options: Vec<&str> = options.split(' ').collect();
        refused(&[&[command, SHIPPED], &set(&options)[..], of_sweep].concat(), &parts);
    }
    let spaced = set(&["excitation.frequency_hz=9", " excitation . frequency_hz=8"]);
    refused(&[&["run", SHIPPED], &spaced[..]].concat(), &["--set excitation.frequency_hz", "after"]);
    // A part of what was set before.
    let tones = "excitation={kind='sines',tones=[{amplitude_g=0.1,frequency_hz=20}]}";
    let louder = "excitation.tones.0.amplitude_g=0.2";
    let short = ["--set", "run.duration_s=0.01", "--set", "run.settle_s=0"];
    accepted(&[&["run", SHIPPED, "--set", tones, "--set", louder], &short[..]].concat());
}

#[test]
fn a_key_that_the_command_does_not_use() {
    let node = ["--set", "node.update_s=30"];
    let of_node = ["--set node.update_s", "[node] is of the command budget"];
    refused(&[&["run", NODE], &node[..]].concat(), &of_node);
    refused(&[&["closed-form", NODE], &node[..]].concat(), &of_node);
    refused(&[&["work-precision", NODE], &node[..]].concat(), &of_node);
    refused(&["sweep", NODE, "--over", "node.update_s=1:2:2"], &["--over node.update_s", of_node[1]]);
    let resonance = ["resonance", SHIPPED, "--from", "19", "--to", "21"];
    for key in ["run.duration_s=20", "run.settle_periods=1", "excitation.frequency_hz=19"] {
        let told = format!("--set {}", key.split('=').next().unwrap_or(key));
        refused(&[&resonance[..], &["--set", key]].concat(), &[&told, "is not used here"]);
    }
    for key in ["run.duration_s=20", "initial.gap_m=1e-3"] {
        refused(&["closed-form", SHIPPED, "--set", key], &["is not used here", "steady motion"]);
    }
}
