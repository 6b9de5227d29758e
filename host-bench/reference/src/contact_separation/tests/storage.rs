//! A full bridge into a bus or a storage: closed forms, limits, and ledgers.

use super::*;
use crate::triboelectric::tests::{draws, ledgers_close_with_storage};
use harvester_scene::scene_file::{Draw, Lockout, RectifiedStore};

/// A stroke between two gaps that the charge does not slow moves `Q(g_max, U) − Q(g_min, −U)` with
/// `Q = (σS g − c V)/(g + d_e) − C_p V` and `U = V_bus + 2 V_D`, and there are two in a period.
#[test]
fn a_bus_gets_the_charge_of_each_stroke() {
    let (stroke, density) = (1e-3, 1e-9);
    let parameters = ContactSeparationParameters {
        damping_ratio: 0.0,
        parasitic_capacitance_f: 3e-12,
        ..table_2(density, ForceLaw::GapField)
    };
    let initial = ContactSeparationStart { gap_m: Some(3e-3 + stroke), ..Default::default() };
    let period = std::f64::consts::TAU * (5e-3f64 / 80.0).sqrt();
    let (permittivity, dielectric, area) = (VACUUM_PERMITTIVITY, 25e-6, 4e-4);
    let charge = |gap: f64, voltage: f64| {
        (density * area * gap - permittivity * area * voltage) / (gap + dielectric) - 3e-12 * voltage
    };
    // Charge over capacitance: volts.
    for (voltage_v, diode_drop_v) in [(1e-4, 0.0), (5e-5, 2e-5), (1e-4, 5e-5)] {
        let span = [1.3 * period, 4.3 * period];
        let mut scene = scene(parameters, initial, 0.0, Excitation::Silence, span);
        scene.load = Load::DcBus { voltage_v, diode_drop_v };
        let outcome = run(&scene);
        let threshold = voltage_v + 2.0 * diode_drop_v;
        let moved = charge(3e-3 + stroke, threshold) - charge(3e-3 - stroke, -threshold);
        assert!(moved > 0.0);
        close(outcome.delivered_energy_j, 3.0 * 2.0 * moved * voltage_v, 1e-8);
        close(outcome.peak_voltage_v, threshold, 1e-9);
        let bus = outcome.store.expect("there is a bus");
        assert_eq!((bus.store_voltage_v, bus.stored_energy_j), (Some(voltage_v), None));
    }
}

/// A bus at 0 V behind ideal diodes is a short circuit, one that is never reached an open one.
#[test]
fn a_bus_has_the_limits_of_a_resistor() {
    for (voltage_v, resistance_ohm) in [(0.0, 0.0), (1e6, f64::INFINITY)] {
        let parameters = table_2(50e-6, ForceLaw::TransferredCharge);
        let start = ContactSeparationStart { gap_m: Some(6.5e-3), ..Default::default() };
        let mut scene = scene(parameters, start, resistance_ohm, sine(0.2 * GRAVITY, 20.0), [0.0, 0.2]);
        let expected = run(&scene);
        scene.load = Load::DcBus { voltage_v, diode_drop_v: 0.0 };
        let found = run(&scene);
        let (one, other) = (particular(&found), particular(&expected));
        assert_eq!(one.impacts, other.impacts);
        assert!(one.impacts > 0);
        close(one.first_impact_s, number(other.first_impact_s), 1e-10);
        close(one.peak_gap_m, number(other.peak_gap_m), 1e-8);
        assert_eq!(found.mean_power_w, Some(0.0));
        assert!(number(found.energy_residual) < 1e-9, "{:?}", found.energy_residual);
    }
}

/// A start charge above the threshold is shared with the storage at once. Its energy is delivered, and lost in the
/// diodes: `V_s + r/2` and `2 V_D + e/2` of a charge with an excess `e` of voltage and a rise `r` of the storage.
#[test]
fn a_start_charge_is_shared_with_the_storage() {
    let (capacitance_f, diode_drop_v, initial_v) = (1e-8, 0.3, 0.5);
    let storage = RectifiedStore {
        capacitance_f,
        diode_drop_v,
        leakage_ohm: f64::INFINITY,
        initial_v,
        draw: Draw::None,
    };
    let parameters = table_2(50e-6, ForceLaw::GapField);
    let short = 1e-4;
    for charge_c in [1e-8, -3e-8] {
        let initial = ContactSeparationStart { charge_c: Some(charge_c), ..Default::default() };
        let mut scene = scene(parameters, initial, 0.0, Excitation::Silence, [0.0, short]);
        scene.load = Load::RectifiedStore(storage);
        let outcome = run(&scene);
        let (gap, dielectric, permittivity_area) = (3e-3, 50e-6 / 2.0, VACUUM_PERMITTIVITY * 4e-4);
        let voltage = ((50e-6 * 4e-4 - charge_c) * gap - charge_c * dielectric) / permittivity_area;
        let own = permittivity_area / (gap + dielectric) + parameters.parasitic_capacitance_f;
        let excess = voltage.abs() - initial_v - 2.0 * diode_drop_v;
        let shared = excess * own * capacitance_f / (own + capacitance_f);
        let delivered = shared * (initial_v + 0.5 * shared / capacitance_f);
        // The gap hardly moves within a tenth of a millisecond.
        close(outcome.delivered_energy_j, delivered, 1e-3);
        let found = outcome.store.expect("there is a storage");
        let gained = number(found.stored_energy_j) - 0.5 * capacitance_f * initial_v * initial_v;
        close(outcome.delivered_energy_j, gained, 1e-9);
        close(found.diode_loss_j, shared * (2.0 * diode_drop_v + 0.5 * excess), 1e-3);
        assert!(number(outcome.energy_residual) < 1e-9, "{:?}", outcome.energy_residual);
    }
}

/// Every law and every draw, with impacts and sticks.
#[test]
fn the_ledgers_close_with_a_storage() {
    for force_law in [ForceLaw::TransferredCharge, ForceLaw::GapField] {
        let draws = draws(Lockout { turn_on_v: 1.0, turn_off_v: 0.9 });
        for (index, draw) in draws.into_iter().enumerate() {
            let stick_charge = if index % 2 == 0 { StickCharge::Frozen } else { StickCharge::Relaxing };
            let restitution = Restitution::Constant { coefficient: 0.3 };
            let parameters =
                ContactSeparationParameters { stick_charge, restitution, ..table_2(50e-6, force_law) };
            let start = ContactSeparationStart { gap_m: Some(6.5e-3), ..Default::default() };
            let scene = scene(parameters, start, 0.0, sine(0.3 * GRAVITY, 15.0), [0.0, 0.5]);
            let outcome = ledgers_close_with_storage(scene, [1.1, 0.3], draw);
            let storage = outcome.store.expect("there is a storage");
            let voltage = number(storage.store_voltage_v);
            close(storage.stored_energy_j, 0.5 * 2e-7 * voltage * voltage, 1e-12);
            assert!(particular(&outcome).impacts > 0);
        }
    }
}
