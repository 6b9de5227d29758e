//! Nodes on a battery, whose voltage says next to nothing of an hour, over random hours of harvesters as designed.

use super::{KINDS, part, random_hours};
use host_bench::simulated_node::{Errors, Name, STORAGES, Setup};

#[test]
#[ignore = "nightly: half a minute"]
fn on_a_battery_the_map_knows_the_hours_three_times_better_than_any_baseline() {
    let lines: Vec<_> =
        (0..2).flat_map(|seed| KINDS.map(|kind| random_hours(kind, true, 4, 50 + seed))).collect();
    let batteries = STORAGES.into_iter().filter(|storage| storage.name.starts_with(['a', 's']));
    let batteries: Vec<_> = batteries.filter(|storage| storage.name != "supercapacitor").collect();
    assert_eq!(batteries.len(), 2);
    for storage in batteries {
        for spread in [0.01, 0.2] {
            let setup = Setup { processor: part("nrf52832"), storage, spread, seeds: 1 };
            let [map, others @ ..] = [Name::Map, Name::Voltage, Name::Difference, Name::Ewma].map(|name| {
                let came = setup.run_all(name, &lines);
                let errors = Errors::of(came.hours.values());
                println!("{} ±{spread} {name:?}: {errors:?}, share {}", storage.name, came.share);
                if matches!(name, Name::Map | Name::Voltage) {
                    assert!(errors.inside >= 0.95 && errors.hours == 24, "{name:?}: {errors:?}");
                }
                assert!(came.lock_outs == 0 && came.share < 0.01 && came.actions > 0, "{name:?}");
                errors.median
            });
            let best = others.into_iter().fold(f64::INFINITY, f64::min);
            assert!(map <= best / 3.0, "{}: {map} {others:?}", storage.name);
        }
    }
}
