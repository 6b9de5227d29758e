//! Files that are read: nothing that is no file, and no more bytes than a limit.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{Error, ErrorKind, Read, Result, stdin};
use std::path::Path;
use std::sync::OnceLock;

/// Most bytes of a scene file.
pub const MOST_OF_SCENE: u64 = 4 << 20;
/// Most bytes of a recording, a trace, or a file of measurements.
pub const MOST_OF_DATA: u64 = 64 << 20;

/// The name of standard input, and of standard output.
pub const STANDARD: &str = "-";
/// Standard input, which can be read once; `None` where it cannot be read.
static INPUT: OnceLock<Option<Vec<u8>>> = OnceLock::new();

/// The bytes of a file, or of standard input.
///
/// # Errors
/// What is no file, cannot be read, or has more than `most` bytes.
pub fn read(file: &Path, most: u64) -> Result<Vec<u8>> {
    if file == Path::new(STANDARD) {
        let mut bytes = Vec::new();
        let all =
            INPUT.get_or_init(|| stdin().take(MOST_OF_DATA + 1).read_to_end(&mut bytes).ok().map(|_| bytes));
        let all = all.clone().ok_or_else(|| Error::other("standard input cannot be read"))?;
        return short(all, most);
    }
    let is_file = fs::metadata(file)?.is_file();
    // A pipe that nobody writes to is never open, and a device may have no end.
    if !is_file {
        return Err(Error::other("is a folder, a device, a pipe or a socket, must be a file"));
    }
    let mut bytes = Vec::new();
    File::open(file)?.take(most + 1).read_to_end(&mut bytes)?;
    short(bytes, most)
}

/// Refuses more bytes than `most`.
fn short(bytes: Vec<u8>, most: u64) -> Result<Vec<u8>> {
    if bytes.len() as u64 > most {
        return Err(Error::new(ErrorKind::FileTooLarge, format!("must have at most {most} bytes, has more")));
    }
    Ok(bytes)
}

/// As [`read`], of a text in UTF-8.
pub fn text(file: &Path, most: u64) -> Result<String> {
    String::from_utf8(read(file, most)?).map_err(|_| Error::new(ErrorKind::InvalidData, "is not UTF-8 text"))
}

/// The first of some names that was there before.
pub fn repeated<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let mut before = BTreeSet::new();
    names.into_iter().find(|name| !before.insert(*name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file;

    #[test]
    fn what_is_no_file_or_too_long_is_refused_and_a_long_scene_is_read_in_proportion() {
        let folder = std::env::temp_dir().join(format!("inputs-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let scene = folder.join("scene.toml");
        let refusal = |file: &Path| scene_file::read(file, &[]).expect_err("no scene").to_string();
        fs::write(&scene, vec![b'#'; MOST_OF_SCENE as usize + 1]).expect("a file");
        assert!(refusal(&scene).contains("must have at most 4194304 bytes"), "{}", refusal(&scene));
        #[cfg(unix)]
        {
            let pipe = folder.join("pipe.toml");
            let made = std::process::Command::new("mkfifo").arg(&pipe).status();
            assert!(made.expect("mkfifo is there").success());
            for file in [pipe.as_path(), Path::new("/dev/zero"), folder.as_path()] {
                assert!(refusal(file).contains("must be a file"), "{}", refusal(file));
            }
        }
        // A reader that counts lines from the start for each table takes more than ten seconds.
        fs::write(&scene, (0..100_000).map(|index| format!("[a{index}]\n")).collect::<String>())
            .expect("a file");
        let began = std::time::Instant::now();
        assert!(refusal(&scene).contains("scene: is missing"), "{}", refusal(&scene));
        assert!(began.elapsed().as_secs_f64() < 8.0, "{:?}", began.elapsed());
        fs::remove_dir_all(&folder).expect("my own folder");
    }
}
