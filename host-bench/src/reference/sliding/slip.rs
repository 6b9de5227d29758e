//! Slip between events: diffsol's BDF, with the events located on its dense output.
//!
//! Local time starts at zero with each slip. In one slip the direction of the friction and the side of
//! the middle are fixed, so the equations are smooth. Events are not left to the crate's root finder,
//! which cannot be told that a zero at the start of a slip is none: each accepted step is cut where the
//! acceleration changes sign, so that the velocity is monotone in every piece, and again where the
//! velocity does, so that the displacement is. A piece then holds at most one zero of each.

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

/// Newton iterations of one step that may fail before the slip does.
const MOST_FAILURES: usize = 50;

/// Part of two patch radii that a displacement must not reach. A ten-millionth before its end the overlap
/// is 4e-11 of a disc, and with it the time constant of the circuit: nothing of a device is left there,
/// and the rates of what is left of the model are beyond any integrator.
pub(super) const REACH: f64 = 1.0 - 1e-7;

/// Steps within which a slip must get on by a millionth of a radian of the beam: a slider that is caught
/// where the overlap ends may be slowed to less.
const STALL: u64 = 100_000;

/// The integrands.
fn powers(physics: &Physics, motion: &Motion, direction: f64, base: f64) -> Integrals {
    let voltage = physics.voltage(motion);
    let [base_work, damper_loss, surface_work, field_work] = physics.powers(motion, direction, base);
    let [into_store, diode_loss, leaked, drawn] = physics.store_powers(motion);
    Integrals {
        voltage_squared: voltage * voltage,
        voltage,
        base_work,
        damper_loss,
        surface_work,
        field_work,
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
    /// A displacement in m, a velocity in m/s and a voltage in V that are of the size of the solution.
    pub(super) scale: [f64; 3],
    /// A time in s over which the solution changes.
    pub(super) time: f64,
}

impl Accuracy {
    /// Absolute tolerances of the motion and of the integrals: far below the relative one on what is
    /// of full size, because a creeping motion in stick-slip matters too.
    fn absolute(&self, physics: &Physics) -> (Vec<f64>, Vec<f64>) {
        let Self { relative, scale, time } = *self;
        let [_, velocity, voltage] = scale;
        let energy = physics.beam.modal_mass * velocity * velocity;
        let squared = voltage * voltage * time;
        let mut integrals = vec![squared, voltage * time, energy, energy, energy, energy];
        let mut motion = scale.to_vec();
        if let Some(store) = &physics.store {
            let (gain, energies) = store.scales(physics.charge_scale(), energy);
            motion.push(gain);
            integrals.extend(energies);
        }
        let scaled = |sizes: &[f64]| sizes.iter().map(|size| 1e-2 * relative * size).collect();
        (scaled(&motion), scaled(&integrals))
    }

    /// Displacement and velocity that are not told from zero at the start of a slip.
    fn clearance(&self) -> [f64; 2] {
        let [displacement, velocity, _] = self.scale;
        [displacement, velocity].map(|size| 64.0 * f64::EPSILON * size)
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
    /// Integrals since the start of the slip, at any local time between the ends.
    pub(super) integrals: &'a dyn Fn(f64) -> Result<Integrals, DiffsolError>,
}

/// What ends a slip before its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Event {
    /// The velocity is zero.
    Stop,
    /// The slider passes the middle.
    Middle,
    /// The discs do not overlap any more, to [`REACH`].
    End,
    /// The bridge or the draw behind it switches.
    Switch(Switch),
}

/// How a slip ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SlipEnd {
    /// Local time of the end in s.
    pub(super) elapsed: f64,
    /// The motion there.
    pub(super) motion: Motion,
    /// Integrals over the slip.
    pub(super) integrals: Integrals,
    /// What ended it; `None` if the time was up.
    pub(super) event: Option<Event>,
}

/// A failure of the integrator, at a local time and motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SlipFailure {
    pub(super) elapsed: f64,
    pub(super) motion: Motion,
    pub(super) reason: String,
}

/// A slip from local time zero on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slip<'a> {
    pub(super) physics: &'a Physics,
    pub(super) base: &'a LocalBase,
    /// The motion at local time zero.
    pub(super) start: Motion,
    /// 1 or −1, or 0 without friction.
    pub(super) direction: f64,
}

