//! The node that knows its income by the voltage of its storage alone: no sensor, no map, no bursts.
//!
//! The income of a time is what the storage gained and what left it. With the stored energy `E`, the standing power `s`, the
//! energy `u` of actions and readings, the leakage `λ E`, and the efficiencies `η` of charging and `δ` of discharging,
//!
//! ```text
//! η income = E(end) − E(begin) + (s t + u)/δ + ∫ λ E dt.
//! ```
//!
//! A reading replaces `E`, because any income may have come since the one before; readings of one second average their noise. At
//! the end of an hour the node reads again at once while the noise is an eighth or more of what is uncertain of the hour.
//!
//! The errors of the standing power, the actions, the leakage, the capacitance, the efficiencies and the converter's reference are the same at all
//! times: they count by the whole energy that they are of, and no bound falls with time as if they averaged out.

mod beside;
mod capacitance;
mod element;
mod parameters;
#[cfg(test)]
pub(super) mod tests;

pub(super) use beside::{Beside, VoltageEstimate};
pub use capacitance::LearntCapacitance;
pub use element::{BatteryElement, CapacitorElement, Element};
pub use parameters::{Tolerances, VoltageParameters};

use super::tier::{ActionStatus, BOUND, IncomeOfTime, PowerSource, Status, StoreReading, Verdict};
use super::{HOUR, Outage, Regular, Task, Tier, Wake, real};
use crate::bounds::{Bounds, ParameterError};
use crate::scalar::Scalar;
use crate::snapshot::{Configuration, Fingerprint, snapshot_fields};

/// Most readings at the end of an hour.
const MOST_READINGS: u32 = 8;
/// Part of the variance of an hour below which the noise of its last reading needs no other one.
const NOISE_PART: f32 = 0.125;
/// Standard deviations beyond what is possible from which a reading must be confirmed.
const GATE: f32 = 6.0;
/// Relative error of the sums of ten years by rounding.
const ROUNDING: f32 = 1e-5;

/// A node that knows its income by the voltage of its storage, a capacitor or a battery. Energies are in J at the storage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VoltageNode<const ACTIONS: usize, E: Element = CapacitorElement> {
    parameters: VoltageParameters<ACTIONS>,
    element: E,
    full_code: u32,
    /// Variances of a reading over the square of the slope, of a capacitor in J over the energy: of one, and of what lasts.
    noise: f32,
    lasting: f32,
    /// Energy from which on the storage may be full, and at the lock-out.
    full: f32,
    lock_out: f32,
    /// Part of the energy that leaks in a second.
    leakage_rate: f32,
    drawn_per_used: f32,
    per_stored: f32,
    /// Standing power, and the largest income, in W.
    standing: f32,
    largest: f32,
    /// Relative variances: of all changes of the energy, and of the leakage.
    scale: f32,
    leakage: f32,
}

/// The energies of a time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Books {
    seconds: u32,
    silent: u32,
    /// The energy at its begin; the variances of that, and of what happened once.
    begin: f32,
    of_begin: f32,
    once: f32,
    /// What left the storage: by the standing power, by actions and readings, by leakage.
    standing: f32,
    spent: f32,
    leaked: f32,
    /// What a full storage is taken to have shunted, and how far that may be off.
    shunted: f32,
    doubt: f32,
}

snapshot_fields!(impl [] Books {
    seconds, silent, begin, of_begin, once, standing, spent, leaked, shunted, doubt,
} if |books| {
    books.of_begin >= 0.0 && books.once >= 0.0 && books.doubt >= 0.0
});

impl Books {
    /// Goes on to the end of another time, which began at the end of this one.
    fn add(&mut self, other: &Self) {
        self.seconds = self.seconds.saturating_add(other.seconds);
        self.silent = self.silent.saturating_add(other.silent);
        self.once += other.once;
        self.standing += other.standing;
        self.spent += other.spent;
        self.leaked += other.leaked;
        self.shunted += other.shunted;
        self.doubt += other.doubt;
    }
}

