//! Common code of the bridge tests: both harvesters, a storage, a run.

use crate::common::harvesters::{self, Contact, Slide};
pub(crate) use crate::common::{adaptive, fixed};
use model_core::clock::Instant;
use model_core::excitation::{Excitation, Sine};
use model_core::hybrid::{Automaton, Driver, HybridState};
use model_core::integrate::{AnyStepControl, Method};
use model_core::observer::{Observer, PowerIndex};
use model_core::part::draw::AnyDraw;
use model_core::part::force_law::AnyForceLaw;
use model_core::part::restitution::{AnyRestitution, ConstantRestitution};
use model_core::part::storage::{Capacitor, StorageCapacitor, StorageElement};
use model_core::scalar::{Mathematics, Polynomial, Scalar};
use model_core::scene::rectified::{ElectricalPort, FullBridge, Mode, Rectified, STATES};
use model_core::scene::{Scene, sliding};

/// Number of all powers.
pub(crate) const WHOLE: usize = PowerIndex::ContactForce as usize + 1;
pub(crate) use model_core::part::{GRAVITY, VACUUM_PERMITTIVITY};

/// The mass over a dielectric of Table 2.
pub(crate) fn pad<S: Scalar>(resistance: f64, force_law: AnyForceLaw) -> Contact<S> {
    let mut parameters = harvesters::contact_parameters();
    parameters.choices.load.resistance = S::from_f64(resistance);
    parameters.choices.restitution =
        AnyRestitution::Constant(ConstantRestitution { coefficient: S::from_f64(0.7) });
    parameters.choices.force_law = force_law;
    parameters.build().expect("in bounds")
}

/// The slider of Table 1, with the field's lateral force so that the ledger closes as a whole.
pub(crate) fn slider<S: Scalar>(resistance: f64) -> Slide<S> {
    let mut parameters = harvesters::sliding_parameters();
    parameters.choices.load.resistance = S::from_f64(resistance);
    parameters.choices.lateral_force = sliding::AnyLateralForce::Field;
    parameters.build().expect("in bounds")
}

pub(crate) fn storage<S: Scalar>(capacitance: f64, voltage: f64) -> StorageCapacitor<S, AnyDraw<S>> {
    StorageCapacitor {
        capacitor: Capacitor { capacitance: S::from_f64(capacitance), leakage_resistance: S::from_f64(1e9) },
        initial_voltage: S::from_f64(voltage),
        draw: AnyDraw::None,
    }
}

pub(crate) fn behind<S: Scalar, H: ElectricalPort<S>, R: StorageElement<S>>(
    harvester: H,
    storage: R,
    drop: f64,
) -> Rectified<S, H, R> {
    Rectified::new(harvester, FullBridge { diode_drop: S::from_f64(drop), storage }).expect("in bounds")
}

pub(crate) fn sine<S: Scalar>(gravities: f64, frequency: f64) -> Sine<S>
where
    Polynomial: Mathematics<S>,
{
    Sine::new(S::from_f64(gravities * GRAVITY), S::from_f64(frequency), S::ZERO).expect("in bounds")
}

/// The default start of a scene.
pub(crate) fn begin<S: Scalar, A: Scene<S, N, WHOLE>, M, const N: usize>(
    scene: &A,
    vibration: &impl Excitation<S>,
    driver: &Driver<M, AnyStepControl<S>>,
) -> HybridState<S, A::Mode, N, WHOLE>
where
    A::Start: Default,
{
    scene.start(&A::Start::default(), vibration, &driver.control).expect("in bounds")
}

/// Runs from a start.
pub(crate) fn run<S, H, R, M, E, O>(
    scene: &Rectified<S, H, R>,
    start: &H::Start,
    vibration: &E,
    driver: &Driver<M, AnyStepControl<S>>,
    seconds: f64,
    observer: &mut O,
) -> HybridState<S, Mode<<H as Automaton<S, 3, 0>>::Mode>, STATES, WHOLE>
where
    S: Scalar,
    H: ElectricalPort<S>,
    R: StorageElement<S>,
    M: Method<S>,
    E: Excitation<S>,
    O: Observer<S>,
{
    let mut state = scene.start::<_, _, WHOLE>(start, vibration, &driver.control).expect("in bounds");
    let end = Instant::from_seconds(seconds).expect("in range");
    driver.advance(scene, &mut state, vibration, end, u32::MAX, observer).expect("runs");
    state
}
