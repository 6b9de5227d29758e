//! Shooting for the triboelectric scenes, bare and behind a bridge into a bus of constant voltage.

use model_core::hybrid::{Automaton, HybridState};
use model_core::integrate::{AnyStepControl, Method as Integrator, Point};
use model_core::observer::ALL_POWERS;
use model_core::part::storage::AnyStorage;
use model_core::scalar::Mathematics;
use model_core::scene::rectified::Rectified;
use model_core::scene::{Scene as CoreScene, Simulation};

use super::super::excitation::Setting;
use super::super::triboelectric::{Prepared, STATES, Triboelectric, behind_bridge, by_method, prepared};
use super::{Kind, Memory, follow, remembered};
use crate::steady_state::{Coordinates, Orbit, Response, Spent};
use harvester_scene::method::Failure;
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

/// Checks a scene, bare or behind a bridge.
type Prepare<T, A> = for<'s> fn(Setting<'s, f64>, &'s T) -> Result<Prepared<'s, f64, A, T>, Failure>;

/// A triboelectric scene whose harvester of the core is `A`, with `N` states.
struct Triboelectrical<'a, T, A: Automaton<f64, N, ALL_POWERS>, const N: usize> {
    model: &'a T,
    prepare: Prepare<T, A>,
    typical: fn(&T, &A) -> [f64; N],
    known: Option<OrbitOf<A, N>>,
}

/// A scene with a resistor.
pub(super) fn bare<'a, M: Mathematics<f64>, T: Triboelectric>(model: &'a T) -> Box<dyn Kind + 'a>
where
    <T::Core<f64> as Automaton<f64, STATES, ALL_POWERS>>::Mode: 'static,
{
    let typical = |model: &T, core: &T::Core<f64>| model.typical(core);
    Box::new(Triboelectrical { model, prepare: prepared::<f64, M, T>, typical, known: None })
}

pub(super) fn bridged<'a, M: Mathematics<f64>, T: Triboelectric>(model: &'a T) -> Box<dyn Kind + 'a>
where
    <T::Core<f64> as Automaton<f64, STATES, 0>>::Mode: 'static,
{
    let typical = |model: &T, core: &Rectified<f64, T::Core<f64>, AnyStorage<f64>>| {
        let [position, velocity, charge] = model.typical(core.harvester());
        // The voltage of a bus does not change.
        [position, velocity, charge, 1.0]
    };
    Box::new(Triboelectrical { model, prepare: behind_bridge::<f64, M, T>, typical, known: None })
}

impl<T, A, const N: usize> Kind for Triboelectrical<'_, T, A, N>
where
    T: Triboelectric,
    A: CoreScene<f64, N, ALL_POWERS, Start = T::Start<f64>> + Copy,
    HybridState<f64, <A as Automaton<f64, N, ALL_POWERS>>::Mode, N, ALL_POWERS>: Send + Sync + 'static,
{
    fn resume(
        &self,
        setting: Setting<'_, f64>,
        memory: Option<&Memory>,
    ) -> Result<(Outcome, Memory), Failure> {
        let prepared = (self.prepare)(setting, self.model)?;
        let typical = (self.typical)(self.model, &prepared.core);
        by_method!(prepared, |simulation| {
            let state = prepared.start(&simulation, &self.model.start())?;
            remembered(&prepared.run(&simulation), state, &typical, memory)
        })
    }

    fn follow(&mut self, setting: Setting<'_, f64>, spent: &mut Spent) -> Result<Option<Response>, Failure> {
        let prepared = (self.prepare)(setting, self.model)?;
        let typical = (self.typical)(self.model, &prepared.core);
        by_method!(prepared, |simulation| {
            let state = prepared.start(&simulation, &self.model.start())?;
            follow(&prepared.run(&simulation), state, &typical, &mut self.known, spent)
        })
    }
}
