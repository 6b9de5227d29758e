//! The linear algebra of a TR-BDF2 step: one factorisation of `I − w J` and five solves (two Newton
//! iterations in each stage and the filter of the error estimate), on iteration matrices from along
//! the motion of the shipped scene.
//!
//! Three ways: the scene's own elimination by hand, whose time includes making the Jacobian; model-core's
//! factorisation for any small system; and nalgebra's. The last two are given the Jacobian.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use harvester_timing::{Runner, Shipped, shipped};
use model_core::hybrid::Automaton;
use model_core::integrate::{DenseFactor, System};
use model_core::scalar::{Mathematics, Polynomial, Scalar};
use model_core::scene::contact_separation::{ContactSeparation, Flow, Mode};
use nalgebra::{RealField, SMatrix, SVector};

const N: usize = 3;
const SOLVES: usize = 5;
/// Iteration matrices in one measurement.
const MATRICES: usize = 64;

type Scene<S, M> = ContactSeparation<S, Shipped<S, M>>;

/// One matrix: where it is from, and its entries.
#[derive(Clone, Copy)]
struct Sample<S> {
    state: [S; N],
    weight: S,
    jacobian: [[S; N]; N],
}

fn flow<S: Scalar, M: Mathematics<S>>(scene: &Scene<S, M>) -> Flow<'_, S, Shipped<S, M>> {
    Automaton::<S, N, 1>::flow(scene, Mode::Free)
}

/// Matrices from a second of the motion with impacts, for steps of T/50 to T/3200.
fn samples<S: Scalar + RealField>() -> Vec<Sample<S>> {
    let runner = Runner::<f64, Polynomial, _>::new(shipped::<f64, Polynomial>(1e8), 1e-3);
    let double: Scene<f64, Polynomial> = shipped(1e8);
    let mut state = runner.start();
    (0..MATRICES)
        .map(|index| {
            runner.run_to(&mut state, 0.5 + (index as f64 + 0.37) / MATRICES as f64);
            let step = 0.05 / (50.0 * 2f64.powi((index % 7) as i32));
            let weight = 0.292_893_218_813 * step;
            let point = state.point.state;
            let flow = flow(&double);
            let factor = System::<f64, N, 1>::factor(&flow, &point, 0.0, weight).expect("regular");
            // The inverse column by column, inverted again: the matrix itself is never formed there.
            let inverse = SMatrix::<f64, N, N>::from_columns(&[0, 1, 2].map(|column| {
                let unit = core::array::from_fn(|row| f64::from(u8::from(row == column)));
                SVector::<f64, N>::from(System::<f64, N, 1>::solve(&flow, &factor, unit))
            }));
            let matrix = inverse.try_inverse().expect("regular");
            let jacobian = (SMatrix::<f64, N, N>::identity() - matrix) / weight;
            Sample {
                state: point.map(<S as Scalar>::from_f64),
                weight: <S as Scalar>::from_f64(weight),
                jacobian: core::array::from_fn(|i| {
                    core::array::from_fn(|j| <S as Scalar>::from_f64(jacobian[(i, j)]))
                }),
            }
        })
        .collect()
}

fn peer_jacobian<S: RealField + Copy>(sample: &Sample<S>) -> SMatrix<S, N, N> {
    SMatrix::from_fn(|i, j| sample.jacobian[i][j])
}

fn precision<S: Scalar + RealField, M: Mathematics<S>>(criterion: &mut Criterion, name: &str) {
    let scene: Scene<S, M> = shipped(1e8);
    let samples = samples::<S>();
    let right: [S; N] = [1e-3, -0.2, 0.05].map(<S as Scalar>::from_f64);
    let mut group = criterion.benchmark_group(format!("linear/{name}, {MATRICES} factorisations"));
    group.bench_function("by hand", |bencher| {
        let flow = flow(&scene);
        bencher.iter(|| {
            for sample in black_box(&samples) {
                let factor =
                    System::<S, N, 1>::factor(&flow, &sample.state, S::ZERO, sample.weight).expect("regular");
                let mut x = right;
                for _ in 0..SOLVES {
                    x = System::<S, N, 1>::solve(&flow, &factor, x);
                }
                black_box(x);
            }
        });
    });
    group.bench_function("model-core", |bencher| {
        bencher.iter(|| {
            for sample in black_box(&samples) {
                let factor = DenseFactor::new(&sample.jacobian, sample.weight).expect("regular");
                let mut x = right;
                for _ in 0..SOLVES {
                    x = factor.solve(&x);
                }
                black_box(x);
            }
        });
    });
    group.bench_function("nalgebra", |bencher| {
        let jacobians: Vec<(SMatrix<S, N, N>, S)> =
            samples.iter().map(|sample| (peer_jacobian(sample), sample.weight)).collect();
        let right = SVector::<S, N>::from(right);
        bencher.iter(|| {
            for (jacobian, weight) in black_box(&jacobians) {
                let factor = (SMatrix::identity() - jacobian * *weight).lu();
                let mut x = right;
                for _ in 0..SOLVES {
                    x = factor.solve(&x).expect("regular");
                }
                black_box(x);
            }
        });
    });
    group.finish();
    agree::<S, M>(&samples, right);
}

/// That all three solve the same systems.
fn agree<S: Scalar + RealField, M: Mathematics<S>>(samples: &[Sample<S>], right: [S; N]) {
    let scene: Scene<S, M> = shipped(1e8);
    let flow = flow(&scene);
    for sample in samples {
        let factor =
            System::<S, N, 1>::factor(&flow, &sample.state, S::ZERO, sample.weight).expect("regular");
        let hand = System::<S, N, 1>::solve(&flow, &factor, right);
        let own = DenseFactor::new(&sample.jacobian, sample.weight).expect("regular").solve(&right);
        let peer = (SMatrix::identity() - peer_jacobian(sample) * sample.weight)
            .lu()
            .solve(&SVector::from(right))
            .expect("regular");
        for i in 0..N {
            let [hand, own, peer] = [hand[i], own[i], peer[i]].map(Scalar::to_f64);
            let scale = hand.abs().max(1e-3);
            assert!((own - hand).abs() < 1e-3 * scale && (peer - hand).abs() < 1e-3 * scale);
        }
    }
}

fn solves(criterion: &mut Criterion) {
    precision::<f32, Polynomial>(criterion, "f32");
    precision::<f64, Polynomial>(criterion, "f64");
}

criterion_group!(benches, solves);
criterion_main!(benches);
