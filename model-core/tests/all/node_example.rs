//! The example of a node: its map, and what is made at compile time.

#[allow(dead_code, reason = "the example's own output")]
#[path = "../../examples/node.rs"]
mod node;

use model_core::energy::ResponseMap;
use model_core::energy::response_map::MapError;
use model_core::excitation::LineBank;
use model_core::node::{Finding, MapNode, PredictedPower};

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
            let modelled = PredictedPower::of_blocks(&map, &[lines.expect("a block")], 3.0);
            assert_eq!(modelled.finding, Finding::Rest, "{resonance} Hz, {mean} and {noise} counts");
            assert!(modelled.lower.value == 0.0 && modelled.lower.noise > 0.0, "{modelled:?}");
        }
    }
}

#[test]
fn a_node_in_flash_is_that_made_at_run_time() {
    let map = ResponseMap::new(&node::map::MAP[..], node::map::FINGERPRINT).expect("a map");
    let [rate, resonance, half, unit] =
        std::hint::black_box([100.0, node::map::RESONANCE_HZ, node::map::HALF_BANDWIDTH_HZ, 9.806_65e-3]);
    let bank = LineBank::new(rate, resonance, half, unit).expect("in bounds");
    assert_eq!(node::NODE, MapNode::new(map, bank, *node::NODE.parameters()).expect("in bounds"));
    let mut words = node::map::MAP;
    words[500] ^= 1;
    assert_eq!(ResponseMap::of_words(&words, node::map::FINGERPRINT), Err(MapError::Corrupt));
    let short = ResponseMap::of_words(&words[..40], node::map::FINGERPRINT);
    assert_eq!(short, Err(MapError::TooShort { needed: words.len(), given: 40 }));
}
