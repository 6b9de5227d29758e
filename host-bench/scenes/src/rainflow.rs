//! Counts the cycles of a stress history by the rainflow rule of ASTM E1049-85, section 5.4.4.
//!
//! Values come one by one. The rule compares the last two ranges between turning points: a range that is not larger than
//! the next is a whole cycle, or half a cycle if it contains the first turning point. What remains at the end counts as
//! half cycles. The memory is that of the remaining turning points and of a histogram.

use std::collections::BTreeMap;

/// Classes of the histogram in a doubling of the range: about 1 % each.
const CLASSES_PER_DOUBLING: f64 = 64.0;

/// Counts cycles of a history.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rainflow {
    /// Turning points that are not counted yet, and the last value.
    points: Vec<f64>,
    /// Half cycles by class of their range.
    half_cycles: BTreeMap<i64, u64>,
    largest: f64,
}

impl Rainflow {
    /// Appends a value of the history. Not-a-number and infinities are left out.
    pub fn push(&mut self, value: f64) {
        if !value.is_finite() {
            return;
        }
        match self.points[..] {
            // The last value was no turning point.
            [.., before, last] if (last - before) * (value - last) >= 0.0 => {
                self.points.pop();
                self.points.push(value);
            }
            [last] if last == value => {}
            _ => {
                self.reduce();
                self.points.push(value);
            }
        }
    }

    /// Counts the cycles that the turning points so far complete.
    fn reduce(&mut self) {
        while let [.., one, two, three] = self.points[..] {
            let (before, range) = ((two - one).abs(), (three - two).abs());
            if range < before {
                return;
            }
            let count = self.points.len();
            if count == 3 {
                self.count(before, 1);
                self.points.remove(0);
            } else {
                self.count(before, 2);
                self.points.drain(count - 3..count - 1);
            }
        }
    }

    fn count(&mut self, range: f64, half_cycles: u64) {
        if range > 0.0 {
            let class = (CLASSES_PER_DOUBLING * range.log2()).floor() as i64;
            *self.half_cycles.entry(class).or_default() += half_cycles;
            self.largest = self.largest.max(range);
        }
    }

    /// The history as if it ended here: what remains is counted as half cycles.
    fn ended(&self) -> Self {
        let mut ended = self.clone();
        ended.reduce();
        let points = std::mem::take(&mut ended.points);
        for pair in points.windows(2) {
            ended.count((pair[1] - pair[0]).abs(), 1);
        }
        ended
    }

    /// The largest range, in the unit of the values; 0 without a turning point.
    pub fn largest_range(&self) -> f64 {
        self.ended().largest
    }

    /// The range in the unit of the values whose cycles, one per second over `seconds`, do the same damage by Miner's rule
    /// with an S–N curve of this exponent `m`: `(Σ n Δᵐ / seconds)^(1/m)`. Exact to half a class.
    pub(crate) fn equivalent_range(&self, exponent: f64, seconds: f64) -> f64 {
        let ended = self.ended();
        // Relative to the largest range, whose power may overflow.
        let damage = ended.half_cycles.iter().map(|(class, half_cycles)| {
            let range = ((*class as f64 + 0.5) / CLASSES_PER_DOUBLING).exp2().min(ended.largest);
            0.5 * *half_cycles as f64 * (range / ended.largest).powf(exponent)
        });
        let damage: f64 = damage.sum();
        if damage > 0.0 { ended.largest * (damage / seconds).powf(exponent.recip()) } else { 0.0 }
    }

    /// Number of cycles, half cycles by their half, of at least a part of the largest range, from 0 to 1; the limit is exact to 1 %.
    pub fn cycles(&self, part: f64) -> f64 {
        let ended = self.ended();
        let limit = (CLASSES_PER_DOUBLING * (part * ended.largest).log2()).floor();
        let counted = ended.half_cycles.iter().filter(|(class, _)| **class as f64 >= limit);
        0.5 * counted.map(|(_, half_cycles)| *half_cycles as f64).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(history: &[f64]) -> Rainflow {
        let mut rainflow = Rainflow::default();
        history.iter().for_each(|value| rainflow.push(*value));
        rainflow
    }

    /// Half cycles of this range, within the class.
    fn half_cycles(rainflow: &Rainflow, range: f64) -> u64 {
        let class = (CLASSES_PER_DOUBLING * range.log2()).floor() as i64;
        rainflow.ended().half_cycles.get(&class).copied().unwrap_or(0)
    }

    /// The example of the standard, figure 6: A to I.
    const EXAMPLE: [f64; 9] = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0];

    #[test]
    fn the_example_of_the_standard_has_its_cycles() {
        let rainflow = of(&EXAMPLE);
        for (range, expected) in [(3.0, 1), (4.0, 3), (6.0, 1), (8.0, 2), (9.0, 1)] {
            assert_eq!(half_cycles(&rainflow, range), expected, "range {range}");
        }
        assert_eq!(rainflow.cycles(0.0), 4.0);
        assert_eq!(rainflow.largest_range(), 9.0);
        // 6, 8, 8 and 9: half cycles of at least half of the largest range.
        assert_eq!(rainflow.cycles(0.5), 2.0);
    }

    /// Half cycles of 3, 4 (three), 6, 8 (two) and 9 in two seconds, with the exponent 5.
    #[test]
    fn the_equivalent_range_is_the_mean_of_the_power() {
        let sum: f64 = [3.0, 4.0, 4.0, 4.0, 6.0, 8.0, 8.0, 9.0].iter().map(|range: &f64| range.powi(5)).sum();
        let expected = (0.5 * sum / 2.0).powf(0.2);
        let found = of(&EXAMPLE).equivalent_range(5.0, 2.0);
        assert!((found / expected - 1.0).abs() < 6e-3, "{found} {expected}");
        assert_eq!(of(&[1.0; 5]).equivalent_range(5.0, 2.0), 0.0);
        // One whole cycle per second: its range.
        let steady: Vec<f64> = (0..=20).map(|index| if index % 2 == 0 { 1.0 } else { -1.0 }).collect();
        assert!((of(&steady).equivalent_range(5.0, 10.0) / 2.0 - 1.0).abs() < 6e-3);
    }

    #[test]
    fn values_between_turning_points_change_nothing() {
        let between = EXAMPLE.windows(2).flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1]), pair[1]]);
        let history: Vec<f64> = between.chain([f64::NAN]).collect();
        assert_eq!(of(&history).ended().half_cycles, of(&EXAMPLE).ended().half_cycles);
    }

    #[test]
    fn a_sine_has_one_cycle_a_period() {
        let history: Vec<f64> = (0..=1000).map(|index| (0.1 * f64::from(index)).sin()).collect();
        let rainflow = of(&history);
        assert!(
            (rainflow.cycles(0.5) - 100.0 / std::f64::consts::TAU).abs() < 1.0,
            "{}",
            rainflow.cycles(0.5)
        );
        assert!((rainflow.largest_range() - 2.0).abs() < 2e-3);
        assert_eq!(of(&[1.0; 5]).cycles(0.0), 0.0);
    }
}
