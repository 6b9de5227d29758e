//! The main job, done when no command is given: error against run time in short, and the report.

use std::io::Write;
use std::path::Path;

use super::{print, work_precision, write_whole};
use crate::method::Failure;
use crate::report;
use crate::work_precision::Extent;

/// Where the report goes, from the workspace.
const REPORT: &str = "target/report";

/// Runs the short comparison, prints it and writes the report.
///
/// # Errors
/// If the shipped scene cannot be run or the report not written.
pub fn run() -> Result<(), Failure> {
    let scenes = work_precision::shipped(&[])?;
    let comparisons = work_precision::compare(&scenes, &Extent::SHORT)?;
    print(&work_precision::text(&comparisons))?;
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    // A binary that was moved away from its sources reports where it stands.
    let folder = workspace.canonicalize().unwrap_or_default().join(REPORT);
    let page = report::page(&comparisons).map_err(Failure::Input)?;
    std::fs::create_dir_all(&folder)
        .map_err(|error| Failure::Input(format!("{}: cannot be made: {error}", folder.display())))?;
    let file = folder.join("index.html");
    write_whole(&file, &page)?;
    // With no standard error left there is nobody to tell.
    let _ = writeln!(std::io::stderr(), "report: {}", file.display());
    Ok(())
}
