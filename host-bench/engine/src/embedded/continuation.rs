//! A harvester under one sine of a held frequency, taken from one steady motion to the next by changes of the amplitude.
//!
//! The amplitude changes at a zero of the sine, so the acceleration is continuous. The state goes on, so a series of
//! rising amplitudes follows one steady motion until it ends, and a falling one follows another.

use model_core::clock::Instant;
use model_core::energy::{RunMeter, RunReport};
use model_core::excitation::{Excitation, Sine};
use model_core::integrate::ExponentialRadau;
use model_core::observer::{Observer, PowerIndex};
use model_core::scalar::{Polynomial, Scalar};
use model_core::scene::bump_stop::Circuit;
use model_core::scene::{Harvester, Scene as CoreScene, rectified};
use model_core::snapshot::Fingerprint;

use super::bump_stop::{begun, by_modes, parameters, resistance};
use super::excitation::{HostExcitation, Setting, bridge, with_setting};
use super::run::{refuse_parameter, refuse_start};
use super::triboelectric::{STATES, Triboelectric, behind_bridge, prepared};
use crate::steady_state::{Coordinates, ForcedSystem, MOST_ATTEMPTS, Spent, Verdict, Watching};
use harvester_scene::method::{Failure, Method, Options, Precision, refuse_first};
use harvester_scene::scene_file::{BumpStop, Excitation as SceneExcitation, Load, Scene, Tone};

/// Windows of transient after which a motion that has not settled counts as not periodic.
const MOST_WINDOWS: usize = 16;
/// The first of them, which are not measured then.
const SETTLING: usize = 4;
/// Fewest periods in a window.
const SHORTEST_WINDOW: f64 = 8.0;
/// Relative change from window to window below which windows agree.
const SETTLED: f64 = 1e-3;
/// Windows in succession that agree when a transient has settled.
const AGREE: usize = 3;

/// How a steady motion was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionKind {
    /// By shooting: a stable orbit of one period that the motion approaches.
    Orbit,
    /// By a transient until its power no longer changed.
    Transient,
    /// As a mean over a motion whose power goes on changing.
    Mean,
}

/// A steady motion at one amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Mean power into the load in W; of a bus, charge per second in A.
    pub value: f64,
    /// Whether the motion has impacts or contact, or of a slider whether it moves.
    pub is_upper: bool,
    pub found: MotionKind,
}

/// A harvester under a sine of a held frequency.
pub trait AmplitudeContinuation {
    /// Changes the amplitude, in m/s², and goes on until the motion is steady.
    fn settle(&mut self, amplitude: f64) -> Result<Motion, Failure>;

    /// Keeps the state, and gives its number.
    fn keep(&mut self) -> usize;

    /// Goes back to a kept state.
    fn go_back(&mut self, number: usize);

    /// Goes back to the start of the scene.
    fn rest(&mut self);

    /// Simulated periods so far.
    fn periods(&self) -> f64;
}

/// The caller's function, behind a reference: the sweep is compiled in this crate and not in the caller's.
type With<'a> = &'a mut dyn FnMut(&mut dyn AmplitudeContinuation) -> Result<(), Failure>;

/// Calls `with` with the harvester of a scene under a sine of `frequency_hz`. Its load is a resistor, or a bridge into a bus.
pub fn with_continuation<R>(
    scene: &Scene,
    frequency_hz: f64,
    options: &Options,
    with: impl FnOnce(&mut dyn AmplitudeContinuation) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let (mut with, mut found) = (Some(with), None);
    called(scene, frequency_hz, options, &mut |continuation| {
        found = with.take().map(|with| with(continuation));
        Ok(())
    })?;
    found.unwrap_or_else(|| unreachable!("a harvester that started calls once"))
}

