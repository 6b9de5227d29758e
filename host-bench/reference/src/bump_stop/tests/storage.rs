//! A full bridge into a bus or a storage: an independent computation, closed forms, limits, and what a node
//! draws.

use super::linear::{I, Steady, steady};
use super::*;
use harvester_scene::scene_file::modes::BumpStopModes;
use harvester_scene::scene_file::{Draw, Lockout, RectifiedStore};

const ANGULAR: f64 = std::f64::consts::TAU * FREQUENCY;

/// A storage without leakage and draw.
fn storage(capacitance_f: f64, diode_drop_v: f64, initial_v: f64) -> RectifiedStore {
    RectifiedStore { capacitance_f, diode_drop_v, leakage_ohm: f64::INFINITY, initial_v, draw: Draw::None }
}

fn resistor(resistance_ohm: f64) -> Draw {
    Draw::Resistor { resistance_ohm, lockout: None }
}

fn storage_voltage(outcome: &Outcome) -> f64 {
    number(outcome.store.expect("there is a storage").store_voltage_v)
}

/// One mode without a stop that starts in the steady state of an open circuit, at a base angle of `phase` rad;
/// with that state.
fn one_mode(model: &mut BumpStop, scene: &mut Scene, phase: f64) -> Steady {
    let steady = steady(model, f64::INFINITY);
    let turn = (I * phase).exp();
    model.stop = None;
    model.initial = BumpStopStart {
        modal_displacement: steady.modal.iter().map(|modal| (modal * turn).im).collect(),
        modal_velocity: steady.modal.iter().map(|modal| (I * ANGULAR * modal * turn).im).collect(),
        ..BumpStopStart::at_rest(0, 0)
    };
    scene.excitation =
        Excitation::Sine(Tone { amplitude_m_per_s2: AMPLITUDE, frequency_hz: FREQUENCY, phase_rad: phase });
    steady
}

/// A start voltage above the threshold is shared with the storage at once, and its energies are booked.
#[test]
fn a_start_voltage_is_shared_with_the_storage() {
    let (mut model, mut scene) = scene([4, 1], [0.0, 1e-5]);
    model.stop = None;
    model.initial.rod_modal_displacement.clear();
    model.initial.rod_modal_velocity.clear();
    model.initial.voltage_v = -5.0;
    scene.excitation = Excitation::Silence;
    let (capacitance, own) = (1e-8, BumpStopModes::new(&model.parameters, None).capacitance);
    scene.load = Load::RectifiedStore(storage(capacitance, 0.3, 0.5));
    let (outcome, _) = run(&model, &scene, Some(1e-5));
    let excess = 5.0 - 0.5 - 0.6;
    let shared = excess * own * capacitance / (own + capacitance);
    let start = row(&outcome, 0.0);
    close(start[7], 0.5 + shared / capacitance, 1e-12);
    close(start[4], -(5.0 - shared / own), 1e-12);
    let found = outcome.store.expect("there is a storage");
    let gained = number(found.stored_energy_j) - 0.5 * capacitance * 0.25;
    close(outcome.delivered_energy_j, shared * (0.5 + 0.5 * shared / capacitance), 1e-4);
    close(outcome.delivered_energy_j, gained, 1e-9);
    close(found.diode_loss_j, shared * (0.6 + 0.5 * excess), 1e-4);
    assert!(number(outcome.energy_residual) < 1e-12, "{:?}", outcome.energy_residual);
}

