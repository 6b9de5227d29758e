//! The contact-separation triboelectric harvester: a mass over a charged dielectric.
//!
//! Fu, Ouyang and Davis, J. Phys. D 53 (2020), equations (19) to (28). A mass `m` on a spring `k`
//! with damping ratio `ζ` carries one electrode at a gap `g` above a dielectric of thickness `d`
//! and permittivity `ε_r` that holds the tribo-charge surface density `σ`; the other electrode lies
//! under it. The base shakes with acceleration `a`, the mass may hit the dielectric and rebound
//! with a coefficient of restitution, and may be held there. A load resistance `R` and a parasitic
//! capacitance `C_p` in parallel join the electrodes.
//!
//! ```text
//! m g'' + c g' + k (g − d0) = −m a − F_e            c = 2 ζ √(k m)           (19), (20)
//! V = (σ S g − q (g + d_e)) / (ε0 S)                d_e = d / ε_r            (24), (25)
//! q' = V / R + C_p V'                                                       (23)
//! ```
//!
//! # The electrical state
//!
//! The state is not the transferred charge `q` but the total charge that has passed the load,
//! `Q = q − C_p V`. Its equation is `Q' = V / R`, and `V` in terms of it is
//! `V = (σ S g − Q (g + d_e)) / (ε0 S + C_p (g + d_e))`: the velocity does not appear, so `Q` stays
//! smooth through an impact, where the equation for `q` has a jump of `C_p σ g'`; there is no
//! mass matrix; and with the load open `Q` is constant. It is kept in units of `√(2 ε0 S m)`, in
//! which the electrostatic force per mass is a plain square.
//!
//! # Force laws
//!
//! See [`TransferredCharge`] and [`GapField`]: the paper's own formula is lost. The first
//! reproduces its findings and is not passive, the second is the energy-consistent electrostatics.

mod automaton;
mod choices;
mod closed_form;
mod electrical_port;
mod flow;
mod force_law;
mod identity;
mod parameters;
mod start;

pub use crate::scene::coupled::ModeFactor;
pub use crate::scene::coupled::{CHARGE, POSITION as GAP, STATES, VELOCITY};
pub use automaton::Mode;
pub use choices::{AnyChoices, Choices, Parts};
pub use flow::Flow;
pub use parameters::Parameters;
pub use start::Start;

pub use crate::part::force_law::{AnyForceLaw, GapField, TransferredCharge};
pub use crate::part::stick_charge::{NeverSticks, StickCharge};

pub(crate) use crate::part::stick_charge::Sticking;

use crate::part::load::{Load, Resistance};
use crate::scalar::Scalar;

/// A harvester whose parameters have been checked: coefficients only, nothing that changes.
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
    /// `√(2 ε0 S m)`, in coulombs.
    charge_unit: S,
    /// `ε0 S` in F·m.
    permittivity_area: S,
    /// `σ S` in charge units.
    tribo_charge: S,
    /// `1/(σ S)`, or a stand-in where that is zero.
    per_tribo_charge: S,
    /// `C_p/(ε0 S)` in 1/m.
    parasitic: S,
    /// `1/(ε0 S R)`; 0 where the load is open or short.
    circuit_rate: S,
    /// Volts per charge unit and metre: `charge_unit/(ε0 S)`.
    field: S,
    /// Below this rebound speed the mass may be held: `10⁻⁴ ω0 d0`.
    stick_speed: S,
    /// Joules below which the energy of a radian is not resolved.
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

    /// Coulombs per unit of the state's charge, `√(2 ε0 S m)`.
    #[must_use]
    pub fn charge_unit(&self) -> S {
        self.charge_unit
    }

    /// Total charge in charge units at which the voltage vanishes at `gap`: `σ S g / (g + d_e)`.
    #[must_use]
    #[inline]
    fn relaxed_charge(&self, gap: S) -> S {
        // A trial step may end far below contact, where this has a pole; the step is then cut at
        // the impact, and only a finite value is asked for.
        let gap = gap.max(S::from_f64(-0.5) * self.dielectric);
        self.tribo_charge * gap / (gap + self.dielectric)
    }

    /// Whether the circuit is a short circuit: then the charge follows the gap.
    #[inline]
    fn is_shorted(&self) -> bool {
        matches!(self.load.resistance(), Resistance::Short)
    }
}
