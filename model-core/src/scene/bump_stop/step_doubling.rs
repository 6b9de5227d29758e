//! Checks the steps of a bump-stop run against steps of half the length, now and then.
//!
//! In a check each step of the run is taken in two halves too, from the state that the halves before it have reached. A check
//! lasts 16 periods of the first mode, or until both motions have come apart. The distances between checks are those of a
//! sequence of golden sections, so that a periodic motion is checked in all of its phases.

use super::Parts;
use super::checks::{Check, Checks, comes_apart, is_apart};
use super::choices::ContactOf;
use super::contact_law::{ContactKind, ContactLaw};
use super::state::{Start, StateOf};
use super::stepper::{LEAST_BUDGET, Pair, Stepper};
use crate::bounds::ParameterError;
use crate::clock::{Instant, TICKS_PER_SECOND};
use crate::excitation::Excitation;
use crate::hybrid::{Advance, Ended, StepError, Work};
use crate::observer::{AcceptedStep, Event, Observer, Outputs, PowerIndex};
use crate::scalar::Scalar;
use crate::scene::{Harvester, StepDoublingError};
use crate::snapshot::{Fingerprint, Snapshot, snapshot_fields};

/// Periods of the first mode in a check: at the usual damping of 0.01 a motion remembers an error for 16 periods.
const PERIODS: u32 = 16;
/// Smallest and largest mean time between checks, in lengths of a check.
const EVERY: [u32; 2] = [2, 1 << 16];
/// Most attempts to reach the end of a step of the run where two halves of it do not.
const MOST_CATCHING_UP: u32 = 128;

/// A bump-stop harvester that checks its steps: a [`Stepper`] with an estimate of its error ([`Checks`]).
///
/// The bits of the run are those of the stepper. The memory is that of two steppers and two states. With a
/// rigid contact ([`Restitution`](super::Restitution)) there are no checks, and no estimate.
///
/// ```
/// # use model_core::clock::Instant;
/// # use model_core::energy::PowerMeter;
/// # use model_core::excitation::Sine;
/// # use model_core::part::{load::Resistor, monomorph::Layer};
/// # use model_core::scene::Harvester;
/// # use model_core::scene::bump_stop::{Choices, Parameters, ResidualFlexibility, StepDoubling, Stepper, Stop};
/// # fn main() -> Result<(), model_core::Error> {
/// # let parameters = Parameters {
/// #     beam_length: 50e-3_f32,
/// #     beam_width: 10e-3,
/// #     substrate: Layer { thickness: 0.5e-3, young_modulus: 200e9, density: 7850.0 },
/// #     piezo: Layer { thickness: 0.5e-3, young_modulus: 66e9, density: 7800.0 },
/// #     piezo_d31: -190e-12,
/// #     piezo_permittivity: 15.93e-9,
/// #     damping_ratio: 0.01,
/// #     choices: Choices::new(Resistor { resistance: 1e5 }).stop(Stop {
/// #         length: 20e-3,
/// #         section: 4e-6,
/// #         young_modulus: 70e9,
/// #         density: 2700.0,
/// #         position: 50e-3,
/// #         gap: 30e-6,
/// #         contact_compliance: 0.0,
/// #         contact: ResidualFlexibility,
/// #     }),
/// # };
/// let scene = parameters.build::<4, 1>()?;
/// let excitation: Sine<f32> = Sine::new(10.0, 240.0, 0.0)?;
/// let mut steps = [26e-6, 360e-6]; // near contact and in flight, in s
/// for _ in 0..4 {
///     let [short, long] = steps;
///     let harvester = StepDoubling::new(Stepper::new(scene, short, long)?, 8);
///     let mut state = harvester.start(&Default::default(), &excitation)?;
///     let mut meter = PowerMeter::new();
///     harvester.advance(&mut state, &excitation, Instant::from_whole_seconds(2), u32::MAX, &mut meter)?;
///     let Some(error) = harvester.step_doubling_error(&state) else { continue };
///     if error.relative < 2e-3 {
///         break;
///     }
///     steps = steps.map(|step| step * error.step_factor(1e-3));
/// }
/// assert!(steps[0] < 20e-6);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepDoubling<S: Scalar, P: Parts<S>, const B: usize, const R: usize, const ALL: usize = 0> {
    stepper: Stepper<S, P, B, R, ALL>,
    /// Each step has half the ticks, rounded down.
    finer: Stepper<S, P, B, R>,
    /// Period of the first mode in ticks.
    period: u64,
    /// Mean time from the start of a check to that of the next, in lengths of a check.
    every: u32,
}

