//! A node corrects the error of its harvester model by the voltage of its storage.
//!
//! The true storage is simulated here in `f64`, in steps of a second by its differential equation for the voltage;
//! the estimator runs in `f32` with one 12-bit reading a minute.

use crate::common::Random;
use model_core::energy::{
    Capacitor, Correction, CorrectionParameters, CorrectionState, Reading, StorageParameters,
};

const BITS: u32 = 12;
const FULL_SCALE: f64 = 5.0;
const CELL: f64 = FULL_SCALE / 4096.0;
const CHARGING: f64 = 0.8;
const DISCHARGING: f64 = 0.9;

/// A node, its harvester and one hour.
#[derive(Debug, Clone, Copy)]
struct Hour {
    capacitance: f64,
    leakage_resistance: f64,
    /// Voltage at the start.
    voltage: f64,
    /// Modelled mean power in watts.
    modelled: f64,
    /// Of how large a part it varies from minute to minute.
    unsteady: f64,
    /// True income over modelled income.
    factor: f64,
    /// What the load uses, as a part of what the true income of each minute would serve.
    used: f64,
    /// Standard deviation of a reading in volts.
    noise: f64,
    seed: u64,
}

/// What became of it: `None` if the storage left the range from 1.8 V to 4.8 V.
#[derive(Debug, Clone, Copy)]
struct Found {
    state: CorrectionState<f32>,
    /// Relative error of the income estimate.
    error: f64,
    /// The same in its own standard deviations.
    in_deviations: f64,
    /// Error of the stored energy in its own standard deviations.
    energy_in_deviations: f64,
}

fn estimator(hour: &Hour) -> Correction<f32> {
    drifting(hour, 0.0)
}

fn drifting(hour: &Hour, gain_drift: f32) -> Correction<f32> {
    let storage = StorageParameters {
        capacitor: Capacitor {
            capacitance: hour.capacitance as f32,
            leakage_resistance: hour.leakage_resistance as f32,
        },
        charging_efficiency: CHARGING as f32,
        discharging_efficiency: DISCHARGING as f32,
        highest_voltage: 4.9,
        lock_out_voltage: 1.7,
        turn_on_voltage: 2.2,
    };
    let storage = storage.build().expect("within bounds");
    let parameters = CorrectionParameters {
        bits: BITS,
        full_scale: FULL_SCALE as f32,
        noise: hour.noise as f32,
        gain_deviation: 1.0,
        gain_drift,
    };
    parameters.build(&storage).expect("within bounds")
}

fn code(voltage: f64) -> u32 {
    (voltage / CELL).round().clamp(0.0, 4095.0) as u32
}

fn run(hour: &Hour) -> Option<Found> {
    let correction = estimator(hour);
    let mut state = correction.start();
    let mut random = Random(hour.seed);
    let mut voltage = hour.voltage;
    let read = |voltage: f64, random: &mut Random| code(voltage + hour.noise * random.normal());
    correction.observe(&mut state, read(voltage, &mut random));
    for _minute in 0..60 {
        let modelled = hour.modelled * (1.0 + hour.unsteady * random.between(-1.0, 1.0));
        let income = hour.factor * modelled * CHARGING;
        let load = hour.used * income * DISCHARGING;
        let power = income - load / DISCHARGING;
        for _second in 0..60 {
            // C V V' = p − V²/R, by the midpoint rule.
            let slope = |v: f64| (power / v - v / hour.leakage_resistance) / hour.capacitance;
            voltage += slope(voltage + 0.5 * slope(voltage));
        }
        if !(1.8..4.8).contains(&voltage) {
            return None;
        }
        correction.predict(&mut state, 60, (modelled * 60.0) as f32, (load * 60.0) as f32);
        correction.observe(&mut state, read(voltage, &mut random));
    }
    let error = f64::from(state.estimate().gain) / hour.factor - 1.0;
    let energy = 0.5 * hour.capacitance * voltage * voltage;
    Some(Found {
        state,
        error,
        in_deviations: error * hour.factor / f64::from(state.estimate().gain_deviation),
        energy_in_deviations: (f64::from(state.estimate().energy) - energy)
            / f64::from(state.estimate().energy_deviation),
    })
}

