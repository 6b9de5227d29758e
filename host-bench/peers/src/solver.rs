//! The integrators of other crates behind one interface.

pub(crate) mod explicit;
pub(crate) mod implicit;

use crate::Stop;

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
