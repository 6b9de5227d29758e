//! Both energy ledgers close whatever the laws are.

use super::*;
use crate::triboelectric::tests::{draws, ledgers_close_with_storage};
use harvester_scene::scene_file::Lockout;

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

/// Every law and every draw, with sticks.
#[test]
fn the_ledgers_close_with_a_storage() {
    for force_law in [ForceLaw::TransferredCharge, ForceLaw::GapField] {
        for lateral_force in [false, true] {
            let draws = draws(Lockout { turn_on_v: 0.28, turn_off_v: 0.25 });
            for (index, draw) in draws.into_iter().enumerate() {
                let stick_charge = if index % 2 == 0 { StickCharge::Frozen } else { StickCharge::Relaxing };
                let parameters =
                    SlidingParameters { lateral_force, stick_charge, ..table_1(30e-6, force_law) };
                let scene = shaken(parameters, 0.0, 0.4, 12.0, [1.0, 5.0]);
                ledgers_close_with_storage(scene, [0.3, 0.05], draw);
            }
        }
    }
}
