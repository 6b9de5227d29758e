//! The response of the harvester by resonance period: the frequencies in its velocity, and the energy of each period.
//!
//! An error of the input counts by what the harvester takes up of it, so the frequencies are weighted by the squared
//! velocity. How much the energy `e` of a period changes with the squared velocity `w` in it follows from the periods
//! themselves: with the slope `b` of the regression of `e` on `w`,
//!
//! ```text
//! gain = d(ln Σ e)/d(ln amplitude) = 2 b Σ w / Σ e
//! ```
//!
//! is 2 in a linear harvester, and more where the power rises steeply towards a closed gap (derived here).

use super::accumulator::EnergyAccumulator;
use crate::scalar::{CompensatedSum, Scalar};
use crate::snapshot::snapshot_fields;

/// Gain of a linear harvester: a power is a square.
const LEAST_GAIN: f64 = 2.0;
/// Largest gain: with a larger one the harvester is near a jump between two motions, and the slope is not known.
const LARGEST_GAIN: f64 = 20.0;
/// Periods for which a motion is independent of a neighbouring one after an impact. Fitted: docs/energy.md.
const PERIODS_AFTER_IMPACT: f64 = 6.0;
/// Standard errors that are stated where the part of the time is known in which motions are independent.
const STANDARD_ERRORS: f64 = 2.0;
/// Number of periods below which neither gain nor scatter are known.
const LEAST_PERIODS: u32 = 3;
/// Roundings of the sum of squares below which the periods have equal velocities.
const VARIANCE_ROUNDINGS: f64 = 64.0;

/// Sums over the samples of one period, and over all periods.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Response<S> {
    /// Velocity at the newest known sample, in m/s.
    velocity: S,
    /// Its change over the last sampling interval.
    slope: S,
    /// Number of samples of this period so far.
    samples: u32,
    /// Squares of the velocity, of its first and second differences, of the sample and of its difference in this period.
    period: [S; 5],
    /// Energy in J of the last whole period.
    last: S,
    periods: Periods<S>,
}

/// Sums over whole periods.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Periods<S> {
    count: u32,
    /// Number of periods with an impact.
    with_impact: u32,
    /// As [`Response::period`].
    squares: [CompensatedSum<S>; 5],
    /// Delivered energies in J.
    energy: CompensatedSum<S>,
    energy_squares: CompensatedSum<S>,
    /// Squared velocities of a period, squared.
    velocity_fourths: CompensatedSum<S>,
    /// Products of the energy and the squared velocities of a period.
    products: CompensatedSum<S>,
    /// Energies in J of the periods in which the harvester settles.
    settling: CompensatedSum<S>,
    /// Powers in W before each restart, and their products with the time in s to the restart.
    lost: [S; 2],
}

impl<S: Scalar> Response<S> {
    /// Adds the velocity in m/s at the end of a sampling interval, and a sample with its difference in m/s², with the samples in a
    /// period and whether the harvester settles.
    #[inline]
    pub(super) fn add(
        &mut self,
        velocity: S,
        [sample, rise]: [S; 2],
        (per_period, settles): (u32, bool),
        accumulator: &mut EnergyAccumulator<S>,
    ) {
        let slope = velocity - self.velocity;
        let bend = slope - self.slope;
        for (sum, part) in self.period.iter_mut().zip([velocity, slope, bend, sample, rise]) {
            *sum += part * part;
        }
        (self.velocity, self.slope) = (velocity, slope);
        self.samples = self.samples.saturating_add(1);
        if self.samples >= per_period {
            self.end_period(settles, accumulator);
        }
    }

    #[inline(never)]
    fn end_period(&mut self, settles: bool, accumulator: &mut EnergyAccumulator<S>) {
        let (energy, with_impact) = accumulator.take_period();
        let period = core::mem::take(&mut self.period);
        (self.samples, self.last) = (0, energy.abs());
        let Periods { count, squares, .. } = &mut self.periods;
        *count = count.saturating_add(1);
        for (sum, part) in squares.iter_mut().zip(period) {
            sum.add(part);
        }
        let [square, ..] = period;
        let periods = &mut self.periods;
        periods.with_impact = periods.with_impact.saturating_add(u32::from(with_impact));
        periods.energy.add(energy);
        periods.energy_squares.add(energy * energy);
        periods.velocity_fourths.add(square * square);
        periods.products.add(energy * square);
        if settles {
            periods.settling.add(self.last);
        }
    }

    /// The harvester restarts at rest after an outage; both times in s.
    pub(super) fn lose(&mut self, outage: S, period: S) {
        let [power, energy] = &mut self.periods.lost;
        *power += self.last / period;
        *energy += self.last / period * outage;
    }

