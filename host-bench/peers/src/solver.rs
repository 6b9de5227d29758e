//! The integrators of other crates behind one interface.

use std::marker::PhantomData;

use differential_equations::error::Error;
use differential_equations::interpolate::Interpolation;
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::status::Status;
use diffsol::error::DiffsolError;
use diffsol::{
    NalgebraContext, NalgebraMat, NalgebraVec, OdeBuilder, OdeEquationsImplicit, OdeSolverMethod,
    OdeSolverProblem, OdeSolverStopReason, Vector,
};

use super::Stop;
use super::scene::{Harvester, System};

/// An integrator that takes one step at a time and has dense output.
pub(crate) trait Solver<const N: usize> {
    /// Begins anew at a time in s, with a first step of about this length in s.
    fn restart(&mut self, time: f64, state: &[f64; N], step: f64) -> Result<(), Stop>;

    /// Takes a step that ends at `limit` in s at the latest.
    fn step(&mut self, limit: f64) -> Result<(), Stop>;

    /// The time in s at the end of the last step.
    fn time(&self) -> f64;

    /// The state at the end of the last step.
    fn state(&self) -> [f64; N];

    /// The state at a time in s within the last step.
    fn at(&mut self, time: f64) -> Result<[f64; N], Stop>;
}

// The explicit Runge-Kutta methods of Dormand and Prince, of the crate `differential-equations`.
//
// The crate's own event search is not used, because it may return a time that is no zero.

/// Rejected attempts in a row after which a step is given up.
const MOST_REJECTIONS: u32 = 100;

impl<H: Harvester<N>, const N: usize> ODE<f64, [f64; N]> for System<H, N> {
    fn diff(&self, t: f64, y: &[f64; N], dydt: &mut [f64; N]) {
        *dydt = self.harvester.rates(&self.mode.get(), t, y);
    }
}

/// A method of the crate on a system.
pub(crate) struct Explicit<'a, H: Harvester<N>, M, const N: usize> {
    pub(crate) system: &'a System<H, N>,
    pub(crate) method: M,
}

fn explicit_stop<const N: usize>(error: Error<f64, [f64; N]>) -> Stop {
    let reason = match error {
        Error::Stiffness { .. } => "the crate gives up: stiff",
        Error::StepSize { .. } => "the crate gives up: step too small",
        _ => "the crate gives up",
    };
    Stop::Integrator(reason.to_owned())
}

impl<H, M, const N: usize> Solver<N> for Explicit<'_, H, M, N>
where
    H: Harvester<N>,
    M: OrdinaryNumericalMethod<f64, [f64; N]> + Interpolation<f64, [f64; N]>,
{
    fn restart(&mut self, time: f64, state: &[f64; N], step: f64) -> Result<(), Stop> {
        self.method.init(self.system, time, f64::INFINITY, state).map_err(explicit_stop)?;
        self.method.set_h(step);
        Ok(())
    }

    fn step(&mut self, limit: f64) -> Result<(), Stop> {
        for _ in 0..MOST_REJECTIONS {
            let left = limit - self.method.t();
            if self.method.h() > left {
                self.method.set_h(left);
            }
            self.method.step(self.system).map_err(explicit_stop)?;
            if *self.method.status() != Status::RejectedStep {
                return Ok(());
            }
        }
        Err(Stop::Integrator("the crate rejects every step".to_owned()))
    }

    fn time(&self) -> f64 {
        self.method.t()
    }

    fn state(&self) -> [f64; N] {
        *self.method.y()
    }

    fn at(&mut self, time: f64) -> Result<[f64; N], Stop> {
        self.method.interpolate(time).map_err(explicit_stop)
    }
}

/// The equations of a system as the crate takes them.
pub(crate) trait Equations:
    OdeEquationsImplicit<M = NalgebraMat<f64>, V = NalgebraVec<f64>, T = f64, C = NalgebraContext>
{
}

impl<E> Equations for E where
    E: OdeEquationsImplicit<M = NalgebraMat<f64>, V = NalgebraVec<f64>, T = f64, C = NalgebraContext>
{
}

/// The problem of a system with the analytic Jacobian.
pub(crate) fn problem<'a, H: Harvester<N>, const N: usize>(
    system: &'a System<H, N>,
    start: [f64; N],
    relative: f64,
    absolute: [f64; N],
) -> Result<OdeSolverProblem<impl Equations + 'a>, DiffsolError> {
    OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(relative)
        .atol(absolute.to_vec())
        .rhs_implicit(
            move |x: &[f64], _: &[f64], t: f64, rates: &mut [f64]| {
                rates.copy_from_slice(&system.harvester.rates(&system.mode.get(), t, whole(x)));
            },
            move |x: &[f64], _: &[f64], t: f64, change: &[f64], rates: &mut [f64]| {
                let all = system.harvester.rates_along(&system.mode.get(), t, whole(x), whole(change));
                rates.copy_from_slice(&all);
            },
        )
        .init(move |_: &[f64], _: f64, x: &mut [f64]| x.copy_from_slice(&start), N)
        .build()
}

fn whole<const N: usize>(states: &[f64]) -> &[f64; N] {
    states.try_into().expect("the crate passes all states")
}

pub(crate) fn stop(error: DiffsolError) -> Stop {
    let text = error.to_string();
    Stop::Integrator(text.lines().next().unwrap_or("failed").to_owned())
}

/// A method of the crate on a system.
pub(crate) struct Implicit<'a, H: Harvester<N>, E: Equations, M, const N: usize> {
    system: &'a System<H, N>,
    method: M,
    equations: PhantomData<E>,
    /// For a state of the dense output.
    dense: NalgebraVec<f64>,
    /// The stop time in s that the method has.
    limit: f64,
}

impl<'a, H: Harvester<N>, E: Equations + 'a, M: OdeSolverMethod<'a, E>, const N: usize>
    Implicit<'a, H, E, M, N>
{
    pub(crate) fn new(system: &'a System<H, N>, method: M) -> Self {
        let dense = NalgebraVec::zeros(N, *method.problem().context());
        Self { system, method, equations: PhantomData, dense, limit: f64::NAN }
    }
}

impl<'a, H: Harvester<N>, E: Equations + 'a, M: OdeSolverMethod<'a, E>, const N: usize> Solver<N>
    for Implicit<'a, H, E, M, N>
{
    fn restart(&mut self, time: f64, state: &[f64; N], step: f64) -> Result<(), Stop> {
        let rates = self.system.harvester.rates(&self.system.mode.get(), time, state);
        let now = self.method.state_mut();
        now.y.batch_as_mut_slice(0).copy_from_slice(state);
        now.dy.batch_as_mut_slice(0).copy_from_slice(&rates);
        (*now.t, *now.h) = (time, step);
        Ok(())
    }

    fn step(&mut self, limit: f64) -> Result<(), Stop> {
        if limit != self.limit {
            self.method.set_stop_time(limit).map_err(stop)?;
            self.limit = limit;
        }
        if let OdeSolverStopReason::TstopReached = self.method.step().map_err(stop)? {
            // The method forgets the stop time with it.
            self.limit = f64::NAN;
        }
        Ok(())
    }

    fn time(&self) -> f64 {
        self.method.state().t
    }

    fn state(&self) -> [f64; N] {
        *whole(self.method.state().y.batch_as_slice(0))
    }

    fn at(&mut self, time: f64) -> Result<[f64; N], Stop> {
        self.method.interpolate_inplace(time, &mut self.dense).map_err(stop)?;
        Ok(*whole(self.dense.batch_as_slice(0)))
    }
}
