//! The explicit Runge-Kutta methods of Dormand and Prince, of the crate `differential-equations`.
//!
//! The crate's own event search is not used, because it may return a time that is no zero.

use differential_equations::error::Error;
use differential_equations::interpolate::Interpolation;
use differential_equations::ode::{ODE, OrdinaryNumericalMethod};
use differential_equations::status::Status;

use super::Solver;
use crate::Stop;
use crate::harvester::{Harvester, System};

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

fn stop<const N: usize>(error: Error<f64, [f64; N]>) -> Stop {
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
        self.method.init(self.system, time, f64::INFINITY, state).map_err(stop)?;
        self.method.set_h(step);
        Ok(())
    }

    fn step(&mut self, limit: f64) -> Result<(), Stop> {
        for _ in 0..MOST_REJECTIONS {
            let left = limit - self.method.t();
            if self.method.h() > left {
                self.method.set_h(left);
            }
            self.method.step(self.system).map_err(stop)?;
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
        self.method.interpolate(time).map_err(stop)
    }
}
