//! Sine and exponential of the crate `libm`, within one unit in the last place, in software.
//!
//! The single-precision sine of `libm` computes in double precision. It costs a Cortex-M4F about 1300
//! instructions and 9 kB of flash; the default backend takes a few tens of instructions.

use super::{Mathematics, Scalar};

/// Elementary functions of the crate `libm`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Libm;

impl Mathematics<f32> for Libm {
    const NAME: &'static str = "libm";

    fn sine_of_turns(phase: u64) -> f32 {
        libm::sinf(f32::from_fraction(phase.cast_signed()) * core::f32::consts::PI)
    }

    fn exponential(x: f32) -> f32 {
        libm::expf(x)
    }
}

impl Mathematics<f64> for Libm {
    const NAME: &'static str = "libm";

    fn sine_of_turns(phase: u64) -> f64 {
        libm::sin(f64::from_fraction(phase.cast_signed()) * core::f64::consts::PI)
    }

    fn exponential(x: f64) -> f64 {
        libm::exp(x)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Polynomial;
    use super::*;

    #[test]
    fn agrees_with_the_polynomials_to_rounding() {
        for k in 0..10_000_u64 {
            let phase = k.wrapping_mul(1_844_674_407_370_955_161);
            let (a, b): (f64, f64) = (Libm::sine_of_turns(phase), Polynomial::sine_of_turns(phase));
            assert!((a - b).abs() < 7e-16);
            let (a, b): (f32, f32) = (Libm::sine_of_turns(phase), Polynomial::sine_of_turns(phase));
            assert!((a - b).abs() < 4e-7);
            let x = -20.0 + k as f64 * 0.004;
            let (a, b): (f64, f64) = (Libm::exponential(x), Polynomial::exponential(x));
            assert!((a / b - 1.0).abs() < 6e-16);
        }
    }
}
