//! What a node says of random inputs, by its samples, bank of lines, map and code, against their trajectories.

use std::f64::consts::TAU;
use std::sync::Arc;

use model_core::energy::ResponseMap;
use model_core::excitation::{LineBank, Lines};
use model_core::node::{Finding, OutputPower, PredictedPower};

use super::Map;
use super::axes::amplitude_of;
use crate::method::{Failure, Options};
use crate::run::{run_scene, try_each};
use crate::scene_file::{Excitation, Load, RunSpan, Scene, Trace};
use crate::stability::random::Source;

/// Samples of a section and sections of a block, as in the firmware.
const SECTION: usize = 80;
const SECTIONS: usize = 16;
/// Samples of the sensor in a period of the resonance.
const PER_PERIOD: f64 = 20.0;
/// Values of the trajectory's input for a sample of the sensor: straight lines between them are within 10⁻³ of the input.
const FINER: usize = 4;
/// Sensor: m/s² of a count, and its noise in counts RMS.
const UNIT: f64 = 9.806_65 / 1024.0;
const NOISE_COUNTS: f64 = 3.0;
/// Gravity on the sensor's axis in m/s².
const GRAVITY: f64 = 9.806_65;
/// Time constants of the free motion before the measurement, and blocks that are measured: of lines and of noise.
const SETTLING: f64 = 8.0;
const BLOCKS: [usize; 2] = [2, 40];
/// Sines of a noise.
const SINES: usize = 600;

/// A kind of input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A sine.
    Line,
    /// A sine and a weaker one beside it.
    TwoLines,
    /// Band-limited noise of even density.
    Noise,
}

/// All kinds, by turns.
pub const KINDS: [Kind; 3] = [Kind::Line, Kind::TwoLines, Kind::Noise];

/// What a node says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prediction {
    /// The output power, with its bounds.
    Known { value: f64, low: f64, high: f64 },
    /// That of one of two motions, with bounds that cover both.
    Either { low: f64, high: f64 },
    /// An order of magnitude: of broadband vibration beyond the linear motion.
    Beyond,
    /// No more than an order of magnitude, or nothing: neither a line nor broadband, or outside the map.
    Nothing,
}

/// One input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detected {
    pub kind: Kind,
    /// Mean power of the trajectory in W.
    pub truth: f64,
    pub prediction: Prediction,
}

/// The sines of an input: amplitude in m/s², frequency in Hz, phase in rad.
type Sines = Vec<[f64; 3]>;

/// Random inputs of all kinds by turns against trajectories.
pub fn detected(
    scene: &Scene,
    map: &Map,
    count: usize,
    seed: u64,
    options: &Options,
    step: &(impl Fn() + Sync),
) -> Result<Vec<Detected>, Failure> {
    if !matches!(scene.load, Load::Resistor { .. }) {
        return Err(Failure::of_file(scene, "load.kind: must be \"resistor\" with --inputs"));
    }
    let axes = &map.axes;
    let rate = PER_PERIOD * axes.centre_hz;
    let bank = LineBank::<SECTION, SECTIONS>::new(
        rate as f32,
        axes.centre_hz as f32,
        axes.half_bandwidth_hz as f32,
        UNIT as f32,
    )
    .map_err(|error| Failure::of_file(scene, format!("--inputs: {error}")))?;
    let numbers: Vec<usize> = (0..count).collect();
    try_each(&numbers, |&number| {
        let mut source = Source::new(seed, number as u64);
        let kind = KINDS[number % KINDS.len()];
        let sines = sines(map, kind, &mut source);
        let detected = one(scene, map, &bank, (kind, &sines), &mut source, options);
        step();
        detected
    })
}

