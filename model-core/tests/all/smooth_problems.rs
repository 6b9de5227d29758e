//! Smooth problems with published or closed-form solutions.
//!
//! * An oscillator forced to move as a cosine: the order of both methods for the state and for the integrated power,
//!   the square of the velocity.
//! * Van der Pol's oscillator with `ε = 10⁻⁶` (Bari/CWI test set, VDPOL) and `10⁻³`.
//! * Robertson's reaction (ROBER), to 10¹¹ s and with the two roots of the SUNDIALS example. The clock cannot
//!   represent 10¹¹ s, so the problem runs in logarithmic time: `t = t₀ (e^s − 1)` with `s` proportional to the
//!   clock, which gives `dy/ds = (dt/ds) f(y)`. `dt/ds` is a known function of the clock and enters exactly as the
//!   input.

use crate::common::{Given, Leap, Problem, Run, adaptive, fixed, precision, table};
use model_core::excitation::Silence;
use model_core::integrate::{Method, RungeKutta4, TrBdf2};
use model_core::scalar::Scalar;

/// `x'' = u − c x' − ω² x`.
#[derive(Debug, Clone, Copy)]
struct Oscillator;

const OWN: f64 = 80.0;
const DAMPING: f64 = 8.0;
/// Angular frequency of the forced motion `x = cos Ω t`. Its period is a sixteenth of a second, so that a step and its
/// middle are whole ticks: half a tick of 3.6 ps off, the input at the middle stage of RK4 shows at an error of 10⁻¹⁰.
const FORCED: f64 = 16.0 * core::f64::consts::TAU;

fn force(t: f64) -> f64 {
    (OWN * OWN - FORCED * FORCED) * (FORCED * t).cos() - DAMPING * FORCED * (FORCED * t).sin()
}

impl<S: Scalar> Problem<S, 2> for Oscillator {
    type Mode = ();

    fn rate(&self, (): (), y: &[S; 2], input: S) -> [S; 2] {
        [y[1], input - S::from_f64(DAMPING) * y[1] - S::from_f64(OWN * OWN) * y[0]]
    }

    fn jacobian(&self, (): (), _y: &[S; 2], _input: S) -> [[S; 2]; 2] {
        [[S::ZERO, S::ONE], [-S::from_f64(OWN * OWN), -S::from_f64(DAMPING)]]
    }

    fn angular_frequency(&self) -> S {
        S::from_f64(FORCED)
    }

    fn sizes(&self, (): (), _y: &[S; 2]) -> [S; 2] {
        [S::ONE, S::from_f64(FORCED)]
    }

    fn power(&self, (): (), y: &[S; 2]) -> S {
        y[1] * y[1]
    }
}

/// Errors of the state after two periods, and of the mean square velocity over them.
fn oscillator_errors<S: Scalar>(method: impl Method<S>, steps_per_period: u32) -> [f64; 2] {
    let period = core::f64::consts::TAU / FORCED;
    let control = fixed(period / f64::from(steps_per_period));
    let mut run = Run::start(Oscillator, (), [S::ONE, S::ZERO], Given(force), method, control);
    let end = 2.0 * period;
    run.to(end).expect("smooth");
    let (x, v) = (run.entry(0) - (FORCED * end).cos(), run.entry(1) / FORCED + (FORCED * end).sin());
    // The integral of Ω² sin² over whole periods.
    let exact = 0.5 * FORCED * FORCED * end;
    [x.hypot(v), (run.log.energy / exact - 1.0).abs()]
}

fn assert_order<S: Scalar, M: Method<S> + Copy>(
    name: &str,
    method: M,
    coarsest: u32,
    halvings: u32,
    order: f64,
    slack: f64,
) {
    let mut before: Option<[f64; 2]> = None;
    for halving in 0..=halvings {
        let steps = coarsest << halving;
        let errors = oscillator_errors::<S>(method, steps);
        let orders = before.map(|before| [0, 1].map(|i| (before[i] / errors[i]).log2()));
        println!("{name} {} {steps:5} steps: {}, orders {orders:.3?}", precision::<S>(), table(&errors));
        for measured in orders.into_iter().flatten() {
            assert!((measured - order).abs() < slack, "{name} {}: order {measured}", precision::<S>());
        }
        before = Some(errors);
    }
}

#[test]
fn both_methods_have_their_order() {
    assert_order::<f64, _>("TR-BDF2", TrBdf2, 64, 4, 2.0, 0.1);
    assert_order::<f32, _>("TR-BDF2", TrBdf2, 64, 2, 2.0, 0.1);
    assert_order::<f64, _>("RK4", RungeKutta4, 64, 3, 4.0, 0.15);
    assert_order::<f32, _>("RK4", RungeKutta4, 16, 1, 4.0, 0.3);
}

