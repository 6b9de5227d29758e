//! The stages of Radau IIA along a motion, and their tableau (Hairer and Wanner, Solving Ordinary Differential Equations
//! II, section IV.5).

use super::{Change, POSITION, VELOCITY};
use crate::clock::seconds_of_ticks;
use crate::integrate::{Attempt, BoundaryLayer, CircuitEquation, Input, Point, System};
use crate::scalar::{Mathematics, Scalar};

const ROOT_SIX: f64 = 2.449_489_742_783_178_098_2;
/// The nodes of Radau IIA.
pub(super) const NODES: [f64; 3] = [(4.0 - ROOT_SIX) / 10.0, (4.0 + ROOT_SIX) / 10.0, 1.0];
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

/// Weights of the stages in the coefficients, by rising powers of θ, of the parabola through them or the cubic that is 0 at the start.
const fn coefficients(is_cubic: bool) -> [[f64; 3]; 3] {
    let mut weights = [[0.0; 3]; 3];
    let mut i = 0;
    while i < 9 {
        weights[i / 3][i % 3] = LAGRANGE[i % 3][i / 3] / if is_cubic { NODES[i % 3] } else { 1.0 };
        i += 1;
    }
    weights
}
/// Of 1, θ and θ² of the parabola.
const PARABOLA: [[f64; 3]; 3] = coefficients(false);
/// Of θ, θ² and θ³ of the cubic.
pub(super) const CUBIC: [[f64; 3]; 3] = coefficients(true);

/// Part of the difference between the power at the start and its extrapolation from the stages that estimates the error
/// of the energy of a step.
const ENERGY_ERROR_PART: f64 = 0.05;
/// Part of the correction of the motion that estimates the error of the corrected motion.
const MOTION_ERROR_PART: f64 = 1.0 / 16.0;
/// Weights of a change of the force at the end, times `h²` and `h`, in the displacement and the velocity that a further pass would add.
const NEXT_PASS: [f64; 2] = [1.0 / 12.0, 1.0 / 4.0];

/// Whether the energies of a step are corrected, which takes too much flash in single precision.
pub(super) fn corrects_energy<S: Scalar, Y: System<S, N, P>, const N: usize, const P: usize>(
    system: &Y,
) -> bool {
    S::IS_DOUBLE && system.is_harmonic()
}

/// The displacement over a step: the polynomial of fourth degree in the fraction θ of the step through position,
/// velocity and acceleration at the start, and position and velocity at the end; with the acceleration there, of fifth.
pub(super) struct Path<S> {
    change: Change<S>,
    /// Coefficients of θ to θ⁴.
    coefficients: [S; 4],
    /// Coefficient of θ⁵, with the acceleration at the end. Double precision only.
    fifth: Option<S>,
    per_step: S,
}

impl<S: Scalar> Path<S> {
    #[inline]
    pub(super) fn new<const N: usize, const P: usize>(
        start: &Point<S, N, P>,
        change: Change<S>,
        step: S,
        end_acceleration: Option<S>,
    ) -> Self {
        let linear = step * start.state[VELOCITY];
        let square = step * step;
        let bend = square * start.derivative[VELOCITY];
        let quadratic = S::from_f64(0.5) * bend;
        let rest = change.displacement - linear - quadratic;
        let mut fourth = step * change.velocity - bend - S::from_f64(3.0) * rest;
        let mut third = rest - fourth;
        let mut fifth = None;
        if let Some(end) = end_acceleration {
            let last =
                S::from_f64(0.5) * (square * end - bend) - S::from_f64(3.0) * (third + fourth + fourth);
            (third, fourth, fifth) = (third + last, fourth - (last + last), Some(last));
        }
        Self { change, coefficients: [linear, quadratic, third, fourth], fifth, per_step: S::ONE / step }
    }

    /// Of a fixed position.
    #[inline]
    pub(super) fn fixed() -> Self {
        Self { change: Change::NONE, coefficients: [S::ZERO; 4], fifth: None, per_step: S::ZERO }
    }

