//! Hours of a harvester: what shakes it, and what it gives.

use model_core::excitation::{AnyExcitation, Burst, Random, Sine, SpectralDensity, Tones};

use super::Source;
use super::harvester::{Kind, tone};
use super::plant::GRAVITY;
use crate::embedded::{Deviation, LINES, Vibration};
use crate::method::Failure;

/// What shakes the harvester in an hour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VibrationKind {
    Tone,
    Beat,
    Bursts,
    /// A tone whose frequency drifts, while the resonance drifts by 2 % with the temperature.
    Drift,
    Broadband,
    /// The bed of a truck on a highway, with stops.
    Truck,
    /// A wagon, with stops.
    Rail,
    /// A machine whose speed rises and falls for hours.
    Speed,
    /// A foot strikes twice a second, with rests.
    Walking,
    Silence,
}

impl VibrationKind {
    /// Those of random hours.
    pub const RANDOM: [Self; 5] = [Self::Tone, Self::Beat, Self::Bursts, Self::Drift, Self::Broadband];
}

/// The kind of hours of a timeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Course {
    /// Tones, beats, bursts, drifting tones and broadband vibration, hour by hour
    Random,
    /// MIL-STD-810, method 514: a truck on highways, vertical axis, with stops
    Truck,
    /// A machine whose speed drifts
    Speed,
    /// Walking at two steps a second, with rests
    Walking,
    /// Random hours from 8 to 16 o'clock of working days, over 30 days
    Month,
    /// IEC 60721-3-2, class 2M2: goods on a train, with stops
    Rail,
}

/// Some hours of a harvester.
#[derive(Debug, Clone)]
pub struct Timeline {
    pub kind: Kind,
    /// Whether the harvester is the one of the map.
    pub as_designed: bool,
    /// Of each hour.
    pub hour_kinds: Vec<VibrationKind>,
    /// Of each minute.
    pub vibration: Vec<Vibration>,
    /// Energies in J of each minute.
    pub minutes: Vec<f64>,
}

/// Sines of the vibration of a vehicle near a resonance.
const VEHICLE_LINES: usize = 60;

/// One-sided spectral density in g²/Hz of MIL-STD-810, method 514, a truck on highways, vertical axis: even to 40 Hz, then
/// straight in logarithmic axes to a hundredth at 500 Hz.
fn truck(frequency: f64) -> f64 {
    0.015 * if frequency > 40.0 { libm::pow(frequency / 40.0, -2.0 / libm::log10(12.5)) } else { 1.0 }
}

/// One-sided spectral density in m²/s³ of IEC 60721-3-2, classes 2M1 and 2M2, of goods on wheels: 1 to 200 Hz, and 0.3 above.
fn rail(frequency: f64) -> f64 {
    if frequency > 200.0 { 0.3 } else { 1.0 }
}

impl Timeline {
    /// Hours of a course by a seed. A harvester that is not as designed is off in charge, damping, load and resonance, and its
    /// resonance drifts by 2 % in hours of drift.
    ///
    /// # Errors
    /// If a shipped scene cannot be read or stepped.
    pub fn new(
        kind: Kind,
        as_designed: bool,
        course: Course,
        hours: usize,
        seed: u64,
    ) -> Result<Self, Failure> {
        let mut random = Source::of_seed(seed);
        let (mut vibration, mut hour_kinds) = (Vec::new(), Vec::<VibrationKind>::new());
        for _ in 0..hours {
            let vibration_kind = match course {
                Course::Random | Course::Month => drawn(kind, &mut random),
                Course::Truck => VibrationKind::Truck,
                Course::Rail => VibrationKind::Rail,
                Course::Speed => VibrationKind::Speed,
                Course::Walking => VibrationKind::Walking,
            };
            // A tone goes on for some hours.
            let goes_on =
                vibration_kind == VibrationKind::Tone && hour_kinds.last() == Some(&VibrationKind::Tone);
            if goes_on && random.uniform(0.0, 1.0) < 0.6 {
                vibration.extend_from_within(vibration.len() - 60..);
            } else {
                vibration
                    .extend(hour(kind, vibration_kind, hour_kinds.len(), &mut random).unwrap_or_default());
            }
            hour_kinds.push(vibration_kind);
        }
        let mut factor = |most: f64| libm::pow(most, 2.0 * random.uniform(0.0, 1.0) - 1.0);
        let off = if as_designed {
            Deviation::NONE
        } else {
            Deviation {
                charge: factor(1.41),
                damping: factor(1.7),
                resistance: factor(1.5),
                resonance: factor(1.005),
            }
        };
        let minutes = kind.minutes(&vibration, &|minute| {
            let part = (minute % 60) as f64 / 60.0 - 0.5;
            let drifts = hour_kinds[minute / 60] == VibrationKind::Drift && !as_designed;
            Deviation { resonance: off.resonance * if drifts { 1.0 + 0.02 * part } else { 1.0 }, ..off }
        })?;
        let line = Self { kind, as_designed, hour_kinds, vibration, minutes };
        Ok(if course == Course::Month { line.month() } else { line })
    }

