//! The resonance over the resistance: of the sliding harvester and its charge density, findings 21 to 30; piezoelectric shunting, with
//! which the first paper compares, findings 31 and 32.

use super::runs::{Changes, Loader, bump_stop, each_of, value};
use super::statistics::{largest, least, smallest, spread};
use super::{Bound::*, Measured, check};
use crate::embedded::resonance_peak;
use crate::method::{Failure, Options};
use crate::run::{run_scene, try_each};
use crate::steady_state::{DEFAULT_POINTS, Peak as SteadyPeak};

/// Charge densities in C/m² of the first sweep.
const CHARGE_DENSITIES: [&str; 8] = ["0", "10e-6", "20e-6", "40e-6", "60e-6", "80e-6", "100e-6", "120e-6"];
/// Resistances in Ω.
const RESISTANCES: [&str; 10] = ["0", "1e6", "5e6", "1e7", "2e7", "5e7", "1e8", "2e8", "1e9", "1e10"];
/// What stands for 0 Ω on the logarithmic axis, and the part of the distance of three resistances to which an extreme is found.
const LEAST_OHM: f64 = 1e5;
const WITHIN: f64 = 1e-2;
/// Range in Hz of the resonance; with the largest charge and base acceleration it begins lower.
const RANGE_HZ: [f64; 2] = [18.28, 18.42];
const WIDE_RANGE_HZ: [f64; 2] = [18.1, 18.45];
const CHARGE_DENSITY: &str = "parameters.charge_density_c_per_m2";
const RESISTANCE: &str = "load.resistance_ohm";
const AMPLITUDE: &str = "excitation.amplitude_g";

/// The peak of the steady state over frequency.
#[derive(Clone, Copy)]
struct Peak {
    /// Its frequency less the natural frequency, in mHz at the shipped natural frequency.
    shift_mhz: f64,
    amplitude_mm: f64,
    /// Largest RMS voltage in V.
    rms_voltage_v: f64,
}

fn peak(loader: Loader<'_>, changes: Changes<'_>, range_hz: [f64; 2]) -> Result<Peak, Failure> {
    let (scene, ratio) = loader.scaled("sliding", changes)?;
    let natural_hz = scene.sliding()?.parameters.natural_frequency_hz();
    let range_hz = range_hz.map(|frequency_hz| ratio * frequency_hz);
    let (found, _) = resonance_peak(&scene, range_hz, DEFAULT_POINTS, &Options::default())?;
    let found = found.ok_or_else(|| Failure::of_file(&scene, "no stable orbit of one period"))?;
    // At an end of the range there may be a larger one beyond.
    let inside = |peak: SteadyPeak, value: f64| if peak.at_edge { f64::NAN } else { value };
    let (amplitude, voltage) = (found.amplitude, found.rms_voltage);
    Ok(Peak {
        shift_mhz: inside(amplitude, 1e3 * (amplitude.frequency_hz - natural_hz) / ratio),
        amplitude_mm: inside(amplitude, 1e3 * amplitude.value),
        rms_voltage_v: inside(voltage, voltage.value),
    })
}

struct OverResistance {
    peaks: Vec<Peak>,
    /// That of the lowest frequency and that of the largest amplitude, at any resistance, the ends included.
    lowest: Peak,
    highest: Peak,
}

impl OverResistance {
    fn new(loader: Loader<'_>, changes: Changes<'_>, range_hz: [f64; 2]) -> Result<Self, Failure> {
        let at = |resistance: &str| peak(loader, &[changes, &[(RESISTANCE, resistance)]].concat(), range_hz);
        let peaks = try_each(&RESISTANCES, |resistance| at(resistance))?;
        let exponent = |place: usize| RESISTANCES[place].parse().unwrap_or(0.0_f64).max(LEAST_OHM).log10();
        let between = |exponent: f64| at(&format!("{:e}", 10_f64.powf(exponent)));
        let least = |of: fn(&Peak) -> f64| least(&peaks, exponent, between, of, WITHIN);
        let (lowest, _) = least(|peak| peak.shift_mhz)?;
        let (highest, _) = least(|peak| -peak.amplitude_mm)?;
        Ok(Self { peaks, lowest, highest })
    }
}

