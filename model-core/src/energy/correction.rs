//! The measured voltage of the store as an observation: of the stored energy, and of the gain by which the
//! modelled income must be multiplied to give the true one.
//!
//! A Kalman filter with two states, the gain `g` and the stored energy `E`. Over an interval of modelled
//! income `m` and known expenditure `u`, with the store's closed form `w = e^(−x)`, `φ = (1 − w)/x`,
//!
//! ```text
//! E ← w E + (g m − u) φ,   g ← g + random walk
//! ```
//!
//! Energy is linear in both. What is read is a code: that the voltage, with its noise, lies in one
//! cell of the converter. Between two readings a capacitor often stays in the same cell, and then the error of
//! the second is that of the first: a filter that took each as a new sample with variance `Δ²/12` would count
//! one piece of news sixty times an hour. So the observation is taken as what it is. Given the state, the
//! reading's energy is normal with variance `P + R`; its mean and variance *within the cell* follow by
//! quadrature, and the filter is updated with these: the Gaussian fit of R. E. Curry, *Estimation and Control
//! with Quantized Measurements*, MIT Press 1970. Where the state is less certain than a cell is wide, that is
//! the usual update with `Δ²/12`; where it is more certain and well inside, nothing is learnt; and when the
//! code changes, or does not where it should have, the edge of the cell is.
//!
//! # What can be had
//!
//! After an hour the gain is known to about a third of a cell over what the true income alone would have moved
//! the voltage in that time: to 5 % (three standard deviations) where that is some 20 cells or more, however
//! little the voltage moves in the end because the load takes as much. With 12 bits over 5 V and the store at
//! 3 V a cell is 0.17 µJ for 47 µF, 3.7 µJ for 1 mF and 3.7 mJ for 1 F: an income of 1 nW, 20 nW and 20 µW
//! into the store. Below that [`CorrectionState::income_error`] says so. Nothing is learnt of the gain
//! while the store is full, whose income is shunted. Known are taken capacitance, leakage, efficiencies and
//! expenditure: an error in them goes into the gain, and is not in the error figure.

use super::storage::Storage;
use crate::part::bounds::{Bounds, ParameterError};
use crate::scalar::{Mathematics, Scalar, add_increment};

/// How the voltage is read, and what is thought of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CorrectionParameters<S> {
    /// Resolution of the converter in bits, 4 to 16. Code `k` stands for the voltages nearest to
    /// `k · full_scale / 2^bits`.
    pub bits: u32,
    /// Full scale in volts.
    pub full_scale: S,
    /// Standard deviation of a reading's noise in volts, independent from reading to reading; 0 if it is small
    /// against a cell.
    pub noise: S,
    /// Standard deviation of the gain about 1 before any reading.
    pub gain_deviation: S,
    /// Standard deviation of what the gain changes in an hour, for a model whose error is not constant.
    pub gain_drift: S,
}

/// The estimator, its parameters checked.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Correction<S> {
    storage: Storage<S>,
    cell: S,
    full_code: u32,
    noise: S,
    gain_variance: S,
    /// Variance of the gain gained per second.
    drift: S,
}

/// What the estimator knows. The variances in squares of one and of joules.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CorrectionState<S> {
    gain: S,
    energy: S,
    energy_low: S,
    gain_variance: S,
    covariance: S,
    energy_variance: S,
    /// Whether the store has been read at all.
    located: bool,
    rejected_in_turn: u32,
    used: u32,
    saturated: u32,
    rejected: u32,
}

/// What was made of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reading {
    /// It has been used.
    Used,
    /// It is the highest code, which says no more than that the voltage is at least that; not used.
    Saturated,
    /// It is 0, at which no node runs, or too far from what is expected; not used.
    Rejected,
}

/// The gain is kept from 0 to this.
const HIGHEST_GAIN: f64 = 10.0;

/// A reading is rejected whose cell is more than this number of standard deviations away.
const GATE: f64 = 5.0;

/// After this number of rejected readings in turn the model is wrong and not the reading.
const PATIENCE: u32 = 10;

/// The gain is not claimed to be known better than this part of it: the arithmetic of `f32`, and no model is.
const LEAST_DEVIATION: f64 = 1e-3;

impl<S: Scalar> CorrectionParameters<S> {
    /// Checks the parameters, for readings of the voltage of `storage`.
    ///
    /// # Errors
    /// The first field that is out of its bounds.
    pub fn build(self, storage: &Storage<S>) -> Result<Correction<S>, ParameterError<S>> {
        Bounds::new(4.0, 16.0).check("bits", S::from_u32(self.bits))?;
        Bounds::new(0.01, 1e3).check("full_scale", self.full_scale)?;
        Bounds { lowest: S::ZERO, highest: self.full_scale }.check("noise", self.noise)?;
        Bounds::new(LEAST_DEVIATION, HIGHEST_GAIN).check("gain_deviation", self.gain_deviation)?;
        Bounds::new(0.0, HIGHEST_GAIN).check("gain_drift", self.gain_drift)?;
        let codes = 1_u32 << self.bits.min(16);
        Ok(Correction {
            storage: *storage,
            cell: self.full_scale / S::from_u32(codes),
            full_code: codes - 1,
            noise: self.noise,
            gain_variance: self.gain_deviation * self.gain_deviation,
            drift: self.gain_drift * self.gain_drift * S::literal(1.0 / 3600.0),
        })
    }
}

