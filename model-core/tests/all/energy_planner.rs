//! A planner spends what random days bring, without filling or emptying the storage, and as evenly as the storage allows.
//!
//! Random nodes learn the income of seven random days; on the eighth they spend by plan. Every day of a node has the
//! same hours of light and other clouds. The true storage is simulated in `f64`, minute by minute.

use crate::common::Random;
use crate::energy_budget::{MINUTES, SLOTS, Season, TrueStore};
use model_core::energy::{Action, Budget, BudgetParameters, Capacitor, IncomeParameters, StorageParameters};

const LEARNT: u32 = 7;

/// A node: a storage of 1 to 24 hours of the mean income.
struct Node {
    budget: Budget<f32, SLOTS>,
    season: Season,
    truth: TrueStore,
    mean: f64,
    standing: f64,
    action: Action<f32>,
}

/// What became of the eighth day, in joules at the load.
#[derive(Debug, Clone, Copy)]
struct Spent {
    /// Spent, and what the storage holds above the lock-out at the end.
    used: f64,
    /// What was there and what came, had nothing been shunted or leaked.
    brought: f64,
    /// Actions that found the storage at its lock-out.
    emptied: u32,
    /// Standard deviation of the energy of an hour over its mean.
    unevenness: f64,
    /// The same of a node that spends whatever it can afford.
    greedy: f64,
}

impl Node {
    fn new(random: &mut Random) -> Self {
        let mean = random.between_logarithmic(1e-6, 1e-3);
        let hours = random.between_logarithmic(1.0, 24.0);
        let (highest, lock_out) = (4.5, random.between(1.5, 3.0));
        let (charging, discharging) = (random.between(0.5, 1.0), random.between(0.5, 1.0));
        let capacitance =
            2.0 * mean * charging * hours * 3600.0 / (f64::powi(highest, 2) - f64::powi(lock_out, 2));
        // Leaks a tenth of its energy in 10 to 1000 hours.
        let constant = 2.0 * 36e3 * random.between_logarithmic(10.0, 1000.0);
        let parameters = StorageParameters {
            capacitor: Capacitor {
                capacitance: capacitance as f32,
                leakage_resistance: (constant / capacitance) as f32,
            },
            charging_efficiency: charging as f32,
            discharging_efficiency: discharging as f32,
            highest_voltage: highest as f32,
            lock_out_voltage: lock_out as f32,
            turn_on_voltage: (lock_out * 1.05) as f32,
        };
        let standing = 0.05 * mean * charging * discharging;
        let usable = mean * charging * hours * 3600.0 * discharging;
        let budget = BudgetParameters {
            storage: parameters,
            income: IncomeParameters { time_constant: 7200.0, day_weight: 0.5 },
            standing_power: standing as f32,
        };
        let energy = |voltage: f64| 0.5 * capacitance * voltage.powi(2);
        Self {
            budget: budget.build().expect("within the bounds"),
            season: Season::new(random),
            truth: TrueStore {
                energy: energy(random.between(lock_out, highest)),
                capacity: energy(highest),
                lock_out: energy(lock_out),
                turn_on: energy(lock_out * 1.05),
                leakage_rate: 2.0 / constant,
                charging,
                discharging,
                on: true,
            },
            mean,
            standing,
            action: Action::new("work", (usable / 200.0) as f32, 0.1).expect("finite"),
        }
    }

    /// The eighth day.
    fn run(&mut self, random: &mut Random) -> Spent {
        let mut days = Vec::new();
        (0..=LEARNT).for_each(|_| days.push(self.season.day(random, self.mean)));
        let last = days.pop().expect("a day");
        let mut state = self.budget.start(0);
        for [power, _] in days.concat() {
            self.budget.update(&mut state, 60, (power * 60.0) as f32, 0.0);
        }
        let voltage = (self.truth.energy / self.truth.capacity).sqrt() * 4.5;
        self.budget.correct_by_voltage(&mut state, voltage as f32, 1e-3);
        let mut greedy = self.truth;
        let truth = &mut self.truth;
        let had = truth.energy - truth.lock_out;
        let came: f64 = last.iter().map(|[power, _]| power * 60.0 * truth.charging).sum();
        let (mut hours, mut greedy_hours) = ([0.0_f64; 24], [0.0_f64; 24]);
        let (mut credit, mut emptied) = (0.0, 0);
        let (work, drawn) =
            (f64::from(self.action.energy()), f64::from(self.action.energy()) / truth.discharging);
        for minute in 0..MINUTES {
            let hour = (minute / 60) as usize;
            let power = last[minute as usize][0];
            let planned = f64::from(self.budget.planned_power(&state, self.action.energy()));
            credit = (credit + (planned - self.standing) * 60.0 / work).min(20.0);
            while credit >= 1.0 && self.budget.can_afford(&state, &self.action, 60 * minute) {
                self.budget.spend(&mut state, self.action.energy());
                truth.energy -= drawn;
                emptied += u32::from(truth.energy < truth.lock_out);
                hours[hour] += work;
                credit -= 1.0;
            }
            while greedy.energy - 1.5 * drawn > greedy.lock_out {
                greedy.energy -= drawn;
                greedy_hours[hour] += work;
            }
            let on = truth.energy > truth.lock_out;
            truth.advance(60.0, power, if on { self.standing } else { 0.0 });
            greedy.advance(60.0, power, self.standing);
            hours[hour] += if on { self.standing * 60.0 } else { 0.0 };
            self.budget.update(&mut state, 60, (power * 60.0) as f32, 0.0);
        }
        let left = (truth.energy - truth.lock_out).max(0.0);
        Spent {
            used: hours.iter().sum::<f64>() + left * truth.discharging,
            brought: (had + came) * truth.discharging,
            emptied,
            unevenness: unevenness(&hours),
            greedy: unevenness(&greedy_hours),
        }
    }
}

/// Standard deviation over mean.
fn unevenness(hours: &[f64]) -> f64 {
    let mean = hours.iter().sum::<f64>() / hours.len() as f64;
    let square = hours.iter().map(|hour| (hour - mean).powi(2)).sum::<f64>() / hours.len() as f64;
    square.sqrt() / mean
}

#[test]
fn random_days_are_spent_by_plan() {
    let mut random = Random(7);
    let days: Vec<Spent> = (0..1000).map(|_| Node::new(&mut random).run(&mut random)).collect();
    assert!(days.iter().all(|day| day.emptied == 0));
    let mut used: Vec<f64> = days.iter().map(|day| day.used / day.brought).collect();
    used.sort_by(f64::total_cmp);
    let mean = used.iter().sum::<f64>() / used.len() as f64;
    let median = |of: fn(&Spent) -> f64| {
        let mut values: Vec<f64> = days.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let (even, greedy) = (median(|day| day.unevenness), median(|day| day.greedy));
    println!("used: mean {mean:.3}, 5 of 100 below {:.3}, least {:.3}", used[50], used[0]);
    println!("unevenness of the hours: {even:.2}, without a plan {greedy:.2}");
    // An upper bound of what perfect knowledge could spend is all that was brought.
    assert!(mean >= 0.9, "{mean}");
    assert!(even < 0.5 * greedy, "{even} {greedy}");
}
