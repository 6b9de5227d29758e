//! Statistics of a scene with a random excitation over several seeds.

use comfy_table::presets;
use serde::Serialize;

use crate::accuracy::{Statements, imbalance, run_as_it_is, run_with_steps};
use crate::command::json_text;
use crate::method::{Failure, Options};
use crate::outcome::{Fields, Format, fields, flattened, small};
use crate::rows::{Column, Digits, Rows};
use crate::run::{run_scene, try_each};
use crate::scene_file::{Excitation, Scene};
use harvester_scene::root::far_side;

/// The highest seed that a scene file takes.
const HIGHEST_SEED: u64 = 4_294_967_295;
/// Probability of the confidence interval.
const CONFIDENCE: f64 = 0.95;
/// Numbers of an outcome that are not results of the motion.
const NO_RESULTS: [&str; 9] = [
    "duration_s",
    "settle_s",
    "processor_s",
    "steps",
    "rejected_steps",
    "newton_iterations",
    "base_rms_m_per_s2",
    "natural_frequency_hz",
    "energy_residual",
];

/// Successive seeds, from that of a scene on.
#[derive(Debug, Clone, Copy)]
pub struct Seeds {
    first: u64,
    count: u64,
}

impl Seeds {
    /// `count` seeds from that of the scene on.
    ///
    /// # Errors
    /// A scene without a seed, or a last seed out of bounds.
    pub fn new(scene: &Scene, count: u64) -> Result<Self, Failure> {
        let Some(random) = scene.excitation.random() else {
            return Err(Failure::of_file(scene, "excitation.kind: must be \"random\" with --seeds"));
        };
        let (first, count) = (random.seed, count);
        if first + count - 1 > HIGHEST_SEED {
            let text = format!("--seeds {count}: the last seed must be at most {HIGHEST_SEED}");
            return Err(Failure::Input(text));
        }
        Ok(Self { first, count })
    }

    /// The number of seeds.
    pub fn count(&self) -> usize {
        self.count as usize
    }
}

/// A quantity over the seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SampleStatistics {
    /// Number of seeds that have it: with an event that some runs lack, fewer than all.
    pub count: usize,
    /// Mean over the seeds.
    pub mean: f64,
    /// Standard deviation of one seed, with one degree of freedom less than seeds; none of one seed.
    pub standard_deviation: Option<f64>,
    /// Lower end of the 95 % confidence interval of the mean by Student's t distribution; none of one seed.
    pub confidence_low: Option<f64>,
    /// Its upper end.
    pub confidence_high: Option<f64>,
    /// Smallest of the seeds.
    pub least: f64,
    /// Largest of the seeds.
    pub largest: f64,
}

impl SampleStatistics {
    /// Of the values of the seeds; `None` of no value.
    pub fn of(values: &[f64]) -> Option<Self> {
        let number = values.len() as f64;
        let mean = values.iter().sum::<f64>() / number;
        let deviation = (values.len() > 1).then(|| {
            let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            (squares / (number - 1.0)).sqrt()
        });
        let freedom = u32::try_from(values.len()).unwrap_or(u32::MAX).saturating_sub(1);
        let half = deviation.map(|deviation| quantile(freedom, CONFIDENCE) * deviation / number.sqrt());
        (!values.is_empty()).then(|| Self {
            count: values.len(),
            mean,
            standard_deviation: deviation,
            confidence_low: half.map(|half| mean - half),
            confidence_high: half.map(|half| mean + half),
            least: values.iter().copied().fold(f64::INFINITY, f64::min),
            largest: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    }
}

/// The statistics of a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Statistics {
    scene: &'static str,
    method: String,
    precision: &'static str,
    math: &'static str,
    duration_s: f64,
    settle_s: f64,
    base_rms_m_per_s2: Option<f64>,
    /// First and last seed.
    seeds: [u64; 2],
    confidence: f64,
    /// Each quantity of an outcome, over the seeds.
    statistics: Fields,
    /// The largest statement of the seeds, and their warnings.
    #[serde(flatten)]
    pub(crate) stated: Fields,
}

impl Statistics {
    /// Runs a scene with each seed on all cores; `done` is called after each. With `accuracy` each has its
    /// statement, and the others the steps that were chosen for the first.
    ///
    /// # Errors
    /// If a seed cannot be run to its end.
    pub fn of(
        scene: &Scene,
        options: &Options,
        seeds: &Seeds,
        accuracy: bool,
        done: impl Fn() + Sync,
    ) -> Result<Self, Failure> {
        let (mut first, options) =
            if accuracy { run_with_steps(scene, options)? } else { (run_scene(scene, options)?, *options) };
        if !accuracy {
            first.warnings.extend(imbalance(&first));
        }
        done();
        let others: Vec<u64> = (1..seeds.count).map(|index| seeds.first + index).collect();
        let others = try_each(&others, |&seed| {
            let run = if accuracy { run_as_it_is } else { run_scene };
            let mut outcome = run(&with_seed(scene, seed)?, &options)
                .map_err(|failure| failure.of_case(&format!("excitation.seed = {seed}")))?;
            if !accuracy {
                outcome.warnings.extend(imbalance(&outcome));
            }
            done();
            Ok(outcome)
        })?;
        let statements = Statements::of(std::iter::once(&first).chain(&others));
        let rows: Vec<Fields> = std::iter::once(&first).chain(&others).map(fields).collect();
        Ok(Self {
            scene: first.scene,
            method: first.method,
            precision: first.precision,
            math: first.math,
            duration_s: first.duration_s,
            settle_s: first.settle_s,
            base_rms_m_per_s2: first.base_rms_m_per_s2,
            seeds: [seeds.first, seeds.first + seeds.count - 1],
            confidence: CONFIDENCE,
            statistics: statistics_by_quantity(&rows),
            stated: statements.fields(&[]),
        })
    }