/// Weakly coupled, each half period brings the charge `2 C (V_oc − V_dc − 2 V_D)` into a bus, and through two
/// diodes. The digits are those of an independent computation.
#[test]
fn a_bus_gets_the_charge_of_each_half_period() {
    let (mut model, mut scene) = scene([1, 0], [10.0 / FREQUENCY, 30.0 / FREQUENCY]);
    model.parameters.coupling = Coupling::OneWay;
    let open = one_mode(&mut model, &mut scene, 0.0).voltage.norm();
    close(open, 7.08722, 1e-6);
    let capacitance = BumpStopModes::new(&model.parameters, None).capacitance;
    for (part, diode_drop_v, known) in [
        (0.5, 0.0, 176.0315),
        (0.25, 0.0, f64::NAN),
        (0.75, 0.0, f64::NAN),
        (0.5, 0.3, f64::NAN),
        (0.25, 0.3, f64::NAN),
    ] {
        let voltage_v = part * open;
        scene.load = Load::DcBus { voltage_v, diode_drop_v };
        let (outcome, _) = run(&model, &scene, None);
        let moved = 4.0 * FREQUENCY * capacitance * (open - voltage_v - 2.0 * diode_drop_v);
        close(number(outcome.mean_power_w), moved * voltage_v, 1e-10);
        if !known.is_nan() {
            close(1e6 * number(outcome.mean_power_w), known, 1e-6);
        }
        assert!(number(outcome.energy_residual) < 1e-12);
        close(number(outcome.peak_voltage_v), voltage_v + 2.0 * diode_drop_v, 1e-11);
    }
    // The whole run, its start included: what the diodes lose is to what comes through as 2 V_D to the bus.
    let diode_drop_v = 0.3;
    scene.load = Load::DcBus { voltage_v: 3.0, diode_drop_v };
    scene.run.settle_s = 0.0;
    let (outcome, _) = run(&model, &scene, None);
    let lost = number(outcome.store.and_then(|store| store.diode_loss_j));
    close(lost / number(outcome.delivered_energy_j), 2.0 * diode_drop_v / 3.0, 1e-12);
    assert_eq!(outcome.store.and_then(|store| store.stored_energy_j), None);
}

/// From one end of the stroke to the other, `V_{n+1} (C_s + C) = V_n (C_s − C) + 2 C (V_oc − 2 V_D)`.
#[test]
fn a_storage_charges_by_half_periods() {
    let (mut model, mut scene) = scene([1, 0], [0.0, 1.0]);
    model.parameters.coupling = Coupling::OneWay;
    let modal = steady(&model, f64::INFINITY).modal[0];
    let open = one_mode(&mut model, &mut scene, -std::f64::consts::FRAC_PI_2 - modal.arg()).voltage.norm();
    let (capacitance_f, diode_drop_v) = (1e-6, 0.3);
    let capacitance = BumpStopModes::new(&model.parameters, None).capacitance;
    model.initial.voltage_v = -2.0 * diode_drop_v;
    scene.load = Load::RectifiedStore(storage(capacitance_f, diode_drop_v, 0.0));
    let mut voltage = 0.0;
    for count in 1..=200 {
        voltage = (voltage * (capacitance_f - capacitance) + 2.0 * capacitance * (open - 2.0 * diode_drop_v))
            / (capacitance_f + capacitance);
        if [1, 2, 100, 200].contains(&count) {
            scene.run.duration_s = 0.5 * f64::from(count) / FREQUENCY;
            let (outcome, _) = run(&model, &scene, None);
            close(storage_voltage(&outcome), voltage, 1e-10);
            assert!(number(outcome.energy_residual) < 1e-11, "{:?}", outcome.energy_residual);
        }
    }
}

/// The closed form of Shu and Lien for one mode with finite coupling and a resistor after the storage, which
/// takes the motion as a sine: `u = γB / √[(ηω + 2ωθ²R/q²)² + (K − ω² + ωθ²R/q)²]`, `V = ωθRu/q`,
/// `q = CωR + π/2`.
#[test]
fn a_weak_coupling_is_that_of_shu_and_lien() {
    for resistance in [30e3, 100e3, 1e6] {
        let (mut model, mut scene) = scene([1, 0], [0.0, 1.0]);
        model.parameters.piezo_d31_m_per_v *= 0.1;
        one_mode(&mut model, &mut scene, 0.0);
        let modes = BumpStopModes::new(&model.parameters, None);
        let (mode, capacitance) = (modes.beam[0], modes.capacitance);
        let (own, coupling) = (mode.angular_frequency, mode.coupling);
        let q = capacitance * ANGULAR * resistance + std::f64::consts::FRAC_PI_2;
        let damping = ANGULAR
            * (2.0 * model.parameters.damping_ratio * own + 2.0 * coupling * coupling * resistance / (q * q));
        let stiffness = own * own - ANGULAR * ANGULAR + ANGULAR * coupling * coupling * resistance / q;
        let amplitude = mode.participation * AMPLITUDE / damping.hypot(stiffness);
        let voltage = ANGULAR * coupling.abs() * resistance * amplitude / q;
        // Ten time constants of the storage from the value expected; the beam's is far below.
        let capacitance_f = 2.0 / resistance;
        scene.run = RunSpan { duration_s: 4400.0 / FREQUENCY, settle_s: 4000.0 / FREQUENCY };
        scene.load = Load::RectifiedStore(RectifiedStore {
            draw: resistor(resistance),
            ..storage(capacitance_f, 0.0, voltage)
        });
        let (outcome, _) = run(&model, &scene, None);
        // What enters leaves through the resistor. The square of the coupling coefficient is 4.8e-4.
        close((number(outcome.mean_power_w) * resistance).sqrt(), voltage, 6e-4);
    }
}

