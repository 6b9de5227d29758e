//! The scene interface of a rectified harvester, with external changes of the storage voltage.

use super::{BridgeRegime, CHARGE, ElectricalPort, Flow, Mode, Rectified, STATES, STORAGE};
use crate::excitation::Excitation;
use crate::hybrid::{Automaton, HybridState};
use crate::integrate::{Point, StepControl};
use crate::part::storage::StorageElement;
use crate::scalar::{Scalar, add_increment};
use crate::scene::{ParameterError, Scene, coupled};
use crate::snapshot::{Fingerprint, Snapshot, snapshot_fields, snapshot_variants};

/// The mode of a rectified harvester.
type ModeOf<S, H> = Mode<<H as Automaton<S, { coupled::STATES }, 0>>::Mode>;

impl<S: Scalar, H: ElectricalPort<S>, R: StorageElement<S>, const POWERS: usize> Scene<S, STATES, POWERS>
    for Rectified<S, H, R>
{
    type Start = H::Start;

    fn start<E: Excitation<S>, C: StepControl<S>>(
        &self,
        start: &H::Start,
        excitation: &E,
        control: &C,
    ) -> Result<HybridState<S, ModeOf<S, H>, STATES, POWERS>, ParameterError<S>> {
        self.start(start, excitation, control)
    }

    fn keep_storage(
        &self,
        before: &HybridState<S, ModeOf<S, H>, STATES, POWERS>,
        state: &mut HybridState<S, ModeOf<S, H>, STATES, POWERS>,
        acceleration: S,
    ) {
        state.mode.connected = before.mode.connected;
        let voltage = self.storage_voltage(before.mode, &before.point.state);
        Scene::set_storage_voltage(self, state, voltage, acceleration);
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("rectified");
        self.harvester.identify(fingerprint);
        self.bridge.identify(fingerprint);
    }

    fn set_storage_voltage(
        &self,
        state: &mut HybridState<S, ModeOf<S, H>, STATES, POWERS>,
        voltage: S,
        acceleration: S,
    ) {
        // Conduction ends and its charge is added to the state. If the storage is now below the harvester, the event
        // that is due restarts conduction and accounts for the instantaneous charge.
        let Point { state: mut now, mut remainder, .. } = state.point;
        let transferred = self.electrics(state.mode, &now).charge - now[CHARGE];
        (now[CHARGE], remainder[CHARGE]) = add_increment(now[CHARGE], remainder[CHARGE], transferred);
        (now[STORAGE], remainder[STORAGE]) = (voltage, S::ZERO);
        state.mode.regime = BridgeRegime::Blocked;
        state.point =
            Point { remainder, ..Point::at(&Flow { scene: self, mode: state.mode }, now, acceleration) };
    }
}

impl<M> Mode<M> {
    /// Number of the mode in outputs: that of the harvester, plus 16 times the regime, plus 64 for a connected draw.
    pub(super) fn number(&self, inner: u8) -> u8 {
        inner.wrapping_add(16 * self.regime as u8 + 64 * u8::from(self.connected))
    }
}

snapshot_variants!(BridgeRegime { Blocked, Forward, Backward });
snapshot_fields!(impl [M: Snapshot] Mode<M> { inner, regime, connected });
