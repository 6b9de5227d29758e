//! A duration that a node adds up for as long as it runs.

use crate::clock::{Instant, TICKS_PER_SECOND};
use crate::scalar::Scalar;
use crate::snapshot::snapshot_fields;

/// A sum of durations in ticks. It holds 136 years, then it stays at that value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct ElapsedTime {
    seconds: u32,
    /// The rest in ticks, below [`ElapsedTime::MOST_TICKS`].
    ticks: u64,
}

impl ElapsedTime {
    /// Half a year. Two such numbers and any sampling interval add up to less than 2⁶⁴.
    const MOST_TICKS: u64 = 1 << 62;

    #[inline(always)]
    pub(super) fn add(&mut self, ticks: u32) {
        self.ticks += u64::from(ticks);
        if self.ticks >= Self::MOST_TICKS {
            self.carry(0);
        }
    }

    /// Adds `count` intervals of `interval` ticks.
    pub(super) fn add_intervals(&mut self, count: u32, interval: u64) {
        let product = u128::from(count) * u128::from(interval);
        self.ticks += product as u64 % TICKS_PER_SECOND;
        self.carry(u32::try_from(product / u128::from(TICKS_PER_SECOND)).unwrap_or(u32::MAX));
    }

    /// Adds whole seconds, and those in the ticks if these are too many.
    #[cold]
    fn carry(&mut self, seconds: u32) {
        let mut whole = seconds;
        if self.ticks >= Self::MOST_TICKS {
            whole = whole.saturating_add((self.ticks / TICKS_PER_SECOND) as u32);
            self.ticks %= TICKS_PER_SECOND;
        }
        self.seconds = self.seconds.saturating_add(whole);
    }

    /// The duration in s, rounded.
    pub(super) fn seconds<S: Scalar>(self) -> S {
        S::from_u32(self.seconds) + Instant::from_ticks(self.ticks).seconds::<S>()
    }
}

snapshot_fields!(impl [] ElapsedTime { seconds, ticks } if |time| time.ticks < ElapsedTime::MOST_TICKS);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost_within_a_century_and_nothing_wraps_after_it() {
        let mut time = ElapsedTime::default();
        let interval = TICKS_PER_SECOND / 400;
        // A hundred years in intervals of a 400th of a second, and one step.
        for _ in 0..100 {
            for _ in 0..366 {
                time.add_intervals(400 * 86_400, interval);
            }
        }
        time.add(1 << 31);
        let lost = (TICKS_PER_SECOND % 400) as f64 * 86_400.0 * 36_600.0 / TICKS_PER_SECOND as f64;
        let exact = 86_400.0 * 36_600.0 - lost + 1.0 / 128.0;
        assert!((time.seconds::<f64>() - exact).abs() < 1e-6, "{}", time.seconds::<f64>());
        for _ in 0..3 {
            time.add_intervals(u32::MAX, 1 << 48);
        }
        let beyond = time.seconds::<f64>() - f64::from(u32::MAX);
        assert!((0.0..f64::from(1 << 24)).contains(&beyond), "{beyond}");
        // Steps alone.
        let mut steps = ElapsedTime { seconds: 7, ticks: ElapsedTime::MOST_TICKS - 1 };
        steps.add(u32::MAX);
        let seconds = 7.0 + (ElapsedTime::MOST_TICKS as f64 + f64::from(u32::MAX)) / TICKS_PER_SECOND as f64;
        assert!((steps.seconds::<f64>() - seconds).abs() < 1e-6);
        assert!(steps.ticks < TICKS_PER_SECOND);
    }
}
