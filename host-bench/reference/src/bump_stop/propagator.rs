//! Exact propagation of `y' = A y` over a grid step and its binary fractions, and exact integrals of
//! quadratic forms of `y` along the way.
//!
//! The exponential is stored as `E = exp(A h) − 1`, so that slow modes keep their digits beside fast ones in a stiff circuit. `E` of a
//! very short step is a few terms of the series, and `E ← 2E + E²` doubles the step. The integral of `yᵀ M y` over a step is `y₀ᵀ G y₀`
//! with the Gramian `G`, doubled as `G ← G + (1+E)ᵀ G (1+E)`.

use nalgebra::DMatrix;

use crate::ledger::Integrals;

/// Binary digits of a time within a grid step.
pub(super) const DIGITS: u32 = 40;

/// Ticks of a whole grid step.
pub(super) const WHOLE: u64 = 1 << DIGITS;

/// Number of quadratic forms that are integrated: one for each of the [`Integrals`].
pub(super) const FORMS: usize = 10;

/// Terms of the series at the shortest step, whose norm is at most 2⁻⁸.
const TERMS: u32 = 8;

/// Steps after which the moments are summed up, so that rounding stays small.
const BATCH: u32 = 1 << 12;

/// Propagation over `step / 2^level` for each level.
pub(super) struct Propagator {
    size: usize,
    /// Grid step in s.
    step: f64,
    levels: Vec<Level>,
}

struct Level {
    /// `exp(A h) − 1`.
    increment: DMatrix<f64>,
    gramians: [DMatrix<f64>; FORMS],
}

impl Propagator {
    /// For a system, a grid step in s and symmetric forms.
    pub(super) fn new(matrix: &DMatrix<f64>, step: f64, forms: &[DMatrix<f64>; FORMS]) -> Self {
        let size = matrix.nrows();
        let norm = matrix.column_iter().map(|column| column.abs().sum()).fold(0.0, f64::max) * step;
        let deepest = (norm.log2().ceil() as i32 + 8).max(DIGITS as i32);
        let shortest = step * 0.5f64.powi(deepest);
        let generator = matrix * shortest;
        let mut increment = DMatrix::zeros(size, size);
        let mut term = DMatrix::identity(size, size);
        for n in 1..=TERMS {
            term = &term * &generator / f64::from(n);
            increment += &term;
        }
        let mut gramians = forms.each_ref().map(|form| {
            // Derivatives of (exp)ᵀ M exp at 0, divided by factorials.
            let (mut term, mut sum) = (form * shortest, form * shortest);
            for n in 2..=TERMS {
                let product = &term * &generator;
                term = (&product + product.transpose()) / f64::from(n);
                sum += &term;
            }
            sum
        });
        let mut levels = Vec::new();
        for depth in (0..=deepest).rev() {
            if depth <= DIGITS as i32 {
                levels.push(Level { increment: increment.clone(), gramians: gramians.clone() });
            }
            for gramian in &mut gramians {
                let once = &*gramian + &*gramian * &increment;
                *gramian += &once + increment.tr_mul(&once);
            }
            increment = &increment * 2.0 + &increment * &increment;
        }
        levels.reverse();
        Self { size, step, levels }
    }

    /// Length of a tick in s.
    pub(super) fn tick(&self) -> f64 {
        self.step / WHOLE as f64
    }

    /// Moves a vector on by one step of a level, out of place.
    fn step(&self, level: usize, from: &[f64], to: &mut [f64]) {
        to.copy_from_slice(from);
        let increment = self.levels[level].increment.as_slice();
        // Four columns at a time, for speed: a run spends its time here.
        let (fours, rest) = (increment.chunks_exact(4 * self.size), from.chunks_exact(4).remainder());
        let columns = fours.remainder().chunks_exact(self.size);
        for (columns, weights) in fours.zip(from.chunks_exact(4)) {
            let (first, others) = columns.split_at(self.size);
            let (second, others) = others.split_at(self.size);
            let (third, fourth) = others.split_at(self.size);
            let others = second.iter().zip(third.iter().zip(fourth));
            for (entry, (first, (second, (third, fourth)))) in to.iter_mut().zip(first.iter().zip(others)) {
                *entry +=
                    (weights[0] * first + weights[1] * second) + (weights[2] * third + weights[3] * fourth);
            }
        }
        for (column, weight) in columns.zip(rest) {
            for (entry, increment) in to.iter_mut().zip(column) {
                *entry += weight * increment;
            }
        }
    }