fn sines(map: &Map, kind: Kind, source: &mut Source) -> Sines {
    let axes = &map.axes;
    let [low, high] = axes.amplitudes;
    let phase = |source: &mut Source| source.uniform(0.0, TAU);
    // The band of the bank: a quarter of a section's rate to both sides.
    let reach = 0.2 * PER_PERIOD * axes.centre_hz / SECTION as f64;
    let [first, last] = [axes.frequencies[0], axes.frequencies[axes.frequencies.len() - 1]];
    let near =
        |frequency: f64| frequency.clamp(first, last).clamp(axes.centre_hz - reach, axes.centre_hz + reach);
    let strong =
        [source.logarithmic(low, high), near(axes.frequency(source.uniform(0.0, 1.0))), phase(source)];
    match kind {
        Kind::Line => vec![strong],
        Kind::TwoLines => {
            let weak = source.logarithmic(0.03, 0.5) * strong[0];
            let beside = source.signed(0.1, 1.0) * reach;
            vec![strong, [weak, near(strong[1] + beside), phase(source)]]
        }
        Kind::Noise => {
            let rising = map.slices[0].iter().map(|column| column.rising).fold(f64::INFINITY, f64::min);
            // Up to the density at which three times the motion leaves the lower branch: linear and beyond.
            let limit = amplitude_of(rising).powi(2) / (9.0 * std::f64::consts::PI * axes.half_bandwidth_hz);
            let density = source.logarithmic(1e-3 * limit, limit);
            let band = 40.0 * axes.half_bandwidth_hz;
            let amplitude = (2.0 * density * band / SINES as f64).sqrt();
            let frequency = |source: &mut Source| axes.centre_hz + source.uniform(-0.5, 0.5) * band;
            (0..SINES).map(|_| [amplitude, frequency(source), phase(source)]).collect()
        }
    }
}

/// The values of a sum of sines, `count` of them at `rate` a second: each sine is a phasor that is turned.
fn values(sines: &Sines, rate: f64, count: usize) -> Vec<f64> {
    let mut sums = vec![0.0; count];
    for &[amplitude, frequency, phase] in sines {
        let (turn_sine, turn_cosine) = (TAU * frequency / rate).sin_cos();
        let (mut sine, mut cosine) = phase.sin_cos();
        for sum in &mut sums {
            *sum += amplitude * sine;
            (sine, cosine) =
                (sine * turn_cosine + cosine * turn_sine, cosine * turn_cosine - sine * turn_sine);
        }
    }
    sums
}

fn one(
    scene: &Scene,
    map: &Map,
    bank: &LineBank<SECTION, SECTIONS>,
    (kind, sines): (Kind, &Sines),
    source: &mut Source,
    options: &Options,
) -> Result<Detected, Failure> {
    let axes = &map.axes;
    let rate = PER_PERIOD * axes.centre_hz;
    let blocks = BLOCKS[usize::from(kind == Kind::Noise)];
    // The free motion falls to 1/e in 1/(2π · half-bandwidth).
    let settling = (SETTLING / (TAU * axes.half_bandwidth_hz) * rate).ceil() as usize;
    let samples = settling + blocks * bank.block();
    let input = values(sines, rate * FINER as f64, (samples + 2) * FINER);
    let counts: Vec<i16> = input
        .iter()
        .step_by(FINER)
        .skip(settling)
        .map(|acceleration| {
            // The sum of twelve uniform numbers has the variance 1.
            let noise: f64 = (0..12).map(|_| source.uniform(-0.5, 0.5)).sum();
            ((acceleration + GRAVITY) / UNIT + NOISE_COUNTS * noise).round() as i16
        })
        .collect();
    let (mut state, mut detected, mut left) = (bank.start(), Vec::new(), &counts[..]);
    while !left.is_empty() {
        let (taken, lines) = bank.take(&mut state, left);
        detected.extend(lines);
        left = &left[taken..];
    }
    let lookup = map.image.map()?;
    let prediction = prediction(&lookup, &detected);
    let scene = Scene {
        excitation: Excitation::File(Trace {
            samples_m_per_s2: Arc::from(input),
            rate_hz: rate * FINER as f64,
            repeat: false,
            resampled: None,
        }),
        run: RunSpan { duration_s: samples as f64 / rate, settle_s: settling as f64 / rate },
        ..scene.clone()
    };
    let outcome = run_scene(&scene, &Options { bare: true, ..*options })?;
    Ok(Detected { kind, truth: outcome.mean_power_w.unwrap_or(f64::NAN), prediction })
}

/// What a node says of its blocks while its storage says nothing.
fn prediction(map: &ResponseMap<&[u16]>, blocks: &[Lines]) -> Prediction {
    let predicted = PredictedPower::of_blocks(map, blocks, 0.0);
    let bounds = |found: OutputPower| {
        let [value, bound] = [found.value, found.bound()].map(f64::from);
        [value - bound, value, value + bound]
    };
    match predicted.finding {
        Finding::Line | Finding::Broadband | Finding::Rest => {
            let [low, value, high] = bounds(predicted.lower);
            Prediction::Known { value, low, high }
        }
        Finding::TwoMotions | Finding::TwoMotionsOneSeen => {
            let [low, _, high] = bounds(predicted.either());
            Prediction::Either { low, high }
        }
        Finding::BroadbandBeyond => Prediction::Beyond,
        Finding::Outside(_) | Finding::Unclear | Finding::Damaged => Prediction::Nothing,
    }
}
