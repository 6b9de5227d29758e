//! The program `harvester-log`, which reads a firmware's log: built when there is a log to read.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::{env, fs};

use super::decode::Error;

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

/// Builds the program beside the firmware.
fn build() -> Result<PathBuf, String> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let all = env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    let target = workspace.join(all).join("on-target");
    let status = Command::new("cargo")
        .args(["build", "--quiet", "--package", "harvester-log", "--target-dir"])
        .arg(&target)
        .current_dir(&workspace)
        // The output of this command is a table.
        .stdout(Stdio::null())
        .status()
        .map_err(|error| format!("cargo: {error}"))?;
    if !status.success() {
        return Err("the package harvester-log does not build".to_owned());
    }
    Ok(target.join("debug").join("harvester-log").with_extension(env::consts::EXE_EXTENSION))
}
