//! Estimates the harvested power of a sensor node, with a bound, at a cost of about 1 % of it.
//!
//! A firmware engineer writes a [`Board`] and generates a response map with the host's command `map`; [`Node`] does the rest. It
//! reads the voltage of the storage by the ADC. Now and then it *listens*: it takes a burst of acceleration samples and
//! looks up what they yield in the map. It estimates income and stored energy, and says which action may run. Nothing here
//! waits: each call does a bounded amount of work and says when it wants to be called again, so that a node is driven from
//! interrupts, from an executor, or by [`Runner`].
//!
//! The map must be made with the load that the harvester sees: a resistor for a matched converter, a bridge (`map --voltage`) for
//! a rectifier straight into the storage. `docs/node.md` has the choice, all parameters and a glossary; `examples/node.rs` is a
//! complete node.
//!
//! ```text
//! wake(second, code of the storage's voltage) → Wake { task, again_in, read }
//!     Task::Sleep             sleep for again_in seconds, then read the voltage if `read`, and wake
//!     Task::Listen            switch the sensor on, hand its samples to samples(), as the FIFO has them
//!     Task::Run(index)        carry the action out, and wake again
//! samples(&[i16]) → Progress::More(left) or Progress::Heard(what)
//! ```
//!
//! # What is known, and by what
//!
//! * A reading of the storage's voltage corrects the income since the last one. Below some size of the storage nothing else is
//!   needed, and the node wakes for a listen at its longest interval only.
//! * A *glance* is a reading that is only compared with thresholds, without an update of the estimate ([`Node::with_glances`]).
//! * A listen gives the power by the map. The ratio of the true to the modelled power, the *gain* of the map, is learnt where a listen
//!   finds the shaking of the listen before, and the storage has told its power in between.
//! * Between readings and listens the power is held, and its uncertainty grows as the listens have shown it to change.
//! * A full storage says nothing about the income ([`NodeState::store_tells`]), and the income is then that of the map times
//!   the gain learnt before.
//! * The standing power is learnt while the harvester rests, when nothing else moves the storage.
//!
//! Every income is told with a bound of two and a half standard deviations. The capacitance, the leakage and the efficiencies of the
//! storage are taken as exact: an income is as wrong as the capacitance. The highest voltage need not be exact
//! ([`Spread::highest_voltage`]).

mod board;
mod covariance;
mod decision;
mod filter;
mod gap;
mod glance;
mod heard;
mod hearing;
mod learning;
mod parameters;
#[cfg(test)]
mod plant_tests;
mod schedule;
mod state;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod textbook_tests;
mod tier;
mod voltage;
#[cfg(test)]
mod voltage_tests;

pub use board::{Board, Fault, Runner, SaveError, Step};
pub use filter::StoreReading;
pub use hearing::{Hearing, Modelled, Yield};
pub use parameters::{Converter, KnowingCost, NodeError, NodeParameters, Regular, Sensor, Spread};
pub use state::{IncomeOfTime, NodeState};
pub use tier::{Gap, Progress, Task, Tier, Wake};
pub use voltage::{Tolerances, VoltageNode, VoltageParameters, VoltageState};

use crate::energy::response_map::Words;
use crate::energy::{Action, Budget, Listening, ResponseMap};
use crate::excitation::LineBank;
use crate::scalar::Scalar;
use crate::snapshot::{Configuration, Fingerprint};
use filter::{Filter, Growth};
use glance::Thresholds;
use parameters::of_part;

/// A node: its map in `W`, a bank of sections of at most `M` samples and blocks of `P` sections, a day of `SLOTS` slots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node<W: Words, const M: usize, const P: usize, const SLOTS: usize, const ACTIONS: usize> {
    map: ResponseMap<W>,
    bank: LineBank<M, P>,
    budget: Budget<f32, SLOTS>,
    listening: Listening<f32>,
    filter: Filter<f32>,
    parameters: NodeParameters<ACTIONS>,
    /// A listen as an action.
    listen: Action<f32>,
    /// Samples in a listen without those of the start-up.
    samples: u32,
    /// Time of a listen in s, rounded up.
    duration: u32,
    thresholds: Thresholds<ACTIONS>,
    /// Energy of a glance in J.
    glance: Option<f32>,
}

