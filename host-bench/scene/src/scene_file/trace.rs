//! A recorded acceleration in a CSV or a WAV file.

mod table;
mod wave;

use super::bounds::Bound;
use super::document::SceneError;
use super::scene::Trace;
use super::section::Section;

/// Largest acceleration of the base in m/s².
pub(super) const HIGHEST_ACCELERATION: f64 = 1e5;

/// Which column of a table, or channel of a recording.
#[derive(Debug, Clone, PartialEq)]
enum Column {
    /// By its name in the first row.
    Name(String),
    /// By its number, from 1; a first row that is not a number there is a heading.
    Number(usize),
}

/// Why a trace was refused, and the key to blame.
#[derive(Debug, Clone, PartialEq, Eq)]
struct TraceFault {
    key: &'static str,
    text: String,
}

impl TraceFault {
    fn new(key: &'static str, text: impl Into<String>) -> Self {
        Self { key, text: text.into() }
    }
}

impl Column {
    const WANTED: &str = "the name of a column, or its number from 1";

    /// Reads a key that names a column, if it is there.
    fn optional(section: &mut Section<'_>, key: &'static str) -> Result<Option<Self>, SceneError> {
        if !section.has(key) {
            return Ok(None);
        }
        if let Some(name) = section.text(key) {
            return Ok(Some(Self::Name(name.to_owned())));
        }
        match section.optional_number(key) {
            Ok(Some(number)) if number.fract() == 0.0 => Ok(Some(Self::Number(number as usize))),
            _ => Err(section.refuse(key, format!("must be {}", Self::WANTED))),
        }
    }

    /// Reads a key that names a column and must be there.
    fn read(section: &mut Section<'_>, key: &'static str) -> Result<Self, SceneError> {
        Self::optional(section, key)?
            .ok_or_else(|| section.refuse(key, format!("is missing; must be {}", Self::WANTED)))
    }
}

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

/// Reads the keys of an excitation from a file, and the file.
pub(super) fn trace(section: &mut Section<'_>) -> Result<Trace, SceneError> {
    let scale = section.number("scale_m_per_s2")?;
    let repeat = section.flag("repeat", false)?;
    let column = Column::read(section, "column")?;
    let Some(path) = section.text("path") else {
        let absent = if section.has("path") { "" } else { "is missing; " };
        return Err(section.refuse("path", format!("{absent}must be the name of a CSV or WAV file")));
    };
    let full = section.file().parent().map_or_else(|| path.into(), |folder| folder.join(path));
    let is_wave = full.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("wav"));
    let (samples, rate_hz) = if is_wave {
        let told = section.optional_number("rate_hz")?;
        wave::samples(&full, &column, scale, told, section.bound("rate_hz"))
    } else {
        let rate_hz = section.number("rate_hz")?;
        let clock = Column::optional(section, "time_column")?;
        table::samples(&full, &column, scale, clock.as_ref(), rate_hz).map(|samples| (samples, rate_hz))
    }
    .map_err(|fault| section.refuse(fault.key, format!("{}: {}", full.display(), fault.text)))?;
    Ok(Trace { samples_m_per_s2: samples.into(), rate_hz, repeat })
}
