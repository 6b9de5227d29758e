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

use super::{Attempt, CircuitEquation, Input, Method, NotConverged, Point, System, Trial};
use crate::clock::seconds_of_ticks;
use crate::oscillator::{Kernel, Oscillator, Response};
use crate::scalar::{Mathematics, Scalar, add_increment};

/// Index of the position in the state.
const POSITION: usize = 0;
/// Index of the velocity.
const VELOCITY: usize = 1;

const ROOT_SIX: f64 = 2.449_489_742_783_178_098_2;
/// The nodes of Radau IIA.
const NODES: [f64; 3] = [(4.0 - ROOT_SIX) / 10.0, (4.0 + ROOT_SIX) / 10.0, 1.0];
/// The matrix of Radau IIA; its last row is the quadrature.
const STAGES: [[f64; 3]; 3] = [
    [(88.0 - 7.0 * ROOT_SIX) / 360.0, (296.0 - 169.0 * ROOT_SIX) / 1800.0, (3.0 * ROOT_SIX - 2.0) / 225.0],
    [(296.0 + 169.0 * ROOT_SIX) / 1800.0, (88.0 + 7.0 * ROOT_SIX) / 360.0, (-3.0 * ROOT_SIX - 2.0) / 225.0],
    [(16.0 - ROOT_SIX) / 36.0, (16.0 + ROOT_SIX) / 36.0, 1.0 / 9.0],
];

/// Coefficients of 1, θ and θ² of the parabola that is 1 at node `i` and 0 at the other two.
const fn lagrange(i: usize) -> [f64; 3] {
    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
    let scale = 1.0 / ((NODES[i] - NODES[j]) * (NODES[i] - NODES[k]));
    [NODES[j] * NODES[k] * scale, -(NODES[j] + NODES[k]) * scale, scale]
}
const LAGRANGE: [[f64; 3]; 3] = [lagrange(0), lagrange(1), lagrange(2)];

/// Weights of the stages in the coefficients of θ, θ² and θ³ of the cubic that vanishes at the start.
const CUBIC: [[f64; 3]; 3] = {
    let mut weights = [[0.0; 3]; 3];
    let mut i = 0;
    while i < 9 {
        weights[i / 3][i % 3] = LAGRANGE[i % 3][i / 3] / NODES[i % 3];
        i += 1;
    }
    weights
};
/// Weights of the stages in the parabola through them, at the start.
const AT_START: [f64; 3] = [LAGRANGE[0][0], LAGRANGE[1][0], LAGRANGE[2][0]];

/// Part of the difference between the power at the start and its extrapolation from the stages that estimates the error
/// of the energy of a step.
const ENERGY_ERROR_PART: f64 = 0.05;
/// Part of the correction of the motion that estimates the error of the corrected motion.
const MOTION_ERROR_PART: f64 = 1.0 / 16.0;
/// Weights of a change of the force at the end, times `h²` and `h`, in the displacement and the velocity that a further
/// pass would add.
const NEXT_PASS: [f64; 2] = [1.0 / 12.0, 1.0 / 4.0];

/// The exact flow of a linear oscillator with the three-stage Radau IIA method for its circuit.
///
/// The global error is of fourth order. The cost of a step does not depend on the stiffness of the circuit. A step is at
/// most 0.8 radians of the oscillator long, or 0.9 to an event. A system must state its split form ([`System::SPLIT`]); without it this
/// method does not compile.
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

    #[inline(always)]
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
    kernel: Kernel<S>,
    response: Response<S>,
    /// The rate of the circuit's state at the start, beyond a boundary layer.
    rate: S,
    /// The force per mass at the start, in m/s².
    force: S,
    /// Predicted change of the force over the step.
    rise: S,
    change: Change<S>,
}

/// The displacement over a step: the polynomial of fourth degree in the fraction θ of the step through position,
/// velocity and acceleration at the start, and position and velocity at the end.
struct Path<S> {
    change: Change<S>,
    /// Coefficients of θ to θ⁴.
    coefficients: [S; 4],
    per_step: S,
}

