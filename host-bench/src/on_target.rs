//! The firmware built for each core, run under QEMU, and what its log says.
//!
//! The counts are of *instructions*: QEMU runs with a virtual clock on which every instruction takes
//! a nanosecond, so they are the same on every run and every machine. They are not cycles: on a
//! Cortex-M4F a division takes 14 of those, a load up to 2 and a taken branch 2 to 4.

pub mod accuracy;
pub mod build;
pub mod core;
pub mod decode;
pub mod image;
pub mod native;
pub mod node;
pub mod qemu;
pub mod size;
pub mod symbols;
pub mod toolchain;

use self::build::Binary;
use self::core::Core;
use self::decode::{Sample, Section};
use self::size::Size;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;
use thiserror::Error;

/// What one core made of the firmware.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// The core.
    pub core: Core,
    /// Instructions counted for an instruction: 1, or there would be no figures.
    pub calibration: f64,
    /// Bytes of flash that the workloads add to a firmware without them.
    pub flash: u64,
    /// Size of the whole firmware.
    pub size: Size,
    /// The workloads, in the order in which they ran.
    pub workloads: Vec<Workload>,
}

/// What one workload cost on one core, and where it got to.
#[derive(Debug, Clone, PartialEq)]
pub struct Workload {
    /// Its name in the firmware.
    pub name: String,
    /// Deepest stack in bytes, from the top of RAM.
    pub stack: u64,
    /// The states that it logged, as raw bits, and what it had cost to get there; at least one.
    pub samples: Vec<Sample>,
    /// Instructions in a tick of the board's counter.
    instructions_per_tick: f64,
}

/// A stretch of a workload, between two samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// Steps taken.
    pub steps: u64,
    /// Time simulated, in seconds.
    pub seconds: f64,
    /// Instructions executed.
    pub instructions: f64,
}

impl Workload {
    /// From the start to the last sample.
    #[must_use]
    pub fn whole(&self) -> Stretch {
        self.stretch(None)
    }

    /// From sample number `first` to the last one.
    #[must_use]
    pub fn after(&self, first: usize) -> Stretch {
        self.stretch(self.samples.get(first))
    }

    fn stretch(&self, from: Option<&Sample>) -> Stretch {
        let counts = |sample: Option<&Sample>| {
            sample.map_or((0, 0, 0), |sample| (sample.simulated_us, sample.steps, sample.ticks))
        };
        let (start, end) = (counts(from), counts(self.samples.last()));
        Stretch {
            seconds: (end.0 - start.0) as f64 * 1e-6,
            steps: end.1 - start.1,
            instructions: (end.2 - start.2) as f64 * self.instructions_per_tick,
        }
    }
}

impl Stretch {
    /// Instructions for a step.
    #[must_use]
    pub fn instructions_per_step(&self) -> f64 {
        self.instructions / self.steps as f64
    }

    /// Instructions for a simulated second.
    #[must_use]
    pub fn instructions_per_second(&self) -> f64 {
        self.instructions / self.seconds
    }
}

/// Why a measurement did not come about, or cannot be trusted.
#[derive(Debug, Error)]
pub enum Error {
    /// There is nothing to compile with, or the firmware does not build.
    #[error(transparent)]
    Build(#[from] build::Error),
    /// QEMU is missing, or the run went wrong.
    #[error(transparent)]
    Qemu(#[from] qemu::Error),
    /// The log is not what the firmware writes.
    #[error("{core}: {source}")]
    Log {
        /// The core.
        core: Core,
        /// What is wrong with it.
        source: decode::Error,
    },
    /// A firmware file could not be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// A firmware file is not one that this core could run.
    #[error("{}: {source}", path.display())]
    Image {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: image::Error,
    },
    /// Code is linked that the firmware promises to do without.
    #[error("{core}: the firmware links code that can panic, or double arithmetic: {}", symbols.join(", "))]
    Symbols {
        /// The core.
        core: Core,
        /// The names of that code.
        symbols: Vec<String>,
    },
    /// The core comes to other bits than the host.
    #[error(
        "{core}: {workload}: sample {sample}, number {number}: the bits are {found:08x}, \
         on the host {expected:08x}"
    )]
    Bits {
        /// The core.
        core: Core,
        /// The workload's name.
        workload: String,
        /// Which sample, from 0.
        sample: usize,
        /// Which number of it, from 0.
        number: usize,
        /// What the core logged.
        found: u32,
        /// What the host computed.
        expected: u32,
    },
    /// The core logs something that the host does not have to compare with.
    #[error("{core}: {what}")]
    Other {
        /// The core.
        core: Core,
        /// What differs.
        what: String,
    },
    /// The reference, or the host's own run, did not come about.
    #[error("on the host: {0}")]
    Host(String),
    /// The instructions of the calibration did not count as one each.
    #[error("{core}: an instruction counts as {instructions:.4}; the board's clock is not what it should be")]
    Calibration {
        /// The core.
        core: Core,
        /// What it counts as.
        instructions: f64,
    },
}

