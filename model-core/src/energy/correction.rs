//! Estimates the stored energy and the gain of the modelled income from readings of the storage's voltage.
//!
//! A Kalman filter with two states: the gain `g`, the ratio of the true to the modelled income, and the
//! stored energy `E` in J. Over an interval with the modelled income `m` and the known expenditure `u` in J,
//! and with the closed form of the storage `w = e^(−x)`, `φ = (1 − w)/x`,
//!
//! ```text
//! E ← w E + (g m − u) φ,   g ← g + random walk.
//! ```
//!
//! `E` is linear in both states. A reading is a code: the voltage, with its noise, lies in one cell of the
//! converter. Between two readings a capacitor often stays in the same cell, and the errors of the two
//! readings are then the same. A filter with each reading as a new sample of variance `Δ²/12` would count the
//! same error many times. So the measurement update uses the quantised reading itself. Given the state, the
//! energy of the reading is normal with the variance `P + R`. Its mean and variance *within the cell* follow
//! by quadrature, and they update the filter: the Gaussian fit of R. E. Curry, *Estimation and Control with
//! Quantized Measurements*, MIT Press 1970. If the standard deviation of the state is wider than a cell, this
//! is the usual update with `Δ²/12`. If it is narrower and the state is well inside the cell, the update
//! changes nothing. A change of the code, or a missing change, locates the edge of the cell.

use super::account::is_energy;
use super::storage::Storage;
use super::truncated_normal::moments_within;
use crate::bounds::{Bounds, ParameterError};
use crate::scalar::{Scalar, add_increment};
use crate::snapshot::{Configuration, Fingerprint, snapshot_fields};

/// Parameters of a [`Correction`]: of the readings, and of the error of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CorrectionParameters<S> {
    /// Resolution of the converter in bits, 4 to 16. Code `k` means that `k · full_scale / 2^bits` is the
    /// nearest voltage.
    pub bits: u32,
    /// Full scale of the converter in V, 0.01 to 1000.
    pub full_scale: S,
    /// Standard deviation of the noise of a reading in V, independent from reading to reading, at most
    /// `full_scale`. A value below a fifth of a cell is raised to a fifth of a cell.
    pub noise: S,
    /// Standard deviation of the gain about 1 before any reading, 10⁻³ to 10.
    pub gain_deviation: S,
    /// Standard deviation of the change of the gain in an hour, 0 to 10.
    pub gain_drift: S,
}

