//! The plant of a node: storage, converter and sensor, with an income that is known minute by minute.

use harvester_scene::market::Reservoir;
use model_core::node::{IncomeOfTime, Progress, Task, VoltageParameters, Wake};

use super::harvester::acceleration;
use super::settings::{CELL, CONVERTER_NOISE, Settings, UNIT, begin_v};
use super::{Source, Strategy};
use crate::embedded::Vibration;

/// Noise of the sensor in counts RMS, and gravity in m/s², which is on its axis.
pub(super) const NOISE_COUNTS: f64 = 3.0;
pub(super) const GRAVITY: f64 = 9.806_65;

/// What is true of the plant beside the income, each over what is stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    pub standing: f64,
    pub action: f64,
    /// Highest voltage of the storage.
    pub highest: f64,
    pub capacitance: f64,
    /// Leaking power.
    pub leakage: f64,
}

impl Parts {
    /// All as stated.
    pub const AS_STATED: Self =
        Self { standing: 1.0, action: 1.0, highest: 1.0, capacitance: 1.0, leakage: 1.0 };
}

/// The estimate of an hour. Energies in J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hour {
    /// Hour of the run in which most of it was, from 0.
    pub index: usize,
    pub truth: f64,
    pub estimated: f64,
    pub bound: f64,
    /// Share of the hour in which the storage was full.
    pub full: f64,
    pub silent: f64,
    /// Spent on estimation since the start.
    pub spent: f64,
}

impl Hour {
    /// Whether the truth is within the bound.
    pub fn is_inside(&self) -> bool {
        (self.estimated - self.truth).abs() <= self.bound
    }
}

/// The result of a run. Energies in J.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Run {
    pub hours: Vec<Hour>,
    /// Energy spent on estimation, and shunted, over the true income.
    pub share: f64,
    pub shunted: f64,
    pub lock_outs: u32,
    pub actions: u32,
    /// Stored energy after each second; the first is that of the beginning.
    pub stored: Vec<f64>,
    /// Second of each action.
    pub acted: Vec<u32>,
    /// Taken in, shunted, leaked and spent in all.
    pub account: [f64; 4],
}

/// A plant, in the energies of the harvester as it is.
#[derive(Debug)]
pub struct World<'a> {
    pub(super) parameters: VoltageParameters<1>,
    reservoir: Reservoir,
    rate: f64,
    minutes: &'a [f64],
    vibration: &'a [Vibration],
    pub(super) parts: Parts,
    seed: u64,
    /// Second of the last reading, and readings before it in that second.
    read: u64,
    repeated: u64,
    random: Source,
    pub energy: f64,
    is_on: bool,
    /// True income, and seconds at the highest voltage, up to each second; stored energy after it.
    income: Vec<f64>,
    full: Vec<u32>,
    stored: Vec<f64>,
    shunted: f64,
    leaked: f64,
    spent: f64,
    pub lock_outs: u32,
}

impl<'a> World<'a> {
    /// At 3 V or with a half-charged battery, under the energies in J and the vibration of each minute.
    pub fn new(
        settings: &Settings,
        (minutes, vibration): (&'a [f64], &'a [Vibration]),
        parts: Parts,
        seed: u64,
    ) -> Self {
        let mut world = Self {
            parameters: settings.parameters(),
            reservoir: settings.reservoir(parts.capacitance),
            rate: settings.rate(),
            minutes,
            vibration,
            parts,
            seed,
            read: u64::MAX,
            repeated: 0,
            random: Source::of_seed(seed),
            energy: 0.0,
            is_on: true,
            income: vec![0.0],
            full: vec![0],
            stored: Vec::new(),
            shunted: 0.0,
            leaked: 0.0,
            spent: 0.0,
            lock_outs: 0,
        };
        world.energy = world.reservoir.energy_j(begin_v(settings.battery));
        world.stored.push(world.energy);
        world
    }

    /// Seconds since the start.
    pub fn second(&self) -> u32 {
        self.income.len() as u32 - 1
    }

