//! The accuracies whose tolerances are tried: 1 and 3 times the powers of ten.

/// The least accuracy that an option may ask for.
pub(super) const LOWEST: f64 = 1e-12;

/// The largest rung that is not above an accuracy, from the least one on.
pub(super) fn at_or_below(accuracy: f64) -> f64 {
    let decade = accuracy.log10().floor() as i32;
    // By their decimal texts, so that they are the numbers that options have.
    let rungs = (decade - 1..=decade + 1)
        .rev()
        .flat_map(|decade| [3, 1].map(|digit| format!("{digit}e{decade}").parse::<f64>().unwrap_or(LOWEST)));
    // A product such as 0.1 × 0.03 is a rung but for its rounding.
    let mut below = rungs.filter(|rung| *rung <= accuracy * (1.0 + 1e-12));
    below.next().unwrap_or(LOWEST).max(LOWEST)
}

/// The next rung below one.
pub(super) fn below(rung: f64) -> f64 {
    at_or_below(0.9 * rung)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rungs_are_one_and_three_times_powers_of_ten() {
        for (accuracy, rung) in [
            (1e-6, 1e-6),
            (0.1 * 0.03, 3e-3),
            (2e-3, 1e-3),
            (0.1, 0.1),
            (5e-2, 3e-2),
            (9.99e-5, 3e-5),
            (1e-12, 1e-12),
        ] {
            assert_eq!(at_or_below(accuracy), rung, "{accuracy}");
        }
        let mut all = vec![0.1];
        while let Some(&last) = all.last().filter(|last| **last > LOWEST) {
            all.push(below(last));
        }
        assert_eq!(all.len(), 23);
        assert!(all.windows(2).all(|pair| (2.9..3.5).contains(&(pair[0] / pair[1]))), "{all:?}");
    }
}
