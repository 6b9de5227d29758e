//! Parts that scenes are put together from.
//!
//! Each part has a type for every choice that can be made at compile time, so that firmware
//! contains what its scene needs and no more, and one `Any…` type that makes the choice at run
//! time for a host that must serve any scene file. Both give the same bits.

pub mod bounds;
pub mod load;
pub mod parasitic;
pub mod restitution;
