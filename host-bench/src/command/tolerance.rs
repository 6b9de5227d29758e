//! `tolerance`: how a number of the result spreads where keys vary from part to part.

mod sampling;
mod statistics;

use std::path::PathBuf;

use comfy_table::presets;
use serde_json::{Value, json};

pub(super) use self::sampling::Varied;
use self::sampling::{Correlation, GENERATOR, Sampling, correlation};
use self::statistics::{Sensitivity, percentile, ranks, sensitivities, wilson};
use super::count;
use super::sweep::points::{Done, Point, PointArguments, Points};
use super::sweep::warnings;
use crate::accuracy::print_warnings;
use crate::method::Failure;
use crate::optimise::check_quantity;
use crate::outcome::{Fields, Format, fields, flattened, folded, small, text};
use crate::report::chart::{Axis, Chart, Curve, FITTING, Mark};
use crate::report::setting::{distinct_labels, exact_label, label, number_and_unit, scaled, words_and_unit};
use crate::report::svg::{BLACK, BLUE, GREEN, VERMILION, range};
use crate::report::{Picture, terminal};
use crate::rows::{Digits, Rows};
use crate::scene_file::finite_number_in;
use crate::seeds::SampleStatistics;

/// Samples where none are asked for and there are no parts.
const SAMPLES: usize = 400;
/// Least part of the variance that a linear fit must explain for its coefficients to say which key matters.
const LEAST_R_SQUARED: f64 = 0.7;
/// Percentiles: name, and part of the samples below it.
const PERCENTILES: [(&str, f64); 3] = [("percentile_5", 0.05), ("median", 0.5), ("percentile_95", 0.95)];

#[derive(Debug, Clone, Default, clap::Args)]
pub struct ToleranceArguments {
    #[command(flatten)]
    points: PointArguments,
    /// A key that varies evenly by up to this bound about its value in the scene, in per cent of it or in its own unit;
    /// with :normal the bound is two standard deviations; repeat it
    #[arg(long = "vary", value_name = "KEY=±BOUND[%][:normal]", required_unless_present = "parts")]
    varied: Vec<Varied>,
    /// Measured parts: a CSV file with a column for each key and a row for each part; the samples take them in turn
    #[arg(long, value_name = "PARTS.csv")]
    parts: Option<PathBuf>,
    /// The correlation of two normal keys of --vary; of the normal deviates from which others are made; may be repeated
    #[arg(long = "correlate", value_name = "KEY,KEY=VALUE", value_parser = correlation)]
    correlations: Vec<Correlation>,
    /// Number of samples [default: 400, or the number of parts]
    #[arg(long, value_name = "COUNT", value_parser = count::<usize>(2..=999_999))]
    samples: Option<usize>,
    /// Which samples; more samples with the same seed begin with the same ones
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// The number of the result
    #[arg(long, value_name = "QUANTITY", default_value = "mean_power_w")]
    quantity: String,
    /// Print the share of the samples that have at least this value, the yield
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    at_least: Option<String>,
}

/// Runs the samples, writes the files and prints the statistics. Fails after that if a sample could not be run.
pub(super) fn run(arguments: &ToleranceArguments) -> Result<(), Failure> {
    with_samples(arguments, |points, done, found, picture| {
        let text = match points.arguments.scene.format {
            Format::Table => found.table(&picture),
            format => text(&found.fields, format),
        };
        points.end(done, Some(&picture), &text)
    })
    .map(|_| ())
}

/// The picture of samples of some keys, with their statistics as the text.
pub(super) fn sampled(
    shared: &PointArguments,
    varied: Vec<Varied>,
    samples: usize,
) -> Result<Picture, Failure> {
    let arguments = ToleranceArguments {
        points: shared.clone(),
        varied,
        samples: Some(samples),
        quantity: "mean_power_w".to_owned(),
        ..ToleranceArguments::default()
    };
    let found = with_samples(&arguments, |_, _, found, picture| {
        Ok(Picture { text: found.table(&Picture::default()).trim_end().to_owned(), ..picture })
    });
    Ok(found?.unwrap_or_default())
}

