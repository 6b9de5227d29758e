//! Percentiles, a yield with its interval, and which key matters.

use nalgebra::DVector;

/// Two-sided quantile of the normal distribution for 95 %.
const NORMAL_95: f64 = 1.959_963_984_540_054;
/// Least part of the deviation of a term of a fit that does not follow from the terms before it.
const LEAST_PIVOT: f64 = 1e-3;

/// The value below which a part of the samples is, linear between two of them (type 7 of Hyndman and Fan, 1996).
pub(super) fn percentile(sorted: &[f64], part: f64) -> f64 {
    let at = part.clamp(0.0, 1.0) * sorted.len().saturating_sub(1) as f64;
    let value = |index: usize| sorted.get(index).copied().unwrap_or(f64::NAN);
    let below = at as usize;
    // The last one has no next.
    let next = if at > below as f64 { value(below + 1) } else { value(below) };
    value(below) + (at - below as f64) * (next - value(below))
}

/// The 95 % confidence interval of a share that so many samples have given (Wilson, 1927).
pub(super) fn wilson(share: f64, count: usize) -> [f64; 2] {
    let (n, z) = (count as f64, NORMAL_95);
    let centre = share + z * z / (2.0 * n);
    let half = z * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    [-half, half].map(|side| ((centre + side) / (1.0 + z * z / n)).clamp(0.0, 1.0))
}

/// The samples, by their index in rising order, between which the value is with 95 % below which a part of all parts is
/// (order statistics at the quantiles of the binomial distribution); `None` where no sample is far enough out.
pub(super) fn ranks(part: f64, count: usize) -> [Option<usize>; 2] {
    const TAIL: f64 = 0.025;
    let (mut low, mut below) = (None, 0.0);
    let mut logarithm = count as f64 * libm::log1p(-part);
    for rank in 0..=count {
        // `below` is the probability of fewer than `rank` samples below the value.
        if below <= TAIL {
            low = rank.checked_sub(1);
        }
        if below >= 1.0 - TAIL {
            return [low, rank.checked_sub(1)];
        }
        below += libm::exp(logarithm);
        logarithm += libm::log((count - rank) as f64 / (rank + 1) as f64 * part / (1.0 - part));
    }
    [low, None]
}

/// Which key matters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sensitivities {
    /// Parts of the variance that a linear fit over all keys explains, and a quadratic one, each less what as many terms explain
    /// by chance (adjusted R²); `None` with too few samples.
    pub(super) r_squared: [Option<f64>; 2],
    pub(super) keys: Vec<Sensitivity>,
}

/// How a key matters; `None` for one that is constant or follows from others, and with too few samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Sensitivity {
    /// The part of the variance that the quadratic fit explains with the key only, its products with other keys included.
    pub(super) variance_share: Option<f64>,
    /// Standardised coefficient of the linear fit.
    pub(super) coefficient: Option<f64>,
}

/// Least number of samples for each term of a fit.
const SAMPLES_PER_TERM: usize = 3;

