//! Which parts a scene needs for a stated accuracy.
//!
//! Each part in turn is left out of the scene, and the run is compared with that of the full scene, both in double precision and within
//! a fraction of the accuracy. As many of the parts that are not needed are left out together as the accuracy allows. For the cut scene
//! that remains, the cheapest method, precision and step are sought that hold the accuracy against the same full run.

mod change;
mod emit;
mod numerics;
mod part;
mod study;

use serde::Serialize;

pub(crate) use self::change::{Change, Corner, corner_name, cycles, impacts};
pub(crate) use self::emit::Emission;
pub(crate) use self::numerics::{Control, Numerics, REPEATS, Setting, cheapest, host_time};
pub(crate) use self::part::Part;
use self::part::{modes, parts};
pub(crate) use self::study::Study;
use crate::method::Failure;
use crate::run::each;
use crate::scene_file::Scene;

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
    /// The change may be chance, within the scatter of the runs.
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

pub(crate) struct Needs {
    pub(crate) findings: Vec<Finding>,
    /// The parts that are left out of the cut scene.
    pub(crate) cut: Vec<Part>,
    pub(crate) cut_scene: Scene,
    pub(crate) cut_change: Change,
}

impl Study {
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
        let mut findings = each(&all, |part| {
            let finding = self.finding(*part);
            done(all.len());
            finding
        });
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
        let failing = each(pairs, |pair| {
            let holds = self.holds(pair);
            done();
            (!holds).then_some(*pair)
        });
        failing.into_iter().flatten().collect()
    }

    /// The candidates that can be left out together: all, or one after the other those that still can.
    fn cut(&self, candidates: &[Part]) -> Vec<Part> {
        if self.holds(candidates) {
            return candidates.to_vec();
        }
        let [beam, rod] = modes(&self.scene);
        let mut cut = Vec::new();
        for part in candidates {
            // More modes may hold together with the others, and some where none at all does not.
            let counts: Vec<Part> = match *part {
                Part::BeamModes(retained) => (retained..beam).map(Part::BeamModes).collect(),
                Part::RodModes(retained) => (retained..rod).map(Part::RodModes).collect(),
                Part::Rod => [Part::Rod].into_iter().chain((1..rod).map(Part::RodModes)).collect(),
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
    let mut retained: Vec<&Finding> = findings
        .iter()
        .filter(|finding| finding.verdict == Verdict::NotNeeded && holds_with_more(findings, finding.part))
        // The other behaviour of the charge leaves nothing out.
        .filter(|finding| finding.part != Part::StickCharge)
        .collect();
    let change = |finding: &Finding| finding.change.map_or(f64::INFINITY, |change| change.largest());
    retained.sort_by(|one, other| change(one).total_cmp(&change(other)));
    let parts: Vec<Part> = retained.iter().map(|finding| finding.part).collect();
    let covered = |part: &Part| parts.iter().any(|other| other != part && covers(*other, *part));
    parts.iter().copied().filter(|part| !covered(part)).collect()
}

/// Whether the accuracy holds with each larger number of modes too; for any other part it does.
fn holds_with_more(findings: &[Finding], part: Part) -> bool {
    findings.iter().all(|finding| {
        let is_larger = match (part, finding.part) {
            (Part::BeamModes(retained), Part::BeamModes(other))
            | (Part::RodModes(retained), Part::RodModes(other)) => other > retained,
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
            (Part::BeamModes(least), Part::BeamModes(retained))
            | (Part::RodModes(least), Part::RodModes(retained)) => least <= retained,
            (Part::Stop, other) => stop.contains(&other) || matches!(other, Part::RodModes(_)),
            (Part::Rod, other) => matches!(other, Part::RodModes(_)),
            (Part::Bridge(_), other) => {
                store.contains(&other) || matches!(other, Part::DiodeDrop | Part::Storage(_))
            }
            (Part::Storage(_), other) => store.contains(&other),
            _ => false,
        }
}
