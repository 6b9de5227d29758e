//! The store of a node as it is, whatever it stands on.

use super::store::StoreAccount;
use crate::embedded::StoreInLoop;
use crate::method::Failure;
use crate::scene_file::Storage;

/// What the node lives in.
pub(super) trait Plant {
    /// Voltage of the store in V.
    fn voltage(&self) -> f64;

    /// Energy in it in J.
    fn energy(&self) -> f64;

    /// Whether the node is switched on.
    fn is_supplied(&self) -> bool;

    /// Whether it was so all through the last interval.
    fn was_supplied(&self) -> bool;

    /// An action takes `joules` at the node.
    fn spend(&mut self, joules: f64);

    /// Some seconds go by from a second of the day on; gives what the harvester delivers in them, in J.
    ///
    /// # Errors
    /// If the trajectory cannot go on.
    fn advance(&mut self, from: u32, seconds: u32) -> Result<f64, Failure>;

    /// Where energy came from and went since the account began.
    fn account(&self) -> &StoreAccount;

    /// The account starts anew.
    fn begin_account(&mut self);
}

/// The store of a trajectory of the core.
///
/// What actions take is drawn as a constant power over the interval that follows them. The core's store has no
/// highest voltage: what is above it at the end of an interval is drawn in the next as well, and counted as shunted.
pub(super) struct LoopedStore<'a> {
    looped: &'a mut dyn StoreInLoop,
    storage: &'a Storage,
    /// What the standing load takes from the store, in W.
    standing_w: f64,
    /// What actions take from the store in the next interval, in J.
    pending_j: f64,
    was_supplied: bool,
    account: StoreAccount,
}

impl<'a> LoopedStore<'a> {
    /// At midnight; `standing_power_w` is that of the node.
    pub(super) fn new(looped: &'a mut dyn StoreInLoop, storage: &'a Storage, standing_power_w: f64) -> Self {
        let standing_w = standing_power_w / storage.discharging_efficiency + storage.own_power_w;
        let account = StoreAccount::default();
        Self { looped, storage, standing_w, pending_j: 0.0, was_supplied: false, account }
    }

    fn energy_at(&self, voltage: f64) -> f64 {
        0.5 * self.storage.capacitance_f * voltage * voltage
    }
}

impl Plant for LoopedStore<'_> {
    fn voltage(&self) -> f64 {
        self.looped.voltage()
    }

    fn energy(&self) -> f64 {
        self.energy_at(self.looped.voltage()) - self.pending_j
    }

    fn is_supplied(&self) -> bool {
        self.looped.is_connected()
    }

    fn was_supplied(&self) -> bool {
        self.was_supplied
    }

    fn spend(&mut self, joules: f64) {
        self.pending_j += joules / self.storage.discharging_efficiency;
    }

    fn advance(&mut self, from: u32, seconds: u32) -> Result<f64, Failure> {
        let began = self.looped.is_connected();
        let excess = (self.energy() - self.energy_at(self.storage.highest_v)).max(0.0);
        let length = f64::from(seconds);
        let standing = self.standing_w * length;
        let asked = std::mem::take(&mut self.pending_j) + excess + standing;
        let stretch = self.looped.advance(from + seconds, asked / length)?;
        self.was_supplied = began && self.looped.is_connected();
        // A node that was switched off within the interval took the same part of each.
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

    fn account(&self) -> &StoreAccount {
        &self.account
    }

    fn begin_account(&mut self) {
        self.account = StoreAccount::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embedded::Stretch;

    /// A store of 1 mF that takes 10 µW, loses nothing, and gives whatever is asked.
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
        let mut world = LoopedStore::new(&mut plain, &storage, 2e-6);
        world.spend(0.1e-3);
        assert!((world.energy() - 4.3e-3).abs() < 1e-15, "an action counts at once");
        world.advance(0, 60).expect("nothing can fail");
        // 600 µJ in, 200 µJ of the action and 60 s of 5 µW out.
        assert!((world.energy() - 4.6e-3).abs() < 1e-12);
        for minute in 1..60 {
            world.advance(60 * minute, 60).expect("nothing can fail");
        }
        // Full at 5.12 mJ: what comes in over an interval is above that at its end.
        assert!((world.energy() - 5.12e-3 - 0.3e-3).abs() < 1e-12, "{}", world.energy());
        let account = *world.account();
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(account.actions, 0.2e-3);
        close(account.standing, 18e-3);
        close(account.income, 36e-3);
        close(account.shunted, 4.5e-3 + 36e-3 - 18e-3 - 0.2e-3 - world.energy());
        assert_eq!((account.lockout_s, account.lockouts, account.steps), (0, 0, 60));
    }
}
