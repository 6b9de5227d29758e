//! The run of the full scene, and what other scenes change against it.

use super::change::{
    Change, Corner, FEWEST_RUNS, Sampled, apart, corner_name, cycles, mean, over_cycles, relative_deviation,
    run_cycles, switches, with_cycles,
};
use super::part::Part;
use crate::accuracy::{MOST_HALVINGS, imbalance, run_as_it_is, run_with_steps};
use crate::embedded::{DEFAULT_LONG_STEP_S, DEFAULT_SHORT_STEP_S};
use crate::method::{Failure, Options, Precision};
use crate::outcome::{Accuracy, Outcome};
use crate::resolution::remarks;
use crate::run::run_scene;
use crate::scene_file::{Model, Scene};
use crate::shift::{SHIFT, shaken};

/// Halvings of a tolerance at a time in search of the accuracy of a chaotic scene.
const TOLERANCE_HALVINGS: u32 = 4;
/// Most halvings of a tolerance in search of the accuracy of a chaotic scene.
const MOST_TOLERANCE_HALVINGS: u32 = 12;

/// Accuracy of the full run over the stated one: triboelectric, and bump-stop, whose cost rises faster.
const FULL: [f64; 2] = [0.01, 0.25];
/// Estimated error of the full run over the stated accuracy, up to which the verdicts are sound.
const SOUND: f64 = 0.5;
/// Change of the mean power under it over the accuracy, above which the motion is chaotic.
const CHAOTIC: f64 = 0.1;
/// Most attempted steps of a run over those of the full one, and in addition.
const MOST_ATTEMPTS: [u64; 2] = [16, 1 << 20];
/// Standard deviations of the power of a run that a single one is allowed.
const OF_A_RUN: f64 = 3.0;

/// A scene whose parts are examined.
pub(crate) struct Study {
    pub(crate) scene: Scene,
    pub(super) accuracy: f64,
    /// The run of the full scene. Mean power and voltages are means over `runs`.
    pub(crate) full: Outcome,
    /// The runs of the full scene: several of a chaotic motion.
    runs: Vec<Outcome>,
    pub(super) options: Options,
    /// Whether a base acceleration larger by 10⁻⁹ changes the mean power by more than a tenth of the accuracy.
    pub(crate) is_chaotic: bool,
    /// The same scene at the corners of the range of its excitation.
    pub(crate) corners: Vec<(Corner, Self)>,
}

impl Study {
    /// Runs the full scene, and the full scene at the corners of a range, for a study of its parts at a relative accuracy.
    pub(crate) fn with_corners(
        scene: &Scene,
        corners: &[(Corner, Scene)],
        accuracy: f64,
    ) -> Result<Self, Failure> {
        let corner = |(at, scene): &(Corner, Scene)| {
            let study = Self::new(scene, accuracy).map_err(|failure| failure.of_case(&corner_name(*at)))?;
            Ok((*at, study))
        };
        let corners = corners.iter().map(corner).collect::<Result<Vec<_>, Failure>>()?;
        let mut study = Self::new(scene, accuracy)?;
        for (at, corner) in &corners {
            let warned = corner.full.warnings.iter().map(|text| format!("at {}: {text}", corner_name(*at)));
            study.full.warnings.extend(warned);
        }
        Ok(Self { corners, ..study })
    }

    /// Runs the full scene for a study of its parts at a relative accuracy.
    pub(crate) fn new(scene: &Scene, accuracy: f64) -> Result<Self, Failure> {
        let (scene, warning) = with_cycles(scene)?;
        let mut study = Self::of_window(&scene, accuracy)?;
        study.full.warnings.extend(warning);
        Ok(study)
    }

    fn of_window(scene: &Scene, accuracy: f64) -> Result<Self, Failure> {
        let [triboelectric, bump_stop] = FULL;
        let is_bump_stop = matches!(scene.model, Model::BumpStop(_));
        let share = if is_bump_stop { bump_stop } else { triboelectric };
        let asked = Options {
            precision: Some(Precision::F64),
            accuracy: Some(share * accuracy),
            blocks: true,
            ..Options::default()
        };
        // No step brings two runs of a chaotic motion together: that it is chaotic must be known before one is sought.
        let usual = if is_bump_stop { Options { accuracy: None, ..asked } } else { asked };
        let first = run_cycles(scene, &usual)?;
        if changes_under_a_shift(scene, &first, &usual, accuracy) {
            return Self::of_chaos(scene, accuracy, &usual, first);
        }
        let (full, options) = run_with_steps(scene, &asked)?;
        let full = over_cycles(full);
        if changes_under_a_shift(scene, &full, &options, accuracy) {
            return Self::of_chaos(scene, accuracy, &usual, first);
        }
        let runs = vec![full.clone()];
        let corners = Vec::new();
        Ok(Self { scene: scene.clone(), accuracy, full, runs, options, is_chaotic: false, corners }.limited())
    }

