//! The draw of a sensor node from its storage.
//!
//! A converter connects the node when the storage has risen to a turn-on voltage and disconnects it when the
//! storage has fallen to a turn-off voltage: under-voltage lock-out with hysteresis. A connected node is a
//! resistor, a constant current (a linear regulator), or a constant power (a switching regulator).

use core::fmt::Debug;

use crate::bounds::{Bounds, ParameterError, bounded};
use crate::forward;
use crate::scalar::Scalar;

/// Largest voltage of a storage in V.
pub(crate) const HIGHEST_VOLTAGE: f64 = 1e6;

/// Under-voltage lock-out: two voltages of the storage in V.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Lockout<S> {
    /// The draw is connected when the storage rises to this voltage.
    pub turn_on: S,
    /// The draw is disconnected when the storage falls to this voltage, below `turn_on`.
    pub turn_off: S,
}

bounded! { Lockout<S>: "draw.turn_on" = turn_on: 0.0, HIGHEST_VOLTAGE; }

impl<S: Scalar> Lockout<S> {
    fn check(&self) -> Result<(), ParameterError<S>> {
        self.check_numbers()?;
        Bounds { lowest: S::ZERO, highest: self.turn_on * (S::ONE - S::EPSILON) }
            .check("draw.turn_off", self.turn_off)
    }
}

/// The current that a node draws from a storage; the provided methods are those of no draw.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no draw on a storage",
    note = "a draw is `NoDraw`, a `ResistiveDraw`, a `CurrentDraw`, a `PowerDraw` or an `AnyDraw`"
)]
pub(crate) trait Draw<S: Scalar>: Copy + Debug + PartialEq {
    /// Whether the draw can differ from zero.
    const POSSIBLE: bool;

    /// Whether the current is linear in the voltage.
    const LINEAR: bool = true;

    /// Current in A at a storage voltage in V, while connected.
    #[inline]
    fn current(&self, _voltage: S) -> S {
        S::ZERO
    }

    /// Derivative of the current by the voltage, in A/V.
    #[inline]
    fn current_by_voltage(&self, _voltage: S) -> S {
        S::ZERO
    }

    /// The lock-out; `None` for a draw that is always connected.
    #[inline]
    fn lockout(&self) -> Option<Lockout<S>> {
        None
    }

    /// Checks the parameters of the draw.
    ///
    /// # Errors
    /// The field, its value and its bounds.
    fn check(&self) -> Result<(), ParameterError<S>> {
        Ok(())
    }
}

/// No draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoDraw;

impl<S: Scalar> Draw<S> for NoDraw {
    const POSSIBLE: bool = false;
}

/// A resistor across the storage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ResistiveDraw<S> {
    /// Resistance in Ω, 10⁻³ to 10¹⁵.
    pub resistance: S,
    /// The lock-out; `None` for a draw that is always connected.
    pub lockout: Option<Lockout<S>>,
}

bounded! { ResistiveDraw<S>: "draw.resistance" = resistance: 1e-3, 1e15; }

impl<S: Scalar> Draw<S> for ResistiveDraw<S> {
    const POSSIBLE: bool = true;

    #[inline]
    fn current(&self, voltage: S) -> S {
        voltage / self.resistance
    }

    #[inline]
    fn current_by_voltage(&self, _voltage: S) -> S {
        S::ONE / self.resistance
    }

    #[inline]
    fn lockout(&self) -> Option<Lockout<S>> {
        self.lockout
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        self.check_numbers()?;
        self.lockout.map_or(Ok(()), |lockout| lockout.check())
    }
}

/// A constant current, as of a linear regulator.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CurrentDraw<S> {
    /// Current in A, 0 to 10³.
    pub current: S,
    /// The lock-out, required because an empty storage delivers no current.
    pub lockout: Lockout<S>,
}

bounded! { CurrentDraw<S>: "draw.current" = current: 0.0, 1e3; }

impl<S: Scalar> Draw<S> for CurrentDraw<S> {
    const POSSIBLE: bool = true;

    #[inline]
    fn current(&self, _voltage: S) -> S {
        self.current
    }

    #[inline]
    fn lockout(&self) -> Option<Lockout<S>> {
        Some(self.lockout)
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        self.check_numbers()?;
        self.lockout.check()
    }
}

