//! The contact laws of beam and rod.

use core::fmt::Debug;

use crate::bounds::{ParameterError, bounded};
use crate::scalar::Scalar;

/// The numerical method of a contact law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ContactKind<S> {
    /// No stop.
    None,
    /// A massless spring between the modes: the discrete gradient of its potential.
    Compliant,
    /// The gap is set to zero at the end of each step.
    Constrained,
    /// Impacts between the modes with a coefficient of restitution.
    Impulsive {
        /// The coefficient, 0 to 1.
        restitution: S,
    },
}

/// A law of contact.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no law of contact",
    note = "a law of contact is `ResidualFlexibility`, a `Restitution`, `DisplacementConstraint` or an `AnyContact`"
)]
pub(crate) trait ContactLaw<S: Scalar>: Copy + Debug + PartialEq {
    /// Whether there is a stop; if not, its code is not compiled.
    const POSSIBLE: bool = true;

    /// The numerical method.
    fn kind(&self) -> ContactKind<S>;

    /// Checks the parameters of the law.
    ///
    /// # Errors
    /// The first parameter outside its bounds.
    fn check(&self) -> Result<(), ParameterError<S>> {
        match self.kind() {
            ContactKind::Impulsive { restitution } => {
                Restitution { coefficient: restitution }.check_numbers()
            }
            ContactKind::None | ContactKind::Compliant | ContactKind::Constrained => Ok(()),
        }
    }
}

/// No stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoStop;

impl<S: Scalar> ContactLaw<S> for NoStop {
    const POSSIBLE: bool = false;

    #[inline]
    fn kind(&self) -> ContactKind<S> {
        ContactKind::None
    }
}

/// Contact through the static compliance of the omitted modes, in series with the compliance of the contact itself
/// (MacNeal's residual flexibility).
///
/// Beam and rod touch through a massless boundary, so there is no impulse and no coefficient of restitution, and the
/// static stiffness is correct for every number of modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ResidualFlexibility;

impl<S: Scalar> ContactLaw<S> for ResidualFlexibility {
    #[inline]
    fn kind(&self) -> ContactKind<S> {
        ContactKind::Compliant
    }
}

/// Impacts between the kept modes: `ġ⁺ = −e ġ⁻`.
///
/// The coefficient multiplies an effective mass that falls with the number of modes, and is not a material property.
/// An impact slower than 10⁻⁵ m/s closes the contact. It stays closed while a compressive force is needed to keep the
/// gap at zero at the end of each step; this force does no work.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Restitution<S> {
    /// Coefficient of restitution `e`, 0 to 1.
    pub coefficient: S,
}

bounded! { Restitution<S>: "restitution" = coefficient: 0.0, 1.0; }

impl<S: Scalar> ContactLaw<S> for Restitution<S> {
    #[inline]
    fn kind(&self) -> ContactKind<S> {
        ContactKind::Impulsive { restitution: self.coefficient }
    }
}

/// The paper's method: the force that makes the gap zero at the end of each step, if compressive; equations (8) and
/// (9) with one constant force per step.
///
/// It is stable, but the force is an artefact of the step length: its peaks and the number of contacts grow without
/// bound as the step shrinks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DisplacementConstraint;

impl<S: Scalar> ContactLaw<S> for DisplacementConstraint {
    #[inline]
    fn kind(&self) -> ContactKind<S> {
        ContactKind::Constrained
    }
}

/// A contact law chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyContact<S> {
    /// As [`NoStop`].
    NoStop,
    /// As [`ResidualFlexibility`].
    ResidualFlexibility,
    /// As [`Restitution`].
    Restitution(Restitution<S>),
    /// As [`DisplacementConstraint`].
    DisplacementConstraint,
}

impl<S: Scalar> ContactLaw<S> for AnyContact<S> {
    fn kind(&self) -> ContactKind<S> {
        match self {
            Self::NoStop => ContactKind::None,
            Self::ResidualFlexibility => ContactKind::Compliant,
            Self::Restitution(law) => law.kind(),
            Self::DisplacementConstraint => ContactKind::Constrained,
        }
    }
}
