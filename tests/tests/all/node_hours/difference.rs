//! The baseline of a node: the difference of two readings, sixty lines that a firmware engineer writes without a library.

use model_core::node::{IncomeOfTime, Task, VoltageNode, VoltageParameters, Wake};

use super::plant::{Facts, Strategy};

/// Seconds from one reading to the next.
const EVERY: u32 = 300;

/// Reads the voltage each five minutes. `income = ΔE + standing power × time + actions + readings`; an action runs when it
/// leaves the reserve. Its parameters are those of a node by the voltage.
pub(super) struct Difference(VoltageNode<1>);

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct State {
    second: u32,
    /// Second of the last reading and action, and of the begin of the hour.
    read: u32,
    ran: u32,
    began: u32,
    /// Stored energy by the last reading, at the begin of the hour, and spent since, in J.
    energy: f64,
    first: f64,
    spent: f64,
    readings: u32,
    hour: Option<IncomeOfTime>,
}

impl Difference {
    pub(super) fn new(node: VoltageNode<1>) -> Self {
        Self(node)
    }

    /// The energy of a voltage in V.
    fn energy(&self, voltage: f64) -> f64 {
        0.5 * f64::from(self.0.parameters().storage.capacitor.capacitance) * voltage * voltage
    }

    fn close(&self, state: &mut State) {
        let VoltageParameters { storage, converter, standing_power, tolerances, .. } = self.0.parameters();
        let seconds = state.second - state.began;
        let drawn = f64::from(*standing_power) * f64::from(seconds);
        let income = state.energy - state.first + drawn + state.spent;
        // Two readings with noise and rounding, the standing power, the capacitance.
        let cell = f64::from(converter.full_scale) / f64::from(1_u32 << converter.bits);
        let of_voltage = f64::from(converter.noise).powi(2) + cell * cell / 12.0;
        let of_readings =
            2.0 * f64::from(storage.capacitor.capacitance) * (state.energy + state.first) * of_voltage;
        let of_draw = f64::from(tolerances.standing) * drawn;
        let of_capacitance = f64::from(tolerances.capacitance) * (state.energy - state.first);
        let bound = 2.5 * (of_readings + of_draw.powi(2) + of_capacitance.powi(2)).sqrt();
        let (energy, bound) = (income.max(0.0) as f32, bound as f32);
        state.hour = Some(IncomeOfTime { seconds, energy, bound, silent: 0 });
        (state.began, state.first, state.spent) = (state.second, state.energy, 0.0);
    }
}

impl Strategy for Difference {
    type State = State;

    fn begin(&self) -> State {
        State::default()
    }

    fn call(&self, state: &mut State, now: u32, code: Option<u32>) -> Wake {
        let VoltageParameters { storage, converter, reading, reserve, actions: [action], .. } =
            self.0.parameters();
        state.second = now;
        if let Some(code) = code {
            let cell = f64::from(converter.full_scale) / f64::from(1_u32 << converter.bits);
            state.energy = self.energy(f64::from(code) * cell);
            if state.readings == 0 {
                state.first = state.energy;
            }
            (state.read, state.readings) = (now, state.readings + 1);
            if now - state.began >= 3600 {
                self.close(state);
            }
            state.spent += f64::from(*reading);
        }
        let due = (state.read + EVERY).saturating_sub(now).max(1);
        let energy = f64::from(action.energy);
        let least = self.energy(storage.lock_out_voltage.into()) + f64::from(*reserve);
        if state.energy - energy <= least {
            return Wake { task: Task::Sleep, again_in: due, read: true };
        }
        let rested = now - state.ran;
        if rested < action.every && state.ran > 0 {
            let again_in = due.min(action.every - rested);
            return Wake { task: Task::Sleep, again_in, read: again_in == due };
        }
        (state.ran, state.energy, state.spent) = (now, state.energy - energy, state.spent + energy);
        Wake { task: Task::Run(0), again_in: 0, read: false }
    }

    fn after_lock_out(&self, state: &mut State, now: u32, code: u32) -> Wake {
        self.call(state, now, Some(code))
    }

    fn last_hour(state: &State) -> Option<IncomeOfTime> {
        state.hour
    }

    fn spent(&self, state: &State) -> f64 {
        f64::from(state.readings) * f64::from(self.0.parameters().reading)
    }

    fn facts(&self) -> Facts {
        self.0.facts()
    }
}
