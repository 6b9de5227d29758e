//! `[excitation]`.

use super::GRAVITY;
use super::bounds::{Bound, Short, Table, between};
use super::document::SceneError;
use super::scene::{Burst, BurstShape, Excitation, Random, Sweep, Tone};
use super::section::{Reader, Section};
use super::trace;
use super::trace::HIGHEST_ACCELERATION;
use model_core::bounds::Bounds;
use model_core::excitation::DENSITY_FREQUENCY;

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
    ("duration_s", between(1e-6, 1e6)),
    ("cycles", between(1.0, 1e6)),
    ("start_s", between(0.0, 1e6)),
    ("period_s", between(1e-6, 1e6)),
    ("from_hz", SWEEP_FREQUENCY),
    ("to_hz", SWEEP_FREQUENCY),
    ("sweep_s", between(1e-3, 1e5)),
    ("spectral_density_g2_per_hz", between(1e-13, 1e6)),
    ("spectral_density_m2_per_s3", between(1e-12, 1e8)),
    ("seed", between(0.0, 4_294_967_295.0)),
    ("lines", between(16.0, Random::MOST_LINES as f64)),
]];

/// Frequencies of a sweep in Hz.
const SWEEP_FREQUENCY: Bounds<f64> = between(1e-3, 1e6);
/// Bounds of a burst, whose frequency is not 0.
const BURST: &[Table] = &[&[("frequency_hz", between(1e-6, 1e6))], EXCITATION[0]];
/// Least quotient of the frequencies of a sweep.
const LEAST_RATIO: f64 = 1.001;
/// Longest burst in s.
const LONGEST_BURST: f64 = 1e6;
/// Lines of a random acceleration, where the file says nothing.
const LINES: f64 = 1024.0;
/// Most points of a spectral density.
const MOST_POINTS: usize = 1000;