impl<S: Scalar> CorrectionState<S> {
    /// What the modelled income must be multiplied by, 0 to 10.
    #[must_use]
    pub fn gain(&self) -> S {
        self.gain
    }

    /// Standard deviation of the gain.
    #[must_use]
    pub fn gain_deviation(&self) -> S {
        self.gain_variance.square_root()
    }

    /// Standard deviation of the income estimate as a part of it; infinite if the gain is 0.
    #[must_use]
    pub fn income_error(&self) -> S {
        if self.gain > S::ZERO { self.gain_deviation() / self.gain } else { S::INFINITY }
    }

    /// Stored energy in joules.
    #[must_use]
    pub fn energy(&self) -> S {
        self.energy
    }

    /// Standard deviation of the stored energy in joules.
    #[must_use]
    pub fn energy_deviation(&self) -> S {
        self.energy_variance.square_root()
    }

    /// Number of readings that were used.
    #[must_use]
    pub fn used(&self) -> u32 {
        self.used
    }

    /// Number of readings at full scale.
    #[must_use]
    pub fn saturated(&self) -> u32 {
        self.saturated
    }

    /// Number of readings that were rejected.
    #[must_use]
    pub fn rejected(&self) -> u32 {
        self.rejected
    }
}

impl<S: Scalar> Correction<S> {
    /// The state before any reading: a gain of 1, the store unknown.
    #[must_use]
    pub fn start(&self) -> CorrectionState<S> {
        let half = S::literal(0.5) * self.storage.capacity();
        CorrectionState {
            gain: S::ONE,
            energy: half,
            energy_low: S::ZERO,
            gain_variance: self.gain_variance,
            covariance: S::ZERO,
            energy_variance: half * half,
            located: false,
            rejected_in_turn: 0,
            used: 0,
            saturated: 0,
            rejected: 0,
        }
    }

    /// Time moves on by `interval` seconds, for which the model says that `modelled` joules were harvested, and
    /// in which `spent` joules were used by the load, all of it. At most one exponential.
    ///
    /// Energies that are negative or not finite are taken as none, and leave store and gain unknown anew.
    pub fn predict(&self, state: &mut CorrectionState<S>, interval: u32, modelled: S, spent: S) {
        let sound = |energy: S| energy >= S::ZERO && energy < S::INFINITY;
        if !(sound(modelled) && sound(spent)) {
            self.forget(state);
            return;
        }
        let seconds = S::from_u32(interval);
        let relaxation = self.storage.relaxation(seconds);
        let (income, outgo) = (self.storage.stored(modelled), self.storage.drawn(spent));
        let step = self.storage.step(state.energy, &relaxation, state.gain * income, outgo);
        let (kept, sensitivity) = (relaxation.kept, income * relaxation.of_income);
        let covariance = kept * state.covariance + sensitivity * state.gain_variance;
        state.energy_variance =
            kept * kept * state.energy_variance + sensitivity * (kept * state.covariance + covariance);
        state.covariance = covariance;
        if step.shunted > S::ZERO || step.unserved > S::ZERO {
            // At a limit the gain does not show.
            state.covariance = S::ZERO;
            (state.energy, state.energy_low) = (step.end, S::ZERO);
        } else {
            (state.energy, state.energy_low) = add_increment(state.energy, state.energy_low, step.change);
        }
        let highest = S::literal(HIGHEST_GAIN * HIGHEST_GAIN);
        state.gain_variance = (state.gain_variance + self.drift * seconds).smaller(highest);
    }

