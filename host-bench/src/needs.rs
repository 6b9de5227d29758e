//! Which parts a scene needs for a stated accuracy.
//!
//! Each part in turn is left out of the scene, and the run is compared with that of the full scene, both in double
//! precision and within a fraction of the accuracy. As many of the parts that are not needed are left out together as the
//! accuracy allows. For the cut scene that remains, the cheapest method, precision and step are sought that hold the
//! accuracy against the same full run.

mod change;
mod emit;
mod numerics;
mod part;

use rayon::prelude::*;
use serde::Serialize;

use self::change::sampling_error;
pub(crate) use self::change::{Change, impacts};
pub(crate) use self::emit::Emission;
pub(crate) use self::numerics::{Control, Numerics, Setting, cheapest};
pub(crate) use self::part::Part;
use self::part::{modes, parts};
use crate::accuracy::run_with_steps;
use crate::method::{Failure, Options, Precision};
use crate::outcome::Outcome;
use crate::run::run_scene;
use crate::scene_file::{Excitation, Model, Scene};
use crate::shift::{SHIFT, shaken};

/// Accuracy of the full run over the stated one: triboelectric, and bump-stop, whose cost rises faster.
const FULL: [f64; 2] = [0.01, 0.25];
/// Estimated error of the full run over the stated accuracy, up to which the verdicts are sound.
const SOUND: f64 = 0.5;
/// Change of the mean power under it over the accuracy, above which the motion is chaotic.
const CHAOTIC: f64 = 0.1;
/// Sampling error of the mean power over the accuracy up to which the window of a chaotic motion is lengthened.
const SAMPLED: f64 = 0.25;
/// Most windows of the scene in a lengthened one, and most steps of a run through it.
const MOST_WINDOWS: f64 = 400.0;
const MOST_STEPS: f64 = (1 << 24) as f64;
/// Most attempted steps of a run over those of the full one, and in addition.
const MOST_ATTEMPTS: [u64; 2] = [16, 1 << 20];

/// A scene whose parts are examined.
pub(crate) struct Study {
    /// The full scene, with a longer window where its motion is chaotic.
    pub(crate) scene: Scene,
    /// The stated accuracy.
    accuracy: f64,
    /// The run of the full scene.
    pub(crate) full: Outcome,
    /// Its options.
    options: Options,
    /// Whether a base acceleration larger by 10⁻⁹ changes the mean power by more than a tenth of the accuracy.
    pub(crate) is_chaotic: bool,
}

/// Whether a part is needed.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "verdict")]
pub(crate) enum Verdict {
    /// Its absence changes the result by more than the accuracy, or cannot be run.
    Needed,
    /// Its absence changes the result by less, also together with all other parts that are not needed.
    NotNeeded,
    /// Its absence alone changes the result by less, but not together with others that are left out.
    NotNeededAlone {
        /// The parts of the cut that cannot be left out with it; empty: no single one.
        with: Vec<String>,
    },
    /// Its absence changes the result by less, but with more of the modes kept it changes by more.
    ByChance,
    /// The change may be chance: a longer window decides.
    Undecided,
}

/// A part and what its absence changes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Finding {
    #[serde(serialize_with = "by_name")]
    pub(crate) part: Part,
    /// Why the scene cannot be run without it.
    pub(crate) failure: Option<String>,
    #[serde(flatten)]
    pub(crate) change: Option<Change>,
    #[serde(flatten)]
    pub(crate) verdict: Verdict,
}

fn by_name<S: serde::Serializer>(part: &Part, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&part.name())
}

/// What a scene needs.
pub(crate) struct Needs {
    pub(crate) findings: Vec<Finding>,
    /// The parts that are left out of the cut scene.
    pub(crate) cut: Vec<Part>,
    pub(crate) cut_scene: Scene,
    /// The change by all of them.
    pub(crate) cut_change: Change,
}

impl Study {
    /// Runs the full scene for a study of its parts at a relative accuracy.
    ///
    /// # Errors
    /// If the scene cannot be run.
    pub(crate) fn new(scene: &Scene, accuracy: f64) -> Result<Self, Failure> {
        let [triboelectric, bump_stop] = FULL;
        let share = if matches!(scene.model, Model::BumpStop(_)) { bump_stop } else { triboelectric };
        let asked = Options {
            precision: Some(Precision::F64),
            accuracy: Some(share * accuracy),
            blocks: true,
            ..Options::default()
        };
        let (full, options) = run_with_steps(scene, &asked)?;
        let mut study = Self { scene: scene.clone(), accuracy, full, options, is_chaotic: false };
        study.is_chaotic = study.changes_under_a_shift(&study.scene, &study.full, &study.options);
        if study.is_chaotic && study.lengthen_window() {
            (study.full, study.options) = run_with_steps(&study.scene, &asked)?;
        }
        if study.is_sound() {
            // Said of the accuracy that the study asked for, which is tighter than it needs.
            study.full.warnings.retain(|warning| !warning.starts_with("accuracy:"));
        }
        let [factor, more] = MOST_ATTEMPTS;
        study.options.most_attempts = Some(factor * (study.full.steps + study.full.rejected_steps) + more);
        Ok(study)
    }