    /// The same hours in turn from 8 to 16 o'clock of the working days of thirty days.
    fn month(&self) -> Self {
        let (mut to, mut at) = (Self { hour_kinds: vec![], vibration: vec![], minutes: vec![], ..*self }, 0);
        for hour in 0..30 * 24 {
            if hour / 24 % 7 < 5 && (8..16).contains(&(hour % 24)) && !self.hour_kinds.is_empty() {
                let from = at % self.hour_kinds.len();
                to.hour_kinds.push(self.hour_kinds[from]);
                to.vibration.extend_from_slice(&self.vibration[60 * from..60 * from + 60]);
                to.minutes.extend_from_slice(&self.minutes[60 * from..60 * from + 60]);
                at += 1;
            } else {
                to.hour_kinds.push(VibrationKind::Silence);
                to.vibration.extend(vec![AnyExcitation::Silence; 60]);
                to.minutes.extend([0.0; 60]);
            }
        }
        to
    }
}

/// The kind of vibration of a random hour: a tone as often as all others but one.
fn drawn(kind: Kind, random: &mut Source) -> VibrationKind {
    let vibration_kind =
        VibrationKind::RANDOM[(random.uniform(0.0, 1.0) * 7.0) as usize % VibrationKind::RANDOM.len()];
    // Friction holds the slider under most noises.
    let still = kind.is_slider() && vibration_kind == VibrationKind::Broadband;
    if still { VibrationKind::Tone } else { vibration_kind }
}

/// Minutes of which `on` are of one vibration and `off` silent, in turn.
fn in_turn([on, off]: [usize; 2], vibration: &Vibration) -> Vec<Vibration> {
    let at =
        |minute: usize| if minute % (on + off) < on { vibration.clone() } else { AnyExcitation::Silence };
    (0..60).map(at).collect()
}

/// A random acceleration of a spectral density between two points.
fn noise(points: [[f64; 2]; 2], lines: usize, random: &mut Source) -> Option<Vibration> {
    let density = SpectralDensity::new(&points).ok()?;
    let seed = (1e9 * random.uniform(0.0, 1.0)) as u64;
    Some(AnyExcitation::Random(Random::new(&density, lines as u32, seed).ok()?))
}

/// The vibration of sixty minutes, from the hour of this index on.
fn hour(kind: Kind, of: VibrationKind, index: usize, random: &mut Source) -> Option<Vec<Vibration>> {
    let [[low, high], [first, last]] = kind.vibration();
    let [resonance, half] = kind.resonance();
    let amplitude = low * libm::pow(high / low, random.uniform(0.0, 1.0));
    // Nearer to the resonance more often.
    let frequency = |random: &mut Source| {
        let part = 0.5 * (random.uniform(0.0, 1.0) + random.uniform(0.0, 1.0));
        first + (last - first) * part
    };
    let whole =
        |random: &mut Source, least: usize, more: f64| least + (more * random.uniform(0.0, 1.0)) as usize;
    let centre = frequency(random);
    let tones = |at: &dyn Fn(u32) -> f64| (0..60).map(|minute| tone(amplitude, at(minute))).collect();
    Some(match of {
        VibrationKind::Silence => vec![AnyExcitation::Silence; 60],
        VibrationKind::Tone => vec![tone(amplitude, centre); 60],
        VibrationKind::Beat => {
            let mut both = Tones::new();
            both.push(Sine::new(amplitude, centre, 0.3).ok()?).ok()?;
            let other = frequency(random);
            let beside = amplitude * (0.1 + 0.6 * random.uniform(0.0, 1.0));
            both.push(Sine::new(beside, other, 0.3).ok()?).ok()?;
            vec![AnyExcitation::Tones(both); 60]
        }
        VibrationKind::Bursts => {
            let spans = [whole(random, 2, 8.0), whole(random, 2, 8.0)];
            in_turn(spans, &tone(amplitude, centre))
        }
        VibrationKind::Drift => {
            let end = frequency(random);
            tones(&|minute| centre + (end - centre) * f64::from(minute) / 60.0)
        }
        VibrationKind::Speed => {
            // Up in five hours and down in five.
            let part = |minute: u32| (f64::from(60 * index as u32 + minute) / 300.0 + 0.5).rem_euclid(2.0);
            tones(&|minute| first + (last - first) * (1.0 - (part(minute) - 1.0).abs()))
        }
        VibrationKind::Broadband => {
            // Even density from 0.8 to 1.25 of the resonance, with the mean square within ten half-bandwidths of a sine.
            let density = 0.5 * amplitude * amplitude / (10.0 * half) * random.uniform(0.0, 1.0).max(0.05);
            vec![noise([[0.8 * resonance, density], [1.25 * resonance, density]], LINES, random)?; 60]
        }
        VibrationKind::Truck | VibrationKind::Rail => {
            let is_truck = of == VibrationKind::Truck;
            let density = |hertz| if is_truck { GRAVITY * GRAVITY * truck(hertz) } else { rail(hertz) };
            // What is near the resonance.
            let points = [0.93 * resonance, 1.07 * resonance].map(|hertz| [hertz, density(hertz)]);
            let spans = [whole(random, 15, 30.0), whole(random, 3, 15.0)];
            in_turn(spans, &noise(points, VEHICLE_LINES, random)?)
        }
        VibrationKind::Walking => {
            let peak = 10.0 + 10.0 * random.uniform(0.0, 1.0);
            let strikes = Burst::half_sine(peak, 0.02).ok()?.every(0.5).ok()?;
            let spans = [whole(random, 5, 20.0), whole(random, 2, 10.0)];
            in_turn(spans, &AnyExcitation::Burst(strikes))
        }
    })
}
