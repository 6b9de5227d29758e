//! The excitation of a scene file as one of the core's.

use model_core::excitation::{AfterLastSample, Excitation, ExcitationError, Sampled, Silence, Sine, Tones};
use model_core::scalar::{Mathematics, Scalar};

use harvester_scene::method::{Failure, Options};
use harvester_scene::scene_file::{self, Scene, Tone};

/// Sines that a sum may have.
const MOST_TONES: usize = 32;

/// The core's excitation for any scene file, behind a reference: the run is compiled once for all of them.
pub(super) type HostExcitation<'a, S> = &'a dyn Excitation<S>;

/// What every run of a scene needs, whatever the scene is.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a, S> {
    pub(super) scene: &'a Scene,
    pub(super) options: &'a Options,
    pub(super) excitation: HostExcitation<'a, S>,
    /// Name of the elementary functions.
    pub(super) math: &'static str,
}

/// Calls `with` with the setting of a scene in the precision `S` with the elementary functions `M`.
///
/// The samples of a trace are converted here and live for the call.
pub(super) fn with_setting<S, M, R>(
    scene: &Scene,
    options: &Options,
    with: impl FnOnce(Setting<'_, S>) -> Result<R, Failure>,
) -> Result<R, Failure>
where
    S: Scalar,
    M: Mathematics<S>,
{
    let refuse = |error: ExcitationError| Failure::of_file(scene, format!("excitation: {error}"));
    let with =
        |excitation: HostExcitation<'_, S>| with(Setting { scene, options, excitation, math: M::NAME });
    match &scene.excitation {
        scene_file::Excitation::Silence => with(&Silence),
        scene_file::Excitation::Sine(tone) => with(&sine::<S, M>(tone).map_err(refuse)?),
        scene_file::Excitation::Sines(list) => {
            let mut tones = Tones::<S, MOST_TONES, M>::new();
            for tone in list {
                tones.push(sine(tone).map_err(refuse)?).map_err(|_| {
                    let count = list.len();
                    Failure::of_file(
                        scene,
                        format!("excitation.tones: {count} tones, must be at most {MOST_TONES}"),
                    )
                })?;
            }
            with(&tones)
        }
        scene_file::Excitation::File(trace) => {
            let samples: Vec<S> = trace.samples_m_per_s2.iter().map(|&sample| S::from_f64(sample)).collect();
            let after = if trace.repeat { AfterLastSample::Repeat } else { AfterLastSample::Silence };
            with(&Sampled::new(&samples, S::from_f64(trace.rate_hz), after).map_err(refuse)?)
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
