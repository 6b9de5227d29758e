//! A scene on the embedded core, step by step under inputs that another program sets, as FMI for co-simulation has it.
//!
//! An input is constant over a communication step. A sine with `n` such steps in a period has its amplitude times
//! `sin(π/n)/(π/n)`, and a lag of half a step: at 20 steps the mean power of a linear harvester is 0.82 % too low.

use model_core::clock::Instant;
use model_core::energy::Ledger;
use model_core::excitation::{Excitation, Line};
use model_core::hybrid::{Automaton, HybridState};
use model_core::integrate::{ExponentialRadau, Point};
use model_core::observer::{ALL_POWERS, PowerIndex};
use model_core::scalar::Mathematics;
use model_core::scene::Harvester;
use model_core::scene::bump_stop::Circuit;
use model_core::scene::rectified::{self, CHARGE, VELOCITY};
use model_core::snapshot;

use super::bump_stop::{self, by_modes};
use super::excitation::{bridge, with_setting};
use super::run::BUDGET;
use super::triboelectric::{STATES, Triboelectric, behind_bridge, prepared};
use harvester_scene::method::{Failure, Options};
use harvester_scene::scene_file::{BumpStop, Load, Model, Scene};

/// A variable of a co-simulation. Its place in [`variables`] is its value reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable {
    pub name: &'static str,
    pub unit: &'static str,
    pub meaning: &'static str,
    /// Of an input: its value at the start, the least and the largest.
    pub input: Option<[f64; 3]>,
}

/// The variables of a scene: the time first, then the inputs, then the outputs.
///
/// # Errors
/// A load that has no input.
pub fn variables(scene: &Scene) -> Result<[Variable; 8], Failure> {
    let input = |name, unit, meaning, range| Variable { name, unit, meaning, input: Some(range) };
    let output = |name, unit, meaning| Variable { name, unit, meaning, input: None };
    let (load, current) = match scene.load {
        Load::Resistor { resistance_ohm: ohm @ 1e-9..=1e15 } => (
            input("load_resistance", "Ohm", "Load resistance", [ohm, 1e-9, 1e15]),
            "Current through the load; a positive voltage drives a positive current",
        ),
        Load::DcBus { voltage_v, .. } => (
            input("bus_voltage", "V", "Voltage of the bus behind the bridge", [voltage_v, 0.0, 1e6]),
            "Mean current into the bus over the last communication step",
        ),
        Load::Resistor { resistance_ohm: ohm } => {
            let reason = format!("load.resistance_ohm: is {ohm}, must be from 1e-9 to 1e15 for --fmu");
            return Err(Failure::of_file(scene, reason));
        }
        Load::RectifiedStore(_) => {
            let reason = "load.kind: is \"rectified-store\", must be \"resistor\" or \"dc-bus\" for --fmu";
            return Err(Failure::of_file(scene, reason));
        }
    };
    let displacement = match scene.model {
        Model::ContactSeparation(_) => "Gap, positive if open",
        Model::Sliding(_) => "Displacement of the slider relative to the base",
        Model::BumpStop(_) => "Displacement of the tip relative to the base",
    };
    let acceleration = "Acceleration of the base, positive in the direction of a positive displacement";
    Ok([
        output("time", "s", "Time"),
        input("base_acceleration", "m/s2", acceleration, [0.0, -1e6, 1e6]),
        load,
        output("voltage", "V", "Voltage between the terminals of the harvester"),
        output("current", "A", current),
        output("displacement", "m", displacement),
        output("power", "W", "Mean power into the load or the bus over the last communication step"),
        output("energy", "J", "Energy into the load or the bus since the start"),
    ])
}

/// A harvester that is stepped under inputs.
pub trait CoSimulation {
    /// Begins at a time in s with the inputs as they are.
    fn begin(&mut self, start_s: f64) -> Result<(), Failure>;

    /// Sets an input by its value reference. The charge and the motion have no jump.
    fn set(&mut self, reference: usize, value: f64) -> Result<(), Failure>;

