//! The default command: error against run time in short, and the report.

use super::files::{Outputs, make_folder, report_folder};
use super::{SHIPPED_SCENES, note, print, work_precision};
use crate::method::Failure;
use crate::report::report;
use crate::work_precision::{Extent, table};

/// The page of the report.
const PAGE: &str = "index.html";

/// Runs the short comparison, prints it and writes the report.
pub fn run() -> Result<(), Failure> {
    let scenes = work_precision::shipped(&[], &Extent::SHORT)?;
    let (outputs, folder) = (Outputs::of_shipped(SHIPPED_SCENES), report_folder());
    outputs.check_in("", &folder, &[PAGE])?;
    let comparisons = work_precision::compare(&scenes, &Extent::SHORT)?;
    print(&table::text(&comparisons))?;
    let page = report(&comparisons)?;
    make_folder(&folder)?;
    let file = folder.join(PAGE);
    outputs.write(&file, &page)?;
    note(&format!("report: {}", file.display()));
    Ok(())
}