/// [`with_continuation`] without a type that the caller chooses: it would be compiled with all harvesters in the caller's crate.
fn called(scene: &Scene, frequency_hz: f64, options: &Options, call: With<'_>) -> Result<(), Failure> {
    options.check()?;
    options.check_scene(scene)?;
    let own = by_harvester!(scene,
        triboelectric(_model) => Method::ExponentialRadau,
        bump_stop(_) => Method::DiscreteGradient);
    let is_own = options.method == Method::Auto || options.method == own;
    refuse_first(&[
        (!is_own, "--method: must be auto for steady motions over the amplitude"),
        (options.precision == Some(Precision::F32), "--precision f32: must be f64 for steady motions"),
        (options.math.is_some(), "--math: must not be given for steady motions over the amplitude"),
    ])?;
    let mut scene = scene.clone();
    scene.excitation = SceneExcitation::Sine(Tone { amplitude_m_per_s2: 0.0, frequency_hz, phase_rad: 0.0 });
    with_setting::<f64, Polynomial, _>(&scene, options, |setting| {
        by_harvester!(&scene,
        triboelectric(model) => triboelectric(setting, model, frequency_hz, call),
        bump_stop(model) => match bridge(setting.scene.load) {
            Some(bridge) => by_modes!(model, with_modes::<_>(setting, model, frequency_hz, call, bridge)),
            None => {
                let load = resistance(setting.scene.load);
                by_modes!(model, with_modes::<_>(setting, model, frequency_hz, call, load))
            }
        })
    })
}

/// The fingerprint of the harvester of a scene in `f32`, as a node has it: its parameters, and its load or the diodes of
/// its bridge; not the voltage of a storage.
pub fn fingerprint(scene: &Scene) -> Result<u32, Failure> {
    let mut fingerprint = Fingerprint::new();
    by_harvester!(scene,
    triboelectric(model) => {
        let core = model.core::<f32, Polynomial>(scene)?;
        CoreScene::<f32, STATES, 0>::identify(&core, &mut fingerprint);
    },
    // With the modes of its scene, behind a bridge with open terminals.
    bump_stop(model) => {
        let [beam, rod] = model.modes();
        let core = parameters::<f32>(model, scene.load)
            .build_first::<20, 20>(beam, rod)
            .map_err(|error| refuse_parameter(scene, &error))?;
        core.identify_first([beam, rod], &mut fingerprint);
    });
    if let Some(bridge) = bridge::<f32>(scene.load) {
        fingerprint.numbers(&[bridge.diode_drop]);
    }
    Ok(fingerprint.value())
}

/// A triboelectric scene, with a resistor or behind a bridge.
fn triboelectric<T: Triboelectric>(
    setting: Setting<'_, f64>,
    model: &T,
    frequency_hz: f64,
    with: With<'_>,
) -> Result<(), Failure> {
    let Setting { scene, .. } = setting;
    let is_slider = scene.sliding().is_ok();
    if matches!(scene.load, Load::Resistor { .. }) {
        let prepared = prepared::<f64, Polynomial, T>(setting, model)?;
        let simulation = prepared.simulation::<_, STATES>(ExponentialRadau);
        let start = prepared.start(&simulation, &model.start())?;
        let typical = model.typical(&prepared.core).to_vec();
        return with(Sweep::new(setting, &simulation, start, frequency_hz, is_slider).shooting(typical));
    }
    let prepared = behind_bridge::<f64, Polynomial, T>(setting, model)?;
    let simulation = prepared.simulation::<_, { rectified::STATES }>(ExponentialRadau);
    let start = prepared.start(&simulation, &model.start())?;
    // The voltage of a bus does not change.
    let typical = [&model.typical(prepared.core.harvester())[..], &[1.0]].concat();
    with(Sweep::new(setting, &simulation, start, frequency_hz, is_slider).shooting(typical))
}

fn with_modes<L: Circuit<f64>, const B: usize, const R: usize>(
    setting: Setting<'_, f64>,
    model: &BumpStop,
    frequency_hz: f64,
    with: With<'_>,
    load: L,
) -> Result<(), Failure> {
    let (stepper, start) = begun::<f64, L, B, R>((setting.scene, model, setting.options), load)?;
    let state =
        stepper.start(&start, &setting.excitation).map_err(|error| refuse_start(setting.scene, &error))?;
    with(&mut Sweep::new(setting, &stepper, state, frequency_hz, false))
}

/// Shoots for the orbit of one period that a motion approaches, from a state of it, with the size of each coordinate in a wide motion.
type Shoot<H> = fn(
    &ForcedSystem<'_, H, HostExcitation<'_, f64>>,
    <H as Harvester<f64>>::State,
    &[f64],
    &mut Spent,
) -> Result<Verdict<<H as Harvester<f64>>::State>, Failure>;