    /// The vector `ticks` after `from`.
    pub(super) fn advance(&self, from: &[f64], ticks: u64, to: &mut Vec<f64>) {
        self.walk(from, ticks, to, |_, _| {});
    }

    /// As [`Self::advance`]; adds the moments of the path.
    pub(super) fn advance_measured(
        &self,
        from: &[f64],
        ticks: u64,
        to: &mut Vec<f64>,
        moments: &mut Moments,
    ) {
        self.walk(from, ticks, to, |level, vector| moments.add(self, level, vector));
    }

    /// Advances by `ticks` from `from` and shows the level and the start of each step to `visit`.
    fn walk(&self, from: &[f64], ticks: u64, to: &mut Vec<f64>, mut visit: impl FnMut(usize, &[f64])) {
        to.resize(from.len(), 0.0);
        if ticks == WHOLE {
            visit(0, from);
            self.step(0, from, to);
            return;
        }
        to.copy_from_slice(from);
        let mut here = from.to_vec();
        for level in (0..self.levels.len()).filter(|level| ticks & (WHOLE >> level) != 0) {
            visit(level, &here);
            self.step(level, &here, to);
            here.copy_from_slice(to);
        }
    }

    /// The first tick after the vector `from` at which `past` holds; `past` holds at `until` and changes once.
    pub(super) fn first_past(&self, from: &[f64], until: u64, past: impl Fn(&[f64]) -> bool) -> u64 {
        let (mut here, mut there) = (from.to_vec(), from.to_vec());
        let mut offset = 0;
        for level in 0..self.levels.len() {
            let ticks = WHOLE >> level;
            if offset + ticks >= until {
                continue;
            }
            self.step(level, &here, &mut there);
            if !past(&there) {
                std::mem::swap(&mut here, &mut there);
                offset += ticks;
            }
        }
        offset + 1
    }
}

/// Sums of `y yᵀ` over the steps of each level, from which the integrals of all quadratic forms follow.
pub(super) struct Moments {
    /// For each level the number of steps, and the sums below and on the diagonal, column by column.
    levels: Vec<(u32, Vec<f64>)>,
    integrals: Integrals,
}

impl Moments {
    pub(super) fn new() -> Self {
        Self { levels: vec![(0, Vec::new()); DIGITS as usize + 1], integrals: [0.0; FORMS] }
    }

    /// Adds the moments of a step of a level from a vector; level 0 is a whole grid step.
    pub(super) fn add(&mut self, propagator: &Propagator, level: usize, vector: &[f64]) {
        let (count, sums) = &mut self.levels[level];
        sums.resize(propagator.size * (propagator.size + 1) / 2, 0.0);
        let mut rest = sums.as_mut_slice();
        for (column, entry) in vector.iter().enumerate() {
            let (here, after) = rest.split_at_mut(vector.len() - column);
            for (sum, other) in here.iter_mut().zip(&vector[column..]) {
                *sum += entry * other;
            }
            rest = after;
        }
        *count += 1;
        if *count == BATCH {
            self.sum_up(propagator, level);
        }
    }

    fn sum_up(&mut self, propagator: &Propagator, level: usize) {
        let (count, sums) = &mut self.levels[level];
        if *count == 0 {
            return;
        }
        for (integral, gramian) in self.integrals.iter_mut().zip(&propagator.levels[level].gramians) {
            let mut rest = sums.as_slice();
            for column in 0..propagator.size {
                let (here, after) = rest.split_at(propagator.size - column);
                let weights = &gramian.column(column);
                let weights = &weights.as_slice()[column..];
                let twice: f64 = here.iter().zip(weights).map(|(sum, weight)| sum * weight).sum();
                *integral += 2.0 * twice - here[0] * weights[0];
                rest = after;
            }
        }
        *count = 0;
        sums.fill(0.0);
    }

    /// The integrals of the forms since the last call.
    pub(super) fn take(&mut self, propagator: &Propagator) -> Integrals {
        for level in 0..self.levels.len() {
            self.sum_up(propagator, level);
        }
        std::mem::take(&mut self.integrals)
    }
}

#[cfg(test)]
mod tests;
