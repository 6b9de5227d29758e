//! The parasitic capacitance of leads and cables, in parallel with the load.

use crate::bounds::{ParameterError, bounded};
use crate::scalar::Scalar;

/// An optional parasitic capacitance; the provided method is that of none.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no parasitic capacitance",
    note = "write `.parasitic(ParasiticCapacitance {{ .. }})`, or leave `.parasitic(..)` out"
)]
pub(crate) trait Parasitic<S: Scalar>: Copy + core::fmt::Debug + PartialEq {
    /// Whether the equations contain the parasitic capacitance.
    const PRESENT: bool;

    /// Capacitance in F.
    #[inline]
    fn capacitance(&self) -> S {
        S::ZERO
    }

    /// Refuses a capacitance out of its bounds.
    fn check(&self) -> Result<(), ParameterError<S>> {
        ParasiticCapacitance { capacitance: self.capacitance() }.check_numbers()
    }
}

/// No parasitic capacitance: the equations have no such term, and a step no division for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoParasitic;

impl<S: Scalar> Parasitic<S> for NoParasitic {
    const PRESENT: bool = false;
}

/// A capacitance in parallel with the load; zero is allowed and gives the bits of [`NoParasitic`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParasiticCapacitance<S> {
    /// Capacitance in F.
    pub capacitance: S,
}

bounded! { ParasiticCapacitance<S>: "parasitic_capacitance" = capacitance: 0.0, 1e-3; }

impl<S: Scalar> Parasitic<S> for ParasiticCapacitance<S> {
    const PRESENT: bool = true;

    #[inline]
    fn capacitance(&self) -> S {
        self.capacitance
    }
}
