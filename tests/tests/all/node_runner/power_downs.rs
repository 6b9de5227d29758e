//! Power-downs of a known, of no and of an unknown time, of a node whose actions keep its storage from filling up. The map
//! tells a power that is 1.24 times the true one.

use super::*;

/// Energies of the actions in J: 10 µW at the load.
pub(super) const DEAR: [f64; 2] = [200e-6, 2e-3];

pub(super) fn dear_node() -> &'static OneNode {
    let mut parameters = PARAMETERS;
    for (regular, energy) in parameters.voltage.actions.iter_mut().zip(DEAR) {
        regular.energy = energy as f32;
    }
    Box::leak(Box::new(built(parameters, RATE, 20.13).expect("valid")))
}

impl Bench {
    /// In a stronger vibration, with these actions.
    pub(super) fn dear() -> Self {
        Self { vibration: 2.5, actions: DEAR, ..Self::new() }
    }
}

/// A node after six hours.
fn after_six_hours() -> OneRunner {
    let mut runner = OneRunner::new(Bench::dear(), dear_node(), 0);
    while OneNode::second(runner.state()) < 21_600 {
        step(&mut runner);
    }
    runner
}

/// A node after six hours with its image saved, resumed on the same board after a gap that `change` made, run on for two
/// hours: its states before the gap, after it, and at the end. Whatever it tells in these hours is inside its bound.
fn resumed_after(gap: fn(u32) -> Outage, change: impl Fn(&mut Bench)) -> [OneState; 3] {
    let mut runner = after_six_hours();
    runner.save(&mut [0; SLOT_BYTES]).expect("room");
    let before = *runner.state();
    let mut board = runner.into_board();
    change(&mut board);
    let mut runner = resumed_on(dear_node(), board, gap);
    let after = *runner.state();
    let (mut last, mut hours) = (before.last_hour(), 0);
    while OneNode::second(runner.state()) < OneNode::second(&after) + 7200 {
        step(&mut runner);
        let Status { power, power_bound, .. } = runner.node().status(runner.state());
        let [power, bound] = [power, power_bound].map(f64::from);
        assert!((power - POWER).abs() < bound + 0.1 * POWER && power < 1.5 * POWER, "{power} {bound}");
        if runner.state().last_hour() != last {
            last = runner.state().last_hour();
            let hour = last.expect("an hour");
            assert_inside(hour);
            // The first hour is that of the gap.
            let most = if hours == 0 { 3.0 } else { 0.3 };
            assert!(hour.bound < most * hour.energy, "{hour:?}");
            hours += 1;
        }
    }
    assert!(hours >= 2);
    [before, after, *runner.state()]
}

#[test]
fn after_a_power_down_of_a_known_time_its_income_is_told() {
    let off = 300;
    let [before, after, end] = resumed_after(Outage::OffUntil, |board| {
        board.second += off;
        board.charge(0.9 * POWER, off);
    });
    assert_eq!(OneNode::second(&after), OneNode::second(&before) + off);
    assert_inside(dear_node().overall(&after));
    assert!(OneNode::second(&end) - dear_node().overall(&end).seconds <= 300);
    assert_inside(dear_node().overall(&end));
}

#[test]
fn after_a_reset_between_two_images_what_was_done_since_the_image_is_no_missing_income() {
    let mut runner = OneRunner::new(Bench::dear(), dear_node(), 0);
    let (mut saved, mut last, mut random) = (0, None, 1_u32);
    let (mut hours, mut inside, mut bounds) = (0, 0, 0.0);
    // An image each hour, and a reset 5 to 55 minutes after it.
    let mut reset = u32::MAX;
    while OneNode::second(runner.state()) < 60 * 3600 {
        step(&mut runner);
        let second = OneNode::second(runner.state());
        if second >= saved + 3600 {
            saved = second;
            runner.save(&mut [0; SLOT_BYTES]).expect("room");
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            reset = second + 300 + (random >> 16) % 3000;
        }
        if second >= reset {
            reset = u32::MAX;
            runner = resumed_on(dear_node(), runner.into_board(), Outage::OnUntil);
            assert_eq!(OneNode::second(runner.state()), second);
        }
        if runner.state().last_hour() != last {
            last = runner.state().last_hour();
            let hour = last.expect("an hour");
            let [told, bound, truth] =
                [hour.energy.into(), hour.bound.into(), POWER * f64::from(hour.seconds)];
            hours += 1;
            inside += u32::from((told - truth).abs() <= bound);
            bounds += bound / truth;
        }
    }
    assert!(hours > 40 && 100 * inside >= 95 * hours, "{inside} of {hours}");
    // Of each hour up to 55 minutes are lost, in which the actions took any part of 10 µW.
    assert!(bounds < 0.8 * f64::from(hours), "{bounds}");
}

