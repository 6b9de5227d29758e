//! Estimates the power from the samples of an accelerometer, with its uncertainty and a power-down between samples.
//!
//! `cargo run --example estimator`

use model_core::energy::Estimator;
use model_core::energy::estimator::{Interpolation, SampleFormat, Settings};
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::part::load::Resistor;
use model_core::part::restitution::ConstantRestitution;
use model_core::scene::Simulation;
use model_core::scene::contact_separation::{Choices, Parameters};

/// Raw count of a 16-bit accelerometer with a range of ± 2 g, 400 a second, for 0.2 g at 20.5 Hz: 41 periods in 800. Half of
/// gravity is on its axis, which is tilted by 60°.
fn sample(n: u32) -> i16 {
    (8192.0 + 3277.0 * (core::f32::consts::TAU * (41 * n % 800) as f32 / 800.0).sin()) as i16
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Parameters {
        mass: 5e-3_f32,             // kg
        stiffness: 80.0,            // N/m
        damping_ratio: 0.005,       // of critical
        initial_gap: 3e-3,          // m
        electrode_area: 4e-4,       // m²
        dielectric_thickness: 5e-5, // m
        relative_permittivity: 2.0,
        charge_density: 50e-6, // C/m²
        choices: Choices::new(Resistor { resistance: 1e8 }, ConstantRestitution { coefficient: 0.75 }),
    }
    .build()?;
    let harvester = Simulation::new(scene, ExponentialRadau, Adaptive::new(5e-2)?);
    let settings = Settings {
        rate: 400.0, // samples per second
        format: SampleFormat::counts(9.81 / 16_384.0, 32_767),
        longest_gap: 4,        // samples
        settling_seconds: 3.0, // s: two decay times
        rate_tolerance: 0.05,  // by the data sheet
        jitter: 0.0,           // of an interval
        interpolation: Interpolation::DroopCompensated,
        bias_seconds: Some(2.0), // s: removes gravity; with `None` it would count as acceleration
    };
    let mut estimator = Estimator::new(harvester, settings)?;
    // As measured against the clock of the node: with 5 % the power is known to a factor of some hundred.
    estimator.set_rate(400.0, 2e-4)?;
    let mut flash = [0; 400];
    for n in 0..4000 {
        // At most 100 attempted steps per call, because firmware has deadlines.
        let mut progress = estimator.push_count(sample(n), 100)?;
        while !progress.finished {
            progress = estimator.resume(100)?;
        }
        if n == 1999 {
            // Power down and up: the run continues with the same bits.
            estimator.save(&mut flash)?;
            estimator = Estimator::new(harvester, settings)?;
            estimator.restore(&flash)?;
        }
    }
    let estimate = estimator.estimate();
    println!("{:.3e} W over {} s", estimate.mean_power, estimate.seconds);
    if let Some(bias) = estimate.bias {
        // Far from 0 with gravity on the axis.
        println!("mean of the samples {bias:.2} m/s²");
    }
    match estimate.uncertainty.relative {
        Some(relative) => println!("relative uncertainty {relative:.1e}"),
        None => println!("uncertainty unknown"),
    }
    Ok(())
}
