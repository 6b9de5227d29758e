//! The day of the firmware's node: what shakes its harvester, and what a harvester that is not as designed gives of it, by
//! the full model.
//!
//! The machine stands still at night, and for two minutes at each full hour, in which the harvester comes to rest: so each
//! hour is computed by itself.

use std::fmt::Write;
use std::ops::RangeInclusive;

use firmware_example::node::plant::Minute;
use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::{Sine, Tones};
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::scalar::Polynomial;
use model_core::scene::contact_separation::Start;
use model_core::scene::{Harvester, Simulation};

use super::Error;
use crate::embedded::contact_separation_parameters;
use crate::run::each;
use crate::scene_file;
use crate::stability::random::Source;

/// What shakes the harvester in a minute: amplitudes in mm/s² and frequencies in mHz of two lines.
pub type Lines = [[u16; 2]; 2];

/// By what factors the true harvester differs from `node.toml`, of which the map is. Power goes with the charge density squared.
const CHARGE: f64 = 0.85;
const DAMPING: f64 = 1.4;
const RESISTANCE: f64 = 1.3;
const RESONANCE: f64 = 1.002;
/// How far the resonance is off by the temperature: higher in the coldest hour, lower in the warmest.
const DRIFT: f64 = 0.01;
const COLDEST: f64 = 3.0;
/// Relative tolerance of the trajectory.
const TOLERANCE: f64 = 1e-3;

/// Amplitude of the machine in mm/s², and its part in each hour, in per cent.
const AMPLITUDE: u32 = 1962;
const HOURS: [u32; 24] =
    [0, 0, 0, 0, 0, 50, 100, 100, 100, 70, 100, 100, 50, 100, 100, 100, 70, 100, 100, 100, 50, 0, 0, 0];
/// Frequencies of the machine in mHz.
const FREQUENCIES: RangeInclusive<u16> = 20_200..=20_500;
/// Minutes at the start of an hour in which the machine stands still.
const STILL: usize = 2;

/// What shakes the harvester, minute by minute.
pub fn vibration() -> Vec<Lines> {
    let mut random = Source::of_seed(7);
    HOURS.iter().flat_map(|&part| hour((AMPLITUDE * part / 100) as u16, &mut random)).collect()
}

/// An hour of the machine: an even line, one that wanders, two lines, or bursts.
fn hour(amplitude: u16, random: &mut Source) -> Vec<Lines> {
    let kind = random.whole(0..=3);
    let (from, to, beside) =
        (random.whole(FREQUENCIES), random.whole(FREQUENCIES), random.whole(19_600..=21_000));
    let (part, on, off) = (random.whole(10..=30), random.whole(4..=12), random.whole(2..=6));
    let lines = |minute: usize| {
        let wandered = i32::from(from) + (i32::from(to) - i32::from(from)) * minute as i32 / 60;
        match kind {
            _ if amplitude == 0 || minute < STILL => [[0; 2]; 2],
            0 => [[amplitude, from], [0; 2]],
            1 => [[amplitude, wandered as u16], [0; 2]],
            2 => [[amplitude, from], [(u32::from(amplitude) * u32::from(part) / 100) as u16, beside]],
            _ if (minute - STILL) % usize::from(on + off) < usize::from(on) => [[amplitude, from], [0; 2]],
            _ => [[0; 2]; 2],
        }
    };
    (0..60).map(lines).collect()
}

