//! The steady motions of a scene under a periodic excitation, by runs from other starts.
//!
//! Impacts and dry friction allow several motions under one excitation; the start decides which of them a run comes to. Two runs are of
//! one motion if their mean powers agree within a hundredth and within the sampling error of motions that are not periodic.

use std::f64::consts::TAU;

use crate::accuracy::{MOST_ATTEMPTS, has_own_steps};
use crate::method::{Failure, Method, Options};
use crate::outcome::{Branch, Outcome, standard_error_of_sum};
use crate::report::setting::setting;
use crate::resolution::resonances;
use crate::run::{each, run_scene, try_each};
use crate::scene_file::{Excitation, Load, RunSpan, Scene, Summary};
use crate::shift::{start, started};

/// Relative difference of the mean powers of one motion, beside so many standard errors, which allow half of it at most.
const APART: f64 = 0.01;
const STANDARD_ERRORS: f64 = 3.0;
const MOST_BY_SAMPLING: f64 = 0.5;
/// Most periods after which a motion repeats, and the part of its size by which it then differs.
const MOST_PERIODS: usize = 16;
const REPEATS: f64 = 1e-3;
/// Accuracy of these runs where the options have none.
const ACCURACY: f64 = 1e-4;
/// Exponent by which transients have decayed, far below [`REPEATS`], and the most times of a run that it may take.
const DECAY: f64 = 10.0;
const LONGEST: f64 = 10.0;
/// Displacement and velocity of the starts of `run` from the place of rest, over the size of the motion. They were chosen on
/// 29 contact-separation scenes with two motions under a sine; two random starts find the other one in 80 % of them.
const FEW: [[f64; 2]; 2] = [[-0.25, 2.25], [-0.25, 0.5]];
/// The same of all starts, at most.
const REACH: f64 = 2.25;

/// The warning of displaced starts whose runs cannot be compared.
pub(crate) const UNSETTLED: &str = "attractors: runs from displaced starts have not settled where they are compared: transients \
    take more than ten times run.duration_s; whether there are other steady motions is unknown";

/// From where a scene is started.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    /// Displacement at rest in m.
    rest_m: f64,
    /// Size of the motion: of the displacement in m, and of the velocity in m/s.
    size: [f64; 2],
    /// Least and largest displacement in m of a start.
    ends_m: [f64; 2],
}

impl Place {
    /// Of a scene that has given `outcome`; `None` where another start has nothing to find.
    pub(crate) fn new(scene: &Scene, outcome: &Outcome) -> Option<Self> {
        let is_periodic = match &scene.excitation {
            Excitation::Sine(tone) => tone.amplitude_m_per_s2 != 0.0 && tone.frequency_hz > 0.0,
            Excitation::Sines(tones) => tones.iter().any(|tone| tone.amplitude_m_per_s2 != 0.0),
            Excitation::Burst(burst) => burst.period_s.is_some(),
            // These lead from one motion to another by themselves.
            Excitation::Sweep(_) | Excitation::Random(_) | Excitation::File(_) | Excitation::Silence => false,
        };
        // A storage fills, and the powers of two motions cannot be compared where the load takes none.
        let takes_power = match scene.load {
            Load::Resistor { resistance_ohm } => resistance_ohm > 0.0 && resistance_ohm.is_finite(),
            Load::DcBus { .. } => true,
            Load::RectifiedStore(_) => false,
        };
        let motion = outcome.largest_motion_m().filter(|_| is_periodic && takes_power)?;
        let Summary { rest_m, length_m, range_m: ends_m, .. } = scene.model.summary();
        let size_m = length_m.max(motion - rest_m);
        let (frequencies, _) = resonances(scene, outcome);
        let size = [size_m, size_m * TAU * frequencies.into_iter().reduce(f64::min)?];
        (size_m > 0.0).then_some(Self { rest_m, size, ends_m })
    }

    /// The starts of `run`.
    pub(crate) fn few(&self) -> [[f64; 2]; 2] {
        FEW.map(|sizes| self.at(sizes))
    }

    /// The start at some sizes of the motion from rest.
    fn at(&self, [displacement, velocity]: [f64; 2]) -> [f64; 2] {
        self.within([self.rest_m + self.size[0] * displacement, self.size[1] * velocity])
    }

    /// The possible start nearest to a displacement in m and a velocity in m/s.
    pub(crate) fn within(&self, [displacement_m, velocity_m_per_s]: [f64; 2]) -> [f64; 2] {
        let [low, high] = self.ends_m;
        let at = displacement_m.clamp(low, high);
        // A slider that is faster leaves the overlap of the patches.
        let left = if low.is_finite() && high.is_finite() {
            (high * high - at * at).max(0.0).sqrt()
        } else {
            f64::INFINITY
        };
        let most = self.size[1] / self.size[0] * left;
        [at, velocity_m_per_s.clamp(-most, most)]
    }

