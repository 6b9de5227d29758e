//! Files that a command writes: checked and locked before it computes, and written whole or not at all.

use std::cell::RefCell;
use std::fs::{self, File, Metadata, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use super::{is_called, note};
use crate::input::STANDARD;
use crate::method::Failure;
use crate::name::Name;
use crate::report::file::{ENDINGS, OF_IMAGES};
use crate::scene_file::{Override, files, shipped};

/// The folder of reports, in that of the caller.
pub(crate) fn report_folder() -> PathBuf {
    PathBuf::from("report")
}

/// Makes a folder and those above it, where they do not exist.
pub(crate) fn make_folder(folder: &Path) -> Result<(), Failure> {
    if folder == Path::new(STANDARD) {
        return Err(Failure::Input("--output -: must be a folder, which standard output is not".to_owned()));
    }
    fs::create_dir_all(folder)
        .map_err(|error| Failure::Input(format!("{}: cannot be made: {error}", folder.display())))
}

/// Whether a file of this command is standard output, so that what is for people goes to standard error.
pub(super) static OUTPUT_IS_A_FILE: AtomicBool = AtomicBool::new(false);

/// Writes files, none of which replaces a file that the command reads. A file that was checked is locked until it is
/// written, or until this is dropped.
#[derive(Debug, Default)]
pub(crate) struct Outputs {
    inputs: Vec<PathBuf>,
    claims: RefCell<Vec<Claim>>,
    written: RefCell<Vec<String>>,
    failed: RefCell<Option<Failure>>,
}

impl Outputs {
    /// Of a command that reads this scene.
    pub(crate) fn of(scene: &Path, overrides: &[Override]) -> Result<Self, Failure> {
        Ok(Self { inputs: files(scene, overrides)?, ..Self::default() })
    }

    /// Of a command that reads these files too.
    pub(crate) fn and(mut self, others: &[PathBuf]) -> Self {
        self.inputs.extend(others.iter().cloned());
        self
    }

    /// Of a command that reads these shipped scenes.
    pub(crate) fn of_shipped<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        Self { inputs: names.into_iter().map(shipped).collect(), ..Self::default() }
    }

    /// Locks a file. Refuses one that `option` names twice, that cannot be written, must be kept, or another command has.
    pub(crate) fn check(&self, option: &str, file: &Path) -> Result<(), Failure> {
        if file == Path::new(STANDARD) {
            let is_first = !OUTPUT_IS_A_FILE.swap(true, Ordering::Relaxed);
            let twice = || refusal(option, file, "must not be the file of another output of this command");
            return is_first.then_some(()).ok_or_else(twice);
        }
        let claimed = self.target(file).and_then(|(target, _)| {
            if self.claims.borrow().iter().any(|claim| claim.target == target) {
                return Err("must not be the file of another output of this command".to_owned());
            }
            self.claims.borrow_mut().push(Claim::of(target)?);
            Ok(())
        });
        claimed.map_err(|reason| refusal(option, file, &reason))
    }

    /// As [`Outputs::check`], of pictures, whose names must end in one of [`ENDINGS`].
    pub(crate) fn check_picture<'p>(
        &self,
        option: &str,
        files: impl IntoIterator<Item = &'p PathBuf>,
    ) -> Result<(), Failure> {
        files.into_iter().try_for_each(|file| self.check_ending(option, file, ENDINGS))
    }

    /// As [`Outputs::check`], of a file whose name must end in one of these.
    pub(crate) fn check_ending(&self, option: &str, file: &Path, endings: &[&str]) -> Result<(), Failure> {
        self.check(option, file)?;
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let is_one_of = |endings: &[&str]| ending.as_deref().is_some_and(|ending| endings.contains(&ending));
        if file == Path::new(STANDARD) || is_one_of(endings) {
            return Ok(());
        }
        let needs =
            if is_one_of(&OF_IMAGES) { "; .pdf and .png need a build with --features images" } else { "" };
        Err(refusal(option, file, &format!("must end in .{}{needs}", endings.join(" or ."))))
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
        let trial = above.join(".host-bench.trial");
        match File::create_new(&trial) {
            // Another command may have removed it.
            Ok(_) => fs::remove_file(&trial).or(Ok(())),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(()),
            Err(error) => refuse(&format!("cannot be made: {error}")),
        }
    }

    /// Writes a file whole or not at all: to a temporary file beside it, which is then renamed.
    pub(crate) fn write(&self, file: &Path, bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
        let refuse = |reason: String| Failure::Input(format!("{}: {reason}", file.display()));
        if file == Path::new(STANDARD) {
            let mut output = io::stdout().lock();
            let written = output.write_all(bytes.as_ref()).and_then(|()| output.flush());
            // A reader that closed its end is no error.
            let kind = |error: &io::Error| error.kind() == io::ErrorKind::BrokenPipe;
            let written = written.or_else(|error| if kind(&error) { Ok(()) } else { Err(error) });
            return written.map_err(|error| refuse(format!("cannot be written: {error}")));
        }
        let (target, replaced) = self.target(file).map_err(refuse)?;
        let known = self.claims.borrow().iter().position(|claim| claim.target == target);
        let claim = match known {
            Some(index) => self.claims.borrow_mut().swap_remove(index),
            None => Claim::of(target).map_err(refuse)?,
        };
        let filled = place(&claim.file, bytes.as_ref(), replaced.as_ref(), &claim.part, &claim.target);
        filled.map_err(|error| refuse(format!("cannot be written: {error}")))?;
        self.written.borrow_mut().push(file.display().to_string());
        Ok(())
    }

    /// As [`Outputs::write`], of a command that prints its result without the file too, and then fails by [`Outputs::ended`].
    pub(crate) fn keep(&self, file: &Path, bytes: impl AsRef<[u8]>) {
        if let Err(failure) = self.write(file, bytes) {
            self.failed.borrow_mut().get_or_insert(failure);
        }
    }

    /// Tells which files were written. The first failure of [`Outputs::keep`].
    pub(crate) fn ended(&self) -> Result<(), Failure> {
        let written = self.written.take().join(", ");
        if !written.is_empty() && !is_called() {
            note(&format!("written: {written}"));
        }
        self.failed.take().map_or(Ok(()), Err)
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
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let folder = fs::canonicalize(folder_of(file));
                let folder = folder.map_err(|error| format!("cannot be written: {error}"))?;
                return Ok((folder.join(file.file_name().unwrap_or_default()), None));
            }
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

