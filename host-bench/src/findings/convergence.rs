//! Modes, steps and storage of the second paper: findings 18 to 20.

use super::runs::{Loader, NEAR_RESONANCE, OFF_RESONANCE, each_of, value};
use super::statistics::{largest, smallest, spread};
use super::{Bound::*, Measured, check};
use crate::figures::bump_stop::convergence::{self as figures, ConvergenceRun};
use crate::method::{Failure, Options};
use crate::run::{run_scene, try_each};
use crate::scene_file::{Contact, Scene};

/// Numbers of modes of beam and rod.
const MODES: [(usize, usize); 5] = [(4, 1), (6, 2), (8, 3), (10, 10), (14, 6)];
/// The first with which the results have converged.
const CONVERGED: usize = 1;
/// Steps near contact in s.
const STEPS_S: [f64; 3] = [1e-6, 5e-7, 2.5e-7];
/// Step in free flight in s.
const LONG_STEP_S: f64 = 2e-5;

/// Runs a scene with numbers of modes of beam and rod and a step near contact in s.
fn found(
    loader: Loader<'_>,
    name: &str,
    modes: (usize, usize),
    step_s: f64,
) -> Result<ConvergenceRun, Failure> {
    let scene = loader.scene(name, &[])?;
    let options = Options { step_s: Some(step_s), long_step_s: Some(LONG_STEP_S), ..Options::default() };
    figures::found(&scene, modes, Contact::ResidualFlexibility, scene.run, &options)
}

/// Largest less smallest value over the smallest.
fn relative_spread(found: &[ConvergenceRun], of: fn(&ConvergenceRun) -> f64) -> f64 {
    spread(found.iter().map(of)) / smallest(found.iter().map(of))
}

/// Findings 18 and 19.
pub(super) fn measure(loader: Loader<'_>) -> Result<Measured, Failure> {
    let [tip, mid, _] = OFF_RESONANCE;
    let [near_tip, ..] = NEAR_RESONANCE;
    let [step_s, finer @ ..] = STEPS_S;
    let of_modes = |name: &'static str| MODES.map(|modes| (name, modes, step_s));
    // The longest runs first.
    let steps = finer.into_iter().rev().map(|step_s| (tip, MODES[CONVERGED], step_s));
    let cases: Vec<_> = steps
        .chain(of_modes(near_tip).into_iter().take(4))
        .chain(of_modes(tip))
        .chain(of_modes(mid))
        .collect();
    let mut all = try_each(&cases, |(name, modes, step_s)| found(loader, name, *modes, *step_s))?;
    let mid = all.split_off(all.len() - MODES.len());
    let tip = all.split_off(all.len() - MODES.len());
    let near = all.split_off(finer.len());
    let mut steps = all;
    let voltage = |found: &ConvergenceRun| found.rms_voltage;
    let force = |found: &ConvergenceRun| found.mean_force;
    let spreads =
        |of: fn(&ConvergenceRun) -> f64| [&tip, &mid].map(|found| relative_spread(&found[CONVERGED..], of));
    let contacts = |found: &[ConvergenceRun]| {
        let counts = || found.iter().map(|found| found.contacts_per_period);
        largest(counts()) / smallest(counts())
    };
    let (modes_voltage, modes_force) = (spreads(voltage), spreads(force));
    let contacts = contacts(&tip[CONVERGED..]);
    let four = &tip[..near.len()];
    let sensitivity = relative_spread(&near, voltage) / relative_spread(four, voltage);
    let listed = tip.iter().map(voltage).collect::<Vec<_>>();
    steps.extend(tip.into_iter().skip(CONVERGED).take(1));
    Ok(vec![
        check("18", "spread of the RMS voltage, 6 to 14 modes, tip and mid-span", modes_voltage, Below(5e-3)),
        check("18", "spread of the mean force", modes_force, Below(2e-3)),
        check(
            "18",
            "spread of the RMS voltage, steps of 1, 0.5, 0.25 µs",
            [relative_spread(&steps, voltage)],
            Below(5e-3),
        ),
        check("18", "contacts per period, most / fewest", [contacts], Above(1.3)),
        check("18", "RMS voltage with 4, 6, 8, 10, 14 modes [V]", listed, Reported),
        check("19", "spread over 4 to 10 modes, 220 Hz / 44 Hz", [sensitivity], Above(3.0)),
    ])
}

/// Finding 20.
pub(super) fn measure_storage(loader: Loader<'_>) -> Result<Measured, Failure> {
    let charging = loader.scene("bump-stop-below-resonance-charging", &[])?;
    let stored = each_of(OFF_RESONANCE, |name| {
        let scene = Scene { load: charging.load, run: charging.run, ..loader.scene(name, &[])? };
        let outcome = run_scene(&scene, &Options::default())?;
        let store =
            outcome.store.ok_or_else(|| Failure::of_file(&scene, "load.kind must be \"rectified-store\""))?;
        Ok([value(store.store_voltage_v), 1e6 * value(store.stored_energy_j)])
    })?;
    let voltages = stored.map(|[voltage, _]| voltage);
    let [tip, mid, none] = voltages;
    Ok(vec![
        check(
            "20",
            "voltage after 5 s, mid-span / tip, none / mid-span",
            [mid / tip, none / mid],
            Above(1.15),
        ),
        check("20", "voltage [V]: tip, mid-span, none", voltages, Reported),
        check("20", "energy [µJ]: tip, mid-span, none", stored.map(|[_, energy]| energy), Reported),
    ])
}
