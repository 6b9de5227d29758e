//! The plant: its lock-outs, its books, and the keys of the rows.

use super::part;
use host_bench::simulated_node::{
    Course, Extent, Kind, Name, OneNode, Parts, STORAGES, Settings, Setup, Storage, Strategy, Timeline,
    World, rows,
};
use model_core::node::{IncomeOfTime, Task, Tier, Wake};

fn settings(spread: f64) -> Settings {
    Settings::new(Kind::ContactSeparation, part("nrf52832"), 1e-3, spread)
}

#[test]
fn a_lock_out_within_a_sleep_and_one_by_an_action_are_counted() {
    let settings = settings(0.2);
    let mut node = settings.map();
    // Half an hour without income, and one with 1 mJ a minute: at its end the storage is full again.
    let minutes: Vec<f64> = (0..60).map(|minute| if minute < 30 { 0.0 } else { 1e-3 }).collect();
    let mut world = World::new(&settings, (&minutes, &[]), Parts::AS_STATED, 1);
    let lock_out = world.lock_out();
    // Enough for 1000 s of the standing power.
    world.energy = lock_out + 1000.0 * settings.standing;
    let wake = Wake { task: Task::Sleep, again_in: 3600, read: true };
    world.sleep(&mut node, wake);
    assert_eq!(world.lock_outs, 1);
    // The first 0.8 mJ turn it on again.
    assert!(world.energy > lock_out && (1830..1860).contains(&world.second()), "{}", world.second());
    assert_eq!(OneNode::second(&node.state), world.second());
    world.spend(world.energy - 0.9 * lock_out);
    world.wake(&mut node, None);
    assert_eq!(world.lock_outs, 2);
    assert!(world.energy > lock_out);
}

#[test]
fn the_hours_of_a_lock_out_are_inside_their_bounds() {
    let settings = settings(0.01);
    let mut lock_outs = 0;
    for later in [600.0, 1200.0, 2400.0] {
        for income in [0.1e-6, 1e-6, 5e-6] {
            // Two hours without income, and a lock-out in the second of them.
            let minutes: Vec<f64> =
                (0..360).map(|minute| if minute < 120 { 0.0 } else { 60.0 * income }).collect();
            let mut world = World::new(&settings, (&minutes, &[]), Parts::AS_STATED, 1);
            world.energy = world.lock_out() + (3600.0 + later) * settings.standing;
            let run = world.run(&mut settings.map(), |_| {});
            lock_outs += run.lock_outs;
            for hour in &run.hours {
                assert!(hour.is_inside(), "{later} s, {income} W: {hour:?}");
            }
        }
    }
    assert!(lock_outs >= 6, "{lock_outs}");
}

/// A node that tells its first hour a minute late.
struct Late(u32, Option<IncomeOfTime>);

impl Strategy for Late {
    fn wake(&mut self, now: u32, _: Option<u32>, _: bool) -> Wake {
        let seconds = now - self.0;
        if now == 3660 || now == 7200 {
            (self.0, self.1) = (now, Some(IncomeOfTime { seconds, ..IncomeOfTime::default() }));
        }
        Wake { task: Task::Sleep, again_in: 60, read: true }
    }

    fn last_hour(&self) -> Option<IncomeOfTime> {
        self.1
    }

    fn spent(&self) -> f64 {
        0.0
    }
}

#[test]
fn a_late_hour_is_not_taken_for_the_next_one_and_a_lock_out_at_the_end_is_one() {
    let settings = settings(0.2);
    let minutes = [1e-3; 120];
    let world = World::new(&settings, (&minutes, &[]), Parts::AS_STATED, 1);
    let run = world.run(&mut Late(0, None), |_| {});
    let hours: Vec<_> = run.hours.iter().map(|hour| (hour.index, (hour.truth / 1e-3).round())).collect();
    assert_eq!(hours, [(0, 61.0), (1, 59.0)]);
    let minutes = [0.0; 60];
    let mut world = World::new(&settings, (&minutes, &[]), Parts::AS_STATED, 1);
    world.energy = world.lock_out() + 1000.0 * settings.standing;
    assert_eq!(world.run(&mut settings.map(), |_| {}).lock_outs, 1);
}