/// An estimator of the stored energy and of the gain of the modelled income, from readings of the storage's voltage.
///
/// # Accuracy
///
/// The accuracy depends on the number `n` of cells by which the true income alone would have moved the
/// voltage. After an hour with a reading a minute, the standard deviation of the gain relative to the gain is
/// `0.15/n` with a noise of up to a fifth of a cell, `0.24/n` with half a cell and `0.43/n` with a whole
/// cell. The income estimate is within 5 % in 95 of 100 cases from 4, 10 and 20 cells on.
///
/// With less income, [`CorrectionEstimate::income_error`] states a larger error.
///
/// A full storage carries no information about the gain, because its income is shunted. The filter assumes
/// exact capacitance, leakage, efficiencies and expenditure: their errors enter the gain, and the stated
/// error excludes them.
///
/// ```
/// use model_core::energy::{BudgetParameters, Capacitor, CorrectionParameters, IncomeParameters, StorageParameters};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let storage = StorageParameters::<f32> {
///     capacitor: Capacitor { capacitance: 100e-6, leakage_resistance: f32::INFINITY },
///     charging_efficiency: 0.8,
///     discharging_efficiency: 0.9,
///     highest_voltage: 4.9,
///     lock_out_voltage: 1.8,
///     turn_on_voltage: 2.4,
/// };
/// let income = IncomeParameters { time_constant: 3600.0, day_weight: 0.5 };
/// let standing_power = 0.1e-6;
/// let budget = BudgetParameters { storage, income, standing_power }.build::<48>()?;
/// let reading =
///     CorrectionParameters { bits: 12, full_scale: 5.0, noise: 0.5e-3, gain_deviation: 1.0, gain_drift: 0.05 };
/// let correction = reading.build(budget.storage())?;
///
/// let (mut state, mut correcting) = (budget.start(0), correction.start());
/// let mut truth = 3.0_f64; // V; the true income is twice the modelled one
/// for _minute in 0..60 {
///     let (modelled, spent) = (6e-6, 4e-6); // joules in this minute
///     let used = spent + standing_power * 60.0;
///     let before = correcting.estimate();
///     budget.update(&mut state, 60, before.gain * modelled, spent);
///     // The error of the income.
///     state.raise_uncertainty(3.0 * before.gain_deviation * budget.storage().stored(modelled));
///     correction.predict(&mut correcting, 60, modelled, used);
///     truth = (truth * truth + (2.0 * 6e-6 * 0.8 - f64::from(used) / 0.9) * 2e4).sqrt();
///     correction.observe(&mut correcting, (truth * 4096.0 / 5.0).round() as u32);
///     let after = correcting.estimate();
///     budget.correct(&mut state, after.energy, 3.0 * after.energy_deviation);
/// }
/// let found = correcting.estimate();
/// assert!((found.gain - 2.0).abs() < 0.1 && found.income_error < 0.05);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Correction<S> {
    storage: Storage<S>,
    /// Width of a cell of the converter in V.
    cell: S,
    /// The highest code.
    full_code: u32,
    /// Standard deviation of the noise in V.
    noise: S,
    /// Variance of the gain before any reading.
    gain_variance: S,
    /// Increase of the variance of the gain per second.
    drift: S,
}

/// The state of a [`Correction`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CorrectionState<S> {
    gain: S,
    /// Stored energy in J.
    energy: S,
    /// The part of `energy` that rounding removed.
    energy_low: S,
    gain_variance: S,
    /// Covariance of gain and stored energy in J.
    covariance: S,
    /// Variance of the stored energy in J².
    energy_variance: S,
    /// Whether the stored energy is known.
    located: bool,
    /// Whether the last reading found the storage full.
    was_full: bool,
    /// Number of successive rejected readings.
    rejected_in_turn: u32,
    used: u32,
    saturated: u32,
    rejected: u32,
}

/// Result of a [`Correction`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct CorrectionEstimate<S> {
    /// Gain of the modelled income, 0 to 10.
    pub gain: S,
    /// Standard deviation of the gain.
    pub gain_deviation: S,
    /// Standard deviation of the gain relative to the gain; infinite if the gain is 0.
    pub income_error: S,
    /// Stored energy in J. Between a prediction and the next reading, the limits of the storage are ignored.
    pub energy: S,
    /// Standard deviation of the stored energy in J.
    pub energy_deviation: S,
    /// Number of used readings.
    pub used: u32,
    /// Number of readings at full scale.
    pub saturated: u32,
    /// Number of rejected readings.
    pub rejected: u32,
}

/// The use of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Reading {
    /// Used.
    Used,
    /// Not used: at the highest code the voltage may be any higher voltage.
    Saturated,
    /// Not used: the code is 0, at which no node runs, or too far from the expected code.
    Rejected,
}

/// Largest gain.
const HIGHEST_GAIN: f64 = 10.0;

/// Least noise of a reading in cells. Without noise the edges of cells count as exact, and one case in a
/// hundred ends with a wrong gain that is stated as certain.
const LEAST_NOISE: f64 = 0.2;

/// A reading is rejected if the distance to its cell exceeds the sum of this number of standard deviations
/// and [`GATE_CELLS`].
const GATE: f64 = 5.0;

/// Number of cells in the limit of rejection: after a long time within one cell the energy is less certain
/// than its variance states.
const GATE_CELLS: f64 = 2.0;

