//! Simulates a piezoelectric cantilever that hits a stop: power, RMS voltage, contacts, energy ledger.
//!
//! `cargo run --release --example bump_stop`

use model_core::simulate::bump_stop::{Choices, Parameters, ResidualFlexibility, Start, Stepper, Stop};
use model_core::simulate::*;

fn main() -> Result<(), model_core::Error<f64>> {
    let stop = Stop {
        length: 0.02,            // m
        section: 4e-6,           // m²
        young_modulus: 70e9,     // Pa
        density: 2700.0,         // kg/m³
        position: 0.05,          // m from the clamp
        gap: 10e-6,              // m
        contact_compliance: 0.0, // m/N
        contact: ResidualFlexibility,
    };
    // Four beam modes, one rod mode.
    let scene = Parameters {
        beam_length: 0.05_f64, // m
        beam_width: 0.01,      // m
        substrate: Layer { thickness: 5e-4, young_modulus: 200e9, density: 7850.0 },
        piezo: Layer { thickness: 5e-4, young_modulus: 66e9, density: 7800.0 },
        piezo_d31: -190e-12,          // m/V
        piezo_permittivity: 15.93e-9, // F/m
        damping_ratio: 0.01,
        choices: Choices::new(Resistor { resistance: 1e6 }).stop(stop),
    }
    .build::<4, 1>()?;
    // Steps of 1 µs near contact and of 20 µs in flight.
    let harvester = Stepper::with_all_powers(scene, 1e-6, 2e-5)?;
    let vibration = Sine::<f64>::new(20.0, 220.0, 0.0)?; // m/s², Hz, rad
    let mut state = harvester.start(&Start::default(), &vibration)?;
    let mut meter = RunMeter::new();
    let mut ledger = Ledger::open(&harvester.outputs(&state));
    let end = Instant::from_whole_seconds(1);
    harvester.advance(&mut state, &vibration, end, u32::MAX, &mut (&mut meter, &mut ledger))?;
    let report = meter.report();
    println!("{:.3e} W, {:.3} V RMS", meter.mean_power(), report.rms_voltage.unwrap_or(f64::NAN));
    println!("{} contacts, {:.1} % of the time", report.contacts, 100.0 * report.contact_fraction);
    println!("energy residual {:.1e}", ledger.residual().total().unwrap_or(0.0));
    Ok(())
}
