use super::super::test_support::{advance, oscillator};
use super::*;
use core::f64::consts::{PI, TAU};

fn at(seconds: f64) -> Instant {
    Instant::from_seconds(seconds).expect("in range")
}

/// Displacement and velocity of `x'' + 2ζω x' + ω² x = A sin pt` from rest at `t = 0`; zero before.
fn under_sine([hertz, damping_ratio]: [f64; 2], amplitude: f64, driven: f64, t: f64) -> [f64; 2] {
    if t <= 0.0 {
        return [0.0; 2];
    }
    let own = TAU * hertz;
    let decay = damping_ratio * own;
    let damped = (own * own - decay * decay).sqrt();
    let (stiff, lossy) = (own * own - driven * driven, 2.0 * decay * driven);
    let scale = amplitude / (stiff * stiff + lossy * lossy);
    // The steady motion `scale (stiff sin pt − lossy cos pt)`, and the free one that cancels it at the start.
    let (from, rate) = (-scale * lossy, scale * stiff * driven);
    let (c, s) = (-from, (-rate - decay * from) / damped);
    let shrunk = (-decay * t).exp();
    let (cosine, sine) = ((damped * t).cos(), (damped * t).sin());
    [
        scale * (stiff * (driven * t).sin() - lossy * (driven * t).cos()) + shrunk * (c * cosine + s * sine),
        scale * driven * (stiff * (driven * t).cos() + lossy * (driven * t).sin())
            + shrunk * ((s * damped - decay * c) * cosine - (c * damped + decay * s) * sine),
    ]
}

/// The largest error relative to the largest motion at many instants, against the sum of sines that begin at `starts`
/// with these factors.
fn largest_error<S: Scalar>(
    burst: &impl Excitation<S>,
    natural: [f64; 2],
    [amplitude, driven]: [f64; 2],
    starts: &[(f64, f64)],
) -> f64 {
    let oscillator = oscillator::<S>(natural[0], natural[1]);
    let (mut now, mut motion) = (Instant::START, [S::ZERO; 2]);
    let (mut largest, mut error) = (0.0_f64, 0.0_f64);
    for k in 1..=400_u64 {
        let next = Instant::from_ticks(k * 412_345_678);
        advance(burst, &oscillator, &mut motion, [now, next]);
        now = next;
        let time = next.seconds::<f64>();
        let exact = starts.iter().fold(0.0, |sum, (start, factor)| {
            sum + factor * under_sine(natural, amplitude, driven, time - start)[0]
        });
        largest = largest.max(exact.abs());
        error = error.max((motion[0].to_f64() - exact).abs());
    }
    error / largest
}

#[test]
fn the_response_to_a_half_sine_shock_is_exact_during_and_after_it() {
    // Shorter than, as long as and longer than the period; one near the resonance.
    for (hertz, duration) in [(20.0, 5e-3), (90.0, 11e-3), (45.0, 11e-3), (20.0, 0.2)] {
        for damping_ratio in [0.0, 0.03] {
            let (start, driven) = (0.01, PI / duration);
            let shock = Burst::<f64>::half_sine(50.0, duration).and_then(|shock| shock.starting_at(start));
            let starts = [(start, 1.0), (start + duration, 1.0)];
            let natural = [hertz, damping_ratio];
            let error = largest_error(&shock.expect("valid"), natural, [50.0, driven], &starts);
            assert!(error < 2e-9, "{hertz} {duration} {damping_ratio}: {error}");
            let shock = Burst::<f32>::half_sine(50.0, duration as f32)
                .and_then(|shock| shock.starting_at(start as f32));
            let error = largest_error(&shock.expect("valid"), natural, [50.0, driven], &starts);
            assert!(error < 2e-4, "{hertz} {duration} {damping_ratio}: {error}");
        }
    }
}

