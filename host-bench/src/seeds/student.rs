//! Student's t distribution.

use harvester_scene::root::far_side;

/// The probability that Student's t with `freedom` degrees of freedom is within `±t`: the finite sums of Abramowitz and
/// Stegun, 26.7.3 and 26.7.4.
fn probability(freedom: u32, t: f64) -> f64 {
    let angle = (t / f64::from(freedom).sqrt()).atan();
    let (sine, square) = (angle.sin(), angle.cos().powi(2));
    let first = if freedom.is_multiple_of(2) { 2 } else { 3 };
    // `1 + 1/2 cos² + …` of an even number, `cos + 2/3 cos³ + …` of an odd one.
    let (mut term, mut sum) = (1.0, 0.0);
    let mut n = first;
    while n <= freedom {
        sum += term;
        term *= square * f64::from(n - 1) / f64::from(n);
        n += 2;
    }
    if freedom.is_multiple_of(2) {
        sine * sum
    } else {
        std::f64::consts::FRAC_2_PI * (angle + sine * angle.cos() * sum)
    }
}

/// The `t` within `±` which Student's t with `freedom` degrees of freedom, at least 1, is with a probability.
pub(crate) fn quantile(freedom: u32, confidence: f64) -> f64 {
    let excess = |t: f64| Ok::<f64, std::convert::Infallible>(probability(freedom.max(1), t) - confidence);
    let Ok(t) = far_side(excess, 0.0, 1e3);
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Two-sided 95 %, from the usual tables; the last is that of a Gaussian.
        for (freedom, expected) in
            [(1, 12.706), (2, 4.303), (3, 3.182), (9, 2.262), (19, 2.093), (30, 2.042), (100_000, 1.960)]
        {
            let found = quantile(freedom, 0.95);
            assert!((found - expected).abs() < 6e-4, "{freedom}: {found}");
        }
        assert!((quantile(10, 0.99) - 3.169).abs() < 6e-4);
        // One and two degrees of freedom have closed forms.
        assert!((quantile(1, 0.9) - (0.45 * std::f64::consts::PI).tan()).abs() < 1e-12);
        let two = 0.9 * (2.0 / (1.0 - 0.81_f64)).sqrt();
        assert!((quantile(2, 0.9) - two).abs() < 1e-12);
    }
}