    /// Lengthens the window until the sampling error of a difference of two means is a part of the accuracy. Returns
    /// whether it is longer now; a trace that is not repeated has no more samples.
    fn lengthen_window(&mut self) -> bool {
        if let Excitation::File(trace) = &self.scene.excitation
            && !trace.repeat
        {
            return false;
        }
        let blocks = &self.full.block_energies_j;
        // The difference of two independent runs: the error of one, times the root of two.
        let nothing = vec![0.0; blocks.len()];
        let of_difference = std::f64::consts::SQRT_2 * sampling_error(blocks, &nothing);
        // Without power there is no mean to sample.
        if !of_difference.is_finite() {
            return false;
        }
        let run = &mut self.scene.run;
        let steps = self.full.steps as f64 * run.window_s() / run.duration_s;
        let most = MOST_WINDOWS.min(MOST_STEPS / steps);
        let windows = (of_difference / (SAMPLED * self.accuracy)).powi(2).min(most).ceil();
        run.duration_s = run.settle_s + run.window_s() * windows.max(1.0);
        windows > 1.0
    }

    /// Whether the full run is known to be accurate enough for the verdicts.
    pub(crate) fn is_sound(&self) -> bool {
        self.full.accuracy.total.is_some_and(|total| total <= SOUND * self.accuracy)
    }

    /// Whether the full scene has neither power nor voltage, so that its largest motion decides.
    pub(crate) fn is_by_motion(&self) -> bool {
        let Outcome { mean_power_w, rms_voltage_v, store, .. } = &self.full;
        let stored = store.and_then(|store| store.store_voltage_v);
        [*mean_power_w, *rms_voltage_v, stored].iter().flatten().all(|value| *value == 0.0)
    }

    /// Whether the run of a scene changes under a slightly larger base acceleration.
    fn changes_under_a_shift(&self, scene: &Scene, run: &Outcome, options: &Options) -> bool {
        // A base at rest excites no chaos. A run that ends otherwise is as far from the other as can be.
        shaken(scene, SHIFT).is_some_and(|shifted| {
            run_scene(&shifted, options)
                .map_or(true, |other| Change::between(run, &other, false).largest() > CHAOTIC * self.accuracy)
        })
    }

    /// What changes without some parts, by the options of the full run.
    fn change(&self, left_out: &[Part]) -> Result<Change, String> {
        let scene = self.without(left_out);
        if left_out.contains(&Part::Sticking) {
            self.never_sticks(&scene)?;
        }
        self.compared(&scene, &self.options)
    }

    /// A run of a scene in place of the full one.
    fn compared(&self, scene: &Scene, options: &Options) -> Result<Change, String> {
        let run = run_scene(scene, options).map_err(|failure| failure.to_string())?;
        let is_chaotic = self.is_chaotic || self.changes_under_a_shift(scene, &run, options);
        Ok(Change::between(&self.full, &run, is_chaotic))
    }

