//! The firmware's node on its simulated plant: the day that it lives on, what it tells of it, and its losses of power.
//!
//! That its log on a microcontroller is that of the host is checked by `host-bench on-target --node`.

use firmware_example::node::plant::{DAY, SECONDS, income};
use firmware_example::node::{Entry, LOSSES, Part, Work};
use host_bench::on_target::day;
use host_bench::on_target::node::{Native, calls, native, same_day};

const PARTS: [Part; 2] = [Part::Nrf52832, Part::Stm32l051];

#[test]
fn the_shipped_day_has_its_shaking_and_the_first_minutes_of_some_hours_by_the_full_model() {
    let vibration = day::vibration();
    assert!(DAY.iter().map(|minute| minute.lines).eq(vibration.iter().copied()));
    for (hour, minutes) in [(5, 6), (8, 6), (17, 6)] {
        let energies = day::energies(&vibration, hour, minutes).expect("can be stepped");
        let shipped: Vec<u32> =
            DAY.iter().skip(60 * hour).take(minutes).map(|minute| minute.energy).collect();
        assert_eq!(energies, shipped, "{hour}");
        // The last of them is shaken.
        assert!(shipped[minutes - 1] > 60_000, "{hour}: {shipped:?}");
    }
}

#[test]
#[ignore = "nightly: a day of a trajectory, half a minute"]
fn the_shipped_day_is_what_the_full_model_yields() {
    assert_eq!(DAY[..], day::day().expect("can be stepped"));
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware-example/trace/day.csv");
    assert_eq!(std::fs::read_to_string(file).expect("is there"), day::table(&DAY));
}

/// The states of a log, in order.
fn last_state(native: &Native) -> firmware_example::node::State {
    let mut states = native.entries.iter().filter_map(|entry| match entry {
        Entry::State(state) => Some(*state),
        _ => None,
    });
    states.next_back().expect("states")
}

#[test]
fn the_node_of_either_part_knows_the_income_of_a_harvester_that_is_off_for_a_hundredth_of_it() {
    for part in PARTS {
        let day = native(part, 0).expect("goes on");
        let state = last_state(&day);
        assert!(state.second >= SECONDS && state.income == income(), "{state:?}");
        let truth = 1e-12 * state.income as f64;
        let off = (f64::from(state.estimated.energy) - truth).abs();
        assert!(off < 0.02 * truth && off < f64::from(state.estimated.bound), "{state:?}");
        assert!(f64::from(state.estimation) < 0.01 * truth, "{state:?}");
        assert!(state.ran.iter().all(|&ran| ran > 50), "{state:?}");
        assert!(calls(&day, Work::Burst).calls > 10, "{part:?}");
        // The hours are the day, up to what a later reading tells of it.
        let hours = day.entries.iter().filter_map(|entry| match entry {
            Entry::Hour(hour) => Some((f64::from(hour.estimated.energy), hour.income)),
            _ => None,
        });
        let (told, came) = hours.fold((0.0, 0), |(told, came), hour| (told + hour.0, came + hour.1));
        assert_eq!(came, state.income);
        assert!((told / truth - 1.0).abs() < 0.02, "{told} {truth}");
    }
}

#[test]
fn a_node_that_loses_its_power_ten_times_ends_its_day_with_the_bits_of_one_that_does_not() {
    for part in PARTS {
        let whole = native(part, 0).expect("goes on");
        let restarted = native(part, LOSSES.len()).expect("goes on");
        assert_eq!(restarted.world.losses(), LOSSES.len());
        assert_eq!(restarted.world.plant(), whole.world.plant());
        let repeated = same_day(&restarted.entries, &whole.entries).expect("the same bits");
        assert!(repeated > 20, "{repeated}");
        let starts = restarted.entries.iter().filter(|entry| matches!(entry, Entry::Resumed { .. }));
        assert_eq!(starts.count(), LOSSES.len());
        // A node with another bit would be found.
        let mut other = whole.entries.clone();
        let place = other.iter().rposition(|entry| matches!(entry, Entry::Image { .. })).expect("images");
        if let Entry::Image { checksum, .. } = &mut other[place] {
            *checksum ^= 1;
        }
        assert!(same_day(&restarted.entries, &other).is_err());
    }
}