/// What the true harvester gives in the first so many minutes of an hour of the day, in nJ.
///
/// # Errors
///
/// If `node.toml` cannot be read, or the model not be stepped.
pub fn energies(vibration: &[Lines], hour: usize, minutes: usize) -> Result<Vec<u32>, Error> {
    let mut energies = Vec::new();
    let mut state = None;
    let mut turns = [0.0; 2];
    for (minute, lines) in vibration.iter().skip(60 * hour).take(minutes.min(60)).enumerate() {
        let harvester = harvester(hour as f64 + minute as f64 / 60.0)?;
        let base = base(lines, minute, &mut turns)?;
        let mut now = match state {
            Some(state) => state,
            None => harvester.start(&Start::default(), &base).map_err(fail)?,
        };
        let mut meter = PowerMeter::new();
        let end = Instant::from_whole_seconds(60 * (minute as u32 + 1));
        harvester.advance(&mut now, &base, end, u32::MAX, &mut meter).map_err(fail)?;
        state = Some(now);
        energies.push((1e9 * meter.delivered_energy()).round() as u32);
    }
    Ok(energies)
}

fn fail(error: impl ToString) -> Error {
    Error::Host(error.to_string())
}

/// The true harvester at an hour of the day.
fn harvester(hour: f64) -> Result<impl Harvester<f64, Start = Start<f64>, State: Clone>, Error> {
    let scene = scene_file::read_shipped("node", &[]).map_err(fail)?;
    let model = scene.contact_separation().map_err(fail)?;
    let mut parameters = contact_separation_parameters::<f64, Polynomial>(model, scene.load);
    let warmth = -(std::f64::consts::TAU * (hour - COLDEST) / 24.0).cos();
    let resonance = RESONANCE * (1.0 - DRIFT * warmth);
    parameters.stiffness *= resonance * resonance;
    parameters.charge_density *= CHARGE;
    parameters.damping_ratio *= DAMPING;
    parameters.choices.load.resistance *= RESISTANCE;
    let scene = parameters.build().map_err(fail)?;
    Ok(Simulation::new(scene, ExponentialRadau, Adaptive::new(TOLERANCE).map_err(fail)?))
}

/// The acceleration of the base in a minute of an hour. The phases of the lines, in turns, go on from minute to minute.
fn base(lines: &Lines, minute: usize, turns: &mut [f64; 2]) -> Result<Tones<f64, 2>, Error> {
    let mut base = Tones::new();
    for ([amplitude, frequency], turns) in lines.iter().zip(turns) {
        let frequency = f64::from(*frequency) / 1000.0;
        let phase = (*turns - frequency * 60.0 * minute as f64).rem_euclid(1.0);
        *turns = (*turns + 60.0 * frequency).rem_euclid(1.0);
        if *amplitude > 0 {
            let amplitude = f64::from(*amplitude) / 1000.0;
            let sine = Sine::new(amplitude, frequency, std::f64::consts::TAU * phase).map_err(fail)?;
            base.push(sine).map_err(|_| fail("two lines have room"))?;
        }
    }
    Ok(base)
}

/// The whole day.
///
/// # Errors
///
/// As [`energies`].
pub fn day() -> Result<Vec<Minute>, Error> {
    let vibration = vibration();
    let hours: Vec<usize> = (0..HOURS.len()).collect();
    let energies = each(&hours, |&hour| energies(&vibration, hour, 60));
    let energies = energies.into_iter().collect::<Result<Vec<_>, _>>()?;
    let minutes = vibration.into_iter().zip(energies.into_iter().flatten());
    Ok(minutes.map(|(lines, energy)| Minute { lines, energy }).collect())
}

/// The day as the build script of the firmware reads it.
pub fn table(day: &[Minute]) -> String {
    let mut text = format!(
        "# A day of the harvester of node.toml, minute by minute, that is not as designed: charge density x {CHARGE},
# damping x {DAMPING}, load x {RESISTANCE}, resonance x {RESONANCE} and by the temperature {DRIFT} to either side. Made by the full \
         model:
# host-bench on-target --day firmware-example/trace/day.csv
amplitude_mm_per_s2,frequency_mhz,second_amplitude_mm_per_s2,second_frequency_mhz,energy_nj
"
    );
    for Minute { lines: [[one, at], [other, other_at]], energy } in day {
        let _ = writeln!(text, "{one},{at},{other},{other_at},{energy}");
    }
    text
}