/// Cells by which the true income alone would move the voltage in an hour.
fn cells(hour: &Hour) -> f64 {
    hour.factor * hour.modelled * CHARGING * 3600.0 / (hour.capacitance * hour.voltage * CELL)
}

#[test]
fn a_harvester_off_by_a_factor_of_two_is_found_within_five_per_cent_in_an_hour() {
    // Capacitance, true income, and the part of it that the load uses: the storage moves by 4 cells or more.
    let nodes = [
        (47e-6, 0.05e-6, 0.0),
        (47e-6, 1e-6, 0.97),
        (100e-6, 2e-6, 1.05),
        (100e-6, 1e-4, 0.999),
        (220e-6, 0.2e-6, 0.3),
        (220e-6, 1e-5, 1.01),
        (470e-6, 1e-3, 1.0005),
        (470e-6, 0.5e-6, 0.5),
        (1e-3, 1e-6, 0.3),
        (1e-3, 1e-3, 0.999),
        (1e-3, 3e-6, 1.3),
        (1e-3, 0.05e-6, 0.9),
        (0.1, 1e-3, 1.05),
    ];
    let mut worst = 0.0_f64;
    for (capacitance, income, used) in nodes {
        for factor in [2.0, 0.5] {
            for (noise, seed) in [(0.0, 1), (0.0, 2), (0.5, 3), (0.5, 4), (1.0, 5)] {
                let hour = Hour {
                    capacitance,
                    leakage_resistance: f64::INFINITY,
                    voltage: if used > 1.0 { 3.4 } else { 2.6 } + CELL * 0.3 * seed as f64,
                    modelled: income / factor,
                    unsteady: 0.5,
                    factor,
                    used,
                    noise: noise * CELL,
                    seed,
                };
                let found = run(&hour).unwrap_or_else(|| panic!("left its range: {hour:?}"));
                assert!(found.error.abs() < 0.05, "{found:?}\n{hour:?} {} cells", cells(&hour));
                assert!(found.state.estimate().income_error < 0.05, "{found:?}\n{hour:?}");
                assert_eq!(found.state.estimate().rejected, 0, "{hour:?}");
                worst = worst.max(found.error.abs());
            }
        }
    }
    println!("largest error {worst:.4}");
}

fn random_hour(random: &mut Random) -> Hour {
    let capacitance = random.between_logarithmic(47e-6, 1e-3);
    let voltage = random.between(2.2, 4.2);
    let factor = random.between_logarithmic(0.5, 2.0);
    // From a tenth of a cell in the hour to a thousand.
    let moves = random.between_logarithmic(0.1, 1000.0);
    let income = moves * capacitance * voltage * CELL / (CHARGING * 3600.0);
    let leakage = random.between_logarithmic(1e6, 1e9);
    Hour {
        capacitance,
        leakage_resistance: leakage,
        voltage,
        modelled: income / factor,
        unsteady: random.unit(),
        factor,
        used: random.between(0.0, 1.2),
        noise: if random.next().is_multiple_of(3) { 0.0 } else { CELL * random.between(0.0, 2.0) },
        seed: random.next(),
    }
}

