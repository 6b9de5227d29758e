//! Whether residuals are systematic: runs of one sign (A. Wald and J. Wolfowitz, *On a test whether two samples are from the
//! same population*, Annals of Mathematical Statistics 11 (1940) 147).

/// Least number of residuals that are judged.
const LEAST: usize = 8;
/// Standard deviations by which the runs must be fewer than those of chance: one in 700.
const DEVIATIONS: f64 = 3.0;

/// The number of runs in one or several sequences of residuals, beside that of independent signs.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Runs {
    signs: usize,
    pub(super) count: usize,
    pub(super) expected: f64,
    variance: f64,
}

impl Runs {
    /// Adds a sequence of residuals in their order. With `n₊` and `n₋` residuals of each sign, independent signs have
    /// `1 + 2 n₊ n₋/n` runs on average, with a variance of `(μ − 1)(μ − 2)/(n − 1)`.
    pub(super) fn add(&mut self, residuals: impl IntoIterator<Item = f64>) {
        let signs: Vec<bool> = residuals
            .into_iter()
            .filter(|residual| *residual != 0.0)
            .map(|residual| residual > 0.0)
            .collect();
        if signs.len() < 2 {
            return;
        }
        let all = signs.len() as f64;
        let above = signs.iter().filter(|sign| **sign).count() as f64;
        let expected = 1.0 + 2.0 * above * (all - above) / all;
        self.signs += signs.len();
        self.count += 1 + signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
        self.expected += expected;
        self.variance += ((expected - 1.0) * (expected - 2.0) / (all - 1.0)).max(0.0);
    }

    /// Whether the runs are so few that the residuals hang together.
    pub(super) fn are_systematic(&self) -> bool {
        self.signs >= LEAST && (self.count as f64) < self.expected - DEVIATIONS * self.variance.sqrt()
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
        assert!((wave.expected - 21.0).abs() < 0.2 && wave.are_systematic(), "{wave:?}");
        let alternating = runs((0..40).map(|index| if index % 2 == 0 { 1.0 } else { -1.0 }));
        assert!(alternating.count == 40 && !alternating.are_systematic());
        // The parity of the binary digits: the sequence of Thue and Morse.
        let mixed = runs((0..64_u32).map(|index| f64::from(index.count_ones() % 2) - 0.5));
        assert!(!mixed.are_systematic(), "{mixed:?}");
    }

    /// All orders of five positive and four negative residuals.
    #[test]
    fn mean_and_variance_are_those_of_all_orders() {
        let (mut sum, mut squares, mut orders) = (0.0, 0.0, 0.0);
        let mut stated = Runs::default();
        for order in (0..1_u32 << 9).filter(|order| order.count_ones() == 5) {
            let residuals = (0..9).map(|bit| if order >> bit & 1 == 1 { 1.0 } else { -1.0 });
            stated = runs(residuals);
            sum += stated.count as f64;
            squares += (stated.count as f64).powi(2);
            orders += 1.0;
        }
        let mean = sum / orders;
        assert!((stated.expected - mean).abs() < 1e-12, "{mean}");
        assert!((stated.variance - (squares / orders - mean * mean)).abs() < 1e-12);
    }

    #[test]
    fn few_residuals_are_not_judged() {
        assert!(!runs([1.0, 1.0, 1.0, -1.0, -1.0, -1.0]).are_systematic());
        assert!(!runs([1.0; 12]).are_systematic(), "one sign alone has one run in every order");
    }
}
