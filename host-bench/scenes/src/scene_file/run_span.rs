//! `[run]`.

use super::document::SceneError;
use super::key::{Short, Table, between, number};
use super::scene::{Excitation, RunSpan};
use super::section::Section;

/// Shortest measuring window in s.
const SHORTEST_WINDOW: f64 = 1e-9;

pub(super) static TABLE: Table = Table::of(&[
    number("duration_s", "s", between(1e-6, 1e7), "End of the run").instead_of("duration_periods"),
    number("duration_periods", "periods of the sine", between(0.0, 1e12), "The same in periods")
        .limit("1e-6 to 1e7 s; an excitation of one sine")
        .instead_of("duration_s"),
    number("settle_s", "s", between(0.0, 1e7), "Results are measured from this time to the end")
        .limit("before the end of the run")
        .or_number(0.0)
        .instead_of("settle_periods"),
    number("settle_periods", "periods of the sine", between(0.0, 1e12), "The same in periods")
        .limit("0 to 1e7 s; an excitation of one sine")
        .or_number(0.0)
        .instead_of("settle_s"),
]);

pub(super) fn run_span(mut section: Section<'_>, excitation: &Excitation) -> Result<RunSpan, SceneError> {
    let (duration_key, duration) = span(&mut section, excitation, ["duration_s", "duration_periods"])?;
    let Some(duration_s) = duration else {
        let wanted = section.bound(duration_key).to_string();
        return Err(section.missing_of(&["duration_s", "duration_periods"], &wanted));
    };
    let (settle_key, settle) = span(&mut section, excitation, ["settle_s", "settle_periods"])?;
    let settle_s = settle.unwrap_or(0.0);
    if settle_s > duration_s - SHORTEST_WINDOW {
        let (settle, end) = (Short(settle_s), Short(duration_s));
        let reason = format!("{settle} s must be before the end of the run at {end} s");
        return Err(section.refuse(settle_key, reason));
    }
    if let Excitation::File(trace) = excitation {
        let length = (trace.samples_m_per_s2.len() - 1) as f64 / trace.rate_hz;
        if !trace.repeat && length < duration_s * (1.0 - 1e-12) {
            let length = Short(length);
            let reason =
                format!("the trace is {length} s long; must not be longer, or excitation.repeat be true");
            return Err(section.refuse(duration_key, reason));
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
    let seconds = section.optional_number(seconds_key)?;
    let Some(periods) = section.optional_number(periods_key)? else {
        return Ok((seconds_key, seconds));
    };
    if seconds.is_some() {
        return Err(section.refuse(periods_key, format!("must not be given beside {seconds_key}")));
    }
    let Some(frequency) = excitation.single_frequency() else {
        let reason = format!("needs an excitation of one sine with a frequency above 0; give {seconds_key}");
        return Err(section.refuse(periods_key, reason));
    };
    let value = periods / frequency;
    let bound = section.bound(seconds_key);
    if !bound.contains(value) {
        let reason = format!("is {} s, must be {bound} s", Short(value));
        return Err(section.refuse(periods_key, reason));
    }
    Ok((periods_key, Some(value)))
}
