//! A scene that is slightly changed, from which a chaotic motion diverges and no other does, and a scene from another start.

use crate::embedded::bump_stop_parameters;
use crate::method::{Failure, Method, Options};
use crate::outcome::{Outcome, STABLE};
use crate::scene_file::{BumpStop, BumpStopStart, Excitation, Load, Scene, Summary};

/// Relative change of the base acceleration or of the start: far above the rounding of `f64`, far below any error that matters.
pub(crate) const SHIFT: f64 = 1e-9;

/// The scene with a base acceleration `1 + shift` times as large; `None` if the base is at rest.
pub(crate) fn shaken(scene: &Scene, shift: f64) -> Option<Scene> {
    let is_at_rest = matches!(scene.excitation, Excitation::Silence);
    let excitation = scene.excitation.scaled(1.0 + shift);
    (!is_at_rest).then(|| Scene { excitation, ..scene.clone() })
}

/// The scene with a changed base acceleration, or with a displaced start where the base is at rest; the scene itself at 0.
pub(crate) fn shifted(scene: &Scene, shift: f64) -> Option<Scene> {
    if shift == 0.0 {
        return Some(scene.clone());
    }
    shaken(scene, shift).or_else(|| displaced(scene, shift))
}

/// The scene with a start displaced by a part of the gap or of the radius of the patch; `None` for a beam.
fn displaced(scene: &Scene, shift: f64) -> Option<Scene> {
    let [at, rate] = start(scene);
    // No length suits every scene of a beam at rest.
    scene.model.summary().start?;
    let length = scene.sliding().map_or(at, |model| model.parameters.patch_radius_m);
    Some(started(scene, [at + length * shift, rate]))
}

/// The start of a scene: gap, displacement of the slider or of the tip in m, and its velocity in m/s.
pub(crate) fn start(scene: &Scene) -> [f64; 2] {
    match scene.bump_stop() {
        Ok(model) => [&model.initial.modal_displacement, &model.initial.modal_velocity]
            .map(|modes| (1..).zip(modes).map(|(mode, at)| tip(model, mode) * at).sum()),
        Err(_) => {
            let Summary { rest_m, start, .. } = scene.model.summary();
            let [at, rate, _] = start.unwrap_or_default();
            [at.unwrap_or(rest_m), rate.unwrap_or_default()]
        }
    }
}

/// The scene from another [`start`], to which a beam is moved by its first mode.
pub(crate) fn started(scene: &Scene, [at, rate]: [f64; 2]) -> Scene {
    let [from, from_rate] = start(scene);
    let mut scene = scene.clone();
    if let Some([coordinate, velocity, _]) = scene.model.start_mut() {
        (*coordinate, *velocity) = (Some(at), Some(rate));
    } else if let Ok(model) = scene.bump_stop_mut() {
        let of_first = tip(model, 1);
        let BumpStopStart { modal_displacement, modal_velocity, .. } = &mut model.initial;
        modal_displacement.iter_mut().take(1).for_each(|first| *first += (at - from) / of_first);
        modal_velocity.iter_mut().take(1).for_each(|first| *first += (rate - from_rate) / of_first);
    }
    scene
}

/// The displacement of the tip in m by a modal displacement of 1 √kg·m.
fn tip(model: &BumpStop, mode: u32) -> f64 {
    let open = Load::Resistor { resistance_ohm: f64::INFINITY };
    bump_stop_parameters::<f64>(model, open).beam_mode(mode).shape(1.0).value
}

/// Part of the range of a key by which its neighbours are away.
const NEAR: f64 = 1e-4;

/// The best of many points over the ranges of some keys, and what runs another one.
pub(crate) struct Best<'a> {
    /// The number of the result whose best value is sought.
    pub(crate) quantity: &'a str,
    /// For each key the part of the way over its range.
    pub(crate) place: &'a [f64],
    pub(crate) value: f64,
    pub(crate) scene: Scene,
    pub(crate) options: Options,
    /// The verdict of shooting, where the run had one.
    pub(crate) verdict: Option<&'a str>,
    /// Shoots for the steady state of a scene.
    pub(crate) shoot: &'a dyn Fn(&Scene, &Options) -> Result<Outcome, Failure>,
    /// The value at another place.
    pub(crate) at: &'a dyn Fn(&[f64]) -> Option<f64>,
}

impl Best<'_> {
    /// A warning where the motion has no stable orbit of one period under its sine: the value is then that of one run of a
    /// chaotic motion, or one of several periods, and may be a lucky one.
    pub(crate) fn doubt(&self) -> Option<String> {
        let why = match self.verdict.or_else(|| self.shot())? {
            STABLE => return None,
            "unstable-period-1" => "the orbit of one period is unstable",
            "stable-period-1-not-reached" => "the run does not come to the stable orbit of one period",
            _ => "no orbit of one period is found",
        };
        let shown =
            |value: Option<f64>| value.map_or_else(|| "none".to_owned(), |value| format!("{value:.4e}"));
        let (own, beside) = (shown(Some(self.value)), self.neighbours().map(shown).collect::<Vec<_>>());
        beside.iter().any(|value| *value != own).then(|| {
            format!(
                "the best point has no steady motion of one period: {why}. Its {} of {own} is that of one run, which may be a lucky \
                 one: {} at points that differ by a ten-thousandth of a range",
                self.quantity,
                beside.join(", ")
            )
        })
    }

    /// The verdict of shooting; `None` where there is none: without one sine, of a storage that fills, and by a method of the host.
    fn shot(&self) -> Option<&'static str> {
        let scene = &self.scene;
        scene.excitation.single_frequency()?;
        let of_core =
            matches!(self.options.method, Method::Auto | Method::ExponentialRadau | Method::DiscreteGradient);
        let options = Options { steady_state: true, ..self.options };
        if !of_core || matches!(scene.load, Load::RectifiedStore(_)) || options.check_scene(scene).is_err() {
            return None;
        }
        let found = (self.shoot)(scene, &options).ok()?;
        found.steady_state.map(|found| found.steady_state)
    }

    /// The values of the points beside it, two for each key; none of one that fails.
    fn neighbours(&self) -> impl Iterator<Item = Option<f64>> {
        (0..2 * self.place.len()).map(|side| {
            let (mut place, change) = (self.place.to_vec(), if side % 2 == 0 { -NEAR } else { NEAR });
            place[side / 2] = (place[side / 2] + change).clamp(0.0, 1.0);
            (self.at)(&place)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file;

    #[test]
    fn a_best_value_is_doubted_where_a_point_beside_it_has_another_or_none() {
        let doubt = |at: &dyn Fn(&[f64]) -> Option<f64>| {
            let scene = scene_file::read(&scene_file::shipped("sliding"), &[]).expect("the shipped scene");
            Best {
                quantity: "node_runs",
                place: &[0.5, 1.0],
                value: 1920.0,
                scene,
                options: Options::default(),
                verdict: Some("none"),
                shoot: &|_, _| Err(Failure::Input(String::new())),
                at,
            }
            .doubt()
        };
        assert_eq!(doubt(&|_| Some(1920.0)), None);
        let failing = doubt(&|place| (place[0] == 0.5).then_some(1920.0)).expect("two points fail");
        assert!(failing.contains("none, none, 1.9200e3, 1.9200e3 at points"), "{failing}");
        assert!(doubt(&|place| Some(1920.0 - f64::from(place[1] < 1.0))).is_some());
    }
}
