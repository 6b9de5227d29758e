//! The bouncing ball, the standard test of event location: infinitely many impacts in a finite time (Zeno's paradox),
//! then rest.
//!
//! Closed form for a drop from `h = 10 m` with `g = 9.81 m/s²` and restitution `e = 0.8`: impact `k` is at `t_k = t₀
//! (1 + 2 Σ_{i≤k} e^i)`, `t₀ = √(2h/g)`, and the impacts accumulate at `t₀ (1 + e)/(1 − e) = 12.850588106343581 s`.
//! Between impacts both methods are exact, so the whole error is that of the event location.
//!
//! Asserted: every impact time, speed and the number of impacts; a stick speed ends the chatter before the
//! accumulation point in a mode of rest; without one the driver returns [`StepFailure::EventStorm`] at the
//! accumulation point.

use crate::common::{Leap, Problem, Run, adaptive, exact_seconds, fixed, precision};
use model_core::clock::{LONGEST_STEP_S, TICKS_PER_SECOND};
use model_core::excitation::Silence;
use model_core::hybrid::StepFailure;
use model_core::integrate::{Method, RungeKutta4, StepControl, TrBdf2};
use model_core::part::GRAVITY;
use model_core::scalar::Scalar;

const RESTITUTION: f64 = 0.8;
const HEIGHT: f64 = 10.0;
const ZENO: f64 = 12.850_588_106_343_581;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    Flying,
    Stick,
}

#[derive(Debug, Clone, Copy)]
struct Ball {
    /// Rebounds slower than this are none; 0: there is no such rule.
    stick_speed: f64,
}

impl<S: Scalar> Problem<S, 2> for Ball {
    type Mode = Mode;

    fn number(&self, mode: Mode) -> u8 {
        mode as u8
    }

    fn rate(&self, mode: Mode, y: &[S; 2], _input: S) -> [S; 2] {
        match mode {
            Mode::Flying => [y[1], -S::from_f64(GRAVITY)],
            Mode::Stick => [S::ZERO; 2],
        }
    }

    fn jacobian(&self, mode: Mode, _y: &[S; 2], _input: S) -> [[S; 2]; 2] {
        let coupling = if mode == Mode::Flying { S::ONE } else { S::ZERO };
        [[S::ZERO, coupling], [S::ZERO; 2]]
    }

    fn sizes(&self, _mode: Mode, _y: &[S; 2]) -> [S; 2] {
        [S::from_f64(10.0), S::from_f64(14.0)]
    }

    fn guards(&self, mode: Mode) -> usize {
        usize::from(mode == Mode::Flying)
    }

    fn guard(&self, _mode: Mode, _index: usize, _armed: bool, y: &[S; 2], rate: &[S; 2]) -> [S; 2] {
        [y[0], rate[0]]
    }

    fn leap(&self, _mode: Mode, _index: usize, y: &[S; 2]) -> Leap<S, Mode, 2> {
        let rebound = -S::from_f64(RESTITUTION) * y[1];
        if rebound < S::from_f64(self.stick_speed) {
            Leap { mode: Mode::Stick, state: [S::ZERO; 2], armed: true }
        } else {
            Leap { mode: Mode::Flying, state: [S::ZERO, rebound], armed: true }
        }
    }
}

/// The constants as the given precision has them.
struct Exact {
    first: f64,
    speed: f64,
    restitution: f64,
}

impl Exact {
    fn of<S: Scalar>() -> Self {
        let gravity = S::from_f64(GRAVITY).to_f64();
        let first = (2.0 * HEIGHT / gravity).sqrt();
        Self { first, speed: gravity * first, restitution: S::from_f64(RESTITUTION).to_f64() }
    }

    fn impact(&self, k: usize) -> f64 {
        let bounces: f64 = (1..=k).map(|i| self.restitution.powi(i as i32)).sum();
        self.first * (1.0 + 2.0 * bounces)
    }

    fn speed(&self, k: usize) -> f64 {
        self.speed * self.restitution.powi(k as i32)
    }

    fn zeno(&self) -> f64 {
        self.first * (1.0 + self.restitution) / (1.0 - self.restitution)
    }
}

const TICK: f64 = 1.0 / TICKS_PER_SECOND as f64;

