//! Figures 6 to 11 of Mak, McWilliam, Popov and Fox (IMAC-XXVIII, 2010), rebuilt on the embedded core, and
//! the convergence in modes and in step that the paper asks for.

mod charging;
pub(crate) mod convergence;
mod motion;
mod shapes;

pub use self::motion::{CONTACT_FORCE, Motion, ROD, STOP_POINT, TIP, VOLTAGE};

use super::{Chapter, Figure, Panel, shipped, sine, try_each_counted};
use crate::method::{Failure, Options};
use crate::report::setting::setting;
use crate::scene_file::Scene;

/// The shipped scenes of the figures: the stop at the tip, at mid-span, and none.
const SCENES: [&str; 3] =
    ["bump-stop-below-resonance", "bump-stop-below-resonance-mid-span", "bump-stop-below-resonance-none"];
/// The shipped scene with the storage of figure 11.
const CHARGING: &str = "bump-stop-below-resonance-charging";
/// The shipped scenes of the convergence: near the resonance, where modes and step matter most.
const STIFF: [&str; 2] = ["bump-stop-tip", "bump-stop-mid-span"];

/// The shipped scenes that [`build`] reads.
pub fn scenes() -> impl Iterator<Item = &'static str> {
    SCENES.into_iter().chain([CHARGING]).chain(STIFF)
}

/// Number of runs that [`build`] makes.
pub fn runs() -> usize {
    2 * SCENES.len() + 2 + convergence::runs()
}

/// Makes the figures on all cores; `done` is called after each run.
pub fn build(done: &(dyn Fn() + Sync)) -> Result<Chapter, Failure> {
    let all = |names: &[&str]| names.iter().map(|name| shipped(name)).collect::<Result<Vec<Scene>, _>>();
    let (scenes, stiff) = (all(&SCENES)?, all(&STIFF)?);
    let motions = try_each_counted(&scenes, done, Motion::of)?;
    let charged = charging::of(&shipped(CHARGING)?, &scenes, done)?;
    let ([tip, mid, none], [tip_store, mid_store, no_stop_store]) = (&motions[..], &charged[..]) else {
        return Err(Failure::Input("three scenes were run".to_owned()));
    };
    let ([tip_scene, mid_scene, _], [stiff_tip, stiff_mid]) = (&scenes[..], &stiff[..]) else {
        return Err(Failure::Input("five scenes were read".to_owned()));
    };
    let (note, stiff_note) = (note(tip_scene)?, note(stiff_tip)?);
    let (with_gap, stiff_base) = (setting(tip_scene, &[]), setting(stiff_tip, &[]));
    let charged_base = setting(&shipped(CHARGING)?, &[]);
    let shapes = shapes::of([(tip_scene, tip), (mid_scene, mid)], done)?;
    let modes = convergence::in_modes([stiff_tip, stiff_mid], done)?;
    let steps = convergence::in_step(stiff_tip, done)?;
    let figures = vec![
        motion::six(tip, [&with_gap, &note]),
        shapes::seven(tip, gap_m(tip_scene), [&with_gap, &note])?,
        motion::eight([tip, none], [&with_gap, &note]),
        motion::nine([tip, mid, none], [&with_gap, &note]),
        shapes::ten(&shapes, [&with_gap, &note]),
        charging::eleven([tip_store, mid_store, no_stop_store], [&charged_base, &note]),
        convergence::modes_figure(&modes, [&stiff_base, &stiff_note]),
        convergence::step_figure(&steps, [&stiff_base, &stiff_note]),
    ];
    Ok(Chapter {
        title: "Bump-stop harvester: figures 6 to 11 rebuilt",
        introduction: INTRODUCTION.to_owned(),
        points: scenes.iter().chain(&stiff).map(|scene| (scene.clone(), Options::default())).collect(),
        figures,
    })
}

/// Gap at rest in m; 0 without a stop.
fn gap_m(scene: &Scene) -> f64 {
    scene.bump_stop().ok().and_then(|model| model.stop).map_or(0.0, |stop| stop.gap_m)
}

const INTRODUCTION: &str = "<p>After Mak, McWilliam, Popov and Fox, <i>Vibro-Impact Dynamics of a \
    Piezoelectric Energy Harvester</i>, IMAC-XXVIII (2010). The paper's tables are lost: dimensions, \
    materials, frequency, amplitude, gap and load are choices of this library, with which the results of the paper \
    hold (command <code>findings</code>); ten modes of beam and rod and a damping ratio of 0.01 are what its remains \
    suggest. Compare shapes and trends with the paper, not values. Unlike in the paper the voltage acts \
    back on the beam, and the contact is closed by the static compliance of the modes left out. The convergence is shown \
    near the resonance, at 220 Hz into 1 MΩ with a stop that touches the beam at rest, where modes and step matter \
    most.</p>\n\
    <p>Run in double precision on the embedded core, the code of the firmware.</p>\n";

/// The base acceleration of the runs, for every caption.
fn note(scene: &Scene) -> Result<String, Failure> {
    let tone = sine(scene)?;
    Ok(format!(
        "Base acceleration {} m/s² at {} Hz, both chosen, as are beam and rod.",
        tone.amplitude_m_per_s2, tone.frequency_hz
    ))
}
