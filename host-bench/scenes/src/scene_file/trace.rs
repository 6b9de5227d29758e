//! A recorded acceleration in a CSV or a WAV file.

mod clock;
pub(super) mod number;
mod table;
mod wave;

use std::path::PathBuf;

use super::document::SceneError;
use super::key::{Default, Kind, Value, between, number, other, whole};
use super::scene::Trace;
use super::section::Section;

/// Largest acceleration of the base in m/s².
pub(super) const HIGHEST_ACCELERATION: f64 = 1e5;

pub(super) static FILE: Kind = Kind {
    word: "file",
    meaning: "A recorded acceleration",
    keys: &[
        other("path", Value::Text, "CSV or WAV file, relative to the scene file"),
        other(
            "column",
            Value::Column(between(1.0, 10_000.0)),
            "Column of the samples, by its name or its number from 1; the channel of a WAV file",
        )
        .or(Default::Said("`acceleration_m_per_s2`, or the only one")),
        other(
            "time_column",
            Value::ColumnOrFalse(between(1.0, 10_000.0)),
            "Column of the times, or false: no column has times; CSV only",
        )
        .or(Default::Said("the first whose heading names a time")),
        number("rate_hz", "Hz", between(1e-3, 1e6), "Samples per second")
            .or(Default::Said("that of the times or of the WAV file, else required"))
            .instead_of("resample_hz"),
        number("resample_hz", "Hz", between(1e-3, 1e6), "Even rate to which uneven times are resampled")
            .limit("at least 0.9 of the usual rate; CSV only")
            .or_said("uneven times are refused")
            .instead_of("rate_hz"),
        whole("longest_gap_samples", "", between(0.0, 1e6), "Missing samples in a row to fill")
            .limit("beside `resample_hz`")
            .or_number(2.0),
        number("scale_m_per_s2", "m/s²", between(-1e6, 1e6), "Acceleration for each unit of the file")
            .or(Default::Said("the unit in the heading of the column, else required")),
        other("repeat", Value::Flag, "Whether the recording begins again at its end")
            .or(Default::Flag(false)),
    ],
};

/// Which column of a table, or channel of a recording.
#[derive(Debug, Clone, PartialEq)]
enum Column {
    /// By its name in the first row.
    Name(String),
    /// By its number, from 1; a first row that is not a number there is a heading.
    Number(usize),
}

/// What the scene file says about the columns of a table and the rate of its rows.
struct Asked {
    column: Option<Column>,
    clock: AskedClock,
    rate_hz: Option<f64>,
    /// The rate in Hz of even times, and the most samples in a row that may be missing.
    resampling: Option<(f64, usize)>,
    /// Factor from a number of the file to m/s², where the scene file has one.
    scale: Option<f64>,
}

/// Which column of a table has the times of the samples.
enum AskedClock {
    /// As the file states.
    Unset,
    /// None, whatever the file looks like.
    Ignored,
    Column(Column),
}

impl AskedClock {
    /// Reads `time_column`, if it is there.
    fn read(section: &mut Section<'_>) -> Result<Self, SceneError> {
        const KEY: &str = "time_column";
        if section.is_false(KEY) {
            return Ok(Self::Ignored);
        }
        let wanted = format!("{}, or false", Column::WANTED);
        Ok(Column::optional(section, KEY, &wanted)?.map_or(Self::Unset, Self::Column))
    }

    fn column(&self) -> Option<&Column> {
        if let Self::Column(column) = self { Some(column) } else { None }
    }
}

/// Why a trace was refused, and the key to blame.
#[derive(Debug, Clone, PartialEq, Eq)]
struct TraceFault {
    key: &'static str,
    /// The reason; what is wanted of a key that is missing.
    text: String,
    is_missing: bool,
}

impl TraceFault {
    fn new(key: &'static str, text: impl Into<String>) -> Self {
        Self { key, text: text.into(), is_missing: false }
    }

    /// A key that this file needs.
    fn missing(key: &'static str, wanted: impl Into<String>) -> Self {
        Self { key, text: wanted.into(), is_missing: true }
    }
}

impl Column {
    const WANTED: &str = "the name of a column, or its number from 1";

    /// Reads a key that names a column, if it is there; `wanted` says what it must be.
    fn optional(
        section: &mut Section<'_>,
        key: &'static str,
        wanted: &str,
    ) -> Result<Option<Self>, SceneError> {
        if !section.has(key) {
            return Ok(None);
        }
        if let Some(name) = section.text(key) {
            return Ok(Some(Self::Name(name.to_owned())));
        }
        match section.optional_number(key) {
            Ok(Some(number)) if number.fract() == 0.0 => Ok(Some(Self::Number(number as usize))),
            _ => Err(section.refuse(key, format!("must be {wanted}"))),
        }
    }
}