    /// Takes in a reading of the voltage. A quadrature of 25 exponentials and a square root.
    pub fn observe(&self, state: &mut CorrectionState<S>, code: u32) -> Reading {
        if code >= self.full_code {
            state.saturated = state.saturated.saturating_add(1);
            return Reading::Saturated;
        }
        if code == 0 {
            state.rejected = state.rejected.saturating_add(1);
            return Reading::Rejected;
        }
        let (half, voltage) = (S::literal(0.5) * self.cell, S::from_u32(code) * self.cell);
        let (low, high) = (self.storage.energy(voltage - half), self.storage.energy(voltage + half));
        // dE = C V dV, and a cell is C V Δ wide.
        let noise = (high - low) * (self.noise / self.cell);
        let noise_variance = noise * noise;
        if !state.located {
            self.locate(state, low, high, noise_variance);
            return Reading::Used;
        }
        let variance = state.energy_variance + noise_variance;
        let deviation = variance.square_root();
        let within = ((low - state.energy) / deviation, (high - state.energy) / deviation);
        let Some((mean, spread)) = moments_within(within.0, within.1) else {
            self.reject(state);
            return Reading::Rejected;
        };
        if high + (high - low) >= self.storage.capacity() {
            // Full, or nearly: more income would not show.
            state.covariance = S::ZERO;
        }
        let shift = mean / deviation;
        let highest = S::literal(HIGHEST_GAIN);
        state.gain = (state.gain + state.covariance * shift).larger(S::ZERO).smaller(highest);
        let energy = state.energy + (state.energy_low + state.energy_variance * shift);
        state.energy = energy.larger(S::ZERO).smaller(self.storage.capacity());
        state.energy_low = S::ZERO;
        // What is left: all of it for pure noise, `spread` of it without noise.
        let left = (noise_variance + state.energy_variance * spread) / variance;
        let learnt = state.covariance * state.covariance * (S::ONE - spread) / variance;
        let least = S::literal(LEAST_DEVIATION) * state.gain;
        state.gain_variance = (state.gain_variance - learnt).larger(least * least);
        state.covariance *= left;
        state.energy_variance = (state.energy_variance * left).larger(self.least_energy_variance());
        // The variances are those of something.
        let bound = (state.gain_variance * state.energy_variance).square_root();
        state.covariance = state.covariance.smaller(bound).larger(-bound);
        state.rejected_in_turn = 0;
        state.used = state.used.saturating_add(1);
        Reading::Used
    }

    /// The first reading tells where the store is, and nothing of the gain.
    fn locate(&self, state: &mut CorrectionState<S>, low: S, high: S, noise_variance: S) {
        let width = high - low;
        state.energy = (S::literal(0.5) * (low + high)).smaller(self.storage.capacity());
        state.energy_low = S::ZERO;
        state.covariance = S::ZERO;
        state.energy_variance = width * width * S::literal(1.0 / 12.0) + noise_variance;
        state.located = true;
        state.rejected_in_turn = 0;
        state.used = state.used.saturating_add(1);
    }

    fn reject(&self, state: &mut CorrectionState<S>) {
        state.rejected = state.rejected.saturating_add(1);
        state.rejected_in_turn += 1;
        if state.rejected_in_turn >= PATIENCE {
            self.forget(state);
        }
    }

    /// The store is to be located anew, and the gain as uncertain as at the start.
    fn forget(&self, state: &mut CorrectionState<S>) {
        state.located = false;
        state.rejected_in_turn = 0;
        state.covariance = S::ZERO;
        state.gain_variance = state.gain_variance.larger(self.gain_variance);
        let capacity = self.storage.capacity();
        state.energy_variance = capacity * capacity;
    }

    /// A few roundings of the stored energy.
    fn least_energy_variance(&self) -> S {
        let rounding = S::literal(4.0) * S::EPSILON * self.storage.capacity();
        rounding * rounding
    }
}

/// Panels of Simpson's rule.
const PANELS: u32 = 12;

/// Mean and variance of a standard normal number that is known to lie from `low` to `high`; `None` if that is
/// more than [`GATE`] away from 0, or one is not a number.
///
/// Simpson's rule on the density relative to its largest value there, which neither underflows nor cancels
/// however far out: within 2·10⁻³.
fn moments_within<S: Scalar>(low: S, high: S) -> Option<(S, S)> {
    let gate = S::literal(GATE);
    if !(low <= gate && high >= -gate) {
        return None;
    }
    // The point of largest density, and the distance in which it has vanished: the width of a normal there,
    // of an exponential further out.
    let peak = S::ZERO.larger(low).smaller(high);
    let reach = S::literal(10.0) / S::ONE.larger(peak.absolute()) * S::literal(0.5);
    let (start, end) = (low.larger(peak - reach), high.smaller(peak + reach));
    let step = (end - start) / S::from_u32(2 * PANELS);
    let half = S::literal(0.5);
    let (mut mass, mut first, mut second) = (S::ZERO, S::ZERO, S::ZERO);
    for k in 0..=2 * PANELS {
        let weight = if k == 0 || k == 2 * PANELS { 1 } else { 2 + 2 * (k & 1) };
        // From the peak, so that a narrow cell far out keeps its digits.
        let distance = (start - peak) + step * S::from_u32(k);
        let density = S::Build::exponential(-distance * (peak + half * distance));
        let part = density * S::from_u32(weight);
        mass += part;
        first += part * distance;
        second += part * distance * distance;
    }
    let mean = first / mass;
    let spread = (second / mass - mean * mean).larger(S::ZERO).smaller(S::ONE);
    Some((peak + mean, spread))
}
