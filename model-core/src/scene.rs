//! The harvesters: parameters, checked once, and pure functions of a state.
//!
//! Every harvester implements [`Harvester`]: start, advance, outputs, and a snapshot of its state. The triboelectric
//! scenes are hybrid automata ([`Scene`]); with a method and a step control in a [`Simulation`] they become
//! harvesters. Bump-stop has its own [`bump_stop::Stepper`].

pub mod bump_stop;
pub mod contact_separation;
mod coupled;
mod electrical_port;
pub mod rectified;
mod simulation;
pub mod sliding;

use core::fmt::Debug;

use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::hybrid::{Advance, Automaton, HybridState, StepError};
use crate::integrate::StepControl;
use crate::observer::{Observer, Outputs};
use crate::scalar::Scalar;
use crate::snapshot::{Fingerprint, Snapshot};

pub use crate::bounds::{Bounds, ParameterError};
pub use simulation::Simulation;

/// Natural frequencies in Hz, undamped, that a triboelectric harvester may have.
pub const NATURAL_FREQUENCY: Bounds<f64> = Bounds { lowest: 1e-3, highest: 1e4 };

/// A harvester that is stepped under a base acceleration.
///
/// [`Simulation`] implements it for every [`Scene`], [`bump_stop::Stepper`] for bump-stop.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a harvester in `{S}`",
    note = "put a scene with a method and a step control into `Simulation::new(scene, ExponentialRadau, Adaptive::new(..)?)`",
    note = "put a bump-stop scene into `bump_stop::Stepper::new(scene, short_step, long_step)`"
)]
pub trait Harvester<S: Scalar> {
    /// The complete state of a simulation, which can be copied, compared, saved and restored.
    type State: Copy + Debug + PartialEq + Snapshot;
    /// Initial values.
    type Start: Default;

    /// Whether steps estimate their error.
    const ESTIMATES_ERROR: bool;
    /// As [`Method::ERROR_PER_ESTIMATE`](crate::integrate::Method::ERROR_PER_ESTIMATE).
    const ERROR_PER_ESTIMATE: f64 = 1.0;
    /// Smallest budget of [`Harvester::advance`] in attempted steps.
    const LEAST_BUDGET: u32;

    /// The state at time zero.
    ///
    /// # Errors
    /// An initial value outside its bounds.
    fn start<E: Excitation<S>>(
        &self,
        start: &Self::Start,
        excitation: &E,
    ) -> Result<Self::State, ParameterError<S>>;

    /// The state at rest at `at`, under the acceleration at that time. The storage keeps its charge from `before`.
    ///
    /// # Errors
    /// The harvester cannot start at rest.
    fn restart<E: Excitation<S>>(
        &self,
        before: Option<&Self::State>,
        excitation: &E,
        at: Instant,
    ) -> Result<Self::State, ParameterError<S>>;

    /// Advances `state` to `until`, in at most `budget` attempted steps.
    ///
    /// The bits of the result do not depend on the budgets. They depend on `until`, because a step ends there.
    ///
    /// # Errors
    /// [`StepError`]; `state` is then the last good one, and `observer` has seen all steps before the failed one.
    fn advance<E: Excitation<S>, O: Observer<S>>(
        &self,
        state: &mut Self::State,
        excitation: &E,
        until: Instant,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>>;

    /// Advances `state` to `until`, or by less than `sample_ticks` past it if that is cheaper.
    ///
    /// # Errors
    /// As [`Harvester::advance`].
    #[inline]
    fn advance_past<E: Excitation<S>, O: Observer<S>>(
        &self,
        state: &mut Self::State,
        excitation: &E,
        until: Instant,
        _sample_ticks: u64,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>> {
        self.advance(state, excitation, until, budget, observer)
    }

    /// Simulated time.
    fn clock(&self, state: &Self::State) -> Instant;

    /// Sets the simulated time, under an excitation that is displaced in time by the same amount.
    fn set_clock(&self, state: &mut Self::State, clock: Instant);

    /// Outputs at `state`.
    fn outputs<'a>(&self, state: &'a Self::State) -> Outputs<'a, S>;

    /// Velocity in m/s: the rate of the first coordinate of [`Harvester::outputs`].
    fn velocity(&self, state: &Self::State) -> S {
        let [first, ..] = self.outputs(state).motions;
        first.rate
    }

    /// Sets the voltage of the storage in V, at or above 0, under a base acceleration in m/s². Without effect on a
    /// harvester without a storage.
    fn set_storage_voltage(&self, _state: &mut Self::State, _voltage: S, _acceleration: S) {}

    /// The error of the steps of a harvester that checks them ([`bump_stop::StepDoubling`]); `None` for one that does not, and
    /// before its first check.
    fn step_doubling_error(&self, _state: &Self::State) -> Option<StepDoublingError<S>> {
        None
    }

    /// Angular frequency of the slowest undamped motion in rad/s.
    fn angular_frequency(&self) -> S;

    /// Rate in 1/s at which that motion decays, its damping ratio times its angular frequency; 0 if it is not known: all
    /// time after a gap of the samples is then uncertain.
    fn decay_rate(&self) -> S {
        S::ZERO
    }

    /// Resonance frequency of the slowest undamped motion in Hz.
    fn resonance_frequency(&self) -> S {
        self.angular_frequency() * S::from_f64(0.5 * core::f64::consts::FRAC_1_PI)
    }

    /// Includes all parameters and choices that determine the meaning of a state in a fingerprint.
    fn identify(&self, fingerprint: &mut Fingerprint);

    /// Fingerprint of the harvester, for [`crate::snapshot::save`] and [`crate::snapshot::restore`].
    fn fingerprint(&self) -> u32 {
        let mut fingerprint = Fingerprint::new();
        self.identify(&mut fingerprint);
        fingerprint.value()
    }
}

/// What checks of the steps by finer ones have shown.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StepDoublingError<S> {
    /// Error of the mean power by the finite step, relative.
    pub relative: S,
    /// Part of the time, 0 to 1, in which the motion is so irregular that any other steps lead to another motion.
    pub irregular: S,
    /// Mean power in W while steps were checked. Far below that of the run the checks have missed what counts.
    pub power: S,
}