/// Largest magnitude of the stored energy and its standard deviation, in J: their products are finite in `f32`. A
/// capacity, and a booked energy times the largest gain, are below it.
const LARGEST_STORED: f64 = 1e12;

/// Number of successive rejected readings after which the state is taken to be wrong.
const MOST_REJECTED_IN_TURN: u32 = 10;

/// Least standard deviation of the gain relative to the gain, above the rounding of `f32`.
const LEAST_DEVIATION: f64 = 1e-3;

impl<S: Scalar> CorrectionParameters<S> {
    /// Checks the parameters for readings of the voltage of `storage`.
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
        let cell = self.full_scale / S::from_u32(codes);
        Ok(Correction {
            storage: *storage,
            cell,
            full_code: codes - 1,
            noise: self.noise.max(S::from_f64(LEAST_NOISE) * cell),
            gain_variance: self.gain_deviation * self.gain_deviation,
            drift: self.gain_drift * self.gain_drift * S::from_f64(1.0 / 3600.0),
        })
    }
}

impl<S: Scalar> CorrectionState<S> {
    /// Whether the stored energy and its variance are within [`LARGEST_STORED`].
    fn is_bounded(&self) -> bool {
        let largest = S::from_f64(LARGEST_STORED);
        let energies = self.energy.abs().max(self.energy_low.abs()) <= largest;
        energies && self.energy_variance <= largest * largest
    }

    /// Whether the covariance is that of a correlation of at most 1, within rounding.
    fn is_correlation(&self) -> bool {
        let product = self.gain_variance * self.energy_variance;
        let rounding = S::from_f64(16.0) * S::EPSILON;
        self.covariance * self.covariance <= product + (product * rounding + S::TINY)
    }

    /// Limits the covariance to a correlation of 1, which the roundings of many predictions may exceed.
    fn limit_covariance(&mut self) {
        if !self.is_correlation() {
            let bound = (self.gain_variance * self.energy_variance).sqrt();
            self.covariance = self.covariance.min(bound).max(-bound);
        }
    }

    /// Gain, stored energy, their standard deviations, and the numbers of readings.
    #[must_use]
    pub fn estimate(&self) -> CorrectionEstimate<S> {
        let gain_deviation = self.gain_variance.sqrt();
        CorrectionEstimate {
            gain: self.gain,
            gain_deviation,
            income_error: if self.gain > S::ZERO { gain_deviation / self.gain } else { S::INFINITY },
            energy: self.energy,
            energy_deviation: self.energy_variance.sqrt(),
            used: self.used,
            saturated: self.saturated,
            rejected: self.rejected,
        }
    }
}

impl<S: Scalar> Correction<S> {
    /// The state before any reading: a gain of 1 and an unknown stored energy.
    #[must_use]
    pub fn start(&self) -> CorrectionState<S> {
        let half = S::from_f64(0.5) * self.storage.capacity();
        CorrectionState {
            gain: S::ONE,
            energy: half,
            energy_low: S::ZERO,
            gain_variance: self.gain_variance,
            covariance: S::ZERO,
            energy_variance: half * half,
            located: false,
            was_full: false,
            rejected_in_turn: 0,
            used: 0,
            saturated: 0,
            rejected: 0,
        }
    }