    /// The statistics as text, line break included.
    ///
    /// # Errors
    /// If they cannot be written as JSON.
    pub fn text(&self, format: Format) -> Result<String, Failure> {
        match format {
            Format::Json => json_text(self),
            Format::Csv => Ok(self.rows().csv()),
            Format::Table => Ok(self.table()),
        }
    }

    fn rows(&self) -> Rows {
        let row = |(name, statistics)| {
            let mut row = Fields::from_iter([("quantity".to_owned(), String::as_str(name).into())]);
            row.extend(fields(statistics));
            row.extend(flattened(self.stated.clone()));
            row
        };
        Rows(self.statistics.iter().map(row).collect())
    }

    fn table(&self) -> String {
        let shown = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.5e}"));
        let [first, last] = self.seeds;
        let base = shown(self.base_rms_m_per_s2);
        let heading = format!(
            "{}, {}, {}: seeds {first} to {last}, {} s to {} s, base {base} m/s² RMS, accuracy {}\n",
            self.scene,
            self.method,
            self.precision,
            self.settle_s,
            self.duration_s,
            small(self.stated["accuracy"]["total"].as_f64())
        );
        heading + &self.rows().table(presets::NOTHING, &COLUMNS, 1)
    }
}

const COLUMNS: [Column<'_>; 8] = [
    ("quantity", "quantity", Digits::Word),
    ("mean", "mean", Digits::Exponent(5)),
    ("95 % from", "confidence_low", Digits::Exponent(5)),
    ("to", "confidence_high", Digits::Exponent(5)),
    ("deviation", "standard_deviation", Digits::Exponent(5)),
    ("least", "least", Digits::Exponent(5)),
    ("largest", "largest", Digits::Exponent(5)),
    ("seeds", "count", Digits::Six),
];

/// The spread of each number over the rows, in their order.
fn statistics_by_quantity(rows: &[Fields]) -> Fields {
    let mut names: Vec<&String> = Vec::new();
    for name in rows.iter().flat_map(Fields::keys) {
        if !names.contains(&name) && !NO_RESULTS.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let statistics = |name: &String| {
        let values: Vec<f64> =
            rows.iter().filter_map(|row| row.get(name)?.as_f64()).filter(|value| value.is_finite()).collect();
        Some((name.clone(), fields(&SampleStatistics::of(&values)?).into()))
    };
    names.into_iter().filter_map(statistics).collect()
}

fn with_seed(scene: &Scene, seed: u64) -> Result<Scene, Failure> {
    let excitation = match &scene.excitation {
        Excitation::Random(random) => {
            let drawn = random.with_seed(seed).map_err(|error| Failure::of_file(scene, error))?;
            Excitation::Random(drawn)
        }
        other => other.clone(),
    };
    Ok(Scene { excitation, ..scene.clone() })
}

/// The probability that Student's t of `freedom` is within `±t`: the sums of Abramowitz and Stegun, 26.7.3 and 26.7.4.
fn probability(freedom: u32, t: f64) -> f64 {
    let angle = (t / f64::from(freedom).sqrt()).atan();
    let (sine, square) = (angle.sin(), angle.cos().powi(2));
    let first = if freedom.is_multiple_of(2) { 2 } else { 3 };
    // `1 + 1/2 cos² + …` of an even number, `cos + 2/3 cos³ + …` of an odd one.
    let (mut term, mut sum) = (1.0, 0.0);
    let mut n = first;
    while n <= freedom {
        sum += term;
        term *= square * f64::from(n - 1) / f64::from(n);
        n += 2;
    }
    if freedom.is_multiple_of(2) {
        sine * sum
    } else {
        std::f64::consts::FRAC_2_PI * (angle + sine * angle.cos() * sum)
    }
}

/// The `t` within `±` which Student's t with `freedom` degrees of freedom, at least 1, is with a probability.
pub(crate) fn quantile(freedom: u32, confidence: f64) -> f64 {
    far_side(|t| probability(freedom.max(1), t) - confidence, 0.0, 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Two-sided 95 %, from the usual tables; the last is that of a Gaussian.
        for (freedom, expected) in
            [(1, 12.706), (2, 4.303), (3, 3.182), (9, 2.262), (19, 2.093), (30, 2.042), (100_000, 1.960)]
        {
            let found = quantile(freedom, 0.95);
            assert!((found - expected).abs() < 6e-4, "{freedom}: {found}");
        }
        assert!((quantile(10, 0.99) - 3.169).abs() < 6e-4);
        // One and two degrees of freedom have closed forms.
        assert!((quantile(1, 0.9) - (0.45 * std::f64::consts::PI).tan()).abs() < 1e-12);
        let two = 0.9 * (2.0 / (1.0 - 0.81_f64)).sqrt();
        assert!((quantile(2, 0.9) - two).abs() < 1e-12);
    }
}