#[test]
fn after_a_clock_that_goes_back_the_node_goes_on_from_the_new_time() {
    // While the node sleeps, and at a reset.
    for (back, is_reset) in [(7200, false), (20_000, false), (7200, true)] {
        let mut runner = after_six_hours();
        let (before, ran) = (*runner.state(), runner.board().ran);
        runner.save(&mut [0; SLOT_BYTES]).expect("room");
        runner.board_mut().second -= back;
        if is_reset {
            runner = resumed_on(dear_node(), runner.into_board(), Outage::OnUntil);
        }
        let start = runner.board().second;
        let (mut last, mut hours) = (before.last_hour(), 0);
        while runner.board().second < start + 3 * 3600 {
            step(&mut runner);
            let second = OneNode::second(runner.state());
            assert!(second == runner.board().second && second < 50_000, "{second}");
            runner.save(&mut [0; SLOT_BYTES]).expect("its own image");
            if runner.state().last_hour() != last {
                last = runner.state().last_hour();
                hours += 1;
                // The first hour lacks the income of the time that no clock knows.
                if hours > 1 {
                    assert_inside(last.expect("an hour"));
                }
            }
        }
        assert!(hours >= 2 && runner.board().ran[0] > ran[0] + 30, "{hours} {:?}", runner.board().ran);
    }
}

#[test]
fn after_a_power_down_of_no_time_nothing_has_changed() {
    let [before, after, _] = resumed_after(Outage::OffUntil, |_| {});
    assert_eq!(OneNode::second(&after), OneNode::second(&before));
    let [one, other] = [before, after].map(|state| dear_node().overall(&state));
    assert!((other.energy - one.energy).abs() < one.bound, "{one:?} {other:?}");
}

#[test]
fn after_a_lock_out_at_an_unknown_time_the_income_is_inside_its_bound() {
    let gap = 900;
    for drew in [0, 300, 900] {
        let [before, after, end] = resumed_after(Outage::LockedOutUntil, |board| {
            board.second += gap;
            board.charge(STORED - 10e-6 / 0.9, drew);
            board.charge(0.9 * POWER, gap - drew);
        });
        assert_eq!(OneNode::second(&after), OneNode::second(&before) + gap);
        assert_inside(dear_node().overall(&after));
        assert_inside(dear_node().overall(&end));
        // What it may have drawn is not known.
        let [known, bound] = [before, after].map(|state| f64::from(dear_node().overall(&state).bound));
        assert!(bound > known + 0.2 * 10e-6 * f64::from(gap), "{known} {bound}");
    }
}

#[test]
fn after_a_power_down_of_an_unknown_time_the_storage_is_read_anew_and_no_income_is_told() {
    // The storage is fuller, or emptier, by more than any income or draw of the times that the clock knows.
    for energy in [9.5e-3, 2.0e-3] {
        let [before, after, end] = resumed_after(|_| Outage::Unknown, |board| board.energy = energy);
        assert_eq!(OneNode::second(&after), OneNode::second(&before));
        // Of the time since the last reading nothing is said.
        let [one, other] = [before, after].map(|state| dear_node().overall(&state));
        assert!((other.energy - one.energy).abs() < 1e-3 * one.bound && other.silent > one.silent);
        let now = dear_node().status(&after);
        let [off, bound] = [f64::from(now.energy) - energy, now.energy_bound.into()];
        assert!(off.abs() < bound && bound < 0.1e-3, "{now:?}");
        assert!(OneNode::second(&end) - dear_node().overall(&end).seconds <= 300);
        assert_inside(dear_node().overall(&end));
    }
}