/// What an instruction may count as, when the instructions are known: the slowest SysTick resolves
/// 63 of a million.
const CALIBRATED: RangeInclusive<f64> = 0.999..=1.001;

/// The firmware with no workload.
const EMPTY: Binary = Binary::new("empty");

/// Builds `binary` for `core`, checks it, runs it for at most `time_limit`, and reads its log.
///
/// # Errors
///
/// When something is missing, fails, or contradicts what the figures are supposed to mean.
pub fn measure(core: Core, binary: Binary, time_limit: Duration) -> Result<Measurement, Error> {
    let firmware = Firmware::build(core, binary)?;
    let size = firmware.check()?;
    let empty = Firmware::build(core, EMPTY)?;
    let flash = size.flash.saturating_sub(Size::of(&empty.image()?).flash);

    let log = qemu::run(core, &firmware.path, time_limit)?;
    let mut workloads =
        workloads(core, &firmware.bytes, &log).map_err(|source| Error::Log { core, source })?;
    // The firmware calibrates before anything else.
    if workloads.first().is_none_or(|first| first.name != "calibration") {
        return Err(Error::Log { core, source: decode::Error::Incomplete });
    }
    let calibration = workloads.remove(0).whole().instructions_per_step();
    if !CALIBRATED.contains(&calibration) {
        return Err(Error::Calibration { core, instructions: calibration });
    }
    Ok(Measurement { core, calibration, flash, size, workloads })
}

/// A binary, built.
struct Firmware {
    core: Core,
    binary: Binary,
    path: PathBuf,
    bytes: Vec<u8>,
}

impl Firmware {
    fn build(core: Core, binary: Binary) -> Result<Self, Error> {
        let path = build::build(core, binary)?;
        let bytes = std::fs::read(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
        Ok(Self { core, binary, path, bytes })
    }

    fn image(&self) -> Result<image::Image<'_>, Error> {
        image::open(&self.bytes, self.core).map_err(|source| Error::Image { path: self.path.clone(), source })
    }

    /// Refuses code that should not be there, and gives the size of the rest.
    fn check(&self) -> Result<Size, Error> {
        let image = self.image()?;
        let symbols = symbols::refused(&image);
        // What is ours must be clean; a peer, which has a feature to itself, is as it is.
        if !symbols.is_empty() && self.binary.feature.is_none() {
            return Err(Error::Symbols { core: self.core, symbols });
        }
        Ok(Size::of(&image))
    }
}

/// What the log says, each section for itself.
fn workloads(core: Core, firmware: &[u8], log: &[u8]) -> Result<Vec<Workload>, decode::Error> {
    let sections = decode::decode(firmware, log)?;
    sections.into_iter().map(|section| workload(core, section)).collect()
}

/// What a section of the log means on `core`.
fn workload(core: Core, section: Section) -> Result<Workload, decode::Error> {
    let count = "stack_bytes";
    let Some(&stack) = section.counts.get(count) else {
        return Err(decode::Error::Missing { section: section.name, count });
    };
    if section.samples.is_empty() {
        return Err(decode::Error::Incomplete);
    }
    Ok(Workload {
        stack,
        name: section.name,
        samples: section.samples,
        instructions_per_tick: core.hardware().instructions_per_tick(),
    })
}
