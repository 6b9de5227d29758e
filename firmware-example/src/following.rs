//! The laboratory node: it steps the harvester's model along the samples of an accelerometer that always runs.
//!
//! Acceleration samples in; each second the energy that the harvester's model delivers from them, the storage as the
//! energy budget has it, and a decision: sleep, measure, or transmit. It costs some hundred times what it harvests: a node
//! that is to live on its harvester is one of [`model_core::node`], such as [`crate::node`].
//!
//! What a developer replaces is [`Board`], and the parts in `harvester.rs`. The ecosystem has no traits for this seam
//! that fit: `embedded-hal` has none for a converter or an accelerometer, and the crate `accelerometer` one for three
//! axes at once, on an old `micromath`.

mod estimate;
mod flash_board;
mod harvester;
mod power_manager;

pub use estimate::Following;
pub(crate) use estimate::settings;
pub use flash_board::{FlashBoard, STORE_VOLTAGE};
pub use harvester::{DIODE_DROP, following};
pub(crate) use harvester::{behind_bridge, charging};
pub use power_manager::{CAPACITANCE, PowerManager, PowerManagerState};

/// What the node needs of the hardware.
pub trait Board {
    /// The next sample along the axis of the harvester as a raw count, [`RATE_HZ`] a second; `None` if it
    /// was lost.
    fn acceleration(&mut self) -> Option<i16>;

    /// Voltage of the storage in volts, as the converter reads it; `None` where it was not read. Asked once a second.
    fn storage_voltage(&mut self) -> Option<f32>;

    /// Does what was decided.
    fn carry_out(&mut self, decision: Decision);
}

/// What to do with a second.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// Nothing: the storage is to keep what it has.
    Sleep,
    /// Take a measurement.
    Measure,
    /// Send what was measured.
    Transmit,
}

/// Size of a slot of flash in bytes, with room for the image of the node.
pub const SLOT_BYTES: usize = 768;

/// Samples per second.
pub const RATE_HZ: u32 = 400;
/// Metres per second squared in a raw count: a range of 2 g in 16 bits.
pub const SCALE: f32 = model_core::part::GRAVITY as f32 / 16384.0;
/// How well the converter reads the storage's voltage, in volts: half a step of 12 bits over 5 V, and noise.
pub const VOLTAGE_ERROR: f32 = 2e-3;

/// What the node knows after another second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Whole seconds so far.
    pub second: u32,
    /// Energy harvested in the last of them, in joules.
    pub harvested: f32,
    /// Energy in the storage, in joules, before what is decided is spent.
    pub stored: f32,
    /// What was decided.
    pub decision: Decision,
    /// Steps of the model that it took.
    pub steps: u32,
}

/// Why there is no report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodeError {
    /// A parameter was refused.
    Parameters,
    /// The harvester's model could not be stepped.
    Model,
}