    /// The study of a scene whose motion is chaotic: as many runs, in as long steps, as the accuracy of their mean needs.
    fn of_chaos(scene: &Scene, accuracy: f64, usual: &Options, first: Outcome) -> Result<Self, Failure> {
        let [more, most] = match scene.model {
            Model::BumpStop(_) => [1, MOST_HALVINGS],
            _ => [TOLERANCE_HALVINGS, MOST_TOLERANCE_HALVINGS],
        };
        let others = others(scene, usual)?;
        let sampled = |options: &Options| {
            Ok::<_, Failure>(Sampled::new(scene, options, accuracy, run_cycles(scene, options)?))
        };
        let mut options = *usual;
        let mut full = Sampled::new(scene, &options, accuracy, first);
        let mut coarse = sampled(&doubled(&options))?;
        let error = loop {
            let (error, is_too_coarse) = error_by_the_step(&mut coarse, &mut full, accuracy)?;
            if !is_too_coarse || options.halvings >= most {
                break error;
            }
            options.halvings += more;
            coarse = std::mem::replace(&mut full, sampled(&options)?);
        };
        let runs = full.runs;
        let mut full = means(&runs);
        full.accuracy = Accuracy { step: Some(error), ..others };
        if others.total.is_some() {
            full.accuracy = full.accuracy.summed();
        }
        let doubts: Vec<String> = imbalance(&full).into_iter().chain(remarks(scene, &full)).collect();
        full.warnings.extend(doubts);
        let corners = Vec::new();
        Ok(Self { scene: scene.clone(), accuracy, full, runs, options, is_chaotic: true, corners }.limited())
    }

    /// With a limit of attempted steps, and without the warning of an asked accuracy that is tighter than the study needs.
    fn limited(mut self) -> Self {
        if self.is_sound() {
            self.full.warnings.retain(|warning| !warning.starts_with("accuracy:"));
        }
        let [factor, more] = MOST_ATTEMPTS;
        self.options.most_attempts = Some(factor * (self.full.steps + self.full.rejected_steps) + more);
        self
    }

    /// Whether the full run is known to be accurate enough for the verdicts.
    pub(crate) fn is_sound(&self) -> bool {
        self.full.accuracy.total.is_some_and(|total| total <= SOUND * self.accuracy)
            && self.corners.iter().all(|(_, corner)| corner.is_sound())
    }

    /// Number of runs of the full scene.
    pub(crate) fn runs(&self) -> usize {
        self.runs.len()
    }

    /// The accuracy that one window of the scene holds: of a chaotic motion the scatter of a run is added.
    pub(crate) fn accuracy_of_a_run(&self) -> f64 {
        let powers: Vec<f64> = self.runs.iter().filter_map(|run| run.mean_power_w).collect();
        self.accuracy + OF_A_RUN * relative_deviation(&powers)
    }

    /// Whether the full scene has neither power nor voltage, so that its largest motion decides.
    pub(crate) fn is_by_motion(&self) -> bool {
        let Outcome { mean_power_w, rms_voltage_v, store, .. } = &self.full;
        let stored = store.and_then(|store| store.store_voltage_v);
        [*mean_power_w, *rms_voltage_v, stored].iter().flatten().all(|value| *value == 0.0)
    }

    /// What changes without some parts, by the options of the full run.
    pub(super) fn change(&self, left_out: &[Part]) -> Result<Change, String> {
        let scene = self.without(left_out);
        if left_out.contains(&Part::Sticking) {
            self.never_sticks(&scene)?;
            self.corners.iter().try_for_each(|(_, corner)| corner.never_sticks(&corner.here(&scene)))?;
        }
        self.compared(&scene, None, None).map(|(change, _)| change)
    }

    /// A scene under the excitation of this one, over its window.
    fn here(&self, scene: &Scene) -> Scene {
        Scene { excitation: self.scene.excitation.clone(), run: self.scene.run, ..scene.clone() }
    }

    /// What a scene changes at most that runs in place of the full one, at its own point and at the corners, by some options
    /// or those of the full runs, and its first run. Whether it is chaotic is found out where it is not known.
    pub(super) fn compared(
        &self,
        scene: &Scene,
        options: Option<&Options>,
        is_chaotic: Option<bool>,
    ) -> Result<(Change, Outcome), String> {
        let (mut worst, run) = self.compared_here(scene, options.unwrap_or(&self.options), is_chaotic)?;
        for (at, corner) in &self.corners {
            if worst.is_within(self.accuracy) == Some(false) {
                break;
            }
            let found = corner.compared_here(&corner.here(scene), options.unwrap_or(&corner.options), None);
            let (change, _) = found.map_err(|error| format!("at {}: {error}", corner_name(*at)))?;
            if change.is_within(self.accuracy) == Some(false) || change.most() > worst.most() {
                worst = Change { at: Some(*at), ..change };
            }
        }
        Ok((worst, run))
    }

