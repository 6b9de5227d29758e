//! Estimates the harvested energy from the samples of an accelerometer, with its uncertainty.
//!
//! ```
//! use model_core::energy::Estimator;
//! use model_core::energy::estimator::{Interpolation, SampleFormat, Settings};
//! use model_core::integrate::{Adaptive, ExponentialRadau};
//! use model_core::scene::Simulation;
//! # use model_core::part::load::Resistor;
//! # use model_core::part::restitution::ConstantRestitution;
//! # use model_core::scene::contact_separation::{Choices, Parameters};
//! # fn fifo(n: u32) -> i16 { (8192.0 + 3277.0 * (core::f64::consts::TAU * f64::from(n) / 20.0).sin()) as i16 }
//!
//! # fn main() -> Result<(), model_core::Error> {
//! # let parameters = Parameters {
//! #     mass: 5e-3_f32,
//! #     stiffness: 80.0,
//! #     damping_ratio: 0.005,
//! #     initial_gap: 3e-3,
//! #     electrode_area: 4e-4,
//! #     dielectric_thickness: 5e-5,
//! #     relative_permittivity: 2.0,
//! #     charge_density: 50e-6,
//! #     choices: Choices::new(Resistor { resistance: 1e8 }, ConstantRestitution { coefficient: 0.75 }),
//! # };
//! let harvester = Simulation::new(parameters.build()?, ExponentialRadau, Adaptive::new(2e-2)?);
//! let settings = Settings {
//!     rate: 400.0,                                           // samples per second
//!     format: SampleFormat::counts(9.81 / 16_384.0, 32_767), // ± 2 g in 16 bits
//!     longest_gap: 4,                                        // lost samples to interpolate
//!     settling_seconds: 3.0,                                 // two decay times
//!     rate_tolerance: 0.05,                                  // by the data sheet
//!     jitter: 0.0,                                           // the sensor has its own clock
//!     interpolation: Interpolation::DroopCompensated,
//!     bias_seconds: Some(2.0),                               // gravity on the axis is removed
//! };
//! let mut estimator = Estimator::new(harvester, settings)?;
//! estimator.set_rate(400.0, 2e-4)?; // as measured against the clock of the node
//!
//! for n in 0..4000 {
//!     // At most 100 attempted steps per call.
//!     let mut progress = estimator.push_count(fifo(n), 100)?;
//!     while !progress.finished {
//!         progress = estimator.resume(100)?;
//!     }
//! }
//! let estimate = estimator.estimate();
//! assert!((5e-6..20e-6).contains(&estimate.mean_power)); // W
//! assert!(estimate.uncertainty.relative.is_some_and(|relative| relative < 1.0));
//! assert!(estimate.bias.is_some_and(|bias| (bias - 4.9).abs() < 0.5)); // m/s², half of gravity
//!
//! // Power down and wake up after three lost samples.
//! let mut flash = [0; 400];
//! estimator.save(&mut flash)?;
//! let mut awake = Estimator::new(harvester, settings)?;
//! awake.restore(&flash)?;
//! assert_eq!(awake, estimator);
//! awake.push_missing(3, 100)?;
//! # Ok(())
//! # }
//! ```
//!
//! # Missing samples
//!
//! Up to [`Settings::longest_gap`] successive lost samples are interpolated linearly between their neighbours when the next
//! sample arrives. After a longer gap the state of the harvester is unknown: the time between the samples on either side
//! counts as *unknown* and is not integrated, and the harvester restarts at rest with the first sample after the gap; a
//! storage keeps its energy. A failed step of the model has the same consequence, and is reported as an error once.
//!
//! A sample at the end of the sensor's range is replaced by that end, a lower bound. Intervals adjacent to a
//! lost or a saturated sample count as *uncertain*, and so do those within [`Settings::settling_seconds`] of
//! a start, the first one included. After a gap these are three decay times of the harvester at least.
//!
//! # Sampling
//!
//! The acceleration between samples is linear, which makes a sine weaker ([`Interpolation`]).
//! [`Interpolation::DroopCompensated`] corrects that. Below four samples in a resonance period the uncertainty is unknown.
//! [`Estimator::set_rate`] sets the measured rate of a sensor: with a tolerance of 5 % the power is known to a factor of some
//! hundred; [`Settings::bias_seconds`] removes gravity and a slow bias; without it gravity counts as acceleration.
//!
//! [`Uncertainty`] states the contents and the accuracy of the uncertainty figures.