impl<S: Scalar> Path<S> {
    #[inline(always)]
    fn new<const N: usize, const P: usize>(start: &Point<S, N, P>, change: Change<S>, step: S) -> Self {
        let linear = step * start.state[VELOCITY];
        let bend = step * step * start.derivative[VELOCITY];
        let quadratic = S::from_f64(0.5) * bend;
        let rest = change.displacement - linear - quadratic;
        let fourth = step * change.velocity - bend - S::from_f64(3.0) * rest;
        Self { change, coefficients: [linear, quadratic, rest - fourth, fourth], per_step: S::ONE / step }
    }

    /// Of a fixed position.
    #[inline(always)]
    fn fixed() -> Self {
        Self { change: Change::NONE, coefficients: [S::ZERO; 4], per_step: S::ZERO }
    }

    /// Displacement from the start in m, and velocity in m/s.
    #[inline(always)]
    fn at(&self, theta: f64) -> [S; 2] {
        let [linear, quadratic, third, fourth] = self.coefficients;
        let number = S::from_f64;
        let node = number(theta);
        let displacement = node * (linear + node * (quadratic + node * (third + node * fourth)));
        let slope = linear
            + number(2.0 * theta) * quadratic
            + number(3.0 * theta * theta) * third
            + number(4.0 * theta * theta * theta) * fourth;
        [displacement, slope * self.per_step]
    }
}

/// The stages of a step.
struct Stages<S> {
    /// Velocity in m/s at the first two nodes.
    velocities: [S; 2],
    /// Displacement in m at the first two nodes.
    displacements: [S; 2],
    /// Whether the state of the circuit changes.
    active: bool,
    /// `h y'`; zeros while the state of the circuit is constant.
    increments: [S; 3],
    /// The change of the circuit's state since the start.
    changes: [S; 3],
    /// What the drive of a nonlinear circuit lacks at the last stage.
    defect: S,
    /// Estimated error of the last change due to a nonlinear circuit.
    circuit_error: S,
    /// Force per mass in m/s².
    forces: [S; 3],
}

impl<S: Scalar> Stages<S> {
    /// The stages of a step that changes the motion by `change`.
    #[inline(always)]
    fn along<const N: usize, const P: usize, Y: System<S, N, P>>(
        system: &Y,
        start: &Point<S, N, P>,
        path: &Path<S>,
        step: S,
    ) -> Self {
        let [[one, first], [two, second]] = [path.at(NODES[0]), path.at(NODES[1])];
        let end_velocity = start.state[VELOCITY] + path.change.velocity;
        let stages = [
            system.stage(start, one, first),
            system.stage(start, two, second),
            system.stage(start, path.change.displacement, end_velocity),
        ];
        let mut found = Self {
            velocities: [first, second],
            displacements: [one, two],
            active: false,
            increments: [S::ZERO; 3],
            changes: [S::ZERO; 3],
            defect: S::ZERO,
            circuit_error: S::ZERO,
            forces: [S::ZERO; 3],
        };
        if let [Some(one), Some(two), Some(three)] = stages.map(|stage| stage.circuit) {
            found.active = true;
            found.solve(&[one, two, three], step);
            if !Y::LINEAR {
                found.complete(system, start, [one, two, three], path.change.displacement, step);
            }
        }
        let [a, b, c] = stages;
        let changes = found.changes;
        found.forces = [a.force_at(changes[0]), b.force_at(changes[1]), c.force_at(changes[2])];
        found
    }

    /// Solves the circuit equations of the stages.
    #[inline(always)]
    fn solve(&mut self, equations: &[CircuitEquation<S>; 3], step: S) {
        self.increments = solve(equations, step);
        self.changes = STAGES.map(|weights| weighted(&weights, &self.increments));
    }

