//! Random excitation against spectral integrals, shocks against exact responses, and every kind against the reference.

use std::f64::consts::{PI, TAU};

use cross_crate_tests::{
    adaptive, assert_close, contact_separation, fixed, on_all_cores, outcome, reference, resistor, shipped,
    single, value,
};
use host_bench::method::Options;
use host_bench::scene_file::modes::BumpStopModes;
use host_bench::scene_file::{
    BumpStop, Burst, BurstShape, Excitation, ForceLaw, Model, Random, RunSpan, Scene, Sweep,
};
use host_bench::seeds::SampleStatistics;
use nalgebra::Complex;

/// The linear beam with some modes.
fn beam(modes: usize, excitation: Excitation, [settle_s, duration_s]: [f64; 2]) -> (Scene, BumpStop) {
    let mut scene = shipped("bump-stop-none", &[]);
    let Model::BumpStop(mut model) = scene.model.clone() else { panic!("another scene") };
    model.parameters.beam_modes = modes;
    model.initial.modal_displacement = vec![0.0; modes];
    model.initial.modal_velocity = vec![0.0; modes];
    scene.model = Model::BumpStop(model.clone());
    scene.excitation = excitation;
    scene.run = RunSpan { duration_s, settle_s };
    (scene, model)
}

fn random(density: &[[f64; 2]], lines: u32, seed: u64) -> Excitation {
    Excitation::Random(Random::new(density.to_vec(), lines, seed).expect("valid"))
}

fn shock(amplitude_m_per_s2: f64, duration_s: f64, start_s: f64) -> Excitation {
    let shape = BurstShape::HalfSine { duration_s };
    Excitation::Burst(Burst { amplitude_m_per_s2, shape, start_s, period_s: None })
}

