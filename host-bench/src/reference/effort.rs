//! What the integrator did, and what it says when it cannot go on.

use diffsol::error::DiffsolError;
use diffsol::ode_solver::OdeSolverStatistics;

/// How hard the integrator worked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Effort {
    pub(super) steps: u64,
    pub(super) rejected: u64,
    pub(super) newton_iterations: u64,
}

impl Effort {
    pub(super) fn of(statistics: &OdeSolverStatistics) -> Self {
        let rejected = statistics.number_of_error_test_failures + statistics.number_of_nonlinear_solver_fails;
        Self {
            steps: statistics.number_of_steps as u64,
            rejected: rejected as u64,
            newton_iterations: statistics.number_of_nonlinear_solver_iterations as u64,
        }
    }

    pub(super) fn add(&mut self, more: &Self) {
        self.steps += more.steps;
        self.rejected += more.rejected;
        self.newton_iterations += more.newton_iterations;
    }
}

/// The first line of an error of the crate: some of them are several lines long. Times in it are those
/// of the stretch of motion that was integrated.
pub(super) fn one_line(error: &DiffsolError) -> String {
    let text = error.to_string();
    format!("integrator, in the time of the flight: {}", text.lines().next().unwrap_or("failed"))
}