/// `y1' = y2`, `ε y2' = (1 − y1²) y2 − y1`, with `pace` units of its time in a second of the clock.
#[derive(Debug, Clone, Copy)]
struct VanDerPol {
    per_epsilon: f64,
    pace: f64,
}

impl<S: Scalar> Problem<S, 2> for VanDerPol {
    type Mode = ();

    fn rate(&self, (): (), y: &[S; 2], _input: S) -> [S; 2] {
        let (stiff, pace) = (S::from_f64(self.per_epsilon), S::from_f64(self.pace));
        [pace * y[1], pace * (stiff * ((S::ONE - y[0] * y[0]) * y[1] - y[0]))]
    }

    fn jacobian(&self, (): (), y: &[S; 2], _input: S) -> [[S; 2]; 2] {
        let (stiff, pace) = (S::from_f64(self.per_epsilon), S::from_f64(self.pace));
        let by_position = -(S::from_f64(2.0) * y[0] * y[1] + S::ONE);
        [[S::ZERO, pace], [pace * stiff * by_position, pace * stiff * (S::ONE - y[0] * y[0])]]
    }

    fn angular_frequency(&self) -> S {
        S::from_f64(self.pace)
    }

    fn sizes(&self, (): (), y: &[S; 2]) -> [S; 2] {
        // y2 is of order one on the slow branches and 1/ε in the jumps between them.
        [S::ONE, S::ONE + y[1].abs()]
    }
}

/// Error of `y1` at `t = 2`, from `(2, 0)`, with the steps it took.
fn van_der_pol_error<S: Scalar>(epsilon: f64, pace: f64, tolerance: f64, reference: [f64; 2]) -> (f64, u32) {
    let problem = VanDerPol { per_epsilon: 1.0 / epsilon, pace };
    let control = adaptive(tolerance);
    let mut run = Run::start(problem, (), [S::from_f64(2.0), S::ZERO], Silence, TrBdf2, control);
    let work = run.to(2.0 / problem.pace).expect("smooth");
    let errors = [0, 1].map(|i| (run.entry(i) - reference[i]).abs());
    println!(
        "VDPOL {epsilon:.0e} {} tolerance {tolerance:.0e}: {}, {} steps, {} rejected, {} iterations",
        precision::<S>(),
        table(&errors),
        work.steps,
        work.rejected,
        work.iterations
    );
    (errors[0].max(errors[1]), work.steps + work.rejected)
}

const VDPOL: [f64; 2] = [1.706_167_732_170_483, -0.892_809_701_024_797_5];
const VDPOL_MILD: [f64; 2] = [1.763_234_540_203_46, -0.835_688_681_677_736];

#[test]
fn van_der_pol_through_two_jumps_a_million_times_faster() {
    // Steps on the slow branches are the longest of the clock, 1/256 of a unit at this pace.
    let pace = 0.25;
    for (tolerance, bound) in [(1e-1, 5e-5), (1e-2, 2.5e-5)] {
        for error in [
            van_der_pol_error::<f64>(1e-6, pace, tolerance, VDPOL).0,
            van_der_pol_error::<f32>(1e-6, pace, tolerance, VDPOL).0,
        ] {
            assert!(error < bound, "{error}");
        }
    }
}

#[test]
fn van_der_pol_error_is_in_proportion_to_the_tolerance() {
    let mut before = None;
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-5] {
        let (error, _) = van_der_pol_error::<f64>(1e-3, 64.0, tolerance, VDPOL_MILD);
        assert!(error < 0.08 * tolerance, "{error}");
        if let Some(before) = before {
            assert!(
                (6.0..14.0).contains(&(before / error)),
                "{before} to {error} for a tenth of the tolerance"
            );
        }
        before = Some(error);
        // In single precision the few roundings that a step is allowed take over.
        let (error, attempts) = van_der_pol_error::<f32>(1e-3, 64.0, tolerance, VDPOL_MILD);
        assert!(error < 0.08 * tolerance + 6e-5, "{error}");
        assert!(attempts < 2_600, "{attempts} attempts");
    }
}

/// Robertson's reaction with the input as `dt/ds · ds/d(clock)`.
///
/// The mode is the number of roots passed: `y3 = 0.01` first, then `y1 = 10⁻⁴`.
#[derive(Debug, Clone, Copy)]
struct Robertson;

/// `t₀` in the problem's seconds, and units of `s` in a second of the clock.
const LOG_START: f64 = 1e-3;
const LOG_PACE: f64 = 100.0;

fn reaction_time(clock: f64) -> f64 {
    LOG_START * (LOG_PACE * clock).exp_m1()
}

