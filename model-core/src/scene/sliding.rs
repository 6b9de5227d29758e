//! The sliding-mode triboelectric harvester: a cantilever whose tip slides on a charged patch.
//!
//! Fu, Ouyang and Davis, J. Phys. D 53 (2020), equations (1) to (18). The tip of a cantilever carries a slider, a
//! disc with one electrode and a charged dielectric. The slider rests by its weight on two patches in one plane that
//! move with the base: the *active* patch, a disc of the same radius under the beam's straight position, which is the
//! other electrode, and the *inert* patch around it. The base moves along the plane. In the first mode `φ` of the
//! beam with the slider ([`crate::part::beam`]):
//!
//! ```text
//! x'' + 2 ζ ω x' + ω² x = −κ a + (F_k + F_lat) / M      M = 1/φ(L)²,  κ = Γ φ(L)   (1) to (4)
//! F_k = −μ_k(x) N sgn x',    N = m g + F_e                                         (5)
//! q' = V / R,    V = (σ S2 − q) / C,    C = ε0 ε_r S1 / d                          (12) to (15)
//! ```
//!
//! | symbol | quantity | unit | sign |
//! | --- | --- | --- | --- |
//! | `a` | base acceleration | m/s² | positive in the direction of `x` |
//! | `x` | displacement of the tip from the centre of the active patch | m | |
//! | `ω`, `ζ` | angular frequency and damping ratio of the first mode | rad/s, 1 | |
//! | `M`, `κ` | modal mass at the tip; base coupling | kg, 1 | |
//! | `m`, `r` | mass and radius of the slider | kg, m | |
//! | `F_k`, `F_lat` | kinetic friction; lateral force of the field | N | positive in the direction of `x` |
//! | `N`, `F_e` | normal force; electrostatic force | N | positive: pressing |
//! | `μ_k`, `μ_s` | kinetic, static friction coefficients: area means ([`crate::part::friction`]) | 1 | |
//! | `S = π r²` | area of the slider | m² | |
//! | `S1`, `S2 = S − S1` | overlap of slider and active patch (`part::disc_overlap`), and the remainder | m² | |
//! | `s1`, `s2` | `S1/S` and `S2/S` | 1 | |
//! | `σ` | tribo-charge surface density | C/m² | magnitude |
//! | `d`, `ε_r` | thickness and relative permittivity of the dielectric | m, 1 | |
//! | `q` | transferred charge | C | a positive `V` drives it through the load |
//! | `t` | `σ S` in charge units | 1 | `≥ 0` |
//! | `V`, `R` | terminal voltage, load resistance | V, Ω | |
//!
//! # Stick
//!
//! A slider at rest sticks while static friction balances the load, `|M (ω² x + κ a) − F_lat| ≤ μ_s(x) N`: the modal
//! equation with zero velocity and acceleration. The formula of equation (10) is lost; its text names a
//! derivative of the mode and an equivalent mass of the beam. The shear at the tip, `E I φ'''(L)`, has the slider's mass
//! in place of the modal one and would release the slider with an acceleration in the wrong direction. At
//! release the slider moves against the sign of this load. No kinetic coefficient exceeds the static one of its
//! patch, so the acceleration then has the direction of the motion.
//!
//! # Corners
//!
//! The overlap has a corner at `x = 0`. The sign of `x` is therefore part of the mode, and the crossing of 0 an
//! event: the equations of each mode are smooth.
//!
//! # Units of the charge
//!
//! The charge unit is `√(2 ε0 ε_r S M)`, in which the force of [`TransferredCharge`] per modal mass is `q²/s1`.

mod automaton;
mod choices;
mod circuit;
mod flow;
mod force_law;
mod parameters;
mod state;

pub use crate::scene::coupled::{CHARGE, POSITION as DISPLACEMENT, STATES, VELOCITY};
pub use choices::{AnyChoices, Choices, Parts};
pub use flow::Flow;
pub(crate) use force_law::LateralForce;
pub use force_law::{AnyLateralForce, FieldLateralForce, NoLateralForce};
pub use parameters::Parameters;
pub use state::{Mode, Start};

pub use crate::part::force_law::{AnyForceLaw, GapField, NoForce, TransferredCharge};
pub(crate) use crate::part::friction::Friction;
pub use crate::part::friction::{Frictionless, PatchFriction};
pub use crate::part::stick_charge::{NeverSticks, StickCharge};

pub(crate) use crate::part::stick_charge::Sticking;

use crate::part::load::{Load, Resistance};
use crate::scalar::Scalar;
use force_law::Surface;

/// A sliding harvester with checked parameters: constant coefficients only.
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
    /// `√(2 ε0 ε_r S M)` in C.
    charge_unit: S,
    /// `σS` in charge units, and `√ε_r`.
    surface: Surface<S>,
    /// `1/(σS)` in 1/charge unit, with `σS` raised to at least 10⁻¹².
    per_tribo_charge: S,
    /// `d / (ε0 ε_r S R)` in 1/s; 0 for an open or short-circuited load.
    circuit_rate: S,
    /// [`crate::integrate::System::is_harmonic`].
    harmonic: bool,
    /// Voltage in V per charge unit at full overlap.
    field: S,
    /// Speed in m/s below which a velocity counts as zero.
    velocity_margin: S,
    /// Energy per radian in J below which no relative error is resolved.
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

    /// `κ = Γ φ(L)`: inertial acceleration of the tip relative to the base acceleration.
    #[must_use]
    pub fn base_coupling(&self) -> S {
        self.base_coupling
    }

    /// Charge in C per charge unit of the state, `√(2 ε0 ε_r S M)`.
    #[must_use]
    pub fn charge_unit(&self) -> S {
        self.charge_unit
    }

    /// Charge in charge units at which the voltage vanishes at a displacement: `σ S2`.
    #[inline]
    fn relaxed_charge(&self, displacement: S) -> S {
        self.surface.tribo_charge * self.overlap(displacement >= S::ZERO, displacement).inert
    }

    /// Whether the load is a short circuit: the charge then follows the displacement.
    #[inline]
    fn is_shorted(&self) -> bool {
        matches!(self.load.resistance(), Resistance::Short)
    }
}
