//! Shooting for the triboelectric scenes, bare and behind a bridge into a bus of constant voltage.

use std::marker::PhantomData;

use model_core::hybrid::{Automaton, HybridState};
use model_core::integrate::{
    AnyStepControl, ExponentialRadau, Method as Integrator, Point, RungeKutta4, TrBdf2,
};
use model_core::observer::ALL_POWERS;
use model_core::part::storage::AnyStorage;
use model_core::scalar::Mathematics;
use model_core::scene::rectified::{self, Rectified};
use model_core::scene::{Scene as CoreScene, Simulation};

use super::super::excitation::Setting;
use super::super::report::Report;
use super::super::triboelectric::{Prepared, STATES, Simulated, Triboelectric, behind_bridge, prepared};
use super::{Kind, Memory, follow, remembered, steady};
use crate::steady_state::{Coordinates, Orbit, Response, Spent};
use harvester_scene::method::{Failure, Method};
use harvester_scene::outcome::Outcome;

impl<A, I, const N: usize> Coordinates for Simulation<A, I, AnyStepControl<f64>, N, ALL_POWERS>
where
    A: CoreScene<f64, N, ALL_POWERS>,
    I: Integrator<f64>,
{
    const PARTS: u32 = 1;

    fn coordinates(&self, state: &Self::State) -> Vec<f64> {
        state.point.state.to_vec()
    }

    fn at(&self, pattern: &Self::State, coordinates: &[f64], acceleration: f64) -> Option<Self::State> {
        let vector = coordinates.try_into().ok()?;
        let mut state = *pattern;
        state.point = Point::at(&self.scene().flow(pattern.mode), vector, acceleration);
        Some(state)
    }

    fn is_like(&self, one: &Self::State, other: &Self::State) -> bool {
        one.mode == other.mode
    }
}

/// The orbit of a scene of the core with `N` states.
type OrbitOf<A, const N: usize> =
    Orbit<HybridState<f64, <A as Automaton<f64, N, ALL_POWERS>>::Mode, N, ALL_POWERS>>;

/// The scene of the core of a model.
type CoreOf<M, T> = <T as Triboelectric>::Core<f64, M>;

/// The same behind a bridge.
type RectifiedOf<M, T> = Rectified<f64, CoreOf<M, T>, AnyStorage<f64>>;

/// A triboelectric scene with a resistor.
pub(super) struct Bare<'a, M: Mathematics<f64>, T: Triboelectric> {
    model: &'a T,
    known: Option<OrbitOf<CoreOf<M, T>, STATES>>,
    functions: PhantomData<M>,
}

impl<'a, M: Mathematics<f64>, T: Triboelectric> Bare<'a, M, T> {
    pub(super) fn new(model: &'a T) -> Self {
        Self { model, known: None, functions: PhantomData }
    }
}

impl<M: Mathematics<f64>, T: Triboelectric> Kind for Bare<'_, M, T>
where
    <CoreOf<M, T> as Automaton<f64, STATES, ALL_POWERS>>::Mode: 'static,
{
    fn steady(&self, setting: Setting<'_, f64>) -> Result<Outcome, Failure> {
        let prepared = prepared::<f64, M, T>(setting, self.model)?;
        prepared.steady(&self.model.start(), &self.model.typical(&prepared.core))
    }

    fn resume(
        &self,
        setting: Setting<'_, f64>,
        memory: Option<&Memory>,
        only: bool,
    ) -> Result<Option<(Outcome, Memory)>, Failure> {
        let prepared = prepared::<f64, M, T>(setting, self.model)?;
        prepared.remembered(&self.model.start(), &self.model.typical(&prepared.core), memory, only)
    }

    fn follow(&mut self, setting: Setting<'_, f64>, spent: &mut Spent) -> Result<Option<Response>, Failure> {
        let prepared = prepared::<f64, M, T>(setting, self.model)?;
        let typical = self.model.typical(&prepared.core);
        prepared.follow(&self.model.start(), &typical, &mut self.known, spent)
    }
}

/// A triboelectric scene behind a bridge.
pub(super) struct Bridged<'a, M: Mathematics<f64>, T: Triboelectric> {
    model: &'a T,
    known: Option<OrbitOf<RectifiedOf<M, T>, { rectified::STATES }>>,
    functions: PhantomData<M>,
}

impl<'a, M: Mathematics<f64>, T: Triboelectric> Bridged<'a, M, T> {
    pub(super) fn new(model: &'a T) -> Self {
        Self { model, known: None, functions: PhantomData }
    }

    fn typical(&self, core: &RectifiedOf<M, T>) -> [f64; rectified::STATES] {
        let [position, velocity, charge] = self.model.typical(core.harvester());
        // The voltage of a bus does not change.
        [position, velocity, charge, 1.0]
    }
}

