//! The march of a peer: steps of its integrator, events on its dense output, jumps.

use super::scene::{GUARDS, Harvester, System};
use crate::solver::Solver;
use crate::{Meter, Stop};

/// Parts of a step in which a guard that has not left its zero is looked at.
const PARTS: u32 = 8;

/// Samples of the holding force per period of the base.
const SAMPLES_PER_PERIOD: f64 = 64.0;

/// A march from time zero on.
pub(crate) struct March<'a, H: Harvester<N>, S, const N: usize> {
    system: &'a System<H, N>,
    solver: S,
    time: f64,
    state: [f64; N],
    /// Whether the solver has to begin anew at `time` and `state`.
    is_new: bool,
    /// Length in s of the last step, and the first one after an event over it.
    step: f64,
    restart: f64,
    /// Which guards have been above zero in this flow.
    armed: [bool; GUARDS],
    /// Energy in J delivered in the flows before this one.
    delivered: f64,
    steps: f64,
    most_steps: f64,
}

impl<'a, H: Harvester<N>, S: Solver<N>, const N: usize> March<'a, H, S, N> {
    /// A march at time zero whose first step after an event is `restart` times the last one before it, and which takes
    /// at most `most_steps` steps.
    pub(crate) fn new(
        system: &'a System<H, N>,
        solver: S,
        state: [f64; N],
        [restart, most_steps]: [f64; 2],
    ) -> Self {
        let step = 1e-3 / system.harvester.base().angular_frequency;
        let (time, delivered, steps, armed) = (0.0, 0.0, 0.0, [false; GUARDS]);
        Self { system, solver, time, state, is_new: true, step, restart, armed, delivered, steps, most_steps }
    }

    /// Energy in J delivered so far.
    fn delivered(&self) -> f64 {
        self.delivered + self.state[N - 1]
    }

    /// Begins a flow at the present state. Its delivered energy begins at zero, so that the tolerance of the energy is
    /// relative to that of one flow.
    fn begin(&mut self) {
        self.delivered += std::mem::take(&mut self.state[N - 1]);
        let guards = self.system.harvester.guards(&self.system.mode.get(), &self.state);
        self.armed = guards.map(|guard| guard > 0.0);
        self.is_new = true;
    }

    /// Stands still until the release or until `limit`.
    fn rest(&mut self, limit: f64) {
        let System { harvester, mode } = self.system;
        let (start, state) = (self.time, self.state);
        let reserve = |t: f64| harvester.reserve(&mode.get(), t, &state);
        let spacing = std::f64::consts::TAU / (SAMPLES_PER_PERIOD * harvester.base().angular_frequency);
        let (mut before, mut release) = (start, None);
        while release.is_none() && before < limit {
            let after = (before + spacing).min(limit);
            if reserve(after) < 0.0 {
                release = Some(crossing(before, after, |t| Ok(-reserve(t))).unwrap_or(after));
            }
            before = after;
        }
        self.time = release.unwrap_or(limit);
        harvester.stand(&mut self.state, self.time - start);
        if release.is_some() {
            let mut now = mode.get();
            harvester.release(&mut now, self.time, &self.state);
            mode.set(now);
        }
        self.begin();
    }

    /// One step of the flow, and the first event in it.
    fn flow(&mut self, limit: f64) -> Result<(), Stop> {
        let System { harvester, mode } = self.system;
        if self.is_new {
            self.solver.restart(self.time, &self.state, self.restart * self.step)?;
            self.is_new = false;
        }
        let before = self.time;
        self.solver.step(limit)?;
        self.steps += 1.0;
        (self.time, self.state) = (self.solver.time(), self.solver.state());
        let now = mode.get();
        let guards = harvester.guards(&now, &self.state);
        let mut first: Option<(f64, usize)> = None;
        for (index, guard) in guards.into_iter().enumerate() {
            if guard > 0.0 {
                self.armed[index] = true;
                continue;
            }
            let end = self.time;
            let value = |t: f64| Ok(-harvester.guards(&now, &self.solver.at(t)?)[index]);
            let at = first_crossing(before, end, self.armed[index], value)?;
            if first.is_none_or(|(earlier, _)| at < earlier) {
                first = Some((at, index));
            }
        }
        // The step that a limit or an event cuts short says nothing about the next one.
        if self.time < limit {
            self.step = self.time - before;
        }
        let Some((at, index)) = first else { return harvester.check(&self.state) };
        if at < self.time {
            (self.time, self.state) = (at, self.solver.at(at)?);
        }
        harvester.check(&self.state)?;
        let mut next = now;
        harvester.jump(index, self.time, &mut next, &mut self.state);
        mode.set(next);
        self.begin();
        Ok(())
    }

    /// Goes to `limit` in s.
    fn to(&mut self, limit: f64) -> Result<(), Stop> {
        while limit - self.time > 4.0 * f64::EPSILON * limit {
            if self.steps > self.most_steps {
                return Err(Stop::TooManySteps { steps: self.steps, time_s: self.time });
            }
            if self.system.mode.get().stuck { self.rest(limit) } else { self.flow(limit)? }
        }
        Ok(())
    }

    /// Goes through the run, with the window from `settle` to `end` in s measured.
    pub(crate) fn run(&mut self, [settle, end]: [f64; 2]) -> Result<Meter, Stop> {
        let mut meter = Meter::begin();
        self.begin();
        self.to(settle)?;
        meter.open(self.delivered());
        self.to(end)?;
        Ok(meter.close(self.delivered(), self.steps))
    }
}

/// The time between `before` and `end` at which the value rises through zero. A value that has not been below zero
/// before may be so within the step; otherwise the event is at the end of the step.
fn first_crossing(
    before: f64,
    end: f64,
    armed: bool,
    mut value: impl FnMut(f64) -> Result<f64, Stop>,
) -> Result<f64, Stop> {
    if armed {
        return crossing(before, end, value);
    }
    for part in 1..PARTS {
        let from = before + (end - before) * f64::from(part) / f64::from(PARTS);
        if value(from)? < 0.0 {
            return crossing(from, end, value);
        }
    }
    Ok(end)
}

/// The zero of a value that is below zero at `before` and not at `after`, by the Illinois rule: the end at which the
/// value is not below zero.
fn crossing(
    mut before: f64,
    mut after: f64,
    mut value: impl FnMut(f64) -> Result<f64, Stop>,
) -> Result<f64, Stop> {
    let (mut low, mut high) = (value(before)?, value(after)?);
    if low >= 0.0 {
        return Ok(before);
    }
    let mut last_side = 0;
    while after - before > 4.0 * f64::EPSILON * after {
        let secant = after - high * (after - before) / (high - low);
        let middle = if secant > before && secant < after { secant } else { before + 0.5 * (after - before) };
        if middle <= before || middle >= after {
            break;
        }
        let here = value(middle)?;
        if here >= 0.0 {
            (after, high) = (middle, here);
            low *= if last_side == 1 { 0.5 } else { 1.0 };
            last_side = 1;
        } else {
            (before, low) = (middle, here);
            high *= if last_side == -1 { 0.5 } else { 1.0 };
            last_side = -1;
        }
        if here == 0.0 {
            break;
        }
    }
    Ok(after)
}
