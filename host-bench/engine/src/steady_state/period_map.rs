//! The period map: a state at one phase of the excitation, and the state one period later.

use model_core::clock::Instant;
use model_core::energy::RunMeter;
use model_core::excitation::Excitation;
use model_core::hybrid::Work;
use model_core::observer::{AcceptedStep, Event, Observer};
use model_core::scene::Harvester;

use harvester_scene::method::Failure;

/// Attempts per call of a harvester: the counts of a call fit in 32 bits.
const BUDGET: u32 = 1 << 24;
/// Most attempted steps of a search for one orbit, where the options have no limit: a period of 10⁶ s has more.
pub(crate) const MOST_ATTEMPTS: u64 = 50_000_000;

/// A harvester whose state has coordinates, the unknowns of a periodic motion.
///
/// The other parts of a state, such as its mode, are those of a *pattern*: a state of the transient at the same phase.
pub trait Coordinates: Harvester<f64> {
    /// Parts into which the period is divided to find the extremes of the coordinates; 1 if
    /// [`Outputs::state`](model_core::observer::Outputs::state) has the coordinates at every step.
    const PARTS: u32;

    fn coordinates(&self, state: &Self::State) -> Vec<f64>;

    /// The state with the clock and the mode of `pattern` at other coordinates, under the base acceleration at its clock in
    /// m/s²; `None` if there is no such state.
    fn at(&self, pattern: &Self::State, coordinates: &[f64], acceleration: f64) -> Option<Self::State>;

    /// Whether two states have the same mode, so that a small change of the one leads to the other.
    fn is_like(&self, one: &Self::State, other: &Self::State) -> bool;
}

/// A harvester under one sine.
#[derive(Debug)]
pub struct ForcedSystem<'a, H, E> {
    pub harvester: &'a H,
    /// The base acceleration: one sine.
    pub excitation: &'a E,
    /// Frequency of the sine in Hz.
    pub frequency_hz: f64,
    /// Most attempted steps of a search for one orbit.
    pub most_attempts: u64,
}

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
    /// Attempted steps at which the search for the present orbit stops.
    limit: Option<u64>,
}

impl<H: Harvester<f64>, E: Excitation<f64>> ForcedSystem<'_, H, E> {
    /// The instant `periods` periods after the start, at most the last instant of the clock.
    pub(crate) fn instant(&self, periods: f64) -> Instant {
        Instant::from_seconds(periods / self.frequency_hz).unwrap_or(Instant::from_ticks(u64::MAX))
    }

    /// Begins the search for an orbit: from here on it may take its most attempted steps.
    pub(crate) fn begin(&self, spent: &mut Spent) {
        spent.limit = Some(spent.work.attempts().saturating_add(self.most_attempts));
    }

    /// Advances `state` to `until`, within the attempts that the search may take.
    pub(crate) fn advance<O: Observer<f64>>(
        &self,
        state: &mut H::State,
        until: Instant,
        observer: &mut O,
        spent: &mut Spent,
    ) -> Result<(), Failure> {
        let from = self.harvester.clock(state);
        while self.harvester.clock(state) < until {
            let left = spent.limit.map_or(u64::MAX, |limit| limit.saturating_sub(spent.work.attempts()));
            if left == 0 {
                return Err(given_up(self.most_attempts, self.harvester.clock(state)));
            }
            let budget = u32::try_from(left).unwrap_or(BUDGET).min(BUDGET);
            let advance = self.harvester.advance(state, self.excitation, until, budget, observer);
            spent.work.add(&advance.map_err(|error| Failure::Step(error.to_string()))?.work);
        }
        let ticks = self.harvester.clock(state).ticks().saturating_sub(from.ticks());
        spent.periods += Instant::from_ticks(ticks).seconds::<f64>() * self.frequency_hz;
        Ok(())
    }
}

