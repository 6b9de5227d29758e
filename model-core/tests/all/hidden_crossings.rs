//! Crossings hidden inside one step, with equal signs at both ends.
//!
//! * A body under constant force, `x = 1 − s²/2`, and one on a spring, `x = cos s`, pass a wall at `1 − δ` and
//!   return: at `∓√(2δ)` and `∓acos(1 − δ)`. Steps are longer than that. SUNDIALS and SciPy document that they miss
//!   such pairs.
//! * Guards that fall within one step are located in order of time.
//! * A guard that starts at zero after a jump does not fire at once, also with zero rate.
//! * The bits of a run do not depend on its division by budgets and pauses.

use crate::common::{Leap, Log, Machine, Problem, Run, fixed, precision};
use model_core::clock::{Instant, TICKS_PER_SECOND};
use model_core::excitation::Silence;
use model_core::hybrid::{Driver, Ended, HybridState};
use model_core::integrate::{Method, RungeKutta4, TrBdf2};
use model_core::scalar::Scalar;

/// Radians in a second of the clock: a step of 0.4 rad is 0.4 ms.
const PACE: f64 = 1000.0;
/// Two ticks in radians: an event ends its step at a tick, and the length of the step is rounded to one.
const BLUR: f64 = 2.0 * PACE / TICKS_PER_SECOND as f64;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Below,
    Above,
}

/// `x'' = −stiffness · x − (1 − stiffness)`, in radians: a parabola or a cosine, top at `x = 1`.
#[derive(Debug, Clone, Copy)]
struct Graze {
    stiffness: f64,
    /// `1 − δ`.
    wall: f64,
}

impl<S: Scalar> Problem<S, 2> for Graze {
    type Mode = Side;

    fn number(&self, side: Side) -> u8 {
        side as u8
    }

    fn rate(&self, _side: Side, y: &[S; 2], _input: S) -> [S; 2] {
        let (pace, stiffness) = (S::from_f64(PACE), S::from_f64(self.stiffness));
        [pace * y[1], pace * (-stiffness * y[0] - (S::ONE - stiffness))]
    }

    fn jacobian(&self, _side: Side, _y: &[S; 2], _input: S) -> [[S; 2]; 2] {
        [[S::ZERO, S::from_f64(PACE)], [-S::from_f64(PACE * self.stiffness), S::ZERO]]
    }

    fn angular_frequency(&self) -> S {
        S::from_f64(PACE)
    }

    fn guards(&self, _side: Side) -> usize {
        1
    }

    fn guard(&self, side: Side, _index: usize, _armed: bool, y: &[S; 2], rate: &[S; 2]) -> [S; 2] {
        match side {
            Side::Below => [S::from_f64(self.wall) - y[0], -rate[0]],
            Side::Above => [y[0] - S::from_f64(self.wall), rate[0]],
        }
    }

    fn leap(&self, side: Side, _index: usize, y: &[S; 2]) -> Leap<S, Side, 2> {
        let mode = if side == Side::Below { Side::Above } else { Side::Below };
        Leap { mode, state: *y, armed: true }
    }
}

/// Passes the top once in steps of `step` radians of which one begins at `phase`; the crossings.
fn pass<S: Scalar>(graze: Graze, method: impl Method<S>, phase: f64, step: f64) -> Vec<f64> {
    let start = if graze.stiffness == 0.0 {
        [1.0 - 0.5 * phase * phase, -phase]
    } else {
        [phase.cos(), -phase.sin()]
    };
    let control = fixed(step / PACE);
    let mut run = Run::start(graze, Side::Below, start.map(S::from_f64), Silence, method, control);
    let work = run.to((step - 2.0 * phase) / PACE).expect("smooth");
    assert!(work.steps + work.locating < 100, "{work:?}");
    run.log.times().into_iter().map(|t| PACE * t + phase).collect()
}

const STEP: f64 = 0.4;
const PHASES: i32 = 16;

/// Phases at which a step can begin so that both crossings lie within it.
fn phases(crossing: f64) -> impl Iterator<Item = f64> {
    let room = STEP - 2.0 * crossing;
    (0..PHASES).map(move |k| -crossing - room * (f64::from(k) + 0.5) / f64::from(PHASES))
}

/// Grazes of which both crossings were found, of [`PHASES`], and the largest error of their phases.
fn sweep<S: Scalar>(stiffness: f64, depth: f64, method: impl Method<S> + Copy) -> (i32, f64) {
    let graze = Graze { stiffness, wall: S::from_f64(1.0 - depth).to_f64() };
    let depth = 1.0 - graze.wall;
    let crossing = if stiffness == 0.0 { (2.0 * depth.max(0.0)).sqrt() } else { graze.wall.min(1.0).acos() };
    let (mut found, mut worst) = (0, 0.0_f64);
    for phase in phases(crossing) {
        let crossings = pass::<S>(graze, method, phase, STEP);
        if let [first, second] = crossings[..] {
            found += 1;
            worst = worst.max((first + crossing).abs()).max((second - crossing).abs());
        } else {
            assert_eq!(crossings, [], "a body that goes in must come out");
        }
    }
    (found, worst)
}

