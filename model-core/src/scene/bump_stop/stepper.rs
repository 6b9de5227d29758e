//! Advances a bump-stop harvester: short steps near contact, long steps in free flight, and located impacts.

use super::choices::{ContactOf, Coupling};
use super::circuit::Circuit;
use super::contact_law::{ContactKind, ContactLaw};
use super::energies::GramianSet;
use super::state::StateOf;
use super::step_set::StepSetOf;
use super::trial::TrialOf;
use super::{BumpStop, Parts, State};
use crate::bounds::ParameterError;
use crate::clock::{Instant, seconds_of_ticks, ticks_of_seconds};
use crate::excitation::Excitation;
use crate::hybrid::{Advance, Ended, StepError, StepFailure, Work};
use crate::integrate::step_control::check_step;
use crate::observer::{ALL_POWERS, AcceptedStep, Contact, Event, Observer, Outputs, PowerIndex};
use crate::scalar::Scalar;

/// Most attempts of one step with the location of an impact. A smaller budget of
/// [`Harvester::advance`](crate::scene::Harvester::advance) is raised to this number.
pub(super) const LEAST_BUDGET: u32 = 44;
/// Most attempts to locate an impact: bisection of 2³² ticks.
const MOST_LOCATING: u32 = 40;
/// Impact speed in m/s below which an impact closes the contact.
const CLOSING_SPEED: f64 = 1e-5;

/// Ratio of the gap to the drift above which the drift is removed.
const OPENED: f64 = 16.0;