/// Drops a ball that comes to rest. An impact may be found late by `late` seconds.
fn drop_to_rest<S: Scalar>(
    name: &str,
    method: impl Method<S>,
    control: impl StepControl<S>,
    stick_speed: f64,
    late: f64,
) {
    let start = [S::from_f64(HEIGHT), S::ZERO];
    let mut run = Run::start(Ball { stick_speed }, Mode::Flying, start, Silence, method, control);
    let work = run.to(20.0).expect("comes to rest");
    let exact = Exact::of::<S>();

    // Impact k rebounds at speed k + 1: the last is the first whose rebound is too slow.
    let impacts = 1 + (0..).find(|&k| exact.speed(k + 1) < stick_speed).expect("slows down");
    assert_eq!(run.log.events.len(), impacts, "{name}: events");
    assert_eq!(run.state.mode, Mode::Stick);
    assert_eq!(run.state.point.state, [S::ZERO; 2], "{name}: at rest on the ground");

    let rounding = S::EPSILON.to_f64();
    let (mut worst, mut time_bound, mut speed_bound) = ([0.0_f64; 2], 0.0, 0.0);
    for (k, event) in run.log.events.iter().enumerate() {
        // The ball is put back on the ground: what it fell too long it keeps as speed, of which an
        // impact leaves a part e and adds a rounding. The length of each step is rounded too.
        let flight = exact.impact(k) - if k == 0 { 0.0 } else { exact.impact(k - 1) };
        time_bound += late + rounding * flight + 2.0 * exact.restitution * speed_bound / GRAVITY;
        speed_bound = exact.restitution * speed_bound + GRAVITY * late + rounding * exact.speed(k);
        let time = (event.at - exact.impact(k)).abs();
        let speed = (-event.reached[1] - exact.speed(k)).abs();
        worst = [worst[0].max(time), worst[1].max(speed)];
        assert!(event.reached[0] <= 0.0, "{name}: an event is on the far side");
        assert!(time < time_bound, "{name}: impact {k} is off by {time} s");
        assert!(speed < speed_bound, "{name}: speed {k} is off by {speed} m/s");
    }
    assert!(run.log.events[impacts - 1].at < exact.zeno() + time_bound);
    println!(
        "ball {name} {}, stick speed {stick_speed:.0e}: {impacts} impacts, first off by {:.1e} s, worst {:.1e} s, {:.1e} m/s; {} steps, {} locating",
        precision::<S>(),
        run.log.events[0].at - exact.impact(0),
        worst[0],
        worst[1],
        work.steps,
        work.locating
    );
    // From the tick that the dense output names, at most a step or two more.
    assert!(work.locating <= 3 * impacts as u32, "{name}: {} attempts to locate", work.locating);
}

#[test]
fn impact_times_are_exact_until_the_ball_rests_before_zeno_time() {
    assert!((Exact::of::<f64>().zeno() - ZENO).abs() < 1e-14);
    let step = 3.9e-3;
    for stick_speed in [1e-2, 1e-6] {
        // To the tick in double precision.
        let late = 1.5 * TICK;
        drop_to_rest::<f64>("TR-BDF2 fixed", TrBdf2, fixed(step), stick_speed, late);
        drop_to_rest::<f64>("TR-BDF2 adaptive", TrBdf2, adaptive(1e-4), stick_speed, late);
        drop_to_rest::<f64>("RK4 fixed", RungeKutta4, fixed(step), stick_speed, late);
        // To a few roundings of the step in single. Without an error, adaptive steps grow to the longest of the clock.
        let late_after = |step: f64| 16.0 * f64::from(f32::EPSILON) * step;
        let (late, longest) = (late_after(step), late_after(LONGEST_STEP_S));
        drop_to_rest::<f32>("TR-BDF2 fixed", TrBdf2, fixed(step), stick_speed, late);
        drop_to_rest::<f32>("TR-BDF2 adaptive", TrBdf2, adaptive(1e-4), stick_speed, longest);
        drop_to_rest::<f32>("RK4 fixed", RungeKutta4, fixed(step), stick_speed, late);
    }
}

/// Drops a ball that never rests. The accumulation point is known to `blur` seconds.
fn storm<S: Scalar>(control: impl StepControl<S>, blur: f64) {
    let start = [S::from_f64(HEIGHT), S::ZERO];
    let mut run = Run::start(Ball { stick_speed: 0.0 }, Mode::Flying, start, Silence, TrBdf2, control);
    let error = run.to(20.0).expect_err("there is no rule for rest");
    let exact = Exact::of::<S>();
    let at = exact_seconds(error.at);
    println!(
        "ball {} without rest: storm at {at:.12} s, {:.1e} s after the accumulation point, {} impacts, {} steps",
        precision::<S>(),
        at - exact.zeno(),
        run.log.events.len(),
        run.log.steps
    );
    assert_eq!(error.failure, StepFailure::EventStorm);
    assert!((at - exact.zeno()).abs() < blur, "{at}");
    // 97 impacts more than a nanosecond apart, and 64 that are not.
    assert!((150..175).contains(&run.log.events.len()), "{} impacts", run.log.events.len());
    assert!(run.log.steps < 20_000);

    // The state is the one that the observer saw last, on the ground and at rest but for rounding.
    assert_eq!(run.state.clock.ticks(), run.log.clock);
    assert_eq!(run.state.clock, error.at);
    let [height, velocity] = run.state.point.state.map(|y| y.to_f64());
    assert!(height.abs() < 1e-12 && velocity.abs() < 1e-6, "{height} m, {velocity} m/s");

    // Calling again gives the same answer, not a hang and not another state.
    let before = (run.state, run.log.events.len());
    assert_eq!(run.to(20.0).expect_err("still none"), error);
    assert_eq!((run.state, run.log.events.len()), before);
}

#[test]
fn without_a_rule_for_rest_the_accumulation_is_named() {
    // Each of 162 impacts is late by up to 1.5 ticks. What the ball fell too long it keeps as speed, and all later
    // flights are longer by 2 e / (1 − e) times the delay.
    let late = 162.0 * 1.5 * TICK * (1.0 + 2.0 * RESTITUTION / (1.0 - RESTITUTION));
    storm::<f64>(fixed(1e-3), late);
    storm::<f64>(adaptive(1e-5), late);
    storm::<f32>(fixed(1e-3), 5e-6);
    storm::<f32>(adaptive(1e-5), 5e-6);
}
