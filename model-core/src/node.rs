//! Estimates the harvested power of a sensor node, with a bound, for less than a thousandth of it where the storage's voltage suffices.
//!
//! A firmware engineer writes a [`Board`] and chooses a node; [`Runner`] does the rest. Nothing here waits: each call does a bounded amount of
//! work and says when it wants to be called again, so that a node is driven from interrupts, from an executor, or by [`Runner`].
//!
//! * [`VoltageNode`] reads the voltage of the storage by the ADC, and nothing else.
//! * [`MapNode`] does the same, and takes bursts of acceleration samples where that voltage says nothing of the income: a full storage, a
//!   coarse ADC on a large one, the power now. It looks them up in a response map, which the host's command `map` makes with the load that
//!   the harvester sees: a resistor for a matched converter, a bridge (`map --voltage`) for a rectifier straight into the storage.
//!
//! ```text
//! wake(second, code of the storage's voltage) → Wake { task, again_in, read }
//!     Task::Sleep             sleep for again_in seconds, then read the voltage if `read`, and wake
//!     Task::Burst             switch the sensor on, hand its samples to samples(), as the FIFO has them
//!     Task::Run(index)        carry the action out, and wake again
//! samples(&[i16]) → Progress::More(left), or Progress::Done(finding): switch the sensor off, and wake
//! ```
//!
//! Every income is estimated with a bound of two and a half standard deviations. `docs/node.md` has the choice, all parameters and a glossary;
//! `examples/node_voltage.rs` and `examples/node.rs` are complete nodes.

mod board;
mod map;
#[cfg(feature = "embedded-batteries")]
mod smart_battery;
mod tier;
mod voltage;

pub use board::{Board, Fault, Runner, SaveError, Step};
pub use map::{
    Bursts, Finding, MapNode, MapParameters, MapState, NodeError, OutputPower, PredictedPower, Sensor,
};
pub use tier::{
    ActionStatus, IncomeOfTime, Outage, PowerSource, Progress, Status, StoreReading, Task, TaskAccount,
    TaskLedger, Thresholds, TickClock, Tier, Verdict, Wake,
};
pub use voltage::{
    BatteryElement, CapacitorElement, Element, LearntCapacitance, Tolerances, VoltageNode, VoltageParameters,
    VoltageState,
};

pub use crate::energy::{Battery, Capacitor, ResponseMap, StorageParameters};
pub use crate::excitation::LineBank;

use crate::bounds::{ParameterError, first_outside};
use crate::scalar::Scalar;

/// A [`MapNode`] with its map in flash, and the sizes of most nodes: `ACTIONS` actions, sections of at most `SECTION` samples,
/// `SECTIONS` of them in a burst.
pub type FlashMapNode<const ACTIONS: usize, const SECTION: usize = 20, const SECTIONS: usize = 16> =
    MapNode<&'static [u16], SECTION, SECTIONS, ACTIONS>;

/// Seconds in an hour.
const HOUR: u32 = 3600;

/// A count as a number.
fn real(count: u32) -> f32 {
    f32::from_u32(count)
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

impl Converter {
    /// The code of a voltage of the storage in V, for a driver that gives volts or millivolts: the nearest one, 0 for not-a-number.
    #[must_use]
    pub fn code(&self, voltage: f32) -> u32 {
        let codes = 1_u32.checked_shl(self.bits).unwrap_or(0);
        (voltage / self.full_scale * real(codes) + 0.5).to_u32().min(codes.saturating_sub(1))
    }
}

/// Names of the numbers of the first actions in errors; the last ones stand for all others.
const NAMES: [[&str; 2]; 5] = [
    ["actions.0.energy", "actions.0.every"],
    ["actions.1.energy", "actions.1.every"],
    ["actions.2.energy", "actions.2.every"],
    ["actions.3.energy", "actions.3.every"],
    ["actions.energy", "actions.every"],
];
