//! The components of a sliding harvester.

use core::fmt::Debug;

use super::force_law::ForceLaw;
use super::force_law::{AnyLateralForce, LateralForce, NoLateralForce};
use crate::part::force_law::{AnyForceLaw, GapField};
use crate::part::friction::{Friction, PatchFriction};
use crate::part::load::{AnyLoad, Load};
use crate::part::stick_charge::{StickCharge, Sticking};
use crate::scalar::Scalar;
use crate::scene::parts;

/// The components of a sliding harvester, each by its type: firmware contains only the chosen ones.
///
/// ```
/// use model_core::part::load::Resistor;
/// use model_core::scene::sliding::{Choices, PatchFriction, TransferredCharge};
///
/// let friction =
///     PatchFriction { static_active: 0.35, static_inert: 0.25, kinetic_active: 0.30, kinetic_inert: 0.20 };
/// let choices = Choices::new(Resistor { resistance: 1e8_f32 }, friction).force_law(TransferredCharge);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Choices<L, R, F = GapField, K = StickCharge, T = NoLateralForce> {
    /// Load; a finite resistance must be from 10⁻⁹ to 10³⁰ Ω.
    pub load: L,
    /// Friction between slider and patches.
    pub friction: R,
    /// Electrostatic force law.
    pub force_law: F,
    /// Whether the slider can stick, and the behaviour of the charge in stick.
    pub sticking: K,
    /// Whether the field exerts a force along the plane.
    pub lateral_force: T,
}

/// Every choice at run time.
pub type AnyChoices<S> = Choices<AnyLoad<S>, PatchFriction<S>, AnyForceLaw, StickCharge, AnyLateralForce>;

impl<L, R> Choices<L, R> {
    /// A load and a friction law, with the force of the field normal to the plane, no lateral force, and a frozen charge in stick.
    #[must_use]
    pub const fn new(load: L, friction: R) -> Self {
        Self {
            load,
            friction,
            force_law: GapField,
            sticking: StickCharge::Frozen,
            lateral_force: NoLateralForce,
        }
    }
}

impl<L, R, F, K, T> Choices<L, R, F, K, T> {
    /// With another electrostatic force law.
    #[must_use]
    pub fn force_law<Other>(self, force_law: Other) -> Choices<L, R, Other, K, T> {
        let Self { load, friction, sticking, lateral_force, .. } = self;
        Choices { load, friction, force_law, sticking, lateral_force }
    }

    /// With another behaviour of the slider at rest.
    #[must_use]
    pub fn sticking<Other>(self, sticking: Other) -> Choices<L, R, F, Other, T> {
        let Self { load, friction, force_law, lateral_force, .. } = self;
        Choices { load, friction, force_law, sticking, lateral_force }
    }

    /// With another lateral force.
    #[must_use]
    pub fn lateral_force<Other>(self, lateral_force: Other) -> Choices<L, R, F, K, Other> {
        let Self { load, friction, force_law, sticking, .. } = self;
        Choices { load, friction, force_law, sticking, lateral_force }
    }
}

parts! { S:
    /// The load.
    L = Load: Load<S>,
    /// The friction.
    R = Friction: Friction<S>,
    /// The electrostatic force law.
    F = ForceLaw: ForceLaw<S>,
    /// The behaviour of the slider at rest.
    K = Sticking: Sticking,
    /// The lateral force of the field.
    T = LateralForce: LateralForce,
}
