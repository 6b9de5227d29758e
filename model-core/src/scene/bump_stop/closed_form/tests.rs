//! Against published numbers and limits.

use super::*;
use crate::part::load::AnyLoad;
use crate::part::monomorph::Layer;
use crate::scene::bump_stop::{AnyChoices, AnyContact, AnyCoupling, Choices, Parameters, Stop};

/// The baseline: 50 × 10 mm of 0.5 mm steel and 0.5 mm PZT-5A against an aluminium rod of 20 × 2 × 2 mm, 10 µm from
/// its tip.
fn baseline<S: Scalar>(coupling: AnyCoupling, resistance: f64) -> Parameters<S, AnyChoices<S>> {
    let number = S::from_f64;
    Parameters {
        beam_length: number(0.05),
        beam_width: number(0.01),
        substrate: Layer { thickness: number(5e-4), young_modulus: number(200e9), density: number(7850.0) },
        piezo: Layer { thickness: number(5e-4), young_modulus: number(66e9), density: number(7800.0) },
        piezo_d31: number(-190e-12),
        piezo_permittivity: number(15.93e-9),
        damping_ratio: number(0.01),
        choices: Choices::new(AnyLoad { resistance: number(resistance) })
            .coupling(coupling)
            .stop(Stop {
                length: number(0.02),
                section: number(4e-6),
                young_modulus: number(70e9),
                density: number(2700.0),
                position: number(0.05),
                gap: number(10e-6),
                contact_compliance: S::ZERO,
                contact: AnyContact::NoStop,
            })
            .tip_mass(None)
            .transducer(None),
    }
}

fn free<const B: usize>(coupling: AnyCoupling, resistance: f64) -> BumpStop<f64, AnyChoices<f64>, B, 0> {
    baseline(coupling, resistance).build().expect("valid")
}

fn close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() < relative, "{value} is not {expected} within {relative}");
}

const TWO_WAY: AnyCoupling = AnyCoupling::TwoWay;
const ONE_WAY: AnyCoupling = AnyCoupling::OneWay;

#[test]
fn voltage_tip_and_power_are_the_published_ones() {
    // Ten modes at 20 m/s², 220 Hz, 1 MΩ: voltage in V, tip in µm, power in µW.
    for (coupling, voltage, tip, power) in
        [(TWO_WAY, 5.298_981, 66.9337, 14.0396), (ONE_WAY, 7.029_422, 86.8043, 24.7064)]
    {
        let found = free::<10>(coupling, 1e6).closed_form(20.0, 220.0);
        close(found.rms_voltage * 2f64.sqrt(), voltage, 2e-7);
        close(1e6 * found.amplitude, tip, 1e-6);
        close(1e6 * found.mean_power, power, 3e-6);
        assert!(found.validity.holds());
    }
    // Six modes.
    let six = |coupling, resistance| free::<6>(coupling, resistance).closed_form(20.0, 220.0);
    close(1e6 * six(TWO_WAY, 1e6).amplitude, 66.9104, 1e-6);
    close(1e6 * six(TWO_WAY, 1e6).mean_power, 14.0835, 5e-6);
    close(1e6 * six(TWO_WAY, 45.41e3).mean_power, 193.168, 5e-6);
    close(1e6 * six(ONE_WAY, 45.41e3).mean_power, 272.573, 5e-6);
    close(six(TWO_WAY, 1e3).rms_voltage * 2f64.sqrt(), 0.154_761_8, 1e-6);
}

#[test]
fn the_best_loads_are_the_published_ones() {
    // Frequency in Hz, resistance in kΩ and power in µW.
    for (coupling, frequency, resistance, power) in [
        (TWO_WAY, 220.0, 33.9, 200.3),
        (ONE_WAY, 220.0, 45.7, 272.6),
        (TWO_WAY, 239.7, 16.2, 3812.0),
        (TWO_WAY, 245.3, 100.0, 3789.0),
    ] {
        let at = |resistance: f64| free::<6>(coupling, resistance).closed_form(20.0, frequency).mean_power;
        close(1e6 * at(1e3 * resistance), power, 2e-3);
        // The optimum is given to at most three digits.
        for other in [0.8, 1.25] {
            assert!(at(other * 1e3 * resistance) < at(1e3 * resistance), "{frequency} Hz");
        }
    }
}

