//! Whether the motion at an optimum has a period, and how far the value scatters where it has none.

use super::{Point, Request};
use crate::embedded;
use crate::method::{Method, Options};
use crate::outcome::{Outcome, STABLE};
use crate::scene_file::Load;

/// Part of the range of a key by which its neighbours are away.
const NEAR: f64 = 1e-4;

/// A warning where the motion at the best point has no stable orbit of one period under its sine: the value is then that of
/// one run of a chaotic motion, or one of several periods, and may be a lucky one.
pub(super) fn of_motion(request: &Request<'_>, best: &Point, outcome: &Outcome) -> Option<String> {
    let verdict = verdict(request, best, outcome)?;
    if verdict == STABLE {
        return None;
    }
    let why = match verdict {
        "unstable-period-1" => "the orbit of one period is unstable",
        "stable-period-1-not-reached" => "the run does not come to the stable orbit of one period",
        _ => "no orbit of one period is found",
    };
    let [low, high] = neighbours(request, best)?;
    Some(format!(
        "the best point has no steady motion of one period: {why}. Its {} is that of one run, which may be a lucky one: {:.4e} \
         to {:.4e} at points that differ by a ten-thousandth of a range",
        request.quantity,
        request.signed(low).min(request.signed(high)),
        request.signed(low).max(request.signed(high))
    ))
}

/// The verdict of the shooting at the best point; `None` where there is none: without one sine, of a storage that fills, and
/// by a method of the host.
fn verdict(request: &Request<'_>, best: &Point, outcome: &Outcome) -> Option<&'static str> {
    if let Some(found) = &outcome.steady_state {
        return Some(found.steady_state);
    }
    let scene = request.scene(&best.place).ok()?;
    scene.excitation.single_frequency()?;
    let of_core =
        matches!(request.options.method, Method::Auto | Method::ExponentialRadau | Method::DiscreteGradient);
    let options = Options { steady_state: true, ..request.options };
    if !of_core || matches!(scene.load, Load::RectifiedStore(_)) || options.check_scene(&scene).is_err() {
        return None;
    }
    let found = request.counted(embedded::steady_state(&scene, &options)).ok()?;
    found.steady_state.map(|found| found.steady_state)
}

/// The least and the largest value of the best point and of those beside it; the higher the better.
fn neighbours(request: &Request<'_>, best: &Point) -> Option<[f64; 2]> {
    let own = best.value()?;
    let mut ends = [own; 2];
    for index in 0..best.place.len() {
        for change in [-NEAR, NEAR] {
            let mut place = best.place.clone();
            place[index] = (place[index] + change).clamp(0.0, 1.0);
            if let Some(value) = request.point(&place).value() {
                ends = [ends[0].min(value), ends[1].max(value)];
            }
        }
    }
    Some(ends)
}