    fn compared_here(
        &self,
        scene: &Scene,
        options: &Options,
        is_chaotic: Option<bool>,
    ) -> Result<(Change, Outcome), String> {
        let text = |failure: Failure| failure.to_string();
        let run = run_cycles(scene, options).map_err(text)?;
        if switches(scene) && cycles(&self.full).is_some() && cycles(&run).is_none() {
            return Err("its draw has no whole cycle of the switch".to_owned());
        }
        let is_chaotic = is_chaotic
            .unwrap_or_else(|| self.is_chaotic || changes_under_a_shift(scene, &run, options, self.accuracy));
        if !is_chaotic {
            return Ok((Change::between(&self.full, &run), run));
        }
        let mut sampled = Sampled::new(scene, options, self.accuracy, run.clone());
        let mut count = FEWEST_RUNS;
        loop {
            sampled.grow(count).map_err(text)?;
            let change = Change::of_means(&self.runs, &sampled.runs);
            if count >= sampled.most_runs() || change.is_clear(self.accuracy) {
                return Ok((change, run));
            }
            count = (2 * count).min(sampled.most_runs());
        }
    }

    pub(super) fn without(&self, left_out: &[Part]) -> Scene {
        let mut scene = self.scene.clone();
        for part in left_out {
            part.leave_out(&mut scene);
        }
        scene
    }

    /// Refuses a scene whose mass or slider sticks at any time of the run.
    fn never_sticks(&self, scene: &Scene) -> Result<(), String> {
        let mut whole = scene.clone();
        whole.run.settle_s = 0.0;
        let run = run_scene(&whole, &self.options).map_err(|failure| failure.to_string())?;
        let separating = run.contact_separation().and_then(|found| found.stuck_fraction);
        let fraction = separating.or(run.sliding().and_then(|found| found.stick_fraction)).unwrap_or(0.0);
        if fraction == 0.0 { Ok(()) } else { Err(format!("sticks for {:.2} % of the run", 100.0 * fraction)) }
    }
}

/// Whether the run of a scene changes under a slightly larger base acceleration.
fn changes_under_a_shift(scene: &Scene, run: &Outcome, options: &Options, accuracy: f64) -> bool {
    // A base at rest excites no chaos. A run that ends otherwise is as far from the other as can be.
    shaken(scene, SHIFT).is_some_and(|shifted| {
        run_cycles(&shifted, options).map_or(true, |other| apart(run, &other) > CHAOTIC * accuracy)
    })
}

/// The statement of one run of a chaotic scene, for its sources of error besides the step; the total is unknown if one of them is.
fn others(scene: &Scene, options: &Options) -> Result<Accuracy, Failure> {
    let has_none = matches!(scene.model, Model::BumpStop(_)) && !scene.excitation.is_recorded();
    let none = Accuracy { step: Some(0.0), ..Accuracy::default() };
    if has_none { Ok(none.summed()) } else { Ok(run_as_it_is(scene, options)?.accuracy) }
}

/// The options with twice the default steps of a bump-stop scene, or a looser tolerance.
fn doubled(options: &Options) -> Options {
    match options.accuracy {
        Some(accuracy) => {
            Options { accuracy: Some(accuracy / 0.5_f64.powi(TOLERANCE_HALVINGS.cast_signed())), ..*options }
        }
        None => Options {
            step_s: Some(2.0 * DEFAULT_SHORT_STEP_S),
            long_step_s: Some(2.0 * DEFAULT_LONG_STEP_S),
            ..*options
        },
    }
}

/// The error of the mean over runs by the step, from runs in longer steps, and whether a shorter one is needed. Both grow
/// until that is clear. In a method of first order or higher the error is at most the difference from twice the step.
fn error_by_the_step(
    coarse: &mut Sampled<'_>,
    full: &mut Sampled<'_>,
    accuracy: f64,
) -> Result<(f64, bool), Failure> {
    let most = full.most_runs();
    let mut count = 2 * FEWEST_RUNS;
    loop {
        coarse.grow(count)?;
        full.grow(count)?;
        let change = Change::of_means(coarse.first(count), full.first(count));
        let (largest, chance) = (change.largest(), change.sampling_error.unwrap_or(0.0));
        let error = largest + chance;
        if error <= SOUND * accuracy {
            return Ok((error, false));
        }
        let is_too_coarse = largest - chance > SOUND * accuracy;
        if is_too_coarse || count >= most {
            return Ok((error, is_too_coarse));
        }
        count = (2 * count).min(most);
    }
}

/// The first of some runs with the means of all in place of its mean power and voltages.
fn means(runs: &[Outcome]) -> Outcome {
    let of = |value: &dyn Fn(&Outcome) -> Option<f64>| {
        runs.iter().map(value).collect::<Option<Vec<f64>>>().map(|values| mean(&values))
    };
    let mut full = runs[0].clone();
    full.mean_power_w = of(&|run| run.mean_power_w);
    full.rms_voltage_v = of(&|run| run.rms_voltage_v);
    full.delivered_energy_j = of(&|run| run.delivered_energy_j);
    if let Some(store) = &mut full.store {
        store.store_voltage_v = of(&|run| run.store.and_then(|store| store.store_voltage_v));
    }
    full
}

#[cfg(test)]
mod tests;
