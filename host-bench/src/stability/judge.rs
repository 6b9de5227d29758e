//! Judges the run of a case by runs that are more accurate.

use std::cell::OnceCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use serde::{Deserialize, Serialize};

use super::Case;
use super::exact::{
    CLOSER_TOLERANCE, Comparison, Ensemble, HALVINGS, HALVINGS_OF_MEAN, Numbers, Quantity,
    REFERENCE_TOLERANCE, by_reference, reference_repeats, relative, tighter,
};
use super::twin::{POWER, halves, rescaled, split_error};
use crate::accuracy::{run_as_it_is, run_with_steps};
use crate::method::{Failure, Options, Precision};
use crate::outcome::Outcome;
use crate::run::run_scene;
use crate::scene_file::{Scene, SceneError};

/// Relative error up to which a run is right, in double and in single precision.
pub(super) const RIGHT: [f64; 2] = [0.01, 0.02];
/// Most differences of a twin that warns, over what it states.
const TWIN: f64 = 2.0;

/// What became of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// The mean power is within 1 % in double precision and 2 % in single precision of that of the more accurate run;
    /// where no power is delivered, motion and RMS voltage are.
    Right,
    /// It is not, but the more accurate run diverges from one with a start displaced or a base acceleration changed by
    /// 10⁻⁹, and the statistics of all these runs agree.
    Chaotic,
    /// As chaotic, but the standard error is more than a fifth of the mean: no agreement can be stated.
    Undecided,
    /// It is not, and a warning that begins with `accuracy:` says so.
    Warned,
    /// The scene is refused before the run.
    Refused,
    /// A step could not be taken, and the error says why.
    NamedError,
    /// Stopped after the most attempted steps.
    StepLimit,
    /// No more accurate run came to its end.
    #[default]
    Unjudged,
    /// The mean power is off, and nothing says so.
    Wrong,
    /// A panic, or a number that is not finite.
    Broken,
}

impl Class {
    /// Of a run that is off if there is a comparison of its statistics.
    fn of(comparison: Option<Comparison>, is_warned: bool) -> Self {
        match (comparison, is_warned) {
            (None, _) => Self::Right,
            (Some(Comparison::Agree), _) => Self::Chaotic,
            (Some(_), true) => Self::Warned,
            (Some(Comparison::Undecided), false) => Self::Undecided,
            (Some(Comparison::Differ), false) => Self::Wrong,
        }
    }

    /// Whether nothing explains it.
    pub fn is_failure(self) -> bool {
        matches!(self, Self::Wrong | Self::Broken)
    }
}

/// How much a case may cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Most attempted steps of the run.
    pub most_attempts: u64,
    /// Whether the reference judges, where it comes to its end; otherwise a run of the same method with a tighter
    /// tolerance or shorter steps in double precision.
    pub by_reference: bool,
    /// Pairs of displaced starts whose accurate runs, with that of the case, judge the mean power of a chaotic motion.
    pub chaotic_pairs: i32,
}

/// A run that was judged; a row of a table of cases.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Finding {
    /// Number of the case in its list.
    pub number: usize,
    /// The shipped scene of the case, by its name without ending.
    pub scene: String,
    /// Name of the precision.
    pub precision: String,
    /// What became of it.
    pub class: Class,
    /// What was compared; `None` without a more accurate run.
    pub quantity: Option<Quantity>,
    /// Relative error of the quantity.
    pub error: Option<f64>,
    /// The statement of the relative error of the mean power.
    pub stated: Option<f64>,
    /// Whether a warning begins with `accuracy:`.
    pub is_warned: bool,
    /// Whether the reference was the more accurate run.
    pub by_reference: bool,
    /// Whether the mean power is that of an ensemble.
    pub is_chaotic: bool,
    /// Steps of the runs of the statement over those of the run.
    pub work: f64,
    /// Why there is no mean power, or what is wrong with it.
    pub reason: String,
    /// The arguments with which the command line runs the case.
    pub arguments: String,
    /// The program that judged it; empty outside a table.
    pub build: String,
}

