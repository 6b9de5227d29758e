//! Response maps: the steady motions of a scene over amplitude and frequency by the full model, and the image of them that
//! a node looks its income up in ([`model_core::energy::ResponseMap`]).
//!
//! At each column of the map one harvester is taken through rising and then through falling amplitudes, so that both
//! steady motions are found where there are two, and the boundaries at which each ends are narrowed down by bisection. The
//! bounds are the errors at random places; a second set of places checks them.

mod agreement;
mod axes;
mod column;
mod image;
mod inputs;
mod picture;
#[cfg(test)]
mod tests;

use std::fmt::Write;

pub use self::agreement::{Agreement, Judged};
pub use self::axes::Axes;
pub use self::column::Column;
pub use self::image::Image;
pub use self::inputs::{Detected, KINDS, Kind, Prediction, detected};
pub use self::picture::drawn;
pub(crate) use self::picture::{best, picture};
pub use agreement::{OperatingPoint, Truth};

use self::agreement::{judge, margin};
use self::image::{Content, SliceBounds, bounds};
use crate::accuracy::Statements;
use crate::embedded::{fingerprint, with_continuation};
use crate::method::{Failure, Options};
use crate::name::Name;
use crate::run::try_each;
use crate::scene_file::{Load, Scene};
use agreement::{random, truth};

/// What a map is to cover, and how well it is to be tested.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Lowest and highest amplitude in m/s².
    pub amplitudes: [f64; 2],
    /// Lowest and highest frequency in Hz.
    pub frequencies: [f64; 2],
    /// Voltages of the storage in V, rising; empty for a resistor.
    pub voltages: Vec<f64>,
    /// Median of the relative error above which the command says so.
    pub error: f64,
    /// Random places in a slice by which the bounds are measured, and as many others that check them.
    pub places: usize,
    /// Of the random places.
    pub seed: u64,
}

/// Places that check a map at which a run is made with its statement.
const STATED: usize = 8;
/// Most slices.
const MOST_SLICES: usize = 16;

impl Request {
    /// Checks the numbers against their bounds.
    ///
    /// # Errors
    /// [`Failure::Input`] with the first number outside its bounds, under its name on the command line.
    pub fn check(&self) -> Result<(), Failure> {
        let refuse = |text: String| Err(Failure::Input(text));
        let range = |name: &str, [low, high]: [f64; 2], [lowest, highest]: [f64; 2]| {
            if lowest <= low && low < high && high <= highest {
                return Ok(());
            }
            refuse(format!(
                "{name} {low}:{high}: must be from {lowest:e} to {highest:e}, the lower one first"
            ))
        };
        range("amplitude", self.amplitudes, [1e-3, 1e4])?;
        range("frequency", self.frequencies, [1e-6, 1e5])?;
        let Self { voltages, error, .. } = self;
        if !(*error > 0.0 && *error <= 1.0) {
            return refuse(format!("error {error}: must be above 0, to 1"));
        }
        if voltages.len() > MOST_SLICES || voltages.iter().any(|voltage| !(1e-2..=1e3).contains(voltage)) {
            return refuse(format!("voltage: must be up to {MOST_SLICES} voltages from 0.01 to 1000"));
        }
        if voltages.windows(2).any(|pair| pair[0] >= pair[1]) {
            return refuse("voltage: must rise".to_owned());
        }
        Ok(())
    }
}

/// A map, what it was made of, and what it was tested by.
#[derive(Debug, Clone)]
pub struct Map {
    pub image: Image,
    pub axes: Axes,
    /// The columns of each slice.
    pub slices: Vec<Vec<Column>>,
    /// The places that check it.
    pub checked: Vec<Judged>,
    pub agreement: Agreement,
    /// Margin beside a boundary, as a part of the amplitude.
    pub margin: f64,
    /// Output power over the one-sided spectral density of broadband vibration, in W/((m/s²)²/Hz), and the largest density.
    pub broadband: Option<[f64; 2]>,
    /// Simulated periods in all.
    pub periods: f64,
    /// What runs at some of the places that check it state.
    pub(crate) statements: Statements,
}

/// How far a map is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// So many columns and places are to come.
    More(usize),
    /// One of them is done.
    Done,
}

