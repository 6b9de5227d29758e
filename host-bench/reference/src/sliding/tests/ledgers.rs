//! Both energy ledgers close whatever the laws are.

use std::sync::Arc;

use super::*;
use harvester_scene::scene_file::Trace;

const LAWS: [ForceLaw; 2] = [ForceLaw::TransferredCharge, ForceLaw::GapField];

#[test]
fn the_ledgers_close_for_every_law_and_load() {
    for force_law in LAWS {
        for lateral_force in [false, true] {
            for stick_charge in [StickCharge::Frozen, StickCharge::Relaxing] {
                for resistance in [0.0, 1e-7, 1e5, 1e8, f64::INFINITY] {
                    let parameters =
                        SlidingParameters { lateral_force, stick_charge, ..table_1(30e-6, force_law) };
                    // With sticks: twice a period at the start.
                    let outcome = run(&shaken(parameters, resistance, 0.4, 12.0, [0.0, 3.0]));
                    let residual = outcome.energy_residual.expect("a number");
                    assert!(
                        residual < 1e-9,
                        "{force_law:?} {lateral_force} {stick_charge:?} {resistance}: {residual:e}"
                    );
                    assert!(particular(&outcome).amplitude_m > Some(1e-4));
                }
            }
        }
    }
}

/// The force along the patches takes from the slider what the load receives: the motion is smaller, by
/// the part of the power that is harvested.
#[test]
fn the_lateral_force_brakes_by_what_the_load_receives() {
    let outcome = |lateral_force| {
        // A single patch without friction, at resonance: the damper and the load share the work.
        let parameters = SlidingParameters {
            lateral_force,
            damping_ratio: 0.05,
            force_law: ForceLaw::GapField,
            ..rubbing(120e-6, 0.0)
        };
        run(&shaken(parameters, 3e7, 0.36, NATURAL, [60.0, 70.0]))
    };
    let (free, braked) = (outcome(false), outcome(true));
    let amplitude = |outcome: &Outcome| particular(outcome).amplitude_m.expect("a number");
    let loss = 1.0 - amplitude(&braked) / amplitude(&free);
    // At resonance the work of the base is proportional to the amplitude, that of the damper to its square:
    // d X / X = −P / P_damper.
    let beam = Cantilever::new(&table_1(0.0, ForceLaw::GapField));
    let speed = beam.angular_frequency * amplitude(&free);
    let damper = 0.05 * beam.angular_frequency * beam.modal_mass * speed * speed;
    let share = braked.mean_power_w.expect("a number") / damper;
    assert!((loss / share - 1.0).abs() < 0.1, "{loss} {share}");
}

/// A trace of a sine, finely sampled, does what the sine does, through a corner at every sample.
#[test]
fn a_sampled_sine_is_nearly_the_sine() {
    let parameters = table_1(80e-6, ForceLaw::TransferredCharge);
    let smooth = shaken(parameters, 1e8, 0.3, 10.0, [1.0, 3.0]);
    let mut sampled = smooth.clone();
    let rate = 1000.0;
    let samples: Arc<[f64]> = (0..100)
        .map(|index| 0.3 * GRAVITY * (std::f64::consts::TAU * 10.0 * f64::from(index) / rate).sin())
        .collect();
    sampled.excitation = Excitation::File(Trace { samples_m_per_s2: samples, rate_hz: rate, repeat: true });
    let (smooth, sampled) = (run(&smooth), run(&sampled));
    // Straight lines between samples take (2π · 10 / 1000)² / 12 = 3e-4 off the amplitude; of it, what
    // exceeds the friction counts six times.
    close(sampled.rms_voltage_v, smooth.rms_voltage_v.expect("a number"), 1e-2);
    let amplitude = particular(&smooth).amplitude_m.expect("a number");
    close(particular(&sampled).amplitude_m, amplitude, 5e-3);
    assert_eq!(particular(&sampled).sticks_per_period, None);
    assert!(sampled.energy_residual.expect("a number") < 1e-9);
}
