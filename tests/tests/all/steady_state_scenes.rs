//! The periodic steady state by shooting of bump-stop, and behind a bridge into a constant voltage: against closed forms,
//! and against long transients of the same core.

use cross_crate_tests::{adaptive, assert_close, on_all_cores, outcome, relative_difference, shipped, value};
use host_bench::closed_form::estimate;
use host_bench::embedded::{Search, best_resistance, search};
use host_bench::method::{Failure, Options, Precision};
use host_bench::outcome::Outcome;
use host_bench::scene_file::{Excitation, Scene};
use host_bench::steady_state::{Response, resonance};

/// The outcome of shooting, which must find the orbit to which the transient goes.
fn shot(scene: &Scene, options: &Options) -> Outcome {
    let outcome = outcome(scene, &Options { steady_state: true, ..*options });
    let found = outcome.steady_state.as_ref().expect("it was sought");
    assert_eq!(found.steady_state, "stable-period-1", "{:?}: {:?}", scene.load, outcome.warnings);
    assert_eq!(found.steady_state_residual, None);
    // The paper's force law creates energy, and the plates are small for a uniform field: no errors of the orbit.
    let is_known = |warning: &String| warning.contains("creates energy") || warning.starts_with("model:");
    let others = outcome.warnings.iter().find(|warning| !is_known(warning));
    assert_eq!(others, None);
    outcome
}

/// Largest relative difference of two outcomes in power, voltage and motion.
fn apart(one: &Outcome, two: &Outcome) -> f64 {
    let pairs = [
        (one.mean_power_w, two.mean_power_w),
        (one.rms_voltage_v, two.rms_voltage_v),
        (one.largest_motion_m(), two.largest_motion_m()),
    ];
    pairs.into_iter().map(|(one, two)| relative_difference(one, two)).fold(0.0, f64::max)
}

/// Difference of a beam behind a bridge from period to period: its steps do not end where the bridge switches.
const OF_STEPS: f64 = 5e-5;

/// Without a stop the steady state is the linear response, at any load and frequency.
#[test]
fn a_free_beam_has_the_linear_response() {
    let mut cases = Vec::new();
    for ohms in ["0", "1e3", "4e4", "1e6", "inf"] {
        for hertz in ["100", "220", "239.7", "245.2", "1500"] {
            cases.push((ohms, hertz));
        }
    }
    let found = on_all_cores(&cases, |&(ohms, hertz)| {
        let changes = [("load.resistance_ohm", ohms), ("excitation.frequency_hz", hertz)];
        let scene = shipped("bump-stop-none", &changes);
        (shot(&scene, &Options::default()), estimate(&scene, Precision::F64).expect("one sine"))
    });
    for ((ohms, hertz), (outcome, expected)) in cases.iter().zip(&found) {
        let motion = outcome.bump_stop().expect("a beam");
        let differences = [
            relative_difference(outcome.mean_power_w, Some(expected.mean_power_w)),
            relative_difference(outcome.rms_voltage_v, Some(expected.rms_voltage_v)),
            relative_difference(motion.peak_tip_displacement_m, Some(expected.amplitude_m)),
        ];
        println!("{ohms} Ω, {hertz} Hz: {differences:?}");
        // Steps of 20 µs: 0.2 rad at 1500 Hz. The peak is that of a cubic between their ends.
        let allowed = if *hertz == "1500" { 2e-4 } else { 2e-6 };
        assert!(differences.into_iter().all(|off| off < allowed), "{ohms} Ω, {hertz} Hz: {differences:?}");
        assert!(value(outcome.energy_residual) < 1e-12);
    }
}

/// The linear steady state is that of a long transient too, and the multiplier is the decay of the slowest motion.
#[test]
fn a_free_beam_shoots_to_where_its_transient_ends() {
    let changes = [("run.duration_periods", "600"), ("run.settle_periods", "599")];
    let scene = shipped("bump-stop-none", &changes);
    let found = shot(&scene, &Options::default());
    let long = outcome(&scene, &Options::default());
    // The peak is that of a cubic between the ends of steps of 20 µs, at another phase in each.
    assert!(apart(&found, &long) < 5e-8, "{}", apart(&found, &long));
    assert!(found.steps < long.steps / 2);
    // Short-circuited, a mode decays by exp(−ζ ω_1 T).
    let scene = shipped("bump-stop-none", &[("load.resistance_ohm", "0")]);
    let first = shot(&scene, &Options::default()).steady_state.expect("it was sought");
    let expected = (-0.01 * 239.705_436 / 220.0 * std::f64::consts::TAU).exp();
    assert_close("multiplier", value(first.largest_multiplier), expected, 1e-7);
}