    /// A variable by its value reference.
    fn get(&self, reference: usize) -> Result<f64, Failure>;

    /// Goes on by `step_s` from the time `at_s`, both in s.
    fn advance(&mut self, at_s: f64, step_s: f64) -> Result<(), Failure>;

    /// The state as bytes, with its inputs.
    fn save(&self) -> Result<Vec<u8>, Failure>;

    /// Goes back to a state. Its bytes must be of the same scene.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), Failure>;
}

/// A scene for co-simulation, in `f64`, by the method and the accuracy of a run without options.
///
/// The functions `M` are a type parameter, so that the caller compiles the harvesters, and not every user of this crate.
///
/// # Errors
/// A scene that the core refuses, or as [`variables`].
pub fn co_simulation<M: Mathematics<f64> + 'static>(scene: &Scene) -> Result<Box<dyn CoSimulation>, Failure> {
    let bridge = |load| bridge::<f64>(load).unwrap_or_else(|| unreachable!("a bus has a bridge"));
    by_harvester!(scene,
        triboelectric(model) => triboelectric::<M, _>(scene, model),
        bump_stop(model) => match scene.load {
            Load::Resistor { .. } => by_modes!(model, beam::<_>(scene, model, bump_stop::resistance::<f64>)),
            _ => by_modes!(model, beam::<_>(scene, model, bridge)),
        }
    )
}

/// The scene with the load at the value of its input.
fn loaded(scene: &Scene, value: f64) -> Scene {
    let load = scene.load.with_voltage(value).unwrap_or(Load::Resistor { resistance_ohm: value });
    Scene { load, ..scene.clone() }
}

fn triboelectric<M, T>(scene: &Scene, model: &T) -> Result<Box<dyn CoSimulation>, Failure>
where
    M: Mathematics<f64>,
    T: Triboelectric<Core<f64>: 'static> + Clone + 'static,
    T::Start<f64>: 'static,
{
    let (variables, scene, model) = (variables(scene)?, scene.clone(), model.clone());
    let options = Options::default();
    if !matches!(scene.load, Load::Resistor { .. }) {
        let build = move |volts| {
            with_setting::<f64, M, _>(&loaded(&scene, volts), &options, |setting| {
                let prepared = behind_bridge::<f64, M, T>(setting, &model)?;
                Ok((prepared.simulation::<_, { rectified::STATES }>(ExponentialRadau), model.start()))
            })
        };
        return Stepped::boxed(variables, build, |_, harvester, state, [before, now]| {
            if before[1] == now[1] {
                accelerate(harvester.scene(), state, [before[0], now[0]]);
            } else {
                harvester.set_storage_voltage(state, now[1], now[0]);
            }
            Ok(())
        });
    }
    let build = move |ohm| {
        with_setting::<f64, M, _>(&loaded(&scene, ohm), &options, |setting| {
            let prepared = prepared::<f64, M, T>(setting, &model)?;
            Ok((prepared.simulation::<_, STATES>(ExponentialRadau), model.start()))
        })
    };
    Stepped::boxed(variables, build, |build, harvester, state, [before, now]| {
        if before[1] == now[1] {
            accelerate(harvester.scene(), state, [before[0], now[0]]);
            return Ok(());
        }
        (*harvester, _) = build(now[1])?;
        let control = &harvester.driver().control;
        // As after an event: the rate of the charge jumps with the resistance, the voltage does not.
        let mut begun =
            HybridState::start(harvester.scene(), state.mode, state.point.state, &Constant(now[0]), control);
        begun.clock = state.clock;
        begun.point.remainder = state.point.remainder;
        begun.point.derivative[CHARGE] = state.point.derivative[CHARGE] * (before[1] / now[1]);
        *state = begun;
        Ok(())
    })
}

/// Changes the base acceleration of a state in m/s² from one value to another.
fn accelerate<A: Automaton<f64, N, ALL_POWERS>, const N: usize>(
    core: &A,
    state: &mut HybridState<f64, A::Mode, N, ALL_POWERS>,
    accelerations: [f64; 2],
) {
    let flow = core.flow(state.mode);
    let [before, now] = accelerations.map(|a| Point::at(&flow, state.point.state, a).derivative[VELOCITY]);
    state.point.derivative[VELOCITY] += now - before;
}

