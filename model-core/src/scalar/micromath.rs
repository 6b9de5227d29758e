//! Sine and exponential of the crate `micromath`: small, coarse, single precision only.

use super::{Mathematics, Scalar};
use micromath::F32Ext;

/// Elementary functions of the crate `micromath`: sine within 2e-3 absolute, exponential within 3e-3 relative.
///
/// These errors reach the excitation and the coefficient of restitution. The square root of `micromath`, with
/// an error of up to 5 %, is not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Micromath;

impl Mathematics<f32> for Micromath {
    const NAME: &'static str = "micromath";

    fn sine_of_turns(phase: u64) -> f32 {
        F32Ext::sin(f32::from_fraction(phase.cast_signed()) * core::f32::consts::PI)
    }

    fn exponential(x: f32) -> f32 {
        // Below −80 the exponent arithmetic of `micromath` overflows.
        if x < -80.0 { 0.0 } else { F32Ext::exp(x) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Polynomial;
    use super::*;

    #[test]
    fn stays_within_its_stated_error() {
        for k in 0..10_000_u64 {
            let phase = k.wrapping_mul(1_844_674_407_370_955_161);
            let (a, b): (f32, f32) = (Micromath::sine_of_turns(phase), Polynomial::sine_of_turns(phase));
            assert!((a - b).abs() < 2e-3, "{phase} {a} {b}");
            let x = -20.0 + k as f32 * 0.002;
            let (a, b): (f32, f32) = (Micromath::exponential(x), Polynomial::exponential(x));
            assert!((a / b - 1.0).abs() < 3e-3, "{x} {a} {b}");
        }
    }
}
