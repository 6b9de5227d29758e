//! The reference for the contact-separation harvester: flights, impacts and holds.

mod flight;
mod hold;
mod measure;
mod physics;

use std::time::Instant;

use self::flight::{Accuracy, Event, fly};
use self::hold::Hold;
use self::measure::Meters;
use self::physics::{Motion, Physics};
use super::base::Base;
use super::bridge::{Bridge, Harvester};
use super::effort::Effort;
use super::{ReferenceOptions, StepFailure};
use crate::outcome::{Outcome, Particular};
use crate::scene_file::{ContactSeparation, Scene};

/// Events in a row that may pass without time doing so.
const STORM: u32 = 10_000;

/// Whether the mass is free or held on the dielectric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Free,
    Held,
}

/// Runs the scene from its start to its end.
pub(super) fn run(
    scene: &Scene,
    model: &ContactSeparation,
    options: &ReferenceOptions,
) -> Result<Outcome, StepFailure> {
    let began = Instant::now();
    let parameters = &model.parameters;
    let (physics, start) = Physics::new(parameters, scene.load, &model.initial);
    let angular_frequency = (parameters.stiffness_n_per_m / parameters.mass_kg).sqrt();
    let accuracy = Accuracy {
        relative: options.tolerance,
        scale: Motion {
            gap: parameters.initial_gap_m,
            velocity: parameters.initial_gap_m * angular_frequency,
            voltage: physics.voltage_scale(&start, angular_frequency),
            bridge: Bridge::default(),
        },
        time: 1.0 / angular_frequency,
    };
    let base = Base(&scene.excitation);
    let mut meters = Meters::new(&physics, &start, options.record_every);
    let mut effort = Effort::default();
    let (mut time, mut motion, mut events) = (0.0, start, 0u64);
    let mut mode = if motion.gap == 0.0
        && motion.velocity == 0.0
        && physics.contact_force(&motion, base.from(0.0).at(0.0)) > 0.0
    {
        physics.come_to_rest(&mut motion);
        Mode::Held
    } else {
        Mode::Free
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
        let (elapsed, event) = match mode {
            Mode::Free => {
                let landing = fly(&physics, &local_base, motion, span, &accuracy, &mut effort, |piece| {
                    meters.watch(time, &local_base, piece)
                })
                .map_err(|failure| StepFailure {
                    reason: failure.reason,
                    time_s: time + failure.elapsed,
                    state: describe(&failure.motion),
                })?;
                meters.add(&landing.integrals);
                motion = landing.motion;
                match landing.event {
                    None => {}
                    Some(Event::Switch(switch)) => meters.add(&physics.switch(switch, &mut motion)),
                    Some(Event::Impact) => {
                        let acceleration = local_base.at(landing.elapsed);
                        let at = time + landing.elapsed;
                        if rebound(&physics, &mut motion, acceleration, &mut meters, at) {
                            mode = Mode::Held;
                            meters.add(&physics.come_to_rest(&mut motion));
                        } else {
                            meters.add(&physics.settle(&mut motion));
                        }
                    }
                }
                (landing.elapsed, landing.event.is_some())
            }
            Mode::Held => {
                let hold = Hold { physics: &physics, base: &local_base, start: motion };
                let switch = hold.switch(span);
                let release = hold.release(switch.map_or(span, |(at, _)| at));
                let elapsed = release.or(switch.map(|(at, _)| at)).unwrap_or(span);
                meters.watch_hold(time, elapsed, &hold).map_err(|error| StepFailure {
                    reason: error.to_string(),
                    time_s: time,
                    state: describe(&motion),
                })?;
                motion = hold.motion(elapsed);
                if release.is_some() {
                    mode = Mode::Free;
                    meters.add(&physics.settle(&mut motion));
                } else if let Some((_, switch)) = switch {
                    meters.add(&physics.switch_at_rest(switch, &mut motion));
                }
                (elapsed, release.is_some() || switch.is_some())
            }
        };
        time = if event { (time + elapsed).min(whole) } else { whole };
        if event {
            events += 1;
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
    let totals = meters.close(scene, parameters.force_law, &motion);
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
        particular: Particular::ContactSeparation(totals.particular),
        store: totals.store,
        steady_state: None,
        trace: totals.recording,
    })
}

/// The impact: `v⁺ = −e(|v⁻|) v⁻`, equation (21), charge and voltage continuous. Returns whether the
/// mass stays: when it would leave slower than the model's threshold although it is pressed down.
fn rebound(physics: &Physics, motion: &mut Motion, base: f64, meters: &mut Meters<'_>, time: f64) -> bool {
    let speed = -motion.velocity;
    let energy_before = physics.mechanical_energy(motion);
    motion.velocity = physics.restitution(speed) * speed;
    let held = motion.velocity < physics.stick_speed && physics.contact_force(motion, base) > 0.0;
    if held {
        motion.velocity = 0.0;
    }
    meters.impact(time, speed, energy_before - physics.mechanical_energy(motion));
    held
}

fn describe(motion: &Motion) -> String {
    let Motion { gap, velocity, voltage, .. } = motion;
    format!("gap {gap:e} m, velocity {velocity:e} m/s, voltage {voltage:e} V")
}

#[cfg(test)]
mod tests;
