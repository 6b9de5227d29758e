//! The reference for the bump-stop harvester: exact propagation from event to event.
//!
//! In each regime, one state of contact and circuit, the harvester and the generator of the base acceleration are one linear system, so
//! the motion over a grid step is a matrix without error of integration. A grid step is a tenth of the shortest period. Each step is
//! searched for crossings of the guards, hidden pairs of crossings included, and an event is located to 2⁻⁴⁰ of a step. The integrals
//! are exact too, as quadratic forms.

mod meter;
mod propagator;
mod regime;
mod system;

use std::cell::OnceCell;

use cpu_time::ThreadTime;

use self::meter::Meter;
use self::propagator::{DIGITS, WHOLE};
use self::regime::{Change, Guard, Regime};
use self::system::{Row, System, value};
use super::schedule::{Schedule, Stretch};
use super::{ReferenceOptions, StepFailure};
use harvester_scene::base_motion::Base;
use harvester_scene::outcome::Outcome;
use harvester_scene::progress;
use harvester_scene::scene_file::{BumpStop, Draw, Scene};
use regime::Circuit;

/// Grid steps in the shortest period.
const STEPS_PER_PERIOD: f64 = 10.0;

/// Grid steps after which the generators of the base are set again from the time, so that they do not drift.
const STRETCH: u64 = 4096;

/// Speed in m/s of approach below which an impact of restitution closes the contact.
const CLOSING_SPEED: f64 = 1e-5;

/// Relative change of the storage voltage in a step with a draw of constant power. The error of the tangent to
/// `P/V_s` is of the order of its square.
const POWER_STEP: f64 = 3e-5;

/// The contact closes or opens, or there is an impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Event {
    /// Time in s.
    pub(super) time: f64,
    /// Speed of approach in m/s just before the event; negative where beam and stop part.
    pub(super) speed: f64,
}

/// All regimes; each is computed when it is first entered.
struct Regimes<'a> {
    system: &'a System,
    /// Contact force and release of the closed contact.
    closed: [Row; 2],
    step: f64,
    entered: [[OnceCell<Regime>; Circuit::COUNT]; 2],
}

impl Regimes<'_> {
    fn get(&self, in_contact: bool, circuit: Circuit) -> &Regime {
        self.entered[usize::from(in_contact)][circuit.index()].get_or_init(|| {
            let [force, release] = if in_contact {
                self.closed.clone()
            } else {
                [vec![0.0; self.system.layout.size()], self.system.gap.clone()]
            };
            Regime::new(self.system, force, release, circuit, self.step)
        })
    }
}

/// The state of a run.
struct March<'a> {
    system: &'a System,
    /// Coefficient of restitution; `None`: a spring closes the contact.
    restitution: Option<f64>,
    regimes: Regimes<'a>,
    meter: Meter<'a>,
    vector: Vec<f64>,
    in_contact: bool,
    circuit: Circuit,
    latches: Latches,
    events: u64,
    steps: u64,
}

/// Guards that begin at zero and must fall before they can rise.
#[derive(Debug, Default)]
struct Latches {
    /// A rigid contact opened at zero gap and zero speed.
    contact: bool,
    /// The bridge has just ended to conduct.
    bridge: Option<Change>,
}