    /// Advances the time by `interval` in s with a `modelled` income and all energy `spent` by the load, both in J.
    ///
    /// An energy that is negative, not finite, or above 10⁹ J makes the stored energy and the gain as uncertain as at
    /// the start. A predicted energy or standard deviation above 10¹² J makes the stored energy unknown.
    ///
    /// Cost: at most one exponential, and a square root if rounding has brought the correlation above 1.
    pub fn predict(&self, state: &mut CorrectionState<S>, interval: u32, modelled: S, spent: S) {
        if !(is_energy(modelled) && is_energy(spent)) {
            self.forget(state);
            return;
        }
        let seconds = S::from_u32(interval);
        let relaxation = self.storage.relaxation(seconds);
        let (income, outgo) = (self.storage.stored(modelled), self.storage.drawn(spent));
        // The limits of the storage are ignored: if a wrong gain predicts more than the capacity, or a
        // negative energy, the distance to the reading shows the error of the gain.
        let change = self.storage.step(state.energy, &relaxation, state.gain * income, outgo).change;
        (state.energy, state.energy_low) = add_increment(state.energy, state.energy_low, change);
        let (kept, sensitivity) = (relaxation.kept, income * relaxation.of_income);
        let covariance = kept * state.covariance + sensitivity * state.gain_variance;
        state.energy_variance =
            kept * kept * state.energy_variance + sensitivity * (kept * state.covariance + covariance);
        state.covariance = covariance;
        let highest = S::from_f64(HIGHEST_GAIN * HIGHEST_GAIN);
        state.gain_variance = (state.gain_variance + self.drift * seconds).min(highest);
        state.limit_covariance();
        if !state.is_bounded() {
            let largest = S::from_f64(LARGEST_STORED);
            state.energy = state.energy.max(-largest).min(largest);
            state.energy_low = S::ZERO;
            self.forget_energy(state);
        }
    }

    /// Distance of the cell of a reading from the expected stored energy, in standard deviations of both; 0 if the
    /// expected energy is in the cell, or unknown. A node listens again after a large one
    /// ([`Listening::is_due`](super::Listening::is_due)).
    #[must_use]
    pub fn departure(&self, state: &CorrectionState<S>, code: u32) -> S {
        if !state.located {
            return S::ZERO;
        }
        let (half, voltage) = (S::from_f64(0.5) * self.cell, S::from_u32(code) * self.cell);
        let low = self.storage.energy((voltage - half).max(S::ZERO));
        let high = self.storage.energy(voltage + half);
        let noise = (high - low) * (self.noise / self.cell);
        let distance = (low - state.energy).max(state.energy - high).max(S::ZERO);
        distance / (state.energy_variance + noise * noise).sqrt()
    }

    /// Updates the state by a reading of the voltage.
    ///
    /// Cost: 25 exponentials and four square roots.
    pub fn observe(&self, state: &mut CorrectionState<S>, code: u32) -> Reading {
        let reach = S::from_f64(GATE) * state.energy_variance.sqrt();
        if code >= self.full_code {
            state.saturated = state.saturated.saturating_add(1);
            if state.energy + reach >= self.storage.energy(S::from_u32(code) * self.cell) {
                // The storage may be at that voltage, and full.
                self.forget_energy(state);
            }
            return Reading::Saturated;
        }
        if code == 0 {
            state.rejected = state.rejected.saturating_add(1);
            return Reading::Rejected;
        }
        let (half, voltage) = (S::from_f64(0.5) * self.cell, S::from_u32(code) * self.cell);
        let (low, high) = (self.storage.energy(voltage - half), self.storage.energy(voltage + half));
        // dE = C V dV, and a cell is C V Δ wide.
        let noise = (high - low) * (self.noise / self.cell);
        let full = high + (high - low) + noise + noise >= self.storage.capacity();
        // Shunted income does not appear in the reading. If the storage was full at either end of the
        // interval, the reading carries no information about the gain, and the predicted energy may exceed
        // the reading by any amount.
        let limited = full || state.was_full;
        if !state.located || (limited && state.energy + reach >= low) {
            self.locate(state, low, high, noise);
            state.was_full = full;
            return Reading::Used;
        }
        let noise_variance = noise * noise;
        let variance = state.energy_variance + noise_variance;
        let deviation = variance.sqrt();
        let gate = S::from_f64(GATE) * deviation + S::from_f64(GATE_CELLS) * (high - low);
        if !(low - state.energy <= gate && state.energy - high <= gate) {
            self.reject(state);
            return Reading::Rejected;
        }
        let (low, high) = ((low - state.energy) / deviation, (high - state.energy) / deviation);
        let (mean, spread) = moments_within(low, high);
        state.was_full = full;
        let shift = mean / deviation;
        let highest = S::from_f64(HIGHEST_GAIN);
        state.gain = (state.gain + state.covariance * shift).max(S::ZERO).min(highest);
        let energy = state.energy + (state.energy_low + state.energy_variance * shift);
        state.energy = energy.max(S::ZERO).min(self.storage.capacity());
        state.energy_low = S::ZERO;
        // The remaining part of the variance: 1 for pure noise, `spread` without noise.
        let left = (noise_variance + state.energy_variance * spread) / variance;
        let learnt = state.covariance * state.covariance * (S::ONE - spread) / variance;
        let least = S::from_f64(LEAST_DEVIATION) * state.gain;
        state.gain_variance = (state.gain_variance - learnt).max(least * least);
        state.covariance *= left;
        let rounding = S::from_f64(4.0) * S::EPSILON * self.storage.capacity();
        state.energy_variance = (state.energy_variance * left).max(rounding * rounding);
        // A correlation of at most 1.
        let bound = (state.gain_variance * state.energy_variance).sqrt();
        state.covariance = state.covariance.min(bound).max(-bound);
        state.rejected_in_turn = 0;
        state.used = state.used.saturating_add(1);
        Reading::Used
    }

