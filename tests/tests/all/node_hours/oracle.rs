//! The greatest number of actions, against all schedules of small storages.

use host_bench::simulated_node::{Oracle, Source};

/// The most actions of any schedule, by trying all of them; `None` if each locks out.
fn by_trying(oracle: &Oracle, second: usize, energy: f64, rested: u32) -> Option<usize> {
    if second == oracle.net.len() {
        return (energy > oracle.end.max(oracle.lock_out)).then_some(0);
    }
    let goes_on = |energy: f64, rested: u32| {
        let next = (energy + oracle.net[second] - oracle.leaking * energy).min(oracle.capacity);
        (energy > oracle.lock_out).then_some(())?;
        by_trying(oracle, second + 1, next, rested + 1)
    };
    let acts = (rested >= oracle.every).then(|| goes_on(energy - oracle.action, 0)).flatten();
    goes_on(energy, rested).max(acts.map(|most| most + 1))
}

#[test]
fn no_schedule_has_more_actions_than_the_oracle() {
    let mut random = Source::of_seed(1);
    let (mut some, mut none, mut full) = (0, 0, 0);
    for case in 0..2000 {
        let mut between = |low: f64, high: f64| random.uniform(low, high);
        let oracle = Oracle {
            begin: between(2.0, 10.0),
            end: between(0.0, 4.0),
            capacity: 10.0,
            lock_out: 1.0,
            action: between(0.5, 3.0),
            every: 1 + (3.0 * between(0.0, 1.0)) as u32,
            net: (0..12).map(|_| between(-1.5, 2.5)).collect(),
            leaking: between(0.0, 0.1),
        };
        let most = by_trying(&oracle, 0, oracle.begin, 9);
        let found = oracle.schedule();
        assert_eq!(found.as_ref().map(Vec::len), most, "{case}: {oracle:?} {found:?}");
        some += usize::from(most > Some(2));
        none += usize::from(most.is_none());
        full += usize::from(oracle.begin + oracle.net[0] > oracle.capacity);
    }
    assert!(some > 500 && none > 50 && full > 50, "{some} {none} {full}");
}