/// The state of a [`StepDoubling`]; `T` is that of its stepper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepDoublingState<S, T> {
    /// The state of the run.
    run: T,
    /// In a check: the state that the finer steps have reached.
    finer: T,
    /// In a check its end, else the start of the next one.
    next: Instant,
    checking: bool,
    /// Number of checks so far, modulo 2³².
    number: u32,
    /// In a check: energy delivered since its start, in J, and what the finer steps changed of it.
    energy: S,
    change: S,
    /// In a check: largest energy of the difference of both states in its first half, in J.
    middle: S,
    /// Number of whole periods of this check so far.
    periods: u32,
    checks: Checks<S>,
}

impl<S, T> StepDoublingState<S, T> {
    /// The state of the run, with the bits of a run of the stepper.
    #[must_use]
    pub fn run(&self) -> &T {
        &self.run
    }
}

/// The delivered energy of the steps it observes, in J.
#[derive(Debug)]
struct Delivered<S>(S);

impl<S: Scalar> Observer<S> for Delivered<S> {
    const READS_OUTPUTS: bool = false;
    const READS_POWERS: bool = false;

    #[inline]
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        self.0 += step.energy(PowerIndex::Load);
    }

    #[inline]
    fn event(&mut self, event: &Event<'_, S>) {
        self.0 += event.energies.first().copied().unwrap_or(S::ZERO);
    }
}

