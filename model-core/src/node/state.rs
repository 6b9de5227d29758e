//! The state of a node, and what it tells.

use super::Wake;
use super::filter::{FilterState, StoreReading};
use super::glance::Glances;
use super::hearing::Blocks;
use super::parameters::{MOST_BLOCKS, MOST_START_UP};
use crate::energy::{BudgetState, ListeningState};
use crate::excitation::LineBankState;
use crate::scalar::{CompensatedSum, Scalar};
use crate::snapshot::{snapshot_fields, snapshot_variants};

/// Standard deviations in a bound. The shaking of machines jumps more often than a normal distribution has it: two would
/// hold for nine hours of ten.
pub(super) const BOUND: f32 = 2.5;

/// The state of a [`Node`](super::Node): all that it has learnt, and a listen that is under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeState<const P: usize, const SLOTS: usize, const ACTIONS: usize> {
    /// Second at the last wake. Seconds of the state are those of the clock and [`Self::ahead`], which never go back.
    pub(super) second: u32,
    /// Second up to which filter and budget have come.
    pub(super) settled: u32,
    /// Seconds by which the clock has gone back.
    pub(super) ahead: u32,
    pub(super) glances: Glances<ACTIONS>,
    pub(super) filter: FilterState<f32>,
    pub(super) listening: ListeningState<f32>,
    pub(super) budget: BudgetState<f32, SLOTS>,
    pub(super) listen: Listen<P>,
    pub(super) last_listen: u32,
    pub(super) last_reading: u32,
    /// Second of the last reading that was asked for and did not come.
    pub(super) last_missing: u32,
    /// Second for which the last wake asked for a reading; the largest number if it did not.
    pub(super) asked_for: u32,
    pub(super) last_run: [u32; ACTIONS],
    /// Listens with a value, listens without one since, and readings.
    pub(super) listens: u32,
    pub(super) misses: u32,
    pub(super) readings: u32,
    /// Modelled power in W: the part of it that lasts, and that of the last listen, 0 if that was in doubt.
    pub(super) last_modelled: f32,
    pub(super) last_heard: f32,
    /// Variance in W² of what changes within the time from listen to listen.
    pub(super) fluctuation: f32,
    /// Modelled powers in W of the two motions that the last whole listen found, 0 if it found other shaking.
    pub(super) last_motions: [f32; 2],
    /// Largest departure of a reading since the last listen, in standard deviations.
    pub(super) departure: f32,
    pub(super) reading: Option<StoreReading>,
    /// Energy in J spent since the last wake and not yet in the filter.
    pub(super) spent: f32,
    /// Energy in J spent on knowing.
    pub(super) knowing: CompensatedSum<f32>,
    /// Income in J that the budget has.
    pub(super) booked: f32,
    pub(super) started: u32,
    pub(super) hour_start: u32,
    pub(super) hour: Option<IncomeOfTime>,
    /// Seconds in which the storage told nothing: of this hour, and before.
    pub(super) silent: u32,
    pub(super) silent_before: u32,
}

/// A listen under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Listen<const P: usize> {
    pub(super) bank: LineBankState<P>,
    pub(super) blocks: Blocks,
    /// Samples of the start-up, and others, that are still missing.
    pub(super) start_up: u32,
    pub(super) missing: u32,
    /// Second at which it began.
    pub(super) started: u32,
}

/// The income of a time with its bound.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IncomeOfTime {
    /// Seconds.
    pub seconds: u32,
    /// Harvested energy in J, before the charging efficiency.
    pub energy: f32,
    /// Bound of its error in J: two and a half standard deviations.
    pub bound: f32,
    /// Seconds of them in which the storage told nothing, as it was full or its energy unknown: the income is then that of
    /// the map with the gain learnt before, and as wrong as that.
    pub silent: u32,
}

