//! A whole day of a harvester on the embedded core, step by step, shaken harder or softer from hour to hour.

use model_core::clock::Instant;
use model_core::energy::{Ledger, PowerMeter};
use model_core::excitation::Excitation;
use model_core::integrate::ExponentialRadau;
use model_core::scalar::Scalar;
use model_core::scene::Harvester;

use harvester_scene::progress;

use super::excitation::{Setting, with_setting};
use super::refuse_bump_stop;
use super::run::{BUDGET, remainder};
use super::triboelectric::{STATES, Triboelectric, created_energy, prepared};
use harvester_scene::method::{Failure, Options, Precision};
use harvester_scene::outcome::CreatedEnergy;
use harvester_scene::scene_file::{HOURS, Load, Scene};

const DAY_S: u32 = 86_400;
const HOUR_S: u32 = 3600;

#[derive(Debug, Clone, PartialEq)]
pub struct WholeDay {
    /// Energy delivered to the load in J, in each of the equal intervals of the day.
    pub energies_j: Vec<f64>,
    /// What is left over in the energy ledger of the day, as a run reports it.
    pub energy_residual: Option<f64>,
    /// Energy that the force law created over the day.
    pub created: CreatedEnergy,
    pub steps: u64,
}

/// Runs a triboelectric scene for a day by TR-BDF2, its excitation multiplied hour by hour from midnight, and adds
/// up what it delivers in intervals of `interval_s` seconds, which divide the day.
pub fn whole_day(
    scene: &Scene,
    hours: &[f64; HOURS],
    interval_s: u32,
    options: &Options,
) -> Result<WholeDay, Failure> {
    options.check()?;
    options.check_scene(scene)?;
    if !matches!(scene.load, Load::Resistor { .. }) {
        let reason = "load.kind: must be \"resistor\" or \"rectified-store\" with --exact";
        return Err(Failure::of_file(scene, reason));
    }
    match options.precision {
        Some(Precision::F32) => whole_day_as::<f32>(scene, hours, interval_s, options),
        _ => whole_day_as::<f64>(scene, hours, interval_s, options),
    }
}

fn whole_day_as<S: Scalar>(
    scene: &Scene,
    hours: &[f64; HOURS],
    interval_s: u32,
    options: &Options,
) -> Result<WholeDay, Failure> {
    with_setting::<S, S::Build, _>(scene, options, |setting| {
        // At 10⁵ steps a second a day of bump-stop would take hours.
        by_harvester!(scene,
            triboelectric(model) => day(setting, model, hours, interval_s),
            bump_stop(_) => Err(refuse_bump_stop(scene, "with --exact")))
    })
}

fn day<S: Scalar, T: Triboelectric>(
    setting: Setting<'_, S>,
    model: &T,
    hours: &[f64; HOURS],
    interval_s: u32,
) -> Result<WholeDay, Failure> {
    let prepared = prepared::<S, S::Build, T>(setting, model)?;
    let daily = Daily { base: setting.excitation, factors: hours.map(S::from_f64) };
    let simulation = prepared.simulation::<_, STATES>(ExponentialRadau);
    let mut state = prepared.start(&simulation, &model.start())?;
    let mut ledger = Ledger::open(&simulation.outputs(&state));
    let mut energies_j = Vec::new();
    let mut steps = 0;
    progress::begin();
    for end in (interval_s..=DAY_S).step_by(interval_s as usize) {
        let mut meter = PowerMeter::new();
        let until = Instant::from_whole_seconds(end);
        let mut observer = (&mut ledger, &mut meter);
        while state.clock < until {
            let advance = simulation
                .advance(&mut state, &daily, until, BUDGET, &mut observer)
                .map_err(|error| prepared.run(&simulation).step_failure(error, &state))?;
            steps += u64::from(advance.work.steps);
        }
        progress::report(f64::from(end) / f64::from(DAY_S), [steps, 0]);
        energies_j.push(meter.delivered_energy().to_f64());
    }
    let energy_residual = model.residual(&ledger.residual()).map(S::to_f64);
    let created = created_energy(ledger.integrals()).to_f64();
    let created = CreatedEnergy::new(created, energies_j.iter().sum(), remainder(&ledger));
    Ok(WholeDay { energies_j, energy_residual, created, steps })
}

/// An excitation multiplied with a factor for each hour of the day. In the first second of an hour the factor goes
/// in a straight line from the one before, so that the acceleration has no jump.
#[derive(Debug)]
pub struct Daily<S, E> {
    /// The excitation at a factor of one.
    pub base: E,
    pub factors: [S; HOURS],
}

impl<S: Scalar, E> Daily<S, E> {
    /// The factor, its rate in 1/s, and the ticks until it next has a kink.
    fn factor(&self, at: Instant) -> (S, S, u64) {
        let hour_ticks = Instant::from_whole_seconds(HOUR_S).ticks();
        let second_ticks = Instant::from_whole_seconds(1).ticks();
        let hour = (at.ticks() / hour_ticks) as usize % HOURS;
        let within = at.ticks() % hour_ticks;
        let (before, now) = (self.factors[(hour + HOURS - 1) % HOURS], self.factors[hour]);
        if within < second_ticks {
            let rate = now - before;
            let part = Instant::from_ticks(within).seconds::<S>();
            (before + rate * part, rate, second_ticks - within)
        } else {
            (now, S::ZERO, hour_ticks - within)
        }
    }
}

impl<S: Scalar, E: Excitation<S>> Excitation<S> for Daily<S, E> {
    fn acceleration(&self, at: Instant) -> S {
        self.factor(at).0 * self.base.acceleration(at)
    }

    fn jerk(&self, at: Instant) -> S {
        let (factor, rate, _) = self.factor(at);
        factor * self.base.jerk(at) + rate * self.base.acceleration(at)
    }

    fn resolved_ticks_at(&self, at: Instant) -> u32 {
        self.base.resolved_ticks_at(at)
    }

    fn resolved_ticks(&self) -> u32 {
        self.base.resolved_ticks()
    }

    fn angular_frequency(&self) -> S {
        self.base.angular_frequency()
    }

    fn smooth_ticks(&self, at: Instant) -> u32 {
        let kink = u32::try_from(self.factor(at).2).unwrap_or(u32::MAX);
        self.base.smooth_ticks(at).min(kink)
    }
}
