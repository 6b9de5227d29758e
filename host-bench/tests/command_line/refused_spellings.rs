//! Keys that are misspelt, and files that are not TOML.

use super::tool::{SHIPPED, file, folder, refused};

const NODE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/node.toml");

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