/// The state of a [`VoltageNode`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VoltageState<const ACTIONS: usize> {
    second: u32,
    /// The stored energy in J at the last reading that was used, its variance, and whether it is known.
    read: f32,
    variance: f32,
    is_located: bool,
    /// The code that the next reading must confirm, or 0.
    doubted: u32,
    reading: Option<StoreReading>,
    /// Seconds since that reading, and since the last attempt; what was drawn and leaked since, without an income, in J.
    since: u32,
    attempted: u32,
    out: f32,
    leaked: f32,
    /// The part of it in which the storage may have been full.
    drained: f32,
    /// Standing power above the stated one in W.
    excess: f32,
    /// Income in J of the last interval, its variance, and its seconds.
    income: f32,
    of_income: f32,
    over: u32,
    /// Seconds after which a reading was asked for; the largest number if none was.
    asked: u32,
    /// Readings in turn at the end of the hour.
    repeated: u32,
    readings: u32,
    /// Since the beginning of the hour, and since the start up to there.
    hour: Books,
    closed: Books,
    last_hour: Option<IncomeOfTime>,
    /// Seconds since each action.
    rested: [u32; ACTIONS],
}

snapshot_fields!(impl [const ACTIONS: usize] VoltageState<ACTIONS> {
    second, read, variance, is_located, doubted, reading, since, attempted, out, leaked, drained, excess, income, of_income, over, asked, repeated,
    readings, hour, closed, last_hour, rested,
} if |state| {
    state.variance >= 0.0 && state.of_income >= 0.0
});

impl<const ACTIONS: usize> VoltageState<ACTIONS> {
    /// The income of the last hour; of a longer time if the storage could not be read at its end. `None` before the first.
    #[must_use]
    pub fn last_hour(&self) -> Option<IncomeOfTime> {
        self.last_hour
    }

    /// Seconds since the start of the hour.
    pub(super) fn seconds_of_hour(&self) -> u32 {
        self.hour.seconds
    }

    /// Whether a reading of this second was used, or silent.
    pub(super) fn is_just_read(&self) -> bool {
        self.since == 0 && self.doubted == 0
    }

    /// The energy that is stored if there was no income since the last reading.
    fn energy(&self) -> f32 {
        self.read - self.out - self.leaked
    }

    /// A reading was used.
    fn begin_interval(&mut self, read: f32) {
        (self.read, self.out, self.leaked, self.drained, self.since) = (read, 0.0, 0.0, 0.0, 0);
    }

    /// What the last reading of the voltage was good for; `None` before the first.
    #[must_use]
    pub fn last_reading(&self) -> Option<StoreReading> {
        self.reading
    }

    /// Number of readings.
    #[must_use]
    pub fn readings(&self) -> u32 {
        self.readings
    }
}

impl<const ACTIONS: usize, E: Element> VoltageNode<ACTIONS, E> {
    /// The parameters.
    #[must_use]
    pub const fn parameters(&self) -> &VoltageParameters<ACTIONS> {
        &self.parameters
    }

    /// The income since the start.
    #[must_use]
    pub fn overall(&self, state: &VoltageState<ACTIONS>) -> IncomeOfTime {
        let mut all = state.closed;
        all.add(&state.hour);
        self.income(&all, state, self.uncertainty(&all, state))
    }

    /// Stored energy in J without the income since the last reading, and its bound.
    pub(super) fn stored(&self, state: &VoltageState<ACTIONS>) -> [f32; 2] {
        let variance = state.variance + self.lasting_error(state.read, state.out);
        [Scalar::max(state.energy(), 0.0), BOUND * Scalar::sqrt(variance)]
    }

    /// Harvested power in W between the last two readings, and its bound.
    pub(super) fn power(&self, state: &VoltageState<ACTIONS>) -> [f32; 2] {
        let VoltageEstimate { power, variance, .. } = self.estimated(state);
        [Scalar::max(power, 0.0), BOUND * Scalar::sqrt(variance)]
    }

    /// [`Status::endurance`] and [`Status::verdict`] by a harvested power in W and its bound.
    pub(super) fn outlook(&self, state: &VoltageState<ACTIONS>, power: [f32; 2]) -> (f32, Verdict) {
        let Tolerances { standing, leakage, .. } = self.parameters.tolerances;
        let [energy, bound] = self.stored(state);
        // It leaks less and less.
        let [drawn, leaking] = [self.standing + state.excess, self.leakage_rate * energy];
        let (out, of_out) = (drawn + leaking, BOUND * (standing * drawn + leakage * leaking));
        let [income, of_income] = power.map(|power| self.stored_of(power));
        let (change, either) = (income - out, of_income + of_out);
        if !state.is_located {
            return (0.0, Verdict::Open);
        }
        let spare = Scalar::max(energy - bound - self.lock_out, 0.0);
        let verdict = match change {
            _ if change > either => Verdict::LivesOn,
            _ if change < -either => Verdict::Fades,
            _ => Verdict::Open,
        };
        (spare / Scalar::max(out + of_out, f32::MIN_POSITIVE), verdict)
    }

