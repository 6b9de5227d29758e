//! `stability`: the grids of stiff and extreme scenes, and random scenes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::ValueEnum as _;
use comfy_table::presets;

use super::files::{Outputs, make_folder, report_folder};
use super::rows::{self, Parts, Rows};
use super::{SHIPPED_SCENES, count, json_text, one_more, print, with_progress};
use crate::method::Failure;
use crate::outcome::Format;
use crate::run::try_each;
use crate::stability::{
    CASES, COLUMNS, Case, Compared, DAY_S, Effort, Extent, Finding, Kind, build, draw_varied, grid, page,
    pairs, summary,
};

#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "Run time: with --grid coarse 1, 3 and 5 minutes for the three scenes, the whole grid 20 minutes, on two cores"
)]
pub struct StabilityArguments {
    /// Which cases
    #[arg(long, value_enum, default_value_t)]
    grid: Extent,
    /// Of which scene only
    #[arg(long, value_enum, value_name = "SCENE")]
    scene: Option<Kind>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Run this many random scenes in place of the grid
    #[arg(long, value_name = "COUNT", value_parser = count::<u64>(1..=1_000_000),
        conflicts_with_all = ["grid", "scene", "report"])]
    random: Option<u64>,
    /// Which random scenes
    #[arg(long, value_name = "N", default_value_t = 0, requires = "random")]
    seed: u64,
    /// Run the random scenes of these numbers alone; of one, print its row with the arguments that repeat it
    #[arg(long, value_name = "N,..", value_delimiter = ',', requires = "random", conflicts_with = "output")]
    case: Vec<u64>,
    /// By how many accurate runs the mean power of a chaotic random scene is judged
    #[arg(long, value_name = "RUNS", default_value_t = 33, value_parser = count::<i32>(3..=9_999), requires = "random",
        conflicts_with = "output")]
    judges: i32,
    /// Run each shipped scene for 86,400 simulated seconds in f32 and in f64 in place of the grid, and compare the mean powers
    #[arg(long, conflicts_with_all = ["grid", "random", "output", "report"])]
    day: bool,
    /// Append a row for each case to this file; a file with rows of this build is continued
    #[arg(long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    #[command(flatten)]
    parts: Parts,
    /// Folder of the page with the maps of the grid, and of its cases as CSV [default: report/stability]
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

const PAGE: &str = "index.html";
/// The option that names the file of rows.
const OUTPUT: &str = "--output";
/// Most attempted steps of a run of a grid, and of a random scene.
const MOST_ATTEMPTS: [u64; 2] = [2_000_000, 200_000];
/// Of the settings of the grid and of the random scenes of a beam, every so many-th is judged by the reference.
const BY_REFERENCE: [usize; 2] = [7, 3];

/// Runs all cases, on all cores, and prints what became of them. Fails if a case is wrong or broken.
pub(super) fn run(arguments: &StabilityArguments) -> Result<(), Failure> {
    if arguments.day {
        return run_days(arguments.scene, arguments.format);
    }
    let outputs = Outputs::of_shipped(SHIPPED_SCENES);
    let (output, parts) = (arguments.output.as_deref(), arguments.parts);
    output.iter().try_for_each(|file| outputs.check(OUTPUT, &parts.file(file)))?;
    if (parts.is_one() || parts.merge.is_some()) && arguments.random.is_none() {
        return Err(Failure::Input("--part, --merge: must be with --random".to_owned()));
    }
    let folder = arguments.report.clone().unwrap_or_else(|| report_folder().join("stability"));
    let has_page = arguments.random.is_none();
    if has_page {
        make_folder(&folder)?;
        [PAGE, CASES].iter().try_for_each(|name| outputs.check("--report", &folder.join(name)))?;
    }
    if let (Some(case), Some(count)) = (arguments.case.iter().max(), arguments.random)
        && *case >= count
    {
        return Err(Failure::Input(format!("--case {case}: must be below the {count} of --random")));
    }
    let cases = cases(arguments);
    let is_asked = |number: usize| {
        parts.has(number) && (arguments.case.is_empty() || arguments.case.contains(&(number as u64)))
    };
    let effort = |number| effort(arguments, number, &cases[number]);
    let rows = judged(&cases, is_asked, effort, (output, parts))?;
    let csv = || rows.iter().fold(Finding::heading(), |text, row| text + &row.csv());
    print(&match arguments.format {
        Format::Table if arguments.case.len() != 1 => summary(&rows),
        Format::Csv => csv(),
        _ => json_text(&rows)?,
    })?;
    if has_page {
        outputs.write(&folder.join(CASES), csv())?;
        outputs.write(&folder.join(PAGE), page(&cases, &rows))?;
        outputs.ended()?;
    }
    none_of(&rows, |row| row.class.is_failure(), "cases are wrong or broken")
}

