//! What is at the terminals, as a step sees it: a load resistance, or a bridge and its storage.

use core::fmt::Debug;

use crate::observer::StorageOutput;
use crate::part::bounds::ParameterError;
use crate::part::bridge_step::{BridgeStep, Passed};
use crate::part::circuit::CircuitStep;
use crate::part::load::{Load, Resistance};
use crate::part::rectifier::FullBridge;
use crate::part::storage::StorageElement;
use crate::part::storage_step::{StorageAccount, StorageState};
use crate::scalar::Scalar;
use crate::snapshot::{Fingerprint, Snapshot};

/// The current of a step, taken as constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepCurrent<S> {
    /// Voltage in V at the start.
    pub voltage: S,
    /// Charge in C that strain brings to the electrodes.
    pub charge: S,
    /// Mean voltage in V.
    pub mean_voltage: S,
}

/// A circuit at the terminals: over a step its mean voltage is linear, `v̄ = e0 + e1 Δq`, in the charge Δq that
/// strain brings to the electrodes, or it is found from such lines.
///
/// The provided methods are those of a circuit without a storage, whose mean voltage is one line.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be at the terminals of a bump-stop harvester",
    note = "`Choices::new(load)` takes a load resistance, `Choices::behind(bridge)` a `FullBridge`"
)]
pub trait Circuit<S: Scalar>: Copy + Debug + PartialEq {
    /// What it remembers from step to step: nothing, or its storage.
    type State: Copy + Debug + PartialEq + Snapshot;
    /// Its coefficients for one length of step.
    type Step: Copy + Debug + PartialEq;
    /// Whether it has a storage, and other lines than the one tried first. If not, the code for them is not
    /// compiled.
    const SWITCHES: bool = false;

    /// Whether its terminals are joined, so that the charge follows the strain.
    #[inline]
    fn is_short(&self) -> bool {
        false
    }

    /// Refuses what is out of bounds.
    ///
    /// # Errors
    /// The field, its value and its bounds.
    fn check(&self) -> Result<(), ParameterError<S>>;

    /// What it remembers before the first step.
    fn start(&self) -> Self::State;

    /// The coefficients of a step in s, on a capacitance in F.
    fn step(&self, capacitance: S, step: S) -> Self::Step;

    /// The line that is tried first.
    fn line(step: &Self::Step) -> &CircuitStep<S>;

    /// Lets the current flow, and what happens after it.
    fn conclude(
        &self,
        step: &Self::Step,
        flow: &StepCurrent<S>,
        state: &mut Self::State,
        account: &mut StorageAccount<S>,
    ) -> Passed<S>;

    /// Energy in J delivered to the load in a step with this mean square voltage in V².
    fn delivered(step: &Self::Step, mean_square_voltage: S, account: &StorageAccount<S>) -> S;

    /// Takes in all that tells this circuit from others.
    fn identify(&self, fingerprint: &mut Fingerprint);

    /// Whether a voltage may be taken for one that strays from it by at most `interpolation_bound`, both in V.
    #[inline]
    fn resolves(&self, _voltage: S, _interpolation_bound: S, _state: &Self::State) -> bool {
        true
    }

    /// What happens at a voltage before the current flows; gives the charge in C that leaves the electrodes.
    #[inline]
    fn begin(
        &self,
        _step: &Self::Step,
        _voltage: S,
        _state: &mut Self::State,
        _account: &mut StorageAccount<S>,
    ) -> S {
        S::ZERO
    }

    /// The line `[e0, e1]` that touches the mean voltage at a charge, where that is not the first.
    #[inline]
    fn tangent(&self, _step: &Self::Step, _voltage: S, _charge: S, _state: &Self::State) -> Option<[S; 2]> {
        None
    }

    /// The storage behind it, or the bus.
    #[inline]
    fn storage(&self, _state: &Self::State) -> Option<StorageOutput<S>> {
        None
    }

    /// The resistance of a resistive load; `None` behind a bridge.
    fn load_resistance(&self) -> Option<Resistance<S>> {
        None
    }

    /// Puts the storage to a voltage in V; without one nothing changes.
    fn set_storage_voltage(_state: &mut Self::State, _volts: S) {}
}

/// A load resistance at the terminals of a bump-stop harvester.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Resistive<L>(pub L);

