//! The element that a rectifier charges: a storage capacitor, or a DC bus.
//!
//! ```text
//! C V' = i − V/R_leak − i_draw(V)
//! ```
//!
//! with the rectified current `i ≥ 0`.

use core::fmt::Debug;

use super::draw::{AnyDraw, Draw, HIGHEST_VOLTAGE, Lockout};
use crate::bounds::{ParameterError, bounded};
use crate::forward;
use crate::scalar::Scalar;

/// The storage behind a rectifier; the provided methods are those of a DC bus.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no storage element",
    label = "cannot be charged",
    note = "a bridge charges a `StorageCapacitor`, a `DcBus` or an `AnyStorage`",
    note = "a resistor across the storage is a draw: `StorageCapacitor {{ draw: ResistiveDraw {{ .. }}, .. }}`"
)]
pub trait StorageElement<S: Scalar>: Copy + Debug + PartialEq {
    /// Whether the voltage changes.
    const CHARGES: bool;
    /// Whether a lock-out can connect and disconnect the draw.
    const SWITCHES: bool;

    /// Whether the outflow is linear in the voltage.
    const LINEAR: bool;

    /// `1/C` in 1/F; 0 for a DC bus.
    fn elastance(&self) -> S;

    /// Capacitance in F; infinite for a DC bus.
    fn capacitance(&self) -> S;

    /// Voltage in V before the first step.
    fn initial_voltage(&self) -> S;

    /// Leakage current in A at a voltage in V, in proportion to it: without a draw the circuit is solved as linear.
    fn leakage(&self, voltage: S) -> S;

    /// Current in A into the connected draw, at a voltage in V.
    fn drawn(&self, voltage: S) -> S;

    /// Derivatives of leakage and draw by the voltage, in A/V.
    fn by_voltage(&self, voltage: S) -> [S; 2];

    /// The lock-out of the draw; `None` if the draw is always connected or absent.
    fn lockout(&self) -> Option<Lockout<S>>;

    /// Stored energy in J at a voltage in V; 0 for a DC bus, which has no energy balance.
    fn stored_energy(&self, voltage: S) -> S;

    /// Checks the parameters of the storage and its draw.
    ///
    /// # Errors
    /// The field, its value and its bounds.
    fn check(&self) -> Result<(), ParameterError<S>>;

    /// Outflow in A at a voltage in V: leakage, and the draw if it is connected.
    #[inline]
    fn outflow(&self, voltage: S, connected: bool) -> S {
        if connected { self.leakage(voltage) + self.drawn(voltage) } else { self.leakage(voltage) }
    }

    /// Derivative of the outflow by the voltage, in A/V.
    #[inline]
    fn outflow_by_voltage(&self, voltage: S, connected: bool) -> S {
        // Without a draw its derivative is not computed.
        let [leakage, drawn] =
            if connected { self.by_voltage(voltage) } else { [self.by_voltage(voltage)[0], S::ZERO] };
        if connected { leakage + drawn } else { leakage }
    }

    /// Whether the draw is connected before the first step: from the turn-on voltage.
    #[inline]
    fn starts_connected(&self) -> bool {
        self.lockout().is_none_or(|lockout| self.initial_voltage() >= lockout.turn_on)
    }
}

/// A capacitor with leakage: the storage element of a bridge and of an energy budget.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Capacitor<S> {
    /// Capacitance in F; 10⁻¹² to 10⁴ behind a bridge, 10⁻⁹ to 10⁵ in a budget.
    pub capacitance: S,
    /// Leakage resistance in Ω, infinity for no leakage; 10⁻³ or more behind a bridge, 1 or more in a budget.
    pub leakage_resistance: S,
}

/// A storage capacitor behind a bridge, with the draw of the node.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StorageCapacitor<S, D> {
    /// The capacitor.
    pub capacitor: Capacitor<S>,
    /// Voltage in V at the start, 0 to 10⁶.
    pub initial_voltage: S,
    /// The draw of the node.
    pub draw: D,
}

bounded! { StorageCapacitor<S, D>:
    "storage.capacitance" = capacitor.capacitance: 1e-12, 1e4;
    "storage.leakage_resistance" = capacitor.leakage_resistance: 1e-3, f64::INFINITY;
    "storage.initial_voltage" = initial_voltage: 0.0, HIGHEST_VOLTAGE;
}

impl<S: Scalar, D: Draw<S>> StorageElement<S> for StorageCapacitor<S, D> {
    const CHARGES: bool = true;
    const SWITCHES: bool = D::POSSIBLE;
    const LINEAR: bool = D::LINEAR;

    #[inline]
    fn elastance(&self) -> S {
        S::ONE / self.capacitor.capacitance
    }

    #[inline]
    fn capacitance(&self) -> S {
        self.capacitor.capacitance
    }

    #[inline]
    fn initial_voltage(&self) -> S {
        self.initial_voltage
    }

    #[inline]
    fn leakage(&self, voltage: S) -> S {
        voltage / self.capacitor.leakage_resistance
    }

    #[inline]
    fn drawn(&self, voltage: S) -> S {
        self.draw.current(voltage)
    }

    #[inline]
    fn by_voltage(&self, voltage: S) -> [S; 2] {
        [S::ONE / self.capacitor.leakage_resistance, self.draw.current_by_voltage(voltage)]
    }

    #[inline]
    fn lockout(&self) -> Option<Lockout<S>> {
        self.draw.lockout()
    }

