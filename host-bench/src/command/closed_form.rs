//! `closed-form`: mean power without a trajectory, and the map of its error.

use std::path::PathBuf;

use serde_json::{Map, Value};

use super::sweep::Axis;
use super::sweep::picture::{self, Quantity};
use super::{make_folder, print, progress, write_whole};
use crate::closed_form::map::{Means, Place, Point, Summary, map};
use crate::closed_form::{Estimate, estimate};
use crate::method::{Failure, Precision};
use crate::outcome::{Format, cell, csv_line, text};
use crate::scene_file::{self, Excitation, Load, Override, Scene};

/// Most points of a map.
const MOST: usize = 100_000;
/// An error below this is drawn as this.
const SMALLEST: f64 = 1e-6;

/// Arguments of `closed-form`.
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
    /// Another value for a key of the scene, such as run.duration_s=5; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<Override>,
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
///
/// # Errors
/// Bad input.
pub fn run(arguments: &ClosedFormArguments) -> Result<(), Failure> {
    let scene = scene_file::read(&arguments.scene, &arguments.overrides)?;
    let found = estimate(&scene, arguments.precision)?;
    if !arguments.map {
        let mut fields = vec![("scene".to_owned(), Value::from(scene.name()))];
        fields.extend(found.fields());
        return print(&text(fields, arguments.format));
    }
    let axes = axes(arguments, &scene)?;
    let places = places(&axes)?;
    let bar = progress(places.len());
    let means = Means { precision: arguments.precision, references: arguments.references };
    let points = map(&scene, &places, means, || bar.inc(1))?;
    bar.finish_and_clear();
    if let Some(folder) = &arguments.output {
        make_folder(folder)?;
        write_whole(&folder.join("closed-form.csv"), &csv(&points))?;
        for (name, picture) in pictures(scene.name(), &axes, &points)? {
            write_whole(&folder.join(name), &picture)?;
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
            let default = || {
                let refused =
                    |reason| Failure::of_file(scene, format!("{key} = {middle}: {reason}; give {option}"));
                axis(key)(&format!("{}:{}:{count}", low * middle, high * middle)).map_err(refused)
            };
            given.clone().map_or_else(default, Ok)
        };
    Ok([
        around(
            &arguments.resistance,
            "--resistance",
            "resistance_ohm",
            resistance_ohm,
            [0.01, 10.0],
            "4:log",
        )?,
        around(
            &arguments.amplitude,
            "--amplitude",
            "amplitude_m_per_s2",
            tone.amplitude_m_per_s2,
            [0.125, 2.0],
            "9:log",
        )?,
        around(&arguments.frequency, "--frequency", "frequency_hz", tone.frequency_hz, [0.85, 1.15], "31")?,
    ])
}

fn places([resistance, amplitude, frequency]: &[Axis; 3]) -> Result<Vec<Place>, Failure> {
    let count = resistance.count().checked_mul(amplitude.count());
    let count = count.and_then(|count| count.checked_mul(frequency.count()));
    if count.is_none_or(|count| count > MOST) {
        return Err(Failure::Input(format!("--map: the map must have at most {MOST} points")));
    }
    let mut places = Vec::new();
    for one in 0..resistance.count() {
        for two in 0..amplitude.count() {
            for three in 0..frequency.count() {
                places.push(Place {
                    resistance_ohm: resistance.value(one),
                    amplitude_m_per_s2: amplitude.value(two),
                    frequency_hz: frequency.value(three),
                });
            }
        }
    }
    Ok(places)
}

/// Names and values of a point.
fn fields(point: &Point) -> Vec<(String, Value)> {
    let power = |found: &Result<f64, String>| found.as_ref().ok().copied();
    let own: [(&str, Value); 3] = [
        ("resistance_ohm", point.place.resistance_ohm.into()),
        ("amplitude_m_per_s2", point.place.amplitude_m_per_s2.into()),
        ("frequency_hz", point.place.frequency_hz.into()),
    ];
    let compared: [(&str, Value); 4] = [
        ("trajectory_power_w", power(&point.trajectory).into()),
        ("error", Some(point.error()).filter(|error| error.is_finite()).into()),
        ("reference_power_w", point.reference.as_ref().and_then(power).into()),
        ("failure", point.trajectory.as_ref().err().map(String::as_str).into()),
    ];
    let named = |(name, value): (&str, Value)| (name.to_owned(), value);
    let estimate = Estimate::fields(&point.estimate);
    own.map(named).into_iter().chain(estimate).chain(compared.map(named)).collect()
}

fn csv(points: &[Point]) -> String {
    let rows: Vec<Vec<(String, Value)>> = points.iter().map(fields).collect();
    let heading = rows.first().into_iter().flatten().map(|(name, _)| name.clone());
    let lines = rows.iter().map(|row| csv_line(row.iter().map(|(_, value)| cell(value))));
    csv_line(heading) + &lines.collect::<String>()
}

fn json(points: &[Point]) -> String {
    let object = |fields: Vec<(String, Value)>| Value::Object(fields.into_iter().collect::<Map<_, _>>());
    let all = [
        ("summary".to_owned(), object(Summary::of(points).fields())),
        ("points".to_owned(), points.iter().map(|point| object(fields(point))).collect()),
    ];
    format!("{:#}\n", object(all.to_vec()))
}

/// The summary, and the points at which the reference was run.
fn report(points: &[Point]) -> String {
    let mut report = text(Summary::of(points).fields(), Format::Table);
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

/// A picture for each resistance: the power of ten of the error where the closed form is claimed to hold.
fn pictures(scene: &str, axes: &[Axis; 3], points: &[Point]) -> Result<Vec<(String, String)>, Failure> {
    let [resistance, rest @ ..] = axes;
    let size = points.len() / resistance.count();
    let drawn = (0..resistance.count()).zip(points.chunks(size.max(1))).filter_map(|(index, points)| {
        let shown =
            |point: &Point| point.estimate.holds().then(|| point.error().clamp(SMALLEST, 1.0).log10());
        let quantity =
            Quantity { name: "log10 of the error of mean power", values: points.iter().map(shown).collect() };
        let title = format!("{scene}, {:.3e} ohm: closed form against trajectory", resistance.value(index));
        let name = format!("closed-form-{index}.svg");
        match picture::draw(&title, rest, &[quantity]) {
            Ok(picture) => picture.map(|picture| Ok((name, picture))),
            Err(error) => Some(Err(Failure::Input(error))),
        }
    });
    drawn.collect()
}
