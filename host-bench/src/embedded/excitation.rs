//! The excitation of a scene file as one of the core's.

use model_core::excitation::{AfterLastSample, AnyExcitation, ExcitationError, Sampled, Sine, Tones};
use model_core::scalar::{Mathematics, Scalar};

use crate::method::Failure;
use crate::scene_file::{Excitation, Scene, Tone};

/// Sines that a sum may have.
const MOST_TONES: usize = 32;

/// The core's excitation for any scene file.
pub(super) type HostExcitation<'a, S, M> = AnyExcitation<'a, S, MOST_TONES, M>;

/// Calls `with` with the scene's excitation in the precision `S`.
///
/// The samples of a trace are converted here and live for the call.
///
/// # Errors
/// [`Failure::Input`] if the core refuses it, and whatever `with` gives.
pub(super) fn with_excitation<S, M, R>(
    scene: &Scene,
    with: impl FnOnce(&HostExcitation<'_, S, M>) -> Result<R, Failure>,
) -> Result<R, Failure>
where
    S: Scalar,
    M: Mathematics<S>,
{
    let refuse =
        |error: ExcitationError| Failure::Input(format!("{}: excitation: {error}", scene.file.display()));
    match &scene.excitation {
        Excitation::Silence => with(&AnyExcitation::Silence),
        Excitation::Sine(tone) => with(&AnyExcitation::Sine(sine(tone).map_err(refuse)?)),
        Excitation::Sines(list) => {
            let mut tones = Tones::new();
            for tone in list {
                tones.push(sine(tone).map_err(refuse)?).map_err(|_| {
                    Failure::Input(format!(
                        "{}: excitation.tones: {} tones, must be at most {MOST_TONES}",
                        scene.file.display(),
                        list.len()
                    ))
                })?;
            }
            with(&AnyExcitation::Tones(tones))
        }
        Excitation::File(trace) => {
            let samples: Vec<S> = trace.samples_m_per_s2.iter().map(|&sample| S::from_f64(sample)).collect();
            let after = if trace.repeat { AfterLastSample::Repeat } else { AfterLastSample::Silence };
            let sampled = Sampled::new(&samples, S::from_f64(trace.rate_hz), after).map_err(refuse)?;
            with(&AnyExcitation::Sampled(sampled))
        }
    }
}

fn sine<S: Scalar, M: Mathematics<S>>(tone: &Tone) -> Result<Sine<S, M>, ExcitationError> {
    Sine::new(
        S::from_f64(tone.amplitude_m_per_s2),
        S::from_f64(tone.frequency_hz),
        S::from_f64(tone.phase_rad),
    )
}
