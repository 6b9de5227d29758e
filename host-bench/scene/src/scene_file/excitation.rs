//! `[excitation]`.

use super::GRAVITY;
use super::bounds;
use super::document::SceneError;
use super::scene::{Excitation, Tone};
use super::section::Section;
use super::trace;

#[derive(Debug, Clone, Copy)]
enum Kind {
    Sine,
    Sines,
    File,
    Silence,
}

/// Reads `[excitation]`, and the trace it names.
pub(super) fn excitation(mut section: Section<'_>) -> Result<Excitation, SceneError> {
    let kind = section.choice(
        "kind",
        &[("sine", Kind::Sine), ("sines", Kind::Sines), ("file", Kind::File), ("silence", Kind::Silence)],
    )?;
    let excitation = match kind {
        Kind::Silence => Excitation::Silence,
        Kind::Sine => Excitation::Sine(tone(&mut section)?),
        Kind::Sines => {
            let tones = section.tables("tones")?.into_iter().map(|mut section| {
                let tone = tone(&mut section)?;
                section.finish()?;
                Ok(tone)
            });
            Excitation::Sines(tones.collect::<Result<_, SceneError>>()?)
        }
        Kind::File => Excitation::File(trace::trace(&mut section)?),
    };
    section.finish()?;
    Ok(excitation)
}

fn tone(section: &mut Section<'_>) -> Result<Tone, SceneError> {
    let metric = section.optional_number("amplitude_m_per_s2", &bounds::of("amplitude_m_per_s2"))?;
    let in_gravities = section.optional_number("amplitude_g", &bounds::of("amplitude_g"))?;
    let amplitude_m_per_s2 = match (metric, in_gravities) {
        (Some(amplitude), None) => amplitude,
        (None, Some(gravities)) => gravities * GRAVITY,
        (None, None) => {
            let bound = bounds::of("amplitude_m_per_s2");
            return Err(section.refuse(
                "amplitude_m_per_s2",
                format!("is missing, and so is amplitude_g; must be {bound}"),
            ));
        }
        (Some(_), Some(_)) => {
            return Err(section.refuse("amplitude_g", "must not be given beside amplitude_m_per_s2"));
        }
    };
    Ok(Tone {
        amplitude_m_per_s2,
        frequency_hz: section.number("frequency_hz", &bounds::of("frequency_hz"))?,
        phase_rad: section.optional_number("phase_rad", &bounds::of("phase_rad"))?.unwrap_or(0.0),
    })
}
