//! Figures 8 to 11 of Fu, Ouyang and Davis (J. Phys. D 53, 2020), rebuilt on the embedded core: the
//! second half of the paper, on the contact-separation harvester.

mod bifurcation;
mod history;
mod motion;
mod response;

pub use self::bifurcation::diagram;
pub use self::history::FREQUENCIES;
pub use self::motion::{Case, Grid, Motion, Response, WINDOW};
pub use self::response::{CHARGE_DENSITIES, RESISTANCES, Sweep, pairs, sweeps};

use super::{Chapter, Figure, Panel};
use crate::method::Failure;
use crate::scene_file::{Excitation, GRAVITY, Scene};

/// Relative tolerance of the frequency responses: against 1e-7 the largest gap of a periodic motion
/// moves by less than 1e-4, far less than the width of a curve, and a run takes 40 ms.
pub const RESPONSE_TOLERANCE: f64 = 1e-3;

/// Relative tolerance where single motions are shown. Between the two frequencies at the onset of
/// impacts the gap that is missed is 70 µm: at 1e-3 of it 9 µm are left, at 1e-4 64 µm.
pub const MOTION_TOLERANCE: f64 = 1e-4;

/// Periods before those that are measured, as in the paper's kind of response: far from the
/// onset of impacts 5 µm of the start are left.
pub const SETTLE: u32 = 200;
/// The same for figure 10, where the start must not be seen: just below the onset of impacts it fades
/// over hundreds of periods, while the softening spring lets it come and go.
pub const DIAGRAM_SETTLE: u32 = 800;

/// Frequencies of figures 8 and 11.
const RESPONSES: Grid = Grid { from: 1800, to: 2200, step: 2 };
/// Frequencies of figure 10.
const DIAGRAM: Grid = Grid { from: 1850, to: 2050, step: 1 };
/// Charge density in µC/m² and load in MΩ of figures 9 and 10.
pub const STRONG: [f64; 2] = [50.0, 100.0];

/// Number of runs that [`build`] makes.
#[must_use]
pub fn runs() -> usize {
    pairs().len() * RESPONSES.frequencies().count() + DIAGRAM.frequencies().count() + FREQUENCIES.len()
}

/// Makes the figures on all cores; `done` is called after each run.
///
/// # Errors
/// If a run fails or a picture cannot be drawn.
pub fn build(base: &Scene, done: &(dyn Fn() + Sync)) -> Result<Chapter, Failure> {
    let start = start(base)?;
    let sweeps = sweeps(base, &pairs(), RESPONSES, RESPONSE_TOLERANCE, done)?;
    let nine = history::nine(base, STRONG, MOTION_TOLERANCE, &start, done)?;
    let diagram = diagram(base, STRONG, DIAGRAM, MOTION_TOLERANCE, done)?;
    let rest = || -> Result<[Figure; 3], String> {
        Ok([
            response::eight(&sweeps, RESPONSES, &start)?,
            bifurcation::ten(&diagram, STRONG, DIAGRAM, &start)?,
            response::eleven(&sweeps, RESPONSES, &start)?,
        ])
    };
    let [eight, ten, eleven] = rest().map_err(Failure::Input)?;
    Ok(Chapter {
        title: "Contact-separation harvester: figures 8 to 11 rebuilt",
        introduction: introduction(),
        figures: vec![eight, nine, ten, eleven],
    })
}

fn introduction() -> String {
    format!(
        "<p>After Fu, Ouyang and Davis, <i>Effects of electrical properties on vibrations via electromechanical \
         coupling in triboelectric energy harvesting</i>, J. Phys. D 53 (2020). Most numbers of the paper do not \
         survive in the text that we have. Mass, stiffness, electrode area, restitution, amplitude of the base, \
         the charge densities and the middle resistance are choices of this library, made so that the paper's \
         trends show: compare shapes and trends with the paper, not values.</p>\n\
         <p>Run in double precision on the embedded core, the code of the firmware, with a relative tolerance \
         of {RESPONSE_TOLERANCE:.0e} for the frequency responses (figures 8 and 11) and of \
         {MOTION_TOLERANCE:.0e} for single motions (9 and 10).</p>\n"
    )
}

/// What every caption says of the runs.
fn start(base: &Scene) -> Result<String, Failure> {
    let Excitation::Sine(tone) = &base.excitation else {
        return Err(Failure::Input(format!("{}: excitation.kind must be \"sine\"", base.file.display())));
    };
    let model = base.contact_separation()?;
    Ok(format!(
        "Base acceleration {} g. Every run starts anew, at rest at the initial gap of {} mm, without voltage; the \
         frequency at which impacts end depends on that.",
        tone.amplitude_m_per_s2 / GRAVITY,
        1e3 * model.parameters.initial_gap_m,
    ))
}

#[cfg(test)]
mod tests;