fn beam<L: Circuit<f64> + 'static, const B: usize, const R: usize>(
    scene: &Scene,
    model: &BumpStop,
    load: impl Fn(Load) -> L + 'static,
) -> Result<Box<dyn CoSimulation>, Failure> {
    let (variables, scene, model) = (variables(scene)?, scene.clone(), model.clone());
    let options = Options::default();
    let is_resistor = matches!(scene.load, Load::Resistor { .. });
    let build = move |value| {
        let scene = loaded(&scene, value);
        bump_stop::begun::<f64, L, B, R>((&scene, &model, &options), load(scene.load))
    };
    Stepped::boxed(variables, build, move |build, harvester, state, [before, now]| {
        if before[1] != now[1] && is_resistor {
            (*harvester, _) = build(now[1])?;
        } else if before[1] != now[1] {
            harvester.set_storage_voltage(state, now[1], now[0]);
        }
        Ok(())
    })
}

/// An acceleration in m/s² that is constant over a communication step.
struct Constant(f64);

impl Excitation<f64> for Constant {
    fn acceleration(&self, _at: Instant) -> f64 {
        self.0
    }

    fn jerk(&self, _at: Instant) -> f64 {
        0.0
    }

    /// The state has the acceleration before the step, which may be another.
    fn line(&self, _at: Instant, _ticks: u32, _step: f64, _start: f64) -> Line<f64> {
        Line { mean: self.0, tilt: 0.0, end: self.0 }
    }
}

/// A harvester `H` of the core under inputs.
struct Stepped<H: Harvester<f64>, B, C> {
    variables: [Variable; 8],
    /// Makes the harvester at a load.
    build: B,
    /// Changes harvester and state from inputs to others.
    change: C,
    harvester: H,
    start: H::Start,
    fingerprint: u32,
    state: H::State,
    /// Acceleration in m/s², and resistance in Ω or voltage in V.
    inputs: [f64; 2],
    /// Time of the start in s, energy in J, and of the last step the mean power in W and the mean current in A.
    totals: [f64; 4],
}

impl<H, B, C> Stepped<H, B, C>
where
    H: Harvester<f64> + 'static,
    H::Start: 'static,
    H::State: 'static,
    B: Fn(f64) -> Result<(H, H::Start), Failure> + 'static,
    C: Fn(&B, &mut H, &mut H::State, [[f64; 2]; 2]) -> Result<(), Failure> + 'static,
{
    fn boxed(variables: [Variable; 8], build: B, change: C) -> Result<Box<dyn CoSimulation>, Failure> {
        let inputs =
            [1, 2].map(|reference: usize| variables[reference].input.map_or(0.0, |[start, ..]| start));
        let (harvester, start) = build(inputs[1])?;
        let state = started(&harvester, &start, inputs[0])?;
        let (fingerprint, totals) = (harvester.fingerprint(), [0.0; 4]);
        Ok(Box::new(Self { variables, build, change, harvester, start, fingerprint, state, inputs, totals }))
    }
}

fn started<H: Harvester<f64>>(
    harvester: &H,
    start: &H::Start,
    acceleration: f64,
) -> Result<H::State, Failure> {
    harvester
        .start(start, &Constant(acceleration))
        .map_err(|error| Failure::Input(format!("initial.{error}")))
}

