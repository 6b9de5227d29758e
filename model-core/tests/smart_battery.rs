//! The status of a node by the Smart Battery specification.

use CapacityModeValue::CentiWattUnsigned;
use embedded_batteries::smart_battery::*;
use model_core::node::*;

#[test]
fn a_status_has_the_terms_of_a_smart_battery() {
    let parameters = VoltageParameters::<0> {
        storage: StorageParameters {
            capacitor: Capacitor { capacitance: 10e-3, leakage_resistance: 100e6 },
            charging_efficiency: 1.0,
            discharging_efficiency: 0.9,
            highest_voltage: 4.5,
            lock_out_voltage: 1.9,
            turn_on_voltage: 2.2,
        },
        converter: Converter { bits: 12, full_scale: 5.0, noise: 0.6e-3 },
        standing_power: 0.6e-6,
        reading: 0.3e-6,
        intervals: [60, 300],
        tolerances: Tolerances::EXACT,
        largest_power: 100e-6,
        reserve: 35e-3,
        actions: [],
    };
    let node = parameters.build().expect("parameters in their bounds");
    let mut status = node.status(&node.start(0));
    assert_eq!(status.max_error(), Ok(100));
    // 350 mWh, two thirds full, known to 5 %, without vibration.
    (status.voltage, status.charge) = (2.3456, 2.0 / 3.0);
    (status.energy, status.energy_bound, status.room) = (840.0, 63.0, 1260.0);
    (status.power, status.verdict) = (0.0, Verdict::Fades);
    let charge = [status.relative_state_of_charge(), status.absolute_state_of_charge(), status.max_error()];
    assert_eq!((status.voltage(), charge), (Ok(2346), [Ok(67), Ok(67), Ok(5)]));
    let full = [status.full_charge_capacity(), status.design_capacity()];
    assert_eq!(
        (status.remaining_capacity(), full),
        (Ok(CentiWattUnsigned(23)), [Ok(CentiWattUnsigned(35)); 2])
    );
    assert!(status.battery_mode().is_ok_and(|mode| mode.capacity_mode()));
    let flags = |mut status: Status, charge: f32, power: f32| {
        (status.charge, status.power) = (charge, power);
        let flags = status.battery_status().expect("flags");
        [flags.initialized(), flags.fully_charged(), flags.fully_discharged(), flags.discharging()]
    };
    assert_eq!(flags(status, 0.5, 0.0), [true, false, false, true]);
    assert_eq!(flags(status, 1.0, 1e-6), [true, true, false, false]);
    assert_eq!(flags(status, 0.0, 0.0), [true, false, true, true]);
    let failed = |code| Some(ErrorKind::BatteryStatus(code));
    assert_eq!(status.temperature().err(), failed(ErrorCode::UnsupportedCmd));
    status.voltage = 65.6;
    assert_eq!(status.voltage().err(), failed(ErrorCode::UnderOverFlow));
    (status.voltage, status.energy_bound) = (2.3456, f32::INFINITY);
    assert_eq!((status.voltage().err(), status.max_error()), (failed(ErrorCode::Busy), Ok(100)));
    assert_eq!(flags(status, 0.5, 0.0), [false, false, false, true]);
}
