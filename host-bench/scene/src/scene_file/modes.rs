//! The vibration modes of the beams that a scene file describes: for the checks of the reader, the reference
//! and the peers.

mod bump_stop;
mod cantilever;
mod quadrature;

pub use self::bump_stop::BumpStopModes;
pub use self::cantilever::Cantilever;
