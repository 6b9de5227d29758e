//! One step of each method on the contact-separation scene: 125 µs (T/400) of free flight, with the
//! delivered energy alone and with the whole account of powers.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use harvester_timing::{Runner, Shipped, any, shipped};
use model_core::clock::ticks_of_seconds;
use model_core::excitation::Excitation;
use model_core::hybrid::Automaton;
use model_core::integrate::{Attempt, Method, Point, RungeKutta4, TrBdf2};
use model_core::observer::ALL_POWERS;
use model_core::scalar::{Mathematics, Polynomial, Scalar};
use model_core::scene::contact_separation::{
    AnyChoices, CHARGE, ContactSeparation, GAP, Mode, Parts, VELOCITY,
};

/// Benches a step that carries `POWERS` powers.
fn step<S, F, P, M, const POWERS: usize>(
    criterion: &mut Criterion,
    name: &str,
    scene: &ContactSeparation<S, P>,
    method: M,
) where
    S: Scalar,
    F: Mathematics<S>,
    P: Parts<S>,
    M: Method<S>,
{
    let runner = Runner::<S, F, P>::new(*scene, 1e-3);
    let mut state = runner.start();
    // In free flight, a while after the fourth or so impact.
    runner.run_to(&mut state, 0.61);
    assert_eq!(state.mode, Mode::Free);
    let flow = Automaton::<S, 3, POWERS>::flow(scene, Mode::Free);
    let from = state.clock;
    let input = |ticks: u32| runner.excitation.acceleration(from.after(ticks));
    let [gap, velocity, charge] = [GAP, VELOCITY, CHARGE].map(|index| state.point.state[index]);
    let start: Point<S, 3, POWERS> = Point::at(&flow, [gap, velocity, charge], input(0));
    let ticks = ticks_of_seconds(S::from_f64(0.05 / 400.0));
    let accuracy = S::from_f64(1e-6);
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| {
            let (start, ticks) = (black_box(&start), black_box(ticks));
            let step = Attempt { start, input, ticks, accuracy, after_jump: false };
            let prediction = method.predict(&flow, &step);
            method.attempt(&flow, &step, prediction.as_ref())
        });
    });
}

fn all<S: Scalar, F: Mathematics<S>>(criterion: &mut Criterion, precision: &str) {
    let scene: ContactSeparation<S, Shipped<S, F>> = shipped(1e8);
    let any: ContactSeparation<S, AnyChoices<S, F>> = any(1e8);
    step::<S, F, _, _, 1>(criterion, &format!("step/tr-bdf2/{precision}/energy"), &scene, TrBdf2);
    step::<S, F, _, _, { ALL_POWERS }>(
        criterion,
        &format!("step/tr-bdf2/{precision}/account"),
        &scene,
        TrBdf2,
    );
    step::<S, F, _, _, 1>(criterion, &format!("step/tr-bdf2/{precision}/energy, any parts"), &any, TrBdf2);
    step::<S, F, _, _, 1>(criterion, &format!("step/rk4/{precision}/energy"), &scene, RungeKutta4);
    step::<S, F, _, _, { ALL_POWERS }>(
        criterion,
        &format!("step/rk4/{precision}/account"),
        &scene,
        RungeKutta4,
    );
}

fn steps(criterion: &mut Criterion) {
    all::<f32, Polynomial>(criterion, "f32");
    all::<f64, Polynomial>(criterion, "f64");
}

criterion_group!(benches, steps);
criterion_main!(benches);