/// A harvester on its way through the amplitudes. Between two calls its state is at a zero of the sine, at time zero.
pub(super) struct Sweep<'a, H: Harvester<f64>> {
    setting: Setting<'a, f64>,
    harvester: &'a H,
    /// `None`: the transient alone finds a steady motion of a beam, whose many modes each cost a period of the period map, and whose
    /// motion with contact is rarely of one period.
    shoot: Option<(Shoot<H>, Vec<f64>)>,
    start: H::State,
    state: H::State,
    saved: Vec<H::State>,
    frequency_hz: f64,
    is_slider: bool,
    /// Periods in a window of a transient.
    window: f64,
    periods: f64,
}

impl<H: Coordinates> Sweep<'_, H> {
    /// The same by shooting, with the size of each coordinate in a wide motion.
    fn shooting(&mut self, typical: Vec<f64>) -> &mut Self {
        let shoot: Shoot<H> = |system, from, typical, spent| system.steady_state(from, typical, spent);
        self.shoot = Some((shoot, typical));
        self
    }
}

impl<'a, H: Harvester<f64>> Sweep<'a, H> {
    pub(super) fn new(
        setting: Setting<'a, f64>,
        harvester: &'a H,
        start: H::State,
        frequency_hz: f64,
        is_slider: bool,
    ) -> Self {
        // A free motion falls to 1/e of its amplitude in 1/(2π ζ) of its periods.
        let window = (0.5 / (std::f64::consts::PI * setting.scene.model.summary().damping_ratio)).ceil();
        Self {
            setting,
            harvester,
            shoot: None,
            start,
            state: start,
            saved: Vec::new(),
            frequency_hz,
            is_slider,
            window: window.clamp(SHORTEST_WINDOW, 200.0),
            periods: 0.0,
        }
    }

    /// Advances to a time in periods of the sine.
    fn advance<O: Observer<f64>>(
        &mut self,
        excitation: HostExcitation<'_, f64>,
        until_periods: f64,
        observer: &mut O,
    ) -> Result<(), Failure> {
        let Self { harvester, frequency_hz, .. } = *self;
        let system =
            ForcedSystem { harvester, excitation: &excitation, frequency_hz, most_attempts: MOST_ATTEMPTS };
        let mut spent = Spent::default();
        system.begin(&mut spent);
        let advanced = system.advance(&mut self.state, system.instant(until_periods), observer, &mut spent);
        advanced.map_err(|failure| self.failure(failure))
    }

    fn failure(&self, failure: Failure) -> Failure {
        match failure {
            Failure::Step(error) => Failure::Step(format!("{error}: at {} Hz", self.frequency_hz)),
            other => other,
        }
    }

    /// The mean power, or charge per second, of a meter.
    fn value(&self, meter: &RunMeter<f64>) -> f64 {
        let power = meter.integrals().mean(PowerIndex::Load);
        match self.setting.scene.load {
            Load::DcBus { voltage_v, .. } => power / voltage_v,
            Load::Resistor { .. } | Load::RectifiedStore(_) => power,
        }
    }

    fn is_upper(&self, report: &RunReport<f64>) -> bool {
        if self.is_slider { report.stick_fraction < 1.0 } else { report.impacts + report.contacts > 0 }
    }

    /// The motion on the orbit that shooting finds, if it does.
    fn by_shooting(&mut self, excitation: HostExcitation<'_, f64>) -> Result<Option<Motion>, Failure> {
        let Some((shoot, typical)) = &self.shoot else { return Ok(None) };
        let Self { harvester, frequency_hz, .. } = *self;
        let system =
            ForcedSystem { harvester, excitation: &excitation, frequency_hz, most_attempts: MOST_ATTEMPTS };
        let mut spent = Spent::default();
        let verdict = shoot(&system, self.state, typical, &mut spent);
        self.periods += spent.periods;
        let verdict = verdict.map_err(|failure| self.failure(failure))?;
        let Verdict::StablePeriodOne(orbit) = verdict else { return Ok(None) };
        self.state = orbit.start;
        let mut meter = RunMeter::starting_at(&self.harvester.outputs(&self.state));
        let phase = self.harvester.clock(&self.state).seconds::<f64>() * self.frequency_hz;
        let watching: &mut Watching<'_, '_> = &mut (&mut None, &mut Some(&mut meter));
        self.advance(excitation, phase + 1.0, watching)?;
        self.advance(excitation, phase.ceil() + 1.0, &mut ())?;
        self.periods += 1.0 + phase.ceil() - phase;
        let is_upper = self.is_upper(&meter.report());
        // What is left of the charge of a slider that is stuck flows off.
        let value = if self.is_slider && !is_upper { 0.0 } else { self.value(&meter) };
        Ok(Some(Motion { value, is_upper, found: MotionKind::Orbit }))
    }