/// Runs the samples, and makes something of them with their picture; `None` of one part of them.
fn with_samples<T>(
    arguments: &ToleranceArguments,
    make: impl FnOnce(&Points<'_>, Done, &Found<'_>, Picture) -> Result<T, Failure>,
) -> Result<Option<T>, Failure> {
    let ToleranceArguments { points: shared, varied, parts, correlations, samples, seed, quantity, at_least } =
        arguments;
    let at_least =
        at_least.as_deref().map(finite_number_in(number_and_unit(quantity).1, "--at-least")).transpose();
    let at_least = at_least.map_err(Failure::Input)?;
    let sampling = Sampling::new(&shared.scene, (varied, parts.as_deref()), correlations, *seed)?;
    let samples = samples.or(sampling.parts()).unwrap_or(SAMPLES);
    if let Some(parts) = sampling.parts().filter(|parts| varied.is_empty() && samples > *parts) {
        let reason = format!("must be at most {parts}, the number of parts, where nothing else varies");
        return Err(Failure::Input(format!("--samples {samples}: {reason}")));
    }
    let option = |key: &Varied| if key.parts.is_empty() { "--vary" } else { "--parts" };
    let points = Points {
        arguments: shared,
        command: "tolerance",
        keys: sampling.keys.iter().map(|one| (option(one), one.key.as_str())).collect(),
        count: samples + 1,
        values: Box::new(|number| sampling.values(number)),
        asked: format!("{sampling:?} {samples}"),
        compare: false,
    };
    if quantity != "mean_power_w" {
        shared.options().check()?;
        check_quantity("--quantity", quantity, &points.numbers(0)?)?;
    }
    let Some(done) = points.run(parts.as_slice())? else { return Ok(None) };
    let found = Found::new(arguments, at_least, &sampling, &done.points);
    print_warnings(&found.fields);
    let keys: Vec<&str> = sampling.keys.iter().map(|one| one.key.as_str()).collect();
    let title = points.title(&done.points, &keys)?;
    let picture = Picture { title, width: 900, charts: found.charts(), ..Picture::default() };
    make(&points, done, &found, picture).map(Some)
}

struct Found<'a> {
    arguments: &'a ToleranceArguments,
    at_least: Option<f64>,
    /// The quantity of the scene, and of the samples that have it, in their order and sorted.
    nominal: Option<f64>,
    values: Vec<f64>,
    sorted: Vec<f64>,
    /// The keys in the order in which they matter, with their values in these samples.
    keys: Vec<(&'a Varied, Vec<f64>)>,
    /// The result for programs.
    fields: Fields,
}

impl<'a> Found<'a> {
    fn new(
        arguments: &'a ToleranceArguments,
        at_least: Option<f64>,
        sampling: &'a Sampling,
        points: &[Point],
    ) -> Self {
        let ToleranceArguments { quantity, seed, .. } = arguments;
        let number = |point: &Point| {
            let found = flattened(point.found.as_ref().ok()?.clone());
            found.get(quantity)?.as_f64().filter(|value| value.is_finite())
        };
        let nominal = points.first().and_then(number);
        let (valued, values): (Vec<&Point>, Vec<f64>) =
            points.iter().skip(1).filter_map(|point| Some((point, number(point)?))).unzip();
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        let of_key = |key: usize| valued.iter().map(|point| point.values[key].1).collect::<Vec<f64>>();
        let drawn: Vec<Vec<f64>> = (0..sampling.keys.len()).map(of_key).collect();
        let matter = sensitivities(&values, &drawn);
        let [r_squared, quadratic] = matter.r_squared;
        let mut keys: Vec<_> = sampling.keys.iter().zip(drawn).zip(matter.keys).collect();
        let size = |of: &Sensitivity| of.variance_share.or(of.coefficient).map_or(0.0, f64::abs);
        keys.sort_by(|one, other| size(&other.1).total_cmp(&size(&one.1)));
        let row = |((key, _), matters): &((&Varied, _), Sensitivity)| {
            let bound = Some(key.bound).filter(|bound| *bound > 0.0);
            json!({ "name": key.key, "nominal": key.nominal, "bound": bound, "distribution": key.distribution,
                "variance_share": matters.variance_share, "standardised_coefficient": matters.coefficient })
        };
        let size = |one: &Value| one["total"].as_f64().unwrap_or(f64::INFINITY);
        let stated = points.iter().filter_map(|point| point.found.as_ref().ok()?.get("accuracy"));
        let remarks = remarks(sampling, points, (quantity, &sorted), matter.r_squared);
        let fields = fields(&json!({
            "quantity": quantity,
            "generator": GENERATOR,
            "seed": seed,
            "samples": values.len(),
            "at_least": at_least,
            "statistics": statistics(nominal, &values, &sorted, at_least),
            "keys": keys.iter().map(row).collect::<Vec<_>>(),
            "linear_r_squared": r_squared,
            "quadratic_r_squared": quadratic,
            "accuracy": stated.max_by(|one, other| size(one).total_cmp(&size(other))),
            "warnings": warnings(points).chain(remarks).collect::<Vec<_>>(),
        }));
        Self {
            arguments,
            at_least,
            nominal,
            values,
            sorted,
            keys: keys.into_iter().map(|key| key.0).collect(),
            fields,
        }
    }

