//! Readings that are compared and not taken in: a few integers decide that nothing is to be done.
//!
//! A node that is given what a comparison costs ([`Node::with_glances`]) reads the voltage at each wake. A *glance* is a
//! reading after which nothing is to be done: the storage is as full, or as little full, as before, no action has become
//! affordable that was not granted before, and neither an hour, a listen nor a reading is due. The filter stays where it
//! is, and the last glance is kept beside it. Where a later reading finds that the storage may be full, that glance is taken
//! in at its own time, so that the income up to there is known.
//!
//! What leaves the storage is counted in codes. A drop of the energy by `o` from a voltage of at most `V₁` to one of at least
//! `V₀` is one of the voltage by at most `2 o/(C (V₀ + V₁))` if it begins at `V₁`, and by at most `o/(C V₀)` anywhere.

use super::filter::Filter;
use super::parameters::NodeParameters;
use super::{HOUR, Node, NodeState, Regular, Task, Wake, real};
use crate::bounds::{Bounds, ParameterError};
use crate::energy::Storage;
use crate::energy::response_map::Words;
use crate::scalar::Scalar;
use crate::snapshot::snapshot_fields;

/// Parts of a code in which what leaves the storage is counted.
const PARTS: f32 = 65_536.0;
/// Seconds in which what the budget said about an action holds, for more energy if it granted it, for less if it refused it.
const VALID: u32 = 2 * HOUR;
/// Seconds after which the budget is asked again where there is a reading anyway.
const RENEWED: u32 = HOUR / 2;
/// Part of the share of the income for readings that glances may cost.
const GLANCES: f32 = 0.5;
/// Standard deviations of the standing power above the stated one that may leave the storage.
const DEVIATIONS: f32 = 3.0;

/// Change, relative, of the voltage at which a storage is full, from one time to the next.
const FULL_DRIFT: f32 = 2e-3;

/// Codes of the storage's voltage from which on something may be the case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Thresholds<const ACTIONS: usize> {
    /// From this code on the storage may be full: at the least, where it has been as high, and in any case.
    least_full: u32,
    full: u32,
    /// Codes below the highest one from which on it may be full again.
    below_top: u32,
    /// Largest drop of the code for an energy drawn, in 2⁻¹⁶ a joule: of a storage that was full, and of any.
    drop_of_full: f32,
    drop: f32,
    /// Largest drop of the code of a full storage in a second without actions, and without any draw, in 2⁻¹⁶.
    standing: u32,
    leaking: u32,
    /// The code from which on an action leaves the reserve in the storage, and that energy in J.
    affordable: [u32; ACTIONS],
    energy: [f32; ACTIONS],
}

impl<const ACTIONS: usize> Thresholds<ACTIONS> {
    pub(super) fn new(
        filter: &Filter<f32>,
        storage: &Storage<f32>,
        parameters: &NodeParameters<ACTIONS>,
    ) -> Self {
        let of = storage.parameters();
        let noise = filter.noise / filter.cell;
        let code = |voltage: f32| voltage / filter.cell;
        let (highest, lowest) =
            (of.highest_voltage, Scalar::max(of.lock_out_voltage, of.highest_voltage * (1.0 / 16.0)));
        let farads = of.capacitor.capacitance;
        let drop_of_full = 2.0 * PARTS * code(1.0) / (farads * (highest + lowest));
        let leaked = highest * highest / of.capacitor.leakage_resistance;
        let drawn = storage.drawn(filter.standing * (1.0 + DEVIATIONS * parameters.spread.standing));
        let actions = parameters.actions.each_ref();
        let affordable = actions.map(|regular: &Regular| {
            let energy = storage.lock_out() + storage.drawn(regular.energy + parameters.reserve);
            let above = 1.5 + DEVIATIONS * noise;
            (code(storage.voltage(energy)) + above).to_u32().saturating_add(1)
        });
        let below = 1.5 + 2.0 * noise;
        Self {
            least_full: Scalar::max(code(highest * (1.0 - parameters.spread.highest_voltage)) - below, 0.0)
                .to_u32(),
            full: Scalar::max(code(highest) - below, 0.0).to_u32(),
            below_top: (2.0 * below + FULL_DRIFT * code(highest)).to_u32(),
            drop_of_full,
            drop: PARTS * code(1.0) / (farads * lowest),
            standing: ((drawn + leaked) * drop_of_full).to_u32().saturating_add(1),
            leaking: (leaked * drop_of_full).to_u32().saturating_add(u32::from(leaked > 0.0)),
            affordable,
            energy: affordable.map(|code| storage.energy(real(code) * filter.cell)),
        }
    }
}

