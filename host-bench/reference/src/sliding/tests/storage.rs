//! A full bridge into a bus or a storage: closed forms, limits, and ledgers.

use super::*;
use crate::triboelectric::tests::{draws, ledgers_close_with_storage};
use harvester_scene::scene_file::Lockout;

/// A stroke between the middle and an end that the charge does not slow moves `Q(x, U) − Q(0, −U)` with
/// `Q = σS s2 − c s1 V` and `U = V_bus + 2 V_D`, and there are four in a period.
#[test]
fn a_bus_gets_the_charge_of_each_stroke() {
    let (amplitude, density) = (8e-3, 1e-6);
    let parameters =
        SlidingParameters { damping_ratio: 0.0, charge_density_c_per_m2: density, ..rubbing(density, 0.0) };
    let initial = SlidingStart { displacement_m: Some(amplitude), ..Default::default() };
    let beam = Cantilever::new(&parameters);
    let period = std::f64::consts::TAU / beam.angular_frequency;
    let area = std::f64::consts::PI * 1e-4;
    let capacitance = VACUUM_PERMITTIVITY * 2.0 * area / 0.05e-3;
    let ratio = amplitude / 20e-3;
    let inert = std::f64::consts::FRAC_2_PI * (ratio.asin() + ratio * (1.0 - ratio * ratio).sqrt());
    for (voltage_v, diode_drop_v) in [(0.3, 0.0), (0.2, 0.05), (0.1, 0.1)] {
        let span = [1.3 * period, 4.3 * period];
        let mut scene = scene(parameters, initial, 0.0, Excitation::Silence, span);
        scene.load = Load::DcBus { voltage_v, diode_drop_v };
        let outcome = run(&scene);
        let threshold = voltage_v + 2.0 * diode_drop_v;
        let moved = density * area * inert - capacitance * (2.0 - inert) * threshold;
        assert!(moved > 0.0);
        close(outcome.delivered_energy_j, 3.0 * 4.0 * moved * voltage_v, 1e-8);
        close(outcome.peak_voltage_v, threshold, 1e-9);
    }
}

/// A bus at 0 V behind ideal diodes is a short circuit, one that is never reached an open one.
#[test]
fn a_bus_has_the_limits_of_a_resistor() {
    for (voltage_v, resistance_ohm) in [(0.0, 0.0), (1e6, f64::INFINITY)] {
        let parameters = table_1(30e-6, ForceLaw::TransferredCharge);
        let mut scene = shaken(parameters, resistance_ohm, 0.4, 12.0, [0.0, 4.0]);
        let expected = run(&scene);
        scene.load = Load::DcBus { voltage_v, diode_drop_v: 0.0 };
        let found = run(&scene);
        close(particular(&found).amplitude_m, number(particular(&expected).amplitude_m), 1e-8);
        close(particular(&found).stick_fraction, number(particular(&expected).stick_fraction), 1e-7);
        assert!(particular(&found).stick_fraction > Some(0.0));
        assert_eq!(found.mean_power_w, Some(0.0));
        assert!(number(found.energy_residual) < 1e-9, "{:?}", found.energy_residual);
    }
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