/// `∫ |h(f)|² S df` over a flat density of `level` by Simpson's rule.
fn integral([low, high]: [f64; 2], level: f64, h: impl Fn(f64) -> Complex<f64>) -> f64 {
    let parts = 20_000;
    let width = (high - low) / f64::from(parts);
    let weight = |k: i32| if k == 0 || k == parts { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
    let value = |k: i32| h(low + f64::from(k) * width).norm_sqr();
    (0..=parts).map(|k| weight(k) * value(k)).sum::<f64>() * width / 3.0 * level
}

/// Asserts that a closed form is within the 95 % confidence interval of the mean over the seeds.
#[track_caller]
fn assert_within(what: &str, values: &[f64], exact: f64, widest: f64) {
    let spread = SampleStatistics::of(values).expect("there are seeds");
    let [low, high] = [spread.confidence_low, spread.confidence_high].map(value);
    assert!(low < exact && exact < high, "{what}: {exact:e} is not from {low:e} to {high:e}");
    assert!(high - low < 2.0 * widest * exact, "{what}: from {low:e} to {high:e} is too wide for {exact:e}");
}

/// Twenty seeds.
fn seeds() -> Vec<u64> {
    (1..=20).collect()
}

#[test]
fn the_random_response_of_the_linear_beam_is_the_spectral_integral() {
    let (band, level) = ([120.0, 400.0], 0.5);
    let scene = |seed| {
        let excitation = random(&[[band[0], level], [band[1], level]], 512, seed);
        beam(2, excitation, [0.4, 1.2])
    };
    let (base, model) = scene(0);
    let modes = BumpStopModes::new(&model.parameters, None);
    let resistance = base.load.resistance_ohm();
    let damping_ratio = model.parameters.damping_ratio;
    let capacitance = modes.capacitance;
    // Angular frequency, participation of the base, coupling, displacement of the tip.
    let modes: Vec<[f64; 4]> = modes
        .beam
        .iter()
        .map(|mode| [mode.angular_frequency, mode.participation, mode.coupling, mode.at_tip])
        .collect();
    // With `D = ω_r² − ω² + 2jζω_rω`: `q_r = −(γ_r a + g_r V)/D_r`, `V (1/R + jωC) = Σ g_r jω q_r`.
    let receptance = |own: f64, omega: f64| {
        Complex::new(own * own - omega * omega, 2.0 * damping_ratio * own * omega).inv()
    };
    let voltage = |frequency: f64| {
        let omega = TAU * frequency;
        let turn = Complex::new(0.0, omega);
        let (mut driven, mut back) = (Complex::new(0.0, 0.0), turn * capacitance + resistance.recip());
        for [own, participation, coupling, _] in &modes {
            let velocity = turn * receptance(*own, omega) * *coupling;
            driven -= velocity * *participation;
            back += velocity * *coupling;
        }
        driven / back
    };
    let tip = |frequency: f64| {
        let volts = voltage(frequency);
        let of = |[own, participation, coupling, at_tip]: &[f64; 4]| {
            -(volts * *coupling + *participation) * receptance(*own, TAU * frequency) * *at_tip
        };
        modes.iter().map(of).sum::<Complex<f64>>()
    };
    let runs = on_all_cores(&seeds(), |seed| {
        let options = Options { step_s: Some(5e-5), trace_every_s: Some(2e-4), ..Options::default() };
        outcome(&scene(*seed).0, &options)
    });
    let powers: Vec<f64> = runs.iter().map(|run| value(run.mean_power_w)).collect();
    assert_within("mean power", &powers, integral(band, level, voltage) / resistance, 0.25);
    let squares: Vec<f64> = runs
        .iter()
        .map(|run| {
            let rows = &run.trace.as_ref().expect("a trace").rows;
            let late: Vec<f64> = rows.iter().filter(|row| row[0] >= 0.4).map(|row| row[1] * row[1]).collect();
            late.iter().sum::<f64>() / late.len() as f64
        })
        .collect();
    assert_within("mean square of the tip", &squares, integral(band, level, tip), 0.25);
}

#[test]
fn the_random_power_of_the_linear_triboelectric_oscillator_is_the_spectral_integral() {
    let (band, level, damping_ratio) = ([5.0, 60.0], 1e-5, 0.05);
    let scene = |seed| {
        contact_separation(|scene, model| {
            model.parameters.damping_ratio = damping_ratio;
            model.parameters.force_law = ForceLaw::None;
            model.parameters.parasitic_capacitance_f = 0.0;
            scene.excitation = random(&[[band[0], level], [band[1], level]], 256, seed);
            scene.run = RunSpan { duration_s: 5.0, settle_s: 1.0 };
        })
    };
    let base = scene(0);
    let parameters = base.contact_separation().expect("the scene").parameters;
    let own = (parameters.stiffness_n_per_m / parameters.mass_kg).sqrt();
    let (gap, thin) =
        (parameters.initial_gap_m, parameters.dielectric_thickness_m / parameters.relative_permittivity);
    let vacuum = model_core::part::VACUUM_PERMITTIVITY;
    let capacitance = vacuum * parameters.electrode_area_m2 / (thin + gap);
    // The motions are a thousandth of the gap: about it `V = β u − q/C`, and `q' = V/R`.
    let beta = parameters.charge_density_c_per_m2 / vacuum * thin / (thin + gap);
    let resistance = base.load.resistance_ohm();
    let displacement = |frequency: f64| {
        let omega = TAU * frequency;
        -Complex::new(own * own - omega * omega, 2.0 * damping_ratio * own * omega).inv()
    };
    let voltage = |frequency: f64| {
        let lag = Complex::new(0.0, TAU * frequency * resistance * capacitance);
        displacement(frequency) * beta * lag / (lag + 1.0)
    };
    let exact = integral(band, level, voltage) / resistance;
    for (precision, options) in [("f64", adaptive(1e-6)), ("f32", single(adaptive(1e-3)))] {
        let powers = on_all_cores(&seeds(), |seed| value(outcome(&scene(*seed), &options).mean_power_w));
        assert_within(precision, &powers, exact, 0.15);
    }
}

/// Displacement under `x'' + 2ζω x' + ω² x = sin pt` from rest at `t = 0`; zero before.
fn under_sine([own, damping_ratio]: [f64; 2], driven: f64, t: f64) -> f64 {
    if t <= 0.0 {
        return 0.0;
    }
    let decay = damping_ratio * own;
    let damped = (own * own - decay * decay).sqrt();
    let (stiff, lossy) = (own * own - driven * driven, 2.0 * decay * driven);
    let scale = (stiff * stiff + lossy * lossy).recip();
    let (from, rate) = (-scale * lossy, scale * stiff * driven);
    let (c, s) = (-from, (-rate - decay * from) / damped);
    let steady = scale * (stiff * (driven * t).sin() - lossy * (driven * t).cos());
    steady + (-decay * t).exp() * (c * (damped * t).cos() + s * (damped * t).sin())
}

/// The largest error of the position at the ends of runs, over the largest position; `exact` is a function of time.
fn position_error(scene: &Scene, options: &Options, times: &[f64], exact: impl Fn(f64) -> f64) -> f64 {
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    for time in times {
        // The run ends just after the row at this time; between the ends of steps a trace interpolates.
        let run = RunSpan { duration_s: time * (1.0 + 1e-9), settle_s: 0.0 };
        let options = Options { trace_every_s: Some(*time), ..*options };
        let trace = outcome(&Scene { run, ..scene.clone() }, &options).trace.expect("a trace was asked for");
        let last = trace.rows.last().expect("a row");
        assert_close("time", last[0], *time, 1e-12);
        error = error.max((last[1] - exact(*time)).abs());
        largest = largest.max(exact(*time).abs());
    }
    error / largest
}

#[test]
fn a_half_sine_shock_has_the_exact_response_of_an_oscillator_and_of_the_beam() {
    // The mass over the dielectric, without charge.
    for duration in [4e-3, 11e-3, 60e-3] {
        let start = 0.02;
        let scene = contact_separation(|scene, model| {
            model.parameters.charge_density_c_per_m2 = 0.0;
            scene.excitation = shock(5.0, duration, start);
        });
        let parameters = scene.contact_separation().expect("the scene").parameters;
        let own = [(parameters.stiffness_n_per_m / parameters.mass_kg).sqrt(), parameters.damping_ratio];
        let exact = |t: f64| {
            let (after, driven) = (t - start, PI / duration);
            let both = under_sine(own, driven, after) + under_sine(own, driven, after - duration);
            parameters.initial_gap_m - 5.0 * both
        };
        // During the shock, at its end, and after it.
        let times = [start + 0.3 * duration, start + 0.77 * duration, start + duration, 0.095, 0.21];
        for (options, bound) in [(adaptive(1e-6), 1e-9), (single(adaptive(1e-3)), 2e-6), (reference(), 1e-9)]
        {
            let error = position_error(&scene, &options, &times, exact);
            assert!(error < bound, "{duration} s: {error:e}");
        }
    }
    // One mode of the beam with its terminals short-circuited. Its steps see the line with the mean and the moment of the
    // base acceleration, across the ends of the shock too: what is left is of third order. At 1 µs it is below what the
    // rounding of the times to ticks of 3.6 ps does.
    for (duration, in_long_steps) in [(50e-6, 1e-5), (0.5e-3, 1e-8), (2.2e-3, 1e-9)] {
        let start = 1e-3;
        let (mut scene, model) = beam(1, shock(100.0, duration, start), [0.0, 0.06]);
        scene.load = resistor(0.0);
        let modes = BumpStopModes::new(&model.parameters, None);
        let mode = &modes.beam[0];
        let own = [mode.angular_frequency, model.parameters.damping_ratio];
        let exact = |t: f64| {
            let (after, driven) = (t - start, PI / duration);
            let both = under_sine(own, driven, after) + under_sine(own, driven, after - duration);
            -100.0 * mode.participation * mode.at_tip * both
        };
        let times = [start + 0.3 * duration, start + 0.77 * duration, start + duration, 5.1e-3, 21e-3];
        for (options, bound) in [(fixed(1e-5), in_long_steps), (fixed(1e-6), 3e-9), (reference(), 1e-9)] {
            let error = position_error(&scene, &options, &times, exact);
            assert!(error < bound, "{duration} s, {:?}: {error:e}", options.step_s);
        }
    }
}

/// Each new kind of excitation, for a natural frequency in Hz and an amplitude in m/s².
fn kinds(natural_hz: f64, amplitude_m_per_s2: f64) -> Vec<(&'static str, Excitation)> {
    let shape = BurstShape::Cycles { frequency_hz: natural_hz, cycles: 3 };
    let (start_s, period_s) = (0.1 / natural_hz, Some(7.3 / natural_hz));
    let sweep = |logarithmic, [from, to]: [f64; 2]| {
        Excitation::Sweep(Sweep {
            amplitude_m_per_s2,
            from_hz: from * natural_hz,
            to_hz: to * natural_hz,
            sweep_s: 12.0 / natural_hz,
            logarithmic,
            phase_rad: 0.3,
        })
    };
    let level = amplitude_m_per_s2 * amplitude_m_per_s2 / natural_hz;
    vec![
        ("bursts", Excitation::Burst(Burst { amplitude_m_per_s2, shape, start_s, period_s })),
        ("shock", shock(3.0 * amplitude_m_per_s2, 0.4 / natural_hz, 0.2 / natural_hz)),
        ("linear sweep", sweep(false, [0.5, 1.5])),
        ("logarithmic sweep", sweep(true, [2.0, 0.6])),
        ("random", random(&[[0.5 * natural_hz, level], [2.0 * natural_hz, 0.5 * level]], 64, 4)),
    ]
}

#[test]
fn every_kind_agrees_with_the_reference() {
    for (name, excitation) in kinds(20.0, 2.0) {
        let scene = contact_separation(|scene, _| {
            scene.excitation = excitation;
            scene.run = RunSpan { duration_s: 1.2, settle_s: 0.3 };
        });
        let exact = outcome(&scene, &reference());
        let found = outcome(&scene, &adaptive(1e-7));
        // A sweep is within 3·10⁻⁶.
        let bound = if name == "random" { 1e-6 } else { 3e-5 };
        assert_close(name, value(found.mean_power_w), value(exact.mean_power_w), bound);
        let found = outcome(&scene, &single(adaptive(1e-4)));
        assert_close(name, value(found.mean_power_w), value(exact.mean_power_w), 2e-3);
    }
    for (name, excitation) in kinds(239.7, 20.0) {
        let (scene, _) = beam(3, excitation, [0.02, 0.1]);
        let exact = outcome(&scene, &reference());
        let found = outcome(&scene, &fixed(2e-6));
        let bound = 3e-5;
        assert_close(name, value(found.mean_power_w), value(exact.mean_power_w), bound);
        let found = outcome(&scene, &single(fixed(1e-5)));
        assert_close(name, value(found.mean_power_w), value(exact.mean_power_w), 2e-3);
    }
}
