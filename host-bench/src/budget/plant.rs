//! The storage of a node as it is, and the harvester that charges it: what the node's budget is an estimate of.

use super::income::Income;
use crate::embedded::StoreInLoop;
use crate::method::Failure;
use crate::scene_file::Storage;
use harvester_scene::progress;

/// The storage of a node with its harvester and loads.
pub(super) trait Plant {
    /// Voltage of the storage in V.
    fn voltage(&self) -> f64;

    /// Energy in the storage in J.
    fn energy(&self) -> f64;

    /// Whether the node is switched on.
    fn is_supplied(&self) -> bool;

    /// Whether the node was switched on all through the last interval.
    fn was_supplied(&self) -> bool;

    /// Takes the energy in J of an action at the node.
    fn spend(&mut self, energy: f64);

    /// Advances by some seconds from a second of the day on; gives the energy in J that the harvester delivers in them.
    fn advance(&mut self, from: u32, seconds: u32) -> Result<f64, Failure>;

    /// Where energy came from and went since the account began.
    fn account(&mut self) -> &mut StorageAccount;
}

/// Energy in J of a storage at a voltage in V.
pub(super) fn energy_at(storage: &Storage, voltage: f64) -> f64 {
    storage.reservoir().energy_j(voltage)
}

/// Power in W at the storage of a standing load at the node, with the storage's own.
fn standing_power(storage: &Storage, at_node: f64) -> f64 {
    at_node / storage.discharging_efficiency + storage.own_power_w
}

/// Energies since the account began, in J: the first at the harvester's load, all others at the storage.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct StorageAccount {
    /// Delivered by the harvester.
    pub(super) harvested: f64,
    /// Delivered, times the charging efficiency.
    pub(super) income: f64,
    /// Income above the highest voltage.
    pub(super) shunted: f64,
    pub(super) leaked: f64,
    /// Taken by actions.
    pub(super) actions: f64,
    /// Taken by the standing load.
    pub(super) standing: f64,
    /// Lost in the diodes of a bridge, if the bridge is simulated step by step.
    pub(super) diodes: f64,
    /// Steps of the harvester, if it is simulated with the storage.
    pub(super) steps: u64,
    /// Seconds for which the node was switched off.
    pub(super) lockout_s: u32,
    /// How often the node was switched off.
    pub(super) lockouts: u32,
}

/// The storage of a trajectory of the core.
///
/// The energy of actions is drawn as a constant power over the interval that follows them. The core's storage has no
/// highest voltage: energy above it at the end of an interval is drawn in the next interval, and counted as shunted.
pub(super) struct LoopedStorage<'a> {
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
    pub(super) fn new(looped: &'a mut dyn StoreInLoop, storage: &'a Storage, standing_power_w: f64) -> Self {
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

// The energy of a storage under a given income, in double precision.
//
// Over each second the powers in and out are constant and the leakage resistance takes `2 E / (R C)`:
//
// ```text
// E' = P − 2 E / (R C)
// ```
//
// is solved exactly. Thresholds are checked every second. With a battery the factor of `E` is that of its self-discharge, and of
// the leakage resistance at the voltage at the beginning of an interval.

/// A storage charged by a given income, and whether the node at it is switched on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ChargedStorage<'a> {
    storage: Storage,
    income: &'a Income,
    /// Power of the standing load at the storage in W.
    standing_w: f64,
    energy: f64,
    supplied: bool,
    /// Whether the node was switched on all through the last interval.
    was_supplied: bool,
    account: StorageAccount,
}

impl<'a> ChargedStorage<'a> {
    /// The storage at its initial voltage; `standing_power_w` is the power at the node.
    pub(super) fn new(storage: &Storage, standing_power_w: f64, income: &'a Income) -> Self {
        Self {
            storage: *storage,
            income,
            standing_w: standing_power(storage, standing_power_w),
            energy: energy_at(storage, storage.initial_v),
            supplied: storage.initial_v >= storage.turn_on_v,
            was_supplied: false,
            account: StorageAccount::default(),
        }
    }

    fn switch(&mut self) {
        if self.supplied && self.energy < energy_at(&self.storage, self.storage.turn_off_v) {
            self.supplied = false;
            self.account.lockouts += 1;
        } else if !self.supplied && self.energy >= energy_at(&self.storage, self.storage.turn_on_v) {
            self.supplied = true;
        }
    }
}

impl Plant for ChargedStorage<'_> {
    fn voltage(&self) -> f64 {
        self.storage.reservoir().voltage_v(self.energy)
    }

    fn energy(&self) -> f64 {
        self.energy
    }

    fn is_supplied(&self) -> bool {
        self.supplied
    }

    fn was_supplied(&self) -> bool {
        self.was_supplied
    }

    fn spend(&mut self, energy: f64) {
        let drawn = energy / self.storage.discharging_efficiency;
        self.account.actions += drawn;
        self.energy -= drawn;
        self.switch();
    }

    fn advance(&mut self, from: u32, seconds: u32) -> Result<f64, Failure> {
        let before = self.account.harvested;
        self.was_supplied = self.supplied;
        let reservoir = self.storage.reservoir();
        let rate = reservoir.leaking(self.energy);
        let efficiency = self.storage.charging_efficiency * reservoir.charging_efficiency();
        let mean_remaining = if rate > 0.0 { -(-rate).exp_m1() / rate } else { 1.0 };
        for second in from..from + seconds {
            let harvested = self.income.power_w(second, self.voltage());
            let standing = if self.supplied { self.standing_w } else { 0.0 };
            let stored = harvested * efficiency;
            let end = self.energy * (-rate).exp() + (stored - standing) * mean_remaining;
            let account = &mut self.account;
            account.harvested += harvested;
            account.income += stored;
            account.standing += standing;
            // The leakage of the energy at the start, and of the constant power in, each in closed form.
            account.leaked += -(-rate).exp_m1() * self.energy + (1.0 - mean_remaining) * (stored - standing);
            account.lockout_s += u32::from(!self.supplied);
            self.energy = end.min(energy_at(&self.storage, self.storage.highest_v));
            self.account.shunted += end - self.energy;
            self.switch();
            self.was_supplied &= self.supplied;
        }
        Ok(self.account.harvested - before)
    }

    fn account(&mut self) -> &mut StorageAccount {
        &mut self.account
    }
}

