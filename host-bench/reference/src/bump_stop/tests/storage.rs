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
    let (outcome, _) = run(&model, &scene, None);
    let excess = 5.0 - 0.5 - 0.6;
    let shared = excess * own * capacitance / (own + capacitance);
    let found = outcome.store.expect("there is a storage");
    let gained = number(found.stored_energy_j) - 0.5 * capacitance * 0.25;
    close(outcome.delivered_energy_j, shared * (0.5 + 0.5 * shared / capacitance), 1e-4);
    close(outcome.delivered_energy_j, gained, 1e-9);
    close(found.diode_loss_j, shared * (0.6 + 0.5 * excess), 1e-4);
    assert!(number(outcome.energy_residual) < 1e-12, "{:?}", outcome.energy_residual);
}

/// Digits of an independent computation, event-driven, in the eigenvectors of the six regimes: free or in
/// contact, blocked or conducting either way.
#[test]
fn six_regimes_are_those_of_an_independent_computation() {
    let (mut model, mut scene) = scene([4, 1], [0.0, 12e-3]);
    model.stop = Some(StopParameters { gap_m: 5e-6, ..stop(1) });
    scene.load = Load::RectifiedStore(RectifiedStore { draw: resistor(2e6), ..storage(0.2e-6, 0.05, 0.2) });
    let (outcome, _) = run(&model, &scene, Some(12e-3));
    assert_eq!(outcome.events, 54);
    assert!((storage_voltage(&outcome) - 0.675_257_0).abs() <= 0.6e-7, "{:?}", outcome.store);
    let row = row(&outcome, 12e-3);
    assert!((row[4] - 0.216_503_9).abs() <= 0.6e-7, "{row:?}");
    assert_eq!(row[7], storage_voltage(&outcome));
    assert!(number(outcome.energy_residual) < 1e-12, "{:?}", outcome.energy_residual);
    assert_eq!(outcome.trace.as_ref().map(|trace| trace.columns[7]), Some("store_voltage_v"));
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

/// Weakly coupled, the best bus gets 2/π of what the best resistor `1/ωC` does.
#[test]
fn the_best_bus_and_the_best_resistor() {
    let (mut model, mut scene) = scene([1, 0], [200.0 / FREQUENCY, 210.0 / FREQUENCY]);
    model.parameters.coupling = Coupling::OneWay;
    let open = one_mode(&mut model, &mut scene, 0.0).voltage.norm();
    let capacitance = BumpStopModes::new(&model.parameters, None).capacitance;
    scene.load = Load::Resistor { resistance_ohm: (ANGULAR * capacitance).recip() };
    let resistor = number(run(&model, &scene, None).0.mean_power_w);
    close(resistor, 0.25 * ANGULAR * capacitance * open * open, 1e-9);
    scene.load = Load::DcBus { voltage_v: 0.5 * open, diode_drop_v: 0.0 };
    let bus = number(run(&model, &scene, None).0.mean_power_w);
    close(bus / resistor, std::f64::consts::FRAC_2_PI, 1e-9);
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

/// No more than `(γB)²/16ζω` can be taken from one mode.
#[test]
fn no_bus_takes_more_than_the_beam_can_give() {
    for voltage_v in [2.0, 5.0, 10.0] {
        let (mut model, mut scene) = scene([1, 0], [0.5, 1.0]);
        let mode = BumpStopModes::new(&model.parameters, None).beam[0];
        let bound = (mode.participation * AMPLITUDE).powi(2)
            / (16.0 * model.parameters.damping_ratio * mode.angular_frequency);
        one_mode(&mut model, &mut scene, 0.0);
        scene.excitation =
            Excitation::Sine(Tone { amplitude_m_per_s2: AMPLITUDE, frequency_hz: 242.0, phase_rad: 0.0 });
        scene.load = Load::DcBus { voltage_v, diode_drop_v: 0.0 };
        let power = number(run(&model, &scene, None).0.mean_power_w);
        assert!(power < bound && power > 0.02 * bound, "{voltage_v}: {power:e} {bound:e}");
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

/// A harvester that starts above the threshold shares its charge with the storage.
#[test]
fn a_start_above_the_threshold_conducts_at_once() {
    let (mut model, mut scene) = scene([2, 0], [0.0, 1e-6]);
    model.stop = None;
    model.initial = BumpStopStart { voltage_v: -5.0, ..BumpStopStart::at_rest(2, 0) };
    scene.excitation = Excitation::Silence;
    let capacitance = BumpStopModes::new(&model.parameters, None).capacitance;
    scene.load = Load::RectifiedStore(storage(3.0 * capacitance, 0.25, 1.5));
    let (outcome, _) = run(&model, &scene, Some(1e-6));
    // 5 V against 2 V: the harvester gives three quarters of the difference.
    let row = row(&outcome, 0.0);
    close(row[7], 2.25, 1e-12);
    close(row[4], -2.75, 1e-12);
}

/// Charging 4.7 µF at 0.3 V per diode from 220 Hz: volts at the seconds named, from an independent computation
/// by steps of 1 µs. Rare peaks of the voltage decide in the end, so truncation and step tell.
fn charging(stop: Option<StopParameters>, beam_modes: usize, rows: &[(f64, f64)], allowed: f64) {
    let end = rows.last().map_or(0.0, |(time, _)| *time);
    let rod_modes = stop.map_or(0, |stop| stop.rod_modes);
    let (mut model, mut scene) = scene([beam_modes, rod_modes], [0.0, end]);
    model.stop = stop;
    scene.load = Load::RectifiedStore(storage(4.7e-6, 0.3, 0.0));
    let (outcome, _) = run(&model, &scene, Some(0.5));
    for (time, expected) in rows {
        let found = row(&outcome, *time)[7];
        println!("{time} s: {found} V, expected {expected} V");
    }
    for (time, expected) in rows {
        close(row(&outcome, *time)[7], *expected, allowed);
    }
    assert!(number(outcome.energy_residual) < 1e-10, "{:?}", outcome.energy_residual);
}

fn with_gap(gap_m: f64, position_m: f64) -> Option<StopParameters> {
    Some(StopParameters { gap_m, position_m, ..stop(3) })
}

#[test]
fn the_storage_charges_without_a_stop() {
    charging(None, 10, &[(0.5, 4.011), (1.0, 4.572)], 1e-3);
}

#[test]
fn the_storage_charges_over_a_stop_in_the_middle() {
    charging(with_gap(10e-6, 25e-3), 10, &[(0.5, 2.048), (1.0, 2.447)], 5e-3);
}

#[test]
#[ignore = "ten minutes in the release profile"]
fn the_storage_charges_for_long() {
    charging(None, 10, &[(2.0, 4.700), (5.0, 4.707), (20.0, 4.707)], 1e-3);
    let mid = [(0.5, 2.048), (1.0, 2.447), (2.0, 2.549), (5.0, 2.555), (10.0, 2.556), (20.0, 2.556)];
    charging(with_gap(10e-6, 25e-3), 10, &mid, 5e-3);
    let tip = [(0.5, 0.589), (1.0, 0.720), (2.0, 0.771), (5.0, 0.793), (10.0, 0.805), (20.0, 0.808)];
    charging(with_gap(10e-6, 50e-3), 10, &tip, 0.05);
    let touching = [(0.5, 0.761), (1.0, 1.046), (2.0, 1.232), (5.0, 1.342), (10.0, 1.386), (20.0, 1.415)];
    charging(with_gap(0.0, 25e-3), 10, &touching, 0.05);
    let touching = [(0.5, 0.269), (1.0, 0.328), (2.0, 0.347), (5.0, 0.351), (10.0, 0.352), (20.0, 0.352)];
    charging(with_gap(0.0, 50e-3), 10, &touching, 0.1);
}
