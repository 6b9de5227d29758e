//! Computes the bending of the beam at its clamp: curvature, strain and stress of the outer fibres.
//!
//! The curvature is the sum over the kept modes and the static curvature of the omitted ones, which respond
//! statically, as in the compliance of the contact:
//!
//! ```text
//! κ = Σ φ_i''(0) r_i − c_F F − c_a a − χ c_v v
//! c_F = X_c/EI − Σ φ_i''(0) φ_i(X_c)/ω_i²      c_a = m' L²/2EI − Σ φ_i''(0) γ_i/ω_i²
//! c_v = ν/EI − Σ φ_i''(0) θ_i/ω_i²
//! ```
//!
//! `X_c/EI`, `m' L²/2EI` and `ν/EI` are the curvatures at the clamp of a cantilever under a force at `X_c`, under a
//! uniform load, and under a moment at its tip: those of all modes together. A tip mass `M` with its centre at `d` beyond
//! the tip adds `M (L + d)/EI` to the second. Without this correction the sum over
//! ten modes lacks some 10⁻³ of the first two and 6 % of the third. The strain of a fibre is its distance from the neutral
//! axis times the curvature, its stress the strain times the Young's modulus: that of bending alone, without the stress
//! of the electric field in the piezoelectric layer. Derived here.

use super::choices::Coupling;
use super::contact_law::{ContactKind, ContactLaw};
use super::stop::StopChoice;
use super::tip_mass::TipMassChoice;
use super::{BumpStop, Choices, Parameters, Parts};
use crate::bounds::ParameterError;
use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::integrate::Cubic;
use crate::integrate::cubic::Peak;
use crate::observer::{AcceptedStep, Observer, Outputs};
use crate::part::monomorph::Transducer as _;
use crate::scalar::{CompensatedSum, Scalar};

/// An outer fibre of the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fibre<S> {
    /// Distance from the neutral axis in m.
    pub distance: S,
    /// Young's modulus in Pa.
    pub young_modulus: S,
}

impl<S: Scalar> Fibre<S> {
    /// Bending strain at a curvature in 1/m, with the sign of the curvature.
    ///
    /// One outer fibre is in tension where the other is in compression: the sign does not say which.
    #[must_use]
    pub fn strain(&self, curvature: S) -> S {
        self.distance * curvature
    }

    /// Bending stress in Pa at a curvature in 1/m, with the sign of the curvature, as [`Fibre::strain`].
    #[must_use]
    pub fn stress(&self, curvature: S) -> S {
        self.young_modulus * self.strain(curvature)
    }
}

/// The curvature of the beam at its clamp as a function of state, contact force, base acceleration and voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClampBending<S, const B: usize> {
    /// `φ_i''(0)` in 1/(m² √kg).
    modes: [S; B],
    /// `c_F` in 1/(m N), `c_a` in s²/m², `χ c_v` in 1/(m V).
    force: S,
    base: S,
    voltage: S,
    /// Contact stiffness in N/m of a compliant contact; `None` if the force does not follow from the penetration.
    stiffness: Option<S>,
    /// Outer fibre of the substrate.
    pub substrate: Fibre<S>,
    /// Outer fibre of the piezoelectric layer.
    pub piezo: Fibre<S>,
}

impl<S: Scalar, C> Parameters<S, C> {
    /// The bending at the clamp of the harvester that [`Parameters::build_first`] builds with the first `beam` and `rod`
    /// modes.
    ///
    /// # Errors
    /// As [`Parameters::build_first`].
    pub fn clamp_bending<const B: usize, const R: usize>(
        &self,
        beam: usize,
        rod: usize,
    ) -> Result<ClampBending<S, B>, ParameterError<S>>
    where
        C: Parts<S>,
    {
        let harvester: BumpStop<S, C, B, R> = self.build_first(beam, rod)?;
        let &Choices { stop, tip_mass, transducer, .. } = self.choices.choices();
        let section = self.section();
        let (length, rigidity) = (self.beam_length, section.bending_stiffness);
        let cantilever = self.cantilever(&section);
        let mut modes = [S::ZERO; B];
        for (number, mode) in (1..=B as u32).zip(modes.iter_mut().take(beam)) {
            *mode = tip_mass.mode(&cantilever, number).shape(S::ZERO).curvature / (length * length);
        }
        let place = stop.stop().map_or(S::ZERO, |stop| stop.position);
        let mut force = place / rigidity;
        let beam_moment = S::from_f64(0.5) * section.mass_per_length * length * length;
        let mut base = tip_mass.moment_at_clamp(&cantilever, beam_moment) / rigidity;
        let mut voltage = section.coupling / rigidity;
        for (curvature, mode) in modes.iter().zip(&harvester.beam) {
            let compliance = *curvature / (mode.angular_frequency * mode.angular_frequency);
            force -= compliance * mode.contact;
            base -= compliance * mode.base;
            voltage -= compliance * mode.voltage;
        }
        let [substrate, piezo] = transducer.outer_distances([&self.substrate, &self.piezo]);
        Ok(ClampBending {
            modes,
            force,
            base,
            voltage: if harvester.coupling.is_two_way() { voltage } else { S::ZERO },
            stiffness: matches!(harvester.contact.kind(), ContactKind::Compliant)
                .then_some(harvester.stiffness),
            substrate: Fibre { distance: substrate, young_modulus: self.substrate.young_modulus },
            piezo: Fibre { distance: piezo, young_modulus: self.piezo.young_modulus },
        })
    }
}

