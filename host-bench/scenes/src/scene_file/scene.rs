//! A scene as plain numbers in SI units: what a scene file says once it has been checked.

mod excitation;
mod node;

use std::path::PathBuf;

pub use self::excitation::{Burst, BurstShape, Excitation, Random, Sweep, Tone, Trace};
pub use self::node::{Action, EstimationCost, HOURS, Node, PartFigure, Storage};
use super::Summary;
pub use super::bump_stop::{
    Bimorph, BumpStop, BumpStopParameters, BumpStopStart, Contact, Coupling, StopParameters,
    TipMassParameters,
};
pub use super::contact_separation::{ContactSeparation, ContactSeparationParameters, Restitution};
use super::document::SceneError;
pub use super::sliding::{Sliding, SlidingParameters};
pub use super::triboelectric::{ForceLaw, StickCharge, TriboelectricStart};
pub use crate::market::Lockout;

/// A checked scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The file it came from, for messages.
    pub file: PathBuf,
    /// The harvester and its start.
    pub model: Model,
    /// What is connected to the harvester.
    pub load: Load,
    /// What shakes the base.
    pub excitation: Excitation,
    /// How long, and what is measured.
    pub run: RunSpan,
    /// Table `[limits]`: the name of each compared quantity and its limit, or the pressure for its limit, in the order of the keys.
    pub limits: Vec<(&'static str, f64)>,
}

impl Scene {
    /// The name that the file gives the scene: `contact-separation`, `sliding` or `bump-stop`.
    pub fn name(&self) -> &'static str {
        self.model.summary().name
    }
}

/// For each harvester: it, and the same to change it.
macro_rules! one_harvester {
    ($($harvester:ident $of:ident $of_mut:ident;)+) => {
        impl Scene {
            $(
                /// The harvester of this kind, for what is about that one only.
                ///
                /// # Errors
                /// If the scene is another one.
                pub fn $of(&self) -> Result<&$harvester, SceneError> {
                    if let Model::$harvester(model) = &self.model { Ok(model) } else { Err(self.another(stringify!($of))) }
                }

                /// The same, to change it.
                ///
                /// # Errors
                /// If the scene is another one.
                pub fn $of_mut(&mut self) -> Result<&mut $harvester, SceneError> {
                    // The error holds a copy of the name: it is made before the model is lent out.
                    let another = self.another(stringify!($of));
                    if let Model::$harvester(model) = &mut self.model { Ok(model) } else { Err(another) }
                }
            )+
        }

        $(impl From<$harvester> for Model {
            fn from(harvester: $harvester) -> Self {
                Self::$harvester(harvester)
            }
        })+
    };
}

one_harvester! {
    ContactSeparation contact_separation contact_separation_mut;
    Sliding sliding sliding_mut;
    BumpStop bump_stop bump_stop_mut;
}

impl Scene {
    fn another(&self, wanted: &str) -> SceneError {
        let reason = format!("is {:?}, must be {:?} here", self.name(), wanted.replace('_', "-"));
        SceneError::of_absent(&self.file, "scene", reason)
    }
}

/// The harvester.
#[derive(Debug, Clone, PartialEq)]
pub enum Model {
    /// A mass over a dielectric.
    ContactSeparation(ContactSeparation),
    /// A slider at the tip of a cantilever, rubbing over two patches.
    Sliding(Sliding),
    /// A piezoelectric cantilever that hits a rod.
    BumpStop(BumpStop),
}

impl Model {
    /// What is said of it where its kind does not matter.
    pub fn summary(&self) -> Summary {
        match self {
            Self::ContactSeparation(model) => model.summary(),
            Self::Sliding(model) => model.summary(),
            Self::BumpStop(model) => model.summary(),
        }
    }

    /// Coordinate in m, velocity in m/s and charge in C at the start, to change them; `None` for bump-stop, which starts with modes.
    pub fn start_mut(&mut self) -> Option<[&mut Option<f64>; 3]> {
        match self {
            Self::ContactSeparation(ContactSeparation { initial, .. })
            | Self::Sliding(Sliding { initial, .. }) => {
                Some([&mut initial.position_m, &mut initial.velocity_m_per_s, &mut initial.charge_c])
            }
            Self::BumpStop(_) => None,
        }
    }
}

/// What is connected to the harvester.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    Resistor {
        /// Resistance in Ω: 0 is a short circuit, infinity an open one.
        resistance_ohm: f64,
    },
    /// A full bridge into a storage capacitor.
    RectifiedStore(RectifiedStore),
    /// A full bridge into a bus of constant voltage.
    DcBus {
        /// Voltage of the bus in V.
        voltage_v: f64,
        /// Forward voltage in V of each of the two diodes that conduct at a time.
        diode_drop_v: f64,
    },
}

impl Load {
    /// Resistance in Ω between the harvester's terminals; behind a bridge infinite, as while it blocks.
    pub fn resistance_ohm(self) -> f64 {
        match self {
            Self::Resistor { resistance_ohm } => resistance_ohm,
            Self::RectifiedStore(_) | Self::DcBus { .. } => f64::INFINITY,
        }
    }

    /// The same bridge into a bus of constant voltage in V, as large a storage is; `None` for a resistor.
    pub fn with_voltage(self, voltage_v: f64) -> Option<Self> {
        match self {
            Self::Resistor { .. } => None,
            Self::RectifiedStore(RectifiedStore { diode_drop_v, .. }) | Self::DcBus { diode_drop_v, .. } => {
                Some(Self::DcBus { voltage_v, diode_drop_v })
            }
        }
    }
}

/// A storage capacitor behind a full bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectifiedStore {
    /// Capacitance in F.
    pub capacitance_f: f64,
    /// Forward voltage in V of each of the two diodes that conduct at a time.
    pub diode_drop_v: f64,
    /// Leakage resistance in Ω; infinity is no leakage.
    pub leakage_ohm: f64,
    /// Voltage in V at the start.
    pub initial_v: f64,
    /// What the node draws.
    pub draw: Draw,
}

/// What a node draws from its store while it is connected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Draw {
    /// Nothing.
    None,
    Resistor {
        /// Resistance in Ω.
        resistance_ohm: f64,
        /// When it is connected; `None`: always.
        lockout: Option<Lockout>,
    },
    /// A constant current.
    Current {
        /// Current in A.
        current_a: f64,
        /// When it is connected.
        lockout: Lockout,
    },
    /// A constant power.
    Power {
        /// Power in W.
        power_w: f64,
        /// When it is connected.
        lockout: Lockout,
    },
}

impl Draw {
    /// Thresholds of the draw; `None` if the draw is always connected, or if there is none.
    pub fn lockout(&self) -> Option<Lockout> {
        match *self {
            Self::None => None,
            Self::Resistor { lockout, .. } => lockout,
            Self::Current { lockout, .. } | Self::Power { lockout, .. } => Some(lockout),
        }
    }
}

/// How long to simulate, and from when to measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunSpan {
    /// End of the run in s.
    pub duration_s: f64,
    /// Start of the measuring window in s; the window ends at `duration_s`.
    pub settle_s: f64,
}

impl RunSpan {
    /// Length of the measuring window in s.
    pub fn window_s(&self) -> f64 {
        self.duration_s - self.settle_s
    }
}
