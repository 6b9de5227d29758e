//! `[excitation]`.

use super::GRAVITY;
use super::document::SceneError;
use super::key::{Bound, Key, Kind, Short, Table, Value, between, number, other, whole, words};
use super::scene::{Burst, BurstShape, Excitation, Random, Sweep, Tone};
use super::section::{Reader, Section};
use super::trace;
use super::trace::HIGHEST_ACCELERATION;
use model_core::bounds::Bounds;
use model_core::excitation::DENSITY_FREQUENCY;

pub(super) static TABLE: Table =
    Table::of_kinds(&[&SINE, &SINES, &trace::FILE, &RANDOM, &HALF_SINE, &BURSTS, &SWEEP, &SILENCE]);

static SINE: Kind = Kind { word: "sine", meaning: "A sin(2π f t + phase)", keys: TONE };
static SINES: Kind = Kind {
    word: "sines",
    meaning: "A sum of sines",
    keys: &[other("tones", Value::Tables(&TONES), "The sines, each with the keys of a sine")],
};
static TONES: Table = Table::of(TONE);
const TONE: &[Key] =
    &[METRIC, IN_GRAVITIES, number("frequency_hz", "Hz", between(0.0, 1e6), "Frequency"), PHASE];
static RANDOM: Kind = Kind {
    word: "random",
    meaning: "A random acceleration with a one-sided spectral density",
    keys: &[
        other(
            "spectral_density_g2_per_hz",
            Value::Points(between(1e-13, 1e6), MOST_POINTS),
            "Spectral density: points of frequency and density, straight in logarithmic axes",
        )
        .unit("g²/Hz")
        .limit("frequencies 1e-3 to 1e5 Hz, rising")
        .instead_of("spectral_density_m2_per_s3"),
        other(
            "spectral_density_m2_per_s3",
            Value::Points(between(1e-12, 1e8), MOST_POINTS),
            "The same in (m/s²)²/Hz",
        )
        .unit("m²/s³")
        .limit("frequencies 1e-3 to 1e5 Hz, rising")
        .instead_of("spectral_density_g2_per_hz"),
        whole("seed", "", between(0.0, 4_294_967_295.0), "Seed of frequencies and phases"),
        whole(
            "lines",
            "",
            between(16.0, Random::MOST_LINES as f64),
            "Sines that the acceleration is a sum of",
        )
        .or_number(1024.0),
    ],
};
static HALF_SINE: Kind = Kind {
    word: "half-sine",
    meaning: "Shocks of half a sine",
    keys: &[
        METRIC,
        IN_GRAVITIES,
        number("duration_s", "s", between(1e-6, 1e6), "Length of a shock"),
        START,
        PERIOD,
    ],
};
static BURSTS: Kind = Kind {
    word: "bursts",
    meaning: "Bursts of whole cycles of a sine",
    keys: &[
        METRIC,
        IN_GRAVITIES,
        number("frequency_hz", "Hz", between(1e-6, 1e6), "Frequency in a burst"),
        whole("cycles", "", between(1.0, 1e6), "Cycles of a burst").limit("at most 1e6 s"),
        START,
        PERIOD,
    ],
};
static SWEEP: Kind = Kind {
    word: "sweep",
    meaning: "A sine whose frequency goes up and down",
    keys: &[
        METRIC,
        IN_GRAVITIES,
        number("from_hz", "Hz", SWEEP_FREQUENCY, "Frequency at the start"),
        number("to_hz", "Hz", SWEEP_FREQUENCY, "Frequency at the other end")
            .limit("a factor of at least 1.001 apart"),
        number("sweep_s", "s", between(1e-3, 1e5), "Time from one end to the other"),
        other("law", Value::Words(&words(&LAWS)), "Frequency over time"),
        PHASE,
    ],
};
static SILENCE: Kind = Kind { word: "silence", meaning: "A base at rest", keys: &[] };

