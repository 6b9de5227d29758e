//! Advances a bump-stop harvester: short steps near contact, longer steps in free flight, and located impacts.

use super::choices::ContactOf;
use super::circuit::Circuit;
use super::contact_law::{ContactKind, ContactLaw};
use super::energies::GramianSet;
use super::gap_bound::{Flight, GapBound};
use super::state::StateOf;
use super::step_set::StepSetOf;
use super::trial::Trial;
use super::{BumpStop, Parts, weighted_sum};
use crate::bounds::ParameterError;
use crate::clock::{Instant, seconds_of_ticks, ticks_of_seconds};
use crate::excitation::Excitation;
use crate::hybrid::{Advance, Ended, StepError, StepFailure, Work};
use crate::integrate::step_control::check_step;
use crate::observer::{ALL_POWERS, AcceptedStep, Contact, Observer, Outputs, PowerIndex};
use crate::scalar::Scalar;

/// Most attempts of one step with the location of an impact: flights of all lengths, the short step, and those of the
/// location. A smaller budget of [`Harvester::advance`](crate::scene::Harvester::advance) is raised to this number.
pub(super) const LEAST_BUDGET: u32 = LEVELS as u32 + 1 + MOST_LOCATING;

/// Most attempts to locate an impact: bisection of 2³² ticks.
pub(super) const MOST_LOCATING: u32 = 40;

/// Number of step lengths. A fifth saves 7 % of the steps and 1 % of the instructions.
pub(super) const LEVELS: usize = 4;

/// A bump-stop harvester with its step lengths, and the coefficients of a bound on the gap within a step.
///
/// The gap cannot reach zero within a step if `max(g, g⁺)` is below zero by more than the gap can depart from a straight
/// line (`GapBound`). A longer step is attempted if the free motion leaves the gap open, and is taken if the whole bound
/// does. Between the short step and the long one are their geometric mean, and the geometric mean of that and the short
/// step: most steps near contact are limited by the gap.
///
/// A bridge evaluates the voltage at the ends of a step. Behind a bridge a longer step is taken only if the part of the
/// modes in a similar bound shows that the bridge blocks throughout, or that the voltage is nearly linear while the current
/// keeps its direction.
///
/// `ALL` is 1 to integrate every power, 0 to integrate only the delivered energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepper<S: Scalar, P: Parts<S>, const B: usize, const R: usize, const ALL: usize = 0> {
    pub(super) scene: BumpStop<S, P, B, R>,
    /// From the long step to the short one.
    pub(super) sets: [StepSetOf<S, P, B, R>; LEVELS],
    /// Of all steps but the short one.
    gap_bounds: [GapBound<S, B, R>; LEVELS - 1],
    gramians: [[GramianSet<S, B, R>; LEVELS]; ALL],
}

/// The state of a run, and the one that the next step writes. An accepted step swaps them: a copy of the state costs as much as a mode.
pub(super) struct Pair<'a, T> {
    pub(super) now: &'a mut T,
    pub(super) next: &'a mut T,
}

impl<T> Pair<'_, T> {
    fn swap(&mut self) {
        core::mem::swap(&mut self.now, &mut self.next);
    }
}