impl<H, B, C> CoSimulation for Stepped<H, B, C>
where
    H: Harvester<f64>,
    B: Fn(f64) -> Result<(H, H::Start), Failure>,
    C: Fn(&B, &mut H, &mut H::State, [[f64; 2]; 2]) -> Result<(), Failure>,
{
    fn begin(&mut self, start_s: f64) -> Result<(), Failure> {
        self.state = started(&self.harvester, &self.start, self.inputs[0])?;
        self.totals = [start_s, 0.0, 0.0, 0.0];
        Ok(())
    }

    fn set(&mut self, reference: usize, value: f64) -> Result<(), Failure> {
        let Some(Variable { name, unit, input: Some([_, least, most]), .. }) = self.variables.get(reference)
        else {
            return Err(Failure::Input(format!("value reference {reference}: must be that of an input")));
        };
        if !(*least..=*most).contains(&value) {
            let text = format!("{name} = {value} {unit}: must be from {least:e} to {most:e} {unit}");
            return Err(Failure::Input(text));
        }
        let (before, mut now) = (self.inputs, self.inputs);
        now[reference - 1] = value;
        if self.harvester.clock(&self.state) > Instant::START {
            (self.change)(&self.build, &mut self.harvester, &mut self.state, [before, now])?;
            self.inputs = now;
            return Ok(());
        }
        if now[1] != before[1] {
            (self.harvester, self.start) = (self.build)(now[1])?;
        }
        self.inputs = now;
        self.begin(self.totals[0])
    }

    fn get(&self, reference: usize) -> Result<f64, Failure> {
        let outputs = self.harvester.outputs(&self.state);
        let [start, energy, power, current] = self.totals;
        Ok(match reference {
            0 => start + self.harvester.clock(&self.state).seconds::<f64>(),
            1 => self.inputs[0],
            2 => self.inputs[1],
            3 => outputs.voltage,
            4 if outputs.storage.is_none() => outputs.voltage / self.inputs[1],
            4 => current,
            5 => outputs.coordinate().value,
            6 => power,
            7 => energy,
            _ => return Err(Failure::Input(format!("value reference {reference}: must be at most 7"))),
        })
    }

    fn advance(&mut self, at_s: f64, step_s: f64) -> Result<(), Failure> {
        let clock = self.harvester.clock(&self.state);
        let now = self.get(0)?;
        // Importers add up their steps.
        if !((at_s - now).abs() <= 1e-9 * (1.0 + now - self.totals[0]) + 4.0 * f64::EPSILON * now.abs()) {
            return Err(Failure::Input(format!("communication point {at_s} s: must be {now} s")));
        }
        let until = Instant::from_seconds(at_s - self.totals[0] + step_s).filter(|until| *until > clock);
        let Some(until) = until.filter(|_| step_s > 0.0) else {
            let text =
                format!("communication step {step_s} s: must be above 4e-12 s, and end before 6.7e7 s");
            return Err(Failure::Input(text));
        };
        let mut ledger = Ledger::open(&self.harvester.outputs(&self.state));
        while self.harvester.clock(&self.state) < until {
            self.harvester
                .advance(&mut self.state, &Constant(self.inputs[0]), until, BUDGET, &mut ledger)
                .map_err(|error| Failure::Step(error.to_string()))?;
        }
        let seconds = Instant::from_ticks(until.ticks() - clock.ticks()).seconds::<f64>();
        let [energy, charge] =
            [PowerIndex::Load, PowerIndex::CurrentMagnitude].map(|power| ledger.integrals().integral(power));
        let [start, before, ..] = self.totals;
        self.totals = [start, before + energy, energy / seconds, charge / seconds];
        Ok(())
    }

    fn save(&self) -> Result<Vec<u8>, Failure> {
        let mut bytes = vec![0; snapshot::size_of::<(H::State, [f64; 2], [f64; 4])>()];
        snapshot::save(&(self.state, self.inputs, self.totals), self.fingerprint, &mut bytes)
            .map_err(|error| Failure::Input(format!("state: {error}")))?;
        Ok(bytes)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        let (state, inputs, totals) =
            snapshot::restore::<(H::State, [f64; 2], [f64; 4])>(self.fingerprint, bytes)
                .map_err(|error| Failure::Input(format!("state: {error}")))?;
        if inputs[1] != self.inputs[1] {
            (self.harvester, self.start) = (self.build)(inputs[1])?;
        }
        (self.state, self.inputs, self.totals) = (state, inputs, totals);
        Ok(())
    }
}
