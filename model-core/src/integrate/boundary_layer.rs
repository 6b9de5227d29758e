//! The boundary layer of a circuit that is much faster than the motion.

use super::{Point, System};
use crate::scalar::{Mathematics, Scalar, add_increment, zip_with};

/// Roundings of the state within which a rate counts as settled.
const ROUNDINGS: f64 = 4.0;
/// Largest change of the circuit within a thin layer, relative.
const THIN: f64 = 1e-3;

/// The fast part of a circuit's response to a disturbance: the rate of its state relaxes to the rate at which the state
/// follows the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryLayer<S> {
    /// Rate of the relaxation in 1/s.
    pub relaxation: S,
    /// The rate of the circuit's state that follows the motion.
    pub following: S,
    /// The scale of the state, whose rounding disturbs the rate.
    pub scale: S,
}

impl<S: Scalar> BoundaryLayer<S> {
    /// What a rate exceeds `following` by; 0 if that is no more than the rounding of the state.
    #[inline]
    pub(crate) fn excess(&self, rate: S) -> S {
        let excess = rate - self.following;
        let rounding = S::EPSILON * S::from_f64(ROUNDINGS) * self.scale * self.relaxation;
        if excess.abs() > rounding { excess } else { S::ZERO }
    }

    /// The rate with which a step of `step` s starts, from the rate `before` just after a disturbance.
    ///
    /// A step `h` much longer than the layer starts with the rate beyond the layer. The weight of `following` is of third
    /// order in `h · relaxation / 10`, so that both limits are exact.
    #[inline]
    pub(crate) fn settled(&self, before: S, step: S) -> S {
        let thickness = S::from_f64(0.1) * step * self.relaxation;
        let weight = thickness * thickness * thickness;
        // Above this weight `before` is negligible, and the weight might overflow.
        if weight > S::from_f64(1e9) {
            self.following
        } else {
            (before + weight * self.following) / (S::ONE + weight)
        }
    }
}

/// The layer of a step that begins with a jump, taken out of the step.
///
/// The motion does not move within it: the rate exceeds the one that follows the motion by `e exp(−λ τ)`. The charge that
/// this carries and its energy have a closed form, and the step begins with the rate beyond the layer.
pub(crate) struct ThinLayer<S> {
    /// `e`.
    excess: S,
    /// `λ` in 1/s.
    relaxation: S,
    following: S,
}

/// The start of a step after a jump without its boundary layer; `None` unless the layer is thin.
#[cold]
#[inline(never)]
pub(crate) fn without_layer<S: Scalar, const N: usize, const P: usize, Y: System<S, N, P>>(
    system: &Y,
    start: &Point<S, N, P>,
    input: S,
) -> Option<(Point<S, N, P>, ThinLayer<S>)> {
    let layer = system.boundary_layer(&start.state)?;
    let BoundaryLayer { relaxation, following, .. } = layer;
    let rate = start.derivative[Y::CIRCUIT];
    let mut moves = start.derivative;
    moves[Y::CIRCUIT] = S::ZERO;
    let after = zip_with(start.state, &moves, |state, rate| state + *rate / relaxation);
    let later = system.boundary_layer(&after)?;
    let limit = S::from_f64(THIN);
    let is_thin = (later.relaxation - relaxation).abs() <= limit * relaxation
        && (later.following - following).abs() <= limit * following.abs().max(rate.abs());
    if !is_thin {
        return None;
    }
    let excess = layer.excess(rate);
    let mut outside = *start;
    let charge = excess / relaxation;
    (outside.state[Y::CIRCUIT], outside.remainder[Y::CIRCUIT]) =
        add_increment(start.state[Y::CIRCUIT], start.remainder[Y::CIRCUIT], charge);
    outside.derivative[Y::CIRCUIT] = following;
    outside.powers = system.powers(&outside.state, &outside.derivative, input);
    Some((outside, ThinLayer { excess, relaxation, following }))
}

impl<S: Scalar> ThinLayer<S> {
    /// Adds the layer to the end of a step of `step` s and to the integrals over it.
    #[cold]
    #[inline(never)]
    pub(crate) fn restore<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        step: S,
        input: S,
        end: &mut Point<S, N, P>,
        energies: &mut [S; P],
    ) {
        let Self { excess, relaxation, following } = *self;
        let left = S::Build::exponential(-(step * relaxation));
        let change = excess / relaxation * (S::ONE - left);
        let square = change * (S::from_f64(0.5) * excess * (S::ONE + left) + following + following);
        let added = system.quadratic_energies(square).into_iter().zip(system.linear_energies(change));
        for (energy, (quadratic, linear)) in energies.iter_mut().zip(added) {
            *energy += quadratic + linear;
        }
        if left > S::ZERO {
            let remaining = -(excess / relaxation) * left;
            (end.state[Y::CIRCUIT], end.remainder[Y::CIRCUIT]) =
                add_increment(end.state[Y::CIRCUIT], end.remainder[Y::CIRCUIT], remaining);
            end.derivative[Y::CIRCUIT] += excess * left;
            end.powers = system.powers(&end.state, &end.derivative, input);
        }
    }
}