fn parabola<S: Scalar>(shallowest: f64) {
    let rounding = S::EPSILON.to_f64();
    let mut depth = 1e-2;
    while depth > shallowest {
        let swept = [sweep::<S>(0.0, depth, TrBdf2), sweep::<S>(0.0, depth, RungeKutta4)];
        println!("parabola {} δ {depth:.0e}: found of {PHASES}, worst {swept:?}", precision::<S>());
        for (found, worst) in swept {
            assert_eq!(found, PHASES, "depth {depth}");
            // Roundings of the position over the slope, and the blur of the location.
            let bound = 8.0 * rounding / (2.0 * depth).sqrt() + 16.0 * rounding * STEP + BLUR;
            assert!(worst < bound, "depth {depth}: {worst} is above {bound}");
        }
        depth *= 0.1;
    }
    // At tangency either answer is right; beyond it there is nothing to find.
    sweep::<S>(0.0, 0.0, TrBdf2);
    for beyond in [16.0 * rounding, 1e-5, 1e-2] {
        let graze = Graze { stiffness: 0.0, wall: 1.0 + beyond };
        for phase in phases(0.0) {
            assert_eq!(pass::<S>(graze, TrBdf2, phase, STEP), []);
        }
    }
}

#[test]
fn a_parabola_is_followed_down_to_rounding() {
    parabola::<f64>(1e-13);
    parabola::<f32>(2e-6);
}

#[test]
fn a_cosine_is_followed_down_to_the_error_of_the_method() {
    // The position at a crossing is off by what the method makes of less than a step of 0.4 rad;
    // the cubic between the ends of a step adds s⁴/384 = 7e-5, below which a graze may be missed.
    let check = |name: &str, depth: f64, (found, worst): (i32, f64), position: f64| {
        println!("cosine {name} δ {depth:.0e}: found {found} of {PHASES}, worst {worst:.1e} rad");
        if depth >= 1e-4 {
            assert_eq!(found, PHASES, "{name}: depth {depth}");
            assert!(worst * (2.0 * depth).sqrt() < position, "{name}: depth {depth}: {worst}");
        } else if depth <= -3e-4 {
            assert_eq!(found, 0, "{name}: a wall beyond the top at {depth}");
        }
    };
    for depth in [1e-2, 5e-3, 2e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 0.0, -3e-4, -1e-2] {
        check("TR-BDF2 f64", depth, sweep::<f64>(1.0, depth, TrBdf2), 1.3e-4);
        check("TR-BDF2 f32", depth, sweep::<f32>(1.0, depth, TrBdf2), 1.3e-4);
        check("RK4 f64", depth, sweep::<f64>(1.0, depth, RungeKutta4), 2e-5);
        check("RK4 f32", depth, sweep::<f32>(1.0, depth, RungeKutta4), 2e-5);
    }
}

/// `s' = PACE`: a point that moves along a line past fences. The mode has a bit for each one that
/// has been passed.
#[derive(Debug, Clone, Copy)]
struct Walk<'a> {
    /// Guard and its derivative by position.
    fences: &'a [fn(f64) -> [f64; 2]],
}

impl<S: Scalar> Problem<S, 1> for Walk<'_> {
    type Mode = u32;

    fn number(&self, passed: u32) -> u8 {
        passed as u8
    }

    fn rate(&self, _passed: u32, _y: &[S; 1], _input: S) -> [S; 1] {
        [S::from_f64(PACE)]
    }

    fn jacobian(&self, _passed: u32, _y: &[S; 1], _input: S) -> [[S; 1]; 1] {
        [[S::ZERO]]
    }

    fn angular_frequency(&self) -> S {
        S::from_f64(PACE)
    }

    fn guards(&self, _passed: u32) -> usize {
        self.fences.len()
    }

    fn guard(&self, passed: u32, index: usize, _armed: bool, y: &[S; 1], rate: &[S; 1]) -> [S; 2] {
        if passed & (1 << index) != 0 {
            return [S::ONE, S::ZERO];
        }
        let [value, slope] = self.fences[index](y[0].to_f64()).map(S::from_f64);
        [value, slope * rate[0]]
    }

    fn leap(&self, passed: u32, index: usize, y: &[S; 1]) -> Leap<S, u32, 1> {
        Leap { mode: passed | (1 << index), state: *y, armed: true }
    }
}

