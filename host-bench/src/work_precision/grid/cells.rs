//! The scenes of the grid.

use std::f64::consts::TAU;
use std::path::PathBuf;

use crate::method::Failure;
use crate::scene_file::{self, Excitation, GRAVITY, Override, Scene, Tone, Trace};

const FORCE_LAWS: [&str; 2] = ["transferred-charge", "gap-field"];
/// Loads of contact-separation under the shipped sine, in Ω.
const CONTACT_LOADS: [f64; 8] = [1.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];
/// Loads of contact-separation under two tones and under samples, in Ω.
const OTHER_LOADS: [f64; 2] = [1e6, 1e8];
/// Loads of sliding, in Ω.
const SLIDING_LOADS: [f64; 4] = [1e4, 1e6, 1e8, 1e9];
/// Amplitude in g and frequency in Hz under which the slider moves with the law of the gap field.
const STRONG: [f64; 2] = [0.8, 16.0];
/// The same under which contact-separation with that law hits once a period; under the shipped sine it is chaotic.
const STRONG_CONTACT: [f64; 2] = [1.0, 20.0];
/// Amplitude in g and frequency in Hz under which the slider sticks and slips.
const STICK_SLIP: [f64; 2] = [0.3, 6.0];
/// Amplitude in g and frequency in Hz of the two tones.
const TWO_TONES: [[f64; 2]; 2] = [[0.2, 20.0], [0.1, 27.0]];
/// Samples per second.
const RATE_HZ: f64 = 400.0;

/// A scene of the grid with its names.
pub(crate) struct Cell {
    pub(super) name: &'static str,
    pub(super) force_law: &'static str,
    pub(super) excitation: &'static str,
    pub(super) scene: Scene,
}

/// All scenes, with `overrides` in each.
///
/// # Errors
/// If an override is refused.
pub(crate) fn cells(overrides: &[Override]) -> Result<Vec<Cell>, Failure> {
    let mut cells = Vec::new();
    for force_law in FORCE_LAWS {
        let contact = |load_ohm, sine| cell("contact-separation", force_law, load_ohm, sine, overrides);
        for load_ohm in CONTACT_LOADS {
            cells.push(contact(load_ohm, None)?);
        }
        if force_law == "gap-field" {
            for load_ohm in CONTACT_LOADS {
                cells.push(contact(load_ohm, Some(STRONG_CONTACT))?);
            }
        }
        for load_ohm in OTHER_LOADS {
            let excitations = [("two tones", two_tones()), ("400 Hz samples", samples())];
            for (excitation, own) in excitations {
                let mut cell = contact(load_ohm, None)?;
                cell.excitation = excitation;
                cell.scene.excitation = own;
                cells.push(cell);
            }
        }
        let strong = (force_law == "gap-field").then_some(STRONG);
        for load_ohm in SLIDING_LOADS {
            cells.push(cell("sliding", force_law, load_ohm, strong, overrides)?);
        }
    }
    let mut stick_slip = cell("sliding", "transferred-charge", 1e8, Some(STICK_SLIP), overrides)?;
    (stick_slip.name, stick_slip.excitation) = ("stick-slip", "slow sine");
    cells.push(stick_slip);
    Ok(cells)
}

/// A shipped scene with a load and a force law, under its own sine or one of another amplitude in g and frequency in
/// Hz.
fn cell(
    name: &'static str,
    force_law: &'static str,
    load_ohm: f64,
    sine: Option<[f64; 2]>,
    overrides: &[Override],
) -> Result<Cell, Failure> {
    let mut all = vec![
        Override::new("load.resistance_ohm", &load_ohm.to_string()),
        Override::new("parameters.force_law", force_law),
    ];
    if let Some([amplitude_g, frequency_hz]) = sine {
        all.push(Override::new("excitation.amplitude_g", &amplitude_g.to_string()));
        all.push(Override::new("excitation.frequency_hz", &frequency_hz.to_string()));
    }
    all.extend(overrides.iter().cloned());
    let mut scene = scene_file::read(&scene_file::shipped(name), &all)?;
    // The name without the folder in which this crate was built.
    scene.file = PathBuf::from(name).with_extension("toml");
    let excitation = if sine.is_some() { "strong sine" } else { "sine" };
    Ok(Cell { name, force_law, excitation, scene })
}

fn two_tones() -> Excitation {
    let tone = |[amplitude_g, frequency_hz]: [f64; 2]| Tone {
        amplitude_m_per_s2: amplitude_g * GRAVITY,
        frequency_hz,
        phase_rad: 0.0,
    };
    Excitation::Sines(TWO_TONES.map(tone).to_vec())
}

/// A second of the two tones, which are whole Hz, again and again.
fn samples() -> Excitation {
    let sample = |index: u32| {
        let time_s = f64::from(index) / RATE_HZ;
        let value = |[amplitude_g, frequency_hz]: [f64; 2]| {
            amplitude_g * GRAVITY * (TAU * frequency_hz * time_s).sin()
        };
        TWO_TONES.map(value).iter().sum()
    };
    let samples_m_per_s2 = (0..RATE_HZ as u32).map(sample).collect();
    Excitation::File(Trace { samples_m_per_s2, rate_hz: RATE_HZ, repeat: true })
}
