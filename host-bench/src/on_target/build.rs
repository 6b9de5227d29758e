//! Building the firmware.

use super::core::Core;
use super::toolchain::{self, Toolchain};
use crate::command::is_quiet;
use std::path::{Path, PathBuf};
use std::{env, fs, io};
use thiserror::Error;

/// A binary of the firmware.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binary<'a> {
    /// Its name.
    pub name: &'static str,
    /// What `bench` is to measure: the name of a variant.
    pub variant: Option<&'static str>,
    /// The Cargo feature that the binary needs.
    pub feature: Option<&'static str>,
    /// The scene of the variant `emitted::bench`, if it is not the shipped one.
    pub scene: Option<&'a Path>,
}

impl Binary<'_> {
    /// A binary without variants and features.
    #[must_use]
    pub const fn new(name: &'static str) -> Self {
        Self { name, variant: None, feature: None, scene: None }
    }

    /// The Cargo profile that it is built in.
    #[must_use]
    fn profile(&self) -> &'static str {
        match self.name {
            "node" | "node_bare" | "node_stack" => "node",
            _ => "firmware",
        }
    }
}

/// Why there is no firmware.
#[derive(Debug, Error)]
pub enum Error {
    /// There is nothing to compile with.
    #[error(transparent)]
    Toolchain(#[from] toolchain::Error),
    /// Cargo said why on the terminal.
    #[error("the firmware for {0} does not build")]
    Cargo(Core),
    /// Cargo could not be started, or a file not be kept.
    #[error("building the firmware for {core}: {source}")]
    Io {
        /// The core.
        core: Core,
        /// The system's reason.
        source: io::Error,
    },
}

/// Builds `binary` for `core` in a Cargo run of its own, so that the features of host crates do not reach it.
///
/// # Errors
///
/// When there is no compiler for it, or it does not compile.
pub fn build(core: Core, binary: Binary<'_>) -> Result<PathBuf, Error> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let hardware = core.hardware();
    let toolchain = Toolchain::find(hardware.target)?;
    let io_error = |source| Error::Io { core, source };

    let all = env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    let target_directory = workspace.join(all).join("on-target");
    let status = toolchain
        .cargo("build", hardware.target)
        .args(is_quiet().then_some("--quiet"))
        .args(["--profile", binary.profile(), "--package", "firmware-example", "--bin", binary.name])
        .args(binary.feature.into_iter().flat_map(|feature| ["--features", feature]))
        .arg("--target-dir")
        .arg(&target_directory)
        .env("HARVESTER_BOARD", hardware.board)
        .envs(binary.variant.map(|variant| ("HARVESTER_VARIANT", variant)))
        .envs(binary.scene.map(|scene| ("HARVESTER_SCENE", scene)))
        .current_dir(&workspace)
        .status()
        .map_err(io_error)?;
    if !status.success() {
        return Err(Error::Cargo(core));
    }

    // A copy for each board and variant, because the next build overwrites this one. A target directory for each
    // would compile `core` and the dependencies again.
    let built = target_directory.join(hardware.target).join(binary.profile()).join(binary.name);
    let kept = target_directory.join(hardware.board);
    fs::create_dir_all(&kept).map_err(io_error)?;
    let to = kept.join(binary.variant.unwrap_or(binary.name).replace("::", "-"));
    fs::copy(built, &to).map(|_| to).map_err(io_error)
}
