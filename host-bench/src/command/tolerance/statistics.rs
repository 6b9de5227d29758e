//! Percentiles, a yield with its interval, and which key matters.

use nalgebra::{DMatrix, DVector};

/// Two-sided quantile of the normal distribution for 95 %.
const NORMAL_95: f64 = 1.959_963_984_540_054;
/// Least part of the deviation of a term of a fit that does not follow from the terms before it.
const LEAST_PIVOT: f64 = 1e-6;

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

/// The parts of the variance of a quantity that a linear fit and a quadratic one over all keys explain (R²); and of each key the
/// part that the quadratic fit explains with it only, its products with other keys included, and its standardised coefficient of
/// the linear fit.
pub(super) fn sensitivities(
    quantity: &[f64],
    keys: &[Vec<f64>],
) -> ([Option<f64>; 2], Vec<[Option<f64>; 2]>) {
    let of_unit = |vector: DVector<f64>| vector.add_scalar(-vector.mean()).normalize();
    let sought = of_unit(DVector::from_column_slice(quantity));
    let columns: Vec<_> = keys.iter().map(|key| of_unit(DVector::from_column_slice(key))).collect();
    let fit = |columns: &[DVector<f64>]| {
        if columns.is_empty() || quantity.len() < columns.len() + 2 {
            return None;
        }
        let matrix = DMatrix::from_columns(columns);
        let slopes = matrix.tr_mul(&sought);
        // Keys that are constant or follow from others have no coefficient of their own.
        let solved = matrix
            .tr_mul(&matrix)
            .cholesky()
            .filter(|solved| solved.l_dirty().diagonal().min() > LEAST_PIVOT)?;
        let found = solved.solve(&slopes);
        Some((found.dot(&slopes), found)).filter(|(part, _)| part.is_finite())
    };
    let pairs = (0..keys.len()).flat_map(|one| (one..keys.len()).map(move |other| [one, other]));
    let products =
        pairs.map(|[one, other]| ([one, other], of_unit(columns[one].component_mul(&columns[other]))));
    let terms: Vec<_> =
        columns.iter().cloned().enumerate().map(|(key, column)| ([key; 2], column)).chain(products).collect();
    // Less what as many terms explain by chance.
    let quadratic = |without: Option<usize>| {
        let terms = terms.iter().filter(|(keys, _)| without.is_none_or(|key| !keys.contains(&key)));
        let columns: Vec<_> = terms.map(|(_, column)| column.clone()).collect();
        let freedom = (quantity.len() - 1) as f64;
        fit(&columns).map(|(part, _)| 1.0 - (1.0 - part) * freedom / (freedom - columns.len() as f64))
    };
    let (linear, all) = (fit(&columns), quadratic(None));
    let of_key = |key: usize| {
        let others = if keys.len() == 1 { Some(0.0) } else { quadratic(Some(key)) };
        [
            all.zip(others).map(|(all, others)| (all - others).max(0.0)),
            linear.as_ref().map(|found| found.1[key]),
        ]
    };
    ([linear.as_ref().map(|found| found.0), all], (0..keys.len()).map(of_key).collect())
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
    fn linear_coefficients_explain_a_plane_and_quadratic_ones_a_parabola_and_a_product() {
        // All pairs of a grid: both keys have the variance (21² − 1) / 12 and no correlation.
        let pairs = || (0..441).map(|index| [f64::from(index % 21 - 10), f64::from(index / 21 - 10)]);
        let keys = [0, 1].map(|key| pairs().map(|pair| pair[key]).collect::<Vec<f64>>());
        let plane: Vec<f64> = pairs().map(|[one, other]| 3.0 * one - 4.0 * other).collect();
        let near = |found: Option<f64>, expected: f64, by: f64| {
            found.is_some_and(|found| (found - expected).abs() < by)
        };
        let ([r_squared, _], matter) = sensitivities(&plane, &keys);
        assert!(near(r_squared, 1.0, 1e-12));
        assert!(near(matter[0][1], 0.6, 1e-12) && near(matter[1][1], -0.8, 1e-12), "{matter:?}");
        assert!(near(matter[0][0], 0.36, 0.01) && near(matter[1][0], 0.64, 0.01), "{matter:?}");
        let parabola: Vec<f64> = pairs().map(|[one, other]| one * one + other).collect();
        let ([r_squared, quadratic], matter) = sensitivities(&parabola, &keys);
        // The squares of -10 to 10 have the variance 1068.2222, the numbers 36.6667: this part of the sum is linear.
        assert!(near(r_squared, 0.033_185_84, 1e-8));
        assert!(
            near(quadratic, 1.0, 1e-12) && near(matter[0][0], 0.967, 0.01) && near(matter[1][0], 0.033, 0.01),
            "{matter:?}"
        );
        // A key that follows from another one has no coefficient of its own.
        let ([r_squared, _], matter) = sensitivities(&plane, &[keys[0].clone(), keys[0].clone()]);
        assert!(r_squared.is_none() && matter == [[None; 2]; 2]);
        // Of a product neither key explains anything alone.
        let product: Vec<f64> = pairs().map(|[one, other]| one * other).collect();
        let ([r_squared, _], matter) = sensitivities(&product, &keys);
        assert!(
            near(r_squared, 0.0, 1e-12) && matter.iter().all(|key| near(key[0], 1.0, 0.01)),
            "{matter:?}"
        );
        assert_eq!(sensitivities(&[1.0; 441], &keys), ([None; 2], vec![[None; 2]; 2]));
    }
}