pub(super) fn refusal(option: &str, path: &Path, reason: &str) -> Failure {
    let space = if option.is_empty() { "" } else { " " };
    Failure::Input(format!("{option}{space}{}: {reason}", path.display()))
}

/// The lock of a file that will be written, which is its temporary file too.
#[derive(Debug)]
struct Claim {
    target: PathBuf,
    part: PathBuf,
    file: File,
}

impl Claim {
    /// Locks the temporary file beside a file. That of a command that is gone is taken over.
    fn of(target: PathBuf) -> Result<Self, String> {
        let part = beside(&target, "part");
        let named = Name::of_file(&part).line();
        let failed = |error: io::Error| format!("cannot be written: {named}: {error}");
        loop {
            let (made, file) = match File::create_new(&part) {
                Ok(file) => (true, file),
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(failed(error)),
                Err(_) => match fs::symlink_metadata(&part) {
                    Err(_) => continue,
                    Ok(found) if !found.is_file() => return Err(format!("{named} must be a file")),
                    Ok(_) => match OpenOptions::new().write(true).open(&part) {
                        Ok(file) => (false, file),
                        Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                        Err(error) => return Err(failed(error)),
                    },
                },
            };
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => {
                    return Err(format!("is being written by another command, which has locked {named}"));
                }
                // Some file systems have no locks.
                Err(TryLockError::Error(error)) if error.kind() != io::ErrorKind::Unsupported => {
                    return Err(failed(error));
                }
                _ => {}
            }
            // Its owner may have renamed or removed it before the lock was taken.
            if is_at(&file, &part).map_err(failed)? {
                if !made {
                    note(&format!("{}: was left by a command that is gone, is taken over", part.display()));
                }
                return Ok(Self { target, part, file });
            }
        }
    }
}

impl Drop for Claim {
    /// Removes the temporary file. After it was renamed there is none, or that of another command.
    fn drop(&mut self) {
        if is_at(&self.file, &self.part).unwrap_or(false) {
            // Nothing is lost if it stays.
            let _ = fs::remove_file(&self.part);
        }
    }
}

fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    let own = file.try_clone().and_then(same_file::Handle::from_file)?;
    Ok(same_file::Handle::from_path(path).is_ok_and(|there| there == own))
}

/// Fills an open file, with the permissions of the one that it replaces, and renames it: a failure leaves the old or the new one.
pub(super) fn place(
    mut file: &File,
    bytes: &[u8],
    replaced: Option<&Metadata>,
    from: &Path,
    to: &Path,
) -> io::Result<()> {
    file.set_len(0)?;
    file.write_all(bytes)?;
    replaced.map_or(Ok(()), |replaced| file.set_permissions(replaced.permissions()))?;
    file.sync_all()?;
    fs::rename(from, to)?;
    // Only some systems open a folder as a file.
    File::open(folder_of(to)).map_or(Ok(()), |folder| folder.sync_all())
}

/// A file beside another one, which no other program names so.
pub(super) fn beside(file: &Path, ending: &str) -> PathBuf {
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(format!(".host-bench.{ending}"));
    folder_of(file).join(name)
}

fn folder_of(file: &Path) -> &Path {
    or_here(file.parent().unwrap_or(Path::new("")))
}

/// A folder, the current one for an empty path.
fn or_here(folder: &Path) -> &Path {
    if folder == Path::new("") { Path::new(".") } else { folder }
}
