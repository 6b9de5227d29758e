//! What harvesters yield, minute by minute, by trajectories of the full model over whole hours.

use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::{AnyExcitation, Excitation, Random, Silence, Sine, SpectralDensity, Tones};
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::part::load::Resistor;
use model_core::part::monomorph::Layer;
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::VelocityDependentRestitution;
use model_core::scene::bump_stop::Stepper;
use model_core::scene::{Harvester, Simulation};
use model_core::scene::{bump_stop, contact_separation, sliding};

use super::plant::Source;

/// Sines of a random acceleration.
const LINES: usize = 200;
/// Relative tolerance of the trajectories.
const TOLERANCE: f64 = 1e-3;

pub(super) type Shaking = AnyExcitation<'static, f64, LINES>;

/// A harvester as its map has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    ContactSeparation,
    Sliding,
    BumpStop,
}

pub(super) const KINDS: [Kind; 3] = [Kind::ContactSeparation, Kind::Sliding, Kind::BumpStop];

/// By what factors the true harvester differs from that of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Off {
    /// Of charge density, or of the piezoelectric coefficient: the yield goes with its square.
    pub(super) charge: f64,
    pub(super) damping: f64,
    pub(super) resistance: f64,
    /// Of the resonance.
    pub(super) resonance: f64,
}

pub(super) const AS_DESIGNED: Off = Off { charge: 1.0, damping: 1.0, resistance: 1.0, resonance: 1.0 };

impl Kind {
    /// Resonance and half-bandwidth in Hz.
    pub(super) fn resonance(self) -> [f64; 2] {
        [[20.1325, 0.09625], [18.37313, 0.064306], [245.16, 2.64]][self as usize]
    }

    /// Amplitudes in m/s² and frequencies in Hz of shaking that the harvester is for.
    pub(super) fn shaking(self) -> [[f64; 2]; 2] {
        [[[0.5, 3.0], [19.3, 21.0]], [[3.5, 7.0], [17.9, 18.9]], [[5.0, 40.0], [232.0, 258.0]]][self as usize]
    }

    /// Energies in J of each minute under the shaking of that minute; `off` at each tenth minute.
    pub(super) fn minutes(self, shaking: &[Shaking], off: impl Fn(usize) -> Off) -> Vec<f64> {
        match self {
            Self::ContactSeparation => energies(shaking, |minute| contact_separation(off(minute))),
            Self::Sliding => energies(shaking, |minute| sliding(off(minute))),
            Self::BumpStop => energies(shaking, |minute| bump_stop(off(minute))),
        }
    }
}

/// Each ten minutes the harvester is another one, at rest.
fn energies<H: Harvester<f64>>(shaking: &[Shaking], harvester: impl Fn(usize) -> H) -> Vec<f64> {
    let mut energies = Vec::new();
    for (part, shakings) in shaking.chunks(10).enumerate() {
        let harvester = harvester(10 * part);
        let mut state = harvester.start(&H::Start::default(), &shakings[0]).expect("starts");
        for (index, shaking) in shakings.iter().enumerate() {
            let mut meter = PowerMeter::new();
            let end = Instant::from_whole_seconds(60 * (index as u32 + 1));
            harvester.advance(&mut state, shaking, end, u32::MAX, &mut meter).expect("advances");
            energies.push(meter.delivered_energy());
        }
    }
    energies
}

fn contact_separation(off: Off) -> impl Harvester<f64> {
    let restitution: VelocityDependentRestitution<f64> = VelocityDependentRestitution {
        at_rest: 0.8,
        at_speed: 0.5,
        reference_speed: 0.3,
        mathematics: std::marker::PhantomData,
    };
    let load = Resistor { resistance: 2e7 * off.resistance };
    let scene = contact_separation::Parameters {
        mass: 20e-3,
        stiffness: 320.0 * off.resonance * off.resonance,
        damping_ratio: 0.005 * off.damping,
        initial_gap: 3e-3,
        electrode_area: 20e-4,
        dielectric_thickness: 5e-5,
        relative_permittivity: 2.0,
        charge_density: 50e-6 * off.charge,
        choices: contact_separation::Choices::new(load, restitution)
            .force_law(contact_separation::GapField)
            .parasitic(ParasiticCapacitance { capacitance: 1e-12 }),
    }
    .build()
    .expect("valid");
    Simulation::new(scene, ExponentialRadau, Adaptive::new(TOLERANCE).expect("valid"))
}