/// The state of a checked harvester with the components `P`.
type StepDoublingStateOf<S, P, const B: usize, const R: usize> = StepDoublingState<S, StateOf<S, P, B, R>>;

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize, const ALL: usize> StepDoubling<S, P, B, R, ALL> {
    /// Checks the steps of a stepper in a part `1/every` of the time, `every` from 2 to 65 536, else the nearest of these. A step
    /// that is checked costs some four steps: 64 adds 5 %, on average over a long run.
    #[must_use]
    #[inline]
    pub fn new(stepper: Stepper<S, P, B, R, ALL>, every: u32) -> Self {
        let halves = stepper.sets.each_ref().map(|set| (set.ticks / 2).max(1));
        let omega = stepper.scene().beam_angular_frequency(0).unwrap_or(S::ONE);
        let period = S::from_f64(core::f64::consts::TAU) / omega;
        let period = Instant::from_seconds(period).map_or(TICKS_PER_SECOND, Instant::ticks);
        let finer = Stepper::of_ticks(*stepper.scene(), halves);
        let [least, most] = EVERY;
        Self { stepper, finer, period, every: every.clamp(least, most) }
    }

    /// The stepper of the run.
    #[must_use]
    pub fn stepper(&self) -> &Stepper<S, P, B, R, ALL> {
        &self.stepper
    }

    /// What the checks so far have shown.
    #[must_use]
    pub fn checks<'a>(&self, state: &'a StepDoublingStateOf<S, P, B, R>) -> &'a Checks<S> {
        &state.checks
    }

    #[inline]
    fn state_of(&self, run: StateOf<S, P, B, R>) -> StepDoublingStateOf<S, P, B, R> {
        StepDoublingState {
            run,
            finer: run,
            next: run.clock,
            checking: false,
            number: 0,
            energy: S::ZERO,
            change: S::ZERO,
            middle: S::ZERO,
            periods: 0,
            checks: Checks::default(),
        }
    }

    /// The bits of the run are those of the stepper: it ends a step where a budget is spent, and a budget has no effect on them.
    #[inline]
    fn run<const CUT: bool, E: Excitation<S>, O: Observer<S>>(
        &self,
        state: &mut StepDoublingStateOf<S, P, B, R>,
        excitation: &E,
        until: Instant,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>> {
        let budget = budget.max(<Self as Harvester<S>>::LEAST_BUDGET);
        let mut work = Work::default();
        while state.run.clock < until {
            let left = budget.saturating_sub(work.attempts());
            if work.attempts() > 0 && left < <Self as Harvester<S>>::LEAST_BUDGET {
                return Ok(Advance { ended: Ended::BudgetSpent, work });
            }
            if !state.checking && state.run.clock >= state.next && self.is_checkable() {
                self.begin(state);
            }
            if state.checking {
                work = work.and(self.step_with_check::<CUT, E, O>(state, excitation, until, observer)?);
                continue;
            }
            // So many steps end before the next check, except within the last few of them.
            let steps = match self.is_checkable() {
                true => self.steps_until(state.run.clock, state.next),
                false => u32::MAX,
            };
            let budget = left.min(steps.max(LEAST_BUDGET));
            let advance =
                self.stepper.run::<CUT, E, O>(&mut state.run, excitation, until, budget, observer)?;
            work = work.and(advance.work);
        }
        Ok(Advance { ended: Ended::Finished, work })
    }

    /// Whether there are checks: not with rigid impacts, at slightly other instants in finer steps.
    #[inline]
    fn is_checkable(&self) -> bool {
        !matches!(self.stepper.scene().contact.kind(), ContactKind::Impulsive { .. })
    }

    /// Number of the longest steps from one instant to a later one.
    fn steps_until(&self, from: Instant, to: Instant) -> u32 {
        let longest = self.stepper.sets.iter().fold(1, |longest, set| set.ticks.max(longest));
        let steps = to.ticks().saturating_sub(from.ticks()) / u64::from(longest);
        steps.min(u64::from(u32::MAX)) as u32
    }

    #[inline(never)]
    fn begin(&self, state: &mut StepDoublingStateOf<S, P, B, R>) {
        state.finer = state.run;
        state.next = later(state.run.clock, self.period);
        state.checking = true;
        state.periods = 0;
        (state.energy, state.change, state.middle) = (S::ZERO, S::ZERO, S::ZERO);
    }

    /// One step of the run, in two halves as well.
    #[inline(never)]
    fn step_with_check<const CUT: bool, E: Excitation<S>, O: Observer<S>>(
        &self,
        state: &mut StepDoublingStateOf<S, P, B, R>,
        excitation: &E,
        until: Instant,
        observer: &mut O,
    ) -> Result<Work, StepError<S>> {
        let mut delivered = Delivered(S::ZERO);
        let from = state.run.clock;
        let mut both = (&mut delivered, observer);
        // The least budget allows one step.
        let advance =
            self.stepper.run::<CUT, E, _>(&mut state.run, excitation, until, LEAST_BUDGET, &mut both)?;
        let mut work = advance.work;
        let Delivered(energy) = delivered;
        let ticks = from.ticks_until(state.run.clock, u32::MAX);
        let mut halves = Work::default();
        match self.halves(ticks, &mut state.finer, state.run.clock, excitation, &mut halves) {
            Some(finer) => {
                state.energy += energy;
                state.change += finer - energy;
                if state.run.clock >= state.next {
                    self.end_period(state);
                }
            }
            // The finer steps have failed: this check shows nothing.
            None => self.plan(state),
        }
        work.locating = work.locating.saturating_add(halves.attempts());
        Ok(work)
    }

    /// The energy in J that the finer steps deliver over a step of `ticks` that ends at `until`; `None` if they fail.
    fn halves<E: Excitation<S>>(
        &self,
        ticks: u32,
        state: &mut StateOf<S, P, B, R>,
        until: Instant,
        excitation: &E,
        work: &mut Work,
    ) -> Option<S> {
        let mut delivered = Delivered(S::ZERO);
        // The short step first, should all lengths be equal.
        if let Some(level) = self.stepper.sets.iter().rposition(|set| set.ticks == ticks) {
            let mut spare = *state;
            let home = core::ptr::from_ref(state);
            let mut pair = Pair { now: &mut *state, next: &mut spare };
            for _ in 0..2 {
                if !self.finer.step_of(level, &mut pair, until, excitation, &mut delivered, work).ok()? {
                    break;
                }
            }
            if !core::ptr::eq(pair.now, home) {
                *pair.next = *pair.now;
            }
        }
        if state.clock.after(1) >= until {
            // Half of an odd number of ticks is half a tick short.
            state.clock = until;
            return Some(delivered.0);
        }
        // A step that was cut is shorter than any of the finer steps: it has its own halves.
        let half = state.clock.ticks_until(until, u32::MAX) / 2;
        for end in [state.clock.after(half.max(1)), until] {
            let budget = MOST_CATCHING_UP / 2;
            let advance =
                self.finer.run::<true, E, _>(state, excitation, end, budget, &mut delivered).ok()?;
            *work = work.and(advance.work);
            if advance.ended != Ended::Finished {
                return None;
            }
        }
        Some(delivered.0)
    }

    /// Ends a period of a check, and with the last one the check. It ends early where both states have come apart: from there
    /// on the difference is that of two motions, no longer that of the steps.
    #[inline(never)]
    fn end_period(&self, state: &mut StepDoublingStateOf<S, P, B, R>) {
        let scene = self.stepper.scene();
        state.periods = state.periods.wrapping_add(1);
        state.next = later(state.next, self.period);
        let stored = scene.stored_energy(&state.run).total();
        let distance = scene.energy_between(&state.run, &state.finer);
        let apart = is_apart(distance, stored);
        if state.periods <= PERIODS / 2 {
            state.middle = state.middle.max(distance);
        }
        if apart || state.periods >= PERIODS {
            // Without a stop two motions approach each other.
            let may_diverge =
                ContactOf::<S, P>::POSSIBLE && !matches!(scene.contact.kind(), ContactKind::None);
            let diverges = may_diverge && (apart || comes_apart(state.middle, distance));
            let periods = state.periods;
            state.checks.add(&Check { energy: state.energy, change: state.change, periods, diverges });
            self.plan(state);
        }
    }

    /// Sets the start of the next check. The distances are those of a sequence of golden sections, between a half and
    /// three halves of their mean: a periodic motion is checked in all of its phases.
    fn plan(&self, state: &mut StepDoublingStateOf<S, P, B, R>) {
        const GOLDEN: u32 = 0x9E37_79B9;
        state.checking = false;
        state.number = state.number.wrapping_add(1);
        let part = u64::from(state.number.wrapping_mul(GOLDEN) >> 16);
        let length = self.period.saturating_mul(u64::from(state.periods.max(1)));
        let mean = length.saturating_mul(u64::from(self.every));
        let distance = (mean / 2).saturating_add((mean >> 16).saturating_mul(part));
        state.next = later(state.run.clock, distance.saturating_sub(length));
    }
}

