//! Turns the defmt log of a firmware into lines of text: `harvester-log FIRMWARE.elf LOG`.
//!
//! The decoder brings forty crates, which only `host-bench on-target` needs: it builds this program when it has a log to read.
//! Each frame is one line of standard output. Exit code 3 is a damaged frame, after the good ones; 2 everything else.

use std::ffi::OsStr;
use std::io::{self, Write};
use std::process::ExitCode;
use std::{env, fs};

use defmt_decoder::{DecodeError, Table};

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(3),
        Err(reason) => {
            // Without a standard error nothing can be printed.
            let _ = writeln!(io::stderr(), "{reason}");
            ExitCode::from(2)
        }
    }
}

/// Prints the frames; whether all of them are good.
fn run() -> Result<bool, String> {
    let arguments: Vec<_> = env::args_os().skip(1).collect();
    let [firmware, log] = &arguments[..] else {
        return Err("usage: harvester-log FIRMWARE.elf LOG".to_owned());
    };
    let (firmware, log) = (read(firmware)?, read(log)?);
    let table =
        Table::parse(&firmware).map_err(|error| format!("no defmt strings in the firmware: {error}"))?;
    let table = table.ok_or("no defmt strings in the firmware: no .defmt section")?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(&log);
    let mut output = io::BufWriter::new(io::stdout().lock());
    let is_good = loop {
        match decoder.decode() {
            Ok(frame) => {
                let line = frame.display_message().to_string();
                if line.contains('\n') {
                    return Err(format!("a message of two lines: {line:?}"));
                }
                writeln!(output, "{line}").map_err(|error| error.to_string())?;
            }
            Err(DecodeError::UnexpectedEof) => break true,
            Err(DecodeError::Malformed) => break false,
        }
    };
    output.flush().map_err(|error| error.to_string())?;
    Ok(is_good)
}

fn read(file: &OsStr) -> Result<Vec<u8>, String> {
    fs::read(file).map_err(|error| format!("{}: {error}", file.display()))
}