    /// The variance of a change of the energy and of what left beside it, by what is off at all times.
    fn lasting_error(&self, change: f32, out: f32) -> f32 {
        let Tolerances { standing, action, .. } = self.parameters.tolerances;
        let of_out = Scalar::max(standing, action) * out;
        self.scale * change * change + of_out * of_out
    }

    /// Energy in J at the load that the readings took since the start.
    #[must_use]
    pub fn spent_on_readings(&self, state: &VoltageState<ACTIONS>) -> f32 {
        real(state.readings) * self.parameters.reading
    }

    /// The variance of the income of a time up to the last reading.
    fn uncertainty(&self, books: &Books, state: &VoltageState<ACTIONS>) -> f32 {
        let Tolerances { standing, action, .. } = self.parameters.tolerances;
        let change = state.read - books.begin;
        let [standing, spent] = [standing * books.standing, action * books.spent];
        let rounding = ROUNDING * (books.standing + books.spent + books.leaked);
        books.of_begin
            + books.once
            + state.variance
            + standing * standing
            + spent * spent
            + rounding * rounding
            + self.scale * change * change
            + self.leakage * books.leaked * books.leaked
    }

    /// The income of a time up to the last reading, of this variance.
    #[inline(never)]
    fn income(&self, books: &Books, state: &VoltageState<ACTIONS>, variance: f32) -> IncomeOfTime {
        let gone = books.standing + books.spent + books.leaked + books.shunted - state.out;
        let deviation = Scalar::sqrt(variance);
        let energy = self.per_stored * Scalar::max(state.read - books.begin + gone, 0.0);
        let of_charging = BOUND * self.parameters.tolerances.charging * energy;
        IncomeOfTime {
            seconds: books.seconds.saturating_sub(state.since),
            energy,
            bound: self.per_stored * (BOUND * deviation + books.doubt) + of_charging,
            silent: books.silent,
        }
    }

    /// Books energy in J at the load that is spent now.
    pub(super) fn spend(&self, state: &mut VoltageState<ACTIONS>, used: f32) {
        let drawn = self.drawn_per_used * used;
        state.out += drawn;
        state.hour.spent += drawn;
    }

    /// Books a reading.
    pub(super) fn book_reading(&self, state: &mut VoltageState<ACTIONS>) {
        state.readings = state.readings.saturating_add(1);
        self.spend(state, self.parameters.reading);
    }

    /// Advances the time to `now`. Of an interval in which the clock went back nothing is said.
    fn advance(&self, state: &mut VoltageState<ACTIONS>, now: u32, is_on: bool) -> u32 {
        let seconds = now.saturating_sub(state.second);
        if now < state.second {
            self.lose(state);
        }
        state.second = now;
        if seconds == 0 {
            return 0;
        }
        let aged = |age: u32| age.saturating_add(seconds);
        (state.since, state.attempted) = (aged(state.since), aged(state.attempted));
        (state.hour.seconds, state.rested) = (aged(state.hour.seconds), state.rested.map(aged));
        if !state.is_located {
            state.hour.silent = state.hour.silent.saturating_add(seconds);
            return seconds;
        }
        let time = real(seconds);
        let standing = if is_on { (self.standing + state.excess) * time } else { 0.0 };
        let ratio = Scalar::min(self.leakage_rate * time, 1.0);
        let energy = state.energy();
        state.leaked += ratio * (energy - 0.5 * (standing + ratio * energy));
        state.out += standing;
        state.hour.standing += standing;
        seconds
    }

    /// The stored energy is unknown: of the time since the last reading nothing is said.
    fn lose(&self, state: &mut VoltageState<ACTIONS>) {
        if core::mem::replace(&mut state.is_located, false) {
            state.hour.silent = state.hour.silent.saturating_add(state.since);
        }
    }