impl Finding {
    fn new(class: Class, reason: impl Into<String>) -> Self {
        Self { class, reason: reason.into(), ..Self::default() }
    }
}

/// Runs a case with its accuracy statement, and judges it.
pub fn judge(case: &Case, effort: Effort) -> Finding {
    Judge::new(case, effort).finding(case.precision)
}

/// What the runs of a case in both precisions are judged by. Each of its runs is computed where it is first needed.
#[derive(Debug)]
pub struct Judge {
    scene: Result<Scene, SceneError>,
    /// The scene in other units, which multiply the power by [`POWER`].
    twin: Option<Scene>,
    options: Options,
    effort: Effort,
    /// The reference at its usual tolerance, and at that for a run beyond its statement.
    references: [OnceCell<Option<Numbers>>; 2],
    /// Whether the reference repeats itself, where a run is off by it.
    repeats: OnceCell<bool>,
    /// The run that judges where the reference does not.
    tighter: OnceCell<Option<Numbers>>,
    /// Those of a motion that is not stated as chaotic, and of one that is, with more runs.
    ensembles: [OnceCell<Ensemble>; 2],
}

impl Judge {
    /// Of a case; its precision does not matter.
    pub fn new(case: &Case, effort: Effort) -> Self {
        let options = Options { most_attempts: Some(effort.most_attempts), ..case.options() };
        Self {
            scene: case.read(),
            twin: effort.by_reference.then(|| rescaled(case)?.read().ok()).flatten(),
            options,
            effort,
            references: [const { OnceCell::new() }; 2],
            repeats: OnceCell::new(),
            tighter: OnceCell::new(),
            ensembles: [const { OnceCell::new() }; 2],
        }
    }

    /// Runs the case in a precision with its accuracy statement, and judges it.
    pub fn finding(&self, precision: Precision) -> Finding {
        match &self.scene {
            Ok(scene) => catch_unwind(AssertUnwindSafe(|| self.finding_of(scene, precision)))
                .unwrap_or_else(|_| Finding::new(Class::Broken, "panicked")),
            Err(error) => Finding::new(Class::Refused, error.to_string()),
        }
    }

    fn finding_of(&self, scene: &Scene, precision: Precision) -> Finding {
        let own = Options { precision: Some(precision), ..self.options };
        let (outcome, options) = match run_with_steps(scene, &own) {
            Ok(found) => found,
            Err(Failure::Input(reason)) => return Finding::new(Class::Refused, reason),
            Err(Failure::Step(reason)) => return Finding::new(Class::NamedError, reason),
            Err(Failure::StepLimitExceeded(reason)) => return Finding::new(Class::StepLimit, reason),
        };
        let mut finding = Finding {
            stated: outcome.accuracy.total,
            is_warned: is_warned(&outcome),
            is_chaotic: outcome.accuracy.chaos.is_some(),
            work: outcome.accuracy.work,
            ..Finding::new(Class::Unjudged, "no more accurate run came to its end")
        };
        if !is_finite(&outcome) {
            return Finding { class: Class::Broken, reason: "a number is not finite".to_owned(), ..finding };
        }
        let allowed = RIGHT[usize::from(precision == Precision::F32)];
        let Some(found) = Numbers::of(&outcome) else { return finding };
        // The mean of a chaotic motion is compared with that of accurate runs below.
        let exact = if finding.is_chaotic {
            self.tighter(scene, &options).map(|exact| (exact.clone(), false))
        } else {
            self.exact(scene, &options, (&found, finding.stated, allowed))
        };
        let Some((exact, by_reference)) = exact else { return finding };
        let (quantity, mut error) = compared_with(&found, &exact);
        if finding.is_chaotic {
            error = relative(found.value(quantity), self.ensemble(scene, &options, true).mean(quantity));
        }
        (finding.quantity, finding.error) = (Some(quantity), Some(error));
        finding.by_reference = by_reference;
        let is_off = !(error <= allowed);
        let comparison = is_off.then(|| self.compared(scene, &options, (&found, quantity, allowed)));
        finding.class = Class::of(comparison, finding.is_warned);
        finding.reason = if is_off { found.difference(&exact, quantity) } else { String::new() };
        let is_right = !is_off && !finding.is_warned && !finding.is_chaotic;
        let has_identities = is_right && quantity == Quantity::Power && self.effort.by_reference;
        let broken = has_identities.then(|| self.broken_identity(scene, &options, &outcome, allowed));
        match broken.flatten() {
            Some(reason) => Finding { class: Class::Wrong, reason, ..finding },
            None => finding,
        }
    }