    fn note(&self) -> String {
        let samples = format!("{} samples", self.values.len());
        let drawn = format!(", seed {}, {GENERATOR}", self.arguments.seed);
        if self.arguments.varied.is_empty() { samples } else { samples + &drawn }
    }

    fn table(&self, picture: &Picture) -> String {
        let stated = small(self.fields["accuracy"]["total"].as_f64());
        let [statistics, keys] = ["statistics", "keys"].map(|name| {
            let rows = Rows::of(self.fields[name].as_array().into_iter().flatten());
            // In one notation, whatever the sizes.
            let columns = rows.plain().into_iter().map(|(name, key, _)| (name, key, Digits::Exponent(4)));
            rows.table(presets::NOTHING, &columns.collect::<Vec<_>>(), 1)
        });
        let r_squared = ["linear_r_squared", "quadratic_r_squared"].map(|name| self.fields[name].as_f64());
        let fits = explained(r_squared, &self.sorted);
        let chart = picture.charts.first().map_or_else(String::new, |chart| terminal(chart, 12));
        let heading =
            format!("{}: {}; accuracy of mean_power_w {stated}", self.arguments.quantity, self.note());
        let heading = folded(&heading, 2);
        format!("{heading}\n\n{statistics}\n{keys}R²: {fits}\n\n{chart}")
    }

    /// The distribution, and the quantity over each of the keys that matter most.
    fn charts(&self) -> Vec<Chart> {
        let Self { sorted, nominal, .. } = self;
        let (words, unit) = number_and_unit(&self.arguments.quantity);
        let (title, factor) = scaled(&words, unit, sorted.iter().copied());
        let share = |value: f64| sorted.partition_point(|one| *one <= value) as f64 / sorted.len() as f64;
        let found: Vec<f64> = PERCENTILES.iter().map(|(_, part)| percentile(sorted, *part)).collect();
        let all: Vec<f64> = found.iter().copied().chain(*nominal).collect();
        let mut labels = distinct_labels(&all, unit).into_iter();
        let upright = |name: String, colour, mark, value: f64| {
            Curve::new(name, colour, mark, [0.0, 1.0].map(|share| (factor * value, share)))
        };
        let line = sorted.iter().map(|value| (factor * value, share(*value)));
        let mut curves = vec![Curve::new("", BLUE, Mark::line(0, 1.8), line)];
        let percentiles =
            PERCENTILES.iter().zip(&found).zip(&mut labels).map(|(((name, part), value), label)| {
                (format!("{}: {label}", name.replace('_', " ")), [(factor * value, *part)])
            });
        curves.extend(Curve::distinct(&[GREEN, BLACK], (Mark::point, 9.0), percentiles));
        let nominal_line = nominal.zip(labels.next());
        let nominal_line = nominal_line
            .map(|(value, label)| upright(format!("nominal: {label}"), VERMILION, Mark::line(0, 1.2), value));
        let wished = self.at_least.map(|value| {
            upright(format!("wished: {}", exact_label(value, unit)), BLACK, Mark::line(1, 1.2), value)
        });
        curves.extend(nominal_line.into_iter().chain(wished));
        let across = |title: &str, curves: &[Curve]| {
            let all = curves.iter().flat_map(|curve| &curve.points).map(|point| point.0);
            Axis::linear(title, range(all).into(), 6)
        };
        let up = Axis::linear("share of the samples up to it", [0.0, 1.0], 5);
        let distribution = Chart::new("", across(&title, &curves), up, curves);
        let of_key = |(key, values): &(&Varied, Vec<f64>)| {
            let (words, unit) = words_and_unit(&key.key);
            let about = exact_label(key.nominal, &unit);
            // Of 0 there is no percentage.
            let (key_title, [from, scale]) = match key.nominal {
                0.0 => (label(&key.key), [0.0, 1.0]),
                from => (format!("{words}, deviation from {about} [%]"), [from, 100.0 / from.abs()]),
            };
            let place = |(at, value): (f64, f64)| (scale * (at - from), factor * value);
            let samples = values.iter().copied().zip(self.values.iter().copied()).map(place);
            let nominal = nominal.map(|value| place((key.nominal, value)));
            let curves = vec![
                Curve::new("samples", BLUE, Mark::point(0, 4.0), samples),
                Curve::new("nominal", VERMILION, Mark::point(1, 11.0), nominal),
            ];
            let across = across(&key_title, &curves);
            Chart {
                is_half: true,
                ..Chart::new("", across, Axis::linear(title.as_str(), FITTING, 6), curves)
            }
        };
        let keys = self.keys.iter().take(4).map(of_key);
        let all = std::iter::once(Chart { note: self.note(), ..distribution }).chain(keys);
        if sorted.is_empty() { Vec::new() } else { all.collect() }
    }
}

