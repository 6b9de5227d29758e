//! `closed-form`: mean power without a trajectory, and the map of its error.

use std::path::PathBuf;

use serde_json::json;

use super::files::{Outputs, make_folder};
use super::storage_voltage::StorageVoltage;
use super::sweep::picture::{self, Quantity, Words};
use super::sweep::{Axis, points_of, values};
use super::{NODE, Unused, check_overrides, print, progress};
use crate::closed_form::estimate;
use crate::closed_form::map::{Place, Point, Summary, map};
use crate::method::{Failure, Precision};
use crate::outcome::{Fields, Format, fields, rows_csv, text};
use crate::report::setting::with_unit;
use crate::scene_file::{self, Excitation, Load, Override, Scene};

/// Keys that a closed form does not use without the map.
const UNUSED: [Unused; 4] = [
    NODE,
    ("excitation.phase_rad", "a closed form is that of the steady motion; --map has trajectories"),
    ("run", "a closed form is that of the steady motion; --map has trajectories"),
    ("initial", "a closed form is that of the steady motion; --map has trajectories"),
];
/// The table of a map.
const TABLE: &str = "closed-form.csv";
/// Most points of a map.
const MOST: usize = 100_000;
/// An error below this is drawn as this.
const SMALLEST: f64 = 1e-6;

#[derive(Debug, Clone, clap::Args)]
pub struct ClosedFormArguments {
    /// Scene file
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Precision of the closed form
    #[arg(long, value_enum, default_value = "f64")]
    precision: Precision,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Another value for a key of the scene, such as load.resistance_ohm=1e6; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
    #[command(flatten)]
    storage_voltage: StorageVoltage,
    /// Compare with the trajectory over amplitude, frequency and load around the scene's own
    #[arg(long)]
    map: bool,
    /// Amplitudes of the map in m/s²; an eighth to twice the scene's
    #[arg(long, value_name = "FROM:TO:COUNT[:log]", requires = "map", value_parser = axis("amplitude_m_per_s2"))]
    amplitude: Option<Axis>,
    /// Frequencies of the map in Hz; 15 % to both sides of the scene's
    #[arg(long, value_name = "FROM:TO:COUNT[:log]", requires = "map", value_parser = axis("frequency_hz"))]
    frequency: Option<Axis>,
    /// Resistances of the map in Ω; a hundredth to ten times the scene's
    #[arg(long, value_name = "FROM:TO:COUNT[:log]", requires = "map", value_parser = axis("resistance_ohm"))]
    resistance: Option<Axis>,
    /// Points of the map at which the reference is run too, of those where the closed form holds
    #[arg(long, value_name = "COUNT", requires = "map", default_value_t = 4)]
    references: usize,
    /// Write closed-form.csv and a picture of the error for each resistance into this folder
    #[arg(long, value_name = "DIR", requires = "map")]
    output: Option<PathBuf>,
}

