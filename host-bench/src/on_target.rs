//! Builds the firmware for each core, runs it under QEMU and reads its log.
//!
//! The counts are *instructions*: on the virtual clock of QEMU every instruction takes a nanosecond, so that the counts are the same on
//! every machine. Instructions are not cycles: on a Cortex-M4F a division takes 14 cycles, a load up to 2 and a taken branch 2 to 4.

pub mod build;
pub mod day;
pub mod decode;
pub mod image;
pub mod native;
pub mod node;
pub mod qemu;

use self::build::Binary;
use self::decode::{Sample, Section};
use firmware_example::workload::{Variant, named};
use image::Size;
use qemu::Core;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::Duration;
use thiserror::Error;

/// What one core measured of one variant.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Bytes of flash that the workloads add to a firmware without them.
    pub flash: u64,
    /// Size of the whole firmware.
    pub size: Size,
    /// The workloads, in the order in which they ran.
    pub workloads: Vec<Workload>,
}

/// The cost of one workload on one core, and its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Workload {
    /// Its name in the firmware.
    pub name: String,
    /// Deepest stack in bytes, from the top of RAM.
    pub stack: u64,
    /// The samples that it logged; at least one.
    pub samples: Vec<Sample>,
    /// Instructions in a tick of the board's counter.
    pub(crate) instructions_per_tick: f64,
}

/// The cost of a workload between two samples.
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
    pub fn whole(&self) -> Stretch {
        self.after(0)
    }

    /// From the sample at a simulated time in microseconds, or from the start at 0, to the last sample.
    pub fn after(&self, simulated_us: u64) -> Stretch {
        // A computation without simulated time has its sample at 0.
        let start =
            self.samples.iter().find(|sample| simulated_us > 0 && sample.simulated_us == simulated_us);
        let counts = |sample: &Sample| [sample.simulated_us, sample.steps, sample.ticks];
        let start = start.map_or([0; 3], counts);
        let end = self.samples.last().map_or([0; 3], counts);
        Stretch {
            seconds: (end[0] - start[0]) as f64 * 1e-6,
            steps: end[1] - start[1],
            instructions: (end[2] - start[2]) as f64 * self.instructions_per_tick,
        }
    }
}

impl Stretch {
    /// Instructions for a step.
    pub fn instructions_per_step(&self) -> f64 {
        self.instructions / self.steps as f64
    }

    /// Instructions for a simulated second.
    pub fn instructions_per_second(&self) -> f64 {
        self.instructions / self.seconds
    }
}

