//! The response map in the firmware: of the harvester in the firmware, and what the full model yields.

use cross_crate_tests::contact_separation;
use firmware_example::workload::contact_separation::loaded;
use firmware_example::workload::response_map::contact_separation::{FINGERPRINT, MAP};
use host_bench::embedded::{self, with_continuation};
use host_bench::map::{Request, Step, map};
use host_bench::method::Options;
use model_core::energy::response_map::{Branch, MapError};
use model_core::energy::{Response, ResponseMap};
use model_core::scene::Scene;
use model_core::snapshot::Fingerprint;

#[test]
fn the_map_is_of_the_scene_with_the_parts_of_the_firmware_and_of_no_other() {
    let fingerprint = |resistance| {
        let scene = loaded(resistance).build().expect("valid");
        let mut fingerprint = Fingerprint::new();
        Scene::<f32, 3, 0>::identify(&scene, &mut fingerprint);
        fingerprint.value()
    };
    assert_eq!(fingerprint(1e8), FINGERPRINT);
    // The host reads the same scene from a file, with every choice made at run time.
    assert_eq!(embedded::fingerprint(&contact_separation(|_, _| ())).expect("valid"), FINGERPRINT);
    let map = ResponseMap::new(&MAP[..], fingerprint(1e8)).expect("a map");
    assert!(map.agreement().bounds_hold > 0.95, "{:?}", map.agreement());
    let other = ResponseMap::new(&MAP[..], fingerprint(1.1e8));
    assert_eq!(other.err(), Some(MapError::ForeignHarvester { of: FINGERPRINT }));
}

#[test]
fn the_map_tells_what_the_full_model_yields_on_both_ways() {
    let map = ResponseMap::new(&MAP[..], FINGERPRINT).expect("a map");
    let scene = contact_separation(|_, _| ());
    // Below the resonance without impacts, at it with impacts, above it both.
    let places = [(0.3, 18.5), (1.5, 19.45), (1.2, 20.6)];
    for (amplitude, frequency) in places {
        let [rising, falling] =
            with_continuation(&scene, f64::from(frequency), &Options::default(), |held| {
                held.settle(0.5 * f64::from(amplitude))?;
                let rising = held.settle(f64::from(amplitude))?;
                for larger in [8.0, 4.0, 2.0, 1.4, 1.2, 1.1] {
                    held.settle(larger * f64::from(amplitude))?;
                }
                Ok([rising, held.settle(f64::from(amplitude))?])
            })
            .expect("steady motions");
        let within = |income: model_core::energy::response_map::Bounded, value: f64| {
            let (low, high) = (f64::from(income.low), f64::from(income.high));
            assert!((low..=high).contains(&value), "{amplitude} {frequency}: {income:?} {value}");
        };
        match map.at(amplitude, frequency) {
            Response::One { branch, income } => {
                assert_eq!(rising.is_upper, branch == Branch::Upper, "{amplitude} {frequency}");
                within(income, rising.value);
                within(income, falling.value);
            }
            Response::Two { lower, upper } => {
                assert!(!rising.is_upper && falling.is_upper, "{amplitude} {frequency}");
                within(lower, rising.value);
                within(upper, falling.value);
            }
            Response::Outside(edge) => panic!("{amplitude} {frequency}: {edge:?}"),
        }
    }
}

#[test]
#[ignore = "nightly: makes three maps, minutes"]
fn maps_of_other_random_places_meet_the_targets() {
    for seed in [11, 12, 13] {
        let request = Request {
            amplitudes: [0.1, 4.0],
            frequencies: [17.0, 24.0],
            voltages: Vec::new(),
            error: 0.02,
            places: 300,
            seed,
        };
        let scene = contact_separation(|_, _| ());
        let made = map(&scene, &request, &Options::default(), &|_: Step| ()).expect("a map");
        let found = made.agreement;
        assert!(made.image.bytes() <= 2048, "{} bytes", made.image.bytes());
        assert!(found.median <= 0.02 && found.percentile_90 <= 0.08, "{seed}: {found:?}");
        assert!(found.bounds_hold >= 0.95 && found.regime_right >= 0.99, "{seed}: {found:?}");
    }
}
