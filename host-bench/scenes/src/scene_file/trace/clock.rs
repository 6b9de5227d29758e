//! The times of the samples: which column has them, and the rate that follows.

use super::TraceFault;
use crate::scene_file::key::{Bound, Short};

/// Part of the interval of two samples by which a time may be off: the rounding of a printed time, and no more.
const UNEVEN: f64 = 0.25;

/// Names of a column of times.
const TIME_WORDS: [&str; 7] = ["t", "time", "timestamp", "zeit", "temps", "tempo", "tiempo"];
/// Units of time and their lengths in s.
const UNITS: [(&str, f64); 15] = [
    ("s", 1.0),
    ("sec", 1.0),
    ("second", 1.0),
    ("seconds", 1.0),
    ("ms", 1e-3),
    ("us", 1e-6),
    ("µs", 1e-6),
    ("μs", 1e-6),
    ("ns", 1e-9),
    ("min", 60.0),
    ("minute", 60.0),
    ("minutes", 60.0),
    ("h", 3600.0),
    ("hour", 3600.0),
    ("hours", 3600.0),
];

/// The unit in s of the times in a column with this heading, 1 s where it names none, not-a-number where its unit is not known;
/// `None` if neither the heading nor a key, which `is_stated`, says that these are times.
pub(super) fn unit_of(heading: &str, is_stated: bool) -> Option<f64> {
    let lower = heading.to_lowercase();
    let words: Vec<&str> =
        lower.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let (first, last) = (words.first()?, words.last()?);
    let unit = UNITS.iter().find(|(name, _)| name == last).map(|(_, length)| *length);
    // Metres per second, or radians per second, are no time.
    let is_rate = words.contains(&"per") || words.contains(&"m") || lower.contains('/');
    let is_time = is_stated || TIME_WORDS.contains(first);
    let has_none = TIME_WORDS.contains(last) || words.len() == 1;
    match unit {
        // The last word of a least value is `min` too.
        Some(length) if is_time || !is_rate && length <= 1.0 => Some(length),
        _ => is_time.then_some(if has_none { 1.0 } else { f64::NAN }),
    }
}

/// The times of the samples and the lines that they stand in.
#[derive(Debug, Default)]
pub(super) struct Times {
    pub(super) seconds: Vec<f64>,
    pub(super) lines: Vec<u64>,
}

impl Times {
    /// Whether the times rise throughout, as those of a recording do and its samples do not.
    pub(super) fn rise(&self) -> bool {
        self.seconds.len() > 2 && self.seconds.windows(2).all(|pair| pair[0] < pair[1])
    }

    /// Whether they are a count: each is one more than the one before.
    pub(super) fn count(&self) -> bool {
        self.seconds.windows(2).all(|pair| pair[1] - pair[0] == 1.0)
    }

    /// The rate in Hz from the first time to the last.
    fn own_rate(&self) -> Option<f64> {
        let (first, last) = (self.seconds.first()?, self.seconds.last()?);
        let rate = (self.seconds.len() - 1) as f64 / (last - first);
        (rate.is_finite() && rate > 0.0).then_some(rate)
    }

    /// The rate in Hz within `bound`, which is `stated` where that is given; `key` is blamed for times that do not have it.
    pub(super) fn rate(
        &self,
        stated: Option<f64>,
        bound: Bound,
        key: &'static str,
    ) -> Result<f64, TraceFault> {
        let refuse = |text: String| Err(TraceFault::new(key, text));
        if let Some(bad) = self.seconds.iter().position(|time| !time.is_finite()) {
            return refuse(format!("line {}: time {} s must be finite", self.lines[bad], self.seconds[bad]));
        }
        let Some(rate) = stated.or(self.own_rate()) else {
            return refuse("the times do not rise from the first to the last".to_owned());
        };
        match (self.first_off(rate), stated) {
            (None, _) if bound.contains(rate) => Ok(rate),
            (None, _) => refuse(format!("the times are those of {} Hz: must be {bound}", Short(rate))),
            (Some(off), Some(stated)) => refuse(self.contradiction(off, stated)),
            (Some(_), None) => refuse(self.jitter(1.0 / rate)),
        }
    }

    /// The time in s at which a sample is due.
    fn due(&self, index: usize, rate: f64) -> f64 {
        self.seconds.first().copied().unwrap_or(0.0) + index as f64 / rate
    }

    /// The first sample that is not where the rate has it.
    fn first_off(&self, rate: f64) -> Option<usize> {
        let is_off = |(index, time): (usize, &f64)| (time - self.due(index, rate)).abs() * rate > UNEVEN;
        self.seconds.iter().enumerate().position(is_off)
    }

    /// Why the times contradict the stated rate: that of the scene file and their own.
    fn contradiction(&self, off: usize, stated: f64) -> String {
        let own = match self.own_rate() {
            Some(own) => format!("are those of {own} Hz on average; leave rate_hz out to take their rate"),
            None => "do not rise".to_owned(),
        };
        let (line, now, due) = (self.lines[off], self.seconds[off], self.due(off, stated));
        format!("line {line}: time {now} s must be {due} s, as at rate_hz = {stated}; the times {own}")
    }

    /// Why the times are not even: the interval that differs most from the mean one in s.
    fn jitter(&self, mean: f64) -> String {
        let steps = self.seconds.windows(2).map(|pair| pair[1] - pair[0]);
        let worst = steps
            .zip(&self.lines[1..])
            .max_by(|(a, _), (b, _)| (a - mean).abs().total_cmp(&(b - mean).abs()));
        let (step, line) = worst.unwrap_or((f64::NAN, &0));
        format!(
            "line {line}: the time is {step:.6} s after the one before, the mean interval is {mean:.6} s: the times must \
             be even to {UNEVEN} intervals"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_names_a_time_and_its_unit() {
        for (heading, expected) in [
            ("time_s", Some(1.0)),
            ("Time (ms)", Some(1e-3)),
            ("t", Some(1.0)),
            ("t [µs]", Some(1e-6)),
            ("Time/s", Some(1.0)),
            ("Timestamp", Some(1.0)),
            ("Zeit in s", Some(1.0)),
            ("elapsed_ms", Some(1e-3)),
            ("time (min)", Some(60.0)),
            ("Time [h]", Some(3600.0)),
            ("acceleration_min", None),
            ("seconds", Some(1.0)),
            ("acceleration_m_per_s2", None),
            ("velocity (m/s)", None),
            ("velocity_m_per_s", None),
            ("voltage_v", None),
            ("x", None),
            ("temperature", None),
            ("", None),
        ] {
            assert_eq!(unit_of(heading, false), expected, "{heading:?}");
        }
        for (heading, expected) in [("x", 1.0), ("elapsed time", 1.0), ("elapsed [min]", 60.0)] {
            assert_eq!(unit_of(heading, true), Some(expected), "{heading:?}");
        }
        for (heading, is_stated) in [("time (d)", false), ("t_fortnights", false), ("elapsed [d]", true)] {
            assert!(unit_of(heading, is_stated).is_some_and(f64::is_nan), "{heading:?}");
        }
    }
}
