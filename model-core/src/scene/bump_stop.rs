//! The bump-stop harvester: a piezoelectric cantilever that hits a rod.
//!
//! Mak, McWilliam, Popov and Fox, *Vibro-impact dynamics of a piezoelectric energy harvester*,
//! IMAC-XXVIII (2010). A monomorph cantilever, clamped to a base that shakes with acceleration `a`,
//! bends by `y` towards a rod that stands on the same base at a distance `Δ` from the place `X_c`
//! of the beam. Both are in modal coordinates, `y = Σ φ_i r_i` and `z = Σ ψ_j q_j`; while they touch a
//! force `F ≥ 0` acts between them; the electrodes feed a load:
//!
//! ```text
//! r̈_i + 2 ζ ω_i ṙ_i + ω_i² r_i = −γ_i a − φ_i(X_c) F − χ θ_i v
//! q̈_j + 2 ζ Ω_j q̇_j + Ω_j² q_j = −g_j a + ψ_j(L_r) F
//! C_p v' = Σ θ_i ṙ_i − v/R                    g = y(X_c) − z(L_r) − Δ
//! ```
//!
//! Displacements are relative to the base and positive towards the stop; the gap coordinate `g` is
//! below zero where the gap is open. `χ` is 1 where the voltage acts back on the beam
//! ([`TwoWay`]), and 0 as in the paper ([`OneWay`]).
//!
//! # How a step is taken
//!
//! The modes are propagated exactly (`integrate::modal`) under a base acceleration that is
//! linear over the step and a contact force and a voltage that are constant; the force is the discrete
//! gradient of the contact's potential (`integrate::discrete_gradient`), the voltage the mean
//! of the circuit's exact solution (`part::circuit`). Both follow from one scalar equation
//! in closed form. The energy of modes, capacitance and contact then never grows, whatever the step.
//!
//! Free flight is exact, so a second, much longer step is taken wherever a bound on the gap's
//! curvature says that no contact can occur within it ([`Stepper`]).
//!
//! The mode counts are type parameters, `B` of the beam and `R` of the rod.

mod choices;
mod circuit;
mod closed_form;
mod contact_law;
mod energies;
mod harvester;
mod identity;
mod parameters;
mod rectified;
mod state;
mod step_set;
mod stepper;
mod stop;
mod trial;

pub use choices::{AnyChoices, AnyCoupling, Choices, OneWay, Parts, TwoWay};
pub use circuit::{Circuit, Resistive};
pub use contact_law::{AnyContact, DisplacementConstraint, NoStop, ResidualFlexibility, Restitution};
pub use parameters::Parameters;
pub use state::{Start, State, StateOf};
use stepper::LEAST_BUDGET;
pub use stepper::Stepper;
pub use stop::Stop;

use crate::scalar::Scalar;
use choices::ContactOf;

/// Coefficients of a beam mode, in SI units with a modal mass of one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BeamCoefficients<S> {
    angular_frequency: S,
    /// `γ`: modal force per base acceleration, negated.
    base: S,
    /// `φ(X_c)`.
    contact: S,
    /// `φ(L)`.
    tip: S,
    /// `θ`: modal force per voltage, negated, and charge per modal displacement.
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

/// A harvester whose parameters have been checked: coefficients only, nothing that changes.
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
    /// Contact stiffness `k`: the inverse of residual and contact compliance.
    stiffness: S,
    /// `W = Σ φ² + Σ ψ²`, the inverse of the mass that an impact feels.
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

    /// Displacement of the beam's tip towards the stop, and its rate, in m and m/s.
    #[must_use]
    pub(crate) fn tip<C>(&self, state: &State<S, B, R, C>) -> [S; 2] {
        self.along_beam(state, |mode| mode.tip)
    }

    /// Displacement of the beam at the stop, and its rate, in m and m/s.
    #[must_use]
    pub(crate) fn stop_point<C>(&self, state: &State<S, B, R, C>) -> [S; 2] {
        self.along_beam(state, |mode| mode.contact)
    }

    /// Displacement of the rod's face, and its rate, in m and m/s.
    #[must_use]
    pub(crate) fn rod_tip<C>(&self, state: &State<S, B, R, C>) -> [S; 2] {
        let mut sums = [S::ZERO; 2];
        for (mode, coordinate) in self.rod.iter().zip(&state.rod) {
            sums[0] += mode.contact * coordinate[0];
            sums[1] += mode.contact * coordinate[1];
        }
        sums
    }

    /// Voltage at the terminals in V.
    #[must_use]
    pub fn voltage<C>(&self, state: &State<S, B, R, C>) -> S {
        (state.strain_charge - state.moved_charge) * self.elastance
    }

    fn along_beam<C>(&self, state: &State<S, B, R, C>, weight: impl Fn(&BeamCoefficients<S>) -> S) -> [S; 2] {
        let mut sums = [S::ZERO; 2];
        for (mode, coordinate) in self.beam.iter().zip(&state.beam) {
            sums[0] += weight(mode) * coordinate[0];
            sums[1] += weight(mode) * coordinate[1];
        }
        sums
    }
}
