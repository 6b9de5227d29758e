//! The stop.

use core::fmt::Debug;

use super::contact_law::{ContactLaw, NoStop, ResidualFlexibility};
use crate::bounds::{Bounds, ParameterError, bounded};
use crate::part::rod::Rod;
use crate::scalar::Scalar;

/// A stop or none.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no stop",
    note = "write `.stop(Stop {{ .., contact: ResidualFlexibility }})`, or leave `.stop(..)` out"
)]
pub(crate) trait StopChoice<S: Scalar>: Copy + Debug + PartialEq {
    type Contact: ContactLaw<S>;

    fn contact(&self) -> Self::Contact;

    /// The stop; `None` without one.
    fn stop(&self) -> Option<Stop<S, Self::Contact>>;
}

impl<S: Scalar> StopChoice<S> for NoStop {
    type Contact = Self;

    #[inline]
    fn contact(&self) -> Self {
        *self
    }

    #[inline]
    fn stop(&self) -> Option<Stop<S, Self>> {
        None
    }
}

/// A rod on the base with its free face next to the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stop<S, C = ResidualFlexibility> {
    /// Length of the rod in m, 10⁻⁴ to 10.
    pub length: S,
    /// Cross section of the rod in m², 10⁻¹² to 1.
    pub section: S,
    /// Young's modulus of the rod in Pa, 10⁵ to 10¹⁵.
    pub young_modulus: S,
    /// Density of the rod in kg/m³, 1 to 10⁵.
    pub density: S,
    /// Position `X_c` of the contact in m from the clamp, 10⁻⁴ to the length of the beam.
    pub position: S,
    /// Distance `Δ` of beam and rod at rest in m, 0 to 1.
    pub gap: S,
    /// Compliance of the contact itself in m/N, 0 to 1, in series with that of the omitted modes.
    pub contact_compliance: S,
    /// The contact law.
    pub contact: C,
}

impl<S: Scalar, C: ContactLaw<S>> StopChoice<S> for Stop<S, C> {
    type Contact = C;

    #[inline]
    fn contact(&self) -> C {
        self.contact
    }

    #[inline]
    fn stop(&self) -> Option<Self> {
        Some(*self)
    }
}

bounded! { Stop<S, C>:
    "stop.length" = length: 1e-4, 10.0;
    "stop.section" = section: 1e-12, 1.0;
    "stop.young_modulus" = young_modulus: 1e5, 1e15;
    "stop.density" = density: 1.0, 1e5;
    "stop.gap" = gap: 0.0, 1.0;
    "stop.contact_compliance" = contact_compliance: 0.0, 1.0;
}

impl<S: Scalar, C: ContactLaw<S>> Stop<S, C> {
    /// The rod for axial modes.
    pub(super) fn rod(&self) -> Rod<S> {
        Rod {
            length: self.length,
            axial_stiffness: self.young_modulus * self.section,
            mass_per_length: self.density * self.section,
        }
    }

    /// Checks the stop for a beam of the length `beam_length` in m.
    #[inline]
    pub(super) fn check(&self, beam_length: S) -> Result<(), ParameterError<S>> {
        self.check_numbers()?;
        Bounds { lowest: S::from_f64(1e-4), highest: beam_length }.check("stop.position", self.position)?;
        self.contact.check()
    }
}