impl Slip<'_> {
    /// Slips for `span` seconds or until an event, and shows each step to `watch`.
    ///
    /// A slip begins without velocity after a stop, and in the middle after passing it: the same event is
    /// not looked for until the slider has left that place.
    pub(super) fn run(
        &self,
        span: f64,
        accuracy: &Accuracy,
        effort: &mut Effort,
        mut watch: impl FnMut(&Piece<'_>) -> Result<(), DiffsolError>,
    ) -> Result<SlipEnd, SlipFailure> {
        let Self { physics, base, start, direction } = *self;
        let failure = |elapsed: f64, motion: Motion| {
            move |error: DiffsolError| SlipFailure { elapsed, motion, reason: one_line(&error) }
        };
        let (states, integrals_count) = if physics.store.is_some() { (4, ALL) } else { (3, WITHOUT_BRIDGE) };
        let motion_of = |values: &[f64]| match *values {
            [displacement, velocity, voltage] => Motion { displacement, velocity, voltage, ..start },
            [displacement, velocity, voltage, gain] => {
                Motion { displacement, velocity, voltage, bridge: Bridge { gain, ..start.bridge }, ..start }
            }
            _ => Motion { displacement: f64::NAN, ..start },
        };
        let (absolute, out_absolute) = accuracy.absolute(physics);
        let problem = OdeBuilder::<Matrix>::new()
            .rtol(accuracy.relative)
            .atol(absolute)
            .out_rtol(accuracy.relative)
            .out_atol(out_absolute)
            .rhs_implicit(
                |x: &[f64], _: &[f64], t: f64, rates: &mut [f64]| {
                    let motion = motion_of(x);
                    let [displacement, velocity, voltage] = physics.rates(&motion, direction, base.at(t));
                    let gain = physics.gain_rate(&motion);
                    rates.copy_from_slice(&[displacement, velocity, voltage, gain][..states]);
                },
                |x: &[f64], _: &[f64], _: f64, change: &[f64], rates: &mut [f64]| {
                    let (motion, change) = (motion_of(x), motion_of(change));
                    let [displacement, velocity, voltage] = physics.rates_along(&motion, direction, &change);
                    let gain = physics.gain_rate_along(&motion, &change);
                    rates.copy_from_slice(&[displacement, velocity, voltage, gain][..states]);
                },
            )
            .init(
                |_: &[f64], _: f64, x: &mut [f64]| {
                    let Motion { displacement, velocity, voltage, bridge, .. } = start;
                    x.copy_from_slice(&[displacement, velocity, voltage, bridge.gain][..states]);
                },
                states,
            )
            .out_implicit(
                |x: &[f64], _: &[f64], t: f64, powers: &mut [f64]| {
                    let all = self::powers(physics, &motion_of(x), direction, base.at(t)).to_array();
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
        // The first step with a tiny load is tiny.
        solver.config_mut().minimum_timestep = 1e-30;
        solver.set_stop_time(span).map_err(failure(0.0, start))?;

        let mut lookout =
            physics.store.as_ref().map(|store| Lookout::new(store, start.bridge, start.voltage));
        let mut guards = Guards::new(physics, direction, &start, accuracy.clearance());
        let (mut from, mut last) = (0.0, start);
        let mut checked = (0, 0.0);
        loop {
            // The crate counts failures over a whole slip, however long; what counts is those of a step.
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
            let acceleration = |t: f64| -> Result<f64, DiffsolError> {
                let [_, acceleration, _] = physics.rates(&motion(t)?, direction, base.at(t));
                Ok(acceleration)
            };
            let mut found = guards.look(&motion, &acceleration, from, to).map_err(failure(from, last))?;
            if let Some(lookout) = &mut lookout {
                let at = |t: f64| motion(t).map(|motion| (physics.terminals(&motion), motion.bridge));
                let until = found.event.map_or(to, |(t, _)| t);
                let switch =
                    lookout.first(&instants(from, until, &found.turns), &at).map_err(failure(from, last))?;
                let switch = switch.map(|(t, switch)| (t, Event::Switch(switch)));
                found.event = earlier(found.event, switch, to - from);
            }
            let end = found.event.map_or(to, |(t, _)| t);
            found.turns.retain(|turn| *turn < end);
            watch(&Piece { from, to: end, turns: &found.turns, motion: &motion, integrals: &integrals })
                .map_err(failure(from, last))?;
            last = motion(end).map_err(failure(from, last))?;
            if !(last.displacement.is_finite() && last.velocity.is_finite() && last.voltage.is_finite()) {
                effort.add(&total);
                let reason = "the motion left the model".into();
                return Err(SlipFailure { elapsed: end, motion: last, reason });
            }
            from = end;
            if total.steps > checked.0 + STALL {
                if from - checked.1 < 1e-6 * accuracy.time {
                    effort.add(&total);
                    let reason = format!("stalled: {STALL} steps without progress");
                    return Err(SlipFailure { elapsed: from, motion: last, reason });
                }
                checked = (total.steps, from);
            }
            if found.event.is_some() || finished {
                effort.add(&total);
                let integrals = integrals(end).map_err(failure(from, last))?;
                let event = found.event.map(|(_, event)| event);
                let elapsed = if event.is_some() { end } else { span };
                return Ok(SlipEnd { elapsed, motion: last, integrals, event });
            }
        }
    }
}

/// What the guards find in one accepted step.
struct Found {
    /// Local time of the first event and what it is, if there is one.
    event: Option<(f64, Event)>,
    /// Local times at which the velocity changes sign, up to the event.
    turns: Vec<f64>,
}

/// What is looked for in a slip, and whether the slider has left where it began.
struct Guards {
    direction: f64,
    side: f64,
    /// Displacement in m at which the overlap ends.
    reach: f64,
    clearance: [f64; 2],
    has_left_middle: bool,
    has_left_rest: bool,
}

type Dense<'a> = dyn Fn(f64) -> Result<Motion, DiffsolError> + 'a;

impl Guards {
    fn new(physics: &Physics, direction: f64, start: &Motion, clearance: [f64; 2]) -> Self {
        let reach = REACH * 2.0 * physics.radius;
        let mut guards = Self {
            direction,
            side: start.side,
            reach,
            clearance,
            has_left_middle: false,
            has_left_rest: false,
        };
        guards.arm(start);
        guards
    }

    fn arm(&mut self, motion: &Motion) {
        let [displacement, velocity] = self.clearance;
        self.has_left_middle |= self.side * motion.displacement > displacement;
        self.has_left_rest |= self.direction * motion.velocity > velocity;
    }

    /// Looks through one accepted step.
    fn look(
        &mut self,
        motion: &Dense<'_>,
        acceleration: &dyn Fn(f64) -> Result<f64, DiffsolError>,
        from: f64,
        to: f64,
    ) -> Result<Found, DiffsolError> {
        let mut found = Found { event: None, turns: Vec::new() };
        // Instants between which the velocity is monotone.
        let middle = from + 0.5 * (to - from);
        let mut instants = vec![from];
        for [left, right] in [[from, middle], [middle, to]] {
            if (acceleration(left)? > 0.0) != (acceleration(right)? > 0.0) {
                instants.push(far_side(acceleration, left, right)?);
            }
            instants.push(right);
        }
        let mut begin = (from, motion(from)?);
        for next in instants.into_iter().skip(1) {
            let next = (next, motion(next)?);
            let mut ends = [Some(next), None];
            if (begin.1.velocity > 0.0) != (next.1.velocity > 0.0) && begin.1.velocity != 0.0 {
                let turn = far_side(|t| Ok::<_, DiffsolError>(motion(t)?.velocity), begin.0, next.0)?;
                ends = [Some((turn, motion(turn)?)), Some(next)];
            }
            for end in ends.into_iter().flatten() {
                found.event = self.event(motion, begin, end)?;
                if found.event.is_some() {
                    return Ok(found);
                }
                if ends[1].is_some() && end.0 < next.0 {
                    found.turns.push(end.0);
                }
                self.arm(&end.1);
                begin = end;
            }
        }
        Ok(found)
    }

    /// The first event in a piece in which velocity and displacement are monotone.
    fn event(
        &self,
        motion: &Dense<'_>,
        begin: (f64, Motion),
        end: (f64, Motion),
    ) -> Result<Option<(f64, Event)>, DiffsolError> {
        let [displacement, velocity] = self.clearance;
        let (side, direction, reach) = (self.side, self.direction, self.reach);
        let crossing = |value: &dyn Fn(&Motion) -> f64| {
            far_side(|t| Ok::<_, DiffsolError>(value(&motion(t)?)), begin.0, end.0)
        };
        let away = side * end.1.displacement;
        let place = if away >= reach {
            Some((crossing(&|motion| side * motion.displacement - reach)?, Event::End))
        } else if self.has_left_middle && away <= 0.0 {
            Some((crossing(&|motion| side * motion.displacement)?, Event::Middle))
        } else if !self.has_left_middle && away < -displacement {
            // It left to the other side.
            Some((end.0, Event::Middle))
        } else {
            None
        };
        let onward = direction * end.1.velocity;
        let rest = if self.has_left_rest && onward <= 0.0 {
            Some((crossing(&|motion| direction * motion.velocity)?, Event::Stop))
        } else if !self.has_left_rest && onward < -velocity {
            // Driven back before it had begun to move.
            Some((end.0, Event::Stop))
        } else {
            None
        };
        Ok(match (place, rest) {
            (Some(place), Some(rest)) if rest.0 < place.0 => Some(rest),
            (place, rest) => place.or(rest),
        })
    }
}
