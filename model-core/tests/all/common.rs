//! Common code of these tests: hybrid problems through the public traits, a recording observer, and inputs as
//! functions of time.

pub(crate) mod harvesters;

use core::fmt::Debug;

use model_core::clock::{Instant, TICKS_PER_SECOND};
use model_core::energy::estimator::{EstimatorError, Progress};
use model_core::excitation::Excitation;
use model_core::hybrid::{Automaton, Driver, Ended, Guard, HybridState, InputAt, Jump, StepError, Work};
use model_core::integrate::{
    Adaptive, AnyStepControl, DenseFactor, ErrorScale, FixedStep, Method, Point, StepControl, System,
};
use model_core::observer::{AcceptedStep, Event, Observer, Outputs, PowerIndex};
use model_core::scalar::Scalar;

/// Where a jump leads.
pub(crate) struct Leap<S, Mode, const N: usize> {
    pub(crate) mode: Mode,
    pub(crate) state: [S; N],
    pub(crate) armed: bool,
}

/// A hybrid problem as the literature states one: rates, Jacobians, guards and jumps.
pub(crate) trait Problem<S: Scalar, const N: usize>: Copy {
    type Mode: Copy + Debug + PartialEq;

    /// Number of a mode, by which events name it; 0 for a problem of one mode.
    fn number(&self, _mode: Self::Mode) -> u8 {
        0
    }
    fn rate(&self, mode: Self::Mode, y: &[S; N], input: S) -> [S; N];
    fn jacobian(&self, mode: Self::Mode, y: &[S; N], input: S) -> [[S; N]; N];
    /// Radians of the slow motion per second of the clock.
    fn angular_frequency(&self) -> S {
        S::ONE
    }
    /// What the entries of the state are measured by.
    fn sizes(&self, _mode: Self::Mode, _y: &[S; N]) -> [S; N] {
        [S::ONE; N]
    }
    /// Integrated along with the state.
    fn power(&self, _mode: Self::Mode, _y: &[S; N]) -> S {
        S::ZERO
    }
    fn guards(&self, _mode: Self::Mode) -> usize {
        0
    }
    /// Value and rate of a guard at a state and its derivative.
    fn guard(&self, _mode: Self::Mode, _index: usize, _armed: bool, _y: &[S; N], _rate: &[S; N]) -> [S; 2] {
        unreachable!("a problem without guards")
    }
    fn rearms(&self, _mode: Self::Mode, _y: &[S; N]) -> bool {
        true
    }
    fn leap(&self, _mode: Self::Mode, _index: usize, _y: &[S; N]) -> Leap<S, Self::Mode, N> {
        unreachable!("a problem without guards")
    }
    fn check(&self, _y: &[S; N]) -> Result<(), (&'static str, S)> {
        Ok(())
    }
}

/// A [`Problem`] as an [`Automaton`] with one power.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Machine<Q>(pub(crate) Q);

/// One mode of a [`Problem`] as a [`System`], with the crate's dense factorisation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flowing<'a, Q, Mode> {
    problem: &'a Q,
    mode: Mode,
}

impl<S: Scalar, const N: usize, Q: Problem<S, N>> System<S, N, 1> for Flowing<'_, Q, Q::Mode> {
    type Factor = DenseFactor<S, N>;

    fn flow(&self, state: &[S; N], input: S) -> [S; N] {
        self.problem.rate(self.mode, state, input)
    }

    fn factor(&self, state: &[S; N], input: S, weight: S) -> Option<Self::Factor> {
        DenseFactor::new(&self.problem.jacobian(self.mode, state, input), weight)
    }

    fn solve(&self, factor: &Self::Factor, right: [S; N]) -> [S; N] {
        factor.solve(&right)
    }

    fn powers(&self, state: &[S; N], _derivative: &[S; N], _input: S) -> [S; 1] {
        [self.problem.power(self.mode, state)]
    }

    fn error_norm(&self, state: &[S; N], change: &[S; N]) -> S {
        let sizes = self.problem.sizes(self.mode, state);
        // Written so that not-a-number is kept.
        (0..N).fold(S::ZERO, |largest, i| {
            let part = (change[i] / sizes[i]).abs();
            if part <= largest { largest } else { part }
        })
    }
}

