//! Figures 6 to 10 of Mak, McWilliam, Popov and Fox (IMAC-XXVIII, 2010), rebuilt on the embedded core, and
//! the convergence in modes and in step that the paper asks for.

mod chatter;
mod convergence;
mod history;
mod motion;
mod shapes;

pub use self::motion::{CONTACT_FORCE, Motion, ROD, STOP_POINT, TIP, VOLTAGE};

use super::{Chapter, Figure, Panel, each, shipped, sine};
use crate::method::Failure;
use crate::scene_file::Scene;

/// The shipped scenes of the figures: the stop at the tip, at mid-span, and none.
const SCENES: [&str; 3] = ["bump-stop-tip", "bump-stop-mid-span", "bump-stop-none"];

/// Number of runs that [`build`] makes.
pub fn runs() -> usize {
    SCENES.len() + 2 + convergence::runs()
}

/// Makes the figures on all cores; `done` is called after each run.
pub fn build(done: &(dyn Fn() + Sync)) -> Result<Chapter, Failure> {
    let scenes = SCENES.iter().map(|name| shipped(name)).collect::<Result<Vec<Scene>, _>>()?;
    let motions = each(&scenes, done, Motion::of)?;
    let ([tip, mid, none], [tip_scene, mid_scene, _]) = (&motions[..], &scenes[..]) else {
        return Err(Failure::Input("three scenes were run".to_owned()));
    };
    let note = note(tip_scene)?;
    let shapes = shapes::of([(tip_scene, tip), (mid_scene, mid)], done)?;
    let modes = convergence::in_modes([tip_scene, mid_scene], done)?;
    let steps = convergence::in_step(tip_scene, done)?;
    let figures = || -> Result<Vec<Figure>, String> {
        Ok(vec![
            history::six(tip, &note)?,
            chatter::seven(tip, &note)?,
            history::eight([tip, none], &note)?,
            history::nine([tip, mid, none], &note)?,
            shapes::ten(&shapes, &note)?,
            convergence::modes_figure(&modes, &note)?,
            convergence::step_figure(&steps, &note)?,
        ])
    };
    Ok(Chapter {
        title: "Bump-stop harvester: figures 6 to 10 rebuilt",
        introduction: INTRODUCTION.to_owned(),
        figures: figures().map_err(Failure::Input)?,
    })
}

const INTRODUCTION: &str = "<p>After Mak, McWilliam, Popov and Fox, <i>Vibro-Impact Dynamics of a \
    Piezoelectric Energy Harvester</i>, IMAC-XXVIII (2010). The paper's tables are lost: dimensions and \
    materials, frequency and amplitude are choices of this library, made for its orders of magnitude; ten modes \
    of beam and rod, 1 MΩ, a damping ratio of 0.01 and a stop that touches the beam at rest are what its \
    remains suggest. Compare shapes and trends with the paper, not values. Unlike in the paper the voltage acts \
    back on the beam, and the contact is closed by the static compliance of the modes left out.</p>\n\
    <p>Run in double precision on the embedded core, the code of the firmware.</p>\n";

/// The base acceleration of the runs, for every caption.
fn note(scene: &Scene) -> Result<String, Failure> {
    let tone = sine(scene)?;
    Ok(format!(
        "Base acceleration {} m/s² at {} Hz, both chosen, as are beam and rod.",
        tone.amplitude_m_per_s2, tone.frequency_hz
    ))
}