    /// Energy in J that was delivered while the harvester settled, and that which the motions before outages would deliver in
    /// these and in free decay, at this rate of the amplitude, for this time in s at most.
    pub(super) fn settling_and_lost(&self, decay_rate: S, seconds: S) -> [S; 2] {
        let [power, energy] = self.periods.lost;
        let decay = (S::from_f64(0.5) / decay_rate).min(seconds);
        [self.periods.settling.value(), power * decay + energy]
    }

    /// The sums begin anew; the motion continues, and with it the decay of a lost one while the harvester settles.
    pub(super) fn clear(&mut self, settles: bool) {
        let [power, _] = self.periods.lost;
        self.periods =
            Periods { lost: [if settles { power } else { S::ZERO }, S::ZERO], ..Periods::default() };
        *self = Self { samples: 0, period: [S::ZERO; 5], ..*self };
    }

    /// Whether a period has ended since the sums began.
    pub(super) fn has_whole_period(&self) -> bool {
        self.periods.count > 0
    }

    /// The means of `sin² x` and `sin⁴ x` in all whole periods, 0 to 1, with `x` half the turn of a sampling interval; `None`
    /// without motion.
    pub(super) fn frequencies(&self) -> Option<[S; 2]> {
        let [squares, slopes, bends, ..] = self.periods.squares.each_ref().map(CompensatedSum::value);
        let parts = [S::from_f64(0.25) * slopes, S::from_f64(0.0625) * bends];
        (squares > S::ZERO).then(|| parts.map(|part| (part / squares).min(S::ONE)))
    }

    /// The mean squares of velocity, sample and change of the sample in all whole periods of so many samples, in SI units;
    /// `None` before the first one has ended.
    pub(super) fn mean_squares(&self, per_period: u32) -> Option<[S; 3]> {
        let samples = S::from_u32(self.periods.count) * S::from_u32(per_period);
        let [velocity, _, _, sample, rise] = self.periods.squares.each_ref().map(|sum| sum.value() / samples);
        self.has_whole_period().then_some([velocity, sample, rise])
    }

    /// Relative change of the energy per relative change of the amplitude, 2 to 20.
    pub(super) fn gain(&self) -> S {
        let Periods { count, squares: [squares, ..], energy, velocity_fourths, products, .. } = &self.periods;
        let (least, largest) = (S::from_f64(LEAST_GAIN), S::from_f64(LARGEST_GAIN));
        if *count < LEAST_PERIODS {
            return largest;
        }
        let (squares, energy, fourths) = (squares.value(), energy.value(), velocity_fourths.value());
        let mean = squares / S::from_u32(*count);
        let variance = fourths - mean * squares;
        if !(variance > S::EPSILON * S::from_f64(VARIANCE_ROUNDINGS) * fourths) {
            return least;
        }
        let slope = (products.value() - mean * energy) / variance;
        (least * slope * squares / energy.abs().max(S::TINY)).max(least).min(largest)
    }

    /// Standard error of the difference of the mean energies of two motions, relative to the mean, as if they and their
    /// periods were independent; √2 if it is not known.
    fn difference(&self) -> S {
        let Periods { count, energy, energy_squares, .. } = &self.periods;
        let both = S::from_f64(core::f64::consts::SQRT_2);
        if *count < LEAST_PERIODS {
            return both;
        }
        let (sum, count) = (energy.value(), S::from_u32(*count));
        let deviations = (energy_squares.value() - sum * sum / count).max(S::ZERO);
        both * ((deviations * count / (count - S::ONE)).sqrt() / sum.abs().max(S::TINY))
    }

    /// The relative difference of the energies of two motions under one input: the scatter of the periods, of both motions, by the
    /// part of the time in which they are independent, with the coverage of two standard errors. Where that part is not known it
    /// is the time after impacts, and the coverage one standard error.
    pub(super) fn irregularity(&self, independent: Option<S>) -> S {
        let Periods { count, with_impact, .. } = self.periods;
        let affected = S::from_u32(with_impact) * S::from_f64(PERIODS_AFTER_IMPACT);
        let after_impacts = (affected / S::from_u32(count.max(1))).min(S::ONE);
        self.difference() * independent.map_or(after_impacts, |part| S::from_f64(STANDARD_ERRORS) * part)
    }
}

snapshot_fields!(impl [S: Scalar] Response<S> { velocity, slope, samples, period, last, periods });
snapshot_fields!(impl [S: Scalar] Periods<S> {
    count, with_impact, squares, energy, energy_squares, velocity_fourths, products, settling, lost,
} if |periods| periods.with_impact <= periods.count);
