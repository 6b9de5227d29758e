//! Analytic limits of the contact-separation harvester, which the core and the independent reference must meet alike.

use cross_crate_tests::{
    adaptive, assert_close, contact_separation, fixed, mean_square_current, periods, reference, resistor,
    run, sine, single, value,
};
use host_bench::method::Options;
use host_bench::run::run_scene;
use host_bench::scene_file::{Excitation, ForceLaw, Restitution, RunSpan, Scene};
use model_core::part::VACUUM_PERMITTIVITY;

const MASS: f64 = 5e-3;
const STIFFNESS: f64 = 80.0;
const GAP: f64 = 3e-3;
const AREA: f64 = 4e-4;
/// `d / ε_r`.
const DIELECTRIC: f64 = 25e-6;
const PARASITIC: f64 = 1e-12;

fn omega() -> f64 {
    (STIFFNESS / MASS).sqrt()
}

fn seconds(duration_s: f64, settle_s: f64) -> RunSpan {
    RunSpan { duration_s, settle_s }
}

/// Columns of a trace: time, gap, velocity, transferred charge, voltage.
fn trace(scene: &Scene, options: Options, every: f64) -> Vec<Vec<f64>> {
    let options = Options { trace_every_s: Some(every), ..options };
    run_scene(scene, &options).expect("the scene runs").trace.expect("a trace was asked for").rows
}

/// Without charge the mass is a damped linear oscillator.
#[test]
fn without_charge_the_amplitude_is_the_linear_one() {
    for frequency in [15.0, 19.0, 25.0] {
        let scene = contact_separation(|scene, model| {
            model.parameters.charge_density_c_per_m2 = 0.0;
            scene.excitation = sine(0.005, frequency);
            scene.run = seconds(41.0, 40.0);
        });
        let drive = std::f64::consts::TAU * frequency;
        let expected = 0.005 * 9.81
            / ((omega().powi(2) - drive.powi(2)).powi(2) + (2.0 * 0.005 * omega() * drive).powi(2)).sqrt();
        for (options, tolerance) in
            [(adaptive(1e-5), 2e-5), (single(adaptive(1e-4)), 1e-3), (reference(), 1e-8)]
        {
            let (outcome, found) = run(&scene, &options);
            assert_close("amplitude", value(found.peak_gap_m) - GAP, expected, tolerance);
            assert_close("amplitude towards it", GAP - value(found.min_gap_m), expected, tolerance);
            assert_eq!(
                (found.impacts, found.max_impact_speed_m_per_s, found.first_impact_s),
                (0, None, None)
            );
            assert_eq!(outcome.mean_power_w, Some(0.0));
        }
    }
}

/// Without force the charge does not change the motion, impacts included, and all that the load takes is created.
#[test]
fn without_force_the_motion_is_that_without_charge() {
    let scene = |density: f64, force_law: ForceLaw| {
        contact_separation(|scene, model| {
            model.parameters.charge_density_c_per_m2 = density;
            model.parameters.force_law = force_law;
            scene.run = seconds(0.7, 0.0);
        })
    };
    let charged = scene(50e-6, ForceLaw::None);
    let plain = scene(0.0, ForceLaw::GapField);
    for options in [adaptive(1e-6), single(adaptive(1e-4)), reference()] {
        let (outcome, found) = run(&charged, &options);
        let (_, expected) = run(&plain, &options);
        assert!(found.impacts > 2);
        assert_eq!(found.impacts, expected.impacts);
        let close = if outcome.precision == "f32" { 1e-4 } else { 1e-5 };
        // Exponential Radau reads a peak from a cubic over a long step.
        assert_close("peak gap", value(found.peak_gap_m), value(expected.peak_gap_m), 1e-3);
        assert_close(
            "speed",
            value(found.max_impact_speed_m_per_s),
            value(expected.max_impact_speed_m_per_s),
            close,
        );
        let created = outcome.created.expect("a triboelectric scene").created_energy_j;
        let delivered = value(outcome.delivered_energy_j);
        // The capacitances hold what the load did not take.
        assert!(created > 0.9 * delivered && delivered > 0.0, "{created} {delivered}");
    }
}