mod accumulator;
mod gaps;
mod origin;
mod response;
mod sample;
mod sampling;
mod state;
mod uncertainty;

use crate::bounds::{Bounds, ParameterError, bounded};
use crate::clock::Instant;
use crate::excitation::{Excitation, Stream};
use crate::hybrid::{Ended, StepError, Work};
use crate::scalar::Scalar;
use crate::scene::Harvester;
use crate::snapshot::{self, Configuration, Fingerprint, SnapshotError};

pub use accumulator::EnergyAccumulator;
use origin::out_of_bounds;
pub use sample::{Sample, SampleFormat};
use sampling::Droop;
pub use sampling::Interpolation;
pub use state::State;
pub use uncertainty::{Estimate, Uncertainty};

/// The samples and the treatment of missing samples.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings<S> {
    /// Samples per second, 10⁻³ to 10⁶.
    pub rate: S,
    /// The conversion of counts or values to accelerations.
    pub format: SampleFormat<S>,
    /// Largest number of successive lost samples that are interpolated: short against a period of the motion.
    pub longest_gap: u16,
    /// Time in s in which the harvester settles after a start from rest that may differ from its true state,
    /// 0 to 10⁶: some decay times `1/(damping ratio · angular frequency)`. 0 if a node starts at rest. After a gap it
    /// is three decay times at least.
    pub settling_seconds: S,
    /// Largest error of [`Settings::rate`], relative, 0 to 1: by the data sheet of the sensor, 0.05 is usual.
    /// [`Estimator::set_rate`] replaces it.
    pub rate_tolerance: S,
    /// Standard deviation of the instants of the samples from regular ones, as a part of the interval, 0 to 1: 0 for a
    /// sensor that samples by its own clock, more where software starts each conversion.
    pub jitter: S,
    /// The acceleration between the samples.
    pub interpolation: Interpolation,
    /// Time constant in s of a high-pass that removes gravity and a slow bias from the samples, 10⁻² to 10⁶: some tens
    /// of periods, because a sine of angular frequency `w` loses `1/(2 (w · time)²)` of its amplitude. `None` to
    /// remove nothing: only for samples whose mean is 0. With gravity on the axis the estimate is then several times off, and its
    /// uncertainty does not show it.
    pub bias_seconds: Option<S>,
}

bounded! { Settings<S>:
    "rate" = rate: RATE.lowest, RATE.highest;
    "settling_seconds" = settling_seconds: 0.0, 1e6;
    "rate_tolerance" = rate_tolerance: 0.0, 1.0;
    "jitter" = jitter: 0.0, 1.0;
    "bias_seconds" = bias_seconds: 1e-2, 1e6;
}

/// Allowed sampling rates in Hz.
const RATE: Bounds<f64> = Bounds { lowest: 1e-3, highest: 1e6 };

/// The reason why a call failed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EstimatorError<S> {
    /// A setting is outside its bounds, or the harvester cannot start at rest.
    Parameter(ParameterError<S>),
    /// A step failed. The time up to the next sample is unknown, and the harvester restarts with that sample:
    /// continue with further samples.
    Step(StepError<S>),
    /// The previous sample is not finished: call [`Estimator::resume`]. This sample was not taken.
    Unfinished,
    /// A sequence number before the expected one: a repeated sample, or one out of order. It was not taken.
    OutOfOrder {
        /// The number expected.
        expected: u32,
        /// The number given.
        given: u32,
    },
}

impl<S: Scalar> core::fmt::Display for EstimatorError<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Parameter(error) => error.fmt(f),
            Self::Step(error) => error.fmt(f),
            Self::Unfinished => write!(f, "the sample before is not finished"),
            Self::OutOfOrder { expected, given } => {
                write!(f, "sample {given} is out of order: sample {expected} was expected")
            }
        }
    }
}

impl<S: Scalar> core::error::Error for EstimatorError<S> {}

/// The result of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use = "an unfinished sample needs `Estimator::resume`"]
#[non_exhaustive]
pub struct Progress {
    /// Whether the sample is finished; if not, the budget is spent and [`Estimator::resume`] continues.
    pub finished: bool,
    /// The work done.
    pub work: Work,
}

