//! Instructions of a [`Node`](crate::node::Node), by which firmware and simulations state what knowing costs.

use super::Core;

/// Instructions of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instructions {
    /// Of a wake-up with a reading: filter, budget and decision.
    pub reading: f32,
    /// Of one of the node by the voltage alone.
    pub voltage: f32,
    /// Of a glance: a reading that is only compared.
    pub glance: f32,
    /// Of a sample in a listen.
    pub sample: f32,
    /// Of the end of a block, with its look-up, the filter and the wake after it.
    pub block: f32,
}

/// Instructions under QEMU of the node of `on-target --node` over its day, with its decisions on two actions and the forecasts for
/// them: the table "Cost" of `docs/node.md`, rounded up. Those of the M0 are with the arithmetic of `firmware-example`.
#[must_use]
pub const fn node_instructions(core: Core) -> Instructions {
    match core {
        Core::M0Plus => {
            Instructions { reading: 37_000.0, voltage: 4_600.0, glance: 560.0, sample: 40.0, block: 82_000.0 }
        }
        Core::M4F | Core::M33 => {
            Instructions { reading: 2_200.0, voltage: 480.0, glance: 320.0, sample: 23.0, block: 15_000.0 }
        }
    }
}
