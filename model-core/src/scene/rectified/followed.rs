//! What a node needs to follow this harvester, and a store that is drawn from outside.

use super::{BridgeRegime, CHARGE, Flow, Mode, Rectified, STATES, STORE, Terminals};
use crate::excitation::Excitation;
use crate::hybrid::{Automaton, HybridState};
use crate::image::{Fingerprint, Image, ImageError, Reader, Writer};
use crate::integrate::{Point, StepControl};
use crate::part::store::Reservoir;
use crate::scalar::{Scalar, add_increment};
use crate::scene::{Followed, ParameterError, StoreReading, coupled};

/// The mode of a rectified harvester.
type ModeOf<S, H> = Mode<<H as Automaton<S, { coupled::STATES }, 0>>::Mode>;

impl<S, H, R, const POWERS: usize> Followed<S, STATES, POWERS> for Rectified<S, H, R>
where
    S: Scalar,
    H: Terminals<S, Start: Default> + Followed<S, { coupled::STATES }, 0>,
    R: Reservoir<S>,
{
    fn at_rest<E: Excitation<S>, C: StepControl<S>>(
        &self,
        before: Option<&HybridState<S, ModeOf<S, H>, STATES, POWERS>>,
        excitation: &E,
        control: &C,
    ) -> Result<HybridState<S, ModeOf<S, H>, STATES, POWERS>, ParameterError<S>> {
        let mut state = self.start(&H::Start::default(), excitation, control)?;
        if let Some(before) = before {
            state.mode.connected = before.mode.connected;
            let volts = self.store_voltage(before.mode, &before.point.state);
            let input = excitation.acceleration(state.clock);
            Followed::set_store_voltage(self, &mut state, volts, input);
        }
        Ok(state)
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("rectified");
        self.harvester.identify(fingerprint);
        self.bridge.identify(fingerprint);
    }

    fn store(&self, state: &HybridState<S, ModeOf<S, H>, STATES, POWERS>) -> Option<StoreReading<S>> {
        let voltage = self.store_voltage(state.mode, &state.point.state);
        Some(StoreReading { voltage, energy: self.stored_in_reservoir(voltage) })
    }

    fn set_store_voltage(
        &self,
        state: &mut HybridState<S, ModeOf<S, H>, STATES, POWERS>,
        volts: S,
        acceleration: S,
    ) {
        // Conduction ends, its charge taken up; where the store is now below the harvester, the event that is
        // due begins it anew and accounts for what passes at once.
        let Point { state: mut now, mut remainder, .. } = state.point;
        let passed = self.electrics(state.mode, &now).charge - now[CHARGE];
        (now[CHARGE], remainder[CHARGE]) = add_increment(now[CHARGE], remainder[CHARGE], passed);
        (now[STORE], remainder[STORE]) = (volts, S::ZERO);
        state.mode.regime = BridgeRegime::Blocked;
        state.point =
            Point { remainder, ..Point::at(&Flow { scene: self, mode: state.mode }, now, acceleration) };
    }
}

/// The harvester's own mode, and a byte each for the regime (0 blocked, 1 forward, 2 backward) and the draw.
impl<M: Image> Image for Mode<M> {
    const BYTES: usize = M::BYTES + 2;

    fn write(&self, out: &mut Writer<'_>) {
        self.inner.write(out);
        let regime: u8 = match self.regime {
            BridgeRegime::Blocked => 0,
            BridgeRegime::Forward => 1,
            BridgeRegime::Backward => 2,
        };
        regime.write(out);
        self.connected.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, ImageError> {
        let inner = M::read(from)?;
        let regime = match u8::read(from)? {
            0 => BridgeRegime::Blocked,
            1 => BridgeRegime::Forward,
            2 => BridgeRegime::Backward,
            _ => return Err(ImageError::NoState),
        };
        Ok(Self { inner, regime, connected: bool::read(from)? })
    }
}
