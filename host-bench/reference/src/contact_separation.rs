//! The reference for the contact-separation harvester: flights, impacts and sticks.

mod guards;
mod harvester;
mod physics;

pub(super) use self::physics::Physics as ContactSeparation;

#[cfg(test)]
mod tests;
