//! Advances a hybrid state: step, event location, jump.

use super::attempt::{Attempts, MOST_ATTEMPTS, MOST_GUARDS, Memo, bit};
use super::outcome::{Advance, Ended, StepError, StepFailure, Work};
use super::search::Search;
use super::{Automaton, Guard, HybridState, InputAt};
use crate::clock::{Instant, seconds_of_ticks, ticks_of_seconds};
use crate::excitation::Excitation;
use crate::integrate::control_memory::ControlMemory;
use crate::integrate::step_control::{ErrorScale, StepErrors, Verdict};
use crate::integrate::{Method, NotConverged, Point, StepControl, System, Trial};
use crate::observer::{AcceptedStep, Contact, Event, Observer, Outputs, PowerIndex};
use crate::scalar::Scalar;

/// Most attempts of [`Driver::advance`] before it can pause: one step and the location of one event. A
/// smaller budget is raised to this number.
pub const LEAST_BUDGET: u32 = MOST_ATTEMPTS + 2;

/// Number of successive events, each within [`CROWDED_TICKS`] of the event before, beyond which
/// [`StepFailure::EventStorm`] is returned.
pub(super) const MOST_CROWDED_EVENTS: u8 = 64;
/// One nanosecond in ticks.
const CROWDED_TICKS: u32 = 275;
/// Time after an event in ticks (15 µs) within which a method without prediction takes a boundary layer out of its steps:
/// the first step may be shorter than the layer.
const LAYER_TICKS: u32 = 1 << 22;
/// Longest step in ticks (61 µs) whose end outside the domain is an error.
const DOMAIN_TICKS: u32 = 1 << 24;
/// Shortest step that may be shortened, in ticks (15 ps).
const SHORTEST_TICKS: u32 = 4;

/// An integration method with a step control.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Driver<M, C> {
    /// The method.
    pub method: M,
    /// The step control.
    pub control: C,
    /// Whether [`Driver::advance`] returns after each event.
    pub pause_at_events: bool,
}

/// An accepted step.
struct TakenStep<S, const N: usize, const P: usize> {
    trial: Trial<S, N, P>,
    ticks: u32,
    /// The guard at which the step ends.
    event: Option<usize>,
    /// Whether event location ran; a guard may then be due at the end of the step.
    searched: bool,
    /// Guards at its end.
    memo: Memo<S>,
}

/// A number of ticks times a factor of at least 1.
#[inline]
fn lengthened<S: Scalar>(ticks: u32, factor: S) -> u32 {
    if factor > S::ONE { (factor * S::from_u32(ticks)).to_u32() } else { ticks }
}

impl<M, C> Driver<M, C> {
    /// A driver that does not pause at events.
    #[must_use]
    pub const fn new(method: M, control: C) -> Self {
        Self { method, control, pause_at_events: false }
    }

