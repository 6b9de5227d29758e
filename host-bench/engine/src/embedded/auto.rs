//! What `--method auto` chooses for a triboelectric scene: exponential Radau, and the tolerance for a stated accuracy.
//!
//! Over loads from 1 Ω to 1 GΩ, both force laws and every kind of excitation, exponential Radau takes the fewest
//! instructions at errors of the mean power of 10⁻², 10⁻³ and 10⁻⁵ (`work-precision --grid`). Its error falls with the
//! square of the tolerance, so that one rule serves all of them.

/// Relative error of the mean power that a run without options aims at.
pub const DEFAULT_ACCURACY: f64 = 1e-6;
/// Tolerance over the square root of the accuracy.
const TOLERANCE_PER_ROOT: f64 = 0.6;
/// The loosest tolerance that is chosen: at 0.1 some stiff loads are 10 % off.
const LOOSEST: f64 = 6e-2;

/// The tolerance of exponential Radau for a relative error of the mean power of `accuracy`.
#[must_use]
pub fn tolerance(accuracy: f64) -> f64 {
    (TOLERANCE_PER_ROOT * accuracy.sqrt()).min(LOOSEST)
}