/// At a gap that does not move, the capacitances discharge with the time constant R (C + C_p), and
/// the load receives their energy.
#[test]
fn at_a_fixed_gap_the_load_receives_the_energy_of_the_capacitances() {
    let resistance = 1e9;
    let capacitance = VACUUM_PERMITTIVITY * AREA / (GAP + DIELECTRIC) + PARASITIC;
    // So little charge that the force moves nothing.
    let density = 1e-9;
    let open_circuit = density * GAP / VACUUM_PERMITTIVITY;
    let time_constant = resistance * capacitance;
    for elapsed in [0.5, 1.0, 3.0] {
        let scene = contact_separation(|scene, model| {
            model.parameters.charge_density_c_per_m2 = density;
            model.initial.charge_c = Some(0.0);
            scene.load = resistor(resistance);
            scene.excitation = Excitation::Silence;
            scene.run = seconds(elapsed * time_constant, 0.0);
        });
        let expected = 0.5 * capacitance * open_circuit.powi(2) * (1.0 - (-2.0 * elapsed).exp());
        for options in [adaptive(1e-6), reference()] {
            let (outcome, _) = run(&scene, &options);
            assert_close("delivered energy", value(outcome.delivered_energy_j), expected, 1e-6);
            assert_close("peak voltage", value(outcome.peak_voltage_v), open_circuit, 1e-9);
            let mean = open_circuit * (1.0 - (-elapsed).exp()) / elapsed;
            assert_close("mean voltage", value(outcome.mean_voltage_v), mean, 1e-6);
        }
    }
}

/// With the load open all charge goes into the parasitic capacitance, q − C_p V is constant, and the
/// voltage is that of the gap at this charge.
#[test]
fn with_the_load_open_the_charge_behind_the_load_is_constant() {
    let scene = contact_separation(|scene, _| {
        scene.load = resistor(f64::INFINITY);
        scene.run = seconds(2.0, 0.0);
    });
    let rows = trace(&scene, fixed(2e-5), 1e-3);
    let behind = |row: &Vec<f64>| row[3] - PARASITIC * row[4];
    let start = behind(&rows[0]);
    assert!(rows.len() == 2001 && start > 0.0);
    // The trace interpolates gap and voltage each for itself.
    for row in &rows {
        assert_close("charge behind the load", behind(row), start, 1e-8);
        let distance = row[1] + DIELECTRIC;
        let voltage =
            (50e-6 * AREA * row[1] - start * distance) / (VACUUM_PERMITTIVITY * AREA + PARASITIC * distance);
        assert!((row[4] - voltage).abs() < 1e-3, "{} V instead of {voltage} V", row[4]);
    }
    let (outcome, _) = run(&scene, &adaptive(1e-4));
    assert_eq!((outcome.mean_power_w, outcome.delivered_energy_j), (Some(0.0), Some(0.0)));
    assert!(value(outcome.peak_voltage_v) > 10.0);
}

/// Close to a short circuit the charge follows the gap: q = σ S g / (g + d_e).
#[test]
fn a_small_resistance_lets_the_charge_follow_the_gap() {
    for (resistance, options, interpolated) in [
        (0.0, fixed(1e-5), 1e-7),
        (0.0, reference(), 0.0),
        (1.0, fixed(1e-5), 1e-9),
        (1e3, fixed(1e-5), 1e-9),
    ] {
        let scene = contact_separation(|scene, _| {
            scene.load = resistor(resistance);
            scene.run = seconds(1.0, 0.0);
        });
        let rows = trace(&scene, options, 1.3e-3);
        assert_eq!(rows.len(), 770);
        for row in rows {
            let gap = row[1];
            let expected = 50e-6 * AREA * gap / (gap + DIELECTRIC);
            // It lags by C V: at most 142 pF and the voltage of some 1e-4 A, at contact. The core's trace
            // interpolates gap and charge each for itself.
            let lag = resistance * 142e-12 * 1e-4;
            let error = (row[3] - expected).abs();
            assert!(
                error < lag + interpolated * expected + 1e-20,
                "{resistance} Ω: off by {error:e} C at {gap:e} m"
            );
        }
    }
}

