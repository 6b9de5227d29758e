//! A storage that is simulated with its harvester and bridge, step by step, on the embedded core.

use harvester_scene::progress;

use super::{Plant, StorageAccount, energy_at, standing_power};
use crate::embedded::StoreInLoop;
use crate::method::Failure;
use crate::scene_file::Storage;

/// The storage of a trajectory of the core.
///
/// The energy of actions is drawn as a constant power over the interval that follows them. The core's storage has no
/// highest voltage: energy above it at the end of an interval is drawn in the next interval, and counted as shunted.
pub(in crate::budget) struct LoopedStorage<'a> {
    looped: &'a mut dyn StoreInLoop,
    storage: &'a Storage,
    /// Power of the standing load at the storage in W.
    standing_w: f64,
    /// Energy at the storage in J that is drawn for actions in the next interval.
    pending_j: f64,
    was_supplied: bool,
    account: StorageAccount,
}

impl<'a> LoopedStorage<'a> {
    /// The storage at midnight; `standing_power_w` is the power at the node.
    pub(in crate::budget) fn new(
        looped: &'a mut dyn StoreInLoop,
        storage: &'a Storage,
        standing_power_w: f64,
    ) -> Self {
        let standing_w = standing_power(storage, standing_power_w);
        let account = StorageAccount::default();
        Self { looped, storage, standing_w, pending_j: 0.0, was_supplied: false, account }
    }
}

impl Plant for LoopedStorage<'_> {
    fn voltage(&self) -> f64 {
        self.looped.voltage()
    }

    fn energy(&self) -> f64 {
        energy_at(self.storage, self.looped.voltage()) - self.pending_j
    }

    fn is_supplied(&self) -> bool {
        self.looped.is_connected()
    }

    fn was_supplied(&self) -> bool {
        self.was_supplied
    }

    fn spend(&mut self, energy: f64) {
        self.pending_j += energy / self.storage.discharging_efficiency;
    }

    fn advance(&mut self, from: u32, seconds: u32) -> Result<f64, Failure> {
        let began = self.looped.is_connected();
        let excess = (self.energy() - energy_at(self.storage, self.storage.highest_v)).max(0.0);
        let length = f64::from(seconds);
        let standing = self.standing_w * length;
        let asked = std::mem::take(&mut self.pending_j) + excess + standing;
        let stretch = self.looped.advance(from + seconds, asked / length)?;
        progress::report(f64::from(from + seconds) / 86_400.0, [self.account.steps, 0]);
        self.was_supplied = began && self.looped.is_connected();
        // A node that is switched off within the interval takes the same part of each.
        let part = if asked > 0.0 { stretch.drawn_j / asked } else { 0.0 };
        let account = &mut self.account;
        account.harvested += stretch.delivered_j;
        account.income += stretch.delivered_j;
        account.leaked += stretch.leaked_j;
        account.shunted += part * excess;
        account.standing += part * standing;
        account.actions += part * (asked - excess - standing);
        account.diodes += stretch.diodes_j;
        account.steps += stretch.steps;
        account.lockout_s += if self.was_supplied { 0 } else { seconds };
        account.lockouts += u32::from(began && !self.looped.is_connected());
        Ok(stretch.delivered_j)
    }

    fn account(&mut self) -> &mut StorageAccount {
        &mut self.account
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embedded::Stretch;

    /// A storage of 1 mF that is charged by 10 µW, loses nothing, and supplies any power.
    struct Plain {
        second: u32,
        energy: f64,
    }

    impl StoreInLoop for Plain {
        fn advance(&mut self, until_s: u32, draw_w: f64) -> Result<Stretch, Failure> {
            let seconds = f64::from(until_s - self.second);
            let stretch = Stretch {
                delivered_j: 10e-6 * seconds,
                drawn_j: draw_w * seconds,
                steps: 1,
                ..Stretch::default()
            };
            self.energy += stretch.delivered_j - stretch.drawn_j;
            self.second = until_s;
            Ok(stretch)
        }

        fn voltage(&self) -> f64 {
            (2.0 * self.energy / 1e-3).sqrt()
        }

        fn is_connected(&self) -> bool {
            true
        }
    }

    #[test]
    fn actions_standing_load_and_excess_are_drawn_in_the_next_interval() {
        let storage = Storage {
            capacitance_f: 1e-3,
            leakage_ohm: f64::INFINITY,
            initial_v: 3.0,
            charging_efficiency: 1.0,
            discharging_efficiency: 0.5,
            highest_v: 3.2,
            turn_off_v: 1.0,
            turn_on_v: 2.0,
            own_power_w: 1e-6,
        };
        let mut plain = Plain { second: 0, energy: 4.5e-3 };
        let mut plant = LoopedStorage::new(&mut plain, &storage, 2e-6);
        plant.spend(0.1e-3);
        assert!((plant.energy() - 4.3e-3).abs() < 1e-15, "an action counts at once");
        plant.advance(0, 60).expect("nothing can fail");
        // 600 µJ in, 200 µJ of the action and 60 s of 5 µW out.
        assert!((plant.energy() - 4.6e-3).abs() < 1e-12);
        for minute in 1..60 {
            plant.advance(60 * minute, 60).expect("nothing can fail");
        }
        // Full at 5.12 mJ: what comes in over an interval is above that at its end.
        assert!((plant.energy() - 5.12e-3 - 0.3e-3).abs() < 1e-12, "{}", plant.energy());
        let account = *plant.account();
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(account.actions, 0.2e-3);
        close(account.standing, 18e-3);
        close(account.income, 36e-3);
        close(account.shunted, 4.5e-3 + 36e-3 - 18e-3 - 0.2e-3 - plant.energy());
        assert_eq!((account.lockout_s, account.lockouts, account.steps), (0, 0, 60));
    }
}
