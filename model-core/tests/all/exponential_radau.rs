//! Exponential Radau: orders of convergence, ledgers, near pull-in, heavy damping, single precision, and a split system of
//! the user. Agreement with the independent reference is in `tests/tests/all/exponential_radau.rs`.

mod coil;
mod limits;
mod orders;

use model_core::clock::Instant;
use model_core::energy::{Ledger, RunMeter};
use model_core::excitation::Excitation;
use model_core::hybrid::{Ended, HybridState};
use model_core::integrate::{Method, StepControl};
use model_core::observer::ALL_POWERS;
use model_core::scalar::Scalar;
use model_core::scene::{Harvester, Scene, Simulation};

/// The result of a run from its start.
#[derive(Debug, Clone)]
struct Found {
    power: f64,
    /// Time of the first impact in s.
    first_impact: Option<f64>,
    /// The last state, with what rounding took from it.
    state: Vec<f64>,
    attempts: u32,
    events: u32,
    /// Relative residual of the energies of mechanics and circuit together.
    residual: f64,
}

fn run<S, A, M, C, E, const N: usize>(
    scene: A,
    start: &A::Start,
    method: M,
    control: C,
    excitation: &E,
    seconds: f64,
) -> Found
where
    S: Scalar,
    A: Scene<S, N, ALL_POWERS>,
    M: Method<S>,
    C: StepControl<S>,
    E: Excitation<S>,
{
    let harvester = Simulation::with_all_powers(scene, method, control);
    let mut state: HybridState<S, A::Mode, N, ALL_POWERS> =
        harvester.start(start, excitation).expect("in bounds");
    let mut meter = RunMeter::new();
    let mut ledger = Ledger::open(&harvester.outputs(&state));
    let until = Instant::from_seconds(seconds).expect("in range");
    let mut observer = (&mut meter, &mut ledger);
    let advance =
        harvester.advance(&mut state, excitation, until, u32::MAX, &mut observer).expect("runs to its end");
    assert_eq!(advance.ended, Ended::Finished);
    let residual = ledger.residual();
    Found {
        power: meter.mean_power().to_f64(),
        first_impact: meter.report().first_contact.map(crate::common::exact_seconds),
        state: (0..N).map(|i| state.point.state[i].to_f64() + state.point.remainder[i].to_f64()).collect(),
        attempts: advance.work.attempts(),
        events: advance.work.events,
        residual: ((residual.mechanical + residual.electrical) / residual.scale).to_f64().abs(),
    }
}

/// Slope of `ln error` over `ln step` by least squares.
fn order(steps: &[f64], errors: &[f64]) -> f64 {
    let count = steps.len() as f64;
    let mean = |numbers: &[f64]| numbers.iter().map(|number| number.ln()).sum::<f64>() / count;
    let (x, y) = (mean(steps), mean(errors));
    let products = |others: &[f64], mean: f64| -> f64 {
        steps.iter().zip(others).map(|(step, other)| (step.ln() - x) * (other.ln() - mean)).sum()
    };
    products(errors, y) / products(steps, x)
}