fn later(from: Instant, ticks: u64) -> Instant {
    Instant::from_ticks(from.ticks().saturating_add(ticks))
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize, const ALL: usize> Harvester<S>
    for StepDoubling<S, P, B, R, ALL>
{
    type State = StepDoublingStateOf<S, P, B, R>;
    type Start = Start<S, B, R>;

    const ESTIMATES_ERROR: bool = false;
    /// A step, its two halves, and steps where these fail.
    const LEAST_BUDGET: u32 = 4 * LEAST_BUDGET + MOST_CATCHING_UP;

    fn start<E: Excitation<S>>(
        &self,
        start: &Self::Start,
        excitation: &E,
    ) -> Result<Self::State, ParameterError<S>> {
        Ok(self.state_of(self.stepper.start(start, excitation)?))
    }

    /// The checks before the restart keep their weight.
    fn restart<E: Excitation<S>>(
        &self,
        before: Option<&Self::State>,
        excitation: &E,
        at: Instant,
    ) -> Result<Self::State, ParameterError<S>> {
        let run = self.stepper.restart(before.map(|before| &before.run), excitation, at)?;
        let mut state = self.state_of(run);
        if let Some(before) = before {
            (state.checks, state.number) = (before.checks, before.number);
        }
        Ok(state)
    }

    #[inline]
    fn advance<E: Excitation<S>, O: Observer<S>>(
        &self,
        state: &mut Self::State,
        excitation: &E,
        until: Instant,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>> {
        self.run::<true, E, O>(state, excitation, until, budget, observer)
    }

    #[inline]
    fn advance_past<E: Excitation<S>, O: Observer<S>>(
        &self,
        state: &mut Self::State,
        excitation: &E,
        until: Instant,
        sample_ticks: u64,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>> {
        if self.stepper.overshoots(sample_ticks) {
            self.run::<false, E, O>(state, excitation, until, budget, observer)
        } else {
            self.run::<true, E, O>(state, excitation, until, budget, observer)
        }
    }

    fn clock(&self, state: &Self::State) -> Instant {
        state.run.clock
    }

    fn set_clock(&self, state: &mut Self::State, clock: Instant) {
        let left = state.next.ticks().saturating_sub(state.run.clock.ticks());
        state.next = later(clock, left);
        (state.run.clock, state.finer.clock) = (clock, clock);
    }

    fn outputs<'a>(&self, state: &'a Self::State) -> Outputs<'a, S> {
        self.stepper.outputs(&state.run)
    }

    fn velocity(&self, state: &Self::State) -> S {
        self.stepper.velocity(&state.run)
    }

    fn set_storage_voltage(&self, state: &mut Self::State, voltage: S, acceleration: S) {
        self.stepper.set_storage_voltage(&mut state.run, voltage, acceleration);
        self.stepper.set_storage_voltage(&mut state.finer, voltage, acceleration);
    }

    fn angular_frequency(&self) -> S {
        self.stepper.angular_frequency()
    }

    fn decay_rate(&self) -> S {
        self.stepper.decay_rate()
    }

    fn step_doubling_error(&self, state: &Self::State) -> Option<StepDoublingError<S>> {
        state.checks.error(self.angular_frequency())
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        self.stepper.identify(fingerprint);
        fingerprint.name("checked");
        fingerprint.count(self.every);
    }
}

snapshot_fields!(impl [S: Scalar, T: Snapshot] StepDoublingState<S, T> {
    run, finer, next, checking, number, energy, change, middle, periods, checks,
} if |state| state.periods <= PERIODS);
