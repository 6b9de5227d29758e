//! Sensor nodes on a simulated plant: a harvester by the full model, a storage, an ADC, an accelerometer, and the strategies by
//! which a node may know its income and decide on its actions.
//!
//! The truth is a trajectory in `f64` over every second of every hour, at a tolerance of 10⁻³, into a resistor (the matched
//! converter of `node.toml`). What it delivers in a minute flows evenly into the storage. A node with a map has that of the
//! harvester as designed, made by
//!
//! ```text
//! host-bench map node.toml --amplitude 0.1:4 --frequency 17:24 --output contact-separation.bin
//! host-bench map sliding.toml --amplitude 2:8 --frequency 16:21 --output sliding.bin
//! host-bench map bump-stop-none.toml --amplitude 1:50 --frequency 200:280 --output bump-stop.bin
//! ```
//!
//! and reads 16-bit samples of the vibration with gravity and noise. Energies are scaled so that the mean income is 2.9 µW.

mod baseline;
mod compared;
mod harvester;
mod oracle;
pub(crate) mod picture;
mod plant;
mod settings;
mod strategy;
mod timeline;
mod years;

pub use self::compared::{Errors, Extent, Name, Row, STORAGES, Setup, Storage, Totals, rows};
pub(crate) use self::compared::{ROWS, timelines};
pub use self::harvester::{Deviation, Kind, Vibration, tone};
pub use self::oracle::Oracle;
pub use self::plant::{Hour, Parts, Run, World};
pub use self::settings::{OneNode, OneState, Settings};
pub use self::strategy::{Strategy, Tiered};
pub use self::timeline::{Course, Timeline, VibrationKind};
pub use self::years::{Quarter, Stress, years};
pub use crate::stability::random::Source;
