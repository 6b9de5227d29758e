//! `stop`: what the stop of a bump-stop scene saves in bending at the clamp, and what it costs in power.

use comfy_table::presets;
use serde_json::{Value, json};

use super::sweep::{Axis, check_axes, values};
use super::{NODE, SceneArguments, check_keys, print, warn, with_progress};
use crate::accuracy::run_with_steps;
use crate::method::{Failure, Method, Options};
use crate::outcome::{self, Fields, Outcome, number};
use crate::rows::{Column, Digits, Rows};
use crate::run::{run_scene, try_each};
use crate::scene_file::{self, Model, Override, Scene, contains};

/// Numbers of a run that are compared with those without the stop, and the part by which the stop lowers each.
const COMPARED: [[&str; 2]; 5] = [
    ["clamp_stress_peak_pa", "clamp_stress_peak_saved"],
    ["clamp_stress_rms_pa", "clamp_stress_rms_saved"],
    ["clamp_stress_largest_range_pa", "clamp_stress_largest_range_saved"],
    ["clamp_stress_equivalent_range_pa", "clamp_stress_equivalent_range_saved"],
    ["mean_power_w", "mean_power_lost"],
];

#[derive(Debug, Clone, clap::Args)]
pub struct StopArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Values for a key of the scene, such as stop.gap_m; repeat it for a grid
    #[arg(long = "over", value_name = "KEY=FROM:TO:COUNT[:log]")]
    axes: Vec<Axis>,
    /// Run each point once only, in the default steps: without the error of the mean power and the changes by half the step
    #[arg(long)]
    no_accuracy: bool,
}

/// A run, with the stop or without, at some values of the axes.
struct Row {
    /// The value of each axis; none of an axis of the stop where there is no stop.
    values: Vec<Option<f64>>,
    with_stop: bool,
    scene: Scene,
    numbers: Fields,
    warnings: Vec<String>,
}

impl Row {
    fn new(values: Vec<Option<f64>>, with_stop: bool, scene: Scene) -> Self {
        Self { values, with_stop, scene, numbers: Fields::new(), warnings: Vec::new() }
    }

    /// The numbers and the warnings of the scene, run with the accuracy statement of `run`, and in half the steps for what the
    /// numbers of the bending change: the statement is of the mean power alone.
    fn ran(&self, options: &Options, no_accuracy: bool) -> Result<(Fields, Vec<String>), Failure> {
        if no_accuracy {
            return Ok((numbers(&run_scene(&self.scene, options)?)?, Vec::new()));
        }
        let (outcome, chosen) = run_with_steps(&self.scene, options)?;
        let mut found = numbers(&outcome)?;
        let halved = Options { halvings: chosen.halvings + 1, ..chosen };
        // The reference has no step to halve. A run in half the steps that fails leaves the changes unknown.
        let finer =
            (chosen.method != Method::Reference).then(|| run_scene(&self.scene, &halved).ok()).flatten();
        let finer = finer.map_or_else(|| Ok(Fields::new()), |finer| numbers(&finer))?;
        let changes: Vec<(String, Value)> = found
            .iter()
            .filter(|(name, _)| name.contains("stress"))
            .map(|(name, value)| {
                let finer = finer.get(name).and_then(Value::as_f64);
                let change = value.as_f64().zip(finer).and_then(|(value, finer)| relative(value, finer));
                (changed(name), json!(change))
            })
            .collect();
        found.extend(changes);
        found.insert(POWER_ERROR.to_owned(), json!(outcome.accuracy.total));
        Ok((found, outcome.warnings))
    }

    /// The values of the axes, and whether there is a stop.
    fn place(&self, axes: &[Axis]) -> String {
        let values = axes.iter().zip(&self.values);
        let named =
            values.filter_map(|(axis, value)| Some(format!("{} = {}, ", axis.key, number((*value)?))));
        format!(
            "{}{}",
            named.collect::<String>(),
            if self.with_stop { "with the stop" } else { "without a stop" }
        )
    }
}

/// Key of the estimated relative error of the mean power.
const POWER_ERROR: &str = "mean_power_error";

