//! The components of a contact-separation harvester.

use core::fmt::Debug;

use super::force_law::ForceLaw;
use crate::part::force_law::{AnyForceLaw, GapField};
use crate::part::load::{AnyLoad, Load};
use crate::part::parasitic::{NoParasitic, Parasitic, ParasiticCapacitance};
use crate::part::restitution::{AnyRestitution, Restitution};
use crate::part::stick_charge::{StickCharge, Sticking};
use crate::scalar::{Polynomial, Scalar};
use crate::scene::parts;

/// The components of a contact-separation harvester, each by its type: firmware contains only the chosen ones.
///
/// ```
/// use model_core::part::load::Resistor;
/// use model_core::part::parasitic::ParasiticCapacitance;
/// use model_core::part::restitution::ConstantRestitution;
/// use model_core::scene::contact_separation::{Choices, TransferredCharge};
///
/// let choices = Choices::new(Resistor { resistance: 1e8_f32 }, ConstantRestitution { coefficient: 0.75 })
///     .force_law(TransferredCharge)
///     .parasitic(ParasiticCapacitance { capacitance: 1e-12 });
/// ```
///
/// A component of the wrong kind is a compile error that names the alternatives: a bridge is no load of this scene.
///
/// ```compile_fail,E0277
/// # use model_core::part::rectifier::FullBridge;
/// # use model_core::part::restitution::ConstantRestitution;
/// # use model_core::part::storage::DcBus;
/// # use model_core::scene::contact_separation::{Choices, Parameters};
/// let bridge = FullBridge { diode_drop: 0.3, storage: DcBus { voltage: 3.0 } };
/// let scene = Parameters {
///     mass: 5e-3,
///     stiffness: 80.0,
///     damping_ratio: 0.005,
///     initial_gap: 3e-3,
///     electrode_area: 4e-4,
///     dielectric_thickness: 5e-5,
///     relative_permittivity: 2.0,
///     charge_density: 50e-6,
///     choices: Choices::new(bridge, ConstantRestitution { coefficient: 0.75 }),
/// }
/// .build();
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Choices<L, R, F = GapField, C = NoParasitic, K = StickCharge> {
    /// Load; a finite resistance must be from 10⁻⁹ to 10³⁰ Ω.
    pub load: L,
    /// Coefficient of restitution.
    pub restitution: R,
    /// Electrostatic force law.
    pub force_law: F,
    /// Parasitic capacitance `C_p` in parallel with the load, 0 to 10⁻³ F.
    pub parasitic: C,
    /// Whether the mass can stick to the dielectric, and the behaviour of the charge in stick.
    pub sticking: K,
}

/// Every choice at run time.
pub type AnyChoices<S, M = Polynomial> =
    Choices<AnyLoad<S>, AnyRestitution<S, M>, AnyForceLaw, ParasiticCapacitance<S>, StickCharge>;

impl<L, R> Choices<L, R> {
    /// A load and a coefficient of restitution, with the force of the field, no parasitic capacitance, and a frozen charge in stick.
    #[must_use]
    pub const fn new(load: L, restitution: R) -> Self {
        Self { load, restitution, force_law: GapField, parasitic: NoParasitic, sticking: StickCharge::Frozen }
    }
}

impl<L, R, F, C, K> Choices<L, R, F, C, K> {
    /// With another electrostatic force law.
    #[must_use]
    pub fn force_law<Other>(self, force_law: Other) -> Choices<L, R, Other, C, K> {
        let Self { load, restitution, parasitic, sticking, .. } = self;
        Choices { load, restitution, force_law, parasitic, sticking }
    }

    /// With another parasitic capacitance.
    #[must_use]
    pub fn parasitic<Other>(self, parasitic: Other) -> Choices<L, R, F, Other, K> {
        let Self { load, restitution, force_law, sticking, .. } = self;
        Choices { load, restitution, force_law, parasitic, sticking }
    }

    /// With another behaviour on the dielectric.
    #[must_use]
    pub fn sticking<Other>(self, sticking: Other) -> Choices<L, R, F, C, Other> {
        let Self { load, restitution, force_law, parasitic, .. } = self;
        Choices { load, restitution, force_law, parasitic, sticking }
    }
}

parts! { S:
    /// The load.
    L = Load: Load<S>,
    /// The coefficient of restitution.
    R = Restitution: Restitution<S>,
    /// The electrostatic force law.
    F = ForceLaw: ForceLaw<S>,
    /// The parasitic capacitance.
    C = Parasitic: Parasitic<S>,
    /// The behaviour on the dielectric.
    K = Sticking: Sticking,
}
