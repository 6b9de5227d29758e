//! The income by the map: the predicted output power, held from burst to burst.
//!
//! Between two bursts the power is taken to have jumped once, at any time: its mean is that of both, and the variance of its
//! integral over the time `t` is `(Δ t)²/12`. After the last burst it walks, by `c` in W² a second, which is the mean of
//! `Δ²/t` over the bursts: over the time from `h` to `h + t` after the burst the variance of the integral is `c (h t² + t³/3)`.

use super::finding::OutputPower;
use crate::node::real;
use crate::scalar::Scalar;
use crate::snapshot::snapshot_fields;

/// Weight of the newest change of the power in their mean.
const NEWEST: f32 = 0.0625;
/// Relative change of the power in the root of an hour that is expected before two bursts have shown one.
const EXPECTED: f32 = 0.5;
/// Part of the largest power by which the power changes at least in the root of an hour: vibration begins and ends.
const LEAST_CHANGE: f32 = 0.03;

/// The predicted output power since the last burst.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct LatestPower {
    pub(super) is_known: bool,
    /// What the last burst said.
    pub(super) output: OutputPower,
    /// Seconds since it.
    pub(super) seconds: u32,
    /// Mean square of the change of the power in W² a second; 0 before two bursts in turn.
    change: f32,
}

/// Predicted energy of a time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct PredictedEnergy {
    /// Seconds, and those of them of which the map says nothing.
    pub(super) seconds: u32,
    pub(super) unknown: u32,
    /// In J; the variance of its error by noise and changes, and the error that is the same at the same place in the map.
    pub(super) energy: f32,
    variance: f32,
    pub(super) systematic: f32,
}

/// Least mean square of the change of the power in W² a second, of a harvester of a `largest` power in W.
pub(super) const fn least_change(largest: f32) -> f32 {
    let least = LEAST_CHANGE * largest;
    least * least * (1.0 / 3600.0)
}

impl LatestPower {
    /// Mean square of the change of the power in W² a second, at least that of [`least_change`].
    pub(super) fn change(&self, least: f32) -> f32 {
        if self.change > 0.0 {
            return Scalar::max(self.change, least);
        }
        let expected = EXPECTED * self.output.value;
        Scalar::max(expected * expected * (1.0 / 3600.0), least)
    }

    /// Variance of the power now in W².
    pub(super) fn variance(&self, least: f32) -> f32 {
        self.output.noise * self.output.noise + self.change(least) * real(self.seconds)
    }

    /// A time passes. What is held adds to `sums`.
    pub(super) fn pass(&mut self, seconds: u32, sums: [&mut PredictedEnergy; 2]) {
        let (OutputPower { value, noise, systematic }, time) = (self.output, real(seconds));
        let (energy, noise, systematic) = (value * time, noise * noise, systematic * value * time);
        for sum in sums {
            if self.is_known {
                // The noise of a burst is the same for as long as it is held.
                let before = real(self.seconds.min(sum.seconds));
                let after = before + time;
                sum.energy += energy;
                sum.variance += noise * (after * after - before * before);
                sum.systematic += systematic;
            } else {
                sum.unknown = sum.unknown.saturating_add(seconds);
            }
            sum.seconds = sum.seconds.saturating_add(seconds);
        }
        self.seconds = self.seconds.saturating_add(seconds);
    }

    /// A burst says what the power is now.
    pub(super) fn update(&mut self, output: OutputPower, sums: [&mut PredictedEnergy; 2]) {
        let step = output.value - self.output.value;
        if self.is_known {
            for sum in sums {
                let moved = step * real(self.seconds.min(sum.seconds));
                sum.energy = Scalar::max(sum.energy + 0.5 * moved, 0.0);
                sum.variance += moved * moved * (1.0 / 12.0);
            }
            let noise = output.noise * output.noise + self.output.noise * self.output.noise;
            let change = Scalar::max(step * step - noise, 0.0) / real(self.seconds.max(1));
            let weight = if self.change > 0.0 { NEWEST } else { 1.0 };
            // A walk that has been seen is not taken for none.
            self.change = Scalar::max(self.change + weight * (change - self.change), f32::MIN_POSITIVE);
        }
        (self.is_known, self.output, self.seconds) = (true, output, 0);
    }

    /// A burst had no value.
    pub(super) fn miss(&mut self) {
        (self.is_known, self.seconds) = (false, 0);
    }
}

impl PredictedEnergy {
    /// Whether the map says something of all of the time.
    pub(super) fn is_known(&self) -> bool {
        self.unknown == 0 && self.seconds > 0
    }

    /// The variance of the energy in J² up to now.
    pub(super) fn variance(&self, latest: &LatestPower, least: f32) -> f32 {
        let within = latest.seconds.min(self.seconds);
        let (before, time) = (real(latest.seconds - within), real(within));
        self.variance + latest.change(least) * time * time * (before + time * (1.0 / 3.0))
    }
}

snapshot_fields!(impl [] LatestPower { is_known, output, seconds, change } if |latest| latest.change >= 0.0);
snapshot_fields!(impl [] PredictedEnergy { seconds, unknown, energy, variance, systematic } if |sum| sum.variance >= 0.0);
