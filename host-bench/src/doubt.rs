//! Whether the motion at the best of many points has a period, and how far the value scatters where it has none.

use crate::method::{Failure, Method, Options};
use crate::outcome::{Outcome, STABLE};
use crate::scene_file::{Load, Scene};

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
        let [low, high] = self.neighbours();
        Some(format!(
            "the best point has no steady motion of one period: {why}. Its {} is that of one run, which may be a lucky one: \
             {low:.4e} to {high:.4e} at points that differ by a ten-thousandth of a range",
            self.quantity
        ))
    }

    /// The verdict of shooting; `None` where there is none: without one sine, of a storage that fills, and by a method of the
    /// host.
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

    /// The least and the largest value of the point and of those beside it.
    fn neighbours(&self) -> [f64; 2] {
        let mut ends = [self.value; 2];
        for index in 0..self.place.len() {
            for change in [-NEAR, NEAR] {
                let mut place = self.place.to_vec();
                place[index] = (place[index] + change).clamp(0.0, 1.0);
                if let Some(value) = (self.at)(&place) {
                    ends = [ends[0].min(value), ends[1].max(value)];
                }
            }
        }
        ends
    }
}
