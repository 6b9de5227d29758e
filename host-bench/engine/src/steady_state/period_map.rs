//! The period map: a state at one phase of the excitation, and the state one period later.

use model_core::clock::Instant;
use model_core::excitation::Excitation;
use model_core::hybrid::{Automaton, Driver, HybridState, StepError, Work};
use model_core::integrate::{AnyStepControl, Method, Point};
use model_core::observer::{AcceptedStep, Event, Observer};

/// Attempts per call of the driver: the counts of a call fit in 32 bits.
const BUDGET: u32 = 1 << 24;

/// A harvester under one sine.
#[derive(Debug)]
pub struct ForcedSystem<'a, A, E, I, const N: usize, const P: usize> {
    pub harvester: &'a A,
    /// The base acceleration: one sine.
    pub excitation: &'a E,
    /// Frequency of the sine in Hz.
    pub frequency_hz: f64,
    /// The driver that takes the steps.
    pub driver: &'a Driver<I, AnyStepControl<f64>>,
}

/// A state of a harvester of the core.
pub type StateOf<A, const N: usize, const P: usize> =
    HybridState<f64, <A as Automaton<f64, N, P>>::Mode, N, P>;

/// Work of a whole run: a long one has more steps than fit in 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Total {
    pub steps: u64,
    pub rejected: u64,
    /// Steps taken to locate events.
    pub locating: u64,
    /// Newton iterations within steps.
    pub iterations: u64,
    pub events: u64,
}

impl Total {
    /// Steps kept, rejected, and taken to locate events.
    pub fn attempts(&self) -> u64 {
        self.steps + self.rejected + self.locating
    }

    pub(crate) fn add(&mut self, work: &Work) {
        self.steps += u64::from(work.steps);
        self.rejected += u64::from(work.rejected);
        self.locating += u64::from(work.locating);
        self.iterations += u64::from(work.iterations);
        self.events += u64::from(work.events);
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spent {
    /// Simulated periods of the excitation, parts included.
    pub periods: f64,
    pub work: Total,
}

impl<A, E, I, const N: usize, const P: usize> ForcedSystem<'_, A, E, I, N, P>
where
    A: Automaton<f64, N, P>,
    E: Excitation<f64>,
    I: Method<f64>,
{
    /// The instant `periods` periods after the start, at most the last instant of the clock.
    pub(super) fn instant(&self, periods: f64) -> Instant {
        Instant::from_seconds(periods / self.frequency_hz).unwrap_or(Instant::from_ticks(u64::MAX))
    }

    /// Advances `state` to `until`.
    pub(super) fn advance<O: Observer<f64>>(
        &self,
        state: &mut StateOf<A, N, P>,
        until: Instant,
        observer: &mut O,
        spent: &mut Spent,
    ) -> Result<(), StepError<f64>> {
        let from = state.clock;
        while state.clock < until {
            let advance =
                self.driver.advance(self.harvester, state, self.excitation, until, BUDGET, observer)?;
            spent.work.add(&advance.work);
        }
        let ticks = state.clock.ticks().saturating_sub(from.ticks());
        spent.periods += Instant::from_ticks(ticks).seconds::<f64>() * self.frequency_hz;
        Ok(())
    }

    /// `pattern` at another state vector, with its clock, mode and memory.
    pub(super) fn at(&self, pattern: &StateOf<A, N, P>, vector: &[f64; N]) -> StateOf<A, N, P> {
        let input = self.excitation.acceleration(pattern.clock);
        let mut state = *pattern;
        state.point = Point::at(&self.harvester.flow(pattern.mode), *vector, input);
        state
    }

    /// The state vector one period after `vector`, which has the clock and the mode of `pattern`; `None` if the mode then
    /// is another, or a step cannot be taken.
    pub(super) fn period<O: Observer<f64>>(
        &self,
        pattern: &StateOf<A, N, P>,
        vector: &[f64; N],
        observer: &mut O,
        spent: &mut Spent,
    ) -> Option<[f64; N]> {
        let mut state = self.at(pattern, vector);
        let until = Instant::from_ticks(state.clock.ticks().saturating_add(self.instant(1.0).ticks()));
        self.advance(&mut state, until, observer, spent).ok()?;
        (state.mode == pattern.mode).then_some(state.point.state)
    }
}

/// The smooth stretches of a motion, and the extremes of each state.
#[derive(Debug)]
pub(super) struct Watch<const N: usize> {
    stretches: Vec<Stretch>,
    event: bool,
    lowest: [f64; N],
    highest: [f64; N],
}

#[derive(Debug)]
struct Stretch {
    stick: bool,
    from: u64,
    to: u64,
}

impl<const N: usize> Watch<N> {
    pub(super) fn new() -> Self {
        Self {
            stretches: Vec::new(),
            event: true,
            lowest: [f64::INFINITY; N],
            highest: [f64::NEG_INFINITY; N],
        }
    }

    /// Half the range of each state, at least a thousandth of its typical size.
    pub(super) fn scale(&self, typical: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|index| {
            let half = 0.5 * (self.highest[index] - self.lowest[index]);
            half.max(1e-3 * typical[index])
        })
    }

    /// Ticks from the start of the watch to the middle of the longest smooth stretch, without stick if there is such a
    /// stretch; 0 for a motion without events.
    pub(super) fn calmest(&self) -> u64 {
        let [first, _, ..] = &self.stretches[..] else { return 0 };
        let longest = self.stretches.iter().max_by_key(|stretch| (!stretch.stick, stretch.to - stretch.from));
        longest.map_or(0, |stretch| stretch.from.midpoint(stretch.to) - first.from)
    }
}

impl<const N: usize> Observer<f64> for Watch<N> {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        let (from, to) = (step.from.ticks(), step.until().ticks());
        match self.stretches.last_mut() {
            Some(stretch) if !self.event => stretch.to = to,
            _ => self.stretches.push(Stretch { stick: step.start.stick, from, to }),
        }
        self.event = false;
        for state in [step.start.state, step.end.state] {
            for (index, &entry) in state.iter().enumerate().take(N) {
                self.lowest[index] = self.lowest[index].min(entry);
                self.highest[index] = self.highest[index].max(entry);
            }
        }
    }

    fn event(&mut self, _event: &Event<'_, f64>) {
        self.event = true;
    }
}
