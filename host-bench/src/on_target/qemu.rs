//! Running firmware under QEMU.

use super::core::Core;
use std::io::{self, Read};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};
use thiserror::Error;

const QEMU: &str = "qemu-system-arm";

/// Why a run yields nothing.
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
