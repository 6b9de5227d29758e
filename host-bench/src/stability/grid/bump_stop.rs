//! The bump-stop cases: from the shipped scene with a few modes, one quantity at a time is taken through its range,
//! under each contact law and at each step.

use super::{Extent, Kind, noise, shipped, stores};
use crate::stability::Case;

/// Periods of the shipped scene's base that a case runs, and after which it is measured: sixteen are, one for each part of the window.
const PERIODS: [f64; 2] = [22.0, 6.0];
/// Frequency of the shipped scene's base in Hz.
const FREQUENCY_HZ: f64 = 220.0;

/// The law of the contact as the scene file has it.
const LAWS: [&[(&str, &str)]; 5] = [
    &[("stop.contact", "residual-flexibility")],
    &[("stop.contact", "restitution"), ("stop.restitution", "0.5")],
    &[("stop.contact", "displacement-constraint")],
    &[("stop.contact", "restitution"), ("stop.restitution", "0.99")],
    &[("stop.contact", "restitution"), ("stop.restitution", "1.0")],
];
/// The first of the laws, which go with all ranges; the others go with the gaps alone.
const MAIN_LAWS: usize = 3;

/// Steps in s; `None` is the default, by the accuracy.
const STEPS: [Option<f64>; 5] = [None, Some(1e-6), Some(1e-5), Some(1e-4), Some(1e-3)];
const COARSE_STEPS: [Option<f64>; 4] = [None, Some(1e-6), Some(1e-5), Some(1e-3)];

/// The shortest step in s, with the gaps alone.
const SHORTEST_STEP_S: f64 = 1e-7;

/// A key, the value in the middle, and its other values.
type Range = (&'static str, f64, &'static [f64]);

const RANGES: [Range; 6] = [
    ("parameters.beam_modes", 4.0, &[1.0, 2.0, 3.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]),
    ("stop.rod_modes", 1.0, &[0.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]),
    // From touching at rest to out of reach, in m.
    ("stop.gap_m", 1e-5, &[0.0, 1e-7, 1e-6, 3e-5, 1e-4, 1e-2]),
    ("load.resistance_ohm", 1e6, &[0.0, 1.0, 1e3, f64::INFINITY]),
    // Over six decades, in Pa.
    ("stop.young_modulus_pa", 7e10, &[7e7, 7e13, 7e8, 7e12, 7e9, 7e11]),
    ("parameters.damping_ratio", 0.01, &[0.0, 0.5, 1e-3, 0.1, 0.3]),
];
/// The key of the gap, which goes with all laws.
const GAP: &str = "stop.gap_m";

pub(super) fn settings(extent: Extent) -> Vec<Case> {
    let steps: &[Option<f64>] = if extent == Extent::Whole { &STEPS } else { &COARSE_STEPS };
    let ranges = ranges(extent).into_iter().flat_map(|case| at(&case, steps));
    let others = others().into_iter().flat_map(|case| at(&case, &[None, Some(1e-6)]));
    let shortest = if extent == Extent::Whole { gaps(&LAWS) } else { Vec::new() };
    let shortest = shortest.into_iter().map(|case| Case { step_s: Some(SHORTEST_STEP_S), ..case });
    ranges.chain(others).chain(shortest).collect()
}

fn at(case: &Case, steps: &[Option<f64>]) -> Vec<Case> {
    steps.iter().map(|&step_s| Case { step_s, ..case.clone() }).collect()
}

/// The case in the middle of all ranges, but for one key and its value.
fn middle(law: &[(&str, &str)], changed: Option<(&str, f64)>) -> Case {
    let base = shipped(Kind::BumpStop);
    let ranged = RANGES.iter().fold(base, |case, &(key, value, _)| {
        let value = changed.filter(|(other, _)| *other == key).map_or(value, |(_, value)| value);
        if key.ends_with("modes") { case.with(key, value) } else { case.with_number(key, value) }
    });
    law.iter().fold(ranged, |case, (key, value)| case.with(key, value))
}

/// The case for some periods of the shipped scene.
fn short(case: Case) -> Case {
    let [duration_s, settle_s] = PERIODS.map(|periods| periods / FREQUENCY_HZ);
    case.with("run", format_args!("{{duration_s={duration_s},settle_s={settle_s}}}"))
}

fn ranges(extent: Extent) -> Vec<Case> {
    let (main, others) = LAWS.split_at(MAIN_LAWS);
    let mut settings = Vec::new();
    for law in main {
        for (key, _, values) in RANGES.into_iter().filter(|(key, ..)| *key != GAP) {
            let values = extent.thinned(values, 2);
            settings.extend(values.into_iter().map(|value| short(middle(law, Some((key, value))))));
        }
        // All modes of the shipped scene.
        let base = law.iter().fold(shipped(Kind::BumpStop), |case, (key, value)| case.with(key, value));
        settings.push(short(base));
    }
    [gaps(main), settings, gaps(others)].concat()
}

/// Every gap under some laws.
fn gaps(laws: &[&[(&str, &str)]]) -> Vec<Case> {
    let values = RANGES
        .iter()
        .filter(|(key, ..)| *key == GAP)
        .flat_map(|(_, middle, values)| std::iter::once(*middle).chain(values.iter().copied()));
    let values: Vec<f64> = values.collect();
    laws.iter().flat_map(|law| values.iter().map(|gap| short(middle(law, Some((GAP, *gap)))))).collect()
}

/// Fast bases, small motions and small storages, under each law that conserves or loses energy in an impact.
fn others() -> Vec<Case> {
    let mut settings = Vec::new();
    for law in [LAWS[0], LAWS[1], LAWS[4]] {
        let base = middle(law, None);
        settings.extend([1e4, 1e5].map(|rate_hz| short(noise(&base, rate_hz, 50.0))));
        for (amplitude, frequency_hz) in
            [(20.0, 1e3), (100.0, 4.2e3), (100.0, 1e4), (0.01, 5.0), (0.01, 220.0)]
        {
            let case = base
                .clone()
                .with_number("excitation.amplitude_m_per_s2", amplitude)
                .with_number("excitation.frequency_hz", frequency_hz);
            settings.push(short(case));
        }
        for voltage_v in [10.0, -1e3] {
            let charged = base.clone().with_number("initial.voltage_v", voltage_v);
            settings.push(short(charged));
        }
    }
    settings.extend([LAWS[0], LAWS[1]].into_iter().flat_map(stores_of));
    settings
}

/// The storages with this law; the resistance is not set, because the load has none.
fn stores_of(law: &[(&str, &str)]) -> Vec<Case> {
    let mut base = short(middle(law, None));
    base.changes.retain(|(key, _)| key != "load.resistance_ohm");
    stores(&base)
}
