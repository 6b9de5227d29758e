//! Shaking below the lowest amplitude of a map, without a linear motion, as of a slider that sticks, and with one.

use model_core::energy::ResponseMap;
use model_core::excitation::Lines;
use model_core::node::{Finding, PredictedPower};

use host_bench::simulated_node::Kind;

#[test]
fn noise_whose_peaks_reach_into_the_map_is_no_rest() {
    let bytes = Kind::Sliding.map();
    let fingerprint = u32::from_le_bytes([bytes[6], bytes[7], bytes[8], bytes[9]]);
    let response = ResponseMap::new(bytes, fingerprint).expect("a map");
    let [lowest, _] = response.amplitudes();
    let finding = |part: f32, purity: f32| {
        let frequency = Kind::Sliding.resonance()[0] as f32;
        let lines = Lines { amplitude: part * lowest, frequency, purity, density: 1.0, rest: 0.5 };
        PredictedPower::of_blocks(&response, &[lines], 0.0).finding
    };
    assert_eq!(response.broadband(1.0), None, "no linear motion");
    assert_eq!(finding(0.5, 0.99), Finding::Rest, "a line");
    assert_eq!(finding(0.05, 0.2), Finding::Rest, "noise of the sensor");
    assert_eq!(finding(0.5, 0.2), Finding::Unclear, "noise");
}

#[test]
fn a_line_below_the_map_and_beside_the_resonance_is_covered() {
    let bytes = Kind::BumpStop.map();
    let fingerprint = u32::from_le_bytes([bytes[6], bytes[7], bytes[8], bytes[9]]);
    let response = ResponseMap::new(bytes, fingerprint).expect("a map");
    let [lowest, _] = response.amplitudes();
    let [resonance, half] = Kind::BumpStop.resonance().map(|of| of as f32);
    for beside in [0.0, 1.0, 3.0, 4.0] {
        let frequency = resonance + beside * half;
        let edge = response.at(lowest * 1.001, frequency).income().expect("in the map").value;
        for part in [0.3, 0.6, 0.97] {
            // The bank's density is that at the resonance, where the line is not.
            let lines =
                Lines { amplitude: part * lowest, frequency, purity: 0.99, density: 1e-6, rest: 1e-6 };
            let told = PredictedPower::of_blocks(&response, &[lines], 0.0);
            assert_eq!(told.finding, Finding::Rest);
            let truth = part * part * edge;
            assert!(
                (told.lower.value - truth).abs() <= told.lower.bound(),
                "{beside} {part}: {told:?} {truth}"
            );
        }
    }
}