#[cfg(test)]
mod tests {
    use harvester_scene::market::Battery;

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
            battery: None,
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

    const STORAGE: Storage = Storage {
        battery: None,
        capacitance_f: 1e-3,
        leakage_ohm: 1e6,
        initial_v: 3.0,
        charging_efficiency: 0.8,
        discharging_efficiency: 0.5,
        highest_v: 4.0,
        turn_off_v: 2.0,
        turn_on_v: 2.5,
        own_power_w: 1e-6,
    };

    #[test]
    fn a_leaking_storage_follows_its_exponential_and_its_account_closes() {
        let income = Income::constant(10e-6);
        let mut storage = ChargedStorage::new(&STORAGE, 2e-6, &income);
        let start = storage.energy();
        for k in 0..5 {
            storage.advance(100 * k, 100).expect("nothing can fail");
        }
        // 8 µW in, 2 µW through 0.5 and 1 µW out, time constant 500 s.
        let (net, rate): (f64, f64) = (8e-6 - 5e-6, 2.0 / (1e6 * 1e-3));
        let settled = net / rate;
        let expected = settled + (start - settled) * (-rate * 500.0).exp();
        assert!((storage.energy() / expected - 1.0).abs() < 1e-12);
        let account = *storage.account();
        let balance = account.income - account.leaked - account.shunted - account.actions - account.standing;
        assert!((storage.energy() - start - balance).abs() < 1e-15);
        assert!((account.harvested - 5e-3).abs() < 1e-12);
    }

    #[test]
    fn a_battery_follows_its_charge_and_its_account_closes() {
        let battery = Battery::named("slb12400l151").expect("a part");
        let storage = Storage {
            battery: Some(battery),
            capacitance_f: 100e-6,
            leakage_ohm: f64::INFINITY,
            initial_v: 2.3,
            highest_v: 2.7,
            ..STORAGE
        };
        let income = Income::constant(5e-3);
        let mut plant = ChargedStorage::new(&storage, 2e-6, &income);
        let start = plant.energy();
        // The charge, step by step: from 0.3 + 0.2 · 0.04/0.08 of 540 C, by the current of the stored power at the voltage.
        let mut state_of_charge = 0.4;
        let volts = |state: f64| {
            let after =
                battery.open_circuit.iter().position(|point| f64::from(point[0]) > state).expect("not full");
            let [from, to] = [after - 1, after].map(|at| battery.open_circuit[at].map(f64::from));
            from[1] + (to[1] - from[1]) * (state - from[0]) / (to[0] - from[0])
        };
        for hour in 0..10 {
            plant.advance(3600 * hour, 3600).expect("nothing can fail");
            for _ in 0..3600 {
                let power = 5e-3 * 0.8 * 0.99 - 5e-6 - 1.3e-8 * plant.energy();
                state_of_charge += power / volts(state_of_charge) / 540.0;
            }
        }
        assert!(
            (plant.voltage() - volts(state_of_charge)).abs() < 1e-4,
            "{} {state_of_charge}",
            plant.voltage()
        );
        assert!(state_of_charge > 0.5, "{state_of_charge}");
        let account = *plant.account();
        let balance = account.income - account.leaked - account.shunted - account.actions - account.standing;
        assert!((plant.energy() - start - balance).abs() < 1e-9);
        assert!((account.income - 0.8 * 0.99 * 180.0).abs() < 1e-7 && account.leaked > 0.0, "{account:?}");
    }

    #[test]
    fn a_full_storage_shunts_and_an_empty_one_waits_for_its_turn_on_voltage() {
        let sealed = Storage { leakage_ohm: f64::INFINITY, ..STORAGE };
        let income = Income::constant(1e-3);
        let mut storage = ChargedStorage::new(&sealed, 0.0, &income);
        storage.advance(0, 600).expect("nothing can fail");
        assert_eq!(storage.voltage(), 4.0);
        assert!((storage.account().shunted - (0.8 * 0.6 - 6e-4 - 3.5e-3)).abs() < 1e-9);
        // 2.9 mJ at the node are 5.8 mJ of the 8, and the lock-out is at 2.
        storage.spend(2.9e-3);
        assert!(storage.is_supplied());
        storage.spend(1e-3);
        assert!(!storage.is_supplied() && storage.account().lockouts == 1);
        let weak = Income::constant(1e-5);
        let mut storage = ChargedStorage { income: &weak, ..storage };
        while !storage.is_supplied() {
            storage.advance(0, 1).expect("nothing can fail");
        }
        // From 0.2 mJ to 3.125 mJ at 8 µW.
        assert!((storage.voltage() - 2.5).abs() < 1e-2);
        assert!((f64::from(storage.account().lockout_s) - 365.625).abs() < 1.5);
        assert!(!storage.was_supplied());
    }
}