    /// The scene without some parts.
    fn without(&self, left_out: &[Part]) -> Scene {
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

    fn finding(&self, part: Part) -> Finding {
        let (change, failure) = match self.change(&[part]) {
            Ok(change) => (Some(change), None),
            Err(failure) => (None, Some(failure)),
        };
        let verdict = match change.map(|change| change.is_within(self.accuracy)) {
            Some(Some(true)) => Verdict::NotNeeded,
            Some(None) => Verdict::Undecided,
            Some(Some(false)) | None => Verdict::Needed,
        };
        Finding { part, failure, change, verdict }
    }

    /// Whether the scene holds the accuracy without some parts.
    fn holds(&self, left_out: &[Part]) -> bool {
        self.change(left_out).is_ok_and(|change| change.is_within(self.accuracy) == Some(true))
    }

    /// Examines all parts; calls `done` after each run of a part or a pair, with the number of those that are known.
    pub(crate) fn needs(&self, done: impl Fn(usize) + Sync) -> Result<Needs, Failure> {
        let [beam, rod] = modes(&self.scene);
        let mut all = parts(&self.scene, &self.full);
        all.extend((1..beam).map(Part::BeamModes));
        all.extend((1..rod).map(Part::RodModes));
        let mut findings: Vec<Finding> = all
            .par_iter()
            .map(|part| {
                let finding = self.finding(*part);
                done(all.len());
                finding
            })
            .collect();
        let candidates = candidates(&findings);
        let cut = self.cut(&candidates);
        let excluded =
            candidates.iter().copied().filter(|part| !cut.iter().any(|other| covers(*other, *part)));
        let pairs: Vec<[Part; 2]> =
            excluded.flat_map(|part| cut.iter().map(move |other| [part, *other])).collect();
        let pairs = self.failing_pairs(&pairs, || done(all.len() + pairs.len()));
        let by_chance: Vec<Part> =
            all.iter().copied().filter(|part| !holds_with_more(&findings, *part)).collect();
        for finding in &mut findings {
            let part = finding.part;
            let is_left_out = part == Part::StickCharge || cut.iter().any(|other| covers(*other, part));
            if finding.verdict != Verdict::NotNeeded || is_left_out {
                continue;
            }
            if by_chance.contains(&part) {
                finding.verdict = Verdict::ByChance;
                continue;
            }
            let with = pairs.iter().filter(|[one, _]| *one == part).map(|[_, other]| other.name());
            finding.verdict = Verdict::NotNeededAlone { with: with.collect() };
        }
        let cut_change = self.change(&cut).map_err(Failure::Step)?;
        Ok(Needs { findings, cut_scene: self.without(&cut), cut, cut_change })
    }

    /// The pairs that cannot be left out together.
    fn failing_pairs(&self, pairs: &[[Part; 2]], done: impl Fn() + Sync) -> Vec<[Part; 2]> {
        let failing = pairs.par_iter().filter(|pair| {
            let holds = self.holds(*pair);
            done();
            !holds
        });
        failing.copied().collect()
    }

    /// The candidates that can be left out together: all, or one after the other those that still can.
    fn cut(&self, candidates: &[Part]) -> Vec<Part> {
        if self.holds(candidates) {
            return candidates.to_vec();
        }
        let [beam, rod] = modes(&self.scene);
        let mut cut = Vec::new();
        for part in candidates {
            // More modes may hold together with the others.
            let counts: Vec<Part> = match *part {
                Part::BeamModes(kept) => (kept..beam).map(Part::BeamModes).collect(),
                Part::RodModes(kept) => (kept..rod).map(Part::RodModes).collect(),
                other => vec![other],
            };
            let with = |count: &&Part| self.holds(&[cut.as_slice(), &[**count]].concat());
            cut.extend(counts.iter().find(with).copied());
        }
        cut
    }
}

/// The parts that are not needed alone, those that change least first; a part that another one covers is left out with it.
fn candidates(findings: &[Finding]) -> Vec<Part> {
    let mut kept: Vec<&Finding> = findings
        .iter()
        .filter(|finding| finding.verdict == Verdict::NotNeeded && holds_with_more(findings, finding.part))
        // The other behaviour of the charge leaves nothing out.
        .filter(|finding| finding.part != Part::StickCharge)
        .collect();
    let change = |finding: &Finding| finding.change.map_or(f64::INFINITY, |change| change.largest());
    kept.sort_by(|one, other| change(one).total_cmp(&change(other)));
    let parts: Vec<Part> = kept.iter().map(|finding| finding.part).collect();
    let covered = |part: &Part| parts.iter().any(|other| other != part && covers(*other, *part));
    parts.iter().copied().filter(|part| !covered(part)).collect()
}

/// Whether the accuracy holds with each larger number of modes too; for any other part it does.
fn holds_with_more(findings: &[Finding], part: Part) -> bool {
    findings.iter().all(|finding| {
        let is_larger = match (part, finding.part) {
            (Part::BeamModes(kept), Part::BeamModes(other))
            | (Part::RodModes(kept), Part::RodModes(other)) => other > kept,
            (Part::Rod, Part::RodModes(_)) => true,
            _ => false,
        };
        !is_larger || finding.verdict == Verdict::NotNeeded
    })
}

/// Whether a scene without `one` has no `other`.
fn covers(one: Part, other: Part) -> bool {
    let stop = [Part::Rod, Part::ResidualCompliance, Part::ContactCompliance];
    let store = [Part::Leakage, Part::Draw];
    one == other
        || match (one, other) {
            (Part::BeamModes(least), Part::BeamModes(kept))
            | (Part::RodModes(least), Part::RodModes(kept)) => least <= kept,
            (Part::Stop, other) => stop.contains(&other) || matches!(other, Part::RodModes(_)),
            (Part::Rod, other) => matches!(other, Part::RodModes(_)),
            (Part::Bridge(_), other) => {
                store.contains(&other) || matches!(other, Part::DiodeDrop | Part::Storage(_))
            }
            (Part::Storage(_), other) => store.contains(&other),
            _ => false,
        }
}
