//! Common code of the tests across crates: the shipped scenes, modified and run.

use host_bench::method::{Method, Options, Precision};
use host_bench::outcome::{BumpStopOutcome, ContactSeparationOutcome, Outcome, SlidingOutcome};
use host_bench::run::run_scene;
use host_bench::scene_file::{
    self, ContactSeparation, Excitation, Load, RunSpan, Scene, Sliding, SlidingParameters, Tone, Trace,
};

pub use model_core::part::GRAVITY;

/// The shipped contact-separation scene (Table 2 of the paper), changed by `change`.
#[must_use]
pub fn contact_separation(change: impl FnOnce(&mut Scene, &mut ContactSeparation)) -> Scene {
    let mut scene = shipped("contact-separation", &[]);
    let mut model = scene.contact_separation().expect("a contact-separation scene").clone();
    change(&mut scene, &mut model);
    scene.model = model.into();
    scene
}

/// The shipped sliding scene (Table 1 of the paper), changed by `change`.
#[must_use]
pub fn sliding(change: impl FnOnce(&mut Scene, &mut Sliding)) -> Scene {
    let mut scene = shipped("sliding", &[]);
    let mut model = scene.sliding().expect("a sliding scene").clone();
    change(&mut scene, &mut model);
    scene.model = model.into();
    scene
}

/// A shipped scene by the name of its file, with these keys changed.
#[must_use]
pub fn shipped(name: &str, changes: &[(&str, &str)]) -> Scene {
    scene_file::read_shipped(name, changes).expect("the shipped scene is valid")
}

/// The same coefficients of friction on both patches, static and kinetic.
pub fn rub(parameters: &mut SlidingParameters, coefficient: f64) {
    parameters.static_friction_active = coefficient;
    parameters.static_friction_inert = coefficient;
    parameters.kinetic_friction_active = coefficient;
    parameters.kinetic_friction_inert = coefficient;
}

/// One sine, with its amplitude in standard gravities.
#[must_use]
pub fn sine(gravities: f64, frequency_hz: f64) -> Excitation {
    Excitation::Sine(Tone { amplitude_m_per_s2: gravities * GRAVITY, frequency_hz, phase_rad: 0.0 })
}

/// A resistor.
#[must_use]
pub fn resistor(resistance_ohm: f64) -> Load {
    Load::Resistor { resistance_ohm }
}

/// A run of `periods` at `frequency_hz`, of which the last `measured` are measured.
#[must_use]
pub fn periods(frequency_hz: f64, periods: u32, measured: u32) -> RunSpan {
    RunSpan {
        duration_s: f64::from(periods) / frequency_hz,
        settle_s: f64::from(periods - measured) / frequency_hz,
    }
}

/// A repeated trace without any symmetry, of this amplitude in m/s².
#[must_use]
pub fn rough(amplitude: f64) -> Excitation {
    let samples = (0..60).map(|index: i32| amplitude * (f64::from((index * 7919) % 61) / 30.0 - 1.0));
    let trace = Trace { samples_m_per_s2: samples.collect(), rate_hz: 400.0, repeat: true, resampled: None };
    Excitation::File(trace)
}

/// Options for the core with error control, in double precision.
#[must_use]
pub fn adaptive(tolerance: f64) -> Options {
    Options { tolerance: Some(tolerance), ..Options::default() }
}

/// Options for the core with a fixed step in seconds, in double precision.
#[must_use]
pub fn fixed(step: f64) -> Options {
    Options { step_s: Some(step), ..Options::default() }
}

/// The same options in single precision.
#[must_use]
pub fn single(options: Options) -> Options {
    Options { precision: Some(Precision::F32), ..options }
}

/// Options for the independent reference.
#[must_use]
pub fn reference() -> Options {
    Options { method: Method::Reference, ..Options::default() }
}

/// Runs a scene that must run.
#[must_use]
pub fn outcome(scene: &Scene, options: &Options) -> Outcome {
    run_scene(scene, options).unwrap_or_else(|failure| panic!("{failure}"))
}

/// Runs a contact-separation scene that must run.
#[must_use]
pub fn run(scene: &Scene, options: &Options) -> (Outcome, ContactSeparationOutcome) {
    let outcome = outcome(scene, options);
    let particular = outcome.contact_separation().expect("a contact-separation run").clone();
    (outcome, particular)
}

/// Runs a sliding scene that must run.
#[must_use]
pub fn slide(scene: &Scene, options: &Options) -> (Outcome, SlidingOutcome) {
    let outcome = outcome(scene, options);
    let particular = outcome.sliding().expect("a sliding run").clone();
    (outcome, particular)
}

