//! The node that takes bursts of acceleration samples where the voltage of its storage says nothing of the income.
//!
//! It is a [`VoltageNode`] with a response map. A burst gives the output power by the map; the ratio of the true to the predicted power,
//! the *gain* of the map, is learnt from the income between two readings where the storage's voltage resolves it. The map is used
//!
//! * while the storage is full: for what is shunted;
//! * where two readings resolve an hour worse than the map: the hour is then estimated by the map;
//! * for the power now.
//!
//! A burst is taken if it narrows the bound of the hour by more than it costs ([`Bursts::worth`]): with the walk `c` of the power in W² a
//! second, bursts each `T` leave an hour the deviation `T √(300 s c)`, of which the next one takes the part `T/3600 s`.
//! Where the readings do as well none is taken, but for one each [`Bursts::check`] that compares the map with the storage.

mod finding;
mod gain;
mod income;
mod parameters;
#[cfg(test)]
mod tests;

pub use finding::{Finding, OutputPower, PredictedPower};
pub use parameters::{Bursts, MapParameters, NodeError, Sensor};

use super::tier::{ActionStatus, BOUND, IncomeOfTime, PowerSource, Status, StoreReading};
use super::voltage::{BatteryElement, CapacitorElement, Element};
use super::voltage::{Beside, VoltageEstimate};
use super::{HOUR, Outage, Progress, Task, Tier, VoltageNode, VoltageParameters, VoltageState, Wake, real};
use crate::bounds::ParameterError;
use crate::energy::response_map::WordSource;
use crate::energy::{Battery, ResponseMap};
use crate::excitation::{LineBank, LineBankState};
use crate::scalar::Scalar;
use crate::snapshot::{Configuration, Fingerprint, Reader, Snapshot, Writer, snapshot_fields};
use finding::{Blocks, Motion};
use gain::CONTRADICTIONS;
use income::{LatestPower, PredictedEnergy, least_change};

/// Seconds after its end at which a burst that is not complete is given up.
const GRACE: u32 = 2;
/// Doublings of the shortest time between bursts without a value.
const MOST_DOUBLINGS: u32 = 6;

/// Relative standard deviation of the gain above which it is learnt while the storage fills up.
const UNCERTAIN: f32 = 0.1;

/// A node with its map in `W`, and a bank of sections of at most `M` samples and blocks of `P` sections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapNode<
    W: WordSource,
    const M: usize,
    const P: usize,
    const ACTIONS: usize,
    E: Element = CapacitorElement,
> {
    voltage: VoltageNode<ACTIONS, E>,
    map: ResponseMap<W>,
    bank: LineBank<M, P>,
    parameters: MapParameters<ACTIONS>,
    /// Samples in a burst without those of the start-up.
    samples: u32,
    /// Time of a burst in s, rounded up, and [`GRACE`].
    longest: u32,
    /// Variances: of the standing power in W², of the gain at most, and by how much that grows in a second; the least mean square of a change of
    /// the power in W² a second.
    of_standing: f32,
    most_of_gain: f32,
    drift: f32,
    least_change: f32,
}

/// The state of a [`MapNode`]: all that it has learnt, and a burst that is under way.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MapState<const P: usize, const ACTIONS: usize> {
    voltage: VoltageState<ACTIONS>,
    burst: Burst<P>,
    latest: LatestPower,
    /// Predicted energy since the last reading that was used, and since the start of the hour.
    interval: PredictedEnergy,
    hour: PredictedEnergy,
    /// Gain of the map, its variance, and twice the comparisons in turn that contradict it, with 1 more where they are below it.
    gain: f32,
    of_gain: f32,
    contradictions: u32,
    is_doubtful: bool,
    /// Variance of the standing power in W².
    of_draw: f32,
    /// Whether the last burst found no vibration.
    is_rest: bool,
    /// Estimates by the voltage in the last two intervals that were used in turn, the newest first, and the seconds since.
    estimated: [Option<VoltageEstimate>; 2],
    unreported: u32,
    /// Whether the last burst was taken between these two.
    is_between: bool,
    /// Which of two motions goes on, as long as bursts find two.
    motion: Option<Motion>,
    /// Seconds since the last burst; bursts, and those in turn without a value.
    since: u32,
    bursts: u32,
    misses: u32,
    is_asked: bool,
    last_hour: Option<IncomeOfTime>,
}

