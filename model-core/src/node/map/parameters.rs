//! Parameters of the node with a map.

use crate::bounds::{Bounds, ParameterError, first_outside};
use crate::node::VoltageParameters;

/// Parameters of a [`MapNode`](super::MapNode), beside its map and its bank of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MapParameters<const ACTIONS: usize> {
    /// All that the node by the voltage alone needs.
    pub voltage: VoltageParameters<ACTIONS>,
    /// The accelerometer.
    pub sensor: Sensor,
    /// When to take a burst.
    pub bursts: Bursts,
    /// Standard deviation of the gain of the map, its ratio of the true to the predicted output power, before any comparison
    /// with the storage, 10⁻³ to 10: 0.05 of a harvester whose gain was measured, 1 of one of which nothing is known.
    pub gain: f32,
    /// Of its change in an hour, 0 to 10.
    pub gain_drift: f32,
}

/// The accelerometer of a node and how long a burst takes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sensor {
    /// Samples in a second; those of the bank of lines.
    pub rate: f32,
    /// Samples after switching on that are not valid, up to 10⁴.
    pub start_up: u32,
    /// Blocks of the bank in a burst, 1 to 64. Broadband vibration is known to 0.85 over the root of this number.
    pub blocks: u32,
    /// Magnitude of a count from which on the sensor is at its end.
    pub clipped: i16,
}

/// What a burst costs, and what it must be worth.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bursts {
    /// Energy of a burst in J at the load: sensor with its start-up, transfer, computing, wake-ups. 0 to 10.
    pub energy: f32,
    /// J by which the bound of an hour must narrow for each J that a burst costs, 0 to 10⁶. Bursts then end a
    /// time in which the power has changed by as much.
    pub worth: f32,
    /// Shortest time from a burst to the next in s, 1 to 3600.
    pub shortest: u32,
    /// Time in s from a burst to the next where the voltage resolves the income, 3600 to 10⁷: it compares the map with the
    /// storage. A part of a day would fall on the same times of each day.
    pub check: u32,
}

impl<const ACTIONS: usize> MapParameters<ACTIONS> {
    /// The first number outside its bounds, but for those of [`VoltageParameters`].
    pub(super) const fn first_outside(&self) -> Option<ParameterError<f32>> {
        let Self { sensor, bursts, gain, gain_drift, .. } = self;
        first_outside(&[
            ("sensor.rate", sensor.rate, 1.0, 1e5),
            ("sensor.start_up", sensor.start_up as f32, 0.0, MOST_START_UP as f32),
            ("sensor.blocks", sensor.blocks as f32, 1.0, MOST_BLOCKS as f32),
            ("sensor.clipped", sensor.clipped as f32, 1.0, 32_767.0),
            ("bursts.energy", bursts.energy, 0.0, 10.0),
            ("bursts.worth", bursts.worth, 0.0, 1e6),
            ("bursts.shortest", bursts.shortest as f32, 1.0, 3600.0),
            ("bursts.check", bursts.check as f32, 3600.0, 1e7),
            ("gain", *gain, 1e-3, 10.0),
            ("gain_drift", *gain_drift, 0.0, 10.0),
        ])
    }

    /// The rate of the sensor, if it is another one than that of the bank of lines.
    pub(super) const fn other_rate(&self, bank: f32) -> Option<ParameterError<f32>> {
        let rate = self.sensor.rate;
        if (rate - bank).abs() <= SAME_RATE * bank {
            return None;
        }
        let bounds = Bounds { lowest: bank, highest: bank };
        Some(ParameterError { field: "sensor.rate", value: rate, bounds })
    }
}

/// The reason why there is no node.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum NodeError {
    /// A parameter outside its bounds.
    Parameter(ParameterError<f32>),
    /// The rate of the sensor is not that of the bank of lines.
    Bank(ParameterError<f32>),
    /// The map has none of the frequencies of the bank of lines.
    Band {
        /// The lowest and the highest of these frequencies in Hz.
        band: [f32; 2],
    },
}

impl From<ParameterError<f32>> for NodeError {
    fn from(error: ParameterError<f32>) -> Self {
        Self::Parameter(error)
    }
}

impl core::fmt::Display for NodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Parameter(error) => error.fmt(f),
            Self::Bank(error) => write!(f, "{error}, the rate of the bank of lines"),
            Self::Band { band: [lowest, highest] } => {
                write!(f, "the map has no frequency of the bank of lines, {lowest:?} Hz to {highest:?} Hz")
            }
        }
    }
}

impl core::error::Error for NodeError {}

/// Most blocks in a burst.
const MOST_BLOCKS: u32 = 64;
/// Most samples of a sensor's start-up.
const MOST_START_UP: u32 = 10_000;
/// Relative difference up to which two rates are the same.
const SAME_RATE: f32 = 1e-5;
