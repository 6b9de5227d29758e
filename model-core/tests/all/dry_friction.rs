//! Dry friction as modes, not as a steep smooth function of the speed.
//!
//! * A slider on a spring with Coulomb friction, `x'' = −x − μ sgn x'`, `μ = 0.15`, from `x = 1`: each swing is half
//!   a cosine about `±μ`. It turns at `−0.7`, `0.4` and `−0.1` at `π`, `2π` and `3π`, where the spring force is below
//!   the friction: it sticks for ever.
//! * A block on a belt with the speed `v₀ = 0.2` (`m = k = 1`, static friction 1, kinetic 1/2): it sticks until `x =
//!   1`, slips for `2 (π − atan(5/2)) = 3.9026054`, sticks again at `x = 0`, and repeats with the period `8.9026054`.
//!
//! Asserted: positions, times, modes and number of events, in both precisions, for both methods.

use crate::common::{Leap, Problem, Run, adaptive, fixed, precision};
use model_core::clock::LONGEST_STEP_S;
use model_core::excitation::Silence;
use model_core::integrate::{Method, RungeKutta4, StepControl, TrBdf2};
use model_core::scalar::Scalar;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    /// To the right, faster than what it rubs on.
    SlipUp,
    /// To the left, or slower.
    SlipDown,
    Stick,
}

/// A unit mass on a unit spring, rubbing on a base of constant speed: position, and speed
/// relative to the base, so that sticking is an exact zero.
#[derive(Debug, Clone, Copy)]
struct Slider {
    base_speed: f64,
    at_rest: f64,
    sliding: f64,
}

impl Slider {
    fn friction(&self, mode: Mode) -> f64 {
        match mode {
            Mode::SlipUp => -self.sliding,
            Mode::SlipDown => self.sliding,
            Mode::Stick => 0.0,
        }
    }
}

impl<S: Scalar> Problem<S, 2> for Slider {
    type Mode = Mode;

    fn number(&self, mode: Mode) -> u8 {
        mode as u8
    }

    fn rate(&self, mode: Mode, y: &[S; 2], _input: S) -> [S; 2] {
        let speed = S::from_f64(self.base_speed) + y[1];
        if mode == Mode::Stick {
            return [S::from_f64(self.base_speed), S::ZERO];
        }
        [speed, S::from_f64(self.friction(mode)) - y[0]]
    }

    fn jacobian(&self, mode: Mode, _y: &[S; 2], _input: S) -> [[S; 2]; 2] {
        if mode == Mode::Stick { [[S::ZERO; 2]; 2] } else { [[S::ZERO, S::ONE], [-S::ONE, S::ZERO]] }
    }

    fn guards(&self, mode: Mode) -> usize {
        // Friction holds in two directions.
        if mode == Mode::Stick { 2 } else { 1 }
    }

    fn guard(&self, mode: Mode, index: usize, _armed: bool, y: &[S; 2], rate: &[S; 2]) -> [S; 2] {
        let held = S::from_f64(self.at_rest);
        match (mode, index) {
            (Mode::SlipUp, _) => [y[1], rate[1]],
            (Mode::SlipDown, _) => [-y[1], -rate[1]],
            (Mode::Stick, 0) => [held - y[0], -rate[0]],
            (Mode::Stick, _) => [held + y[0], rate[0]],
        }
    }

    fn leap(&self, mode: Mode, index: usize, y: &[S; 2]) -> Leap<S, Mode, 2> {
        let mode = match mode {
            Mode::Stick if index == 0 => Mode::SlipDown,
            Mode::Stick => Mode::SlipUp,
            // The spring's pull at the moment of rest decides.
            _ if y[0].abs() < S::from_f64(self.at_rest) => Mode::Stick,
            _ if y[0] > S::ZERO => Mode::SlipDown,
            _ => Mode::SlipUp,
        };
        Leap { mode, state: [y[0], S::ZERO], armed: true }
    }
}

/// How late TR-BDF2 is after `radians` of a harmonic motion: `(3√2 − 4)/6 h²` per radian.
///
/// In single precision a step is allowed an error of a few roundings. It is then the longest of the clock.
fn late_with_longest_steps(radians: f64) -> f64 {
    (3.0 * 2f64.sqrt() - 4.0) / 6.0 * LONGEST_STEP_S * LONGEST_STEP_S * radians
}

const COULOMB: Slider = Slider { base_speed: 0.0, at_rest: 0.15, sliding: 0.15 };