/// What a node keeps of its last code and of its plans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Glances<const ACTIONS: usize> {
    /// The last code and its second.
    pub(super) second: u32,
    pub(super) code: u32,
    /// The highest code that two readings in turn have reached, less one for each hour since.
    top: u32,
    /// Largest drop of the code in 2⁻¹⁶ by what was spent since: after that second, at the slope of a full storage, and in
    /// all, at the steepest.
    later: u32,
    paid: u32,
    /// Whether the storage may have been full before the last code that was taken in or doubted.
    pub(super) was_full: bool,
    /// Whether the last code is that of a glance, and the energy in J spent between the filter's time and it.
    is_open: bool,
    spent: f32,
    /// Glances that are not yet booked.
    count: u32,
    /// Seconds between glances; when the next reading and the next listen are due.
    pub(super) interval: u32,
    reading: u32,
    listen: u32,
    /// When the budget was asked about an action, the lowest code at which it granted, and the highest at which it refused.
    asked: [u32; ACTIONS],
    granted: [u32; ACTIONS],
    refused: [u32; ACTIONS],
}

impl<const ACTIONS: usize> Glances<ACTIONS> {
    pub(super) fn new(second: u32) -> Self {
        Self {
            second,
            code: 0,
            top: 0,
            later: 0,
            paid: 0,
            was_full: false,
            is_open: false,
            spent: 0.0,
            count: 0,
            interval: 1,
            reading: second,
            listen: second,
            asked: [second; ACTIONS],
            granted: [u32::MAX; ACTIONS],
            refused: [0; ACTIONS],
        }
    }

    /// A code was read.
    pub(super) fn see(&mut self, second: u32, code: u32) {
        // One reading alone may be a glitch.
        self.top = self.top.max(code.min(self.code));
        (self.second, self.code, self.later, self.paid) = (second, code, 0, 0);
    }

    /// Where the storage is full may have changed.
    pub(super) fn close_hour(&mut self) {
        self.top = self.top.saturating_sub(1);
    }

    /// The code now, at least.
    fn least(&self) -> u32 {
        self.code.saturating_sub(self.paid >> 16)
    }

    /// Keeps what the budget said about an action at a code.
    fn asked(&mut self, index: usize, second: u32, code: u32, is_granted: bool) {
        let (Some(asked), Some(granted), Some(refused)) =
            (self.asked.get_mut(index), self.granted.get_mut(index), self.refused.get_mut(index))
        else {
            return;
        };
        if second.saturating_sub(*asked) >= RENEWED {
            (*asked, *granted, *refused) = (second, u32::MAX, 0);
        }
        if is_granted {
            *granted = code.min(*granted);
        } else {
            *refused = code.max(*refused);
        }
    }
}

/// What a glance says about an action.
enum Verdict {
    Wait,
    Run,
    Ask,
}

