//! What the node may spend: its storage, its actions, and when it takes them.

use model_core::energy::{
    Action, Budget, BudgetParameters, BudgetState, Capacitor, IncomeParameters, StorageParameters,
};

use model_core::snapshot::{Configuration, Fingerprint};

use super::{Decision, NodeError, VOLTAGE_ERROR};

/// Slots of the day of which the budget learns what they bring.
const SLOTS: usize = 24;
/// Seconds from one measurement to the next, if the storage allows it.
const MEASURE_EVERY: u32 = 10;
/// Seconds from one transmission to the next, if the storage allows it.
const TRANSMIT_EVERY: u32 = 60;

/// Capacitance of the storage in farads.
pub const CAPACITANCE: f32 = 22e-6;
/// A ceramic capacitor behind the bridge, and a node that runs straight from it: 22 µF, used from 1.9 V up to
/// 4.2 V.
pub(super) const STORAGE: StorageParameters<f32> = StorageParameters {
    capacitor: Capacitor { capacitance: CAPACITANCE, leakage_resistance: 100e6 },
    // The diodes' loss is in the harvester's model.
    charging_efficiency: 1.0,
    discharging_efficiency: 1.0,
    highest_voltage: 4.2,
    lock_out_voltage: 1.9,
    turn_on_voltage: 2.2,
};

/// The budget of the node and its habits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerManager {
    budget: Budget<f32, SLOTS>,
    state: BudgetState<f32, SLOTS>,
    measure: Action<f32>,
    transmit: Action<f32>,
    since_measurement: u32,
    since_transmission: u32,
}

/// The state of a [`PowerManager`]: that of its budget, and the seconds since a measurement and a transmission.
pub type PowerManagerState = (BudgetState<f32, SLOTS>, [u32; 2]);

impl PowerManager {
    /// At midnight, with an empty storage until a first reading says otherwise.
    ///
    /// # Errors
    /// If a parameter is out of its bounds.
    pub fn new() -> Result<Self, NodeError> {
        let refused = |_| NodeError::Parameters;
        let budget = BudgetParameters {
            storage: core::hint::black_box(STORAGE),
            income: IncomeParameters { time_constant: 600.0, day_weight: 0.5 },
            // Asleep with a clock that runs: 0.1 µA.
            standing_power: 0.3e-6,
        }
        .build()
        .map_err(refused)?;
        Ok(Self {
            state: budget.start(0),
            budget,
            // A conversion of a sensor, and a short packet: upper bounds.
            measure: Action::new("measure", 4e-6, 5e-3).map_err(refused)?,
            transmit: Action::new("transmit", 35e-6, 3e-3).map_err(refused)?,
            since_measurement: MEASURE_EVERY,
            since_transmission: 0,
        })
    }

    /// The storage as it was read.
    pub fn read(&mut self, voltage: f32) {
        self.budget.correct_by_voltage(&mut self.state, voltage, VOLTAGE_ERROR);
    }

    /// A second has gone by, in which `harvested` joules came in, give or take `uncertainty` joules; what to
    /// do now. What is decided is taken as spent.
    pub fn second(&mut self, harvested: f32, uncertainty: f32) -> Decision {
        let Self { budget, state, measure, transmit, .. } = self;
        budget.update(state, 1, harvested, 0.0);
        state.raise_uncertainty(uncertainty);
        let now = state.second();
        self.since_measurement += 1;
        self.since_transmission += 1;
        let (decision, action) =
            if self.since_transmission >= TRANSMIT_EVERY && budget.can_run_now(state, transmit, now) {
                self.since_transmission = 0;
                (Decision::Transmit, transmit)
            } else if self.since_measurement >= MEASURE_EVERY && budget.can_run_now(state, measure, now) {
                self.since_measurement = 0;
                (Decision::Measure, measure)
            } else {
                return Decision::Sleep;
            };
        budget.spend(state, action.energy());
        decision
    }

    /// Energy in the storage, in joules.
    #[must_use]
    pub fn stored(&self) -> f32 {
        self.state.energy()
    }

    /// Voltage of the storage, in volts.
    #[must_use]
    pub fn storage_voltage(&self) -> f32 {
        self.budget.storage().voltage(self.state.energy())
    }

    /// What the account of the storage leaves unexplained, in joules.
    #[must_use]
    pub fn unexplained(&self) -> f32 {
        self.state.account().balance - self.state.energy()
    }
}

impl PowerManager {
    /// The state.
    #[must_use]
    pub fn state(&self) -> PowerManagerState {
        (self.state, [self.since_measurement, self.since_transmission])
    }

    /// Continues from a state.
    pub fn set_state(&mut self, (state, [since_measurement, since_transmission]): PowerManagerState) {
        self.state = state;
        self.since_measurement = since_measurement;
        self.since_transmission = since_transmission;
    }
}

impl Configuration for PowerManager {
    type State = PowerManagerState;

    fn identify(&self, fingerprint: &mut Fingerprint) {
        self.budget.identify(fingerprint);
        for action in [&self.measure, &self.transmit] {
            fingerprint.numbers(&[action.energy(), action.duration()]);
        }
        fingerprint.numbers(&[MEASURE_EVERY, TRANSMIT_EVERY]);
    }
}
