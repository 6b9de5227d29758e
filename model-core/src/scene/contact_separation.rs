//! The contact-separation triboelectric harvester: a mass over a charged dielectric.
//!
//! Fu, Ouyang and Davis, J. Phys. D 53 (2020), equations (19) to (28). A mass on a spring carries one electrode above
//! a charged dielectric; the other electrode lies under the dielectric. The base moves, and the mass may hit the
//! dielectric, rebound, or stick. A load resistance and a parasitic capacitance connect the electrodes in parallel.
//!
//! ```text
//! m g'' + 2 ζ √(k m) g' + k (g − d0) = −m a − F_e                            (19), (20)
//! V = (σ S g − q (g + d_e)) / (ε0 S)                                         (24), (25)
//! q' = V / R + C_p V'                                                        (23)
//! ```
//!
//! | symbol | quantity | unit | sign |
//! | --- | --- | --- | --- |
//! | `a` | base acceleration | m/s² | positive in the direction of an opening gap |
//! | `g`, `d0` | gap; gap at rest | m | positive: open |
//! | `m`, `k`, `ζ` | mass, stiffness, damping ratio | kg, N/m, 1 | |
//! | `S` | electrode area | m² | |
//! | `d`, `ε_r` | thickness and relative permittivity of the dielectric | m, 1 | |
//! | `d_e = d/ε_r` | equivalent air thickness of the dielectric | m | |
//! | `σ` | tribo-charge surface density | C/m² | magnitude |
//! | `q` | transferred charge | C | a positive `V` drives it through the load |
//! | `Q = q − C_p V` | total charge through the load | C | as `q` |
//! | `V`, `R` | terminal voltage, load resistance | V, Ω | |
//! | `C_p`, `c = C_p/(ε0 S)` | parasitic capacitance | F, 1/m | |
//! | `F_e` | electrostatic force | N | positive: attraction |
//!
//! # The electrical state
//!
//! The charge state is the total charge `Q` through the load, with `Q' = V / R` and `V = (σ S g − Q (g + d_e)) / (ε0
//! S + C_p (g + d_e))`. The velocity does not appear, so `Q` stays smooth through an impact, while the equation for
//! `q` has a jump of `C_p σ g'`. There is no mass matrix, and `Q` is constant with an open load. Its unit is `√(2 ε0
//! S m)`, the *charge unit*, in which a charge squared is a force per mass in m/s².
//!
//! # Force laws
//!
//! The paper's formula for `F_e` is not available. [`TransferredCharge`] reproduces its results and is not passive;
//! [`GapField`] is energy-consistent electrostatics.

mod automaton;
mod choices;
mod circuit;
mod flow;
mod force_law;
mod parameters;
mod state;

pub use crate::scene::coupled::{CHARGE, ModeFactor, POSITION as GAP, STATES, VELOCITY};
pub use choices::{AnyChoices, Choices, Parts};
pub use flow::Flow;
pub use parameters::Parameters;
pub use state::{Mode, Start};

pub use crate::part::force_law::{AnyForceLaw, GapField, NoForce, TransferredCharge};
pub use crate::part::stick_charge::{NeverSticks, StickCharge};

pub(crate) use crate::part::stick_charge::Sticking;

use crate::part::load::{Load, Resistance};
use crate::scalar::Scalar;

/// A contact-separation harvester with checked parameters: constant coefficients only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSeparation<S: Scalar, P: Parts<S>> {
    mass: S,
    stiffness: S,
    /// `d0`.
    initial_gap: S,
    /// `ω0² = k/m`.
    stiffness_per_mass: S,
    /// `2 ζ ω0 = c/m`.
    damping_per_mass: S,
    /// `ω0`.
    angular_frequency: S,
    /// `1/ω0`.
    time_scale: S,
    /// `d_e = d/ε_r`.
    dielectric: S,
    /// `√(2 ε0 S m)` in C.
    charge_unit: S,
    /// `ε0 S` in F·m.
    permittivity_area: S,
    /// `σ S` in charge units.
    tribo_charge: S,
    /// `1/(σ S)` in 1/charge unit, with `σ S` raised to at least 10⁻¹².
    per_tribo_charge: S,
    /// `C_p/(ε0 S)` in 1/m.
    parasitic: S,
    /// `1/(ε0 S R)` in 1/(m s); 0 for an open or short-circuited load.
    circuit_rate: S,
    /// `charge_unit/(ε0 S)` in V/m per charge unit.
    field: S,
    /// Rebound speed in m/s below which the mass may stick: `10⁻⁴ ω0 d0`.
    stick_speed: S,
    /// Energy per radian in J below which no relative error is resolved.
    energy_floor: S,
    load: P::Load,
    force_law: P::ForceLaw,
    restitution: P::Restitution,
    sticking: P::Sticking,
}

impl<S: Scalar, P: Parts<S>> ContactSeparation<S, P> {
    /// Undamped angular frequency `√(k/m)` in rad/s.
    #[must_use]
    pub fn angular_frequency(&self) -> S {
        self.angular_frequency
    }

    /// Charge in C per charge unit of the state, `√(2 ε0 S m)`.
    #[must_use]
    pub fn charge_unit(&self) -> S {
        self.charge_unit
    }

    /// Total charge in charge units at which the voltage vanishes at `gap`: `σ S g / (g + d_e)`.
    #[inline]
    fn relaxed_charge(&self, gap: S) -> S {
        // A trial step may end far below contact, near the pole of this formula. The impact then cuts the step; the
        // value must only be finite.
        let gap = gap.max(S::from_f64(-0.5) * self.dielectric);
        self.tribo_charge * gap / (gap + self.dielectric)
    }

    /// Whether the load is a short circuit: the charge then follows the gap.
    #[inline]
    fn is_shorted(&self) -> bool {
        matches!(self.load.resistance(), Resistance::Short)
    }
}
