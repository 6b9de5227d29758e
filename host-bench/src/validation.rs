//! Published measurements beside the models.
//!
//! Neither of the two measurements says anything about the force law of a triboelectric scene, the impact or the friction.

use serde::Serialize;

use crate::closed_form::{Estimate, estimate};
use crate::method::{Failure, Options, Precision};
use crate::report::Picture;
use crate::report::chart::{Axis, Chart, Curve, FROM_ZERO, Mark};
use crate::report::svg::{BLUE, COLOURS, VERMILION};
use crate::run::run_scene;
use crate::scene_file::{self, Override, Scene};
use harvester_scene::root::lowest_point;

/// A published figure and that of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct Figure {
    /// What was measured, with its unit; `≥`: the publication states a lower bound.
    pub quantity: String,
    pub source: &'static str,
    /// Where the publication does not say how the first cycle begins: `touch`, without charge, or `apart`, with the charge of
    /// electrodes that were discharged apart.
    pub start: Option<&'static str>,
    pub measured: f64,
    pub ours: f64,
    /// `ours / measured − 1`.
    pub relative_difference: f64,
    /// Whether a parameter was fitted to this figure.
    pub fitted: bool,
}

impl Figure {
    fn new(source: &'static str, quantity: impl Into<String>, measured: f64, ours: f64) -> Self {
        let relative_difference = ours / measured - 1.0;
        Self { quantity: quantity.into(), source, measured, ours, relative_difference, ..Self::default() }
    }
}

/// All figures.
///
/// # Errors
/// A shipped scene that is not found, or a run that stops.
pub fn figures() -> Result<Vec<Figure>, Failure> {
    Ok([bimorph()?, charging()?].concat())
}

fn scene(name: &str, changes: &[(&str, f64)]) -> Result<Scene, Failure> {
    let changes: Vec<Override> =
        changes.iter().map(|(key, value)| Override::new(key, &value.to_string())).collect();
    Ok(scene_file::read(&scene_file::shipped(name), &changes)?)
}

/// The abscissa of the largest value between two positive ends, on a logarithmic scale.
fn largest(of: impl Fn(f64) -> Result<f64, Failure>, ends: [f64; 2]) -> Result<f64, Failure> {
    lowest_point(|logarithm| Ok(-of(logarithm.exp())?), ends.map(f64::ln), 1e-6).map(f64::exp)
}

/// The scenes: Erturk and Inman's bimorph, the device of Hosseini et al. and its capacitor.
pub(crate) const SCENES: [&str; 2] = ["bimorph-erturk-inman", "contact-separation-hosseini"];

const ERTURK: &str = "Erturk";
/// Erturk and Inman's bimorph: name, resonance in Hz, load in Ω of the largest power there, peak power in W per g².
const BIMORPH: [(&str, f64, f64, f64); 2] = [("short", 45.6, 35e3, 23.9e-3), ("open", 48.4, 186e3, 23.9e-3)];
/// The loads in Ω of a short and of an open circuit, at which the voltage still has a resonance.
const ENDS: [f64; 2] = [1.0, f64::INFINITY];
/// Frequencies in Hz and loads in Ω between which the measured ones are.
const FREQUENCIES: [f64; 2] = [40.0, 55.0];
const LOADS: [f64; 2] = [1e3, 2e6];

/// The closed form of the bimorph at 1 g.
fn at_one_g(resistance_ohm: f64, frequency_hz: f64) -> Result<Estimate, Failure> {
    let changes = [
        ("excitation.amplitude_g", 1.0),
        ("excitation.frequency_hz", frequency_hz),
        ("load.resistance_ohm", resistance_ohm),
    ];
    estimate(&scene(SCENES[0], &changes)?, Precision::F64)
}

/// The resonances in Hz of the voltage in short and open circuit.
fn resonances() -> Result<[f64; 2], Failure> {
    let [short, open] = ENDS.map(|load| largest(|hz| Ok(at_one_g(load, hz)?.rms_voltage_v), FREQUENCIES));
    Ok([short?, open?])
}

/// Peak power in W, twice the mean.
fn peak_power(resistance_ohm: f64, frequency_hz: f64) -> Result<f64, Failure> {
    Ok(2.0 * at_one_g(resistance_ohm, frequency_hz)?.mean_power_w)
}

fn bimorph() -> Result<Vec<Figure>, Failure> {
    let mut figures = Vec::new();
    for ((name, resonance, load, power), ours_hz) in BIMORPH.into_iter().zip(resonances()?) {
        let best = largest(|load| peak_power(load, ours_hz), LOADS)?;
        let figure = |quantity: &str, measured, ours| {
            Figure::new(ERTURK, format!("{name}-circuit {quantity}"), measured, ours)
        };
        figures.extend([
            figure("resonance [Hz]", resonance, ours_hz),
            figure("best load [Ω]", load, best),
            figure("peak power [W/g²]", power, peak_power(best, ours_hz)?),
        ]);
    }
    Ok(figures)
}

const HOSSEINI: &str = "Hosseini";
/// The published best capacitor in F, and the cycle in which it has its largest power.
const BEST_F: f64 = 390e-12;
const BEST_CYCLE: usize = 2;
/// Frequencies in Hz with the published powers in W in that cycle. The charge is fitted to the first one.
const POWERS: [(f64, f64); 2] = [(1.7, 900e-9), (5.0, 2.7e-6)];
/// A large capacitor in F, chosen here: the publication names none.
const LARGE_F: f64 = 2.2e-9;
/// Cycles among which the one of the largest power is sought.
const CYCLES: usize = 8;

