//! Zeros and minima of a function of one variable, to the last bits.
//!
//! Bisection and golden section cannot fail, and a run needs a few zeros in each period only.

/// The zero of `f` between `from` and `to`, where `f` has opposite signs: an abscissa within one rounding of
/// the zero at which `f` is zero or has the sign of `f(to)`.
pub fn far_side(mut f: impl FnMut(f64) -> f64, from: f64, to: f64) -> f64 {
    let positive_after = f(to) > 0.0;
    let (mut near, mut far) = (from, to);
    loop {
        let middle = near + 0.5 * (far - near);
        if middle <= near || middle >= far {
            return far;
        }
        let value = f(middle);
        if value == 0.0 {
            return middle;
        }
        if (value > 0.0) == positive_after {
            far = middle;
        } else {
            near = middle;
        }
    }
}

/// The abscissa of the only minimum of `f` between `from` and `to`, to the part `within` of their distance. A part of 1e-9
/// is half the digits; the value of `f` there is right to all digits.
pub fn lowest_point<E>(
    mut f: impl FnMut(f64) -> Result<f64, E>,
    [from, to]: [f64; 2],
    within: f64,
) -> Result<f64, E> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (from, to);
    while high - low > within * (to - from) {
        let left = high - GOLDEN * (high - low);
        let right = low + GOLDEN * (high - low);
        if f(left)? < f(right)? {
            high = right;
        } else {
            low = left;
        }
    }
    Ok(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    #[test]
    fn a_zero_is_found_to_the_last_bit_from_either_sign() {
        for sign in [1.0, -1.0] {
            let zero = far_side(|x| sign * (x * x - 2.0), 0.0, 2.0);
            assert!((zero - 2f64.sqrt()).abs() <= 2.0 * f64::EPSILON);
            assert!(zero * zero >= 2.0, "on the far side");
        }
    }

    #[test]
    fn a_minimum_is_found() {
        let Ok(at) = lowest_point(|x| Ok::<_, Infallible>((x - 0.3).powi(2) - 1.0), [0.0, 1.0], 1e-9);
        assert!((at - 0.3).abs() < 1e-7);
    }
}
