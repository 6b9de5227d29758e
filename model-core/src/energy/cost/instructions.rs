//! Instructions of a node, by which firmware and simulations state what knowing costs.

use super::Core;

/// Instructions of a [`VoltageNode`](crate::node::VoltageNode), and of the bursts of a [`MapNode`](crate::node::MapNode).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instructions {
    /// Of a wake-up with a reading, and the decision after it.
    pub reading: f32,
    /// Of a sample in a burst.
    pub sample: f32,
    /// Of the end of a block, with its look-up, and of the wake after it.
    pub block: f32,
}

/// Instructions under QEMU of the node of `on-target --node` over its day, with its decisions on two actions: the table "Cost" of
/// `docs/node.md`, rounded up. Those of the M0 are with the arithmetic of `firmware-example`.
#[must_use]
pub const fn node_instructions(core: Core) -> Instructions {
    match core {
        Core::M0Plus => Instructions { reading: 4_900.0, sample: 40.0, block: 45_000.0 },
        Core::M4F | Core::M33 => Instructions { reading: 490.0, sample: 24.0, block: 14_000.0 },
    }
}
