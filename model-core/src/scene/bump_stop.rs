//! The bump-stop harvester: a piezoelectric cantilever that hits a rod.
//!
//! Mak, McWilliam, Popov and Fox, *Vibro-impact dynamics of a piezoelectric energy harvester*, IMAC-XXVIII (2010). A
//! monomorph cantilever, clamped to a moving base, bends towards a rod on the same base. While beam and rod touch, a
//! contact force acts between them. The electrodes feed a load. Beam and rod are in modal coordinates:
//!
//! ```text
//! r̈_i + 2 ζ ω_i ṙ_i + ω_i² r_i = −γ_i a − φ_i(X_c) F − χ θ_i v          y = Σ φ_i r_i
//! q̈_j + 2 ζ Ω_j q̇_j + Ω_j² q_j = −g_j a + ψ_j(L_r) F                    z = Σ ψ_j q_j
//! C_p v' = Σ θ_i ṙ_i − v/R                    g = y(X_c) − z(L_r) − Δ
//! ```
//!
//! | symbol | quantity | unit | sign |
//! | --- | --- | --- | --- |
//! | `a` | base acceleration | m/s² | positive towards the stop |
//! | `y`, `z` | displacement of beam and rod relative to the base | m | positive towards the stop |
//! | `r_i`, `q_j` | modal coordinates, modal masses of one | m √kg | |
//! | `φ_i`, `ψ_j` | mode shapes | 1/√kg | |
//! | `ω_i`, `Ω_j` | angular frequencies | rad/s | |
//! | `ζ` | damping ratio of all modes | 1 | |
//! | `γ_i`, `g_j` | modal force per negative base acceleration | √kg | |
//! | `X_c`, `L_r` | position of the stop on the beam; length of the rod | m | |
//! | `Δ` | gap at rest | m | |
//! | `g` | gap coordinate | m | negative while the gap is open |
//! | `F` | contact force | N | `F ≥ 0`, compressive |
//! | `v` | terminal voltage | V | |
//! | `θ_i` | charge per modal coordinate, and modal force per negative voltage | C/(m √kg) | |
//! | `C_p`, `R` | piezoelectric capacitance; load resistance | F; Ω | |
//! | `χ` | back-action of the voltage on the beam: 1 ([`TwoWay`]), 0 ([`OneWay`]) | 1 | |
//!
//! # Integration
//!
//! The modes are propagated exactly (`integrate::modal`) under forces that are linear over a step: the base
//! acceleration ([`Excitation::line`](crate::excitation::Excitation::line)), in contact the contact force (`integrate::discrete_gradient`), and in free flight the voltage
//! (`part::circuit`). Near contact the voltage is constant over a step. Two moments of the gap's rate or of the charge
//! determine force or voltage in closed form, so that the energy of modes, capacitance and contact never grows, at any
//! step length.
//!
//! Free flight needs no short step, so longer steps are used while a bound on the gap excludes contact within them
//! ([`Stepper`]). Behind a bridge the voltage is linear over a step if the bridge blocks throughout, and the
//! contact force is constant over a step in which the bridge conducts.
//!
//! The numbers of modes are type parameters, `B` of the beam and `R` of the rod.
//!
//! # Tip mass
//!
//! A rigid body of mass, rotary inertia and offset at the tip ([`TipMass`]) changes the modes only (`part::beam`), and
//! with them every coefficient. The base acceleration acts on the body too, and by its offset on the rotation of the tip;
//! `γ_i` contains both. The contact acts on the beam, at `X_c ≤ L_b`, not on the body beyond its tip. The charge of the
//! electrodes, which cover the whole length of the beam, remains that of the slope at the tip, `θ_i = ν φ_i'(L_b)`.
//! The static compliance and the static curvatures of all modes together do not depend on masses; only the curvature under
//! the base acceleration has the moment `M (L_b + d)` of the body as well.
//!
//! # Bimorph
//!
//! [`Choices::transducer`] takes a [`Bimorph`]: a second piezoelectric layer below the substrate, in series or in parallel.
//! It changes bending stiffness, mass, `ν` and `C_p` only. A [`Parameters::piezo`] then describes each of the two layers.

mod checks;
mod choices;
mod circuit;
mod clamp;
mod closed_form;
mod contact_law;
mod energies;
mod gap_bound;
mod halves;
mod harvester;
mod impact;
mod mode_step;
mod parameters;
mod rectified;
mod state;
mod step_doubling;
mod step_set;
mod stepper;
mod stop;
mod tip_mass;
mod trial;
mod validity;