/// Runs a bump-stop scene that must run.
#[must_use]
pub fn run_beam(scene: &Scene, options: &Options) -> (Outcome, BumpStopOutcome) {
    let outcome = outcome(scene, options);
    let particular = outcome.bump_stop().expect("a bump-stop run").clone();
    (outcome, particular)
}

/// The number, or not-a-number, which fails every comparison.
#[must_use]
pub fn value(number: Option<f64>) -> f64 {
    number.unwrap_or(f64::NAN)
}

/// The relative difference of two numbers, and 0 if they are equal or both are absent.
pub fn relative_difference(one: Option<f64>, two: Option<f64>) -> f64 {
    match (one, two) {
        (None, None) => 0.0,
        (Some(one), Some(two)) if one == two => 0.0,
        (one, two) => (value(one) / value(two) - 1.0).abs(),
    }
}

/// Numbers in one line, to two digits.
pub fn shown(numbers: &[f64]) -> String {
    numbers.iter().map(|number| format!("{number:.1e} ")).collect()
}

/// Asserts that two numbers agree to a relative tolerance.
#[track_caller]
pub fn assert_close(what: &str, found: f64, expected: f64, tolerance: f64) {
    let error = (found / expected - 1.0).abs();
    assert!(
        error <= tolerance,
        "{what}: {found} instead of {expected}, off by {error:.2e}, allowed {tolerance:.0e}"
    );
}

/// A run: its options, by how much each number may be off, and by how much it is.
pub type Run<'a, const N: usize> = (&'a str, [f64; N], [f64; N]);

/// Shows by how much the runs of each scene are off, and asserts that none is off by more than is allowed.
pub fn assert_rows_within<C, const N: usize>(scenes: &[(&str, C)], rows: &[Vec<Run<'_, N>>]) {
    let all =
        || scenes.iter().zip(rows).flat_map(|((name, _), rows)| rows.iter().map(move |row| (name, row)));
    for (name, (options, _, found)) in all() {
        println!("{name}, {options}: off by {}", shown(found));
    }
    for (name, (options, allowed, found)) in all() {
        // Written so that not-a-number is too much.
        let close = found.iter().zip(allowed).all(|(off, allowed)| off <= allowed);
        assert!(close, "{name}, {options}: {}", shown(found));
    }
}

/// Slope of `ln error` over `ln step` by least squares: the order of convergence.
#[must_use]
pub fn order(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(step, error)| (step.ln(), error.ln())).collect();
    let mean = |pick: fn(&(f64, f64)) -> f64| logs.iter().map(pick).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let covariance: f64 = logs.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    covariance / logs.iter().map(|point| (point.0 - x).powi(2)).sum::<f64>()
}

/// Mean square of the current in A² through a resistor in periodic motion, `q' = rate(θ) (relaxed(θ) − q)` with the phase `θ` from
/// 0 to 2π in a period in s: exponential midpoint rule from the periodic charge. Charges in C, rates in 1/s.
pub fn mean_square_current(period_s: f64, rate: impl Fn(f64) -> f64, relaxed: impl Fn(f64) -> f64) -> f64 {
    const PARTS: u32 = 2_000_000;
    let part_s = period_s / f64::from(PARTS);
    let cycle = |start: f64| {
        (0..PARTS).fold([start, 1.0, 0.0], |[charge, left, squares], part| {
            let phase = std::f64::consts::TAU * (f64::from(part) + 0.5) / f64::from(PARTS);
            let (rate, relaxed) = (rate(phase), relaxed(phase));
            let half = (-0.5 * rate * part_s).exp();
            let away = charge - relaxed;
            let current = rate * away * half;
            [relaxed + away * half * half, left * half * half, squares + current * current]
        })
    };
    let [end, left, _] = cycle(0.0);
    cycle(end / (1.0 - left))[2] / f64::from(PARTS)
}

/// Calls `work` for each item, on all cores, and gives the results in the items' order.
pub fn on_all_cores<I: Sync, R: Send>(items: &[I], work: impl Fn(&I) -> R + Sync) -> Vec<R> {
    let next = std::sync::atomic::AtomicUsize::new(0);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut results: Vec<(usize, R)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores)
            .map(|_| {
                scope.spawn(|| {
                    let mut done = Vec::new();
                    loop {
                        let index = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                        let Some(item) = items.get(index) else { return done };
                        done.push((index, work(item)));
                    }
                })
            })
            .collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("a test's work does not panic")).collect()
    });
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}