    /// The least and the largest displacement in m and velocity in m/s of a start.
    pub(crate) fn ranges(&self) -> [[f64; 2]; 2] {
        let [low, high] = [-REACH, REACH].map(|size| [self.at([size, 0.0])[0], self.at([0.0, size])[1]]);
        [[low[0], high[0]], [low[1], high[1]]]
    }
}

/// Where a run from a start ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct End {
    pub(crate) start: [f64; 2],
    pub(crate) power_w: f64,
    /// Standard error of the power in W.
    error_w: f64,
    pub(crate) period: Option<usize>,
}

impl End {
    fn new(scene: &Scene, start: [f64; 2], outcome: &Outcome, period: Option<usize>) -> Option<Self> {
        let period = if outcome.is_of_an_orbit() { Some(1) } else { period };
        let blocks = &outcome.block_energies_j;
        let is_sampled = period.is_none() && blocks.len() > 1;
        let error_w = if is_sampled { standard_error_of_sum(blocks) / scene.run.window_s() } else { 0.0 };
        Some(Self { start, power_w: outcome.mean_power_w?, error_w, period })
    }

    fn agrees(&self, other: &Self) -> bool {
        let largest = self.power_w.abs().max(other.power_w.abs());
        let by_sampling = STANDARD_ERRORS * self.error_w.hypot(other.error_w);
        let allowed = APART * largest + by_sampling.min(MOST_BY_SAMPLING * largest);
        let has_period = self.period.zip(other.period).is_none_or(|(one, other)| one == other);
        has_period && (self.power_w - other.power_w).abs() <= allowed
    }
}

/// The periods after which the motion of a run repeats, by its rows, one for each period.
fn period(scene: &Scene, outcome: &Outcome) -> Option<usize> {
    let settled = (scene.run.settle_s * scene.excitation.single_frequency()?).ceil() as usize;
    let rows = outcome.trace.as_ref()?.rows.iter().skip(settled);
    let at: Vec<f64> = rows.map(|row| row[1]).collect();
    let allowed = REPEATS * outcome.largest_motion_m()?;
    let repeats =
        |period: &usize| at.iter().zip(&at[*period..]).all(|(one, two)| (one - two).abs() <= allowed);
    (1..=MOST_PERIODS.min(at.len() / 2)).find(repeats)
}

/// The options of the runs from displaced starts.
pub(crate) fn options(scene: &Scene, asked: &Options) -> Options {
    let chooses = matches!(asked.method, Method::Auto | Method::ExponentialRadau) && !asked.steady_state;
    let is_free = chooses && asked.step_s.is_none() && asked.tolerance.is_none();
    let by_default = is_free.then_some(ACCURACY);
    Options {
        accuracy: asked.accuracy.or(by_default).filter(|_| !has_own_steps(scene, asked)),
        most_attempts: asked.most_attempts.or(Some(MOST_ATTEMPTS)),
        trace_every_s: None,
        ..*asked
    }
}

/// Where the runs from some starts end, on all cores, without those that fail; `done` is called after each.
pub(crate) fn ends(scene: &Scene, asked: &Options, starts: &[[f64; 2]], done: impl Fn() + Sync) -> Vec<End> {
    let every_s = scene.excitation.single_frequency().map(|frequency_hz| 1.0 / frequency_hz);
    let trace_every_s = every_s.filter(|_| !asked.steady_state);
    let options = Options { blocks: true, bare: true, trace_every_s, ..options(scene, asked) };
    let end = |start: &[f64; 2]| {
        let outcome = run_scene(&started(scene, *start), &options);
        done();
        let outcome = outcome.ok()?;
        End::new(scene, *start, &outcome, period(scene, &outcome))
    };
    each(starts, end).into_iter().flatten().collect()
}

/// The scene with its window from an instant in s on, and from where the transients have decayed; `None` if that is far beyond its end.
pub(crate) fn settled(scene: &Scene, outcome: &Outcome, from_s: f64) -> Option<Scene> {
    let (frequencies, damping_ratio) = resonances(scene, outcome);
    let settle_s = from_s.max(DECAY / (damping_ratio * TAU * frequencies.into_iter().reduce(f64::min)?));
    let run = RunSpan { duration_s: settle_s + scene.run.window_s(), settle_s };
    (settle_s <= LONGEST * scene.run.duration_s).then(|| Scene { run, ..scene.clone() })
}

/// What is to be said of the runs from `starts` starts that failed, if any did.
pub(crate) fn failed(ends: &[End], starts: usize) -> Option<String> {
    let failed = starts - ends.len();
    (failed > 0).then(|| {
        format!("attractors: {failed} of {starts} runs failed: to which motions their starts lead is unknown")
    })
}