/// The keys of the acceleration for each unit of the file, and of a resampling.
const SCALE: &str = "scale_m_per_s2";
const RESAMPLED: &str = "resample_hz";
const GAP: &str = "longest_gap_samples";

/// A number of the file, read at `place`, times `scale`, in m/s².
fn scaled(value: f64, scale: f64, place: impl FnOnce() -> String) -> Result<f64, TraceFault> {
    let scaled = value * scale;
    // Not-a-number is refused too.
    if scaled.abs() <= HIGHEST_ACCELERATION {
        return Ok(scaled);
    }
    let place = place();
    let text = format!("{place}: {value} times scale_m_per_s2 must be within {HIGHEST_ACCELERATION:e} m/s2");
    Err(TraceFault::new("path", text))
}

/// Refuses a trace between whose samples there is nothing, which ends at `place`.
fn enough(samples: &[f64], place: &str) -> Result<(), TraceFault> {
    let count = samples.len();
    if count >= 2 {
        return Ok(());
    }
    Err(TraceFault::new("path", format!("{place}: ends with {count} samples, must have at least 2")))
}

/// The recording that `[excitation]` names, if it names one; the name is relative to the scene file.
pub(super) fn path(section: &mut Section<'_>) -> Option<PathBuf> {
    let path = section.text("path")?;
    Some(section.file().parent().map_or_else(|| path.into(), |folder| folder.join(path)))
}

/// Samples in m/s², their rate in Hz, and how many were moved to even times and how many fill gaps.
type Samples = (Vec<f64>, f64, Option<[usize; 2]>);

/// Brings columns of samples of these times in s and lines of a file to even times of a rate in Hz from the first one on, as by
/// `resample_hz`; up to two missing ones are filled. Gives how many were moved, and how many fill gaps.
///
/// # Errors
/// Why they cannot be resampled.
pub fn resample<'c>(
    (times, lines): (&[f64], &[u64]),
    columns: impl Iterator<Item = &'c mut Vec<f64>>,
    rate_hz: f64,
) -> Result<[usize; 2], String> {
    let times = clock::Times { seconds: times.to_owned(), lines: lines.to_owned() };
    let mut counts = None;
    for samples in columns {
        (*samples, _, counts) =
            times.resampled(samples, (rate_hz, 2), "time_s").map_err(|fault| fault.text)?;
    }
    Ok(counts.unwrap_or_default())
}

/// Reads the keys of an excitation from a file, and the file.
pub(super) fn trace(section: &mut Section<'_>) -> Result<Trace, SceneError> {
    let scale = section.optional_number(SCALE)?;
    let repeat = section.flag("repeat")?;
    let column = Column::optional(section, "column", Column::WANTED)?;
    let Some(full) = path(section) else {
        return Err(section.must_be("path", "the name of a CSV or WAV file"));
    };
    let rate_hz = section.optional_number("rate_hz")?;
    let bound = section.bound("rate_hz");
    let longest_gap = section.whole_number(GAP)?;
    let resampling = section.optional_number(RESAMPLED)?.map(|rate_hz| (rate_hz, longest_gap));
    match resampling {
        Some(_) if rate_hz.is_some() => return Err(section.refuse(RESAMPLED, "must not be beside rate_hz")),
        None if section.has(GAP) => return Err(section.refuse(GAP, "must be beside resample_hz")),
        _ => {}
    }
    let is_wave = full.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("wav"));
    let (samples, rate_hz, resampled) = if is_wave {
        if let Some(key) = ["time_column", RESAMPLED].into_iter().find(|key| section.has(key)) {
            return Err(section.refuse(key, "unknown key for a WAV file, which has no times"));
        }
        scale
            .ok_or_else(|| TraceFault::missing(SCALE, section.bound(SCALE).to_string()))
            .and_then(|scale| wave::samples(&full, column.as_ref(), scale, rate_hz, bound))
            .map(|(samples, rate_hz)| (samples, rate_hz, None))
    } else {
        let clock = AskedClock::read(section)?;
        table::samples(&full, &Asked { column, clock, rate_hz, resampling, scale }, bound)
    }
    .map_err(|fault| {
        let TraceFault { key, text, is_missing } = fault;
        if is_missing {
            section.missing(key, &format!("{text} ({})", full.display()))
        } else {
            section.refuse(key, format!("{}: {text}", full.display()))
        }
    })?;
    Ok(Trace { samples_m_per_s2: samples.into(), rate_hz, repeat, resampled })
}
