//! Parameters of a node.

use crate::bounds::{Bounds, ParameterError, first_outside};
use crate::energy::{Action, BudgetParameters, ListeningParameters};
use crate::scalar::Scalar;

/// Parameters of a [`Node`](super::Node), beside its map and its bank of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NodeParameters<const ACTIONS: usize> {
    /// Storage, income by slot of the day, standing power.
    pub budget: BudgetParameters<f32>,
    /// The ADC on the storage's voltage.
    pub converter: Converter,
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
    /// Blocks of the bank in a listen, 1 to 64. Broadband shaking is known to 0.85 over the root of this number.
    pub blocks: u32,
    /// Magnitude of a count from which on the sensor is at its end.
    pub clipped: i16,
}

/// Energies of the estimate itself (*knowing* the income), all of them at the load: see [`CostModel`](crate::energy::cost::CostModel).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct KnowingCost {
    /// Energy of a listen in J: sensor with its start-up, transfer, computing, wake-ups. 0 to 10.
    pub listen: f32,
    /// Energy of a reading of the voltage in J, with its wake-up and the computing after it. 0 to 10.
    pub reading: f32,
    /// Part of the mean income that readings may cost, 10⁻⁵ to 1, counted as the share of listens, which is that of
    /// [`ListeningParameters`].
    pub reading_share: f32,
    /// Shortest time between readings in s, 1 to 3600.
    pub shortest_reading: u32,
    /// Doublings from the shortest to the longest time between readings, 0 to 12.
    pub reading_doublings: u32,
}

/// Uncertainties (one standard deviation) of what is stated of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Spread {
    /// Of the gain of the map, its ratio of the true to the modelled power, before any reading, 10⁻³ to 10.
    pub gain: f32,
    /// Of its change in an hour, 0 to 10.
    pub gain_drift: f32,
    /// Of the standing power, relative, 0 to 1. The node learns the standing power while the harvester rests.
    pub standing: f32,
    /// Of the energy of an action, relative, 0 to 1.
    pub action: f32,
    /// Of the income after an hour, relative to its mean, 10⁻³ to 10, until listens show it.
    pub income: f32,
    /// Of the gain of the map after a change of the yield by a factor of e, relative, 0 to 10: a map of a harvester with
    /// another resonance is off by another factor elsewhere.
    pub gain_by_place: f32,
    /// Of the voltage at which the storage is full, relative, 0 to 0.1: how far it may be below the highest voltage of the
    /// storage as the converter reads it. A limit, not a deviation: threshold of the protection and reference together.
    /// Within it a storage that sinks from its highest voltage by less than a code of the converter an hour counts as full,
    /// since the voltage at which it is full may sink so.
    pub highest_voltage: f32,
    /// Of the income before anything is known, in W, 10⁻⁹ to 10³: the largest power of such a harvester.
    pub power: f32,
}

/// An action that a node carries out regularly if its storage allows it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Regular {
    /// Energy in J at the load, with the standing power of its time, 0 to 10⁶: what it takes at most.
    pub energy: f32,
    /// Time from one to the next in s, 1 to 10⁷.
    pub every: u32,
}

impl Regular {
    /// The first number outside its bounds, of the action with this index.
    pub(super) const fn outside(&self, index: usize) -> Option<ParameterError<f32>> {
        let [energy, every] = NAMES[if index < NAMES.len() { index } else { NAMES.len() - 1 }];
        let rows = [(energy, self.energy, 0.0, 1e6), (every, self.every as f32, 1.0, 1e7)];
        first_outside(&rows)
    }

    /// It as an action of the budget.
    pub(super) fn action(&self) -> Action<f32> {
        Action::at_once(self.energy)
    }
}

/// An analogue-to-digital converter on the storage's voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Converter {
    /// Resolution in bits, 4 to 16. Code `k` means that `k · full_scale / 2^bits` is the nearest voltage.
    pub bits: u32,
    /// Full scale in V, by the divider before it, 0.01 to 1000.
    pub full_scale: f32,
    /// Standard deviation of the noise of a reading in V, independent from reading to reading, 0 to `full_scale`.
    pub noise: f32,
}