/// How much of the variance both fits explain, or why there is none.
fn explained(r_squared: [Option<f64>; 2], sorted: &[f64]) -> String {
    let is_constant = sorted.len() > 1 && sorted.first() == sorted.last();
    let reason = if is_constant { "fails: all values are equal" } else { "has too few samples" };
    let [linear, quadratic] = r_squared.map(|part| match part {
        Some(part) => format!("explains {:.1} % of the variance", 100.0 * part.max(0.0)),
        None => reason.to_owned(),
    });
    format!("a linear fit {linear}, a quadratic one {quadratic}")
}

/// What is to be known of the samples beside the warnings of their runs.
fn remarks(
    sampling: &Sampling,
    points: &[Point],
    (quantity, sorted): (&str, &[f64]),
    r_squared: [Option<f64>; 2],
) -> impl Iterator<Item = String> {
    let (all, valued) = (points.len() - 1, sorted.len());
    let lacking = (valued < all)
        .then(|| format!("{} of {all} samples failed or have no {quantity}, and are left out", all - valued));
    let unexplained = r_squared[0].is_none_or(|part| part < LEAST_R_SQUARED).then(|| {
        format!(
            "sensitivities: {}: standardised coefficients do not say which key matters, and variance_share as far as the \
             quadratic fit",
            explained(r_squared, sorted)
        )
    });
    let repeated = sampling.parts().filter(|parts| *parts < all).map(|parts| {
        format!(
            "samples: {parts} parts are taken in turn; intervals are those of further samples of these parts"
        )
    });
    let unsteady = points.iter().filter(|point| point.is_of_a_run()).count();
    let unsteady = (unsteady > 0).then(|| {
        format!(
            "steady state: {unsteady} of {} runs come to no stable orbit, their numbers are of the run",
            all + 1
        )
    });
    [lacking, unexplained, repeated, unsteady].into_iter().flatten()
}

/// A row for each statistic, with its 95 % confidence interval for the number of samples: of the mean by Student's t, of
/// percentiles by order statistics, of the yield by Wilson's interval of a share.
fn statistics(nominal: Option<f64>, values: &[f64], sorted: &[f64], at_least: Option<f64>) -> Vec<Value> {
    let row = |name: &str, value: Option<f64>, [low, high]: [Option<f64>; 2]| json!({ "name": name, "value": value, "confidence_low": low, "confidence_high": high });
    let mut rows = vec![row("nominal", nominal, [None; 2])];
    let Some(mean) = SampleStatistics::of(values) else { return rows };
    rows.push(row("mean", Some(mean.mean), [mean.confidence_low, mean.confidence_high]));
    rows.push(row("standard_deviation", mean.standard_deviation, [None; 2]));
    rows.extend(PERCENTILES.map(|(name, part)| {
        let ends = ranks(part, sorted.len()).map(|rank| sorted.get(rank?).copied());
        row(name, Some(percentile(sorted, part)), ends)
    }));
    rows.extend(at_least.map(|least| {
        let share = values.iter().filter(|value| **value >= least).count() as f64 / values.len() as f64;
        row("yield", Some(share), wilson(share, values.len()).map(Some))
    }));
    rows
}