/// Simulates a harvester from the samples of an accelerometer.
///
/// Each sample completes the interval that ends one sample *earlier* (see [`Stream`]): the estimate lags one
/// sample behind. The clock of the harvester restarts at zero before it ends ([`Estimator::known_until`]), so that an
/// estimator runs without end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimator<S: Scalar, H: Harvester<S>> {
    harvester: H,
    settings: Settings<S>,
    /// Follows from the harvester and the rate of the stream.
    droop: Droop<S>,
    state: State<S, H::State>,
}

impl<S: Scalar, H: Harvester<S>> Estimator<S, H> {
    /// Size in bytes of the snapshot of [`Estimator::save`].
    pub const SNAPSHOT_BYTES: usize = snapshot::size_of::<State<S, H::State>>();

    /// An estimator before its first sample.
    ///
    /// # Errors
    /// [`EstimatorError::Parameter`] with the setting outside its bounds.
    pub fn new(harvester: H, settings: Settings<S>) -> Result<Self, EstimatorError<S>> {
        let Settings { rate, format, rate_tolerance, .. } = settings;
        settings.check_numbers().and_then(|()| format.check()).map_err(EstimatorError::Parameter)?;
        let stream =
            Stream::new(rate, S::ZERO).map_err(|_| EstimatorError::Parameter(out_of_bounds(rate)))?;
        let rested =
            harvester.restart(None, &stream, stream.known_until()).map_err(EstimatorError::Parameter)?;
        let droop = Droop::new(harvester.angular_frequency(), rate);
        Ok(Self { harvester, settings, droop, state: State::waiting(stream, rate_tolerance, rested) })
    }

    /// The state of the model, one sample behind.
    #[must_use]
    pub fn harvester_state(&self) -> &H::State {
        &self.state.harvester
    }

    /// The instant up to which the samples so far are integrated, once they are finished, on the clock of
    /// [`Estimator::harvester_state`]. That clock begins at the first sample, and again at zero with
    /// [`Estimator::set_rate`] and half a year after its last beginning.
    #[must_use]
    pub fn known_until(&self) -> Instant {
        self.state.stream.known_until()
    }

    /// Takes the next sample as a raw count, in at most `budget` attempted steps.
    ///
    /// # Errors
    /// As [`Estimator::push`].
    #[inline]
    pub fn push_count(&mut self, count: i16, budget: u32) -> Result<Progress, EstimatorError<S>> {
        self.push(self.settings.format.of_count(count), budget)
    }

    /// Takes the next sample in m/s², in at most `budget` attempted steps. A sample that is not finite, or above
    /// 10⁶ m/s² in magnitude, is missing.
    ///
    /// # Errors
    /// As [`Estimator::push`].
    #[inline]
    pub fn push_acceleration(&mut self, acceleration: S, budget: u32) -> Result<Progress, EstimatorError<S>> {
        self.push(self.settings.format.of_acceleration(acceleration), budget)
    }

    /// Takes `count` lost samples, in at most `budget` attempted steps.
    ///
    /// # Errors
    /// As [`Estimator::push`].
    pub fn push_missing(&mut self, count: u32, budget: u32) -> Result<Progress, EstimatorError<S>> {
        self.refuse_unfinished()?;
        self.state.expected = self.state.expected.map(|expected| expected.wrapping_add(count));
        self.lose(count);
        self.resume(budget)
    }

    /// Takes the sample with number `sequence`, which may wrap; the samples skipped since the previous number
    /// were lost. Counting starts at the first number given.
    ///
    /// # Errors
    /// As [`Estimator::push`], and [`EstimatorError::OutOfOrder`].
    pub fn push_at(
        &mut self,
        sequence: u32,
        sample: Sample<S>,
        budget: u32,
    ) -> Result<Progress, EstimatorError<S>> {
        self.refuse_unfinished()?;
        let expected = self.state.expected.unwrap_or(sequence);
        let lost = sequence.wrapping_sub(expected);
        if lost >= 1 << 31 {
            return Err(EstimatorError::OutOfOrder { expected, given: sequence });
        }
        self.lose(lost);
        self.state.expected = Some(sequence.wrapping_add(1));
        self.take(sample);
        self.resume(budget)
    }