/// A bus at 0 V behind ideal diodes is a short circuit, one that is never reached an open one.
#[test]
fn a_bus_has_the_limits_of_a_resistor() {
    let (mut model, mut scene) = scene([4, 1], [0.0, 6e-3]);
    model.initial = BumpStopStart::at_rest(4, 1);
    for (voltage_v, resistance_ohm) in [(0.0, 0.0), (1e4, f64::INFINITY)] {
        scene.load = Load::Resistor { resistance_ohm };
        let (expected, _) = run(&model, &scene, Some(1e-3));
        scene.load = Load::DcBus { voltage_v, diode_drop_v: 0.0 };
        let (found, _) = run(&model, &scene, Some(1e-3));
        for time in [3e-3, 6e-3] {
            close(row(&found, time)[1], row(&expected, time)[1], 1e-9);
        }
        assert_eq!(particular(&found).contacts, particular(&expected).contacts);
        assert_eq!(found.mean_power_w, Some(0.0));
        assert!(number(found.energy_residual) < 1e-12);
    }
}

/// A node that is connected throughout draws its power or its current; with a lock-out a resistor is connected
/// and disconnected, and the storage stays between the thresholds.
#[test]
fn the_draw_is_what_the_node_asks_for() {
    const END: f64 = 40e-3;
    let (mut model, mut scene) = scene([4, 1], [0.0, END]);
    model.stop = Some(StopParameters { gap_m: 5e-6, ..stop(1) });
    let lockout = Lockout { turn_on_v: 0.5, turn_off_v: 0.1 };
    let base = RectifiedStore { leakage_ohm: 5e6, ..storage(0.2e-6, 0.05, 0.6) };
    let power_w = 0.4e-6;
    scene.load = Load::RectifiedStore(RectifiedStore { draw: Draw::Power { power_w, lockout }, ..base });
    let (outcome, _) = run(&model, &scene, None);
    let drawn = |outcome: &Outcome| number(outcome.store.and_then(|store| store.drawn_energy_j));
    close(drawn(&outcome), power_w * END, 5e-9);
    assert!(number(outcome.energy_residual) < 1e-11, "{:?}", outcome.energy_residual);

    let current_a = 0.5e-6;
    scene.load = Load::RectifiedStore(RectifiedStore { draw: Draw::Current { current_a, lockout }, ..base });
    let every = 1e-5;
    let (outcome, _) = run(&model, &scene, Some(every));
    let rows = &outcome.trace.as_ref().expect("a recording").rows;
    // The voltage has kinks where conduction ends: the trapezium is good for 1e-5.
    let sum: f64 = rows.windows(2).map(|pair| 0.5 * every * (pair[0][7] + pair[1][7])).sum();
    close(drawn(&outcome), current_a * sum, 1e-5);
    assert!(number(outcome.energy_residual) < 1e-11);

    let lockout = Lockout { turn_on_v: 0.65, turn_off_v: 0.62 };
    let draw = Draw::Resistor { resistance_ohm: 50e3, lockout: Some(lockout) };
    scene.load = Load::RectifiedStore(RectifiedStore { draw, ..base });
    let (outcome, _) = run(&model, &scene, Some(every));
    // The same hysteresis, followed from row to row.
    let (mut connected, mut switches, mut sum) = (false, 0, 0.0);
    for row in &outcome.trace.as_ref().expect("a recording").rows {
        let voltage = row[7];
        let before = connected;
        connected = if connected { voltage > lockout.turn_off_v } else { voltage >= lockout.turn_on_v };
        switches += u32::from(connected != before);
        sum += if connected { every * voltage * voltage / 50e3 } else { 0.0 };
    }
    assert!(switches > 3, "{switches}");
    close(drawn(&outcome), sum, 1e-2);
    assert!(number(outcome.energy_residual) < 1e-11);
}
