//! Pictures of the motion of runs: time histories, phase portrait, spectrum, energy flow; several runs compared.

mod energy;
mod series;

use std::path::Path;

pub(crate) use self::series::Series;

use crate::accuracy::has_own_steps;
use crate::method::{Failure, Math, Options, Precision};
use crate::name::Name;
use crate::report::Picture;
use crate::report::chart::{Axis, Chart, Curve, FITTING, Mark};
use crate::report::file::columns;
use crate::report::setting::{distinct_labels, number_and_unit, scaled, with_unit};
use crate::report::svg::{BLACK, COLOURS, range};
use crate::scene_file::{Excitation, Scene, Tone};

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum View {
    /// Quantities over time.
    History,
    /// Velocity over position.
    Phase,
    /// Amplitudes over frequency, in the measuring window.
    Spectrum,
    /// Where the energy of the base goes, over the whole run.
    Energy,
}

/// An axis of the spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum LogAxis {
    /// Frequency.
    X,
    /// Amplitude.
    Y,
    /// None.
    None,
}

#[derive(Debug, Clone)]
pub(crate) struct Wanted<'a> {
    pub(crate) title: &'a str,
    pub(crate) views: &'a [View],
    /// Columns of the time histories; the last is that of the spectrum.
    pub(crate) quantities: Vec<String>,
    /// First and last instant in s of time histories and phase portrait.
    pub(crate) span_s: [f64; 2],
    /// First and last instant in s of the spectrum.
    pub(crate) window_s: [f64; 2],
    /// The period of the excitation in s, of which the spectrum has whole numbers; `None` where it has no single one.
    pub(crate) period_s: Option<f64>,
    /// The last quantity of the first run at a tenth of its accuracy, by which the noise of the spectrum is known.
    pub(crate) coarse: Option<&'a Series>,
    /// Largest frequency in Hz of the spectrum.
    pub(crate) highest_hz: f64,
    /// Whether it goes up to there where nothing stands out.
    pub(crate) is_up_to_highest: bool,
    pub(crate) logarithmic: &'a [LogAxis],
}

/// Width of the picture, and heights of a time history and of a portrait or a spectrum.
const WIDTH: u32 = 1120;
const STRIP: u32 = 230;
const PANEL: u32 = 430;
/// Periods of the excitation that a time history shows, and rows in it.
const SHOWN_PERIODS: f64 = 6.0;
const SHOWN_ROWS: f64 = 3000.0;
/// Rows in a period of the excitation, whatever the span: a quarter of their rate is the highest line of a spectrum.
const ROWS_A_PERIOD: f64 = 4.0 * HARMONICS;
/// The same of the highest frequency of an excitation that has many.
const ROWS_OF_A_BAND: f64 = 16.0;
/// Most rows of a whole run.
const MOST_ROWS: f64 = 1e6;
/// Parts of a longer time history of which the lowest and the highest value are drawn.
const PARTS: usize = 4000;
/// Frequency of the highest line of a spectrum over that of the excitation.
const HARMONICS: f64 = 20.0;
/// Most impacts that are marked.
const MOST_MARKS: usize = 300;

/// What time histories show where nothing else is said: the last periods, or the last tenth of the window.
pub(crate) fn span_s(scene: &Scene) -> [f64; 2] {
    let end = scene.run.duration_s;
    let periods = scene.excitation.single_frequency().map(|frequency| SHOWN_PERIODS / frequency);
    let length = periods.unwrap_or(0.1 * scene.run.window_s()).min(scene.run.window_s());
    [end - length, end]
}

/// The distance in s of the rows for a picture of these instants.
pub(crate) fn every_s(scene: &Scene, [from, to]: [f64; 2]) -> f64 {
    let of_period = closest(scene).map_or(f64::INFINITY, |(frequency, rows)| 1.0 / (rows * frequency));
    ((to - from) / SHOWN_ROWS).min(of_period).max(scene.run.duration_s / MOST_ROWS).max(1e-9)
}

/// The highest frequency of the excitation in Hz, and the rows that its period should have.
fn closest(scene: &Scene) -> Option<(f64, f64)> {
    let highest = |tones: &[Tone]| tones.iter().map(|tone| tone.frequency_hz).fold(0.0, f64::max);
    let band = match &scene.excitation {
        Excitation::Sine(tone) => {
            return (tone.frequency_hz > 0.0).then_some((tone.frequency_hz, ROWS_A_PERIOD));
        }
        Excitation::Sines(tones) => highest(tones),
        Excitation::Random(random) => highest(&random.tones),
        Excitation::Burst(burst) => burst.frequency_hz(),
        Excitation::Sweep(sweep) => sweep.from_hz.max(sweep.to_hz),
        Excitation::File(_) | Excitation::Silence => return None,
    };
    (band > 0.0).then_some((band, ROWS_OF_A_BAND))
}