fn clock_of(reaction_time: f64) -> f64 {
    (reaction_time / LOG_START).ln_1p() / LOG_PACE
}

impl<S: Scalar> Problem<S, 3> for Robertson {
    type Mode = usize;

    fn number(&self, roots: usize) -> u8 {
        roots as u8
    }

    fn rate(&self, _roots: usize, y: &[S; 3], input: S) -> [S; 3] {
        let forward = S::from_f64(0.04) * y[0] - S::from_f64(1e4) * y[1] * y[2];
        let third = S::from_f64(3e7) * y[1] * y[1];
        [-input * forward, input * (forward - third), input * third]
    }

    fn jacobian(&self, _roots: usize, y: &[S; 3], input: S) -> [[S; 3]; 3] {
        let (a, b, c) = (S::from_f64(0.04), S::from_f64(1e4) * y[2], S::from_f64(1e4) * y[1]);
        let d = S::from_f64(6e7) * y[1];
        [[-a, b, c], [a, -b - d, -c], [S::ZERO, d, S::ZERO]].map(|row| row.map(|entry| input * entry))
    }

    fn angular_frequency(&self) -> S {
        S::from_f64(LOG_PACE)
    }

    fn sizes(&self, _roots: usize, y: &[S; 3]) -> [S; 3] {
        // Relative from where the species first matters.
        [y[0].abs(), y[1].abs() + S::from_f64(1e-9), y[2].abs() + S::from_f64(1e-6)]
            .map(|size| size.max(S::from_f64(1e-16)))
    }

    fn guards(&self, roots: usize) -> usize {
        usize::from(roots < 2)
    }

    fn guard(&self, roots: usize, _index: usize, _armed: bool, y: &[S; 3], rate: &[S; 3]) -> [S; 2] {
        if roots == 0 { [S::from_f64(0.01) - y[2], -rate[2]] } else { [y[0] - S::from_f64(1e-4), rate[0]] }
    }

    fn leap(&self, roots: usize, _index: usize, y: &[S; 3]) -> Leap<S, usize, 3> {
        Leap { mode: roots + 1, state: *y, armed: true }
    }
}

fn robertson<S: Scalar>(tolerance: f64, until: f64, reference: [f64; 3]) -> ([f64; 3], Vec<f64>) {
    let input = Given(|clock: f64| LOG_PACE * LOG_START * (LOG_PACE * clock).exp());
    let control = adaptive(tolerance);
    let mut run = Run::start(Robertson, 0, [S::ONE, S::ZERO, S::ZERO], input, TrBdf2, control);
    let work = run.to(clock_of(until)).expect("smooth");
    let errors = [0, 1, 2].map(|i| (run.entry(i) / reference[i] - 1.0).abs());
    let roots: Vec<f64> = run.log.times().into_iter().map(reaction_time).collect();
    println!(
        "ROBER {until:.0e} {} tolerance {tolerance:.0e}: relative {}, roots {roots:.10?}, {} steps, {} rejected",
        precision::<S>(),
        table(&errors),
        work.steps,
        work.rejected
    );
    (errors, roots)
}

const ROBER: [f64; 3] = [2.083_340_149_701_255e-8, 8.333_360_770_334_713e-14, 0.999_999_979_166_505_0];
const ROBER_40: [f64; 3] = [7.158_270_687_2e-1, 9.185_534_764_6e-6, 2.841_637_457_5e-1];

/// The roots, of which the second is known to nine digits.
const ROOTS: [f64; 2] = [0.264_019_078_19, 2.079_549_69e7];

#[test]
fn robertson_to_the_end_and_its_roots() {
    let assert_near = |errors: [f64; 3], roots: &[f64], expected: usize, bound: f64| {
        assert_eq!(roots.len(), expected);
        let roots = roots.iter().zip(ROOTS).map(|(root, exact)| (root / exact - 1.0).abs());
        for error in errors.into_iter().chain(roots) {
            assert!(error < bound, "{error} is above {bound}");
        }
    };
    for tolerance in [1e-3, 1e-4, 1e-5] {
        let (errors, roots) = robertson::<f64>(tolerance, 1e11, ROBER);
        assert_near(errors, &roots, 2, 0.06 * tolerance);
        // In single precision y3 is a sum of steps whose roundings show at the end.
        let (errors, roots) = robertson::<f32>(tolerance, 40.0, ROBER_40);
        assert_near(errors, &roots, 1, 0.06 * tolerance + 3e-5);
        let (errors, roots) = robertson::<f32>(tolerance, 1e11, ROBER);
        assert_near(errors, &roots, 2, 0.06 * tolerance + 8e-5);
    }
}