/// Why there is no measurement.
#[derive(Debug, Error)]
pub enum Error {
    /// There is nothing to compile with, or the firmware does not build.
    #[error(transparent)]
    Build(#[from] build::Error),
    /// QEMU is missing, or the run went wrong.
    #[error(transparent)]
    Qemu(#[from] qemu::Error),
    /// A firmware file could not be read, or is not for the core.
    #[error("{}: {what}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The firmware contains what it must not, or its log is not the expected one.
    #[error("{core}: {what}")]
    Core {
        /// The core.
        core: Core,
        /// What is wrong.
        what: String,
    },
    /// The reference or the host's own run failed.
    #[error("on the host: {0}")]
    Host(String),
}

impl Error {
    fn on(core: Core, what: impl ToString) -> Self {
        Self::Core { core, what: what.to_string() }
    }
}

/// The counts of one instruction that pass the calibration: the slowest SysTick resolves 63 of a million.
const CALIBRATED: RangeInclusive<f64> = 0.999..=1.001;

/// The variant with the workloads of a peer, which a Cargo feature of the firmware links.
const PEER: Variant = named("peer::smooth");
/// The variant with a module that `needs` emitted.
const EMITTED: Variant = named("emitted::bench");

/// A core on which variants are measured.
#[derive(Debug, Clone, Copy)]
pub struct Bench {
    core: Core,
    time_limit: Duration,
    /// Flash of the firmware without a workload, in bytes.
    empty_flash: u64,
}

impl Bench {
    /// The bench on `core`, with runs of at most `time_limit`.
    ///
    /// # Errors
    ///
    /// If the firmware without a workload does not build.
    pub fn new(core: Core, time_limit: Duration) -> Result<Self, Error> {
        let empty = Firmware::build(core, Binary::new("empty"))?;
        Ok(Self { core, time_limit, empty_flash: Size::of(&empty.image()?).flash })
    }

    /// The core.
    pub fn core(&self) -> Core {
        self.core
    }

    /// Builds the bench with `variant`, checks it, runs it, reads its log, and compares its bits with the host's.
    ///
    /// # Errors
    ///
    /// If the firmware does not build, contains what it must not, fails, or computes other bits than the host.
    pub fn measure(&self, variant: &Variant) -> Result<Measurement, Error> {
        let core = self.core;
        let name = variant.name;
        let feature = (name == PEER.name).then_some("peer");
        let measured = self.run(Binary { name: "bench", variant: Some(name), feature, scene: None })?;
        let compared = native::compare(core, &measured.workloads, variant)?;
        if compared != measured.workloads.len() && feature.is_none() {
            let what = format!("{name}: {} workloads, on the host {compared}", measured.workloads.len());
            return Err(Error::on(core, what));
        }
        Ok(measured)
    }

    /// As [`Bench::measure`], of a module that `needs` emitted; its bits are the caller's to compare.
    ///
    /// # Errors
    ///
    /// If the firmware does not build, contains what it must not, or fails.
    pub fn measure_emitted(&self, scene: &Path) -> Result<Measurement, Error> {
        self.run(Binary { name: "bench", variant: Some(EMITTED.name), feature: None, scene: Some(scene) })
    }

    /// Builds a binary of the bench, checks it, runs it and reads its log.
    fn run(&self, binary: Binary<'_>) -> Result<Measurement, Error> {
        let core = self.core;
        let firmware = Firmware::build(core, binary)?;
        let size = firmware.check()?;
        let log = qemu::run(core, &firmware.path, self.time_limit)?;
        let mut workloads = workloads(core, &firmware.path, &log).map_err(|error| Error::on(core, error))?;
        // The firmware logs the calibration first.
        if workloads.first().is_none_or(|first| first.name != "calibration") {
            return Err(Error::on(core, decode::Error::Incomplete));
        }
        let instructions = workloads.remove(0).whole().instructions_per_step();
        if !CALIBRATED.contains(&instructions) {
            let what = format!(
                "an instruction counts as {instructions:.4}; the board's clock is not what it should be"
            );
            return Err(Error::on(core, what));
        }
        Ok(Measurement { flash: size.flash.saturating_sub(self.empty_flash), size, workloads })
    }
}

/// A binary that has been built.
struct Firmware<'a> {
    core: Core,
    binary: Binary<'a>,
    path: PathBuf,
    bytes: Vec<u8>,
}

impl<'a> Firmware<'a> {
    fn build(core: Core, binary: Binary<'a>) -> Result<Self, Error> {
        let path = build::build(core, binary)?;
        let bytes = std::fs::read(&path)
            .map_err(|error| Error::File { path: path.clone(), what: error.to_string() })?;
        Ok(Self { core, binary, path, bytes })
    }

    fn image(&self) -> Result<image::Image<'_>, Error> {
        image::open(&self.bytes, self.core)
            .map_err(|error| Error::File { path: self.path.clone(), what: error.to_string() })
    }

    /// Refuses code that must not be there, and gives the size.
    fn check(&self) -> Result<Size, Error> {
        let image = self.image()?;
        let symbols = image::refused(&image);
        // Only a peer, which needs a feature, may link panics and double arithmetic.
        if !symbols.is_empty() && self.binary.feature.is_none() {
            let what = format!(
                "the firmware links code that can panic, or double arithmetic: {}",
                symbols.join(", ")
            );
            return Err(Error::on(self.core, what));
        }
        Ok(Size::of(&image))
    }
}

fn workloads(core: Core, firmware: &Path, log: &[u8]) -> Result<Vec<Workload>, decode::Error> {
    let sections = decode::decode(firmware, log)?;
    sections.into_iter().map(|section| workload(core, section)).collect()
}

/// A section of the log as a workload on `core`.
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
