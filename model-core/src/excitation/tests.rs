use super::test_support::{line_by_quadrature, oscillator, response_by_quadrature};
use super::*;
use crate::clock::seconds_of_ticks;

fn sine(amplitude: f64, frequency: f64, phase: f64) -> Sine<f64> {
    Sine::new(amplitude, frequency, phase).expect("valid")
}

fn tones() -> Tones<f64, 2> {
    let mut tones = Tones::new();
    for tone in [sine(3.0, 700.0, 0.4), sine(2.0, 450.0, 1.0)] {
        tones.push(tone).expect("it fits");
    }
    tones
}

/// 30 000 samples per second.
fn samples() -> Vec<f64> {
    (0..64).map(|n| f64::from(n * n % 17) - 8.0).collect()
}

fn shock() -> Burst<f64> {
    let shock = Burst::half_sine(-4.0, 2.5e-3).expect("valid");
    shock.starting_at(1e-3).and_then(|shock| shock.every(7e-3)).expect("valid")
}

fn random() -> Random<f64, 40> {
    let density = [[30.0, 1.0], [100.0, 1.0], [600.0, 0.05]];
    Random::new(&SpectralDensity::new(&density).expect("valid"), 40, 9).expect("valid")
}

fn sweep(law: SweepLaw, frequencies: [f64; 2]) -> Sweep<f64> {
    Sweep::new(2.0, frequencies, 0.3, law, 0.7).expect("valid")
}

#[test]
fn the_line_over_a_step_has_the_mean_and_the_moment_of_the_acceleration() {
    let (sine, tones, samples) = (sine(3.0, 700.0, 0.4), tones(), samples());
    let trace = Sampled::new(&samples, 3e4, AfterLastSample::Repeat).expect("valid");
    let (shock, random) = (shock(), random());
    let sweeps = [sweep(SweepLaw::Linear, [650.0, 50.0]), sweep(SweepLaw::Logarithmic, [10.0, 700.0])];
    for k in 0..40_u64 {
        // Up to 0.9 radians of the sine, and six samples.
        let (at, ticks) = (Instant::from_ticks(k * 1_234_567_891), 1_300_000 * (k as u32 + 1));
        let step = seconds_of_ticks(ticks);
        let close = |excitation: &dyn Excitation<f64>, pieces, bound: f64| {
            let line = excitation.line(at, ticks, step, excitation.acceleration(at));
            let [mean, tilt] = line_by_quadrature(&excitation, at, ticks, pieces);
            let error = (line.mean - mean).abs().max((line.tilt - tilt).abs());
            assert!(error < bound, "{k}: {line:?} {mean} {tilt}");
            assert!((line.end - excitation.acceleration(at.after(ticks))).abs() < 1e-12);
        };
        close(&sine, 8, 1.2e-4);
        close(&trace, 4000, 2e-3);
        // The line of a sum is that of a parabola.
        close(&tones, 8, 2e-2);
        close(&shock, 4000, 1e-6);
        // The cubic through Gauss's nodes.
        close(&random, 400, 1e-8);
        for sweep in &sweeps {
            close(sweep, 8, 1.2e-4);
        }
    }
    // Steps over several kinks of the shocks.
    for (at, ticks) in [(0, u32::MAX), (300_000_000, 3_000_000_000_u32), (5_000_000_000, 2_500_000_000)] {
        let at = Instant::from_ticks(at);
        let line = shock.line(at, ticks, seconds_of_ticks(ticks), shock.acceleration(at));
        let [mean, tilt] = line_by_quadrature(&shock, at, ticks, 20_000);
        // Each piece is a sine within 4·10⁻⁵.
        assert!((line.mean - mean).abs().max((line.tilt - tilt).abs()) < 1e-4, "{line:?} {mean} {tilt}");
    }
}

