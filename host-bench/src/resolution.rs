//! Whether the lines of a random excitation resolve the resonances of a scene.

use crate::outcome::Outcome;
use crate::scene_file::{Model, Scene};

/// Least number of lines in the half-power bandwidth of a resonance. With fewer the response is a beat of few sines.
const LEAST_LINES: f64 = 4.0;

/// The natural frequencies in Hz of a scene that has given `outcome`, and their damping ratio.
fn resonances(scene: &Scene, outcome: &Outcome) -> (Vec<f64>, f64) {
    match &scene.model {
        Model::ContactSeparation(model) => {
            let parameters = &model.parameters;
            let angular = (parameters.stiffness_n_per_m / parameters.mass_kg).sqrt();
            (vec![angular / std::f64::consts::TAU], parameters.damping_ratio)
        }
        Model::Sliding(model) => {
            let found = outcome.sliding().and_then(|found| found.natural_frequency_hz);
            (found.into_iter().collect(), model.parameters.damping_ratio)
        }
        Model::BumpStop(model) => {
            let found = outcome.bump_stop().map(|found| {
                [&found.beam_natural_frequencies_hz[..], &found.rod_natural_frequencies_hz].concat()
            });
            (found.unwrap_or_default(), model.parameters.damping_ratio)
        }
    }
}

/// The warning of a random excitation whose lines are too far apart for a resonance in its band.
pub(crate) fn too_few_lines(scene: &Scene, outcome: &Outcome) -> Option<String> {
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