/// A constant power, as of a switching regulator.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PowerDraw<S> {
    /// Power in W, 0 to 10³.
    pub power: S,
    /// The lock-out, with a turn-off voltage of at least 1 mV: the current grows without bound towards 0 V.
    pub lockout: Lockout<S>,
}

bounded! { PowerDraw<S>:
    "draw.power" = power: 0.0, 1e3;
    "draw.turn_off" = lockout.turn_off: 1e-3, HIGHEST_VOLTAGE;
}

impl<S: Scalar> PowerDraw<S> {
    /// Voltage in V below which the current is constant. A trial step may reach below the turn-off voltage
    /// before the event cuts the step.
    #[inline]
    fn floor(&self) -> S {
        S::from_f64(0.5) * self.lockout.turn_off
    }
}

impl<S: Scalar> Draw<S> for PowerDraw<S> {
    const POSSIBLE: bool = true;
    const LINEAR: bool = false;

    #[inline]
    fn current(&self, voltage: S) -> S {
        self.power / voltage.max(self.floor())
    }

    #[inline]
    fn current_by_voltage(&self, voltage: S) -> S {
        if voltage > self.floor() { -self.power / (voltage * voltage) } else { S::ZERO }
    }

    #[inline]
    fn lockout(&self) -> Option<Lockout<S>> {
        Some(self.lockout)
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        self.lockout.check()?;
        self.check_numbers()
    }
}

/// A draw chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyDraw<S> {
    /// As [`NoDraw`].
    None,
    /// As [`ResistiveDraw`].
    Resistor(ResistiveDraw<S>),
    /// As [`CurrentDraw`].
    Current(CurrentDraw<S>),
    /// As [`PowerDraw`].
    Power(PowerDraw<S>),
}

impl<S: Scalar> Draw<S> for AnyDraw<S> {
    const POSSIBLE: bool = true;
    const LINEAR: bool = false;

    forward! {
        match {
            Self::None => NoDraw,
            Self::Resistor(draw) => draw,
            Self::Current(draw) => draw,
            Self::Power(draw) => draw,
        }
        #[inline] fn current(&self, voltage: S) -> S;
        #[inline] fn current_by_voltage(&self, voltage: S) -> S;
        #[inline] fn lockout(&self) -> Option<Lockout<S>>;
        fn check(&self) -> Result<(), ParameterError<S>>;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOCKOUT: Lockout<f64> = Lockout { turn_on: 3.0, turn_off: 2.0 };

    #[test]
    fn derivatives_are_those_of_the_currents() {
        let draws = [
            AnyDraw::None,
            AnyDraw::Resistor(ResistiveDraw { resistance: 5e4, lockout: Some(LOCKOUT) }),
            AnyDraw::Current(CurrentDraw { current: 1e-5, lockout: LOCKOUT }),
            AnyDraw::Power(PowerDraw { power: 2e-5, lockout: LOCKOUT }),
        ];
        for draw in draws {
            for voltage in [0.4, 1.7, 2.0, 3.3] {
                let h = 1e-6;
                let slope = (draw.current(voltage + h) - draw.current(voltage - h)) / (2.0 * h);
                assert!((slope - draw.current_by_voltage(voltage)).abs() < 1e-12, "{draw:?} {voltage}");
            }
        }
        let power = PowerDraw { power: 2e-5, lockout: LOCKOUT };
        assert!((power.current(2.5) * 2.5 - 2e-5).abs() < 1e-20);
    }

    #[test]
    fn a_lock_out_without_hysteresis_and_power_from_an_empty_store_are_refused() {
        let power = |turn_on, turn_off| {
            PowerDraw { power: 1e-6, lockout: Lockout { turn_on, turn_off } }
                .check()
                .err()
                .map(|error: ParameterError<f64>| (error.field, error.value))
        };
        assert_eq!(power(3.0, 2.0), None);
        assert_eq!(power(2.0, 2.0), Some(("draw.turn_off", 2.0)));
        assert_eq!(power(2.0, 0.0), Some(("draw.turn_off", 0.0)));
        assert_eq!(power(-1.0, -2.0), Some(("draw.turn_on", -1.0)));
        let current = CurrentDraw { current: -1e-6, lockout: LOCKOUT }.check().err();
        assert_eq!(current.map(|error| error.field), Some("draw.current"));
    }
}