/// Seconds in an hour.
const HOUR: u32 = 3600;

impl<W: Words, const M: usize, const P: usize, const SLOTS: usize, const ACTIONS: usize>
    Node<W, M, P, SLOTS, ACTIONS>
{
    /// A node that listens by `bank` and looks up in `map`.
    ///
    /// # Errors
    /// The first parameter outside its bounds, a sensor with another rate than that of the bank, or a map that has none of
    /// the frequencies of the bank.
    #[cold]
    #[inline(never)]
    pub fn new(
        map: ResponseMap<W>,
        bank: LineBank<M, P>,
        parameters: NodeParameters<ACTIONS>,
    ) -> Result<Self, NodeError> {
        parameters.check()?;
        parameters.check_rate(bank.rate())?;
        let budget = parameters.budget.build().map_err(of_part("budget"))?;
        if !bank.frequencies().any(|frequency| map.has_frequency(frequency)) {
            return Err(NodeError::Band { band: bank.band() });
        }
        let samples = bank.block() as u32 * parameters.sensor.blocks;
        let all = samples + parameters.sensor.start_up;
        let seconds = real(all) / parameters.sensor.rate;
        let NodeParameters { converter, spread, .. } = parameters;
        let codes = 1_u32 << converter.bits.min(16);
        let cell = converter.full_scale / real(codes);
        let standing = parameters.budget.standing_power;
        let standing_deviation = parameters.spread.standing * standing;
        let filter = Filter {
            storage: *budget.storage(),
            standing,
            standing_variance: standing_deviation * standing_deviation,
            draw_drift: standing_deviation * standing_deviation * (1.0 / filter::DRAW_MEMORY as f32),
            spent: parameters.spread.action,
            cell,
            noise: Scalar::max(converter.noise, Filter::least_noise(cell)),
            lasting: Filter::lasting_variance(converter.noise / cell),
            full_code: codes - 1,
            gain_variance: spread.gain * spread.gain,
            gain_drift: spread.gain_drift * spread.gain_drift * (1.0 / 3600.0),
            power: parameters.spread.power,
        };
        Ok(Self {
            listen: Action::new("listen", parameters.cost.listen, seconds)?,
            listening: parameters.listening.build().map_err(of_part("listening"))?,
            duration: seconds as u32 + 1,
            thresholds: Thresholds::new(&filter, budget.storage(), &parameters),
            glance: None,
            map,
            bank,
            budget,
            filter,
            parameters,
            samples,
        })
    }

    /// The budget.
    #[must_use]
    pub fn budget(&self) -> &Budget<f32, SLOTS> {
        &self.budget
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &NodeParameters<ACTIONS> {
        &self.parameters
    }

    /// Voltage of the storage in V for a map of charge; 0 for another one, which does not ask for it.
    fn voltage_of_map(&self, state: &NodeState<P, SLOTS, ACTIONS>) -> f32 {
        if !self.map.is_current() {
            return 0.0;
        }
        let storage = self.budget.storage();
        let energy = Scalar::min(Scalar::max(state.filter.store().mean, 0.0), storage.capacity());
        storage.voltage(energy)
    }

    /// The sensor starts anew: samples were lost if a listen has begun and is not complete. A reading that was asked for was not
    /// attempted.
    fn interrupt(&self, state: &mut NodeState<P, SLOTS, ACTIONS>) {
        state.asked_for = u32::MAX;
        if state.listen.missing == self.samples {
            // The sensor starts up again.
            state.listen.start_up = self.parameters.sensor.start_up;
        } else if state.listen.missing > 0 {
            self.samples_lost(state);
        }
    }

    /// Advances filter and budget to `now`; whether that is later than the last time.
    #[inline(never)]
    fn advance(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, now: u32, is_on: bool) -> bool {
        let seconds = now.saturating_sub(state.settled);
        if seconds == 0 {
            return false;
        }
        let growth = self.growth(state);
        self.advance_by(state, seconds, is_on, growth);
        state.second = state.second.max(state.settled);
        true
    }

    /// Advances filter and budget by some seconds.
    pub(super) fn advance_by(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        seconds: u32,
        is_on: bool,
        growth: Growth<f32>,
    ) {
        if !state.store_tells() {
            state.silent = state.silent.saturating_add(seconds);
        }
        let spent = core::mem::replace(&mut state.spent, 0.0);
        let relaxation = self.filter.predict(&mut state.filter, seconds, is_on, spent, growth);
        let harvested = state.filter.all().mean - state.booked;
        if is_on {
            let harvested = Scalar::max(harvested, 0.0);
            self.budget.update_over(&mut state.budget, seconds, &relaxation, harvested);
            state.booked += harvested;
        } else {
            self.budget.gap(&mut state.budget, seconds);
            state.booked += harvested;
        }
        state.settled += seconds;
    }

    /// Takes in a code at the time of the filter.
    #[inline(never)]
    fn observe(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, code: u32, is_full: bool) {
        let (reading, departure) = self.filter.observe(&mut state.filter, code, is_full);
        state.reading = Some(reading);
        state.departure = Scalar::max(state.departure, departure);
        state.last_reading = state.settled;
        state.readings = state.readings.saturating_add(1);
    }

    /// Takes in a reading of the voltage; closes the hour.
    #[inline(never)]
    fn read(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, code: Option<u32>, is_later: bool) {
        if let Some(code) = code {
            let before = state.last_reading.max(state.hour_start);
            let is_full = self.may_be_full(state, state.second, code)
                || (state.filter.is_doubted() && state.glances.was_full);
            state.glances.see(state.second, code);
            state.glances.was_full = is_full;
            let told = state.store_tells();
            self.observe(state, code, is_full);
            if told && state.reading == Some(StoreReading::Silent) {
                // It was full before this reading already.
                state.silent = state.silent.saturating_add(state.settled.saturating_sub(before));
            }
        } else if is_later && state.second >= state.asked_for {
            // The converter did not answer.
            state.filter.miss_confirmation();
            state.last_missing = state.second;
            self.spend_on_knowing(state, self.parameters.cost.reading);
        }
        let store = state.filter.store();
        if state.filter.is_located() && (is_later || code.is_some()) {
            // What was spent just now is not yet in the filter.
            let left = store.mean - self.budget.storage().drawn(state.spent);
            let energy = Scalar::min(Scalar::max(left, 0.0), self.budget.storage().capacity());
            self.budget.correct(&mut state.budget, energy, 3.0 * store.deviation());
        }
        if code.is_some() {
            self.spend_on_knowing(state, self.parameters.cost.reading);
        }
        // A listen may last beyond the hour: the next reading ends it.
        let is_over = state.second.saturating_sub(state.hour_start) >= HOUR;
        let is_answered = code.is_some() || state.last_missing == state.second;
        if is_over && is_answered && !state.filter.is_doubted() {
            state.close_hour(code.map_or(0.0, |code| self.filter.resolution(code)));
            state.glances.close_hour();
            self.ask_beforehand(state);
        }
    }

    /// Books energy that the node spends now, in J at the load.
    fn spend(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, energy: f32) {
        self.budget.spend(&mut state.budget, energy);
        state.spent += energy;
        self.pay(state, energy);
    }

    fn spend_on_knowing(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, energy: f32) {
        self.spend(state, energy);
        state.knowing.add(energy);
    }
}

impl<W: Words, const M: usize, const P: usize, const SLOTS: usize, const ACTIONS: usize> Tier
    for Node<W, M, P, SLOTS, ACTIONS>
{
    const BURSTS: bool = true;

    fn start(&self, second: u32) -> NodeState<P, SLOTS, ACTIONS> {
        NodeState::new(
            second,
            self.filter.start(),
            self.listening.start(),
            self.bank.start(),
            self.budget.start(second),
        )
    }

    fn second(state: &NodeState<P, SLOTS, ACTIONS>) -> u32 {
        state.second()
    }

    /// Cost: a step of the filter and of the budget, with a reading also a correction of both, and all of this twice where a
    /// glance is taken in before it; the decision on an action as [`Budget::can_run_now`].
    #[inline(never)]
    fn wake(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, now: u32, code: Option<u32>) -> Wake {
        let Some(now) = self.present(state, now) else {
            let wake = self.wake_after_unknown_gap(state, code);
            let read = Wake { task: Task::Sleep, again_in: 1, read: true };
            return if code.is_some() { wake } else { state.ask(read) };
        };
        if let Some(wake) = self.look(state, now, code) {
            return wake;
        }
        self.settle(state, now, code);
        let is_later = self.advance(state, now, true);
        self.read(state, code, is_later);
        self.decide(state)
    }

    #[cold]
    #[inline(never)]
    fn wake_after(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, gap: Gap, code: Option<u32>) -> Wake {
        match gap {
            Gap::OnUntil(now) if now == state.second() => {
                self.interrupt(state);
                self.wake(state, now, code)
            }
            Gap::OnUntil(now) => self.wake_after_reset(state, now, code),
            Gap::OffUntil(now) => self.return_from_gap(state, now, code, 0.0, false),
            Gap::LockedOutUntil(now) => self.wake_after_lost_calls(state, now, code),
            Gap::Unknown => self.wake_after_unknown_gap(state, code),
        }
    }

    /// Cost: that of [`LineBank::take`]; a look-up for each whole block.
    #[inline(never)]
    fn samples(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, samples: &[i16]) -> Progress {
        let voltage = self.voltage_of_map(state);
        let listen = &mut state.listen;
        if listen.missing == 0 {
            return Progress::Idle;
        }
        let skipped = (listen.start_up as usize).min(samples.len());
        listen.start_up -= skipped as u32;
        let valid = samples.get(skipped..).unwrap_or(&[]);
        let mut left = valid.get(..listen.missing as usize).unwrap_or(valid);
        let clipped = self.parameters.sensor.clipped;
        listen.blocks.is_damaged |= left.iter().any(|&sample| sample >= clipped || sample <= -clipped);
        while !left.is_empty() {
            let (taken, lines) = self.bank.take(&mut listen.bank, left);
            if taken == 0 {
                break;
            }
            listen.missing = listen.missing.saturating_sub(taken as u32);
            left = left.get(taken..).unwrap_or(&[]);
            if let Some(lines) = lines {
                listen.blocks.add(&self.map, &lines, voltage);
            }
        }
        if listen.missing == 0 {
            return Progress::Heard(self.conclude(state, voltage));
        }
        Progress::More(listen.start_up.saturating_add(listen.missing))
    }

    fn samples_lost(&self, state: &mut NodeState<P, SLOTS, ACTIONS>) {
        state.listen.blocks.is_damaged = true;
    }
}

/// A count as a number.
fn real(count: u32) -> f32 {
    f32::from_u32(count)
}

impl<W: Words, const M: usize, const P: usize, const SLOTS: usize, const ACTIONS: usize> Configuration
    for Node<W, M, P, SLOTS, ACTIONS>
{
    type State = NodeState<P, SLOTS, ACTIONS>;

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("node");
        fingerprint.numbers(&[self.map.fingerprint(), self.map.checksum()]);
        self.bank.identify(fingerprint);
        self.budget.storage().identify(fingerprint);
        // Energies, shares, intervals and uncertainties may change: what was learnt is still true.
        fingerprint.numbers(&[self.filter.cell]);
        fingerprint.numbers(&[self.filter.full_code]);
    }
}