#[test]
fn weakly_coupled_the_best_load_is_that_of_the_capacitance() {
    let frequency = 220.0;
    let scene = free::<1>(ONE_WAY, 1e6);
    let open = free::<1>(ONE_WAY, f64::INFINITY).closed_form(20.0, frequency);
    let omega = core::f64::consts::TAU * frequency;
    let best = 1.0 / (omega * scene.capacitance());
    let square = 2.0 * open.rms_voltage * open.rms_voltage;
    let power = |resistance: f64| free::<1>(ONE_WAY, resistance).closed_form(20.0, frequency).mean_power;
    close(power(best), 0.25 * omega * scene.capacitance() * square, 1e-12);
    assert!(power(1.01 * best) < power(best) && power(0.99 * best) < power(best));
    // At any coupling, one mode gives at most (γ B)²/(16 ζ ω): 3.98 mW.
    let bound = (0.048_976_12_f64 * 20.0).powi(2) / (16.0 * 0.01 * core::f64::consts::TAU * 239.705_436);
    close(bound, 3.982e-3, 1e-3);
    let mut most = 0.0_f64;
    for k in 0..200 {
        for l in 0..60 {
            let (frequency, resistance) =
                (235.0 + 0.075 * f64::from(k), 5e3 * 10f64.powf(0.04 * f64::from(l)));
            most = most.max(free::<1>(TWO_WAY, resistance).closed_form(20.0, frequency).mean_power);
        }
    }
    assert!(most < bound && most > 0.99 * bound, "{most} {bound}");
}

#[test]
fn the_ends_of_the_load_are_limits() {
    let at = |resistance: f64| free::<6>(TWO_WAY, resistance).closed_form(20.0, 220.0);
    let (short, open) = (at(0.0), at(f64::INFINITY));
    assert_eq!((short.mean_power, short.rms_voltage, open.mean_power), (0.0, 0.0, 0.0));
    close(at(1e-3).amplitude, short.amplitude, 1e-9);
    close(at(1e15).rms_voltage, open.rms_voltage, 1e-9);
    close(at(1e15).amplitude, open.amplitude, 1e-9);
    // Short-circuit current: v/R no longer depends on R.
    close(at(1e-3).rms_voltage / 1e-3, at(1e-6).rms_voltage / 1e-6, 1e-7);
}

#[test]
fn what_reaches_the_stop_is_flagged() {
    let mut parameters = baseline::<f64>(TWO_WAY, 1e6);
    parameters.choices.stop.contact = AnyContact::ResidualFlexibility;
    let scene = parameters.build::<10, 10>().expect("valid");
    let found = scene.closed_form(20.0, 220.0);
    let Validity::NeedsTrajectory { reason: Reason::ReachesStop, margin } = found.validity else {
        panic!("{:?}", found.validity)
    };
    // 66.93 µm over 10 µm, less the rod's motion in the other direction by nanometres.
    close(margin, 6.6934, 1e-4);
    let limit = 20.0 / margin;
    assert!(scene.closed_form(0.999 * limit, 220.0).validity.holds());
    assert!(!scene.closed_form(1.001 * limit, 220.0).validity.holds());
    // With the beam in contact at rest, only zero excitation is free of contact.
    let mut touching = parameters;
    touching.choices.stop.gap = 0.0;
    let touching = touching.build::<4, 1>().expect("valid");
    assert!(touching.closed_form(0.0, 220.0).validity.holds());
    assert!(!touching.closed_form(1e-9, 220.0).validity.holds());
}

#[test]
fn single_precision_gives_the_same() {
    for resistance in [1.0, 1e4, 1e6, 1e30] {
        for frequency in [50.0, 220.0, 239.7, 245.0, 1500.0] {
            let fine = free::<10>(TWO_WAY, resistance).closed_form(20.0, frequency);
            let single = baseline::<f32>(TWO_WAY, resistance).build::<10, 10>().expect("valid");
            let coarse = single.closed_form(20.0, frequency as f32);
            // At resonance 10⁻⁷ of the frequency is 10⁻⁵ of the detuning.
            close(coarse.mean_power.into(), fine.mean_power, 2e-4);
            close(coarse.amplitude.into(), fine.amplitude, 1e-4);
        }
    }
}

