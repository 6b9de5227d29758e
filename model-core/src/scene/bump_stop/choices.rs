//! The components of a bump-stop harvester.

use core::fmt::Debug;

use super::circuit::{Circuit, Resistive};
use super::contact_law::{AnyContact, NoStop};
use super::stop::{Stop, StopChoice};
use super::tip_mass::{NoTipMass, TipMassChoice};
use crate::part::beam::TipMass;
use crate::part::load::AnyLoad;
use crate::part::monomorph::{Bimorph, Monomorph, Transducer};
use crate::part::rectifier::FullBridge;
use crate::scalar::Scalar;
use crate::scene::parts;

/// Whether the voltage acts back on the beam.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not say whether the voltage acts back on the beam",
    note = "a coupling is `TwoWay`, `OneWay` or `AnyCoupling`"
)]
pub(crate) trait Coupling: Copy + Debug + PartialEq {
    /// Whether the voltage acts back on the beam.
    fn is_two_way(&self) -> bool;
}

/// The voltage acts back on the beam: the harvested energy is taken from the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TwoWay;

impl Coupling for TwoWay {
    #[inline]
    fn is_two_way(&self) -> bool {
        true
    }
}

/// The voltage does not act back on the beam: equations (1) and (10) of the paper as printed. Its text announces the
/// effect on the beam for the equation of motion, which is [`TwoWay`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OneWay;

impl Coupling for OneWay {
    #[inline]
    fn is_two_way(&self) -> bool {
        false
    }
}

/// A coupling chosen at run time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnyCoupling {
    /// As [`TwoWay`].
    TwoWay,
    /// As [`OneWay`].
    OneWay,
}

impl Coupling for AnyCoupling {
    #[inline]
    fn is_two_way(&self) -> bool {
        *self == Self::TwoWay
    }
}

/// The components of a bump-stop harvester, each by its type: firmware contains only the chosen ones.
///
/// ```
/// use model_core::part::load::Resistor;
/// use model_core::scene::bump_stop::{Choices, ResidualFlexibility, Stop};
///
/// let free_beam = Choices::new(Resistor { resistance: 1e6_f32 });
/// let with_a_stop = free_beam.stop(Stop {
///     length: 20e-3,
///     section: 4e-6,
///     young_modulus: 70e9,
///     density: 2700.0,
///     position: 50e-3,
///     gap: 10e-6,
///     contact_compliance: 0.0,
///     contact: ResidualFlexibility,
/// });
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Choices<L, T = NoStop, K = TwoWay, M = NoTipMass, X = Monomorph> {
    /// The circuit at the terminals: a [`Resistive`] load, or, by [`Choices::behind`], a [`FullBridge`].
    pub load: L,
    /// The stop.
    pub stop: T,
    /// Whether the voltage acts back on the beam.
    pub coupling: K,
    /// A rigid body at the tip of the beam: a [`TipMass`], or [`NoTipMass`].
    pub tip_mass: M,
    /// The piezoelectric layers: a [`Monomorph`] or a [`Bimorph`].
    pub transducer: X,
}

/// Every choice at run time, except the one between a load and a bridge.
pub type AnyChoices<S, L = Resistive<AnyLoad<S>>> =
    Choices<L, Stop<S, AnyContact<S>>, AnyCoupling, Option<TipMass<S>>, Option<Bimorph>>;

impl<L> Choices<Resistive<L>> {
    /// A load resistance, without stop and tip mass, with two-way coupling and one piezoelectric layer.
    #[must_use]
    pub const fn new(load: L) -> Self {
        Choices {
            load: Resistive(load),
            stop: NoStop,
            coupling: TwoWay,
            tip_mass: NoTipMass,
            transducer: Monomorph,
        }
    }
}

impl<S, R> Choices<FullBridge<S, R>> {
    /// A full bridge with its storage, without stop and tip mass, with two-way coupling and one piezoelectric layer.
    #[must_use]
    pub const fn behind(bridge: FullBridge<S, R>) -> Self {
        Choices { load: bridge, stop: NoStop, coupling: TwoWay, tip_mass: NoTipMass, transducer: Monomorph }
    }
}

impl<L, T, K, M, X> Choices<L, T, K, M, X> {
    /// With a stop.
    #[must_use]
    pub fn stop<Other>(self, stop: Other) -> Choices<L, Other, K, M, X> {
        let Self { load, coupling, tip_mass, transducer, .. } = self;
        Choices { load, stop, coupling, tip_mass, transducer }
    }

    /// With another coupling.
    #[must_use]
    pub fn coupling<Other>(self, coupling: Other) -> Choices<L, T, Other, M, X> {
        let Self { load, stop, tip_mass, transducer, .. } = self;
        Choices { load, stop, coupling, tip_mass, transducer }
    }

    /// With a tip mass.
    #[must_use]
    pub fn tip_mass<Other>(self, tip_mass: Other) -> Choices<L, T, K, Other, X> {
        let Self { load, stop, coupling, transducer, .. } = self;
        Choices { load, stop, coupling, tip_mass, transducer }
    }

    /// With other piezoelectric layers.
    #[must_use]
    pub fn transducer<Other>(self, transducer: Other) -> Choices<L, T, K, M, Other> {
        let Self { load, stop, coupling, tip_mass, .. } = self;
        Choices { load, stop, coupling, tip_mass, transducer }
    }
}

/// The contact law of beam and rod, by the choice of the stop.
pub(super) type ContactOf<S, P> = <<P as Parts<S>>::Stop as StopChoice<S>>::Contact;

parts! { S:
    /// The circuit at the terminals.
    L = Load: Circuit<S>,
    /// The stop.
    T = Stop: StopChoice<S>,
    /// Whether the voltage acts back on the beam.
    K = Coupling: Coupling,
    /// A rigid body at the tip of the beam.
    M = TipMass: TipMassChoice<S>,
    /// The piezoelectric layers.
    X = Transducer: Transducer<S>,
}