impl<S: Scalar, const N: usize, Q: Problem<S, N>> Automaton<S, N, 1> for Machine<Q> {
    type Mode = Q::Mode;
    type Flow<'a>
        = Flowing<'a, Q, Q::Mode>
    where
        Self: 'a;

    fn flow(&self, mode: Q::Mode) -> Self::Flow<'_> {
        Flowing { problem: &self.0, mode }
    }

    fn guards(&self, mode: Q::Mode) -> usize {
        self.0.guards(mode)
    }

    fn guard<E: Excitation<S>>(
        &self,
        mode: Q::Mode,
        index: usize,
        armed: bool,
        point: &Point<S, N, 1>,
        _moment: &InputAt<'_, E>,
    ) -> Guard<S> {
        let [value, rate] = self.0.guard(mode, index, armed, &point.state, &point.derivative);
        Guard { value, rate }
    }

    fn rearms(&self, mode: Q::Mode, point: &Point<S, N, 1>) -> bool {
        self.0.rearms(mode, &point.state)
    }

    fn jump<E: Excitation<S>>(
        &self,
        mode: Q::Mode,
        index: usize,
        point: &Point<S, N, 1>,
        moment: &InputAt<'_, E>,
        _step: S,
    ) -> Jump<S, Q::Mode, N> {
        let Leap { mode, state, armed } = self.0.leap(mode, index, &point.state);
        let derivative = self.0.rate(mode, &state, moment.acceleration());
        Jump { mode, state, remainder: [S::ZERO; N], derivative, loss: S::ZERO, armed }
    }

    fn outputs<'a>(&self, mode: Q::Mode, point: &'a Point<S, N, 1>) -> Outputs<'a, S> {
        let mut outputs = Outputs::of_state(&point.state);
        outputs.mode = self.0.number(mode);
        outputs
    }

    fn error_scale(&self) -> ErrorScale<S> {
        ErrorScale {
            angular_frequency: self.0.angular_frequency(),
            decay_rate: S::ZERO,
            energy_floor: S::ONE,
        }
    }

    fn check(&self, _mode: Q::Mode, state: &[S; N]) -> Result<(), (&'static str, S)> {
        self.0.check(state)
    }
}

/// An input given as a function of time in seconds, evaluated in double precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Given<F>(pub(crate) F);

impl<S: Scalar, F: Fn(f64) -> f64> Excitation<S> for Given<F> {
    fn acceleration(&self, at: Instant) -> S {
        S::from_f64((self.0)(at.seconds()))
    }

    fn jerk(&self, _at: Instant) -> S {
        unreachable!("no guard of these problems depends on the input")
    }
}

/// An event as it was observed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Seen {
    /// Seconds, exactly: a run of these tests is shorter than 2⁵³ ticks.
    pub(crate) at: f64,
    pub(crate) guard: usize,
    /// Numbers of the modes, as [`Problem::number`] gives them.
    pub(crate) before: u8,
    pub(crate) after: u8,
    pub(crate) reached: Vec<f64>,
    pub(crate) left: Vec<f64>,
}

/// Keeps all events, adds up the energies, and checks that the steps join.
#[derive(Debug, Clone, Default)]
pub(crate) struct Log {
    pub(crate) events: Vec<Seen>,
    pub(crate) steps: usize,
    pub(crate) energy: f64,
    pub(crate) clock: u64,
    /// Smallest and largest value of the first entry of the state at the ends of steps.
    pub(crate) lowest: f64,
    pub(crate) highest: f64,
}

impl Log {
    pub(crate) fn new() -> Self {
        Self {
            events: Vec::new(),
            steps: 0,
            energy: 0.0,
            clock: 0,
            lowest: f64::INFINITY,
            highest: f64::NEG_INFINITY,
        }
    }

    pub(crate) fn times(&self) -> Vec<f64> {
        self.events.iter().map(|event| event.at).collect()
    }
}

/// Seconds of an instant, in double precision.
pub(crate) fn exact_seconds(at: Instant) -> f64 {
    at.ticks() as f64 / TICKS_PER_SECOND as f64
}

