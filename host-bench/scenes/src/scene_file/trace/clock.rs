//! The times of the samples: which column has them, and the rate that follows.

use super::{GAP, RESAMPLED, Samples, TraceFault};
use crate::scene_file::key::{Bound, Short};

/// Part of the interval of two samples by which a time may be off: the rounding of a printed time, and no more.
const UNEVEN: f64 = 0.25;

/// Missing samples in a row that the cubic bridges; a straight line fills more.
const BRIDGED: f64 = 2.0;
/// Least interval of two samples in usual ones: a cubic magnifies their noise by about its reciprocal. And least even rate in
/// usual ones: what is below its half does not fold, so there is no low-pass.
const LEAST: [f64; 2] = [0.1, 0.9];
/// Part of an even interval by which the last time may lie before the last even one: roundings.
const ROUNDING: f64 = 1e-6;
/// Most samples at even times.
const MOST_SAMPLES: f64 = 1e7;

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
        self.check_finite(key)?;
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

    fn check_finite(&self, key: &'static str) -> Result<(), TraceFault> {
        let Some(bad) = self.seconds.iter().position(|time| !time.is_finite()) else { return Ok(()) };
        let text = format!("line {}: time {} s must be finite", self.lines[bad], self.seconds[bad]);
        Err(TraceFault::new(key, text))
    }

    /// The samples at even times from the first one on, by the cubic through four, and by a straight line across a gap.
    pub(super) fn resampled(
        &self,
        samples: &[f64],
        (rate_hz, longest_gap): (f64, usize),
        key: &'static str,
    ) -> Result<Samples, TraceFault> {
        self.check_finite(key)?;
        let times = &self.seconds;
        let missing = self.missing(rate_hz, longest_gap, key)?;
        let is_near = |at: usize| missing.get(at).is_some_and(|missing| *missing <= BRIDGED);
        let count = ((times[times.len() - 1] - times[0]) * rate_hz + ROUNDING).floor() + 1.0;
        if !(2.0..=MOST_SAMPLES).contains(&count) {
            let text = format!("makes {count} samples, must make 2 to {MOST_SAMPLES:e}");
            return Err(TraceFault::new(RESAMPLED, text));
        }
        let (mut left, mut counts) = (0, [0, 0]);
        let even = (0..count as usize).map(|index| {
            let time = self.due(index, rate_hz);
            while left + 2 < times.len() && times[left + 1] <= time {
                left += 1;
            }
            let distance = (time - times[left]).abs().min((times[left + 1] - time).abs());
            // Nearer to a sample that is missing than to one that is there.
            let usual = (times[left + 1] - times[left]) / (missing[left] + 1.0);
            let is_filled = missing[left] > 0.0 && 2.0 * distance > usual;
            // A hundredth of an interval is the rounding of a printed time.
            counts[usize::from(is_filled)] += usize::from(distance * rate_hz > 0.01);
            let from = left - usize::from(left > 0 && is_near(left) && is_near(left - 1));
            let to = left + 1 + usize::from(is_near(left) && is_near(left + 1));
            lagrange(&times[from..=to], &samples[from..=to], time)
        });
        Ok((even.collect(), rate_hz, Some(counts)))
    }

    /// How many samples are missing after each, by the usual interval; refuses what cannot be resampled so.
    fn missing(&self, rate_hz: f64, longest: usize, key: &'static str) -> Result<Vec<f64>, TraceFault> {
        let refuse = |key: &'static str, text: String| Err(TraceFault::new(key, text));
        let steps: Vec<f64> = self.seconds.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut sorted = steps.clone();
        sorted.sort_by(f64::total_cmp);
        let (usual, [closest, slowest]) = (sorted[sorted.len() / 2], LEAST);
        let missing: Vec<f64> = steps.iter().map(|step| ((step / usual).round() - 1.0).max(0.0)).collect();
        for ((step, missing), line) in steps.iter().zip(&missing).zip(&self.lines[1..]) {
            let after = format!("line {line}: the time is {step:.6} s after the one before");
            if !(*step > 0.0 && *step >= closest * usual) {
                return refuse(key, format!("{after}, must be at least {closest} of the usual {usual:.6} s"));
            }
            if *missing > longest as f64 {
                let text = format!("{after}: {missing} samples are missing, must be at most {longest}");
                return refuse(GAP, text);
            }
        }
        if rate_hz * usual < slowest {
            let least = slowest / usual;
            return refuse(RESAMPLED, format!("must be at least {least:.6}, {slowest} of the usual rate"));
        }
        Ok(missing)
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
             be even to {UNEVEN} intervals; resample_hz takes uneven ones"
        )
    }
}

