//! A scene as plain numbers in SI units: what a scene file says once it has been checked.

mod excitation;
mod node;

use std::path::PathBuf;

pub use self::excitation::{Burst, BurstShape, Excitation, Random, Sweep, Tone, Trace};
pub use self::node::{Action, EstimationCost, HOURS, Node, PartFigure, Storage};
pub use super::bump_stop::{
    BumpStop, BumpStopParameters, BumpStopStart, Contact, Coupling, StopParameters, TipMassParameters,
};
pub use super::contact_separation::{
    ContactSeparation, ContactSeparationParameters, ContactSeparationStart, Restitution,
};
use super::document::SceneError;
pub use super::sliding::{Sliding, SlidingParameters, SlidingStart};

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
    /// Table `[limits]`: the name of each compared quantity and its limit, or the pressure for its limit, in the order of the
    /// keys.
    pub limits: Vec<(&'static str, f64)>,
}

impl Scene {
    /// The name that the file gives the scene: `contact-separation`, `sliding` or `bump-stop`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self.model {
            Model::ContactSeparation(_) => "contact-separation",
            Model::Sliding(_) => "sliding",
            Model::BumpStop(_) => "bump-stop",
        }
    }

    /// The contact-separation harvester, for what is about that one only.
    ///
    /// # Errors
    /// If the scene is another one.
    pub fn contact_separation(&self) -> Result<&ContactSeparation, SceneError> {
        match &self.model {
            Model::ContactSeparation(model) => Ok(model),
            Model::Sliding(_) | Model::BumpStop(_) => Err(self.another()),
        }
    }

    /// The same, to change it.
    ///
    /// # Errors
    /// If the scene is another one.
    pub fn contact_separation_mut(&mut self) -> Result<&mut ContactSeparation, SceneError> {
        // The error holds a copy of the name: it is made before the model is lent out.
        let another = self.another();
        match &mut self.model {
            Model::ContactSeparation(model) => Ok(model),
            Model::Sliding(_) | Model::BumpStop(_) => Err(another),
        }
    }

    fn another(&self) -> SceneError {
        let reason = format!("is {:?}, must be \"contact-separation\" here", self.name());
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

/// Electrostatic force law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForceLaw {
    /// The transferred charge as that of a capacitor, equations (16) and (28) of Fu, Ouyang and Davis:
    /// on the overlap in sliding, on the total capacitance in contact-separation. Gives the paper's
    /// trends; not passive in contact-separation.
    TransferredCharge,
    /// The field in the gap between the surfaces: the law that conserves energy.
    GapField,
    /// No force on the motion: what the load takes is created.
    None,
}

/// What the charge does while the mass is held on the dielectric, or the slider sticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StickCharge {
    /// It stays as it was: the load is open.
    Frozen,
    /// It goes on flowing through the load.
    Relaxing,
}

impl Model {
    /// The sliding harvester, for what is about that one only.
    #[must_use]
    pub fn sliding(&self) -> Option<&Sliding> {
        if let Self::Sliding(model) = self { Some(model) } else { None }
    }

    /// The bump-stop harvester, for what is about that one only.
    #[must_use]
    pub fn bump_stop(&self) -> Option<&BumpStop> {
        if let Self::BumpStop(model) = self { Some(model) } else { None }
    }
}

/// What is connected to the harvester.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// A resistor.
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
    #[must_use]
    pub fn resistance_ohm(self) -> f64 {
        match self {
            Self::Resistor { resistance_ohm } => resistance_ohm,
            Self::RectifiedStore(_) | Self::DcBus { .. } => f64::INFINITY,
        }
    }

    /// The same bridge into a bus of constant voltage in V, as large a storage is; `None` for a resistor.
    #[must_use]
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
    /// A resistor.
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
    #[must_use]
    pub fn lockout(&self) -> Option<Lockout> {
        match *self {
            Self::None => None,
            Self::Resistor { lockout, .. } => lockout,
            Self::Current { lockout, .. } | Self::Power { lockout, .. } => Some(lockout),
        }
    }
}

/// Under-voltage lock-out with hysteresis. A store that starts between the two starts disconnected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lockout {
    /// The draw is connected where the store rises to this voltage, in V.
    pub turn_on_v: f64,
    /// It is disconnected where the store falls to this voltage, in V.
    pub turn_off_v: f64,
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
    #[must_use]
    pub fn window_s(&self) -> f64 {
        self.duration_s - self.settle_s
    }
}