#[test]
fn into_a_bus_the_power_is_the_published_one() {
    // One mode without back-coupling: open 7.08722 V; power in µW at the best voltage of the bus.
    let scene = free::<1>(ONE_WAY, f64::INFINITY);
    let open = scene.closed_form(20.0, 220.0).rms_voltage * 2f64.sqrt();
    close(open, 7.087_22, 1e-6);
    for (drop, power) in [(0.0, 176.0315), (0.3, 147.4877)] {
        let best = 0.5 * (open - 2.0 * drop);
        let found = scene.closed_form_into_bus(20.0, 220.0, best, drop);
        close(1e6 * found.mean_power, power, 2e-6);
        assert!(found.validity.holds());
        for other in [0.9, 1.1] {
            let less = scene.closed_form_into_bus(20.0, 220.0, other * best, drop);
            assert!(less.mean_power < found.mean_power);
        }
    }
    // A bus above the open voltage blocks the bridge.
    let blocked = scene.closed_form_into_bus(20.0, 220.0, 1.01 * open, 0.0);
    assert_eq!(blocked.mean_power, 0.0);
    close(blocked.rms_voltage * 2f64.sqrt(), open, 1e-12);
    // The maximum with a bus is 2/π of the maximum with a resistor.
    let resistor = 1.0 / (core::f64::consts::TAU * 220.0 * scene.capacitance());
    let most = free::<1>(ONE_WAY, resistor).closed_form(20.0, 220.0).mean_power;
    let bus = scene.closed_form_into_bus(20.0, 220.0, 0.5 * open, 0.0).mean_power;
    close(bus / most, core::f64::consts::FRAC_2_PI, 1e-9);
    // Near resonance the voltage of a bus changes the motion with two-way coupling.
    let strong = free::<1>(TWO_WAY, 1e6).closed_form_into_bus(20.0, 239.0, 1.0, 0.0);
    assert!(matches!(strong.validity, Validity::NeedsTrajectory { reason: Reason::StrongCoupling, .. }));
}

#[test]
fn into_a_store_it_is_shu_and_liens_formula() {
    let (frequency, theta, gamma, capacitance) = (239.705_436_f64, 0.041_497_95, 0.048_976_12, 15.93e-9);
    let natural = core::f64::consts::TAU * frequency;
    // One mode, ideal diodes: the closed form of the voltage.
    let formula = |part: f64, frequency: f64, resistance: f64| {
        let (omega, theta) = (core::f64::consts::TAU * frequency, part * theta);
        let q = capacitance * omega * resistance + core::f64::consts::FRAC_PI_2;
        let damping = 2.0 * 0.01 * natural * omega + 2.0 * omega * theta * theta * resistance / (q * q);
        let stiffness = natural * natural - omega * omega + omega * theta * theta * resistance / q;
        omega * theta * resistance * (gamma * 20.0 / damping.hypot(stiffness)) / q
    };
    // Published: 3.4848 V at 220 Hz and 100 kΩ.
    close(formula(1.0, 220.0, 1e5), 3.4848, 2e-5);
    for (part, frequency, resistance) in
        [(1.0, 220.0, 1e5), (1.0, 200.0, 3e4), (0.1, 230.0, 1e5), (0.1, 260.0, 1e6)]
    {
        let mut parameters = baseline::<f64>(TWO_WAY, 1e6);
        parameters.piezo_d31 *= part;
        let scene = parameters.build::<1, 0>().expect("valid");
        let found = scene.closed_form_into_store(20.0, frequency, resistance, 0.0);
        let expected = formula(part, frequency, resistance);
        close(found.mean_power, expected * expected / resistance, 2e-6);
        assert!(found.validity.holds(), "{:?}", found.validity);
    }
    // With one-way coupling a bus at the storage voltage takes the power of the storage's load.
    let scene = free::<4>(ONE_WAY, 1e6);
    let storage = scene.closed_form_into_store(20.0, 220.0, 1e5, 0.3);
    let voltage = (storage.mean_power * 1e5).sqrt();
    let bus = scene.closed_form_into_bus(20.0, 220.0, voltage, 0.3);
    close(bus.mean_power, storage.mean_power, 1e-9);
    close(bus.rms_voltage, storage.rms_voltage, 1e-9);
    // Diode drops above the voltage.
    assert_eq!(scene.closed_form_into_store(20.0, 220.0, 1e5, 10.0).mean_power, 0.0);
    // At resonance the motion is not harmonic.
    assert!(!free::<1>(TWO_WAY, 1e6).closed_form_into_store(20.0, 242.0, 1e5, 0.0).validity.holds());
}

