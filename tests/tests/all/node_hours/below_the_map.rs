//! Shaking below the lowest amplitude of a map without a linear motion, as of a slider that sticks.

use model_core::energy::ResponseMap;
use model_core::excitation::Lines;
use model_core::node::{Hearing, Modelled};

use super::map;
use super::truth::Kind;

#[test]
fn noise_whose_peaks_reach_into_the_map_is_no_rest() {
    let bytes = map(Kind::Sliding);
    let fingerprint = u32::from_le_bytes([bytes[6], bytes[7], bytes[8], bytes[9]]);
    let response = ResponseMap::new(bytes, fingerprint).expect("a map");
    let [lowest, _] = response.amplitudes();
    let hearing = |part: f32, purity: f32| {
        let frequency = Kind::Sliding.resonance()[0] as f32;
        let lines = Lines { amplitude: part * lowest, frequency, purity, density: 1.0, rest: 0.5 };
        Modelled::of_blocks(&response, &[lines], 0.0).hearing
    };
    assert_eq!(response.broadband(1.0), None, "no linear motion");
    assert_eq!(hearing(0.5, 0.99), Hearing::Rest, "a line");
    assert_eq!(hearing(0.05, 0.2), Hearing::Rest, "noise of the sensor");
    assert_eq!(hearing(0.5, 0.2), Hearing::Unclear, "noise");
}
