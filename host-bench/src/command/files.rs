//! Files that a command writes: checked before it computes, and written whole or not at all.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::method::Failure;
use crate::scene_file::{Override, files, shipped};

/// The folder of reports, in that of the caller.
pub(crate) fn report_folder() -> PathBuf {
    PathBuf::from("report")
}

/// Makes a folder and those above it, where they do not exist.
pub(crate) fn make_folder(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder)
        .map_err(|error| Failure::Input(format!("{}: cannot be made: {error}", folder.display())))
}

/// Writes files, none of which replaces a file that the command reads.
#[derive(Debug)]
pub(crate) struct Outputs {
    inputs: Vec<PathBuf>,
}

impl Outputs {
    /// Of a command that reads this scene.
    pub(crate) fn of(scene: &Path, overrides: &[Override]) -> Result<Self, Failure> {
        Ok(Self { inputs: files(scene, overrides)? })
    }

    /// Of a command that reads these files too.
    pub(crate) fn and(mut self, others: &[PathBuf]) -> Self {
        self.inputs.extend(others.iter().cloned());
        self
    }

    /// Of a command that reads these shipped scenes.
    pub(crate) fn of_shipped<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        Self { inputs: names.into_iter().map(shipped).collect() }
    }

    /// Refuses a file that could not be written or must not be replaced; `option` names it.
    pub(crate) fn check(&self, option: &str, file: &Path) -> Result<(), Failure> {
        let writable = self.target(file).and_then(|(target, _)| {
            try_beside(&target).map_err(|error| format!("cannot be written: {error}"))
        });
        writable.map_err(|reason| refusal(option, file, &reason))
    }

    /// As [`Outputs::check`], of a picture whose name must end in one of these.
    pub(crate) fn check_picture(&self, option: &str, file: &Path, endings: &[&str]) -> Result<(), Failure> {
        self.check(option, file)?;
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        if !ending.is_some_and(|ending| endings.contains(&ending.as_str())) {
            return Err(refusal(option, file, &format!("must end in .{}", endings.join(" or ."))));
        }
        Ok(())
    }

    /// Refuses a folder that could not be made, or in which one of these files could not be written.
    pub(crate) fn check_in(&self, option: &str, folder: &Path, names: &[&str]) -> Result<(), Failure> {
        if folder.is_dir() {
            return names.iter().try_for_each(|name| self.check(option, &folder.join(name)));
        }
        let refuse = |reason: &str| Err(refusal(option, folder, reason));
        if fs::symlink_metadata(folder).is_ok() {
            return refuse("must be a folder");
        }
        // The nearest that exists: there the folder is made.
        let Some(above) = folder.ancestors().skip(1).map(or_here).find(|above| above.exists()) else {
            return refuse("cannot be made");
        };
        if !above.is_dir() {
            return refuse(&format!("cannot be made: {} must be a folder", above.display()));
        }
        try_beside(&above.join("folder")).or_else(|error| refuse(&format!("cannot be made: {error}")))
    }

    /// Writes a file whole or not at all: to a temporary file beside it, which is then renamed.
    pub(crate) fn write(&self, file: &Path, text: &str) -> Result<(), Failure> {
        self.write_bytes(file, text.as_bytes())
    }

    /// As [`Outputs::write`], of bytes.
    pub(crate) fn write_bytes(&self, file: &Path, bytes: &[u8]) -> Result<(), Failure> {
        let refuse = |reason: String| Failure::Input(format!("{}: {reason}", file.display()));
        let (target, replaced) = self.target(file).map_err(refuse)?;
        let part = part_of(&target);
        let written = write_new(&part, bytes, replaced.as_ref()).and_then(|()| fs::rename(&part, &target));
        written.map_err(|error| {
            // Removes the temporary file, if it was made.
            let _ = fs::remove_file(&part);
            refuse(format!("cannot be written: {error}"))
        })
    }

    /// The file that a path leads to, through links, and what is there now; refuses what must not be replaced.
    fn target(&self, file: &Path) -> Result<(PathBuf, Option<Metadata>), String> {
        if file.file_name().is_none() {
            return Err("is a folder, must be a file".to_owned());
        }
        match fs::symlink_metadata(file) {
            Ok(_) => {}
            Err(_) if !folder_of(file).is_dir() => {
                return Err(format!("{} must be a folder", folder_of(file).display()));
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok((file.to_owned(), None)),
            Err(error) => return Err(format!("cannot be written: {error}")),
        }
        let target =
            fs::canonicalize(file).map_err(|error| format!("is a link that leads nowhere: {error}"))?;
        let found = fs::metadata(&target).map_err(|error| format!("cannot be written: {error}"))?;
        if found.is_dir() {
            return Err("is a folder, must be a file".to_owned());
        }
        if !found.is_file() {
            return Err("is a device, a pipe or a socket, must be a file".to_owned());
        }
        if let Some(input) =
            self.inputs.iter().find(|input| same_file::is_same_file(input, &target).unwrap_or(false))
        {
            return Err(format!("must not be {}, which this command reads", input.display()));
        }
        // A superuser can open a file that nobody may write.
        if found.permissions().readonly() || OpenOptions::new().write(true).open(&target).is_err() {
            return Err("is read-only, must be writable".to_owned());
        }
        Ok((target, Some(found)))
    }
}

fn refusal(option: &str, path: &Path, reason: &str) -> Failure {
    let space = if option.is_empty() { "" } else { " " };
    Failure::Input(format!("{option}{space}{}: {reason}", path.display()))
}

/// Makes and removes the temporary file beside a file.
fn try_beside(file: &Path) -> io::Result<()> {
    let part = part_of(file);
    // It is closed before it is removed.
    drop(File::create_new(&part)?);
    fs::remove_file(&part)
}

/// Writes a new file with the permissions of the one that it replaces.
fn write_new(part: &Path, bytes: &[u8], replaced: Option<&Metadata>) -> io::Result<()> {
    let mut file = File::create_new(part)?;
    file.write_all(bytes)?;
    replaced.map_or(Ok(()), |replaced| file.set_permissions(replaced.permissions()))
}

/// The temporary file beside a file.
fn part_of(file: &Path) -> PathBuf {
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    folder_of(file).join(name)
}

fn folder_of(file: &Path) -> &Path {
    or_here(file.parent().unwrap_or(Path::new("")))
}

/// A folder, the current one for an empty path.
fn or_here(folder: &Path) -> &Path {
    if folder == Path::new("") { Path::new(".") } else { folder }
}
