//! Motions of one period of the excitation: found after a transient, or from an orbit at a frequency close by.

use std::f64::consts::TAU;

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
/// Distance below which three periods show that the transient arrives. Farther off it may leave again: without contact it follows the
/// linearisation exactly, until the beat of a light damping brings it to the contact.
const CLOSE: f64 = 0.02;
/// Fewest periods for which the transient must follow the linearisation of an orbit.
const WATCHED: f64 = 3.0;
/// Most periods, beside [`PATIENCE`], for which it is watched: a circuit may be slower by far.
const LONGEST: f64 = 1e4;
/// Largest difference of the transient from the linearisation, as a part of the change and of the approach that this predicts over a
/// period: a motion of three periods beside an orbit changes as predicted, but comes no nearer.
const MISPREDICTED: f64 = 0.5;

/// Periods of transient before the first attempt, and from one attempt to the next.
///
/// Within twenty periods the amplitude of a lightly damped start has overshot. Measured on 568 points of the
/// contact-separation scene, after 10 periods the impacts of the later motion are missed at 7 points, most at the upper
/// edge of the band, and after 20 periods at none.
const PATIENCE: u32 = 20;
/// Attempts after which the search ends.
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

    /// Magnitude and angle of the multipliers that turn a distance from the orbit, which are those of the motion; a circuit has the
    /// others. Of all if there is none that turns.
    fn of_motion(&self) -> impl Iterator<Item = (f64, f64)> {
        let turns = self.multipliers.iter().any(|value| value.im != 0.0);
        self.multipliers.iter().filter(move |value| !turns || value.im != 0.0).map(|value| value.to_polar())
    }

    /// Magnitude of the one that decays most slowly; 0 if there is none.
    fn slowest(&self) -> f64 {
        self.of_motion().map(|(size, _)| size).fold(0.0, f64::max)
    }

    /// Periods for which a motion at a distance must follow the linearisation: until each of these multipliers has turned it round
    /// once, so that its whole beat is seen, or has made it small.
    fn periods_to_follow(&self, distance: f64) -> u32 {
        let decay = (distance / CLOSE).ln();
        let periods = self.of_motion().map(|(size, angle)| (TAU / angle.abs()).min(decay / -size.ln()));
        periods.fold(WATCHED, f64::max).ceil() as u32
    }

    /// What coordinates have more than the orbit, in units of the scale of each.
    fn distances(&self, coordinates: &[f64]) -> Vec<f64> {
        let entries = coordinates.iter().zip(&self.coordinates).zip(&self.scale);
        entries.map(|((entry, of_orbit), scale)| (entry - of_orbit) / scale).collect()
    }

    /// Whether a motion goes from one distance to another in a period as the linearisation predicts.
    fn predicts(&self, from: &[f64], to: &[f64]) -> bool {
        let predicted = self.linearisation.image(from);
        let approach = (1.0 - self.slowest()) * apart(from, None);
        apart(to, Some(&predicted)) < MISPREDICTED * approach.min(apart(from, Some(&predicted)))
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
                    if self.arrives(&orbit, &mut state, &mut periods, spent)? {
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

    /// Whether the motion from `state`, at the phase of the orbit, comes to it. Advances the state, and counts its periods.
    fn arrives(
        &self,
        orbit: &Orbit<H::State>,
        state: &mut H::State,
        periods: &mut u32,
        spent: &mut Spent,
    ) -> Result<bool, Failure> {
        let section = self.harvester.clock(state).ticks();
        let mut distances = orbit.distances(&self.harvester.coordinates(state));
        let decay = (apart(&distances, None) / CLOSE).ln() / -orbit.slowest().ln();
        let most = (2.0 * decay).min(LONGEST) as u32 + PATIENCE;
        let mut followed = 0;
        for period in 1..=most {
            let until = section.saturating_add(self.instant(f64::from(period)).ticks());
            self.advance(state, Instant::from_ticks(until), &mut (), spent)?;
            *periods += 1;
            let next = orbit.distances(&self.harvester.coordinates(state));
            let follows = orbit.predicts(&distances, &next) && self.harvester.is_like(state, &orbit.start);
            followed = if follows { followed + 1 } else { 0 };
            distances = next;
            let distance = apart(&distances, None);
            if distance < ARRIVED || followed >= orbit.periods_to_follow(distance) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// The largest difference of the entries of two vectors, the second all zero without one.
fn apart(one: &[f64], other: Option<&[f64]>) -> f64 {
    let other = other.into_iter().flatten().chain(std::iter::repeat(&0.0));
    one.iter().zip(other).fold(0.0, |apart, (one, other)| (one - other).abs().max(apart))
}
