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
mod timeline;
mod years;

use model_core::node::{IncomeOfTime, Outage, Progress, Tier, Wake};

pub use self::compared::{Errors, Extent, Name, Row, STORAGES, Setup, Storage, Totals, rows};
pub(crate) use self::compared::{PARTS, ROWS, summary, timelines};
pub use self::harvester::{Kind, tone};
pub use self::oracle::Oracle;
pub use self::plant::{Hour, Parts, Run, World};
pub use self::settings::{OneNode, OneState, Settings};
pub use self::timeline::{Course, Timeline, VibrationKind};
pub use self::years::{Quarter, Stress, years};
pub use crate::embedded::{Deviation, Vibration};
pub use crate::stability::random::Source;

/// A node as its plant sees it: when it reads, and when it acts.
pub trait Strategy {
    /// Wakes it at a second, with the code of the storage's voltage where it was read; after a lock-out with `was_off`.
    fn wake(&mut self, now: u32, code: Option<u32>, was_off: bool) -> Wake;

    fn samples(&mut self, _samples: &[i16]) -> Progress {
        Progress::Idle
    }

    /// The income of the last hour.
    fn last_hour(&self) -> Option<IncomeOfTime>;

    /// Energy in J that estimating the income has taken.
    fn spent(&self) -> f64;
}

/// A node of the library with its state.
#[derive(Debug, Clone, Copy)]
pub struct Tiered<N: Tier> {
    pub node: N,
    pub state: N::State,
    hour: fn(&N::State) -> Option<IncomeOfTime>,
    /// The income since the start.
    overall: fn(&N, &N::State) -> IncomeOfTime,
    spent: fn(&N, &N::State) -> f64,
}

impl<N: Tier> Tiered<N> {
    fn new(
        node: N,
        hour: fn(&N::State) -> Option<IncomeOfTime>,
        overall: fn(&N, &N::State) -> IncomeOfTime,
        spent: fn(&N, &N::State) -> f64,
    ) -> Self {
        let state = node.start(0);
        Self { node, state, hour, overall, spent }
    }
}

impl<N: Tier> Strategy for Tiered<N> {
    fn wake(&mut self, now: u32, code: Option<u32>, was_off: bool) -> Wake {
        let Self { node, state, .. } = self;
        if was_off {
            node.wake_after(state, Outage::LockedOutUntil(now), code)
        } else {
            node.wake(state, now, code)
        }
    }

    fn samples(&mut self, samples: &[i16]) -> Progress {
        self.node.samples(&mut self.state, samples)
    }

    fn last_hour(&self) -> Option<IncomeOfTime> {
        (self.hour)(&self.state)
    }

    fn spent(&self) -> f64 {
        (self.spent)(&self.node, &self.state)
    }
}
