//! A node on a plant: storage, converter and sensor, with an income that is known minute by minute.

use harvester_scene::market::{Accelerometer, Code, CostModel, Instructions, Processor, node_instructions};
use model_core::energy::{Capacitor, ResponseMap, StorageParameters};
use model_core::excitation::LineBank;
use model_core::node::{
    Bursts, Converter, Gap, IncomeOfTime, MapNode, MapParameters, MapState, Progress, Regular, Sensor, Task,
    Tier, Tolerances, VoltageNode, VoltageParameters, VoltageState, Wake,
};

use super::difference::Difference;
use super::truth::{Kind, Shaking, acceleration};

/// Random numbers by SplitMix64.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source(pub(super) u64);

impl Source {
    /// Even from 0 to 1.
    pub(super) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normal with the variance 1, as the sum of twelve.
    pub(super) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform() - 0.5).sum()
    }
}

pub(super) type Bytes = &'static [u8];
/// Sections of at most 20 samples, 32 of them in a block; one action.
pub(super) type OneNode = MapNode<Bytes, 20, 32, 1>;
pub(super) type OneState = MapState<32, 1>;

/// Sensor: m/s² of a count, and its noise in counts RMS; gravity is on its axis.
const UNIT: f64 = 9.806_65 / 1024.0;
const NOISE_COUNTS: f64 = 3.0;
const GRAVITY: f64 = 9.806_65;
/// Converter: 12 bits over 5 V, half a cell of noise.
const CELL: f64 = 5.0 / 4096.0;
const CONVERTER_NOISE: f64 = 0.6e-3;

/// How a node is built: its storage and what its parts cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Build {
    pub(super) kind: Kind,
    pub(super) capacitance: f64,
    pub(super) processor: Processor,
    /// Mean income in W that the harvester is scaled to.
    pub(super) income: f64,
    /// Standing power, and energy of an action, in W and J.
    pub(super) standing: f64,
    pub(super) action: f64,
    pub(super) every: u32,
    pub(super) reserve: f64,
    /// Relative deviations of the standing power, and of the energy of an action.
    pub(super) spread: f64,
    pub(super) of_action: f64,
    /// How far the highest voltage of the storage may be below the stated one, relative.
    pub(super) of_highest: f64,
}

/// What is true of the plant, beside the income.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plant {
    /// Standing power over the stated one.
    pub(super) standing: f64,
    /// Energy of actions over the stated one.
    pub(super) action: f64,
    /// Highest voltage of the storage over the stated one.
    pub(super) highest: f64,
    /// Capacitance over the stated one.
    pub(super) capacitance: f64,
}

/// All as stated.
pub(super) const AS_STATED: Plant = Plant { standing: 1.0, action: 1.0, highest: 1.0, capacitance: 1.0 };

/// A node as the plant sees it.
pub(super) trait Strategy {
    type State: Clone;
    fn begin(&self) -> Self::State;
    fn call(&self, state: &mut Self::State, now: u32, code: Option<u32>) -> Wake;
    fn after_lock_out(&self, state: &mut Self::State, now: u32, code: u32) -> Wake;
    fn take(&self, _state: &mut Self::State, _samples: &[i16]) -> Progress {
        Progress::Idle
    }
    fn last_hour(state: &Self::State) -> Option<IncomeOfTime>;
    /// Energy in J that the estimate itself has taken.
    fn spent(&self, state: &Self::State) -> f64;
    fn facts(&self) -> Facts;
}

/// What the plant needs of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Facts {
    storage: StorageParameters<f32>,
    standing: f64,
    action: f64,
}

impl Strategy for OneNode {
    type State = OneState;

    fn begin(&self) -> OneState {
        self.start(0)
    }

    fn call(&self, state: &mut OneState, now: u32, code: Option<u32>) -> Wake {
        self.wake(state, now, code)
    }

    fn after_lock_out(&self, state: &mut OneState, now: u32, code: u32) -> Wake {
        self.wake_after(state, Gap::LockedOutUntil(now), Some(code))
    }