#[test]
fn the_error_figure_is_honest() {
    let mut random = Random(20_070_401);
    let mut bands = [[0_u32; 5]; 4];
    let mut count = 0;
    while count < 4000 {
        let hour = random_hour(&mut random);
        let Some(found) = run(&hour) else { continue };
        count += 1;
        let band = &mut bands[(cells(&hour).log10().floor() + 1.0).clamp(0.0, 3.0) as usize];
        band[0] += 1;
        band[1] += u32::from(found.in_deviations.abs() < 3.0);
        band[2] += u32::from(found.energy_in_deviations.abs() < 3.0);
        band[3] += u32::from(found.error.abs() < 0.05);
        band[4] += u32::from(found.state.estimate().income_error < 0.05);
    }
    println!("cells in the hour: cases, gain in 3 deviations, energy so, error below 5 %, figure below 5 %");
    for (band, from) in bands.iter().zip(["0.1", "1", "10", "100"]) {
        println!("from {from}: {band:?}");
        let [cases, gain, energy, within, claimed] = band.map(f64::from);
        assert!(cases > 300.0, "{from}: {cases}");
        assert!(gain >= 0.98 * cases && energy >= 0.98 * cases, "from {from} cells: {band:?}");
        // What is claimed is there in as many cases.
        assert!(within >= 0.9 * claimed, "from {from} cells: {band:?}");
    }
    // Below a cell little can be known, and is not claimed; above a hundred cells everything.
    assert!(bands[0][4] == 0 && bands[3][4] * 100 > bands[3][0] * 99);
}

#[test]
fn impossible_readings_are_counted_and_change_nothing() {
    let hour = Hour {
        capacitance: 100e-6,
        leakage_resistance: 1e9,
        voltage: 3.0,
        modelled: 1e-6,
        unsteady: 0.0,
        factor: 1.0,
        used: 0.2,
        noise: 0.0,
        seed: 1,
    };
    let correction = estimator(&hour);
    let mut state = correction.start();
    assert_eq!(correction.observe(&mut state, code(3.0)), Reading::Used);
    correction.predict(&mut state, 60, 60e-6, 12e-6);
    let before = state;
    assert_eq!(correction.observe(&mut state, 4095), Reading::Saturated);
    assert_eq!(correction.observe(&mut state, 70_000), Reading::Saturated);
    assert_eq!(correction.observe(&mut state, 0), Reading::Rejected);
    assert_eq!(correction.observe(&mut state, code(1.0)), Reading::Rejected);
    assert_eq!((state.estimate().saturated, state.estimate().rejected, state.estimate().used), (2, 2, 1));
    assert_eq!(
        (state.estimate().gain, state.estimate().energy),
        (before.estimate().gain, before.estimate().energy)
    );
    assert_eq!(state.estimate().gain_deviation, before.estimate().gain_deviation);
}

#[test]
fn a_full_store_teaches_nothing_and_spoils_nothing() {
    // An hour below full, at twice the modelled income; six hours full; and an hour on the way down again.
    let hour = Hour {
        capacitance: 220e-6,
        leakage_resistance: f64::INFINITY,
        voltage: 2.5,
        modelled: 0.2e-6,
        unsteady: 0.4,
        factor: 2.0,
        used: 0.3,
        noise: 0.3 * CELL,
        seed: 9,
    };
    let mut state = run(&hour).expect("in range").state;
    let (gain, deviation) = (state.estimate().gain, state.estimate().gain_deviation);
    let correction = estimator(&hour);
    let capacity = 0.5 * 220e-6 * 4.9 * 4.9;
    let mut random = Random(5);
    let (mut energy, mut filled) = (f64::from(state.estimate().energy), false);
    for minute in 0..8 * 60 {
        let income = 2.0 * 0.2e-6 * CHARGING * 60.0;
        let load = if minute < 7 * 60 { 0.0 } else { 1.5 * income };
        energy = (energy + income - load).min(capacity);
        filled |= energy == capacity;
        correction.predict(&mut state, 60, 0.2e-6 * 60.0, (load * DISCHARGING) as f32);
        let voltage = (2.0 * energy / 220e-6).sqrt() + hour.noise * random.normal();
        correction.observe(&mut state, code(voltage));
    }
    assert_eq!((state.estimate().rejected, filled), (0, true));
    assert!(
        (gain - 2.0).abs() < 0.05
            && (state.estimate().gain - 2.0).abs() < 3.0 * state.estimate().gain_deviation
    );
    assert!(state.estimate().gain_deviation <= deviation);
}