impl<H: Coordinates, E: Excitation<f64>> ForcedSystem<'_, H, E> {
    /// Advances `state` to `until` and watches it on its way.
    pub(super) fn watched(
        &self,
        state: &mut H::State,
        until: Instant,
        spent: &mut Spent,
    ) -> Result<Watch, Failure> {
        let mut watch = Watch::new(H::PARTS == 1);
        let from = self.harvester.clock(state).ticks();
        let length = until.ticks().saturating_sub(from);
        for part in 1..=u64::from(H::PARTS) {
            let end = Instant::from_ticks(from + length / u64::from(H::PARTS) * part);
            let end = if part == u64::from(H::PARTS) { until } else { end };
            let watching: &mut Watching<'_, '_> = &mut (&mut Some(&mut watch), &mut None);
            self.advance(state, end, watching, spent)?;
            if H::PARTS > 1 {
                watch.see(&self.harvester.coordinates(state));
            }
        }
        Ok(watch)
    }

    /// `pattern` at other coordinates, with its clock, mode and memory.
    pub(super) fn at(&self, pattern: &H::State, vector: &[f64]) -> Option<H::State> {
        let acceleration = self.excitation.acceleration(self.harvester.clock(pattern));
        self.harvester.at(pattern, vector, acceleration)
    }

    /// The coordinates one period after `vector`, which has the clock and the mode of `pattern`; `None` if the mode then
    /// is another, or a step cannot be taken.
    pub(super) fn period<O: Observer<f64>>(
        &self,
        pattern: &H::State,
        vector: &[f64],
        observer: &mut O,
        spent: &mut Spent,
    ) -> Option<Vec<f64>> {
        let mut state = self.at(pattern, vector)?;
        let from = self.harvester.clock(&state).ticks();
        let until = Instant::from_ticks(from.saturating_add(self.instant(1.0).ticks()));
        self.advance(&mut state, until, observer, spent).ok()?;
        self.harvester.is_like(&state, pattern).then(|| self.harvester.coordinates(&state))
    }
}

/// The end of a run that has taken the most attempted steps that it may.
pub(crate) fn given_up(most: u64, at: Instant) -> Failure {
    let at_s = at.seconds::<f64>();
    Failure::StepLimitExceeded(format!("given up after {most} attempted steps at {at_s} s"))
}

/// What watches a motion, what measures it, or both: in one type, for which a harvester is compiled once.
pub(crate) type Watching<'a, 'b> = (&'a mut Option<&'b mut Watch>, &'a mut Option<&'b mut RunMeter<f64>>);

/// The smooth stretches of a motion, and the extremes of each coordinate.
pub(crate) struct Watch {
    stretches: Vec<Stretch>,
    event: bool,
    /// Whether the outputs have the coordinates.
    reads_state: bool,
    lowest: Vec<f64>,
    highest: Vec<f64>,
}

struct Stretch {
    /// Whether the mass sticks, or beam and stop touch.
    in_contact: bool,
    from: u64,
    to: u64,
}

impl Watch {
    fn new(reads_state: bool) -> Self {
        let (lowest, highest) = (Vec::new(), Vec::new());
        Self { stretches: Vec::new(), event: true, reads_state, lowest, highest }
    }

    /// Half the range of each coordinate, at least a thousandth of its typical size.
    pub(super) fn scale(&self, typical: &[f64]) -> Vec<f64> {
        let ranges = self.lowest.iter().zip(&self.highest).zip(typical);
        ranges.map(|((lowest, highest), typical)| (0.5 * (highest - lowest)).max(1e-3 * typical)).collect()
    }

    /// Ticks from the start of the watch to the middle of the longest smooth stretch, without stick or contact if there is
    /// such a stretch; 0 for a motion without events.
    pub(super) fn calmest(&self) -> u64 {
        let [first, _, ..] = &self.stretches[..] else { return 0 };
        let longest =
            self.stretches.iter().max_by_key(|stretch| (!stretch.in_contact, stretch.to - stretch.from));
        longest.map_or(0, |stretch| stretch.from.midpoint(stretch.to) - first.from)
    }

    /// Widens the extremes to some coordinates.
    fn see(&mut self, coordinates: &[f64]) {
        self.lowest.resize(coordinates.len(), f64::INFINITY);
        self.highest.resize(coordinates.len(), f64::NEG_INFINITY);
        for ((lowest, highest), &entry) in self.lowest.iter_mut().zip(&mut self.highest).zip(coordinates) {
            *lowest = lowest.min(entry);
            *highest = highest.max(entry);
        }
    }
}

impl Observer<f64> for Watch {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        let (from, to) = (step.from.ticks(), step.until().ticks());
        let in_contact = step.start.stick || step.contact.peak_force > 0.0;
        match self.stretches.last_mut() {
            Some(stretch) if !self.event && stretch.in_contact == in_contact => stretch.to = to,
            _ => self.stretches.push(Stretch { in_contact, from, to }),
        }
        self.event = false;
        if self.reads_state {
            self.see(step.start.state);
            self.see(step.end.state);
        }
    }

    fn event(&mut self, _event: &Event<'_, f64>) {
        self.event = true;
    }
}
