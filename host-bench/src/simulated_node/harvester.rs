//! The harvesters of the simulated nodes.

use std::path::Path;
use std::sync::OnceLock;

use model_core::clock::Instant;
use model_core::excitation::{AnyExcitation, Excitation, Silence, Sine};

use crate::embedded::{Deviation, Vibration, energies_by_minute, natural_frequency_hz};
use crate::map::{self, Request, Step};
use crate::method::{Failure, Options};
use crate::scene_file::{self, Excitation as Base, Load, Scene, Tone};

/// A harvester of which there is a response map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Kind {
    ContactSeparation,
    Sliding,
    BumpStop,
    /// That of a scene file.
    #[value(skip)]
    Other,
}

/// A harvester of a scene file: its scene, [`Kind::resonance`], [`Kind::vibration`], and its map.
#[derive(Debug)]
struct Other {
    scene: Scene,
    resonance: [f64; 2],
    vibration: [[f64; 2]; 2],
    map: Vec<u8>,
}

static OTHER: OnceLock<Other> = OnceLock::new();

impl Kind {
    /// That of a scene file, with its map; one of a process. It is for vibration from a quarter to 1.5 of the amplitude of its sine,
    /// within 4 % of the resonance. Refuses another excitation, another load, and a stop.
    pub(crate) fn of_file(file: &Path, step: &(impl Fn(Step) + Sync)) -> Result<Self, Failure> {
        let scene = scene_file::read(file, &[])?;
        let refuse = |text: String| Err(Failure::of_file(&scene, text));
        let natural = natural_frequency_hz(&scene)?;
        let (Base::Sine(Tone { amplitude_m_per_s2: amplitude, .. }), Load::Resistor { .. }) =
            (&scene.excitation, scene.load)
        else {
            return refuse("excitation.kind must be \"sine\", load.kind \"resistor\"".to_owned());
        };
        if scene.bump_stop().is_ok_and(|model| model.stop.is_some()) {
            return refuse("stop: must be absent: of a beam the first mode alone is simulated".to_owned());
        }
        // A tenth of the lowest rate of a sensor, and 0.45 of the highest one.
        if !(10.0..=360.0).contains(&natural) {
            return refuse(format!("the natural frequency is {natural:.4} Hz: must be from 10 to 360 Hz"));
        }
        let of = |of: [f64; 2], unit: f64| of.map(|of| of * unit);
        let [amplitudes, frequencies] = [of([0.05, 2.0], *amplitude), of([0.85, 1.2], natural)];
        let request =
            Request { amplitudes, frequencies, voltages: vec![], error: 0.02, places: 300, seed: 1 };
        request.check()?;
        let found = map::map(&scene, &request, &Options::default(), step)?;
        let centre = found.axes.centre_hz;
        OTHER.get_or_init(|| Other {
            resonance: [centre, found.axes.half_bandwidth_hz],
            vibration: [of([0.25, 1.5], *amplitude), of([0.96, 1.04], centre)],
            map: map::bytes(&found),
            scene: scene.clone(),
        });
        Ok(Self::Other)
    }

    fn other(self) -> Option<&'static Other> {
        OTHER.get().filter(|_| self == Self::Other)
    }

    /// Whether friction holds it under random vibration and under steps.
    pub(super) fn is_slider(self) -> bool {
        self.other().map_or(self == Self::Sliding, |other| other.scene.sliding().is_ok())
    }

    /// Samples of its vibration in a second.
    pub(super) fn rate(self) -> f64 {
        [100.0, 400.0].into_iter().find(|rate| self.resonance()[0] <= 0.45 * rate).unwrap_or(800.0)
    }

    /// Resonance and half-bandwidth in Hz.
    pub fn resonance(self) -> [f64; 2] {
        let shipped = || [[20.1325, 0.09625], [18.37313, 0.064306], [245.16, 2.64]][self as usize];
        self.other().map_or_else(shipped, |other| other.resonance)
    }

    /// Amplitudes in m/s² and frequencies in Hz of vibration that the harvester is for.
    pub(super) fn vibration(self) -> [[f64; 2]; 2] {
        let [mass, slider, beam] =
            [[[0.5, 3.0], [19.3, 21.0]], [[3.5, 7.0], [17.9, 18.9]], [[5.0, 40.0], [232.0, 258.0]]];
        self.other().map_or_else(|| [mass, slider, beam][self as usize], |other| other.vibration)
    }

    /// The response map of the harvester as designed.
    pub fn map(self) -> &'static [u8] {
        match self {
            Self::ContactSeparation => include_bytes!("contact-separation.bin"),
            Self::Sliding => include_bytes!("sliding.bin"),
            Self::BumpStop => include_bytes!("bump-stop.bin"),
            Self::Other => self.other().map_or(&[], |other| &other.map),
        }
    }

    /// [`energies_by_minute`] of its scene, as shipped or of the file.
    ///
    /// # Errors
    /// If the scene cannot be read or stepped.
    pub fn minutes(
        self,
        vibration: &[Vibration],
        off: &dyn Fn(usize) -> Deviation,
    ) -> Result<Vec<f64>, Failure> {
        let name = || ["node", "sliding", "bump-stop-none"][self as usize];
        let shipped = || scene_file::read(&scene_file::shipped(name()), &[]);
        let scene = self.other().map_or_else(shipped, |other| Ok(other.scene.clone()))?;
        energies_by_minute(&scene, vibration, off)
    }
}

/// A sine of an amplitude in m/s² and a frequency in Hz; silence without an amplitude.
pub fn tone(amplitude: f64, frequency: f64) -> Vibration {
    Sine::new(amplitude, frequency, 0.3)
        .ok()
        .filter(|_| amplitude > 0.0)
        .map_or(AnyExcitation::Silence, AnyExcitation::Sine)
}

/// Acceleration in m/s² at a time in s since the start of a minute of a timeline.
pub(super) fn acceleration(vibration: &Vibration, minute: usize, seconds: f64) -> f64 {
    let at = Instant::from_seconds(60.0 * (minute % 10) as f64 + seconds);
    at.map_or(0.0, |at| match vibration {
        AnyExcitation::Silence => Excitation::<f64>::acceleration(&Silence, at),
        other => other.acceleration(at),
    })
}
