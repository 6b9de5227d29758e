//! The measured voltage of the storage as an observation: of the stored energy, and of the gain by which the
//! modelled income must be multiplied to give the true one.
//!
//! A Kalman filter with two states, the gain `g` and the stored energy `E`. Over an interval of modelled
//! income `m` and known expenditure `u`, with the storage's closed form `w = e^(−x)`, `φ = (1 − w)/x`,
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
//! What counts is by how many cells the true income alone would have moved the voltage, however little it moves in
//! the end because the load takes as much. After `n` such cells in an hour of a reading a minute the gain is known,
//! as a standard deviation, to `0.15/n` of itself with a noise of up to a fifth of a cell, `0.24/n` with half a cell,
//! `0.43/n` with a whole one; the income estimate is within 5 % in 95 of 100 cases from 4, 10 and 20 cells on.
//! With 12 bits over 5 V and the storage at 3 V a cell is 0.17 µJ for 47 µF, 3.7 µJ for 1 mF and 3.7 mJ for 1 F, and 20
//! cells in an hour an income into the storage of 1 nW, 20 nW and 20 µW. Below that 5 % cannot be had in the hour,
//! and [`CorrectionState::income_error`] says so. Nothing is learnt of the gain while the storage is full, whose
//! income is shunted. Capacitance, leakage, efficiencies and expenditure are taken as known: an error in them goes
//! into the gain, and is not in the error figure.
//!
//! ```
//! use model_core::energy::{BudgetParameters, CorrectionParameters, IncomeParameters, StorageParameters};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let storage = StorageParameters::<f32> {
//!     capacitance: 100e-6,
//!     leakage_resistance: f32::INFINITY,
//!     charging_efficiency: 0.8,
//!     discharging_efficiency: 0.9,
//!     highest_voltage: 4.9,
//!     lock_out_voltage: 1.8,
//!     turn_on_voltage: 2.4,
//! };
//! let income = IncomeParameters { time_constant: 3600.0, day_weight: 0.5 };
//! let standing_power = 0.1e-6;
//! let budget = BudgetParameters { storage, income, standing_power }.build::<48>()?;
//! let reading =
//!     CorrectionParameters { bits: 12, full_scale: 5.0, noise: 0.5e-3, gain_deviation: 1.0, gain_drift: 0.05 };
//! let correction = reading.build(budget.storage())?;
//!
//! let (mut state, mut estimate) = (budget.start(0), correction.start());
//! let mut truth = 3.0_f64; // volts: what the ADC sees, of twice the income that the model knows of
//! for _minute in 0..60 {
//!     let (modelled, spent) = (6e-6, 4e-6); // joules in this minute
//!     let used = spent + standing_power * 60.0;
//!     budget.update(&mut state, 60, estimate.gain() * modelled, spent);
//!     // How far the income may be off.
//!     state.raise_uncertainty(3.0 * estimate.gain_deviation() * budget.storage().stored(modelled));
//!     correction.predict(&mut estimate, 60, modelled, used);
//!     truth = (truth * truth + (2.0 * 6e-6 * 0.8 - f64::from(used) / 0.9) * 2e4).sqrt();
//!     correction.observe(&mut estimate, (truth * 4096.0 / 5.0).round() as u32);
//!     budget.correct(&mut state, estimate.energy(), 3.0 * estimate.energy_deviation());
//! }
//! assert!((estimate.gain() - 2.0).abs() < 0.1 && estimate.income_error() < 0.05);
//! # Ok(())
//! # }
//! ```

use super::cut_normal::moments_within;
use super::storage::Storage;
use crate::part::bounds::{Bounds, ParameterError};
use crate::scalar::{Scalar, add_increment};

/// How the voltage is read, and what is thought of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CorrectionParameters<S> {
    /// Resolution of the converter in bits, 4 to 16. Code `k` stands for the voltages nearest to
    /// `k · full_scale / 2^bits`.
    pub bits: u32,
    /// Full scale in volts.
    pub full_scale: S,
    /// Standard deviation of a reading's noise in volts, independent from reading to reading; less than a fifth
    /// of a cell counts as that.
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
    /// Whether it is known where the storage is.
    located: bool,
    /// Whether the last reading found it full.
    was_full: bool,
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

/// A reading's noise is not taken to be less than this part of a cell. Were it none, edges of cells would be known
/// exactly, and one case in a hundred would end in a certainty that is false.
const LEAST_NOISE: f64 = 0.2;

/// A reading is rejected whose cell is further away than this number of standard deviations and
const GATE: f64 = 5.0;