    fn take(&self, state: &mut OneState, samples: &[i16]) -> Progress {
        self.samples(state, samples)
    }

    fn last_hour(state: &OneState) -> Option<IncomeOfTime> {
        state.last_hour()
    }

    fn spent(&self, state: &OneState) -> f64 {
        self.spent_on_knowing(state).into()
    }

    fn facts(&self) -> Facts {
        Facts::of(&self.parameters().voltage)
    }
}

impl Facts {
    fn of(parameters: &VoltageParameters<1>) -> Self {
        let VoltageParameters { storage, standing_power, actions: [action], .. } = parameters;
        Self { storage: *storage, standing: (*standing_power).into(), action: action.energy.into() }
    }
}

impl Strategy for VoltageNode<1> {
    type State = VoltageState<1>;

    fn begin(&self) -> VoltageState<1> {
        self.start(0)
    }

    fn call(&self, state: &mut VoltageState<1>, now: u32, code: Option<u32>) -> Wake {
        self.wake(state, now, code)
    }

    fn after_lock_out(&self, state: &mut VoltageState<1>, now: u32, code: u32) -> Wake {
        self.wake_after(state, Gap::LockedOutUntil(now), Some(code))
    }

    fn last_hour(state: &VoltageState<1>) -> Option<IncomeOfTime> {
        state.last_hour()
    }

    fn spent(&self, state: &VoltageState<1>) -> f64 {
        f64::from(state.readings()) * f64::from(self.parameters().reading)
    }

    fn facts(&self) -> Facts {
        Facts::of(self.parameters())
    }
}

/// An hour that a node has told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hour {
    /// Hour of the run in which it ended, from 0.
    pub(super) index: usize,
    pub(super) truth: f64,
    pub(super) told: f64,
    pub(super) bound: f64,
    /// Share of the hour in which the storage was full.
    pub(super) full: f64,
    pub(super) silent: f64,
}

/// What came of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run<S> {
    pub(super) hours: Vec<Hour>,
    /// Energy spent on knowing over the true income.
    pub(super) share: f64,
    pub(super) lock_outs: u32,
    pub(super) actions: u32,
    pub(super) shunted: f64,
    pub(super) state: S,
}

fn rate(kind: Kind) -> f64 {
    if kind == Kind::BumpStop { 800.0 } else { 100.0 }
}

fn accelerometer(kind: Kind) -> Accelerometer {
    Accelerometer::named(if kind == Kind::BumpStop { "bma400" } else { "adxl367" }).expect("a part")
}

const BLOCKS: u32 = 1;

impl Build {
    /// Energy in J of a reading of so many instructions.
    fn reading(&self, instructions: f64) -> f64 {
        CostModel::new(self.processor, accelerometer(self.kind)).reading(instructions)
    }

    fn storage(&self, scale: f64) -> StorageParameters<f32> {
        StorageParameters {
            capacitor: Capacitor {
                capacitance: (self.capacitance / scale) as f32,
                leakage_resistance: f32::INFINITY,
            },
            charging_efficiency: 1.0,
            discharging_efficiency: 1.0,
            highest_voltage: 4.5,
            lock_out_voltage: 1.8,
            turn_on_voltage: 2.2,
        }
    }

    /// The node of the voltage alone, on a storage whose capacitance is known to a tolerance.
    pub(super) fn voltage_node(&self, scale: f64, capacitance: f32) -> VoltageNode<1> {
        self.voltage_parameters(scale, capacitance).build().expect("valid")
    }

    fn voltage_parameters(&self, scale: f64, capacitance: f32) -> VoltageParameters<1> {
        let small = |energy: f64| (energy / scale) as f32;
        let instructions = node_instructions(self.processor.core).reading;
        VoltageParameters {
            storage: self.storage(scale),
            converter: Converter { bits: 12, full_scale: 5.0, noise: CONVERTER_NOISE as f32 },
            standing_power: small(self.standing),
            reading: small(self.reading(instructions)),
            intervals: [60, 300],
            tolerances: Tolerances {
                standing: self.spread as f32,
                action: self.of_action as f32,
                capacitance,
                highest_voltage: self.of_highest as f32,
                ..Tolerances::EXACT
            },
            largest_power: small(10.0 * self.income),
            reserve: small(self.reserve),
            actions: [Regular { energy: small(self.action), every: self.every }],
        }
    }

