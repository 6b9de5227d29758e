//! Every number with every kind of bad value, every table with an unknown and a missing key.

use super::tool::{SHIPPED, file, folder, refused, refused_with};

/// What no number may be.
const NO_NUMBERS: [&str; 9] = ["nan", "inf", "-inf", "1e30", "-1e30", "1e999", "true", "{}", "[1]"];

/// Each number: its key, overrides that make it be read, values out of its bounds, and the bounds.
fn numbers() -> Vec<(&'static str, &'static [&'static str], Vec<&'static str>, &'static str)> {
    const NONE: &[&str] = &[];
    const CONSTANT: &[&str] = &["parameters.restitution={kind=\"constant\",coefficient=1}"];
    const FILE: &[&str] =
        &["excitation={kind=\"file\",path=\"a.csv\",column=1,rate_hz=400,scale_m_per_s2=1}"];
    vec![
        ("parameters.mass_kg", NONE, vec!["0", "-5e-3", "1e-13", "1001"], "from 1e-12 to 1e3"),
        ("parameters.stiffness_n_per_m", NONE, vec!["0", "-80", "2e9"], "from 1e-9 to 1e9"),
        ("parameters.damping_ratio", NONE, vec!["-0.005", "10.1"], "from 0 to 10"),
        ("parameters.initial_gap_m", NONE, vec!["0", "-3e-3", "1.1"], "from 1e-9 to 1"),
        ("parameters.electrode_area_m2", NONE, vec!["0", "-4e-4", "11"], "from 1e-12 to 10"),
        ("parameters.dielectric_thickness_m", NONE, vec!["0", "-5e-5", "0.2"], "from 1e-9 to 0.1"),
        ("parameters.relative_permittivity", NONE, vec!["0", "0.99", "-2", "1e6"], "from 1 to 1e5"),
        ("parameters.charge_density_c_per_m2", NONE, vec!["-1e-9", "0.011"], "from 0 to 0.01"),
        ("parameters.parasitic_capacitance_f", NONE, vec!["-1e-12", "1e-2"], "from 0 to 1e-3"),
        ("parameters.restitution.at_rest", NONE, vec!["-0.1", "1.001"], "from 0 to 1"),
        ("parameters.restitution.at_speed", NONE, vec!["-0.1", "1.001"], "from 0 to 1"),
        ("parameters.restitution.reference_speed_m_per_s", NONE, vec!["0", "-0.3"], "from 1e-9 to 1e3"),
        ("parameters.restitution.coefficient", CONSTANT, vec!["-0.1", "1.001"], "from 0 to 1"),
        ("initial.gap_m", NONE, vec!["-1e-12", "1.1"], "from 0 to 1"),
        ("initial.velocity_m_per_s", NONE, vec!["1001", "-1001"], "from -1e3 to 1e3"),
        ("initial.charge_c", NONE, vec!["1.1", "-1.1"], "from -1 to 1"),
        ("excitation.amplitude_g", NONE, vec!["-0.2", "1e5"], "from 0 to 1e4"),
        ("excitation.amplitude_m_per_s2", NONE, vec!["-2", "1e6"], "from 0 to 1e5"),
        ("excitation.frequency_hz", NONE, vec!["-20", "2e6"], "from 0 to 1e6"),
        ("excitation.phase_rad", NONE, vec!["1001", "-1001"], "from -1e3 to 1e3"),
        ("excitation.rate_hz", FILE, vec!["0", "-400", "2e6"], "from 1e-3 to 1e6"),
        ("excitation.scale_m_per_s2", FILE, vec!["2e6", "-2e6"], "from -1e6 to 1e6"),
        ("run.duration_s", NONE, vec!["0", "-15", "1e8"], "from 1e-6 to 1e7"),
        ("run.settle_s", NONE, vec!["-10", "1e8"], "from 0 to 1e7"),
        ("run.duration_periods", NONE, vec!["-300"], "from 0 to 1e12"),
        ("run.settle_periods", NONE, vec!["-200"], "from 0 to 1e12"),
    ]
}

#[test]
fn a_number_out_of_its_bounds() {
    for (key, context, values, bound) in numbers() {
        for value in values.into_iter().chain(NO_NUMBERS) {
            let change = format!("{key}={value}");
            let shown = if value.starts_with(['{', '[']) { "a " } else { value };
            let mut overrides = context.to_vec();
            overrides.push(&change);
            refused_with(&overrides, &[SHIPPED, key, shown, bound]);
        }
    }
}

#[test]
fn a_resistance_may_be_nothing_or_infinite_but_not_negative_or_absurd() {
    for value in ["-1", "-inf", "nan", "1e31", "1e-10", "1e999", "true"] {
        let change = format!("load.resistance_ohm={value}");
        refused_with(&[&change], &["load.resistance_ohm", value, "0, inf, or a number from 1e-9 to 1e30"]);
    }
}

#[test]
fn a_text_where_a_number_stands() {
    for (key, context, _, bound) in numbers() {
        for (written, shown) in [("3 apples", "\"3 apples\""), ("\"1\"", "\"1\""), ("1,5", "\"1,5\"")] {
            let change = format!("{key}={written}");
            let mut overrides = context.to_vec();
            overrides.push(&change);
            refused_with(&overrides, &[key, shown, bound]);
        }
    }
}

#[test]
fn a_word_that_is_not_one_of_the_choices() {
    for (key, choice) in [
        ("scene", "\"contact-separation\" or \"sliding\" or \"bump-stop\""),
        ("parameters.force_law", "\"transferred-charge\" or \"gap-field\""),
        ("parameters.stick_charge", "\"frozen\" or \"relaxing\""),
        ("parameters.restitution.kind", "\"constant\" or \"velocity-dependent\""),
        ("load.kind", "\"resistor\""),
        ("excitation.kind", "\"sine\" or \"sines\" or \"file\" or \"half-sine\""),
    ] {
        for (value, shown) in [("Exact", "\"Exact\""), ("3", "3"), ("\"\"", "\"\""), ("true", "true")] {
            refused_with(&[&format!("{key}={value}")], &[key, shown, choice]);
        }
    }
}

#[test]
fn a_bridge_without_its_numbers() {
    for (change, key) in [
        ("load={kind='rectified-store'}", "load.capacitance_f: is missing"),
        ("load={kind='dc-bus'}", "load.voltage_v: is missing"),
        ("load={kind='dc-bus',voltage_v=3.0}", "load.diode_drop_v: is missing"),
        ("load={kind='dc-bus',voltage_v=-1.0,diode_drop_v=0.3}", "load.voltage_v = -1"),
    ] {
        refused_with(&[change], &[key, "a number from"]);
    }
}

#[test]
fn a_draw_that_has_no_consistent_switching() {
    let store = "capacitance_f=1e-6,diode_drop_v=0.3,leakage_ohm=inf,initial_v=0.0";
    for (draw, told) in [
        ("{kind='power',value=1e-6,turn_on_v=3.0,turn_off_v=0.0}", "load.draw.turn_off_v = 0"),
        ("{kind='power',value=1e-6,turn_on_v=2.0,turn_off_v=2.0}", "must be below turn_on_v = 2"),
        ("{kind='current',value=1e-6,turn_on_v=2.0,turn_off_v=3.0}", "must be below turn_on_v = 2"),
        ("{kind='current',value=1e-6}", "load.draw.turn_on_v: is missing"),
        ("{kind='lamp'}", "\"none\" or \"resistor\" or \"current\" or \"power\""),
    ] {
        refused_with(&[&format!("load={{kind='rectified-store',{store},draw={draw}}}")], &[told]);
    }
}

#[test]
fn an_unknown_key_at_any_level() {
    let keys = "extra extra.deep.key parameters.extra parameters.mass parameters.restitution.coefficient load.extra load.draw.kind \
                excitation.extra excitation.repeat run.extra initial.voltage_v";
    for key in keys.split(' ') {
        refused_with(&[&format!("{key}=1")], &[SHIPPED, key, "1", "unknown key"]);
    }
    refused_with(
        &["excitation={kind=\"sines\",tones=[{amplitude_g=0.1,frequency_hz=20,extra=1}]}"],
        &["excitation.tones[0].extra = 1", "unknown key"],
    );
    refused_with(&["excitation={kind=\"silence\",frequency_hz=1}"], &["excitation.frequency_hz", "unknown"]);
}

#[test]
fn a_table_that_is_none() {
    for key in ["parameters", "parameters.restitution", "load", "excitation", "run", "initial"] {
        refused_with(&[&format!("{key}=1")], &[&format!("{key} = 1"), "must be a table"]);
    }
    for (tones, shown) in [("1", "1"), ("[]", "[a list of 0]"), ("[1]", "[a list of 1]")] {
        let change = format!("excitation={{kind=\"sines\",tones={tones}}}");
        refused_with(&[&change], &["excitation.tones", shown, "a list of tables, at least one"]);
    }
}

#[test]
fn a_missing_key_is_named_with_its_bound() {
    let shipped = std::fs::read_to_string(SHIPPED).expect("the shipped scene");
    let folder = folder("missing-keys");
    for (line, key, wanted) in [
        ("scene", "scene", "contact-separation"),
        ("mass_kg", "parameters.mass_kg", "from 1e-12 to 1e3"),
        ("stiffness_n_per_m", "parameters.stiffness_n_per_m", "from 1e-9 to 1e9"),
        ("damping_ratio", "parameters.damping_ratio", "from 0 to 10"),
        ("initial_gap_m", "parameters.initial_gap_m", "from 1e-9 to 1"),
        ("electrode_area_m2", "parameters.electrode_area_m2", "from 1e-12 to 10"),
        ("dielectric_thickness_m", "parameters.dielectric_thickness_m", "from 1e-9 to 0.1"),
        ("relative_permittivity", "parameters.relative_permittivity", "from 1 to 1e5"),
        ("charge_density_c_per_m2", "parameters.charge_density_c_per_m2", "from 0 to 0.01"),
        ("force_law", "parameters.force_law", "transferred-charge"),
        ("stick_charge", "parameters.stick_charge", "frozen"),
        ("restitution", "parameters.restitution", "a table"),
        ("resistance_ohm", "load.resistance_ohm", "from 1e-9 to 1e30"),
        ("kind", "load.kind", "resistor"),
        ("amplitude_g", "excitation.amplitude_m_per_s2", "from 0 to 1e5"),
        ("frequency_hz", "excitation.frequency_hz", "from 0 to 1e6"),
        ("duration_s", "run.duration_s", "from 1e-6 to 1e7"),
    ] {
        let mut found = false;
        let without: String = shipped
            .lines()
            .filter(|text| {
                let skip = !found && text.starts_with(&format!("{line} ="));
                found |= skip;
                !skip
            })
            .map(|text| format!("{text}\n"))
            .collect();
        assert!(found, "{line} is in the shipped scene");
        let scene = file(&folder, "scene.toml", without);
        refused(&["run", &scene, "--method", "reference"], &[&scene, key, "is missing", wanted]);
    }
    for table in ["parameters", "load", "excitation", "run"] {
        let start = shipped.find(&format!("[{table}]")).expect("the table is there");
        let rest = &shipped[start + 1..];
        let end = rest.find("\n[").map_or(shipped.len(), |end| start + 1 + end);
        let scene = file(&folder, "scene.toml", format!("{}{}", &shipped[..start], &shipped[end..]));
        refused(&["run", &scene, "--method", "reference"], &[&scene, table, "is missing"]);
    }
}

#[test]
fn numbers_that_do_not_fit_together() {
    refused_with(&["run.settle_s=15"], &["run.settle_s = 15", "before the end of the run at 15 s"]);
    refused_with(&["run.duration_s=10"], &["run.settle_s = 10.0", "at 10 s", ":34:"]);
    refused_with(
        &["parameters.stiffness_n_per_m=1e9", "parameters.mass_kg=1e-12"],
        &["parameters.stiffness_n_per_m = 1e9", "natural frequency", "from 1e-3 to 1e4"],
    );
    refused_with(
        &["excitation={kind=\"sine\",amplitude_g=1,amplitude_m_per_s2=9.81,frequency_hz=1}"],
        &["excitation.amplitude_g = 1", "beside amplitude_m_per_s2"],
    );
    refused_with(
        &["run={duration_s=1,duration_periods=20}"],
        &["run.duration_periods = 20", "beside duration_s"],
    );
    for excitation in ["{kind=\"silence\"}", "{kind=\"sine\",amplitude_g=1,frequency_hz=0}"] {
        refused_with(
            &[&format!("excitation={excitation}"), "run.duration_periods=20"],
            &["run.duration_periods = 20", "one sine"],
        );
    }
    refused_with(&["run.duration_periods=1e12"], &["run.duration_periods = 1e12", "to 1e7 s"]);
}

#[test]
fn the_line_of_the_file_is_told() {
    let shipped = std::fs::read_to_string(SHIPPED).expect("the shipped scene");
    let folder = folder("lines");
    let line = 1 + shipped.lines().position(|line| line.starts_with("damping_ratio")).expect("is there");
    for (bad, shown) in [("damping_ratio = -1", "= -1: must be"), ("damping_ratio = '3 mm'", "\"3 mm\"")] {
        let scene = file(&folder, "scene.toml", shipped.replace("damping_ratio = 0.005", bad));
        let place = format!("{scene}:{line}: parameters.damping_ratio");
        refused(&["run", &scene, "--method", "reference"], &[&place, shown]);
    }
    for bad in ["damping_ratio = ", "damping_ratio 0.005", "damping_ratio = 0.005\ndamping_ratio = 0.005"] {
        let scene = file(&folder, "scene.toml", shipped.replace("damping_ratio = 0.005", bad));
        refused(&["run", &scene, "--method", "reference"], &[&format!("{scene}:"), "is not TOML"]);
    }
}

#[test]
fn a_file_that_is_no_scene() {
    let folder = folder("no-scene");
    let absent = folder.join("absent.toml");
    let absent = absent.to_str().expect("a plain path");
    refused(&["run", absent, "--method", "reference"], &[absent, "cannot be read"]);
    let itself = folder.to_str().expect("a plain path");
    refused(&["run", itself, "--method", "reference"], &[itself, "cannot be read"]);
    let empty = file(&folder, "empty.toml", "");
    refused(&["run", &empty, "--method", "reference"], &[&empty, "scene", "is missing"]);
    let bytes = file(&folder, "bytes.toml", b"scene = 1\n\xff\xfe");
    refused(&["run", &bytes, "--method", "reference"], &[&bytes, ":2:", "UTF-8"]);
    let line_break = file(&folder, "break.toml", "scene = \"a\\nb\"");
    refused(&["run", &line_break, "--method", "reference"], &["scene = \"a\\nb\""]);
}

#[test]
fn an_override_that_leads_nowhere() {
    refused_with(&["scene.deep=1"], &["scene.deep = 1", "no table"]);
    refused_with(&["excitation.tones.0=1"], &["excitation.tones"]);
    // A line break must not smuggle in a second key.
    refused_with(&["parameters.mass_kg=1\nextra=2"], &["parameters.mass_kg", "from 1e-12"]);
    for bad in ["parameters.mass_kg", "=1", "parameters.mass_kg=", ""] {
        refused(&["run", SHIPPED, "--method", "reference", "--set", bad], &["--set", "KEY=VALUE"]);
    }
}
