//! The harvesters' motions, as general integrators take them.

pub(crate) mod bump_stop;
pub(crate) mod contact_separation;
pub(crate) mod sliding;

/// Vacuum permittivity in F/m.
pub(crate) const VACUUM_PERMITTIVITY: f64 = 8.854_187_812_8e-12;