    /// The difference of two readings on the same storage.
    pub(super) fn difference(&self, scale: f64, capacitance: f32) -> Difference {
        Difference::new(self.voltage_node(scale, capacitance))
    }

    /// The node with a map; energies over `scale`, so that the map of the harvester as it is fits. Its gain is known to a standard
    /// deviation.
    pub(super) fn node(&self, map: Bytes, scale: f64, capacitance: f32, gain: f32) -> OneNode {
        let fingerprint = u32::from_le_bytes([map[6], map[7], map[8], map[9]]);
        let map = ResponseMap::new(map, fingerprint).expect("a map");
        let [resonance, half] = self.kind.resonance();
        let rate = rate(self.kind);
        let bank = LineBank::new(rate as f32, resonance as f32, half as f32, UNIT as f32).expect("fits");
        let sensor = accelerometer(self.kind);
        let Instructions { sample, block, .. } = node_instructions(self.processor.core);
        let samples = bank.block() as u32 * BLOCKS;
        let instructions = f64::from(samples) * sample + f64::from(BLOCKS) * block;
        let cost = CostModel::new(self.processor, sensor);
        let energy = cost.burst(samples, rate, instructions, Code::Filter).expect("a rate").total();
        let parameters = MapParameters {
            voltage: self.voltage_parameters(scale, capacitance),
            sensor: Sensor {
                rate: rate as f32,
                start_up: sensor.start_up_samples,
                blocks: BLOCKS,
                clipped: 32_000,
            },
            bursts: Bursts { energy: (energy / scale) as f32, worth: 10.0, shortest: 60, check: 80_000 },
            gain,
            gain_drift: 0.02,
        };
        MapNode::new(map, bank, parameters).expect("valid")
    }
}

/// A plant with its node, in the units of the node.
pub(super) struct World<'a, N> {
    node: &'a N,
    facts: Facts,
    rate: f64,
    minutes: &'a [f64],
    shaking: &'a [Shaking],
    plant: Plant,
    seed: u64,
    /// Second of the last reading, and readings before it in that second.
    read: u64,
    repeated: u64,
    random: Source,
    energy: f64,
    is_on: bool,
    /// True income, and seconds at the highest voltage, up to each second.
    income: Vec<f64>,
    full: Vec<u32>,
    shunted: f64,
    lock_outs: u32,
}

impl<'a, N: Strategy> World<'a, N> {
    /// At 3 V.
    pub(super) fn new(
        build: &Build,
        node: &'a N,
        (minutes, shaking): (&'a [f64], &'a [Shaking]),
        plant: Plant,
        seed: u64,
    ) -> Self {
        let mut world = Self {
            node,
            facts: node.facts(),
            rate: rate(build.kind),
            minutes,
            shaking,
            plant,
            seed,
            read: u64::MAX,
            repeated: 0,
            random: Source(seed),
            energy: 0.0,
            is_on: true,
            income: vec![0.0],
            full: vec![0],
            shunted: 0.0,
            lock_outs: 0,
        };
        world.energy = world.at(3.0);
        world
    }

    fn second(&self) -> u32 {
        self.income.len() as u32 - 1
    }

    fn capacitance(&self) -> f64 {
        f64::from(self.facts.storage.capacitor.capacitance) * self.plant.capacitance
    }

    /// Energy at a voltage.
    fn at(&self, voltage: f32) -> f64 {
        0.5 * self.capacitance() * f64::from(voltage).powi(2)
    }