    /// Solves the equations again with what their drives lack at the found changes: a step of Newton's iteration. Its
    /// error is estimated by its convergence.
    #[inline(never)]
    fn complete<const N: usize, const P: usize, Y: System<S, N, P>>(
        &mut self,
        system: &Y,
        start: &Point<S, N, P>,
        mut equations: [CircuitEquation<S>; 3],
        displacement: S,
        step: S,
    ) {
        let linear = self.changes[2];
        let [one, two] = self.displacements;
        let places = [one, two, displacement].into_iter().zip(self.changes);
        for (equation, (displacement, change)) in equations.iter_mut().zip(places) {
            self.defect = system.circuit_defect(start, displacement, change);
            equation.drive += self.defect;
        }
        self.solve(&equations, step);
        let correction = (self.changes[2] - linear).abs();
        let convergence = correction / linear.abs().max(S::TINY);
        self.circuit_error = correction * convergence.min(S::ONE);
    }

    /// Solves the last stage again, at a displacement and a velocity. Returns the force per mass there.
    #[inline(always)]
    fn close<const N: usize, const P: usize, Y: System<S, N, P>>(
        &mut self,
        system: &Y,
        start: &Point<S, N, P>,
        change: &Change<S>,
        step: S,
    ) -> S {
        let stage = system.stage(start, change.displacement, start.state[VELOCITY] + change.velocity);
        if let Some(equation) = stage.circuit {
            let weight = S::from_f64(STAGES[2][2]);
            let before = self.changes[2] - weight * self.increments[2];
            let stiffness = step * equation.stiffness;
            let drive = if Y::LINEAR { equation.drive } else { equation.drive + self.defect };
            let increment = (step * drive - stiffness * before) / (equation.inertia + stiffness * weight);
            self.increments[2] = increment;
            self.changes[2] = before + weight * increment;
        }
        stage.force_at(self.changes[2])
    }
}

/// Product of step and relaxation below which the stages resolve a boundary layer.
const RESOLVED: f64 = 0.05;

/// Adds what the quadrature of the stages misses of the energy of a boundary layer.
///
/// In the layer the rate exceeds the one that follows the motion by `e exp(−λ τ)`. The integral of its square is exact
/// here; the stages find the same exponential by the method. The mixed term is linear and needs no correction.
#[cold]
#[inline(never)]
fn add_layer<S: Scalar, const N: usize, const P: usize, Y: System<S, N, P>>(
    system: &Y,
    start: &Point<S, N, P>,
    step: S,
    energies: &mut [S; P],
) {
    let Some(layer) = system.boundary_layer(&start.state) else { return };
    let relaxation = layer.relaxation;
    let turns = step * relaxation;
    if !(turns > S::from_f64(RESOLVED)) {
        return;
    }
    let decay = CircuitEquation { inertia: S::ONE, stiffness: relaxation, drive: S::ONE };
    let squares = solve(&[decay; 3], step).map(|increment| increment * increment);
    let exact = (S::ONE - S::Build::exponential(-(turns + turns))) / (relaxation + relaxation);
    let missing = exact - weighted(&STAGES[2], &squares) / step;
    let excess = layer.excess(start.derivative[Y::CIRCUIT]);
    for (energy, more) in energies.iter_mut().zip(system.quadratic_energies(excess * excess * missing)) {
        *energy += more;
    }
}

/// The estimated error of the energy of a step per second: a part of the difference between the first power at the start
/// and its extrapolation from the stages.
#[inline(always)]
fn energy_error_rate<S: Scalar, const P: usize>(start: &[S; P], stages: &[[S; P]; 3]) -> S {
    let [first, second, third] = stages.map(|powers| powers.first().copied().unwrap_or(S::ZERO));
    let extrapolated = weighted(&AT_START, &[first, second, third]);
    S::from_f64(ENERGY_ERROR_PART) * (start.first().copied().unwrap_or(S::ZERO) - extrapolated)
}

