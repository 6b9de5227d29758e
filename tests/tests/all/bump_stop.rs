//! The bump-stop harvester: the core against the independent reference, another program and closed forms.
//!
//! The other program is not in this repository: event-driven, in NumPy, by the eigenvectors of each state of
//! contact. SciPy's DOP853 at a tolerance of 10⁻¹² confirmed its event times. The paper's own numbers are lost.

use cross_crate_tests::{assert_close, fixed, reference, run_beam, shipped, value};
use host_bench::method::Options;
use host_bench::scene_file::{Model, Scene};

/// The shipped scene from `settle` to `end` with these numbers of modes.
fn modes([beam, rod]: [&str; 2], [settle, end]: [&str; 2], changes: &[(&str, &str)]) -> Scene {
    let first = [
        ("parameters.beam_modes", beam),
        ("stop.rod_modes", rod),
        ("run.settle_s", settle),
        ("run.duration_s", end),
    ];
    shipped("bump-stop", &[&first[..], changes].concat())
}

const MID_SPAN: (&str, &str) = ("stop.position_m", "25e-3");

#[test]
fn the_first_contact_is_that_of_another_program() {
    // For (6, 2) modes both ways and one way coupled, for (10, 10), and at mid-span.
    for (count, change, expected) in [
        (["6", "2"], ("parameters.coupling", "two-way"), 3.306_469_272e-3),
        (["6", "2"], ("parameters.coupling", "one-way"), 3.333_173_400e-3),
        (["10", "10"], ("parameters.coupling", "two-way"), 3.306_545_404e-3),
        (["10", "10"], MID_SPAN, 3.722_591_251e-3),
    ] {
        let scene = modes(count, ["0", "4e-3"], &[change]);
        let [exact, found] =
            [reference(), fixed(1e-6)].map(|options| value(run_beam(&scene, &options).1.first_contact_s));
        println!("{count:?} {change:?}: reference {exact:e}, core {found:e}");
        assert!((exact - expected).abs() < 1e-12, "{count:?} {change:?}: {exact:e} instead of {expected:e}");
        assert!((found - exact).abs() < 1e-6, "{count:?} {change:?}: {found:e} instead of {exact:e}");
    }
}

#[test]
fn with_the_stop_at_mid_span_the_statistics_are_those_of_the_reference() {
    let scene = modes(["6", "2"], ["0.3", "0.6"], &[MID_SPAN]);
    let ((exact, exact_contacts), (found, contacts)) =
        (run_beam(&scene, &reference()), run_beam(&scene, &fixed(1e-6)));
    let close = |what: &str, found: Option<f64>, exact: Option<f64>, tolerance: f64| {
        println!("{what}: {} instead of {}", value(found), value(exact));
        assert_close(what, value(found), value(exact), tolerance);
    };
    close("RMS voltage", found.rms_voltage_v, exact.rms_voltage_v, 0.02);
    close("mean power", found.mean_power_w, exact.mean_power_w, 0.04);
    close("mean force", contacts.mean_force_n, exact_contacts.mean_force_n, 0.03);
    close("peak voltage", found.peak_voltage_v, exact.peak_voltage_v, 0.05);
    close("tip", contacts.peak_tip_displacement_m, exact_contacts.peak_tip_displacement_m, 0.03);
    close(
        "stop",
        contacts.peak_stop_point_displacement_m,
        exact_contacts.peak_stop_point_displacement_m,
        0.03,
    );
    // The other program, for the motion that has settled.
    close("RMS voltage, other program", exact.rms_voltage_v, Some(1.883), 0.02);
}

#[test]
fn impacts_with_restitution_are_those_of_the_reference() {
    for rod in ["0", "1"] {
        let changes = [("stop.contact", "restitution"), ("stop.restitution", "0.5"), MID_SPAN];
        let scene = modes(["6", rod], ["0.1", "0.4"], &changes);
        let (exact, found) = (run_beam(&scene, &reference()).0, run_beam(&scene, &fixed(1e-6)).0);
        println!("(6, {rod}): {} {}", value(found.rms_voltage_v), value(exact.rms_voltage_v));
        assert_close("RMS voltage", value(found.rms_voltage_v), value(exact.rms_voltage_v), 0.05);
    }
}

/// The paper's method: the force that makes the gap zero at the end of each step. What it does at touch-down
/// is an impulse spread over one step.
#[test]
fn the_peak_force_of_the_constraint_in_each_step_grows_as_the_step_shrinks() {
    let scene = modes(["10", "3"], ["0", "0.03"], &[("stop.contact", "displacement-constraint")]);
    let runs = [5e-7, 2e-7, 1e-7].map(|step| (step, run_beam(&scene, &fixed(step))));
    let [(_, (coarse, _)), ..] = &runs;
    let impulses = runs.each_ref().map(|(step, (outcome, particular))| {
        let force = value(particular.peak_force_n);
        println!("{step:e}: {force} N, {} V", value(outcome.rms_voltage_v));
        assert_close("RMS voltage", value(outcome.rms_voltage_v), value(coarse.rms_voltage_v), 0.05);
        force * step
    });
    // Five times as high a peak at a fifth of the step, within the factor that the touch-down of the moment
    // makes of it.
    for impulse in impulses {
        assert_close("peak force times step", impulse, impulses[0], 0.5);
    }
}

