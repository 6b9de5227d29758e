//! The storage of a node as it is, and the harvester that charges it: what the node's budget is an estimate of.

mod looped;
mod storage;

pub(super) use self::looped::LoopedStorage;
pub(super) use self::storage::ChargedStorage;
use crate::method::Failure;
use crate::scene_file::Storage;

/// The storage of a node with its harvester and loads.
pub(super) trait Plant {
    /// Voltage of the storage in V.
    fn voltage(&self) -> f64;

    /// Energy in the storage in J.
    fn energy(&self) -> f64;

    /// Whether the node is switched on.
    fn is_supplied(&self) -> bool;

    /// Whether the node was switched on all through the last interval.
    fn was_supplied(&self) -> bool;

    /// Takes the energy in J of an action at the node.
    fn spend(&mut self, energy: f64);

    /// Advances by some seconds from a second of the day on; gives the energy in J that the harvester delivers in them.
    fn advance(&mut self, from: u32, seconds: u32) -> Result<f64, Failure>;

    /// Where energy came from and went since the account began.
    fn account(&mut self) -> &mut StorageAccount;
}

/// Energy in J of a storage at a voltage in V.
pub(super) fn energy_at(storage: &Storage, voltage: f64) -> f64 {
    0.5 * storage.capacitance_f * voltage * voltage
}

/// Power in W at the storage of a standing load at the node, with the storage's own.
fn standing_power(storage: &Storage, at_node: f64) -> f64 {
    at_node / storage.discharging_efficiency + storage.own_power_w
}

/// Energies since the account began, in J: the first at the harvester's load, all others at the storage.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct StorageAccount {
    /// Delivered by the harvester.
    pub(super) harvested: f64,
    /// Delivered, times the charging efficiency.
    pub(super) income: f64,
    /// Income above the highest voltage.
    pub(super) shunted: f64,
    pub(super) leaked: f64,
    /// Taken by actions.
    pub(super) actions: f64,
    /// Taken by the standing load.
    pub(super) standing: f64,
    /// Lost in the diodes of a bridge, if the bridge is simulated step by step.
    pub(super) diodes: f64,
    /// Steps of the harvester, if it is simulated with the storage.
    pub(super) steps: u64,
    /// Seconds for which the node was switched off.
    pub(super) lockout_s: u32,
    /// How often the node was switched off.
    pub(super) lockouts: u32,
}
