//! How keys vary from part to part, and the values of each sample.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::path::Path;
use std::str::FromStr;

use nalgebra::{DMatrix, DVector};

use crate::command::SceneArguments;
use crate::fit::data::columns;
use crate::method::Failure;
use crate::scene_file::{self, Override, finite_number_of, number_at};
use crate::stability::random::Source;

/// The generator of the samples.
pub(super) const GENERATOR: &str = "SplitMix64, normal deviates by Box and Muller";

/// A key that varies: `KEY=±BOUND`, `KEY=±BOUND%`, with `:normal` or without; or a column of measured parts.
#[derive(Debug, Clone)]
pub(in crate::command) struct Varied {
    pub(in crate::command) key: String,
    /// Its value in the scene.
    pub(super) nominal: f64,
    /// Ends of a uniform distribution about it, or two standard deviations of a normal one; a part of it where it is relative.
    pub(super) bound: f64,
    is_relative: bool,
    /// `uniform`, `normal` or `parts`.
    pub(super) distribution: &'static str,
    pub(super) parts: Vec<f64>,
}

impl FromStr for Varied {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str =
            "must be KEY=±BOUND or KEY=±BOUND%, with or without :normal behind it; +- is ± too";
        let (key, rest) = text.split_once('=').ok_or(FORM)?;
        let of = |bound| (bound, "normal");
        let (bound, distribution) = rest.strip_suffix(":normal").map_or((rest, "uniform"), of);
        let bound = bound.trim();
        let signed = bound.strip_prefix('±').or_else(|| bound.strip_prefix("+-"));
        // A part needs no sign; a number without one would be a value.
        let bound = signed.or(Some(bound).filter(|bound| bound.ends_with('%'))).ok_or(FORM)?;
        let part = bound.strip_suffix('%').map(|part| part.trim().parse::<f64>().ok());
        let value = match part {
            Some(part) => part.map(|part| part / 100.0),
            None => Some(finite_number_of(key.trim(), "BOUND", bound)?),
        };
        let value = value.filter(|value| *value > 0.0 && value.is_finite()).ok_or_else(|| {
            format!("BOUND = {bound:?} must be a number above 0, in per cent or in the unit of the key")
        })?;
        let (key, is_relative) = (key.trim().to_owned(), part.is_some());
        Ok(Self { key, nominal: f64::NAN, bound: value, is_relative, distribution, parts: Vec::new() })
    }
}

impl Varied {
    /// The same with its value in the scene, and with the bound of this.
    fn about(mut self, scene: &SceneArguments, option: &'static str) -> Result<Self, Failure> {
        let value = number_at(&scene.scene, &scene.overrides, &self.key)?;
        let refuse = |reason: &str| Err(Failure::Input(format!("{option} {}: {reason}", self.key)));
        let probe = [&scene.overrides[..], &[Override::new(&self.key, "0").by(option)]].concat();
        let refused = if value.is_none() { scene_file::read(&scene.scene, &probe).err() } else { None };
        if let Some(error) = refused.filter(|error| error.to_string().contains(": unknown key")) {
            return Err(error.without_value().into());
        }
        let Some(nominal) = value.filter(|value| value.is_finite()) else {
            return refuse("must have a finite value in the scene; --set gives it one");
        };
        if self.is_relative && nominal == 0.0 {
            return refuse("must have another value than 0 for a bound in per cent");
        }
        self.bound *= if self.is_relative { nominal.abs() } else { 1.0 };
        Ok(Self { nominal, ..self })
    }
}

/// Two keys and the correlation of their normal deviates: `KEY,KEY=VALUE`.
pub(super) type Correlation = (String, String, f64);

pub(super) fn correlation(text: &str) -> Result<Correlation, String> {
    const FORM: &str = "must be KEY,KEY=VALUE with two keys of --vary and a value between -1 and 1";
    let (keys, value) = text.split_once('=').ok_or(FORM)?;
    let (one, other) = keys.split_once(',').ok_or(FORM)?;
    let value = value.trim().parse().ok().filter(|value: &f64| value.abs() < 1.0).ok_or(FORM)?;
    Ok((one.trim().to_owned(), other.trim().to_owned(), value))
}

#[derive(Debug)]
pub(super) struct Sampling {
    /// Those of `--vary`, and behind them those of the parts.
    pub(super) keys: Vec<Varied>,
    /// Times independent normal deviates: the correlated ones.
    factor: DMatrix<f64>,
    seed: u64,
}

impl Sampling {
    pub(super) fn new(
        scene: &SceneArguments,
        (varied, parts): (&[Varied], Option<&Path>),
        correlations: &[Correlation],
        seed: u64,
    ) -> Result<Self, Failure> {
        let columns = parts.map_or(Ok(Vec::new()), columns)?.into_iter().map(|(key, parts)| {
            let column =
                Varied { key, nominal: 0.0, bound: 0.0, is_relative: false, distribution: "parts", parts };
            column.about(scene, "--parts")
        });
        let keys = varied.iter().map(|one| one.clone().about(scene, "--vary")).chain(columns);
        let keys: Vec<Varied> = keys.collect::<Result<_, _>>()?;
        let mut matrix = DMatrix::identity(keys.len(), keys.len());
        for (one, other, value) in correlations {
            let [row, column] = [one, other].map(|key| varied.iter().position(|varied| varied.key == *key));
            let (Some(row), Some(column)) = (row, column.filter(|_| one != other)) else {
                return Err(Failure::Input(format!("--correlate {one},{other}: must be two keys of --vary")));
            };
            if matrix[(row, column)] != 0.0 {
                return Err(Failure::Input(format!("--correlate {one},{other}: is given twice")));
            }
            (matrix[(row, column)], matrix[(column, row)]) = (*value, *value);
        }
        let reason = "--correlate: must be possible together, their matrix is not positive definite";
        let refused = || Failure::Input(reason.to_owned());
        let factor = matrix.cholesky().map(|found| found.unpack()).ok_or_else(refused)?;
        Ok(Self { keys, factor, seed })
    }

    /// The number of measured parts, if there are any.
    pub(super) fn parts(&self) -> Option<usize> {
        self.keys.iter().map(|key| key.parts.len()).find(|parts| *parts > 0)
    }

    /// The values of the keys: number 0 is the scene, the others are samples by number and seed alone, of the parts in turn.
    pub(super) fn values(&self, number: usize) -> Vec<f64> {
        let Some(index) = number.checked_sub(1) else {
            return self.keys.iter().map(|key| key.nominal).collect();
        };
        let mut source = Source::new(self.seed, index as u64);
        let mut normal = || {
            let [radius, angle] = [(); 2].map(|()| source.uniform(0.0, 1.0));
            (-2.0 * libm::log(1.0 - radius)).sqrt() * libm::cos(TAU * angle)
        };
        let deviates = &self.factor * DVector::from_fn(self.keys.len(), |_, _| normal());
        let value = |(key, deviate): (&Varied, &f64)| match key.distribution {
            "parts" => key.parts[index % key.parts.len()],
            "normal" => key.nominal + 0.5 * key.bound * deviate,
            // The normal distribution function makes a uniform deviate of it.
            _ => key.nominal + key.bound * libm::erf(FRAC_1_SQRT_2 * deviate),
        };
        self.keys.iter().zip(&deviates).map(value).collect()
    }
}
