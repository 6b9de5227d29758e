//! Mean power without a trajectory: `closed-form`.

use super::tool::{BEAM, BUMP_STOP, SHIPPED, accepted, json, number, refused};

const STORE: &str =
    "load={kind='rectified-store',capacitance_f=1e-6,diode_drop_v=0,leakage_ohm=2e5,initial_v=0}";

fn of(arguments: &[&str]) -> serde_json::Value {
    json(&[&["closed-form"], arguments].concat())
}

#[test]
fn a_scene_has_its_power_and_whether_that_holds() {
    let found = of(&[BEAM]);
    assert_eq!((&found["scene"], &found["holds"]), (&"bump-stop".into(), &true.into()));
    let single = of(&[BEAM, "--precision", "f32"]);
    assert!((number(&single, "mean_power_w") / number(&found, "mean_power_w") - 1.0).abs() < 1e-3);
    let found = of(&[BUMP_STOP]);
    assert_eq!((&found["holds"], &found["reason"]), (&false.into(), &"reaches-stop".into()));
    assert!(accepted(&["closed-form", BEAM]).contains("mean_power_w"));
}

#[test]
fn a_beam_behind_a_bridge_has_a_closed_form_too() {
    let weak = ["--set", "parameters.piezo_d31_m_per_v=-19e-12", "--set", "excitation.amplitude_m_per_s2=2"];
    let behind = |load: &str| {
        let found = of(&[&[BEAM, "--set", load], &weak[..]].concat());
        assert_eq!(found["holds"], true, "{found}");
        found
    };
    // The steady voltage of a store at its load is that of the bus that delivers as much.
    let draw = STORE.replace('}', ",draw={kind='resistor',value=2e5}}");
    let store = number(&behind(&draw), "mean_power_w");
    let voltage = (store * 1e5).sqrt();
    let bus = behind(&format!("load={{kind='dc-bus',voltage_v={voltage},diode_drop_v=0}}"));
    let power = number(&bus, "mean_power_w");
    assert!((store / power - 1.0).abs() < 1e-2, "{store:e} {power:e}");
    assert!((power / number(&bus, "mean_store_current_a") / voltage - 1.0).abs() < 1e-12, "{bus}");
    // The same of a store whose voltage is held.
    let voltage = voltage.to_string();
    let held = of(&[&[BEAM, "--set", STORE, "--storage-voltage", &voltage], &weak[..]].concat());
    assert_eq!(number(&held, "mean_power_w"), power);
}

#[test]
fn what_has_no_closed_form_is_refused() {
    refused(&["closed-form", SHIPPED], &["scene", "\"bump-stop\"", "--steady-state"]);
    refused(&["closed-form", BEAM, "--set", STORE], &["load.draw", "a resistor", "--storage-voltage"]);
    refused(&["closed-form", BEAM, "--storage-voltage", "3"], &["load.kind", "must be a bridge"]);
    let held = ["closed-form", BEAM, "--set", STORE, "--storage-voltage"];
    refused(&[&held[..], &["-1"]].concat(), &["--storage-voltage -1", "from 0"]);
    refused(
        &[&held[..], &["3", "--set", "load.initial_v=1"]].concat(),
        &["load.initial_v", "--storage-voltage holds"],
    );
    let still = "excitation={kind='silence'}";
    refused(&["closed-form", BEAM, "--set", still], &["excitation.kind", "\"sine\""]);
}
