//! Against published limits, and against the equations by other means.

use super::*;
use crate::part::GRAVITY;
use crate::part::force_law::AnyForceLaw;
use crate::part::load::AnyLoad;
use crate::part::parasitic::ParasiticCapacitance;
use crate::part::restitution::{AnyRestitution, ConstantRestitution};
use crate::scene::contact_separation::{AnyChoices, Choices, Parameters, StickCharge};

/// Table 2 of the paper, with a charge density in µC/m² and a resistance in Ω.
fn scene<S: Scalar>(density: f64, resistance: f64) -> ContactSeparation<S, AnyChoices<S, S::Build>> {
    scene_with(density, resistance, AnyForceLaw::TransferredCharge)
}

fn scene_with<S: Scalar>(
    density: f64,
    resistance: f64,
    force_law: AnyForceLaw,
) -> ContactSeparation<S, AnyChoices<S, S::Build>> {
    Parameters {
        mass: S::from_f64(5e-3),
        stiffness: S::from_f64(80.0),
        damping_ratio: S::from_f64(0.005),
        initial_gap: S::from_f64(3e-3),
        electrode_area: S::from_f64(4e-4),
        dielectric_thickness: S::from_f64(5e-5),
        relative_permittivity: S::from_f64(2.0),
        charge_density: S::from_f64(1e-6 * density),
        choices: Choices {
            load: AnyLoad { resistance: S::from_f64(resistance) },
            restitution: AnyRestitution::Constant(ConstantRestitution { coefficient: S::from_f64(0.7) }),
            force_law,
            parasitic: ParasiticCapacitance { capacitance: S::from_f64(1e-12) },
            sticking: StickCharge::Frozen,
        },
    }
    .build()
    .expect("valid")
}

fn close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() < relative, "{value} is not {expected} within {relative}");
}

#[test]
fn the_gap_at_rest_and_the_small_signal_peak_are_the_published_ones() {
    // Charge density in µC/m², gap in mm, frequency of the peak in Hz at 0.005 g and 1 MΩ.
    for (density, gap, peak) in [
        (5.0, 2.997_98, Some(20.1248)),
        (20.0, 2.967_37, Some(20.0317)),
        (35.0, 2.897_95, Some(19.8159)),
        (50.0, 2.784_38, Some(19.4477)),
        (70.0, 2.544_29, None),
        (80.0, 2.370_28, None),
    ] {
        let scene = scene::<f64>(density, 1e6);
        close(1e3 * scene.equilibrium().gap, gap, 3e-6);
        let Some(peak) = peak else { continue };
        let amplitude = |frequency: f64| scene.closed_form(0.005 * GRAVITY, frequency).amplitude;
        let step = 5e-4;
        let highest = (-40..40)
            .map(|k| peak + step * f64::from(k))
            .max_by(|one, other| amplitude(*one).total_cmp(&amplitude(*other)))
            .expect("some");
        assert!((highest - peak).abs() < 1e-3, "{density}: {highest} instead of {peak}");
    }
}

#[test]
fn without_charge_the_motion_is_that_of_the_linear_oscillator() {
    let scene = scene::<f64>(0.0, 1e8);
    let natural = scene.angular_frequency();
    for frequency in [5.0, 18.0, 22.0, 40.0] {
        let omega = core::f64::consts::TAU * frequency;
        let found = scene.closed_form(1.0, frequency);
        let detuning = natural * natural - omega * omega;
        let expected = 1.0 / detuning.hypot(2.0 * 0.005 * natural * omega);
        close(found.amplitude, expected, 2.0 * TOLERANCE);
        assert_eq!((found.mean_power, found.rms_voltage), (0.0, 0.0));
        assert!(found.validity.holds(), "{:?}", found.validity);
    }
}

/// The mean power along `g(θ)` by integrating the circuit's equation in the form of the paper,
/// `Q' = V/R`, over many periods with small implicit steps.
fn integrated(
    scene: &ContactSeparation<f64, AnyChoices<f64>>,
    gap: impl Fn(f64) -> f64,
    omega: f64,
    resistance: f64,
) -> f64 {
    let steps = 8_000;
    let step = core::f64::consts::TAU / f64::from(steps);
    let rate = scene.circuit_rate / omega;
    let mut charge = scene.relaxed_charge(gap(0.0));
    let mut sum = 0.0;
    for _ in 0..15 {
        sum = 0.0;
        for k in 0..steps {
            // The midpoint rule; the charge at the middle follows from a linear equation.
            let gap = gap(step * (f64::from(k) + 0.5));
            let at = |charge: f64| scene.circuit(gap, charge).voltage;
            let slope = at(1.0) - at(0.0);
            let middle = (charge + 0.5 * step * rate * at(0.0)) / (1.0 - 0.5 * step * rate * slope);
            charge = 2.0 * middle - charge;
            let voltage = scene.field * at(middle);
            sum += voltage * voltage / (resistance * f64::from(steps));
        }
    }
    sum
}

