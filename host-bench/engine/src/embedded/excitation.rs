//! The excitation and the load of a scene file as those of the core.

use model_core::excitation::{
    AfterLastSample, Burst, Excitation, ExcitationError, Random, Sampled, Silence, Sine, SpectralDensity,
    Sweep, SweepLaw, Tones,
};
use model_core::part::draw::{AnyDraw, CurrentDraw, Lockout, PowerDraw, ResistiveDraw};
use model_core::part::rectifier::FullBridge;
use model_core::part::storage::{AnyStorage, Capacitor, DcBus, StorageCapacitor};
use model_core::scalar::{Mathematics, Scalar};

use harvester_scene::method::{Failure, Options};
use harvester_scene::scene_file::{self, BurstShape, Draw, Load, Scene, Tone};

/// Sines that a sum may have.
const MOST_TONES: usize = 32;

/// The core's excitation for any scene file, behind a reference: the run is compiled once for all of them.
pub(super) type HostExcitation<'a, S> = &'a dyn Excitation<S>;

/// What every run of a scene needs, whatever the scene is.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a, S> {
    pub(super) scene: &'a Scene,
    pub(super) options: &'a Options,
    pub(super) excitation: HostExcitation<'a, S>,
    /// Name of the elementary functions.
    pub(super) math: &'static str,
}

/// Calls `with` with the setting of a scene in the precision `S` with the elementary functions `M`.
///
/// The samples of a trace are converted here and live for the call.
pub(super) fn with_setting<S, M, R>(
    scene: &Scene,
    options: &Options,
    with: impl FnOnce(Setting<'_, S>) -> Result<R, Failure>,
) -> Result<R, Failure>
where
    S: Scalar,
    M: Mathematics<S>,
{
    let refuse = |error: ExcitationError| Failure::of_file(scene, format!("excitation: {error}"));
    let with =
        |excitation: HostExcitation<'_, S>| with(Setting { scene, options, excitation, math: M::NAME });
    match &scene.excitation {
        scene_file::Excitation::Silence => with(&Silence),
        scene_file::Excitation::Sine(tone) => with(&sine::<S, M>(tone).map_err(refuse)?),
        scene_file::Excitation::Sines(list) => {
            let mut tones = Tones::<S, MOST_TONES, M>::new();
            for tone in list {
                tones.push(sine(tone).map_err(refuse)?).map_err(|_| {
                    let count = list.len();
                    Failure::of_file(
                        scene,
                        format!("excitation.tones: {count} tones, must be at most {MOST_TONES}"),
                    )
                })?;
            }
            with(&tones)
        }
        scene_file::Excitation::File(trace) => {
            let samples: Vec<S> = trace.samples_m_per_s2.iter().map(|&sample| S::from_f64(sample)).collect();
            let after = if trace.repeat { AfterLastSample::Repeat } else { AfterLastSample::Silence };
            with(&Sampled::new(&samples, S::from_f64(trace.rate_hz), after).map_err(refuse)?)
        }
        scene_file::Excitation::Burst(given) => with(&burst::<S, M>(given).map_err(refuse)?),
        scene_file::Excitation::Sweep(given) => with(&sweep::<S, M>(given).map_err(refuse)?),
        scene_file::Excitation::Random(given) => {
            let points: Vec<[S; 2]> = given.density.iter().map(|point| point.map(S::from_f64)).collect();
            let density = SpectralDensity::new(&points).map_err(refuse)?;
            // On the heap: its capacity is that of the most lines.
            let random =
                Random::<S, { scene_file::Random::MOST_LINES }, M>::new(&density, given.lines, given.seed);
            with(&*random.map(Box::new).map_err(refuse)?)
        }
    }
}

fn sine<S: Scalar, M: Mathematics<S>>(tone: &Tone) -> Result<Sine<S, M>, ExcitationError> {
    Sine::new(
        S::from_f64(tone.amplitude_m_per_s2),
        S::from_f64(tone.frequency_hz),
        S::from_f64(tone.phase_rad),
    )
}

fn burst<S: Scalar, M: Mathematics<S>>(burst: &scene_file::Burst) -> Result<Burst<S, M>, ExcitationError> {
    let amplitude = S::from_f64(burst.amplitude_m_per_s2);
    let once = match burst.shape {
        BurstShape::HalfSine { duration_s } => Burst::half_sine(amplitude, S::from_f64(duration_s)),
        BurstShape::Cycles { frequency_hz, cycles } => {
            Burst::cycles(amplitude, S::from_f64(frequency_hz), cycles)
        }
    };
    let once = once?.starting_at(S::from_f64(burst.start_s))?;
    burst.period_s.map_or(Ok(once), |period| once.every(S::from_f64(period)))
}

fn sweep<S: Scalar, M: Mathematics<S>>(sweep: &scene_file::Sweep) -> Result<Sweep<S, M>, ExcitationError> {
    let law = if sweep.logarithmic { SweepLaw::Logarithmic } else { SweepLaw::Linear };
    Sweep::new(
        S::from_f64(sweep.amplitude_m_per_s2),
        [sweep.from_hz, sweep.to_hz].map(S::from_f64),
        S::from_f64(sweep.sweep_s),
        law,
        S::from_f64(sweep.phase_rad),
    )
}

/// The bridge; `None` where the load is a resistor.
pub(super) fn bridge<S: Scalar>(load: Load) -> Option<FullBridge<S, AnyStorage<S>>> {
    let number = S::from_f64;
    match load {
        Load::Resistor { .. } => None,
        Load::RectifiedStore(store) => Some(FullBridge {
            diode_drop: number(store.diode_drop_v),
            storage: AnyStorage::Capacitor(StorageCapacitor {
                capacitor: Capacitor {
                    capacitance: number(store.capacitance_f),
                    leakage_resistance: number(store.leakage_ohm),
                },
                initial_voltage: initial_voltage(store.initial_v, store.draw.lockout()),
                draw: draw(store.draw),
            }),
        }),
        Load::DcBus { voltage_v, diode_drop_v } => Some(FullBridge {
            diode_drop: number(diode_drop_v),
            storage: AnyStorage::DcBus(DcBus { voltage: number(voltage_v) }),
        }),
    }
}

/// The start voltage in V; of a draw that it does not connect, below the rounded turn-on voltage.
fn initial_voltage<S: Scalar>(initial_v: f64, lockout: Option<scene_file::Lockout>) -> S {
    let below = lockout.filter(|lockout| initial_v < lockout.turn_on_v);
    let most = below.map(|lockout| S::from_f64(lockout.turn_on_v) * (S::ONE - S::EPSILON));
    most.map_or(S::from_f64(initial_v), |most| S::from_f64(initial_v).min(most))
}

fn draw<S: Scalar>(draw: Draw) -> AnyDraw<S> {
    let number = S::from_f64;
    let thresholds = |lockout: scene_file::Lockout| Lockout {
        turn_on: number(lockout.turn_on_v),
        turn_off: number(lockout.turn_off_v),
    };
    match draw {
        Draw::None => AnyDraw::None,
        Draw::Resistor { resistance_ohm, lockout } => AnyDraw::Resistor(ResistiveDraw {
            resistance: number(resistance_ohm),
            lockout: lockout.map(thresholds),
        }),
        Draw::Current { current_a, lockout } => {
            AnyDraw::Current(CurrentDraw { current: number(current_a), lockout: thresholds(lockout) })
        }
        Draw::Power { power_w, lockout } => {
            AnyDraw::Power(PowerDraw { power: number(power_w), lockout: thresholds(lockout) })
        }
    }
}
