//! What `--method auto` chooses, against the cheapest choice that is accurate enough, over a grid of scenes.

mod search;

use std::f64::consts::TAU;
use std::path::PathBuf;

use comfy_table::presets;
use serde::Serialize;

use super::table::{grouped, ratio, resistance};
use crate::embedded::tolerance_for;
use crate::method::{Failure, Method, Options};
use crate::rows::{Column, Digits, Rows};
use crate::run::run_scene;
use crate::scene_file::{self, Excitation, GRAVITY, Override, Scene, Tone, Trace};
use search::Search;

/// Relative errors of the mean power that are asked for.
pub(crate) const ACCURACIES: [f64; 3] = [1e-2, 1e-3, 1e-5];
/// Tolerance of exponential Radau for the mean power that errors are relative to.
const REFERENCE_TOLERANCE: f64 = 1e-8;
/// Largest ratio of run times that counts as equal to the cheapest choice.
const NEAR: f64 = 1.3;
/// Largest error over the accuracy that counts as met.
const MET: f64 = 1.5;
/// Largest difference of the two references, over the accuracy, with which a row is compared. Above it the motion is
/// chaotic, and no two runs have the same mean power.
const AGREED: f64 = 0.1;

/// One cell of the grid at one accuracy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Row {
    scene: &'static str,
    load_ohm: f64,
    force_law: &'static str,
    excitation: &'static str,
    accuracy: f64,
    auto_tolerance: f64,
    /// Relative error of the mean power of the run that `auto` makes.
    auto_error: f64,
    /// Steps of that run, kept and rejected, per simulated second.
    auto_attempts_per_s: f64,
    /// Run time in ns per simulated second.
    auto_ns_per_s: f64,
    /// Run time over that of the cheapest choice; `None` if no choice meets the accuracy, or none can.
    auto_over_best: Option<f64>,
    best_method: Option<&'static str>,
    best_setting: Option<String>,
    best_error: Option<f64>,
    best_attempts_per_s: Option<f64>,
    /// Run time over that of the cheapest choice that meets the accuracy with all finer settings of its ladder: the
    /// errors of loose settings change their sign, and one of them may be small by chance.
    auto_over_sure: Option<f64>,
    sure_setting: Option<String>,
    /// Relative difference of the mean power of the independent reference from the one errors are relative to.
    cross_check: f64,
}

/// Whether the mean power is known well enough to decide whether a run meets the accuracy.
fn is_known(cross_check: f64, accuracy: f64) -> bool {
    cross_check <= AGREED * accuracy
}

/// What the whole grid says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Summary {
    /// Rows that have a cheapest choice.
    compared: usize,
    /// Rows whose references differ by more than a tenth of the accuracy; they are not in the other counts.
    chaotic: usize,
    /// Other rows without a cheapest choice.
    met_by_none: usize,
    largest_auto_over_best: Option<f64>,
    median_auto_over_best: Option<f64>,
    largest_auto_over_sure: Option<f64>,
    /// Rows whose ratio is above 1.3.
    above: usize,
    /// Rows whose error is more than 1.5 times the accuracy.
    missed: usize,
}

/// The rows of the grid with what they say together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Grid {
    pub(crate) rows: Vec<Row>,
    pub(crate) summary: Summary,
}

impl Grid {
    pub(crate) fn of(rows: Vec<Row>) -> Self {
        let known: Vec<&Row> = rows.iter().filter(|row| is_known(row.cross_check, row.accuracy)).collect();
        let mut ratios: Vec<f64> = known.iter().filter_map(|row| row.auto_over_best).collect();
        ratios.sort_by(f64::total_cmp);
        let summary = Summary {
            compared: ratios.len(),
            chaotic: rows.len() - known.len(),
            met_by_none: known.len() - ratios.len(),
            largest_auto_over_best: ratios.last().copied(),
            median_auto_over_best: (!ratios.is_empty()).then(|| super::median(ratios.clone())),
            largest_auto_over_sure: known.iter().filter_map(|row| row.auto_over_sure).reduce(f64::max),
            above: ratios.iter().filter(|&&ratio| ratio > NEAR).count(),
            missed: known.iter().filter(|row| !(row.auto_error <= MET * row.accuracy)).count(),
        };
        Self { rows, summary }
    }
}

