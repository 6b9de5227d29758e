//! Changed files of rows, through the binary: refused in one line and left as they are, or resumed to the result of an
//! uninterrupted run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use arbtest::arbitrary::Unstructured;

use super::change::{any, below};
use super::scenes::folder;
use crate::fuzz;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/contact-separation-passive.toml");
const ROWS: &str = "sweep.rows.jsonl";

/// The command on one core within 1 GB of addresses, ten CPU seconds, and files of so many times 512 bytes.
fn run(folder: &Path, arguments: &[&str], most: &str) -> Output {
    let bounds =
        format!("ulimit -v 1000000; ulimit -t 10; ulimit -c 0; ulimit -f {most}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &bounds, env!("CARGO_BIN_EXE_host-bench")]).args(arguments);
    command.env("RAYON_NUM_THREADS", "1").current_dir(folder).output().expect("the binary starts")
}

/// Changes a file of rows: it ends anywhere, lines are missing, stand twice or in another order, or bytes are others.
fn change(bytes: &mut Unstructured<'_>, text: &str) -> Vec<u8> {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let (one, other) = (1 + below(bytes, lines.len() - 1), 1 + below(bytes, lines.len() - 1));
    match below(bytes, 9) {
        0 => drop(lines.remove(one)),
        1 => lines.truncate(one),
        2 => return text.as_bytes()[..below(bytes, text.len())].to_vec(),
        3 => lines.swap(one, other),
        4 => lines.insert(other, lines[one]),
        _ => {
            let mut text = text.as_bytes().to_vec();
            // A change of the heading is that of one byte of four.
            let heading = if below(bytes, 4) == 0 { 0 } else { lines[0].len() };
            let place = heading + below(bytes, text.len() - heading);
            match below(bytes, 4) {
                0 => text[place] ^= 1 << below(bytes, 8),
                1 => text[place] = any(bytes),
                2 => text[place] = b"0123456789.,\"\n-e"[below(bytes, 16)],
                _ => drop(text.drain(place..(place + 1 + below(bytes, 30)).min(text.len()))),
            }
            return text;
        }
    }
    lines.concat().into_bytes()
}

/// Rows of CSV without the columns that differ from run to run, in order.
fn results(table: &[u8]) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_reader(table);
    let heading = reader.headers().expect("a heading").clone();
    let is_kept = |at: usize| !["processor_s", "checksum_fnv1a"].contains(&&heading[at]);
    let rows = reader.records().map(|row| row.expect("a row"));
    let kept =
        rows.map(|row| (0..row.len()).filter(|at| is_kept(*at)).map(|at| row[at].to_owned()).collect());
    let mut rows: Vec<Vec<String>> = kept.collect();
    rows.sort();
    rows
}

/// A command that goes on from its file of rows.
struct Resumed<'a> {
    folder: &'a Path,
    rows: PathBuf,
    arguments: &'a [&'a str],
    /// What it has found at its end.
    table: &'a dyn Fn(&Output) -> Vec<u8>,
}

impl Resumed<'_> {
    /// Runs the command with these rows; whether they are taken. It then finds the same as without them.
    fn is_taken(&self, rows: &[u8], found: &[Vec<String>]) -> bool {
        fs::write(&self.rows, rows).expect("a file");
        let output = run(self.folder, self.arguments, "unlimited");
        let told = String::from_utf8_lossy(&output.stderr);
        if output.status.code() == Some(2) {
            assert_eq!(told.lines().count(), 1, "{told}");
            assert_eq!(fs::read(&self.rows).expect("it stays"), rows, "a refused file is changed: {told}");
            return false;
        }
        assert_eq!(output.status.code(), Some(0), "{told}");
        assert_eq!(results(&(self.table)(&output)), found, "{}", String::from_utf8_lossy(rows));
        true
    }
}

#[test]
fn rows_of_a_sweep() {
    let folder = folder("fuzz-sweep");
    let output = folder.join("sweep");
    let over = ["--over", "load.resistance_ohm=1e6:1e9:6:log", "--no-accuracy", "--output", "sweep"];
    let arguments = [&["sweep", SCENE, "--set", "run={duration_s=0.3,settle_s=0.2}"], &over[..]].concat();
    let table = |_: &Output| fs::read(output.join("sweep.csv")).expect("the table");
    let _ = fs::remove_dir_all(&output);
    let found = results(&table(&run(&folder, &arguments, "unlimited")));
    // The file of rows is there as long as the sweep runs: the system stops it in the fifth row or near it.
    run(&folder, &arguments, "12");
    let rows = fs::read_to_string(output.join(ROWS)).expect("the rows");
    let rows = &rows[..=rows.rfind('\n').expect("whole lines")];
    assert!(rows.lines().count() >= 4, "{rows}");
    let resumed = Resumed { folder: &folder, rows: output.join(ROWS), arguments: &arguments, table: &table };
    fuzz("rows of a sweep", 30, |bytes| resumed.is_taken(&change(bytes, rows), &found));
}

#[test]
fn rows_of_stability() {
    let folder = folder("fuzz-stability");
    let file = folder.join("rows.csv");
    let _ = fs::remove_file(&file);
    let arguments = ["stability", "--random", "3", "--seed", "2", "--format", "csv", "--output", "rows.csv"];
    let table = |output: &Output| output.stdout.clone();
    let found = results(&table(&run(&folder, &arguments, "unlimited")));
    let rows = fs::read_to_string(&file).expect("the rows");
    let resumed = Resumed { folder: &folder, rows: file.clone(), arguments: &arguments, table: &table };
    fuzz("rows of stability", 15, |bytes| {
        let is_taken = resumed.is_taken(&change(bytes, &rows), &found);
        // What it leaves, it takes.
        let left = fs::read(&file).expect("it stays");
        assert!(!is_taken || resumed.is_taken(&left, &found));
        is_taken
    });
}
