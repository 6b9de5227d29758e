//! The command line of the harvester models.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::FromArgMatches;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use host_bench::command::line::{Arguments, command};
use host_bench::command::report;
use host_bench::method::Failure;

fn main() -> ExitCode {
    let parsed = command().try_get_matches().and_then(|matches| {
        check_width(&matches)?;
        Arguments::from_arg_matches(&matches)
    });
    match parsed {
        Err(error) => usage(&error),
        Ok(arguments) => arguments.run().map_or_else(|failure| report(&failure), |()| ExitCode::SUCCESS),
    }
}

/// Refuses the width of a picture where no file of a picture is written, and of pages, which have none.
fn check_width(matches: &clap::ArgMatches) -> Result<(), clap::Error> {
    let Some(width) = matches.get_one::<f64>("width") else { return Ok(()) };
    let (name, of_command) = matches.subcommand().unwrap_or(("the command without a name", matches));
    let files: &[&str] = match name {
        "budget" | "figures" => return Ok(()),
        "plot" | "sweep" | "tolerance" => &["output"],
        "fit" | "map" | "optimise" => &["output", "picture"],
        "node-strategies" | "node-years" => &["page"],
        _ => &["picture"],
    };
    let file = |option: &&str| of_command.try_get_one::<PathBuf>(option).ok().flatten();
    let (pages, pictures): (Vec<&PathBuf>, Vec<&PathBuf>) = files
        .iter()
        .filter_map(file)
        .partition(|file| file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("html")));
    let reason = match pages.first() {
        _ if !pictures.is_empty() || name == "plot" && pages.is_empty() => return Ok(()),
        Some(page) => format!("{} is a page, which has the width of its window", page.display()),
        None => format!("{name} writes no file of a picture here, whose width this is"),
    };
    Err(clap::Error::raw(ErrorKind::ArgumentConflict, format!("--width {width}mm: {reason}")))
}

/// Prints help as clap does, and an error as one line.
fn usage(error: &clap::Error) -> ExitCode {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        // Without a standard output nothing can be printed.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    if let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand)
        && word.ends_with(".toml")
    {
        let text = format!(
            "{word}: must be a command; a scene file is run by run {word}, other commands are in --help"
        );
        return report(&Failure::Input(text));
    }
    let text = error.to_string();
    let text_lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let lines: Vec<&str> =
        text_lines.take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more")).collect();
    // What is similar follows in a line of its own.
    let line = lines.join(" ").replace(" tip: ", "; ");
    report(&Failure::Input(line.trim_start_matches("error: ").to_owned()))
}
