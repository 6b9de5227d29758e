//! The tip mass.

use core::fmt::Debug;

use crate::bounds::ParameterError;
use crate::part::beam::{BeamMode, Cantilever, TipMass};
use crate::scalar::Scalar;

/// A tip mass or none: the modes of the beam, and the static moment at the clamp.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no tip mass",
    note = "write `.tip_mass(TipMass {{ mass, rotary_inertia, offset }})`, or leave `.tip_mass(..)` out"
)]
pub(crate) trait TipMassChoice<S: Scalar>: Copy + Debug + PartialEq {
    /// Mode `number` of the beam, from 1.
    fn mode(&self, beam: &Cantilever<S>, number: u32) -> BeamMode<S>;

    /// Static compliance in m/N at `place` of the modes after the first `kept`.
    fn residual_compliance(&self, beam: &Cantilever<S>, place: S, modes: u32) -> S;

    /// Moment in N·m at the clamp per negative base acceleration in m/s², of the mass of the beam, `beam_moment`, and of the tip mass.
    fn moment_at_clamp(&self, beam: &Cantilever<S>, beam_moment: S) -> S;

    /// Checks the tip mass for a beam.
    fn check(&self, beam: &Cantilever<S>) -> Result<(), ParameterError<S>>;
}

/// A free end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoTipMass;

impl<S: Scalar> TipMassChoice<S> for NoTipMass {
    #[inline]
    fn mode(&self, beam: &Cantilever<S>, number: u32) -> BeamMode<S> {
        beam.mode(number)
    }

    #[inline]
    fn residual_compliance(&self, beam: &Cantilever<S>, place: S, modes: u32) -> S {
        beam.residual_compliance(place, modes)
    }

    #[inline]
    fn moment_at_clamp(&self, _: &Cantilever<S>, beam_moment: S) -> S {
        beam_moment
    }

    #[inline]
    fn check(&self, _: &Cantilever<S>) -> Result<(), ParameterError<S>> {
        Ok(())
    }
}

impl<S: Scalar> TipMassChoice<S> for TipMass<S> {
    #[inline]
    fn mode(&self, beam: &Cantilever<S>, number: u32) -> BeamMode<S> {
        beam.mode_with(self, number)
    }

    #[inline]
    fn residual_compliance(&self, beam: &Cantilever<S>, place: S, modes: u32) -> S {
        beam.residual_compliance_with(self, place, modes)
    }

    #[inline]
    fn moment_at_clamp(&self, beam: &Cantilever<S>, beam_moment: S) -> S {
        beam_moment + self.mass * (beam.length + self.offset)
    }

    #[inline]
    fn check(&self, beam: &Cantilever<S>) -> Result<(), ParameterError<S>> {
        TipMass::check(self, beam)
    }
}

/// A tip mass chosen at run time. `None` gives the bits of [`NoTipMass`].
impl<S: Scalar> TipMassChoice<S> for Option<TipMass<S>> {
    fn mode(&self, beam: &Cantilever<S>, number: u32) -> BeamMode<S> {
        match self {
            Some(body) => body.mode(beam, number),
            None => NoTipMass.mode(beam, number),
        }
    }

    fn residual_compliance(&self, beam: &Cantilever<S>, place: S, modes: u32) -> S {
        match self {
            Some(body) => body.residual_compliance(beam, place, modes),
            None => NoTipMass.residual_compliance(beam, place, modes),
        }
    }

    fn moment_at_clamp(&self, beam: &Cantilever<S>, beam_moment: S) -> S {
        match self {
            Some(body) => body.moment_at_clamp(beam, beam_moment),
            None => beam_moment,
        }
    }

    fn check(&self, beam: &Cantilever<S>) -> Result<(), ParameterError<S>> {
        self.as_ref().map_or(Ok(()), |body| TipMassChoice::check(body, beam))
    }
}
