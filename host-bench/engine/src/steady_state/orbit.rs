//! Motions of one period of the excitation: found after a transient, or from an orbit at a frequency close by.

use model_core::clock::Instant;
use model_core::energy::{RunMeter, RunReport};
use model_core::excitation::Excitation;
use model_core::hybrid::{Automaton, HybridState, StepError};
use model_core::integrate::Method;
use nalgebra::Complex;

use super::newton::{Linearisation, Map};
use super::period_map::{ForcedSystem, Spent, StateOf, Watch};

/// Change of the state, in units of the size of the motion, below which an orbit counts as found.
const ACCURACY: f64 = 1e-7;
/// Distance, in the same units, at which the transient has arrived at an orbit.
const ARRIVED: f64 = 1e-3;
/// Periods for which the transient is watched. On a motion of two or three periods beside the orbit it returns to where it
/// was, or comes no nearer to the orbit.
const WATCHED: u32 = 3;
/// Largest difference of the transient from the prediction by the orbit's multipliers, as a part of its first distance.
const MISPREDICTED: f64 = 0.2;

/// Periods of transient before the first attempt, and from one attempt to the next.
///
/// Within twenty periods the amplitude of a lightly damped start has overshot. Measured on 568 points of the
/// contact-separation scene, after 10 periods the impacts of the later motion are missed at 7 points, most at the upper
/// edge of the band, and after 20 periods at none.
const PATIENCE: u32 = 20;
/// Attempts after which the search ends. At four of those points a run of 300 periods ends on another motion than the
/// orbit that was found.
const ATTEMPTS: u32 = 5;

/// A motion of one period of the excitation.
#[derive(Debug, Clone, PartialEq)]
pub struct Orbit<Mode, const N: usize, const P: usize> {
    /// Its state at some instant of the first period, away from events.
    pub start: HybridState<f64, Mode, N, P>,
    /// Its Floquet multipliers, the largest magnitude first. A quantity that the motion conserves,
    /// such as the charge of an open circuit, is no unknown and has none.
    pub multipliers: Vec<Complex<f64>>,
    /// Part of a period from its beginning to `start`.
    phase: f64,
    scale: [f64; N],
    linearisation: Linearisation,
}

impl<Mode, const N: usize, const P: usize> Orbit<Mode, N, P> {
    /// Magnitude of the largest multiplier; 0 if there is none.
    pub fn largest_multiplier(&self) -> f64 {
        self.multipliers.first().map_or(0.0, |value| value.norm())
    }

    /// Whether small disturbances die out.
    pub fn is_stable(&self) -> bool {
        self.largest_multiplier() < 1.0
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum Verdict<Mode, const N: usize, const P: usize> {
    /// A stable orbit that the transient approaches.
    StablePeriodOne(Orbit<Mode, N, P>),
    /// A stable orbit that the transient does not approach.
    NotReached(Orbit<Mode, N, P>),
    UnstablePeriodOne(Orbit<Mode, N, P>),
    NotFound,
}

impl<Mode, const N: usize, const P: usize> Verdict<Mode, N, P> {
    /// Its name in reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::StablePeriodOne(_) => harvester_scene::outcome::STABLE,
            Self::NotReached(_) => "stable-period-1-not-reached",
            Self::UnstablePeriodOne(_) => "unstable-period-1",
            Self::NotFound => "none",
        }
    }

    /// The orbit, if there is one.
    pub fn orbit(&self) -> Option<&Orbit<Mode, N, P>> {
        match self {
            Self::StablePeriodOne(orbit) | Self::NotReached(orbit) | Self::UnstablePeriodOne(orbit) => {
                Some(orbit)
            }
            Self::NotFound => None,
        }
    }
}

/// The values of a resonance curve at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Half the distance between the extremes of the harvester's coordinate, in m.
    pub amplitude_m: f64,
    /// Root mean square of the terminal voltage, in V.
    pub rms_voltage_v: f64,
}

