//! Failed steps: each ends with the right [`StepError`], in bounded work, with the last good state; a further call
//! neither hangs nor changes that state.
//!
//! The problems fail at known places: a derivative that ceases to exist at a given position, an equation on which
//! Newton's iteration diverges, a singular iteration matrix, a jump without effect, a quantity that leaves its
//! domain.

use crate::common::{Leap, Log, Machine, Problem, State, adaptive, exact_seconds, fixed, precision};
use model_core::clock::Instant;
use model_core::excitation::Silence;
use model_core::hybrid::{Driver, Ended, HybridState, LEAST_BUDGET, StepError, StepFailure};
use model_core::integrate::{DenseFactor, Method, RungeKutta4, StepControl, TrBdf2};
use model_core::scalar::Scalar;

/// Where the trouble is; all start at 1 and fall with unit speed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Trouble {
    /// The derivative is not a number below 1/2.
    NotANumber,
    /// The derivative is infinite below 1/2.
    Infinite,
    /// Below 1/2 the derivative points up, above it down, steeply: an implicit step across the
    /// middle has no solution.
    NoSolution,
    /// Below 1/2 there is no Jacobian.
    NoMatrix,
    /// At 1/2 is a guard whose jump changes nothing.
    DeadJump,
    /// The model holds down to 1/2.
    Domain,
}

const MIDDLE: f64 = 0.5;

#[derive(Debug, Clone, Copy)]
struct Falling(Trouble);

impl<S: Scalar> Problem<S, 1> for Falling {
    type Mode = ();

    fn rate(&self, (): (), y: &[S; 1], _input: S) -> [S; 1] {
        let below = y[0] < S::from_f64(MIDDLE);
        match self.0 {
            Trouble::NotANumber if below => [S::from_f64(f64::NAN)],
            Trouble::Infinite if below => [S::INFINITY],
            Trouble::NoSolution if below => [S::from_f64(1e9)],
            Trouble::NoSolution if y[0] < S::from_f64(MIDDLE + 1e-3) => [-S::from_f64(1e9)],
            _ => [-S::ONE],
        }
    }

    fn jacobian(&self, (): (), y: &[S; 1], _input: S) -> [[S; 1]; 1] {
        if self.0 == Trouble::NoMatrix && y[0] < S::from_f64(MIDDLE) {
            [[S::from_f64(f64::NAN)]]
        } else {
            [[S::ZERO]]
        }
    }

    fn power(&self, (): (), y: &[S; 1]) -> S {
        y[0]
    }

    fn guards(&self, (): ()) -> usize {
        usize::from(self.0 == Trouble::DeadJump)
    }

    fn guard(&self, (): (), _index: usize, _armed: bool, y: &[S; 1], rate: &[S; 1]) -> [S; 2] {
        [y[0] - S::from_f64(MIDDLE), rate[0]]
    }

    fn leap(&self, (): (), _index: usize, y: &[S; 1]) -> Leap<S, (), 1> {
        Leap { mode: (), state: *y, armed: true }
    }

    fn check(&self, y: &[S; 1]) -> Result<(), (&'static str, S)> {
        if self.0 == Trouble::Domain && y[0] < S::from_f64(MIDDLE) { Err(("height", y[0])) } else { Ok(()) }
    }
}

struct Failed<S: Scalar> {
    error: StepError<S>,
    state: State<S, (), 1>,
    log: Log,
}

/// Attempts from the start to the trouble, in steps of a millisecond, and those on its brink: a
/// fixed step begins anew with its whole length, 15 quarterings above a picosecond, and each time
/// a quarter or more of what is left is gained.
const MOST_ATTEMPTS: u32 = 500 + 15 * 70;