impl<S: Scalar, L: Load<S>> Load<S> for Resistive<L> {
    #[inline]
    fn resistance(&self) -> Resistance<S> {
        self.0.resistance()
    }
}

impl<S: Scalar, L: Load<S>> Circuit<S> for Resistive<L> {
    type State = ();
    type Step = CircuitStep<S>;

    #[inline]
    fn is_short(&self) -> bool {
        matches!(self.resistance(), Resistance::<S>::Short)
    }

    fn check(&self) -> Result<(), ParameterError<S>> {
        self.resistance().check()
    }

    fn start(&self) {}

    fn load_resistance(&self) -> Option<Resistance<S>> {
        Some(self.resistance())
    }

    fn step(&self, capacitance: S, step: S) -> CircuitStep<S> {
        CircuitStep::new(capacitance, self.resistance(), step)
    }

    #[inline]
    fn line(step: &CircuitStep<S>) -> &CircuitStep<S> {
        step
    }

    #[inline]
    fn conclude(
        &self,
        step: &CircuitStep<S>,
        flow: &StepCurrent<S>,
        _state: &mut (),
        _account: &mut StorageAccount<S>,
    ) -> Passed<S> {
        Passed { charge: step.charge_by_mean * flow.mean_voltage, mean_square_voltage: None }
    }

    #[inline]
    fn delivered(step: &CircuitStep<S>, mean_square_voltage: S, _account: &StorageAccount<S>) -> S {
        step.charge_by_mean * mean_square_voltage
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        Load::<S>::resistance(self).identify(fingerprint);
    }
}

/// What a voltage may stray by, beside the bridge's threshold: an error of that kind in the voltage to which a
/// storage is charged is bounded by it.
const RESOLUTION: f64 = 1.0 / 128.0;

impl<S: Scalar, R: StorageElement<S>> Circuit<S> for FullBridge<S, R> {
    type State = StorageState<S>;
    type Step = BridgeStep<S>;
    const SWITCHES: bool = true;

    fn check(&self) -> Result<(), ParameterError<S>> {
        FullBridge::check(self)
    }

    fn start(&self) -> StorageState<S> {
        StorageState::of(&self.storage)
    }

    fn step(&self, capacitance: S, step: S) -> BridgeStep<S> {
        BridgeStep::new(capacitance, &self.storage, step)
    }

    #[inline]
    fn line(step: &BridgeStep<S>) -> &CircuitStep<S> {
        &step.blocked
    }

    #[inline]
    fn storage(&self, state: &StorageState<S>) -> Option<StorageOutput<S>> {
        let StorageState { voltage, remainder, connected } = *state;
        Some(StorageOutput { voltage, remainder, capacitance: self.storage.capacitance(), connected })
    }

    /// Where it blocks either way, or the difference is small beside the threshold.
    #[inline]
    fn resolves(&self, voltage: S, interpolation_bound: S, state: &StorageState<S>) -> bool {
        let threshold = self.threshold(state.voltage);
        interpolation_bound <= S::from_f64(RESOLUTION) * threshold
            || voltage.abs() + interpolation_bound < threshold
    }

    #[inline]
    fn begin(
        &self,
        step: &BridgeStep<S>,
        voltage: S,
        state: &mut StorageState<S>,
        account: &mut StorageAccount<S>,
    ) -> S {
        step.drain(self, voltage, state, account)
    }

    #[inline]
    fn tangent(
        &self,
        step: &BridgeStep<S>,
        voltage: S,
        charge: S,
        state: &StorageState<S>,
    ) -> Option<[S; 2]> {
        step.tangent(self.threshold(state.voltage), voltage, charge)
    }

    #[inline]
    fn conclude(
        &self,
        step: &BridgeStep<S>,
        flow: &StepCurrent<S>,
        state: &mut StorageState<S>,
        account: &mut StorageAccount<S>,
    ) -> Passed<S> {
        step.conclude(self, [flow.voltage, flow.charge], state, account)
    }

    #[inline]
    fn delivered(_step: &BridgeStep<S>, _mean_square_voltage: S, account: &StorageAccount<S>) -> S {
        account.delivered
    }

    fn set_storage_voltage(state: &mut StorageState<S>, voltage: S) {
        state.put(voltage);
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        FullBridge::identify(self, fingerprint);
    }
}