/// Least and largest change of steps at a time.
const STEP_FACTORS: [f64; 2] = [0.25, 2.0];

impl<S: Scalar> StepDoublingError<S> {
    /// The factor, 0.25 to 2, by which all steps should be changed for this relative error of the mean power by the finite
    /// step, if that falls with the square of the step. The method is of an order of 2 to 3 where the steps resolve the
    /// contact: a shorter step then gives more than asked for.
    ///
    /// It does not change [`StepDoublingError::irregular`]: an irregular motion needs a longer time.
    #[must_use]
    pub fn step_factor(&self, tolerance: S) -> S {
        let [least, most] = STEP_FACTORS.map(S::from_f64);
        (tolerance / self.relative.max(S::TINY)).sqrt().max(least).min(most)
    }
}

/// A harvester as a hybrid automaton of `N` states with `P` powers.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a scene of {N} states with {P} powers in `{S}`",
    note = "a triboelectric scene needs a `Load` (`Resistor`, `OpenCircuit`, ..); behind a bridge, give it \
            `OpenCircuit` and put it into `rectified::Rectified::new(scene, bridge)`"
)]
pub trait Scene<S: Scalar, const N: usize, const P: usize>: Automaton<S, N, P, Mode: Snapshot> {
    /// Initial values.
    type Start: Default;

    /// Index in the state of the rate of the first coordinate.
    const VELOCITY: usize = 1;

    /// The state at time zero.
    ///
    /// # Errors
    /// An initial value outside its bounds.
    fn start<E: Excitation<S>, C: StepControl<S>>(
        &self,
        start: &Self::Start,
        excitation: &E,
        control: &C,
    ) -> Result<HybridState<S, Self::Mode, N, P>, ParameterError<S>>;

    /// Copies the storage of `before` into `state`, under a base acceleration in m/s². Without effect on a scene without a storage.
    fn keep_storage(
        &self,
        _before: &HybridState<S, Self::Mode, N, P>,
        _state: &mut HybridState<S, Self::Mode, N, P>,
        _acceleration: S,
    ) {
    }

    /// As [`Harvester::set_storage_voltage`].
    fn set_storage_voltage(
        &self,
        _state: &mut HybridState<S, Self::Mode, N, P>,
        _voltage: S,
        _acceleration: S,
    ) {
    }

    /// As [`Harvester::identify`].
    fn identify(&self, fingerprint: &mut Fingerprint);
}

/// Declares `Parts` and implements it for `Choices`: each type parameter of `Choices` with its name and its bound.
macro_rules! parts {
    ($scalar:ident: $($(#[$doc:meta])* $parameter:ident = $name:ident: $bound:path,)+) => {
        /// The component types of [`Choices`].
        pub trait Parts<$scalar: Scalar>: Copy + Debug + PartialEq {
            $($(#[$doc])* type $name: $bound;)+

            /// The choices themselves.
            fn choices(&self) -> &Choices<$(Self::$name),+>;
        }

        impl<$scalar: Scalar, $($parameter: $bound),+> Parts<$scalar> for Choices<$($parameter),+> {
            $(type $name = $parameter;)+

            #[inline]
            fn choices(&self) -> &Self {
                self
            }
        }
    };
}
pub(crate) use parts;
