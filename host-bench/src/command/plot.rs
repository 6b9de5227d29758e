//! `plot`: the motion of one run or of several, as a picture.

use std::path::PathBuf;

use super::files::{Outputs, make_folder, report_folder};
use super::{FileArguments, NODE, Watch, check_keys, is_called, note, print, warn};
use crate::accuracy::{Statements, print_warnings};
use crate::method::{Failure, Options};
use crate::motion::{self, LogAxis, Series, View, Wanted};
use crate::outcome::{Fields, Format, text};
use crate::report::Picture;
use crate::report::setting::{exact_label, margin, named, setting, words_and_unit};
use crate::run::run_scene;
use crate::scene_file::{self, Override, Scene, finite_number_in};

/// The picture in the folder of reports.
const PLOT: &str = "plot.svg";
/// Most runs that are compared.
const MOST_RUNS: usize = 6;

/// A key and the values at which runs are compared.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Compared {
    key: String,
    values: Vec<String>,
}

impl std::str::FromStr for Compared {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts = text.split_once('=').map(|(key, values)| (key.trim(), values.split(',').map(str::trim)));
        match parts {
            Some((key, values)) if !key.is_empty() && values.clone().all(|value| !value.is_empty()) => {
                Ok(Self { key: key.to_owned(), values: values.map(str::to_owned).collect() })
            }
            _ => Err("must be KEY=VALUE,VALUE, for example load.resistance_ohm=1e6,1e8".to_owned()),
        }
    }
}