/// Runs the scene from its start to its end, and shows each event of the contact to `watch`.
pub(super) fn run(
    scene: &Scene,
    model: &BumpStop,
    options: &ReferenceOptions,
    mut watch: impl FnMut(&Event),
) -> Result<Outcome, StepFailure> {
    let began = ThreadTime::now();
    let base = Base(&scene.excitation).pieces_from(0.0);
    let system = System::new(model, scene.load, &base);
    let (closed, stiffness) = system.closed_contact(model);
    let highest = system.highest_frequency(stiffness).max(base.highest_frequency());
    let step = (STEPS_PER_PERIOD * highest).recip();
    let mut vector = system.start(&model.initial);
    system.set_base(&mut vector, &base);
    let mut meter = Meter::new(&system, stiffness, model.stop.is_some(), &vector, options.record_every);
    meter.ledger.in_window = scene.run.settle_s <= 0.0;
    meter.ledger.add(&system.share_at_start(&model.initial, &mut vector));
    // A start voltage may have charged the storage.
    let connected = system.is_connected_at_start(&vector);
    let mut march = March {
        meter,
        system: &system,
        restitution: model.stop.and_then(|stop| stop.restitution),
        regimes: Regimes { system: &system, closed, step, entered: Default::default() },
        vector,
        in_contact: false,
        circuit: Circuit { sign: 0, connected },
        latches: Latches::default(),
        events: 0,
        steps: 0,
    };
    let mut schedule = Schedule::new(scene, true, STRETCH as f64 * step, step);
    progress::begin();
    while let Some(stretch) = schedule.next() {
        progress::report(stretch.start / scene.run.duration_s, [march.steps, march.events]);
        march.meter.ledger.in_window = stretch.in_window;
        system.set_base(&mut march.vector, &stretch.base);
        let event = march.stretch(&stretch, step);
        if !march.vector.iter().all(|entry| entry.is_finite()) {
            return Err(march.failure("the motion is not finite".to_owned(), stretch.start));
        }
        schedule
            .advance(&stretch, event.map(|(elapsed, _)| elapsed))
            .map_err(|reason| march.failure(reason, schedule.time))?;
        if let Some((_, change)) = event {
            march.change(change, schedule.time, &mut watch);
        }
    }
    let March { meter, vector, events, steps, .. } = march;
    Ok(meter.close(scene, &vector, events, steps).outcome(scene, began))
}

impl March<'_> {
    /// Goes through a stretch or to the first event, and gives the seconds until the event and its change.
    fn stretch(&mut self, stretch: &Stretch, step: f64) -> Option<(f64, Change)> {
        let regime = self.regimes.get(self.in_contact, self.circuit);
        let tick = regime.propagator.tick();
        let whole_steps = (stretch.span / step).floor();
        let all = whole_steps as u64 * WHOLE + ((stretch.span - whole_steps * step) / tick).round() as u64;
        let power = match self.system.storage.map(|storage| storage.draw) {
            Some(Draw::Power { power_w, .. }) if self.circuit.connected => Some(power_w),
            _ => None,
        };
        let mut end = Vec::new();
        let (mut done, mut found) = (0, None);
        while done < all && found.is_none() {
            let mut most = WHOLE;
            if let Some(power) = power {
                self.system.set_draw(&mut self.vector, power, &regime.storage_rate);
                most >>= halvings(self.system, regime, &self.vector, step);
            }
            let ticks = most.min(all - done);
            let elapsed = done as f64 * tick;
            regime.propagator.advance(&self.vector, ticks, &mut end);
            let ends: [&[f64]; 2] = [&self.vector, &end];
            let rises = regime.guards.iter().filter_map(|guard| {
                let at = self.latches.first_rise(self.system, regime, guard, ends, ticks)?;
                Some((at, guard.change))
            });
            found = rises.min_by_key(|(at, _)| *at);
            let taken = found.map_or(ticks, |(at, _)| at);
            let moments = self.meter.moments();
            if taken == WHOLE {
                moments.add(&regime.propagator, 0, &self.vector);
            } else {
                regime.propagator.advance_measured(&self.vector, taken, &mut end, moments);
            }
            let length = taken as f64 * tick;
            self.meter.watch([&self.vector, &end], taken, regime, self.in_contact);
            self.meter.record(stretch.start + elapsed, length, &self.vector, regime);
            std::mem::swap(&mut self.vector, &mut end);
            self.steps += 1;
            done += taken;
        }
        self.meter.sum_up(&regime.propagator);
        found.map(|(_, change)| (done as f64 * tick, change))
    }

    /// Carries out a change of regime at `time`, and shows an event of the contact to `watch`.
    fn change(&mut self, change: Change, time: f64, watch: &mut impl FnMut(&Event)) {
        self.events += 1;
        match change {
            Change::Contact => {
                let speed = value(&self.system.gap_rate, &self.vector);
                watch(&Event { time, speed });
                self.change_contact(time, speed);
            }
            Change::Conducts { sign } => self.circuit.sign = sign,
            Change::Blocks => self.block(),
            Change::Draw { connected } => self.circuit.connected = connected,
        }
        // After an impact or a change of the draw the current would flow back.
        let regime = || self.regimes.get(self.in_contact, self.circuit);
        if self.circuit.sign != 0 && value(&regime().into_storage, &self.vector) < 0.0 {
            self.block();
        }
    }

    fn block(&mut self) {
        let sign = std::mem::take(&mut self.circuit.sign);
        self.latches.bridge = Some(Change::Conducts { sign });
    }

    /// The contact closes or opens at `time` with this speed of approach, or there is an impact.
    fn change_contact(&mut self, time: f64, speed: f64) {
        if self.in_contact {
            self.in_contact = false;
            // A rigid contact opens at rest, a spring while the beam moves away.
            self.latches.contact = self.restitution.is_some();
            return;
        }
        self.meter.contact(time);
        match self.restitution {
            None => self.in_contact = true,
            Some(coefficient) => self.rebound(coefficient, speed),
        }
    }

    /// An impact between the modes that are kept: Newton's law for the rate of the gap. The contact stays
    /// closed if the impact is slow and beam and rod are pressed together.
    fn rebound(&mut self, coefficient: f64, speed: f64) {
        let mobility = self.system.mobility;
        let closing = speed < CLOSING_SPEED;
        let rebound = if closing { 0.0 } else { coefficient };
        let momentum = (1.0 + rebound) * speed / mobility;
        for (entry, push) in self.vector.iter_mut().zip(&self.system.push) {
            *entry += push * momentum;
        }
        self.meter.impact(momentum, 0.5 * (1.0 - rebound * rebound) * speed * speed / mobility);
        if closing {
            let [force, _] = &self.regimes.closed;
            self.in_contact = value(force, &self.vector) > 0.0;
            self.latches.contact = !self.in_contact;
        }
    }

    fn failure(&self, reason: String, time: f64) -> StepFailure {
        let of = |row: &[f64]| value(row, &self.vector);
        let (tip, gap, voltage) = (of(&self.system.tip), of(&self.system.gap), of(&self.system.voltage));
        let state = format!("tip {tip:e} m, penetration {gap:e} m, voltage {voltage:e} V");
        StepFailure { reason, time_s: time, state }
    }
}