/// Key of the relative change of a number in half the steps.
fn changed(name: &str) -> String {
    format!("{name}_change")
}

/// The relative change from one value to another; 0 if both are 0, `None` of 0 to another.
fn relative(from: f64, to: f64) -> Option<f64> {
    if from == to { Some(0.0) } else { Some(to / from - 1.0).filter(|change| change.is_finite()) }
}

/// Runs the scene with its stop and without it at each point, and prints the comparison.
pub(super) fn run(arguments: &StopArguments) -> Result<(), Failure> {
    let StopArguments { scene: SceneArguments { options, .. }, axes, no_accuracy } = arguments;
    options.check()?;
    let count = check_axes(axes)?;
    let overrides = arguments.scene.overrides.iter().map(|change| ("--set", change.key()));
    let keys = overrides.chain(axes.iter().map(|axis| ("--over", axis.key.as_str())));
    check_keys(&keys.collect::<Vec<_>>(), &[NODE])?;
    let mut rows = rows(arguments, count)?;
    // The accuracy statement holds an accuracy by the steps.
    let accuracy = options.accuracy.filter(|_| *no_accuracy);
    for row in &rows {
        Options { accuracy, ..*options }.check_scene(&row.scene)?;
    }
    let found = with_progress("points", rows.len(), |bar| {
        try_each(&rows, |row| {
            let ran = row.ran(options, *no_accuracy);
            bar.inc(1);
            ran
        })
    })?;
    for (row, found) in rows.iter_mut().zip(found) {
        (row.numbers, row.warnings) = found;
        row.warnings.iter().for_each(|warning| warn(&format!("{}: {warning}", row.place(axes))));
    }
    let rows = Rows(rows.iter().map(|row| fields(axes, row, &rows)).collect());
    print(&rows.text(arguments.scene.format, |rows| table(axes, rows)))
}

/// The runs without a stop, then those with it. Points that differ in the stop only have one run without it.
fn rows(arguments: &StopArguments, count: usize) -> Result<Vec<Row>, Failure> {
    let axes = &arguments.axes;
    let (mut free, mut stopped): (Vec<Row>, Vec<Row>) = (Vec::new(), Vec::new());
    for index in 0..count {
        let values = values(axes, index);
        let mut overrides = arguments.scene.overrides.clone();
        overrides.extend(
            axes.iter().zip(&values).map(|(axis, at)| Override::new(&axis.key, &number(*at)).by("--over")),
        );
        let scene = scene_file::read(&arguments.scene.scene, &overrides)?;
        let shared = without_stop(axes, &values);
        if !free.iter().any(|row| row.values == shared) {
            free.push(Row::new(shared, false, unstopped(&scene)?));
        }
        let values = values.into_iter().map(Some).collect();
        stopped.push(Row::new(values, true, scene));
    }
    free.extend(stopped);
    Ok(free)
}

/// The values of the axes that are not of the stop.
fn without_stop(axes: &[Axis], values: &[f64]) -> Vec<Option<f64>> {
    let shared = |(axis, value): (&Axis, &f64)| (!contains("stop", &axis.key)).then_some(*value);
    axes.iter().zip(values).map(shared).collect()
}

fn unstopped(scene: &Scene) -> Result<Scene, Failure> {
    let mut scene = scene.clone();
    let Model::BumpStop(model) = &mut scene.model else {
        return Err(Failure::of_file(&scene, "must be a bump-stop scene here"));
    };
    if model.stop.take().is_none() {
        return Err(Failure::of_file(&scene, "stop: is missing; there is nothing to compare"));
    }
    model.initial.rod_modal_displacement.clear();
    model.initial.rod_modal_velocity.clear();
    Ok(scene)
}

/// The numbers of a run that are printed. Fails if the method does not measure the bending.
fn numbers(outcome: &Outcome) -> Result<Fields, Failure> {
    let particular = outcome.bump_stop();
    let Some(clamp) = particular.and_then(|found| found.clamp) else {
        return Err(Failure::Input("--method: this method does not measure the bending".to_owned()));
    };
    let mut numbers = outcome::fields(&clamp);
    numbers.retain(|name, _| name.contains("stress"));
    numbers.insert("mean_power_w".to_owned(), json!(outcome.mean_power_w));
    let contacts = particular.and_then(|found| found.contacts_per_period);
    numbers.insert("contacts_per_period".to_owned(), json!(contacts));
    Ok(numbers)
}

