//! Harvesters that can be advanced from sample to sample.

use core::fmt::Debug;

use super::accumulator::EnergyAccumulator;
use crate::clock::Instant;
use crate::excitation::{Excitation, Stream};
use crate::hybrid::{Advance, Driver, HybridState, StepError};
use crate::integrate::step_control::ErrorScale;
use crate::integrate::{Method, StepControl};
use crate::scalar::Scalar;
use crate::scene::bump_stop::{self, Stepper};
use crate::scene::{ParameterError, Resumable, StorageReading};
use crate::snapshot::{Fingerprint, Snapshot};

/// A harvester with a way to step it, as the [`super::Estimator`] needs it.
pub trait Model<S: Scalar> {
    /// What changes.
    type State: Copy + Debug + PartialEq + Snapshot;

    /// Whether the steps come with an estimate of their error.
    const ESTIMATES_ERROR: bool;
    /// Attempted steps that [`Model::advance`] takes as the smallest budget.
    const LEAST_BUDGET: u32;

    /// The state at rest at [`Stream::known_until`], under the acceleration there. What a storage held in
    /// `before` it still holds.
    ///
    /// # Errors
    /// If the harvester cannot start at rest.
    fn at_rest(
        &self,
        before: Option<&Self::State>,
        stream: &Stream<S>,
    ) -> Result<Self::State, ParameterError<S>>;

    /// Advances `state` to [`Stream::known_until`], or less than a sample beyond it, in at most `budget`
    /// attempted steps.
    ///
    /// # Errors
    /// [`StepError`]; the state is then the last good one.
    fn advance(
        &self,
        state: &mut Self::State,
        stream: &Stream<S>,
        budget: u32,
        accumulator: &mut EnergyAccumulator<S>,
    ) -> Result<Advance, StepError<S>>;

    /// Angular frequency of the slow motion in rad/s.
    fn angular_frequency(&self) -> S;

    /// Takes in all that decides how a run goes on from a state.
    fn identify(&self, fingerprint: &mut Fingerprint);

    /// The storage at `state`; `None` without one.
    fn storage(&self, _state: &Self::State) -> Option<StorageReading<S>> {
        None
    }

    /// Puts the storage to a voltage in volts; without one nothing changes.
    fn set_storage_voltage(&self, _state: &mut Self::State, _stream: &Stream<S>, _volts: S) {}
}

/// An acceleration that does not change: that of the sample at which a run starts.
#[derive(Debug, Clone, Copy)]
struct Level<S>(S);

impl<S: Scalar> Level<S> {
    fn at_start(stream: &Stream<S>) -> Self {
        Self(stream.acceleration(stream.known_until()))
    }
}

impl<S: Scalar> Excitation<S> for Level<S> {
    fn acceleration(&self, _at: Instant) -> S {
        self.0
    }

    fn jerk(&self, _at: Instant) -> S {
        S::ZERO
    }
}

/// A hybrid harvester of `N` states with `P` powers, with a method and a step control.
///
/// `P = 1` is what a node needs: the power in the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HybridModel<H, M, C, const N: usize, const P: usize> {
    scene: H,
    driver: Driver<M, C>,
}

impl<H, M, C, const N: usize, const P: usize> HybridModel<H, M, C, N, P> {
    /// `scene` stepped by `method` under `control`.
    #[must_use]
    pub const fn new(scene: H, method: M, control: C) -> Self {
        Self { scene, driver: Driver::new(method, control) }
    }

    /// The harvester.
    #[must_use]
    pub const fn scene(&self) -> &H {
        &self.scene
    }
}

impl<S, H, M, C, const N: usize, const P: usize> Model<S> for HybridModel<H, M, C, N, P>
where
    S: Scalar,
    H: Resumable<S, N, P>,
    M: Method<S>,
    C: StepControl<S>,
{
    type State = HybridState<S, H::Mode, N, P>;

    const ESTIMATES_ERROR: bool = M::ESTIMATES_ERROR;
    const LEAST_BUDGET: u32 = crate::hybrid::LEAST_BUDGET;

    fn at_rest(
        &self,
        before: Option<&Self::State>,
        stream: &Stream<S>,
    ) -> Result<Self::State, ParameterError<S>> {
        let mut state = self.scene.at_rest(before, &Level::at_start(stream), &self.driver.control)?;
        state.clock = stream.known_until();
        Ok(state)
    }

    #[inline]
    fn advance(
        &self,
        state: &mut Self::State,
        stream: &Stream<S>,
        budget: u32,
        accumulator: &mut EnergyAccumulator<S>,
    ) -> Result<Advance, StepError<S>> {
        self.driver.advance(&self.scene, state, stream, stream.known_until(), budget, accumulator)
    }

    fn angular_frequency(&self) -> S {
        self.scene.error_scale().angular_frequency
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        self.scene.identify(fingerprint);
        fingerprint.count(P as u32);
        // Method and step control, by what they do: a state resumes with the same bits under the same only.
        fingerprint.count(u32::from(M::ESTIMATES_ERROR));
        // A motion so fast that no tolerance is below its roundings.
        let scale = ErrorScale { angular_frequency: S::from_f64(1e6), energy_floor: S::ONE };
        let control = &self.driver.control;
        fingerprint.count(control.start(&scale).ticks);
        fingerprint.numbers(&[control.accuracy(u32::MAX, &scale)]);
    }

    fn storage(&self, state: &Self::State) -> Option<StorageReading<S>> {
        self.scene.storage(state)
    }

    fn set_storage_voltage(&self, state: &mut Self::State, stream: &Stream<S>, volts: S) {
        self.scene.set_storage_voltage(state, volts, stream.acceleration(state.clock));
    }
}

/// Whole steps, the last up to a short step beyond a sample; where a short step is not shorter than a sample,
/// the steps are cut at the samples.
impl<S, P, const B: usize, const R: usize> Model<S> for Stepper<S, P, B, R>
where
    S: Scalar,
    P: bump_stop::Parts<S>,
{
    type State = bump_stop::StateOf<S, P, B, R>;

    const ESTIMATES_ERROR: bool = false;
    const LEAST_BUDGET: u32 = bump_stop::LEAST_BUDGET;

    fn at_rest(
        &self,
        before: Option<&Self::State>,
        stream: &Stream<S>,
    ) -> Result<Self::State, ParameterError<S>> {
        let mut state = self.scene().start(&bump_stop::Start::default(), &Level::at_start(stream))?;
        state.clock = stream.known_until();
        if let Some(before) = before {
            state.circuit = before.circuit;
        }
        Ok(state)
    }

    #[inline]
    fn advance(
        &self,
        state: &mut Self::State,
        stream: &Stream<S>,
        budget: u32,
        accumulator: &mut EnergyAccumulator<S>,
    ) -> Result<Advance, StepError<S>> {
        let until = stream.known_until();
        if u64::from(self.short_ticks()) < stream.ticks_per_sample() {
            self.advance_beyond(state, stream, until, budget, accumulator)
        } else {
            self.advance(state, stream, until, budget, accumulator)
        }
    }

    fn angular_frequency(&self) -> S {
        self.scene().beam_angular_frequency(0).unwrap_or(S::ONE)
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        Stepper::identify(self, fingerprint);
    }

    fn storage(&self, state: &Self::State) -> Option<StorageReading<S>> {
        self.scene().reading(state)
    }

    fn set_storage_voltage(&self, state: &mut Self::State, _stream: &Stream<S>, volts: S) {
        self.scene().set_storage_voltage(state, volts);
    }
}