#[test]
fn the_response_over_a_step_is_the_integral_over_the_impulse_response() {
    let (sine, samples) = (sine(3.0, 700.0, 0.4), samples());
    let trace = Sampled::new(&samples, 3e3, AfterLastSample::Repeat).expect("valid");
    let (shock, random) = (shock(), random());
    let sweeps = [sweep(SweepLaw::Linear, [650.0, 50.0]), sweep(SweepLaw::Logarithmic, [10.0, 700.0])];
    for oscillator in [oscillator(90.0, 0.02), oscillator(600.0, 0.4)] {
        for k in 0..60_u64 {
            let at = Instant::from_ticks(k * 1_834_567_891);
            let close = |excitation: &dyn Excitation<f64>, amplitude: f64, bound: f64| {
                let smooth = excitation.resolved_ticks().min(excitation.smooth_ticks(at));
                let ticks = smooth.min(crate::clock::ticks_of_seconds(0.9 / 600.0 / std::f64::consts::TAU));
                let kernel = Kernel::new(&oscillator, seconds_of_ticks(ticks));
                let response = excitation.response(at, ticks, &kernel);
                let [displacement, velocity] = response_by_quadrature(&excitation, &oscillator, at, ticks);
                let (step, bound) = (kernel.step, bound * amplitude);
                let error = (response.displacement - displacement).abs() / (step * step);
                assert!(error < bound, "{k}: {response:?} {displacement} {error:e}");
                let error = (response.velocity - velocity).abs() / step;
                assert!(error < bound, "{k}: {response:?} {velocity} {error:e}");
                assert!((response.end - excitation.acceleration(at.after(ticks))).abs() < bound, "{k}");
            };
            close(&sine, 3.0, 1e-9);
            // A step ends up to a few millionths of an interval past a sample.
            close(&trace, 8.0, 2e-5);
            close(&shock, 4.0, 1e-9);
            // The response is that to a cubic through Gauss's nodes.
            close(&random, 10.0, 1e-8);
            for sweep in &sweeps {
                close(sweep, 2.0, 3e-6);
            }
        }
    }
}

#[test]
fn an_excitation_chosen_at_run_time_has_the_bits_of_its_type() {
    let samples = samples();
    let trace = Sampled::new(&samples, 3e3, AfterLastSample::Repeat).expect("valid");
    let pairs: [(&dyn Excitation<f64>, AnyExcitation<'_, f64, 40>); 6] = [
        (&Silence, AnyExcitation::Silence),
        (&sine(3.0, 70.0, 0.4), AnyExcitation::Sine(sine(3.0, 70.0, 0.4))),
        (&trace, AnyExcitation::Sampled(trace)),
        (&shock(), AnyExcitation::Burst(shock())),
        (&random(), AnyExcitation::Random(random())),
        (
            &sweep(SweepLaw::Logarithmic, [10.0, 700.0]),
            AnyExcitation::Sweep(sweep(SweepLaw::Logarithmic, [10.0, 700.0])),
        ),
    ];
    for (typed, chosen) in pairs {
        assert_eq!(typed.resolved_ticks(), chosen.resolved_ticks());
        for tenth in 0..20 {
            let at = Instant::from_ticks(tenth << 35);
            assert_eq!(typed.resolved_ticks_at(at), chosen.resolved_ticks_at(at));
        }
        assert_eq!(typed.angular_frequency().to_bits(), chosen.angular_frequency().to_bits());
        for k in 0..50 {
            let (at, ticks) = (Instant::from_ticks(k * 987_654_321), 20_000_000);
            let step = seconds_of_ticks(ticks);
            let kernel = Kernel::new(&oscillator(90.0, 0.02), step);
            assert_eq!(typed.acceleration(at).to_bits(), chosen.acceleration(at).to_bits());
            assert_eq!(typed.jerk(at).to_bits(), chosen.jerk(at).to_bits());
            assert_eq!(typed.smooth_ticks(at), chosen.smooth_ticks(at));
            assert_eq!(typed.response(at, ticks, &kernel), chosen.response(at, ticks, &kernel));
            let start = typed.acceleration(at);
            assert_eq!(typed.line(at, ticks, step, start), chosen.line(at, ticks, step, start));
        }
    }
}
