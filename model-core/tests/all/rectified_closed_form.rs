//! The closed form behind a bridge into a constant voltage: its limits are those of a resistor, its charge is that of the
//! extremes of the motion.

use crate::bridge::{VACUUM_PERMITTIVITY, behind, pad, slider};
use crate::common::harvesters::sliding_parameters;
use model_core::part::force_law::AnyForceLaw;
use model_core::part::storage::DcBus;
use model_core::scene::closed_form::{ClosedForm, Reason, Validity};
use model_core::scene::rectified::RegularMotion;

const G: f64 = 9.81;

fn close(name: &str, found: f64, expected: f64, relative: f64) {
    println!("{name}: {found:e}, expected {expected:e}");
    assert!((found / expected - 1.0).abs() < relative, "{name}: {found} is not {expected} within {relative}");
}

fn into_bus(harvester: impl RegularMotion<f64>, voltage: f64, drop: f64, at: [f64; 2]) -> ClosedForm<f64> {
    behind(harvester, DcBus { voltage }, drop).closed_form_at(at[0], at[1], voltage)
}

/// No voltage and no drop are a short circuit, a voltage out of reach is an open circuit. The closed forms with a resistor
/// are those of other formulas: two harmonics of the plate, Den Hartog's motion of the slider.
#[test]
fn the_limits_are_those_of_a_resistor() {
    let open = f64::INFINITY;
    for law in [AnyForceLaw::TransferredCharge, AnyForceLaw::GapField] {
        for at in [[0.05 * G, 18.0], [0.02 * G, 19.0], [0.1 * G, 24.0]] {
            let shorted = pad::<f64>(0.0, law).closed_form(at[0], at[1]);
            let found = into_bus(pad(open, law), 0.0, 0.0, at);
            close("short-circuited plate", found.amplitude, shorted.amplitude, 1e-3);
            assert_eq!(found.mean_power, 0.0);
            let opened = pad::<f64>(open, law).closed_form(at[0], at[1]);
            let found = into_bus(pad(open, law), 1e6, 0.3, at);
            close("open plate", found.amplitude, opened.amplitude, 1e-3);
            close("voltage of the open plate", found.rms_voltage, opened.rms_voltage, 5e-3);
            assert_eq!(found.mean_power, 0.0);
        }
    }
    for at in [[0.36 * G, 18.3], [0.36 * G, 16.0], [0.3 * G, 21.0]] {
        let shorted = slider::<f64>(0.0).closed_form(at[0], at[1]);
        let found = into_bus(slider(open), 0.0, 0.0, at);
        // Off resonance the drive is little above the friction.
        close("short-circuited slider", found.amplitude, shorted.amplitude, 2e-2);
    }
}

/// The rectangle in the plane of charge and voltage: two charges at the ends of the motion, and twice as many of the slider.
#[test]
fn the_charge_is_that_of_the_rectangle() {
    let (voltage, drop, frequency) = (1.0, 0.3, 18.0);
    let threshold = voltage + 2.0 * drop;
    // Without a force of the field the mean gap is that at rest.
    let law = AnyForceLaw::None;
    let found = into_bus(pad(f64::INFINITY, law), voltage, drop, [0.05 * G, frequency]);
    let (area, thickness) = (VACUUM_PERMITTIVITY * 4e-4, 5e-5 / 2.0);
    let charge = |gap: f64, voltage: f64| {
        let distance = gap + thickness;
        (50e-6 * 4e-4 * gap - voltage * (area + 1e-12 * distance)) / distance
    };
    let (high, low) = (3e-3 + found.amplitude, 3e-3 - found.amplitude);
    let passed = charge(high, threshold) - charge(low, -threshold);
    close("plate", found.mean_power, 2.0 * frequency * passed * voltage, 1e-9);
    assert!(found.validity.holds(), "{:?}", found.validity);

    let voltage = 20.0;
    let frequency = 18.3;
    let found = into_bus(slider(f64::INFINITY), voltage, drop, [0.36 * G, frequency]);
    let patch = core::f64::consts::PI * 1e-4;
    let away = found.amplitude / 0.02;
    let overlap = (away.acos() - away * (1.0 - away * away).sqrt()) * core::f64::consts::FRAC_2_PI;
    let capacitance = VACUUM_PERMITTIVITY * 2.0 * patch / 5e-5;
    // V = (σ S (1 − s) − q)/(C s), at the turning point and at the centre.
    let density = sliding_parameters::<f64>().charge_density;
    let most = density * patch * (1.0 - overlap) - (voltage + 2.0 * drop) * capacitance * overlap;
    let passed = most - (voltage + 2.0 * drop) * capacitance;
    close("slider", found.mean_power, 4.0 * frequency * passed * voltage, 1e-7);
    assert!(found.validity.holds(), "{:?}", found.validity);
}

#[test]
fn what_is_not_regular_is_flagged() {
    let law = AnyForceLaw::TransferredCharge;
    let reason = |found: ClosedForm<f64>| match found.validity {
        Validity::NeedsTrajectory { reason, margin } => {
            assert!(margin > 1.0);
            Some(reason)
        }
        Validity::Holds { .. } => None,
    };
    let plate = |gravities: f64, frequency: f64| {
        reason(into_bus(pad(f64::INFINITY, law), 3.0, 0.3, [gravities * G, frequency]))
    };
    assert_eq!(plate(0.02, 18.0), None);
    assert_eq!(plate(2.0, 17.0), Some(Reason::Impacts));
    // Above resonance a transient of twice the amplitude reaches the dielectric.
    assert_eq!(plate(0.8, 22.5), Some(Reason::ImpactsInTransient));
    let slider = |gravities: f64, frequency: f64| {
        into_bus(slider(f64::INFINITY), 20.0, 0.3, [gravities * G, frequency])
    };
    assert_eq!(reason(slider(3.0, 18.3)), Some(Reason::LeavesOverlap));
    let held = slider(0.01, 18.3);
    assert_eq!((held.mean_power, held.amplitude, held.validity.holds()), (0.0, 0.0, true));
}
