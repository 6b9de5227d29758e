//! Implements [`Harvester`] for bump-stop.

use super::choices::ContactOf;
use super::circuit::Circuit;
use super::contact_law::ContactLaw;
use super::state::StateOf;
use super::{BumpStop, LEAST_BUDGET, Parts, Start, Stepper};
use crate::bounds::ParameterError;
use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::hybrid::{Advance, StepError};
use crate::observer::{Motion, Observer, Outputs, StorageOutput};
use crate::scalar::Scalar;
use crate::scene::Harvester;
use crate::snapshot::Fingerprint;

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Outputs at `state`; the current is unknown there and set to zero.
    #[inline]
    pub(super) fn outputs<'a>(&self, state: &'a StateOf<S, P, B, R>) -> Outputs<'a, S> {
        let motion = |[value, rate]: [S; 2]| Motion { value, rate };
        let mut outputs = Outputs::of_state(state.beam.as_flattened());
        outputs.motions = [self.tip(state), self.stop_point(state), self.rod_tip(state)].map(motion);
        outputs.charge.value = state.moved_charge;
        outputs.voltage = self.voltage(state);
        outputs.stored = self.stored_energy(state);
        outputs.storage = self.load.storage(&state.circuit, outputs.voltage, self.elastance);
        if let Some(StorageOutput { threshold, .. }) = outputs.storage {
            outputs.voltage = outputs.voltage.max(-threshold).min(threshold);
        }
        outputs.penetration = state.gap;
        outputs.in_contact = ContactOf::<S, P>::POSSIBLE && (state.gap > S::ZERO || state.closed);
        outputs.mode = u8::from(state.closed);
        outputs
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize, const ALL: usize> Harvester<S>
    for Stepper<S, P, B, R, ALL>
{
    type State = StateOf<S, P, B, R>;
    type Start = Start<S, B, R>;

    const ESTIMATES_ERROR: bool = false;
    const LEAST_BUDGET: u32 = LEAST_BUDGET;

    fn start<E: Excitation<S>>(
        &self,
        start: &Self::Start,
        excitation: &E,
    ) -> Result<Self::State, ParameterError<S>> {
        self.scene.start(start, excitation)
    }

    fn restart<E: Excitation<S>>(
        &self,
        before: Option<&Self::State>,
        excitation: &E,
        at: Instant,
    ) -> Result<Self::State, ParameterError<S>> {
        let mut state = self.scene.start(&Start::default(), excitation)?;
        state.acceleration = excitation.acceleration(at);
        state.clock = at;
        if let Some(before) = before {
            state.circuit = before.circuit;
        }
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
        self.run::<true, E, O>(state, excitation, until, budget, observer)
    }

    /// Ends with a whole step unless a short step is at least as long as a sample interval.
    #[inline]
    fn advance_past<E: Excitation<S>, O: Observer<S>>(
        &self,
        state: &mut Self::State,
        excitation: &E,
        until: Instant,
        sample_ticks: u64,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>> {
        if self.overshoots(sample_ticks) {
            self.run::<false, E, O>(state, excitation, until, budget, observer)
        } else {
            self.run::<true, E, O>(state, excitation, until, budget, observer)
        }
    }

    fn clock(&self, state: &Self::State) -> Instant {
        state.clock
    }

    fn set_clock(&self, state: &mut Self::State, clock: Instant) {
        state.clock = clock;
    }

    fn outputs<'a>(&self, state: &'a Self::State) -> Outputs<'a, S> {
        self.scene.outputs(state)
    }

    fn velocity(&self, state: &Self::State) -> S {
        let [_displacement, rate] = self.scene.tip(state);
        rate
    }

    fn set_storage_voltage(&self, state: &mut Self::State, voltage: S, _acceleration: S) {
        P::Load::set_storage_voltage(&mut state.circuit, voltage);
    }

    fn angular_frequency(&self) -> S {
        self.scene.beam_angular_frequency(0).unwrap_or(S::ONE)
    }

    fn decay_rate(&self) -> S {
        self.scene.damping_ratio * self.angular_frequency()
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        self.scene.identify(fingerprint);
        for set in &self.sets {
            fingerprint.count(set.ticks);
        }
    }
}