/// Reads `[excitation]`, and the trace it names.
pub(super) fn excitation(mut section: Section<'_>) -> Result<Excitation, SceneError> {
    section.bounded_by(EXCITATION);
    let kinds: [(&str, Reader<Excitation>); 8] = [
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
        ("half-sine", |section| half_sine(section).map(Excitation::Burst)),
        ("bursts", |section| bursts(section).map(Excitation::Burst)),
        ("sweep", |section| sweep(section).map(Excitation::Sweep)),
        ("random", |section| random(section).map(Excitation::Random)),
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
    Ok(Tone {
        amplitude_m_per_s2: amplitude(section)?,
        frequency_hz: section.number("frequency_hz")?,
        phase_rad: section.number_or("phase_rad", Some(0.0))?,
    })
}

/// An amplitude in m/s², given in that unit or in g.
fn amplitude(section: &mut Section<'_>) -> Result<f64, SceneError> {
    let metric = section.optional_number("amplitude_m_per_s2")?;
    let in_gravities = section.optional_number("amplitude_g")?;
    match (metric, in_gravities) {
        (Some(amplitude), None) => Ok(amplitude),
        (None, Some(gravities)) => Ok(gravities * GRAVITY),
        (None, None) => {
            let wanted = section.bound("amplitude_m_per_s2").to_string();
            Err(section.missing_of(&["amplitude_m_per_s2", "amplitude_g"], &wanted))
        }
        (Some(_), Some(_)) => {
            Err(section.refuse("amplitude_g", "must not be given beside amplitude_m_per_s2"))
        }
    }
}

fn half_sine(section: &mut Section<'_>) -> Result<Burst, SceneError> {
    let amplitude_m_per_s2 = amplitude(section)?;
    let duration_s = section.number("duration_s")?;
    repeated(section, amplitude_m_per_s2, BurstShape::HalfSine { duration_s })
}

fn bursts(section: &mut Section<'_>) -> Result<Burst, SceneError> {
    section.bounded_by(BURST);
    let amplitude_m_per_s2 = amplitude(section)?;
    let frequency_hz = section.number("frequency_hz")?;
    let cycles = section.whole_number("cycles")?;
    let length = cycles as f64 / frequency_hz;
    if length > LONGEST_BURST {
        let reason = format!("a burst is {} s long, must be at most {LONGEST_BURST:e} s", Short(length));
        return Err(section.refuse("cycles", reason));
    }
    // The bound of the cycles is below 2³².
    repeated(section, amplitude_m_per_s2, BurstShape::Cycles { frequency_hz, cycles: cycles as u32 })
}

/// A burst, with its start and its period.
fn repeated(
    section: &mut Section<'_>,
    amplitude_m_per_s2: f64,
    shape: BurstShape,
) -> Result<Burst, SceneError> {
    let start_s = section.number_or("start_s", Some(0.0))?;
    let period_s = section.optional_number("period_s")?;
    let burst = Burst { amplitude_m_per_s2, shape, start_s, period_s };
    let length = burst.length_s();
    match period_s {
        Some(period) if period < length => {
            let reason = format!("must not be shorter than the {} s of one", Short(length));
            Err(section.refuse("period_s", reason))
        }
        _ => Ok(burst),
    }
}

fn sweep(section: &mut Section<'_>) -> Result<Sweep, SceneError> {
    let amplitude_m_per_s2 = amplitude(section)?;
    let [from_hz, to_hz] = [section.number("from_hz")?, section.number("to_hz")?];
    if from_hz.max(to_hz) < LEAST_RATIO * from_hz.min(to_hz) {
        let reason = format!("must differ from from_hz by a factor of at least {LEAST_RATIO}");
        return Err(section.refuse("to_hz", reason));
    }
    Ok(Sweep {
        amplitude_m_per_s2,
        from_hz,
        to_hz,
        sweep_s: section.number("sweep_s")?,
        logarithmic: section.choice("law", &[("linear", false), ("logarithmic", true)])?,
        phase_rad: section.number_or("phase_rad", Some(0.0))?,
    })
}

fn random(section: &mut Section<'_>) -> Result<Random, SceneError> {
    const KEYS: [&str; 2] = ["spectral_density_g2_per_hz", "spectral_density_m2_per_s3"];
    let [in_gravities, metric] = KEYS;
    let (key, unit) = match (section.has(in_gravities), section.has(metric)) {
        (true, false) => (in_gravities, GRAVITY * GRAVITY),
        (false, true) => (metric, 1.0),
        (true, true) => {
            return Err(section.refuse(in_gravities, format!("must not be given beside {metric}")));
        }
        (false, false) => {
            return Err(section.missing_of(&KEYS, "a list of points [Hz, density], at least two"));
        }
    };
    let density = density(section, key, unit)?;
    let lines = if section.has("lines") { section.whole_number("lines")? } else { LINES as usize };
    let seed = section.whole_number("seed")?;
    // The bound of the lines is below 2³².
    let drawn = Random::new(density, lines as u32, seed as u64);
    drawn.map_err(|error| section.refuse(key, error.to_string()))
}

/// The points of a spectral density in (m/s²)²/Hz; `unit` is that of the file in it.
fn density(section: &mut Section<'_>, key: &'static str, unit: f64) -> Result<Vec<[f64; 2]>, SceneError> {
    let given = section.points(key, MOST_POINTS)?;
    let frequencies = Bound::from(DENSITY_FREQUENCY);
    // In either unit within that of the library.
    let densities = section.bound(key);
    let mut last: Option<f64> = None;
    for (index, [frequency, density]) in given.iter().enumerate() {
        let refusal = if !frequencies.contains(*frequency) {
            Some(format!("the frequency of point {index} is {}, must be {frequencies} Hz", Short(*frequency)))
        } else if !densities.contains(*density) {
            Some(format!("the density of point {index} is {}, must be {densities}", Short(*density)))
        } else {
            last.filter(|last| frequency <= last).map(|last| {
                let (frequency, last) = (Short(*frequency), Short(last));
                format!(
                    "the frequency of point {index} is {frequency} Hz, must be above the {last} Hz before it"
                )
            })
        };
        if let Some(reason) = refusal {
            return Err(section.refuse(key, reason));
        }
        last = Some(*frequency);
    }
    Ok(given.into_iter().map(|[frequency, density]| [frequency, density * unit]).collect())
}

#[cfg(test)]
mod tests;
