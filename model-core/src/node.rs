//! Estimates the harvested power of a sensor node, with a bound, for less than a thousandth of it where the storage's voltage tells.
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
//! samples(&[i16]) → Progress::More(left) or Progress::Done(finding)
//! ```
//!
//! Every income is told with a bound of two and a half standard deviations. `docs/node.md` has the choice, all parameters and a glossary;
//! `examples/node_voltage.rs` and `examples/node.rs` are complete nodes.

mod board;
mod map;
mod parameters;
mod tier;
mod voltage;

pub use board::{Board, Fault, Runner, SaveError, Step};
pub use map::{Bursts, Finding, MapNode, MapParameters, MapState, Modelled, NodeError, Sensor, Yield};
pub use parameters::{Converter, Regular};
pub use tier::{Gap, IncomeOfTime, Progress, StoreReading, Task, Tier, Wake};
pub use voltage::{Tolerances, VoltageNode, VoltageParameters, VoltageState};

pub use crate::energy::{Capacitor, ResponseMap, StorageParameters};
pub use crate::excitation::LineBank;

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
