//! Bump-stop scenes: what is refused, and what a good run prints and writes.

use serde_json::Value;

use super::tool::{
    BEAM, BUMP_STOP, MID_SPAN, TIP, accepted, folder, has_keys, json, number, outcome, place, refused,
    refused_scene, set,
};

/// Six milliseconds with six modes of the beam and two of the rod, with the first contacts in them.
const SHORT: [&str; 4] =
    ["parameters.beam_modes=6", "stop.rod_modes=2", "run.duration_s=6e-3", "run.settle_s=1e-3"];

#[track_caller]
fn refused_with(overrides: &[&str], parts: &[&str]) {
    refused_scene(BUMP_STOP, overrides, parts);
}

#[test]
fn json_has_every_key_of_the_contract() {
    let found = outcome(BUMP_STOP, &SHORT);
    let own = "beam_natural_frequencies_hz rod_natural_frequencies_hz peak_tip_displacement_m \
               peak_stop_point_displacement_m contacts contacts_per_period contact_fraction first_contact_s \
               peak_force_n mean_force_n clamp_curvature_peak_per_m clamp_curvature_rms_per_m clamp_strain_peak \
               clamp_stress_peak_pa clamp_stress_rms_pa clamp_stress_largest_range_pa clamp_stress_cycles \
               clamp_stress_equivalent_range_pa piezo_clamp_strain_peak piezo_clamp_stress_peak_pa \
               piezo_clamp_stress_rms_pa";
    has_keys(&found, false, own);
    assert_eq!(found["scene"], "bump-stop");
    let frequencies = found["beam_natural_frequencies_hz"].as_array().expect("a list");
    let of_rod = found["rod_natural_frequencies_hz"].as_array().expect("a list");
    assert_eq!([frequencies.len(), of_rod.len()], [6, 2]);
    assert!((frequencies[0].as_f64().expect("a number") - 239.705_436).abs() < 1e-6);
    assert!((number(&found, "first_contact_s") - 3.306_469_272e-3).abs() < 1e-12);
    assert_eq!(number(&found, "contacts"), 8.0);
    assert!((number(&found, "contacts_per_period") * 220.0 * 5e-3 - 8.0).abs() < 1e-9);
    let power = number(&found, "mean_power_w");
    assert!((number(&found, "delivered_energy_j") / (power * 5e-3) - 1.0).abs() < 1e-12);
    assert!((number(&found, "rms_voltage_v").powi(2) / 1e6 / power - 1.0).abs() < 1e-12);
    // Mean force times window is less than the peak times the time in contact.
    let most = number(&found, "peak_force_n") * number(&found, "contact_fraction");
    let mean = number(&found, "mean_force_n");
    assert!(mean > 0.3 * most && mean < most);
    assert!(number(&found, "energy_residual") < 1e-12);
}

#[test]
fn the_shipped_cases_rank_as_in_the_paper() {
    let short = ["parameters.beam_modes=4", "run.settle_s=0.1", "run.duration_s=0.2"];
    let with_stop = [&short[..], &["stop.rod_modes=1"]].concat();
    let none = outcome(BEAM, &short);
    let [tip, middle] = [TIP, MID_SPAN].map(|scene| outcome(scene, &with_stop));
    let peak = |found: &Value| number(found, "peak_voltage_v");
    assert!(peak(&none) > peak(&middle) && peak(&middle) > peak(&tip));
    assert_eq!(number(&none, "contacts"), 0.0);
    for absent in ["first_contact_s", "peak_force_n", "mean_force_n", "peak_stop_point_displacement_m"] {
        assert!(none[absent].is_null(), "{absent}");
    }
    assert!(number(&tip, "contacts") > 100.0 && number(&middle, "contacts") > 100.0);
}

#[test]
fn the_start_may_be_chosen() {
    let start = "initial={modal_displacement=[-1e-7,0,0,0,0,0],rod_modal_velocity=[1e-6,0],voltage_v=2.5}";
    let still = "excitation={kind=\"silence\"}";
    let found = outcome(BUMP_STOP, &[&SHORT[..3], &[start, still, "run.settle_s=0"]].concat());
    assert!(number(&found, "peak_voltage_v") >= 2.5);
    assert!((number(&found, "peak_tip_displacement_m") / 31.974_430_7e-7 - 1.0).abs() < 0.5);
    assert!(found["contacts_per_period"].is_null());
    let rest = outcome(BUMP_STOP, &[&SHORT[..], &[still]].concat());
    assert!(rest["energy_residual"].is_null() && rest["first_contact_s"].is_null());
    assert_eq!(number(&rest, "peak_force_n"), 0.0);
    for resistance in ["load.resistance_ohm=0", "load.resistance_ohm=inf"] {
        let found = outcome(BUMP_STOP, &[&SHORT[..], &[resistance]].concat());
        assert_eq!(number(&found, "mean_power_w"), 0.0);
        assert_eq!(number(&found, "peak_voltage_v") == 0.0, resistance.ends_with('0'));
    }
}

