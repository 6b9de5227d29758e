//! Free keys: their start, their bounds, and the scale on which they are varied.

use std::path::Path;

use crate::method::Failure;
use crate::outcome::{number, shown};
use crate::scene_file::{self, Override, finite_number_of};

/// Factor from the start to the bounds of a key, where nothing else bounds it.
const FARTHEST: f64 = 1e3;
/// Least part of the start that a positive key with a bound of 0 goes down to.
const LEAST: f64 = 1e-9;
/// Steps of the search for the bound of a key.
const HALVINGS: usize = 60;

/// A free key as it is asked for: `KEY` or `KEY=LOW:HIGH`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Asked {
    pub(crate) key: String,
    pub(crate) bounds: Option<[f64; 2]>,
}

impl std::str::FromStr for Asked {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "must be KEY or KEY=LOW:HIGH";
        let (key, range) = match text.split_once('=') {
            None => (text, None),
            Some((key, range)) => (key, Some(range)),
        };
        let key = key.split('.').map(str::trim).collect::<Vec<_>>().join(".");
        if key.is_empty() {
            return Err(FORM.to_owned());
        }
        let Some(range) = range else { return Ok(Self { key, bounds: None }) };
        let (low, high) = range.split_once(':').ok_or(FORM)?;
        let number = |name: &str, text: &str| {
            finite_number_of(&key, name, text).map_err(|reason| format!("{key}: {reason}"))
        };
        let (low, high) = (number("LOW", low)?, number("HIGH", high)?);
        if !(low < high) {
            return Err(format!("{key}: LOW = {low} must be below HIGH = {high}"));
        }
        Ok(Self { key, bounds: Some([low, high]) })
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    /// A key of the scene.
    Key,
    /// The displacement at the start of the data file with this number.
    StartOf(usize),
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Free {
    /// Its name in the result: the key.
    pub(crate) name: String,
    pub(crate) place: Place,
    pub(crate) start: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Whether the bounds were asked for.
    pub(crate) is_bounded: bool,
    /// The unit of its coordinate; `None`: its coordinate is its logarithm.
    pub(crate) unit: Option<f64>,
}

impl Free {
    pub(crate) fn coordinate(&self, value: f64) -> f64 {
        match self.unit {
            Some(unit) => value / unit,
            None => value.max(LEAST * self.start).ln(),
        }
    }

    pub(crate) fn value(&self, coordinate: f64) -> f64 {
        let value = self.unit.map_or_else(|| coordinate.exp(), |unit| coordinate * unit);
        // The rounding of the logarithm must not leave the bounds.
        let is_at = |end: &f64| (value - end).abs() <= 1e-14 * end.abs();
        [self.low, self.high].into_iter().find(is_at).unwrap_or(value)
    }

    /// The value at a coordinate, within the bounds.
    pub(crate) fn within(&self, coordinate: f64) -> f64 {
        self.value(coordinate).clamp(self.low, self.high)
    }

    /// Whether an interval is more than half of the range between the bounds of the key, by the values or by the coordinates:
    /// bounds that a user gives may be as narrow as what the data determine.
    pub(crate) fn covers_most(&self, interval: [f64; 2]) -> bool {
        let most = |[low, high]: [f64; 2], [first, last]: [f64; 2]| high - low > 0.5 * (last - first);
        if self.is_bounded {
            return false;
        }
        most(interval, [self.low, self.high])
            || most(interval.map(|value| self.coordinate(value)), self.ends())
    }

    /// The derivative of the value by the coordinate.
    pub(crate) fn slope(&self, value: f64) -> f64 {
        self.unit.unwrap_or(value)
    }

    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.coordinate(self.low), self.coordinate(self.high)]
    }

    pub(crate) fn is_at_bound(&self, value: f64) -> bool {
        let at = self.coordinate(value);
        let [low, high] = self.ends();
        let within = 1e-6 * (high - low).min(1.0);
        at <= low + within || at >= high - within
    }
}

/// The free number of a key of a scene, which must be a number.
///
/// Bounds that are not given are where the scene file's reader begins to refuse, at most a factor of a thousand from the start.
pub(crate) fn of_key(file: &Path, overrides: &[Override], asked: &Asked) -> Result<Free, Failure> {
    let refuse = |text: String| Failure::Input(format!("--free {}: {text}", asked.key));
    let read = |value: f64| {
        let mut all = overrides.to_vec();
        all.push(Override::new(&asked.key, &number(value)).by("--free"));
        scene_file::read(file, &all)
    };
    let given =
        scene_file::number_at(file, overrides, &asked.key).map_err(|error| refuse(error.to_string()))?;
    let middle = |[low, high]: [f64; 2]| if low > 0.0 { (low * high).sqrt() } else { 0.5 * (low + high) };
    let start = match (given, asked.bounds) {
        (Some(start), Some([low, high])) if !(low..=high).contains(&start) => {
            let [start, low, high] = [start, low, high].map(|value| shown(&value.into()));
            return Err(refuse(format!("the scene's {start} must be within {low}:{high}")));
        }
        (Some(start), _) => start,
        (None, Some(bounds)) => middle(bounds),
        (None, None) => 0.0,
    };
    if !start.is_finite() {
        return Err(refuse(format!("the scene's {start} must be finite to start from")));
    }
    let is_chosen = given.is_some() || asked.bounds.is_some();
    // A default value is not printed.
    read(start).map_err(|error| if is_chosen { error } else { error.without_value() })?;
    if !is_chosen && !asked.key.starts_with("initial.") {
        return Err(refuse(
            "is not in the scene: must have a value there to start from, or LOW:HIGH".to_owned(),
        ));
    }
    let accepts = |value: f64| read(value).is_ok();
    let is_start = asked.key.starts_with("initial.");
    let (low, high) = match asked.bounds {
        Some([low, high]) => (farthest(start, low, &accepts), farthest(start, high, &accepts)),
        None if start > 0.0 && !is_start => {
            (farthest(start, start / FARTHEST, &accepts), farthest(start, start * FARTHEST, &accepts))
        }
        None => {
            let size = FARTHEST * if start == 0.0 { 1e-3 } else { start.abs() };
            (farthest(start, -size, &accepts), farthest(start, size, &accepts))
        }
    };
    let is_logarithmic = start > 0.0 && low >= 0.0 && !is_start;
    let linear = || if start == 0.0 { high.abs().max(low.abs()).min(1e-3) } else { start.abs() };
    Ok(Free {
        name: asked.key.clone(),
        place: Place::Key,
        start,
        low,
        high,
        is_bounded: asked.bounds.is_some(),
        unit: (!is_logarithmic).then(linear),
    })
}

/// The value on the way from `start` to `end` that is farthest and accepted.
fn farthest(start: f64, end: f64, accepts: &dyn Fn(f64) -> bool) -> f64 {
    if accepts(end) {
        return end;
    }
    let (mut near, mut far) = (start, end);
    for _ in 0..HALVINGS {
        let middle = if near > 0.0 && far > 0.0 { (near * far).sqrt() } else { near + 0.5 * (far - near) };
        if accepts(middle) {
            near = middle;
        } else {
            far = middle;
        }
    }
    near
}