    #[inline]
    fn stored_energy(&self, voltage: S) -> S {
        S::from_f64(0.5) * self.capacitor.capacitance * voltage * voltage
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        self.check_numbers()?;
        self.draw.check()
    }
}

/// A bus of constant voltage, such as a large battery.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DcBus<S> {
    /// Voltage in V, 0 to 10⁶.
    pub voltage: S,
}

bounded! { DcBus<S>: "bus.voltage" = voltage: 0.0, HIGHEST_VOLTAGE; }

impl<S: Scalar> StorageElement<S> for DcBus<S> {
    const CHARGES: bool = false;
    const SWITCHES: bool = false;
    const LINEAR: bool = true;

    #[inline]
    fn elastance(&self) -> S {
        S::ZERO
    }

    #[inline]
    fn capacitance(&self) -> S {
        S::INFINITY
    }

    #[inline]
    fn leakage(&self, _voltage: S) -> S {
        S::ZERO
    }

    #[inline]
    fn drawn(&self, _voltage: S) -> S {
        S::ZERO
    }

    #[inline]
    fn by_voltage(&self, _voltage: S) -> [S; 2] {
        [S::ZERO; 2]
    }

    #[inline]
    fn lockout(&self) -> Option<Lockout<S>> {
        None
    }

    #[inline]
    fn stored_energy(&self, _voltage: S) -> S {
        S::ZERO
    }

    #[inline]
    fn initial_voltage(&self) -> S {
        self.voltage
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        self.check_numbers()
    }
}

/// A capacitor or a bus, chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyStorage<S> {
    /// As [`StorageCapacitor`].
    Capacitor(StorageCapacitor<S, AnyDraw<S>>),
    /// As [`DcBus`].
    DcBus(DcBus<S>),
}

impl<S: Scalar> StorageElement<S> for AnyStorage<S> {
    const CHARGES: bool = true;
    const SWITCHES: bool = true;
    const LINEAR: bool = false;

    forward! {
        match { Self::Capacitor(capacitor) => capacitor, Self::DcBus(bus) => bus }
        #[inline] fn elastance(&self) -> S;
        #[inline] fn capacitance(&self) -> S;
        #[inline] fn initial_voltage(&self) -> S;
        #[inline] fn leakage(&self, voltage: S) -> S;
        #[inline] fn drawn(&self, voltage: S) -> S;
        #[inline] fn by_voltage(&self, voltage: S) -> [S; 2];
        #[inline] fn lockout(&self) -> Option<Lockout<S>>;
        #[inline] fn stored_energy(&self, voltage: S) -> S;
        fn check(&self) -> Result<(), ParameterError<S>>;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::draw::{NoDraw, PowerDraw};

    #[test]
    fn what_leaves_is_leakage_and_what_is_connected() {
        let draw = PowerDraw { power: 6e-6_f64, lockout: Lockout { turn_on: 3.0, turn_off: 2.0 } };
        let storage = StorageCapacitor {
            capacitor: Capacitor { capacitance: 1e-6, leakage_resistance: 1e6 },
            initial_voltage: 2.5,
            draw,
        };
        assert!(!storage.starts_connected());
        assert!((storage.outflow(2.0, false) - 2e-6).abs() < 1e-18);
        assert!((storage.outflow(2.0, true) - 5e-6).abs() < 1e-18);
        assert!((storage.outflow_by_voltage(2.0, true) + 0.5e-6).abs() < 1e-18);
        let sealed = StorageCapacitor {
            capacitor: Capacitor {
                leakage_resistance: f64::INFINITY,
                ..store_without_draw(&storage).capacitor
            },
            draw: NoDraw,
            ..store_without_draw(&storage)
        };
        assert_eq!((sealed.outflow(2.0, true), sealed.outflow_by_voltage(2.0, true)), (0.0, 0.0));
        assert!(sealed.starts_connected());
        assert_eq!(DcBus { voltage: 3.0 }.outflow(3.0, true), 0.0);
    }

    fn store_without_draw(storage: &StorageCapacitor<f64, PowerDraw<f64>>) -> StorageCapacitor<f64, NoDraw> {
        let StorageCapacitor {
            capacitor: Capacitor { capacitance, leakage_resistance },
            initial_voltage,
            draw: _,
        } = *storage;
        StorageCapacitor {
            capacitor: Capacitor { capacitance, leakage_resistance },
            initial_voltage,
            draw: NoDraw,
        }
    }

    #[test]
    fn parameters_out_of_bounds_are_named() {
        let good = StorageCapacitor {
            capacitor: Capacitor { capacitance: 1e-6, leakage_resistance: 1e9 },
            initial_voltage: 0.0,
            draw: NoDraw,
        };
        let field = |storage: StorageCapacitor<f64, NoDraw>| storage.check().err().map(|error| error.field);
        assert_eq!(field(good), None);
        assert_eq!(
            field(StorageCapacitor { capacitor: Capacitor { capacitance: 0.0, ..good.capacitor }, ..good }),
            Some("storage.capacitance")
        );
        assert_eq!(
            field(StorageCapacitor {
                capacitor: Capacitor { leakage_resistance: f64::NAN, ..good.capacitor },
                ..good
            }),
            Some("storage.leakage_resistance")
        );
        assert_eq!(
            field(StorageCapacitor { initial_voltage: -1.0, ..good }),
            Some("storage.initial_voltage")
        );
        assert_eq!(
            DcBus { voltage: f64::INFINITY }.check().err().map(|error| error.field),
            Some("bus.voltage")
        );
    }
}