impl<S: Scalar, const B: usize> ClampBending<S, B> {
    /// The curvature in 1/m of the modes, displacement and velocity of each in turn, and its rate in 1/(m s).
    fn of_modes(&self, state: &[S]) -> [S; 2] {
        let [displacements, velocities] = [0, 1].map(|first| state.iter().skip(first).step_by(2));
        self.modes.iter().zip(displacements.zip(velocities)).fold(
            [S::ZERO; 2],
            |[value, rate], (mode, (displacement, velocity))| {
                [value + *mode * *displacement, rate + *mode * *velocity]
            },
        )
    }

    /// The static curvature in 1/m of the omitted modes.
    fn of_omitted(&self, force: S, acceleration: S, voltage: S) -> S {
        -(self.force * force + self.base * acceleration + self.voltage * voltage)
    }

    /// The curvature in 1/m, positive where the beam bends towards the stop: for displacement and velocity of each beam
    /// mode in turn, a contact force in N, a base acceleration in m/s² and a voltage in V.
    #[must_use]
    pub fn curvature(&self, state: &[S], force: S, acceleration: S, voltage: S) -> S {
        let [value, _] = self.of_modes(state);
        value + self.of_omitted(force, acceleration, voltage)
    }

    /// The contact force in N at an end of a step: of a compliant contact by the penetration, else `mean`.
    fn force_at(&self, outputs: &Outputs<'_, S>, mean: S) -> S {
        self.stiffness.map_or(mean, |stiffness| stiffness * outputs.penetration.max(S::ZERO))
    }
}

/// Meter of the curvature at the clamp: its extremes and its mean square.
///
/// An observer of its own: a run without it does not compute the curvature.
#[derive(Debug, Clone, Copy)]
pub struct ClampMeter<S, E, const B: usize> {
    bending: ClampBending<S, B>,
    excitation: E,
    curvature: Peak<S>,
    square: CompensatedSum<S>,
    ticks: u64,
    last: [S; 4],
}

impl<S: Scalar, E: Excitation<S>, const B: usize> ClampMeter<S, E, B> {
    /// A meter at zero, of a run with this excitation.
    #[must_use]
    pub fn new(bending: ClampBending<S, B>, excitation: E) -> Self {
        Self {
            bending,
            excitation,
            curvature: Peak::new(),
            square: CompensatedSum::ZERO,
            ticks: 0,
            last: [S::ZERO; 4],
        }
    }

    /// The bending that is measured.
    #[must_use]
    pub fn bending(&self) -> &ClampBending<S, B> {
        &self.bending
    }

    /// Extremes of the curvature in 1/m.
    #[must_use]
    pub fn curvature(&self) -> Peak<S> {
        self.curvature
    }

    /// Root mean square of the curvature in 1/m; 0 at time zero.
    #[must_use]
    pub fn rms_curvature(&self) -> S {
        if self.ticks == 0 {
            return S::ZERO;
        }
        (self.square.value() / Instant::from_ticks(self.ticks).seconds()).sqrt()
    }

    /// Curvature in 1/m along the last step: at its start, where it turns, and at its end.
    #[must_use]
    pub fn last(&self) -> [S; 4] {
        self.last
    }
}

impl<S: Scalar, E: Excitation<S>, const B: usize> Observer<S> for ClampMeter<S, E, B> {
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        let ends = [(&step.start, step.from), (&step.end, step.until())];
        let [start, end] = ends.map(|(outputs, at)| {
            let force = self.bending.force_at(outputs, step.contact.force);
            let omitted = self.bending.of_omitted(force, self.excitation.acceleration(at), outputs.voltage);
            (self.bending.of_modes(outputs.state), omitted)
        });
        let ([from, leaves], before) = start;
        let ([to, arrives], after) = end;
        let slope = (after - before) / step.step;
        let (from, to) = (from + before, to + after);
        let curvature = Cubic::new(from, leaves + slope, to, arrives + slope, step.step);
        self.curvature.include(&curvature, S::INFINITY);
        // The trapezium: a free step may be longer than the periods of the highest modes.
        self.square.add(S::from_f64(0.5) * step.step * (from * from + to * to));
        self.ticks = self.ticks.wrapping_add(u64::from(step.ticks));
        self.last = curvature.turns();
    }
}

#[cfg(test)]
mod tests;
