//! Against published limits, and against the equations by other means.

use super::*;
use crate::part::GRAVITY;
use crate::part::load::AnyLoad;
use crate::scene::sliding::{
    AnyChoices, AnyForceLaw, AnyLateralForce, Choices, Parameters, PatchFriction, StickCharge,
};

/// Table 1: static friction on the active and the inert patch, kinetic friction on both.
const PUBLISHED: [f64; 4] = [0.35, 0.25, 0.3, 0.2];

/// Table 1 of the paper, with a charge density in µC/m² and a resistance in Ω.
fn scene<S: Scalar>(density: f64, resistance: f64) -> Sliding<S, AnyChoices<S>> {
    parameters(density, resistance, PUBLISHED, 0.0035).build().expect("valid")
}

fn parameters<S: Scalar>(
    density: f64,
    resistance: f64,
    friction: [f64; 4],
    damping_ratio: f64,
) -> Parameters<S, AnyChoices<S>> {
    let number = S::from_f64;
    let [static_active, static_inert, kinetic_active, kinetic_inert] = friction.map(number);
    Parameters {
        beam_length: number(0.1),
        beam_width: number(0.02),
        beam_thickness: number(0.5e-3),
        young_modulus: number(210e9),
        density: number(7800.0),
        damping_ratio: number(damping_ratio),
        slider_mass: number(8e-3),
        patch_radius: number(0.01),
        dielectric_thickness: number(5e-5),
        relative_permittivity: number(2.0),
        charge_density: number(1e-6 * density),
        choices: Choices {
            load: AnyLoad { resistance: number(resistance) },
            friction: PatchFriction { static_active, static_inert, kinetic_active, kinetic_inert },
            force_law: AnyForceLaw::TransferredCharge,
            sticking: StickCharge::Frozen,
            lateral_force: AnyLateralForce::None,
        },
    }
}

fn natural_frequency() -> f64 {
    scene::<f64>(0.0, 0.0).angular_frequency() / core::f64::consts::TAU
}

fn close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() < relative, "{value} is not {expected} within {relative}");
}

#[test]
fn the_amplitude_at_resonance_is_that_of_the_published_energy_balance() {
    // Charge density in µC/m², amplitude in mm at 0.36 g with a short-circuited and a nearly open load.
    for (density, short, open) in [
        (0.0, 14.115, 14.115),
        (10.0, 13.830, 13.746),
        (20.0, 13.148, 12.909),
        (40.0, 11.511, 11.054),
        (80.0, 8.860, 8.302),
        (120.0, 7.113, 6.590),
    ] {
        for (resistance, amplitude) in [(0.0, short), (1e12, open)] {
            let found = scene::<f64>(density, resistance).closed_form(0.36 * GRAVITY, natural_frequency());
            close(1e3 * found.amplitude, amplitude, 3e-4);
            assert!(found.validity.holds(), "{:?}", found.validity);
        }
    }
}

#[test]
fn with_constant_friction_alone_it_is_den_hartogs() {
    let scene = parameters::<f64>(0.0, 1e8, [0.2; 4], 0.0).build().expect("valid");
    for (frequency, amplitude) in [(14.0, 0.637_432), (16.0, 1.071_944), (22.0, 0.564_334), (25.0, 0.282_935)]
    {
        let found = scene.closed_form(0.36 * GRAVITY, frequency);
        close(1e3 * found.amplitude, amplitude, 2.0 * TOLERANCE);
        assert!(found.validity.holds(), "{frequency}: {:?}", found.validity);
    }
}

#[test]
fn without_friction_it_is_the_linear_oscillator() {
    let scene = parameters::<f64>(0.0, 1e8, [0.0; 4], 0.0035).build().expect("valid");
    let natural = scene.angular_frequency();
    for frequency in [10.0, 15.0, 18.0, 25.0] {
        let omega = core::f64::consts::TAU * frequency;
        let drive = scene.base_coupling() * 0.05 * GRAVITY;
        let detuning = natural * natural - omega * omega;
        let expected = drive / detuning.hypot(2.0 * 0.0035 * natural * omega);
        close(scene.closed_form(0.05 * GRAVITY, frequency).amplitude, expected, 2.0 * TOLERANCE);
    }
}

#[test]
fn the_peaks_are_where_the_published_ones_are() {
    // Charge density in µC/m², resistance in Ω; shift of the peak in Hz, amplitude in mm, RMS voltage in V.
    for (density, resistance, shift, amplitude, voltage) in [
        (120.0, 1e6, -0.006_25, 7.1149, 1.360),
        (120.0, 1e7, -0.012_54, 7.1152, 12.537),
        (120.0, 5e7, -0.026_88, 6.9109, 40.709),
        (120.0, 1e8, -0.022_77, 6.7224, 50.056),
        (120.0, 1e10, -0.004_73, 6.5905, 54.911),
        (20.0, 1e8, -0.002_06, 13.0376, 19.179),
    ] {
        let scene = scene::<f64>(density, resistance);
        let at = |frequency: f64| scene.closed_form(0.36 * GRAVITY, frequency);
        let peak = (-60..30)
            .map(|k| natural_frequency() + 5e-4 * f64::from(k))
            .max_by(|one, other| at(*one).amplitude.total_cmp(&at(*other).amplitude))
            .expect("some");
        assert!(
            (peak - natural_frequency() - shift).abs() < 2e-3,
            "{density} {resistance}: {}",
            peak - natural_frequency()
        );
        close(1e3 * at(peak).amplitude, amplitude, 1e-3);
        close(at(peak).rms_voltage, voltage, 8e-3);
    }
}

