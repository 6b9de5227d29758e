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