/// The sensitivities of a quantity to keys, by their values in the same samples.
pub(super) fn sensitivities(quantity: &[f64], keys: &[Vec<f64>]) -> Sensitivities {
    let of_unit = |vector: DVector<f64>| vector.add_scalar(-vector.mean()).normalize();
    let sought = of_unit(DVector::from_column_slice(quantity));
    let columns: Vec<_> = keys.iter().map(|key| of_unit(DVector::from_column_slice(key))).collect();
    let pairs = (0..keys.len()).flat_map(|one| (one..keys.len()).map(move |other| [one, other]));
    let products =
        pairs.map(|[one, other]| ([one, other], of_unit(columns[one].component_mul(&columns[other]))));
    let terms: Vec<_> =
        columns.iter().cloned().enumerate().map(|(key, column)| ([key; 2], column)).chain(products).collect();
    let explained = |columns: &mut dyn Iterator<Item = &DVector<f64>>| {
        let basis = independent(columns);
        let (samples, terms) = (quantity.len(), basis.len());
        let part = basis.iter().map(|column| column.dot(&sought).powi(2)).sum::<f64>();
        let freedom = samples.saturating_sub(1) as f64;
        let adjusted = 1.0 - (1.0 - part) * freedom / (freedom - terms as f64);
        (samples > SAMPLES_PER_TERM * terms).then_some(adjusted).filter(|part| part.is_finite())
    };
    let all = explained(&mut terms.iter().map(|(_, column)| column)).filter(|_| !keys.is_empty());
    let linear = independent(columns.iter()).len();
    let of_key = |key: usize| {
        let others = columns.iter().enumerate().filter(|(other, _)| *other != key).map(|(_, column)| column);
        let others = independent(others);
        // What is left of a key when all others are taken from it gives its coefficient (Frisch and Waugh, 1933).
        let own = residual(&columns[key], &others);
        if others.len() == linear || quantity.len() <= SAMPLES_PER_TERM * linear {
            return Sensitivity::default();
        }
        let without = terms.iter().filter(|(keys, _)| !keys.contains(&key)).map(|(_, column)| column);
        let without = explained(&mut { without });
        Sensitivity {
            variance_share: all.zip(without).map(|(all, without)| (all - without.max(0.0)).max(0.0)),
            coefficient: Some(own.dot(&sought) / own.norm_squared()).filter(|number| number.is_finite()),
        }
    };
    let first = explained(&mut columns.iter()).filter(|_| !keys.is_empty());
    Sensitivities { r_squared: [first, all], keys: (0..keys.len()).map(of_key).collect() }
}

/// What is left of a column when a basis is taken from it.
fn residual(column: &DVector<f64>, basis: &[DVector<f64>]) -> DVector<f64> {
    // Twice, against the rounding.
    [basis; 2].into_iter().flatten().fold(column.clone(), |left, taken| &left - taken * taken.dot(&left))
}