fn sliding(off: Off) -> impl Harvester<f64> {
    let friction = sliding::PatchFriction {
        static_active: 0.35,
        static_inert: 0.25,
        kinetic_active: 0.30,
        kinetic_inert: 0.20,
    };
    let scene = sliding::Parameters {
        beam_length: 0.1,
        beam_width: 20e-3,
        beam_thickness: 0.5e-3,
        young_modulus: 210e9 * off.resonance * off.resonance,
        density: 7800.0,
        damping_ratio: 0.0035 * off.damping,
        slider_mass: 8e-3,
        patch_radius: 10e-3,
        dielectric_thickness: 0.05e-3,
        relative_permittivity: 2.0,
        charge_density: 80e-6 * off.charge,
        choices: sliding::Choices::new(Resistor { resistance: 1e8 * off.resistance }, friction)
            .force_law(sliding::TransferredCharge),
    }
    .build()
    .expect("valid");
    Simulation::new(scene, ExponentialRadau, Adaptive::new(TOLERANCE).expect("valid"))
}

/// With its first mode only, whose share of the power near the resonance is all but 10⁻³.
fn bump_stop(off: Off) -> impl Harvester<f64> {
    let scene = bump_stop::Parameters {
        beam_length: 50e-3,
        beam_width: 10e-3,
        substrate: Layer {
            thickness: 0.5e-3,
            young_modulus: 200e9 * off.resonance * off.resonance,
            density: 7850.0,
        },
        piezo: Layer {
            thickness: 0.5e-3,
            young_modulus: 66e9 * off.resonance * off.resonance,
            density: 7800.0,
        },
        piezo_d31: -190e-12 * off.charge,
        piezo_permittivity: 15.93e-9,
        damping_ratio: 0.01 * off.damping,
        choices: bump_stop::Choices::new(Resistor { resistance: 1e6 * off.resistance }),
    }
    .build::<1, 0>()
    .expect("valid");
    Stepper::new(scene, 1e-4, 2e-4).expect("valid")
}

/// What shakes the harvester in an hour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Weather {
    Tone,
    Beat,
    Bursts,
    /// A tone whose frequency drifts, while the resonance drifts by 2 % with the temperature.
    Drift,
    Broadband,
}

pub(super) const WEATHERS: [Weather; 5] =
    [Weather::Tone, Weather::Beat, Weather::Bursts, Weather::Drift, Weather::Broadband];

/// The shaking of sixty minutes.
pub(super) fn hour(kind: Kind, weather: Weather, random: &mut Source) -> Vec<Shaking> {
    let [[low, high], [first, last]] = kind.shaking();
    let amplitude = low * (high / low).powf(random.uniform());
    // Nearer to the resonance more often.
    let frequency = |random: &mut Source| {
        let part = 0.5 * (random.uniform() + random.uniform());
        first + (last - first) * part
    };
    let centre = frequency(random);
    let sine = |amplitude, frequency| Sine::new(amplitude, frequency, 0.3).expect("valid");
    match weather {
        Weather::Tone => vec![AnyExcitation::Sine(sine(amplitude, centre)); 60],
        Weather::Beat => {
            let mut tones = Tones::new();
            tones.push(sine(amplitude, centre)).expect("room");
            let other = frequency(random);
            tones.push(sine(amplitude * (0.1 + 0.6 * random.uniform()), other)).expect("room");
            vec![AnyExcitation::Tones(tones); 60]
        }
        Weather::Bursts => {
            let (on, off) = (2 + (8.0 * random.uniform()) as usize, 2 + (8.0 * random.uniform()) as usize);
            (0..60)
                .map(|minute| {
                    if minute % (on + off) < on {
                        AnyExcitation::Sine(sine(amplitude, centre))
                    } else {
                        AnyExcitation::Silence
                    }
                })
                .collect()
        }
        Weather::Drift => {
            let end = frequency(random);
            (0..60)
                .map(|minute| {
                    AnyExcitation::Sine(sine(amplitude, centre + (end - centre) * f64::from(minute) / 60.0))
                })
                .collect()
        }
        Weather::Broadband => {
            // Even density from 0.7 to 1.4 of the resonance, with the mean square within ten half-bandwidths of a sine.
            let [resonance, half] = kind.resonance();
            let density = 0.5 * amplitude * amplitude / (10.0 * half) * random.uniform().max(0.05);
            let points = [[0.8 * resonance, density], [1.25 * resonance, density]];
            let density = SpectralDensity::new(&points).expect("valid");
            let random = Random::new(&density, LINES as u32, (1e9 * random.uniform()) as u64).expect("valid");
            vec![AnyExcitation::Random(random); 60]
        }
    }
}

/// A sine; silence without an amplitude.
pub(super) fn tone(amplitude: f64, frequency: f64) -> Shaking {
    if amplitude > 0.0 {
        AnyExcitation::Sine(Sine::new(amplitude, frequency, 0.3).expect("valid"))
    } else {
        AnyExcitation::Silence
    }
}

/// Acceleration at a time in s since the start of a minute that is the given one of ten.
pub(super) fn acceleration(shaking: &Shaking, minute: usize, seconds: f64) -> f64 {
    let at = Instant::from_seconds(60.0 * (minute % 10) as f64 + seconds).expect("positive");
    match shaking {
        AnyExcitation::Silence => Excitation::<f64>::acceleration(&Silence, at),
        other => other.acceleration(at),
    }
}
