//! The periodic steady state by shooting, against the long transient, closed forms and another program.
//!
//! The other program is not in this repository: TR-BDF2 with fixed steps of T/400 to T/800 and bisected events.
//! SciPy's Radau at a relative tolerance of 10⁻⁹ confirmed the orbit with one impact a period.

use cross_crate_tests::{
    adaptive, assert_close, contact_separation, on_all_cores, periods, resistor, run, sine, value,
};
use host_bench::embedded::resonance_peak;
use host_bench::method::{Method, Options};
use host_bench::outcome::SteadyState;
use host_bench::scene_file::{ForceLaw, Restitution, Scene};

fn scene(density: f64, resistance: f64, gravities: f64, frequency: f64) -> Scene {
    contact_separation(|scene, model| {
        model.parameters.charge_density_c_per_m2 = density;
        scene.load = resistor(resistance);
        scene.excitation = sine(gravities, frequency);
        scene.run = periods(frequency, 300, 100);
    })
}

fn shooting(tolerance: f64) -> Options {
    Options { steady_state: true, ..adaptive(tolerance) }
}

fn verdict(scene: &Scene, options: &Options) -> SteadyState {
    run(scene, options).0.steady_state.expect("it was sought")
}

/// The other program's point with one impact a period, and the long transient of the same core.
#[test]
fn an_impacting_orbit_is_that_of_the_long_transient() {
    let scene = scene(50e-6, 1e8, 0.2, 20.0);
    let (steady, motion) = run(&scene, &shooting(1e-5));
    let found = steady.steady_state.clone().expect("it was sought");
    assert_eq!(found.steady_state, "stable-period-1");
    assert!(found.simulated_periods < 60.0, "{}", found.simulated_periods);
    assert_eq!(motion.impacts, 1);
    assert_close("gap", value(motion.peak_gap_m), 5.51344e-3, 1e-4);
    assert_close("RMS voltage", value(steady.rms_voltage_v), 32.51, 3e-4);
    assert_close("impact speed", value(motion.max_impact_speed_m_per_s), 0.06378, 2e-4);
    assert!(value(steady.mean_voltage_v).abs() < 1e-5 * value(steady.rms_voltage_v));
    assert!(value(steady.energy_residual) < 1e-5, "{:?}", steady.energy_residual);
    let (long, transient) = run(&scene, &adaptive(1e-5));
    for (name, one, other) in [
        ("mean power", steady.mean_power_w, long.mean_power_w),
        ("RMS voltage", steady.rms_voltage_v, long.rms_voltage_v),
        ("gap", motion.peak_gap_m, transient.peak_gap_m),
        ("impact speed", motion.max_impact_speed_m_per_s, transient.max_impact_speed_m_per_s),
    ] {
        // Twice the error that the tolerance leaves in each.
        assert_close(name, value(one), value(other), 2e-6);
    }
    assert!(steady.steps < long.steps / 4, "{} steps against {}", steady.steps, long.steps);
}

/// Without charge the motion is linear: `|x| = A / √((ω0² − Ω²)² + (2 ζ ω0 Ω)²)`, and its multipliers
/// have the magnitude `exp(−ζ ω0 T)`; that of a circuit with a slow load is `exp(−T/τ)`.
#[test]
fn a_linear_motion_has_its_amplitude_and_its_multipliers() {
    let (mass, stiffness, damping) = (5e-3, 80.0, 0.005);
    let natural = f64::sqrt(stiffness / mass);
    for frequency in [15.0, 19.0, 20.3, 25.0] {
        let scene = scene(0.0, 1e8, 0.02, frequency);
        // With the short steps of TR-BDF2 the cubic of the gap has its extremes.
        let (outcome, motion) = run(&scene, &Options { method: Method::TrBdf2, ..shooting(1e-5) });
        let found = outcome.steady_state.expect("it was sought");
        assert_eq!(found.steady_state, "stable-period-1");
        let angular = std::f64::consts::TAU * frequency;
        let bottom = (natural * natural - angular * angular).hypot(2.0 * damping * natural * angular);
        let amplitude = 0.5 * (value(motion.peak_gap_m) - value(motion.min_gap_m));
        // The period error of the steps, 2e-7, is enlarged by ω0² / |ω0² − Ω²| / 2 or so: 60 at 20.3 Hz.
        assert_close("amplitude", amplitude, 0.02 * model_core::part::GRAVITY / bottom, 5e-5);
        let expected = (-damping * natural / frequency).exp();
        assert_close("multiplier", value(found.largest_multiplier), expected, 1e-6);
    }
    // Almost at rest at the initial gap, the charge relaxes through the load with τ = R (C + C_p).
    for resistance in [1e12, 1e13] {
        let scene = scene(1e-6, resistance, 1e-3, 30.0);
        let found = verdict(&scene, &shooting(1e-5));
        let capacitance = model_core::part::VACUUM_PERMITTIVITY * 4e-4 / (3e-3 + 2.5e-5) + 1e-12;
        let expected = (-1.0 / (30.0 * resistance * capacitance)).exp();
        let found = value(found.largest_multiplier);
        assert!(
            ((1.0 - found) / (1.0 - expected) - 1.0).abs() < 1e-3 && expected > 0.98,
            "{found} instead of {expected}"
        );
    }
}

