//! The [`Status`] of a node by the Smart Battery specification, for code that is written against `embedded-batteries`.
//!
//! Nine of its 35 methods have a value. The others give [`ErrorCode::UnsupportedCmd`]: a node has no temperature, cycles, alarms and
//! names, its currents are far below a milliampere, and times to empty or full depend on the actions to come.

use super::Status;
use crate::scalar::Scalar;
use embedded_batteries::smart_battery::*;
use embedded_batteries::{MilliAmps, MilliAmpsSigned, MilliVolts};

/// A value of the stored energy; [`ErrorCode::Busy`] while that is unknown.
fn known<T>(status: &Status, value: T) -> Result<T, ErrorKind> {
    if status.energy_bound < f32::INFINITY { Ok(value) } else { refused(ErrorCode::Busy) }
}

fn refused<T>(code: ErrorCode) -> Result<T, ErrorKind> {
    Err(ErrorKind::BatteryStatus(code))
}

/// An energy in J in 10 mWh, which are 36 J: of a capacitor mostly 0.
fn capacity(energy: f32) -> CapacityModeValue {
    let counts = (energy * (1.0 / 36.0) + 0.5).to_u32();
    CapacityModeValue::CentiWattUnsigned(u16::try_from(counts).unwrap_or(u16::MAX))
}

fn percent(part: f32) -> Percent {
    Scalar::min(100.0 * part + 0.5, 100.0).to_u32() as Percent
}

/// `discharging` says that nothing is harvested: a status does not know what is drawn.
fn flags(status: &Status) -> BatteryStatusFields {
    let charge = known(status, status.charge).ok();
    BatteryStatusFields::new()
        .with_initialized(charge.is_some())
        .with_fully_charged(charge >= Some(1.0))
        .with_fully_discharged(charge.is_some_and(|charge| charge <= 0.0))
        .with_discharging(status.power <= 0.0)
}

impl ErrorType for Status {
    type Error = ErrorKind;
}

macro_rules! methods {
    ($status:ident: $($method:ident $result:ident = $value:expr;)+ [$($other:ident($($type:ty)?) $of:ty),+]) => {
        $(fn $method(&mut self) -> Result<$result, ErrorKind> {
            let $status = &*self;
            $value
        })+
        $(fn $other(&mut self $(, _: $type)?) -> Result<$of, ErrorKind> {
            refused(ErrorCode::UnsupportedCmd)
        })+
    };
}

impl SmartBattery for Status {
    fn battery_mode(&mut self) -> Result<BatteryModeFields, ErrorKind> {
        Ok(BatteryModeFields::new().with_capacity_mode(true))
    }

    methods! { status:
        voltage MilliVolts = match MilliVolts::try_from((1e3 * status.voltage + 0.5).to_u32()) {
            Ok(voltage) => known(status, voltage),
            Err(_) => refused(ErrorCode::UnderOverFlow),
        };
        max_error Percent = Ok(percent(status.energy_bound / status.room));
        relative_state_of_charge Percent = known(status, percent(status.charge));
        absolute_state_of_charge Percent = known(status, percent(status.charge));
        remaining_capacity CapacityModeValue = known(status, capacity(status.charge * status.room));
        full_charge_capacity CapacityModeValue = Ok(capacity(status.room));
        design_capacity CapacityModeValue = Ok(capacity(status.room));
        battery_status BatteryStatusFields = Ok(flags(status));
        [set_battery_mode(BatteryModeFields) (), remaining_capacity_alarm() CapacityModeValue,
        set_remaining_capacity_alarm(CapacityModeValue) (), remaining_time_alarm() Minutes,
        set_remaining_time_alarm(Minutes) (), at_rate() CapacityModeSignedValue,
        set_at_rate(CapacityModeSignedValue) (), at_rate_time_to_full() Minutes, at_rate_time_to_empty() Minutes,
        at_rate_ok() bool, run_time_to_empty() Minutes, average_time_to_empty() Minutes,
        average_time_to_full() Minutes, temperature() DeciKelvin, current() MilliAmpsSigned,
        average_current() MilliAmpsSigned, charging_current() MilliAmps, charging_voltage() MilliVolts,
        cycle_count() Cycles, design_voltage() MilliVolts, specification_info() SpecificationInfoFields,
        manufacture_date() ManufactureDate, serial_number() u16, manufacturer_name(&mut [u8]) (),
        device_name(&mut [u8]) (), device_chemistry(&mut [u8]) ()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::{PowerSource, Verdict};
    use CapacityModeValue::CentiWattUnsigned;

    #[test]
    fn a_status_has_the_terms_of_a_smart_battery() {
        // 350 mWh, two thirds full, known to 5 %, without vibration.
        let mut status = Status {
            voltage: 2.3456,
            energy: 840.0,
            energy_bound: 63.0,
            energy_age: 0,
            room: 1260.0,
            charge: 2.0 / 3.0,
            power: 0.0,
            power_bound: 1e-6,
            power_age: 0,
            source: PowerSource::Voltage,
            endurance: 3600.0,
            verdict: Verdict::Fades,
        };
        let charge =
            [status.relative_state_of_charge(), status.absolute_state_of_charge(), status.max_error()];
        assert_eq!((status.voltage(), charge), (Ok(2346), [Ok(67), Ok(67), Ok(5)]));
        let full = [status.full_charge_capacity(), status.design_capacity()];
        assert_eq!(
            (status.remaining_capacity(), full),
            (Ok(CentiWattUnsigned(23)), [Ok(CentiWattUnsigned(35)); 2])
        );
        assert!(status.battery_mode().is_ok_and(|mode| mode.capacity_mode()));
        let flags = |mut status: Status| {
            let flags = status.battery_status().expect("flags");
            [flags.initialized(), flags.fully_charged(), flags.fully_discharged(), flags.discharging()]
        };
        assert_eq!(flags(status), [true, false, false, true]);
        assert_eq!(flags(Status { charge: 1.0, power: 1e-6, ..status }), [true, true, false, false]);
        assert_eq!(flags(Status { charge: 0.0, ..status }), [true, false, true, true]);
        let failed = |code| Some(ErrorKind::BatteryStatus(code));
        assert_eq!(status.temperature().err(), failed(ErrorCode::UnsupportedCmd));
        assert_eq!(Status { voltage: 65.6, ..status }.voltage().err(), failed(ErrorCode::UnderOverFlow));
        status.energy_bound = f32::INFINITY;
        assert_eq!((status.voltage().err(), status.max_error()), (failed(ErrorCode::Busy), Ok(100)));
        assert_eq!(flags(status), [false, false, false, true]);
    }
}
