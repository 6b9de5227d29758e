//! Finding a compiler for a microcontroller.
//!
//! The way for everybody is `rustup target add`. Where rustup cannot fetch a target, Debian has a
//! compiler with the source of a matching `core`, and Cargo builds that along with the firmware.

use std::path::{Path, PathBuf};
use std::process::Command;
use thiserror::Error;

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
pub struct Error {
    target: &'static str,
}

impl Toolchain {
    /// Whichever there is for `target`, the usual one first.
    ///
    /// # Errors
    ///
    /// When there is none.
    pub fn find(target: &'static str) -> Result<Self, Error> {
        let libraries = ask("rustc", &["--print", "target-libdir", "--target", target]);
        if libraries.is_some_and(|directory| directory.is_dir()) {
            return Ok(Self::Usual);
        }
        let source = ask(DEBIAN_RUSTC, &["--print", "sysroot"])
            .map(|root| root.join("lib/rustlib/src/rust/library/core"));
        if source.is_some_and(|directory| directory.is_dir()) && Path::new(DEBIAN_CARGO).exists() {
            return Ok(Self::Debian { linker: linker() });
        }
        Err(Error { target })
    }

    /// `cargo COMMAND`, set up to compile for `target`.
    #[must_use]
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
