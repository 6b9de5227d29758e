//! The components of scenes: beams, contacts, loads, rectifiers, storage.
//!
//! Each component has one type for every choice made at compile time, so that firmware contains only the code
//! of its scene, and one `Any…` type for a choice at run time, for a host that reads any scene file. Both
//! give the same bits.

pub mod beam;
pub(crate) mod bridge_step;
pub(crate) mod circuit;
pub(crate) mod disc_overlap;
pub mod draw;
pub mod force_law;
pub mod friction;
pub mod load;
pub mod monomorph;
pub mod parasitic;
pub mod rectifier;
pub mod restitution;
pub(crate) mod rod;
pub mod stick_charge;
pub mod storage;
pub mod storage_step;

/// Vacuum permittivity `ε0` in F/m.
pub const VACUUM_PERMITTIVITY: f64 = 8.854_187_812_8e-12;

/// Acceleration of gravity in m/s², rounded as in the papers.
pub const GRAVITY: f64 = 9.81;
