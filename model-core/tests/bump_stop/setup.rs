//! The scene of the paper, and how it is run.

#[allow(dead_code, reason = "the other scenes are for other tests")]
#[path = "../common/harvesters.rs"]
mod harvesters;

use model_core::clock::Instant;
use model_core::excitation::{Excitation, Sine};
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::{ModalMeter, ModalObserver, ModalSpan, Parts, Start, Stepper};

/// The baseline.
pub(super) use harvesters::bump_parameters as baseline;

pub(super) fn shaking<S: Scalar>() -> Sine<S, S::Build> {
    Sine::new(S::from_f64(20.0), S::from_f64(220.0), S::ZERO).expect("valid")
}

pub(super) fn seconds(seconds: f64) -> Instant {
    Instant::from_seconds(seconds).expect("a time")
}

pub(super) fn close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() < relative, "{value} is not {expected} within {relative}");
}

/// Runs from rest to `settle` and on to `end`; gives what the meter saw from `settle` on.
pub(super) fn measured<'a, S, P, E, const B: usize, const R: usize>(
    stepper: &'a Stepper<S, P, B, R>,
    excitation: &E,
    settle: f64,
    end: f64,
) -> ModalMeter<'a, S, P, B, R>
where
    S: Scalar,
    P: Parts<S>,
    E: Excitation<S>,
{
    let mut state = stepper.scene().start(&Start::default(), excitation).expect("valid");
    let mut meter = ModalMeter::new(stepper.scene());
    let budget = u32::MAX;
    stepper.advance(&mut state, excitation, seconds(settle), budget, &mut ()).expect("runs");
    stepper.advance(&mut state, excitation, seconds(end), budget, &mut meter).expect("runs");
    meter
}

/// Notes the first touch-downs and sums the impulse.
#[derive(Default)]
pub(super) struct Touches {
    pub(super) at: Vec<f64>,
    pub(super) impulse: f64,
    pub(super) largest: f64,
    touching: bool,
    pub(super) negative: bool,
    pub(super) pulled_open: bool,
}

impl<const B: usize, const R: usize> ModalObserver<f64, B, R> for Touches {
    fn step(&mut self, span: &ModalSpan<'_, f64, B, R>) {
        self.negative |= span.force < 0.0;
        self.pulled_open |= span.force > 0.0 && span.start.gap() <= 0.0 && span.end.gap() < 0.0;
        self.impulse += span.force * span.step;
        self.largest = self.largest.max(span.force);
        let touches = span.force > 0.0;
        if touches && !self.touching {
            let (from, to) = (span.start.gap(), span.end.gap());
            let fraction = if to > from { (-from / (to - from)).max(0.0) } else { 0.0 };
            self.at.push(span.start.clock.seconds::<f64>() + fraction * span.step);
        }
        self.touching = touches && span.end.gap() > 0.0;
    }
}