    /// Advances by some seconds, or up to a lock-out.
    fn advance(&mut self, seconds: u32) {
        let draw = self.facts.standing * self.plant.standing;
        let capacity = self.at(self.facts.storage.highest_voltage) * self.plant.highest.powi(2);
        for _ in 0..seconds {
            let draw = if self.is_on { draw } else { 0.0 };
            let income = self.minutes.get(self.second() as usize / 60).map_or(0.0, |minute| minute / 60.0);
            self.energy += income - draw;
            let above = (self.energy - capacity).max(0.0);
            self.energy -= above;
            self.shunted += above;
            self.income.push(self.income.last().unwrap_or(&0.0) + income);
            self.full.push(self.full.last().unwrap_or(&0) + u32::from(above > 0.0));
            if self.locks_out() {
                break;
            }
        }
    }

    /// Takes energy out of the storage in J; whatever takes it may lock the node out.
    fn spend(&mut self, energy: f64) {
        self.energy -= energy;
        self.locks_out();
    }

    /// Whether the node is on and its storage below the lock-out: it is then off, and the lock-out is counted.
    fn locks_out(&mut self) -> bool {
        let lock_out = self.at(self.facts.storage.lock_out_voltage);
        let locks_out = self.is_on && self.energy <= lock_out;
        self.is_on &= !locks_out;
        self.lock_outs += u32::from(locks_out);
        locks_out
    }

    /// Of the same noise at the same time for each strategy.
    fn code(&mut self) -> u32 {
        let second = u64::from(self.second());
        self.repeated = if self.read == second { self.repeated + 1 } else { 0 };
        self.read = second;
        let noise = CONVERTER_NOISE * Source(self.seed ^ (second << 20) ^ (self.repeated << 56)).normal();
        let voltage = (2.0 * self.energy / self.capacitance()).max(0.0).sqrt() + noise;
        (voltage / CELL).round().clamp(0.0, 4095.0) as u32
    }

    /// Hands the samples of a burst over in parts, unless its energy locks the node out.
    fn burst(&mut self, state: &mut N::State, samples: u32) {
        if !self.is_on {
            return;
        }
        let from = f64::from(self.second());
        let mut counts = Vec::new();
        for n in 0..samples {
            let time = from + f64::from(n) / self.rate;
            let minute = (time / 60.0) as usize;
            let within = time - 60.0 * minute as f64;
            let value = self.shaking.get(minute).map_or(0.0, |shaking| acceleration(shaking, minute, within));
            counts.push(((value + GRAVITY) / UNIT + NOISE_COUNTS * self.random.normal()).round() as i16);
        }
        for burst in counts.chunks(170) {
            assert!(self.node.take(state, burst) != Progress::Idle);
        }
        self.advance((f64::from(samples) / self.rate).ceil() as u32);
    }

    /// Sleeps, and wakes the node.
    fn sleep(&mut self, state: &mut N::State, wake: Wake) -> Wake {
        self.advance(wake.again_in);
        let code = (wake.read && self.is_on).then(|| self.code());
        self.wake(state, code)
    }

    /// Wakes the node, after a lock-out when the storage has reached its turn-on voltage. What a reading or a burst takes leaves the
    /// storage.
    fn wake(&mut self, state: &mut N::State, code: Option<u32>) -> Wake {
        let before = self.node.spent(state);
        let wake = if self.is_on {
            self.node.call(state, self.second(), code)
        } else {
            let turn_on = self.at(self.facts.storage.turn_on_voltage);
            while self.energy < turn_on && self.is_going_on() {
                self.advance(1);
            }
            self.is_on = true;
            let code = self.code();
            self.node.after_lock_out(state, self.second(), code)
        };
        self.spend(self.node.spent(state) - before);
        wake
    }

    fn is_going_on(&self) -> bool {
        (self.second() as usize) < 60 * self.minutes.len()
    }

    /// The hour that ends now.
    fn hour(&self, told: IncomeOfTime) -> Hour {
        let begin = (self.second() - told.seconds) as usize;
        let seconds = f64::from(told.seconds);
        Hour {
            index: (self.second() as usize - 1) / 3600,
            truth: self.income[self.second() as usize] - self.income[begin],
            told: told.energy.into(),
            bound: told.bound.into(),
            full: f64::from(self.full[self.second() as usize] - self.full[begin]) / seconds,
            silent: f64::from(told.silent) / seconds,
        }
    }