/// What a picture with rows at this distance in s does not show, where the run is too long for closer ones.
pub(crate) fn unresolved(scene: &Scene, every_s: f64) -> Option<String> {
    let (frequency, _) = closest(scene)?;
    let rows = 1.0 / (frequency * every_s);
    (rows < ROWS_OF_A_BAND).then(|| {
        format!(
            "{rows:.1} rows in a period of {frequency} Hz, because a run has at most {MOST_ROWS:e}: time histories, portrait \
             and spectrum do not show the motion; a shorter run.duration_s does"
        )
    })
}

/// The lowest and the highest value of each part of a time history that has more points than can be seen.
fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let length = points.len().div_ceil(PARTS);
    if length <= 2 {
        return points;
    }
    let of_part = |part: &[(f64, f64)]| {
        let by_value = |one: &&(f64, f64), other: &&(f64, f64)| one.1.total_cmp(&other.1);
        let ends = [part.iter().min_by(by_value), part.iter().max_by(by_value)];
        let mut ends: Vec<(f64, f64)> = ends.into_iter().flatten().copied().collect();
        ends.sort_by(|one, other| one.0.total_cmp(&other.0));
        ends
    };
    points.chunks(length).flat_map(of_part).collect()
}

/// The highest line of a spectrum in Hz, for rows at this distance in s.
pub(crate) fn highest_hz(scene: &Scene, every_s: f64) -> f64 {
    let aliased = 0.25 / every_s;
    scene.excitation.single_frequency().map_or(aliased, |frequency| (HARMONICS * frequency).min(aliased))
}

/// What `run --picture` draws of a scene, whose rows are at this distance in s.
pub(crate) fn usual<'a>(scene: &Scene, title: &'a str, series: &Series, every_s: f64) -> Wanted<'a> {
    Wanted {
        title,
        views: &[View::History, View::Phase, View::Spectrum, View::Energy],
        quantities: series.usual_quantities(),
        span_s: span_s(scene),
        window_s: [scene.run.settle_s, scene.run.duration_s],
        highest_hz: highest_hz(scene, every_s),
        is_up_to_highest: false,
        period_s: scene.excitation.single_frequency().map(f64::recip),
        coarse: None,
        logarithmic: &[LogAxis::Y],
    }
}

/// Accuracy of a run whose spectrum is drawn: errors of a step repeat with the impacts, and are lines of their own.
const OF_A_SPECTRUM: f64 = 1e-9;

/// The options of a run whose spectrum is drawn, and of the same at a tenth of its accuracy or in twice its steps; `None` where
/// the accuracy is given, or is no option of the scene.
pub(crate) fn of_spectrum(scene: &Scene, options: &Options) -> Option<[Options; 2]> {
    let is_given = options.tolerance.or(options.step_s).or(options.accuracy).is_some();
    let is_single = options.precision == Some(Precision::F32) || options.math == Some(Math::Micromath);
    if is_given || is_single {
        return None;
    }
    // A beam has steps of its own: half of them, and those.
    if scene.bump_stop().is_ok() {
        let all = [1, 0].map(|more| Options { halvings: options.halvings + more, ..*options });
        return has_own_steps(scene, options).then_some(all);
    }
    let all = [1.0, 10.0].map(|factor| Options { accuracy: Some(factor * OF_A_SPECTRUM), ..*options });
    all.iter().all(|options| options.check_scene(scene).is_ok()).then_some(all)
}

/// The title of a picture: file, method and parameters.
pub(crate) fn title(file: &Path, method: &str, setting: &str) -> String {
    let name = Name::of_file(file).line();
    format!("{name}, {method}: {setting}")
}