    /// The identity that a right run does not hold within `allowed`: the window split in two, or the scene in other units. A
    /// motion that diverges from displaced starts holds none, nor do halves that warn, of a power that rounding
    /// takes, nor a twin that warns of as much.
    fn broken_identity(
        &self,
        scene: &Scene,
        options: &Options,
        outcome: &Outcome,
        allowed: f64,
    ) -> Option<String> {
        let energy_j = outcome.delivered_energy_j?;
        let warns = |half: &Scene| run_as_it_is(half, options).is_ok_and(|half| is_warned(&half));
        let is_counted = |split: &f64| *split > allowed && !halves(scene).iter().any(warns);
        let split = split_error(scene, options, energy_j).filter(is_counted).unwrap_or(0.0);
        let options = Options { step_s: options.step_s.map(|step_s| 2.0 * step_s), ..*options };
        let apart = |twin: &Scene| {
            let power_w = run_scene(twin, &options).ok()?.mean_power_w?;
            let apart = relative(power_w / POWER, outcome.mean_power_w.unwrap_or(0.0));
            let is_stated = |twin: &Outcome| {
                is_warned(twin) && twin.accuracy.total.is_none_or(|total| apart <= TWIN * total)
            };
            (apart > allowed && !run_as_it_is(twin, &options).is_ok_and(|twin| is_stated(&twin)))
                .then_some(apart)
        };
        let units = self.twin.as_ref().and_then(apart).unwrap_or(0.0);
        let (error, identity) = if split > units {
            (split, "the sum over both halves of the window")
        } else {
            (units, "the scene in other units")
        };
        let chaotic = || self.ensemble(scene, &options, false).diverges(Quantity::Power, allowed);
        (error > allowed && !chaotic()).then(|| format!("{identity} differs by {error:.1e}"))
    }

    /// The more accurate run of `found`, and whether it is the reference: that may be off itself.
    fn exact(
        &self,
        scene: &Scene,
        options: &Options,
        (found, stated, allowed): (&Numbers, Option<f64>, f64),
    ) -> Option<(Numbers, bool)> {
        let reference = |is_closer| Some((self.reference(scene, is_closer)?.clone(), true));
        let tighter = || Some((self.tighter(scene, options)?.clone(), false));
        let first = self.effort.by_reference.then(|| reference(false)).flatten();
        let mut exact = first.or_else(tighter)?;
        let (_, error) = compared_with(found, &exact.0);
        if stated.is_none_or(|stated| !(error <= stated)) && !(exact.1 && error > allowed) {
            exact = reference(true).unwrap_or(exact);
        }
        let (quantity, error) = compared_with(found, &exact.0);
        let is_doubted = exact.1 && !(error <= allowed);
        let doubted = (&exact.0, quantity, allowed);
        let repeats = || reference_repeats(scene, self.effort.most_attempts, doubted);
        if is_doubted && !self.repeats.get_or_init(repeats) { tighter() } else { Some(exact) }
    }

    fn reference(&self, scene: &Scene, is_closer: bool) -> Option<&Numbers> {
        let kind = usize::from(is_closer);
        let tolerance = [REFERENCE_TOLERANCE, CLOSER_TOLERANCE][kind];
        let run = || by_reference(scene, self.effort.most_attempts, tolerance);
        self.references[kind].get_or_init(run).as_ref()
    }

