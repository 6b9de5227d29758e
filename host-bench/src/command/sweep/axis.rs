//! One axis of a sweep: `KEY=FROM:TO:COUNT[:log]`.

use std::str::FromStr;

use crate::optimise::ends;

/// Most points on one axis.
const MOST: usize = 100_000;

#[derive(Debug, Clone, PartialEq)]
pub(in crate::command) struct Axis {
    /// The key, such as `load.resistance_ohm`.
    pub(in crate::command) key: String,
    from: f64,
    to: f64,
    count: usize,
    /// Whether the values are spread evenly in their logarithm.
    pub(super) logarithmic: bool,
}

impl Axis {
    /// Values spread evenly, or evenly in their logarithm.
    pub(in crate::command) fn new(key: &str, [from, to]: [f64; 2], count: usize, logarithmic: bool) -> Self {
        Self { key: key.to_owned(), from, to, count, logarithmic }
    }

    /// Number of values.
    pub(in crate::command) fn count(&self) -> usize {
        self.count
    }

    /// The value with the given index; the first and the last are exactly FROM and TO.
    pub(in crate::command) fn value(&self, index: usize) -> f64 {
        if index == 0 {
            return self.from;
        }
        if index + 1 >= self.count {
            return self.to;
        }
        self.at(index as f64 / (self.count - 1) as f64)
    }

    /// The value at a part of the way from FROM to TO.
    pub(in crate::command) fn at(&self, part: f64) -> f64 {
        if self.logarithmic {
            // To base ten, so that decades are exact.
            10f64.powf(self.from.log10() + part * (self.to.log10() - self.from.log10()))
        } else {
            self.from + part * (self.to - self.from)
        }
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const FORM: &str = "must be KEY=FROM:TO:COUNT or KEY=FROM:TO:COUNT:log";
        let (key, [from, to], rest, logarithmic) = ends(text, FORM, ["FROM", "TO"])?;
        let [count] = rest[..] else { return Err(FORM.to_owned()) };
        let count = match count.parse() {
            Ok(count) if (1..=MOST).contains(&count) => count,
            _ => return Err(format!("COUNT = {count:?} must be a whole number from 1 to {MOST}")),
        };
        if count == 1 && from != to {
            return Err(format!("COUNT = 1 must be at least 2 to go from {from} to {to}"));
        }
        Ok(Self::new(key, [from, to], count, logarithmic))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_spread_evenly_and_end_at_the_bounds() {
        let axis: Axis = "run.duration_s=1:3:5".parse().expect("valid");
        let values: Vec<f64> = (0..axis.count()).map(|index| axis.value(index)).collect();
        assert_eq!(values, [1.0, 1.5, 2.0, 2.5, 3.0]);
        let axis: Axis = "load.resistance_ohm=1e5:1e9:5:log".parse().expect("valid");
        let values: Vec<f64> = (0..axis.count()).map(|index| axis.value(index)).collect();
        assert_eq!(values, [1e5, 1e6, 1e7, 1e8, 1e9]);
    }

    #[test]
    fn what_is_no_axis_is_refused() {
        let words = " a a= =1:2:3 a=1:2 a=1:2:3:lin a=1:2:0 a=1:2:-1 a=1:2:1 a=1:2:2.5 a=x:2:3 a=1:nan:3 a=1:inf:3 \
            a=0:2:3:log a=-1:2:3:log a=1:2:1000000";
        for text in words.split(' ') {
            assert!(text.parse::<Axis>().is_err(), "{text}");
        }
    }
}