/// Without force and impacts the gap is `d0 + X sin θ`, and the circuit is linear with periodic coefficients: its power is a
/// quadrature. Close to a short circuit it is `R` times the mean square of the rate of `σ S g / (g + d_e)`.
#[test]
fn in_a_sinusoidal_gap_the_power_is_a_quadrature() {
    let (drive, permittivity_area) = (std::f64::consts::TAU * 15.0, VACUUM_PERMITTIVITY * AREA);
    let response = (omega().powi(2) - drive.powi(2)).hypot(2.0 * 0.05 * omega() * drive);
    let amplitude = 0.8 * 9.81 / response;
    let gap = |phase: f64| GAP + amplitude * phase.sin();
    let relaxed = |phase: f64| 50e-6 * AREA * gap(phase) / (gap(phase) + DIELECTRIC);
    let per_volt = |phase: f64| permittivity_area / (gap(phase) + DIELECTRIC) + PARASITIC;
    for resistance in [1e-3, 1e3, 1e7, 1e9, 3e9, 1e10, 1e11] {
        let squared = if resistance < 1e6 {
            let current = |part: i32| {
                let phase = std::f64::consts::TAU * (f64::from(part) + 0.5) / 1e4;
                let field = 50e-6 * AREA * DIELECTRIC / (gap(phase) + DIELECTRIC).powi(2);
                field * amplitude * drive * phase.cos()
            };
            (0..10_000).map(|part| current(part).powi(2)).sum::<f64>() / 1e4
        } else {
            mean_square_current(1.0 / 15.0, |phase| 1.0 / (resistance * per_volt(phase)), relaxed)
        };
        let scene = contact_separation(|scene, model| {
            model.parameters.force_law = ForceLaw::None;
            model.parameters.damping_ratio = 0.05;
            scene.load = resistor(resistance);
            scene.excitation = sine(0.8, 15.0);
            scene.run = periods(15.0, 120, 15);
        });
        for (options, tolerance) in [(adaptive(1e-8), 5e-6), (single(adaptive(1e-5)), 1e-3)] {
            let (outcome, found) = run(&scene, &options);
            assert_eq!(found.impacts, 0);
            let power = value(outcome.mean_power_w);
            println!("{resistance:e} Ω: off by {:.1e}", power / (resistance * squared) - 1.0);
            assert_close(&format!("{resistance:e} Ω: power"), power, resistance * squared, tolerance);
        }
    }
}

/// A steady current through a resistor would need a source of charge.
#[test]
fn in_periodic_motion_the_mean_voltage_is_zero() {
    for resistance in [1e6, 1e8] {
        let scene = contact_separation(|scene, _| {
            scene.load = resistor(resistance);
            scene.run = periods(20.0, 300, 100);
        });
        let (outcome, _) = run(&scene, &adaptive(1e-4));
        let mean = value(outcome.mean_voltage_v) / value(outcome.rms_voltage_v);
        assert!(mean.abs() < 1e-7, "{mean}");
    }
}

/// Undamped and unforced, the mass returns after (π + 2 ψ)/ω0 with the speed it left with, and each
/// impact takes off a factor e.
#[test]
fn a_bounce_without_damping_returns_on_time() {
    let restitution: f64 = 0.9;
    let mut speed: f64 = 0.5;
    let mut expected = 0.0;
    let scene_for = |duration: f64| {
        contact_separation(|scene, model| {
            model.parameters.charge_density_c_per_m2 = 0.0;
            model.parameters.damping_ratio = 0.0;
            model.parameters.restitution = Restitution::Constant { coefficient: restitution };
            model.initial.position_m = Some(0.0);
            model.initial.velocity_m_per_s = Some(0.5);
            scene.excitation = Excitation::Silence;
            scene.run = seconds(duration, 0.0);
        })
    };
    for impact in 1..=6_u64 {
        let phase = GAP.atan2(speed / omega());
        expected += (std::f64::consts::PI + 2.0 * phase) / omega();
        // It has happened a microsecond after its time, and not a microsecond before.
        for (offset, count) in [(-1e-6, impact - 1), (1e-6, impact)] {
            for options in [adaptive(1e-5), reference()] {
                let (_, found) = run(&scene_for(expected + offset), &options);
                assert_eq!(found.impacts, count, "impact {impact}");
                assert_eq!(found.impacts_per_period, None);
            }
        }
        speed *= restitution;
    }
    let phase = GAP.atan2(0.5 / omega());
    let return_time = (std::f64::consts::PI + 2.0 * phase) / omega();
    for (options, [of_time, of_speed]) in [(adaptive(1e-6), [1e-7, 1e-7]), (reference(), [2e-10, 2e-8])] {
        let (_, first) = run(&scene_for(0.1), &options);
        assert_close("first return", value(first.first_impact_s), return_time, of_time);
        assert_close("its speed", value(first.max_impact_speed_m_per_s), 0.5, of_speed);
    }
}

/// Static equilibrium under the transferred-charge law, by the closed form `k (d0 − g) = F_e(g)`; its small-signal resonance is in
/// `steady_state`.
#[test]
fn the_transferred_charge_softens_the_spring() {
    for (density, gap) in [
        (5e-6, 2.99798e-3),
        (20e-6, 2.96737e-3),
        (35e-6, 2.89795e-3),
        (50e-6, 2.78438e-3),
        (80e-6, 2.37028e-3),
    ] {
        let scene = contact_separation(|scene, model| {
            model.parameters.charge_density_c_per_m2 = density;
            model.parameters.damping_ratio = 0.1;
            scene.load = resistor(1e6);
            scene.excitation = Excitation::Silence;
            scene.run = seconds(3.0, 2.9);
        });
        for (options, tolerance) in [(adaptive(1e-4), 3e-6), (reference(), 2e-6)] {
            let (_, found) = run(&scene, &options);
            assert_close("equilibrium gap", value(found.peak_gap_m), gap, tolerance);
            assert_close("equilibrium gap", value(found.min_gap_m), gap, tolerance);
        }
    }
}

