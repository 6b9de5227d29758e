//! The marching loop that contact-separation and sliding share: flow, stick, and the jumps between them.

mod bridge;
mod flow;
mod harvester;
mod meter;
mod radau;
mod stick;

use cpu_time::ThreadTime;

pub(crate) use self::bridge::ElectricalPort;
use self::flow::{Event, Flow};
pub(crate) use self::harvester::{
    Branch, CircuitKind, Counts, Dense, Guards, Harvester, Jump, LoadCircuit, Mode, Motion, Sample, Scales,
    VACUUM_PERMITTIVITY,
};
use self::meter::Meter;
use self::radau::Reason;
pub(crate) use self::stick::Stick;
use super::ledger::Effort;
use super::schedule::{Schedule, Stretch};
use super::{ReferenceOptions, StepFailure};
use harvester_scene::base_motion::Base;
use harvester_scene::outcome::Outcome;
use harvester_scene::progress;
use harvester_scene::scene_file::Scene;

/// Part of the time scale of the motion that counts as progress between events.
const PROGRESS: f64 = 1e-9;

/// The state of a run.
struct March<'a, H: Harvester> {
    harvester: &'a H,
    scales: Scales,
    tolerance: f64,
    meter: Meter<'a, H>,
    motion: Motion,
    mode: Mode,
    events: u64,
    effort: Effort,
}

/// Runs a scene from its start to its end.
pub(super) fn run<H: Harvester>(
    scene: &Scene,
    (harvester, start): (H, Motion),
    options: &ReferenceOptions,
) -> Result<Outcome, StepFailure> {
    let began = ThreadTime::now();
    let scales = harvester.scales(&start);
    let mut schedule = Schedule::new(scene, false, f64::INFINITY, PROGRESS * scales.time);
    let mut march = March {
        harvester: &harvester,
        scales,
        tolerance: options.tolerance,
        meter: Meter::new(&harvester, &start, options.record_every),
        motion: start,
        mode: Mode::Flow,
        events: 0,
        effort: Effort::default(),
    };
    march.meter.ledger.in_window = scene.run.settle_s <= 0.0;
    march.start(Base(&scene.excitation).from(0.0).at(0.0));
    progress::begin();
    while let Some(stretch) = schedule.next() {
        if options.most_steps.is_some_and(|most| march.effort.attempts() > most) {
            let reason = format!("given up after {} steps", march.effort.steps);
            return Err(march.failure(reason, stretch.start));
        }
        march.meter.ledger.in_window = stretch.in_window;
        progress::report(stretch.start / scene.run.duration_s, [march.effort.steps, march.events]);
        let event = match march.mode {
            Mode::Flow => march.flow(&stretch)?,
            Mode::Stick => march.stick(&stretch),
        };
        if let Err(reason) = schedule.advance(&stretch, event) {
            return Err(march.failure(reason, schedule.time));
        }
    }
    let March { meter, motion, events, effort, .. } = march;
    Ok(meter.close(scene, &motion, events, effort).outcome(scene, began))
}

impl<H: Harvester> March<'_, H> {
    /// Finds the mode at the start, under a base acceleration in m/s². A start charge above the threshold of the bridge
    /// is shared with the storage at once.
    fn start(&mut self, base: f64) {
        self.mode = self.harvester.start(&mut self.motion, base);
        self.share();
    }

    /// Flows through a stretch or to the first event, and gives the time of the event in s since the start of the stretch.
    fn flow(&mut self, stretch: &Stretch) -> Result<Option<f64>, StepFailure> {
        let Stretch { start, span, base, .. } = stretch;
        let Self { harvester, meter, scales, tolerance, .. } = self;
        let flow = Flow { harvester: *harvester, base, start: self.motion, scales, tolerance: *tolerance };
        let mut last = (0.0, self.motion);
        let end = flow.run(*span, &mut self.effort, &mut last, &mut |step| meter.watch(*start, base, step));
        let (elapsed, time) = (last.0, start + last.0);
        self.motion = last.1;
        let (integrals, event) = end.map_err(|Reason(reason)| self.failure(reason, time))?;
        self.meter.ledger.add(&integrals);
        match event {
            None => return Ok(None),
            Some(Event::Switch(switch)) => {
                self.events += 1;
                self.meter.ledger.add(&self.harvester.switch(switch, Mode::Flow, &mut self.motion));
            }
            Some(Event::Scene(event)) => {
                let jump = self.harvester.jump(event, &mut self.motion, base.at(elapsed));
                self.jump(jump.map_err(|reason| self.failure(reason, time))?, time);
            }
        }
        Ok(Some(elapsed))
    }

    /// Books a jump of the motion at `time` seconds.
    fn jump(&mut self, jump: Jump, time: f64) {
        self.events += u64::from(jump.counts);
        if let Some(impact) = jump.impact {
            self.meter.impact(time, impact);
        }
        self.mode = jump.mode;
        if jump.mode == Mode::Stick {
            self.meter.stick();
        }
        self.share();
    }

    /// Lets the bridge find its regime, and books the energies of a charge that is shared at once.
    fn share(&mut self) {
        let shared = match self.mode {
            Mode::Flow => self.harvester.find_bridge_regime(&mut self.motion),
            Mode::Stick => self.harvester.enter_stick(&mut self.motion),
        };
        self.meter.ledger.add(&shared);
    }

    /// Sticks through a stretch or to the first event, and gives the time of the event in s since the start of the stretch.
    fn stick(&mut self, stretch: &Stretch) -> Option<f64> {
        let Stretch { start, span, base, .. } = stretch;
        let stick = Stick { harvester: self.harvester, base, start: self.motion };
        let switch = stick.switch(*span);
        let release = stick.release(switch.map_or(*span, |(at, _)| at));
        let event = release.or(switch.map(|(at, _)| at));
        let elapsed = event.unwrap_or(*span);
        self.meter.watch_stick(*start, elapsed, &stick);
        self.motion = stick.motion(elapsed);
        self.events += u64::from(event.is_some());
        if release.is_some() {
            self.mode = Mode::Flow;
            self.harvester.release(&mut self.motion, base.at(elapsed));
            self.meter.ledger.add(&self.harvester.find_bridge_regime(&mut self.motion));
        } else if let Some((_, switch)) = switch {
            self.meter.ledger.add(&self.harvester.switch(switch, Mode::Stick, &mut self.motion));
        }
        event
    }

    fn failure(&self, reason: String, time_s: f64) -> StepFailure {
        let Motion { position, velocity, voltage, .. } = self.motion;
        let name = H::POSITION;
        let state = format!("{name} {position:e} m, velocity {velocity:e} m/s, voltage {voltage:e} V");
        StepFailure { reason, time_s, state }
    }
}

#[cfg(test)]
pub(crate) mod tests;
