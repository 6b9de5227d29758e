//! The peak finder on a response with a known peak; fixed points of a known map.

use harvester_engine::steady_state::{Map, Response, resonance};

/// An affine map with the eigenvalues 0.999 and ½ ± ½ i.
fn affine([x, y, z]: &[f64; 3]) -> Option<[f64; 3]> {
    Some([0.5 * x - 0.5 * y + 1.0, 0.5 * x + 0.5 * y, 0.999 * z + 0.1 * x + 2.0])
}

#[test]
fn the_fixed_point_of_an_affine_map_has_its_eigenvalues() {
    let mut map = Map { apply: &mut affine, scale: [1.0, 2.0, 100.0], accuracy: 1e-7 };
    let found = map.fixed_point([3.0, -7.0, 0.0], None).expect("converges");
    // (I − A) x = b: x = y = 1 and z = (0.1 + 2)/0.001.
    for (value, expected) in found.point.iter().zip([1.0, 1.0, 2100.0]) {
        assert!((value / expected - 1.0).abs() < 1e-6, "{:?}", found.point);
    }
    let multipliers = found.linearisation.multipliers();
    assert!((multipliers[0].re - 0.999).abs() < 1e-8 && multipliers[0].im.abs() < 1e-12);
    for pair in &multipliers[1..] {
        assert!((pair.re - 0.5).abs() < 1e-8 && (pair.im.abs() - 0.5).abs() < 1e-8, "{pair}");
    }
}

#[test]
fn an_entry_that_is_handed_on_is_no_unknown() {
    let mut count = 0;
    let mut apply = |[x, y]: &[f64; 2]| {
        count += 1;
        Some([0.2 * x * x + 0.1 * y, *y])
    };
    let mut map = Map { apply: &mut apply, scale: [1.0, 1.0], accuracy: 1e-9 };
    let found = map.fixed_point([0.3, 2.0], None).expect("converges");
    // 0.2 x² − x + 0.2 = 0.
    let exact = (1.0 - (1.0 - 0.16_f64).sqrt()) / 0.4;
    assert!((found.point[0] - exact).abs() < 1e-9, "{:?}", found.point);
    assert_eq!(found.point[1], 2.0);
    let multipliers = found.linearisation.multipliers();
    assert_eq!(multipliers.len(), 1);
    assert!((multipliers[0].re - 0.4 * exact).abs() < 1e-5);
    assert!(count < 16, "{count} applications");
}

#[test]
fn a_map_without_a_fixed_point_has_none() {
    let mut apply = |[x]: &[f64; 1]| Some([x + 1.0 + x * x]);
    let mut map = Map { apply: &mut apply, scale: [1.0], accuracy: 1e-9 };
    assert_eq!(map.fixed_point([0.7], None), None);
}

#[test]
fn both_peaks_of_a_lorentzian_are_found() {
    let mut evaluations = 0;
    let line = |f: f64, centre: f64, width: f64| 1.0 / (1.0 + ((f - centre) / width).powi(2)).sqrt();
    let found = resonance([19.0, 21.0], 21, |f| {
        evaluations += 1;
        Ok::<_, ()>(
            (f < 20.55)
                .then(|| Response { amplitude_m: line(f, 20.0317, 0.1), rms_voltage_v: line(f, 20.43, 0.3) }),
        )
    });
    let found = found.expect("no error").expect("a peak");
    assert!((found.amplitude.frequency_hz - 20.0317).abs() < 1e-4, "{:?}", found.amplitude);
    assert!((found.rms_voltage.frequency_hz - 20.43).abs() < 1e-4, "{:?}", found.rms_voltage);
    assert!(!found.amplitude.at_edge && found.amplitude.within_hz < 1e-4);
    assert!(evaluations < 50, "{evaluations}");
    let rising =
        resonance([19.0, 20.0], 11, |f| Ok::<_, ()>(Some(Response { amplitude_m: f, rms_voltage_v: -f })));
    let rising = rising.expect("no error").expect("a peak");
    assert!(rising.amplitude.at_edge && rising.rms_voltage.at_edge);
    assert_eq!(resonance([19.0, 20.0], 11, |_| Ok::<_, ()>(None)), Ok(None));
}
