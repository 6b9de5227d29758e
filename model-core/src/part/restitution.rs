//! The coefficient of restitution of an impact.

use core::marker::PhantomData;

use crate::bounds::{ParameterError, parameters};
use crate::forward;
use crate::scalar::{Mathematics, Polynomial, Scalar};
use crate::snapshot::Fingerprint;

/// A law of restitution: the ratio of the speed after an impact to the speed before it.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no law of restitution",
    note = "a law of restitution is a `ConstantRestitution`, a `VelocityDependentRestitution` or an `AnyRestitution`"
)]
pub trait Restitution<S: Scalar>: Copy + core::fmt::Debug + PartialEq {
    /// The coefficient at an impact speed in m/s, at or above zero.
    fn coefficient(&self, speed: S) -> S;

    /// Refuses the first parameter of the law that is out of its bounds.
    ///
    /// # Errors
    /// The parameter, its value and its bounds.
    fn check(&self) -> Result<(), ParameterError<S>>;

    /// Takes the names and the values of the law's parameters into a fingerprint.
    fn identify(&self, fingerprint: &mut Fingerprint);
}

parameters! { $ constant_restitution_numbers "restitution."
/// Newton's law: one coefficient for every speed, 0 (no rebound) to 1 (no loss).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConstantRestitution<S> {
    { coefficient "`e`": coefficient "1" 0.0..=1.0 "Coefficient of restitution"; }
} }

impl<S: Scalar> Restitution<S> for ConstantRestitution<S> {
    #[inline]
    fn coefficient(&self, _speed: S) -> S {
        self.coefficient
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        self.check_numbers()
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name(Self::BOUNDS[0].0);
        fingerprint.numbers(&[self.coefficient]);
    }
}

parameters! { $ variable_restitution_numbers "restitution."
/// A coefficient that falls with the impact speed: `e(v) = e_∞ + (e_0 − e_∞) exp(−v / v_ref)`.
///
/// The measured law of equation (21) of Fu, Ouyang and Davis (2020) is missing from the available copy;
/// this form has its limits at rest and at high speed as parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VelocityDependentRestitution<S, M = Polynomial> {
    {
        at_rest "`e_0`": at_rest "1" 0.0..=1.0 "Coefficient in the limit of no speed";
        at_speed "`e_∞`": at_speed "1" 0.0..=1.0 "Coefficient in the limit of high speed";
        reference_speed "`v_ref`": reference_speed_m_per_s "m/s" 1e-9..=1e3
            "Speed over which the coefficient falls by a factor e";
    }
    /// The elementary functions for the exponential.
    pub mathematics: PhantomData<M>,
} }

impl<S: Scalar, M: Mathematics<S>> Restitution<S> for VelocityDependentRestitution<S, M> {
    #[inline]
    fn coefficient(&self, speed: S) -> S {
        self.at_speed + (self.at_rest - self.at_speed) * M::exponential(-speed / self.reference_speed)
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        self.check_numbers()
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        for ((name, _), value) in Self::BOUNDS.iter().zip([self.at_rest, self.at_speed, self.reference_speed])
        {
            fingerprint.name(name);
            fingerprint.numbers(&[value]);
        }
    }
}

/// A law of restitution chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyRestitution<S, M = Polynomial> {
    /// One coefficient for every speed.
    Constant(ConstantRestitution<S>),
    /// A coefficient that falls with the speed.
    VelocityDependent(VelocityDependentRestitution<S, M>),
}

impl<S: Scalar, M: Mathematics<S>> Restitution<S> for AnyRestitution<S, M> {
    forward! {
        match { Self::Constant(law) => law, Self::VelocityDependent(law) => law }
        fn coefficient(&self, speed: S) -> S;
        fn check(&self) -> Result<(), ParameterError<S>>;
        fn identify(&self, fingerprint: &mut Fingerprint);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_velocity_dependent_law_has_its_limits() {
        let law = VelocityDependentRestitution::<f64> {
            at_rest: 0.8,
            at_speed: 0.5,
            reference_speed: 0.3,
            mathematics: PhantomData,
        };
        assert!((law.coefficient(0.0) - 0.8).abs() < 1e-15);
        assert!((law.coefficient(1e6) - 0.5).abs() < 1e-15);
        assert!((law.coefficient(0.3) - (0.5 + 0.3 / core::f64::consts::E)).abs() < 1e-15);
    }
}