    /// Displacement from the start in m, and velocity in m/s.
    #[inline]
    fn at(&self, theta: f64) -> [S; 2] {
        let [linear, quadratic, third, fourth] = self.coefficients;
        let number = S::from_f64;
        let node = number(theta);
        let fifth = self.fifth.filter(|_| S::IS_DOUBLE);
        let last = fifth.map_or(fourth, |fifth| fourth + node * fifth);
        let displacement = node * (linear + node * (quadratic + node * (third + node * last)));
        let mut slope = linear
            + number(2.0 * theta) * quadratic
            + number(3.0 * theta * theta) * third
            + number(4.0 * theta * theta * theta) * fourth;
        if let Some(fifth) = fifth {
            slope += number(5.0 * theta * theta * theta * theta) * fifth;
        }
        [displacement, slope * self.per_step]
    }
}

/// The stages of a step.
pub(super) struct Stages<S> {
    /// Velocity in m/s at the first two nodes.
    velocities: [S; 2],
    /// Displacement in m at the first two nodes.
    displacements: [S; 2],
    /// Whether the state of the circuit changes.
    pub(super) active: bool,
    /// `h y'`; zeros while the state of the circuit is constant.
    pub(super) increments: [S; 3],
    /// The change of the circuit's state since the start.
    pub(super) changes: [S; 3],
    /// What the drive of a nonlinear circuit lacks at the last stage.
    defect: S,
    /// Relaxation of a harmonic circuit in the step, at the second stage.
    turns: S,
    /// Estimated error of the last change due to a nonlinear circuit.
    pub(super) circuit_error: S,
    /// Force per mass in m/s².
    pub(super) forces: [S; 3],
}

impl<S: Scalar> Stages<S> {
    /// The stages of a step that changes the motion by `change`.
    #[inline(always)]
    pub(super) fn along<const N: usize, const P: usize, Y: System<S, N, P>>(
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
            turns: S::ZERO,
            circuit_error: S::ZERO,
            forces: [S::ZERO; 3],
        };
        if let [Some(one), Some(two), Some(three)] = stages.map(|stage| stage.circuit) {
            found.active = true;
            if corrects_energy(system) {
                found.turns = step * two.stiffness / two.inertia;
            }
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
    #[inline]
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
        let [first, second, third] = self.changes;
        let defects = [(one, first), (two, second), (displacement, third)]
            .map(|(displacement, change)| system.circuit_defect(start, displacement, change));
        if defects == [S::ZERO; 3] {
            return;
        }
        for (equation, defect) in equations.iter_mut().zip(defects) {
            equation.drive += defect;
        }
        self.defect = defects[2];
        self.solve(&equations, step);
        let correction = (self.changes[2] - linear).abs();
        let convergence = correction / linear.abs().max(S::TINY);
        self.circuit_error = correction * convergence.min(S::ONE);
    }