/// Runs one cell of the grid, on the calling thread: a row for each accuracy.
///
/// # Errors
/// If the scene is refused, or if a reference or a run by `auto` stops on its way.
pub(crate) fn examine(cell: &Cell) -> Result<Vec<Row>, Failure> {
    let scene = &cell.scene;
    let fine = Options {
        method: Method::ExponentialRadau,
        tolerance: Some(REFERENCE_TOLERANCE),
        bare: true,
        ..Options::default()
    };
    let mean_power = |options: &Options| -> Result<f64, Failure> {
        let power = run_scene(scene, options)?.mean_power_w.filter(|power| *power > 0.0);
        power.ok_or_else(|| Failure::of_file(scene, "the mean power must be above 0 to be compared"))
    };
    let power = mean_power(&fine)?;
    let independent = mean_power(&Options { method: Method::Reference, ..Options::default() })?;
    let cross_check = ((independent - power) / power).abs();
    let mut search = Search::new(scene, power);
    let chosen: Vec<usize> = ACCURACIES
        .iter()
        .map(|&accuracy| {
            let options = Options { accuracy: Some(accuracy), ..Options::default() };
            search.run("auto", String::new(), options)
        })
        .collect::<Result<_, _>>()?;
    search.climb()?;
    let best = ACCURACIES.map(|accuracy| search.candidates(accuracy));
    let sure = ACCURACIES.map(|accuracy| search.sure_candidates(accuracy));
    search.time(chosen.iter().chain(best.iter().flatten()).chain(sure.iter().flatten()).copied())?;
    let rows = ACCURACIES.iter().zip(chosen).zip(best.iter().zip(&sure));
    let rows = rows.map(|((&accuracy, chosen), (best, sure))| {
        let known = is_known(cross_check, accuracy);
        row(cell, &search, [accuracy, cross_check], chosen, [best, sure].map(|all| known.then_some(&**all)))
    });
    Ok(rows.collect())
}

/// A row: of the run of `auto` at `chosen`, and of the candidates that meet the accuracy, loosely and surely.
fn row(
    cell: &Cell,
    search: &Search<'_>,
    [accuracy, cross_check]: [f64; 2],
    chosen: usize,
    candidates: [Option<&[usize]>; 2],
) -> Row {
    let scene = &cell.scene;
    let auto = search.of(chosen);
    let [best, sure] = candidates.map(|places| {
        let choices = places.unwrap_or_default().iter().map(|&place| search.of(place));
        choices.min_by(|one, other| one.seconds.total_cmp(&other.seconds))
    });
    let per_s = |value: f64| value / scene.run.duration_s;
    Row {
        scene: cell.name,
        load_ohm: scene.load.resistance_ohm(),
        force_law: cell.force_law,
        excitation: cell.excitation,
        accuracy,
        auto_tolerance: tolerance_for(scene, accuracy),
        auto_error: auto.error,
        auto_attempts_per_s: per_s(auto.attempts),
        auto_ns_per_s: per_s(1e9 * auto.seconds),
        auto_over_best: best.map(|best| auto.seconds / best.seconds),
        best_method: best.map(|best| best.method),
        best_setting: best.map(|best| best.setting.clone()),
        best_error: best.map(|best| best.error),
        best_attempts_per_s: best.map(|best| per_s(best.attempts)),
        auto_over_sure: sure.map(|sure| auto.seconds / sure.seconds),
        sure_setting: sure.map(|sure| format!("{} {}", sure.method, sure.setting)),
        cross_check,
    }
}