impl<S: Scalar> Stages<S> {
    /// The powers at one of the first two stages; `derivative` is that at the end.
    #[inline(always)]
    fn powers<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
        derivative: &[S; N],
        stage: usize,
    ) -> [S; P] {
        let Attempt { start, ref input, ticks, .. } = *attempt;
        let mut state = start.state;
        state[POSITION] += self.displacements[stage];
        state[VELOCITY] = self.velocities[stage];
        state[Y::CIRCUIT] += self.changes[stage];
        let mut derivative = *derivative;
        derivative[Y::CIRCUIT] = self.increments[stage] / seconds_of_ticks(ticks);
        let part = (S::from_u32(ticks) * S::from_f64(NODES[stage])).to_u32();
        system.powers(&state, &derivative, input.at(part))
    }

    /// Sets the error of the corrected motion, as a change of the state.
    ///
    /// It is a part of the correction by the bend of the force, or what a further pass would change: more where the force
    /// depends strongly on the motion, as near pull-in. The slope of the force may be predicted roughly.
    #[inline(always)]
    fn doubt<const N: usize>(&self, doubt: &mut [S; N], bend: &Change<S>, end_force: S, step: S) {
        let part = S::from_f64(MOTION_ERROR_PART);
        let change = step * (end_force - self.forces[2]).abs();
        let [displacement, velocity] = NEXT_PASS.map(S::from_f64);
        doubt[POSITION] = (part * bend.displacement.abs()).max(displacement * step * change);
        doubt[VELOCITY] = (part * bend.velocity.abs()).max(velocity * change);
    }
}

/// `Σ_j weights_j increments_j`.
#[inline(always)]
fn weighted<S: Scalar>(weights: &[f64; 3], increments: &[S; 3]) -> S {
    let [a, b, c] = weights.map(S::from_f64);
    let [first, second, third] = *increments;
    a * first + b * second + c * third
}

/// Solves `inertia_i z_i + h stiffness_i Σ_j a_ij z_j = h drive_i`. All leading minors are positive, so no row is
/// exchanged.
#[inline(always)]
fn solve<S: Scalar>(equations: &[CircuitEquation<S>; 3], step: S) -> [S; 3] {
    let [one, two, three] = *equations;
    let row = |equation: &CircuitEquation<S>, weights: &[f64; 3]| {
        let stiffness = step * equation.stiffness;
        weights.map(|weight| stiffness * S::from_f64(weight))
    };
    let [a, b, c] = row(&one, &STAGES[0]);
    let [d, e, f] = row(&two, &STAGES[1]);
    let [g, h, i] = row(&three, &STAGES[2]);
    let [right_a, right_b, right_c] = [one, two, three].map(|equation| step * equation.drive);
    let pivot = S::ONE / (one.inertia + a);
    let (second, third) = (d * pivot, g * pivot);
    let (e, f, right_b) = (two.inertia + e - second * b, f - second * c, right_b - second * right_a);
    let (h, i, right_c) = (h - third * b, three.inertia + i - third * c, right_c - third * right_a);
    let second = S::ONE / e;
    let third = h * second;
    let z3 = (right_c - third * right_b) / (i - third * f);
    let z2 = (right_b - f * z3) * second;
    [(right_a - b * z2 - c * z3) * pivot, z2, z3]
}

impl<S: Scalar> Prediction<S> {
    /// The change of the motion by the difference between the force at the stages and its prediction: by its linear part,
    /// and by the rest.
    #[inline(always)]
    fn corrections(&self, forces: &[S; 3]) -> [Change<S>; 2] {
        let Kernel { step, ramps: [zeroth, first, second, third], .. } = self.kernel;
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

    /// The acceleration in m/s² at the end of the step under a force per mass.
    #[inline(always)]
    fn end_acceleration<const N: usize>(&self, state: &[S; N], force: S) -> S {
        let Oscillator { stiffness, damping, rest, base_coupling } = self.oscillator;
        force
            - stiffness * (state[POSITION] - rest)
            - damping * state[VELOCITY]
            - base_coupling * self.response.end
    }
}

impl<S: Scalar> Method<S> for ExponentialRadau {
    const ESTIMATES_ERROR: bool = true;
    const ESTIMATE_ORDER: i32 = 3;
    /// Two steps for a quarter of a period. A step to an event may be an eighth longer.
    const LONGEST_RADIANS: f64 = 0.8;
    const CARRIES_DERIVATIVES: bool = true;
    const PREDICTS: bool = true;

