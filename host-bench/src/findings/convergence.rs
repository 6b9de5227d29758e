//! Modes and steps of the second paper: findings 18 and 19.

use super::scenes::{NEAR_RESONANCE, PAPER, bump_stop, each, scene, value};
use super::statistics::{largest, smallest, spread};
use super::{Bound, Check, Measured};
use crate::method::{Failure, Options};
use crate::run::run_scene;

/// Numbers of modes of beam and rod.
const MODES: [[&str; 2]; 5] = [["4", "1"], ["6", "2"], ["8", "3"], ["10", "10"], ["14", "6"]];
/// The first with which the results have converged.
const CONVERGED: usize = 1;
/// Steps near contact in s.
const STEPS_S: [f64; 3] = [1e-6, 5e-7, 2.5e-7];
/// Step in free flight in s.
const LONG_STEP_S: f64 = 2e-5;

/// The numbers of a run.
struct Found {
    rms_voltage_v: f64,
    mean_force_n: f64,
    contacts_per_period: f64,
}

/// Runs a scene with numbers of modes of beam and rod and a step near contact in s.
fn found(name: &str, [beam, rod]: [&str; 2], step_s: f64) -> Result<Found, Failure> {
    let scene = scene(name, &[("parameters.beam_modes", beam), ("stop.rod_modes", rod)])?;
    let options = Options { step_s: Some(step_s), long_step_s: Some(LONG_STEP_S), ..Options::default() };
    let outcome = run_scene(&scene, &options)?;
    let contacts = bump_stop(&outcome)?;
    Ok(Found {
        rms_voltage_v: value(outcome.rms_voltage_v),
        mean_force_n: value(contacts.mean_force_n),
        contacts_per_period: value(contacts.contacts_per_period),
    })
}

/// Largest less smallest value over the smallest.
fn relative_spread(found: &[Found], of: fn(&Found) -> f64) -> f64 {
    spread(found.iter().map(of)) / smallest(found.iter().map(of))
}

/// Findings 18 and 19.
pub(super) fn measure() -> Result<Measured, Failure> {
    let [tip, mid, _] = PAPER;
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
    let mut all = each(&cases, |(name, modes, step_s)| found(name, *modes, *step_s))?;
    let mid = all.split_off(all.len() - MODES.len());
    let tip = all.split_off(all.len() - MODES.len());
    let near = all.split_off(finer.len());
    let mut steps = all;
    let voltage = |found: &Found| found.rms_voltage_v;
    let force = |found: &Found| found.mean_force_n;
    let spreads = |of: fn(&Found) -> f64| [&tip, &mid].map(|found| relative_spread(&found[CONVERGED..], of));
    let contacts = |found: &[Found]| {
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
        (
            "18",
            vec![
                Check::new(
                    "spread of the RMS voltage, 6 to 14 modes, tip and mid-span",
                    modes_voltage,
                    Bound::Below(5e-3),
                ),
                Check::new("spread of the mean force", modes_force, Bound::Below(2e-3)),
                Check::new(
                    "spread of the RMS voltage, steps of 1, 0.5, 0.25 µs",
                    [relative_spread(&steps, voltage)],
                    Bound::Below(5e-3),
                ),
                Check::new("contacts per period, most / fewest", [contacts], Bound::Above(1.3)),
                Check::new("RMS voltage with 4, 6, 8, 10, 14 modes [V]", listed, Bound::Reported),
            ],
        ),
        (
            "19",
            vec![Check::new("spread over 4 to 10 modes, 220 Hz / 44 Hz", [sensitivity], Bound::Above(3.0))],
        ),
    ])
}
