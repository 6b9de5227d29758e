//! The peak finder on a response with a known peak; fixed points of a known map; the orbit of several to which a start leads; the end
//! of a search by attempted steps.

use harvester_engine::embedded::{run, steady_state};
use harvester_engine::steady_state::{Map, Response, best_load, resonance};
use harvester_scene::method::{Failure, Options};
use harvester_scene::scene_file::read_shipped;

/// An affine map with the eigenvalues 0.999 and ½ ± ½ i.
fn affine(point: &[f64]) -> Option<Vec<f64>> {
    let [x, y, z] = point else { return None };
    Some(vec![0.5 * x - 0.5 * y + 1.0, 0.5 * x + 0.5 * y, 0.999 * z + 0.1 * x + 2.0])
}

#[test]
fn the_fixed_point_of_an_affine_map_has_its_eigenvalues() {
    let mut map = Map { apply: &mut affine, scale: vec![1.0, 2.0, 100.0], accuracy: 1e-7 };
    let found = map.fixed_point(vec![3.0, -7.0, 0.0], None).expect("converges");
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
    let mut apply = |point: &[f64]| {
        let [x, y] = point else { return None };
        count += 1;
        Some(vec![0.2 * x * x + 0.1 * y, *y])
    };
    let mut map = Map { apply: &mut apply, scale: vec![1.0, 1.0], accuracy: 1e-9 };
    let found = map.fixed_point(vec![0.3, 2.0], None).expect("converges");
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
    let mut apply = |point: &[f64]| Some(point.iter().map(|x| x + 1.0 + x * x).collect());
    let mut map = Map { apply: &mut apply, scale: vec![1.0], accuracy: 1e-9 };
    // |x + 1 + x² − x| is at least 1.
    let left = map.fixed_point(vec![0.7], None).expect_err("there is none");
    assert!((1.0..1.5).contains(&left.residual), "{left:?}");
}

fn response(amplitude_m: f64, rms_voltage_v: f64) -> Response {
    Response { amplitude_m, rms_voltage_v, mean_power_w: 0.0, mean_current_a: 0.0 }
}

#[test]
fn both_peaks_of_a_lorentzian_are_found() {
    let mut evaluations = 0;
    let line = |f: f64, centre: f64, width: f64| 1.0 / (1.0 + ((f - centre) / width).powi(2)).sqrt();
    let found = resonance([19.0, 21.0], 21, false, |f| {
        evaluations += 1;
        Ok::<_, ()>((f < 20.55).then(|| response(line(f, 20.0317, 0.1), line(f, 20.43, 0.3))))
    });
    let found = found.expect("no error").expect("a peak");
    assert!((found.amplitude.frequency_hz - 20.0317).abs() < 1e-4, "{:?}", found.amplitude);
    assert!((found.rms_voltage.frequency_hz - 20.43).abs() < 1e-4, "{:?}", found.rms_voltage);
    assert!(!found.amplitude.at_edge && found.amplitude.within_hz < 1e-4);
    assert!(evaluations < 50, "{evaluations}");
    let rising = resonance([19.0, 20.0], 11, false, |f| Ok::<_, ()>(Some(response(f, -f))));
    let rising = rising.expect("no error").expect("a peak");
    assert!(rising.amplitude.at_edge && rising.rms_voltage.at_edge);
    assert_eq!(resonance([19.0, 20.0], 11, false, |_| Ok::<_, ()>(None)), Ok(None));
}

/// The power of a source with the inner resistance 3 MΩ, largest into a load of as much.
#[test]
fn the_best_load_is_that_of_the_source() {
    let inner = 3e6;
    let taken = |ohms: f64| Response { mean_power_w: ohms / (ohms + inner).powi(2), ..response(0.0, 0.0) };
    let found = best_load(|ohms| Ok::<_, ()>(Some(taken(ohms)))).expect("no error").expect("a peak");
    assert!((found.resistance_ohm / inner - 1.0).abs() < 1e-3, "{found:?}");
    assert!((found.mean_power_w * 4.0 * inner - 1.0).abs() < 1e-6, "{found:?}");
    // A source of current delivers the more the larger the load.
    let rising = |ohms: f64| Response { mean_power_w: ohms, ..response(0.0, 0.0) };
    assert_eq!(best_load(|ohms| Ok::<_, ()>(Some(rising(ohms)))), Ok(None));
}

/// The peak of the power is sought if it is asked for.
#[test]
fn the_peak_of_the_power_is_found() {
    let respond = |f: f64| {
        let mean_power_w = 1.0 / (1.0 + ((f - 20.2) / 0.2).powi(2));
        Ok::<_, ()>(Some(Response { mean_power_w, ..response(1.0 - (f - 19.7).powi(2), 1.0) }))
    };
    let found = resonance([19.0, 21.0], 21, true, respond).expect("no error").expect("a peak");
    let power = found.mean_power.expect("it was asked for");
    assert!((power.frequency_hz - 20.2).abs() < 1e-4 && (power.value - 1.0).abs() < 1e-6, "{power:?}");
    let without = resonance([19.0, 21.0], 21, false, respond).expect("no error").expect("a peak");
    assert_eq!(without.mean_power, None);
}

/// A period of 10⁶ s has more steps than a day computes.
#[test]
fn a_search_over_a_long_period_is_given_up() {
    for name in ["contact-separation", "bump-stop"] {
        let scene = read_shipped(name, &[("excitation.frequency_hz", "1e-6")]).expect("a valid scene");
        let options = Options { steady_state: true, most_attempts: Some(100_000), ..Options::default() };
        let found = steady_state(&scene, &options);
        let Err(Failure::StepLimitExceeded(told)) = found else { panic!("{name}: {found:?}") };
        assert!(told.contains("given up after 100000 attempted steps"), "{name}: {told}");
    }
}

/// Beside another orbit: one without contact, which the transient follows until the first beat of its light damping (1.28 µW in place
/// of 15.5), and one that a motion of three periods turns round.
#[test]
fn a_start_leads_to_the_motion_of_its_long_run() {
    let beat = [
        ("parameters.damping_ratio", "0.005"),
        ("excitation.amplitude_m_per_s2", "0.7"),
        ("excitation.frequency_hz", "20.25"),
    ];
    let three = [("load.resistance_ohm", "1e6"), ("excitation.frequency_hz", "19.55")];
    for (name, changes) in [("measured/contact-separation", &beat[..]), ("contact-separation", &three)] {
        let scene = read_shipped(name, changes).expect("a valid scene");
        let options = Options::default();
        let outcomes = [steady_state(&scene, &options), run(&scene, &options)];
        let [found, long] =
            outcomes.map(|outcome| outcome.expect("a motion").mean_power_w.expect("a window"));
        assert!((found / long - 1.0).abs() < 0.01, "{name}: {found} W instead of {long} W");
    }
}