impl<A, E, I, const N: usize, const P: usize> ForcedSystem<'_, A, E, I, N, P>
where
    A: Automaton<f64, N, P>,
    E: Excitation<f64>,
    I: Method<f64>,
{
    /// The steady state of the motion from `start`, at time zero; `typical` is the size of each state in its own unit, of
    /// which a thousandth counts as a small motion.
    pub fn steady_state(
        &self,
        start: StateOf<A, N, P>,
        typical: &[f64; N],
        spent: &mut Spent,
    ) -> Result<Verdict<A::Mode, N, P>, StepError<f64>> {
        let mut state = start;
        let mut periods = 0;
        let mut verdict = Verdict::NotFound;
        for _ in 0..ATTEMPTS {
            periods += PATIENCE;
            self.advance(&mut state, self.instant(f64::from(periods - 1)), &mut (), spent)?;
            let mut watch = Watch::<N>::new();
            self.advance(&mut state, self.instant(f64::from(periods)), &mut watch, spent)?;
            let phase = watch.calmest();
            let section = Instant::from_ticks(state.clock.ticks() + phase);
            self.advance(&mut state, section, &mut (), spent)?;
            periods += u32::from(phase > 0);
            let mut pattern = state;
            pattern.clock = Instant::from_ticks(phase);
            let phase = pattern.clock.seconds::<f64>() * self.frequency_hz;
            match self.orbit(&pattern, phase, watch.scale(typical), None, spent) {
                Some(orbit) if orbit.is_stable() => {
                    if self.goes_to(&orbit, &pattern, spent) {
                        return Ok(Verdict::StablePeriodOne(orbit));
                    }
                    verdict = Verdict::NotReached(orbit);
                }
                Some(orbit) => verdict = Verdict::UnstablePeriodOne(orbit),
                None => {}
            }
        }
        Ok(verdict)
    }

    /// The orbit at this frequency that continues `other`, an orbit at a frequency close by.
    pub fn continued(&self, other: &Orbit<A::Mode, N, P>, spent: &mut Spent) -> Option<Orbit<A::Mode, N, P>> {
        let mut pattern = other.start;
        pattern.clock = self.instant(other.phase);
        self.orbit(&pattern, other.phase, other.scale, Some(other.linearisation.clone()), spent)
    }

    /// The response of the stable orbit that continues `known` at this frequency, or else of the steady state of the
    /// motion from `start`. The orbit of the response replaces `known`.
    pub fn followed(
        &self,
        known: &mut Option<Orbit<A::Mode, N, P>>,
        start: StateOf<A, N, P>,
        typical: &[f64; N],
        spent: &mut Spent,
    ) -> Result<Option<Response>, StepError<f64>> {
        let continued = known.as_ref().and_then(|orbit| self.continued(orbit, spent));
        *known = match continued.filter(Orbit::is_stable) {
            Some(orbit) => Some(orbit),
            None => match self.steady_state(start, typical, spent)? {
                Verdict::StablePeriodOne(orbit) => Some(orbit),
                Verdict::NotReached(_) | Verdict::UnstablePeriodOne(_) | Verdict::NotFound => None,
            },
        };
        Ok(known.as_ref().and_then(|orbit| self.response(orbit, spent)))
    }

    /// The response of one period of an orbit by the meters; `None` if a step cannot be taken.
    pub fn response(&self, orbit: &Orbit<A::Mode, N, P>, spent: &mut Spent) -> Option<Response> {
        let mut meter = RunMeter::new();
        self.period(&orbit.start, &orbit.start.point.state, &mut meter, spent)?;
        let RunReport { coordinate, rms_voltage, .. } = meter.report();
        Some(Response {
            amplitude_m: 0.5 * (coordinate.highest - coordinate.lowest),
            rms_voltage_v: rms_voltage?,
        })
    }

    /// The orbit that Newton's iteration finds from the state `pattern`.
    fn orbit(
        &self,
        pattern: &StateOf<A, N, P>,
        phase: f64,
        scale: [f64; N],
        known: Option<Linearisation>,
        spent: &mut Spent,
    ) -> Option<Orbit<A::Mode, N, P>> {
        let mut apply = |vector: &[f64; N]| self.period(pattern, vector, &mut (), spent);
        let mut map = Map { apply: &mut apply, scale, accuracy: ACCURACY };
        let found = map.fixed_point(pattern.point.state, known)?;
        Some(Orbit {
            start: self.at(pattern, &found.point),
            multipliers: found.linearisation.multipliers(),
            phase,
            scale,
            linearisation: found.linearisation,
        })
    }

    /// Whether the motion from `state` approaches the orbit as its linearisation predicts.
    fn goes_to(&self, orbit: &Orbit<A::Mode, N, P>, state: &StateOf<A, N, P>, spent: &mut Spent) -> bool {
        let from_orbit = |vector: &[f64; N]| -> [f64; N] {
            std::array::from_fn(|index| (vector[index] - orbit.start.point.state[index]) / orbit.scale[index])
        };
        let size = |vector: &[f64; N]| vector.iter().fold(0.0_f64, |size, entry| size.max(entry.abs()));
        let mut vector = state.point.state;
        let mut predicted = from_orbit(&vector);
        let distance = size(&predicted);
        if distance < ARRIVED {
            return true;
        }
        for _ in 0..WATCHED {
            let Some(next) = self.period(state, &vector, &mut (), spent) else { return false };
            vector = next;
            predicted = orbit.linearisation.image(&predicted);
        }
        let found = from_orbit(&vector);
        let difference: [f64; N] = std::array::from_fn(|index| found[index] - predicted[index]);
        size(&difference) < MISPREDICTED * distance
    }
}