/// The reason why there is no node.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum NodeError {
    /// A parameter outside its bounds.
    Parameter(ParameterError<f32>),
    /// A parameter of a part outside its bounds.
    Part {
        /// The field of [`NodeParameters`] that the part is built from.
        part: &'static str,
        /// The parameter of the part.
        error: ParameterError<f32>,
    },
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
            Self::Part { part, error } => write!(f, "{part}.{error}"),
            Self::Bank(error) => write!(f, "{error}, the rate of the bank of lines"),
            Self::Band { band: [lowest, highest] } => {
                write!(f, "the map has no frequency of the bank of lines, {lowest:?} Hz to {highest:?} Hz")
            }
        }
    }
}

impl core::error::Error for NodeError {}

/// Most blocks in a listen.
pub(super) const MOST_BLOCKS: u32 = 64;
/// Most samples of a sensor's start-up.
pub(super) const MOST_START_UP: u32 = 10_000;
/// Names of the numbers of the first actions in errors; the last ones stand for all others.
const NAMES: [[&str; 2]; 5] = [
    ["actions.0.energy", "actions.0.every"],
    ["actions.1.energy", "actions.1.every"],
    ["actions.2.energy", "actions.2.every"],
    ["actions.3.energy", "actions.3.every"],
    ["actions.energy", "actions.every"],
];
/// The numbers that belong to no other part, by name, with the least and the largest value of each. In single precision: a loop
/// over literals in double precision would be converted by the firmware.
static BOUNDS: [(&str, f32, f32); 20] = [
    ("converter.bits", 4.0, 16.0),
    ("converter.full_scale", 0.01, 1e3),
    ("sensor.rate", 1.0, 1e5),
    ("sensor.start_up", 0.0, MOST_START_UP as f32),
    ("sensor.blocks", 1.0, MOST_BLOCKS as f32),
    ("sensor.clipped", 1.0, 32_767.0),
    ("cost.listen", 0.0, 10.0),
    ("cost.reading", 0.0, 10.0),
    ("cost.reading_share", 1e-5, 1.0),
    ("cost.shortest_reading", 1.0, 3600.0),
    ("cost.reading_doublings", 0.0, 12.0),
    ("spread.gain", 1e-3, 10.0),
    ("spread.gain_drift", 0.0, 10.0),
    ("spread.standing", 0.0, 1.0),
    ("spread.action", 0.0, 1.0),
    ("spread.income", 1e-3, 10.0),
    ("spread.gain_by_place", 0.0, 10.0),
    ("spread.highest_voltage", 0.0, 0.1),
    ("spread.power", 1e-9, 1e3),
    ("reserve", 0.0, 1e6),
];
/// Part of a rate by which the rates of sensor and bank may differ: the rounding of both.
const SAME_RATE: f32 = 1e-5;

/// Names the part that an error is of.
pub(super) fn of_part(part: &'static str) -> impl Fn(ParameterError<f32>) -> NodeError {
    move |error| NodeError::Part { part, error }
}

impl<const ACTIONS: usize> NodeParameters<ACTIONS> {
    /// Refuses a bank of lines for another rate than that of the sensor.
    pub(super) fn check_rate(&self, bank: f32) -> Result<(), NodeError> {
        let rate = self.sensor.rate;
        if Scalar::abs(rate - bank) <= SAME_RATE * bank {
            return Ok(());
        }
        let bounds = Bounds { lowest: bank, highest: bank };
        Err(NodeError::Bank(ParameterError { field: "sensor.rate", value: rate, bounds }))
    }

    /// Checks the numbers that belong to no other part.
    pub(super) fn check(&self) -> Result<(), ParameterError<f32>> {
        let Self { converter, sensor, cost, spread, .. } = self;
        let count = f32::from_u32;
        Bounds { lowest: 0.0, highest: converter.full_scale }.check("converter.noise", converter.noise)?;
        let values = [
            count(converter.bits),
            converter.full_scale,
            sensor.rate,
            count(sensor.start_up),
            count(sensor.blocks),
            f32::from(sensor.clipped),
            cost.listen,
            cost.reading,
            cost.reading_share,
            count(cost.shortest_reading),
            count(cost.reading_doublings),
            spread.gain,
            spread.gain_drift,
            spread.standing,
            spread.action,
            spread.income,
            spread.gain_by_place,
            spread.highest_voltage,
            spread.power,
            self.reserve,
        ];
        for (value, &(field, lowest, highest)) in values.into_iter().zip(&BOUNDS) {
            Bounds { lowest, highest }.check(field, value)?;
        }
        if let Some(error) = self.actions.iter().enumerate().find_map(|(index, action)| action.outside(index))
        {
            return Err(error);
        }
        Ok(())
    }
}