#[test]
fn the_power_is_that_of_the_circuits_equation_along_the_orbit() {
    let omega = core::f64::consts::TAU * 18.0;
    for resistance in [1e7, 1e9, 1e10] {
        let scene = scene::<f64>(50.0, resistance);
        for (amplitude, second) in
            [(0.5e-3, Complex::ZERO), (2.0e-3, Complex::ZERO), (1.8e-3, Complex::new(1e-5, -0.5e-5))]
        {
            let motion = Motion { mean: 2.78e-3, amplitude, second };
            let (power, rms) = scene.electrical(&motion, omega);
            let gap = |theta: f64| {
                let (sine, cosine) = (2.0 * theta).sin_cos();
                motion.mean + amplitude * theta.cos() + second.re * cosine - second.im * sine
            };
            // The second harmonic is included to first order.
            close(
                power,
                integrated(&scene, gap, omega, resistance),
                if second == Complex::ZERO { 1e-4 } else { 2e-3 },
            );
            close(rms * rms / resistance, power, 1e-12);
        }
    }
}

#[test]
fn the_ends_of_the_load_are_limits() {
    let at = |resistance: f64| scene::<f64>(50.0, resistance).closed_form(0.1 * GRAVITY, 18.0);
    let (short, small, open, large) = (at(0.0), at(1.0), at(f64::INFINITY), at(1e15));
    assert_eq!((short.mean_power, short.rms_voltage, open.mean_power), (0.0, 0.0, 0.0));
    close(small.amplitude, short.amplitude, 1e-6);
    // P = R I²: a millionth of that at 1 MΩ.
    close(1e6 * small.mean_power, at(1e6).mean_power, 1e-2);
    // With an open load the charge is that at rest, and the mean voltage is not quite zero.
    assert!(open.rms_voltage > large.rms_voltage && open.rms_voltage < 1.3 * large.rms_voltage);
    assert!(large.mean_power > 0.0 && large.mean_power < 1e-3 * at(1e9).mean_power);
}

#[test]
fn what_touches_or_may_come_to_touch_is_flagged() {
    let scene = scene::<f64>(50.0, 1e8);
    let verdict = |gravities: f64, frequency: f64| scene.closed_form(gravities * GRAVITY, frequency).validity;
    // In the published band of impacts, 18.85 to 20.15 Hz at 0.2 g.
    for frequency in [18.9, 19.0, 19.5, 20.0, 20.1] {
        assert!(!verdict(0.2, frequency).holds(), "{frequency}");
    }
    for frequency in [10.0, 18.0, 22.0, 30.0] {
        assert!(verdict(0.2, frequency).holds(), "{frequency}: {:?}", verdict(0.2, frequency));
    }
    assert!(matches!(verdict(0.2, 19.2), Validity::NeedsTrajectory { .. }));
    assert!(matches!(
        verdict(0.25, 20.4),
        Validity::NeedsTrajectory { reason: Reason::ImpactsInTransient, .. }
    ));
    assert!(verdict(f64::NAN, 19.0) != Validity::Holds { margin: 0.0 } && !verdict(f64::NAN, 19.0).holds());
}

#[test]
fn single_precision_gives_the_same() {
    for law in [AnyForceLaw::TransferredCharge, AnyForceLaw::GapField] {
        for resistance in [1.0, 1e6, 1e8, 1e10] {
            for (gravities, frequency) in [(0.005, 19.0), (0.1, 18.0), (0.2, 22.0), (0.2, 5.0)] {
                let fine =
                    scene_with::<f64>(50.0, resistance, law).closed_form(gravities * GRAVITY, frequency);
                let coarse = scene_with::<f32>(50.0, resistance, law)
                    .closed_form((gravities * GRAVITY) as f32, frequency as f32);
                close(coarse.mean_power.into(), fine.mean_power, 2e-3);
                assert_eq!(
                    coarse.validity.holds(),
                    fine.validity.holds(),
                    "{law:?} {resistance} {frequency}"
                );
            }
        }
    }
}