/// A row with what the stop saves and costs: parts of the values without it, `null` in the row without it and where these values are 0.
fn fields(axes: &[Axis], row: &Row, rows: &[Row]) -> Fields {
    let keys = axes.iter().map(|axis| axis.key.clone());
    let mut fields: Fields = keys.zip(row.values.iter().map(|value| json!(value))).collect();
    fields.insert("with_stop".to_owned(), row.with_stop.into());
    fields.extend(row.numbers.clone());
    let values: Vec<f64> = row.values.iter().map(|value| value.unwrap_or(f64::NAN)).collect();
    let shared = without_stop(axes, &values);
    let free = rows.iter().find(|other| row.with_stop && !other.with_stop && other.values == shared);
    for [name, part] in COMPARED {
        let saved = free.and_then(|free| {
            let [without, with] = [free, row].map(|row| row.numbers.get(name).and_then(Value::as_f64));
            without.filter(|without| *without != 0.0).zip(with).map(|(without, with)| 1.0 - with / without)
        });
        fields.insert(part.to_owned(), json!(saved));
    }
    fields
}

const COLUMNS: [Column<'_>; 12] = [
    ("stop", "with_stop", Digits::Choice(["none", "yes"])),
    ("peak MPa", "clamp_stress_peak_pa", Digits::Fixed(1e-6, 3)),
    ("RMS MPa", "clamp_stress_rms_pa", Digits::Fixed(1e-6, 3)),
    ("cycles", "clamp_stress_cycles", Digits::Fixed(1.0, 1)),
    ("equivalent MPa", "clamp_stress_equivalent_range_pa", Digits::Fixed(1e-6, 3)),
    ("power uW", "mean_power_w", Digits::Fixed(1e6, 3)),
    ("contacts/period", "contacts_per_period", Digits::Fixed(1.0, 2)),
    ("peak saved %", "clamp_stress_peak_saved", Digits::Fixed(100.0, 1)),
    ("RMS %", "clamp_stress_rms_saved", Digits::Fixed(100.0, 1)),
    ("range %", "clamp_stress_largest_range_saved", Digits::Fixed(100.0, 1)),
    ("equivalent %", "clamp_stress_equivalent_range_saved", Digits::Fixed(100.0, 1)),
    ("power lost %", "mean_power_lost", Digits::Fixed(100.0, 1)),
];

/// Columns of the table of what is known of the numbers, all in per cent: heading and number, of the power its error.
const CHANGES: [(&str, &str); 5] = [
    ("peak %", "clamp_stress_peak_pa"),
    ("RMS %", "clamp_stress_rms_pa"),
    ("largest range %", "clamp_stress_largest_range_pa"),
    ("cycles %", "clamp_stress_cycles"),
    ("equivalent %", "clamp_stress_equivalent_range_pa"),
];

fn table(axes: &[Axis], rows: &Rows) -> String {
    let behind = |columns: &[Column<'_>]| {
        let keys = axes.iter().map(|axis| (axis.key.as_str(), axis.key.as_str(), Digits::Exponent(4)));
        let all: Vec<Column<'_>> = keys.chain(columns.iter().copied()).collect();
        rows.table(presets::NOTHING, &all, axes.len() + 1)
    };
    let numbers = behind(&COLUMNS);
    if !rows.0.iter().any(|row| row.contains_key(POWER_ERROR)) {
        return numbers;
    }
    let keys = CHANGES.map(|(_, key)| changed(key));
    let mut columns = vec![COLUMNS[0]];
    columns.extend(CHANGES.iter().zip(&keys).map(|((heading, _), key)| (*heading, &**key, PER_CENT)));
    columns.push(("power's error %", POWER_ERROR, PER_CENT));
    format!(
        "{numbers}\nChange in half the steps, and the estimated error of the mean power\n\n{}",
        behind(&columns)
    )
}

const PER_CENT: Digits = Digits::Fixed(100.0, 3);
