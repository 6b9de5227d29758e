//! Converters that do not answer, or answer with glitches.

use super::part;
use model_core::node::{StoreReading, Task, Tier};

use host_bench::simulated_node::{Kind, OneNode, OneState, Settings};

/// Forty hours of a full storage whose code is `code(reading)`; the wakes, and the state.
fn forty_hours(code: impl Fn(u32) -> Option<u32>) -> (u32, OneState, OneNode) {
    let node = Settings::new(Kind::ContactSeparation, part("nrf52832"), 1e-3, 0.2).map().node;
    let mut state = node.start(0);
    let (mut second, mut wakes, mut readings) = (0, 0, 0);
    let mut wake = node.wake(&mut state, second, Some(2800));
    while second < 40 * 3600 {
        let code = match wake.task {
            Task::Sleep => {
                second += wake.again_in;
                readings += u32::from(wake.read);
                if wake.read { code(readings) } else { None }
            }
            Task::Burst { samples } => {
                node.samples(&mut state, &vec![0; samples as usize]);
                second += 7;
                None
            }
            Task::Run(_) => None,
        };
        wake = node.wake(&mut state, second, code);
        wakes += 1;
    }
    (wakes, state, node)
}

#[test]
fn a_converter_that_does_not_answer_is_asked_as_often_as_one_that_does() {
    let (answered, _, _) = forty_hours(|_| Some(2800));
    let (wakes, state, node) = forty_hours(|_| None);
    println!("{wakes} wakes, {answered} with answers");
    assert!(wakes < 2 * answered, "{wakes}");
    assert_eq!(state.voltage().last_reading(), Some(StoreReading::Refused));
    let attempts = f64::from(state.voltage().readings());
    assert!(attempts > 0.5 * f64::from(wakes), "attempts are booked");
    assert!(f64::from(node.spent_on_estimation(&state)) > 0.0);
}

#[test]
fn one_reading_at_the_end_of_the_converter_does_not_lose_the_storage() {
    let (_, steady, node) = forty_hours(|_| Some(2800));
    let (_, glitches, _) = forty_hours(|reading| Some(if reading % 10 == 0 { 4095 } else { 2800 }));
    let [steady, glitches] = [steady, glitches].map(|state| node.overall(&state).bound);
    println!("{steady} J, {glitches} J");
    assert!(glitches < 1.5 * steady, "{glitches} J in place of {steady} J");
}
