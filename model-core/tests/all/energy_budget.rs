//! No allowed action empties the storage below its lock-out, and the actions use the income.
//!
//! Random days of random nodes: storage with and without leakage, income with nights, spikes and gaps, actions that
//! cost at most their declared energy, at the beginning, the end or throughout. The true storage is simulated here in
//! `f64`, in twenty steps a minute, each by the exact solution for a constant power; the budget runs in `f32` with
//! one update a minute.

use crate::common::Random;
use model_core::energy::{
    Action, Budget, BudgetParameters, BudgetState, Capacitor, IncomeParameters, StorageParameters,
};

pub(crate) const SLOTS: usize = 24;
pub(crate) const MINUTES: u32 = 1440;
/// Seconds of a minute in which actions may be started.
const BUSY: f64 = 40.0;

/// The storage as it is: what it holds, and the rate at which that leaks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrueStore {
    pub(crate) energy: f64,
    pub(crate) capacity: f64,
    pub(crate) lock_out: f64,
    pub(crate) turn_on: f64,
    pub(crate) leakage_rate: f64,
    pub(crate) charging: f64,
    pub(crate) discharging: f64,
    pub(crate) on: bool,
}

impl TrueStore {
    /// A time in which harvester and load have constant powers in watts.
    pub(crate) fn advance(&mut self, seconds: f64, harvested: f64, load: f64) {
        let load = if self.on { load } else { 0.0 };
        let power = harvested * self.charging - load / self.discharging;
        self.energy = if self.leakage_rate > 0.0 {
            let settled = power / self.leakage_rate;
            settled + (self.energy - settled) * (-self.leakage_rate * seconds).exp()
        } else {
            self.energy + power * seconds
        };
        self.energy = self.energy.clamp(0.0, self.capacity);
    }

    fn switch(&mut self) {
        if self.energy <= self.lock_out {
            self.on = false;
        } else if self.energy >= self.turn_on {
            self.on = true;
        }
    }
}

/// An action, and what it really takes.
#[derive(Debug, Clone, Copy)]
struct Deed {
    declared: Action<f32>,
    energy: f64,
    duration: f64,
    /// Part of the duration in which all of it is taken, and where that part begins.
    taken: [f64; 2],
}

/// What the node does with its budget.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Policy {
    /// Whatever can be afforded.
    Afford,
    /// Whatever can be run now.
    RunNow,
}

/// What the node knows.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Knowledge {
    /// What each action took; the voltage once, at the start.
    Costs,
    /// What actions declare; the voltage every so many minutes, to within a quantum and a noise that is bounded.
    Voltage { every: u32, error: f64 },
}

#[derive(Debug, Clone, Copy, Default)]
struct EnergyAccumulator {
    started: u32,
    refused: u32,
    emptied: u32,
    /// Joules at the load: what actions and the standing load took, what they could have taken, and what of
    /// that is left in the end.
    spent: f64,
    spendable: f64,
    left: f64,
}

struct Day {
    budget: Budget<f32, SLOTS>,
    truth: TrueStore,
    standing: f64,
    actions: Vec<Action<f32>>,
    thrift: [f64; 2],
    policy: Policy,
    knowledge: Knowledge,
    /// Mean power of the harvester in each minute, and what part of a minute brings it.
    income: Vec<[f64; 2]>,
}

fn storage(random: &mut Random, kind: Kind) -> StorageParameters<f32> {
    let highest = random.between(3.0, 5.5);
    let off = highest * random.between(0.3, 0.7);
    let capacitance = random.between_logarithmic(47e-6, 5e-3);
    // Time constant of the voltage, in seconds.
    let constant = random.between_logarithmic(if kind == Kind::Average { 1e6 } else { 100.0 }, 1e8);
    let leaks = kind == Kind::Average || !random.next().is_multiple_of(4);
    StorageParameters {
        capacitor: Capacitor {
            capacitance: capacitance as f32,
            leakage_resistance: if leaks { (constant / capacitance) as f32 } else { f32::INFINITY },
        },
        charging_efficiency: random.between(0.5, 1.0) as f32,
        discharging_efficiency: random.between(0.5, 1.0) as f32,
        highest_voltage: highest as f32,
        lock_out_voltage: off as f32,
        turn_on_voltage: random.between(off, highest) as f32,
    }
}

