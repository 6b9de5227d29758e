//! Against closed forms: an oscillator, a fast circuit, and the integrals of both.

use super::*;

/// An undamped oscillator of 2 rad/s, and a decay of `rate` per second.
fn system(rate: f64) -> DMatrix<f64> {
    DMatrix::from_row_slice(3, 3, &[0.0, 2.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, -rate])
}

fn forms() -> [DMatrix<f64>; FORMS] {
    std::array::from_fn(|index| {
        let mut form = DMatrix::zeros(3, 3);
        match index {
            0 => form[(0, 0)] = 1.0,
            1 => {
                form[(0, 1)] = 0.5;
                form[(1, 0)] = 0.5;
            }
            _ => form[(2, 2)] = 1.0,
        }
        form
    })
}

#[test]
fn motion_and_integrals_are_those_of_the_closed_forms() {
    for rate in [0.0, 3.0, 1e9] {
        let propagator = Propagator::new(&system(rate), 0.3, &forms());
        let mut moments = Moments::new();
        for ticks in [WHOLE, WHOLE / 2, 3 * WHOLE / 7, 1, WHOLE - 1] {
            let (start, mut end) = ([0.0, 1.0, 1.0], Vec::new());
            propagator.advance_measured(&start, ticks, &mut end, &mut moments);
            let t = ticks as f64 * propagator.tick();
            for (found, expected) in end.iter().zip([(2.0 * t).sin(), (2.0 * t).cos(), (-rate * t).exp()]) {
                assert!((found - expected).abs() < 2e-15, "{rate} {ticks}: {found} {expected}");
            }
            let integrals = moments.take(&propagator);
            // ∫ sin², ∫ sin cos, ∫ exp(−2 rate t).
            let decay = if rate == 0.0 { t } else { -(-2.0 * rate * t).exp_m1() / (2.0 * rate) };
            let squares = if ticks == 1 { 4.0 / 3.0 * t.powi(3) } else { 0.5 * t - (4.0 * t).sin() / 8.0 };
            let products = (2.0 * t).sin().powi(2) / 4.0;
            for (found, expected) in integrals.iter().zip([squares, products, decay]) {
                let allowed = 1e-14 * expected.max(1e-3 * t);
                assert!((found - expected).abs() < allowed, "{rate} {ticks}: {found:e} {expected:e}");
            }
        }
    }
}

#[test]
fn a_long_run_keeps_its_phase() {
    let propagator = Propagator::new(&system(1.0), 0.3, &forms());
    let (mut here, mut next) = (vec![0.0, 1.0, 1.0], Vec::new());
    for _ in 0..1_000_000 {
        propagator.advance(&here, WHOLE, &mut next);
        std::mem::swap(&mut here, &mut next);
    }
    let expected: [f64; 2] = [6e5f64.sin(), 6e5f64.cos()];
    for (found, expected) in here.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}

#[test]
fn the_first_tick_behind_a_crossing_is_found() {
    let propagator = Propagator::new(&system(1.0), 0.3, &forms());
    let tick = propagator.first_past(&[0.0, 1.0, 1.0], WHOLE, |vector| vector[0] > 0.25);
    let time = 0.5 * 0.25f64.asin();
    assert!((tick as f64 * propagator.tick() - time).abs() <= 1.01 * propagator.tick());
    assert_eq!(propagator.first_past(&[0.0, 1.0, 1.0], WHOLE, |_| true), 1);
    assert_eq!(propagator.first_past(&[0.0, 1.0, 1.0], 12_345, |_| false), 12_345);
}