#[derive(Debug, Clone, clap::Args)]
pub struct PlotArguments {
    #[command(flatten)]
    scene: FileArguments,
    /// Traces to draw beside the run, as run --trace writes them
    #[arg(value_name = "TRACE.csv")]
    traces: Vec<PathBuf>,
    #[command(flatten)]
    options: Options,
    /// A run for each of these values of a key, beside each other
    #[arg(long, value_name = "KEY=VALUE,VALUE…")]
    compare: Option<Compared>,
    /// What to show, separated by commas [default: all]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "VIEW")]
    view: Vec<View>,
    /// Columns of the time histories, separated by commas; the spectrum is that of the last [default: position, force, power, voltage]
    #[arg(long, value_delimiter = ',', value_name = "COLUMN")]
    quantity: Vec<String>,
    /// First instant in s of time histories and phase portrait [default: six periods before the end]
    #[arg(long, value_name = "S", value_parser = finite_number_in("s", "S"))]
    from: Option<f64>,
    /// Their last instant in s [default: the end of the run]
    #[arg(long, value_name = "S", value_parser = finite_number_in("s", "S"))]
    to: Option<f64>,
    /// Highest frequency in Hz of the spectrum [default: where nothing follows, at most 20 times that of the excitation]
    #[arg(long, value_name = "HZ", value_parser = finite_number_in("Hz", "HZ"))]
    highest: Option<f64>,
    /// Logarithmic axes of the spectrum, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', value_name = "AXIS", default_value = "y")]
    log: Vec<LogAxis>,
    /// Write the picture to this file, or to an .html file a page with zoom and hover [default: report/plot.svg]
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Runs the scene, at each value that is compared, and draws the runs beside the traces. A caller in this process gets the
/// picture as SVG and as a page, with what the runs state, as JSON.
pub(super) fn run(arguments: &PlotArguments) -> Result<(), Failure> {
    let outputs = Outputs::of(&arguments.scene.scene, &arguments.scene.overrides)?.and(&arguments.traces);
    let file = arguments.output.clone().unwrap_or_else(|| report_folder().join(PLOT));
    let check = || match &arguments.output {
        Some(file) => outputs.check_picture("--output", [file]),
        None if is_called() => Ok(()),
        None => outputs.check_in("", &report_folder(), &[PLOT]),
    };
    let (picture, mut stated) = drawn(arguments, check)?;
    if is_called() {
        stated
            .extend([("svg".to_owned(), picture.svg()?.into()), ("page".to_owned(), picture.page()?.into())]);
        return print(&text(&stated, Format::Json));
    }
    let picture = picture.of_file(&file)?;
    if arguments.output.is_none() {
        make_folder(&report_folder())?;
    }
    outputs.write(&file, &picture)?;
    note("each run once, without an accuracy statement: `run` has one");
    print(&format!("{}\n", file.display()))
}

/// The picture, and what the runs state; `check` looks at the files before they begin.
fn drawn(
    arguments: &PlotArguments,
    check: impl FnOnce() -> Result<(), Failure>,
) -> Result<(Picture, Fields), Failure> {
    let compared = arguments.compare.as_ref();
    let keys = arguments.scene.overrides.iter().map(|change| ("--set", change.key()));
    let keys: Vec<(&str, &str)> = keys.chain(compared.map(|one| ("--compare", one.key.as_str()))).collect();
    check_keys(&keys, &[NODE])?;
    let scenes = scenes(arguments)?;
    let (_, first) =
        scenes.first().ok_or_else(|| Failure::Input("--compare: must have a value".to_owned()))?;
    let span_s = span(arguments, first)?;
    let every_s = motion::every_s(first, span_s);
    if let Some(text) = motion::unresolved(first, every_s) {
        warn(&text);
    }
    let options = Options { trace_every_s: Some(every_s), ..arguments.options };
    options.check()?;
    let traces: Vec<Series> =
        arguments.traces.iter().map(|file| Series::read(file)).collect::<Result<_, _>>()?;
    check()?;
    let watch = Watch::new();
    let (mut series, mut method) = (Vec::new(), String::new());
    let (mut smallest, mut stated) = (Vec::new(), Statements::default());
    let has_spectrum = arguments.view.is_empty() || arguments.view.contains(&View::Spectrum);
    let of_spectrum = |scene| has_spectrum.then(|| motion::of_spectrum(scene, &options)).flatten();
    let mut coarse = None;
    for (name, scene) in &scenes {
        let accurate = of_spectrum(scene);
        if let (true, Some([_, tenth])) = (series.is_empty(), accurate) {
            coarse = run_scene(scene, &tenth).ok().map(|outcome| Series::of(name.as_str(), scene, &outcome));
        }
        let options = accurate.map_or(options, |[accurate, _]| accurate);
        let outcome = run_scene(scene, &options).map_err(|failure| failure.of_case(name))?;
        series.push(Series::of(name.as_str(), scene, &outcome));
        smallest.extend(named(&outcome.margins));
        stated.add(&outcome);
        method = outcome.method;
    }
    drop(watch);
    series.extend(traces);
    let words = setting(first, compared.map(|one| one.key.as_str()).as_slice()) + &margin(smallest);
    let title = motion::title(&arguments.scene.scene, &method, &words);
    let usual = motion::usual(first, &title, &series[0], every_s);
    let wanted = Wanted {
        views: if arguments.view.is_empty() { usual.views } else { &arguments.view },
        quantities: quantities(arguments, &series, &usual)?,
        span_s,
        highest_hz: arguments.highest.unwrap_or(usual.highest_hz),
        is_up_to_highest: arguments.highest.is_some(),
        logarithmic: &arguments.log,
        coarse: coarse.as_ref(),
        ..usual
    };
    let stated = stated.fields(&[]);
    print_warnings(&stated);
    Ok((motion::picture(&wanted, &series)?, stated))
}

fn scenes(arguments: &PlotArguments) -> Result<Vec<(String, Scene)>, Failure> {
    let Some(Compared { key, values }) = &arguments.compare else {
        let scene = scene_file::read(&arguments.scene.scene, &arguments.scene.overrides)?;
        return Ok(vec![("run".to_owned(), scene)]);
    };
    if values.len() > MOST_RUNS {
        return Err(Failure::Input(format!(
            "--compare {key}: {} values, must be at most {MOST_RUNS}",
            values.len()
        )));
    }
    let file = &arguments.scene.scene;
    let read = |value: &String| {
        let last = std::iter::once(Override::new(key, value).by("--compare"));
        let overrides: Vec<Override> = arguments.scene.overrides.iter().cloned().chain(last).collect();
        Ok((scene_file::number_at(file, &overrides, key)?, scene_file::read(file, &overrides)?))
    };
    let found: Vec<(Option<f64>, Scene)> = values.iter().map(read).collect::<Result<_, Failure>>()?;
    let (words, unit) = words_and_unit(key);
    let named = values.iter().zip(found).map(|(text, (number, scene))| {
        let label = number.map_or_else(|| text.clone(), |number| exact_label(number, &unit));
        (format!("{words} = {label}"), scene)
    });
    Ok(named.collect())
}

/// First and last instant that are shown.
fn span(arguments: &PlotArguments, scene: &Scene) -> Result<[f64; 2], Failure> {
    let [from, to] = motion::span_s(scene);
    let to = arguments.to.unwrap_or(if arguments.from.is_some() { scene.run.duration_s } else { to });
    let from = arguments.from.unwrap_or(from.min(to));
    let end = scene.run.duration_s;
    if !(0.0..end).contains(&from) {
        return Err(Failure::Input(format!(
            "--from {from}: must be from 0 to the end of the run at {end} s"
        )));
    }
    if !(to > from && to <= end) {
        return Err(Failure::Input(format!(
            "--to {to}: must be after {from} s, at most the end of the run at {end} s"
        )));
    }
    if let Some(highest) = arguments.highest.filter(|highest| !(1e-3..=1e6).contains(highest)) {
        return Err(Failure::Input(format!("--highest {highest}: must be from 1e-3 to 1e6 Hz")));
    }
    Ok([from, to])
}

/// The columns to show, each of which a run must have.
fn quantities(
    arguments: &PlotArguments,
    series: &[Series],
    usual: &Wanted<'_>,
) -> Result<Vec<String>, Failure> {
    if arguments.quantity.is_empty() {
        return Ok(usual.quantities.clone());
    }
    let known = series.iter().flat_map(|one| one.columns());
    for name in &arguments.quantity {
        if !known.clone().any(|column| column == name) {
            let all = series[0].columns().join(", ");
            return Err(Failure::Input(format!("--quantity {name}: is no column; columns are {all}")));
        }
    }
    Ok(arguments.quantity.clone())
}