impl<W: Words, const M: usize, const P: usize, const SLOTS: usize, const ACTIONS: usize>
    Node<W, M, P, SLOTS, ACTIONS>
{
    /// The node with glances at the storage: at each wake it asks for the voltage, and where nothing is to be done it compares
    /// the code and leaves it at that, at a cost of `energy` in J at the load, 0 to 10: the converter, the wake-up and some
    /// 500 instructions.
    ///
    /// Half of [`KnowingCost::reading_share`](super::KnowingCost::reading_share) is then for glances.
    ///
    /// # Errors
    /// An energy outside its bounds.
    pub fn with_glances(mut self, energy: f32) -> Result<Self, ParameterError<f32>> {
        Bounds::new(0.0, 10.0).check("glance", energy)?;
        self.glance = Some(energy);
        Ok(self)
    }

    /// Energy of a glance in J at the load; `None` without glances.
    #[must_use]
    pub fn glance(&self) -> Option<f32> {
        self.glance
    }

    /// Whether the storage may have been full since the last code, or is at this one.
    ///
    /// Where it is full is known to [`Spread::highest_voltage`](super::Spread::highest_voltage) only, and where it has not
    /// been higher before it may be full there.
    pub(super) fn may_be_full(&self, state: &NodeState<P, SLOTS, ACTIONS>, now: u32, code: u32) -> bool {
        let Thresholds { least_full, full, below_top, standing, .. } = self.thresholds;
        let full = state.glances.top.saturating_sub(below_top).max(least_full).min(full);
        let seconds = now.saturating_sub(state.glances.second);
        let left = standing.saturating_mul(seconds).saturating_add(state.glances.later);
        code.saturating_add(left >> 16).saturating_add(1) >= full
    }

    /// Books a time from the last call to `now` in which nothing is drawn.
    pub(super) fn be_off(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, now: u32) {
        let Thresholds { standing, leaking, .. } = self.thresholds;
        let glances = &mut state.glances;
        let on = standing.saturating_mul(state.second.saturating_sub(glances.second));
        let off = leaking.saturating_mul(now.saturating_sub(state.second));
        glances.later = glances.later.saturating_add(on).saturating_add(off);
        glances.second = glances.second.max(now);
    }

    /// Books energy that left the storage after the last code.
    pub(super) fn pay(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, energy: f32) {
        let drawn = self.budget.storage().drawn(energy);
        let glances = &mut state.glances;
        glances.paid = glances.paid.saturating_add((drawn * self.thresholds.drop).to_u32());
        // What was spent at a code left before the storage could fill up again.
        if glances.second != state.second {
            let later = (drawn * self.thresholds.drop_of_full).to_u32().saturating_add(1);
            glances.later = glances.later.saturating_add(later);
        }
    }

    /// Looks at the storage; `None` if there is more to do than that.
    pub(super) fn look(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        now: u32,
        code: Option<u32>,
    ) -> Option<Wake> {
        self.glance?;
        let now = now.max(state.second);
        let is_known = state.filter.is_located() && !state.filter.is_doubted();
        let is_over = now.saturating_sub(state.hour_start) >= HOUR;
        let plans = &state.glances;
        if !is_known || is_over || state.listen.missing > 0 || now >= plans.reading || now >= plans.listen {
            return None;
        }
        match code {
            Some(code) => {
                let is_out = code == 0 || code >= self.filter.full_code;
                if is_out || self.may_be_full(state, now, code) != state.filter.was_full() {
                    return None;
                }
            }
            // After an action.
            None if now == plans.second => {}
            None => return None,
        }
        let least = code.unwrap_or_else(|| state.glances.least());
        let mut next = HOUR.saturating_sub(now.saturating_sub(state.hour_start));
        for (index, regular) in self.parameters.actions.iter().enumerate() {
            match self.verdict(state, [now, least], index, regular, &mut next) {
                Verdict::Wait => {}
                Verdict::Ask => return None,
                Verdict::Run => {
                    self.keep(state, now, code);
                    self.run(state, index, regular);
                    return Some(state.ask(Wake { task: Task::Run(index), again_in: 0, read: false }));
                }
            }
        }
        self.keep(state, now, code);
        let glances = &state.glances;
        let due = glances.reading.min(glances.listen).saturating_sub(now);
        let again_in = next.min(due).min(glances.interval).max(1);
        Some(state.ask(Wake { task: Task::Sleep, again_in, read: true }))
    }

    /// Whether an action waits, runs, or is to be asked about at the second `now` with at least a `code`; `next` is shortened
    /// to when it is due.
    fn verdict(
        &self,
        state: &NodeState<P, SLOTS, ACTIONS>,
        [now, code]: [u32; 2],
        index: usize,
        regular: &Regular,
        next: &mut u32,
    ) -> Verdict {
        let at = |of: &[u32; ACTIONS]| of.get(index).copied().unwrap_or(u32::MAX);
        let glances = &state.glances;
        if code < at(&self.thresholds.affordable) {
            return Verdict::Wait;
        }
        let since = now.saturating_sub(at(&state.last_run));
        if since < regular.every {
            *next = (*next).min(regular.every - since);
            return Verdict::Wait;
        }
        if now.saturating_sub(at(&glances.asked)) >= VALID {
            return Verdict::Ask;
        }
        let (granted, refused) = (at(&glances.granted), at(&glances.refused));
        // A forecast is not exact to an eighth of the energy between both.
        if code >= granted - (granted.saturating_sub(refused) >> 3) {
            Verdict::Run
        } else if refused > 0 {
            // The next reading asks again: with little energy each rise of the code would cost one.
            Verdict::Wait
        } else {
            Verdict::Ask
        }
    }

    /// Whether an action can run now.
    pub(super) fn can_run(
        &self,
        state: &mut NodeState<P, SLOTS, ACTIONS>,
        index: usize,
        regular: &Regular,
    ) -> bool {
        let is_granted = self.grants(&state.budget, regular);
        let code = state.glances.least();
        state.glances.asked(index, state.second, code, is_granted);
        is_granted
    }

    /// Asks the budget whether the least energy with which an action is affordable would do: then it is not asked about it
    /// for the next hours.
    pub(super) fn ask_beforehand(&self, state: &mut NodeState<P, SLOTS, ACTIONS>) {
        if self.glance.is_none() || !state.filter.is_located() {
            return;
        }
        let at_least = self.thresholds.affordable.iter().zip(&self.thresholds.energy);
        for (index, (regular, (&code, &energy))) in self.parameters.actions.iter().zip(at_least).enumerate() {
            let asked = state.glances.asked.get(index).copied().unwrap_or(state.second);
            if state.second.saturating_sub(asked) >= RENEWED {
                let mut least = state.budget;
                self.budget.correct(&mut least, energy, 0.0);
                let is_granted = self.grants(&least, regular);
                state.glances.asked(index, state.second, code, is_granted);
            }
        }
    }

    /// Keeps a glance.
    fn keep(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, now: u32, code: Option<u32>) {
        state.second = now;
        if let Some(code) = code {
            state.glances.see(now, code);
            state.glances.count = state.glances.count.saturating_add(1);
            state.glances.is_open = true;
            state.glances.spent = state.spent;
        }
    }

    /// Books an action that is run now.
    pub(super) fn run(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, index: usize, regular: &Regular) {
        if let Some(last) = state.last_run.get_mut(index) {
            *last = state.second;
        }
        self.spend(state, regular.energy);
    }

    /// Books the glances, and takes in the last one where the storage has since become full, or no longer is. `code` is that
    /// of the reading at `now`.
    #[inline(never)]
    pub(super) fn settle(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, now: u32, code: Option<u32>) {
        let count = core::mem::replace(&mut state.glances.count, 0);
        let is_open = core::mem::replace(&mut state.glances.is_open, false);
        let was_full = state.filter.was_full();
        let turns = code.is_some_and(|code| self.may_be_full(state, now, code) != was_full);
        if is_open && turns {
            let Glances { second, code, spent, .. } = state.glances;
            let rest = state.spent - spent;
            state.spent = spent;
            self.advance(state, second, true);
            // The code now confirms it.
            state.filter.confirm();
            self.observe(state, code, was_full);
            state.spent += rest;
            self.spend_on_knowing(state, self.parameters.cost.reading);
        }
        if count > 0 {
            self.spend_on_knowing(state, real(count) * self.glance.unwrap_or(0.0));
        }
    }

    /// Plans the next reading, listen and glance.
    pub(super) fn plan(&self, state: &mut NodeState<P, SLOTS, ACTIONS>, reading: u32, listen: u32) {
        let Some(energy) = self.glance else { return };
        let now = state.second;
        let shortest = self.parameters.cost.shortest_reading;
        let power = GLANCES * self.parameters.cost.reading_share * state.usual_power();
        let interval = if power * real(HOUR) > energy { (energy / power).to_u32() } else { HOUR };
        let glances = &mut state.glances;
        glances.interval = interval.max(shortest).min(HOUR);
        (glances.reading, glances.listen) = (now.saturating_add(reading), now.saturating_add(listen));
    }

    /// Part of the share for readings that is left to those of the filter.
    pub(super) fn share_of_readings(&self) -> f32 {
        if self.glance.is_some() { 1.0 - GLANCES } else { 1.0 }
    }
}

snapshot_fields!(impl [const ACTIONS: usize] Glances<ACTIONS> {
    second, code, top, later, paid, was_full, is_open, spent, count, interval, reading, listen, asked, granted, refused,
});