    /// Makes the stored energy unknown, after an unknown income or expenditure. The next reading determines
    /// the stored energy and leaves the gain unchanged.
    pub(crate) fn forget_energy(&self, state: &mut CorrectionState<S>) {
        let capacity = self.storage.capacity();
        state.located = false;
        state.rejected_in_turn = 0;
        state.covariance = S::ZERO;
        state.energy_variance = capacity * capacity;
    }

    /// Determines the stored energy by a reading alone.
    fn locate(&self, state: &mut CorrectionState<S>, low: S, high: S, noise: S) {
        let width = high - low;
        state.energy = (S::from_f64(0.5) * (low + high)).min(self.storage.capacity());
        state.energy_low = S::ZERO;
        state.covariance = S::ZERO;
        state.energy_variance = width * width * S::from_f64(1.0 / 12.0) + noise * noise;
        state.located = true;
        state.rejected_in_turn = 0;
        state.used = state.used.saturating_add(1);
    }

    /// Counts a rejected reading.
    fn reject(&self, state: &mut CorrectionState<S>) {
        state.rejected = state.rejected.saturating_add(1);
        state.rejected_in_turn += 1;
        if state.rejected_in_turn >= MOST_REJECTED_IN_TURN {
            self.forget(state);
        }
    }

    /// Makes the stored energy unknown, and the gain at least as uncertain as at the start.
    fn forget(&self, state: &mut CorrectionState<S>) {
        self.forget_energy(state);
        state.gain_variance = state.gain_variance.max(self.gain_variance);
    }
}

snapshot_fields!(impl [S: Scalar] CorrectionState<S> {
    gain, energy, energy_low, gain_variance, covariance, energy_variance, located, was_full, rejected_in_turn, used,
    saturated, rejected,
} if |state| {
    let highest = S::from_f64(HIGHEST_GAIN * HIGHEST_GAIN);
    let gain_variance = state.gain_variance >= S::ZERO && state.gain_variance <= highest;
    let variances = gain_variance && state.energy_variance >= S::ZERO && state.is_correlation();
    let gain = state.gain >= S::ZERO && state.gain <= S::from_f64(HIGHEST_GAIN);
    variances && gain && state.is_bounded() && state.rejected_in_turn < MOST_REJECTED_IN_TURN
});

impl<S: Scalar> Configuration for Correction<S> {
    type State = CorrectionState<S>;

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("correction");
        self.storage.identify(fingerprint);
        fingerprint.count(self.full_code);
        fingerprint.numbers(&[self.cell, self.noise, self.gain_variance, self.drift]);
    }
}