    /// Takes in a reading of the voltage. A storage that may be full asks `beside` for what else says something of the income since the last one.
    #[inline(never)]
    fn observe<B>(&self, state: &mut VoltageState<ACTIONS>, code: u32, beside: B)
    where
        B: FnOnce() -> Option<Beside>,
    {
        let code = code.min(self.full_code);
        let read = self.element.energy(code);
        let slope = self.element.square_of_slope(read);
        let noise = self.noise * slope;
        if !state.is_located && code > 0 {
            // What changed while it was unknown is no income.
            let jump = read - state.read + state.out;
            state.hour.begin += jump;
            state.closed.begin += jump;
            state.hour.once += state.variance + noise;
            (state.variance, state.is_located, state.reading) = (noise, true, Some(StoreReading::Silent));
            state.begin_interval(read);
            return;
        }
        let time = real(state.since);
        let (energy, ratio, most) = (state.energy(), self.leakage_rate * time, self.largest * time);
        let leaked = if ratio < 1.0 {
            // An income since the last reading has leaked for half of the time.
            state.leaked + 0.5 * ratio * (read - energy)
        } else {
            // By the trapezoid; the storage cannot leak more than it has.
            Scalar::min(0.5 * ratio * (state.read + read), state.read + most)
        };
        let (out, of_both) = (state.out + leaked, state.variance + noise);
        let income = read - state.read + out;
        // No income is below 0 or above the largest one, and what left may be twice what is booked.
        let beyond = Scalar::max(-income, income - most) - out;
        // The end of the converter may be a glitch too.
        let is_end = code == self.full_code && state.reading != Some(StoreReading::Silent);
        let is_possible = code > 0 && !is_end && (beyond <= 0.0 || beyond * beyond <= GATE * GATE * of_both);
        let is_confirmed = state.doubted > 0 && code.abs_diff(state.doubted) <= code / 64 + 2;
        if !is_possible && !is_confirmed {
            state.doubted = if state.doubted > 0 { 0 } else { code };
            state.reading = Some(StoreReading::Refused);
            return;
        }
        state.doubted = 0;
        state.reading = Some(StoreReading::Used);
        if !is_possible {
            state.hour.doubt += Scalar::max(beyond, 0.0);
        }
        if state.since == 0 {
            let part = state.variance / of_both;
            state.variance = Scalar::max(part * noise, self.lasting * slope);
            state.begin_interval(energy + part * (read - energy));
            return;
        }
        state.variance = noise;
        state.hour.leaked += leaked;
        let curved = leaked * Scalar::min(ratio, 12.0) * (1.0 / 12.0);
        state.hour.once += curved * curved;
        if code == self.full_code || read + out - state.drained >= self.full {
            let usual = state.income * time / real(state.over.max(1));
            let beside = beside().unwrap_or(Beside {
                energy: Scalar::min(usual, most),
                variance: 0.0,
                bound: f32::INFINITY,
            });
            let guess = Scalar::max(beside.energy, income);
            // No income was below what is stored now, or above the largest one.
            let doubt = Scalar::min(beside.bound, Scalar::max(most - income, 0.0));
            state.hour.shunted += guess - income;
            state.hour.doubt += doubt;
            state.hour.once += beside.variance;
            state.hour.silent = state.hour.silent.saturating_add(state.since);
            state.reading = Some(StoreReading::Silent);
            (state.income, state.of_income) = (guess, beside.variance + doubt * doubt);
        } else {
            let lasting = self.lasting_error(read - state.read, state.out);
            (state.income, state.of_income) = (income, of_both + lasting);
        }
        state.over = state.since;
        state.begin_interval(read);
    }

    /// Time from a reading to the next in s: half of that in which the storage fills up, within the intervals.
    fn interval(&self, state: &VoltageState<ACTIONS>) -> u32 {
        let [shortest, longest] = self.parameters.intervals;
        let room = (self.full - state.read) * real(state.over);
        if room >= 2.0 * state.income * real(longest) {
            return longest;
        }
        (room / (2.0 * state.income)).to_u32().max(shortest).min(longest)
    }

    /// Energy in J above the lock-out without income since the last reading, less than any before the first, and the square of its bound.
    fn spare(&self, state: &VoltageState<ACTIONS>) -> [f32; 2] {
        let above = state.energy() - self.lock_out;
        let variance = state.variance + self.scale * above * above;
        [if state.is_located { above } else { f32::NEG_INFINITY }, BOUND * BOUND * variance]
    }

    /// Whether an action leaves the reserve of what is spare, and by the bound of that no less than the lock-out.
    fn grants(&self, [above, square]: [f32; 2], action: &Regular) -> bool {
        let left = above - self.drawn_per_used * action.energy;
        left >= self.drawn_per_used * self.parameters.reserve && left * left >= square
    }