#[test]
fn a_gain_that_changes_is_followed_where_a_drift_is_allowed_for() {
    let hour = Hour {
        capacitance: 470e-6,
        leakage_resistance: f64::INFINITY,
        voltage: 3.0,
        modelled: 2e-6,
        unsteady: 0.0,
        factor: 1.0,
        used: 1.0,
        noise: 0.0,
        seed: 1,
    };
    let after_the_change = |gain_drift: f32| {
        let correction = drifting(&hour, gain_drift);
        let mut state = correction.start();
        let mut energy = 0.5 * 470e-6 * 9.0_f64;
        for minute in 0..240 {
            // Half as much again in the course of the fourth hour; the load uses all of it.
            let factor = 1.0 + 0.5 * f64::from((minute - 180).max(0)) / 60.0;
            let income = factor * 2e-6 * CHARGING * 60.0;
            let load = if minute % 2 == 0 { 0.5 * income } else { 1.5 * income };
            energy += income - load;
            correction.predict(&mut state, 60, 120e-6, (load * DISCHARGING) as f32);
            correction.observe(&mut state, code((2.0 * energy / 470e-6).sqrt()));
        }
        state
    };
    let (fixed, followed) = (after_the_change(0.0), after_the_change(0.2));
    assert!(
        (followed.estimate().gain - 1.5).abs() < 3.0 * followed.estimate().gain_deviation,
        "{followed:?}"
    );
    assert!(
        (followed.estimate().gain - 1.5).abs() < 0.05 && followed.estimate().rejected == 0,
        "{followed:?}"
    );
    // Where none is, readings are refused sooner or later, until the model is given up.
    assert!(fixed.estimate().rejected > 0 || (fixed.estimate().gain - 1.5).abs() > 0.1, "{fixed:?}");
}

#[test]
fn a_model_that_is_far_off_is_given_up_and_found_anew() {
    // The gain has settled at 1; then the storage is found far below, again and again: someone has exchanged it.
    let hour = Hour {
        capacitance: 1e-3,
        leakage_resistance: f64::INFINITY,
        voltage: 3.0,
        modelled: 0.7e-6,
        unsteady: 0.3,
        factor: 1.0,
        used: 0.0,
        noise: 0.0,
        seed: 1,
    };
    let mut state = run(&hour).expect("in range").state;
    assert!(state.estimate().gain_deviation < 0.05);
    let correction = estimator(&hour);
    let mut voltage = 2.0_f64;
    for _ in 0..60 {
        voltage = (voltage * voltage + 2.0 * 0.7e-6 * 0.8 * 3.0 * 60.0 / 1e-3).sqrt();
        correction.predict(&mut state, 60, 0.7e-6 * 60.0, 0.0);
        correction.observe(&mut state, code(voltage));
    }
    assert_eq!(state.estimate().rejected, 10);
    assert!((state.estimate().gain - 3.0).abs() < 0.05, "{state:?}");
}

#[test]
fn a_reading_far_from_the_expected_energy_departs_by_its_deviations() {
    let correction = estimator(&Hour {
        capacitance: 100e-6,
        leakage_resistance: 1e12,
        voltage: 3.0,
        modelled: 0.0,
        unsteady: 0.0,
        factor: 1.0,
        used: 0.0,
        noise: 0.5 * CELL,
        seed: 1,
    });
    let mut state = correction.start();
    let code = |volts: f64| (volts / CELL).round() as u32;
    assert_eq!(correction.departure(&state, code(3.0)), 0.0, "nothing is expected before the first reading");
    correction.observe(&mut state, code(3.0));
    assert_eq!(correction.departure(&state, code(3.0)), 0.0);
    // Energies in units of C V Δ: the state has a variance of 1/12 + 1/4, the reading of 1/4.
    for cells in [4.0_f64, 10.0, -10.0] {
        let expected = (cells.abs() - 0.5) / (1.0_f64 / 12.0 + 0.25 + 0.25).sqrt();
        let found = f64::from(correction.departure(&state, code(3.0 + cells * CELL)));
        assert!((found - expected).abs() < 0.02 * expected, "{cells}: {found} {expected}");
    }
}
