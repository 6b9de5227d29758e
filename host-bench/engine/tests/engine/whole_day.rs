//! The hourly factor of a day's excitation.

use harvester_engine::embedded::Daily;
use model_core::clock::Instant;
use model_core::excitation::{Excitation, Sine};

#[test]
fn the_factor_goes_from_hour_to_hour_without_a_jump() {
    let base = Sine::<f64>::new(2.0, 0.3, 0.1).expect("valid");
    let factors = std::array::from_fn(|hour| (hour % 5) as f64);
    let daily = Daily { base: &base, factors };
    let at = |seconds: f64| Instant::from_seconds(seconds).expect("in range");
    let factor = |seconds: f64| daily.acceleration(at(seconds)) / base.acceleration(at(seconds));
    for (seconds, expected) in [
        (3600.0 * 3.0 + 1.0, 3.0),
        (3600.0 * 4.0 - 0.01, 3.0),
        (3600.0 * 4.0 + 0.25, 3.25),
        (3600.0 * 5.0 + 0.25, 3.0),
        // The next day, after hour 23.
        (86_400.0 + 0.5, 1.5),
    ] {
        assert!((factor(seconds) - expected).abs() < 1e-9, "{seconds}: {}", factor(seconds));
    }
    for seconds in [4.3, 3600.2, 14_400.4, 14_401.5] {
        let h = 1e-5;
        let slope = (daily.acceleration(at(seconds + h)) - daily.acceleration(at(seconds - h))) / (2.0 * h);
        assert!((slope - daily.jerk(at(seconds))).abs() < 1e-6, "{seconds}");
    }
    // A step ends at a kink.
    let kink = at(3600.0);
    assert_eq!(at(3599.999).after(daily.smooth_ticks(at(3599.999))), kink);
    assert_eq!(daily.smooth_ticks(kink), u32::MAX);
}