const FORCE_LAWS: [&str; 2] = ["transferred-charge", "gap-field"];
/// Loads of contact-separation under the shipped sine, in Ω.
const CONTACT_LOADS: [f64; 8] = [1.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];
/// Loads of contact-separation under two tones and under samples, in Ω.
const OTHER_LOADS: [f64; 2] = [1e6, 1e8];
/// Loads of sliding, in Ω.
const SLIDING_LOADS: [f64; 4] = [1e4, 1e6, 1e8, 1e9];
/// Amplitude in g and frequency in Hz under which the slider moves with the law of the gap field.
const STRONG: [f64; 2] = [0.8, 16.0];
/// The same under which contact-separation with that law hits once a period; under the shipped sine it is chaotic.
const STRONG_CONTACT: [f64; 2] = [1.0, 20.0];
/// Amplitude in g and frequency in Hz under which the slider sticks and slips.
const STICK_SLIP: [f64; 2] = [0.3, 6.0];
/// Amplitude in g and frequency in Hz of the two tones.
const TWO_TONES: [[f64; 2]; 2] = [[0.2, 20.0], [0.1, 27.0]];
/// Samples per second.
const RATE_HZ: f64 = 400.0;

/// A scene of the grid with its names.
pub(crate) struct Cell {
    name: &'static str,
    force_law: &'static str,
    excitation: &'static str,
    scene: Scene,
}

/// All scenes, with `overrides` in each.
///
/// # Errors
/// If an override is refused.
pub(crate) fn cells(overrides: &[Override]) -> Result<Vec<Cell>, Failure> {
    let mut cells = Vec::new();
    for force_law in FORCE_LAWS {
        let contact = |load_ohm, sine| cell("contact-separation", force_law, load_ohm, sine, overrides);
        for load_ohm in CONTACT_LOADS {
            cells.push(contact(load_ohm, None)?);
        }
        if force_law == "gap-field" {
            for load_ohm in CONTACT_LOADS {
                cells.push(contact(load_ohm, Some(STRONG_CONTACT))?);
            }
        }
        for load_ohm in OTHER_LOADS {
            let excitations = [("two tones", two_tones()), ("400 Hz samples", samples())];
            for (excitation, own) in excitations {
                let mut cell = contact(load_ohm, None)?;
                cell.excitation = excitation;
                cell.scene.excitation = own;
                cells.push(cell);
            }
        }
        let strong = (force_law == "gap-field").then_some(STRONG);
        for load_ohm in SLIDING_LOADS {
            cells.push(cell("sliding", force_law, load_ohm, strong, overrides)?);
        }
    }
    let mut stick_slip = cell("sliding", "transferred-charge", 1e8, Some(STICK_SLIP), overrides)?;
    (stick_slip.name, stick_slip.excitation) = ("stick-slip", "slow sine");
    cells.push(stick_slip);
    Ok(cells)
}

/// A shipped scene with a load and a force law, under its own sine or one of another amplitude in g and frequency in Hz.
fn cell(
    name: &'static str,
    force_law: &'static str,
    load_ohm: f64,
    sine: Option<[f64; 2]>,
    overrides: &[Override],
) -> Result<Cell, Failure> {
    let mut all = vec![
        Override::new("load.resistance_ohm", &load_ohm.to_string()),
        Override::new("parameters.force_law", force_law),
    ];
    if let Some([amplitude_g, frequency_hz]) = sine {
        all.push(Override::new("excitation.amplitude_g", &amplitude_g.to_string()));
        all.push(Override::new("excitation.frequency_hz", &frequency_hz.to_string()));
    }
    all.extend(overrides.iter().cloned());
    let mut scene = scene_file::read(&scene_file::shipped(name), &all)?;
    // The name without the folder in which this crate was built.
    scene.file = PathBuf::from(name).with_extension("toml");
    let excitation = if sine.is_some() { "strong sine" } else { "sine" };
    Ok(Cell { name, force_law, excitation, scene })
}

fn two_tones() -> Excitation {
    let tone = |[amplitude_g, frequency_hz]: [f64; 2]| Tone {
        amplitude_m_per_s2: amplitude_g * GRAVITY,
        frequency_hz,
        phase_rad: 0.0,
    };
    Excitation::Sines(TWO_TONES.map(tone).to_vec())
}

