//! The sums of the estimator along the steps.

use crate::clock::{Instant, TICKS_PER_SECOND};
use crate::integrate::step_control::REMEMBERED_RADIANS;
use crate::observer::{AcceptedStep, Event, Observer, PowerIndex};
use crate::scalar::{CompensatedSum, Scalar};
use crate::snapshot::snapshot_fields;

/// Relative error of a power per relative error of the state: a power is a square.
const POWER_PER_STATE: f64 = 2.0;
/// Roundings in the energy of a step, which some tens of operations compute from the state.
const ENERGY_ROUNDINGS: f64 = 32.0;
/// Roundings of a compensated sum with any number of terms (Kahan); the next part is smaller by the number of terms times a rounding.
const SUM_ROUNDINGS: f64 = 2.0;

/// Largest energy in J and largest sum of errors that an image may have: their products are finite in `f32`.
const LARGEST_SUM: f64 = 1e12;

/// Delivered energy and its errors, summed over steps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergyAccumulator<S> {
    /// Energy delivered to the load, in J.
    energy: CompensatedSum<S>,
    /// Magnitudes of the estimated local errors of the energy, in J.
    energy_error: CompensatedSum<S>,
    /// Estimated local errors of the state, in the error norm of the scene.
    state_error: CompensatedSum<S>,
    time: ElapsedTime,
    /// Energy delivered to the load in this resonance period, in J.
    period_energy: S,
    /// Whether there was an impact in this period.
    impact: bool,
}

impl<S: Scalar> EnergyAccumulator<S> {
    #[inline]
    pub(super) fn add(&mut self, energy: S, ticks: u32) {
        self.energy.add(energy);
        self.period_energy += energy;
        self.time.add(ticks);
    }

    /// Ends a resonance period: the energy delivered in it in J, and whether there was an impact.
    pub(super) fn take_period(&mut self) -> (S, bool) {
        (core::mem::take(&mut self.period_energy), core::mem::take(&mut self.impact))
    }

    /// Energy delivered to the load, in J.
    pub(super) fn energy(&self) -> S {
        self.energy.value()
    }

    /// Integrated time in s.
    pub(super) fn seconds(&self) -> S {
        self.time.seconds()
    }

    /// Error of the energy by the method's own estimate, in J.
    pub(super) fn step_error(&self, angular_frequency: S) -> S {
        // The state carries the errors of the last `REMEMBERED_RADIANS` radians.
        let radians = (angular_frequency * self.seconds()).max(S::TINY);
        let remembered = S::from_f64(REMEMBERED_RADIANS).min(radians);
        let carried = self.state_error.value() * (remembered / radians);
        self.energy_error.value() + S::from_f64(POWER_PER_STATE) * carried * self.energy().abs()
    }

    /// Error of the energy by rounding, in J.
    pub(super) fn rounding(&self) -> S {
        let of_state = POWER_PER_STATE * REMEMBERED_RADIANS;
        S::EPSILON * S::from_f64(ENERGY_ROUNDINGS + SUM_ROUNDINGS + of_state) * self.energy().abs()
    }
}

impl<S: Scalar> Observer<S> for EnergyAccumulator<S> {
    const READS_OUTPUTS: bool = false;

    // A Cortex-M0 build would outline this function and then store a complete `AcceptedStep` in memory.
    #[inline]
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        self.add(step.energy(PowerIndex::Load), step.ticks);
        // A method without an estimate compiles none of this.
        if step.state_error != S::ZERO {
            self.energy_error.add(step.energy_error.abs());
            self.state_error.add(step.state_error);
        }
    }

    fn event(&mut self, event: &Event<'_, S>) {
        if let Some(&energy) = event.energies.first()
            && energy != S::ZERO
        {
            self.energy.add(energy);
            self.period_energy += energy;
        }
        self.impact |= event.impact_speed.is_some();
    }
}

snapshot_fields!(impl [S: Scalar] EnergyAccumulator<S> {
    energy, energy_error, state_error, time, period_energy, impact,
} if |sums| {
    let largest = S::from_f64(LARGEST_SUM);
    let energies = sums.energy.value().abs().max(sums.period_energy.abs()) <= largest;
    energies && [&sums.energy_error, &sums.state_error].iter().all(|sum| {
        sum.value() >= S::ZERO && sum.value() <= largest
    })
});

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

    #[inline]
    pub(super) fn add(&mut self, ticks: u32) {
        self.ticks = self.ticks.wrapping_add(ticks.into());
        if self.ticks >= Self::MOST_TICKS {
            self.carry(0);
        }
    }

    pub(super) fn add_intervals(&mut self, count: u32, interval: u64) {
        let product = u128::from(count) * u128::from(interval);
        self.ticks = self.ticks.wrapping_add(product as u64 % TICKS_PER_SECOND);
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
    use crate::clock::TICKS_PER_SECOND;

    #[test]
    fn a_day_of_small_equal_energies_is_summed_to_a_rounding_in_single_precision() {
        const STEPS_PER_SECOND: u32 = 128;
        let (mut single, mut double) =
            (EnergyAccumulator::<f32>::default(), EnergyAccumulator::<f64>::default());
        let energy = 4.7e-8_f32;
        let ticks = (TICKS_PER_SECOND / u64::from(STEPS_PER_SECOND)) as u32;
        let steps = 86_400 * STEPS_PER_SECOND;
        let mut halfway = [0.0; 2];
        for step in 0..steps {
            single.add(energy, ticks);
            double.add(energy.into(), ticks);
            if step == steps / 2 - 1 {
                halfway = [single.energy().into(), double.energy()];
            }
        }
        assert_eq!((single.seconds(), double.seconds()), (86_400.0, 86_400.0));
        for [found, expected] in [
            [f64::from(single.energy()), double.energy()],
            [f64::from(single.energy()) - halfway[0], double.energy() - halfway[1]],
        ] {
            assert!((found / expected - 1.0).abs() < 2e-7, "{found} {expected}");
        }
    }
}

#[cfg(test)]
mod tests_of_elapsed {
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
