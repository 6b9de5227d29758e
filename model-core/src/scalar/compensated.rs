//! Compensated sums, which keep the part that a plain addition rounds away (Kahan 1965, with the comparison
//! of Neumaier 1974).

use super::Scalar;
use crate::snapshot::snapshot_fields;

/// A running sum whose error stays at one rounding of the result for any number of terms.
///
/// A term may be larger than the sum so far. Each addition includes the correction of the previous one, so
/// the correction never exceeds a rounding of the sum.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct CompensatedSum<S> {
    sum: S,
    correction: S,
}

impl<S: Scalar> CompensatedSum<S> {
    /// The empty sum.
    pub(crate) const ZERO: Self = Self { sum: S::ZERO, correction: S::ZERO };

    /// Adds `term`.
    #[inline]
    pub(crate) fn add(&mut self, term: S) {
        let moved = term + self.correction;
        let total = self.sum + moved;
        self.correction = if self.sum.abs() >= moved.abs() {
            (self.sum - total) + moved
        } else {
            (moved - total) + self.sum
        };
        self.sum = total;
    }

    /// The sum, rounded once.
    #[inline]
    pub(crate) fn value(&self) -> S {
        self.sum + self.correction
    }
}

snapshot_fields!(impl [S: Scalar] CompensatedSum<S> { sum, correction });

/// `high + low + increment` as a new pair, in which `low` is the part that rounding removed from `high`.
///
/// For a state with small increments. Without the branch of [`CompensatedSum::add`], an increment larger than
/// the state is added with the rounding of a plain addition.
#[inline]
pub(crate) fn add_increment<S: Scalar>(high: S, low: S, increment: S) -> (S, S) {
    let moved = increment + low;
    let sum = high + moved;
    (sum, moved - (sum - high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_of_microjoules_does_not_drift_in_single_precision() {
        let (mut compensated, mut plain) = (CompensatedSum::<f32>::ZERO, 0.0_f32);
        let terms = 86_400_u32 * 100;
        for k in 0..terms {
            let term = 1e-8 * (1.0 + 0.5 * ((k % 7) as f32));
            compensated.add(term);
            plain += term;
        }
        let mut exact = 0.0_f64;
        for k in 0..terms {
            exact += f64::from(1e-8_f32 * (1.0 + 0.5 * ((k % 7) as f32)));
        }
        assert!((f64::from(compensated.value()) / exact - 1.0).abs() < 1e-7);
        assert!((f64::from(plain) / exact - 1.0).abs() > 1e-4, "the plain sum is expected to drift");
    }

    #[test]
    fn increments_below_a_unit_in_the_last_place_are_kept() {
        let (mut high, mut low) = (3e-3_f32, 0.0_f32);
        for _ in 0..1_000_000 {
            (high, low) = add_increment(high, low, 1e-12);
        }
        assert!((high - 3.001e-3).abs() < 1e-9, "{high}");
    }
}
