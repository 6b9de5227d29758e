//! The bits of a run do not depend on its division, and a guard that starts at zero after a jump does not fire at
//! once.
//!
//! The subject is a forced oscillator between a stop with restitution and a latch that holds it while a timer runs:
//! many events, rejected steps, and, after each release, a guard that is zero with zero rate, at a position that no
//! binary fraction represents. There is no reference: the runs are compared with each other.

use crate::common::{Given, Leap, Log, Machine, Problem, Random, adaptive, fixed, precision};
use model_core::clock::Instant;
use model_core::hybrid::{Driver, Ended, HybridState, LEAST_BUDGET};
use model_core::integrate::{Method, StepControl, TrBdf2};
use model_core::scalar::Scalar;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    Free,
    Closed,
}

const STOP: f64 = 0.1;
const STIFFNESS: f64 = 1e4;
const DAMPING: f64 = 4.0;
/// Seconds for which the latch holds.
const HOLD: f64 = 0.011;

/// `x'' = u − c x' − k x` above a stop at `−STOP`; the third entry is the timer.
#[derive(Debug, Clone, Copy)]
struct Latched;

impl Latched {
    fn margin<S: Scalar>() -> S {
        S::from_f64(64.0 * STOP) * S::EPSILON
    }
}

impl<S: Scalar> Problem<S, 3> for Latched {
    type Mode = Mode;

    fn number(&self, mode: Mode) -> u8 {
        mode as u8
    }

    fn rate(&self, mode: Mode, y: &[S; 3], input: S) -> [S; 3] {
        match mode {
            Mode::Free => {
                [y[1], input - S::from_f64(DAMPING) * y[1] - S::from_f64(STIFFNESS) * y[0], S::ZERO]
            }
            Mode::Closed => [S::ZERO, S::ZERO, -S::ONE],
        }
    }

    fn jacobian(&self, mode: Mode, _y: &[S; 3], _input: S) -> [[S; 3]; 3] {
        let mut jacobian = [[S::ZERO; 3]; 3];
        if mode == Mode::Free {
            jacobian[0][1] = S::ONE;
            jacobian[1] = [-S::from_f64(STIFFNESS), -S::from_f64(DAMPING), S::ZERO];
        }
        jacobian
    }

    fn angular_frequency(&self) -> S {
        S::from_f64(100.0)
    }

    fn sizes(&self, _mode: Mode, _y: &[S; 3]) -> [S; 3] {
        [S::from_f64(STOP), S::from_f64(100.0 * STOP), S::from_f64(HOLD)]
    }

    fn power(&self, _mode: Mode, y: &[S; 3]) -> S {
        y[1] * y[1]
    }

    fn guards(&self, _mode: Mode) -> usize {
        1
    }

    fn guard(&self, mode: Mode, _index: usize, armed: bool, y: &[S; 3], rate: &[S; 3]) -> [S; 2] {
        match mode {
            Mode::Free => {
                let lowered = if armed { S::ZERO } else { Self::margin() };
                [y[0] + S::from_f64(STOP) + lowered, rate[0]]
            }
            Mode::Closed => [y[2], rate[2]],
        }
    }

    fn rearms(&self, mode: Mode, y: &[S; 3]) -> bool {
        mode == Mode::Closed || y[1] > S::ZERO && y[0] + S::from_f64(STOP) > Self::margin()
    }

    fn leap(&self, mode: Mode, _index: usize, y: &[S; 3]) -> Leap<S, Mode, 3> {
        let rest = -S::from_f64(STOP);
        match mode {
            // A slow impact is caught, a fast one rebounds.
            Mode::Free if y[1] > -S::from_f64(3.0) => {
                Leap { mode: Mode::Closed, state: [rest, S::ZERO, S::from_f64(HOLD)], armed: true }
            }
            Mode::Free => {
                Leap { mode: Mode::Free, state: [rest, -S::from_f64(0.6) * y[1], S::ZERO], armed: true }
            }
            Mode::Closed => Leap { mode: Mode::Free, state: [rest, S::ZERO, S::ZERO], armed: false },
        }
    }
}

const END: f64 = 4.0;

/// How a run is divided.
#[derive(Debug, Clone, Copy)]
enum Division {
    Whole,
    Budgets(u64),
    Pauses,
    BudgetsAndPauses(u64),
}

/// All that a run leaves, as text: as many digits as tell any two numbers apart.
fn outcome<S: Scalar>(
    method: impl Method<S>,
    control: impl StepControl<S>,
    push: f64,
    division: Division,
) -> (String, usize, usize) {
    let machine = Machine(Latched);
    let input = Given(move |t: f64| push + 1400.0 * (88.0 * t).sin());
    let mut state = HybridState::start(&machine, Mode::Free, [S::ZERO; 3], &input, &control);
    let mut driver = Driver::new(method, control);
    let (budgets, pauses) = match division {
        Division::Whole => (None, false),
        Division::Budgets(seed) => (Some(seed), false),
        Division::Pauses => (None, true),
        Division::BudgetsAndPauses(seed) => (Some(seed), true),
    };
    driver.pause_at_events = pauses;
    let mut random = Random(budgets.unwrap_or(0));
    let mut log = Log::new();
    let until = Instant::from_seconds(END).expect("in range");
    let mut calls = 0;
    loop {
        let budget = if budgets.is_some() { (random.next() % 150) as u32 } else { u32::MAX };
        let advance =
            driver.advance(&machine, &mut state, &input, until, budget, &mut log).expect("a sound problem");
        calls += 1;
        let spent = advance.work.steps + advance.work.rejected + advance.work.locating;
        assert!(spent <= budget.max(LEAST_BUDGET), "{spent} attempts for a budget of {budget}");
        match advance.ended {
            Ended::Finished => break,
            Ended::Event => assert!(pauses && advance.work.events == 1),
            Ended::BudgetSpent => assert!(spent + advance.work.events > 0, "a call must get on"),
        }
    }
    (format!("{state:?} {log:?}"), log.events.len(), calls)
}