fn cases(arguments: &StabilityArguments) -> Vec<Case> {
    if let Some(count) = arguments.random {
        return (0..count).map(|number| draw_varied(arguments.seed, number)).collect();
    }
    let kinds = arguments.scene.as_ref().map_or(Kind::value_variants(), std::slice::from_ref);
    kinds.iter().flat_map(|&kind| grid(kind, arguments.grid)).collect()
}

/// Of the case of a number. A setting has two numbers, one for each precision.
fn effort(arguments: &StabilityArguments, number: usize, case: &Case) -> Effort {
    let ([of_grid, of_random], [setting, beam]) = (MOST_ATTEMPTS, BY_REFERENCE);
    let is_random = arguments.random.is_some();
    let (number, every, most_attempts) =
        if is_random { (number, beam, of_random) } else { (number / 2, setting, of_grid) };
    let by_reference = number.is_multiple_of(every) || is_random && !case.scene.starts_with("bump-stop");
    Effort { most_attempts, by_reference, chaotic_pairs: arguments.judges / 2 }
}

fn none_of<T>(rows: &[T], fails: impl Fn(&T) -> bool, what: &str) -> Result<(), Failure> {
    match rows.iter().filter(|row| fails(row)).count() {
        0 => Ok(()),
        count => Err(Failure::Step(format!("{count} of {} {what}", rows.len()))),
    }
}

/// Runs all pairs on all cores and prints them. Fails if a pair differs by more than it claims.
fn run_days(kind: Option<Kind>, format: Format) -> Result<(), Failure> {
    let pairs = pairs(kind, DAY_S);
    let runs: Vec<(usize, usize)> =
        (0..pairs.len()).flat_map(|pair| [0, 1].map(|precision| (pair, precision))).collect();
    let outcomes = with_progress("days", runs.len(), |bar| {
        try_each(&runs, |&(pair, precision)| {
            let outcome = pairs[pair].run(precision);
            one_more(bar);
            outcome
        })
    })?;
    let both = outcomes.chunks_exact(2).zip(&pairs);
    let compared = both.map(|(runs, pair)| pair.compared([&runs[0], &runs[1]]));
    let rows = compared.collect::<Result<Vec<Compared>, Failure>>()?;
    print(&crate::rows::Rows::of(&rows).text(format, |rows| rows.table(presets::NOTHING, &COLUMNS, 2)))?;
    none_of(&rows, |row| !row.agrees(), "pairs differ by more than they claim")
}

/// A large odd number: its multiples modulo 2⁶⁴ have no order.
const SHUFFLE: u64 = 0x9e37_79b9_7f4a_7c15;

/// The rows of the cases that are asked for, by number, judged on all cores. With a file, the row of a case is appended when the
/// case is judged, and a case whose row the file has is not run again. A file with rows of another build is refused.
fn judged(
    cases: &[Case],
    is_asked: impl Fn(usize) -> bool,
    effort: impl Fn(usize) -> Effort + Sync,
    (output, parts): (Option<&Path>, Parts),
) -> Result<Vec<Finding>, Failure> {
    let (file, done) = match output {
        Some(path) => taken_up(path, parts, cases).map(|(file, done)| (Some(file), done))?,
        None => (None, BTreeMap::new()),
    };
    let is_left = |(number, _): &(usize, &Case)| is_asked(*number) && !done.contains_key(number);
    let left: Vec<(usize, &Case)> = cases.iter().enumerate().filter(is_left).collect();
    let mut groups: Vec<&[(usize, &Case)]> =
        left.chunk_by(|(_, one), (_, other)| one.is_twin_of(other)).collect();
    // Cases of like cost are beside each other: shuffled, the time that is left follows from the time that is gone.
    groups.sort_by_key(|group| group.first().map_or(0, |(number, _)| (*number as u64).wrapping_mul(SHUFFLE)));
    let new = with_progress("scenes", left.len(), |bar| {
        try_each(&groups, |twins| {
            let number = twins.first().map_or(0, |(number, _)| *number);
            let rows = Finding::judged(twins, effort(number));
            rows.iter().for_each(|_| one_more(bar));
            file.as_ref().map_or(Ok(()), |file| file.append(rows.iter().map(Finding::line)))?;
            Ok(rows)
        })
    })?;
    let mut rows: Vec<Finding> = done.into_values().chain(new.into_iter().flatten()).collect();
    rows.sort_by_key(|row| row.number);
    Ok(rows)
}

