//! Simulates the sliding triboelectric harvester: a cantilever with a slider on a charged patch, with stick-slip.
//!
//! `cargo run --release --example sliding`

use model_core::simulate::sliding::{
    Choices, FieldLateralForce, Parameters, PatchFriction, Start, TransferredCharge,
};
use model_core::simulate::*;

fn main() -> Result<(), model_core::Error<f64>> {
    let friction =
        PatchFriction { static_active: 0.35, static_inert: 0.25, kinetic_active: 0.30, kinetic_inert: 0.20 };
    let scene = Parameters {
        beam_length: 0.1_f64, // m
        beam_width: 0.02,     // m
        beam_thickness: 5e-4, // m
        young_modulus: 210e9, // Pa
        density: 7800.0,      // kg/m³
        damping_ratio: 0.0035,
        slider_mass: 8e-3,          // kg
        patch_radius: 0.01,         // m
        dielectric_thickness: 5e-5, // m
        relative_permittivity: 2.0,
        charge_density: 80e-6, // C/m²
        // The field's lateral force takes from the motion what the load receives. The normal force of the transferred
        // charge acts on the friction only.
        choices: Choices::new(Resistor { resistance: 1e8 }, friction)
            .force_law(TransferredCharge)
            .lateral_force(FieldLateralForce),
    }
    .build()?;
    let harvester = Simulation::with_all_powers(scene, ExponentialRadau, Adaptive::new(1e-4)?);
    let vibration = Sine::<f64>::new(3.53, 18.373, 0.0)?; // m/s², Hz, rad
    let mut state = harvester.start(&Start::default(), &vibration)?;
    let mut meter = RunMeter::new();
    let mut ledger = Ledger::open(&harvester.outputs(&state));
    let end = Instant::from_whole_seconds(10);
    harvester.advance(&mut state, &vibration, end, u32::MAX, &mut (&mut meter, &mut ledger))?;
    let report = meter.report();
    println!("{:.3e} W, {:.3} V RMS", meter.mean_power(), report.rms_voltage.unwrap_or(f64::NAN));
    println!("{} times stuck, {:.1} % of the time", report.sticks, 100.0 * report.stick_fraction);
    println!("energy residual {:.1e}", ledger.residual().total().unwrap_or(0.0));
    Ok(())
}
