//! More than a year of both tiers, each quarter of which is known as the first, and a harvester that has changed.

use std::collections::BTreeSet;

use host_bench::simulated_node::{Deviation, Kind, OneNode, Parts, Settings, Storage, World, years};
use model_core::node::Tier;

use super::{capacitor, part, random_hours};

#[test]
fn each_quarter_of_four_hundred_days_is_inside_its_bounds() {
    quarters_are_inside_their_bounds(capacitor(10e-3, 0.0));
}

#[test]
#[ignore = "nightly: ten seconds"]
fn each_quarter_of_four_hundred_days_on_a_supercapacitor_is_inside_its_bounds() {
    let name = "supercapacitor";
    let storage = Storage { name, leakage: 40e6, of_capacitance: 0.2, ..Storage::capacitor(0.2) };
    quarters_are_inside_their_bounds(storage);
}

fn quarters_are_inside_their_bounds(storage: Storage) {
    let quarters = years(400, &[storage]).expect("steps");
    // Two tiers, still and noisy nights, six stresses, four quarters.
    assert_eq!(quarters.len(), 2 * 2 * 6 * 4);
    for (index, quarter) in quarters.iter().enumerate() {
        assert_eq!(quarter.quarter as usize, 1 + index % 4);
        assert!(quarter.hours > 1500 && quarter.inside >= 0.95, "{quarter:?}");
        assert!(quarter.bound_over_first <= 1.2 && quarter.resolved_over_first <= 1.2, "{quarter:?}");
        let off = (quarter.sum_estimated_j - quarter.sum_true_j).abs();
        assert!(quarter.sum_true_j > 10.0 && off <= quarter.sum_bound_j, "{quarter:?}");
        assert!(quarter.share > 1e-4 && quarter.share <= 0.01, "{quarter:?}");
        let faults = [quarter.refused_images, quarter.frozen_hours, quarter.not_a_number];
        assert_eq!(faults, [0; 3], "{quarter:?}");
    }
    let text = format!("{:?}", quarters[0]);
    let keys = "tier storage capacitance_f still_nights stress quarter hours inside bound_over_first \
                resolved_over_first silent sum_estimated_j sum_bound_j sum_true_j share refused_images \
                frozen_hours not_a_number";
    let keys: Vec<_> = keys.split(' ').collect();
    let places: Vec<_> = keys.iter().map(|key| text.find(&format!(" {key}: ")).expect(key)).collect();
    assert!(places.is_sorted() && text.matches(": ").count() == keys.len(), "{text}");
}

#[test]
fn a_resonance_that_has_moved_by_a_fiftieth_makes_the_map_doubtful_within_a_day() {
    is_doubtful_where_the_resonance_has_moved(&[Kind::ContactSeparation], 4);
}

#[test]
#[ignore = "nightly: a minute"]
fn in_forty_days_no_map_is_doubtful_without_a_reason() {
    is_doubtful_where_the_resonance_has_moved(&[Kind::ContactSeparation, Kind::BumpStop], 40);
}

/// Harvesters: as designed for a day and for so many further days, and for a day with a resonance 2 % off.
fn is_doubtful_where_the_resonance_has_moved(kinds: &[Kind], days_as_designed: usize) {
    for &kind in kinds {
        let line = random_hours(kind, true, 12, 70 + kind as u64);
        let settings =
            Settings { gain: 0.1, check: 3600, ..Settings::new(kind, part("nrf52832"), 10e-3, 0.01) };
        let settings = settings.scaled(&line.minutes);
        for (resonance, days) in [(1.0, days_as_designed), (1.02, 1), (0.98, 1)] {
            let moved = if resonance == 1.0 {
                line.minutes.clone()
            } else {
                let moved = Deviation { resonance, ..Deviation::NONE };
                kind.minutes(&line.vibration, &|_| moved).expect("steps")
            };
            let (mut minutes, mut vibration) = (Vec::new(), Vec::new());
            for half in 0..2 + 2 * days {
                minutes.extend(if half < 2 { &line.minutes } else { &moved });
                vibration.extend_from_slice(&line.vibration);
            }
            // Seconds with an alarm, and the gain of the map.
            let (mut node, mut alarms) = (settings.map(), Vec::new());
            World::new(&settings, (&minutes, &vibration), Parts::AS_STATED, 7).run(&mut node, |running| {
                if running.state.is_map_doubtful() {
                    alarms.push((OneNode::second(&running.state), running.state.gain().map(f64::from)));
                }
            });
            let hours: BTreeSet<u32> = alarms.iter().map(|(second, _)| second / 3600).collect();
            println!("{kind:?} × {resonance}: {} hours from {:?} on", hours.len(), alarms.first());
            if resonance == 1.0 {
                assert!(hours.is_empty(), "{hours:?}");
                continue;
            }
            let (second, [gain, bound]) = alarms[0];
            assert!((86_400..86_400 + 2 * 3600).contains(&second), "{second} s");
            let minute = second as usize / 60 - 6;
            let truth = minutes[minute] / line.minutes[minute % line.minutes.len()];
            assert!((gain - truth).abs() <= bound && (gain - 1.0).abs() > bound, "{gain} ± {bound}: {truth}");
        }
    }
}