/// Runs into the trouble with the least budget: an attempt a call.
fn fail<S: Scalar, M: Method<S>, C: StepControl<S>>(trouble: Trouble, driver: &Driver<M, C>) -> Failed<S> {
    let machine = Machine(Falling(trouble));
    let mut state = HybridState::start(&machine, (), [S::ONE], &Silence, &driver.control);
    let mut log = Log::new();
    let until = Instant::from_whole_seconds(2);
    for call in 0..MOST_ATTEMPTS {
        match driver.advance(&machine, &mut state, &Silence, until, 0, &mut log) {
            Ok(advance) => {
                assert_eq!(advance.ended, Ended::BudgetSpent, "call {call}");
                let work = advance.work;
                assert!(work.steps + work.rejected + work.locating <= LEAST_BUDGET);
            }
            Err(error) => return Failed { error, state, log },
        }
    }
    panic!("{trouble:?}: no error in {MOST_ATTEMPTS} calls, {} s", state.clock.seconds::<f64>());
}

/// What every failure leaves behind: the state that the observer saw last, just above the middle.
fn assert_last_good<S: Scalar>(failed: &Failed<S>, name: &str) {
    let Failed { error, state, log } = failed;
    let at = exact_seconds(error.at);
    println!("{name} {}: {error}, after {} steps", precision::<S>(), log.steps);
    assert_eq!(state.clock, error.at, "{name}");
    assert_eq!(state.clock.ticks(), log.clock, "{name}");
    let height = state.point.state[0].to_f64();
    let slack = 256.0 * S::EPSILON.to_f64();
    assert!((height + at - 1.0).abs() < slack, "{name}: {height} m at {at} s");
    let [derivative, power] = [state.point.derivative[0], state.point.powers[0]];
    assert!(derivative.is_finite() && (power.to_f64() - height).abs() < slack, "{name}");
}

fn assert_vanishes<S: Scalar>(trouble: Trouble, driver: &Driver<impl Method<S>, impl StepControl<S>>) {
    let failed = fail::<S, _, _>(trouble, driver);
    assert_last_good(&failed, &format!("{trouble:?}"));
    assert_eq!(failed.error.failure, StepFailure::StepVanished);
    let height = failed.state.point.state[0].to_f64();
    // The step shrinks to picoseconds, or to what the height is rounded to.
    assert!((height - MIDDLE).abs() < 1e-10 + 2.0 * S::EPSILON.to_f64(), "{height}");
}

#[test]
fn a_derivative_that_ceases_to_exist() {
    for trouble in [Trouble::NotANumber, Trouble::Infinite] {
        assert_vanishes::<f64>(trouble, &Driver::new(TrBdf2, adaptive(1e-3)));
        assert_vanishes::<f32>(trouble, &Driver::new(TrBdf2, adaptive(1e-3)));
        assert_vanishes::<f64>(trouble, &Driver::new(TrBdf2, fixed(1e-3)));
        assert_vanishes::<f32>(trouble, &Driver::new(TrBdf2, fixed(1e-3)));
        assert_vanishes::<f64>(trouble, &Driver::new(RungeKutta4, fixed(1e-3)));
    }
}

#[test]
fn equations_that_newton_cannot_solve() {
    assert_vanishes::<f64>(Trouble::NoMatrix, &Driver::new(TrBdf2, adaptive(1e-3)));
    assert_vanishes::<f32>(Trouble::NoMatrix, &Driver::new(TrBdf2, fixed(1e-3)));
    fn no_solution<S: Scalar>(control: impl StepControl<S>) {
        let failed = fail::<S, _, _>(Trouble::NoSolution, &Driver::new(TrBdf2, control));
        println!("NoSolution {}: {}", precision::<S>(), failed.error);
        assert_eq!(failed.error.failure, StepFailure::StepVanished);
        assert_eq!(failed.state.clock.ticks(), failed.log.clock);
        let (height, slack) = (failed.state.point.state[0].to_f64(), 256.0 * S::EPSILON.to_f64());
        assert!((MIDDLE..MIDDLE + 1e-3 + 1e-10 + slack).contains(&height), "{height}");
    }
    no_solution::<f64>(adaptive(1e-3));
    no_solution::<f32>(adaptive(1e-3));
    no_solution::<f64>(fixed(1e-3));
    no_solution::<f32>(fixed(1e-3));
}