/// Mean power of the harvester over `step` seconds from `start` in a minute that brings `power` on average, all of
/// it in the first `part` of the minute.
fn power_within(start: f64, step: f64, [power, part]: [f64; 2]) -> f64 {
    let end = 60.0 * part;
    power / part * ((end - start) / step).clamp(0.0, 1.0)
}

/// Which days.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// Whatever may happen.
    Any,
    /// A storage that leaks little and takes what a minute brings, and actions that suit it.
    Average,
}

/// Whether and when it is light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Season {
    dawn: f64,
    dusk: f64,
    indoors: bool,
}

impl Season {
    pub(crate) fn new(random: &mut Random) -> Self {
        let (dawn, dusk) = (random.between(0.1, 0.4), random.between(0.6, 0.95));
        Self { dawn, dusk, indoors: random.next().is_multiple_of(2) }
    }

    /// A day with clouds.
    pub(crate) fn day(&self, random: &mut Random, mean: f64) -> Vec<[f64; 2]> {
        income(random, *self, mean, Kind::Average)
    }
}

/// Nights, clouds, spikes and gaps; watts in each minute.
fn income(random: &mut Random, season: Season, mean: f64, kind: Kind) -> Vec<[f64; 2]> {
    let Season { dawn, dusk, indoors } = season;
    let (mut cloud, mut gap) = (1.0, 0_u32);
    (0..MINUTES)
        .map(|minute| {
            let time = f64::from(minute) / f64::from(MINUTES);
            cloud = (cloud + 0.2 * random.between(-1.0, 1.0)).clamp(0.05, 2.0);
            let sun = ((time - dawn) / (dusk - dawn) * core::f64::consts::PI).sin().max(0.0);
            let shape = if indoors {
                0.6
            } else if time > dawn && time < dusk {
                2.0 * sun
            } else {
                0.0
            };
            let mut power = mean * shape * cloud;
            if kind == Kind::Any {
                if random.next().is_multiple_of(200) {
                    power += mean * random.between_logarithmic(1.0, 300.0);
                }
                if gap == 0 && random.next().is_multiple_of(300) {
                    gap = random.between(1.0, 180.0) as u32;
                }
            }
            if gap > 0 {
                gap -= 1;
                power = 0.0;
            }
            [power, [1.0, 0.5, 0.02][(random.next() % 3) as usize]]
        })
        .collect()
}

impl Day {
    fn new(random: &mut Random, kind: Kind) -> Self {
        let parameters = storage(random, kind);
        // What the budget was told, to the bit: single precision is exact in double.
        let energy =
            |voltage: f32| 0.5 * f64::from(parameters.capacitor.capacitance) * f64::from(voltage).powi(2);
        let (capacity, lock_out) = (energy(parameters.highest_voltage), energy(parameters.lock_out_voltage));
        let (charging, discharging) =
            (f64::from(parameters.charging_efficiency), f64::from(parameters.discharging_efficiency));
        let usable = (capacity - lock_out) * discharging;
        let mut truth = TrueStore {
            energy: random.between(0.5 * lock_out, capacity),
            capacity,
            lock_out,
            turn_on: energy(parameters.turn_on_voltage),
            leakage_rate: 2.0
                / (f64::from(parameters.capacitor.capacitance)
                    * f64::from(parameters.capacitor.leakage_resistance)),
            charging,
            discharging,
            on: true,
        };
        truth.switch();
        let stores_a_day = if kind == Kind::Average {
            random.between(5.0, 50.0)
        } else {
            random.between_logarithmic(0.3, 3e3)
        };
        let mean = stores_a_day * usable / 86_400.0;
        let standing = (mean * random.between(0.0, 0.3)) as f32;
        let count = 1 + random.next() % 4;
        let part = if kind == Kind::Average { [0.04, 0.1] } else { [1e-3, 1.0] };
        let actions = (0..count)
            .map(|_| {
                let energy = usable * random.between_logarithmic(part[0], part[1]);
                let duration = random.between_logarithmic(1e-3, 10.0);
                Action::new("deed", energy as f32, duration as f32).expect("finite")
            })
            .collect();
        let budget = BudgetParameters {
            storage: parameters,
            income: IncomeParameters { time_constant: 7200.0, day_weight: 0.5 },
            standing_power: standing,
        };
        let highest = f64::from(parameters.highest_voltage);
        let season = Season::new(random);
        Self {
            budget: budget.build().expect("within bounds"),
            truth,
            standing: f64::from(standing) * if random.next().is_multiple_of(2) { 1.0 } else { random.unit() },
            actions,
            thrift: if random.next().is_multiple_of(2) { [1.0, 1.0] } else { [0.4, 1.0] },
            policy: if random.next().is_multiple_of(2) { Policy::Afford } else { Policy::RunNow },
            knowledge: if kind == Kind::Any && random.next().is_multiple_of(2) {
                Knowledge::Costs
            } else {
                let bits = [8.0, 10.0, 12.0][(random.next() % 3) as usize];
                let error = highest / f64::powf(2.0, bits) * random.between(0.5, 2.0);
                Knowledge::Voltage { every: [1, 10, 60][(random.next() % 3) as usize], error }
            },
            income: income(random, season, mean, kind),
        }
    }

