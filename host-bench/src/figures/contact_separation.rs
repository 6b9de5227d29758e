//! Figures 8 to 11 of Fu, Ouyang and Davis (J. Phys. D 53, 2020), rebuilt on the embedded core: the
//! second half of the paper, on the contact-separation harvester.

mod motion;
mod response;

use self::motion::{Case, FREQUENCIES, Grid};
use self::response::{Sweep, diagram, pairs, sweeps};

use super::{Chapter, Figure, Panel, sine, table, try_each_counted};
use crate::method::Failure;
use crate::scene_file::{GRAVITY, Scene};

/// Relative tolerance of the frequency responses. From here to 1e-7 the largest gap of a periodic motion changes by less
/// than a part in 1e4, far less than the width of a curve. A run takes 40 ms.
pub(crate) const RESPONSE_TOLERANCE: f64 = 1e-3;

/// Relative tolerance of single motions. At the lower of the two frequencies at the onset of impacts the mass passes the
/// dielectric at a distance of 70 µm: the computed distance is 9 µm at a tolerance of 1e-3, and 64 µm at 1e-4.
pub(crate) const MOTION_TOLERANCE: f64 = 1e-4;

/// Periods before those that are measured, as in the paper's kind of response. Far from the onset of impacts 5 µm of the
/// initial transient are left.
pub(crate) const SETTLE: u32 = 200;
/// Periods before those that are measured in figure 10, which must not show the initial transient. Just below the onset
/// of impacts the transient decays over hundreds of periods, with a beat of the softening spring.
pub(crate) const DIAGRAM_SETTLE: u32 = 800;

/// Frequencies of figures 8 and 11.
const RESPONSES: Grid = Grid { from: 1800, to: 2200, step: 2 };
/// Frequencies of figure 10.
const DIAGRAM: Grid = Grid { from: 1850, to: 2050, step: 1 };
/// Charge density in µC/m² and load in MΩ of figures 9 and 10.
pub(crate) const STRONG: [f64; 2] = [50.0, 100.0];

/// Number of runs that [`build`] makes.
pub(crate) fn runs() -> usize {
    pairs().len() * RESPONSES.frequencies().count() + DIAGRAM.frequencies().count() + FREQUENCIES.len()
}

/// Makes the figures on all cores; `done` is called after each run.
pub(crate) fn build(base: &Scene, done: &(dyn Fn() + Sync)) -> Result<Chapter, Failure> {
    let start = start(base)?;
    let of_base = format!("{} g", sine(base)?.amplitude_m_per_s2 / GRAVITY);
    let of = [of_base.as_str(), &start];
    let sweeps = sweeps(base, &pairs(), RESPONSES, RESPONSE_TOLERANCE, done)?;
    let nine = motion::nine(base, STRONG, MOTION_TOLERANCE, of, done)?;
    let diagram = diagram(base, STRONG, DIAGRAM, MOTION_TOLERANCE, done)?;
    let [charge_density, resistance] = STRONG;
    let of_nine = FREQUENCIES.map(|frequency| Case { charge_density, resistance, frequency, settle: SETTLE });
    let points = sweeps.iter().flat_map(Sweep::marked).map(|case| case.point(base, RESPONSE_TOLERANCE));
    let points =
        points.chain(of_nine.map(|case| case.point(base, MOTION_TOLERANCE))).collect::<Result<_, _>>()?;
    Ok(Chapter {
        title: "Contact-separation harvester: figures 8 to 11 rebuilt",
        introduction: introduction(),
        points,
        figures: vec![
            response::eight(&sweeps, RESPONSES, of),
            nine,
            response::ten(&diagram, STRONG, DIAGRAM, of),
            response::eleven(&sweeps, RESPONSES, of),
        ],
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

/// Base acceleration and start of the runs, for every caption.
fn start(base: &Scene) -> Result<String, Failure> {
    let tone = sine(base)?;
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