pub(crate) fn picture(wanted: &Wanted<'_>, series: &[Series]) -> Result<Picture, Failure> {
    let has = |view: View| wanted.views.contains(&view);
    let mut charts: Vec<Chart> = Vec::new();
    if has(View::History) {
        let quantities = wanted.quantities.iter().enumerate();
        charts.extend(quantities.map(|(index, name)| history(wanted, series, name, index == 0)));
    }
    match (has(View::Spectrum).then(|| lines(wanted, series)).flatten(), charts.last_mut()) {
        // A spectrum of one line would be an empty panel.
        (Some(spectrum), Some(last)) if !spectrum.note.is_empty() && last.note.is_empty() => {
            last.note = spectrum.note
        }
        (spectrum, _) => charts.extend(spectrum),
    }
    charts.extend(has(View::Phase).then(|| phase(wanted, series)).flatten());
    let figure = has(View::Energy).then(|| energy::flow(columns(WIDTH), series, COLOURS)).flatten();
    if charts.is_empty() && figure.is_none() {
        let reason = "the picture cannot be drawn: no run has what the views show";
        return Err(Failure::Input(reason.to_owned()));
    }
    Ok(Picture { title: wanted.title.to_owned(), width: WIDTH, charts, figure, text: String::new() })
}

/// The curve of each run with its name in a legend, which one run alone does not have.
fn curves<P: Iterator<Item = (f64, f64)>>(
    series: &[Series],
    width: f64,
    points: impl IntoIterator<Item = P>,
) -> Vec<Curve> {
    let name = |one: &Series| if series.len() > 1 { one.name.clone() } else { String::new() };
    Curve::distinct(&COLOURS, (Mark::line, width), series.iter().map(name).zip(points))
}

/// A quantity over time; the first of them marks the impacts of a run alone.
fn history(wanted: &Wanted<'_>, series: &[Series], column: &str, first: bool) -> Chart {
    let [from, to] = wanted.span_s;
    let within = |series: &Series| -> Vec<(f64, f64)> {
        series.over_time(column).into_iter().filter(|(time, _)| (from..=to).contains(time)).collect()
    };
    let all: Vec<Vec<(f64, f64)>> = series.iter().map(within).collect();
    let (word, unit) = number_and_unit(column);
    let (up, factor) = scaled(&word, unit, all.iter().flatten().map(|point| point.1));
    let scaled =
        |points: Vec<(f64, f64)>| thinned(points).into_iter().map(|(time, value)| (time, factor * value));
    let mut curves = curves(series, 1.4, all.into_iter().map(scaled));
    if let ([one], true) = (series, first) {
        let marks: Vec<(f64, f64)> = one
            .impacts_s
            .iter()
            .filter(|instant| (from..=to).contains(*instant))
            .filter_map(|instant| Some((*instant, factor * one.at(column, *instant)?)))
            .collect();
        if (1..=MOST_MARKS).contains(&marks.len()) {
            curves.push(Curve::new("impact", BLACK, Mark::point(0, 6.0), marks));
        }
    }
    let across = Axis::linear("time [s]", [from, to], 10);
    Chart::new("", across, Axis::linear(up, FITTING, 5), curves).grouped("time", STRIP)
}

/// Velocity over position; `None` if no run has both.
fn phase(wanted: &Wanted<'_>, series: &[Series]) -> Option<Chart> {
    let all: Vec<Vec<[f64; 3]>> = series.iter().map(|one| one.portrait(wanted.span_s)).collect();
    let values = |of: usize| all.iter().flatten().map(move |row| row[of]);
    let column = series.iter().find_map(Series::position)?;
    let (position, x_factor) = scaled(&number_and_unit(column).0, "m", values(1));
    let (velocity, y_factor) = scaled("velocity", "m/s", values(2));
    let scaled = all.iter().map(|points| points.iter().map(|[_, x, y]| (x_factor * x, y_factor * y)));
    let mut curves = curves(series, 1.1, scaled);
    for (curve, points) in curves.iter_mut().zip(&all) {
        curve.notes = points.iter().map(|[time, ..]| format!("time: {time:.6} s")).collect();
    }
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let span = range(points().map(|point| point.0)).into();
    points().next()?;
    let across = Axis::linear(position, span, 6);
    let up = Axis::linear(velocity, FITTING, 7);
    let chart = Chart::new("phase portrait", across, up, curves);
    Some(Chart { is_orbit: true, is_half: true, height: PANEL, ..chart })
}

/// The values of the time histories, of which the unit of a quantity is.
fn shown(wanted: &Wanted<'_>, series: &[Series], column: &str) -> impl Iterator<Item = f64> {
    let [from, to] = wanted.span_s;
    let points = series.iter().flat_map(move |one| one.over_time(column));
    points.filter(move |(time, _)| (from..=to).contains(time)).map(|point| point.1)
}

