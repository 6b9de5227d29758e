//! The embedded core on the host: runs of any scene file, and their periodic steady state by shooting.
//!
//! Every harvester, method, precision and set of elementary functions of `model-core` is compiled in this crate. It
//! has no unit tests, so that this happens once.

pub mod embedded;
pub mod steady_state;