impl<S: Scalar> Observer<S> for Log {
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        assert_eq!(step.from.ticks(), self.clock, "a step must begin where the one before ended");
        assert!(step.ticks > 0, "a step must advance the clock");
        self.clock += u64::from(step.ticks);
        self.steps += 1;
        self.energy += step.energy(PowerIndex::Load).to_f64();
        self.lowest = self.lowest.min(step.end.state[0].to_f64());
        self.highest = self.highest.max(step.end.state[0].to_f64());
    }

    fn event(&mut self, event: &Event<'_, S>) {
        assert_eq!(event.at.ticks(), self.clock, "an event must lie at the end of a step");
        self.events.push(Seen {
            at: exact_seconds(event.at),
            guard: event.guard,
            before: event.before.mode,
            after: event.after.mode,
            reached: event.before.state.iter().map(|y| y.to_f64()).collect(),
            left: event.after.state.iter().map(|y| y.to_f64()).collect(),
        });
    }
}

/// The state of a problem with one power.
pub(crate) type State<S, Mode, const N: usize> = HybridState<S, Mode, N, 1>;

/// A problem, an input, a driver and where it stands.
pub(crate) struct Run<S, Q: Problem<S, N>, E, M, C, const N: usize>
where
    S: Scalar,
{
    pub(crate) machine: Machine<Q>,
    pub(crate) input: E,
    pub(crate) driver: Driver<M, C>,
    pub(crate) state: State<S, Q::Mode, N>,
    pub(crate) log: Log,
}

impl<S, Q, E, M, C, const N: usize> Run<S, Q, E, M, C, N>
where
    S: Scalar,
    Q: Problem<S, N>,
    E: Excitation<S>,
    M: Method<S>,
    C: StepControl<S>,
{
    pub(crate) fn start(problem: Q, mode: Q::Mode, state: [S; N], input: E, method: M, control: C) -> Self {
        let machine = Machine(problem);
        let state = HybridState::start(&machine, mode, state, &input, &control);
        Self { machine, input, driver: Driver::new(method, control), state, log: Log::new() }
    }

    /// Runs to `until` seconds in one call.
    pub(crate) fn to(&mut self, until: f64) -> Result<Work, StepError<S>> {
        let until = Instant::from_seconds(until).expect("a time that the clock holds");
        let advance = self.driver.advance(
            &self.machine,
            &mut self.state,
            &self.input,
            until,
            u32::MAX,
            &mut self.log,
        )?;
        assert_eq!(advance.ended, Ended::Finished);
        assert_eq!(self.state.clock, until);
        Ok(advance.work)
    }

    /// An entry of the state with what rounding took from it.
    pub(crate) fn entry(&self, index: usize) -> f64 {
        self.state.point.state[index].to_f64() + self.state.point.remainder[index].to_f64()
    }
}

/// Adaptive steps of a relative tolerance: of one type with [`fixed`], so that the problems are compiled once for both.
pub(crate) fn adaptive<S: Scalar>(tolerance: f64) -> AnyStepControl<S> {
    AnyStepControl::Adaptive(Adaptive::new(S::from_f64(tolerance)).expect("in bounds"))
}

/// Steps of so many seconds.
pub(crate) fn fixed<S: Scalar>(seconds: f64) -> AnyStepControl<S> {
    AnyStepControl::Fixed(FixedStep::of_seconds(seconds).expect("in bounds"))
}

/// A name for tables: `f32` or `f64`.
pub(crate) fn precision<S: Scalar>() -> &'static str {
    core::any::type_name::<S>()
}

/// Numbers for random tests, the same on every machine (SplitMix64).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to 1, 1 excluded.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// Evenly from `low` to `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// From `low` to `high`, both above 0, evenly in the logarithm.
    pub(crate) fn between_logarithmic(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// Normal with standard deviation 1.
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (core::f64::consts::TAU * self.unit()).cos()
    }
}

/// Asserts that an estimator finished a sample within its budget.
pub(crate) fn finished<S: Scalar>(pushed: Result<Progress, EstimatorError<S>>) {
    assert!(pushed.expect("runs").finished);
}

/// Numbers for tables.
pub(crate) fn table(numbers: &[f64]) -> String {
    let texts: Vec<String> = numbers.iter().map(|number| format!("{number:9.2e}")).collect();
    texts.join(" ")
}
