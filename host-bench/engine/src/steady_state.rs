//! The periodic steady state of a harvester under one sine, by shooting.
//!
//! The state at one phase of the excitation determines the state a period later: the *period map* `P` of the hybrid system, impacts,
//! sticking, contact and the switching of a bridge included, is computed by the embedded core. A motion of one period is a fixed point
//!
//! ```text
//! P(x) = x
//! ```
//!
//! which Newton's iteration finds in about ten simulated periods, while a transient takes hundreds. The eigenvalues of
//! `∂P/∂x` at the fixed point are the Floquet multipliers: the motion is stable if all lie within the unit circle. A
//! circuit much slower than the motion has multipliers just below one and makes the search no longer.
//!
//! Several stable motions may exist. The motion that a run from the scene's start ends in is wanted: a transient comes
//! first, and a motion is accepted only if the transient approaches it.
//!
//! T. S. Parker and L. O. Chua, *Practical Numerical Algorithms for Chaotic Systems* (1989), chapter 5.

mod orbit;
mod period_map;
mod resonance;

use nalgebra::{Complex, DMatrix, DVector};

pub use orbit::{Orbit, Response, Verdict};
pub use period_map::{Coordinates, ForcedSystem, Spent, Total};
pub(crate) use period_map::{MOST_ATTEMPTS, Watching, given_up};
pub use resonance::{BestLoad, DEFAULT_POINTS, Peak, Resonance, best_load, resonance};

/// Size of the finite differences, relative to the scale of each entry.
///
/// Measured on an impacting motion at tolerances of 1e-3 and below, the map has a noise of 1e-11 of the scale, from the
/// rounding of events and the choice of steps, and a curvature of the order of 10. So the entries of the Jacobian are
/// accurate to about 1e-4. Below 1 Ω the noise is 1e-7 to 1e-6, because a change of the gap alone starts a transient much
/// faster than any step. A smaller difference would be lost in that noise.
const DIFFERENCE: f64 = 1e-5;
/// Iterations after which the search from a start ends.
const MOST_ITERATIONS: usize = 10;
/// Smallest part of a step that is tried.
const SMALLEST_PART: f64 = 1.0 / 8.0;
/// Part of the residual; a step that leaves more of it shows that the Jacobian has changed.
const POOR: f64 = 0.2;

/// A map linearised at a point, in units of the scale of each entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Linearisation {
    /// Derivative of entry `i` of the image by entry `j` of the point.
    jacobian: DMatrix<f64>,
    /// The entries that the map changes. An entry that keeps all bits is no unknown.
    unknowns: Vec<usize>,
}

impl Linearisation {
    /// Eigenvalues among the unknowns, the largest magnitude first.
    pub fn multipliers(&self) -> Vec<Complex<f64>> {
        if self.unknowns.is_empty() {
            return Vec::new();
        }
        let part = self.jacobian.select_rows(&self.unknowns).select_columns(&self.unknowns);
        let mut values: Vec<Complex<f64>> = part.complex_eigenvalues().iter().copied().collect();
        values.sort_by(|one, other| other.norm().total_cmp(&one.norm()));
        values
    }

    /// The change of the image that a small change of the point makes.
    pub fn image(&self, change: &[f64]) -> Vec<f64> {
        (&self.jacobian * DVector::from_column_slice(change)).as_slice().to_vec()
    }

    /// The solution of `(I − J) step = residual` among the unknowns; `None` if there is none.
    fn step(&self, residual: &DVector<f64>) -> Option<DVector<f64>> {
        let mut step = DVector::zeros(residual.len());
        if self.unknowns.is_empty() {
            return Some(step);
        }
        let size = self.unknowns.len();
        let matrix = DMatrix::identity(size, size)
            - self.jacobian.select_rows(&self.unknowns).select_columns(&self.unknowns);
        let solved = matrix.lu().solve(&residual.select_rows(&self.unknowns))?;
        for (&index, &value) in self.unknowns.iter().zip(solved.iter()) {
            step[index] = value;
        }
        step.iter().all(|value| value.is_finite()).then_some(step)
    }

