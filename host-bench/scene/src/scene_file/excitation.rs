//! `[excitation]`.

use super::GRAVITY;
use super::bounds::{Table, between};
use super::document::SceneError;
use super::scene::{Excitation, Tone};
use super::section::{Reader, Section};
use super::trace;
use super::trace::HIGHEST_ACCELERATION;

/// Bounds of `[excitation]`; a column of a file may have a number.
const EXCITATION: &[Table] = &[&[
    ("amplitude_m_per_s2", between(0.0, HIGHEST_ACCELERATION)),
    ("amplitude_g", between(0.0, 1e4)),
    ("frequency_hz", between(0.0, 1e6)),
    ("phase_rad", between(-1e3, 1e3)),
    ("rate_hz", between(1e-3, 1e6)),
    ("scale_m_per_s2", between(-1e6, 1e6)),
    ("column", between(1.0, 10_000.0)),
    ("time_column", between(1.0, 10_000.0)),
]];

/// Reads `[excitation]`, and the trace it names.
pub(super) fn excitation(mut section: Section<'_>) -> Result<Excitation, SceneError> {
    section.bounded_by(EXCITATION);
    let kinds: [(&str, Reader<Excitation>); 4] = [
        ("sine", |section| tone(section).map(Excitation::Sine)),
        ("sines", |section| {
            section
                .tables("tones")?
                .into_iter()
                .map(whole_tone)
                .collect::<Result<_, _>>()
                .map(Excitation::Sines)
        }),
        ("file", |section| trace::trace(section).map(Excitation::File)),
        ("silence", |_| Ok(Excitation::Silence)),
    ];
    let excitation = section.choice("kind", &kinds)?(&mut section)?;
    section.finish()?;
    Ok(excitation)
}

/// Reads a table that is a tone.
fn whole_tone(mut section: Section<'_>) -> Result<Tone, SceneError> {
    section.bounded_by(EXCITATION);
    let tone = tone(&mut section)?;
    section.finish()?;
    Ok(tone)
}

fn tone(section: &mut Section<'_>) -> Result<Tone, SceneError> {
    let metric = section.optional_number("amplitude_m_per_s2")?;
    let in_gravities = section.optional_number("amplitude_g")?;
    let amplitude_m_per_s2 = match (metric, in_gravities) {
        (Some(amplitude), None) => amplitude,
        (None, Some(gravities)) => gravities * GRAVITY,
        (None, None) => {
            let wanted = section.bound("amplitude_m_per_s2").to_string();
            return Err(section.missing_of(&["amplitude_m_per_s2", "amplitude_g"], &wanted));
        }
        (Some(_), Some(_)) => {
            return Err(section.refuse("amplitude_g", "must not be given beside amplitude_m_per_s2"));
        }
    };
    Ok(Tone {
        amplitude_m_per_s2,
        frequency_hz: section.number("frequency_hz")?,
        phase_rad: section.optional_number("phase_rad")?.unwrap_or(0.0),
    })
}
