//! A random acceleration against the exact sum of its lines.

use core::f64::consts::TAU;

use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::{Excitation, Line, Random, Sine, SpectralDensity, Tones};
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::oscillator::{Kernel, Oscillator, Response};
use model_core::scene::{Harvester, Simulation, bump_stop, contact_separation};

use crate::common::harvesters::{bump_parameters, contact_parameters};

const LINES: usize = 32;

/// The exact sum of the lines, with the steps of the random acceleration.
struct Sum {
    random: Random<f64, LINES>,
    tones: Tones<f64, LINES>,
}

impl Sum {
    fn of(random: Random<f64, LINES>) -> Self {
        let mut tones = Tones::new();
        for line in random.lines() {
            let sine = Sine::new(line.amplitude, line.frequency, line.phase).expect("valid");
            tones.push(sine).expect("as many");
        }
        Self { random, tones }
    }
}

impl Excitation<f64> for Sum {
    fn acceleration(&self, at: Instant) -> f64 {
        self.tones.acceleration(at)
    }

    fn jerk(&self, at: Instant) -> f64 {
        self.tones.jerk(at)
    }

    fn resolved_ticks(&self) -> u32 {
        self.random.resolved_ticks()
    }

    fn angular_frequency(&self) -> f64 {
        self.random.angular_frequency()
    }

    fn smooth_ticks(&self, at: Instant) -> u32 {
        self.random.smooth_ticks(at)
    }

    fn response(&self, at: Instant, ticks: u32, kernel: &Kernel<f64>) -> Response<f64> {
        self.tones.response(at, ticks, kernel)
    }

    /// From the oscillator `x'' = a` without stiffness: its velocity and displacement are the two moments.
    fn line(&self, at: Instant, ticks: u32, step: f64, _start: f64) -> Line<f64> {
        let free = Oscillator { stiffness: 0.0, damping: 0.0, rest: 0.0, base_coupling: 1.0 };
        let response = self.tones.response(at, ticks, &Kernel::new(&free, step));
        let mean = response.velocity / step;
        // `∫ (h − s) a ds`: of the line `mean + tilt (2θ − 1)` it is `h² (mean/2 − tilt/6)`.
        let tilt = 6.0 * (0.5 * mean - response.displacement / (step * step));
        Line { mean, tilt, end: response.end }
    }
}

/// Asserts that the mean power under a random acceleration from 0.7 of a natural frequency in Hz on, of a density in
/// (m/s²)²/Hz, is that under the exact sum of its lines, whatever the end of the band.
fn check<H: Harvester<f64>>(harvester: &H, start: &H::Start, natural: f64, level: f64, seconds: f64) {
    let power = |excitation: &dyn Excitation<f64>| {
        let mut state = harvester.start(start, &excitation).expect("starts");
        let mut meter = PowerMeter::new();
        let until = Instant::from_seconds(seconds).expect("in range");
        harvester.advance(&mut state, &excitation, until, u32::MAX, &mut meter).expect("runs");
        meter.delivered_energy() / seconds
    };
    for top in [1.05, 2.0, 4.0] {
        let points = [[0.7 * natural, level], [top * natural, level]];
        let density = SpectralDensity::new(&points).expect("valid");
        let random = Random::<f64, LINES>::new(&density, LINES as u32, 1).expect("valid");
        let found = power(&random);
        let change = power(&Sum::of(random)) / found - 1.0;
        assert!(found > 0.0 && change.abs() < 2e-6, "{top}: {found:e} {change:e}");
    }
}

#[test]
fn a_random_power_is_that_of_the_exact_sum_of_its_lines() {
    let mut parameters = contact_parameters::<f64>();
    parameters.damping_ratio = 0.02;
    let natural = (parameters.stiffness / parameters.mass).sqrt() / TAU;
    let control = Adaptive::new(1e-5).expect("valid");
    let harvester = Simulation::new(parameters.build().expect("valid"), ExponentialRadau, control);
    check(&harvester, &contact_separation::Start::default(), natural, 2.0, 3.0);
    let scene = bump_parameters::<f64>().build::<3, 2>().expect("valid");
    let natural = scene.open_circuit_angular_frequency(0).expect("a mode") / TAU;
    // A stronger one makes the motion chaotic.
    let harvester = bump_stop::Stepper::new(scene, 2e-6, 20e-6).expect("valid");
    check(&harvester, &bump_stop::Start::default(), natural, 0.01, 0.3);
}
