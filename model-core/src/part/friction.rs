//! Coulomb friction of a slider on two patches.

use core::fmt::Debug;

use crate::bounds::{Bounds, ParameterError, bounded};
use crate::scalar::Scalar;

/// A law of dry friction; the provided methods are those without friction.
///
/// A part `active` (0 to 1) of the slider's face rests on the active patch and the remainder on the inert
/// patch. Each patch has its own coefficients; the friction coefficient of the pair is their mean, weighted
/// by the parts (equations (5) and (11) of Fu, Ouyang and Davis 2020).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no law of friction",
    note = "a law of friction is a `PatchFriction` or `Frictionless`"
)]
pub(crate) trait Friction<S: Scalar>: Copy + Debug + PartialEq {
    /// Whether there is friction; if not, the code for reversals and sticking is not compiled.
    const PRESENT: bool;

    /// Coefficient of static friction with the part `active` on the active patch.
    #[inline]
    fn static_coefficient(&self, _active: S) -> S {
        S::ZERO
    }

    /// Coefficient of kinetic friction with the part `active` on the active patch.
    #[inline]
    fn kinetic_coefficient(&self, _active: S) -> S {
        S::ZERO
    }

    /// Derivative of the kinetic coefficient by the part on the active patch.
    #[inline]
    fn kinetic_by_share(&self) -> S {
        S::ZERO
    }

    /// Checks the parameters of the law.
    ///
    /// # Errors
    /// The first parameter outside its bounds.
    fn check(&self) -> Result<(), ParameterError<S>> {
        Ok(())
    }
}

/// Coulomb friction with static and kinetic coefficients on an active patch (the charged electrode) and an
/// inert patch.
///
/// On each patch the kinetic coefficient must not exceed the static one. Otherwise kinetic friction would
/// push back a slider that overcomes static friction, and no mode would be consistent.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PatchFriction<S> {
    /// `μ_s1`, static, active patch, 0 to 10.
    pub static_active: S,
    /// `μ_s2`, static, inert patch, 0 to 10.
    pub static_inert: S,
    /// `μ_k1`, kinetic, active patch, 0 to `static_active`.
    pub kinetic_active: S,
    /// `μ_k2`, kinetic, inert patch, 0 to `static_inert`.
    pub kinetic_inert: S,
}

bounded! { PatchFriction<S>:
    "static_friction_active" = static_active: 0.0, 10.0;
    "static_friction_inert" = static_inert: 0.0, 10.0;
}

impl<S: Scalar> Friction<S> for PatchFriction<S> {
    const PRESENT: bool = true;

    #[inline]
    fn static_coefficient(&self, active: S) -> S {
        self.static_inert + (self.static_active - self.static_inert) * active
    }

    #[inline]
    fn kinetic_coefficient(&self, active: S) -> S {
        self.kinetic_inert + self.kinetic_by_share() * active
    }

    #[inline]
    fn kinetic_by_share(&self) -> S {
        self.kinetic_active - self.kinetic_inert
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        self.check_numbers()?;
        let up_to = |highest: S| Bounds { lowest: S::ZERO, highest };
        up_to(self.static_active).check("kinetic_friction_active", self.kinetic_active)?;
        up_to(self.static_inert).check("kinetic_friction_inert", self.kinetic_inert)
    }
}

/// No friction: a reversal is not an event, and the slider does not stick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frictionless;

impl<S: Scalar> Friction<S> for Frictionless {
    const PRESENT: bool = false;
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATCHES: PatchFriction<f64> =
        PatchFriction { static_active: 0.35, static_inert: 0.25, kinetic_active: 0.30, kinetic_inert: 0.20 };

    #[test]
    fn coefficients_are_weighed_by_the_shares() {
        assert_eq!(PATCHES.static_coefficient(1.0), 0.35);
        assert_eq!(PATCHES.static_coefficient(0.0), 0.25);
        assert!((PATCHES.kinetic_coefficient(0.25) - (0.25 * 0.30 + 0.75 * 0.20)).abs() < 1e-15);
        let slope = (PATCHES.kinetic_coefficient(0.7) - PATCHES.kinetic_coefficient(0.6)) / 0.1;
        assert!((slope - PATCHES.kinetic_by_share()).abs() < 1e-13);
    }

    #[test]
    fn kinetic_friction_above_static_is_refused_on_each_patch() {
        let refused = |friction: PatchFriction<f64>| friction.check().err().map(|error| error.field);
        assert_eq!(refused(PATCHES), None);
        assert_eq!(
            refused(PatchFriction { kinetic_active: 0.36, ..PATCHES }),
            Some("kinetic_friction_active")
        );
        assert_eq!(refused(PatchFriction { kinetic_inert: 0.26, ..PATCHES }), Some("kinetic_friction_inert"));
        assert_eq!(refused(PatchFriction { static_inert: -0.1, ..PATCHES }), Some("static_friction_inert"));
        assert_eq!(
            refused(PatchFriction { static_active: f64::NAN, ..PATCHES }),
            Some("static_friction_active")
        );
    }
}
