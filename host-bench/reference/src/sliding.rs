//! The reference for the sliding harvester: slip in either direction, and stick.
//!
//! In one slip the direction of the friction and the side of the middle are fixed, so the equations are smooth.

mod guards;
mod harvester;
mod overlap;
mod physics;

pub(super) use self::physics::Physics as Sliding;

#[cfg(test)]
mod tests;
