//! One simulated second of the shipped contact-separation scene by exponential Radau, from 1 s to 2 s: 20 impacts or so; the reference from rest.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use harvester_reference::ReferenceOptions;
use harvester_scene::scene_file::{self, Override};
use harvester_timing::{Runner, any, shipped};
use model_core::scalar::{Mathematics, Polynomial, Scalar};
use model_core::scene::contact_separation::{ContactSeparation, Parts};

fn second<S: Scalar, M: Mathematics<S>, P: Parts<S>>(
    criterion: &mut Criterion,
    name: &str,
    scene: ContactSeparation<S, P>,
    tolerance: f64,
) {
    let runner = Runner::<S, M, P>::new(scene, tolerance);
    let mut begin = runner.start();
    runner.run_to(&mut begin, 1.0);
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| {
            let mut state = black_box(begin);
            runner.run_to(&mut state, 2.0)
        });
    });
}

fn seconds(criterion: &mut Criterion) {
    for tolerance in [5e-2, 1e-3] {
        let name = |precision, parts| format!("second/{precision}/{tolerance:e}/{parts}");
        second::<_, Polynomial, _>(
            criterion,
            &name("f32", "compile-time parts"),
            shipped::<f32, Polynomial>(1e8),
            tolerance,
        );
        second::<_, Polynomial, _>(
            criterion,
            &name("f32", "any parts"),
            any::<f32, Polynomial>(1e8),
            tolerance,
        );
        second::<_, Polynomial, _>(
            criterion,
            &name("f64", "compile-time parts"),
            shipped::<f64, Polynomial>(1e8),
            tolerance,
        );
        second::<_, Polynomial, _>(
            criterion,
            &name("f64", "any parts"),
            any::<f64, Polynomial>(1e8),
            tolerance,
        );
    }
    let run = Override::new("run", "{duration_s=1.0,settle_s=0.0}");
    let scene =
        scene_file::read(&scene_file::shipped("contact-separation"), &[run]).expect("a shipped scene");
    for tolerance in [1e-6, 1e-12] {
        let options = ReferenceOptions { tolerance, ..ReferenceOptions::default() };
        criterion.bench_function(&format!("second/f64/{tolerance:e}/reference"), |bencher| {
            bencher.iter(|| harvester_reference::run(black_box(&scene), &options).expect("runs"));
        });
    }
}

criterion_group!(benches, seconds);
criterion_main!(benches);
