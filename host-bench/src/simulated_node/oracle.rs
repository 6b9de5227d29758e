//! The greatest number of equal actions without a lock-out, by a node that knows its income.

use model_core::node::{IncomeOfTime, Task, Wake};

use super::Strategy;
use super::plant::World;

/// A storage whose income is known. Energies in J.
#[derive(Debug, Clone, PartialEq)]
pub struct Oracle {
    /// Stored at the beginning, and at the end at least.
    pub begin: f64,
    pub end: f64,
    /// At the highest voltage, and at the lock-out.
    pub capacity: f64,
    pub lock_out: f64,
    /// Of an action, and the shortest time in s from one to the next.
    pub action: f64,
    pub every: u32,
    /// Income without the standing power in each second, and the part of the energy that leaks in it.
    pub net: Vec<f64>,
    pub leaking: f64,
}

impl Oracle {
    /// Of a plant at its begin over so many seconds, which ends with no less than `end`, or than it has to leave.
    pub(super) fn new(world: &World<'_>, seconds: usize, end: f64) -> Self {
        let [draw, action, leaking] = world.draws();
        let reserve = f64::from(world.parameters.reserve) + world.lock_out();
        Self {
            begin: world.energy,
            // A schedule may end with the same, up to a rounding.
            end: end.min(reserve) * (1.0 - 1e-12),
            capacity: world.capacity(),
            lock_out: world.lock_out(),
            action,
            every: world.parameters.actions[0].every,
            net: (0..seconds as u32).map(|second| world.stored_of(second) - draw).collect(),
            leaking,
        }
    }

    /// The seconds of the actions, or `None` if the storage is locked out without any.
    ///
    /// An action runs at each second at which the shortest time has passed and the storage, without any further action, neither
    /// locks out nor ends below `end`. No other schedule has more. Let `s₁ < s₂ < …` be one without a lock-out, and `g₁ < g₂ < …`
    /// this one. In a second the energy goes by `f(E) = min(capacity, (1 − λ) E + net)`. It rises with `E`, and
    /// `f(E − a) ≥ f(E) − a` for `a ≥ 0`. While this schedule is ahead by `d ≥ 0` actions, its energy is therefore at least that of the
    /// other one less `d` actions: by the second property in a second without an action, and by subtraction at an action of
    /// either. If `gᵢ ≤ sᵢ` for all `i ≤ k`, then at `sₖ₊₁` with `k` actions each, this one has at least the energy of the other, and has
    /// rested for at least as long. The other may act there, so this one may too, as more energy at one time is more energy at all
    /// later ones: `gₖ₊₁ ≤ sₖ₊₁`. By induction each action of the other has one of this schedule.
    pub fn schedule(&self) -> Option<Vec<u32>> {
        // What must be stored before each second, and at the end.
        let mut needed = vec![self.end.max(self.lock_out); self.net.len() + 1];
        for (second, net) in self.net.iter().enumerate().rev() {
            needed[second] = ((needed[second + 1] - net) / (1.0 - self.leaking)).max(self.lock_out);
            if needed[second + 1] >= self.capacity {
                return None;
            }
        }
        let mut energy = self.begin;
        if energy <= needed[0] {
            return None;
        }
        let mut acted: Vec<u32> = Vec::new();
        for (second, net) in self.net.iter().enumerate() {
            let has_rested = acted.last().is_none_or(|last| second as u32 - last >= self.every);
            if has_rested && energy - self.action > needed[second] {
                energy -= self.action;
                acted.push(second as u32);
            }
            energy = (energy + net - self.leaking * energy).min(self.capacity);
        }
        Some(acted)
    }
}

/// A node that acts at these seconds, the first ones last.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Planned(Vec<u32>);

impl Planned {
    pub(super) fn new(mut seconds: Vec<u32>) -> Self {
        seconds.reverse();
        Self(seconds)
    }
}

impl Strategy for Planned {
    fn wake(&mut self, now: u32, _: Option<u32>, _: bool) -> Wake {
        let rest = self.0.last().map_or(60, |second| second.saturating_sub(now).min(60));
        if rest == 0 {
            self.0.pop();
            return Wake { task: Task::Run(0), again_in: 0, read: false };
        }
        Wake { task: Task::Sleep, again_in: rest, read: false }
    }

    fn last_hour(&self) -> Option<IncomeOfTime> {
        None
    }

    fn spent(&self) -> f64 {
        0.0
    }
}