/// A bump-stop harvester with its two step lengths, and the coefficients of a bound on the gap's curvature.
///
/// The gap cannot reach zero within a step of `h` if `max(g, g⁺) + M h²/8 < 0`, where `M` bounds `|g̈|`. The energy
/// of a free mode does not grow, so `|r̈| ≤ √(1 + 4ζ²) ω √(ω² r² + ṙ²) + 3 (|γ| a + χ |θ| v)`, with `a` and `v` the
/// largest magnitudes over the step of the base acceleration, which is linear, and of the voltage, which is constant
/// (derived here).
///
/// A bridge evaluates the voltage at the ends of a step. Behind a bridge a long step is taken only if the part of the
/// modes in a similar bound shows that the bridge blocks throughout, or that the voltage is nearly linear.
///
/// `ALL` is 1 to integrate every power, 0 to integrate only the delivered energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepper<S: Scalar, P: Parts<S>, const B: usize, const R: usize, const ALL: usize = 0> {
    pub(super) scene: BumpStop<S, P, B, R>,
    pub(super) short: StepSetOf<S, P, B, R>,
    pub(super) long: StepSetOf<S, P, B, R>,
    /// Number of short steps in a long step.
    ratio: u16,
    /// `|φ| √(1 + 4ζ²) ω` of each beam mode, and of each rod mode.
    beam_curvature: [S; B],
    rod_curvature: [S; R],
    /// `3 Σ |φ γ| + 3 Σ |ψ g|` and `3 χ Σ |φ θ|`.
    curvature_by_base: S,
    curvature_by_voltage: S,
    /// `h²/8` of the long step.
    sagitta: S,
    /// The Gramians of a short and of a long step.
    gramians: [[GramianSet<S, B, R>; 2]; ALL],
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> Stepper<S, P, B, R> {
    /// A stepper that integrates only the delivered energy, enough for a node. Steps have the number of ticks nearest
    /// to `short` near contact and `long` in free flight, both in s and up to 15.6 ms. A `long` at or below `short`
    /// disables long steps.
    ///
    /// # Errors
    /// [`ParameterError`] with the field `short_step` or `long_step` for a length that is not above 0 and at most 15.6
    /// ms.
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
    fn build(scene: BumpStop<S, P, B, R>, short: S, long: S) -> Result<Self, ParameterError<S>> {
        check_step("short_step", short)?;
        check_step("long_step", long)?;
        let (short, long) = (scene.step_set(ticks_of_seconds(short)), scene.step_set(ticks_of_seconds(long)));
        let three = S::from_f64(3.0);
        let damping = S::from_f64(2.0) * scene.damping_ratio;
        let factor = (S::ONE + damping * damping).sqrt();
        let two_way = scene.coupling.is_two_way();
        let (mut by_base, mut by_voltage) = (S::ZERO, S::ZERO);
        for mode in &scene.beam {
            by_base += three * (mode.contact * mode.base).abs();
            by_voltage += three * (mode.contact * mode.voltage).abs();
        }
        for mode in &scene.rod {
            by_base += three * (mode.contact * mode.base).abs();
        }
        let ratio = u16::try_from(long.ticks / short.ticks.max(1)).unwrap_or(u16::MAX);
        Ok(Self {
            beam_curvature: scene.beam.map(|mode| mode.contact.abs() * factor * mode.angular_frequency),
            rod_curvature: scene.rod.map(|mode| mode.contact.abs() * factor * mode.angular_frequency),
            curvature_by_base: by_base,
            curvature_by_voltage: if two_way { by_voltage } else { S::ZERO },
            sagitta: S::from_f64(0.125) * long.step * long.step,
            gramians: core::array::from_fn(|_| {
                [short.ticks, long.ticks].map(|ticks| GramianSet::new(&scene, ticks))
            }),
            scene,
            short,
            long,
            ratio,
        })
    }

    /// The harvester.
    #[must_use]
    pub fn scene(&self) -> &BumpStop<S, P, B, R> {
        &self.scene
    }

    /// Advances `state` to `until`; without `CUT` it ends with a whole step, less than a short step past `until`.
    ///
    /// A cut step computes its own coefficients, which cost more than many steps: from sample to sample, whole steps
    /// are cheaper. The base acceleration is linear over each step, so kinks of a sampled excitation within a long
    /// step are smoothed.
    #[inline]
    pub(super) fn run<const CUT: bool, E: Excitation<S>, O: Observer<S>>(
        &self,
        state: &mut StateOf<S, P, B, R>,
        excitation: &E,
        until: Instant,
        budget: u32,
        observer: &mut O,
    ) -> Result<Advance, StepError<S>> {
        let mut work = Work::default();
        let budget = budget.max(LEAST_BUDGET);
        let long_is_of_use = self.long.ticks > self.short.ticks;
        while state.clock < until {
            let spent = work.steps + work.rejected + work.locating;
            if spent > 0 && budget.saturating_sub(spent) < LEAST_BUDGET {
                return Ok(Advance { ended: Ended::BudgetSpent, work });
            }
            // Every step resolves the excitation.
            let resolved = excitation.resolved_ticks();
            let left = state.clock.ticks_until(until, resolved);
            let left = if CUT { left } else { left.max(self.short.ticks.min(resolved)) };
            let open = state.short_steps == 0 && !state.closed;
            if long_is_of_use && left >= self.long.ticks && open {
                // Most rejected long steps start too near to contact: reject them before computing them.
                let modes = self.curvature_of_modes(state);
                let interpolation_bound = self.interpolation_bound_of_voltage(state);
                if self.is_clear(state.gap + modes * self.sagitta)
                    && self.resolves_voltage(state, interpolation_bound)
                {
                    let trial = self.attempt(&self.long, state, excitation);
                    if self.cannot_touch(state, &trial, modes)
                        && self.resolves_voltage(&trial.end, interpolation_bound)
                    {
                        self.take(state, &trial, (self.long.ticks, self.long.step), observer, &mut work)?;
                        continue;
                    }
                }
                work.rejected += 1;
                state.short_steps = self.ratio;
            }
            state.short_steps = state.short_steps.saturating_sub(1);
            if left >= self.short.ticks {
                self.short_step(&self.short, state, excitation, observer, &mut work)?;
            } else {
                self.cut_step(left, state, excitation, observer, &mut work)?;
            }
        }
        Ok(Advance { ended: Ended::Finished, work })
    }

    #[inline(always)]
    fn attempt<E: Excitation<S>>(
        &self,
        set: &StepSetOf<S, P, B, R>,
        state: &StateOf<S, P, B, R>,
        excitation: &E,
    ) -> TrialOf<S, P, B, R> {
        self.scene.trial(set, state, excitation.acceleration(state.clock.after(set.ticks)))
    }

    /// Whether a largest gap coordinate excludes contact, or there is no stop.
    #[inline(always)]
    fn is_clear(&self, highest: S) -> bool {
        if !ContactOf::<S, P>::POSSIBLE || matches!(self.scene.contact.kind(), ContactKind::None) {
            return true;
        }
        // `highest < 0` is false for not-a-number.
        highest < S::ZERO
    }

    /// Whether contact is excluded in the long step to `trial`; `modes` is [`Self::curvature_of_modes`] at the start.
    #[inline(always)]
    fn cannot_touch(&self, start: &StateOf<S, P, B, R>, trial: &TrialOf<S, P, B, R>, modes: S) -> bool {
        let nearest = start.gap.max(trial.end.gap);
        let base = start.acceleration.abs().max(trial.end.acceleration.abs());
        let curvature =
            modes + self.curvature_by_base * base + self.curvature_by_voltage * trial.mean_voltage.abs();
        self.is_clear(nearest + curvature * self.sagitta)
    }

    /// The contribution of the modes to a bound on the deviation of the voltage from a straight line over a free long
    /// step, in V; 0 for a load without bridge.
    #[inline(always)]
    fn interpolation_bound_of_voltage(&self, start: &StateOf<S, P, B, R>) -> S {
        let mut bound = S::ZERO;
        if P::Load::SWITCHES {
            for (mode, coordinate) in self.scene.beam.iter().zip(&start.beam) {
                let omega = mode.angular_frequency;
                bound += mode.voltage.abs() * omega * at_least_norm(omega * coordinate[0], coordinate[1]);
            }
        }
        bound * self.scene.elastance * self.sagitta
    }

    /// Whether the load may use the voltage at `state` for one that differs by at most `interpolation_bound` in V.
    #[inline(always)]
    fn resolves_voltage(&self, state: &StateOf<S, P, B, R>, interpolation_bound: S) -> bool {
        !P::Load::SWITCHES
            || self.scene.load.resolves(self.scene.voltage(state), interpolation_bound, &state.circuit)
    }

    /// The contribution of the modes to a bound on `|g̈|` over a free step, in m/s².
    #[inline(always)]
    fn curvature_of_modes(&self, start: &StateOf<S, P, B, R>) -> S {
        let mut bound = S::ZERO;
        for ((weight, mode), coordinate) in self.beam_curvature.iter().zip(&self.scene.beam).zip(&start.beam)
        {
            bound += *weight * at_least_norm(mode.angular_frequency * coordinate[0], coordinate[1]);
        }
        for ((weight, mode), coordinate) in self.rod_curvature.iter().zip(&self.scene.rod).zip(&start.rod) {
            bound += *weight * at_least_norm(mode.angular_frequency * coordinate[0], coordinate[1]);
        }
        bound
    }

    /// Accepts a step of a number of ticks and seconds.
    #[inline(always)]
    fn take<O: Observer<S>>(
        &self,
        state: &mut StateOf<S, P, B, R>,
        trial: &TrialOf<S, P, B, R>,
        (ticks, step): (u32, S),
        observer: &mut O,
        work: &mut Work,
    ) -> Result<(), StepError<S>> {
        if !(trial.end.gap.is_finite() && trial.end.strain_charge.is_finite()) {
            let failure = StepFailure::OutsideDomain { quantity: "gap coordinate", value: trial.end.gap };
            return Err(StepError { failure, at: state.clock });
        }
        let mut energies = [S::ZERO; ALL_POWERS];
        let integrated = match self.gramians.first() {
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
                energies = self.scene.energies(gramians, state, trial, step);
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
            (accepted.start, accepted.end) = (self.scene.outputs(state), self.scene.outputs(&trial.end));
            accepted.end.in_contact |= self.scene.contact.kind() == ContactKind::Constrained;
            accepted.contact = self.scene.contact_within(state, trial);
            if P::Load::SWITCHES {
                // Behind a bridge the extremes of the voltage in a step are at its ends: the corner of the polyline
                // does not exceed the end.
                accepted.mean_voltage = S::from_f64(0.5) * (accepted.start.voltage + accepted.end.voltage);
            }
        }
        observer.step(&accepted);
        *state = State { short_steps: state.short_steps, ..trial.end };
        if state.drift > S::ZERO && state.gap < -S::from_f64(OPENED) * state.drift {
            state.gap += state.drift;
            state.drift = S::ZERO;
        }
        work.steps += 1;
        Ok(())
    }

    /// A step of `ticks` to `until`, with its own coefficients.
    #[cold]
    #[inline(never)]
    fn cut_step<E: Excitation<S>, O: Observer<S>>(
        &self,
        ticks: u32,
        state: &mut StateOf<S, P, B, R>,
        excitation: &E,
        observer: &mut O,
        work: &mut Work,
    ) -> Result<(), StepError<S>> {
        let cut = self.scene.step_set(ticks);
        self.short_step(&cut, state, excitation, observer, work)
    }

    /// A step near contact, up to the first impact in it.
    #[inline(always)]
    fn short_step<E: Excitation<S>, O: Observer<S>>(
        &self,
        set: &StepSetOf<S, P, B, R>,
        state: &mut StateOf<S, P, B, R>,
        excitation: &E,
        observer: &mut O,
        work: &mut Work,
    ) -> Result<(), StepError<S>> {
        let trial = self.attempt(set, state, excitation);
        if ContactOf::<S, P>::POSSIBLE
            && let ContactKind::Impulsive { restitution } = self.scene.contact.kind()
            && !state.closed
            && trial.end.gap > S::ZERO
        {
            return self.locate_impact((*set, trial), restitution, state, excitation, observer, work);
        }
        let was_closed = state.closed;
        self.take(state, &trial, (set.ticks, set.step), observer, work)?;
        if ContactOf::<S, P>::POSSIBLE && was_closed && !state.closed {
            BumpStop::<S, P, B, R>::close_gap(state);
        }
        Ok(())
    }

    /// Steps to the tick at which the gap closes, and through the impact.
    ///
    /// The gap is at or below zero at the start and above zero at the end of the attempt `beyond`.
    #[cold]
    #[inline(never)]
    fn locate_impact<E: Excitation<S>, O: Observer<S>>(
        &self,
        beyond: (StepSetOf<S, P, B, R>, TrialOf<S, P, B, R>),
        restitution: S,
        state: &mut StateOf<S, P, B, R>,
        excitation: &E,
        observer: &mut O,
        work: &mut Work,
    ) -> Result<(), StepError<S>> {
        let (mut set, mut reached) = beyond;
        let (mut open, mut closed) = (0, set.ticks);
        let (mut latest, mut gap, mut rate) = (closed, reached.end.gap, reached.gap_rate);
        let mut attempts = 0;
        while closed - open > 1 && attempts < MOST_LOCATING {
            // Newton's iteration from the last attempt, overshooting; bisection if it leaves the bracket.
            let distance = ((gap / rate).abs() / seconds_of_ticks(1)).to_u32();
            let next = match (rate > S::ZERO, gap > S::ZERO) {
                (true, true) if distance == 0 => break,
                (true, true) => latest.saturating_sub(distance),
                (true, false) => latest.saturating_add(distance).saturating_add(1),
                (false, _) => open,
            };
            latest = if next > open && next < closed { next } else { open + (closed - open) / 2 };
            attempts += 1;
            let shorter = self.scene.step_set(latest);
            let trial = self.attempt(&shorter, state, excitation);
            (gap, rate) = (trial.end.gap, trial.gap_rate);
            if gap > S::ZERO {
                (closed, set, reached) = (latest, shorter, trial);
            } else {
                open = latest;
            }
        }
        work.locating += attempts;
        self.take(state, &reached, (set.ticks, set.step), observer, work)?;
        let before = *state;
        BumpStop::<S, P, B, R>::close_gap(state);
        let speed = reached.gap_rate;
        if !(speed > S::ZERO) {
            return Ok(());
        }
        work.events += 1;
        let holds = speed < S::from_f64(CLOSING_SPEED);
        let rebound = if holds { S::ZERO } else { restitution };
        let impulse = (S::ONE + rebound) * speed / self.scene.inverse_mass;
        for (coordinate, mode) in state.beam.iter_mut().zip(&self.scene.beam) {
            coordinate[1] -= mode.contact * impulse;
        }
        for (coordinate, mode) in state.rod.iter_mut().zip(&self.scene.rod) {
            coordinate[1] += mode.contact * impulse;
        }
        state.closed = holds;
        let half = S::from_f64(0.5);
        let loss = half * (S::ONE - rebound * rebound) * speed * speed / self.scene.inverse_mass;
        let mut energies = [S::ZERO; ALL_POWERS];
        energies[PowerIndex::ContactForce as usize] = impulse;
        observer.event(&Event {
            at: state.clock,
            guard: 0,
            impact_speed: Some(speed),
            before: self.scene.outputs(&before),
            after: self.scene.outputs(state),
            loss,
            energies: &energies,
        });
        Ok(())
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Sets a positive gap coordinate to zero. It is due to the rounding of an impact's time or to the drift of a
    /// closed contact; `drift` shifts the rod's face by this amount until the gap has opened.
    fn close_gap(state: &mut StateOf<S, P, B, R>) {
        if state.gap > S::ZERO {
            state.drift += state.gap;
            state.gap = S::ZERO;
        }
    }
}

/// An upper bound of `√(a² + b²)`, at most 8 % above it, without a square root.
#[inline(always)]
fn at_least_norm<S: Scalar>(a: S, b: S) -> S {
    let (a, b) = (a.abs(), b.abs());
    a.max(b) + S::from_f64(core::f64::consts::SQRT_2 - 1.0) * a.min(b)
}
