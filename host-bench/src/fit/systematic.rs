//! Whether residuals are systematic: runs of one sign (A. Wald and J. Wolfowitz, *On a test whether two samples are from the
//! same population*, Annals of Mathematical Statistics 11 (1940) 147), here of several sequences together.

/// Least number of residuals that are judged.
const LEAST: f64 = 8.0;
/// Standard deviations by which the runs must be fewer than those of chance: one in 700.
const DEVIATIONS: f64 = 3.0;

/// Runs of one sign in one or several sequences of residuals.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Runs {
    /// Residuals above and below zero.
    above: f64,
    below: f64,
    /// Neighbours in a sequence, and pairs of such neighbours that have a residual in common.
    neighbours: f64,
    overlaps: f64,
    sequences: usize,
    pub(super) count: usize,
}

impl Runs {
    /// Adds a sequence of residuals in their order.
    pub(super) fn add(&mut self, residuals: impl IntoIterator<Item = f64>) {
        let signs: Vec<bool> = residuals
            .into_iter()
            .filter(|residual| *residual != 0.0)
            .map(|residual| residual > 0.0)
            .collect();
        if signs.is_empty() {
            return;
        }
        let above = signs.iter().filter(|sign| **sign).count();
        self.above += above as f64;
        self.below += (signs.len() - above) as f64;
        self.neighbours += (signs.len() - 1) as f64;
        self.overlaps += signs.len().saturating_sub(2) as f64;
        self.sequences += 1;
        self.count += 1 + signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
    }

    /// Mean of the number of runs, and its variance, where all orders of the signs over all sequences are equally likely, so
    /// that a sequence of one sign beside one of the other is unlikely. With `n₊` and `n₋` signs of each kind, neighbours
    /// differ with the probability `p = 2 n₊ n₋/(n (n − 1))`, two pairs of them with a residual in common with `p/2`, and two
    /// without with `4 n₊ (n₊ − 1) n₋ (n₋ − 1)/(n (n − 1) (n − 2) (n − 3))`.
    pub(super) fn expected(&self) -> [f64; 2] {
        let Self { above, below, neighbours, overlaps, .. } = *self;
        let all = above + below;
        if all < 4.0 {
            return [self.count as f64, 0.0];
        }
        let one = 2.0 * above * below / (all * (all - 1.0));
        let apart = 2.0 * one * (above - 1.0) * (below - 1.0) / ((all - 2.0) * (all - 3.0));
        let mean = neighbours * one;
        let pairs = neighbours * (neighbours - 1.0) / 2.0;
        let square = mean + overlaps * one + 2.0 * (pairs - overlaps) * apart;
        [self.sequences as f64 + mean, (square - mean * mean).max(0.0)]
    }

    /// Whether the runs are so few that the residuals hang together.
    pub(super) fn are_systematic(&self) -> bool {
        let [expected, variance] = self.expected();
        self.above + self.below >= LEAST && (self.count as f64) < expected - DEVIATIONS * variance.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(residuals: impl IntoIterator<Item = f64>) -> Runs {
        let mut runs = Runs::default();
        runs.add(residuals);
        runs
    }

    #[test]
    fn a_slow_wave_is_systematic_and_alternating_or_random_signs_are_not() {
        let wave = runs((0..40).map(|index| (f64::from(index) * std::f64::consts::TAU / 20.0 + 0.1).sin()));
        assert_eq!(wave.count, 4);
        assert!((wave.expected()[0] - 21.0).abs() < 0.2 && wave.are_systematic(), "{wave:?}");
        let alternating = runs((0..40).map(|index| if index % 2 == 0 { 1.0 } else { -1.0 }));
        assert!(alternating.count == 40 && !alternating.are_systematic());
        // The parity of the binary digits: the sequence of Thue and Morse.
        let mixed = runs((0..64_u32).map(|index| f64::from(index.count_ones() % 2) - 0.5));
        assert!(!mixed.are_systematic(), "{mixed:?}");
    }

    /// All orders of five positive and four negative residuals, in one sequence and in three.
    #[test]
    fn mean_and_variance_are_those_of_all_orders() {
        for lengths in [&[9][..], &[5, 3, 1], &[7, 2]] {
            let (mut sum, mut squares, mut orders) = (0.0, 0.0, 0.0);
            let mut stated = Runs::default();
            for order in (0..1_u32 << 9).filter(|order| order.count_ones() == 5) {
                let mut residuals = (0..9).map(|bit| if order >> bit & 1 == 1 { 1.0 } else { -1.0 });
                stated = Runs::default();
                for &length in lengths {
                    stated.add(residuals.by_ref().take(length));
                }
                sum += stated.count as f64;
                squares += (stated.count as f64).powi(2);
                orders += 1.0;
            }
            let (mean, [expected, variance]) = (sum / orders, stated.expected());
            assert!((expected - mean).abs() < 1e-12, "{lengths:?}: {mean}");
            assert!((variance - (squares / orders - mean * mean)).abs() < 1e-12, "{lengths:?}");
        }
    }

    #[test]
    fn a_sequence_of_each_sign_is_systematic() {
        let mut apart = Runs::default();
        for sign in [1.0, -1.0] {
            apart.add([sign; 10]);
        }
        assert!(apart.count == 2 && apart.are_systematic(), "{apart:?}");
    }

    #[test]
    fn few_residuals_are_not_judged() {
        assert!(!runs([1.0, 1.0, 1.0, -1.0, -1.0, -1.0]).are_systematic());
        assert!(!runs([1.0; 12]).are_systematic(), "one sign alone has one run in every order");
    }
}
