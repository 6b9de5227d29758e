//! Motions of one period of the excitation: found after a transient, or from an orbit at a frequency close by.

use model_core::clock::Instant;
use model_core::energy::{RunMeter, RunReport};
use model_core::excitation::Excitation;
use model_core::observer::PowerIndex;
use nalgebra::Complex;

use harvester_scene::method::Failure;

use super::period_map::{Coordinates, ForcedSystem, Spent, Watching};
use super::{Linearisation, Map, NotFound};

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
pub struct Orbit<T> {
    /// Its state at some instant of the first period, away from events.
    pub start: T,
    /// Its Floquet multipliers, the largest magnitude first. A quantity that the motion conserves,
    /// such as the charge of an open circuit, is no unknown and has none.
    pub multipliers: Vec<Complex<f64>>,
    /// Part of a period from its beginning to `start`.
    phase: f64,
    coordinates: Vec<f64>,
    scale: Vec<f64>,
    linearisation: Linearisation,
}

impl<T> Orbit<T> {
    /// Magnitude of the largest multiplier; 0 if there is none.
    pub fn largest_multiplier(&self) -> f64 {
        self.multipliers.first().map_or(0.0, |value| value.norm())
    }

    /// Part of a period from its beginning to the start.
    pub fn phase(&self) -> f64 {
        self.phase
    }

    /// Whether small disturbances die out.
    pub fn is_stable(&self) -> bool {
        self.largest_multiplier() < 1.0
    }
}

#[derive(Debug, Clone, PartialEq)]
pub enum Verdict<T> {
    /// A stable orbit that the transient approaches.
    StablePeriodOne(Orbit<T>),
    /// A stable orbit that the transient does not approach.
    NotReached(Orbit<T>),
    UnstablePeriodOne(Orbit<T>),
    /// No orbit, with the least change of the state over a period that was reached.
    NotFound(NotFound),
}

impl<T> Verdict<T> {
    /// Its name in reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::StablePeriodOne(_) => harvester_scene::outcome::STABLE,
            Self::NotReached(_) => "stable-period-1-not-reached",
            Self::UnstablePeriodOne(_) => "unstable-period-1",
            Self::NotFound(_) => "none",
        }
    }

    /// The orbit, if there is one.
    pub fn orbit(&self) -> Option<&Orbit<T>> {
        match self {
            Self::StablePeriodOne(orbit) | Self::NotReached(orbit) | Self::UnstablePeriodOne(orbit) => {
                Some(orbit)
            }
            Self::NotFound(_) => None,
        }
    }

    /// Change of the state over a period that the search left, in units of half the range of each coordinate; `None` if
    /// it found an orbit.
    pub fn residual(&self) -> Option<f64> {
        if let Self::NotFound(left) = self { Some(left.residual) } else { None }
    }
}

/// The values of a resonance curve at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Half the distance between the extremes of the harvester's coordinate, in m.
    pub amplitude_m: f64,
    /// Root mean square of the terminal voltage, in V.
    pub rms_voltage_v: f64,
    /// Mean power in W into the load, or into the storage or bus behind a bridge.
    pub mean_power_w: f64,
    /// Mean current in A into the storage or bus: its charge per second; 0 without a bridge.
    pub mean_current_a: f64,
}

