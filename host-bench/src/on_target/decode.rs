//! The firmware's log, read back.
//!
//! The frames are defmt's; its own decoder turns them into text ([`messages`]), with the strings that only
//! the firmware's ELF file has. The text is a record of `firmware-example/src/measure.rs`:
//!
//! ```text
//! begin NAME
//! sample MICROSECONDS STEPS TICKS [WORD, …]
//! count NAME VALUE
//! end NAME
//! ```
//!
//! The reader is strict. A log with a flaw in it is refused as a whole, because the figures are worth
//! nothing if a part of them is missing.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::{env, fs};

use thiserror::Error;

use super::build::cargo;

/// All that is logged from one `begin` to its `end`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Section {
    /// The workload's name.
    pub name: String,
    /// Its states.
    pub samples: Vec<Sample>,
    /// What it counted.
    pub counts: BTreeMap<String, u64>,
}

/// The state at one moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sample {
    /// Simulated time in microseconds.
    pub simulated_us: u64,
    /// Steps taken so far.
    pub steps: u64,
    /// Ticks of the board's counter spent so far.
    pub ticks: u64,
    /// Each number of the state as its bits.
    pub bits: Vec<u32>,
}

/// What is wrong with a log.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum Error {
    /// The decoder cannot be built or run, or the ELF file has nothing to decode the log with.
    #[error("the log cannot be decoded: {0}")]
    Decoder(String),
    /// Bytes that are not a frame.
    #[error("a frame of the log is damaged, after {0} good ones")]
    Frame(usize),
    /// Text that is not a record, or not one that may stand there.
    #[error("not a record of the log: {0:?}")]
    Record(String),
    /// It stops before its end.
    #[error("the log is not complete")]
    Incomplete,
    /// A figure that every workload has is not there.
    #[error("the log of {section} has no count of {count}")]
    Missing {
        /// The workload.
        section: String,
        /// The figure.
        count: &'static str,
    },
}

/// Reads `log`, the bytes that the firmware in the ELF file `firmware` sent while it measured.
///
/// # Errors
///
/// At the first flaw.
pub fn decode(firmware: &Path, log: &[u8]) -> Result<Vec<Section>, Error> {
    sections(&messages(firmware, log)?)
}

/// Compares the messages of a log with those of the host. A number in either is written with as many digits as distinguish it from
/// its neighbours.
///
/// # Errors
///
/// At the first difference.
pub fn same(found: &[String], expected: &[String]) -> Result<(), String> {
    for line in 0..found.len().max(expected.len()) {
        let (found, expected) = (found.get(line), expected.get(line));
        if found != expected {
            return Err(format!("node: logs {found:?}, on the host {expected:?}"));
        }
    }
    Ok(())
}

fn sections(records: &[String]) -> Result<Vec<Section>, Error> {
    let mut done = Vec::new();
    let mut open: Option<Section> = None;
    for record in records {
        let misfit = || Error::Record(record.clone());
        let (kind, rest) = record.split_once(' ').ok_or_else(misfit)?;
        open = match (kind, open) {
            ("begin", None) => {
                Some(Section { name: rest.to_owned(), samples: Vec::new(), counts: BTreeMap::new() })
            }
            ("sample", Some(mut section)) => {
                section.samples.push(sample(rest).ok_or_else(misfit)?);
                Some(section)
            }
            ("count", Some(mut section)) => {
                let (name, value) = rest.split_once(' ').ok_or_else(misfit)?;
                let value = value.parse().map_err(|_| misfit())?;
                section.counts.insert(name.to_owned(), value);
                Some(section)
            }
            ("end", Some(section)) if section.name == rest => {
                done.push(section);
                None
            }
            _ => return Err(misfit()),
        };
    }
    match open {
        None => Ok(done),
        Some(_) => Err(Error::Incomplete),
    }
}

/// `250000 200 23000 [3f3a6b27, c05cca90]`
fn sample(text: &str) -> Option<Sample> {
    let (numbers, words) = text.split_once(" [")?;
    let mut numbers = numbers.split(' ').map(|number| number.parse::<u64>().ok());
    let mut number = || numbers.next().flatten();
    let bits = words.strip_suffix(']')?.split(", ").map(|word| u32::from_str_radix(word, 16));
    let (simulated_us, steps, ticks) = (number()?, number()?, number()?);
    Some(Sample { simulated_us, steps, ticks, bits: bits.collect::<Result<_, _>>().ok()? })
}

/// The messages of a log, one for each frame; `firmware` is the ELF file that sent it.
///
/// # Errors
///
/// If the decoder cannot be built, a frame is damaged, or the firmware does not have the strings.
pub fn messages(firmware: &Path, log: &[u8]) -> Result<Vec<String>, Error> {
    static DECODER: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let decoder = DECODER.get_or_init(build).clone().map_err(Error::Decoder)?;
    let failed = |error: std::io::Error| Error::Decoder(error.to_string());
    let mut file = firmware.as_os_str().to_owned();
    file.push(".log");
    fs::write(&file, log).map_err(failed)?;
    let output = Command::new(decoder).arg(firmware).arg(&file).output().map_err(failed)?;
    let text = String::from_utf8(output.stdout).map_err(|error| Error::Decoder(error.to_string()))?;
    let messages: Vec<String> = text.lines().map(str::to_owned).collect();
    match output.status.code() {
        Some(0) => Ok(messages),
        Some(3) => Err(Error::Frame(messages.len())),
        _ => Err(Error::Decoder(String::from_utf8_lossy(&output.stderr).trim_end().to_owned())),
    }
}

fn build() -> Result<PathBuf, String> {
    let target = cargo(&["build", "--quiet", "--package", "harvester-log"], "on-target")?;
    Ok(target.join("debug").join("harvester-log").with_extension(env::consts::EXE_EXTENSION))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(log: &str) -> Result<Vec<Section>, Error> {
        sections(&log.lines().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn a_complete_log_is_read_to_the_last_bit() {
        let log = "begin a\nsample 250000 200 4294967296 [3f3a6b27, c05cca90]\ncount stack_bytes 4294967296\nend a\nbegin b\nend b";
        let sections = read(log).expect("it is complete");
        assert_eq!(sections.len(), 2);
        assert_eq!(sections[0].samples[0].simulated_us, 250_000);
        assert_eq!((sections[0].samples[0].steps, sections[0].samples[0].ticks), (200, 1 << 32));
        assert_eq!(sections[0].samples[0].bits, [0x3f3a_6b27, 0xc05c_ca90]);
        assert_eq!(sections[0].counts["stack_bytes"], 1 << 32);
    }

    #[test]
    fn a_log_that_stops_early_is_refused() {
        assert_eq!(read("begin a\ncount steps 1"), Err(Error::Incomplete));
    }

    #[test]
    fn a_record_out_of_place_or_of_no_known_form_is_refused() {
        for log in [
            "count steps 1",
            "begin a\nbegin b",
            "begin a\nend b",
            "begin a\nsample 1 1 1 [xyz]",
            "begin a\nsample 1 1 [3f3a6b27]",
            "begin a\nsample 1 1 1 3f3a6b27",
            "begin a\ncount steps -1",
            "begin a\nnoise",
        ] {
            assert!(matches!(read(log), Err(Error::Record(_))), "{log}");
        }
    }
}
