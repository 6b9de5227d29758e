//! Parameters of a node.

use crate::bounds::{Bounds, ParameterError};
use crate::energy::{Action, BudgetParameters, CorrectionParameters, ListeningParameters};
use crate::excitation::ExcitationError;

/// Parameters of a [`Node`](super::Node), beside its map and its bank of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NodeParameters<const ACTIONS: usize> {
    /// Storage, income by slot of the day, standing power.
    pub budget: BudgetParameters<f32>,
    /// The converter of the storage's voltage, and how far the map may be off: its gain at the start and in an hour.
    pub converter: CorrectionParameters<f32>,
    /// When to listen.
    pub listening: ListeningParameters<f32>,
    /// The accelerometer.
    pub sensor: Sensor,
    /// What knowing costs.
    pub cost: KnowingCost,
    /// How far the stated figures may be off.
    pub spread: Spread,
    /// Energy in J at the load that actions leave in the storage above the lock-out, 0 to 10⁶: what the node lives on while
    /// the harvester rests.
    pub reserve: f32,
    /// What the node does, the most important first.
    pub actions: [Regular; ACTIONS],
}

/// The accelerometer of a node and how long a listen takes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sensor {
    /// Samples in a second; those of the bank of lines.
    pub rate: f32,
    /// Samples after switching on that are not valid, up to 10⁴.
    pub start_up: u32,
    /// Blocks of the bank in a listen, 1 to 64. Broadband shaking is known to a half over the root of this number.
    pub blocks: u32,
    /// Magnitude of a count from which on the sensor is at its end.
    pub clipped: i16,
}

/// What it costs to know the income, all of it at the load: see [`CostModel`](crate::energy::cost::CostModel).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct KnowingCost {
    /// Energy of a listen in J: sensor with its start-up, transfer, computing, wake-ups. 0 to 10.
    pub listen: f32,
    /// Energy of a reading of the voltage in J, with its wake-up and the computing after it. 0 to 10.
    pub reading: f32,
    /// Part of the mean income that readings may cost, 10⁻⁵ to 1. The share of listens is that of
    /// [`ListeningParameters`].
    pub reading_share: f32,
    /// Shortest time between readings in s, 1 to 3600.
    pub shortest_reading: u32,
    /// Doublings from the shortest to the longest time between readings, 0 to 12.
    pub reading_doublings: u32,
}

/// One standard deviation of what a node cannot know beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Spread {
    /// Of the standing power, relative, 0 to 1. The node learns the standing power while the harvester rests.
    pub standing: f32,
    /// Of the energy of an action, relative, 0 to 1.
    pub action: f32,
    /// Of the income after an hour, relative to its mean, 10⁻³ to 10, until listens show it.
    pub income: f32,
    /// Of the gain of the map after a change of the yield by a factor of e, relative, 0 to 10: a map of a harvester with
    /// another resonance is off by another factor elsewhere.
    pub gain_by_place: f32,
    /// Of the income before anything is known, in W, 10⁻⁹ to 10³: the largest power of such a harvester.
    pub power: f32,
}

/// An action that a node carries out regularly if its storage allows it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Regular {
    /// The action.
    pub action: Action<f32>,
    /// Time from one to the next in s, 1 or more.
    pub every: u32,
}

/// The reason why there is no node.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum NodeError {
    /// A parameter outside its bounds.
    Parameter(ParameterError<f32>),
    /// The bank of lines does not fit the rate of the sensor.
    Bank(ExcitationError),
}

impl From<ParameterError<f32>> for NodeError {
    fn from(error: ParameterError<f32>) -> Self {
        Self::Parameter(error)
    }
}

impl From<ExcitationError> for NodeError {
    fn from(error: ExcitationError) -> Self {
        Self::Bank(error)
    }
}

impl core::fmt::Display for NodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Parameter(error) => error.fmt(f),
            Self::Bank(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for NodeError {}

impl<const ACTIONS: usize> NodeParameters<ACTIONS> {
    /// Checks the numbers that belong to no other part.
    pub(super) fn check(&self) -> Result<(), ParameterError<f32>> {
        let Self { sensor, cost, spread, .. } = self;
        let count = |number: u32| f32::from(u16::try_from(number).unwrap_or(u16::MAX));
        for (field, value, lowest, highest) in [
            ("sensor.rate", sensor.rate, 1.0, 1e5),
            ("sensor.start_up", count(sensor.start_up), 0.0, 1e4),
            ("sensor.blocks", count(sensor.blocks), 1.0, 64.0),
            ("sensor.clipped", f32::from(sensor.clipped), 1.0, 32_767.0),
            ("cost.listen", cost.listen, 0.0, 10.0),
            ("cost.reading", cost.reading, 0.0, 10.0),
            ("cost.reading_share", cost.reading_share, 1e-5, 1.0),
            ("cost.shortest_reading", count(cost.shortest_reading), 1.0, 3600.0),
            ("cost.reading_doublings", count(cost.reading_doublings), 0.0, 12.0),
            ("spread.standing", spread.standing, 0.0, 1.0),
            ("spread.action", spread.action, 0.0, 1.0),
            ("spread.income", spread.income, 1e-3, 10.0),
            ("spread.gain_by_place", spread.gain_by_place, 0.0, 10.0),
            ("spread.power", spread.power, 1e-9, 1e3),
            ("reserve", self.reserve, 0.0, 1e6),
        ] {
            Bounds::new(lowest, highest).check(field, value)?;
        }
        for regular in &self.actions {
            Bounds::new(1.0, 65_535.0).check("actions.every", count(regular.every))?;
        }
        Ok(())
    }
}