    /// What to do now; `is_read` is whether the voltage was read.
    #[inline(never)]
    fn decide(&self, state: &mut VoltageState<ACTIONS>, is_read: bool) -> Wake {
        let sleep = |again_in: u32, read| Wake { task: Task::Sleep, again_in, read };
        if state.doubted > 0 {
            return sleep(1, true);
        }
        if is_read && state.is_located && state.since == 0 && state.hour.seconds >= HOUR {
            let uncertain = self.uncertainty(&state.hour, state);
            let lasting = 2.0 * self.lasting * self.element.square_of_slope(state.read);
            let is_noisy = state.variance > Scalar::max(NOISE_PART * uncertain, lasting);
            if is_noisy && state.repeated < MOST_READINGS - 1 {
                state.repeated += 1;
                return sleep(0, true);
            }
            self.close_hour(state, uncertain);
        }
        let mut next = HOUR.saturating_sub(state.hour.seconds);
        let reading = self.interval(state).saturating_sub(state.attempted).max(1);
        if next == 0 {
            next = reading;
        }
        let spare = self.spare(state);
        for (index, action) in (0..ACTIONS).zip(&self.parameters.actions) {
            if !self.grants(spare, action) {
                continue;
            }
            let Some(rested) = state.rested.get_mut(index) else { continue };
            if *rested >= action.every {
                *rested = 0;
                self.spend(state, action.energy);
                return Wake { task: Task::Run(index), again_in: 0, read: false };
            }
            next = next.min(action.every - *rested);
        }
        let hour = HOUR.saturating_sub(state.hour.seconds);
        let again_in = next.min(reading);
        sleep(again_in, again_in == reading || again_in == hour)
    }

    fn close_hour(&self, state: &mut VoltageState<ACTIONS>, variance: f32) {
        state.last_hour = Some(self.income(&state.hour, state, variance));
        let (begin, of_begin) = (state.read - state.out, state.variance);
        let hour = core::mem::replace(&mut state.hour, Books { begin, of_begin, ..Books::default() });
        state.closed.add(&hour);
        state.repeated = 0;
    }

    /// Ends a time with a reading or without one, which `is_missing` if it was asked for.
    fn conclude(
        &self,
        state: &mut VoltageState<ACTIONS>,
        code: Option<u32>,
        is_missing: bool,
        beside: impl FnOnce() -> Option<Beside>,
    ) -> Wake {
        if let Some(code) = code {
            self.observe(state, code, beside);
        } else if is_missing {
            (state.doubted, state.reading) = (0, Some(StoreReading::Refused));
        }
        if code.is_some() || is_missing {
            state.attempted = 0;
            self.book_reading(state);
        }
        let wake = self.decide(state, code.is_some());
        state.asked = if wake.read { wake.again_in } else { u32::MAX };
        wake
    }

    /// Books that any energy up to what the node draws at most in so many seconds has left, as far as it was there.
    fn draw_at_most(&self, state: &mut VoltageState<ACTIONS>, seconds: u32, with_standing: bool) {
        let VoltageParameters { reading, intervals: [shortest, _], tolerances, actions, .. } =
            &self.parameters;
        let mut power = reading / real(*shortest);
        let mut once = 0.0;
        for action in actions {
            power += action.energy / real(action.every);
            // It may have been due at the beginning.
            once += action.energy;
        }
        power *= self.drawn_per_used;
        if with_standing {
            power += self.standing * (1.0 + BOUND * tolerances.standing);
        }
        let there = Scalar::max(state.energy() - self.lock_out, 0.0) + self.largest * real(seconds);
        // Each energy is as likely.
        let half = 0.5 * Scalar::min(power * real(seconds) + self.drawn_per_used * once, there);
        state.out += half;
        // It was at the lock-out after all that was drawn; of a node that went on, what it may have drawn says nothing.
        state.drained = if with_standing { state.out } else { half };
        state.hour.spent += half;
        state.hour.once += half * half * (1.0 / 3.0);
    }

    /// As [`Tier::wake`], with what else says something of the income since the last reading.
    pub(super) fn wake_with(
        &self,
        state: &mut VoltageState<ACTIONS>,
        now: u32,
        code: Option<u32>,
        beside: impl FnOnce() -> Option<Beside>,
    ) -> Wake {
        let seconds = self.advance(state, now, true);
        let is_missing = code.is_none() && seconds >= state.asked;
        self.conclude(state, code, is_missing, beside)
    }

