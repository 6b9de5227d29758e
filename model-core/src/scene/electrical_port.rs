//! What a circuit behind the open terminals of a triboelectric harvester needs to know of it.
//!
//! At a position the voltage at the terminals is linear in the charge that has passed them, `∂V/∂Q < 0`:
//! the harvester is a voltage source behind a capacitance, both of which depend on the position.

use core::fmt::Debug;

use crate::observer::ALL_POWERS;
use crate::part::load::Resistance;
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::scene::coupled::{Derivatives, STATES};

/// Voltage at the terminals, and how it changes with position and charge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PortVoltage<S> {
    /// `V` in volts.
    pub value: S,
    /// `∂V/∂x` in V/m.
    pub by_position: S,
    /// `∂V/∂Q` in volts per charge unit, below 0: the same at every charge.
    pub by_charge: S,
    /// `∂²V/∂x²` in V/m².
    pub curvature: S,
    /// `∂²V/∂x∂Q` in V/m per charge unit: the same at every charge.
    pub by_both: S,
    /// The largest of the terms whose difference `V` is, in volts: its roundings are roundings of this.
    pub magnitude: S,
}

/// A triboelectric harvester of three states, position, velocity and charge, as a circuit at its terminals
/// sees it.
///
/// Implemented by [`crate::scene::contact_separation::ContactSeparation`] and
/// [`crate::scene::sliding::Sliding`]; some of it can only be written inside this crate.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be put behind a bridge by `Rectified`",
    note = "a triboelectric harvester can, once built with `OpenCircuit` as its load",
    note = "a bump-stop harvester takes its bridge as a part: `bump_stop::Choices::behind(bridge)`"
)]
pub trait ElectricalPort<S: Scalar>: Scene<S, 3, 0> + Copy + Debug + PartialEq {
    /// The harvester's own load.
    fn resistance(&self) -> Resistance<S>;

    /// Coulombs per unit of the state's charge.
    fn coulombs(&self) -> S;

    /// A voltage in V of the size that the harvester's own charge makes at its terminals.
    fn typical_voltage(&self) -> S;

    /// The voltage at the terminals.
    fn port_voltage(&self, mode: Self::Mode, position: S, charge: S) -> PortVoltage<S>;

    /// Whether the charge stays as it is in `mode`, the terminals being taken as open and without voltage.
    fn charge_is_frozen(&self, mode: Self::Mode) -> bool;

    /// Whether the guards of `mode` can be watched from a state, none of them being zero to rounding.
    fn is_clear(&self, mode: Self::Mode, state: &[S; STATES]) -> bool;

    /// Derivatives of the force where the position moves.
    fn derivatives(&self, mode: Self::Mode, state: &[S; STATES]) -> Derivatives<S>;

    /// The whole account of powers with the terminals open; see [`crate::observer::PowerIndex`].
    fn all_powers(&self, mode: Self::Mode, state: &[S; STATES], acceleration: S) -> [S; ALL_POWERS];
}
