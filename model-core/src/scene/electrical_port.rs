//! A triboelectric harvester as a circuit element at its open terminals.
//!
//! At a fixed position the terminal voltage is linear in the charge that has passed the terminals, `∂V/∂Q < 0`: the
//! harvester is a voltage source in series with a capacitance, both functions of the position.

use core::fmt::Debug;

use crate::observer::ALL_POWERS;
use crate::part::load::Resistance;
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::scene::coupled::{Derivatives, STATES};

/// Terminal voltage and its derivatives by position and charge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PortVoltage<S> {
    /// `V` in V.
    pub value: S,
    /// `∂V/∂x` in V/m.
    pub by_position: S,
    /// `∂V/∂Q` in V per charge unit, below 0, independent of the charge.
    pub by_charge: S,
    /// `∂²V/∂x²` in V/m².
    pub curvature: S,
    /// `∂²V/∂x∂Q` in V/m per charge unit, independent of the charge.
    pub by_both: S,
    /// The larger of the two terms whose difference is `V`, in V: it scales the rounding error of `V`.
    pub magnitude: S,
}

/// A triboelectric harvester of three states, position, velocity and charge, for a circuit at its terminals.
///
/// Implemented by [`crate::scene::contact_separation::ContactSeparation`] and [`crate::scene::sliding::Sliding`]; it
/// cannot be implemented outside this crate. The guards of a mode that is no stick read position and velocity alone.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be put behind a bridge by `Rectified`",
    note = "a triboelectric harvester can, once built with `OpenCircuit` as its load",
    note = "a bump-stop harvester takes its bridge as a part: `bump_stop::Choices::behind(bridge)`"
)]
pub trait ElectricalPort<S: Scalar>: Scene<S, 3, 0> + Copy + Debug + PartialEq {
    /// The harvester's own load.
    fn resistance(&self) -> Resistance<S>;

    /// Charge in C per charge unit of the state.
    fn coulombs(&self) -> S;

    /// Typical terminal voltage in V due to the harvester's own charge.
    fn typical_voltage(&self) -> S;

    /// The voltage at the terminals.
    fn port_voltage(&self, mode: Self::Mode, position: S, charge: S) -> PortVoltage<S>;

    /// Whether the moving part sticks in `mode`.
    fn is_stick(&self, mode: Self::Mode) -> bool;

    /// Whether the charge is frozen in `mode`; the terminals then count as open, with zero voltage.
    fn charge_is_frozen(&self, mode: Self::Mode) -> bool;

    /// Whether no guard of `mode` is zero to rounding at a state, so that the guards can be watched.
    fn is_clear(&self, mode: Self::Mode, state: &[S; STATES]) -> bool;

    /// Derivatives of force and current for a moving position.
    fn derivatives(&self, mode: Self::Mode, state: &[S; STATES]) -> Derivatives<S>;

    /// All powers with open terminals; see [`crate::observer::PowerIndex`].
    fn all_powers(&self, mode: Self::Mode, state: &[S; STATES], acceleration: S) -> [S; ALL_POWERS];
}

/// The items of [`ElectricalPort`] that both scenes have in common.
macro_rules! port_items {
    () => {
        #[inline]
        fn resistance(&self) -> $crate::part::load::Resistance<S> {
            self.load.resistance()
        }

        #[inline]
        fn is_stick(&self, mode: Mode) -> bool {
            matches!(mode, Mode::Stick)
        }

        #[inline]
        fn coulombs(&self) -> S {
            self.charge_unit
        }

        #[inline]
        fn derivatives(&self, mode: Mode, state: &[S; STATES]) -> $crate::scene::coupled::Derivatives<S> {
            Flow::new(self, mode).derivatives(state)
        }

        #[inline]
        fn all_powers(
            &self,
            mode: Mode,
            state: &[S; STATES],
            acceleration: S,
        ) -> [S; $crate::observer::ALL_POWERS] {
            // Of the rates, only the current in a resistor enters the powers.
            Flow::new(self, mode).all_powers(state, &[S::ZERO; STATES], acceleration)
        }
    };
}
pub(super) use port_items;
