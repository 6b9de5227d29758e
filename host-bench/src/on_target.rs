//! The firmware built for each core, run under QEMU, and what its log says.
//!
//! The counts are of *instructions*: QEMU runs with a virtual clock on which every instruction takes
//! a nanosecond, so they are the same on every run and every machine. They are not cycles: on a
//! Cortex-M4F a division takes 14 of those, a load up to 2 and a taken branch 2 to 4.

pub mod build;
pub mod core;
pub mod decode;
pub mod image;
pub mod qemu;
pub mod size;
pub mod symbols;
pub mod toolchain;

use self::core::Core;
use self::decode::{Sample, Section};
use self::size::Size;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
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
    /// Steps taken.
    pub steps: u64,
    /// Time simulated, in seconds.
    pub simulated: f64,
    /// Instructions executed between the samples.
    pub instructions: f64,
    /// Deepest stack in bytes, from the top of RAM.
    pub stack: u64,
    /// The states that it logged, as raw bits.
    pub samples: Vec<Sample>,
    /// Everything that it counted, by name: the figures above and any other.
    pub counts: BTreeMap<String, u64>,
}

impl Workload {
    /// Instructions for a step.
    #[must_use]
    pub fn instructions_per_step(&self) -> f64 {
        self.instructions / self.steps as f64
    }

    /// Instructions for a simulated second.
    #[must_use]
    pub fn instructions_per_second(&self) -> f64 {
        self.instructions / self.simulated
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

/// Builds the firmware for `core`, checks it, runs it for at most `time_limit`, and reads its log.
///
/// # Errors
///
/// When something is missing, fails, or contradicts what the figures are supposed to mean.
pub fn measure(core: Core, time_limit: Duration) -> Result<Measurement, Error> {
    let firmware = build::build(core)?;
    let bench = read(&firmware.bench)?;
    let empty = read(&firmware.empty)?;
    let bench_image = open(&bench, &firmware.bench, core)?;
    let empty_image = open(&empty, &firmware.empty, core)?;

    let symbols = symbols::refused(&bench_image);
    if !symbols.is_empty() {
        return Err(Error::Symbols { core, symbols });
    }
    let size = Size::of(&bench_image);
    let flash = size.flash.saturating_sub(Size::of(&empty_image).flash);

    let log = qemu::run(core, &firmware.bench, time_limit)?;
    let mut workloads = workloads(core, &bench, &log).map_err(|source| Error::Log { core, source })?;
    // The firmware calibrates before anything else.
    if workloads.first().is_none_or(|first| first.name != "calibration") {
        let source = decode::Error::Incomplete;
        return Err(Error::Log { core, source });
    }
    let calibration = workloads.remove(0).instructions_per_step();
    if !CALIBRATED.contains(&calibration) {
        return Err(Error::Calibration { core, instructions: calibration });
    }
    Ok(Measurement { core, calibration, flash, size, workloads })
}

fn read(path: &Path) -> Result<Vec<u8>, Error> {
    std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })
}

fn open<'file>(file: &'file [u8], path: &Path, core: Core) -> Result<image::Image<'file>, Error> {
    image::open(file, core).map_err(|source| Error::Image { path: path.into(), source })
}

/// What the log says, each section for itself.
fn workloads(core: Core, firmware: &[u8], log: &[u8]) -> Result<Vec<Workload>, decode::Error> {
    let sections = decode::decode(firmware, log)?;
    sections.into_iter().map(|section| workload(core, section)).collect()
}

/// What a section of the log means on `core`.
fn workload(core: Core, section: Section) -> Result<Workload, decode::Error> {
    let count = |name: &'static str| {
        section
            .counts
            .get(name)
            .copied()
            .ok_or_else(|| decode::Error::Missing { section: section.name.clone(), count: name })
    };
    Ok(Workload {
        steps: count("steps")?,
        simulated: count("simulated_us")? as f64 * 1e-6,
        instructions: count("ticks")? as f64 * core.hardware().instructions_per_tick(),
        stack: count("stack_bytes")?,
        name: section.name,
        samples: section.samples,
        counts: section.counts,
    })
}
