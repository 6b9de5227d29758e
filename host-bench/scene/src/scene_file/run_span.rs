//! `[run]`.

use super::bounds::{self, Bound, Short};
use super::document::SceneError;
use super::scene::{Excitation, RunSpan};
use super::section::Section;

/// Shortest measuring window in s.
const SHORTEST_WINDOW: f64 = 1e-9;

/// Reads `[run]`.
pub(super) fn run_span(mut section: Section<'_>, excitation: &Excitation) -> Result<RunSpan, SceneError> {
    let (duration_key, duration) = span(&mut section, excitation, ["duration_s", "duration_periods"])?;
    let Some(duration_s) = duration else {
        return Err(section.refuse(duration_key, format!("is missing; must be {}", bounds::of(duration_key))));
    };
    let (settle_key, settle) = span(&mut section, excitation, ["settle_s", "settle_periods"])?;
    let settle_s = settle.unwrap_or(0.0);
    if settle_s > duration_s - SHORTEST_WINDOW {
        return Err(section.refuse(
            settle_key,
            format!("{} s must be before the end of the run at {} s", Short(settle_s), Short(duration_s)),
        ));
    }
    if let Excitation::File(trace) = excitation {
        let length = (trace.samples_m_per_s2.len() - 1) as f64 / trace.rate_hz;
        if !trace.repeat && length < duration_s * (1.0 - 1e-12) {
            return Err(section.refuse(
                duration_key,
                format!(
                    "the trace is {} s long; must not be longer, or excitation.repeat be true",
                    Short(length)
                ),
            ));
        }
    }
    section.finish()?;
    Ok(RunSpan { duration_s, settle_s })
}

/// A time in seconds, given as such or in periods of the one sine; and the key that gave it.
fn span(
    section: &mut Section<'_>,
    excitation: &Excitation,
    [seconds_key, periods_key]: [&'static str; 2],
) -> Result<(&'static str, Option<f64>), SceneError> {
    let bound = bounds::of(seconds_key);
    let seconds = section.optional_number(seconds_key, &bound)?;
    let Some(periods) = section.optional_number(periods_key, &bounds::of(periods_key))? else {
        return Ok((seconds_key, seconds));
    };
    if seconds.is_some() {
        return Err(section.refuse(periods_key, format!("must not be given beside {seconds_key}")));
    }
    let Some(frequency) = excitation.single_frequency() else {
        return Err(section.refuse(
            periods_key,
            format!("needs an excitation of one sine with a frequency above 0; give {seconds_key}"),
        ));
    };
    let value = periods / frequency;
    let Bound { lowest, highest, .. } = bound;
    if !bound.contains(value) {
        return Err(section.refuse(
            periods_key,
            format!("is {} s, must be from {} to {} s", Short(value), Short(lowest), Short(highest)),
        ));
    }
    Ok((periods_key, Some(value)))
}