/// Makes the map of a scene; `step` is called as it proceeds.
pub fn map(
    scene: &Scene,
    request: &Request,
    options: &Options,
    step: &(impl Fn(Step) + Sync),
) -> Result<Map, Failure> {
    let scenes = &scenes(scene, request)?[..];
    let axes = Axes::new(&scenes[0], request, options)?;
    let count = request.places * scenes.len();
    step(Step::More(scenes.len() * axes.frequencies.len() + 2 * count));
    let made = swept(scenes, &axes, request, options, step)?;
    let mut periods: f64 = made.iter().map(|(_, periods)| periods).sum();
    let columns: Vec<Column> = made.into_iter().map(|(column, _)| column).collect();
    let slices: Vec<Vec<Column>> = columns.chunks(axes.frequencies.len()).map(<[_]>::to_vec).collect();
    let voltage =
        |scene: &Scene| if let Load::DcBus { voltage_v, .. } = scene.load { voltage_v } else { 0.0 };
    let voltages: Vec<f64> = scenes.iter().map(voltage).collect();
    let mut content = Content {
        axes: &axes,
        fingerprint: fingerprint(&scenes[0])?,
        voltages: &voltages,
        is_current: matches!(scenes[0].load, Load::DcBus { .. }),
        slices: &slices,
        margin: 0.0,
        bounds: &[],
    };
    let places = random(&axes, scenes.len(), request.seed, 2 * count);
    let measured = truths(scenes, &places, &content, options, step)?;
    periods += measured.iter().map(|(_, periods)| periods).sum::<f64>();
    let known: Vec<(OperatingPoint, Truth, [f64; 2])> = places
        .iter()
        .zip(&measured)
        .map(|(place, (truth, _))| (*place, *truth, boundaries(&content, place)))
        .collect();
    let (calibrating, checking) = known.split_at(count);
    content.margin = margin(calibrating);
    let unbounded: Vec<SliceBounds> = vec![Default::default(); scenes.len()];
    content.bounds = &unbounded;
    let measured = bounds(&content, &judged(&content.image()?, &voltages, calibrating)?);
    content.bounds = &measured;
    let mut image = content.image()?;
    let checked = judged(&image, &voltages, checking)?;
    let Some(agreement) = Agreement::of(&checked) else {
        return Err(Failure::of_file(
            &scenes[0],
            format!(
                "the harvester gives no power at the {count} places that check the map: other amplitudes?"
            ),
        ));
    };
    image.state(&agreement);
    let margin = (content.margin / 2048.0).exp2() - 1.0;
    let broadband = content.linear().map(|found| [found.factor, found.largest]);
    let stated = checked
        .iter()
        .take(STATED)
        .map(|Judged { place, .. }| (&scenes[place.slice], [place.amplitude, place.frequency_hz], None));
    let statements = Statements::of_orbits(&stated.collect::<Vec<_>>(), options)?;
    Ok(Map { image, axes, slices, checked, agreement, margin, broadband, periods, statements })
}

/// The scene of each slice: at a fixed voltage of the storage behind a bridge.
fn scenes(scene: &Scene, request: &Request) -> Result<Vec<Scene>, Failure> {
    let refuse = |text: &str| Err(Failure::of_file(scene, text));
    let bus = |voltage_v: f64, diode_drop_v: f64| Scene {
        load: Load::DcBus { voltage_v, diode_drop_v },
        ..scene.clone()
    };
    match (scene.load, &request.voltages[..]) {
        (Load::Resistor { resistance_ohm }, []) => {
            if resistance_ohm > 0.0 && resistance_ohm.is_finite() {
                Ok(vec![scene.clone()])
            } else {
                refuse("load.resistance_ohm: must be above 0 and finite for a map of the power in it")
            }
        }
        (Load::Resistor { .. }, _) => refuse("load.kind: is \"resistor\", must be a bridge with --voltage"),
        (Load::DcBus { voltage_v, .. }, []) if voltage_v > 0.0 => Ok(vec![scene.clone()]),
        (Load::DcBus { .. }, []) => refuse("load.voltage_v: must be above 0 for a map of the charge"),
        (Load::RectifiedStore(_), []) => {
            refuse("load.kind: is \"rectified-store\", needs --voltage for a map")
        }
        (Load::DcBus { diode_drop_v, .. }, voltages) => {
            Ok(voltages.iter().map(|&voltage| bus(voltage, diode_drop_v)).collect())
        }
        (Load::RectifiedStore(store), voltages) => {
            Ok(voltages.iter().map(|&voltage| bus(voltage, store.diode_drop_v)).collect())
        }
    }
}