    /// One day, minute by minute.
    fn run(mut self, random: &mut Random) -> EnergyAccumulator {
        let mut accumulator = EnergyAccumulator::default();
        let brought: f64 = self.income.iter().map(|[power, _]| power * 60.0).sum();
        let had = (self.truth.energy - self.truth.lock_out).max(0.0);
        accumulator.spendable = (brought * self.truth.charging + had) * self.truth.discharging;
        let mut state = self.budget.start(0);
        let mut off = 0;
        self.measure(&mut state, random);
        for minute in 0..MINUTES {
            if !self.truth.on {
                // The node does not run: nothing is updated until it does again.
                self.sleep([0.0, 60.0], self.income[minute as usize], &mut accumulator);
                self.truth.switch();
                off += 60;
                continue;
            }
            if off > 0 {
                self.budget.gap(&mut state, off);
                self.measure(&mut state, random);
                off = 0;
            } else if let Knowledge::Voltage { every, .. } = self.knowledge
                && minute % every == 0
            {
                self.measure(&mut state, random);
            }
            let harvested = self.minute(minute, &mut state, random, &mut accumulator);
            self.budget.update(&mut state, 60, harvested as f32, 0.0);
            self.truth.switch();
        }
        accumulator.left = (self.truth.energy - self.truth.lock_out).max(0.0) * self.truth.discharging;
        accumulator
    }

    /// A minute of a node that is on; what its harvester brought, in joules.
    fn minute(
        &mut self,
        minute: u32,
        state: &mut BudgetState<f32, SLOTS>,
        random: &mut Random,
        accumulator: &mut EnergyAccumulator,
    ) -> f64 {
        let income = self.income[minute as usize];
        let (mut passed, mut harvested) = (0.0, 0.0);
        for _ in 0..4 {
            if random.next().is_multiple_of(4) {
                // Not beyond the minute: its income ends there.
                let until = (passed + random.between(0.0, 20.0)).min(60.0);
                harvested += self.sleep([passed, until], income, accumulator);
                passed = until;
            }
            let action = self.actions[(random.next() % self.actions.len() as u64) as usize];
            let now = 60 * minute + f64::ceil(passed) as u32;
            let allowed = match self.policy {
                Policy::Afford => self.budget.can_afford(state, &action, now),
                Policy::RunNow => self.budget.can_run_now(state, &action, now),
            };
            if passed > BUSY {
                break;
            }
            if !allowed {
                accumulator.refused += 1;
                continue;
            }
            let energy = f64::from(action.energy()) * random.between(self.thrift[0], self.thrift[1]);
            let start = random.between(0.0, 0.9);
            let deed = Deed {
                declared: action,
                energy,
                duration: f64::from(action.duration()) * random.between(0.1, 1.0),
                taken: [[0.0, 0.1], [0.9, 1.0], [0.0, 1.0], [start, start + 0.1]]
                    [(random.next() % 4) as usize],
            };
            harvested += self.act(&deed, income, passed, accumulator);
            passed += deed.duration;
            let booked = if self.knowledge == Knowledge::Costs {
                // Rounded to the budget's precision upwards.
                deed.energy as f32 * (1.0 + f32::EPSILON)
            } else {
                deed.declared.energy()
            };
            self.budget.spend(state, booked);
        }
        harvested + self.sleep([passed, 60.0], income, accumulator)
    }