    type Prediction = Prediction<S>;

    #[inline(always)]
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
        let Attempt { start: Point { state, derivative, .. }, ref input, ticks, .. } = *attempt;
        let oscillator = system.oscillator()?;
        let step = seconds_of_ticks(ticks);
        let kernel = Kernel::new(&oscillator, step);
        let response = input.response(ticks, &kernel);
        let settled = attempt.settled_derivative(system);
        let rise = step * system.force_rate(state, &settled);
        // The force less the restoring force: no difference of large numbers.
        let pull = derivative[VELOCITY]
            + oscillator.damping * state[VELOCITY]
            + oscillator.base_coupling * response.start;
        let Kernel { impulse, impulse_rate, ramps: [zeroth, first, ..], .. } = kernel;
        let velocity = state[VELOCITY];
        let change = Change {
            displacement: step * (impulse * velocity + step * (zeroth * pull + first * rise))
                - oscillator.base_coupling * response.displacement,
            velocity: impulse_rate * velocity + step * (impulse * pull + zeroth * rise)
                - oscillator.base_coupling * response.velocity,
        };
        let force = pull + oscillator.stiffness * (state[POSITION] - oscillator.rest);
        Some(Prediction { oscillator, kernel, response, rate: settled[Y::CIRCUIT], force, rise, change })
    }

    #[inline(always)]
    fn predicted_end<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        _system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
        prediction: &Prediction<S>,
    ) -> Point<S, N, P> {
        let Prediction { kernel, force, rise, change, .. } = prediction;
        let mut end = *attempt.start;
        end.state[POSITION] += change.displacement;
        end.state[VELOCITY] += change.velocity;
        end.state[Y::CIRCUIT] += kernel.step * end.derivative[Y::CIRCUIT];
        end.derivative[POSITION] = end.state[VELOCITY];
        end.derivative[VELOCITY] = prediction.end_acceleration(&end.state, *force + *rise);
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
        let (mut change, mut force, mut error) = (Change::NONE, S::ZERO, S::ZERO);
        let mut doubt = [S::ZERO; N];
        let path = match prediction {
            Some(prediction) => Path::new(start, prediction.change, step),
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
        let mut end = *start;
        for ((state, remainder), increment) in end.state.iter_mut().zip(&mut end.remainder).zip(increments) {
            (*state, *remainder) = add_increment(*state, *remainder, increment);
        }
        end.derivative = [S::ZERO; N];
        if let Some(prediction) = prediction {
            end.derivative[POSITION] = end.state[VELOCITY];
            end.derivative[VELOCITY] = prediction.end_acceleration(&end.state, force);
        }
        end.derivative[Y::CIRCUIT] = stages.increments[2] / step;
        let inputs = match prediction {
            Some(prediction) => [prediction.response.start, prediction.response.end],
            None => [0, ticks].map(|offset| input.at(offset)),
        };
        end.powers = system.powers(&end.state, &end.derivative, inputs[1]);
        let powers = [
            stages.powers(system, attempt, &end.derivative, 0),
            stages.powers(system, attempt, &end.derivative, 1),
            end.powers,
        ];
        let mut energies: [S; P] = core::array::from_fn(|i| {
            step * weighted(&STAGES[2], &[powers[0][i], powers[1][i], powers[2][i]])
        });
        system.correct_energies(&start.state, &end.state, &mut energies);
        if attempt.after_jump && stages.active {
            add_layer(system, start, step, &mut energies);
        }
        let mut settled = start.derivative;
        settled[Y::CIRCUIT] = match prediction {
            Some(prediction) => prediction.rate,
            None => attempt.settled_derivative(system)[Y::CIRCUIT],
        };
        let at_start = system.powers(&start.state, &settled, inputs[0]);
        let energy_error = step * energy_error_rate(&at_start, &powers);
        let sum = end.state.iter().chain(&end.derivative).fold(error + energy_error, |sum, &term| sum + term);
        if !sum.is_finite() {
            return Err(NotConverged);
        }
        Ok(Trial { end, energies, error, energy_error, iterations: 1 })
    }
}
