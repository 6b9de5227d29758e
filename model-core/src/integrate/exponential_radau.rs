//! Exponential Radau: the exact flow of a linear oscillator, with the three-stage Radau IIA method for its circuit.
//!
//! A split system ([`System::SPLIT`]) is a linear oscillator under the base acceleration and a weak force, and a
//! circuit whose equation is linear in its state once the motion is known:
//!
//! ```text
//! x'' + d x' + w (x − x0) = −κ a(t) + f(x, y)        inertia(x) y' + stiffness(x) (y − y₀) = drive(x)
//! ```
//!
//! One step:
//!
//! 1. The motion is predicted by the variation of constants with the force `f₀ + f₀' τ`, exact for the oscillator and
//!    the base acceleration ([`Kernel`]).
//! 2. The circuit is solved along the predicted motion by Radau IIA (Hairer and Wanner, Solving Ordinary Differential
//!    Equations II, section IV.5): fifth order, L-stable and stiffly accurate. The three stages are one linear system.
//! 3. The difference between the force at the stages and its prediction, a cubic that vanishes at the start, corrects
//!    the motion. The last stage of the circuit is solved again at the corrected end.
//!
//! The global error is of fourth order. A second pass of steps 2 and 3 makes it of fifth order; at equal cost the single
//! pass with shorter steps is more accurate.

mod stages;

use self::stages::{CUBIC, NODES, Path, Stages, corrects_energy, weighted};
use super::{Attempt, BoundaryLayer, Input, Method, NotConverged, Point, System, Trial};
use crate::clock::seconds_of_ticks;
use crate::oscillator::{Kernel, Oscillator, Response};
use crate::scalar::Scalar;

/// Index of the position in the state.
const POSITION: usize = 0;
/// Index of the velocity.
const VELOCITY: usize = 1;

/// The exact flow of a linear oscillator with the three-stage Radau IIA method for its circuit.
///
/// The global error is of fourth order. The cost of a step does not depend on the stiffness of the circuit. A step is at
/// most 0.9 radians of the oscillator long; under error control 0.8, or 0.9 to an event, and in double precision up to
/// half as much longer at tolerances from 1/15 to 0.1. A system must state its split form ([`System::SPLIT`]); without it this method does not compile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ExponentialRadau;

/// The change of the motion over a step.
#[derive(Debug, Clone, Copy)]
struct Change<S> {
    /// In m.
    displacement: S,
    /// In m/s.
    velocity: S,
}

impl<S: Scalar> Change<S> {
    const NONE: Self = Self { displacement: S::ZERO, velocity: S::ZERO };

    #[inline]
    fn and(self, other: Self) -> Self {
        Self {
            displacement: self.displacement + other.displacement,
            velocity: self.velocity + other.velocity,
        }
    }
}

/// The predicted motion of a step.
#[derive(Debug, Clone, Copy)]
pub struct Prediction<S> {
    oscillator: Oscillator<S>,
    step: S,
    /// The first of [`Kernel`]: all of them would be written to memory.
    ramps: [S; 4],
    response: Response<S>,
    /// The boundary layer at the start, and the rate of the circuit's state beyond it.
    layer: Option<BoundaryLayer<S>>,
    rate: S,
    /// The force per mass at the start, in m/s².
    force: S,
    /// Predicted change of the force over the step.
    rise: S,
    change: Change<S>,
}

impl<S: Scalar> Prediction<S> {
    /// The change of the motion by the difference between the force at the stages and its prediction: its linear part and the rest.
    #[inline(always)]
    fn corrections(&self, forces: &[S; 3]) -> [Change<S>; 2] {
        let Self { step, ramps: [zeroth, first, second, third], .. } = *self;
        let defect = |stage: usize| forces[stage] - self.force - S::from_f64(NODES[stage]) * self.rise;
        let defects = [defect(0), defect(1), forces[2] - self.force - self.rise];
        let [linear, quadratic, cubic] =
            [weighted(&CUBIC[0], &defects), weighted(&CUBIC[1], &defects), weighted(&CUBIC[2], &defects)];
        let (quadratic, cubic) = (quadratic + quadratic, S::from_f64(6.0) * cubic);
        let square = step * step;
        [
            Change { displacement: square * (first * linear), velocity: step * (zeroth * linear) },
            Change {
                displacement: square * (second * quadratic + third * cubic),
                velocity: step * (first * quadratic + second * cubic),
            },
        ]
    }

    /// The predicted motion, for a corrected energy with the acceleration at its end.
    #[inline]
    fn path<const N: usize, const P: usize>(&self, start: &Point<S, N, P>, is_corrected: bool) -> Path<S> {
        let end_acceleration = is_corrected.then(|| {
            let mut end = *start;
            end.state[POSITION] += self.change.displacement;
            end.state[VELOCITY] += self.change.velocity;
            self.end_acceleration(&end, self.force + self.rise)
        });
        Path::new(start, self.change, self.step, end_acceleration)
    }

    /// The acceleration in m/s² at the end of the step under a force per mass.
    ///
    /// With the remainder of the position: a small motion is a small difference of positions.
    #[inline]
    fn end_acceleration<const N: usize, const P: usize>(&self, end: &Point<S, N, P>, force: S) -> S {
        let Oscillator { stiffness, damping, rest, base_coupling } = self.oscillator;
        let Point { state, remainder, .. } = end;
        force
            - stiffness * ((state[POSITION] - rest) + remainder[POSITION])
            - damping * state[VELOCITY]
            - base_coupling * self.response.end
    }
}