/// Growth per step of a contact held closed by a force in each step, on modes of a beam that end in the
/// contact: the force is constant over a step, or linear and continuous.
fn growth(angular_frequencies: &[f64], step: f64, is_linear: bool) -> f64 {
    let coefficients: Vec<[f64; 4]> = angular_frequencies
        .iter()
        .map(|omega| {
            let phase = omega * step;
            // The ramp's response cancels where a step is short: four terms of its series there.
            let square = phase * phase;
            let ramp = if phase < 0.1 {
                step * step / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))
            } else {
                (1.0 - phase.sin() / phase) / (omega * omega)
            };
            let half = (0.5 * phase).sin();
            [phase.cos(), phase.sin() / omega, 2.0 * half * half / (omega * omega), ramp]
        })
        .collect();
    // Shapes at the tip: all the same but for their sign, which the sum of squares does not see.
    let mut motion: Vec<[f64; 2]> =
        (0..coefficients.len()).map(|index| [0.0, 1.0 / (index + 1) as f64]).collect();
    let mut force = 0.0;
    let mut logarithms = 0.0;
    const SETTLED: u32 = 2000;
    const STEPS: u32 = 4000;
    for index in 0..STEPS {
        let mut gap = 0.0;
        let mut lever = 0.0;
        for ([at, rate], [cosine, sine, constant, ramp]) in motion.iter().zip(&coefficients) {
            gap += cosine * at + sine * rate;
            if is_linear {
                gap -= (constant - ramp) * force;
                lever += ramp;
            } else {
                lever += constant;
            }
        }
        let next = gap / lever;
        let before = if is_linear { force } else { next };
        let mut energy = 0.0;
        for (([at, rate], [cosine, sine, constant, ramp]), omega) in
            motion.iter_mut().zip(&coefficients).zip(angular_frequencies)
        {
            let (old, rise) = (*at, next - before);
            *at = cosine * old + sine * *rate - constant * before - ramp * rise;
            *rate = cosine * *rate - omega * omega * sine * old - sine * before - constant / step * rise;
            energy += (omega * *at).powi(2) + rate.powi(2);
        }
        let norm = (energy + (next * step).powi(2)).sqrt();
        if index >= SETTLED {
            logarithms += norm.ln();
        }
        motion.iter_mut().flatten().for_each(|entry| *entry /= norm);
        force = next / norm;
    }
    (logarithms / f64::from(STEPS - SETTLED)).exp()
}

/// Why there is no method with a force that is linear over the step and a rigid contact: whatever the step,
/// its error grows, in the limit of short steps by 2 + √3 in each.
#[test]
fn a_linear_force_on_a_rigid_contact_is_not_stable_at_any_step() {
    let Model::BumpStop(model) = modes(["6", "0"], ["0", "1"], &[]).model else { panic!("another scene") };
    let [beam, _] = model.natural_frequencies_hz();
    let omegas: Vec<f64> = beam.iter().map(|frequency| frequency * std::f64::consts::TAU).collect();
    assert_eq!(omegas.len(), 6);
    let limit = 2.0 + 3f64.sqrt();
    for step in [1e-7, 1e-6, 3e-6, 1e-5] {
        let [linear, constant] = [true, false].map(|is_linear| growth(&omegas, step, is_linear));
        println!("{step:e}: linear {linear:.6}, constant {constant:.9}");
        assert!(linear > 1.3, "{step:e}: {linear}");
        assert!(constant < 1.001, "{step:e}: {constant}");
        if step <= 1e-6 {
            assert_close("growth", linear, limit, 0.02);
        }
    }
}

#[test]
fn a_thousand_times_stiffer_rod_leaves_the_voltage() {
    let voltage = |modulus| {
        let scene = modes(["6", "1"], ["0.1", "0.3"], &[("stop.young_modulus_pa", modulus), MID_SPAN]);
        value(run_beam(&scene, &fixed(1e-6)).0.rms_voltage_v)
    };
    let [soft, stiff] = ["70e9", "70e12"].map(voltage);
    println!("{soft} V, {stiff} V");
    assert_close("RMS voltage", stiff, soft, 0.03);
}

/// A beam under uniform load, free and propped: the slope at its tip is q L³ / 6EI free, −1/8 of that with
/// a prop at the tip and 13/64 of it with one at mid-span.
#[test]
fn slow_shaking_gives_the_static_slopes() {
    for (position, factor) in [("50e-3", -1.0 / 8.0), ("25e-3", 13.0 / 64.0)] {
        let changes = [
            ("stop.position_m", position),
            ("stop.gap_m", "0"),
            ("parameters.coupling", "one-way"),
            ("parameters.damping_ratio", "0.5"),
            ("load.resistance_ohm", "inf"),
            ("excitation.frequency_hz", "2"),
        ];
        let scene = modes(["20", "1"], ["0", "0.5"], &changes);
        let options = Options { trace_every_s: Some(0.125), ..fixed(1e-5) };
        let rows = run_beam(&scene, &options).0.trace.expect("recorded").rows;
        // Open circuit: the voltage is the slope. The base pushes away from the stop, then towards it.
        let (free, propped) = (rows[1][4], rows[3][4]);
        println!("{position}: {free} V, {propped} V: {}", -propped / free);
        // ν m' a L³ / (6 E I C), from the closed forms of the section.
        assert_close("free", free, -20.0 * 8.564_079e-10 / 15.93e-9, 2e-3);
        assert_close("propped", -propped / free, factor, 2e-2);
    }
}
