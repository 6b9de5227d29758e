//! What the node harvests with.

use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::part::draw::NoDraw;
use model_core::part::load::OpenCircuit;
use model_core::part::storage::{Capacitor, StorageCapacitor, StorageElement};
use model_core::scene::contact_separation::Start;
use model_core::scene::rectified::{FullBridge, Rectified};
use model_core::scene::{Harvester, Simulation};

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
