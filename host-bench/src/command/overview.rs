//! The default command: error against run time in short, and the report.

use super::{make_folder, print, report_folder, tell, work_precision, write_whole};
use crate::method::Failure;
use crate::report;
use crate::work_precision::{Extent, table};

/// Runs the short comparison, prints it and writes the report.
pub fn run() -> Result<(), Failure> {
    let scenes = work_precision::shipped(&[], &Extent::SHORT)?;
    let comparisons = work_precision::compare(&scenes, &Extent::SHORT)?;
    print(&table::text(&comparisons))?;
    let folder = report_folder();
    let page = report::page(&comparisons).map_err(Failure::Input)?;
    make_folder(&folder)?;
    let file = folder.join("index.html");
    write_whole(&file, &page)?;
    tell(&format!("report: {}", file.display()));
    Ok(())
}