/// Amplitudes over frequency of the last quantity, with a note where there is one line alone; `None` without rows in the window.
fn lines(wanted: &Wanted<'_>, series: &[Series]) -> Option<Chart> {
    let column = wanted.quantities.last()?;
    let has = |axis: LogAxis| wanted.logarithmic.contains(&axis);
    let of = |one: &Series| {
        series::amplitudes(&one.over_time(column), wanted.window_s, wanted.highest_hz, wanted.period_s)
    };
    let mut all: Vec<Vec<(f64, f64)>> = series.iter().map(of).collect();
    let most = all.iter().flatten().max_by(|one, other| one.1.total_cmp(&other.1));
    let (strongest, largest) = most.copied().filter(|(_, largest)| *largest > 0.0)?;
    let (word, unit) = number_and_unit(column);
    let (name, factor) = scaled(&word, unit, shown(wanted, series, column).chain([largest]));
    // Below a millionth of the largest line there is rounding.
    let floor = 1e-6 * factor * largest;
    // A harmonic and the lines beside it, by the window, are no noise.
    let apart = all[0].get(1).map_or(f64::INFINITY, |line| 4.0 * line.0);
    let is_noise = |frequency: f64| {
        let period = wanted.period_s.unwrap_or(0.0);
        (frequency * period - (frequency * period).round()).abs() > apart * period || period == 0.0
    };
    // Within a few periods every line is beside a harmonic.
    let coarse = wanted.coarse.filter(|_| all[0].iter().any(|line| is_noise(line.0)));
    let noise = coarse.map(|coarse| {
        let both = all[0].iter().zip(of(coarse)).filter(|(line, _)| is_noise(line.0));
        both.map(|(fine, coarse)| (fine.1 - coarse.1).abs()).fold(0.0, f64::max)
    });
    let is_seen = |line: &(f64, f64)| factor * line.1 > floor;
    let is_peak = |near: &&[(f64, f64)]| is_seen(&near[1]) && near[1].1 > near[0].1 && near[1].1 >= near[2].1;
    let is_one = series.len() == 1 && all[0].windows(3).filter(is_peak).count() == 1;
    // Under a sine the line is a harmonic, beside which its place is off by the distance of the times.
    let at = wanted.period_s.map_or(strongest, |period| (strongest * period).round() / period);
    let words = format!("{word} spectrum: {} at {} alone", with_unit(largest, unit), with_unit(at, "Hz"));
    let note = if is_one { words } else { String::new() };
    let last = all.iter().flatten().filter(|line| is_seen(line)).map(|line| line.0).fold(0.0, f64::max);
    let end = if wanted.is_up_to_highest { f64::INFINITY } else { 1.2 * last };
    all.iter_mut().for_each(|points| points.retain(|line| line.0 <= end));
    let scaled = all.iter().map(|points| {
        let points = points.iter().filter(|(frequency, _)| *frequency > 0.0 || !has(LogAxis::X));
        points.map(|(frequency, value)| (*frequency, (factor * value).max(floor)))
    });
    let mut curves = curves(series, 1.1, scaled);
    let frequencies = || curves.iter().flat_map(|curve| &curve.points).map(|point| point.0);
    // The last line is whole.
    let ends = [frequencies().fold(f64::INFINITY, f64::min), 1.02 * frequencies().fold(0.0, f64::max)];
    let across = Axis::scaled(has(LogAxis::X), "frequency [Hz]", ends);
    if let Some(noise) = noise {
        let level = (factor * noise).max(floor);
        let name = noise_floor(noise, largest, unit);
        curves.push(Curve::new(name, BLACK, Mark::line(1, 1.2), ends.map(|frequency| (frequency, level))));
    }
    let bottom = if has(LogAxis::Y) { 0.5 * floor } else { 0.0 };
    let up = Axis::scaled(has(LogAxis::Y), name, [bottom, 1.3 * factor * largest]);
    let chart = Chart::new("spectrum: amplitude of each line", across, up, curves);
    Some(Chart { note, is_half: true, height: PANEL, ..chart })
}

/// The noise floor of a spectrum in words, beside its largest line.
fn noise_floor(noise: f64, largest: f64, unit: &str) -> String {
    let words = if noise <= 1e-6 * largest {
        ": below"
    } else if noise <= 1e-3 * largest {
        ":"
    } else {
        // Runs of a chaotic or chattering motion part from each other, however accurate they are.
        ", by two runs that part:"
    };
    format!("noise floor of a line{words} {}", distinct_labels(&[noise.max(1e-6 * largest)], unit).concat())
}

#[cfg(test)]
mod tests;