/// With the field's own law and no charge transferred, the mass stays on the dielectric for ever
/// above σ* = √(2 ε0 k d0 / S) = 103.08 µC/m²; under the other law it always leaves.
#[test]
fn permanent_adhesion_begins_at_the_charge_density_it_should() {
    for (force_law, density, stuck) in [
        (ForceLaw::GapField, 103.07e-6, false),
        (ForceLaw::GapField, 103.09e-6, true),
        (ForceLaw::TransferredCharge, 103.09e-6, false),
    ] {
        let scene = contact_separation(|scene, model| {
            model.parameters.force_law = force_law;
            model.parameters.charge_density_c_per_m2 = density;
            model.initial.position_m = Some(0.0);
            model.initial.charge_c = Some(0.0);
            scene.excitation = Excitation::Silence;
            scene.run = seconds(0.05, 0.0);
        });
        for (options, residual) in [(adaptive(1e-4), 1e-4), (reference(), 1e-9)] {
            let (outcome, found) = run(&scene, &options);
            assert_eq!(found.stuck_fraction, Some(f64::from(u8::from(stuck))), "{force_law:?} {density:e}");
            assert_eq!(found.peak_gap_m > Some(1e-3), !stuck, "{force_law:?} {density:e}");
            // Where nothing moves the field in the dielectric has energy: the ratio exists.
            assert!(value(outcome.energy_residual) < residual, "{:?}", outcome.energy_residual);
        }
    }
}

/// The mass leaves the dielectric when m a + F_e − k d0 falls through zero.
#[test]
fn a_held_mass_leaves_when_the_contact_force_vanishes() {
    // From rest on the dielectric, without charge: a(t) = A sin Ωt starts at 0, so the mass would
    // leave at once; a phase of a quarter turn holds it until A cos Ωt = k d0 / m.
    let (amplitude, frequency) = (60.0, 2.0);
    let scene = contact_separation(|scene, model| {
        model.parameters.charge_density_c_per_m2 = 0.0;
        model.initial.position_m = Some(0.0);
        scene.excitation = Excitation::Sine(host_bench::scene_file::Tone {
            amplitude_m_per_s2: amplitude,
            frequency_hz: frequency,
            phase_rad: std::f64::consts::FRAC_PI_2,
        });
        scene.run = seconds(0.08, 0.0);
    });
    let release = (STIFFNESS * GAP / MASS / amplitude).acos() / (std::f64::consts::TAU * frequency);
    for (options, tolerance) in [(adaptive(1e-4), 1e-9), (single(adaptive(1e-4)), 1e-5), (reference(), 1e-11)]
    {
        let (outcome, found) = run(&scene, &options);
        assert_eq!(outcome.events, 1);
        assert_close("time of release", value(found.stuck_fraction) * 0.08, release, tolerance);
    }
}

/// A held mass does not show its step control what shakes it: a release under an excitation ten times
/// faster than the natural frequency must be found all the same.
#[test]
fn a_fast_excitation_releases_a_held_mass_on_time() {
    let (density, amplitude) = (150e-6_f64, 60.0_f64);
    let attraction = density * density * AREA / (2.0 * VACUUM_PERMITTIVITY);
    let held_by = (attraction - STIFFNESS * GAP) / MASS;
    for frequency in [200.0, 2000.0] {
        let release =
            (std::f64::consts::PI + (held_by / amplitude).asin()) / (std::f64::consts::TAU * frequency);
        let duration = 1.05 * release;
        let scene = contact_separation(|scene, model| {
            model.parameters.force_law = ForceLaw::GapField;
            model.parameters.charge_density_c_per_m2 = density;
            model.initial.position_m = Some(0.0);
            model.initial.charge_c = Some(0.0);
            scene.excitation = sine(amplitude / 9.81, frequency);
            scene.run = seconds(duration, 0.0);
        });
        for options in [adaptive(1e-1), adaptive(1e-4)] {
            let (_, found) = run(&scene, &options);
            assert_close("time of release", value(found.stuck_fraction) * duration, release, 1e-7);
        }
    }
}
