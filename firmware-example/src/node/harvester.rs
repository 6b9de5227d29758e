//! What the two nodes harvest with.

use model_core::energy::estimator::{HybridModel, Model};
use model_core::integrate::{Adaptive, TrBdf2};
use model_core::part::load::OpenCircuit;
use model_core::part::monomorph::Layer;
use model_core::scene::bump_stop::{self, BumpStop, NoStop, OneWay, Stop};

use super::NodeError;
use crate::workload::contact_separation::parts;
use crate::workload::contact_separation::scenes::TOLERANCE;

/// The contact-separation harvester, stepped with error control.
///
/// # Errors
/// If its parameters are refused.
pub fn following() -> Result<impl Model<f32>, NodeError> {
    let scene = core::hint::black_box(parts::whole()).build().map_err(|_| NodeError::Parameters)?;
    Ok(HybridModel::<_, _, _, 3, 1>::new(scene, TrBdf2, Adaptive::new(TOLERANCE)))
}

/// Parts of a piezoelectric cantilever with nothing to hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeBeam;

impl bump_stop::Parts<f32> for FreeBeam {
    // What the closed form is about stands behind a bridge.
    type Load = OpenCircuit;
    type Coupling = OneWay;
    type Contact = NoStop;
}

/// A piezoelectric cantilever behind a full bridge, by its closed form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam(BumpStop<f32, FreeBeam, 1, 0>);

/// Forward voltage in volts of each of the bridge's diodes.
const DIODE_DROP: f32 = 0.3;

impl Beam {
    /// Energy in joules that enters a store at `voltage` volts in a second, under a sine of `amplitude` m/s² and
    /// `hertz`; none where the closed form does not hold.
    #[must_use]
    pub fn energy_in_a_second(&self, amplitude: f32, hertz: f32, voltage: f32) -> f32 {
        let found = self.0.closed_form_into_bus(amplitude, hertz, voltage, DIODE_DROP);
        if found.validity.holds() { found.mean_power } else { 0.0 }
    }
}

/// A beam of 150 mm, half steel and half PZT-5A, with its first mode above the trace's line.
///
/// # Errors
/// If its parameters are refused.
pub fn listening() -> Result<Beam, NodeError> {
    let parameters = bump_stop::Parameters::<f32, FreeBeam> {
        beam_length: 0.15,
        beam_width: 0.01,
        substrate: Layer { thickness: 5e-4, young_modulus: 200e9, density: 7850.0 },
        piezo: Layer { thickness: 5e-4, young_modulus: 66e9, density: 7800.0 },
        piezo_d31: -190e-12,
        piezo_permittivity: 15.93e-9,
        damping_ratio: 0.01,
        stop: Stop {
            length: 1.0,
            section: 1.0,
            young_modulus: 1e9,
            density: 1e3,
            position: 0.15,
            gap: 0.0,
            contact_compliance: 0.0,
        },
        load: OpenCircuit,
        coupling: OneWay,
        contact: NoStop,
    };
    let beam = core::hint::black_box(parameters).build().map_err(|_| NodeError::Parameters)?;
    Ok(Beam(beam))
}