/// Number of halvings of a step after which the storage voltage changes by at most [`POWER_STEP`].
fn halvings(system: &System, regime: &Regime, vector: &[f64], step: f64) -> u32 {
    let rate = value(&regime.storage_rate, vector).abs();
    let curvature = value(&regime.storage_curvature, vector).abs();
    let most = POWER_STEP * value(&system.storage_voltage, vector);
    let change = |halvings: u32| {
        let length = step * 0.5f64.powi(halvings as i32);
        length * (rate + 0.5 * length * curvature)
    };
    (0..DIGITS / 2).find(|halvings| change(*halvings) <= most).unwrap_or(DIGITS / 2)
}

impl Latches {
    /// The first tick within `ticks` at which a guard is above zero after a rise, given the vectors at both ends.
    fn first_rise(
        &mut self,
        system: &System,
        regime: &Regime,
        guard: &Guard,
        [start, end]: [&[f64]; 2],
        ticks: u64,
    ) -> Option<u64> {
        let [after, _] = guard.at(end);
        if guard.change == Change::Contact && self.contact {
            self.contact = after == 0.0;
            return (after > 0.0).then_some(ticks);
        }
        if self.bridge == Some(guard.change) {
            // Where the bridge blocks, the voltage is the threshold to rounding.
            let margin = 64.0 * f64::EPSILON * value(&system.voltage, end).abs();
            if after.abs() <= margin {
                return None;
            }
            self.bridge = None;
            return (after > 0.0).then(|| regime.first_rise(guard, start, end, ticks).unwrap_or(ticks));
        }
        regime.first_rise(guard, start, end, ticks)
    }
}

#[cfg(test)]
mod tests;