/// The rows of a file that an earlier run began. A file that is not there is made, with its heading.
fn taken_up(path: &Path, parts: Parts, cases: &[Case]) -> Result<(Rows, BTreeMap<usize, Finding>), Failure> {
    let heading = Finding::heading();
    let kind = rows::Kind {
        option: OUTPUT,
        heading: heading.trim_end(),
        other: "must be a file of stability, or not be there",
    };
    let read = |line: &str| {
        let row = Finding::read(&format!("{heading}{line}\n")).ok()?.pop()?;
        Some((row.number, row))
    };
    Rows::open(path, (parts, cases.len()), kind, read, |rows| {
        let is_another =
            |row: &&Finding| cases.get(row.number).is_none_or(|case| case.arguments() != row.arguments);
        if let Some(row) = rows.values().find(|row| row.build != build()) {
            let [other, own] = [row.build.as_str(), build()];
            let rest = "remove it or give another file";
            return Err(format!("has rows of another build ({other}, this one is {own}): {rest}"));
        }
        let refused = |row: &Finding| Err(format!("has another case {} than this list of cases", row.number));
        rows.values().find(is_another).map_or(Ok(()), refused)
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::stability::{draw, fnv_1a};

    /// Few attempts: most of these cases are given up at once.
    const EFFORT: Effort = Effort { most_attempts: 10, by_reference: false, chaotic_pairs: 2 };

    fn cases(seed: u64) -> Vec<Case> {
        (0..4).map(|number| draw(seed, number)).collect()
    }

    #[test]
    fn a_file_is_taken_up_without_a_line_that_is_not_whole() {
        let path = std::env::temp_dir().join(format!("judged-cases-{}.csv", std::process::id()));
        let _ = fs::remove_file(&path);
        let output = (Some(&*path), Parts::default());
        let all = judged(&cases(3), |_| true, |_| EFFORT, output).expect("the file was made");
        assert!(all.iter().map(|row| row.number).eq(0..4));
        // The order in the file is that in which the cases were judged.
        let text = fs::read_to_string(&path).expect("is there");
        let (whole, last) = text.trim_end().rsplit_once('\n').expect("has rows");
        let taken_up = |seed: u64| {
            let rows = super::taken_up(&path, Parts::default(), &cases(seed));
            rows.map(|(_, rows)| rows.len()).map_err(|error| error.to_string())
        };
        fs::write(&path, format!("{whole}\n{}", &last[..5])).expect("is writable");
        assert_eq!(taken_up(3), Ok(3));
        assert_eq!(fs::read_to_string(&path).expect("is there"), format!("{whole}\n"));
        assert_eq!(judged(&cases(3), |_| true, |_| EFFORT, output), Ok(all));
        assert!(taken_up(4).is_err_and(|error| error.contains("another case")));
        let of_another = |line: &str| {
            let row = line.rsplit_once(',').expect("a checksum").0.replace(build(), "0.0.9-unknown");
            format!("{row},{:016x}\n", fnv_1a(row.as_bytes()))
        };
        let text = fs::read_to_string(&path).expect("is there");
        let (heading, lines) = text.split_once('\n').expect("a heading");
        fs::write(&path, format!("{heading}\n{}", lines.lines().map(of_another).collect::<String>()))
            .expect("is writable");
        let other = taken_up(3).expect_err("another build");
        assert!(other.contains("rows of another build (0.0.9-unknown, "), "{other}");
        fs::write(&path, "a,b\n1,2\n").expect("is writable");
        assert!(taken_up(3).is_err());
        let _ = fs::remove_file(&path);
    }
}