fn coulomb<S: Scalar>(name: &str, method: impl Method<S>, control: impl StepControl<S>, bound: f64) {
    let mut run = Run::start(COULOMB, Mode::SlipDown, [S::ONE, S::ZERO], Silence, method, control);
    let work = run.to(100.0).expect("comes to rest");
    let turns = [(-0.7, Mode::SlipUp), (0.4, Mode::SlipDown), (-0.1, Mode::Stick)];
    assert_eq!(run.log.events.len(), turns.len(), "{name}: {:?}", run.log.events);
    let mut worst = [0.0_f64; 2];
    for (k, (event, (position, after))) in run.log.events.iter().zip(turns).enumerate() {
        let time = event.at - core::f64::consts::PI * (k + 1) as f64;
        worst = [worst[0].max(time.abs()), worst[1].max((event.reached[0] - position).abs())];
        assert_eq!(event.after, after as u8, "{name}: turn {k}");
        assert_eq!(event.left[1], 0.0);
    }
    println!(
        "slider {name} {}: turns off by {:.1e} s, {:.1e} m; {} steps",
        precision::<S>(),
        worst[0],
        worst[1],
        work.steps
    );
    assert!(worst[0] < bound && worst[1] < bound, "{name}: {worst:?}");
    // It has stuck for 90 s: not a bit has moved.
    assert_eq!(run.state.mode, Mode::Stick);
    let rest = run.log.events[2].left[0];
    assert_eq!(run.state.point.state.map(|y| y.to_f64()), [rest, 0.0]);
}

#[test]
fn a_coulomb_slider_turns_three_times_and_sticks_for_ever() {
    let step = 3.9e-3;
    coulomb::<f64>("TR-BDF2 fixed", TrBdf2, fixed(step), 1e-5);
    coulomb::<f32>("TR-BDF2 fixed", TrBdf2, fixed(step), 1e-5);
    coulomb::<f64>("RK4 fixed", RungeKutta4, fixed(step), 1e-10);
    coulomb::<f32>("RK4 fixed", RungeKutta4, fixed(step), 2e-6);
    coulomb::<f64>("adaptive 1e-7", TrBdf2, adaptive(1e-7), 1e-6);
    let late = late_with_longest_steps(3.0 * core::f64::consts::PI);
    coulomb::<f32>("adaptive 1e-6", TrBdf2, adaptive(1e-6), 1.05 * late);
}

const BELT: Slider = Slider { base_speed: 0.2, at_rest: 1.0, sliding: 0.5 };
const SLIP_TIME: f64 = 3.902_605_407_814_523;
const STICK_TIME: f64 = 5.0;

fn belt<S: Scalar>(name: &str, method: impl Method<S>, control: impl StepControl<S>, bound: f64) {
    let mut run = Run::start(BELT, Mode::Stick, [S::ZERO; 2], Silence, method, control);
    let cycles = 8;
    let work = run.to((SLIP_TIME + STICK_TIME) * f64::from(cycles) + 1.0).expect("smooth");
    assert_eq!(run.log.events.len(), 2 * cycles as usize, "{name}");
    let mut before = 0.0;
    let mut worst = [0.0_f64; 3];
    for pair in run.log.events.chunks(2) {
        let [break_away, catch] = pair else { unreachable!("an even number") };
        let (stick, slip_down) = (Mode::Stick as u8, Mode::SlipDown as u8);
        assert_eq!((break_away.before, break_away.after), (stick, slip_down));
        assert_eq!((catch.before, catch.after), (slip_down, stick));
        let errors =
            [break_away.at - before - STICK_TIME, catch.at - break_away.at - SLIP_TIME, catch.reached[0]];
        worst = core::array::from_fn(|i| worst[i].max(errors[i].abs()));
        before = catch.at;
    }
    println!(
        "belt {name} {}: stick off by {:.1e} s, slip {:.1e} s, catch {:.1e} m; {} steps",
        precision::<S>(),
        worst[0],
        worst[1],
        worst[2],
        work.steps
    );
    // The belt carries an error of position for 1/v₀ = 5 times as long.
    assert!(worst[0] < 5.0 * bound && worst[1] < bound && worst[2] < bound, "{name}: {worst:?}");
}

#[test]
fn a_block_on_a_belt_sticks_and_slips_with_the_exact_period() {
    assert!((2.0 * (core::f64::consts::PI - 2.5f64.atan()) - SLIP_TIME).abs() < 1e-14);
    let step = 3.9e-3;
    belt::<f64>("TR-BDF2 fixed", TrBdf2, fixed(step), 1e-5);
    belt::<f32>("TR-BDF2 fixed", TrBdf2, fixed(step), 1e-5);
    belt::<f64>("RK4 fixed", RungeKutta4, fixed(step), 1e-10);
    belt::<f32>("RK4 fixed", RungeKutta4, fixed(step), 2e-6);
    belt::<f64>("adaptive 1e-7", TrBdf2, adaptive(1e-7), 1e-6);
    let late = late_with_longest_steps(SLIP_TIME);
    belt::<f32>("adaptive 1e-6", TrBdf2, adaptive(1e-6), 1.05 * late);
}
