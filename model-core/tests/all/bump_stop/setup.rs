//! The scene of the paper, and a run of it.

use model_core::energy::RunMeter;
use model_core::excitation::{Excitation, Sine};
use model_core::observer::{AcceptedStep, Observer, PowerIndex};
use model_core::scalar::Scalar;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::{AnyChoices, Parameters, Parts, Start, Stepper, TipMass};

pub(super) use crate::bridged::seconds;
/// The baseline.
pub(super) use crate::common::harvesters::bump_parameters as baseline;

pub(super) fn vibration<S: Scalar>() -> Sine<S, S::Build> {
    Sine::new(S::from_f64(20.0), S::from_f64(220.0), S::ZERO).expect("valid")
}

pub(super) fn close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() < relative, "{value} is not {expected} within {relative}");
}

/// Runs from rest to `settle` and on to `end`; gives what the meter saw from `settle` on.
pub(super) fn measured<S, P, E, const B: usize, const R: usize>(
    stepper: &Stepper<S, P, B, R, 1>,
    excitation: &E,
    settle: f64,
    end: f64,
) -> RunMeter<S>
where
    S: Scalar,
    P: Parts<S>,
    E: Excitation<S>,
{
    let mut state = stepper.scene().start(&Start::default(), excitation).expect("valid");
    let mut meter = RunMeter::new();
    let budget = u32::MAX;
    stepper.advance(&mut state, excitation, seconds(settle), budget, &mut ()).expect("runs");
    stepper.advance(&mut state, excitation, seconds(end), budget, &mut meter).expect("runs");
    meter
}

/// Notes the first touch-downs and sums the impulse; for a stepper with all powers.
#[derive(Default)]
pub(super) struct Touches {
    pub(super) at: Vec<f64>,
    pub(super) impulse: f64,
    pub(super) largest: f64,
    touching: bool,
    pub(super) negative: bool,
    pub(super) pulled_open: bool,
}

impl Observer<f64> for Touches {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        assert!(step.energies.len() > PowerIndex::ContactForce as usize);
        let impulse = step.energy(PowerIndex::ContactForce);
        let (from, to) = (step.start.penetration, step.end.penetration);
        self.negative |= impulse < 0.0;
        self.pulled_open |= impulse > 0.0 && from <= 0.0 && to < 0.0;
        self.impulse += impulse;
        self.largest = self.largest.max(impulse / step.step);
        let touches = impulse > 0.0;
        if touches && !self.touching {
            let fraction = if to > from { (-from / (to - from)).max(0.0) } else { 0.0 };
            self.at.push(step.from.seconds::<f64>() + fraction * step.step);
        }
        self.touching = touches && to > 0.0;
    }
}

/// A steel block of 8 × 10 × 5 mm behind the end of the beam.
pub(super) fn block<S: Scalar>() -> TipMass<S> {
    let mass = 7850.0 * 8e-3 * 10e-3 * 5e-3;
    TipMass {
        mass: S::from_f64(mass),
        rotary_inertia: S::from_f64(mass * (8e-3 * 8e-3 + 5e-3 * 5e-3) / 12.0),
        offset: S::from_f64(4e-3),
    }
}

/// The baseline with the block at its tip.
pub(super) fn with_block<S: Scalar>() -> Parameters<S, AnyChoices<S>> {
    let mut parameters = baseline::<S>();
    parameters.choices.tip_mass = Some(block());
    parameters
}