    /// An action is carried out, in ten steps, `passed` seconds into the minute; what the harvester brought.
    fn act(
        &mut self,
        deed: &Deed,
        income: [f64; 2],
        passed: f64,
        accumulator: &mut EnergyAccumulator,
    ) -> f64 {
        let step = deed.duration / 10.0;
        let [begin, end] = deed.taken;
        let (mut harvested, mut lowest) = (0.0, f64::INFINITY);
        for k in 0..10 {
            // Of the energy, by how much of the step is inside the part in which it is taken.
            let (from, to) = (f64::from(k) * 0.1, f64::from(k + 1) * 0.1);
            let share = (to.min(end) - from.max(begin)).max(0.0) / (end - begin);
            let bringing = power_within(passed + f64::from(k) * step, step, income);
            self.truth.advance(step, bringing, self.standing + deed.energy * share / step);
            harvested += bringing * step;
            lowest = lowest.min(self.truth.energy);
        }
        accumulator.started += 1;
        accumulator.emptied += u32::from(lowest < self.truth.lock_out);
        accumulator.spent += deed.energy + self.standing * deed.duration;
        harvested
    }

    /// Nothing is done from and until so many seconds of a minute, in ten steps; what the harvester brought.
    fn sleep(
        &mut self,
        [from, until]: [f64; 2],
        income: [f64; 2],
        accumulator: &mut EnergyAccumulator,
    ) -> f64 {
        let (step, mut harvested) = ((until - from) / 10.0, 0.0);
        for k in 0..10 {
            let bringing = power_within(from + f64::from(k) * step, step, income);
            if self.truth.on {
                accumulator.spent += self.standing * step;
            }
            self.truth.advance(step, bringing, self.standing);
            harvested += bringing * step;
        }
        harvested
    }

    /// The node reads its voltage.
    fn measure(&self, state: &mut BudgetState<f32, SLOTS>, random: &mut Random) {
        let voltage = self.budget.storage().parameters().highest_voltage;
        let voltage = f64::from(voltage) * (self.truth.energy / self.truth.capacity).sqrt();
        let error = match self.knowledge {
            // As exact as the node can have it.
            Knowledge::Costs => 1e-6 * voltage,
            Knowledge::Voltage { error, .. } => error,
        };
        let read = (voltage + error * random.between(-1.0, 1.0)).max(0.0);
        // A bound of the error is rounded upwards as well.
        self.budget.correct_by_voltage(state, read as f32, (error * 1.000_001 + 1e-6 * voltage) as f32);
    }
}

fn days(seed: u64, count: u32, kind: Kind) -> Vec<EnergyAccumulator> {
    (0..count)
        .map(|day| {
            let mut random = Random(seed.wrapping_add(u64::from(day) << 32));
            Day::new(&mut random, kind).run(&mut random)
        })
        .collect()
}

fn check_random_days(seed: u64, count: u32) {
    let tallies = days(seed, count, Kind::Any);
    let sum = |of: fn(&EnergyAccumulator) -> u32| tallies.iter().map(|t| u64::from(of(t))).sum::<u64>();
    let (started, refused) = (sum(|t| t.started), sum(|t| t.refused));
    println!("{count} days: {started} actions started, {refused} refused");
    for (day, accumulator) in tallies.iter().enumerate() {
        assert_eq!(accumulator.emptied, 0, "day {day}: {accumulator:?}");
    }
    // That nothing is emptied says something only if much is started and much is refused.
    assert!(started > 100 * u64::from(count) && refused > 100 * u64::from(count));
}

#[test]
fn no_action_empties_the_store_in_a_hundred_random_days() {
    check_random_days(1, 100);
}

/// `cargo test --release -p model-core energy_budget:: -- --ignored --nocapture`
#[test]
#[ignore = "a minute in release"]
fn no_action_empties_the_store_in_ten_thousand_random_days() {
    check_random_days(2, 10_000);
}

#[test]
fn what_average_days_bring_is_spent() {
    let mut used: Vec<f64> = days(3, 100, Kind::Average)
        .iter()
        .map(|accumulator| accumulator.spent / (accumulator.spendable - accumulator.left))
        .collect();
    used.sort_by(f64::total_cmp);
    let mean = used.iter().sum::<f64>() / used.len() as f64;
    println!("spent of what could be: mean {mean:.3}, least {:.3}, median {:.3}", used[0], used[50]);
    assert!(mean > 0.95 && used[5] > 0.85);
}