/// The ends of each motion, in the order of the first run of each.
pub(crate) fn motions(ends: &[End]) -> Vec<Vec<&End>> {
    let mut found: Vec<Vec<&End>> = Vec::new();
    for end in ends {
        match found.iter_mut().find(|motion| motion[0].agrees(end)) {
            Some(motion) => motion.push(end),
            None => found.push(vec![end]),
        }
    }
    found
}

/// The motions of the runs from `starts` starts.
pub(crate) fn branches(motions: &[Vec<&End>], starts: usize) -> Vec<Branch> {
    let branch = |motion: &Vec<&End>| Branch {
        mean_power_w: Some(motion[0].power_w),
        period: motion[0].period,
        share: motion.len() as f64 / starts as f64,
        starts,
        displacement_m: motion[0].start[0],
        velocity_m_per_s: motion[0].start[1],
    };
    motions.iter().map(branch).collect()
}

/// Seeks other motions of a scene that has given `outcome` by two displaced starts, again with a later window if one ends elsewhere.
pub(crate) fn add_branches(scene: &Scene, asked: &Options, outcome: &mut Outcome) {
    match found(scene, asked, outcome) {
        Ok(branches) => outcome.branches = branches,
        Err(unknown) => outcome.warnings.push(unknown),
    }
    if let Some(branches) = &outcome.branches {
        let motion = |branch: &Branch| {
            let Branch { mean_power_w, share, starts, displacement_m, velocity_m_per_s, .. } = branch;
            let (power_w, count) = (mean_power_w.unwrap_or(f64::NAN), share * *starts as f64);
            let place = format!("from {displacement_m:.3e} m and {velocity_m_per_s:.3e} m/s");
            format!("{power_w:.3e} W {place} ({count:.0} of {starts} starts)")
        };
        let motions: Vec<String> = branches.iter().map(motion).collect();
        outcome.warnings.push(format!(
            "attractors: the start decides which of several steady motions a run comes to: {}; the command attractors \
             seeks all of them",
            motions.join(", ")
        ));
    }
}

/// The motions if there are several; a warning where that is unknown.
fn found(scene: &Scene, asked: &Options, outcome: &Outcome) -> Result<Option<Vec<Branch>>, String> {
    let own = End::new(scene, start(scene), outcome, None);
    let Some((place, own)) = Place::new(scene, outcome).zip(own) else { return Ok(None) };
    let starts = place.few();
    let found = ends(scene, asked, &starts, || ());
    if found.iter().all(|end| end.agrees(&own)) {
        return failed(&found, starts.len()).map_or(Ok(None), Err);
    }
    let later = settled(scene, outcome, scene.run.duration_s).ok_or(UNSETTLED)?;
    let starts = [own.start, starts[0], starts[1]];
    let found = ends(&later, asked, &starts, || ());
    let branches = branches(&motions(&found), starts.len());
    if branches.len() > 1 { Ok(Some(branches)) } else { failed(&found, starts.len()).map_or(Ok(None), Err) }
}

/// The warning, with its setting, of each scene that has other steady motions or of which that is unknown; on all cores.
pub(crate) fn elsewhere(scenes: &[(Scene, Options)]) -> Result<Vec<Option<String>>, Failure> {
    let of = |(scene, options): &(Scene, Options)| {
        let mut outcome = run_scene(scene, &Options { blocks: true, ..*options })?;
        outcome.warnings.clear();
        add_branches(scene, options, &mut outcome);
        Ok(outcome.warnings.pop().map(|warning| format!("{}: {warning}", setting(scene, &[]))))
    };
    try_each(scenes, of)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slider_starts_with_the_velocities_that_stay_within_the_patches() {
        let place = Place { rest_m: 0.0, size: [0.02, 4.0], ends_m: [-0.01, 0.01] };
        assert_eq!(place.ranges(), [[-0.01, 0.01], [-2.0, 2.0]]);
        assert_eq!(place.within([0.01, 1.0]), [0.01, 0.0]);
        assert!((place.within([0.006, 3.0])[1] - 1.6).abs() < 1e-12);
    }

    #[test]
    fn a_start_whose_run_fails_agrees_with_none() {
        let end = |power_w: f64| End { start: [0.0; 2], power_w, error_w: 0.0, period: None };
        let ended = [end(1.0), end(1.001), end(3.0)];
        let shares: Vec<f64> = branches(&motions(&ended), 4).iter().map(|branch| branch.share).collect();
        assert_eq!(shares, [0.5, 0.25]);
        assert!(failed(&ended, 4).is_some_and(|text| text.contains("1 of 4 runs failed")));
        assert_eq!(failed(&ended, 3), None);
    }
}