/// An hour of a storage that fills up, two hours without income, in which it locks out, and one with.
fn line() -> Timeline {
    let power = |minute: usize| [40e-6, 0.0, 0.0, 5e-6][minute / 60];
    Timeline {
        kind: Kind::ContactSeparation,
        as_designed: true,
        hour_kinds: vec![],
        vibration: vec![],
        minutes: (0..240).map(|minute| 60.0 * power(minute)).collect(),
    }
}

#[test]
fn what_came_in_was_stored_spent_shunted_or_leaked() {
    let storage = Storage { leakage: 20e6, of_capacitance: 0.2, ..Storage::capacitor(1e-3) };
    let battery = STORAGES.into_iter().find(|storage| storage.name == "slb12400l151").expect("a storage");
    let of = |storage| Setup { processor: part("nrf52832"), storage, spread: 0.2, seeds: 1 };
    for name in Name::ALL {
        // What a battery does not give back counts as leaked.
        let [came, shunted, leaked, spent] = of(battery).run(name, &line(), 3, 100).account;
        let stored = of(battery).run(name, &line(), 3, 100).stored;
        let off = (came - shunted - leaked - spent - (stored[stored.len() - 1] - stored[0])).abs();
        assert!(off < 1e-9 * came && leaked > 0.01 * came, "{name:?}: {off} J of {came} J");
        let run = of(storage).run(name, &line(), 3, 100);
        let [came, shunted, leaked, spent] = run.account;
        let change = run.stored.last().expect("a second") - run.stored[0];
        let off = (came - shunted - leaked - spent - change).abs();
        assert!(off < 1e-11 * came, "{name:?}: {off} J of {came} J");
        assert!(
            shunted > 0.0 && leaked > 0.0 && spent > 0.0 && run.actions > 0,
            "{name:?}: {:?}",
            run.account
        );
    }
}

#[test]
fn an_intermittent_node_works_from_its_turn_on_to_its_lock_out() {
    let buffer = STORAGES.into_iter().find(|storage| storage.name == "buffer").expect("a storage");
    let storage = Storage { of_capacitance: 0.0, ..buffer };
    let line = Timeline { minutes: vec![60.0 * storage.income; 240], ..line() };
    let run = Setup { processor: part("nrf52832"), storage, spread: 0.0, seeds: 1 }.run(
        Name::Intermittent,
        &line,
        3,
        0,
    );
    let at = |volts: f64| 0.5 * 17e-6 * volts * volts * 0.9999;
    let mut last = 0;
    for &second in &run.acted {
        let stored = run.stored[second as usize];
        assert!(stored > at(2.4) && (second - last == 2 || stored > at(3.0)), "{second} s: {stored} J");
        last = second;
    }
    // Each 27.5 µJ from off to on, and what an action took below off, take 10 to 20 s of 2.9 µW less leakage.
    assert!((700..1500).contains(&run.lock_outs), "{}", run.lock_outs);
}

#[test]
fn the_rows_have_the_keys_of_their_contract() {
    let extent = Extent {
        kinds: vec![Kind::ContactSeparation],
        courses: vec![Course::Random],
        parts: vec!["nrf52832", "stm32l051", "apollo3"],
        storages: STORAGES.to_vec(),
        as_designed: false,
        hours: 4,
        seeds: 1,
    };
    let rows = rows(&extent, &[line()], || {});
    // Seven strategies, three parts, eleven storages, two draws.
    assert_eq!(rows.len(), 7 * 3 * 11 * 2);
    assert!(rows.iter().all(|row| row.income_w > row.leakage_w));
    let text = format!("{:?}", rows[0]);
    let keys = "strategy part storage capacitance_f income_w leakage_w draw_spread share error_median \
                bound_median inside hours error_over_difference bound_over_difference actions \
                actions_of_oracle lock_outs shunted error_full bound_full inside_full hours_full";
    let keys: Vec<_> = keys.split(' ').collect();
    let places: Vec<_> = keys.iter().map(|key| text.find(&format!(" {key}: ")).expect(key)).collect();
    assert!(places.is_sorted() && text.matches(": ").count() == keys.len(), "{text}");
    for row in rows.iter().filter(|row| row.lock_outs == 0) {
        assert!(row.actions_of_oracle.is_some_and(|most| most >= row.actions), "{row:?}");
    }
}
