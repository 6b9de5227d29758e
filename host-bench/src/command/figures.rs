//! `figures`: the papers' figures, rebuilt.

use std::io::Write;
use std::path::PathBuf;

use super::{make_folder, progress, report_folder, work_precision, write_whole};
use crate::figures;
use crate::method::Failure;
use crate::scene_file;

/// Arguments of `figures`.
#[derive(Debug, Clone, clap::Args)]
pub struct FiguresArguments {
    /// Folder for the pictures, their numbers and the page [default: target/report/figures]
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Runs all that the figures need, then writes pictures, numbers and the page.
///
/// # Errors
/// A folder that cannot be written to, or a run that fails; then nothing is written.
pub fn run(arguments: &FiguresArguments) -> Result<(), Failure> {
    let folder = arguments.output.clone().unwrap_or_else(|| report_folder().join("figures"));
    // Before the work, so that a bad path is told at once.
    make_folder(&folder)?;
    let base = scene_file::read(&work_precision::shipped_file("contact-separation.toml"), &[])?;
    let bar = progress(figures::runs());
    let figures = figures::build(&base, &|| bar.inc(1));
    bar.finish_and_clear();
    let figures = figures?;
    for figure in &figures {
        write_whole(&folder.join(format!("figure-{}.csv", figure.number)), &figure.csv)?;
        for panel in &figure.panels {
            write_whole(&folder.join(format!("{}.svg", panel.name)), &panel.svg)?;
        }
    }
    let page = folder.join("index.html");
    write_whole(&page, &figures::page(&figures))?;
    // With no standard error left there is nobody to tell.
    let _ = writeln!(std::io::stderr(), "figures: {}", page.display());
    Ok(())
}