/// A burst under way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Burst<const P: usize> {
    bank: LineBankState<P>,
    blocks: Blocks,
    /// Samples of the start-up, and others, that are still missing.
    start_up: u32,
    missing: u32,
}

/// It is not in an image, which is of half the size then: after a reset it has no value.
impl<const P: usize> Snapshot for Burst<P> {
    const BYTES: usize = 0;

    fn write(&self, _: &mut Writer<'_>) {}

    fn read(_: &mut Reader<'_>) -> Self {
        Self::default()
    }
}

snapshot_fields!(impl [const P: usize, const ACTIONS: usize] MapState<P, ACTIONS> {
    voltage, burst, latest, interval, hour, gain, of_gain, contradictions, is_doubtful, of_draw, is_rest, estimated, unreported, is_between, motion, since, bursts, misses, is_asked,
    last_hour,
} if |state| {
    state.gain >= 0.0 && state.of_gain >= 0.0 && state.of_draw >= 0.0 && state.contradictions < 2 * CONTRADICTIONS
});

impl<const P: usize, const ACTIONS: usize> MapState<P, ACTIONS> {
    /// What is known by the voltage alone.
    #[must_use]
    pub fn voltage(&self) -> &VoltageState<ACTIONS> {
        &self.voltage
    }

    /// The income of the last hour, by voltage or map, whichever has the smaller bound; of a longer time if the storage could not
    /// be read at its end. `None` before the first.
    #[must_use]
    pub fn last_hour(&self) -> Option<IncomeOfTime> {
        self.last_hour
    }

    /// Ratio of the true output power to that of the map, and its bound.
    #[must_use]
    pub fn gain(&self) -> [f32; 2] {
        [self.gain, BOUND * Scalar::sqrt(self.of_gain)]
    }

    /// Whether the last comparisons with the storage have contradicted the gain that was known: the harvester has changed, and
    /// [`Self::gain`] is learnt anew.
    #[must_use]
    pub fn is_map_doubtful(&self) -> bool {
        self.is_doubtful
    }

    /// Number of bursts.
    #[must_use]
    pub fn bursts(&self) -> u32 {
        self.bursts
    }

