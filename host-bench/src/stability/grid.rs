//! The cases.

mod contact_separation;
mod sliding;

use serde::{Serialize, Serializer};

use crate::scene_file::{ForceLaw, Scene};

pub use contact_separation::ContactSeparationSetting;
pub use sliding::SlidingSetting;

/// One case: what differs from the shipped scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Setting {
    /// Of the contact-separation scene.
    ContactSeparation(ContactSeparationSetting),
    /// Of the sliding scene.
    Sliding(SlidingSetting),
}

fn law<S: Serializer>(law: &ForceLaw, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(law_name(*law))
}

/// The name that a scene file has for a force law.
#[must_use]
pub(super) fn law_name(law: ForceLaw) -> &'static str {
    match law {
        ForceLaw::TransferredCharge => "transferred-charge",
        ForceLaw::GapField => "gap-field",
    }
}

impl Setting {
    /// The scene of this case, made of the shipped one.
    #[must_use]
    pub fn scene(&self, base: &Scene) -> Scene {
        match self {
            Self::ContactSeparation(setting) => setting.scene(base),
            Self::Sliding(setting) => setting.scene(base),
        }
    }

    /// Load resistance in Ω.
    #[must_use]
    pub fn resistance_ohm(&self) -> f64 {
        match self {
            Self::ContactSeparation(setting) => setting.resistance_ohm,
            Self::Sliding(setting) => setting.resistance_ohm,
        }
    }

    /// Whether this is one of the cases that are shown to the reference as well.
    #[must_use]
    pub fn is_for_reference(&self) -> bool {
        match self {
            Self::ContactSeparation(setting) => setting.is_for_reference(),
            Self::Sliding(setting) => setting.is_for_reference(),
        }
    }

    /// The options that make `run` run this case.
    #[must_use]
    pub fn overrides(&self) -> String {
        match self {
            Self::ContactSeparation(setting) => setting.overrides(),
            Self::Sliding(setting) => setting.overrides(),
        }
    }
}

/// Which cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Grid {
    /// All, in each precision: 3648 of contact-separation, 4032 of sliding.
    #[default]
    Whole,
    /// Of contact-separation every third decade of the resistance, of sliding every other value.
    Coarse,
}

/// Of which scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// Contact-separation.
    ContactSeparation,
    /// Sliding.
    Sliding,
    /// Bump-stop, whose cases are those of [`super::bump_stop::settings`].
    BumpStop,
}

impl Grid {
    /// The cases of a scene.
    #[must_use]
    pub fn settings(self, kind: Kind) -> Vec<Setting> {
        let whole = self == Self::Whole;
        match kind {
            Kind::ContactSeparation => contact_separation::settings(if whole { 1 } else { 3 })
                .into_iter()
                .map(Setting::ContactSeparation)
                .collect(),
            Kind::Sliding => sliding::settings(whole).into_iter().map(Setting::Sliding).collect(),
            Kind::BumpStop => Vec::new(),
        }
    }
}