/// An orthonormal basis of some columns of unit length, without those that are constant or follow from columns before them.
fn independent<'a>(columns: impl Iterator<Item = &'a DVector<f64>>) -> Vec<DVector<f64>> {
    columns.fold(Vec::new(), |mut basis, column| {
        let left = residual(column, &basis);
        if left.norm() > LEAST_PIVOT {
            basis.push(left.normalize());
        }
        basis
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_and_intervals_are_those_of_the_tables() {
        let sorted = [1.0, 2.0, 4.0, 8.0];
        for (part, expected) in [(0.0, 1.0), (0.5, 3.0), (1.0, 8.0), (0.9, 6.8)] {
            assert!((percentile(&sorted, part) - expected).abs() < 1e-12, "{part}");
        }
        // Newcombe, Statistics in Medicine 17 (1998), table I, method 3.
        for (share, count, [low, high]) in [
            (81.0 / 263.0, 263, [0.2553, 0.3662]),
            (15.0 / 148.0, 148, [0.0624, 0.1605]),
            (0.0, 20, [0.0, 0.1611]),
        ] {
            let found = wilson(share, count);
            assert!((found[0] - low).abs() < 6e-5 && (found[1] - high).abs() < 6e-5, "{count}: {found:?}");
        }
    }

    #[test]
    fn the_interval_of_a_percentile_is_that_of_order_statistics() {
        // Conover, Practical nonparametric statistics: of the median the 40th to the 61st of 100, the ends of 6, none of 5.
        assert_eq!(ranks(0.5, 100), [Some(39), Some(60)]);
        assert_eq!(ranks(0.5, 6), [Some(0), Some(5)]);
        assert_eq!(ranks(0.5, 5), [None, None]);
        // 0.95^72 is the first below 0.025.
        assert!(ranks(0.05, 71)[0].is_none() && ranks(0.05, 72)[0] == Some(0));
        assert!(ranks(0.95, 71)[1].is_none() && ranks(0.95, 72)[1] == Some(71));
        assert_eq!(ranks(0.5, 0), [None, None]);
    }

    #[test]
    fn linear_coefficients_explain_a_plane_and_quadratic_ones_a_parabola_and_a_product() {
        // All pairs of a grid: both keys have the variance (21² − 1) / 12 and no correlation.
        let pairs = || (0..441).map(|index| [f64::from(index % 21 - 10), f64::from(index / 21 - 10)]);
        let keys = [0, 1].map(|key| pairs().map(|pair| pair[key]).collect::<Vec<f64>>());
        let plane: Vec<f64> = pairs().map(|[one, other]| 3.0 * one - 4.0 * other).collect();
        let near = |found: Option<f64>, expected: f64, by: f64| {
            found.is_some_and(|found| (found - expected).abs() < by)
        };
        let shares = |found: &Sensitivities, expected: [f64; 2]| {
            let each = found.keys.iter().zip(expected);
            each.into_iter().all(|(key, expected)| near(key.variance_share, expected, 0.01))
        };
        let found = sensitivities(&plane, &keys);
        assert!(near(found.r_squared[0], 1.0, 1e-12) && shares(&found, [0.36, 0.64]), "{found:?}");
        assert!(near(found.keys[0].coefficient, 0.6, 1e-12) && near(found.keys[1].coefficient, -0.8, 1e-12));
        let parabola: Vec<f64> = pairs().map(|[one, other]| one * one + other).collect();
        let found = sensitivities(&parabola, &keys);
        // The squares of -10 to 10 have the variance 1068.2222, the numbers 36.6667: this part of the sum is linear, of which
        // two terms explain 2/440 of the rest by chance.
        let linear = 1.0 - (1.0 - 0.033_185_84) * 440.0 / 438.0;
        assert!(near(found.r_squared[0], linear, 1e-8) && near(found.r_squared[1], 1.0, 1e-12), "{found:?}");
        assert!(shares(&found, [0.967, 0.033]), "{found:?}");
        // Of a product neither key explains anything alone.
        let product: Vec<f64> = pairs().map(|[one, other]| one * other).collect();
        let found = sensitivities(&product, &keys);
        assert!(near(found.r_squared[0], 0.0, 0.01) && shares(&found, [1.0, 1.0]), "{found:?}");
    }

    #[test]
    fn a_key_that_is_constant_or_follows_from_another_takes_nothing_from_the_others() {
        let values: Vec<f64> =
            (0..40).map(|index| f64::from(index % 7) + 0.1 * f64::from(index % 11)).collect();
        let other: Vec<f64> = (0..40).map(|index| f64::from(index % 5)).collect();
        let quantity: Vec<f64> = values.iter().zip(&other).map(|(one, other)| one + other).collect();
        let twice: Vec<f64> = other.iter().map(|value| 2.0 * value).collect();
        let found = sensitivities(&quantity, &[values.clone(), vec![3.0; 40]]);
        let alone = sensitivities(&quantity, std::slice::from_ref(&values));
        assert_eq!((found.keys[0], found.keys[1]), (alone.keys[0], Sensitivity::default()));
        let found = sensitivities(&quantity, &[values, other, twice]);
        assert!(found.keys[0].coefficient.is_some_and(|number| number > 0.5), "{found:?}");
        assert_eq!(found.keys[1..], [Sensitivity::default(); 2]);
        assert!(found.r_squared[0].is_some_and(|part| part > 1.0 - 1e-9));
    }

    #[test]
    fn noise_explains_nothing_and_few_samples_say_nothing() {
        let key = |of: u32| (0..60_u32).map(|index| f64::from((index * of) % 61)).collect::<Vec<f64>>();
        let found = sensitivities(&key(29), &[key(7), key(13)]);
        assert!(found.r_squared.iter().all(|part| part.is_some_and(|part| part < 0.3)), "{found:?}");
        let found = sensitivities(&[1.0, 2.0, 4.0], &[vec![1.0, 2.0, 3.0]]);
        assert_eq!(found, Sensitivities { r_squared: [None; 2], keys: vec![Sensitivity::default()] });
        assert_eq!(sensitivities(&[1.0; 441], &[vec![2.0; 441]]).keys, [Sensitivity::default()]);
    }
}