    /// Runs the node over all minutes. `between` is called after each wake between two sleeps.
    pub(super) fn run(mut self, mut between: impl FnMut(N::State) -> N::State) -> Run<N::State> {
        let mut state = self.node.begin();
        let (mut actions, mut hours) = (0, Vec::new());
        let code = self.code();
        let mut wake = self.wake(&mut state, Some(code));
        let mut last = N::last_hour(&state);
        while self.is_going_on() {
            wake = match wake.task {
                Task::Run(_) => {
                    actions += 1;
                    self.spend(self.facts.action * self.plant.action);
                    self.wake(&mut state, None)
                }
                Task::Burst { samples } => {
                    self.burst(&mut state, samples);
                    self.wake(&mut state, None)
                }
                Task::Sleep => self.sleep(&mut state, wake),
            };
            if wake.task == Task::Sleep {
                state = between(state);
            }
            if N::last_hour(&state) != last {
                last = N::last_hour(&state);
                hours.extend(last.map(|told| self.hour(told)));
            }
        }
        let income = self.income[self.second() as usize];
        let share = self.node.spent(&state) / income;
        let lock_outs = self.lock_outs;
        Run { hours, share, lock_outs, actions, shunted: self.shunted / income, state }
    }
}

#[test]
fn a_lock_out_within_a_sleep_and_one_by_an_action_are_counted() {
    let build =
        super::build(Kind::ContactSeparation, Processor::named("nrf52832").expect("a part"), 1e-3, 0.2);
    let node = build.node(super::map(build.kind), 1.0, 0.0, 1.0);
    // Half an hour without income, and one with 1 mJ a minute: at its end the storage is full again.
    let minutes: Vec<f64> = (0..60).map(|minute| if minute < 30 { 0.0 } else { 1e-3 }).collect();
    let plant = AS_STATED;
    let mut world = World::new(&build, &node, (&minutes, &[]), plant, 1);
    let lock_out = world.at(world.facts.storage.lock_out_voltage);
    let mut state = node.start(0);
    // Enough for 1000 s of the standing power.
    world.energy = lock_out + 1000.0 * build.standing;
    let wake = Wake { task: Task::Sleep, again_in: 3600, read: true };
    world.sleep(&mut state, wake);
    assert_eq!(world.lock_outs, 1);
    // The first 0.8 mJ turn it on again.
    assert!(world.is_on && (1830..1860).contains(&world.second()), "{}", world.second());
    assert_eq!(OneNode::second(&state), world.second());
    world.spend(world.energy - 0.9 * lock_out);
    world.wake(&mut state, None);
    assert_eq!(world.lock_outs, 2);
    assert!(world.is_on && world.energy > lock_out);
}

#[test]
fn the_hours_of_a_lock_out_are_inside_their_bounds() {
    let build =
        super::build(Kind::ContactSeparation, Processor::named("nrf52832").expect("a part"), 1e-3, 0.01);
    let node = build.node(super::map(build.kind), 1.0, 0.0, 1.0);
    let plant = AS_STATED;
    let mut lock_outs = 0;
    for later in [600.0, 1200.0, 2400.0] {
        for income in [0.1e-6, 1e-6, 5e-6] {
            // Two hours without income, and a lock-out in the second of them.
            let minutes: Vec<f64> =
                (0..360).map(|minute| if minute < 120 { 0.0 } else { 60.0 * income }).collect();
            let mut world = World::new(&build, &node, (&minutes, &[]), plant, 1);
            let lock_out = world.at(world.facts.storage.lock_out_voltage);
            world.energy = lock_out + (3600.0 + later) * build.standing;
            let run = world.run(|state| state);
            lock_outs += run.lock_outs;
            for hour in &run.hours {
                assert!((hour.told - hour.truth).abs() <= hour.bound, "{later} s, {income} W: {hour:?}");
            }
        }
    }
    assert!(lock_outs >= 6, "{lock_outs}");
}