pub use checks::Checks;
pub use choices::{AnyChoices, AnyCoupling, Choices, OneWay, Parts, TwoWay};
pub use circuit::{Circuit, Resistive};
pub use clamp::{ClampBending, ClampMeter, Fibre};
pub use contact_law::{AnyContact, DisplacementConstraint, NoStop, ResidualFlexibility, Restitution};
pub use parameters::Parameters;
pub use state::{Start, State, StateOf};
pub use step_doubling::{StepDoubling, StepDoublingState};
use stepper::LEAST_BUDGET;
pub use stepper::Stepper;
pub use stop::Stop;
pub use tip_mass::NoTipMass;
pub use validity::{ClosedForm, Reason, Validity};

pub use crate::part::beam::TipMass;
pub use crate::part::monomorph::{Bimorph, Monomorph};
use crate::scalar::Scalar;
use choices::ContactOf;

/// Coefficients of a beam mode, in SI units with a modal mass of one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BeamCoefficients<S> {
    angular_frequency: S,
    /// `γ`: modal force per negative base acceleration.
    base: S,
    /// `φ(X_c)`.
    contact: S,
    /// `φ(L)`.
    tip: S,
    /// `θ`: modal force per negative voltage, and charge per modal coordinate.
    voltage: S,
}

/// Coefficients of a rod mode.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RodCoefficients<S> {
    angular_frequency: S,
    base: S,
    /// `ψ(L_r)`.
    contact: S,
}

/// A bump-stop harvester with checked parameters: constant coefficients only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BumpStop<S: Scalar, P: Parts<S>, const B: usize, const R: usize> {
    beam: [BeamCoefficients<S>; B],
    rod: [RodCoefficients<S>; R],
    damping_ratio: S,
    /// `C_p`, and its inverse.
    capacitance: S,
    elastance: S,
    /// `Δ`.
    gap: S,
    /// Contact stiffness `k` in N/m: the inverse of the sum of residual and contact compliance.
    stiffness: S,
    /// `W = Σ φ² + Σ ψ²` in 1/kg, the inverse of the effective mass of an impact.
    inverse_mass: S,
    load: P::Load,
    coupling: P::Coupling,
    contact: ContactOf<S, P>,
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Undamped short-circuit angular frequency of beam mode `index`, from 0, in rad/s.
    #[must_use]
    pub fn beam_angular_frequency(&self, index: usize) -> Option<S> {
        self.beam.get(index).map(|mode| mode.angular_frequency)
    }

    /// Undamped angular frequency of rod mode `index`, from 0, in rad/s.
    #[must_use]
    pub fn rod_angular_frequency(&self, index: usize) -> Option<S> {
        self.rod.get(index).map(|mode| mode.angular_frequency)
    }

    /// Piezoelectric capacitance `C_p` in F.
    #[must_use]
    pub fn capacitance(&self) -> S {
        self.capacitance
    }

    /// Contact stiffness `k` in N/m.
    #[must_use]
    pub fn contact_stiffness(&self) -> S {
        self.stiffness
    }

    /// Displacement of the beam's tip towards the stop in m, and its rate in m/s.
    pub(crate) fn tip<C>(&self, state: &State<S, B, R, C>) -> [S; 2] {
        weighted_sum(self.beam.iter().map(|mode| mode.tip), &state.beam)
    }

    /// Displacement of the beam at the stop in m, and its rate in m/s.
    pub(crate) fn stop_point<C>(&self, state: &State<S, B, R, C>) -> [S; 2] {
        weighted_sum(self.beam.iter().map(|mode| mode.contact), &state.beam)
    }

    /// Displacement of the rod's face in m, and its rate in m/s.
    pub(crate) fn rod_tip<C>(&self, state: &State<S, B, R, C>) -> [S; 2] {
        weighted_sum(self.rod.iter().map(|mode| mode.contact), &state.rod)
    }

    /// Rate of the gap coordinate in m/s.
    #[inline]
    fn gap_rate<C>(&self, state: &State<S, B, R, C>) -> S {
        self.stop_point(state)[1] - self.rod_tip(state)[1]
    }

    /// Voltage at the terminals in V.
    #[must_use]
    pub fn voltage<C>(&self, state: &State<S, B, R, C>) -> S {
        (state.strain_charge - state.moved_charge) * self.elastance
    }
}

/// Displacement and velocity of the modes, summed with a weight for each mode.
fn weighted_sum<S: Scalar>(weights: impl Iterator<Item = S>, coordinates: &[[S; 2]]) -> [S; 2] {
    weights.zip(coordinates).fold([S::ZERO; 2], |[displacement, velocity], (weight, coordinate)| {
        [displacement + weight * coordinate[0], velocity + weight * coordinate[1]]
    })
}