/// The pair of a harvester with the components `P`.
pub(super) type PairOf<'a, S, P, const B: usize, const R: usize> = Pair<'a, StateOf<S, P, B, R>>;

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> Stepper<S, P, B, R> {
    /// A stepper that integrates only the delivered energy, enough for a node. Steps have the number of ticks nearest
    /// to `short` near contact and `long` in free flight, both in s and up to 15.6 ms. A `long` at or below `short`
    /// disables long steps.
    ///
    /// # Errors
    /// [`ParameterError`] with the field `short_step` or `long_step` for a length that is not above 0 and at most 15.6 ms.
    #[inline]
    pub fn new(scene: BumpStop<S, P, B, R>, short: S, long: S) -> Result<Self, ParameterError<S>> {
        Self::build(scene, short, long)
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> Stepper<S, P, B, R, 1> {
    /// As [`Stepper::new`], integrating every [`crate::observer::PowerIndex`], for a report and an energy ledger.
    ///
    /// # Errors
    /// As [`Stepper::new`].
    pub fn with_all_powers(
        scene: BumpStop<S, P, B, R>,
        short: S,
        long: S,
    ) -> Result<Self, ParameterError<S>> {
        Self::build(scene, short, long)
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize, const ALL: usize> Stepper<S, P, B, R, ALL> {
    // Inlined, it builds in the frame of its caller, which is smaller than two.
    #[inline(always)]
    fn build(scene: BumpStop<S, P, B, R>, short: S, long: S) -> Result<Self, ParameterError<S>> {
        check_step("short_step", short)?;
        check_step("long_step", long)?;
        let middle = (short * long).sqrt();
        let steps = [long, middle, (short * middle).sqrt(), short];
        Ok(Self::of_ticks(scene, steps.map(ticks_of_seconds)))
    }

    /// With steps of so many ticks, from the long step to the short one.
    // Inlined as `build` is.
    #[inline(always)]
    pub(super) fn of_ticks(scene: BumpStop<S, P, B, R>, [a, b, c, d]: [u32; LEVELS]) -> Self {
        // Not by a map, which would need the space of all sets twice.
        let gap_bound = |ticks| GapBound::new(&scene, seconds_of_ticks(ticks));
        Self {
            gramians: core::array::from_fn(|_| [a, b, c, d].map(|ticks| GramianSet::new(&scene, ticks))),
            gap_bounds: [gap_bound(a), gap_bound(b), gap_bound(c)],
            sets: [scene.step_set(a), scene.step_set(b), scene.step_set(c), scene.step_set(d)],
            scene,
        }
    }

    /// The harvester.
    #[must_use]
    pub fn scene(&self) -> &BumpStop<S, P, B, R> {
        &self.scene
    }

    /// Whether whole steps past a sample stay below the next one.
    #[inline]
    pub(super) fn overshoots(&self, sample_ticks: u64) -> bool {
        u64::from(self.short().ticks) < sample_ticks
    }

    /// Advances `state` to `until`; without `CUT` it ends with a whole step, less than a short step past `until`.
    ///
    /// A cut step computes its own coefficients, which cost more than many steps: from sample to sample, whole steps are cheaper.
    #[inline]
    pub(super) fn run<const CUT: bool, E: Excitation<S>, O: Observer<S>>(
        &self,
        state: &mut StateOf<S, P, B, R>,
        excitation: &E,
        until: Instant,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>> {
        let mut spare = *state;
        let home = core::ptr::from_ref(state);
        let mut pair = Pair { now: state, next: &mut spare };
        let result = self.run_pair::<CUT, E, O>(&mut pair, excitation, until, budget, observer);
        if !core::ptr::eq(pair.now, home) {
            *pair.next = *pair.now;
        }
        result
    }

    #[inline(always)]
    fn run_pair<const CUT: bool, E: Excitation<S>, O: Observer<S>>(
        &self,
        pair: &mut PairOf<'_, S, P, B, R>,
        excitation: &E,
        until: Instant,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>> {
        let mut work = Work::default();
        let budget = budget.max(LEAST_BUDGET);
        let (mut trial, mut level) = (Trial::none(), 0);
        while pair.now.clock < until {
            let spent = work.steps.wrapping_add(work.rejected).wrapping_add(work.locating);
            if spent > 0 && budget.saturating_sub(spent) < LEAST_BUDGET {
                return Ok(Advance { ended: Ended::BudgetSpent, work });
            }
            // Every step resolves the excitation.
            let resolved = excitation.resolved_ticks_at(pair.now.clock);
            let left = pair.now.clock.ticks_until(until, resolved);
            let left = if CUT { left } else { left.max(self.short().ticks.min(resolved)) };
            if !pair.now.closed && self.fly(left, &mut level, pair, excitation, observer, &mut work)? {
                continue;
            }
            if left >= self.short().ticks {
                self.short_step(self.short(), pair, &mut trial, excitation, observer, &mut work)?;
            } else {
                self.cut_step(left, pair, &mut trial, excitation, observer, &mut work)?;
            }
        }
        Ok(Advance { ended: Ended::Finished, work })
    }

    /// Takes the longest step in free flight that fits into `left` ticks and cannot touch; `false` if there is none.
    /// `level` is that of the last step: the search begins there.
    #[inline(always)]
    fn fly<E: Excitation<S>, O: Observer<S>>(
        &self,
        left: u32,
        level: &mut usize,
        pair: &mut PairOf<'_, S, P, B, R>,
        excitation: &E,
        observer: &mut O,
        work: &mut Work,
    ) -> Result<bool, StepError<S>> {
        if !self.is_clear(pair.now.gap) {
            return Ok(false);
        }
        let flight = Flight::of(&self.scene, pair.now);
        // The bound grows with the step, in floating point too: the longest step that passes is the same wherever the
        // search begins.
        let mut passes = self.passes(*level, left, pair.now, &flight);
        while passes.is_some() && *level > 0 {
            let longer = self.passes(*level - 1, left, pair.now, &flight);
            if longer.is_none() {
                break;
            }
            (passes, *level) = (longer, *level - 1);
        }
        while *level < LEVELS {
            if let Some(room) = passes
                && self.try_flight(*level, room, pair, excitation, observer, work)?
            {
                return Ok(true);
            }
            *level += 1;
            passes = self.passes(*level, left, pair.now, &flight);
        }
        *level = LEVELS - 1;
        Ok(false)
    }

    /// The part of the modes in the bound of the gap over the step of a level, in m; `None` if the step is longer than
    /// `left` ticks or may touch.
    ///
    /// Most rejected steps end in contact or start near it: the gap's rate rejects them before they are computed.
    #[inline(always)]
    pub(super) fn passes(
        &self,
        level: usize,
        left: u32,
        start: &StateOf<S, P, B, R>,
        flight: &Flight<S, B, R>,
    ) -> Option<S> {
        let set = self.sets.get(level)?;
        if set.ticks > left {
            return None;
        }
        let ahead = start.gap + (flight.rate * set.step).max(S::ZERO);
        if !self.is_clear(ahead) {
            return None;
        }
        // There is none for the short step: only its end must be clear.
        let Some(gap_bound) = self.gap_bounds.get(level) else { return Some(S::ZERO) };
        let modes = if ContactOf::<S, P>::POSSIBLE { gap_bound.of_modes(flight) } else { S::ZERO };
        (set.ticks > self.short().ticks && self.is_clear(ahead + modes)).then_some(modes)
    }

    /// Takes a step in free flight if its end and the bound of the gap are clear; `room` is the part of the modes in the bound in m.
    #[inline(always)]
    pub(super) fn try_flight<E: Excitation<S>, O: Observer<S>>(
        &self,
        level: usize,
        mut room: S,
        pair: &mut PairOf<'_, S, P, B, R>,
        excitation: &E,
        observer: &mut O,
        work: &mut Work,
    ) -> Result<bool, StepError<S>> {
        let Some(set) = self.sets.get(level) else { return Ok(false) };
        let gap_bound = self.gap_bounds.get(level);
        let bound = self.interpolation_bound_of_voltage(pair.now, set.step);
        let blocks = self.blocks(pair.now, bound);
        if !(blocks || (gap_bound.is_some() && self.scene.load.resolves(bound, &pair.now.circuit))) {
            return Ok(false);
        }
        let base = excitation.line(pair.now.clock, set.ticks, set.step, pair.now.acceleration);
        let trial = if blocks {
            self.scene.flight::<ALL>(set, pair.now, &base, pair.next)
        } else {
            let mut trial = Trial::none();
            self.scene.trial(set, pair.now, &base, pair.next, &mut trial);
            trial
        };
        if let Some(gap_bound) = gap_bound {
            let largest = base.mean.abs() + base.tilt.abs();
            room += gap_bound.of_forces(largest, trial.mean_voltage.abs() + trial.voltage_tilt.abs());
        }
        if self.is_clear(pair.now.gap.max(pair.next.gap) + room)
            && (self.blocks(pair.next, bound)
                || (!blocks && self.scene.load.resolves(bound, &pair.next.circuit)))
            && (blocks || self.keeps_direction(pair))
        {
            self.take(pair, &trial, (set.ticks, set.step), observer, work)?;
            return Ok(true);
        }
        work.rejected = work.rejected.wrapping_add(1);
        Ok(false)
    }

    #[inline]
    pub(super) fn short(&self) -> &StepSetOf<S, P, B, R> {
        let [.., short] = &self.sets;
        short
    }

    #[inline(always)]
    pub(super) fn attempt<E: Excitation<S>>(
        &self,
        set: &StepSetOf<S, P, B, R>,
        pair: &mut PairOf<'_, S, P, B, R>,
        trial: &mut Trial<S>,
        excitation: &E,
    ) {
        let base = excitation.line(pair.now.clock, set.ticks, set.step, pair.now.acceleration);
        self.scene.trial(set, pair.now, &base, pair.next, trial);
    }

    /// Whether a largest gap coordinate excludes contact, or there is no stop.
    #[inline]
    fn is_clear(&self, highest: S) -> bool {
        if !ContactOf::<S, P>::POSSIBLE || matches!(self.scene.contact.kind(), ContactKind::None) {
            return true;
        }
        // `highest < 0` is false for not-a-number.
        highest < S::ZERO
    }

    /// The contribution of the modes to a bound on the deviation of the voltage from a straight line over a free step
    /// in s, in V; 0 for a load without bridge.
    #[inline]
    fn interpolation_bound_of_voltage(&self, start: &StateOf<S, P, B, R>, step: S) -> S {
        let mut bound = S::ZERO;
        if P::Load::SWITCHES {
            for (mode, coordinate) in self.scene.beam.iter().zip(&start.beam) {
                let omega = mode.angular_frequency;
                bound += mode.voltage.abs() * omega * at_least_norm(omega * coordinate[0], coordinate[1]);
            }
        }
        bound * self.scene.elastance * S::from_f64(0.125) * step * step
    }

    /// Whether a bridge blocks for all voltages that differ from that at `state` by at most `bound` in V.
    #[inline]
    fn blocks(&self, state: &StateOf<S, P, B, R>, bound: S) -> bool {
        !P::Load::SWITCHES || self.scene.load.blocks(self.scene.voltage(state), bound, &state.circuit)
    }

    /// Whether strain moves charge in one direction at both ends of a step. Where it turns, a bridge that conducts begins to
    /// block: the charge of a step does not show when, so that the error would be of the second order in the long step.
    #[inline]
    fn keeps_direction(&self, pair: &PairOf<'_, S, P, B, R>) -> bool {
        let [from, to] = [&*pair.now, &*pair.next]
            .map(|state| weighted_sum(self.scene.beam.iter().map(|mode| mode.voltage), &state.beam)[1]);
        from * to >= S::ZERO
    }

    /// Accepts a step of a number of ticks and seconds.
    #[inline(always)]
    pub(super) fn take<O: Observer<S>>(
        &self,
        pair: &mut PairOf<'_, S, P, B, R>,
        trial: &Trial<S>,
        (ticks, step): (u32, S),
        observer: &mut O,
        work: &mut Work,
    ) -> Result<(), StepError<S>> {
        let (state, end) = (&*pair.now, &*pair.next);
        if !(end.gap.abs() + end.strain_charge.abs() + trial.delivered.abs()).is_finite() {
            let failure = StepFailure::OutsideDomain { quantity: "gap coordinate", value: end.gap };
            return Err(StepError { failure, at: state.clock });
        }
        let mut energies = [S::ZERO; ALL_POWERS];
        let integrated = match self.gramians.first().filter(|_| O::READS_POWERS) {
            None => {
                energies[PowerIndex::Load as usize] = trial.delivered;
                1
            }
            Some(known) => {
                let made;
                let gramians = match known.iter().find(|known| known.ticks == ticks) {
                    Some(known) => known,
                    None => {
                        made = GramianSet::new(&self.scene, ticks);
                        &made
                    }
                };
                energies = self.scene.energies(gramians, [state, end], trial, step);
                ALL_POWERS
            }
        };
        let mut accepted = AcceptedStep {
            from: state.clock,
            ticks,
            step,
            start: Outputs::of_state(&[]),
            end: Outputs::of_state(&[]),
            energies: energies.get(..integrated).unwrap_or(&energies),
            mean_voltage: trial.mean_voltage,
            contact: Contact::NONE,
            energy_error: S::ZERO,
            state_error: S::ZERO,
        };
        if O::READS_OUTPUTS {
            (accepted.start, accepted.end) = (self.scene.outputs(state), self.scene.outputs(end));
            accepted.end.in_contact |= self.scene.contact.kind() == ContactKind::Constrained;
            accepted.contact = self.scene.contact_within([state, end], trial);
        }
        observer.step(&accepted);
        pair.swap();
        if let ContactKind::Impulsive { .. } = self.scene.contact.kind() {
            BumpStop::<S, P, B, R>::remove_drift(pair.now);
        }
        work.steps = work.steps.wrapping_add(1);
        Ok(())
    }

    /// A step of `ticks` to `until`, with its own coefficients.
    #[cold]
    #[inline(never)]
    fn cut_step<E: Excitation<S>, O: Observer<S>>(
        &self,
        ticks: u32,
        pair: &mut PairOf<'_, S, P, B, R>,
        trial: &mut Trial<S>,
        excitation: &E,
        observer: &mut O,
        work: &mut Work,
    ) -> Result<(), StepError<S>> {
        let cut = self.scene.step_set(ticks);
        self.short_step(&cut, pair, trial, excitation, observer, work)
    }

    /// A step near contact, up to the first impact in it.
    #[inline(always)]
    pub(super) fn short_step<E: Excitation<S>, O: Observer<S>>(
        &self,
        set: &StepSetOf<S, P, B, R>,
        pair: &mut PairOf<'_, S, P, B, R>,
        trial: &mut Trial<S>,
        excitation: &E,
        observer: &mut O,
        work: &mut Work,
    ) -> Result<(), StepError<S>> {
        self.attempt(set, pair, trial, excitation);
        let was_closed = pair.now.closed;
        if ContactOf::<S, P>::POSSIBLE
            && let ContactKind::Impulsive { restitution } = self.scene.contact.kind()
            && !was_closed
            && pair.next.gap > S::ZERO
        {
            return self.locate_impact((*set, *trial), restitution, pair, excitation, observer, work);
        }
        self.take(pair, trial, (set.ticks, set.step), observer, work)?;
        if ContactOf::<S, P>::POSSIBLE && was_closed && !pair.now.closed {
            BumpStop::<S, P, B, R>::close_gap(pair.now);
        }
        Ok(())
    }
}

/// An upper bound of `√(a² + b²)`, at most 8 % above it, without a square root.
#[inline]
fn at_least_norm<S: Scalar>(a: S, b: S) -> S {
    let (a, b) = (a.abs(), b.abs());
    a.max(b) + S::from_f64(core::f64::consts::SQRT_2 - 1.0) * a.min(b)
}