impl<const P: usize, const SLOTS: usize, const ACTIONS: usize> NodeState<P, SLOTS, ACTIONS> {
    pub(super) fn new(
        second: u32,
        filter: FilterState<f32>,
        listening: ListeningState<f32>,
        bank: LineBankState<P>,
        budget: BudgetState<f32, SLOTS>,
    ) -> Self {
        let listen = Listen { bank, blocks: Blocks::default(), start_up: 0, missing: 0, started: second };
        Self {
            second,
            settled: second,
            ahead: 0,
            glances: Glances::new(second),
            filter,
            listening,
            budget,
            listen,
            last_listen: second,
            last_reading: second,
            last_missing: second,
            asked_for: u32::MAX,
            last_run: [second; ACTIONS],
            listens: 0,
            misses: 0,
            readings: 0,
            last_modelled: 0.0,
            last_heard: 0.0,
            fluctuation: 0.0,
            last_motions: [0.0; 2],
            departure: 0.0,
            reading: None,
            spent: 0.0,
            knowing: CompensatedSum::default(),
            booked: 0.0,
            started: second,
            hour_start: second,
            hour: None,
            silent: 0,
            silent_before: 0,
        }
    }

    /// Seconds of the clock at the last wake.
    #[must_use]
    pub fn second(&self) -> u32 {
        self.second.wrapping_sub(self.ahead)
    }

    /// Seconds by which the clock has gone back since the start, in all. The node then went on from the new time as after a gap
    /// that no clock knows ([`Gap::Unknown`](super::Gap::Unknown)).
    #[must_use]
    pub fn clock_went_back(&self) -> u32 {
        self.ahead
    }

    /// The second of the state at a second of the clock.
    pub(super) fn second_of(&self, clock: u32) -> u32 {
        clock.wrapping_add(self.ahead)
    }

    /// The income of the last whole hour; of a longer time if the node was off at its end. `None` before the first.
    #[must_use]
    pub fn last_hour(&self) -> Option<IncomeOfTime> {
        self.hour
    }

    /// The income since the start.
    #[must_use]
    pub fn overall(&self) -> IncomeOfTime {
        let all = self.filter.all();
        IncomeOfTime {
            seconds: self.second.saturating_sub(self.started),
            energy: Scalar::max(all.mean, 0.0),
            bound: BOUND * all.deviation(),
            silent: self.silent_before.saturating_add(self.silent),
        }
    }

    /// Harvested power now, and its bound, in W.
    #[must_use]
    pub fn power(&self) -> [f32; 2] {
        let power = self.filter.power();
        [Scalar::max(power.mean, 0.0), BOUND * power.deviation()]
    }

    /// Ratio of the true power to that of the map, and its bound.
    #[must_use]
    pub fn gain(&self) -> [f32; 2] {
        let gain = self.filter.gain();
        [gain.mean, BOUND * gain.deviation()]
    }

    /// Excess of the standing power over the stated one, and its bound, in W.
    #[must_use]
    pub fn excess_draw(&self) -> [f32; 2] {
        let draw = self.filter.draw();
        [draw.mean, BOUND * draw.deviation()]
    }

    /// Stored energy and its bound in J.
    #[must_use]
    pub fn stored(&self) -> [f32; 2] {
        let store = self.filter.store();
        [Scalar::max(store.mean, 0.0), BOUND * store.deviation()]
    }

    /// Whether the storage tells the income: its energy is known, and it was not full at the last reading.
    #[must_use]
    pub fn store_tells(&self) -> bool {
        self.filter.is_located() && !self.filter.was_full()
    }

    /// What the last reading of the voltage was good for; `None` before the first.
    #[must_use]
    pub fn last_reading(&self) -> Option<StoreReading> {
        self.reading
    }

    /// Energy in J that was spent on knowing the income, at the load.
    #[must_use]
    pub fn spent_on_knowing(&self) -> f32 {
        self.knowing.value()
    }

    /// The energy at the load that was spent on knowing over the harvested energy since the start; infinite without income. Of
    /// what the storage gives to the load it is this part over both efficiencies of the storage.
    #[must_use]
    pub fn share_spent_on_knowing(&self) -> f32 {
        let income = self.filter.all().mean;
        if income > 0.0 { self.knowing.value() / income } else { f32::INFINITY }
    }

    /// Numbers of readings, and of listens with a value.
    #[must_use]
    pub fn instruments(&self) -> [u32; 2] {
        [self.readings, self.listens]
    }

