//! The methods that are compared, with their settings from loose to tight, and the scenes.

use Settings::{StepsPerPeriod, Tolerance};

use harvester_scene::scene_file::{self, Override, Scene, SceneError};

/// A method of the embedded core or of a peer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The core's exponential Radau with step control.
    ExponentialRadau,
    /// The core's TR-BDF2 with step control.
    TrBdf2,
    /// The core's explicit Runge-Kutta method with a fixed step.
    Rk4,
    /// The core's bump-stop method, with the ratio of its two steps that it has by default.
    DiscreteGradient,
    /// The backward differentiation formulas of `diffsol`.
    DiffsolBdf,
    DiffsolTrBdf2,
    /// The ESDIRK method of order 4 of `diffsol`.
    DiffsolEsdirk34,
    /// Dormand and Prince's method of order 5 of `differential-equations`.
    Dopri5,
    /// Dormand and Prince's method of order 8 of `differential-equations`.
    Dop853,
}

/// How the step of a method is chosen, with the loosest and the tightest setting.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Settings {
    /// A fixed number of steps per period of the base.
    StepsPerPeriod(f64, f64),
    /// A tolerance, from one power of ten to another.
    Tolerance(i32, i32),
}

struct Entry {
    method: Method,
    name: &'static str,
    /// The crate, if it is not the embedded core.
    peer: Option<&'static str>,
    settings: Settings,
}

const DIFFSOL: Option<&str> = Some("diffsol");
const DIFFERENTIAL_EQUATIONS: Option<&str> = Some("differential-equations");

/// A line of the list.
const fn entry(method: Method, name: &'static str, peer: Option<&'static str>, settings: Settings) -> Entry {
    Entry { method, name, peer, settings }
}

/// All methods, in the order of the enumeration and of the table.
const LIST: [Entry; 9] = [
    entry(Method::ExponentialRadau, "core exponential Radau", None, Tolerance(-1, -9)),
    entry(Method::TrBdf2, "core TR-BDF2", None, Tolerance(-1, -7)),
    entry(Method::Rk4, "core RK4", None, StepsPerPeriod(16.0, 16384.0)),
    entry(Method::DiscreteGradient, "core discrete gradient", None, StepsPerPeriod(250.0, 2e6)),
    entry(Method::DiffsolBdf, "diffsol BDF", DIFFSOL, Tolerance(-1, -12)),
    entry(Method::DiffsolTrBdf2, "diffsol TR-BDF2", DIFFSOL, Tolerance(-1, -12)),
    entry(Method::DiffsolEsdirk34, "diffsol ESDIRK34", DIFFSOL, Tolerance(-1, -12)),
    entry(Method::Dopri5, "DOPRI5", DIFFERENTIAL_EQUATIONS, Tolerance(-1, -12)),
    entry(Method::Dop853, "DOP853", DIFFERENTIAL_EQUATIONS, Tolerance(-1, -12)),
];

impl Method {
    /// All methods, in the order of the table.
    pub fn all() -> impl Iterator<Item = Self> {
        LIST.iter().map(|entry| entry.method)
    }

    /// The method of this name.
    pub fn named(name: &str) -> Option<Self> {
        LIST.iter().find(|entry| entry.name == name).map(|entry| entry.method)
    }

    fn entry(self) -> &'static Entry {
        &LIST[self as usize]
    }

    /// Its name in the table.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// The crate that it is of, if it is not the embedded core.
    pub fn peer(self) -> Option<&'static str> {
        self.entry().peer
    }

    /// Whether a setting is a number of steps per period of the base, and not a tolerance.
    pub fn is_fixed(self) -> bool {
        matches!(self.entry().settings, StepsPerPeriod(..))
    }

    /// The settings from loose to tight: two in each octave of steps, three in each decade of a tolerance.
    pub fn settings(self) -> Vec<f64> {
        match self.entry().settings {
            StepsPerPeriod(first, last) => {
                let count = (2.0 * (last / first).log2()).round() as i32;
                (0..=count).map(|k| (first * 2f64.powf(0.5 * f64::from(k))).round()).collect()
            }
            Tolerance(first, last) => {
                // By a division, so that each is the number nearest to its decimals.
                let tolerances = |power: i32| [10.0, 5.0, 2.0].map(|part| part / 10f64.powi(1 - power));
                (last..=first).rev().flat_map(tolerances).collect()
            }
        }
    }
}

/// A shipped scene with other values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// Name in the command line.
    pub name: &'static str,
    /// Name of the scene file, without ending.
    pub file: &'static str,
    /// Other values, as `KEY=VALUE`.
    pub overrides: &'static [&'static str],
}

const CONTACT_RUN: &str = "run={duration_s=3, settle_s=2}";
const SLIDING_RUN: &str = "run={duration_periods=54, settle_periods=36}";
const STICK_SLIP: [&str; 3] = [
    "excitation.amplitude_g=0.30",
    "excitation.frequency_hz=6",
    "run={duration_periods=18, settle_periods=12}",
];
/// The core of this comparison has the force law of the first paper.
const FIRST_LAW: &str = "parameters.force_law=transferred-charge";
const BUMP_STOP_RUN: &str = "run={duration_s=0.02, settle_s=0.005}";
/// A storage, at a voltage that the harvester exceeds.
const STORE: &str = "load={kind=\"rectified-store\", capacitance_f=1e-6, diode_drop_v=0.3, leakage_ohm=1e9, \
                     initial_v=5.0, draw={kind=\"none\"}}";
const STORE_OF_PIEZO: &str = "load={kind=\"rectified-store\", capacitance_f=1e-6, diode_drop_v=0.3, leakage_ohm=1e9, \
                              initial_v=0.5, draw={kind=\"none\"}}";

/// All of them, in the order of the table.
pub const CASES: [Case; 9] = [
    case("contact-100M", "contact-separation", &["load.resistance_ohm=1e8", CONTACT_RUN]),
    case("contact-1M", "contact-separation", &["load.resistance_ohm=1e6", CONTACT_RUN]),
    case("contact-1k", "contact-separation", &["load.resistance_ohm=1e3", CONTACT_RUN]),
    case("sliding-100M", "sliding", &["load.resistance_ohm=1e8", SLIDING_RUN]),
    case("sliding-1M", "sliding", &["load.resistance_ohm=1e6", SLIDING_RUN]),
    case("stick-slip", "sliding", &STICK_SLIP),
    case("contact-bridge", "rectified", &[FIRST_LAW, "excitation.frequency_hz=20.0", CONTACT_RUN]),
    case("sliding-bridge", "sliding", &[STORE, SLIDING_RUN]),
    case(
        "bump-stop-bridge",
        "bump-stop",
        &[STORE_OF_PIEZO, "parameters.beam_modes=4", "stop.rod_modes=1", BUMP_STOP_RUN],
    ),
];

const fn case(name: &'static str, file: &'static str, overrides: &'static [&'static str]) -> Case {
    Case { name, file, overrides }
}

impl Case {
    /// The scene.
    ///
    /// # Errors
    /// If a scene file was changed so that a value no longer fits.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        let overrides = self.overrides.iter().filter_map(|pair| pair.split_once('='));
        let overrides: Vec<Override> = overrides.map(|(key, value)| Override::new(key, value)).collect();
        scene_file::read(&scene_file::shipped(self.file), &overrides)
    }
}