fn amplitudes(peaks: &[Peak]) -> Vec<f64> {
    peaks.iter().map(|peak| peak.amplitude_mm).collect()
}

fn shifts(peaks: &[Peak]) -> Vec<f64> {
    peaks.iter().map(|peak| peak.shift_mhz).collect()
}

fn last_over_first(values: &[f64]) -> f64 {
    value(values.last().zip(values.first()).map(|(last, first)| last / first))
}

/// Findings 21 to 24: more charge at 100 MΩ, at an amplitude in g.
pub(super) fn measure_charge(loader: Loader<'_>, amplitude_g: &str) -> Result<Measured, Failure> {
    let peaks = try_each(&CHARGE_DENSITIES, |density| {
        let changes = [(CHARGE_DENSITY, *density), (RESISTANCE, "1e8"), (AMPLITUDE, amplitude_g)];
        peak(loader, &changes, RANGE_HZ)
    })?;
    let away = try_each(&["0", "120e-6"], |density| {
        let changes = [(CHARGE_DENSITY, *density), (RESISTANCE, "1e8"), ("excitation.frequency_hz", "16.0")];
        let options = Options { steady_state: true, ..Options::default() };
        let outcome = run_scene(&loader.scene("sliding", &changes)?, &options)?;
        Ok(value(outcome.sliding().and_then(|found| found.amplitude_m)))
    })?;
    let (amplitudes, shifts) = (amplitudes(&peaks), shifts(&peaks));
    let voltages: Vec<f64> = peaks.iter().map(|peak| peak.rms_voltage_v).collect();
    let ratio = last_over_first(&amplitudes);
    Ok(vec![
        check("21", "peak amplitude [mm], 0 to 120 µC/m²", amplitudes, Falls),
        check("21", "last / first", [ratio], Below(0.6)),
        check("22", "resonance less natural frequency [mHz]", shifts.clone(), Falls),
        check("22", "the same [mHz]", [smallest(shifts.into_iter())], Above(-50.0)),
        check("23", "largest RMS voltage [V], 0 to 120 µC/m²", voltages, Rises),
        check("24", "amplitude at resonance, 120 / 0 µC/m²", [ratio], Below(0.6)),
        check("24", "the same at 16 Hz", [last_over_first(&away)], Above(0.98)),
    ])
}

/// Findings 25 and 26: small charge over resistance.
pub(super) fn measure_small_charge(loader: Loader<'_>) -> Result<Measured, Failure> {
    let small = OverResistance::new(loader, &[(CHARGE_DENSITY, "20e-6")], RANGE_HZ)?;
    let (amplitudes, shifts) = (amplitudes(&small.peaks), shifts(&small.peaks));
    let moved =
        largest(shifts.iter().chain([&small.lowest.shift_mhz]).map(|shift| (shift - shifts[0]).abs()));
    let mut checks = vec![
        check(
            "25",
            "amplitude at resonance, 10 GΩ / 0 Ω",
            [last_over_first(&amplitudes)],
            Within(0.97, 0.99),
        ),
        check("25", "largest move of the resonance from 0 Ω [mHz]", [moved], Below(2.0)),
    ];
    checks.extend(least_inside("26", &small));
    Ok(checks)
}

/// That the smallest shift is inside the range of resistances.
fn least_inside(number: &'static str, of: &OverResistance) -> Measured {
    let shifts = shifts(&of.peaks);
    let ends = [shifts.first(), shifts.last()].map(|end| value(end.map(|end| end - of.lowest.shift_mhz)));
    vec![
        check(number, "shift at 0 Ω and at 10 GΩ less the least [mHz]", ends, Above(0.1)),
        check(number, "shift [mHz], 0 Ω to 10 GΩ", shifts, Reported),
    ]
}

