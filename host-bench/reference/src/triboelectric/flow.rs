//! Flow between events: steps of Radau IIA, with the events located on their polynomials.
//!
//! Local time starts at zero with each flow. Each accepted step is cut where the velocity changes sign. The
//! position is then monotone in every piece, so a short hop or a graze inside one step is found too.
//!
//! The polynomial of a step has order 3, and its end order 5. So a step with an event in it is taken again: first up to shortly before the
//! event, then a short one over it, whose polynomial is exact to rounding, and last one that ends at the event.

use std::cell::Cell;

use super::bridge::{Switch, SwitchSearch, earlier};
use super::harvester::{Dense, Guards, Harvester, Motion, Sample, Scales, SceneEvent};
use super::radau::{Arc, Integrator, Reason};
use crate::ledger::{Effort, Integrals, add};
use harvester_scene::base_motion::LocalBase;
use harvester_scene::root::far_side;

/// Length of the step over an event, as a part of the step in which it was found.
const FINE: f64 = 2e-3;

/// Accepted and refused steps within which a flow must make progress.
const STALL: u64 = 100_000;

/// One accepted step, or the part of it before an event.
pub(crate) struct Step<'a> {
    /// Local start in s and the motion there.
    pub(crate) start: Sample,
    /// Local end in s and the motion there.
    pub(crate) end: Sample,
    /// Local times between the ends at which the velocity changes sign.
    pub(crate) turns: Vec<f64>,
    /// Motion at a local time between the ends, by the polynomial of the step.
    pub(crate) motion: &'a Dense<'a, Motion>,
    /// Rate in V/s of the voltage where it is a state, by the polynomial.
    pub(crate) voltage_rate: &'a Dense<'a, f64>,
    /// Motion at a local time between the ends, by a step to it, which is not counted. The flow ends if that step fails.
    pub(crate) exact: &'a Dense<'a, Motion>,
    /// Integrals over the step.
    pub(crate) integrals: Integrals,
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum Event<E> {
    /// An event of the scene.
    Scene(E),
    /// The bridge or the draw switches.
    Switch(Switch),
}

/// The integrals over a flow and the event that ended it, if the time was not up.
pub(crate) type FlowEnd<H> = (Integrals, Option<Event<SceneEvent<H>>>);

/// An event with its local time in s.
type Found<H> = Option<(f64, Event<SceneEvent<H>>)>;

/// A flow from local time zero on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flow<'a, H> {
    pub(crate) harvester: &'a H,
    pub(crate) base: &'a LocalBase,
    pub(crate) start: Motion,
    pub(crate) scales: &'a Scales,
    /// Relative tolerance of the integrator.
    pub(crate) tolerance: f64,
}