    /// The state of the budget.
    #[must_use]
    pub fn budget(&self) -> &BudgetState<f32, SLOTS> {
        &self.budget
    }

    /// Whether the storage has told the power since the last listen: it tells, and was read.
    pub(super) fn has_told(&self) -> bool {
        self.store_tells() && self.last_reading > self.last_listen
    }

    /// The power in W by which shares of the income are counted: the mean, or the present one if it is larger.
    pub(super) fn usual_power(&self) -> f32 {
        Scalar::max(self.budget.mean_power(), self.filter.power().mean)
    }

    /// Second of the last reading, or of the last attempt at one.
    #[inline(always)]
    pub(super) fn last_attempt(&self) -> u32 {
        self.last_reading.max(self.last_missing)
    }

    /// Keeps whether a wake asks for a reading, and for when.
    pub(super) fn ask(&mut self, wake: Wake) -> Wake {
        self.asked_for = if wake.read { self.second.saturating_add(wake.again_in) } else { u32::MAX };
        wake
    }

    /// Begins a listen.
    pub(super) fn begin(&mut self, bank: LineBankState<P>, samples: u32, start_up: u32) {
        let blocks = Blocks::default();
        self.listen = Listen { bank, blocks, start_up, missing: samples, started: self.second };
    }

    /// Gives up a listen under way, and a reading that was asked for.
    pub(super) fn abandon(&mut self) {
        self.listen.missing = 0;
        self.asked_for = u32::MAX;
    }

    /// A listen gave a value.
    pub(super) fn heard(&mut self, lasting: f32, modelled: f32) {
        self.last_listen = self.second;
        self.listens = self.listens.saturating_add(1);
        self.misses = 0;
        self.departure = 0.0;
        (self.last_modelled, self.last_heard) = (lasting, modelled);
    }

    /// A listen gave none.
    pub(super) fn missed(&mut self) {
        self.last_listen = self.second;
        self.misses = self.misses.saturating_add(1);
        (self.departure, self.last_heard) = (0.0, 0.0);
    }

    /// Ends the hour, with the deviation in J of an income by the last reading: listens hear seconds of an hour, and an income
    /// that the storage does not resolve may have come between them.
    pub(super) fn close_hour(&mut self, resolution: f32) {
        let hour = self.filter.hour();
        let seconds = self.second.saturating_sub(self.hour_start);
        self.hour = Some(IncomeOfTime {
            seconds,
            energy: Scalar::max(hour.mean, 0.0),
            bound: BOUND * Scalar::max(hour.deviation(), resolution),
            silent: self.silent,
        });
        self.silent_before = self.silent_before.saturating_add(self.silent);
        self.silent = 0;
        self.hour_start = self.second;
        self.filter.close_hour();
    }
}

snapshot_fields!(impl [] IncomeOfTime { seconds, energy, bound, silent });

/// Most samples in a section of a bank.
const MOST_SAMPLES: u32 = 128;

snapshot_fields!(impl [const P: usize] Listen<P> { bank, blocks, start_up, missing, started } if |listen| {
    listen.start_up <= MOST_START_UP && listen.missing <= MOST_BLOCKS * MOST_SAMPLES * P as u32
});

snapshot_fields!(impl [const P: usize, const SLOTS: usize, const ACTIONS: usize] NodeState<P, SLOTS, ACTIONS> {
    second, settled, ahead, glances, filter, listening, budget, listen, last_listen, last_reading, last_missing, asked_for, last_run, listens, misses, readings,
    last_modelled, last_heard, fluctuation, last_motions, departure, reading, spent, knowing, booked, started, hour_start, hour, silent, silent_before,
} if |state| {
    let before = [state.last_listen, state.last_reading, state.last_missing, state.listen.started, state.hour_start];
    state.started <= state.hour_start
        && before.iter().chain(&state.last_run).all(|&second| second <= state.second)
        && [state.last_modelled, state.last_heard, state.fluctuation, state.departure, state.spent].iter().chain(&state.last_motions).all(|&number| number >= 0.0)
});

snapshot_variants!(StoreReading { Used, Jump, Silent, Refused });
