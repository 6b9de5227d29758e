//! A node of [`model_core::node`] on a simulated plant, under QEMU and on the host alike: `host-bench on-target --node`
//! compares what both log.
//!
//! | module | subject |
//! | --- | --- |
//! | `parts` | the node: processor, map, storage, actions |
//! | `plant` | the true node: storage, converter, accelerometer, on a day of a harvester that is not as designed |
//! | `day` | what shakes the harvester, and its yield by the full model, minute by minute |
//! | `world` | the plant with two slots of memory, and a supply that fails ten times |
//! | `cycle` | the loop from a start to the end of the day or to a loss of power |
//! | `entry` | what the log has |
//! | `target` | the loop on a microcontroller: a loss of power is a reset |
//! | `bare` | the program without plant and log, on the registers of a microcontroller or on registers in memory |

#[cfg(target_os = "none")]
pub mod bare;
mod cycle;
pub mod day;
mod entry;
pub mod parts;
mod plant;
#[cfg(target_os = "none")]
pub mod target;
mod world;

pub use cycle::{End, Failed, cycle};
pub use entry::{Entry, Hour, State};
pub use parts::{Part, Runner};
pub use plant::Plant;
pub use world::{Count, IMAGE_BYTES, IMAGE_EVERY, LOSSES, Loss, Moment, WORK, Work, World};

/// Counts time. Under QEMU it counts instructions.
pub trait Meter {
    /// Ticks since the start.
    fn ticks(&self) -> u64;
}

/// Counts nothing, for the host.
#[derive(Debug, Clone, Copy)]
pub struct NoMeter;

impl Meter for NoMeter {
    fn ticks(&self) -> u64 {
        0
    }
}