impl<M: Mathematics<f64>, T: Triboelectric> Kind for Bridged<'_, M, T>
where
    <CoreOf<M, T> as Automaton<f64, STATES, 0>>::Mode: 'static,
{
    fn steady(&self, setting: Setting<'_, f64>) -> Result<Outcome, Failure> {
        let prepared = behind_bridge::<f64, M, T>(setting, self.model)?;
        prepared.steady(&self.model.start(), &self.typical(&prepared.core))
    }

    fn resume(
        &self,
        setting: Setting<'_, f64>,
        memory: Option<&Memory>,
        only: bool,
    ) -> Result<Option<(Outcome, Memory)>, Failure> {
        let prepared = behind_bridge::<f64, M, T>(setting, self.model)?;
        prepared.remembered(&self.model.start(), &self.typical(&prepared.core), memory, only)
    }

    fn follow(&mut self, setting: Setting<'_, f64>, spent: &mut Spent) -> Result<Option<Response>, Failure> {
        let prepared = behind_bridge::<f64, M, T>(setting, self.model)?;
        let typical = self.typical(&prepared.core);
        prepared.follow(&self.model.start(), &typical, &mut self.known, spent)
    }
}

impl<A: Copy, T: Triboelectric> Prepared<'_, f64, A, T> {
    fn steady<const N: usize>(&self, start: &A::Start, typical: &[f64; N]) -> Result<Outcome, Failure>
    where
        A: CoreScene<f64, N, ALL_POWERS>,
    {
        match self.setting.options.method {
            Method::Rk4 => self.steady_by(RungeKutta4, start, typical),
            Method::TrBdf2 => self.steady_by(TrBdf2, start, typical),
            _ => self.steady_by(ExponentialRadau, start, typical),
        }
    }

    fn steady_by<I: Integrator<f64>, const N: usize>(
        &self,
        method: I,
        start: &A::Start,
        typical: &[f64; N],
    ) -> Result<Outcome, Failure>
    where
        A: CoreScene<f64, N, ALL_POWERS>,
        T: Report<f64, Simulated<f64, A, I, N>>,
    {
        let simulation = self.simulation(method);
        let state = self.start(&simulation, start)?;
        steady(&self.run(&simulation), state, typical)
    }

    fn remembered<const N: usize>(
        &self,
        start: &A::Start,
        typical: &[f64; N],
        memory: Option<&Memory>,
        only: bool,
    ) -> Result<Option<(Outcome, Memory)>, Failure>
    where
        A: CoreScene<f64, N, ALL_POWERS>,
        HybridState<f64, <A as Automaton<f64, N, ALL_POWERS>>::Mode, N, ALL_POWERS>: Send + Sync + 'static,
    {
        match self.setting.options.method {
            Method::Rk4 => self.remembered_by(RungeKutta4, start, typical, memory, only),
            Method::TrBdf2 => self.remembered_by(TrBdf2, start, typical, memory, only),
            _ => self.remembered_by(ExponentialRadau, start, typical, memory, only),
        }
    }

    fn remembered_by<I: Integrator<f64>, const N: usize>(
        &self,
        method: I,
        start: &A::Start,
        typical: &[f64; N],
        memory: Option<&Memory>,
        only: bool,
    ) -> Result<Option<(Outcome, Memory)>, Failure>
    where
        A: CoreScene<f64, N, ALL_POWERS>,
        HybridState<f64, <A as Automaton<f64, N, ALL_POWERS>>::Mode, N, ALL_POWERS>: Send + Sync + 'static,
    {
        let simulation = self.simulation(method);
        let state = self.start(&simulation, start)?;
        remembered(&self.run(&simulation), state, typical, memory, only)
    }

    fn follow<const N: usize>(
        &self,
        start: &A::Start,
        typical: &[f64; N],
        known: &mut Option<OrbitOf<A, N>>,
        spent: &mut Spent,
    ) -> Result<Option<Response>, Failure>
    where
        A: CoreScene<f64, N, ALL_POWERS>,
    {
        match self.setting.options.method {
            Method::Rk4 => self.follow_by(RungeKutta4, start, typical, known, spent),
            Method::TrBdf2 => self.follow_by(TrBdf2, start, typical, known, spent),
            _ => self.follow_by(ExponentialRadau, start, typical, known, spent),
        }
    }

    fn follow_by<I: Integrator<f64>, const N: usize>(
        &self,
        method: I,
        start: &A::Start,
        typical: &[f64; N],
        known: &mut Option<OrbitOf<A, N>>,
        spent: &mut Spent,
    ) -> Result<Option<Response>, Failure>
    where
        A: CoreScene<f64, N, ALL_POWERS>,
    {
        let simulation = self.simulation(method);
        let state = self.start(&simulation, start)?;
        follow(&self.run(&simulation), state, typical, known, spent)
    }
}
