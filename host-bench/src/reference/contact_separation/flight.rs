//! Free motion between events: diffsol's BDF, with impacts located on its dense output.
//!
//! Local time starts at zero with each flight. Impacts are not left to the crate's root finder, which
//! cannot be told that a zero at the start of a flight is no impact: each accepted step is cut where
//! the velocity changes sign, so that the gap is monotone in every piece, and a piece that ends at or
//! below zero holds exactly one impact. So a short hop or a graze inside one step is found too.

use std::cell::RefCell;

use diffsol::error::DiffsolError;
use diffsol::{
    NalgebraLU, NalgebraMat, NalgebraVec, OdeBuilder, OdeSolverMethod, OdeSolverStopReason, Vector,
};

use super::physics::{Motion, Physics};
use crate::reference::base::LocalBase;
use crate::reference::bridge::{Bridge, Harvester, Lookout, Switch, earlier, instants};
use crate::reference::effort::{Effort, one_line};
use crate::reference::integrals::{ALL, Integrals, WITHOUT_BRIDGE};
use crate::reference::root::far_side;

type Matrix = NalgebraMat<f64>;
type Factors = NalgebraLU<f64>;

/// Newton iterations of one step that may fail before the flight does.
const MOST_FAILURES: usize = 50;

/// Steps within which a flight must get on.
const STALL: u64 = 100_000;

/// The integrands.
fn powers(physics: &Physics, motion: &Motion, base: f64) -> Integrals {
    let voltage = physics.voltage(motion);
    let [into_store, diode_loss, leaked, drawn] = physics.store_powers(motion);
    Integrals {
        voltage_squared: voltage * voltage,
        voltage,
        base_work: -physics.mass * base * motion.velocity,
        damper_loss: physics.damper_power(motion),
        surface_work: physics.force(motion) * motion.velocity,
        field_work: physics.field_force(motion) * motion.velocity,
        into_store,
        diode_loss,
        leaked,
        drawn,
    }
}

/// Tolerances, and the sizes that they are relative to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accuracy {
    /// Relative tolerance of the integrator.
    pub(super) relative: f64,
    /// Gap in m, velocity in m/s, voltage in V that are of the size of the solution.
    pub(super) scale: Motion,
    /// A time in s over which the solution changes.
    pub(super) time: f64,
}

impl Accuracy {
    /// Absolute tolerances of the motion and of the integrals: far below the relative one on what is
    /// of full size, because the voltage between its peaks and the speed of a small hop matter too.
    fn absolute(&self, physics: &Physics) -> (Vec<f64>, Vec<f64>) {
        let Self { relative, scale, time } = *self;
        let energy = physics.mass * scale.velocity * scale.velocity;
        let electric = scale.gap
            * physics.field_force(&scale).max(physics.force(&scale)).max(1e-12 * energy / scale.gap);
        let mut motion = vec![scale.gap, scale.velocity, scale.voltage];
        let squared = scale.voltage * scale.voltage * time;
        let mut integrals = vec![squared, scale.voltage * time, energy, energy, electric, electric];
        if let Some(store) = &physics.store {
            let (gain, energies) = store.scales(physics.charge_scale(), energy);
            motion.push(gain);
            integrals.extend(energies);
        }
        let scaled = |sizes: &[f64]| sizes.iter().map(|size| 1e-2 * relative * size).collect();
        (scaled(&motion), scaled(&integrals))
    }
}

/// One accepted step or the part of it before an event, seen from outside.
pub(super) struct Piece<'a> {
    /// Local start in s.
    pub(super) from: f64,
    /// Local end in s.
    pub(super) to: f64,
    /// Local times between the ends at which the velocity changes sign.
    pub(super) turns: &'a [f64],
    /// Motion at any local time between the ends.
    pub(super) motion: &'a dyn Fn(f64) -> Result<Motion, DiffsolError>,
    /// Integrals since the start of the flight, at any local time between the ends.
    pub(super) integrals: &'a dyn Fn(f64) -> Result<Integrals, DiffsolError>,
}

/// What ends a flight before its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Event {
    /// The mass hits the dielectric.
    Impact,
    /// The bridge or the draw behind it switches.
    Switch(Switch),
}

/// How a flight ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Landing {
    /// Local time of the end in s.
    pub(super) elapsed: f64,
    /// The motion there; before the impact if there is one, with a gap of exactly zero.
    pub(super) motion: Motion,
    /// Integrals over the flight.
    pub(super) integrals: Integrals,
    /// What ended it; `None` if the time was up.
    pub(super) event: Option<Event>,
}