    fn tighter(&self, scene: &Scene, options: &Options) -> Option<&Numbers> {
        self.tighter.get_or_init(|| tighter(scene, options, HALVINGS)).as_ref()
    }

    fn ensemble(&self, scene: &Scene, options: &Options, is_chaotic: bool) -> &Ensemble {
        let kind = usize::from(is_chaotic);
        self.ensembles[kind].get_or_init(|| {
            // Two pairs of displaced starts show that a motion is chaotic. The mean alone is needed of the runs of the second.
            let pairs = [2, self.effort.chaotic_pairs][kind];
            let halvings = [HALVINGS, HALVINGS_OF_MEAN][kind];
            Ensemble::of(scene, &Options { bare: is_chaotic, ..*options }, pairs, halvings)
        })
    }

    /// How a run that is off by more than `allowed` compares with those from slightly displaced starts. Where these do
    /// not diverge, chaos excuses nothing.
    fn compared(
        &self,
        scene: &Scene,
        options: &Options,
        (found, quantity, allowed): (&Numbers, Quantity, f64),
    ) -> Comparison {
        let ensemble = self.ensemble(scene, options, false);
        if ensemble.diverges(quantity, allowed) {
            ensemble.compare(found, quantity)
        } else {
            Comparison::Differ
        }
    }
}

/// The quantity by which a run is compared with a more accurate one, and its relative error.
fn compared_with(found: &Numbers, exact: &Numbers) -> (Quantity, f64) {
    let quantity = found.quantity(exact);
    (quantity, found.error(exact, quantity))
}

fn is_warned(outcome: &Outcome) -> bool {
    outcome.warnings.iter().any(|warning| warning.starts_with("accuracy:"))
}

