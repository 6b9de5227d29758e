//! A slightly changed scene, from which a chaotic motion diverges and no other does.

use crate::scene_file::{Excitation, Model, Scene};

/// Relative change of the base acceleration or of the start: far above the rounding of `f64`, far below any error that
/// matters.
pub(crate) const SHIFT: f64 = 1e-9;

/// The scene with a base acceleration `1 + shift` times as large; `None` if the base is at rest.
pub(crate) fn shaken(scene: &Scene, shift: f64) -> Option<Scene> {
    let is_at_rest = matches!(scene.excitation, Excitation::Silence);
    let excitation = scene.excitation.scaled(1.0 + shift);
    (!is_at_rest).then(|| Scene { excitation, ..scene.clone() })
}

/// The scene with a start displaced by a part of the gap or of the radius of the patch; `None` for a beam.
pub(crate) fn displaced(scene: &Scene, shift: f64) -> Option<Scene> {
    let mut scene = scene.clone();
    match &mut scene.model {
        Model::ContactSeparation(model) => {
            let gap = model.initial.gap_m.unwrap_or(model.parameters.initial_gap_m);
            model.initial.gap_m = Some(gap * (1.0 + shift));
        }
        Model::Sliding(model) => {
            let displacement = model.initial.displacement_m.unwrap_or(0.0);
            model.initial.displacement_m = Some(displacement + model.parameters.patch_radius_m * shift);
        }
        // No length suits every scene of a beam at rest.
        Model::BumpStop(_) => return None,
    }
    Some(scene)
}
