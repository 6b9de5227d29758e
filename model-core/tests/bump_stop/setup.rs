//! The scene of the paper, and how it is run.

use model_core::clock::Instant;
use model_core::excitation::{Excitation, Sine};
use model_core::part::load::AnyLoad;
use model_core::part::monomorph::Layer;
use model_core::scalar::Scalar;
use model_core::scene::bump_stop::{
    AnyContact, AnyCoupling, AnyParts, ModalMeter, ModalObserver, ModalSpan, Parameters, Parts, Start,
    Stepper, Stop,
};

/// The baseline: 50 × 10 mm of 0.5 mm steel and 0.5 mm PZT-5A against an aluminium rod of 20 × 2 × 2 mm,
/// 10 µm from its tip.
pub(super) fn baseline<S: Scalar>() -> Parameters<S, AnyParts> {
    let number = S::literal;
    Parameters {
        beam_length: number(0.05),
        beam_width: number(0.01),
        substrate: Layer { thickness: number(5e-4), young_modulus: number(200e9), density: number(7850.0) },
        piezo: Layer { thickness: number(5e-4), young_modulus: number(66e9), density: number(7800.0) },
        piezo_d31: number(-190e-12),
        piezo_permittivity: number(15.93e-9),
        damping_ratio: number(0.01),
        stop: Stop {
            length: number(0.02),
            section: number(4e-6),
            young_modulus: number(70e9),
            density: number(2700.0),
            position: number(0.05),
            gap: number(10e-6),
            contact_compliance: S::ZERO,
        },
        load: AnyLoad { ohms: number(1e6) },
        coupling: AnyCoupling::TwoWay,
        contact: AnyContact::ResidualFlexibility,
    }
}

pub(super) fn shaking<S: Scalar>() -> Sine<S, S::Build> {
    Sine::new(S::literal(20.0), S::literal(220.0), S::ZERO).expect("valid")
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