/// A second of the two tones, which are whole Hz, again and again.
fn samples() -> Excitation {
    let sample = |index: u32| {
        let time_s = f64::from(index) / RATE_HZ;
        let value = |[amplitude_g, frequency_hz]: [f64; 2]| {
            amplitude_g * GRAVITY * (TAU * frequency_hz * time_s).sin()
        };
        TWO_TONES.map(value).iter().sum()
    };
    let samples_m_per_s2 = (0..RATE_HZ as u32).map(sample).collect();
    Excitation::File(Trace { samples_m_per_s2, rate_hz: RATE_HZ, repeat: true, resampled: None })
}

const COLUMNS: [Column<'_>; 14] = [
    ("scene", "scene", Digits::Word),
    ("load", "load_ohm", Digits::By(resistance)),
    ("force law", "force_law", Digits::Word),
    ("excitation", "excitation", Digits::Word),
    ("accuracy", "accuracy", Digits::Exponent(0)),
    ("auto: tolerance", "auto_tolerance", Digits::Exponent(1)),
    ("error", "auto_error", Digits::Exponent(1)),
    ("attempts per simulated s", "auto_attempts_per_s", Digits::By(grouped)),
    ("ns per simulated s", "auto_ns_per_s", Digits::By(grouped)),
    ("over best", "auto_over_best", OVER),
    ("best", "best", Digits::Word),
    ("its error", "best_error", Digits::Exponent(1)),
    ("its attempts per simulated s", "best_attempts_per_s", Digits::By(grouped)),
    ("over sure best", "auto_over_sure", OVER),
];
/// Columns at the left that hold words.
const WORDS: usize = 4;
/// A ratio of run times.
const OVER: Digits = Digits::By(|value| ratio(Some(value)));

impl Row {
    fn best(&self) -> String {
        match (self.best_method, &self.best_setting) {
            (Some(method), Some(setting)) => format!("{method} {setting}"),
            _ => "none".to_owned(),
        }
    }
}

impl Summary {
    fn text(&self) -> String {
        format!(
            "Run time of auto over that of the cheapest choice: at most {}, median {}, above {NEAR} in {} of {} \
             rows; at most {} over the cheapest that all finer settings confirm. No choice meets the accuracy in {} rows. The error of auto is more than {MET} times the \
             accuracy in {} rows. In {} rows more the motion is chaotic: the references differ by more than {AGREED} \
             times the accuracy.",
            ratio(self.largest_auto_over_best),
            ratio(self.median_auto_over_best),
            self.above,
            self.compared,
            ratio(self.largest_auto_over_sure),
            self.met_by_none,
            self.missed,
            self.chaotic,
        )
    }
}

/// The table for a terminal, with what it says below.
pub(crate) fn text(grid: &Grid) -> String {
    let mut rows = Rows::of(&grid.rows);
    for (shown, row) in rows.0.iter_mut().zip(&grid.rows) {
        shown.insert("best".to_owned(), row.best().into());
    }
    let table = rows.table(presets::ASCII_MARKDOWN, &COLUMNS, WORDS);
    let known = grid.rows.iter().filter(|row| is_known(row.cross_check, row.accuracy));
    let largest = known.map(|row| row.cross_check).fold(0.0, f64::max);
    format!(
        "{table}\n{}\nErrors are of the mean power, relative to exponential Radau in f64 at tolerance {:.0e}, from \
         which the independent reference differs by at most {largest:.1e} where it is not chaotic. The cheapest choice is the coarsest \
         setting of a ladder of exponential Radau, TR-BDF2 or RK4 that meets the accuracy with the next finer one. \
         Run times are the shortest of several runs without energy ledger.\n",
        grid.summary.text(),
        REFERENCE_TOLERANCE,
    )
}

pub(crate) fn csv(grid: &Grid) -> String {
    Rows::of(&grid.rows).csv()
}

#[cfg(test)]
mod tests;