impl<H: Coordinates, E: Excitation<f64>> ForcedSystem<'_, H, E> {
    /// The steady state of the motion from `start`, at time zero; `typical` is the size of each coordinate in its own unit,
    /// of which a thousandth counts as a small motion.
    pub fn steady_state(
        &self,
        start: H::State,
        typical: &[f64],
        spent: &mut Spent,
    ) -> Result<Verdict<H::State>, Failure> {
        self.begin(spent);
        let mut state = start;
        let mut periods = 0;
        let mut verdict = Verdict::NotFound(NotFound { residual: f64::INFINITY });
        for _ in 0..ATTEMPTS {
            periods += PATIENCE;
            self.advance(&mut state, self.instant(f64::from(periods - 1)), &mut (), spent)?;
            let watch = self.watched(&mut state, self.instant(f64::from(periods)), spent)?;
            let phase = watch.calmest();
            let section = Instant::from_ticks(self.harvester.clock(&state).ticks() + phase);
            self.advance(&mut state, section, &mut (), spent)?;
            periods += u32::from(phase > 0);
            let mut pattern = state;
            self.harvester.set_clock(&mut pattern, Instant::from_ticks(phase));
            let phase = Instant::from_ticks(phase).seconds::<f64>() * self.frequency_hz;
            match self.orbit(&pattern, phase, watch.scale(typical), None, spent) {
                Ok(orbit) if orbit.is_stable() => {
                    if self.goes_to(&orbit, &pattern, spent) {
                        return Ok(Verdict::StablePeriodOne(orbit));
                    }
                    verdict = Verdict::NotReached(orbit);
                }
                Ok(orbit) => verdict = Verdict::UnstablePeriodOne(orbit),
                Err(left) => {
                    if let Verdict::NotFound(before) = &mut verdict {
                        before.residual = before.residual.min(left.residual);
                    }
                }
            }
        }
        Ok(verdict)
    }

    /// The orbit at this frequency that continues `other`, an orbit at a frequency close by.
    pub fn continued(&self, other: &Orbit<H::State>, spent: &mut Spent) -> Option<Orbit<H::State>> {
        self.begin(spent);
        let mut pattern = other.start;
        self.harvester.set_clock(&mut pattern, self.instant(other.phase));
        let known = Some(other.linearisation.clone());
        self.orbit(&pattern, other.phase, other.scale.clone(), known, spent).ok()
    }

    /// A state at a phase of a period, from a motion at a frequency close by, as one of the first period here; `None` if there
    /// is no such state.
    pub fn resumed(&self, state: &H::State, phase: f64) -> Option<H::State> {
        let mut pattern = *state;
        self.harvester.set_clock(&mut pattern, self.instant(phase));
        self.at(&pattern, &self.harvester.coordinates(state))
    }

    /// The response of the stable orbit that continues `known` at this frequency, or else of the steady state of the
    /// motion from `start`. The orbit of the response replaces `known`.
    pub fn followed(
        &self,
        known: &mut Option<Orbit<H::State>>,
        start: H::State,
        typical: &[f64],
        spent: &mut Spent,
    ) -> Result<Option<Response>, Failure> {
        let continued = known.as_ref().and_then(|orbit| self.continued(orbit, spent));
        *known = match continued.filter(Orbit::is_stable) {
            Some(orbit) => Some(orbit),
            None => match self.steady_state(start, typical, spent)? {
                Verdict::StablePeriodOne(orbit) => Some(orbit),
                Verdict::NotReached(_) | Verdict::UnstablePeriodOne(_) | Verdict::NotFound(_) => None,
            },
        };
        Ok(known.as_ref().and_then(|orbit| self.response(orbit, spent)))
    }

    /// The response of one period of an orbit by the meters; `None` if a step cannot be taken.
    pub fn response(&self, orbit: &Orbit<H::State>, spent: &mut Spent) -> Option<Response> {
        let mut meter = RunMeter::new();
        let watching: &mut Watching<'_, '_> = &mut (&mut None, &mut Some(&mut meter));
        self.period(&orbit.start, &orbit.coordinates, watching, spent)?;
        let mean_power_w = meter.mean_power();
        let has_storage = self.harvester.outputs(&orbit.start).storage.is_some();
        let current = meter.integrals().mean(PowerIndex::CurrentMagnitude);
        let RunReport { coordinate, rms_voltage, .. } = meter.report();
        Some(Response {
            amplitude_m: 0.5 * (coordinate.highest - coordinate.lowest),
            rms_voltage_v: rms_voltage?,
            mean_power_w,
            mean_current_a: if has_storage { current } else { 0.0 },
        })
    }

    /// The orbit that Newton's iteration finds from the state `pattern`.
    fn orbit(
        &self,
        pattern: &H::State,
        phase: f64,
        scale: Vec<f64>,
        known: Option<Linearisation>,
        spent: &mut Spent,
    ) -> Result<Orbit<H::State>, NotFound> {
        let mut apply = |vector: &[f64]| self.period(pattern, vector, &mut (), spent);
        let mut map = Map { apply: &mut apply, scale: scale.clone(), accuracy: ACCURACY };
        let found = map.fixed_point(self.harvester.coordinates(pattern), known)?;
        let start = self.at(pattern, &found.point).ok_or(NotFound { residual: f64::INFINITY })?;
        Ok(Orbit {
            start,
            multipliers: found.linearisation.multipliers(),
            phase,
            coordinates: found.point,
            scale,
            linearisation: found.linearisation,
        })
    }

    /// Whether the motion from `state` approaches the orbit as its linearisation predicts.
    fn goes_to(&self, orbit: &Orbit<H::State>, state: &H::State, spent: &mut Spent) -> bool {
        let from_orbit = |vector: &[f64]| -> Vec<f64> {
            let entries = vector.iter().zip(&orbit.coordinates).zip(&orbit.scale);
            entries.map(|((entry, of_orbit), scale)| (entry - of_orbit) / scale).collect()
        };
        let size = |vector: &[f64]| vector.iter().fold(0.0_f64, |size, entry| size.max(entry.abs()));
        let mut vector = self.harvester.coordinates(state);
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
        let difference: Vec<f64> = found.iter().zip(&predicted).map(|(found, by)| found - by).collect();
        size(&difference) < MISPREDICTED * distance
    }
}