    /// Energy in J at a voltage in V.
    fn at(&self, voltage: f32) -> f64 {
        self.reservoir.energy_j(voltage.into())
    }

    /// Energy at the lock-out.
    pub fn lock_out(&self) -> f64 {
        self.at(self.parameters.storage.lock_out_voltage)
    }

    /// Energy at the highest voltage.
    pub(super) fn capacity(&self) -> f64 {
        self.reservoir.energy_j(f64::from(self.parameters.storage.highest_voltage) * self.parts.highest)
    }

    /// Energy of a second of the standing power, energy of an action, and part of the energy that leaks in a second.
    pub(super) fn draws(&self) -> [f64; 3] {
        let VoltageParameters { standing_power, actions: [action], .. } = &self.parameters;
        let leaking = self.parts.leakage * self.reservoir.leaking(self.energy);
        [
            f64::from(*standing_power) * self.parts.standing,
            f64::from(action.energy) * self.parts.action,
            leaking,
        ]
    }

    /// True income of a second into the storage.
    pub(super) fn stored_of(&self, second: u32) -> f64 {
        self.reservoir.charging_efficiency() * self.income_of(second)
    }

    fn income_of(&self, second: u32) -> f64 {
        self.minutes.get(second as usize / 60).map_or(0.0, |minute| minute / 60.0)
    }

    /// Advances by some seconds, or up to a lock-out.
    fn advance(&mut self, seconds: u32) {
        let ([draw, _, leaking], capacity) = (self.draws(), self.capacity());
        for _ in 0..seconds {
            let draw = if self.is_on { draw } else { 0.0 };
            let (income, leaked) = (self.income_of(self.second()), leaking * self.energy);
            let stored = self.stored_of(self.second());
            self.energy += stored - draw - leaked;
            let above = (self.energy - capacity).max(0.0);
            self.energy -= above;
            self.shunted += above;
            self.leaked += leaked + (income - stored);
            self.spent += draw;
            self.income.push(self.income.last().unwrap_or(&0.0) + income);
            self.full.push(self.full.last().unwrap_or(&0) + u32::from(above > 0.0));
            self.stored.push(self.energy);
            if self.locks_out() {
                break;
            }
        }
    }

    /// Takes energy out of the storage in J; whatever takes it may lock the node out.
    pub fn spend(&mut self, energy: f64) {
        self.energy -= energy;
        self.spent += energy;
        self.locks_out();
    }

    /// Whether the node is on and its storage below the lock-out: it is then off, and the lock-out is counted.
    fn locks_out(&mut self) -> bool {
        let locks_out = self.is_on && self.energy <= self.lock_out();
        self.is_on &= !locks_out;
        self.lock_outs += u32::from(locks_out);
        locks_out
    }

    /// Of the same noise at the same time for each strategy.
    fn code(&mut self) -> u32 {
        let second = u64::from(self.second());
        self.repeated = if self.read == second { self.repeated + 1 } else { 0 };
        self.read = second;
        let mut noise = Source::of_seed(self.seed ^ (second << 20) ^ (self.repeated << 56));
        let open = self.reservoir.voltage_v(self.energy);
        let resistance = self.reservoir.battery.map_or(0.0, |battery| battery.resistance_ohm.0);
        let [draw, ..] = self.draws();
        let risen = resistance * (self.stored_of(self.second()) - draw) / open.max(0.1);
        let voltage = open + risen + CONVERTER_NOISE * noise.normal();
        (voltage / CELL).round().clamp(0.0, 4095.0) as u32
    }

