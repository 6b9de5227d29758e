//! Any scene on the hybrid driver behind a full bridge.

use model_core::energy::Residual;
use model_core::hybrid::Automaton;
use model_core::part::rectifier::FullBridge;
use model_core::part::storage::AnyStorage;
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::rectified::{ElectricalPort, Mode, Rectified, STATES};

use super::excitation::with_excitation;
use super::hybrid_run::{Found, HostedScene, Run, Store, refuse_start, step_control};
use crate::method::{Failure, Options};
use crate::outcome::{Outcome, Particular};
use crate::scene_file::{Draw, Load, Scene};

/// A step at which an explicit method is stable and accurate: as good as the motion alone needs, and 2
/// times the time constant of what empties the store.
fn explicit_step(motion_s: f64, load: Load) -> f64 {
    let Load::RectifiedStore(store) = load else { return motion_s };
    let drawn = match store.draw {
        Draw::Resistor { resistance_ohm, .. } => resistance_ohm,
        // Steepest where the draw is disconnected.
        Draw::Power { power_w, lockout } => lockout.turn_off_v.powi(2) / power_w,
        Draw::None | Draw::Current { .. } => f64::INFINITY,
    };
    motion_s.min(2.0 * store.capacitance_f * store.leakage_ohm.min(drawn))
}

/// The outcome of a scene whose harvester is `inner`, behind `bridge`; `motion_s` is the step that the motion
/// by itself asks of an explicit method.
pub(super) fn run<S, M, H>(
    scene: &Scene,
    options: &Options,
    inner: H,
    start: &<H::Core as ElectricalPort<S>>::Start,
    bridge: FullBridge<S, AnyStorage<S>>,
    motion_s: f64,
) -> Result<Outcome, Failure>
where
    S: Scalar,
    M: Mathematics<S>,
    H: HostedScene<S, 3>,
    H::Core: ElectricalPort<S>,
{
    let core = Rectified::new(*inner.core(), bridge)
        .map_err(|error| Failure::Input(format!("{}: load.{error}", scene.file.display())))?;
    let control = step_control(scene, options, explicit_step(motion_s, scene.load))?;
    let hosted = Hosted { core, inner };
    with_excitation::<S, M, _>(scene, |excitation| {
        let state =
            hosted.core.start(start, excitation, &control).map_err(|error| refuse_start(scene, &error))?;
        Run { scene, options, hosted: &hosted, excitation, control }.to_end(state)
    })
}

/// The core's harvester behind its bridge.
struct Hosted<S: Scalar, H: HostedScene<S, 3>> {
    core: Rectified<S, H::Core, AnyStorage<S>>,
    inner: H,
}

impl<S, H> HostedScene<S, STATES> for Hosted<S, H>
where
    S: Scalar,
    H: HostedScene<S, 3>,
    H::Core: ElectricalPort<S>,
{
    type Core = Rectified<S, H::Core, AnyStorage<S>>;

    fn core(&self) -> &Self::Core {
        &self.core
    }

    fn columns(&self, with_store: bool) -> &'static [&'static str] {
        self.inner.columns(with_store)
    }

    fn charge(&self, mode: BridgedMode<S, H>, state: &[S; STATES]) -> S {
        let [_, _, charge] = self.core.harvester_state(mode, state);
        charge
    }

    fn store(&self, mode: BridgedMode<S, H>, state: &[S; STATES]) -> Option<Store<S>> {
        let voltage = self.core.storage_voltage(mode, state);
        let has_end = matches!(self.core.bridge().storage, AnyStorage::Capacitor(_));
        Some(Store { voltage, energy: has_end.then(|| self.core.stored_energy_at(voltage)) })
    }

    fn coulombs(&self, position: S, charge: S) -> S {
        self.inner.coulombs(position, charge)
    }

    fn typical(&self) -> [f64; 3] {
        self.inner.typical()
    }

    fn residual(&self, residual: &Residual<S>) -> Option<S> {
        self.inner.residual(residual)
    }

    fn particular(&self, found: &Found<S>) -> Particular {
        self.inner.particular(found)
    }
}

/// The modes behind a bridge.
type BridgedMode<S, H> = Mode<<<H as HostedScene<S, 3>>::Core as Automaton<S, 3, 0>>::Mode>;
