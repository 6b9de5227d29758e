//! The periodic steady state of a harvester under one sine, by shooting.
//!
//! The state at one phase of the excitation determines the state a period later: the *period map* `P`
//! of the hybrid system, impacts and sticking included, computed by the embedded core itself. A motion
//! that repeats itself in every period is a fixed point `P(x) = x`, found by Newton's iteration in some
//! ten simulated periods, where a transient takes hundreds. The eigenvalues of `∂P/∂x` there are the
//! Floquet multipliers: the motion is stable if all lie within the unit circle. Multipliers just below
//! one, of a circuit much slower than the motion, cost nothing.
//!
//! Where several stable motions exist, the one that a run from the scene's start ends in is wanted. So
//! a transient comes first, and a motion is taken only if the transient is seen to go there.
//!
//! T. S. Parker and L. O. Chua, *Practical Numerical Algorithms for Chaotic Systems* (1989), chapter 5.

mod newton;
mod orbit;
mod period_map;
mod resonance;

pub use self::orbit::{Orbit, Response, Search, Verdict};
pub use self::period_map::{ForcedSystem, Spent};
pub use self::resonance::{DEFAULT_POINTS, Peak, Resonance, resonance};

#[cfg(test)]
mod tests;