/// Guards and positions, in order, at which a walk from −1 to 1 in one step passes the fences.
fn walk<S: Scalar>(fences: &[fn(f64) -> [f64; 2]], method: impl Method<S>) -> Vec<(usize, f64)> {
    let control = fixed(2.0 / PACE);
    let mut run = Run::start(Walk { fences }, 0, [-S::ONE], Silence, method, control);
    let work = run.to(2.0 / PACE).expect("smooth");
    assert!(work.steps + work.locating < 30 * (1 + fences.len() as u32), "{work:?}");
    run.log.events.iter().map(|event| (event.guard, PACE * event.at - 1.0)).collect()
}

fn assert_order_of_time<S: Scalar>(fences: &[fn(f64) -> [f64; 2]], expected: &[(usize, f64)]) {
    for passed in [walk::<S>(fences, TrBdf2), walk::<S>(fences, RungeKutta4)] {
        println!("walk {}: {passed:.9?}", precision::<S>());
        assert_eq!(passed.len(), expected.len(), "{passed:?}");
        for ((guard, position), (expected_guard, expected_position)) in passed.iter().zip(expected) {
            assert_eq!(guard, expected_guard, "{passed:?}");
            let error = (position - expected_position).abs();
            assert!(error < 32.0 * S::EPSILON.to_f64() + BLUR, "guard {guard} is off by {error}");
        }
    }
}

/// Straight and curved fences, and two that stand 10⁻⁵ of the step apart.
const FENCES: [fn(f64) -> [f64; 2]; 5] = [
    |s| [0.9 - s, -1.0],
    |s| [0.5 - s * s * s, -3.0 * s * s],
    |s| [-0.600_02 - s, -1.0],
    |s| [0.1 - s, -1.0],
    |s| [-0.6 - s, -1.0],
];

#[test]
fn guards_that_fall_within_one_step_are_taken_in_order_of_time() {
    let expected = [(2, -0.600_02), (4, -0.6), (3, 0.1), (1, 0.5f64.cbrt()), (0, 0.9)];
    assert_order_of_time::<f64>(&FENCES, &expected);
    assert_order_of_time::<f32>(&FENCES, &expected);
}

/// `s⁴ − 0.01` falls at `−0.01^(1/4)`; a cubic through the ends of the step has it at `−0.7`.
const LATE: fn(f64) -> [f64; 2] = |s| [s * s * s * s - 0.01, 4.0 * s * s * s];
/// `s⁴ + 0.01` never falls, but the same cubic does.
const NEVER: fn(f64) -> [f64; 2] = |s| [s * s * s * s + 0.01, 4.0 * s * s * s];

#[test]
fn a_guard_that_the_dense_output_puts_too_early_does_not_delay_another() {
    let expected = [(1, -0.5), (0, -0.01f64.powf(0.25))];
    assert_order_of_time::<f64>(&[LATE, |s| [-0.5 - s, -1.0]], &expected);
    assert_order_of_time::<f32>(&[LATE, |s| [-0.5 - s, -1.0]], &expected);
}

#[test]
fn a_graze_that_the_dense_output_makes_up_does_not_delay_another_guard() {
    assert_order_of_time::<f64>(&[NEVER, |s| [-0.3 - s, -1.0]], &[(1, -0.3)]);
    assert_order_of_time::<f32>(&[NEVER, |s| [-0.3 - s, -1.0]], &[(1, -0.3)]);
}

/// `s⁸ + 0.01`: so steep that the cubic still promises a fall where the step is cut at `−0.3`.
const STEEP: fn(f64) -> [f64; 2] = |s| [s.powi(8) + 0.01, 8.0 * s.powi(7)];

#[test]
fn a_graze_made_up_twice_neither_loses_an_event_nor_depends_on_the_budget() {
    let fences: [fn(f64) -> [f64; 2]; 2] = [STEEP, |s| [-0.3 - s, -1.0]];
    assert_order_of_time::<f64>(&fences, &[(1, -0.3)]);
    assert_order_of_time::<f32>(&fences, &[(1, -0.3)]);
    let ticks = |budget: u32| {
        let walk = Machine(Walk { fences: &fences });
        let driver = Driver::new(TrBdf2, fixed(2.0 / PACE));
        let mut state = HybridState::start(&walk, 0, [-1.0_f64], &Silence, &driver.control);
        let mut log = Log::new();
        let until = Instant::from_seconds(2.0 / PACE).expect("in range");
        while driver.advance(&walk, &mut state, &Silence, until, budget, &mut log).expect("smooth").ended
            != Ended::Finished
        {}
        (state, log.events)
    };
    assert_eq!(ticks(0), ticks(u32::MAX));
}