    /// Hands the samples of a burst over in parts, unless its energy locks the node out.
    fn burst(&mut self, strategy: &mut impl Strategy, samples: u32) {
        if !self.is_on {
            return;
        }
        let from = f64::from(self.second());
        let mut counts = Vec::new();
        for n in 0..samples {
            let time = from + f64::from(n) / self.rate;
            let minute = (time / 60.0) as usize;
            let within = time - 60.0 * minute as f64;
            let value =
                self.vibration.get(minute).map_or(0.0, |vibration| acceleration(vibration, minute, within));
            counts.push(((value + GRAVITY) / UNIT + NOISE_COUNTS * self.random.normal()).round() as i16);
        }
        let mut taken = 0;
        while let Progress::More(missing) = strategy.samples(&counts[taken..counts.len().min(taken + 170)]) {
            taken = counts.len() - missing as usize;
        }
        while strategy.samples(&[]) == Progress::Done(None) {}
        self.advance((f64::from(samples) / self.rate).ceil() as u32);
    }

    /// Sleeps, and wakes the node.
    pub fn sleep(&mut self, strategy: &mut impl Strategy, wake: Wake) -> Wake {
        self.advance(wake.again_in);
        let code = (wake.read && self.is_on).then(|| self.code());
        self.wake(strategy, code)
    }

    /// Wakes the node, after a lock-out at its turn-on voltage. What a reading or a burst takes leaves the storage.
    pub fn wake(&mut self, strategy: &mut impl Strategy, code: Option<u32>) -> Wake {
        let before = strategy.spent();
        let was_off = !self.is_on;
        let turn_on = self.at(self.parameters.storage.turn_on_voltage);
        while was_off && self.energy < turn_on {
            if !self.is_going_on() {
                return Wake { task: Task::Sleep, again_in: 60, read: false };
            }
            self.advance(1);
        }
        self.is_on = true;
        let code = if was_off { Some(self.code()) } else { code };
        let wake = strategy.wake(self.second(), code, was_off);
        self.spend(strategy.spent() - before);
        wake
    }

    fn is_going_on(&self) -> bool {
        (self.second() as usize) < 60 * self.minutes.len()
    }

    /// The hour that ends now.
    fn hour(&self, estimated: IncomeOfTime, spent: f64) -> Hour {
        let (end, begin) = (self.second() as usize, self.second().saturating_sub(estimated.seconds) as usize);
        let seconds = f64::from(estimated.seconds);
        Hour {
            index: (begin + end) / 7200,
            truth: self.income[end] - self.income[begin],
            estimated: estimated.energy.into(),
            bound: estimated.bound.into(),
            full: f64::from(self.full[end] - self.full[begin]) / seconds,
            silent: f64::from(estimated.silent) / seconds,
            spent,
        }
    }

    /// Runs a strategy over all minutes. `between` is called after each wake between two sleeps.
    pub fn run<S: Strategy>(mut self, strategy: &mut S, mut between: impl FnMut(&mut S)) -> Run {
        let (mut acted, mut hours) = (Vec::new(), Vec::new());
        let code = self.code();
        let mut wake = self.wake(strategy, Some(code));
        let mut last = strategy.last_hour();
        let [_, action, _] = self.draws();
        // The last hour may take readings at its end.
        while self.is_going_on() || (wake.read && wake.again_in == 0) {
            wake = match wake.task {
                Task::Run(_) => {
                    acted.push(self.second());
                    self.spend(action);
                    self.wake(strategy, None)
                }
                Task::Burst { samples } => {
                    self.burst(strategy, samples);
                    self.wake(strategy, None)
                }
                Task::Sleep => self.sleep(strategy, wake),
            };
            if wake.task == Task::Sleep {
                between(strategy);
            }
            if strategy.last_hour() != last {
                last = strategy.last_hour();
                hours.extend(last.map(|estimated| self.hour(estimated, strategy.spent())));
            }
        }
        let income = self.income[self.second() as usize];
        // What was drawn since the last second belongs to its end.
        self.stored.pop();
        self.stored.push(self.energy);
        Run {
            hours,
            share: strategy.spent() / income,
            shunted: self.shunted / income,
            lock_outs: self.lock_outs,
            actions: acted.len() as u32,
            stored: self.stored,
            acted,
            account: [income, self.shunted, self.leaked, self.spent],
        }
    }
}