impl<'a, H: Harvester> Flow<'a, H> {
    /// Flows for `span` seconds or until an event, and shows each step to `watch`. Gives the integrals over the
    /// flow and the event; `last` is the motion at the end, or the last good one.
    pub(crate) fn run(
        &self,
        span: f64,
        effort: &mut Effort,
        last: &mut Sample,
        watch: &mut dyn FnMut(&Step<'_>),
    ) -> Result<FlowEnd<H>, Reason> {
        let integrator =
            Integrator::new(self.harvester, self.base, self.start, (self.scales, self.tolerance));
        let (mut search, mut sums) = (self.search(), Integrals::default());
        // The base keeps its polynomials of two such spans; without a frequency it has none.
        let smooth = 1.0 / (8.0 * self.base.highest_frequency());
        let (mut next, mut longest, mut fine) = (0.0, smooth, 0.0);
        let mut checked = (effort.attempts(), 0.0);
        loop {
            if effort.attempts() > checked.0 + STALL {
                if last.0 - checked.1 < H::LEAST_PROGRESS * self.scales.time {
                    return Err(Reason(format!("stalled: {STALL} steps without progress")));
                }
                checked = (effort.attempts(), last.0);
            }
            let arc = integrator.step(last, [next, longest.min(span - last.0)], &sums, effort)?;
            let motion = |t: f64| self.start.with(&arc.at(t)[0]);
            let (mut searched, length) = (search, arc.to - arc.from);
            let (turns, event) = self.cut(&mut searched, &arc, &motion);
            if let Some((at, _)) = event
                && length > f64::max(1.5 * fine, 64.0 * f64::EPSILON * arc.to)
            {
                fine = if fine == 0.0 { FINE * length } else { fine };
                longest = fine.max(at - arc.from - 0.5 * fine).min(smooth);
                effort.refuse();
                continue;
            }
            let (end, integrals) = match event {
                Some((at, _)) => integrator.go(last, at, &sums, effort)?,
                None => ((arc.to, self.start.with(&arc.end)), arc.integrals),
            };
            let failure = Cell::new(None);
            let exact = |t: f64| match integrator.go(last, t, &sums, &mut Effort::default()) {
                Ok(((_, there), _)) => there,
                Err(reason) => {
                    failure.set(Some(reason));
                    motion(t)
                }
            };
            let voltage_rate = |t: f64| arc.at(t)[1][2];
            let (motion, voltage_rate, exact) = (&motion, &voltage_rate, &exact);
            watch(&Step { start: *last, end, turns, motion, voltage_rate, exact, integrals });
            failure.take().map_or(Ok(()), Err)?;
            add(&mut sums, 1.0, &integrals);
            (search, *last, next, longest) = (searched, end, arc.next, smooth);
            if !self.harvester.is_in_range(&end.1) {
                return Err(Reason("the motion left the model".to_owned()));
            }
            if event.is_some() || end.0 >= span * (1.0 - 2.0 * f64::EPSILON) {
                return Ok((sums, event.map(|(_, event)| event)));
            }
        }
    }

    fn search(&self) -> Search<'a, H::Guards> {
        let Motion { voltage, bridge, .. } = self.start;
        let storage = self.harvester.load().storage.as_ref();
        Search {
            guards: self.harvester.guards(&self.start),
            bridge: storage.map(|storage| SwitchSearch::new(storage, bridge, voltage)),
        }
    }

    /// The first event of the scene in a step, and the turns before it.
    fn scene_event(
        &self,
        guards: &mut H::Guards,
        arc: &Arc,
        motion: &Dense<'_, Motion>,
        turns: &mut Vec<f64>,
    ) -> Option<(f64, SceneEvent<H>)> {
        let acceleration = |t: f64| self.harvester.acceleration(&motion(t), self.base.at(t));
        let mut begin = (arc.from, motion(arc.from));
        for cut in guards.cuts(&acceleration, arc.from, arc.to) {
            let end = (cut, motion(cut));
            if begin.1.velocity != 0.0 && (begin.1.velocity > 0.0) != (end.1.velocity > 0.0) {
                let turn = far_side(|t| motion(t).velocity, begin.0, cut);
                let end = (turn, motion(turn));
                if let Some(event) = guards.event(motion, begin, end) {
                    return Some(event);
                }
                turns.push(turn);
                begin = end;
            }
            if let Some(event) = guards.event(motion, begin, end) {
                return Some(event);
            }
            begin = end;
        }
        None
    }

    /// The first event in a step, if there is one, and the turns before it.
    fn cut(
        &self,
        search: &mut Search<'_, H::Guards>,
        arc: &Arc,
        motion: &Dense<'_, Motion>,
    ) -> (Vec<f64>, Found<H>) {
        let mut turns = Vec::new();
        let event = self.scene_event(&mut search.guards, arc, motion, &mut turns);
        let mut event = event.map(|(at, event)| (at, Event::Scene(event)));
        if let Some(bridge) = &mut search.bridge {
            let at = |t: f64| {
                let motion = motion(t);
                (self.harvester.port(&motion), motion.bridge)
            };
            let switch = bridge.first(arc.from, event.map_or(arc.to, |(at, _)| at), &turns, &at);
            event = earlier(event, switch.map(|(at, switch)| (at, Event::Switch(switch))), arc.to - arc.from);
        }
        turns.retain(|turn| event.is_none_or(|(at, _)| *turn < at));
        (turns, event)
    }
}

/// The search for events along a flow.
#[derive(Debug, Clone, Copy)]
struct Search<'a, G> {
    guards: G,
    bridge: Option<SwitchSearch<'a>>,
}