#[test]
fn behind_a_bridge_the_terminal_voltage_is_flat_topped() {
    // By sampling: the charge changes the voltage until it is clamped.
    let scene = free::<1>(ONE_WAY, 1e6);
    let open = scene.closed_form_into_bus(20.0, 220.0, 1e9, 0.0).rms_voltage * 2f64.sqrt();
    for bridge in [0.05 * open, 0.4 * open, 0.9 * open] {
        let (count, mut sum) = (200_000, 0.0);
        for k in 0..count {
            let angle = core::f64::consts::PI * (f64::from(k) + 0.5) / f64::from(count);
            let voltage = (open * (1.0 - angle.cos()) - bridge).min(bridge);
            sum += voltage * voltage / f64::from(count);
        }
        close(scene.closed_form_into_bus(20.0, 220.0, bridge, 0.0).rms_voltage, sum.sqrt(), 1e-6);
    }
}

#[test]
fn the_open_circuit_is_stiffer_by_the_coupling() {
    // One mode: ω² + θ²/C.
    let (frequency, theta, capacitance) = (239.705_436_f64, 0.041_497_95_f64, 15.93e-9);
    let natural = core::f64::consts::TAU * frequency;
    let one = free::<1>(TWO_WAY, 1e6).open_circuit_angular_frequency(0).expect("a mode");
    close(one, (natural * natural + theta * theta / capacitance).sqrt(), 1e-8);
    assert_eq!(free::<1>(TWO_WAY, 1e6).open_circuit_angular_frequency(1), None);
    let same = free::<4>(ONE_WAY, 1e6);
    assert_eq!(same.open_circuit_angular_frequency(2), same.beam_angular_frequency(2));
    // Without damping the open circuit resonates there: each mode of six, and of capacities with modes left at rest.
    let mut parameters = baseline::<f64>(TWO_WAY, f64::INFINITY);
    parameters.damping_ratio = 1e-7;
    let six = parameters.build_first::<10, 0>(6, 0).expect("valid");
    for index in 0..6 {
        let omega = six.open_circuit_angular_frequency(index).expect("a mode");
        let (own, next) = (six.beam_angular_frequency(index), six.beam_angular_frequency(index + 1));
        assert!(omega > own.expect("a mode") && (index == 5 || Some(omega) < next));
        let at = |part: f64| six.closed_form(1.0, part * omega / core::f64::consts::TAU).amplitude;
        assert!(at(1.0) > 50.0 * at(1.0 + 1e-5).max(at(1.0 - 1e-5)), "mode {index}");
    }
    let single = baseline::<f32>(TWO_WAY, 1e6).build_first::<10, 0>(6, 0).expect("valid");
    for index in 0..6 {
        let omega = single.open_circuit_angular_frequency(index).expect("a mode");
        close(omega.into(), six.open_circuit_angular_frequency(index).expect("a mode"), 1e-6);
    }
}

#[test]
fn a_bus_that_acts_back_is_the_storage_of_its_voltage() {
    // Two-way: at the steady voltage of a storage, the power that its load takes (Shu and Lien).
    for (frequency, resistance, drop) in [(220.0, 1e5, 0.0), (200.0, 3e4, 0.3), (260.0, 1e6, 0.0)] {
        let mut parameters = baseline::<f64>(TWO_WAY, 1e6);
        parameters.piezo_d31 *= 0.3;
        let scene = parameters.build::<4, 0>().expect("valid");
        let storage = scene.closed_form_into_store(20.0, frequency, resistance, drop);
        let voltage = (storage.mean_power * resistance).sqrt();
        let bus = scene.closed_form_into_bus(20.0, frequency, voltage, drop);
        close(bus.mean_power, storage.mean_power, 1e-4);
        close(bus.amplitude, storage.amplitude, 1e-4);
        assert!(bus.validity.holds(), "{:?}", bus.validity);
    }
    // A bus out of reach leaves the terminals open.
    let scene = free::<6>(TWO_WAY, f64::INFINITY);
    let blocked = scene.closed_form_into_bus(20.0, 220.0, 100.0, 0.3);
    let open = scene.closed_form(20.0, 220.0);
    assert_eq!(blocked.mean_power, 0.0);
    close(blocked.amplitude, open.amplitude, 1e-12);
    close(blocked.rms_voltage, open.rms_voltage, 1e-12);
    assert!(blocked.validity.holds());
}