#[test]
fn the_current_is_that_of_the_circuits_equation_along_the_orbit() {
    let omega = 115.0;
    for resistance in [1e5, 1e7, 1e8, 1e10] {
        let scene = scene::<f64>(80.0, resistance);
        let amplitude = 8e-3;
        // Implicit midpoint rule in fine steps, a hundred turns; q' = rate · V.
        let steps = 4000;
        let step = core::f64::consts::TAU / f64::from(steps);
        let rate = scene.circuit_rate / omega;
        let (mut charge, mut square) = (scene.surface.tribo_charge * 0.5, 0.0);
        for turn in 0..100 {
            for k in 0..steps {
                let displacement = amplitude * (step * (f64::from(k) + 0.5)).cos();
                let overlap = DiscOverlap::exact(displacement.abs() * scene.per_diameter);
                let own = 0.5 * step * rate / overlap.active;
                let middle = (charge + own * scene.surface.tribo_charge * overlap.inert) / (1.0 + own);
                let current = 2.0 * (middle - charge) / step;
                charge = 2.0 * middle - charge;
                if turn == 99 {
                    square += current * current / f64::from(steps);
                }
            }
        }
        let found = scene.half_turn(amplitude, omega);
        close(found.current_square, square, 2e-2);
    }
}

#[test]
fn a_held_slider_delivers_nothing_and_one_that_sticks_is_flagged() {
    let scene = scene::<f64>(80.0, 1e8);
    // The published threshold of motion from rest.
    let below = scene.closed_form(2.508, 18.0);
    assert_eq!((below.mean_power, below.amplitude), (0.0, 0.0));
    assert!(matches!(below.validity, Validity::Holds { margin } if margin > 0.999));
    assert!(scene.closed_form(2.51, natural_frequency()).amplitude > 0.0);
    // Published motions that stick during 54, 25 and 3 % of the time.
    for (gravities, frequency) in [(0.30, 6.0), (0.30, 10.0), (0.28, 14.0)] {
        let found = scene.closed_form(gravities * GRAVITY, frequency);
        assert!(!found.validity.holds(), "{frequency}: {:?}", found.validity);
    }
    // Far from resonance, with kinetic friction of nine tenths of the drive, every motion sticks.
    let stuck = parameters::<f64>(0.0, 1e8, [0.45, 0.45, 0.35, 0.35], 0.0).build().expect("valid");
    let stuck = stuck.closed_form(0.36 * GRAVITY, 30.0).validity;
    assert!(matches!(stuck, Validity::NeedsTrajectory { reason: Reason::Sticks, .. }), "{stuck:?}");
    // Published: at 0.4 g and more, without charge, the slider leaves the patch.
    let charged = self::scene::<f64>(0.0, 1e8).closed_form(0.5 * GRAVITY, natural_frequency());
    let reason = Reason::LeavesOverlap;
    assert!(matches!(charged.validity, Validity::NeedsTrajectory { reason: found, .. } if found == reason));
    let heavy = parameters::<f64>(80.0, 1e8, PUBLISHED, 2.0).build().expect("valid");
    assert!(!heavy.closed_form(GRAVITY, 10.0).validity.holds());
}

#[test]
fn the_load_may_be_anything() {
    let at = |resistance: f64| scene::<f64>(80.0, resistance).closed_form(0.36 * GRAVITY, 18.37);
    let (short, open, large) = (at(0.0), at(f64::INFINITY), at(1e30));
    assert_eq!((short.mean_power, short.rms_voltage, open.mean_power), (0.0, 0.0, 0.0));
    close(at(1.0).amplitude, short.amplitude, 1e-6);
    // V → −R σ S1'(x) x' at small resistances.
    close(at(1e3).rms_voltage / at(1e2).rms_voltage, 10.0, 1e-3);
    assert!(open.rms_voltage > 0.0 && large.rms_voltage > 0.0 && large.mean_power < 1e-20);
    // With an open load the charge is that of the centre, 0; with a nearly open load it has zero mean voltage.
    close(large.rms_voltage, at(1e12).rms_voltage, 1e-4);
}

#[test]
fn single_precision_gives_the_same() {
    for resistance in [1.0, 1e6, 1e8, 1e10, 1e15] {
        for (gravities, frequency) in [(0.36, 18.37), (0.36, 16.0), (0.5, 21.0), (0.6, 18.3)] {
            let fine = scene::<f64>(80.0, resistance).closed_form(gravities * GRAVITY, frequency);
            let coarse =
                scene::<f32>(80.0, resistance).closed_form((gravities * GRAVITY) as f32, frequency as f32);
            close(coarse.mean_power.into(), fine.mean_power, 2e-3);
            assert_eq!(coarse.validity.holds(), fine.validity.holds(), "{resistance} {frequency}");
        }
    }
}
