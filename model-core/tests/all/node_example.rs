//! The example of a node.

#[allow(dead_code, reason = "the example's own output")]
#[path = "../../examples/node.rs"]
mod node;

use model_core::energy::ResponseMap;
use model_core::excitation::LineBank;
use model_core::node::{Hearing, Modelled};

#[test]
fn the_node_of_the_example_tells_its_day_within_its_bound_for_about_a_hundredth_of_it() {
    let day = node::days(1).expect("a day");
    let error = (day.told - day.truth).abs();
    assert!(error <= day.bound && day.bound < 0.15 * day.truth, "{error} {} {}", day.bound, day.truth);
    assert!(day.hours >= 20 && day.inside + 2 >= day.hours, "{} of {}", day.inside, day.hours);
    assert!(day.share > 0.0 && day.share < 0.02, "{}", day.share);
}

#[test]
fn the_node_of_the_example_lives_through_its_nights() {
    let days = node::days(5).expect("days");
    assert!(days.lowest > 1.9 && days.truth > 0.0, "{} V", days.lowest);
    assert!((days.told - days.truth).abs() <= days.bound, "{} ± {}, {}", days.told, days.bound, days.truth);
    // An action that is due and refused waits for the next reading.
    assert!(days.readings < 5 * 100 && days.share < 0.01, "{} {}", days.readings, days.share);
    assert!(20 * days.inside >= 19 * days.hours, "{} of {}", days.inside, days.hours);
}

#[test]
fn a_sensor_that_is_exactly_still_is_at_rest_as_a_noisy_one_is() {
    let map = ResponseMap::new(&node::map::MAP[..], node::map::FINGERPRINT).expect("a map");
    // The second bank reaches below the frequencies of the map.
    for resonance in [node::map::RESONANCE_HZ, 18.6] {
        let bank = LineBank::<20, 16>::new(100.0, resonance, 0.083, 9.806_65e-3).expect("in bounds");
        let mut random = 1_u32;
        for (mean, noise) in [(0.0, 0.0), (1000.0, 0.0), (-731.0, 0.0), (1000.4, 0.3), (0.5, 0.3)] {
            let mut state = bank.start();
            let samples: Vec<i16> = (0..bank.block())
                .map(|_| {
                    let normal: f64 = (0..12)
                        .map(|_| {
                            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                            f64::from(random >> 8) / f64::from(1 << 24) - 0.5
                        })
                        .sum();
                    (mean + noise * normal).round() as i16
                })
                .collect();
            let (_, lines) = bank.take(&mut state, &samples);
            let modelled = Modelled::of_blocks(&map, &[lines.expect("a block")], 3.0);
            assert_eq!(modelled.hearing, Hearing::Rest, "{resonance} Hz, {mean} and {noise} counts");
            assert!(modelled.lower.value == 0.0 && modelled.lower.noise > 0.0, "{modelled:?}");
        }
    }
}