/// The charges in C at the start, in touch.
fn starts() -> Result<[(&'static str, f64); 2], Failure> {
    let device = &scene(SCENES[1], &[])?;
    let from = &device.contact_separation()?.parameters;
    let (stroke, dielectric) =
        (2.0 * from.initial_gap_m, from.dielectric_thickness_m / from.relative_permittivity);
    let whole = from.charge_density_c_per_m2 * from.electrode_area_m2;
    Ok([("touch", 0.0), ("apart", whole * stroke / (stroke + dielectric))])
}

/// Mean power in W into an empty capacitor in F within a cycle, the first is 1.
fn cycle_power(capacitance_f: f64, frequency_hz: f64, charge_c: f64, cycle: usize) -> Result<f64, Failure> {
    let changes = [
        ("load.capacitance_f", capacitance_f),
        ("excitation.frequency_hz", frequency_hz),
        ("initial.charge_c", charge_c),
        ("run.duration_periods", cycle as f64),
        ("run.settle_periods", cycle as f64 - 1.0),
    ];
    let outcome = run_scene(&scene(SCENES[1], &changes)?, &Options::default())?;
    Ok(outcome.mean_power_w.unwrap_or(f64::NAN))
}

/// The cycle of the largest power at the lower frequency, and this power in W.
fn best_cycle(capacitance_f: f64, charge_c: f64) -> Result<(f64, f64), Failure> {
    let mut best = (0.0, 0.0);
    for cycle in 1..=CYCLES {
        let power = cycle_power(capacitance_f, POWERS[0].0, charge_c, cycle)?;
        if power > best.1 {
            best = (cycle as f64, power);
        }
    }
    Ok(best)
}

fn charging() -> Result<Vec<Figure>, Failure> {
    let figure = |quantity: &str, measured, ours| Figure::new(HOSSEINI, quantity, measured, ours);
    let mut figures = Vec::new();
    let starts = starts()?;
    let [touch, _] = starts;
    for (hz, power) in POWERS {
        let ours = cycle_power(BEST_F, hz, touch.1, BEST_CYCLE)?;
        let of = figure(&format!("power in cycle 2, {hz} Hz [W]"), power, ours);
        figures.push(Figure { start: Some(touch.0), fitted: hz == POWERS[0].0, ..of });
    }
    for (name, charge) in starts {
        let best = largest(|of| cycle_power(of, POWERS[0].0, charge, BEST_CYCLE), [100e-12, 2e-9])?;
        let (cycle, power) = best_cycle(BEST_F, charge)?;
        let part = |of: f64| Ok::<_, Failure>(best_cycle(of * BEST_F, charge)?.1 / power);
        let all = [
            figure("best capacitor in cycle 2 [F]", BEST_F, best),
            figure("cycle of most power, 390 pF", BEST_CYCLE as f64, cycle),
            figure("cycle of most power, 2.2 nF: ≥", 7.0, best_cycle(LARGE_F, charge)?.0),
            figure("power of 273 pF to 390 pF: ≥", 0.9, part(0.7)?),
            figure("power of 507 pF to 390 pF: ≥", 0.9, part(1.3)?),
        ];
        figures.extend(all.map(|figure| Figure { start: Some(name), ..figure }));
    }
    Ok(figures)
}

/// Points of a curve over a logarithmic axis.
fn points(
    [from, to]: [f64; 2],
    count: u32,
    value: impl Fn(f64) -> Result<f64, Failure>,
) -> Result<Vec<(f64, f64)>, Failure> {
    let at = |index: u32| from * (to / from).powf(f64::from(index) / f64::from(count - 1));
    (0..count).map(|index| Ok((at(index), value(at(index))?))).collect()
}

/// Power over the load at both resonances, and over the capacitor in some cycles, with what was measured.
pub(crate) fn picture() -> Result<Picture, Failure> {
    let mut curves = Vec::new();
    let shown = resonances()?.into_iter().zip([BLUE, VERMILION]).enumerate();
    for ((name, _, load, power), (at, (hz, colour))) in BIMORPH.into_iter().zip(shown) {
        let model = points(LOADS, 121, |load| Ok(1e3 * peak_power(load, hz)?))?;
        let name = format!("{name}-circuit resonance, {hz:.1} Hz");
        curves.push(Curve::new(name, colour, Mark::line(at, 1.6), model));
        curves.push(Curve::new("measured", colour, Mark::point(at, 8.0), [(load, 1e3 * power)]));
    }
    let up = Axis::linear("peak power [mW/g²]", FROM_ZERO, 6);
    let loads = Chart::new("Erturk and Inman's bimorph", Axis::logarithmic("load [Ω]", LOADS), up, curves);
    let capacitors = [50.0, 5000.0];
    let cycles = [1, 2, 3, 7].into_iter().map(|cycle| {
        let power = |picofarads: f64| Ok(1e6 * cycle_power(1e-12 * picofarads, POWERS[0].0, 0.0, cycle)?);
        Ok((format!("cycle {cycle}"), points(capacitors, 41, power)?))
    });
    let cycles = cycles.collect::<Result<Vec<_>, Failure>>()?;
    let mut curves = Curve::distinct(&COLOURS, (Mark::line, 1.6), cycles);
    let measured = [(1e12 * BEST_F, 1e6 * POWERS[0].1)];
    curves.push(Curve::new("measured, cycle 2", COLOURS[1], Mark::point(0, 8.0), measured));
    let across = Axis::logarithmic("capacitor [pF]", capacitors);
    let up = Axis::linear("power at 1.7 Hz [µW]", FROM_ZERO, 6);
    let cycles = Chart::new("The device of Hosseini et al., discharged in touch", across, up, curves);
    let title = "Published measurements beside the models".to_owned();
    Ok(Picture { title, width: 900, charts: vec![loads, cycles], ..Picture::default() })
}
