//! The main job, done when no command is given: error against run time in short, and the report.

use std::io::Write;

use super::{make_folder, print, report_folder, work_precision, write_whole};
use crate::method::Failure;
use crate::report;
use crate::work_precision::Extent;

/// Runs the short comparison, prints it and writes the report.
///
/// # Errors
/// If a shipped scene cannot be run or the report not written.
pub fn run() -> Result<(), Failure> {
    let scenes = work_precision::shipped(&[], 2)?;
    let comparisons = work_precision::compare(&scenes, &Extent::SHORT)?;
    let scenes = work_precision::bump_stop::shipped(&[], 1)?;
    let bump_stop = work_precision::bump_stop::compare(&scenes, &Extent::SHORT)?;
    print(&(work_precision::text(&comparisons) + "\n" + &work_precision::bump_stop::text(&bump_stop)))?;
    let folder = report_folder();
    let page = report::page(&comparisons, &bump_stop).map_err(Failure::Input)?;
    make_folder(&folder)?;
    let file = folder.join("index.html");
    write_whole(&file, &page)?;
    // With no standard error left there is nobody to tell.
    let _ = writeln!(std::io::stderr(), "report: {}", file.display());
    Ok(())
}
