//! The reference for the sliding harvester: slip in either direction, and stick.

mod measure;
mod overlap;
mod physics;
mod slip;
mod stick;

use std::time::Instant;

use self::measure::Meters;
use self::physics::{Motion, Physics};
use self::slip::{Accuracy, Event, Slip};
use self::stick::Stick;
use super::base::Base;
use super::bridge::Harvester;
use super::effort::Effort;
use super::{ReferenceOptions, StepFailure};
use crate::outcome::{Outcome, Particular};
use crate::scene_file::{Scene, Sliding};

/// Events in a row that may pass without time doing so.
const STORM: u32 = 10_000;

/// Whether the slider moves over the patches or is held by them.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    /// In the direction 1 or −1; 0 without friction, where it does not matter.
    Slip {
        direction: f64,
    },
    Stick,
}

/// What a slider without velocity does: it sticks if static friction can hold it, else it slips where
/// it is driven, equations (9) to (11).
fn at_rest(physics: &Physics, motion: &mut Motion, base: f64) -> Mode {
    motion.velocity = 0.0;
    let needed = physics.holding_friction(motion, base);
    if physics.is_frictionless() {
        set_out(motion, -needed);
        Mode::Slip { direction: 0.0 }
    } else if needed.abs() <= physics.most_static_friction(motion) {
        Mode::Stick
    } else {
        release(physics, motion, base)
    }
}

/// Slip where the slider is driven.
fn release(physics: &Physics, motion: &mut Motion, base: f64) -> Mode {
    let needed = physics.holding_friction(motion, base);
    let direction = if needed > 0.0 { -1.0 } else { 1.0 };
    set_out(motion, direction);
    Mode::Slip { direction: if physics.is_frictionless() { 0.0 } else { direction } }
}

/// From the middle the overlap is taken on the side to which the slider goes.
fn set_out(motion: &mut Motion, direction: f64) {
    if motion.displacement == 0.0 && direction != 0.0 {
        motion.side = direction.signum();
    }
}