    /// Asks for a burst after the next reading, whatever it is worth: for the power now in [`Tier::status`].
    pub fn ask_for_burst(&mut self) {
        self.is_asked = true;
    }
}

impl<W: WordSource, const M: usize, const P: usize, const ACTIONS: usize> MapNode<W, M, P, ACTIONS> {
    /// A node that takes bursts by `bank` and looks up in `map`.
    ///
    /// # Errors
    /// The first parameter outside its bounds, a sensor with another rate than that of the bank, or a map that has none of
    /// the frequencies of the bank.
    pub const fn new(
        map: ResponseMap<W>,
        bank: LineBank<M, P>,
        parameters: MapParameters<ACTIONS>,
    ) -> Result<Self, NodeError> {
        Self::of_voltage(map, bank, parameters, parameters.voltage.build())
    }
}

impl<W: WordSource, const M: usize, const P: usize, const ACTIONS: usize>
    MapNode<W, M, P, ACTIONS, BatteryElement>
{
    /// As [`MapNode::new`], with a battery beside the capacitor.
    ///
    /// # Errors
    /// As [`MapNode::new`].
    pub const fn with_battery(
        map: ResponseMap<W>,
        bank: LineBank<M, P>,
        parameters: MapParameters<ACTIONS>,
        battery: Battery,
    ) -> Result<Self, NodeError> {
        Self::of_voltage(map, bank, parameters, parameters.voltage.build_with_battery(battery))
    }
}

impl<W: WordSource, const M: usize, const P: usize, const ACTIONS: usize, E: Element>
    MapNode<W, M, P, ACTIONS, E>
{
    const fn of_voltage(
        map: ResponseMap<W>,
        bank: LineBank<M, P>,
        parameters: MapParameters<ACTIONS>,
        voltage: Result<VoltageNode<ACTIONS, E>, ParameterError<f32>>,
    ) -> Result<Self, NodeError> {
        let voltage = match voltage {
            Ok(voltage) => voltage,
            Err(error) => return Err(NodeError::Parameter(error)),
        };
        if let Some(error) = parameters.first_outside() {
            return Err(NodeError::Parameter(error));
        }
        if let Some(error) = parameters.other_rate(bank.rate()) {
            return Err(NodeError::Bank(error));
        }
        let mut bin = 0;
        while !map.has_frequency(bank.bin_frequency(bin)) {
            bin = bin.wrapping_add(1);
            if bin == LineBank::<M, P>::BINS {
                return Err(NodeError::Band { band: bank.band() });
            }
        }
        let samples = (bank.block() as u32).saturating_mul(parameters.sensor.blocks);
        let all = samples.saturating_add(parameters.sensor.start_up);
        let longest = ((all as f32 / parameters.sensor.rate) as u32).saturating_add(1 + GRACE);
        let MapParameters { gain, gain_drift, voltage: VoltageParameters { largest_power, .. }, .. } =
            parameters;
        let (of_standing, drift) = (voltage.of_standing(), gain_drift * gain_drift * (1.0 / 3600.0));
        let most_of_gain = if gain > 1.0 { gain * gain } else { 1.0 };
        let least_change = least_change(largest_power);
        Ok(Self {
            voltage,
            map,
            bank,
            parameters,
            samples,
            longest,
            of_standing,
            most_of_gain,
            drift,
            least_change,
        })
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &MapParameters<ACTIONS> {
        &self.parameters
    }

    /// The income since the start.
    #[must_use]
    pub fn overall(&self, state: &MapState<P, ACTIONS>) -> IncomeOfTime {
        self.voltage.overall(&state.voltage)
    }

    /// Energy in J at the load that readings and bursts took since the start.
    #[must_use]
    pub fn spent_on_estimation(&self, state: &MapState<P, ACTIONS>) -> f32 {
        self.voltage.spent_on_readings(&state.voltage) + real(state.bursts) * self.parameters.bursts.energy
    }

    /// Harvested power in W and its bound by the last burst; `None` where it has no value, or the voltage the smaller bound.
    fn power_by_map(&self, state: &MapState<P, ACTIONS>) -> Option<[f32; 2]> {
        let [_, by_voltage] = self.voltage.power(&state.voltage);
        let OutputPower { value, systematic, .. } = state.latest.output;
        let systematic = systematic * value * state.gain;
        let variance = state.gain * state.gain * state.latest.variance(self.least_change)
            + state.of_gain * value * value
            + systematic * systematic;
        let bound = BOUND * Scalar::sqrt(variance);
        let by_reading = state.voltage.last_reading() == Some(StoreReading::Used) && by_voltage <= bound;
        (state.latest.is_known && !by_reading).then_some([state.gain * value, bound])
    }

    /// A time passes.
    fn pass(&self, state: &mut MapState<P, ACTIONS>, seconds: u32) {
        state.latest.pass(seconds, [&mut state.interval, &mut state.hour]);
        state.since = state.since.saturating_add(seconds);
        let time = real(seconds);
        // In ten days it may change by its deviation.
        let of_draw = state.of_draw + self.of_standing * (1.0 / 864_000.0) * time;
        state.of_draw = Scalar::min(of_draw, self.of_standing);
        state.of_gain = Scalar::min(state.of_gain + self.drift * time, self.most_of_gain);
    }

    /// The state by the voltage, and what the map says of the income since the last reading, which leaves the deviation of the gain.
    fn beside<'a>(
        &'a self,
        state: &'a mut MapState<P, ACTIONS>,
        of_gain: &'a mut Option<f32>,
    ) -> (&'a mut VoltageState<ACTIONS>, impl FnOnce() -> Option<Beside>) {
        let MapState { voltage, interval, latest, gain, of_gain: square, .. } = state;
        let beside = move || {
            let interval = interval.is_known().then_some(interval)?;
            let gain = [*gain, *of_gain.insert(Scalar::sqrt(*square))];
            let [energy, variance, bound] = self.by_map(gain, latest, interval);
            let stored = self.voltage.stored_of(1.0);
            let variance = stored * stored * variance;
            Some(Beside { energy: stored * energy, variance, bound: stored * bound })
        };
        (voltage, beside)
    }

    /// The harvested energy of a time in J by the map, of the gain with its deviation, the variance of its error, and the bound of what is
    /// the same at all times.
    fn by_map(&self, [gain, of_gain]: [f32; 2], latest: &LatestPower, of: &PredictedEnergy) -> [f32; 3] {
        let lasting = of_gain * of.energy + gain * of.systematic;
        [gain * of.energy, gain * gain * of.variance(latest, self.least_change), BOUND * lasting]
    }

    /// Ends a wake with a reading: learns the gain, and estimates the hour if it is over. A reading that has asked for the deviation of the
    /// gain is silent: it teaches no other one.
    fn conclude(&self, state: &mut MapState<P, ACTIONS>, of_gain: Option<f32>) {
        if state.voltage.is_just_read() {
            if state.interval.seconds > 0 {
                self.keep_estimate(state);
            }
            state.interval = PredictedEnergy::default();
        }
        if state.voltage.seconds_of_hour() < state.hour.seconds {
            state.last_hour =
                state.voltage.last_hour().map(|estimated| self.combine(state, estimated, of_gain));
            state.hour = PredictedEnergy::default();
        }
    }

    /// The income of an hour as `estimated` by the voltage, or by the map if that has the smaller bound.
    fn combine(
        &self,
        state: &MapState<P, ACTIONS>,
        estimated: IncomeOfTime,
        of_gain: Option<f32>,
    ) -> IncomeOfTime {
        if !E::IS_FLAT && !state.hour.is_known() {
            return estimated;
        }
        let of_gain = of_gain.unwrap_or_else(|| Scalar::sqrt(state.of_gain));
        let [mut energy, variance, lasting] = self.by_map([state.gain, of_gain], &state.latest, &state.hour);
        let mut bound = BOUND * Scalar::sqrt(variance) + lasting;
        if E::IS_FLAT {
            // Where the map says nothing the power of before goes on, or any other one up to the largest.
            let unknown = real(state.hour.unknown);
            let most = self.parameters.voltage.largest_power * unknown;
            energy += Scalar::min(state.gain * state.latest.output.value * unknown, most);
            bound += most;
        }
        // Vibration that no burst has met is seen by the voltage.
        let is_in_doubt = Scalar::abs(energy - estimated.energy) > bound + estimated.bound;
        if bound < estimated.bound && !is_in_doubt {
            IncomeOfTime { energy, bound, ..estimated }
        } else {
            estimated
        }
    }

    /// Whether to take a burst now, after a reading.
    fn is_burst_due(&self, state: &MapState<P, ACTIONS>) -> bool {
        let Bursts { energy, worth, shortest, check } = self.parameters.bursts;
        if state.is_asked || state.since >= check {
            return true;
        }
        if state.since < shortest << state.misses.min(MOST_DOUBLINGS) {
            return false;
        }
        let of_gain = UNCERTAIN * state.gain;
        if state.since >= HOUR && state.of_gain > of_gain * of_gain && self.voltage.fills_up(&state.voltage) {
            // The voltage still resolves the power of a vibration that it will not resolve when the storage is full.
            return true;
        }
        let is_silent = state.voltage.last_reading() == Some(StoreReading::Silent);
        if !state.latest.is_known {
            return is_silent || self.voltage.is_mute(&state.voltage);
        }
        // By the walk of the power a burst narrows the bound by as much as it must after √(worth / walk), and √(worth · walk) is then
        // left of it beside what the gain leaves. The squares are compared: roots are dear without a division.
        let (hour, since) = (real(HOUR), real(state.since));
        let (worth, since) = (worth * energy * hour, since * since);
        let scale = BOUND * BOUND * (1.0 / 12.0) * hour;
        let walk = scale * state.gain * state.gain * state.latest.change(self.least_change);
        if is_silent || since * since * walk < worth * worth {
            return since * since * walk >= worth * worth;
        }
        let of_gain = BOUND * state.latest.output.value * hour;
        let (of_gain, of_walk) = (of_gain * of_gain * state.of_gain, worth * Scalar::sqrt(walk));
        let rest = self.voltage.square_of_bound(&state.voltage) - of_gain - of_walk;
        rest > 0.0 && 4.0 * of_gain * of_walk < rest * rest
    }

    /// What to do: what the voltage asks for, or a burst before it sleeps.
    fn with_burst(&self, state: &mut MapState<P, ACTIONS>, wake: Wake) -> Wake {
        let is_idle = matches!(wake.task, Task::Sleep) && wake.again_in > self.longest;
        let is_affordable = self.voltage.affords(&state.voltage, self.parameters.bursts.energy);
        let is_due = is_idle && state.voltage.is_just_read() && is_affordable && self.is_burst_due(state);
        if is_due { self.begin(state) } else { wake }
    }

    /// Begins a burst.
    fn begin(&self, state: &mut MapState<P, ACTIONS>) -> Wake {
        let start_up = self.parameters.sensor.start_up;
        state.burst = Burst { start_up, missing: self.samples, ..Burst::default() };
        (state.since, state.is_asked) = (0, false);
        state.bursts = state.bursts.saturating_add(1);
        self.voltage.spend(&mut state.voltage, self.parameters.bursts.energy);
        self.go_on(state, self.longest)
    }

    /// Asks for the samples that are missing, for `left` s.
    fn go_on(&self, state: &MapState<P, ACTIONS>, left: u32) -> Wake {
        let samples = state.burst.start_up.saturating_add(state.burst.missing);
        Wake { task: Task::Burst { samples }, again_in: left, read: false }
    }

    /// Voltage of the storage in V for a map of charge; 0 for another one, which does not ask for it.
    fn voltage_of_map(&self, state: &MapState<P, ACTIONS>) -> f32 {
        if self.map.is_current() { self.voltage.voltage(&state.voltage) } else { 0.0 }
    }

    /// Does a part of what a whole block asks for; whether there was one.
    #[inline(never)]
    fn evaluate_block(&self, burst: &mut Burst<P>, voltage: f32) -> bool {
        if self.bank.transform(&mut burst.bank) {
            return true;
        }
        let lines = self.bank.lines(&mut burst.bank);
        lines.inspect(|lines| burst.blocks.add(&self.map, lines, voltage)).is_some()
    }

    /// Does one of the three parts of what a whole burst asks for: the bins of its last block, their lines, what the burst says, which is given.
    #[inline(never)]
    fn evaluate(&self, state: &mut MapState<P, ACTIONS>) -> Option<Finding> {
        let voltage = self.voltage_of_map(state);
        let is_of_block = self.evaluate_block(&mut state.burst, voltage);
        (!is_of_block).then(|| self.take(state, voltage))
    }

    /// Takes in what a whole burst says.
    #[inline(never)]
    fn take(&self, state: &mut MapState<P, ACTIONS>, voltage: f32) -> Finding {
        let predicted = core::mem::take(&mut state.burst.blocks).predicted(&self.map, voltage);
        let (finding, output) = match predicted.finding {
            Finding::Line | Finding::Broadband | Finding::Rest => (predicted.finding, predicted.lower),
            Finding::TwoMotions => self.decide(state, &predicted),
            other => {
                self.miss(state);
                return other;
            }
        };
        state.is_rest = matches!(predicted.finding, Finding::Rest);
        if !matches!(predicted.finding, Finding::TwoMotions) {
            state.motion = None;
        }
        state.latest.update(output, [&mut state.interval, &mut state.hour]);
        (state.misses, state.is_between) = (0, state.unreported == 0);
        finding
    }

    /// Which of two motions goes on: the one of the burst before, or the one whose output power the voltage has resolved.
    fn decide(&self, state: &mut MapState<P, ACTIONS>, predicted: &PredictedPower) -> (Finding, OutputPower) {
        let estimated = state.estimated[0]
            .filter(|estimated| state.unreported == 0 && estimated.power > 0.0 && state.gain > 0.0);
        if let Some(VoltageEstimate { power, variance, .. }) = estimated {
            // The gain is a factor: the ratio of the expected to the estimated power counts, by (x − 1)/√x.
            let of_power = variance / (power * power);
            let departure = |of: &OutputPower| {
                let ratio = state.gain * of.value / power;
                let noise = of.noise / of.value;
                let variance = of_power
                    + state.of_gain / (state.gain * state.gain)
                    + of.systematic * of.systematic
                    + noise * noise;
                (ratio - 1.0) * (ratio - 1.0) / (ratio * variance)
            };
            state.motion = match [departure(&predicted.lower), departure(&predicted.upper)] {
                [lower, upper] if lower < 4.0 && upper > 16.0 => Some(Motion::Lower),
                [lower, upper] if upper < 4.0 && lower > 16.0 => Some(Motion::Upper),
                _ => state.motion,
            };
        }
        match state.motion {
            Some(Motion::Lower) => (Finding::TwoMotionsOneSeen, predicted.lower),
            Some(Motion::Upper) => (Finding::TwoMotionsOneSeen, predicted.upper),
            None => (Finding::TwoMotions, predicted.either()),
        }
    }

    /// The samples of a burst under way are lost.
    fn give_up(&self, state: &mut MapState<P, ACTIONS>) {
        state.burst = Burst::default();
        self.miss(state);
    }

    /// A burst has no value.
    fn miss(&self, state: &mut MapState<P, ACTIONS>) {
        state.misses = state.misses.saturating_add(1);
        state.motion = None;
        state.latest.miss();
    }
}

impl<W: WordSource, const M: usize, const P: usize, const ACTIONS: usize, E: Element> Tier
    for MapNode<W, M, P, ACTIONS, E>
{
    const BURSTS: bool = true;

    fn start(&self, second: u32) -> MapState<P, ACTIONS> {
        MapState {
            voltage: self.voltage.start(second),
            burst: Burst::default(),
            latest: LatestPower::default(),
            interval: PredictedEnergy::default(),
            hour: PredictedEnergy::default(),
            gain: 1.0,
            of_gain: self.parameters.gain * self.parameters.gain,
            contradictions: 0,
            is_doubtful: false,
            of_draw: self.of_standing,
            is_rest: false,
            estimated: [None; 2],
            unreported: 0,
            is_between: false,
            motion: None,
            since: 0,
            bursts: 0,
            misses: 0,
            is_asked: false,
            last_hour: None,
        }
    }

    fn second(state: &MapState<P, ACTIONS>) -> u32 {
        VoltageNode::<ACTIONS, E>::second(&state.voltage)
    }

    #[inline(never)]
    fn wake(&self, state: &mut MapState<P, ACTIONS>, now: u32, code: Option<u32>) -> Wake {
        let seconds = now.saturating_sub(Self::second(state));
        let is_late = now < Self::second(state) || seconds >= self.longest;
        if state.burst.missing > 0 && is_late {
            self.give_up(state);
        }
        let is_evaluated = state.burst.blocks.is_whole && self.evaluate(state).is_none();
        if is_evaluated || state.burst.missing > 0 {
            if code.is_some() {
                // It has no use before the end of the burst, and has cost a conversion.
                self.voltage.book_reading(&mut state.voltage);
            }
            let next = Wake { task: Task::Sleep, again_in: 0, read: code.is_some() };
            return if is_evaluated { next } else { self.go_on(state, self.longest.saturating_sub(seconds)) };
        }
        self.pass(state, seconds);
        let mut of_gain = None;
        let (voltage, beside) = self.beside(state, &mut of_gain);
        let wake = self.voltage.wake_with(voltage, now, code, beside);
        self.conclude(state, of_gain);
        self.with_burst(state, wake)
    }

    #[cold]
    #[inline(never)]
    fn wake_after(&self, state: &mut MapState<P, ACTIONS>, gap: Outage, code: Option<u32>) -> Wake {
        let before = Self::second(state);
        let seconds = gap.end().map_or(0, |now| now.saturating_sub(before));
        if seconds > 0 || gap == Outage::Unknown {
            // What the vibration was since is unknown.
            state.latest.miss();
        }
        self.pass(state, seconds);
        if state.burst.missing > 0 || state.burst.blocks.is_whole {
            self.give_up(state);
        }
        let mut of_gain = None;
        let (voltage, beside) = self.beside(state, &mut of_gain);
        let wake = self.voltage.wake_after_with(voltage, gap, code, beside);
        self.conclude(state, of_gain);
        self.with_burst(state, wake)
    }

    /// Cost: that of [`LineBank::take`], but for the end of the last block.
    #[inline(never)]
    fn samples(&self, state: &mut MapState<P, ACTIONS>, samples: &[i16]) -> Progress {
        if state.burst.blocks.is_whole {
            return Progress::Done(self.evaluate(state));
        }
        let voltage = self.voltage_of_map(state);
        let burst = &mut state.burst;
        if burst.missing == 0 {
            return Progress::Idle;
        }
        let skipped = (burst.start_up as usize).min(samples.len());
        burst.start_up = burst.start_up.saturating_sub(skipped as u32);
        let valid = samples.get(skipped..).unwrap_or(&[]);
        let left = valid.get(..burst.missing as usize).unwrap_or(valid);
        let clipped = self.parameters.sensor.clipped;
        burst.blocks.is_damaged |= left.iter().any(|&sample| sample >= clipped || sample <= -clipped);
        let taken = self.bank.sum(&mut burst.bank, left);
        if taken == 0 {
            // The block before these samples is full.
            self.evaluate_block(burst, voltage);
        }
        burst.missing = burst.missing.saturating_sub(taken as u32);
        burst.blocks.is_whole = burst.missing == 0;
        if burst.blocks.is_whole {
            return Progress::Done(None);
        }
        Progress::More(burst.start_up.saturating_add(burst.missing))
    }

    fn samples_lost(&self, state: &mut MapState<P, ACTIONS>) {
        state.burst.blocks.is_damaged = true;
    }

    fn status(&self, state: &MapState<P, ACTIONS>) -> Status {
        let status = self.voltage.status(&state.voltage);
        let Some([power, power_bound]) = self.power_by_map(state) else { return status };
        let (_, verdict) = self.voltage.outlook(&state.voltage, [power, power_bound]);
        let (power_age, source) = (state.latest.seconds, PowerSource::Map);
        Status { power, power_bound, power_age, source, verdict, ..status }
    }

    fn action(&self, state: &MapState<P, ACTIONS>, index: usize) -> Option<ActionStatus> {
        self.voltage.action(&state.voltage, index)
    }

    fn book(&self, state: &mut Self::State, energy: f32) -> Result<(), ParameterError<f32>> {
        self.voltage.book(&mut state.voltage, energy)
    }
}

impl<W: WordSource, const M: usize, const P: usize, const ACTIONS: usize, E: Element> Configuration
    for MapNode<W, M, P, ACTIONS, E>
{
    type State = MapState<P, ACTIONS>;

    /// Of map, bank and storage: what was learnt survives other intervals, energies and tolerances.
    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("map");
        fingerprint.numbers(&[self.map.fingerprint(), self.map.checksum()]);
        self.bank.identify(fingerprint);
        self.voltage.identify(fingerprint);
    }
}
