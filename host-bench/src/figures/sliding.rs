//! Figures 3 to 6 of Fu, Ouyang and Davis (J. Phys. D 53, 2020), rebuilt on the embedded core: the first
//! half of the paper, on the sliding harvester.
//!
//! All points are periodic steady states, found by shooting.

mod resistance;
mod resonance;

pub(crate) use self::resonance::{Case, Peak};

use super::{Chapter, Figure, Panel, sine, try_each_counted};
use crate::method::{Failure, Options};
use crate::report::setting::with_unit;
use crate::scene_file::{GRAVITY, Scene};

/// Relative tolerance of the steps. At 1e-7 a resonance differs by less than 1e-5 Hz, its amplitude by less than 1e-5 of it.
pub(crate) const TOLERANCE: f64 = 1e-5;

/// The small and the large charge density in µC/m².
const DENSITIES: [f64; 2] = [20.0, 120.0];

/// Number of resonances that [`build`] follows.
pub(crate) fn runs() -> usize {
    resonance::cases().len() + resistance::cases().len()
}

/// Makes the figures on all cores; `done` is called after each resonance.
pub(crate) fn build(base: &Scene, done: &(dyn Fn() + Sync)) -> Result<Chapter, Failure> {
    let natural = base.sliding()?.parameters.natural_frequency_hz();
    let base_g = format!("{} g", sine(base)?.amplitude_m_per_s2 / GRAVITY);
    let note = format!(
        "Base acceleration {base_g}; natural frequency without friction {natural:.4} Hz. Charge densities, \
         resistances and acceleration are chosen."
    );
    let of = [base_g.as_str(), &note];
    let curves = try_each_counted(&resonance::cases(), done, |case| resonance::Response::of(base, case))?;
    let peaks = try_each_counted(&resistance::cases(), done, |case| case.peak(base))?;
    let figures = vec![
        resonance::three(&curves, of),
        resonance::four(&curves, of),
        resonance::five(&curves, of),
        resistance::six(&peaks, natural, of),
        resistance::charge_sweep(&peaks, natural, &note),
        resistance::resistance_sweep(&peaks, natural, &note),
    ];
    Ok(Chapter {
        title: "Sliding harvester: figures 3 to 6 rebuilt",
        introduction: introduction(),
        points: vec![(base.clone(), Options::default())],
        figures,
    })
}

fn introduction() -> String {
    format!(
        "<p>After Fu, Ouyang and Davis, <i>Effects of electrical properties on vibrations via electromechanical \
         coupling in triboelectric energy harvesting</i>, J. Phys. D 53 (2020). Most numbers of the paper do not \
         survive in the text that we have. Beam, slider mass, patch radius, amplitude of the base, charge \
         densities and resistances are choices of this library, made so that the paper's trends show: compare \
         shapes and trends with the paper, not values. The force law is inferred.</p>\n\
         <p>Every point is the periodic steady state, found by shooting on the embedded core, the code of the \
         firmware, in double precision with a relative tolerance of {TOLERANCE:.0e}. Peaks are narrowed down to \
         20 µHz.</p>\n"
    )
}

/// A resistance in Ω as text.
fn ohms(resistance: f64) -> String {
    with_unit(resistance, "Ω")
}
