//! Steps of the method Radau IIA of order 5, by the crate `differential-equations`.
//!
//! Each step begins the method anew: after a step that keeps its length, version 0.7 of the crate keeps the decomposed matrices at other
//! lengths too.
//!
//! An integral over a step is the sum by the weights of the method, which is what it would be as a further state. Its error is estimated
//! by the formula of the method, and a step that is too long for it is refused.

use differential_equations::error::Error;
use differential_equations::interpolate::Interpolation;
use differential_equations::linalg::Matrix;
use differential_equations::methods::ImplicitRungeKutta;
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::status::Status;
use nalgebra::{Matrix4, Vector4};

use super::harvester::{Harvester, Motion, Sample, Scales};
use crate::ledger::{Effort, Integrals, add};
use harvester_scene::base_motion::LocalBase;

/// Position, velocity, voltage and gain of the storage.
pub(super) type States = [f64; Motion::STATES];

/// Tolerance of the crate over the one that is asked for: it compares an estimate of order 3, and the steps are of order 5.
const LOOSER: f64 = 10.0;

/// Absolute tolerance over the relative tolerance of a quantity of its full size. The voltage between its
/// peaks, the speed of a small hop and a creeping motion need it small.
const ABSOLUTE: f64 = 1e-3;

/// The same for the integrals.
const ABSOLUTE_OF_INTEGRALS: f64 = 1e-2;

/// Refused attempts that one step may have.
const MOST_FAILURES: usize = 50;

/// A time in s within which no motion changes.
const SHORTEST: f64 = 1e-30;

/// Iterations of one attempt: the crate refuses one that takes more, and a looser tolerance has longer steps.
const MOST_ITERATIONS: usize = 12;

/// Change of the states over their tolerance at which the crate's iteration ends. A stiff voltage far below its size needs it small.
const NEWTON: f64 = 1e-5;

/// Iterations of a step after those of the crate, see [`Integrator::polish`]. Without them the errors of the iteration add up: over the
/// 300 periods of the shipped scene of contact-separation the voltage of an open circuit drifts by 3·10⁻⁷.
const POLISHES: usize = 2;

/// The start and the times of the stages as parts of the step.
const NODES: [f64; 4] = [0.0, 0.155_051_025_721_682_2, 0.644_948_974_278_317_8, 1.0];

/// Weights of the rates at the stages in an integral up to each stage.
const WEIGHTS: [[f64; 3]; 3] = [
    [0.196_815_477_223_660_4, -0.065_535_425_850_198_39, 0.023_770_974_348_220_15],
    [0.394_424_314_739_087_3, 0.292_073_411_665_228_5, -0.041_548_752_125_997_93],
    [0.376_403_062_700_467_3, 0.512_485_826_188_421_6, 1.0 / 9.0],
];

/// The estimate of the method for the error of an integral, from its rates at the start and at the stages, per length of the step.
const ERROR: [f64; 4] =
    [0.274_888_829_595_677_3, -0.428_298_294_115_368_1, 0.245_039_074_384_916_4, -0.091_629_609_865_225_8];

/// Why a flow cannot go on.
pub(crate) struct Reason(pub(crate) String);

/// A step that was accepted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    /// Local start in s.
    pub(super) from: f64,
    /// Local end in s.
    pub(super) to: f64,
    pub(super) end: States,
    /// Divided differences of the states at [`NODES`].
    differences: [States; 4],
    /// Integrals over the step.
    pub(super) integrals: Integrals,
    /// Length in s that the next step may have.
    pub(super) next: f64,
}

impl Arc {
    /// The states at a local time, and their rates: the polynomial of collocation.
    pub(super) fn at(&self, t: f64) -> [States; 2] {
        let length = self.to - self.from;
        let part = (t - self.from) / length;
        let (mut states, mut rates) = (self.differences[3], [0.0; Motion::STATES]);
        for (node, differences) in NODES.iter().zip(&self.differences).take(3).rev() {
            for place in 0..Motion::STATES {
                rates[place] = rates[place] * (part - node) + states[place];
                states[place] = states[place] * (part - node) + differences[place];
            }
        }
        [if t >= self.to { self.end } else { states }, rates.map(|rate| rate / length)]
    }
}

