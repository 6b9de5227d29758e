//! What is at the terminals, as a step sees it.

use core::fmt::Debug;

use crate::observer::StorageOutput;
use crate::part::bounds::{Bounds, ParameterError};
use crate::part::bridge_step::{BridgeStep, Passed};
use crate::part::circuit::CircuitStep;
use crate::part::load::{AnyLoad, Load, OpenCircuit, Resistance, Resistor, ShortCircuit};
use crate::part::rectifier::FullBridge;
use crate::part::storage::StorageElement;
use crate::part::storage_step::{StorageAccount, StorageState};
use crate::scalar::Scalar;
use crate::snapshot::{Fingerprint, Snapshot};

/// What a circuit remembers from step to step.
pub trait Memory: Copy + Debug + PartialEq + Snapshot {
    /// What a step has to account for besides the delivered energy.
    type Account: Copy + Debug + PartialEq;
}

/// A resistor remembers nothing.
impl Memory for () {
    type Account = ();
}

/// A bridge remembers its storage.
impl<S: Scalar> Memory for StorageState<S> {
    type Account = StorageAccount<S>;
}

/// What a circuit remembers, and what it accounts for.
type AccountOf<S, C> = <<C as Circuit<S>>::State as Memory>::Account;

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
pub trait Circuit<S: Scalar>: Copy + Debug + PartialEq {
    /// What it remembers.
    type State: Memory;
    /// Its coefficients for one length of step.
    type Step: Copy + Debug + PartialEq;
    /// Whether it has other lines than the one tried first; if not, the code for them is not there.
    const SWITCHES: bool;

    /// The resistance of a resistive load; `None` behind a bridge.
    fn resistance(&self) -> Option<Resistance<S>>;

    /// Whether its terminals are joined, so that the charge follows the strain.
    fn is_short(&self) -> bool;

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

    /// The storage behind it, or the bus; `None` for a resistor.
    fn storage(&self, state: &Self::State) -> Option<StorageOutput<S>>;

    /// Whether a voltage may be taken for one that strays from it by at most `interpolation_bound`, both in V.
    fn resolves(&self, voltage: S, interpolation_bound: S, state: &Self::State) -> bool;

    /// What happens at a voltage before the current flows; gives the charge in C that leaves the electrodes.
    fn begin(&self, step: &Self::Step, voltage: S, state: &mut Self::State) -> (S, AccountOf<S, Self>);

    /// The line `[e0, e1]` that touches the mean voltage at a charge, where that is not the first.
    fn tangent(&self, step: &Self::Step, voltage: S, charge: S, state: &Self::State) -> Option<[S; 2]>;

    /// Lets the current flow, and what happens after it.
    fn conclude(
        &self,
        step: &Self::Step,
        flow: &StepCurrent<S>,
        state: &mut Self::State,
        account: &mut AccountOf<S, Self>,
    ) -> Passed<S>;

    /// Energy in J delivered to the load in a step with this mean square voltage in V².
    fn delivered(step: &Self::Step, mean_square_voltage: S, account: &AccountOf<S, Self>) -> S;

    /// The account of a step behind a bridge; zeros for a resistor.
    fn account(account: &AccountOf<S, Self>) -> StorageAccount<S>;

    /// Puts the storage to a voltage in V; without one nothing changes.
    fn set_storage_voltage(state: &mut Self::State, volts: S);

    /// Takes in all that tells this circuit from others.
    fn identify(&self, fingerprint: &mut Fingerprint);
}

/// A load without diodes is one line.
macro_rules! resistive {
    ($($load:ty),*) => {$(
        impl<S: Scalar> Circuit<S> for $load {
            type State = ();
            type Step = CircuitStep<S>;
            const SWITCHES: bool = false;

            fn resistance(&self) -> Option<Resistance<S>> {
                Some(Load::resistance(self))
            }

            #[inline]
            fn is_short(&self) -> bool {
                matches!(Load::resistance(self), Resistance::<S>::Short)
            }

            fn check(&self) -> Result<(), ParameterError<S>> {
                match Load::resistance(self) {
                    Resistance::Finite(ohms) => Bounds::new(1e-9, 1e30).check("resistance", ohms),
                    Resistance::Short | Resistance::Open => Ok(()),
                }
            }

            fn start(&self) {}

            fn step(&self, capacitance: S, step: S) -> CircuitStep<S> {
                CircuitStep::new(capacitance, Load::resistance(self), step)
            }

            #[inline]
            fn line(step: &CircuitStep<S>) -> &CircuitStep<S> {
                step
            }

            fn storage(&self, _state: &()) -> Option<StorageOutput<S>> {
                None
            }

            #[inline]
            fn resolves(&self, _voltage: S, _sag: S, _state: &()) -> bool {
                true
            }

            #[inline]
            fn begin(&self, _step: &CircuitStep<S>, _voltage: S, _state: &mut ()) -> (S, ()) {
                (S::ZERO, ())
            }

            #[inline]
            fn tangent(&self, _step: &CircuitStep<S>, _voltage: S, _charge: S, _state: &()) -> Option<[S; 2]> {
                None
            }

            #[inline]
            fn conclude(
                &self,
                step: &CircuitStep<S>,
                flow: &StepCurrent<S>,
                _state: &mut (),
                _account: &mut (),
            ) -> Passed<S> {
                Passed { charge: step.charge_by_mean * flow.mean_voltage, mean_square_voltage: None }
            }

            #[inline]
            fn delivered(step: &CircuitStep<S>, mean_square_voltage: S, _account: &()) -> S {
                step.charge_by_mean * mean_square_voltage
            }

            #[inline]
            fn account(_account: &()) -> StorageAccount<S> {
                StorageAccount::default()
            }

            fn set_storage_voltage(_state: &mut (), _volts: S) {}

            fn identify(&self, fingerprint: &mut Fingerprint) {
                Load::<S>::resistance(self).identify(fingerprint);
            }
        }
    )*};
}

resistive!(Resistor<S>, ShortCircuit, OpenCircuit, AnyLoad<S>);

/// What a voltage may stray by, beside the bridge's threshold: an error of that kind in the voltage to which a
/// storage is charged is bounded by it.
const RESOLUTION: f64 = 1.0 / 128.0;

impl<S: Scalar, R: StorageElement<S>> Circuit<S> for FullBridge<S, R> {
    type State = StorageState<S>;
    type Step = BridgeStep<S>;
    const SWITCHES: bool = true;

    fn resistance(&self) -> Option<Resistance<S>> {
        None
    }

    #[inline]
    fn is_short(&self) -> bool {
        false
    }

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
    fn begin(&self, step: &BridgeStep<S>, voltage: S, state: &mut StorageState<S>) -> (S, StorageAccount<S>) {
        let mut account = StorageAccount::default();
        (step.drain(self, voltage, state, &mut account), account)
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

    #[inline]
    fn account(account: &StorageAccount<S>) -> StorageAccount<S> {
        *account
    }

    fn set_storage_voltage(state: &mut StorageState<S>, volts: S) {
        state.put(volts);
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        FullBridge::identify(self, fingerprint);
    }
}
