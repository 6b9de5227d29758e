//! The problem of Prothero and Robinson (Math. Comp. 28, 1974), `y' = λ (y − cos t) − sin t` from `y(0) = 1`: its
//! solution is `cos t` for any `λ`, and its stiffness grows with `−λ`.
//!
//! Asserted for `λ` from −1 to −10⁶: the order, which an implicit method may lose here; steps that grow with the
//! stiffness, which requires a filtered error estimate (Hosea and Shampine, Appl. Numer. Math. 20, 1996); and
//! L-stability.

use crate::common::{Given, Problem, Run, adaptive, fixed, table};
use model_core::integrate::{StepControl, TrBdf2};
use model_core::scalar::Scalar;

/// `y' = λ y + u` with `u = −λ cos t − sin t`.
#[derive(Debug, Clone, Copy)]
struct ProtheroRobinson {
    lambda: f64,
}

/// Units of the problem's time in a second of the clock.
const PACE: f64 = 50.0;

impl<S: Scalar> Problem<S, 1> for ProtheroRobinson {
    type Mode = ();

    fn rate(&self, (): (), y: &[S; 1], input: S) -> [S; 1] {
        [S::from_f64(PACE * self.lambda) * y[0] + input]
    }

    fn jacobian(&self, (): (), _y: &[S; 1], _input: S) -> [[S; 1]; 1] {
        [[S::from_f64(PACE * self.lambda)]]
    }

    fn angular_frequency(&self) -> S {
        S::from_f64(PACE)
    }
}

/// Error at `t = 10` from `1 + offset`, and attempted steps.
fn prothero_robinson<S: Scalar>(lambda: f64, offset: f64, control: impl StepControl<S>) -> (f64, u32) {
    let input = Given(move |clock: f64| {
        let t = PACE * clock;
        PACE * (-lambda * t.cos() - t.sin())
    });
    let start = [S::ONE + S::from_f64(offset)];
    let mut run = Run::start(ProtheroRobinson { lambda }, (), start, input, TrBdf2, control);
    let work = run.to(10.0 / PACE).expect("smooth");
    ((run.entry(0) - 10f64.cos()).abs(), work.steps + work.rejected)
}

#[test]
fn prothero_robinson_keeps_its_order_however_stiff() {
    for power in 0..=6 {
        let lambda = -10f64.powi(power);
        let steps = [128, 256, 512].map(|steps| 10.0 / PACE / f64::from(steps));
        let double = steps.map(|h| prothero_robinson::<f64>(lambda, 0.0, fixed(h)).0);
        let single = steps.map(|h| prothero_robinson::<f32>(lambda, 0.0, fixed(h)).0);
        let orders = [0, 1].map(|i| (double[i] / double[i + 1]).log2());
        println!(
            "PR {lambda:.0e} fixed: f64 {}, orders {orders:.2?}, f32 {}",
            table(&double),
            table(&single)
        );
        // A tick is 1.8e-10 of the problem's time, and the middle stage stands at a whole one.
        for (order, finer) in orders.iter().zip(&double[1..]) {
            assert!(*finer < 1e-10 || (1.85..2.25).contains(order), "{lambda}: orders {orders:?}");
        }
        for (double, single) in double.iter().zip(single) {
            assert!((double - single).abs() < 2e-7, "{lambda}: {double} in f64, {single} in f32");
        }
    }
}

#[test]
fn prothero_robinson_a_stiff_component_does_not_throttle_the_step() {
    let attempts = |lambda: f64, tolerance: f64| {
        let (double, attempts) = prothero_robinson::<f64>(lambda, 0.0, adaptive(tolerance));
        let (single, single_attempts) = prothero_robinson::<f32>(lambda, 0.0, adaptive(tolerance));
        println!(
            "PR {lambda:.0e} tolerance {tolerance:.0e}: f64 {double:.2e} in {attempts}, f32 {single:.2e} in {single_attempts}"
        );
        assert!(double < tolerance && single < tolerance + 4e-6, "{lambda} {tolerance}");
        assert!(single_attempts <= attempts);
        attempts
    };
    for tolerance in [1e-3, 1e-4, 1e-5] {
        let mild = attempts(-1.0, tolerance);
        let mut before = mild;
        for power in 1..=6 {
            let stiff = attempts(-10f64.powi(power), tolerance);
            // The stiffer, the nearer the solution is to its smooth limit, and the longer the steps.
            assert!(stiff <= before, "{before} attempts, then {stiff}");
            before = stiff;
        }
        // What remains is the longest step of the method, 0.4 radians, and the start.
        assert!(before < 25 + 10, "{before} attempts");
    }
}

#[test]
fn prothero_robinson_an_error_far_off_the_slow_motion_is_gone_within_steps() {
    // |R(λ h)| is below 10⁻⁴ here; a method that is not L-stable would ring on.
    let control = fixed(10.0 / PACE / 64.0);
    let (error, _) = prothero_robinson::<f64>(-1e6, 1.0, control);
    assert!(error < 1e-8, "{error}");
}
