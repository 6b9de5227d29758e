//! Building the firmware.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs, io};

use thiserror::Error;

use super::qemu::Core;
use crate::command::is_quiet;

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
    pub const fn new(name: &'static str) -> Self {
        Self { name, variant: None, feature: None, scene: None }
    }

    /// The Cargo profile that it is built in.
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
    Toolchain(#[from] NoCompiler),
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

/// The source tree that this program was built in. A program that is installed has none.
pub(crate) fn workspace() -> Result<PathBuf, String> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let is_there = workspace.join("firmware-example/Cargo.toml").is_file();
    let reason = "builds firmware or an FMU, must be run in the source tree of the project: cargo run --release -- COMMAND";
    is_there.then_some(workspace).ok_or_else(|| reason.to_owned())
}

/// Runs cargo in this workspace for this computer. Returns the target folder, which is `folder` in the usual one.
pub(crate) fn cargo(arguments: &[&str], folder: &str) -> Result<PathBuf, String> {
    let workspace = workspace()?;
    let all = env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    let target = workspace.join(all).join(folder);
    let mut cargo = Command::new("cargo");
    // The output of the caller may be a table.
    let cargo = cargo.args(arguments).arg("--target-dir").arg(&target).stdout(Stdio::null());
    match cargo.current_dir(&workspace).status() {
        Ok(status) if status.success() => Ok(target),
        Ok(status) => Err(format!("cargo {}: {status}", arguments.join(" "))),
        Err(error) => Err(format!("cargo: {error}")),
    }
}

/// Builds `binary` for `core` in a Cargo run of its own, so that the features of host crates do not reach it.
///
/// # Errors
///
/// When there is no compiler for it, or it does not compile.
pub fn build(core: Core, binary: Binary<'_>) -> Result<PathBuf, Error> {
    let io_error = |source| Error::Io { core, source };
    let workspace = workspace().map_err(|reason| io_error(io::Error::other(reason)))?;
    let hardware = core.hardware();
    let toolchain = Toolchain::find(hardware.target)?;

    let all = env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    // A directory for each thread that builds: one build does not wait for the lock of another, and a directory for each board
    // would compile the dependencies five times.
    let directory = workspace.join(all).join("on-target");
    let target_directory = directory.join(rayon::current_thread_index().unwrap_or(0).to_string());
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

    // A copy for each board and variant, because the next build overwrites this one.
    let built = target_directory.join(hardware.target).join(binary.profile()).join(binary.name);
    let copy = directory.join(hardware.board);
    fs::create_dir_all(&copy).map_err(io_error)?;
    let to = copy.join(binary.variant.unwrap_or(binary.name).replace("::", "-"));
    fs::copy(built, &to).map(|_| to).map_err(io_error)
}

// Finding a compiler for a microcontroller.
//
// The way for everybody is `rustup target add`. Where rustup cannot fetch a target, Debian has a
// compiler with the source of a matching `core`, and Cargo builds that along with the firmware.

/// Debian's compiler. By its full name, because rustup's stand-ins usually come first in the path.
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_CARGO: &str = "/usr/bin/cargo";

/// A compiler that has `core` for a target, or the source of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Toolchain {
    /// The usual one: it has the target.
    Usual,
    /// Debian's, with `core` to be built from source.
    Debian {
        /// What to link with.
        linker: PathBuf,
    },
}

/// There is no compiler for a target.
#[derive(Debug, Error)]
#[error(
    "no compiler for {target}: run `rustup target add {target}`, or on Debian \
     `apt-get install --no-install-recommends rustc-web cargo-web rust-web-src lld`"
)]
pub struct NoCompiler {
    target: &'static str,
}

impl Toolchain {
    /// Whichever there is for `target`, the usual one first.
    ///
    /// # Errors
    ///
    /// When there is none.
    pub fn find(target: &'static str) -> Result<Self, NoCompiler> {
        let libraries = ask("rustc", &["--print", "target-libdir", "--target", target]);
        if libraries.is_some_and(|directory| directory.is_dir()) {
            return Ok(Self::Usual);
        }
        let source = ask(DEBIAN_RUSTC, &["--print", "sysroot"])
            .map(|root| root.join("lib/rustlib/src/rust/library/core"));
        if source.is_some_and(|directory| directory.is_dir()) && Path::new(DEBIAN_CARGO).exists() {
            return Ok(Self::Debian { linker: linker() });
        }
        Err(NoCompiler { target })
    }

    /// `cargo COMMAND`, set up to compile for `target`.
    pub fn cargo(&self, command: &str, target: &str) -> Command {
        let mut cargo = match self {
            Self::Usual => Command::new("cargo"),
            Self::Debian { linker } => {
                let mut cargo = Command::new(DEBIAN_CARGO);
                let variable = target.to_uppercase().replace(['-', '.'], "_");
                cargo
                    .env("RUSTC", DEBIAN_RUSTC)
                    // Building `core` is not stable; the compiler it belongs to is let do it.
                    .env("RUSTC_BOOTSTRAP", "1")
                    .env("CARGO_UNSTABLE_BUILD_STD", "core")
                    .env(format!("CARGO_TARGET_{variable}_LINKER"), linker)
                    // `cargo run` points this at the libraries of the other compiler.
                    .env_remove("LD_LIBRARY_PATH");
                cargo
            }
        };
        cargo.args([command, "--target", target]);
        cargo
    }
}

/// The linker that comes with the usual compiler, which would link in the usual case too. The one
/// that Debian 12 calls `lld` keeps the panic of `defmt` in a firmware that never calls it.
fn linker() -> PathBuf {
    ask("rustc", &["--print", "target-libdir"])
        .map(|libraries| libraries.with_file_name("bin/gcc-ld/ld.lld"))
        .filter(|linker| linker.exists())
        .unwrap_or_else(|| "ld.lld".into())
}

/// The path that a compiler prints when asked; `None` if it is not there or does not know.
fn ask(compiler: &str, arguments: &[&str]) -> Option<PathBuf> {
    let output = Command::new(compiler).args(arguments).output().ok()?;
    let answer = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| answer.trim_end().into())
}
