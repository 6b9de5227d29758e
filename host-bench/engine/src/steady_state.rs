//! The periodic steady state of a harvester under one sine, by shooting.
//!
//! The state at one phase of the excitation determines the state a period later: the *period map* `P` of the hybrid
//! system, impacts, sticking, contact and the switching of a bridge included, is computed by the embedded core. A motion of
//! one period is a fixed point
//!
//! ```text
//! P(x) = x
//! ```
//!
//! which Newton's iteration finds in about ten simulated periods, while a transient takes hundreds. The eigenvalues of
//! `∂P/∂x` at the fixed point are the Floquet multipliers: the motion is stable if all lie within the unit circle. A
//! circuit much slower than the motion has multipliers just below one and makes the search no longer.
//!
//! Several stable motions may exist. The motion that a run from the scene's start ends in is wanted: a transient comes
//! first, and a motion is accepted only if the transient approaches it.
//!
//! T. S. Parker and L. O. Chua, *Practical Numerical Algorithms for Chaotic Systems* (1989), chapter 5.

mod newton;
mod orbit;
mod period_map;
mod resonance;

pub use self::newton::{FixedPoint, Linearisation, Map, NotFound};
pub use self::orbit::{Orbit, Response, Verdict};
pub use self::period_map::{Coordinates, ForcedSystem, Spent, Total};
pub(crate) use self::period_map::{MOST_ATTEMPTS, given_up};
pub use self::resonance::{BestLoad, DEFAULT_POINTS, Peak, Resonance, best_load, resonance};