/// The polynomial through some samples, at a time.
fn lagrange(times: &[f64], samples: &[f64], time: f64) -> f64 {
    let weight = |at: usize| -> f64 {
        let others = (0..times.len()).filter(|other| *other != at);
        others.map(|other| (time - times[other]) / (times[at] - times[other])).product()
    };
    samples.iter().enumerate().map(|(at, sample)| sample * weight(at)).sum()
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

    /// The cubic through samples at most `h` apart errs between the two in the middle by at most `3/128 h⁴` of the fourth derivative;
    /// the parabola through three, where there is no fourth, by `√3/27 h³` of the third, a straight line by `1/8 h²` of the second.
    #[test]
    fn jitter_and_gaps_are_resampled_within_the_error_of_the_cubic() {
        const RATE: f64 = 400.0;
        let turns = [10.0, 23.0].map(|frequency| std::f64::consts::TAU * frequency);
        let exact = |time: f64| (turns[0] * time).sin() + 0.3 * (turns[1] * time + 0.7).sin();
        let [second, third, fourth] =
            [2, 3, 4].map(|degree| turns[0].powi(degree) + 0.3 * turns[1].powi(degree));
        let is_there = |at: &u32| ![50, 90, 91].contains(at) && !(200..208).contains(at);
        let rows: Vec<u32> = (0..=400).filter(is_there).collect();
        let time = |at: &u32| (f64::from(*at) + 0.24 * (0.7 * f64::from(at * at)).sin()) / RATE;
        let times = Times {
            seconds: rows.iter().map(time).collect(),
            lines: rows.iter().map(|&at| u64::from(at) + 1).collect(),
        };
        let samples: Vec<f64> = times.seconds.iter().map(|&time| exact(time)).collect();
        let of = |rate_hz: f64, longest_gap| times.resampled(&samples, (rate_hz, longest_gap), "path");
        for rate_hz in [RATE, 1000.0] {
            let mut worst = [0.0_f64; 3];
            for (index, found) in of(rate_hz, 8).expect("a trace").0.iter().enumerate() {
                let time = times.due(index, rate_hz);
                let right = times.seconds.partition_point(|at| *at <= time).clamp(1, samples.len() - 1);
                let near = &times.seconds[right.saturating_sub(2)..(right + 2).min(samples.len())];
                let longest = near.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
                let (kind, bound) = if times.seconds[right] - times.seconds[right - 1] > 3.5 / RATE {
                    (0, longest.powi(2) / 8.0 * second)
                } else if near.len() < 4 || longest > 6.0 / RATE {
                    (1, (1.6 / RATE).powi(3) * 3.0_f64.sqrt() / 27.0 * third)
                } else {
                    (2, longest.powi(4) * 3.0 / 128.0 * fourth)
                };
                worst[kind] = worst[kind].max((found - exact(time)).abs() / bound);
            }
            assert!(worst.iter().all(|part| (0.05..=1.0).contains(part)), "{rate_hz} Hz: {worst:?}");
        }
        // Nearly all samples are off the even times; eleven are missing.
        let counts = of(RATE, 8).expect("a trace").2.expect("counts");
        assert!(counts[0] > 370 && (10..=12).contains(&counts[1]), "{counts:?}");
        for (rate_hz, longest_gap, key, part) in [
            (RATE, 7, GAP, "s after the one before: 8 samples are missing, must be at most 7"),
            (300.0, 8, RESAMPLED, "must be at least 3"),
            (1e8, 8, RESAMPLED, "must make 2 to 1e7"),
        ] {
            let fault = of(rate_hz, longest_gap).expect_err("a fault");
            assert!(fault.key == key && fault.text.contains(part), "{fault:?}");
        }
        let endless = Times { seconds: vec![0.0, f64::INFINITY, 2.0], lines: vec![1, 2, 3] };
        let fault = endless.resampled(&[0.0; 3], (1.0, 2), "path");
        assert!(fault.is_err_and(|fault| fault.text == "line 2: time inf s must be finite"));
        let close = Times { seconds: vec![0.0, 1.0, 2.0, 2.05, 3.0], lines: (1..=5).collect() };
        let fault = close.resampled(&[0.0; 5], (2.0, 2), "path");
        assert!(fault.is_err_and(|fault| fault.text.contains("line 4: the time is 0.05")));
    }
}