    /// As [`Tier::wake_after`], with what else says something of the income since the last reading.
    pub(super) fn wake_after_with(
        &self,
        state: &mut VoltageState<ACTIONS>,
        gap: Outage,
        code: Option<u32>,
        beside: impl FnOnce() -> Option<Beside>,
    ) -> Wake {
        let (now, is_on) = (gap.end().unwrap_or(state.second), matches!(gap, Outage::OnUntil(_)));
        state.doubted = 0;
        if gap == Outage::Unknown {
            self.lose(state);
        }
        let seconds = self.advance(state, now, is_on);
        let is_off = matches!(gap, Outage::OffUntil(_));
        if state.is_located && seconds > 0 && !is_off {
            self.draw_at_most(state, seconds, !is_on);
        }
        self.conclude(state, code, false, beside)
    }
}

impl<const ACTIONS: usize, E: Element> Tier for VoltageNode<ACTIONS, E> {
    fn start(&self, second: u32) -> VoltageState<ACTIONS> {
        VoltageState {
            second,
            read: 0.0,
            variance: 0.0,
            is_located: false,
            doubted: 0,
            reading: None,
            since: 0,
            attempted: 0,
            out: 0.0,
            leaked: 0.0,
            drained: 0.0,
            excess: 0.0,
            income: 0.0,
            of_income: 0.0,
            over: 0,
            asked: u32::MAX,
            repeated: 0,
            readings: 0,
            hour: Books::default(),
            closed: Books::default(),
            last_hour: None,
            rested: [0; ACTIONS],
        }
    }

    fn second(state: &VoltageState<ACTIONS>) -> u32 {
        state.second
    }

    #[inline(never)]
    fn wake(&self, state: &mut VoltageState<ACTIONS>, now: u32, code: Option<u32>) -> Wake {
        self.wake_with(state, now, code, || None)
    }

    #[cold]
    #[inline(never)]
    fn wake_after(&self, state: &mut VoltageState<ACTIONS>, gap: Outage, code: Option<u32>) -> Wake {
        self.wake_after_with(state, gap, code, || None)
    }

    fn status(&self, state: &VoltageState<ACTIONS>) -> Status {
        let ([energy, bound], largest) = (self.stored(state), self.parameters.largest_power);
        let room = Scalar::max(self.full - self.lock_out, f32::MIN_POSITIVE);
        let is_used = state.is_located && state.reading == Some(StoreReading::Used);
        let (source, [power, power_bound]) = match (state.over, self.power(state)) {
            (0, _) => (PowerSource::Unknown, [0.0, largest]),
            (_, power) if is_used => (PowerSource::Voltage, power),
            (_, [power, _]) => (PowerSource::Assumed, [power, Scalar::max(power, largest - power)]),
        };
        let (endurance, verdict) = self.outlook(state, [power, power_bound]);
        Status {
            voltage: self.voltage(state),
            energy,
            energy_bound: if state.is_located { bound } else { f32::INFINITY },
            energy_age: state.since,
            room,
            charge: Scalar::min(Scalar::max((energy - self.lock_out) / room, 0.0), 1.0),
            power,
            power_bound,
            power_age: state.since,
            source,
            endurance,
            verdict,
        }
    }

    fn action(&self, state: &VoltageState<ACTIONS>, index: usize) -> Option<ActionStatus> {
        let (stated, rested) = (*self.parameters.actions.get(index)?, *state.rested.get(index)?);
        Some(ActionStatus { stated, rested, is_affordable: self.grants(self.spare(state), &stated) })
    }

    fn book(&self, state: &mut Self::State, energy: f32) -> Result<(), ParameterError<f32>> {
        Bounds::new(-1e6, 1e6).check("energy", energy)?;
        self.spend(state, energy);
        Ok(())
    }
}

impl<const ACTIONS: usize, E: Element> Configuration for VoltageNode<ACTIONS, E> {
    type State = VoltageState<ACTIONS>;

    /// Of the storage and its converter alone: what was learnt survives other intervals, energies and tolerances.
    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("voltage");
        let Self { element, full_code, leakage_rate, lock_out, .. } = *self;
        fingerprint.numbers(&[element.identity(), leakage_rate, lock_out]);
        fingerprint.numbers(&[full_code, ACTIONS as u32]);
    }
}