    /// Solves the last stage again, at a displacement and a velocity. Returns the force per mass there.
    #[inline(always)]
    pub(super) fn close<const N: usize, const P: usize, Y: System<S, N, P>>(
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

    /// The powers at one of the first two stages; `derivative` is that at the end.
    #[inline(always)]
    pub(super) fn powers<const N: usize, const P: usize, Y: System<S, N, P>>(
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

    /// The energies of a step to `end`, and the estimated error of the first. `layer` is the boundary layer at the start, with the
    /// rate of the circuit's state after it; `input` is the acceleration at the start.
    #[inline]
    pub(super) fn energies<const N: usize, const P: usize, Y: System<S, N, P>>(
        &self,
        system: &Y,
        attempt: &Attempt<'_, S, impl Input<S>, N, P>,
        end: &Point<S, N, P>,
        (layer, rate): (Option<BoundaryLayer<S>>, S),
        input: S,
    ) -> ([S; P], S) {
        let (start, step) = (attempt.start, seconds_of_ticks::<S>(attempt.ticks));
        let powers = [
            self.powers(system, attempt, &end.derivative, 0),
            self.powers(system, attempt, &end.derivative, 1),
            end.powers,
        ];
        let mut energies = powers[0];
        for ((energy, second), third) in energies.iter_mut().zip(&powers[1]).zip(&powers[2]) {
            *energy = step * weighted(&STAGES[2], &[*energy, *second, *third]);
        }
        system.correct_energies(&start.state, &end.state, &mut energies);
        if corrects_energy(system) {
            let stiffness = system.oscillator().map_or(S::ZERO, |oscillator| oscillator.stiffness);
            let square = self.missing_square(rate, stiffness * step * step, step);
            for (energy, more) in energies.iter_mut().zip(system.quadratic_energies(square)) {
                *energy += more;
            }
        }
        if let Some(layer) = &layer
            && self.active
        {
            add_layer(system, start, layer, step, &mut energies);
        }
        // Without a layer the first power is that at the end of the step before.
        let at_start = if layer.is_some() {
            let mut settled = start.derivative;
            settled[Y::CIRCUIT] = rate;
            system.powers(&start.state, &settled, input)
        } else {
            start.powers
        };
        (energies, step * energy_error_rate(&at_start, &powers))
    }

    /// What the quadrature of the stages misses of the integral of the squared rate in a [harmonic](System::is_harmonic) system. `rate` is
    /// that at the start, `swing` the square of the step in radians of the oscillator.
    /// The rate is the parabola `a + b θ + c θ²` of the stages and its error `i`, with `i + z ∫i dθ = r`, where `z` is the
    /// relaxation in a step. The residual `r` is 0 at the nodes: a multiple of their polynomial `π`, known at the start, and of
    /// `θ π` and `θ² π` by the fourth and fifth derivative of the drive. A harmonic drive has them as `−swing` times the
    /// second and third. The integral of `2 (a + b θ + c θ²) i` follows from the moments `∫ θ² π = −1/600` and
    /// `∫ θ³ π = −3/1400`; its decay with `z` is a fit.
    #[inline]
    fn missing_square(&self, rate: S, swing: S, step: S) -> S {
        let (number, z) = (S::from_f64, self.turns);
        let [a, b, c] = PARABOLA.map(|weights| weighted(&weights, &self.increments));
        let gap = step * rate - a;
        let turn = b + c;
        let second = z * turn + c + c;
        let by_gap = c + c + z * (turn + c + z * (a + turn));
        let own = gap * (number(1.0 / 60.0) * by_gap + number(3.0 / 35.0) * gap);
        let fourth = number(1.0 / 7200.0) * second * (z * a + b + number(9.0 / 7.0) * c);
        let fifth = number(1.0 / 18000.0) * a * (z * c - number(30.0) * gap);
        let decay = S::ONE + z * (number(0.571) + z * (number(0.148) + z * number(0.04)));
        (own + swing * (fourth + fifth)) / (step * decay)
    }

    /// Sets the error of the corrected motion, as a change of the state.
    ///
    /// It is a part of the correction by the bend of the force, or what a further pass would change: more where the force
    /// depends strongly on the motion, as near pull-in. The slope of the force may be predicted roughly.
    #[inline]
    pub(super) fn doubt<const N: usize>(&self, doubt: &mut [S; N], bend: &Change<S>, end_force: S, step: S) {
        let part = S::from_f64(MOTION_ERROR_PART);
        let change = step * (end_force - self.forces[2]).abs();
        let [displacement, velocity] = NEXT_PASS.map(S::from_f64);
        doubt[POSITION] = (part * bend.displacement.abs()).max(displacement * step * change);
        doubt[VELOCITY] = (part * bend.velocity.abs()).max(velocity * change);
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
    layer: &BoundaryLayer<S>,
    step: S,
    energies: &mut [S; P],
) {
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
    let extrapolated = weighted(&PARABOLA[0], &[first, second, third]);
    S::from_f64(ENERGY_ERROR_PART) * (start.first().copied().unwrap_or(S::ZERO) - extrapolated)
}

/// `Σ_j weights_j increments_j`.
#[inline]
pub(super) fn weighted<S: Scalar>(weights: &[f64; 3], increments: &[S; 3]) -> S {
    let [a, b, c] = weights.map(S::from_f64);
    let [first, second, third] = *increments;
    a * first + b * second + c * third
}

/// Solves `inertia_i z_i + h stiffness_i Σ_j a_ij z_j = h drive_i`. All leading minors are positive, so no row is exchanged.
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