#[test]
fn a_trace_of_the_motion_is_written_whole() {
    let folder = folder("bump-stop-motion");
    for (scene, changes, has_stop) in [(BUMP_STOP, &SHORT[..], true), (BEAM, &SHORT[2..], false)] {
        let path = &place(&folder, "motion.csv");
        let run = ["run", scene, "--method", "reference", "--trace", path, "--trace-every", "1e-5"];
        accepted(&[&run[..], &set(changes)].concat());
        let mut reader = csv::Reader::from_path(path).expect("the trace");
        let heading: Vec<String> = reader.headers().expect("a heading").iter().map(str::to_owned).collect();
        assert_eq!(
            heading.join(" "),
            "time_s tip_displacement_m stop_point_displacement_m rod_tip_displacement_m voltage_v \
             contact_force_n base_acceleration_m_per_s2"
        );
        let rows: Vec<csv::StringRecord> = reader.records().map(|record| record.expect("a row")).collect();
        assert_eq!(rows.len(), 601);
        let cell = |row: &csv::StringRecord, column: usize| row[column].parse::<f64>().expect("a number");
        for (index, row) in rows.iter().enumerate() {
            let time = 1e-5 * index as f64;
            assert!((cell(row, 0) - time).abs() < 1e-12);
            let base = 20.0 * (2.0 * std::f64::consts::PI * 220.0 * time).sin();
            assert!((cell(row, 6) - base).abs() < 1e-9);
            if has_stop {
                // A force only where the gap is closed.
                let closed = cell(row, 2) - cell(row, 3) >= 10e-6 * (1.0 - 1e-9);
                assert_eq!(cell(row, 5) > 0.0, closed, "{row:?}");
            } else {
                assert_eq!((&row[2], &row[3], &row[5]), ("", "", ""));
            }
        }
        assert_eq!(has_stop && rows.iter().any(|row| cell(row, 5) > 0.5), has_stop);
    }
}

#[test]
fn numbers_that_do_not_fit_together() {
    refused_with(
        &["stop.position_m=51e-3"],
        &["stop.position_m = 51e-3", "must not be above parameters.beam_length_m = 0.05"],
    );
    refused_with(&["stop.contact=restitution"], &["stop.restitution", "is missing", "from 0 to 1"]);
    refused_with(
        &["stop.restitution=0.5"],
        &["stop.restitution = 0.5", "only with contact = \"restitution\""],
    );
    refused_with(
        &["stop.contact=restitution", "stop.restitution=0.5", "stop.contact_compliance_m_per_n=1e-9"],
        &["stop.contact_compliance_m_per_n = 1e-9", "must be 0 unless"],
    );
    let start = "modal_displacement=[4e-7,0,0,0,0,0,0,0,0,0]";
    refused_with(
        &[&format!("initial={{{start}}}")],
        &["initial.modal_displacement", "starts in penetration"],
    );
    let rod = "initial={rod_modal_displacement=[-2e-7,0,0,0,0,0,0,0,0,0]}";
    refused_with(&[rod], &["initial.rod_modal_displacement", "starts in penetration", "1e-5"]);
    refused_with(
        &["parameters.beam_length_m=1e-4", "stop.position_m=1e-4", "parameters.substrate_thickness_m=1"],
        &["parameters.beam_length_m = 1e-4", "the frequency of bending mode", "from 0.01 to 1e8"],
    );
    refused_with(&["stop.length_m=1e-4", "stop.young_modulus_pa=1e15"], &["stop.length_m", "of rod mode 1"]);
    let count = "initial.modal_displacement=[1e-9,0]";
    refused_with(&[count], &["initial.modal_displacement", "must be 10 numbers", "are 2"]);
    let last = "initial.modal_velocity=[0,0,0,0,0,0,0,0,0,nan]";
    refused_with(&[last], &["initial.modal_velocity", "item 9 is", "from -1e6 to 1e6"]);
    // Without a stop there is no rod.
    let rod = "initial.rod_modal_velocity=[0.0]";
    refused_scene(BEAM, &[rod], &["initial.rod_modal_velocity", "must be 0 numbers", "are 1"]);
}

#[test]
fn the_reference_refuses_what_has_no_limit_and_the_core_what_it_has_not() {
    refused_with(
        &["stop.contact=displacement-constraint"],
        &["stop.contact = \"displacement-constraint\"", "--method reference", "time step"],
    );
    refused(&["run", BUMP_STOP, "--tolerance", "1e-4"], &["--tolerance", "must not be given", "--step"]);
    refused(&["run", BUMP_STOP, "--step", "1e-6", "--long-step", "0.5"], &["--long-step 0.5", "at most"]);
    let steady = ["run", BUMP_STOP, "--steady-state", "--method", "rk4"];
    refused(&steady, &["bump-stop", "--method", "discrete-gradient", "periodic steady state"]);
}

#[test]
fn tip_masses_out_of_bounds_are_refused() {
    for (change, parts) in [
        ("tip_mass.offset_m=0.6", ["tip_mass.offset_m", "10 lengths of the beam"]),
        ("tip_mass.rotary_inertia_kg_m2=100", ["tip_mass.rotary_inertia_kg_m2", "square of its length"]),
    ] {
        refused_with(&["tip_mass.mass_kg=1e-3", change], &parts);
    }
    refused_with(&["tip_mass.offset_m=1e-3"], &["tip_mass.mass_kg", "missing"]);
}

/// Without a stop there is nothing to penetrate, and the beam is linear: a start to the other side gives the same numbers.
#[test]
fn a_beam_without_a_stop_starts_at_both_sides() {
    let power = |sign: &str| {
        let start = format!("initial.modal_displacement=[{sign}1e-6,0,0,0,0,0,0,0,0,0]");
        let still = ["excitation={kind=\"silence\"}", "run={duration_s=0.05,settle_s=0}", &start];
        number(&json(&[&["run", BEAM, "--no-accuracy"], &set(&still)[..]].concat()), "mean_power_w")
    };
    assert!(power("") > 0.0 && power("") == power("-"));
}