    /// Takes the next sample, in at most `budget` attempted steps.
    ///
    /// A budget below [`Harvester::LEAST_BUDGET`] is raised to that number. The bits of the result do not
    /// depend on the budgets.
    ///
    /// # Errors
    /// [`EstimatorError::Unfinished`]: the sample is not taken. [`EstimatorError::Step`] and
    /// [`EstimatorError::Parameter`]: the state of the harvester is unknown until the next sample.
    pub fn push(&mut self, sample: Sample<S>, budget: u32) -> Result<Progress, EstimatorError<S>> {
        self.refuse_unfinished()?;
        self.state.expected = self.state.expected.map(|expected| expected.wrapping_add(1));
        self.take(sample);
        self.resume(budget)
    }

    /// Continues an unfinished sample, in at most `budget` attempted steps.
    ///
    /// # Errors
    /// As [`Estimator::push`].
    #[inline(never)]
    pub fn resume(&mut self, budget: u32) -> Result<Progress, EstimatorError<S>> {
        let mut work = Work::default();
        loop {
            while self.state.pending {
                let left = budget.saturating_sub(work.attempts());
                if work.attempts().max(work.events) > 0 && left < H::LEAST_BUDGET {
                    return Ok(Progress { finished: false, work });
                }
                let State { stream, harvester, accumulator, .. } = &mut self.state;
                match self.harvester.advance_past(
                    harvester,
                    stream,
                    stream.known_until(),
                    stream.ticks_per_sample(),
                    left,
                    accumulator,
                ) {
                    Ok(advance) => {
                        work = work.and(advance.work);
                        self.state.pending = advance.ended != Ended::Finished;
                    }
                    Err(error) => {
                        self.lose_harvester();
                        return Err(EstimatorError::Step(error));
                    }
                }
            }
            let Some((sample, uncertain)) = self.state.queue.next() else {
                return Ok(Progress { finished: true, work });
            };
            if self.state.queue.restarts {
                self.restart(sample, uncertain)?;
            } else {
                self.feed(sample, uncertain);
            }
        }
    }

    /// Sets the storage to a voltage in V, measured or after a draw by the node. Call it between samples.
    /// Without effect on a harvester without a storage, and for a voltage that is negative or not finite.
    pub fn set_storage_voltage(&mut self, voltage: S) {
        if voltage >= S::ZERO && voltage.is_finite() {
            let State { stream, harvester, .. } = &mut self.state;
            let acceleration = stream.acceleration(self.harvester.clock(harvester));
            self.harvester.set_storage_voltage(harvester, voltage, acceleration);
        }
    }

    /// Sets energy, time and all counts to zero, to begin a new mean; the harvester continues.
    pub fn clear(&mut self) {
        let state = &mut self.state;
        state.accumulator = EnergyAccumulator::default();
        state.response.clear(state.settling > 0);
        (state.missing_samples, state.saturated_samples) = (0, 0);
        (state.uncertain_time, state.unknown_time) = Default::default();
    }

    /// Writes the state as a snapshot to the front of `bytes`, also in the middle of a sample. Returns its
    /// size, [`Estimator::SNAPSHOT_BYTES`].
    ///
    /// # Errors
    /// [`SnapshotError::NoRoom`] with both sizes.
    pub fn save(&self, bytes: &mut [u8]) -> Result<usize, SnapshotError> {
        snapshot::save(&self.state, self.fingerprint(), bytes)
    }

    /// Restores the state from a snapshot at the front of `bytes`: the run then continues with the same bits.
    ///
    /// # Errors
    /// [`SnapshotError`]; the state is then unchanged.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SnapshotError> {
        self.set_state(snapshot::restore(self.fingerprint(), bytes)?);
        Ok(())
    }

    /// The state, to be saved in one image with the other states of a node ([`snapshot::save_image`]).
    #[must_use]
    pub fn state(&self) -> &State<S, H::State> {
        &self.state
    }

    /// Continues from a state of an estimator with the same harvester and settings.
    pub fn set_state(&mut self, state: State<S, H::State>) {
        self.droop = Droop::new(self.harvester.angular_frequency(), state.stream.rate());
        self.state = state;
    }

    fn fingerprint(&self) -> u32 {
        let mut fingerprint = Fingerprint::new();
        self.identify(&mut fingerprint);
        fingerprint.value()
    }

    fn refuse_unfinished(&self) -> Result<(), EstimatorError<S>> {
        let unfinished = self.state.pending || self.state.queue.left > 0;
        if unfinished { Err(EstimatorError::Unfinished) } else { Ok(()) }
    }
}