/// Divided differences of the states at [`NODES`].
fn divided(mut states: [States; 4]) -> [States; 4] {
    for order in 1..4 {
        for node in (order..4).rev() {
            let before = states[node - 1];
            for (state, before) in states[node].iter_mut().zip(before) {
                *state = (*state - before) / (NODES[node] - NODES[node - order]);
            }
        }
    }
    states
}

fn reason(error: Error<f64, States>) -> Reason {
    Reason(format!("integrator: {error:?}"))
}

/// The equations of a flow with the tolerances of states and integrals.
pub(super) struct Integrator<'a, H> {
    equations: &'a H,
    base: &'a LocalBase,
    /// A motion in the regime of the flow.
    regime: Motion,
    /// Relative and absolute tolerances as the crate takes them.
    relative: f64,
    absolute: States,
    /// The relative tolerance as the crate scales it, and absolute ones of the integrals.
    scaled: f64,
    integrals: Integrals,
}

impl<H: Harvester> ODE<f64, States> for Integrator<'_, H> {
    fn diff(&self, t: f64, states: &States, rates: &mut States) {
        *rates = self.equations.rates(&self.regime.with(states), self.base.at(t));
    }

    fn jacobian(&self, _: f64, states: &States, jacobian: &mut Matrix<f64>) {
        for (column, along) in self.columns(states).iter().enumerate() {
            along.iter().enumerate().for_each(|(row, rate)| jacobian[(row, column)] = *rate);
        }
    }
}

impl<'a, H: Harvester> Integrator<'a, H> {
    /// The equations of a flow that starts with a motion, with its sizes and the relative tolerance.
    pub(super) fn new(
        harvester: &'a H,
        base: &'a LocalBase,
        start: Motion,
        (scales, tolerance): (&Scales, f64),
    ) -> Self {
        let Scales { position, velocity, voltage, time, energy, surface_energy, charge } = *scales;
        let (squared, surface) = (voltage * voltage * time, surface_energy);
        let storage = harvester.load().storage.as_ref();
        let (gain, [into, diodes, leaked, drawn]) =
            storage.map_or((1.0, [energy; 4]), |storage| storage.scales(charge, energy));
        let integrals =
            [squared, voltage * time, energy, energy, surface, surface, into, diodes, leaked, drawn];
        let relative = LOOSER * tolerance;
        let scaled = 0.1 * relative.powf(2.0 / 3.0);
        Self {
            equations: harvester,
            base,
            regime: start,
            relative,
            absolute: [position, velocity, voltage, gain].map(|size| ABSOLUTE * relative * size),
            scaled,
            integrals: integrals.map(|size| ABSOLUTE_OF_INTEGRALS * scaled * size),
        }
    }

    /// The method at the start of a step; its first attempt has the given length in s, or one that it finds if that is zero.
    fn start(
        &self,
        from: f64,
        states: &States,
        length: f64,
    ) -> Result<impl OrdinaryNumericalMethod<f64, States> + Interpolation<f64, States> + use<H>, Reason> {
        let mut method = ImplicitRungeKutta::radau5()
            .rtol([self.relative; Motion::STATES])
            .atol(self.absolute)
            .newton_tol(NEWTON)
            .max_newton_iter(MOST_ITERATIONS)
            .h0(length);
        method.init(self, from, f64::INFINITY, states).map_err(reason)?;
        Ok(method)
    }

    /// Columns of the Jacobian.
    fn columns(&self, states: &States) -> [States; Motion::STATES] {
        let motion = self.regime.with(states);
        std::array::from_fn(|column| {
            let mut change = [0.0; Motion::STATES];
            change[column] = 1.0;
            self.equations.rates_along(&motion, &self.regime.with(&change))
        })
    }