fn is_finite(outcome: &Outcome) -> bool {
    let numbers = [
        outcome.mean_power_w,
        outcome.rms_voltage_v,
        outcome.peak_voltage_v,
        outcome.mean_voltage_v,
        outcome.delivered_energy_j,
        outcome.created.map(|created| created.created_energy_j),
        outcome.energy_residual,
        outcome.accuracy.total,
    ];
    numbers.iter().flatten().all(|number| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::draw_varied;

    const EFFORT: Effort = Effort { most_attempts: 200_000, by_reference: false, chaotic_pairs: 16 };

    fn shipped(changes: &[&str]) -> Case {
        let run = "run={duration_periods=36,settle_periods=20}";
        Case::of("contact-separation", &[&[run], changes].concat(), Precision::F64)
    }

    #[test]
    fn a_periodic_run_is_right_by_the_reference_and_by_a_tighter_run() {
        for by_reference in [false, true] {
            let found = judge(&shipped(&[]), Effort { by_reference, ..EFFORT });
            assert_eq!(found.class, Class::Right, "{found:?}");
            assert_eq!([found.by_reference, found.is_warned], [by_reference, false]);
            assert!(found.error <= found.stated, "{found:?}");
        }
    }

    /// A motion of 10⁻¹¹ of the gap, which the reference at its usual tolerance has with an error of 2·10⁻³.
    #[test]
    fn a_run_beyond_its_statement_is_judged_by_a_closer_reference() {
        let changes = [
            "parameters.damping_ratio=2.453",
            "parameters.force_law=none",
            "parameters.parasitic_capacitance_f=4.528e-9",
            "load.resistance_ohm=189.7",
            "excitation={kind=\"sine\",amplitude_m_per_s2=2.646e-3,frequency_hz=4.924e4,phase_rad=2.701}",
            "run={duration_s=0.01,settle_s=0}",
        ];
        let case = Case::of("contact-separation", &changes, Precision::F64);
        let found = judge(&case, Effort { by_reference: true, ..EFFORT });
        assert!(found.by_reference && found.error <= found.stated, "{found:?}");
    }

    #[test]
    fn a_wrong_run_is_not_excused() {
        let case = shipped(&[]);
        let judge = Judge::new(&case, Effort { by_reference: true, ..EFFORT });
        judge.references[0].set(Some(Numbers::with(1.0, Vec::new()))).expect("is empty");
        judge.repeats.set(true).expect("is empty");
        let found = judge.finding(Precision::F64);
        assert_eq!(found.class, Class::Wrong, "{found:?}");
        assert!(found.reason.ends_with("instead of 1e0 W"), "{found:?}");
    }

    /// Halves of a window that are lost to rounding and warn, a mode whose period is within a step, a storage full to the last 10⁻⁷.
    #[test]
    fn cases_that_were_called_wrong_are_right_or_warn() {
        for (seed, number, class) in [
            (20_261_128, 17_487, Class::Right),
            (20_261_128, 1_239, Class::Warned),
            (20_261_128, 15_947, Class::Right),
            (20_261_127_001, 6_267, Class::Right),
        ] {
            let found = judge(&draw_varied(seed, number), Effort { by_reference: true, ..EFFORT });
            assert_eq!((found.class, found.by_reference), (class, true), "{found:?}");
        }
    }

    /// A rod of 2 MHz: its powers at 4 to 0.5 µs agree to 3·10⁻⁴ and are 8 % off.
    #[test]
    fn a_rod_that_oscillates_within_the_steps_is_warned_of() {
        let of = |modulus: &str| {
            let changes = [
                "parameters.beam_modes=4",
                "stop.rod_modes=1",
                modulus,
                "stop.contact=restitution",
                "stop.restitution=0.5",
                "run={duration_s=0.1,settle_s=0.02727272727272727}",
            ];
            judge(&Case::of("bump-stop", &changes, Precision::F64), Effort { by_reference: true, ..EFFORT })
        };
        let stiff = of("stop.young_modulus_pa=7e13");
        assert!(stiff.is_warned && stiff.stated.is_none() && stiff.error > Some(0.05), "{stiff:?}");
        assert!(of("stop.young_modulus_pa=7e12").stated.is_some());
    }

    #[test]
    fn a_chaotic_motion_is_judged_by_as_many_runs_as_are_asked_for() {
        let case = shipped(&[]);
        let scene = case.read().expect("the shipped scene");
        let mean = |chaotic_pairs| {
            let judge = Judge::new(&case, Effort { chaotic_pairs, ..EFFORT });
            judge.ensemble(&scene, &judge.options, true).mean(Quantity::Power)
        };
        let single = tighter(&scene, &Judge::new(&case, EFFORT).options, HALVINGS_OF_MEAN)
            .expect("runs")
            .value(Quantity::Power);
        // Each mean has the displacements of a few starts by 10⁻⁹ in its last digits.
        assert_eq!(mean(0), single);
        assert!(mean(1) != mean(3) && relative(mean(3), single) < 1e-6, "{}", mean(3));
    }

    #[test]
    fn without_power_the_motion_and_the_voltage_are_compared() {
        for resistance in ["load.resistance_ohm=0", "load.resistance_ohm=inf"] {
            let found = judge(&shipped(&[resistance]), EFFORT);
            assert_eq!(found.class, Class::Right, "{found:?}");
            assert_eq!(found.quantity, Some(Quantity::Motion));
        }
    }

    #[test]
    fn a_run_that_takes_too_many_steps_is_given_up_and_a_bad_key_is_refused() {
        let found = judge(&shipped(&[]), Effort { most_attempts: 1000, ..EFFORT });
        assert_eq!(found.class, Class::StepLimit);
        assert!(found.reason.starts_with("given up after 1000 attempted steps at 0."), "{found:?}");
        let found = judge(&shipped(&["load.resistance_ohm=-1"]), EFFORT);
        assert_eq!(found.class, Class::Refused);
        assert!(found.reason.contains("load.resistance_ohm"), "{found:?}");
    }
}