/// Runs the scene from its start to its end.
pub(super) fn run(
    scene: &Scene,
    model: &Sliding,
    options: &ReferenceOptions,
) -> Result<Outcome, StepFailure> {
    let began = Instant::now();
    let (physics, mut motion) = Physics::new(&model.parameters, scene.load, &model.initial);
    let angular_frequency = physics.beam.angular_frequency;
    let accuracy = Accuracy {
        relative: options.tolerance,
        scale: [physics.radius, physics.radius * angular_frequency, physics.voltage_scale(&motion)],
        time: 1.0 / angular_frequency,
    };
    let base = Base(&scene.excitation);
    let mut meters = Meters::new(&physics, &motion, options.record_every);
    let mut effort = Effort::default();
    let (mut time, mut events) = (0.0, 0u64);
    let mut mode = if motion.velocity == 0.0 {
        let mode = at_rest(&physics, &mut motion, base.from(0.0).at(0.0));
        if mode == Mode::Stick {
            meters.add(&physics.come_to_rest(&mut motion));
        }
        mode
    } else {
        let direction = motion.velocity.signum();
        set_out(&mut motion, direction);
        Mode::Slip { direction: if physics.is_frictionless() { 0.0 } else { direction } }
    };
    let (mut storm, mut storm_began) = (0, 0.0);
    while time < scene.run.duration_s {
        if options.most_steps.is_some_and(|most| effort.steps > most) {
            return Err(StepFailure {
                reason: format!("given up after {} steps", effort.steps),
                time_s: time,
                state: describe(&motion),
            });
        }
        let in_window = time >= scene.run.settle_s;
        meters.set_in_window(in_window);
        let boundary = if in_window { scene.run.duration_s } else { scene.run.settle_s };
        let local_base = base.from(time);
        let span = (boundary - time).min(local_base.smooth_for());
        // What absolute time cannot hold.
        if span <= 8.0 * f64::EPSILON * time {
            time = boundary.min(time + span.max(f64::EPSILON * time));
            continue;
        }
        let whole = if span == boundary - time { boundary } else { time + span };
        let (elapsed, cut) = match mode {
            Mode::Slip { direction } => {
                let slip = Slip { physics: &physics, base: &local_base, start: motion, direction };
                let end = slip
                    .run(span, &accuracy, &mut effort, |piece| meters.watch(time, &slip, piece))
                    .map_err(|failure| StepFailure {
                        reason: failure.reason,
                        time_s: time + failure.elapsed,
                        state: describe(&failure.motion),
                    })?;
                meters.add(&end.integrals);
                motion = end.motion;
                match end.event {
                    None => {}
                    Some(Event::Stop) => {
                        events += 1;
                        mode = at_rest(&physics, &mut motion, local_base.at(end.elapsed));
                        if mode == Mode::Stick {
                            meters.stick();
                            meters.add(&physics.come_to_rest(&mut motion));
                        } else {
                            meters.add(&physics.settle(&mut motion));
                        }
                    }
                    Some(Event::Switch(switch)) => {
                        events += 1;
                        meters.add(&physics.switch(switch, &mut motion));
                    }
                    Some(Event::Middle) => {
                        motion.displacement = 0.0;
                        motion.side = -motion.side;
                        meters.add(&physics.settle(&mut motion));
                    }
                    Some(Event::End) => {
                        return Err(StepFailure {
                            reason: format!(
                                "the slider left the active patch: displacement {:e} m, must stay below \
                                 {:e} m (two patch radii) in magnitude",
                                motion.displacement,
                                2.0 * physics.radius
                            ),
                            time_s: time + end.elapsed,
                            state: describe(&motion),
                        });
                    }
                }
                (end.elapsed, end.event.is_some())
            }
            Mode::Stick => {
                let stick = Stick { physics: &physics, base: &local_base, start: motion };
                let switch = stick.switch(span);
                let given_way = stick.release(switch.map_or(span, |(at, _)| at));
                let elapsed = given_way.or(switch.map(|(at, _)| at)).unwrap_or(span);
                meters.watch_stick(time, elapsed, &stick).map_err(|error| StepFailure {
                    reason: error.to_string(),
                    time_s: time,
                    state: describe(&motion),
                })?;
                motion = stick.motion(elapsed);
                if given_way.is_some() {
                    events += 1;
                    mode = release(&physics, &mut motion, local_base.at(elapsed));
                    meters.add(&physics.settle(&mut motion));
                } else if let Some((_, switch)) = switch {
                    events += 1;
                    meters.add(&physics.switch_at_rest(switch, &mut motion));
                }
                (elapsed, given_way.is_some() || switch.is_some())
            }
        };
        time = if cut { (time + elapsed).min(whole) } else { whole };
        if cut {
            if time > storm_began + 1e-9 * accuracy.time {
                (storm, storm_began) = (0, time);
            }
            storm += 1;
            if storm > STORM {
                return Err(StepFailure {
                    reason: format!("event storm: {STORM} events without progress"),
                    time_s: time,
                    state: describe(&motion),
                });
            }
        }
    }
    let totals = meters.close(scene, &model.parameters, &motion);
    Ok(Outcome {
        scene: scene.name(),
        method: "reference".to_owned(),
        precision: "f64",
        math: "std",
        duration_s: scene.run.duration_s,
        settle_s: scene.run.settle_s,
        mean_power_w: Some(totals.mean_power),
        rms_voltage_v: Some(totals.rms_voltage),
        peak_voltage_v: Some(totals.peak_voltage),
        mean_voltage_v: Some(totals.mean_voltage),
        delivered_energy_j: Some(totals.delivered_energy),
        energy_residual: totals.energy_residual,
        steps: effort.steps,
        rejected_steps: effort.rejected,
        newton_iterations: effort.newton_iterations,
        events,
        wall_s: began.elapsed().as_secs_f64(),
        particular: Particular::Sliding(totals.particular),
        store: totals.store,
        steady_state: None,
        trace: totals.recording,
    })
}

fn describe(motion: &Motion) -> String {
    let Motion { displacement, velocity, voltage, .. } = motion;
    format!("displacement {displacement:e} m, velocity {velocity:e} m/s, voltage {voltage:e} V")
}

#[cfg(test)]
mod tests;
