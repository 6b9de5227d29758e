//! Columns that the model does not follow at the solution, and whether a wrong unit may be why.

use super::model::Problem;
use super::solve::Solved;

/// Relative residual above which the model does not follow a column: 9 % of its mean square are then left. Noise of a usable
/// measurement leaves less, and so does the wrong branch of a bistable band (0.18 in the test of such sweeps).
const UNFOLLOWED: f64 = 0.3;
/// Most by which a ratio is off a power of a thousand that a prefix of a unit would be.
const NEAR: f64 = 2.0;

/// A measured column that the model does not follow.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Unfollowed {
    column: String,
    /// Relative residual.
    residual: f64,
    /// Medians of the magnitudes of data over model: at the solution, and at the start. `None` where the model is 0.
    ratios: [Option<f64>; 2],
}

impl Unfollowed {
    /// The columns of a solution with these relative residuals that it does not follow.
    pub(super) fn of(problem: &Problem<'_>, solved: &Solved, residuals: &[(String, f64)]) -> Vec<Self> {
        let large: Vec<&(String, f64)> =
            residuals.iter().filter(|(_, residual)| !(*residual <= UNFOLLOWED)).collect();
        if large.is_empty() {
            return Vec::new();
        }
        let start: Vec<f64> = problem.free.iter().map(|free| free.coordinate(free.start)).collect();
        let at_start = problem.evaluate(&start, &problem.options).ok();
        let of_column = |(column, residual): &(String, f64)| {
            let ratio = |values: &[f64]| median(ratios(problem, values, column));
            let at_start = at_start.as_ref().and_then(|found| ratio(&found.values));
            let ratios = [ratio(&solved.evaluation.values), at_start];
            Self { column: column.clone(), residual: *residual, ratios }
        };
        large.into_iter().map(of_column).collect()
    }

    /// Whether one of the ratios is that of a prefix of a unit.
    fn is_of_a_unit(&self) -> bool {
        self.ratios.iter().flatten().any(|ratio| is_near_a_power_of_a_thousand(*ratio))
    }

    /// The warning.
    pub(super) fn text(&self) -> String {
        let shown =
            |ratio: Option<f64>| ratio.map_or_else(|| "unknown".to_owned(), |ratio| format!("{ratio:.3e}"));
        let [solution, start] = self.ratios.map(shown);
        let unit = if self.is_of_a_unit() { "; check its unit" } else { "" };
        format!(
            "the model does not follow {}: its relative residual is {:.3}; the median ratio of data to model is {solution}, at \
             the start {start}{unit}",
            self.column, self.residual
        )
    }
}

/// What the comments of a fitted scene add where the model does not follow these columns.
pub(super) fn remark(unfollowed: &[Unfollowed]) -> String {
    let names: Vec<&str> = unfollowed.iter().map(|one| one.column.as_str()).collect();
    if names.is_empty() { String::new() } else { format!(", the model does not follow {}", names.join(", ")) }
}

/// Magnitudes of data over model in a column.
fn ratios(problem: &Problem<'_>, values: &[f64], name: &str) -> Vec<f64> {
    let mut all = Vec::new();
    for (file, data) in problem.data.iter().enumerate() {
        let columns = data.columns.iter().enumerate().filter(|(_, column)| column.name == name);
        for (index, column) in columns {
            let rows = column.values.iter().enumerate();
            all.extend(
                rows.map(|(row, measured)| (measured / values[problem.index(file, index, row)]).abs()),
            );
        }
    }
    all
}

/// The median of those that are finite.
fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.retain(|number| number.is_finite());
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}

/// Whether a ratio is within [`NEAR`] of a thousand, a thousandth, a million and so on.
fn is_near_a_power_of_a_thousand(ratio: f64) -> bool {
    let power = (ratio.log10() / 3.0).round();
    let off = ratio / 1000f64.powf(power);
    power != 0.0 && (1.0 / NEAR..=NEAR).contains(&off)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_of_a_prefix_is_told_from_others() {
        for (ratio, expected) in [
            (1000.0, true),
            (1900.0, true),
            (510.0, true),
            (1.2e-3, true),
            (0.8e6, true),
            (1.0, false),
            (0.6, false),
            (30.0, false),
            (4000.0, false),
            (0.0, false),
            (f64::NAN, false),
        ] {
            assert_eq!(is_near_a_power_of_a_thousand(ratio), expected, "{ratio}");
        }
    }

    #[test]
    fn the_median_leaves_out_what_the_model_has_no_value_for() {
        assert_eq!(median(vec![f64::INFINITY, 3.0, 1.0, 2.0, f64::NAN]), Some(2.0));
        assert_eq!(median(vec![f64::INFINITY]), None);
    }
}