/// The columns of all slices, each with the simulated periods that it took.
fn swept(
    scenes: &[Scene],
    axes: &Axes,
    request: &Request,
    options: &Options,
    step: &(impl Fn(Step) + Sync),
) -> Result<Vec<(Column, f64)>, Failure> {
    let columns: Vec<usize> = (0..scenes.len() * axes.frequencies.len()).collect();
    try_each(&columns, |&index| {
        let frequency_hz = axes.frequencies[index % axes.frequencies.len()];
        let scene = &scenes[index / axes.frequencies.len()];
        let made = with_continuation(scene, frequency_hz, options, |continuation| {
            let column = column::column(continuation, frequency_hz, request.amplitudes)?;
            Ok((column, continuation.periods()))
        });
        step(Step::Done);
        made
    })
}

/// The steady motions at some places, each with the simulated periods that it took.
fn truths(
    scenes: &[Scene],
    places: &[OperatingPoint],
    content: &Content<'_>,
    options: &Options,
    step: &(impl Fn(Step) + Sync),
) -> Result<Vec<(Truth, f64)>, Failure> {
    try_each(places, |place| {
        let truth = with_continuation(&scenes[place.slice], place.frequency_hz, options, |continuation| {
            let [rising, falling] = boundaries(content, place);
            Ok((truth(continuation, place, rising.max(falling))?, continuation.periods()))
        });
        step(Step::Done);
        truth
    })
}

/// The levels of both boundaries at a place, by the columns beside it.
fn boundaries(content: &Content<'_>, place: &OperatingPoint) -> [f64; 2] {
    let (below, part) = content.axes.column(place.frequency_hz);
    let columns = &content.slices[place.slice];
    let between = |get: fn(&Column) -> f64| {
        let [low, high] = [get(&columns[below]), get(&columns[below + 1])];
        low + (high - low) * part
    };
    [between(|column| column.rising), between(|column| column.falling)]
}

/// The values of the map at operating points with known motions.
fn judged(
    image: &Image,
    voltages: &[f64],
    known: &[(OperatingPoint, Truth, [f64; 2])],
) -> Result<Vec<Judged>, Failure> {
    let map = image.map()?;
    Ok(known
        .iter()
        .map(|&(place, truth, boundaries)| {
            let (amplitude, frequency) = (place.amplitude as f32, place.frequency_hz as f32);
            let predicted = match voltages[place.slice] {
                0.0 => map.at(amplitude, frequency),
                // The slice itself: between two slices there are the bounds of both.
                _ => map.in_slice_at(place.slice, amplitude, frequency),
            };
            judge(predicted, boundaries, place, truth)
        })
        .collect())
}

/// Words in a line of the module.
const PER_LINE: usize = 14;

/// The map as a Rust module with constants for firmware; `command` made it.
pub fn module(map: &Map, scene: &str, command: &str) -> String {
    let [scene, command] = [scene, command].map(|text| Name::new(text).line());
    let Map { image, axes, agreement, .. } = map;
    let Agreement { places, median, percentile_90, bounds_hold, .. } = agreement;
    let [low, high] = axes.amplitudes;
    let [first, last] =
        [axes.frequencies.first(), axes.frequencies.last()].map(|end| end.copied().unwrap_or(0.0));
    let mut text = format!(
        "//! Response map of {scene}, from {low} to {high} m/s² and from {first:.3} to {last:.3} Hz, for\n\
         //! `model_core::energy::ResponseMap`. Made by:\n\
         //!\n\
         //! ```sh\n\
         //! {command}\n\
         //! ```\n\
         //!\n\
         //! At {places} random places off its nodes the median error is {:.2} %, the 90th percentile {:.2} %, and the bounds\n\
         //! hold at {:.1} %.\n\n\
         /// Fingerprint of the harvester.\n\
         pub const FINGERPRINT: u32 = {:#010x};\n\n\
         /// Resonance of the harvester and its half-bandwidth in Hz: arguments of `excitation::LineBank::new`.\n\
         pub const RESONANCE_HZ: f32 = {:?};\n\
         pub const HALF_BANDWIDTH_HZ: f32 = {:?};\n\n\
         /// The map: `ResponseMap::new(&MAP[..], FINGERPRINT)`.\n\
         pub static MAP: [u16; {}] = [\n",
        100.0 * median,
        100.0 * percentile_90,
        100.0 * bounds_hold,
        image.fingerprint,
        axes.centre_hz as f32,
        axes.half_bandwidth_hz as f32,
        image.words.len(),
    );
    for line in image.words.chunks(PER_LINE) {
        let words: Vec<String> = line.iter().map(u16::to_string).collect();
        // A string takes all that is written.
        let _ = writeln!(text, "    {},", words.join(", "));
    }
    text + "];\n"
}

/// The map as little-endian bytes.
pub fn bytes(map: &Map) -> Vec<u8> {
    map.image.words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
