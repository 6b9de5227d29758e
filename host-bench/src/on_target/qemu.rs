//! Running firmware under QEMU.

use std::io::{self, Read};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use std::{fmt, thread};

use clap::ValueEnum;
use thiserror::Error;

const QEMU: &str = "qemu-system-arm";

/// Why a run gives no power.
#[derive(Debug, Error)]
pub enum Error {
    /// There is no QEMU.
    #[error(
        "no {QEMU}: install QEMU's Arm system emulator (Debian and Ubuntu: `apt-get install qemu-system-arm`)"
    )]
    Missing,
    /// The system did not let it run.
    #[error("{QEMU}: {0}")]
    Io(#[from] io::Error),
    /// The firmware did not come to an end.
    #[error("{core}: the firmware did not end within {} s", limit.as_secs())]
    TimeOut {
        /// The core.
        core: Core,
        /// How long it had.
        limit: Duration,
    },
    /// The firmware, or QEMU, ended with an error.
    #[error("{core}: {}", reason(*status))]
    Failed {
        /// The core.
        core: Core,
        /// The code that it ended with.
        status: ExitStatus,
    },
}

/// Whether there is a QEMU: better known before minutes of building.
///
/// # Errors
///
/// When there is none.
pub fn find() -> Result<(), Error> {
    let found = Command::new(QEMU).arg("--version").stdout(Stdio::null()).status();
    found.map(|_| ()).map_err(missing)
}

/// Runs `firmware` on the board with `core` until it ends, and returns what it logged.
///
/// # Errors
///
/// When QEMU does not start, the firmware fails, or it is not done in `limit`.
pub fn run(core: Core, firmware: &Path, limit: Duration) -> Result<Vec<u8>, Error> {
    let mut qemu = Command::new(QEMU)
        .args(["-machine", core.hardware().board])
        .args(["-display", "none", "-serial", "none", "-monitor", "none"])
        // The log, and nothing else, on the standard output.
        .args(["-chardev", "stdio,id=log"])
        .args(["-semihosting-config", "enable=on,target=native,chardev=log"])
        // A nanosecond of virtual time for each instruction.
        .args(["-icount", "shift=0"])
        .arg("-kernel")
        .arg(firmware)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(missing)?;

    // On a thread of its own: a pipe that nobody empties would stop the firmware.
    let reader = qemu.stdout.take().map(|mut pipe| {
        thread::spawn(move || {
            let mut log = Vec::new();
            pipe.read_to_end(&mut log).map(|_| log)
        })
    });
    let deadline = Instant::now() + limit;
    let status = loop {
        if let Some(status) = qemu.try_wait()? {
            break status;
        }
        if Instant::now() > deadline {
            qemu.kill()?;
            qemu.wait()?;
            return Err(Error::TimeOut { core, limit });
        }
        thread::sleep(Duration::from_millis(10));
    };
    if !status.success() {
        return Err(Error::Failed { core, status });
    }
    match reader.map(thread::JoinHandle::join) {
        Some(Ok(log)) => Ok(log?),
        _ => Err(io::Error::other("its output was lost").into()),
    }
}

fn missing(error: io::Error) -> Error {
    match error.kind() {
        io::ErrorKind::NotFound => Error::Missing,
        _ => Error::Io(error),
    }
}

/// The codes that the firmware ends with, in words.
fn reason(status: ExitStatus) -> String {
    match status.code() {
        Some(10) => "the workload reported an error".to_owned(),
        Some(11) => "the firmware panicked".to_owned(),
        Some(12) => "the firmware ran into a fault".to_owned(),
        Some(13) => "the firmware logged while it was logging".to_owned(),
        _ => format!("{QEMU} ended with {status}"),
    }
}

/// A core that the firmware is built for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Core {
    /// Cortex-M0: no division, no floating point.
    M0,
    /// Cortex-M3: no floating point.
    M3,
    /// Cortex-M4 with single-precision floating point.
    M4f,
    /// Cortex-M7, with its single-precision instructions only.
    M7,
    /// Cortex-M33 with single-precision floating point.
    M33,
}

/// What building and running for a core takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hardware {
    /// The compiler's name for the core.
    pub target: &'static str,
    /// The board's name, in the firmware's build script and in QEMU alike.
    pub board: &'static str,
    /// Where its flash starts: the vector table is there.
    pub flash_origin: u64,
    /// Where its RAM ends, as far as the firmware uses it: the stack starts there.
    pub stack_top: u32,
    /// The frequency with which QEMU drives its SysTick.
    pub tick_hz: u32,
}

impl Hardware {
    /// With a nanosecond of virtual time for each instruction.
    pub fn instructions_per_tick(&self) -> f64 {
        1e9 / f64::from(self.tick_hz)
    }
}

impl Core {
    /// The board with this core.
    ///
    /// The addresses stand in the firmware's build script as well. Here they are what is checked:
    /// a link with another board's memory map would run on some of them all the same.
    pub const fn hardware(self) -> Hardware {
        let (target, board, flash_origin, stack_top, tick_hz) = match self {
            Self::M0 => ("thumbv6m-none-eabi", "microbit", 0, 0x2000_4000, 16_000_000),
            Self::M3 => ("thumbv7m-none-eabi", "stm32vldiscovery", 0x0800_0000, 0x2000_2000, 24_000_000),
            Self::M4f => ("thumbv7em-none-eabihf", "netduinoplus2", 0x0800_0000, 0x2002_0000, 168_000_000),
            Self::M7 => ("thumbv7em-none-eabihf", "mps2-an500", 0, 0x2002_0000, 25_000_000),
            Self::M33 => ("thumbv8m.main-none-eabihf", "mps2-an505", 0x1000_0000, 0x3802_0000, 20_000_000),
        };
        Hardware { target, board, flash_origin, stack_top, tick_hz }
    }
}

impl fmt::Display for Core {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::M0 => "Cortex-M0",
            Self::M3 => "Cortex-M3",
            Self::M4f => "Cortex-M4F",
            Self::M7 => "Cortex-M7",
            Self::M33 => "Cortex-M33",
        })
    }
}
