//! What the two nodes harvest with.

use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::part::draw::NoDraw;
use model_core::part::load::OpenCircuit;
use model_core::part::monomorph::Layer;
use model_core::part::storage::{Capacitor, StorageCapacitor, StorageElement};
use model_core::scene::bump_stop::{self, BumpStop, Choices, NoStop, OneWay, Resistive};
use model_core::scene::contact_separation::Start;
use model_core::scene::rectified::{FullBridge, Rectified};
use model_core::scene::{Harvester, Simulation};
use model_core::snapshot::{Configuration, Fingerprint};

use super::NodeError;
use super::power_manager::{CAPACITANCE, STORAGE};
use crate::workload::contact_separation::TOLERANCE;
use crate::workload::contact_separation::parts;

/// Forward voltage in volts of each of the bridge's diodes.
pub const DIODE_DROP: f32 = 0.3;

/// The contact-separation harvester behind a full bridge that charges the node's storage, stepped with error
/// control. Its force is that of the field: the paper's creates energy, which a node would book and never receive. The
/// node's budget says what the storage's voltage is: here it neither leaks nor is drawn from.
///
/// # Errors
/// If its parameters are refused.
pub fn following() -> Result<impl Harvester<f32>, NodeError> {
    charging(STORAGE.lock_out_voltage)
}

/// [`following`] with another voltage of the storage at the start, in volts.
///
/// # Errors
/// If the parameters are refused.
pub(crate) fn charging(initial_voltage: f32) -> Result<impl Harvester<f32, Start = Start<f32>>, NodeError> {
    let capacitor = Capacitor { capacitance: CAPACITANCE, leakage_resistance: f32::INFINITY };
    behind_bridge(StorageCapacitor { capacitor, initial_voltage, draw: NoDraw })
}

/// The harvester behind a full bridge that charges `storage`.
///
/// # Errors
/// If the parameters are refused.
pub(crate) fn behind_bridge(
    storage: impl StorageElement<f32>,
) -> Result<impl Harvester<f32, Start = Start<f32>>, NodeError> {
    let refused = |_| NodeError::Parameters;
    let bridge = FullBridge { diode_drop: DIODE_DROP, storage };
    // The bridge is what is at the terminals.
    let alone = core::hint::black_box(parts::passive(OpenCircuit)).build().map_err(refused)?;
    let scene = Rectified::new(alone, core::hint::black_box(bridge)).map_err(refused)?;
    let tolerance = Adaptive::new(TOLERANCE).map_err(refused)?;
    Ok(Simulation::new(scene, ExponentialRadau, tolerance))
}

/// Parts of a piezoelectric cantilever with nothing to hit. What the closed form is about stands behind a bridge.
type FreeBeam = Choices<Resistive<OpenCircuit>, NoStop, OneWay>;

/// A piezoelectric cantilever behind a full bridge, by its closed form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    scene: BumpStop<f32, FreeBeam, 1, 0>,
    parameters: bump_stop::Parameters<f32, FreeBeam>,
}

impl Beam {
    /// Energy in joules that enters a storage at `voltage` volts in a second, under a sine of `amplitude` m/s² and
    /// `frequency`; none where the closed form does not hold.
    #[must_use]
    pub fn energy_in_a_second(&self, amplitude: f32, frequency: f32, voltage: f32) -> f32 {
        let found = self.scene.closed_form_into_bus(amplitude, frequency, voltage, DIODE_DROP);
        if found.validity.holds() { found.mean_power } else { 0.0 }
    }
}

/// No state of its own: what the node learns of its income is that of this beam.
impl Configuration for Beam {
    type State = ();

    fn identify(&self, fingerprint: &mut Fingerprint) {
        let bump_stop::Parameters { substrate, piezo, .. } = self.parameters;
        fingerprint.name("beam");
        for layer in [substrate, piezo] {
            fingerprint.numbers(&[layer.thickness, layer.young_modulus, layer.density]);
        }
        fingerprint.numbers(&[
            self.parameters.beam_length,
            self.parameters.beam_width,
            self.parameters.piezo_d31,
            self.parameters.piezo_permittivity,
            self.parameters.damping_ratio,
            DIODE_DROP,
        ]);
    }
}

/// A beam of 165 mm, half steel and half PZT-5A, with its first mode above the trace's line.
///
/// # Errors
/// If its parameters are refused.
pub fn listening() -> Result<Beam, NodeError> {
    let parameters = bump_stop::Parameters {
        beam_length: 0.165,
        beam_width: 0.01,
        substrate: Layer { thickness: 5e-4, young_modulus: 200e9, density: 7850.0 },
        piezo: Layer { thickness: 5e-4, young_modulus: 66e9, density: 7800.0 },
        piezo_d31: -190e-12,
        piezo_permittivity: 15.93e-9,
        damping_ratio: 0.01,
        choices: Choices::new(OpenCircuit).coupling(OneWay),
    };
    let scene = core::hint::black_box(parameters).build().map_err(|_| NodeError::Parameters)?;
    Ok(Beam { scene, parameters })
}