    /// The motion after a transient, or its mean.
    fn by_transient(&mut self, excitation: HostExcitation<'_, f64>) -> Result<Motion, Failure> {
        let mut values: Vec<f64> = Vec::new();
        let mut settled = 0;
        let mut touched = 0;
        for window in 1..=MOST_WINDOWS {
            let mut meter = RunMeter::starting_at(&self.harvester.outputs(&self.state));
            let watching: &mut Watching<'_, '_> = &mut (&mut None, &mut Some(&mut meter));
            self.advance(excitation, self.window * window as f64, watching)?;
            self.periods += self.window;
            let is_upper = self.is_upper(&meter.report());
            let value = self.value(&meter);
            if self.is_slider && !is_upper {
                return Ok(Motion { value: 0.0, is_upper, found: MotionKind::Transient });
            }
            if is_upper {
                touched = window;
            }
            let is_close = values.last().is_some_and(|last| (value - last).abs() <= SETTLED * value.abs());
            settled = if is_close { settled + 1 } else { 0 };
            values.push(value);
            // A motion that is not periodic may have contact in some windows only: it is the upper one.
            if settled + 1 == AGREE {
                return Ok(Motion {
                    value,
                    is_upper: touched + AGREE > window,
                    found: MotionKind::Transient,
                });
            }
            if window == MOST_WINDOWS {
                let measured = &values[SETTLING..];
                let value = measured.iter().sum::<f64>() / measured.len() as f64;
                return Ok(Motion { value, is_upper: touched > SETTLING, found: MotionKind::Mean });
            }
        }
        unreachable!("the last window returns")
    }
}

impl<H: Harvester<f64>> AmplitudeContinuation for Sweep<'_, H> {
    fn settle(&mut self, amplitude: f64) -> Result<Motion, Failure> {
        let sine = Sine::<f64, Polynomial>::new(amplitude, self.frequency_hz, 0.0)
            .map_err(|error| Failure::of_file(self.setting.scene, format!("excitation: {error}")))?;
        let excitation: HostExcitation<'_, f64> = &sine as &dyn Excitation<f64>;
        let motion = match self.by_shooting(excitation)? {
            Some(motion) => motion,
            None => self.by_transient(excitation)?,
        };
        self.harvester.set_clock(&mut self.state, Instant::START);
        Ok(motion)
    }

    fn keep(&mut self) -> usize {
        self.saved.push(self.state);
        self.saved.len() - 1
    }

    fn go_back(&mut self, number: usize) {
        self.state = self.saved[number];
    }

    fn rest(&mut self) {
        self.state = self.start;
    }

    fn periods(&self) -> f64 {
        self.periods
    }
}

/// Natural frequency in Hz of the slowest motion of a scene.
pub fn natural_frequency_hz(scene: &Scene) -> Result<f64, Failure> {
    let of = |angular: f64| angular / std::f64::consts::TAU;
    by_harvester!(scene,
        triboelectric(model) => {
            let core = Triboelectric::core::<f64, Polynomial>(model, scene)?;
            Ok(of(core.angular_frequency().to_f64()))
        },
        bump_stop(model) => {
            let core = parameters::<f64>(model, Load::Resistor { resistance_ohm: f64::INFINITY })
                .build_first::<20, 20>(model.parameters.beam_modes, 0)
                .map_err(|error| refuse_parameter(scene, &error))?;
            Ok(of(core.beam_angular_frequency(0).unwrap_or(f64::NAN)))
        }
    )
}
