//! Steps the circuit at the terminals: a load resistance, or a bridge with its storage.

use core::fmt::Debug;

use crate::bounds::ParameterError;
use crate::observer::StorageOutput;
use crate::part::bridge_step::{BridgeCharge, BridgeStep};
use crate::part::circuit::{CircuitStep, LinearCircuitStep};
use crate::part::load::{Load, Resistance};
use crate::part::rectifier::FullBridge;
use crate::part::storage::StorageElement;
use crate::part::storage_step::{StorageAccount, StorageState};
use crate::scalar::Scalar;
use crate::snapshot::{Fingerprint, Snapshot};

/// The constant current of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepCurrent<S> {
    /// Voltage in V at the start.
    pub voltage: S,
    /// Charge in C that strain moves to the electrodes.
    pub charge: S,
    /// Mean voltage in V.
    pub mean_voltage: S,
}

/// A circuit at the terminals. Over a step its mean voltage is linear in the charge Δq that strain moves to the
/// electrodes, `v̄ = e0 + e1 Δq`, or a curve that is solved by its tangents.
///
/// The provided methods are those of a circuit without a storage, with one linear relation.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be at the terminals of a bump-stop harvester",
    note = "`Choices::new(load)` takes a load resistance, `Choices::behind(bridge)` a `FullBridge`"
)]
pub trait Circuit<S: Scalar>: Copy + Debug + PartialEq {
    /// The state between steps: empty, or that of the storage.
    type State: Copy + Debug + PartialEq + Snapshot;
    /// The coefficients for one step length.
    type Step: Copy + Debug + PartialEq;
    /// Whether the circuit has a storage, and further tangents. If not, their code is not compiled.
    const SWITCHES: bool = false;

    /// Whether the circuit is a short circuit: the charge then follows the strain.
    #[inline]
    fn is_short(&self) -> bool {
        false
    }

    /// Checks the parameters of the circuit.
    ///
    /// # Errors
    /// The field, its value and its bounds.
    fn check(&self) -> Result<(), ParameterError<S>>;

    /// The state before the first step.
    fn start(&self) -> Self::State;

    /// The coefficients of a step in s, on a capacitance in F.
    fn step(&self, capacitance: S, step: S) -> Self::Step;

    /// The coefficients of a step in s under a current that is linear in time, on a capacitance in F; of a bridge, while it blocks.
    fn linear_step(&self, capacitance: S, step: S) -> LinearCircuitStep<S>;

    /// The linear relation of the first trial.
    fn line(step: &Self::Step) -> &CircuitStep<S>;

    /// Applies the current of a step and the outflow of the storage after it.
    fn conclude(
        &self,
        step: &Self::Step,
        flow: &StepCurrent<S>,
        state: &mut Self::State,
        account: &mut StorageAccount<S>,
    ) -> BridgeCharge<S>;

    /// Energy in J delivered to the load in a step with this mean square voltage in V².
    fn delivered(step: &Self::Step, mean_square_voltage: S, account: &StorageAccount<S>) -> S;

    /// Includes all parameters of the circuit in a fingerprint.
    fn identify(&self, fingerprint: &mut Fingerprint);

    /// Whether the circuit may use its voltage for one that differs by at most `interpolation_bound` in V.
    #[inline]
    fn resolves(&self, _interpolation_bound: S, _state: &Self::State) -> bool {
        true
    }

    /// Whether the circuit has its linear relation for all voltages that differ from `voltage` by at most
    /// `interpolation_bound`, both in V.
    #[inline]
    fn blocks(&self, _voltage: S, _interpolation_bound: S, _state: &Self::State) -> bool {
        true
    }

    /// Applies the outflow of the storage before the current. Returns the charge in C that leaves the electrodes.
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

    /// The tangent `[e0, e1]` of the mean voltage at a charge; `None` for the first linear relation.
    #[inline]
    fn tangent(&self, _step: &Self::Step, _voltage: S, _charge: S, _state: &Self::State) -> Option<[S; 2]> {
        None
    }

    /// The storage or DC bus at a voltage in V, with an elastance of the electrodes in 1/F. A start voltage above its
    /// threshold is shared at once, which lifts the threshold.
    #[inline]
    fn storage(&self, _state: &Self::State, _voltage: S, _elastance: S) -> Option<StorageOutput<S>> {
        None
    }

    /// Sets the storage to a voltage in V; without effect on a circuit without a storage.
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

    fn step(&self, capacitance: S, step: S) -> CircuitStep<S> {
        CircuitStep::new(capacitance, self.resistance(), step)
    }

    fn linear_step(&self, capacitance: S, step: S) -> LinearCircuitStep<S> {
        LinearCircuitStep::new(capacitance, self.resistance(), step)
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
    ) -> BridgeCharge<S> {
        BridgeCharge { charge: step.charge_by_mean * flow.mean_voltage, mean_square_voltage: None }
    }

    #[inline]
    fn delivered(step: &CircuitStep<S>, mean_square_voltage: S, _account: &StorageAccount<S>) -> S {
        step.charge_by_mean * mean_square_voltage
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        Load::<S>::resistance(self).identify(fingerprint);
    }
}

/// Largest interpolation error of the voltage relative to the threshold of the bridge: it bounds the error of the
/// final storage voltage.
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

    fn linear_step(&self, capacitance: S, step: S) -> LinearCircuitStep<S> {
        LinearCircuitStep::new(capacitance, Resistance::Open, step)
    }

    #[inline]
    fn line(step: &BridgeStep<S>) -> &CircuitStep<S> {
        &step.blocked
    }

    #[inline]
    fn storage(&self, state: &StorageState<S>, terminal: S, elastance: S) -> Option<StorageOutput<S>> {
        let StorageState { voltage, remainder, connected } = *state;
        let (capacitance, own) = (self.storage.capacitance(), self.storage.elastance());
        let mut threshold = self.threshold(voltage);
        threshold += (terminal.abs() - threshold).max(S::ZERO) * (own / (own + elastance));
        Some(StorageOutput { voltage, remainder, capacitance, threshold, connected })
    }

    /// True if the interval is small relative to the threshold.
    #[inline]
    fn resolves(&self, interpolation_bound: S, state: &StorageState<S>) -> bool {
        interpolation_bound <= S::from_f64(RESOLUTION) * self.threshold(state.voltage)
    }

    #[inline]
    fn blocks(&self, voltage: S, interpolation_bound: S, state: &StorageState<S>) -> bool {
        voltage.abs() + interpolation_bound < self.threshold(state.voltage)
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
    ) -> BridgeCharge<S> {
        step.conclude(self, [flow.voltage, flow.charge], state, account)
    }

    #[inline]
    fn delivered(_step: &BridgeStep<S>, _mean_square_voltage: S, account: &StorageAccount<S>) -> S {
        account.delivered
    }

    fn set_storage_voltage(state: &mut StorageState<S>, voltage: S) {
        (state.voltage, state.remainder) = (voltage, S::ZERO);
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        FullBridge::identify(self, fingerprint);
    }
}
