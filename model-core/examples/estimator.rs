//! A node that steps its harvester's model along the samples of an accelerometer that always runs: estimated income with its
//! uncertainty, the energy of its storage, an action when it can be afforded, and a power-down between samples.
//!
//! It spends on computing hundreds of times what a harvester of a few µW gives: a node that lives on its harvester is that of
//! `examples/node.rs`.
//!
//! `cargo run --example estimator`

use model_core::simulate::contact_separation::{Choices, GapField, Parameters};
use model_core::{Error, budget::*, estimate::*, simulate::*};

/// A ceramic capacitor behind the bridge, from which the node runs straight.
const CAPACITANCE: f32 = 22e-6; // F
const VOLTAGE: f32 = 2.6; // V, at power-up

/// Raw count of a 16-bit accelerometer with a range of ± 2 g, 400 a second, for 0.2 g at 20.5 Hz: 41 periods in 800. Half of
/// gravity is on its axis, which is tilted by 60°.
fn sample(n: u32) -> i16 {
    (8192.0 + 3277.0 * (core::f32::consts::TAU * (41 * n % 800) as f32 / 800.0).sin()) as i16
}

/// The harvester behind a full bridge. The budget keeps the books of leakage and draw, so that the storage has none here.
fn harvester() -> Result<impl Harvester<f32>, Error> {
    let restitution = ConstantRestitution { coefficient: 0.75 };
    let scene = Parameters {
        mass: 5e-3_f32,             // kg
        stiffness: 80.0,            // N/m
        damping_ratio: 0.005,       // of critical
        initial_gap: 3e-3,          // m
        electrode_area: 4e-4,       // m²
        dielectric_thickness: 5e-5, // m
        relative_permittivity: 2.0,
        charge_density: 50e-6, // C/m²
        // The paper's force creates energy, which a node would book and never receive.
        choices: Choices { force_law: GapField, ..Choices::new(OpenCircuit, restitution) },
    }
    .build()?;
    let capacitor = Capacitor { capacitance: CAPACITANCE, leakage_resistance: f32::INFINITY };
    let storage = StorageCapacitor { capacitor, initial_voltage: VOLTAGE, draw: NoDraw };
    let scene = Rectified::new(scene, FullBridge { diode_drop: 0.3, storage })?;
    Ok(Simulation::new(scene, ExponentialRadau, Adaptive::new(5e-2)?))
}

/// The accelerometer, and how its samples are taken.
fn settings() -> Settings<f32> {
    Settings {
        rate: 400.0, // samples per second
        format: SampleFormat::counts(9.81 / 16_384.0, 32_767),
        longest_gap: 4,        // samples
        settling_seconds: 3.0, // s: two decay times
        rate_tolerance: 2e-4,  // as measured against the clock of the node; by the data sheet 0.05
        jitter: 0.0,           // of an interval
        interpolation: Interpolation::DroopCompensated,
        bias_seconds: Some(2.0), // s: removes gravity; with `None` it would count as acceleration
    }
}

fn main() -> Result<(), Error> {
    let settings = settings();
    let mut estimator = Estimator::new(harvester()?, settings)?;
    let budget = BudgetParameters {
        storage: StorageParameters {
            capacitor: Capacitor { capacitance: CAPACITANCE, leakage_resistance: 100e6 },
            charging_efficiency: 1.0, // the diodes' loss is in the model
            discharging_efficiency: 1.0,
            highest_voltage: 4.2,
            lock_out_voltage: 1.9,
            turn_on_voltage: 2.2,
        },
        income: IncomeParameters { time_constant: 600.0, day_weight: 0.5 },
        standing_power: 0.3e-6, // W
    }
    .build::<24>()?;
    let mut books = budget.start(0);
    budget.correct_by_voltage(&mut books, VOLTAGE, 2e-3);
    let measure = Action::new("measure", 4e-6, 5e-3)?;
    let mut flash = [[0xff_u8; 1024]; 2];
    for second in 1..=60 {
        // What leaked and what was spent is gone from the harvester's storage too.
        estimator.set_storage_voltage(budget.storage().voltage(books.energy()));
        for n in 400 * (second - 1)..400 * second {
            // At most 100 attempted steps per call, because firmware has deadlines.
            let mut progress = estimator.push_count(sample(n), 100)?;
            while !progress.finished {
                progress = estimator.resume(100)?;
            }
        }
        let estimate = estimator.estimate();
        estimator.clear();
        // An income of unknown uncertainty counts as no income.
        let uncertainty = estimate.energy * estimate.uncertainty.relative.unwrap_or(1.0);
        budget.update(&mut books, 1, estimate.energy, 0.0);
        books.raise_uncertainty(uncertainty);
        let runs = second % 10 == 0 && budget.can_run_now(&books, &measure, second);
        if runs {
            budget.spend(&mut books, measure.energy());
        }
        if second % 10 == 0 {
            let [income, stored] = [estimate.mean_power, books.energy()].map(|value| 1e6 * value);
            let uncertain = 1e6 * uncertainty;
            println!("{second} s: {income:.2} ± {uncertain:.2} uW, {stored:.1} uJ, measured: {runs}");
        }
        if second == 30 {
            // Power down and up: the run continues with the same bits.
            save_image(&(&estimator, &budget), &(*estimator.state(), books), 1, &mut flash[0])?;
            estimator = Estimator::new(harvester()?, settings)?;
            let image = newest_image(&(&estimator, &budget), [&flash[0], &flash[1]])?;
            estimator.set_state(image.state.0);
            books = image.state.1;
        }
    }
    Ok(())
}
