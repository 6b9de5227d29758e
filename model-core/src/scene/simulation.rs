//! A scene with its method and step control.

use super::{Harvester, ParameterError, Scene};
use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::hybrid::{Advance, Driver, HybridState, LEAST_BUDGET, StepError};
use crate::integrate::{ErrorScale, Method, StepControl};
use crate::observer::{ALL_POWERS, Observer, Outputs};
use crate::scalar::Scalar;
use crate::snapshot::Fingerprint;

/// A scene of `N` states stepped by the method `M` under the step control `C`, with `P` powers integrated.
///
/// `N` and `P` follow from the scene and the constructor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Simulation<A, M, C, const N: usize, const P: usize> {
    scene: A,
    driver: Driver<M, C>,
}

impl<A, M, C, const N: usize> Simulation<A, M, C, N, 1> {
    /// `scene` stepped by `method` under `control`, integrating only the delivered energy: enough for a node.
    #[must_use]
    pub const fn new(scene: A, method: M, control: C) -> Self {
        Self { scene, driver: Driver::new(method, control) }
    }
}

impl<A, M, C, const N: usize> Simulation<A, M, C, N, ALL_POWERS> {
    /// The same, integrating every [`crate::observer::PowerIndex`], for a report and an energy ledger.
    #[must_use]
    pub const fn with_all_powers(scene: A, method: M, control: C) -> Self {
        Self { scene, driver: Driver::new(method, control) }
    }
}

impl<A, M, C, const N: usize, const P: usize> Simulation<A, M, C, N, P> {
    /// The scene.
    #[must_use]
    pub const fn scene(&self) -> &A {
        &self.scene
    }

    /// The driver: method and step control.
    #[must_use]
    pub const fn driver(&self) -> &Driver<M, C> {
        &self.driver
    }
}

/// A constant base acceleration.
#[derive(Debug, Clone, Copy)]
struct Constant<S>(S);

impl<S: Scalar> Excitation<S> for Constant<S> {
    fn acceleration(&self, _at: Instant) -> S {
        self.0
    }

    fn jerk(&self, _at: Instant) -> S {
        S::ZERO
    }
}

impl<S, A, M, C, const N: usize, const P: usize> Harvester<S> for Simulation<A, M, C, N, P>
where
    S: Scalar,
    A: Scene<S, N, P>,
    M: Method<S>,
    C: StepControl<S>,
{
    type State = HybridState<S, A::Mode, N, P>;
    type Start = A::Start;

    const ESTIMATES_ERROR: bool = M::ESTIMATES_ERROR;
    const ERROR_PER_ESTIMATE: f64 = M::ERROR_PER_ESTIMATE;
    const LEAST_BUDGET: u32 = LEAST_BUDGET;

    fn start<E: Excitation<S>>(
        &self,
        start: &A::Start,
        excitation: &E,
    ) -> Result<Self::State, ParameterError<S>> {
        self.scene.start(start, excitation, &self.driver.control)
    }

    fn restart<E: Excitation<S>>(
        &self,
        before: Option<&Self::State>,
        excitation: &E,
        at: Instant,
    ) -> Result<Self::State, ParameterError<S>> {
        let acceleration = excitation.acceleration(at);
        let mut state =
            self.scene.start(&A::Start::default(), &Constant(acceleration), &self.driver.control)?;
        if let Some(before) = before {
            self.scene.keep_storage(before, &mut state, acceleration);
        }
        state.clock = at;
        Ok(state)
    }

    #[inline]
    fn advance<E: Excitation<S>, O: Observer<S>>(
        &self,
        state: &mut Self::State,
        excitation: &E,
        until: Instant,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>> {
        self.driver.advance(&self.scene, state, excitation, until, budget, observer)
    }

    fn clock(&self, state: &Self::State) -> Instant {
        state.clock
    }

    fn set_clock(&self, state: &mut Self::State, clock: Instant) {
        state.clock = clock;
    }

    fn outputs<'a>(&self, state: &'a Self::State) -> Outputs<'a, S> {
        self.scene.outputs(state.mode, &state.point)
    }

    #[inline]
    fn velocity(&self, state: &Self::State) -> S {
        state.point.state.get(A::VELOCITY).copied().unwrap_or(S::ZERO)
    }

    fn set_storage_voltage(&self, state: &mut Self::State, voltage: S, acceleration: S) {
        self.scene.set_storage_voltage(state, voltage, acceleration);
    }

    fn angular_frequency(&self) -> S {
        self.scene.error_scale().angular_frequency
    }

    fn decay_rate(&self) -> S {
        self.scene.error_scale().decay_rate
    }

    /// The method is identified by its error estimate and the order of it, the step control by its results on test
    /// inputs: the bits of a resumed state depend on both.
    fn identify(&self, fingerprint: &mut Fingerprint) {
        self.scene.identify(fingerprint);
        fingerprint.count(P as u32);
        fingerprint.count(u32::from(M::ESTIMATES_ERROR));
        fingerprint.count(M::ESTIMATE_ORDER.unsigned_abs());
        // At this angular frequency the tolerance exceeds the roundings of a step.
        let scale =
            ErrorScale { angular_frequency: S::from_f64(1e6), decay_rate: S::ZERO, energy_floor: S::ONE };
        let control = &self.driver.control;
        fingerprint.count(control.start(&scale).ticks);
        fingerprint.numbers(&[control.accuracy(u32::MAX, &scale)]);
    }
}