/// Through a soft contact the motion is periodic, with one contact a period: of one mode against a spring, and of the
/// shipped beam and rod.
#[test]
fn a_soft_contact_has_an_orbit() {
    let cases = [["1", "0", "1e-4"], ["4", "1", "1e-3"], ["10", "10", "1e-4"]];
    on_all_cores(&cases, |[beam, rod, compliance]| {
        let scene = shipped(
            "bump-stop",
            &[
                ("parameters.beam_modes", beam),
                ("stop.rod_modes", rod),
                ("stop.contact_compliance_m_per_n", compliance),
                ("run.duration_periods", "600"),
                ("run.settle_periods", "590"),
            ],
        );
        let found = shot(&scene, &Options::default());
        let long = outcome(&scene, &Options::default());
        let motion = found.bump_stop().expect("a beam");
        println!("{beam}, {rod}, {compliance}: {:.1e} apart, {motion:?}", apart(&found, &long));
        assert!((value(motion.contacts_per_period) - 1.0).abs() < 1e-9);
        assert!(value(motion.contact_fraction) > 0.05 && value(motion.peak_force_n) > 0.0);
        assert_eq!(motion.first_contact_s, None);
        assert!(apart(&found, &long) < 1e-7, "{beam}, {rod}: {:e}", apart(&found, &long));
        let force = long.bump_stop().expect("a beam").peak_force_n;
        assert!(relative_difference(motion.peak_force_n, force) < 1e-5);
    });
}

/// The shipped beam chatters and never repeats itself: shooting says what it leaves, and gives the numbers of the run.
#[test]
fn a_chattering_beam_has_none_and_says_so() {
    let scene = shipped("bump-stop", &[("run.duration_s", "0.6"), ("run.settle_s", "0.3")]);
    let found = outcome(&scene, &Options { steady_state: true, ..Options::default() });
    let verdict = found.steady_state.clone().expect("it was sought");
    assert_eq!((verdict.steady_state, verdict.largest_multiplier), ("none", None));
    let left = value(verdict.steady_state_residual);
    assert!(left > 1e-4 && left.is_finite(), "{left}");
    assert!(
        matches!(&found.warnings[..], [text] if text.contains("no orbit of one period")),
        "{:?}",
        found.warnings
    );
    assert_eq!(found.mean_power_w, outcome(&scene, &Options::default()).mean_power_w);
}

/// Behind a bridge into a bus: with impacts, with friction, and of the beam; the long transient ends there.
#[test]
fn behind_a_bridge_the_orbit_is_that_of_the_transient() {
    let long = [("run.duration_periods", "600"), ("run.settle_periods", "500")];
    let bus = |volts: &'static str| ("load", volts);
    let cases = [
        (
            "contact-separation",
            vec![bus("{kind='dc-bus',voltage_v=20,diode_drop_v=0.3}")],
            adaptive(1e-5),
            1e-5,
        ),
        (
            "contact-separation",
            vec![bus("{kind='dc-bus',voltage_v=3,diode_drop_v=0.0}"), ("excitation.amplitude_g", "0.05")],
            adaptive(1e-5),
            1e-5,
        ),
        ("sliding", vec![bus("{kind='dc-bus',voltage_v=20,diode_drop_v=0.3}")], adaptive(1e-5), 1e-5),
        (
            "bump-stop-none",
            vec![bus("{kind='dc-bus',voltage_v=1,diode_drop_v=0.3}"), ("parameters.beam_modes", "3")],
            Options::default(),
            OF_STEPS,
        ),
        (
            "bump-stop",
            vec![
                bus("{kind='dc-bus',voltage_v=1,diode_drop_v=0.3}"),
                ("parameters.beam_modes", "3"),
                ("stop.rod_modes", "0"),
                ("stop.contact_compliance_m_per_n", "1e-3"),
            ],
            Options::default(),
            OF_STEPS,
        ),
    ];
    on_all_cores(&cases, |(name, changes, options, allowed)| {
        let scene = shipped(name, &[&long[..], changes].concat());
        let found = shot(&scene, options);
        let transient = outcome(&scene, options);
        println!("{name}: {:.1e} apart, {:?} W", apart(&found, &transient), found.mean_power_w);
        assert!(apart(&found, &transient) < *allowed, "{name}: {:e}", apart(&found, &transient));
        // Power and charge per second.
        let store = found.store.expect("a bus");
        let volts = value(store.store_voltage_v);
        let current = value(store.mean_store_current_a);
        assert!(current > 0.0);
        assert_close("power", value(found.mean_power_w), volts * current, 1e-9);
    });
}