/// A failure of the integrator, at a local time and motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FlightFailure {
    pub(super) elapsed: f64,
    pub(super) motion: Motion,
    pub(super) reason: String,
}

/// The motion of state variables, in a regime of the bridge.
fn motion_of(values: &[f64], regime: Bridge) -> Motion {
    match *values {
        [gap, velocity, voltage] => Motion { gap, velocity, voltage, bridge: regime },
        [gap, velocity, voltage, gain] => {
            Motion { gap, velocity, voltage, bridge: Bridge { gain, ..regime } }
        }
        _ => Motion { gap: f64::NAN, velocity: f64::NAN, voltage: f64::NAN, bridge: regime },
    }
}

/// Flies from `start` for `span` seconds or until the impact, and shows each step to `watch`.
///
/// A flight that starts at closed gap without velocity is a release: gap, velocity and acceleration
/// are all zero, so no impact is looked for until the mass has left.
pub(super) fn fly(
    physics: &Physics,
    base: &LocalBase,
    start: Motion,
    span: f64,
    accuracy: &Accuracy,
    effort: &mut Effort,
    mut watch: impl FnMut(&Piece<'_>) -> Result<(), DiffsolError>,
) -> Result<Landing, FlightFailure> {
    let failure = |elapsed: f64, motion: Motion| {
        move |error: DiffsolError| FlightFailure { elapsed, motion, reason: one_line(&error) }
    };
    let (absolute, out_absolute) = accuracy.absolute(physics);
    let (states, integrals_count) = if physics.store.is_some() { (4, ALL) } else { (3, WITHOUT_BRIDGE) };
    let motion_of = |values: &[f64]| motion_of(values, start.bridge);
    let problem = OdeBuilder::<Matrix>::new()
        .rtol(accuracy.relative)
        .atol(absolute)
        .out_rtol(accuracy.relative)
        .out_atol(out_absolute)
        .rhs_implicit(
            |x: &[f64], _: &[f64], t: f64, rates: &mut [f64]| {
                let motion = motion_of(x);
                let [gap, velocity, voltage] = physics.rates(&motion, base.at(t));
                rates.copy_from_slice(&[gap, velocity, voltage, physics.gain_rate(&motion)][..states]);
            },
            |x: &[f64], _: &[f64], _: f64, change: &[f64], rates: &mut [f64]| {
                let (motion, change) = (motion_of(x), motion_of(change));
                let [gap, velocity, voltage] = physics.rates_along(&motion, &change);
                let gain = physics.gain_rate_along(&motion, &change);
                rates.copy_from_slice(&[gap, velocity, voltage, gain][..states]);
            },
        )
        .init(
            |_: &[f64], _: f64, x: &mut [f64]| {
                let Motion { gap, velocity, voltage, bridge } = start;
                x.copy_from_slice(&[gap, velocity, voltage, bridge.gain][..states]);
            },
            states,
        )
        .out_implicit(
            |x: &[f64], _: &[f64], t: f64, powers: &mut [f64]| {
                let all = self::powers(physics, &motion_of(x), base.at(t)).to_array();
                powers.copy_from_slice(&all[..integrals_count]);
            },
            // Asked for in sensitivity runs only.
            |_: &[f64], _: &[f64], _: f64, _: &[f64], change: &mut [f64]| change.fill(0.0),
            integrals_count,
        )
        .integrate_out(true)
        .build()
        .map_err(failure(0.0, start))?;
    let mut solver = problem.bdf::<Factors>().map_err(failure(0.0, start))?;
    // The first step after an impact on a tiny load is tiny.
    solver.config_mut().minimum_timestep = 1e-30;
    solver.set_stop_time(span).map_err(failure(0.0, start))?;

    let clearance = 64.0 * f64::EPSILON * physics.initial_gap;
    let mut lookout = physics.store.as_ref().map(|store| Lookout::new(store, start.bridge, start.voltage));
    let mut armed = start.gap > 0.0 || start.velocity != 0.0;
    let (mut from, mut last) = (0.0, start);
    let mut checked = (0, 0.0);
    loop {
        // The crate counts failures over a whole flight, however long; what counts is those of a step.
        let failures = solver.get_statistics().number_of_nonlinear_solver_fails;
        solver.config_mut().maximum_newton_fails = failures + MOST_FAILURES;
        let stop = solver.step().map_err(failure(from, last));
        let total = Effort::of(solver.get_statistics());
        if stop.is_err() {
            effort.add(&total);
        }
        let finished = matches!(stop?, OdeSolverStopReason::TstopReached);
        let to = solver.state().t;
        let scratch = RefCell::new(NalgebraVec::zeros(states, *problem.context()));
        let motion = |t: f64| -> Result<Motion, DiffsolError> {
            let mut scratch = scratch.borrow_mut();
            solver.interpolate_inplace(t, &mut scratch)?;
            Ok(motion_of(scratch.batch_as_slice(0)))
        };
        let integrals = |t: f64| -> Result<Integrals, DiffsolError> {
            let mut values = NalgebraVec::zeros(integrals_count, *problem.context());
            solver.interpolate_out_inplace(t, &mut values)?;
            Ok(Integrals::of(values.batch_as_slice(0)))
        };
        let mut scan = Scan::new(&motion, from, to, &mut armed, clearance).map_err(failure(from, last))?;
        let mut event = scan.impact.map(|at| (at, Event::Impact));
        if let Some(lookout) = &mut lookout {
            let at = |t: f64| motion(t).map(|motion| (physics.terminals(&motion), motion.bridge));
            let switch = lookout
                .first(&instants(from, event.map_or(to, |(at, _)| at), &scan.turns), &at)
                .map_err(failure(from, last))?;
            event = earlier(event, switch.map(|(at, switch)| (at, Event::Switch(switch))), to - from);
        }
        let end = event.map_or(to, |(at, _)| at);
        scan.turns.retain(|turn| *turn < end);
        watch(&Piece { from, to: end, turns: &scan.turns, motion: &motion, integrals: &integrals })
            .map_err(failure(from, last))?;
        last = motion(end).map_err(failure(from, last))?;
        if !last.gap.is_finite() || last.gap <= -physics.dielectric() {
            effort.add(&total);
            return Err(FlightFailure {
                elapsed: end,
                motion: last,
                reason: "the motion left the model".into(),
            });
        }
        from = end;
        if total.steps > checked.0 + STALL {
            if from - checked.1 < 1e-9 * accuracy.time {
                effort.add(&total);
                let reason = format!("stalled: {STALL} steps without progress");
                return Err(FlightFailure { elapsed: from, motion: last, reason });
            }
            checked = (total.steps, from);
        }
        if event.is_some() || finished {
            effort.add(&total);
            let integrals = integrals(end).map_err(failure(from, last))?;
            let event = event.map(|(_, event)| event);
            if event == Some(Event::Impact) {
                // Exactly on the dielectric, and not even by rounding on the way out.
                last = Motion { gap: 0.0, velocity: last.velocity.min(0.0), ..last };
            }
            return Ok(Landing {
                elapsed: if event.is_some() { end } else { span },
                motion: last,
                integrals,
                event,
            });
        }
    }
}

/// What the guards find in one accepted step.
struct Scan {
    /// Local time of the impact, if there is one.
    impact: Option<f64>,
    /// Local times at which the velocity changes sign, up to the impact.
    turns: Vec<f64>,
}

impl Scan {
    /// Looks through one accepted step; `armed` says whether the mass has left since its release.
    fn new(
        motion: &impl Fn(f64) -> Result<Motion, DiffsolError>,
        from: f64,
        to: f64,
        armed: &mut bool,
        clearance: f64,
    ) -> Result<Self, DiffsolError> {
        let mut scan = Self { impact: None, turns: Vec::new() };
        let middle = from + 0.5 * (to - from);
        let mut begin = (from, motion(from)?);
        for next in [middle, to] {
            let next = (next, motion(next)?);
            let turned = (begin.1.velocity > 0.0) != (next.1.velocity > 0.0) && begin.1.velocity != 0.0;
            let mut ends = [Some(next), None];
            if turned {
                let turn = far_side(|t| Ok::<_, DiffsolError>(motion(t)?.velocity), begin.0, next.0)?;
                scan.turns.push(turn);
                ends = [Some((turn, motion(turn)?)), Some(next)];
            }
            for end in ends.into_iter().flatten() {
                if !*armed {
                    *armed = end.1.velocity > 0.0 && end.1.gap > clearance;
                    if end.1.gap < -clearance {
                        // Pressed back before it had left.
                        scan.impact = Some(end.0);
                        return Ok(scan);
                    }
                } else if end.1.gap <= 0.0 && end.1.gap < begin.1.gap {
                    let hit = if begin.1.gap > 0.0 {
                        far_side(|t| Ok::<_, DiffsolError>(motion(t)?.gap), begin.0, end.0)?
                    } else {
                        begin.0
                    };
                    scan.turns.retain(|turn| *turn < hit);
                    scan.impact = Some(hit);
                    return Ok(scan);
                }
                begin = end;
            }
        }
        Ok(scan)
    }
}
