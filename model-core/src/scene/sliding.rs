//! The sliding-mode triboelectric harvester: a cantilever whose tip slides on a charged patch.
//!
//! Fu, Ouyang and Davis, J. Phys. D 53 (2020), equations (1) to (18). The tip of a cantilever
//! carries a slider, a disc of radius `r` and mass `m` with one electrode and a dielectric of thickness
//! `d` and permittivity `ε_r` that holds the tribo-charge surface density `σ`. It rests by its
//! weight on two patches in one plane that move with the base: the *active* one, a disc of the same
//! radius under the beam's straight position, which is the other electrode, and the *inert* one
//! around it. The base shakes along the plane with acceleration `a`. In the first mode `φ` of the beam
//! with the slider ([`crate::part::beam`]), with `x` the displacement of the tip:
//!
//! ```text
//! x'' + 2 ζ ω x' + ω² x = −κ a + (F_k + F_lat) / M      M = 1/φ(L)²,  κ = Γ φ(L)   (1) to (4)
//! F_k = −μ_k(x) N sgn x',    N = m g + F_e                                         (5)
//! q' = V / R,    V = (σ S2 − q) / C,    C = ε0 ε_r S1 / d                          (12) to (15)
//! ```
//!
//! `S1` is the overlap of slider and active patch (`part::disc_overlap`), `S2 = π r² − S1`,
//! `μ_k` the mean of the patches' coefficients by area ([`crate::part::friction`]).
//!
//! # Stick
//!
//! Where the slider comes to rest it is held while static friction can balance what acts on it,
//! `|M (ω² x + κ a) − F_lat| ≤ μ_s(x) N`: the modal equation with velocity and acceleration zero,
//! not the print's (10), which weighs `ω² x` by the slider's mass instead of the modal mass and so
//! releases the slider with an acceleration that points the wrong way. Where it can not, the slider
//! leaves against the sign of that force; and since no kinetic coefficient exceeds the static one of
//! its patch, its acceleration then points the way it goes.
//!
//! # Corners
//!
//! The overlap has a corner at `x = 0`. The sign of `x` is therefore part of the mode, and the
//! crossing an event: inside a mode everything is smooth.
//!
//! # Units of the charge
//!
//! The charge is kept in units of `√(2 ε0 ε_r S M)`, `S = π r²`, in which the force of
//! [`TransferredCharge`] per modal mass is `q²/s1` with `s1 = S1/S`.

mod automaton;
mod choices;
mod closed_form;
mod electrical_port;
mod flow;
mod force_law;
mod identity;
mod lateral_force;
mod parameters;
mod start;

pub use crate::scene::coupled::{CHARGE, POSITION as DISPLACEMENT, STATES, VELOCITY};
pub use automaton::Mode;
pub use choices::{AnyChoices, Choices, Parts};
pub use flow::Flow;
pub(crate) use lateral_force::LateralForce;
pub use lateral_force::{AnyLateralForce, FieldLateralForce, NoLateralForce};
pub use parameters::Parameters;
pub use start::Start;

pub use crate::part::force_law::{AnyForceLaw, GapField, TransferredCharge};
pub(crate) use crate::part::friction::Friction;
pub use crate::part::friction::{Frictionless, PatchFriction};
pub use crate::part::stick_charge::{NeverSticks, StickCharge};

pub(crate) use crate::part::stick_charge::Sticking;

use crate::part::load::{Load, Resistance};
use crate::scalar::Scalar;
use force_law::Surface;

/// A harvester whose parameters have been checked: coefficients only, nothing that changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sliding<S: Scalar, P: Parts<S>> {
    /// `M`.
    modal_mass: S,
    /// `κ`.
    base_coupling: S,
    /// `ω`.
    angular_frequency: S,
    /// `ω²`.
    stiffness_per_mass: S,
    /// `2 ζ ω`.
    damping_per_mass: S,
    /// `1/ω`.
    time_scale: S,
    /// `m g / M` in m/s².
    weight_per_mass: S,
    /// `2 r`.
    diameter: S,
    /// `1 / 2r`.
    per_diameter: S,
    /// `d`.
    dielectric: S,
    /// `√(2 ε0 ε_r S M)` in coulombs.
    charge_unit: S,
    /// `σS` in charge units, and `√ε_r`.
    surface: Surface<S>,
    /// `1/(σS)` in charge units, or a stand-in where that is zero.
    per_tribo_charge: S,
    /// `d / (ε0 ε_r S R)`; 0 where the load is open or short.
    circuit_rate: S,
    /// Volts per charge unit at full overlap.
    field: S,
    /// Below this a velocity is not told from rest.
    velocity_margin: S,
    /// Joules below which the energy of a radian is not resolved.
    energy_floor: S,
    load: P::Load,
    force_law: P::ForceLaw,
    friction: P::Friction,
    sticking: P::Sticking,
    lateral_force: P::LateralForce,
}

impl<S: Scalar, P: Parts<S>> Sliding<S, P> {
    /// Undamped angular frequency `ω` of the first mode in rad/s.
    #[must_use]
    pub fn angular_frequency(&self) -> S {
        self.angular_frequency
    }

    /// Modal mass `M = 1/φ(L)²` in kg, at the tip.
    #[must_use]
    pub fn modal_mass(&self) -> S {
        self.modal_mass
    }

    /// `κ = Γ φ(L)`: how much more than the base's acceleration the tip feels.
    #[must_use]
    pub fn base_coupling(&self) -> S {
        self.base_coupling
    }

    /// Coulombs per unit of the state's charge, `√(2 ε0 ε_r S M)`.
    #[must_use]
    pub fn charge_unit(&self) -> S {
        self.charge_unit
    }

    /// Charge in charge units at which the voltage vanishes at a displacement: `σ S2`.
    #[must_use]
    #[inline]
    fn relaxed_charge(&self, displacement: S) -> S {
        self.surface.tribo_charge * self.overlap(displacement >= S::ZERO, displacement).inert
    }

    /// Whether the circuit is a short circuit: then the charge follows the displacement.
    #[inline]
    fn is_shorted(&self) -> bool {
        matches!(self.load.resistance(), Resistance::Short)
    }
}
