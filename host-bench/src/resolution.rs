//! Whether an excitation meets the resonances of a scene: a sine is near one, or the lines or samples of another one resolve them.

use crate::outcome::{BumpStopOutcome, Outcome};
use crate::scene_file::{Excitation, Scene};

/// Least number of lines in the half-power bandwidth of a resonance. With fewer the response is a beat of few sines.
const LEAST_LINES: f64 = 4.0;

/// The natural frequencies in Hz of a scene that has given `outcome`, and their damping ratio.
pub(crate) fn resonances(scene: &Scene, outcome: &Outcome) -> (Vec<f64>, f64) {
    let of_beam = |found: &BumpStopOutcome| {
        [&found.beam_natural_frequencies_hz[..], &found.rod_natural_frequencies_hz].concat()
    };
    let frequencies = match scene.contact_separation() {
        Ok(model) => vec![model.parameters.natural_frequency_hz()],
        Err(_) => outcome.bump_stop().map_or_else(
            || outcome.sliding().and_then(|found| found.natural_frequency_hz).into_iter().collect(),
            of_beam,
        ),
    };
    (frequencies, scene.model.summary().damping_ratio)
}

/// How a warning of a sine that is far from every resonance begins.
const FAR: &str = "excitation.frequency_hz";
/// Factor between the frequency of a sine and a natural frequency beyond which the resonance has no part in the motion. The
/// displacement is then within 1 % of that without inertia (`1/(1 − 0.1²)` below), or of that without a spring (above).
const FARTHEST: f64 = 10.0;

/// What to know of the excitation before the numbers of a run are used.
pub(crate) fn remarks(scene: &Scene, outcome: &Outcome) -> impl Iterator<Item = String> {
    [far_from_resonance(scene, outcome), too_few_lines(scene, outcome), resampled(scene)]
        .into_iter()
        .flatten()
}

/// What a resampling did to the recording.
fn resampled(scene: &Scene) -> Option<String> {
    let Excitation::File(trace) = &scene.excitation else { return None };
    let ([moved, filled], rate_hz, count) = (trace.resampled?, trace.rate_hz, trace.samples_m_per_s2.len());
    Some(format!(
        "excitation.resample_hz = {rate_hz}: of {count} samples {moved} are moved to even times, {filled} fill gaps"
    ))
}

/// Whether a warning is that of a sine that is far from every resonance.
pub(crate) fn is_of_a_far_sine(warning: &str) -> bool {
    warning.starts_with(FAR)
}

/// The warning of a sine that is far from every resonance, as a wrong unit of a mass or a stiffness makes it.
fn far_from_resonance(scene: &Scene, outcome: &Outcome) -> Option<String> {
    let frequency = scene.excitation.single_frequency()?;
    let (resonances, _) = resonances(scene, outcome);
    let apart = |natural: &f64| (frequency / natural).max(natural / frequency);
    let natural = resonances.into_iter().min_by(|one, other| apart(one).total_cmp(&apart(other)))?;
    let keys = scene.model.summary().frequency_keys;
    (apart(&natural) > FARTHEST).then(|| {
        format!(
            "{FAR} = {frequency} is a factor of {:.1} from the natural frequency of {natural:.4} Hz: no resonance answers; are \
             the units of the frequency, of {keys} right?",
            apart(&natural)
        )
    })
}

/// The natural frequency that a recording should resolve: the lowest one of a scene that has given `outcome`.
pub(crate) fn natural_frequency_hz(scene: &Scene, outcome: &Outcome) -> Option<f64> {
    resonances(scene, outcome).0.into_iter().reduce(f64::min)
}

/// The warning of a random excitation whose lines are too far apart for a resonance in its band.
fn too_few_lines(scene: &Scene, outcome: &Outcome) -> Option<String> {
    let random = scene.excitation.random()?;
    let (frequencies, damping_ratio) = resonances(scene, outcome);
    let few = frequencies.into_iter().find_map(|frequency| {
        let spacing = random.spacing_hz(frequency)?;
        let bandwidth = 2.0 * damping_ratio * frequency;
        (LEAST_LINES * spacing > bandwidth).then_some((frequency, spacing, bandwidth))
    });
    few.map(|(frequency, spacing, bandwidth)| {
        format!(
            "excitation.lines = {}: the lines are {spacing:.2e} Hz apart at the resonance of {frequency:.4} Hz, whose \
             half-power bandwidth of {bandwidth:.2e} Hz should hold {LEAST_LINES}: its response is a beat of few sines; \
             give more lines or a narrower band",
            random.lines
        )
    })
}
