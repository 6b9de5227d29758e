//! The option `--storage-voltage` of the commands on a steady state.

use super::Unused;
use crate::method::Failure;
use crate::scene_file::Scene;

/// Highest voltage of a storage or bus in V, as in a scene file.
const HIGHEST_V: f64 = 1e6;
/// Keys of a storage that a held voltage replaces.
const REPLACED: [Unused; 5] = [
    ("load.voltage_v", "--storage-voltage gives the voltage"),
    ("load.capacitance_f", "--storage-voltage holds the voltage of the storage"),
    ("load.initial_v", "--storage-voltage holds the voltage of the storage"),
    ("load.leakage_ohm", "--storage-voltage holds the voltage of the storage"),
    ("load.draw", "--storage-voltage holds the voltage of the storage"),
];

#[derive(Debug, Clone, Copy, clap::Args)]
pub(super) struct StorageVoltage {
    /// Hold the voltage of the storage or bus behind the bridge at this value in V
    #[arg(long, value_name = "V", allow_hyphen_values = true)]
    storage_voltage: Option<f64>,
}

impl StorageVoltage {
    /// Whether the option is given.
    pub(super) fn is_given(self) -> bool {
        self.storage_voltage.is_some()
    }

    /// The keys that a command does not use, with those that the option replaces.
    pub(super) fn unused(self, others: &[Unused]) -> Vec<Unused> {
        let replaced: &[Unused] = if self.is_given() { &REPLACED } else { &[] };
        [others, replaced].concat()
    }

    /// Holds the voltage of a scene's storage.
    pub(super) fn hold(self, scene: &mut Scene) -> Result<(), Failure> {
        let Some(voltage) = self.storage_voltage else { return Ok(()) };
        if !(0.0..=HIGHEST_V).contains(&voltage) {
            let text = format!("--storage-voltage {voltage}: must be a number from 0 to {HIGHEST_V:e}");
            return Err(Failure::Input(text));
        }
        scene.load = scene.load.held_at(voltage).ok_or_else(|| {
            Failure::of_file(
                scene,
                "load.kind: must be a bridge (\"rectified-store\", \"dc-bus\") with --storage-voltage",
            )
        })?;
        Ok(())
    }

    /// Refuses the option without `--steady-state`.
    pub(super) fn check(self, steady_state: bool) -> Result<(), Failure> {
        if self.is_given() && !steady_state {
            return Err(Failure::Input("--storage-voltage: must be with --steady-state".to_owned()));
        }
        Ok(())
    }
}