/// The closed form of the beam behind a bridge against shooting, where it is claimed to hold.
#[test]
fn the_closed_form_behind_a_bridge_is_that_of_the_orbits() {
    let cases = [("200", 0.1), ("200", 0.3), ("230", 1.0), ("260", 0.5)];
    on_all_cores(&cases, |(hertz, volts)| {
        let bus = format!("{{kind='dc-bus',voltage_v={volts},diode_drop_v=0.02}}");
        let changes = [
            ("load", &bus[..]),
            ("excitation.frequency_hz", hertz),
            ("parameters.beam_modes", "3"),
            ("parameters.piezo_d31_m_per_v", "-40e-12"),
        ];
        let scene = shipped("bump-stop-none", &changes);
        let expected = estimate(&scene, Precision::F64).expect("one sine");
        let outcome = shot(&scene, &Options::default());
        let off = relative_difference(outcome.mean_power_w, Some(expected.mean_power_w));
        let voltage = relative_difference(outcome.rms_voltage_v, Some(expected.rms_voltage_v));
        println!("{changes:?}: {off:.1e}, {voltage:.1e}, margin {}", expected.margin);
        assert!(expected.holds && expected.mean_power_w > 0.0, "{changes:?}: {expected:?}");
        assert!(off < 2e-2 && voltage < 2e-2, "{changes:?}: {off:e}, {voltage:e}");
    });
}

/// The resonances of the beam with short-circuited and open terminals are those of the closed form, and the peak powers at
/// both are alike, as at strong coupling.
#[test]
fn the_beam_resonates_higher_with_open_terminals() {
    let range_hz = [236.0, 248.0];
    let mut frequencies = Vec::new();
    for ohms in ["0", "inf"] {
        let changes = [("load.resistance_ohm", ohms), ("parameters.beam_modes", "3")];
        let mut scene = shipped("bump-stop-none", &changes);
        let by_shooting = Search { range_hz, points: 13, with_power: false };
        let (found, _) = search(&scene, &by_shooting, &Options::default(), &mut || {}).expect("one sine");
        let found = found.expect("orbits").amplitude;
        let by_formula = resonance(range_hz, 13, false, |hertz| {
            set_frequency(&mut scene, hertz);
            let found = estimate(&scene, Precision::F64)?;
            let (amplitude_m, rms_voltage_v) = (found.amplitude_m, found.rms_voltage_v);
            Ok::<_, Failure>(Some(Response {
                amplitude_m,
                rms_voltage_v,
                mean_power_w: 0.0,
                mean_current_a: 0.0,
            }))
        });
        let expected = by_formula.expect("one sine").expect("a peak").amplitude;
        println!("{ohms} Ω: {found:?}, expected {expected:?}");
        assert!((found.frequency_hz - expected.frequency_hz).abs() < 2e-3);
        assert_close("amplitude", found.value, expected.value, 1e-6);
        frequencies.push(found.frequency_hz);
    }
    // 1 Ω and 1 GΩ of ten modes: 239.68 and 245.18 Hz.
    assert!(
        (frequencies[0] - 239.68).abs() < 0.01 && (frequencies[1] - 245.2).abs() < 0.1,
        "{frequencies:?}"
    );
    let mut powers = Vec::new();
    for hertz in frequencies {
        let mut scene = shipped("bump-stop-none", &[("parameters.beam_modes", "3")]);
        set_frequency(&mut scene, hertz);
        let (found, _) = best_resistance(&scene, &Options::default(), &mut || {}).expect("one sine");
        powers.push(found.expect("a largest power"));
    }
    println!("{powers:?}");
    assert!((powers[0].mean_power_w / powers[1].mean_power_w - 1.0).abs() < 0.02);
    assert!(powers[0].resistance_ohm < 0.3 * powers[1].resistance_ohm);
}

fn set_frequency(scene: &mut Scene, hertz: f64) {
    if let Excitation::Sine(tone) = &mut scene.excitation {
        tone.frequency_hz = hertz;
    }
}