/// this number of cells: a storage that was followed inside one cell for long is not as certain as it seems.
const GATE_CELLS: f64 = 2.0;

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
    /// What the modelled income must be multiplied by, 0 to 10.
    #[must_use]
    pub fn gain(&self) -> S {
        self.gain
    }

    /// Standard deviation of the gain.
    #[must_use]
    pub fn gain_deviation(&self) -> S {
        self.gain_variance.sqrt()
    }

    /// Standard deviation of the income estimate as a part of it; infinite if the gain is 0.
    #[must_use]
    pub fn income_error(&self) -> S {
        if self.gain > S::ZERO { self.gain_deviation() / self.gain } else { S::INFINITY }
    }

    /// Stored energy in joules; after a prediction and until the next reading, that of a storage without limits.
    #[must_use]
    pub fn energy(&self) -> S {
        self.energy
    }

    /// Standard deviation of the stored energy in joules.
    #[must_use]
    pub fn energy_deviation(&self) -> S {
        self.energy_variance.sqrt()
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
    /// The state before any reading: a gain of 1, the storage unknown.
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

    /// Time moves on by `interval` seconds, for which the model says that `modelled` joules were harvested, and
    /// in which `spent` joules were used by the load, all of it. At most one exponential.
    ///
    /// Energies that are negative or not finite are taken as none, and leave storage and gain unknown anew.
    pub fn predict(&self, state: &mut CorrectionState<S>, interval: u32, modelled: S, spent: S) {
        let sound = |energy: S| energy >= S::ZERO && energy < S::INFINITY;
        if !(sound(modelled) && sound(spent)) {
            self.forget(state);
            return;
        }
        let seconds = S::from_u32(interval);
        let relaxation = self.storage.relaxation(seconds);
        let (income, outgo) = (self.storage.stored(modelled), self.storage.drawn(spent));
        // The limits of the storage are not the model's to meet: where a gain that is wrong would have filled or
        // emptied it and the reading says otherwise, the reading must find how far off that was.
        let change = self.storage.step(state.energy, &relaxation, state.gain * income, outgo).change;
        (state.energy, state.energy_low) = add_increment(state.energy, state.energy_low, change);
        let (kept, sensitivity) = (relaxation.kept, income * relaxation.of_income);
        let covariance = kept * state.covariance + sensitivity * state.gain_variance;
        state.energy_variance =
            kept * kept * state.energy_variance + sensitivity * (kept * state.covariance + covariance);
        state.covariance = covariance;
        let highest = S::from_f64(HIGHEST_GAIN * HIGHEST_GAIN);
        state.gain_variance = (state.gain_variance + self.drift * seconds).min(highest);
    }

    /// Takes in a reading of the voltage. A quadrature of 25 exponentials, and four square roots.
    pub fn observe(&self, state: &mut CorrectionState<S>, code: u32) -> Reading {
        let reach = S::from_f64(GATE) * state.energy_variance.sqrt();
        if code >= self.full_code {
            state.saturated = state.saturated.saturating_add(1);
            if state.energy + reach >= self.storage.energy(S::from_u32(code) * self.cell) {
                // The storage may well be up there, and full without showing.
                self.lose_store(state);
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
        // What is shunted does not show: an interval tells of the gain only if the storage was not full at
        // either end, and what was expected may then lie any distance above what is read.
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
        // What is left: all of it for pure noise, `spread` of it without noise.
        let left = (noise_variance + state.energy_variance * spread) / variance;
        let learnt = state.covariance * state.covariance * (S::ONE - spread) / variance;
        let least = S::from_f64(LEAST_DEVIATION) * state.gain;
        state.gain_variance = (state.gain_variance - learnt).max(least * least);
        state.covariance *= left;
        state.energy_variance = (state.energy_variance * left).max(self.least_energy_variance());
        // The variances are those of something.
        let bound = (state.gain_variance * state.energy_variance).sqrt();
        state.covariance = state.covariance.min(bound).max(-bound);
        state.rejected_in_turn = 0;
        state.used = state.used.saturating_add(1);
        Reading::Used
    }

    /// The load was off, or something else took from the storage or gave to it: the next reading tells where it
    /// is, and nothing of the gain, which is kept.
    pub fn lose_store(&self, state: &mut CorrectionState<S>) {
        let capacity = self.storage.capacity();
        state.located = false;
        state.rejected_in_turn = 0;
        state.covariance = S::ZERO;
        state.energy_variance = capacity * capacity;
    }

    /// Where the storage is, by a reading alone.
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

    fn reject(&self, state: &mut CorrectionState<S>) {
        state.rejected = state.rejected.saturating_add(1);
        state.rejected_in_turn += 1;
        if state.rejected_in_turn >= PATIENCE {
            self.forget(state);
        }
    }

    /// The storage is to be located anew, and the gain is as uncertain as at the start.
    fn forget(&self, state: &mut CorrectionState<S>) {
        self.lose_store(state);
        state.gain_variance = state.gain_variance.max(self.gain_variance);
    }

    /// A few roundings of the stored energy.
    fn least_energy_variance(&self) -> S {
        let rounding = S::from_f64(4.0) * S::EPSILON * self.storage.capacity();
        rounding * rounding
    }
}