    /// Advances `state` to `until` in at most `budget` attempted steps.
    ///
    /// The bits of the result do not depend on budgets and pauses. They depend on `until`, because a step ends there.
    ///
    /// # Errors
    /// [`StepError`]; `state` is then the last good state, and `observer` has seen all steps before the failed one.
    #[inline]
    pub fn advance<S, A, E, O, const N: usize, const P: usize>(
        &self,
        automaton: &A,
        state: &mut HybridState<S, A::Mode, N, P>,
        excitation: &E,
        until: Instant,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>>
    where
        S: Scalar,
        M: Method<S>,
        C: StepControl<S>,
        A: Automaton<S, N, P>,
        E: Excitation<S>,
        O: Observer<S>,
    {
        const {
            assert!(
                M::ESTIMATES_ERROR || !C::NEEDS_ESTIMATE,
                "`Adaptive` needs a method with an error estimate: `RungeKutta4` takes `FixedStep`"
            );
        }
        let mut work = Work::default();
        let scale = automaton.error_scale().of_the_faster(excitation.angular_frequency());
        let most_attempts = budget.max(LEAST_BUDGET) - LEAST_BUDGET;
        let longest_ticks = lengthened(scale.ticks_of_radians(M::LONGEST_RADIANS), self.lengthening());
        // An event can be due at the first step of a call and after a jump. After an ordinary step the search
        // for a falling guard has excluded it.
        let mut may_be_due = true;
        let mut memo = Memo::EMPTY;
        let mut longest = self.longest_in(automaton, state, excitation, &scale);
        while state.clock < until {
            if work.attempts() > most_attempts {
                return Ok(Advance { ended: Ended::BudgetSpent, work });
            }
            let at = state.clock;
            let fail = |failure| StepError { failure, at };
            let due = if may_be_due { due_event(automaton, state, excitation, &mut memo) } else { None };
            may_be_due = false;
            let event = match due {
                Some(event) => Some(event),
                None => {
                    let resolved = excitation.smooth_ticks(at).min(longest);
                    let limit = at.ticks_until(until, resolved);
                    let control = state.control;
                    let limits = [limit, longest_ticks];
                    let Some(taken) = self
                        .next_step(automaton, state, excitation, limits, (&scale, &memo), &mut work)
                        .map_err(fail)?
                    else {
                        // Rejected: the control memory holds a shorter step.
                        continue;
                    };
                    if let Err((quantity, value)) = automaton.check(state.mode, &taken.trial.end.state) {
                        // A constant state is outside at any step.
                        if taken.ticks > DOMAIN_TICKS && taken.trial.end.state != state.point.state {
                            // A shorter step locates where the domain is left.
                            work.rejected = work.rejected.wrapping_add(1);
                            self.control.shorten(&mut state.control, taken.ticks);
                            continue;
                        }
                        // A further call fails at the same step.
                        state.control = control;
                        return Err(fail(StepFailure::OutsideDomain { quantity, value }));
                    }
                    let settled = self.settled_start::<O, _, _, N, P>(automaton, state, taken.ticks);
                    let start = settled.as_ref().unwrap_or(&state.point);
                    observer.step(&accepted_step::<O, _, _, N, P>(automaton, state, start, &taken));
                    work.steps = work.steps.wrapping_add(1);
                    state.clock = state.clock.after(taken.ticks);
                    state.since_event = state.since_event.saturating_add(taken.ticks);
                    state.point = taken.trial.end;
                    // Armed guards are others.
                    let arms = !state.armed && automaton.rearms(state.mode, &state.point);
                    state.armed |= arms;
                    if A::KEEPS_GUARDS {
                        memo = if arms { Memo::EMPTY } else { taken.memo };
                    }
                    may_be_due = taken.searched;
                    taken.event
                }
            };
            if let Some(guard) = event {
                self.take_jump(automaton, state, excitation, guard, observer)?;
                work.events = work.events.wrapping_add(1);
                may_be_due = true;
                longest = self.longest_in(automaton, state, excitation, &scale);
                if self.pause_at_events {
                    return Ok(Advance { ended: Ended::Event, work });
                }
            }
        }
        Ok(Advance { ended: Ended::Finished, work })
    }

    /// [`StepControl::lengthening`], for a method that it serves.
    #[inline]
    fn lengthening<S: Scalar>(&self) -> S
    where
        M: Method<S>,
        C: StepControl<S>,
    {
        if M::PREDICTS { self.control.lengthening() } else { S::ONE }
    }

    /// The longest step in ticks, which depends on the mode.
    #[inline(never)]
    fn longest_in<S: Scalar, A: Automaton<S, N, P>, const N: usize, const P: usize>(
        &self,
        automaton: &A,
        state: &HybridState<S, A::Mode, N, P>,
        excitation: &impl Excitation<S>,
        scale: &ErrorScale<S>,
    ) -> u32
    where
        M: Method<S>,
        C: StepControl<S>,
    {
        let flow = automaton.flow(state.mode);
        let seconds = self.method.longest_step(&flow, scale.angular_frequency);
        // No error estimate limits the steps of a constant state, whose guards are searched on a cubic.
        let factor = self.lengthening();
        if factor == S::ONE || flow.is_constant() {
            return ticks_of_seconds(seconds).min(excitation.resolved_ticks());
        }
        let of_excitation = if excitation.is_exact() { factor } else { S::ONE };
        ticks_of_seconds(factor * seconds).min(lengthened(excitation.resolved_ticks(), of_excitation))
    }

    /// Attempts a step of at most `limit` ticks; `None` if it was rejected and the control memory holds a shorter one.
    #[inline(always)]
    fn next_step<S: Scalar, A: Automaton<S, N, P>, const N: usize, const P: usize>(
        &self,
        automaton: &A,
        state: &mut HybridState<S, A::Mode, N, P>,
        excitation: &impl Excitation<S>,
        [limit, longest_ticks]: [u32; 2],
        (scale, memo): (&ErrorScale<S>, &Memo<S>),
        work: &mut Work,
    ) -> Result<Option<TakenStep<S, N, P>>, StepFailure<S>>
    where
        M: Method<S>,
        C: StepControl<S>,
    {
        let flow = automaton.flow(state.mode);
        // The guards of a constant state change with the excitation alone, which `limit` resolves.
        let is_constant = M::PREDICTS && flow.is_constant();
        let proposed = if is_constant { limit } else { state.control.ticks };
        let planned = proposed.min(limit);
        let attempts = Attempts {
            automaton,
            mode: state.mode,
            armed: state.armed,
            start: &state.point,
            clock: state.clock,
            excitation,
            driver: self,
            scale,
            planned,
            memo,
            after_jump: M::CARRIES_DERIVATIVES
                && state.since_event <= if M::PREDICTS { 0 } else { LAYER_TICKS },
        };
        let shorten = |memory: &mut _, work: &mut Work| {
            work.rejected = work.rejected.wrapping_add(1);
            if planned < SHORTEST_TICKS {
                return Err(StepFailure::StepVanished);
            }
            self.control.shorten(memory, planned);
            Ok(None)
        };
        let most = state.control.stretched(planned).min(limit);
        let (mut search, mut memo) = (Search::within([planned, most]), Memo::EMPTY);
        let (mut taken, mut control) = loop {
            let attempted = if M::PREDICTS {
                attempts.attempt_to_event(&mut search)
            } else {
                attempts.attempt(planned, None)
            };
            let Ok(mut trial) = attempted else {
                return shorten(&mut state.control, work);
            };
            work.iterations = work.iterations.saturating_add(trial.iterations);
            let mut control = state.control;
            let ticks = [search.ticks, longest_ticks];
            if !is_constant
                && self.judge(&flow, &mut control, &state.point, &trial, ticks, scale) == Verdict::Reject
            {
                work.rejected = work.rejected.wrapping_add(1);
                if search.ticks < SHORTEST_TICKS {
                    return Err(StepFailure::StepVanished);
                }
                state.control = control;
                return Ok(None);
            }
            if M::PREDICTS && attempts.must_repeat(&mut trial, &mut search, &mut memo) {
                work.locating = work.locating.wrapping_add(1);
                continue;
            }
            let Search { ticks, event, .. } = search;
            break (TakenStep { trial, ticks, event, searched: event.is_some(), memo }, control);
        };
        if taken.ticks < proposed {
            let judged = control.ticks;
            control.keep_proposal(&state.control);
            if self.lengthening() > S::ONE && taken.event.is_some() {
                // The next step may be longer than the one before the event: at such tolerances the longest step binds.
                control.ticks = control.ticks.max(judged);
            }
        }
        if !M::PREDICTS && first_event(&attempts, &mut taken, automaton.guards(state.mode), work).is_err() {
            return shorten(&mut state.control, work);
        }
        state.control = control;
        Ok(Some(taken))
    }

    /// Judges an attempt of `ticks` and updates the memory of the step control.
    #[inline(always)]
    fn judge<S: Scalar, Y: System<S, N, P>, const N: usize, const P: usize>(
        &self,
        flow: &Y,
        control: &mut ControlMemory<S>,
        start: &Point<S, N, P>,
        trial: &Trial<S, N, P>,
        [ticks, longest_ticks]: [u32; 2],
        scale: &ErrorScale<S>,
    ) -> Verdict
    where
        M: Method<S>,
        C: StepControl<S>,
    {
        let end = &trial.end;
        let errors = StepErrors {
            ticks,
            order: M::ESTIMATE_ORDER,
            longest_ticks,
            time_scale_ratio: flow.time_scale_ratio(&start.state, &end.state),
            state: trial.error,
            energy: trial.energy_error.abs(),
            delivered: trial.energies.first().copied().unwrap_or(S::ZERO),
            carried: carries::<S, M, Y, N, P>(),
        };
        let rounding = || {
            if carries::<S, M, Y, N, P>() {
                return S::ZERO;
            }
            flow.rounding_energy(&end.state, &end.derivative, seconds_of_ticks(ticks))
        };
        self.control.judge(control, &errors, scale, rounding)
    }

    /// The start of a step of `ticks` after a jump, beyond the boundary layer of a fast circuit; `None` if it is that of
    /// the state, or is not read.
    ///
    /// A dense output that started inside a layer much shorter than the step would overshoot.
    #[inline]
    fn settled_start<O: Observer<S>, S: Scalar, A: Automaton<S, N, P>, const N: usize, const P: usize>(
        &self,
        automaton: &A,
        state: &HybridState<S, A::Mode, N, P>,
        ticks: u32,
    ) -> Option<Point<S, N, P>>
    where
        M: Method<S>,
    {
        if !(O::READS_OUTPUTS && M::CARRIES_DERIVATIVES && state.since_event == 0) {
            return None;
        }
        let (flow, step) = (automaton.flow(state.mode), seconds_of_ticks::<S>(ticks));
        let layer = flow.boundary_layer(&state.point.state)?;
        // The parabola resolves a layer that is longer than the step.
        (layer.relaxation * step > S::ONE).then(|| {
            let mut start = state.point;
            let rate = &mut start.derivative[<A::Flow<'_> as System<S, N, P>>::CIRCUIT];
            *rate = layer.settled(*rate, step);
            start
        })
    }

    /// Carries out the jump of guard number `guard`.
    #[cold]
    #[inline(never)]
    fn take_jump<S: Scalar, A: Automaton<S, N, P>, const N: usize, const P: usize>(
        &self,
        automaton: &A,
        state: &mut HybridState<S, A::Mode, N, P>,
        excitation: &impl Excitation<S>,
        guard: usize,
        observer: &mut impl Observer<S>,
    ) -> Result<(), StepError<S>>
    where
        M: Method<S>,
    {
        let crowded = state.since_event < CROWDED_TICKS;
        let crowded_events = if crowded { state.crowded_events.wrapping_add(1) } else { 0 };
        if crowded_events > MOST_CROWDED_EVENTS {
            return Err(StepError { failure: StepFailure::EventStorm, at: state.clock });
        }
        let input_at = InputAt::new(excitation, state.clock);
        // A method that carries derivatives passes the boundary layer itself.
        let step = if carries::<S, M, A::Flow<'_>, N, P>() {
            S::ZERO
        } else {
            seconds_of_ticks(state.control.ticks)
        };
        let jump = automaton.jump(state.mode, guard, &state.point, &input_at, step);
        let energies = automaton.jump_energies(state.mode, guard, &state.point, &jump);
        let input = input_at.acceleration();
        let mut left = Point::with_derivative(&automaton.flow(jump.mode), jump.state, jump.derivative, input);
        left.remainder = jump.remainder;
        let before = automaton.outputs(state.mode, &state.point);
        let is_impact = automaton.is_impact(state.mode, guard);
        observer.event(&Event {
            at: state.clock,
            guard,
            impact_speed: is_impact.then(|| before.coordinate().rate.abs()),
            before,
            after: automaton.outputs(jump.mode, &left),
            loss: jump.loss,
            energies: &energies,
        });
        state.mode = jump.mode;
        state.point = left;
        state.armed = jump.armed;
        (state.since_event, state.crowded_events) = (0, crowded_events);
        Ok(())
    }
}

/// Whether a method carries the derivative of a system: one that predicts steps by the split form.
#[inline]
const fn carries<S: Scalar, M: Method<S>, Y: System<S, N, P>, const N: usize, const P: usize>() -> bool {
    M::CARRIES_DERIVATIVES && (M::PREDICTS || Y::CARRIED)
}

/// Cuts an attempted step at the first guard that falls in it.
///
/// The search repeats after each located guard, because another guard may fall earlier: the dense output of a
/// long step can order two falls wrongly, or show a graze that the shorter step does not have.
#[inline]
fn first_event<S: Scalar, A: Automaton<S, N, P>, const N: usize, const P: usize>(
    attempts: &Attempts<'_, S, A, impl Excitation<S>, impl Method<S>, impl StepControl<S>, N, P>,
    taken: &mut TakenStep<S, N, P>,
    guards: usize,
    work: &mut Work,
) -> Result<(), NotConverged> {
    // One bit for each guard located in this step. Each guard is located at most once.
    let mut done = 0_u32;
    let mut attempts_left = MOST_ATTEMPTS;
    for _ in 0..=guards.min(MOST_GUARDS) {
        let Some((guard, theta)) = attempts.first_fall(&taken.trial.end, taken.ticks, done) else { break };
        taken.searched = true;
        if attempts_left == 0 {
            break;
        }
        let before = work.locating;
        let located = attempts.locate(guard, theta, taken.trial, taken.ticks, attempts_left, work)?;
        attempts_left = attempts_left.saturating_sub(work.locating.wrapping_sub(before));
        (taken.trial, taken.ticks) = (located.trial, located.ticks);
        taken.event = located.fell.then_some(guard);
        done |= bit(guard);
    }
    Ok(())
}

/// The accepted step as an observer sees it.
#[inline]
fn accepted_step<'a, O: Observer<S>, S: Scalar, A: Automaton<S, N, P>, const N: usize, const P: usize>(
    automaton: &A,
    state: &'a HybridState<S, A::Mode, N, P>,
    start: &'a Point<S, N, P>,
    taken: &'a TakenStep<S, N, P>,
) -> AcceptedStep<'a, S> {
    let TakenStep { trial, ticks, .. } = taken;
    let step = seconds_of_ticks(*ticks);
    let outputs = |point: &'a Point<S, N, P>| {
        if O::READS_OUTPUTS { automaton.outputs(state.mode, point) } else { Outputs::of_state(&point.state) }
    };
    let voltage = trial.energies.get(PowerIndex::Voltage as usize);
    AcceptedStep {
        from: state.clock,
        ticks: *ticks,
        step,
        start: outputs(start),
        end: outputs(&trial.end),
        energies: &trial.energies,
        mean_voltage: voltage.map_or(S::ZERO, |&integral| integral / step),
        contact: Contact::NONE,
        energy_error: trial.energy_error,
        state_error: trial.error,
    }
}

/// A guard whose event is due at the present state.
///
/// Outlined: the compiler would otherwise evaluate the guards before every step.
#[cold]
#[inline(never)]
fn due_event<S: Scalar, A: Automaton<S, N, P>, const N: usize, const P: usize>(
    automaton: &A,
    state: &HybridState<S, A::Mode, N, P>,
    excitation: &impl Excitation<S>,
    memo: &mut Memo<S>,
) -> Option<usize> {
    let input = InputAt::new(excitation, state.clock);
    memo.take(automaton, (state.mode, state.armed), &state.point, &input, Guard::is_due)
}