const METRIC: Key = number(
    "amplitude_m_per_s2",
    "m/s²",
    between(0.0, HIGHEST_ACCELERATION),
    "Amplitude of the base acceleration",
)
.instead_of("amplitude_g");
const IN_GRAVITIES: Key = number("amplitude_g", "g", between(0.0, 1e4), "The same in g = 9.81 m/s²")
    .instead_of("amplitude_m_per_s2");
const PHASE: Key = number("phase_rad", "rad", between(-1e3, 1e3), "Phase at the time 0").or_number(0.0);
const START: Key = number("start_s", "s", between(0.0, 1e6), "Start of the first one").or_number(0.0);
const PERIOD: Key = number("period_s", "s", between(1e-6, 1e6), "Time from one to the next")
    .limit("at least the length of one")
    .or_said("only one");
const LAWS: [(&str, bool); 2] = [("linear", false), ("logarithmic", true)];

/// Frequencies of a sweep in Hz.
const SWEEP_FREQUENCY: Bounds<f64> = between(1e-3, 1e6);
/// Least quotient of the frequencies of a sweep.
const LEAST_RATIO: f64 = 1.001;
/// Longest burst in s.
const LONGEST_BURST: f64 = 1e6;
/// Most points of a spectral density.
const MOST_POINTS: usize = 1000;

/// Reads `[excitation]`, and the trace it names.
pub(super) fn excitation(mut section: Section<'_>) -> Result<Excitation, SceneError> {
    let kinds: [(&Kind, Reader<Excitation>); 8] = [
        (&SINE, |section| tone(section).map(Excitation::Sine)),
        (&SINES, |section| {
            let tones = section.tables("tones")?.into_iter();
            tones.map(whole_tone).collect::<Result<_, _>>().map(Excitation::Sines)
        }),
        (&trace::FILE, |section| trace::trace(section).map(Excitation::File)),
        (&HALF_SINE, |section| half_sine(section).map(Excitation::Burst)),
        (&BURSTS, |section| bursts(section).map(Excitation::Burst)),
        (&SWEEP, |section| sweep(section).map(Excitation::Sweep)),
        (&RANDOM, |section| random(section).map(Excitation::Random)),
        (&SILENCE, |_| Ok(Excitation::Silence)),
    ];
    let excitation = section.kind(&kinds)?(&mut section)?;
    section.finish()?;
    Ok(excitation)
}

/// Reads a table that is a tone.
fn whole_tone(mut section: Section<'_>) -> Result<Tone, SceneError> {
    let tone = tone(&mut section)?;
    section.finish()?;
    Ok(tone)
}

fn tone(section: &mut Section<'_>) -> Result<Tone, SceneError> {
    Ok(Tone {
        amplitude_m_per_s2: amplitude(section)?,
        frequency_hz: section.number("frequency_hz")?,
        phase_rad: section.number("phase_rad")?,
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
    let start_s = section.number("start_s")?;
    let period_s = section.optional_number("period_s")?;
    let burst = Burst { amplitude_m_per_s2, shape, start_s, period_s };
    let length = burst.length_s();
    if period_s.is_some_and(|period| period < length) {
        let reason = format!("must not be shorter than the {} s of one", Short(length));
        return Err(section.refuse("period_s", reason));
    }
    Ok(burst)
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
        logarithmic: section.choice("law", &LAWS)?,
        phase_rad: section.number("phase_rad")?,
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
    let lines = section.whole_number("lines")?;
    let seed = section.whole_number("seed")?;
    // The bound of the lines is below 2³².
    let drawn = Random::new(density, lines as u32, seed as u64);
    drawn.map_err(|error| section.refuse(key, error.to_string()))
}

/// The points of a spectral density in (m/s²)²/Hz; `unit` is that of the file in it.
fn density(section: &mut Section<'_>, key: &'static str, unit: f64) -> Result<Vec<[f64; 2]>, SceneError> {
    let given = section.points(key)?;
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
