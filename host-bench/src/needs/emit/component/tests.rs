//! The emitted functions are compiled here, and their accelerations compared with closed forms.

use model_core::clock::Instant;

use super::function;
use crate::scene_file::{Burst, BurstShape, Excitation, Random, Sweep};

#[expect(unreachable_pub, reason = "as in the firmware")]
mod shocks {
    use model_core::excitation::Burst;
    include!("tests/shocks.rs");
}
#[expect(unreachable_pub, reason = "as in the firmware")]
mod bursts {
    use model_core::excitation::Burst;
    include!("tests/bursts.rs");
}
#[expect(unreachable_pub, reason = "as in the firmware")]
mod sweep {
    use model_core::excitation::{Sweep, SweepLaw};
    include!("tests/sweep.rs");
}
#[expect(unreachable_pub, reason = "as in the firmware")]
mod random {
    use model_core::excitation::{Random, SpectralDensity};
    include!("tests/random.rs");
}

const TAU: f64 = core::f64::consts::TAU;

/// Compares an emitted excitation with `expected` in m/s² over time in s.
fn compare(
    emitted: &impl model_core::excitation::Excitation<f32>,
    expected: impl Fn(f64) -> f64,
    bound: f64,
) {
    for step in 0..400 {
        let at = Instant::from_seconds(1.7e-3 * f64::from(step)).expect("in range");
        let (found, expected) = (f64::from(emitted.acceleration(at)), expected(at.seconds()));
        assert!((found - expected).abs() <= bound, "{step}: {found} {expected}");
    }
}

#[test]
fn a_shock_and_bursts_are_emitted() {
    let shock = Burst {
        amplitude_m_per_s2: -30.0,
        shape: BurstShape::HalfSine { duration_s: 0.011 },
        start_s: 0.1,
        period_s: None,
    };
    assert_eq!(function(&Excitation::Burst(shock)).as_deref(), Some(include_str!("tests/shocks.rs")));
    let half_sine = |at: f64| {
        let part = (at - 0.1) / 0.011;
        if (0.0..=1.0).contains(&part) { -30.0 * (0.5 * TAU * part).sin() } else { 0.0 }
    };
    compare(&shocks::excitation().expect("accepted"), half_sine, 1e-4);

    let cycles = BurstShape::Cycles { frequency_hz: 50.0, cycles: 3 };
    let again = Burst { amplitude_m_per_s2: 2.5, shape: cycles, start_s: 0.05, period_s: Some(0.25) };
    assert_eq!(function(&Excitation::Burst(again)).as_deref(), Some(include_str!("tests/bursts.rs")));
    let expected = |at: f64| {
        let local = if at < 0.05 { 1.0 } else { (at - 0.05) % 0.25 };
        if local < 0.06 { 2.5 * (TAU * 50.0 * local).sin() } else { 0.0 }
    };
    compare(&bursts::excitation().expect("accepted"), expected, 1e-4);
}

#[test]
fn a_sweep_is_emitted() {
    let given = Sweep {
        amplitude_m_per_s2: 4.0,
        from_hz: 10.0,
        to_hz: 40.0,
        sweep_s: 2.0,
        logarithmic: false,
        phase_rad: 0.5,
    };
    assert_eq!(function(&Excitation::Sweep(given)).as_deref(), Some(include_str!("tests/sweep.rs")));
    let expected = |at: f64| 4.0 * (TAU * (10.0 * at + 0.5 * 15.0 * at * at) + 0.5).sin();
    compare(&sweep::excitation().expect("accepted"), expected, 1e-4);
}

#[test]
fn a_random_acceleration_is_emitted() {
    let given = Random::new(vec![[10.0, 0.02], [40.0, 0.1], [80.0, 0.05]], 64, 9).expect("accepted");
    let emitted = function(&Excitation::Random(given.clone()));
    assert_eq!(emitted.as_deref(), Some(include_str!("tests/random.rs")));
    let expected = |at: f64| {
        let line = |tone: &crate::scene_file::Tone| {
            tone.amplitude_m_per_s2 * (TAU * tone.frequency_hz * at + tone.phase_rad).sin()
        };
        given.tones.iter().map(line).sum::<f64>()
    };
    compare(&random::excitation().expect("accepted"), expected, 1e-5 * given.rms_m_per_s2());
}