    /// A step on from a motion at a local time. Its first attempt has the first length in s, or one that is found if that is zero; none
    /// is longer than the second. `sums` are the integrals before.
    pub(super) fn step(
        &self,
        (from, motion): &Sample,
        [first, longest]: [f64; 2],
        sums: &Integrals,
        effort: &mut Effort,
    ) -> Result<Arc, Reason> {
        let (from, states) = (*from, &motion.states());
        let mut method = self.start(from, states, first.min(longest))?;
        if method.h() > longest {
            method = self.start(from, states, longest)?;
        }
        for _ in 0..MOST_FAILURES {
            let length = method.h();
            let work = method.step(self).map_err(reason)?;
            effort.newton_iterations += work.newton as u64;
            let is_refused = *method.status() == Status::RejectedStep;
            // The crate accepts what is not a number.
            let mut shorter = if is_refused { method.h() } else { 0.1 * length };
            if !is_refused && method.y().iter().all(|state| state.is_finite()) {
                let to = method.t();
                let mut nodes = [*states; 4];
                for (node, states) in NODES.iter().zip(&mut nodes).skip(1) {
                    *states = method.interpolate((from + node * length).min(to)).map_err(reason)?;
                }
                self.polish([from, length], &mut nodes);
                let (integrals, error) = self.integrals([from, length], &nodes, sums);
                shorter = 0.9 * length / error.max(1e-8).powf(0.25);
                if error <= 1.0 && nodes.iter().flatten().chain(&integrals).all(|value| value.is_finite()) {
                    effort.steps += 1;
                    let next = method.h().min(shorter);
                    return Ok(Arc { from, to, end: nodes[3], differences: divided(nodes), integrals, next });
                }
            }
            effort.rejected += 1;
            if from + shorter <= from {
                break;
            }
            method = self.start(from, states, shorter)?;
        }
        Err(Reason(format!(
            "integrator, at a local time of {from:e} s: no step of {longest:e} s or less is accepted"
        )))
    }

    /// Steps on from a motion to a local time. Gives the motion there and the integrals.
    pub(super) fn go(
        &self,
        start: &Sample,
        until: f64,
        sums: &Integrals,
        effort: &mut Effort,
    ) -> Result<(Sample, Integrals), Reason> {
        let (mut last, mut integrals) = (*start, Integrals::default());
        // The rounding of a sum of times is no step.
        while until - last.0 > (2.0 * f64::EPSILON * until).max(SHORTEST) {
            let left = until - last.0;
            let arc = self.step(&last, [left, left], sums, effort)?;
            add(&mut integrals, 1.0, &arc.integrals);
            last = (arc.to, self.regime.with(&arc.end));
        }
        Ok(((until, last.1), integrals))
    }

    /// Iterates the stages of a step further where they are not stiff; a stiff state keeps its error, which decays.
    fn polish(&self, [from, length]: [f64; 2], nodes: &mut [States; 4]) {
        let matrix = Matrix4::identity() - length * ERROR[0] * Matrix4::from(self.columns(&nodes[0]));
        let Some(inverse) = matrix.try_inverse() else { return };
        for _ in 0..POLISHES {
            let rates: [States; 3] = std::array::from_fn(|stage| {
                let time = from + NODES[stage + 1] * length;
                self.equations.rates(&self.regime.with(&nodes[stage + 1]), self.base.at(time))
            });
            for (stage, weights) in WEIGHTS.iter().enumerate() {
                let mut residual = Vector4::from(nodes[0]) - Vector4::from(nodes[stage + 1]);
                for (weight, rates) in weights.iter().zip(rates) {
                    residual += length * *weight * Vector4::from(rates);
                }
                nodes[stage + 1] = (Vector4::from(nodes[stage + 1]) + inverse * residual).into();
            }
        }
    }

    /// Integrals over a step, and the largest error over what is allowed.
    fn integrals(&self, [from, length]: [f64; 2], nodes: &[States; 4], sums: &Integrals) -> (Integrals, f64) {
        let mut rates = [Integrals::default(); 4];
        for ((rates, states), node) in rates.iter_mut().zip(nodes).zip(NODES) {
            *rates = self.equations.integrands(&self.regime.with(states), self.base.at(from + node * length));
        }
        let mut integrals = Integrals::default();
        let mut worst: f64 = 0.0;
        for (place, integral) in integrals.iter_mut().enumerate() {
            *integral = length * (0..3).map(|stage| WEIGHTS[2][stage] * rates[stage + 1][place]).sum::<f64>();
            let error = length * (0..4).map(|node| ERROR[node] * rates[node][place]).sum::<f64>();
            let allowed = self.integrals[place] + self.scaled * (sums[place] + *integral).abs();
            worst = worst.max((error / allowed).abs());
        }
        (integrals, worst)
    }
}