impl<S: Scalar> Method<S> for ExponentialRadau {
    const ESTIMATES_ERROR: bool = true;
    const ESTIMATE_ORDER: i32 = 3;
    /// Fitted with the total of the stated errors by steps, sampling and impacts, which covers 97 % of random inputs:
    /// docs/energy.md. The coverage of the figure for the steps alone is not known.
    const ERROR_PER_ESTIMATE: f64 = 0.1;
    /// Two steps for a quarter of a period. A step to an event may be an eighth longer.
    const LONGEST_RADIANS: f64 = 0.8;
    const CARRIES_DERIVATIVES: bool = true;
    const PREDICTS: bool = true;

    type Prediction = Prediction<S>;

    #[inline]
    fn longest_step<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        angular_frequency: S,
    ) -> S {
        match system.oscillator() {
            Some(oscillator) => oscillator.longest_step(angular_frequency),
            None => S::INFINITY,
        }
    }

    #[inline(always)]
    fn predict<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
    ) -> Option<Prediction<S>> {
        let Attempt { start: Point { state, remainder, derivative, .. }, ref input, ticks, .. } = *attempt;
        let oscillator = system.oscillator()?;
        let step = seconds_of_ticks(ticks);
        let kernel = Kernel::new(&oscillator, step);
        let response = input.response(ticks, &kernel);
        let (layer, rate) = attempt.settled_rate(system);
        let mut settled = *derivative;
        settled[Y::CIRCUIT] = rate;
        let rise = step * system.force_rate(state, &settled);
        // The force less the restoring force: no difference of large numbers.
        let pull = derivative[VELOCITY]
            + oscillator.damping * state[VELOCITY]
            + oscillator.base_coupling * response.start;
        let Kernel { impulse, impulse_rate, ramps: [zeroth, first, second, third, ..], .. } = kernel;
        let velocity = state[VELOCITY];
        let change = Change {
            displacement: step * (impulse * velocity + step * (zeroth * pull + first * rise))
                - oscillator.base_coupling * response.displacement,
            velocity: impulse_rate * velocity + step * (impulse * pull + zeroth * rise)
                - oscillator.base_coupling * response.velocity,
        };
        let deflection = (state[POSITION] - oscillator.rest) + remainder[POSITION];
        let force = pull + oscillator.stiffness * deflection;
        let ramps = [zeroth, first, second, third];
        Some(Prediction { oscillator, step, ramps, response, layer, rate, force, rise, change })
    }

    #[inline]
    fn predicted_end<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        _system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
        prediction: &Prediction<S>,
    ) -> Point<S, N, P> {
        let Prediction { step, force, rise, change, .. } = prediction;
        let mut end = *attempt.start;
        end.state[POSITION] += change.displacement;
        end.state[VELOCITY] += change.velocity;
        end.state[Y::CIRCUIT] += *step * end.derivative[Y::CIRCUIT];
        end.derivative[POSITION] = end.state[VELOCITY];
        end.derivative[VELOCITY] = prediction.end_acceleration(&end, *force + *rise);
        end
    }

    #[inline(always)]
    fn attempt<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
        prediction: Option<&Prediction<S>>,
    ) -> Result<Trial<S, N, P>, NotConverged> {
        const {
            assert!(Y::SPLIT, "ExponentialRadau needs a system that states its split form");
            assert!(Y::CIRCUIT < N, "the circuit's state is one of the states");
        }
        let Attempt { start, ref input, ticks, .. } = *attempt;
        let step = seconds_of_ticks::<S>(ticks);
        if system.is_constant() {
            let energies = start.powers.map(|power| step * power);
            return Ok(Trial { end: *start, energies, error: S::ZERO, energy_error: S::ZERO, iterations: 1 });
        }
        let (mut change, mut force, mut error) = (Change::NONE, S::ZERO, S::ZERO);
        let mut doubt = [S::ZERO; N];
        let path = match prediction {
            Some(prediction) => prediction.path(start, corrects_energy(system)),
            None => Path::fixed(),
        };
        let mut stages = Stages::along(system, start, &path, step);
        if let Some(prediction) = prediction {
            let [slope, bend] = prediction.corrections(&stages.forces);
            change = prediction.change.and(slope).and(bend);
            force = stages.close(system, start, &change, step);
            stages.doubt(&mut doubt, &bend, force, step);
        }
        if !Y::LINEAR {
            doubt[Y::CIRCUIT] = stages.circuit_error;
        }
        if !Y::LINEAR || prediction.is_some() {
            error = system.error_norm(&start.state, &doubt);
        }

        let mut increments = [S::ZERO; N];
        increments[POSITION] = change.displacement;
        increments[VELOCITY] = change.velocity;
        increments[Y::CIRCUIT] = stages.changes[2];
        let mut end = start.advanced([S::ZERO; N], increments);
        if let Some(prediction) = prediction {
            end.derivative[POSITION] = end.state[VELOCITY];
            end.derivative[VELOCITY] = prediction.end_acceleration(&end, force);
        }
        end.derivative[Y::CIRCUIT] = stages.increments[2] / step;
        let ([first, last], settled) = match prediction {
            Some(Prediction { response, layer, rate, .. }) => {
                ([response.start, response.end], (*layer, *rate))
            }
            None => ([0, ticks].map(|offset| input.at(offset)), attempt.settled_rate(system)),
        };
        end.powers = system.powers(&end.state, &end.derivative, last);
        let (energies, energy_error) = stages.energies(system, attempt, &end, settled, first);
        let sum = end.state.iter().chain(&end.derivative).fold(error + energy_error, |sum, &term| sum + term);
        if !sum.is_finite() {
            return Err(NotConverged);
        }
        Ok(Trial { end, energies, error, energy_error, iterations: 1 })
    }
}