    /// Broyden's update: the least change of the Jacobian with which `step` has the observed image.
    fn update(&mut self, step: &DVector<f64>, change: &DVector<f64>) {
        let square = step.norm_squared();
        if square > 0.0 {
            self.jacobian += (change - &self.jacobian * step) * step.transpose() / square;
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub struct FixedPoint {
    pub point: Vec<f64>,
    /// The map there.
    pub linearisation: Linearisation,
}

/// The iteration has not found a fixed point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NotFound {
    /// The least distance of a point that was tried from its image, in units of the scale of each entry: the root of the
    /// sum of the squares. Infinite if the map failed at the start.
    pub residual: f64,
}

/// A map of a vector, which fails where it returns `None`, and the scale of each entry.
#[expect(missing_debug_implementations, reason = "a closure has none")]
pub struct Map<'a> {
    /// The map.
    pub apply: &'a mut dyn FnMut(&[f64]) -> Option<Vec<f64>>,
    /// The scale of each entry.
    pub scale: Vec<f64>,
    /// Step, in units of the scale, below which a point counts as found.
    pub accuracy: f64,
}

impl Map<'_> {
    /// The fixed point that the iteration finds from `start`.
    ///
    /// `known` is a linearisation of the map nearby, if there is one.
    ///
    /// # Errors
    /// The residual that is left.
    pub fn fixed_point(
        &mut self,
        start: Vec<f64>,
        known: Option<Linearisation>,
    ) -> Result<FixedPoint, NotFound> {
        let mut point = start;
        let mut image = (self.apply)(&point).ok_or(NotFound { residual: f64::INFINITY })?;
        let mut least = NotFound { residual: self.scaled(&image, &point).norm() };
        let mut fresh = known.is_none();
        let mut linear = match known {
            Some(linear) => linear,
            None => self.linearise(&point, &image).ok_or(least)?,
        };
        for _ in 0..MOST_ITERATIONS {
            let residual = self.scaled(&image, &point);
            least.residual = least.residual.min(residual.norm());
            let step = linear.step(&residual);
            if let Some(step) = step.as_ref().filter(|step| fresh && step.amax() < self.accuracy) {
                return Ok(FixedPoint { point: self.moved(&point, step), linearisation: linear });
            }
            let next = step.as_ref().and_then(|step| self.descend(&point, step, residual.norm()));
            let Some((next, next_image)) = next else {
                if fresh {
                    return Err(least);
                }
                linear = self.linearise(&point, &image).ok_or(least)?;
                fresh = true;
                continue;
            };
            let remaining = self.scaled(&next_image, &next).norm();
            linear.update(&self.scaled(&next, &point), &self.scaled(&next_image, &image));
            (point, image) = (next, next_image);
            let small = step.is_some_and(|step| step.amax() < self.accuracy);
            fresh = small || remaining > POOR * residual.norm();
            if fresh {
                linear = self.linearise(&point, &image).ok_or(least)?;
            }
        }
        // The last iteration may have arrived.
        let residual = self.scaled(&image, &point);
        least.residual = least.residual.min(residual.norm());
        match linear.step(&residual) {
            Some(step) if fresh && step.amax() < self.accuracy => {
                Ok(FixedPoint { point: self.moved(&point, &step), linearisation: linear })
            }
            _ => Err(least),
        }
    }

    /// The farthest point along `step` at which the residual is less, with its image. A step below the accuracy is taken
    /// whole, because the residual may be noise.
    fn descend(&mut self, point: &[f64], step: &DVector<f64>, residual: f64) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut part = 1.0;
        while part >= SMALLEST_PART {
            let next = self.moved(point, &(step * part));
            if let Some(image) = (self.apply)(&next)
                && (self.scaled(&image, &next).norm() < (1.0 - 0.1 * part) * residual
                    || step.amax() < self.accuracy)
            {
                return Some((next, image));
            }
            part *= 0.5;
        }
        None
    }

    fn linearise(&mut self, point: &[f64], image: &[f64]) -> Option<Linearisation> {
        let size = point.len();
        let mut jacobian = DMatrix::zeros(size, size);
        let mut handed_on: Vec<bool> =
            point.iter().zip(image).map(|(before, after)| before == after).collect();
        for column in 0..size {
            let mut beside = point.to_vec();
            beside[column] += DIFFERENCE * self.scale[column];
            // The difference after rounding.
            let difference = (beside[column] - point[column]) / self.scale[column];
            let beside_image = (self.apply)(&beside)?;
            jacobian.set_column(column, &(self.scaled(&beside_image, image) / difference));
            for index in 0..size {
                handed_on[index] &= beside_image[index] == beside[index];
            }
        }
        let unknowns = (0..size).filter(|&index| !handed_on[index]).collect();
        Some(Linearisation { jacobian, unknowns })
    }

    fn scaled(&self, one: &[f64], other: &[f64]) -> DVector<f64> {
        let entries = one.iter().zip(other).zip(&self.scale);
        DVector::from_iterator(one.len(), entries.map(|((one, other), scale)| (one - other) / scale))
    }

    fn moved(&self, point: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let entries = point.iter().zip(&self.scale).zip(step.iter());
        entries.map(|((entry, scale), step)| entry + scale * step).collect()
    }
}