#[test]
fn a_jump_that_leads_nowhere_is_a_storm() {
    fn storm<S: Scalar>(control: impl StepControl<S>) {
        let failed = fail(Trouble::DeadJump, &Driver::new(TrBdf2, control));
        assert_last_good::<S>(&failed, "DeadJump");
        assert_eq!(failed.error.failure, StepFailure::EventStorm);
        assert!((exact_seconds(failed.error.at) - MIDDLE).abs() < 1e-6);
        // All at one instant, and not many.
        assert!((2..100).contains(&failed.log.events.len()), "{} events", failed.log.events.len());
        assert!(failed.log.times().windows(2).all(|pair| pair[0] == pair[1]));
    }
    storm::<f64>(adaptive(1e-3));
    storm::<f32>(adaptive(1e-3));
    storm::<f64>(fixed(1e-3));
    storm::<f32>(fixed(1e-3));
}

#[test]
fn a_quantity_outside_its_domain_is_named_with_its_value() {
    fn leaves<S: Scalar>(driver: &Driver<impl Method<S>, impl StepControl<S>>) {
        let failed = fail(Trouble::Domain, driver);
        assert_last_good::<S>(&failed, "Domain");
        let StepFailure::OutsideDomain { quantity, value } = failed.error.failure else {
            panic!("{}", failed.error);
        };
        assert_eq!(quantity, "height");
        let (value, kept) = (value.to_f64(), failed.state.point.state[0].to_f64());
        // The step that would have left the domain was not kept.
        assert!(value < MIDDLE && kept >= MIDDLE && kept - value < 5e-3, "{value}, {kept}");
    }
    leaves::<f64>(&Driver::new(TrBdf2, adaptive(1e-3)));
    leaves::<f32>(&Driver::new(RungeKutta4, fixed(1e-3)));
}

/// Calls again after a failure: the same failure at the same time, and the same point.
fn assert_lasting<S: Scalar>(trouble: Trouble, driver: &Driver<impl Method<S>, impl StepControl<S>>) {
    let Failed { error, mut state, mut log } = fail::<S, _, _>(trouble, driver);
    let (point, steps) = (state.point, log.steps);
    let until = Instant::from_whole_seconds(2);
    for call in 0..20 {
        let again =
            driver.advance(&Machine(Falling(trouble)), &mut state, &Silence, until, u32::MAX, &mut log);
        assert_eq!(again, Err(error), "{trouble:?}: call {call}");
        assert_eq!((state.point, log.steps), (point, steps), "{trouble:?}: call {call}");
    }
}

#[test]
fn calling_again_after_a_storm_or_outside_the_domain_changes_nothing() {
    for trouble in [Trouble::DeadJump, Trouble::Domain] {
        assert_lasting::<f64>(trouble, &Driver::new(TrBdf2, adaptive(1e-3)));
        assert_lasting::<f32>(trouble, &Driver::new(TrBdf2, fixed(1e-3)));
    }
    assert_lasting::<f64>(Trouble::NotANumber, &Driver::new(RungeKutta4, fixed(1e-3)));
}

#[test]
fn calling_again_after_a_vanished_step_changes_nothing() {
    for trouble in [Trouble::NotANumber, Trouble::Infinite, Trouble::NoMatrix] {
        assert_lasting::<f64>(trouble, &Driver::new(TrBdf2, adaptive(1e-3)));
        assert_lasting::<f32>(trouble, &Driver::new(TrBdf2, fixed(1e-3)));
    }
}

#[test]
fn a_matrix_that_is_not_finite_is_refused() {
    for pivot in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        assert_eq!(DenseFactor::new(&[[pivot]], 0.1), None, "{pivot}");
        assert_eq!(DenseFactor::new(&[[pivot]], -1.0), None, "{pivot}");
        assert_eq!(DenseFactor::new(&[[2.0, 1.0], [1.0, pivot]], 0.1), None, "{pivot}");
    }
}