/// Findings 27 to 30, and a: large charge over resistance.
pub(super) fn measure_large_charge(loader: Loader<'_>) -> Result<Measured, Failure> {
    let large: Changes<'_> = &[(CHARGE_DENSITY, "200e-6"), (AMPLITUDE, "0.8")];
    let swapped: Changes<'_> = &[
        (CHARGE_DENSITY, "200e-6"),
        (AMPLITUDE, "0.8"),
        ("parameters.static_friction_active", "0.25"),
        ("parameters.static_friction_inert", "0.35"),
        ("parameters.kinetic_friction_active", "0.20"),
        ("parameters.kinetic_friction_inert", "0.30"),
    ];
    let cases: [(Changes<'_>, [f64; 2]); 3] =
        [(&[(CHARGE_DENSITY, "120e-6")], RANGE_HZ), (large, WIDE_RANGE_HZ), (swapped, WIDE_RANGE_HZ)];
    let all = each_of(cases, |(changes, range)| OverResistance::new(loader, changes, *range))?;
    let rises = all.each_ref().map(|of| 100.0 * (of.highest.amplitude_mm / of.peaks[0].amplitude_mm - 1.0));
    let [shipped, large, _] = &all;
    let pair = [shipped, large];
    let falls = pair.map(|of| last_over_first(&amplitudes(&of.peaks)));
    let levels = pair.map(|of| match amplitudes(&of.peaks)[..] {
        [.., before, last] => (before / last - 1.0).abs(),
        _ => f64::NAN,
    });
    // From the resonance's least frequency to the ends, in amplitude.
    let between = pair.map(|of| {
        let ends = [&of.peaks[0], &of.peaks[of.peaks.len() - 1]].map(|peak| peak.amplitude_mm);
        (of.lowest.amplitude_mm - smallest(ends.into_iter())) / spread(ends.into_iter())
    });
    let beyond = pair.map(|of| last_less_first(&shifts(&of.peaks)));
    let half_width_mhz = half_width_mhz(loader)?;
    let width =
        pair.map(|of| (largest(shifts(&of.peaks).into_iter()) - of.lowest.shift_mhz) / half_width_mhz);
    let drops = falls.map(|fall| 1.0 - fall);
    let [_, large_rise, swapped_rise] = rises;
    let rest = vec![
        check(
            "27",
            "amplitude at the least: place between the ends, 120 and 200 µC/m²",
            between,
            Within(0.05, 0.95),
        ),
        check("28", "shift at 10 GΩ less at 0 Ω [mHz], 120 and 200 µC/m²", beyond, Above(0.0)),
        check("29", "rise of the amplitude over 0 Ω [%], 120, 200 µC/m², swapped", rises, Above(0.02)),
        check("29", "amplitude at 10 GΩ / at 0 Ω", falls, Below(0.97)),
        check("29", "change from 1 to 10 GΩ", levels, Below(1e-2)),
        check("30", "200 µC/m²: width of the loop / 2ζf", [width[1]], Above(0.5)),
        check("30", "200 µC/m²: drop of the amplitude", [drops[1]], Above(0.05)),
        check("30", "120 µC/m²: width and drop", [width[0], drops[0]], Reported),
        check(
            "a",
            "rise of the amplitude over 0 Ω [%], 200 µC/m², swapped",
            [large_rise, swapped_rise],
            Above(1.0),
        ),
    ];
    Ok(least_inside("27", shipped).into_iter().chain(rest).collect())
}

fn last_less_first(values: &[f64]) -> f64 {
    value(values.last().zip(values.first()).map(|(last, first)| last - first))
}

/// `2ζf` of the sliding scene in mHz, at the shipped natural frequency.
fn half_width_mhz(loader: Loader<'_>) -> Result<f64, Failure> {
    let (scene, ratio) = loader.scaled("sliding", &[])?;
    let parameters = &scene.sliding()?.parameters;
    Ok(2e3 * parameters.damping_ratio * parameters.natural_frequency_hz() / ratio)
}

/// Resistances in Ω.
const SHUNTS: [&str; 7] = ["1", "3e3", "1e4", "3e4", "1e5", "1e6", "1e9"];
/// Frequencies in Hz from which the shunted_peak is narrowed down.
const FIRST_HZ: f64 = 237.0;
const EVERY_HZ: f64 = 1.5;
const COUNT: u32 = 11;
/// Half the width in Hz of the last parabola.
const CLOSE_HZ: f64 = 0.25;

/// Peak tip displacement in m of the beam without a stop, when its free motion has decayed to 10⁻⁸.
fn amplitude(loader: Loader<'_>, resistance: &str, frequency_hz: f64) -> Result<f64, Failure> {
    let frequency = format!("{frequency_hz}");
    let outcome = loader.run(
        "bump-stop-none",
        &[
            ("load.resistance_ohm", resistance),
            ("excitation.frequency_hz", frequency.as_str()),
            ("parameters.beam_modes", "6"),
            ("run.settle_s", "1.2"),
            ("run.duration_s", "1.25"),
        ],
    )?;
    Ok(value(bump_stop(&outcome)?.peak_tip_displacement_m))
}

/// Frequency in Hz of the largest amplitude, and the amplitude in m there; not-a-number if it is at the first or the last.
///
/// The inverse square of the amplitude of a resonance is a parabola in frequency but for terms of higher order: the top
/// of that through three points beside the largest, twice.
fn shunted_peak(loader: Loader<'_>, resistance: &str) -> Result<[f64; 2], Failure> {
    let frequencies: Vec<f64> = (0..COUNT).map(|index| FIRST_HZ + EVERY_HZ * f64::from(index)).collect();
    let at = |frequency_hz: f64| amplitude(loader, resistance, frequency_hz);
    let inverse = |frequency_hz: &f64| at(*frequency_hz).map(|amplitude| amplitude.powi(-2));
    let values = try_each(&frequencies, inverse)?;
    let least = (0..values.len()).min_by(|one, other| values[*one].total_cmp(&values[*other]));
    let Some(least) = least.filter(|least| (1..values.len() - 1).contains(least)) else {
        return Ok([f64::NAN; 2]);
    };
    let near = top(frequencies[least], EVERY_HZ, [values[least - 1], values[least], values[least + 1]]);
    let around = try_each(&[near - CLOSE_HZ, near, near + CLOSE_HZ], inverse)?;
    let [before, here, after] = around[..] else { return Ok([f64::NAN; 2]) };
    let frequency_hz = top(near, CLOSE_HZ, [before, here, after]);
    Ok([frequency_hz, at(frequency_hz)?])
}

/// Place of the lowest point of the parabola through three values at distances `every` around `middle`.
fn top(middle: f64, every: f64, [before, here, after]: [f64; 3]) -> f64 {
    middle + 0.5 * every * (before - after) / (before - 2.0 * here + after)
}

/// Findings 31 and 32.
pub(super) fn measure(loader: Loader<'_>) -> Result<Measured, Failure> {
    let peaks = try_each(&SHUNTS, |resistance| shunted_peak(loader, resistance))?;
    let frequencies: Vec<f64> = peaks.iter().map(|[frequency, _]| *frequency).collect();
    let amplitudes: Vec<f64> = peaks.iter().map(|[_, amplitude]| 1e6 * amplitude).collect();
    let lowest = smallest(amplitudes.iter().copied());
    let ends = [amplitudes.first(), amplitudes.last()].map(|end| end.map_or(f64::NAN, |end| end / lowest));
    let shift = largest(frequencies.iter().copied()) - smallest(frequencies.iter().copied());
    Ok(vec![
        check("31", "resonance [Hz], 1 Ω to 1 GΩ", frequencies, Rises),
        check("31", "open less short circuit [Hz]", [shift], Above(5.0)),
        check("32", "amplitude at 1 Ω and at 1 GΩ / the smallest", ends, Above(1.5)),
        check("32", "amplitude [µm], 1 Ω to 1 GΩ", amplitudes, Reported),
    ])
}