/// The charge of an open circuit is conserved: what is left is found all the same. And a large
/// resistance, a thousand periods of which are a transient, comes at the same price: no current, mean
/// voltage 0.
#[test]
fn open_and_almost_open_circuits_are_found() {
    let open = scene(50e-6, f64::INFINITY, 0.2, 20.0);
    let (_, motion) = run(&open, &shooting(1e-4));
    let (_, transient) = run(&open, &adaptive(1e-4));
    assert_close("gap", value(motion.peak_gap_m), value(transient.peak_gap_m), 1e-5);
    let slow = scene(50e-6, 1e12, 0.2, 20.0);
    let (outcome, motion) = run(&slow, &shooting(1e-4));
    let found = outcome.steady_state.expect("it was sought");
    assert_eq!((found.steady_state, motion.impacts), ("stable-period-1", 1));
    assert!(value(found.largest_multiplier) > 0.95);
    let [mean, rms] = [outcome.mean_voltage_v, outcome.rms_voltage_v].map(value);
    assert!(mean.abs() < 1e-5 * rms, "mean voltage {mean} V of {rms} V");
}

/// From 18.90 to 19.40 Hz the motion of the other program never repeats itself. There the orbit with one impact
/// a period is unstable or none, and the outcome is that of the run.
#[test]
fn there_is_no_stable_orbit_where_the_motion_never_repeats_itself() {
    let frequencies: Vec<f64> = (0..=5).map(|k| 18.9 + 0.1 * f64::from(k)).collect();
    let options = shooting(1e-3);
    let found = on_all_cores(&frequencies, |&frequency| run(&scene(50e-6, 1e8, 0.2, frequency), &options));
    for (frequency, (outcome, motion)) in frequencies.iter().zip(&found) {
        let verdict = outcome.steady_state.as_ref().expect("it was sought");
        println!("{frequency:.2} Hz: {verdict:?}");
        assert!(["unstable-period-1", "none"].contains(&verdict.steady_state), "{frequency} Hz: {verdict:?}");
        assert_eq!(verdict.steady_state == "none", verdict.largest_multiplier.is_none());
        assert!(verdict.largest_multiplier.is_none_or(|value| value > 1.0));
        assert!(motion.impacts > 0);
    }
    let at = 2;
    let (long, _) = run(&scene(50e-6, 1e8, 0.2, frequencies[at]), &adaptive(1e-3));
    assert_eq!(found[at].0.mean_power_w, long.mean_power_w);
}

/// A mass that sticks for a third of each period: the section is laid where it flies.
#[test]
fn a_motion_that_sticks_is_found() {
    let scene = contact_separation(|scene, model| {
        let parameters = &mut model.parameters;
        parameters.initial_gap_m = 0.1e-3;
        parameters.charge_density_c_per_m2 = 20e-6;
        parameters.restitution = Restitution::Constant { coefficient: 0.3 };
        scene.excitation = sine(1.0, 6.0);
        scene.run = periods(6.0, 40, 20);
    });
    let (outcome, motion) = run(&scene, &shooting(1e-5));
    assert_eq!(outcome.steady_state.expect("it was sought").steady_state, "stable-period-1");
    assert_close("gap", value(motion.peak_gap_m), 0.81435e-3, 1e-3);
    assert_close("stuck fraction", value(motion.stuck_fraction), 0.3808, 2e-3);
}

/// The small-signal peaks at 1 MΩ (0.005 g) of the other program, `√((k + dF_e/dg)/m)/2π`: the transferred charge moves
/// them to the left, the field of the gap moves nothing.
#[test]
fn the_small_signal_resonance_is_where_it_should_be() {
    let field = (ForceLaw::GapField, 50e-6, 20.1314);
    let cases = [(5e-6, 20.1248), (20e-6, 20.0317), (35e-6, 19.8159), (50e-6, 19.4477)];
    let cases = cases.map(|(density, expected)| (ForceLaw::TransferredCharge, density, expected));
    let cases = [&cases[..], &[field]].concat();
    let found = on_all_cores(&cases, |&(force_law, density, expected)| {
        let mut scene = scene(density, 1e6, 0.005, expected);
        scene.contact_separation_mut().expect("a contact-separation scene").parameters.force_law = force_law;
        resonance_peak(&scene, [expected - 0.2, expected + 0.2], 9, &adaptive(1e-4))
            .unwrap_or_else(|failure| panic!("{failure}"))
    });
    for ((law, _, expected), (resonance, periods)) in cases.iter().zip(&found) {
        let resonance = resonance.as_ref().expect("a peak");
        let peak = resonance.amplitude;
        println!("{expected} Hz: {peak:?}, {periods:.0} periods");
        let within = if *law == ForceLaw::GapField { 1.5e-3 } else { 5e-4 };
        assert!((peak.frequency_hz - expected).abs() < within, "{peak:?} instead of {expected} Hz");
        assert!(peak.within_hz < 1e-4 && !peak.at_edge, "{peak:?}");
    }
}