/// Reads an axis whose key is known.
fn axis(key: &'static str) -> impl Fn(&str) -> Result<Axis, String> + Clone + Send + Sync + 'static {
    move |text| {
        let axis: Axis =
            format!("{key}={text}").parse().map_err(|error: String| error.replace("KEY=", ""))?;
        let first = axis.value(0).min(axis.value(axis.count() - 1));
        if first > 0.0 { Ok(axis) } else { Err(format!("{first} must be above 0")) }
    }
}

/// Prints the closed form of the scene, or the map of its error.
pub fn run(arguments: &ClosedFormArguments) -> Result<(), Failure> {
    let mut scene = scene_file::read(&arguments.scene, &arguments.overrides)?;
    let unused: &[Unused] = if arguments.map { &[NODE] } else { &UNUSED };
    check_overrides(&arguments.overrides, &arguments.storage_voltage.unused(unused))?;
    arguments.storage_voltage.hold(&mut scene)?;
    let found = estimate(&scene, arguments.precision)?;
    if !arguments.map {
        let mut named = fields(&json!({ "scene": scene.name() }));
        named.extend(found.fields());
        return print(&text(&named, arguments.format));
    }
    let axes = axes(arguments, &scene)?;
    let places = places(&axes)?;
    let outputs = Outputs::of(&arguments.scene, &arguments.overrides)?;
    if let Some(folder) = &arguments.output {
        let pictures: Vec<String> = (0..axes[0].count()).map(picture_name).collect();
        let names: Vec<&str> = std::iter::once(TABLE).chain(pictures.iter().map(String::as_str)).collect();
        outputs.check_in("--output", folder, &names)?;
    }
    let bar = progress(places.len());
    let points = map(&scene, &places, arguments.precision, arguments.references, || bar.inc(1))?;
    bar.finish_and_clear();
    if let Some(folder) = &arguments.output {
        make_folder(folder)?;
        outputs.write(&folder.join(TABLE), &csv(&points))?;
        for (name, picture) in pictures(scene.name(), &axes, &points)? {
            outputs.write(&folder.join(name), &picture)?;
        }
    }
    print(&match arguments.format {
        Format::Table => report(&points),
        Format::Csv => csv(&points),
        Format::Json => json(&points),
    })
}

/// Resistance, amplitude and frequency, the last running fastest.
fn axes(arguments: &ClosedFormArguments, scene: &Scene) -> Result<[Axis; 3], Failure> {
    let (Excitation::Sine(tone), Load::Resistor { resistance_ohm }) = (&scene.excitation, scene.load) else {
        return Err(Failure::of_file(scene, "must have a sine and a resistor for a map"));
    };
    let around =
        |given: &Option<Axis>, option: &str, key, middle: f64, [low, high]: [f64; 2], count: &str| {
            let refused =
                |reason| Failure::of_file(scene, format!("{key} = {middle}: {reason}; give {option}"));
            match given {
                Some(axis) => Ok(axis.clone()),
                None => axis(key)(&format!("{}:{}:{count}", low * middle, high * middle)).map_err(refused),
            }
        };
    let ClosedFormArguments { resistance, amplitude, frequency, .. } = arguments;
    let (acceleration, hertz) = (tone.amplitude_m_per_s2, tone.frequency_hz);
    Ok([
        around(resistance, "--resistance", "resistance_ohm", resistance_ohm, [0.01, 10.0], "4:log")?,
        around(amplitude, "--amplitude", "amplitude_m_per_s2", acceleration, [0.125, 2.0], "9:log")?,
        around(frequency, "--frequency", "frequency_hz", hertz, [0.85, 1.15], "31")?,
    ])
}

fn places(axes: &[Axis; 3]) -> Result<Vec<Place>, Failure> {
    let count = points_of(axes).filter(|count| *count <= MOST);
    let refused = || Failure::Input(format!("--map: the map must have at most {MOST} points"));
    let place = |index| {
        let [resistance_ohm, amplitude_m_per_s2, frequency_hz] = values(axes, index)[..] else { return None };
        Some(Place { resistance_ohm, amplitude_m_per_s2, frequency_hz })
    };
    Ok((0..count.ok_or_else(refused)?).filter_map(place).collect())
}

/// Names and values of a point.
fn row(point: &Point) -> Fields {
    let power = |found: &Result<f64, String>| found.as_ref().ok().copied();
    let mut row = fields(&point.place);
    row.extend(point.estimate.fields());
    row.extend(fields(&json!({
        "trajectory_power_w": power(&point.trajectory),
        "error": point.error(),
        "reference_power_w": point.reference.as_ref().and_then(power),
        "failure": point.trajectory.as_ref().err(),
    })));
    row
}

fn csv(points: &[Point]) -> String {
    let rows: Vec<Fields> = points.iter().map(row).collect();
    rows_csv(rows.first().into_iter().flat_map(Fields::keys), &rows)
}

fn json(points: &[Point]) -> String {
    let rows: Vec<Fields> = points.iter().map(row).collect();
    format!("{:#}\n", json!({ "summary": Summary::of(points).fields(), "points": rows }))
}

/// The summary, and the points at which the reference was run.
fn report(points: &[Point]) -> String {
    let mut report = text(&Summary::of(points).fields(), Format::Table);
    for point in points {
        let Some(reference) = &point.reference else { continue };
        let Place { resistance_ohm, amplitude_m_per_s2, frequency_hz } = point.place;
        let power = |found: &Result<f64, String>| match found {
            Ok(power) => format!("{power:.5e} W"),
            Err(error) => error.clone(),
        };
        report += &format!(
            "at {resistance_ohm:.4e} ohm, {amplitude_m_per_s2:.4} m/s2, {frequency_hz:.4} Hz: closed form {:.5e} W, \
             trajectory {}, reference {}\n",
            point.estimate.mean_power_w,
            power(&point.trajectory),
            power(reference),
        );
    }
    report
}

/// The name of the picture for a resistance.
fn picture_name(index: usize) -> String {
    format!("closed-form-{index}.svg")
}

/// A picture for each resistance: the power of ten of the error where the closed form is claimed to hold.
fn pictures(scene: &str, axes: &[Axis; 3], points: &[Point]) -> Result<Vec<(String, String)>, Failure> {
    let [resistance, rest @ ..] = axes;
    let size = points.len() / resistance.count();
    let drawn = (0..resistance.count()).zip(points.chunks(size.max(1))).filter_map(|(index, points)| {
        let shown =
            |point: &Point| point.estimate.holds().then(|| point.error().clamp(SMALLEST, 1.0).log10());
        let quantity = Quantity {
            name: "log10 of the error of mean power",
            unit: "",
            values: points.iter().map(shown).collect(),
        };
        let load = with_unit(resistance.value(index), "Ω");
        let title = format!("{scene}, {load}: closed form against trajectory");
        let name = picture_name(index);
        let words = Words { title: &title, without: "a trajectory is needed", marked: (&[], "") };
        match picture::draw(words, rest, &[quantity]) {
            Ok(picture) => picture.map(|picture| Ok((name, picture))),
            Err(error) => Some(Err(Failure::Input(error))),
        }
    });
    drawn.collect()
}
