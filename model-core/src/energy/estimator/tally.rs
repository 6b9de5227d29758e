//! What the estimator adds up along the steps, and what it says of it.

use crate::clock::Instant;
use crate::hybrid::{Observer, Span};
use crate::image::{Image, ImageError, Reader, Writer};
use crate::integrate::step_control::REMEMBERED_RADIANS;
use crate::scalar::{CompensatedSum, Scalar};
use crate::scene::StoreReading;
use crate::scene::bump_stop::{ModalObserver, ModalSpan};

/// A power is a square: a small error of the state moves it twice as much.
const POWER_PER_STATE: f64 = 2.0;
/// Roundings in the energy of a step: some tens of operations lie between a state and it.
const ENERGY_ROUNDINGS: f64 = 32.0;

/// Delivered energy and the errors made in it, added up over steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tally<S> {
    /// Energy delivered to the load, in joules.
    energy: CompensatedSum<S>,
    /// Magnitudes of the estimated local errors of that, in joules.
    energy_error: CompensatedSum<S>,
    /// Estimated local errors of the state, relative to what it is measured by.
    state_error: CompensatedSum<S>,
    steps: u64,
    ticks: u64,
}

impl<S: Scalar> Tally<S> {
    /// Nothing yet.
    pub(super) const EMPTY: Self = Self {
        energy: CompensatedSum::ZERO,
        energy_error: CompensatedSum::ZERO,
        state_error: CompensatedSum::ZERO,
        steps: 0,
        ticks: 0,
    };

    #[inline(always)]
    fn add(&mut self, energy: S, ticks: u32) {
        self.energy.add(energy);
        self.steps = self.steps.wrapping_add(1);
        self.ticks = self.ticks.wrapping_add(u64::from(ticks));
    }

    /// Energy delivered to the load, in joules.
    pub(super) fn energy(&self) -> S {
        self.energy.value()
    }

    /// Integrated time in seconds.
    pub(super) fn seconds(&self) -> S {
        Instant::from_ticks(self.ticks).seconds()
    }

    /// Energy in joules by which an error of the state of `error` for each of its `count` parts, made all along
    /// the run, moves the delivered energy: each is remembered for some radians of the motion.
    fn moved_by_state(&self, error: S, angular_frequency: S) -> S {
        let radians = (angular_frequency * self.seconds()).larger(S::TINY);
        let remembered = S::literal(REMEMBERED_RADIANS).smaller(radians);
        S::literal(POWER_PER_STATE) * self.energy().absolute() * error * (remembered / radians)
    }

    /// Error of the energy by the method's own estimate, in joules.
    pub(super) fn step_error(&self, angular_frequency: S) -> S {
        self.energy_error.value() + self.moved_by_state(self.state_error.value(), angular_frequency)
    }

    /// Error of the energy by rounding, in joules.
    pub(super) fn rounding(&self, angular_frequency: S) -> S {
        let (upper, lower) = ((self.steps >> 32) as u32, self.steps as u32);
        let steps = S::from_u32(upper) * S::power_of_two(32) + S::from_u32(lower);
        let summed = S::literal(ENERGY_ROUNDINGS + 2.0) * self.energy().absolute();
        S::EPSILON * (summed + self.moved_by_state(steps, angular_frequency))
    }
}

impl<S: Scalar, Mode, const N: usize, const P: usize> Observer<S, Mode, N, P> for Tally<S> {
    #[inline(always)]
    fn step(&mut self, span: &Span<'_, S, Mode, N, P>) {
        self.add(span.energies.first().copied().unwrap_or(S::ZERO), span.ticks);
        self.energy_error.add(span.energy_error.absolute());
        self.state_error.add(span.state_error);
    }
}

impl<S: Scalar, const B: usize, const R: usize> ModalObserver<S, B, R> for Tally<S> {
    #[inline(always)]
    fn step(&mut self, span: &ModalSpan<'_, S, B, R>) {
        self.add(span.delivered, span.ticks);
    }
}

impl<S: Scalar> Image for Tally<S> {
    const BYTES: usize = 3 * CompensatedSum::<S>::BYTES + 2 * u64::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.energy.write(out);
        self.energy_error.write(out);
        self.state_error.write(out);
        self.steps.write(out);
        self.ticks.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, ImageError> {
        Ok(Self {
            energy: Image::read(from)?,
            energy_error: Image::read(from)?,
            state_error: Image::read(from)?,
            steps: Image::read(from)?,
            ticks: Image::read(from)?,
        })
    }
}

/// What is known of the harvest so far.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimate<S> {
    /// Energy delivered to the load over the integrated time, in joules. Of unknown time it holds nothing.
    pub energy: S,
    /// Mean power over the integrated time, in watts; 0 before any.
    pub mean_power: S,
    /// Integrated time in seconds.
    pub seconds: S,
    /// The store as it is now; `None` for a harvester without one.
    pub store: Option<StoreReading<S>>,
    /// How far this can be trusted.
    pub uncertainty: Uncertainty<S>,
}

/// How far an [`Estimate`] can be trusted: as a model's numbers. How well the model is that of the harvester
/// it does not know.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Uncertainty<S> {
    /// Error of the energy in joules by the finite step, as the method estimates it; `None` for a method
    /// without an estimate (RK4, the modal steps of bump-stop): choose its step on the host.
    pub step: Option<S>,
    /// Error of the energy in joules by rounding.
    pub rounding: S,
    /// Samples that were lost.
    pub missing_samples: u32,
    /// Samples at the end of the sensor's range.
    pub saturated_samples: u32,
    /// Part of the integrated time, in seconds, of which the acceleration is interpolated across lost samples or
    /// cut off at the sensor's range, or in which the harvester is still settling after a start at rest.
    pub uncertain_seconds: S,
    /// Time in seconds that was not integrated.
    pub unknown_seconds: S,
    /// All of it, relative: the errors by step and rounding over the energy, and the uncertain and unknown
    /// seconds over all seconds, as if nothing at all were known of the power in them.
    pub relative: S,
}