#[test]
fn repeated_bursts_are_a_superposition() {
    let (frequency, period) = (50.0, 0.13);
    let burst = Burst::<f64>::cycles(3.0, frequency, 3).and_then(|burst| burst.every(period)).expect("valid");
    let starts: Vec<(f64, f64)> = (0..6)
        .flat_map(|n| {
            let start = f64::from(n) * period;
            [(start, 1.0), (start + 3.0 / frequency, -1.0)]
        })
        .collect();
    for natural in [[20.0, 0.02], [49.0, 0.01], [170.0, 0.1]] {
        let error = largest_error(&burst, natural, [3.0, TAU * frequency], &starts);
        assert!(error < 2e-9, "{natural:?}: {error}");
    }
}

#[test]
fn steps_end_at_the_start_and_the_end_of_each_burst() {
    let shock = Burst::<f32>::half_sine(1.0, 3e-3).and_then(|shock| shock.starting_at(4e-3));
    let shock = shock.and_then(|shock| shock.every(10e-3)).expect("valid");
    let (mut now, mut corners) = (Instant::START, vec![]);
    while now < at(0.05) {
        let before = shock.place(now).within.is_some();
        now = now.after(shock.smooth_ticks(now));
        if shock.place(now).within.is_some() != before {
            corners.push(now);
        }
    }
    let ticks = |seconds: f32| Instant::from_seconds(seconds).expect("in range").ticks();
    let expected = (0..).flat_map(|n| {
        let start = ticks(4e-3) + n * ticks(10e-3);
        [start, start + ticks(3e-3)].map(Instant::from_ticks)
    });
    assert!(corners.iter().copied().eq(expected.take(corners.len())), "{corners:?}");
    assert_eq!(corners.len(), 11);
}

#[test]
fn the_acceleration_is_the_sine_within_a_burst_and_zero_elsewhere() {
    let shock = Burst::<f64>::half_sine(-7.0, 2e-3).and_then(|shock| shock.starting_at(1.0)).expect("valid");
    for (seconds, expected) in
        [(0.0, 0.0), (0.9999, 0.0), (1.0005, -7.0 * 0.5_f64.sqrt()), (1.001, -7.0), (1.0021, 0.0), (1e6, 0.0)]
    {
        assert!((shock.acceleration(at(seconds)) - expected).abs() < 1e-7, "{seconds}");
    }
    assert!((shock.jerk(at(1.0)) + 7.0 * PI / 2e-3).abs() < 1e-3);
    assert_eq!(shock.jerk(at(1.1)), 0.0);
    let burst = Burst::<f64>::cycles(2.0, 10.0, 4).and_then(|burst| burst.every(1.0)).expect("valid");
    // A million periods later the phase is the same.
    for seconds in [0.013, 0.2, 0.399, 0.401, 0.7] {
        let late = at(seconds + 1e6);
        assert!((burst.acceleration(late) - burst.acceleration(at(seconds))).abs() < 1e-8, "{seconds}");
    }
}

#[test]
fn arguments_out_of_range_are_named() {
    let shock = Burst::<f64>::half_sine(1.0, 1e-2).expect("valid");
    assert_eq!(Burst::<f64>::half_sine(f64::NAN, 1e-2), Err(ExcitationError::Amplitude));
    for duration in [0.0, -1.0, 1e-7, 2e6, f64::NAN] {
        assert_eq!(Burst::<f64>::half_sine(1.0, duration), Err(ExcitationError::Duration));
    }
    for frequency in [0.0, -1.0, 2e6, f64::NAN] {
        assert_eq!(Burst::<f64>::cycles(1.0, frequency, 1), Err(ExcitationError::Frequency));
    }
    assert_eq!(Burst::<f64>::cycles(1.0, 10.0, 0), Err(ExcitationError::Duration));
    assert_eq!(Burst::<f64>::cycles(1.0, 1e-3, 1_000_000), Err(ExcitationError::Duration));
    assert_eq!(shock.starting_at(-1.0), Err(ExcitationError::Start));
    for period in [0.0, 9.99e-3, f64::INFINITY] {
        assert_eq!(shock.every(period), Err(ExcitationError::Period));
    }
    assert!(shock.every(1e-2).is_ok());
}
