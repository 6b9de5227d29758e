//! The parts that a sliding harvester is made of.

use core::fmt::Debug;

use super::force_law::ForceLaw;
use super::lateral_force::{AnyLateralForce, LateralForce, NoLateralForce};
use crate::part::force_law::{AnyForceLaw, GapField};
use crate::part::friction::{Friction, PatchFriction};
use crate::part::load::{AnyLoad, Load};
use crate::part::stick_charge::{StickCharge, Sticking};
use crate::scalar::Scalar;

/// The parts of a sliding harvester, each by its type: what is not named is not compiled.
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
    /// Whether the slider can stick, and what the charge does then.
    pub sticking: K,
    /// Whether the field pulls the slider along the plane.
    pub lateral_force: T,
}

/// Every choice at run time.
pub type AnyChoices<S> = Choices<AnyLoad<S>, PatchFriction<S>, AnyForceLaw, StickCharge, AnyLateralForce>;

impl<L, R> Choices<L, R> {
    /// A load and a friction; the force of the field across the plane and none along it, and a charge that is
    /// frozen in stick.
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

    /// With another choice of what happens where the slider comes to rest.
    #[must_use]
    pub fn sticking<Other>(self, sticking: Other) -> Choices<L, R, F, Other, T> {
        let Self { load, friction, force_law, lateral_force, .. } = self;
        Choices { load, friction, force_law, sticking, lateral_force }
    }

    /// With another choice of whether the field pulls along the plane.
    #[must_use]
    pub fn lateral_force<Other>(self, lateral_force: Other) -> Choices<L, R, F, K, Other> {
        let Self { load, friction, force_law, sticking, .. } = self;
        Choices { load, friction, force_law, sticking, lateral_force }
    }
}

/// The types of [`Choices`] as one.
pub trait Parts<S: Scalar>: Copy + Debug + PartialEq {
    /// The load.
    type Load: Load<S>;
    /// The friction.
    type Friction: Friction<S>;
    /// The electrostatic force law.
    type ForceLaw: ForceLaw<S>;
    /// What happens where the slider comes to rest.
    type Sticking: Sticking;
    /// Whether the field pulls along the plane.
    type LateralForce: LateralForce;

    /// The choices themselves.
    fn choices(&self) -> &ChoicesOf<S, Self>;
}

/// The choices of some parts.
type ChoicesOf<S, P> = Choices<
    <P as Parts<S>>::Load,
    <P as Parts<S>>::Friction,
    <P as Parts<S>>::ForceLaw,
    <P as Parts<S>>::Sticking,
    <P as Parts<S>>::LateralForce,
>;

impl<S, L, R, F, K, T> Parts<S> for Choices<L, R, F, K, T>
where
    S: Scalar,
    L: Load<S>,
    R: Friction<S>,
    F: ForceLaw<S>,
    K: Sticking,
    T: LateralForce,
{
    type Load = L;
    type Friction = R;
    type ForceLaw = F;
    type Sticking = K;
    type LateralForce = T;

    #[inline(always)]
    fn choices(&self) -> &Self {
        self
    }
}