fn assert_indivisible<S: Scalar, M: Method<S> + Copy, C: StepControl<S> + Copy>(method: M, control: C) {
    let (whole, events, _) = outcome::<S>(method, control, 0.0, Division::Whole);
    println!("latched oscillator {}: {events} events", precision::<S>());
    assert!(events > 30, "{events} events are no test");
    let (paused, _, calls) = outcome::<S>(method, control, 0.0, Division::Pauses);
    assert!(calls >= events);
    assert_eq!(whole, paused);
    for seed in 0..8 {
        for division in [Division::Budgets(seed), Division::BudgetsAndPauses(seed)] {
            assert_eq!(whole, outcome::<S>(method, control, 0.0, division).0, "{division:?}");
        }
    }
}

#[test]
fn budgets_and_pauses_do_not_change_a_bit() {
    assert_indivisible::<f64, _, _>(TrBdf2, adaptive(1e-4));
    assert_indivisible::<f32, _, _>(TrBdf2, adaptive(1e-4));
    assert_indivisible::<f64, _, _>(TrBdf2, fixed(3e-4));
    assert_indivisible::<f32, _, _>(model_core::integrate::RungeKutta4, fixed(3e-4));
}

/// Time from the first release to the next event.
fn after_release<S: Scalar>(push: f64) -> Option<f64> {
    let machine = Machine(Latched);
    let input = Given(move |_| push);
    let control = adaptive(1e-4);
    let start = [-S::from_f64(STOP), S::ZERO, S::from_f64(HOLD)];
    let mut state = HybridState::start(&machine, Mode::Closed, start, &input, &control);
    let driver = Driver::new(TrBdf2, control);
    let mut log = Log::new();
    let until = Instant::from_seconds(HOLD + 0.04).expect("in range");
    driver.advance(&machine, &mut state, &input, until, u32::MAX, &mut log).expect("a sound problem");
    assert!((log.events[0].at - HOLD).abs() < 1e-8);
    assert_eq!(log.events[0].after, Mode::Free as u8);
    assert!(state.point.state[0].to_f64() >= -STOP - 1e-4, "the stop holds");
    log.events.get(1).map(|event| event.at - HOLD)
}

#[test]
fn a_guard_that_starts_at_zero_with_no_rate_waits_for_the_fall() {
    let balance = -STIFFNESS * STOP;
    for excess in [1.0, 30.0, 500.0] {
        let (double, single) =
            (after_release::<f64>(balance + excess), after_release::<f32>(balance + excess));
        println!("released with {excess:e} m/s² upwards: {double:?}, {single:?}");
        // A damped oscillator started from rest does not come back to where it was.
        assert_eq!((double, single), (None, None));
        let (double, single) =
            (after_release::<f64>(balance - excess), after_release::<f32>(balance - excess));
        println!("released with {excess:e} m/s² downwards: {double:?}, {single:?}");
        let sinks = |rounding: f64| (2.0 * 64.0 * STOP * rounding / excess).sqrt();
        let (double, single) = (double.expect("sinks"), single.expect("sinks"));
        assert!(double < 2.0 * sinks(f64::EPSILON) + 1e-9, "{double}");
        assert!(single < 2.0 * sinks(f64::from(f32::EPSILON)) + 1e-6, "{single}");
    }
}

#[test]
fn a_step_cut_short_by_the_end_of_a_call_does_not_slow_the_next_down() {
    let machine = Machine(Latched);
    let input = Given(|t: f64| 1400.0 * (88.0 * t).sin());
    let control = adaptive(1e-2);
    let driver = Driver::new(TrBdf2, control);
    let run = |pieces: u32| {
        let mut state = HybridState::start(&machine, Mode::Free, [0.0_f64; 3], &input, &control);
        let mut steps = 0;
        for piece in 1..=pieces {
            let until = Instant::from_seconds(END * f64::from(piece) / f64::from(pieces)).expect("in range");
            let advance = driver.advance(&machine, &mut state, &input, until, u32::MAX, &mut ());
            steps += advance.expect("a sound problem").work.steps;
        }
        steps
    };
    let (whole, pieces) = (run(1), 1000);
    let divided = run(pieces);
    println!("{whole} steps in one call, {divided} in {pieces}");
    // Each end of a call costs the step that it cuts in two.
    assert!(divided <= whole + pieces + whole / 20, "{whole} steps in one call, {divided} in {pieces}");
}
