//! The store of a node as it is, in double precision: apart from what the node's budget believes of it.
//!
//! From second to second the power is constant and the leakage resistance takes `2 E/(R C)`, so that the energy is
//! that of the exact solution; thresholds are looked at every second.

use super::income::Income;
use super::world::Plant;
use crate::method::Failure;
use crate::scene_file::Storage;

/// Energies since the account began, in J: at the harvester's load the first, at the store all others.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StoreAccount {
    /// Delivered by the harvester.
    pub harvested: f64,
    /// Of it, what the charging efficiency leaves.
    pub income: f64,
    /// Income above the highest voltage.
    pub shunted: f64,
    /// Leaked.
    pub leaked: f64,
    /// Taken by actions.
    pub actions: f64,
    /// Taken by the standing load.
    pub standing: f64,
    /// Lost in the diodes of a bridge, where it is simulated step by step.
    pub diodes: f64,
    /// Steps of the harvester, where it is simulated with the store.
    pub steps: u64,
    /// Seconds for which the node was switched off.
    pub lockout_s: u32,
    /// Times at which it was.
    pub lockouts: u32,
}

/// A store, and whether the node at it is switched on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Store<'a> {
    storage: Storage,
    income: &'a Income,
    /// What the standing load takes from the store, in W.
    standing_w: f64,
    energy: f64,
    supplied: bool,
    /// Whether it was so all through the last interval.
    was_supplied: bool,
    account: StoreAccount,
}

impl<'a> Store<'a> {
    /// At its initial voltage; `standing_power_w` is that of the node.
    pub(super) fn new(storage: &Storage, standing_power_w: f64, income: &'a Income) -> Self {
        Self {
            storage: *storage,
            income,
            standing_w: standing_power_w / storage.discharging_efficiency + storage.own_power_w,
            energy: 0.5 * storage.capacitance_f * storage.initial_v.powi(2),
            supplied: storage.initial_v >= storage.turn_on_v,
            was_supplied: false,
            account: StoreAccount::default(),
        }
    }

    fn energy_at(&self, voltage: f64) -> f64 {
        0.5 * self.storage.capacitance_f * voltage * voltage
    }

    fn capacity(&self) -> f64 {
        self.energy_at(self.storage.highest_v)
    }

    fn switch(&mut self) {
        if self.supplied && self.energy < self.energy_at(self.storage.turn_off_v) {
            self.supplied = false;
            self.account.lockouts += 1;
        } else if !self.supplied && self.energy >= self.energy_at(self.storage.turn_on_v) {
            self.supplied = true;
        }
    }
}

impl Plant for Store<'_> {
    fn voltage(&self) -> f64 {
        (2.0 * self.energy / self.storage.capacitance_f).sqrt()
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

    fn spend(&mut self, joules: f64) {
        let drawn = joules / self.storage.discharging_efficiency;
        self.account.actions += drawn;
        self.energy -= drawn;
        self.switch();
    }

    fn advance(&mut self, from: u32, seconds: u32) -> Result<f64, Failure> {
        let before = self.account.harvested;
        self.was_supplied = self.supplied;
        let rate = 2.0 / (self.storage.leakage_ohm * self.storage.capacitance_f);
        let mean_kept = if rate > 0.0 { -(-rate).exp_m1() / rate } else { 1.0 };
        for second in from..from + seconds {
            let harvested = self.income.power_w(second, self.voltage());
            let standing = if self.supplied { self.standing_w } else { 0.0 };
            let stored = harvested * self.storage.charging_efficiency;
            let end = self.energy * (-rate).exp() + (stored - standing) * mean_kept;
            let account = &mut self.account;
            account.harvested += harvested;
            account.income += stored;
            account.standing += standing;
            // What leaks of the start and of what comes in evenly, each in closed form.
            account.leaked += -(-rate).exp_m1() * self.energy + (1.0 - mean_kept) * (stored - standing);
            account.lockout_s += u32::from(!self.supplied);
            self.energy = end.min(self.capacity());
            self.account.shunted += end - self.energy;
            self.switch();
            self.was_supplied &= self.supplied;
        }
        Ok(self.account.harvested - before)
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

    const STORAGE: Storage = Storage {
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
    fn a_leaking_store_follows_its_exponential_and_its_account_closes() {
        let income = Income::constant(10e-6);
        let mut store = Store::new(&STORAGE, 2e-6, &income);
        let start = store.energy();
        for k in 0..5 {
            store.advance(100 * k, 100).expect("nothing can fail");
        }
        // 8 µW in, 2 µW through 0.5 and 1 µW out, time constant 500 s.
        let (net, rate): (f64, f64) = (8e-6 - 5e-6, 2.0 / (1e6 * 1e-3));
        let settled = net / rate;
        let expected = settled + (start - settled) * (-rate * 500.0).exp();
        assert!((store.energy() / expected - 1.0).abs() < 1e-12);
        let account = store.account();
        let balance = account.income - account.leaked - account.shunted - account.actions - account.standing;
        assert!((store.energy() - start - balance).abs() < 1e-15);
        assert!((account.harvested - 5e-3).abs() < 1e-12);
    }

    #[test]
    fn a_full_store_shunts_and_an_empty_one_waits_for_its_turn_on_voltage() {
        let sealed = Storage { leakage_ohm: f64::INFINITY, ..STORAGE };
        let income = Income::constant(1e-3);
        let mut store = Store::new(&sealed, 0.0, &income);
        store.advance(0, 600).expect("nothing can fail");
        assert_eq!(store.voltage(), 4.0);
        assert!((store.account().shunted - (0.8 * 0.6 - 6e-4 - 3.5e-3)).abs() < 1e-9);
        // 2.9 mJ at the node are 5.8 mJ of the 8, and the lock-out is at 2.
        store.spend(2.9e-3);
        assert!(store.is_supplied());
        store.spend(1e-3);
        assert!(!store.is_supplied() && store.account().lockouts == 1);
        let weak = Income::constant(1e-5);
        let mut store = Store { income: &weak, ..store };
        while !store.is_supplied() {
            store.advance(0, 1).expect("nothing can fail");
        }
        // From 0.2 mJ to 3.125 mJ at 8 µW.
        assert!((store.voltage() - 2.5).abs() < 1e-2);
        assert!((f64::from(store.account().lockout_s) - 365.625).abs() < 1.5);
        assert!(!store.was_supplied());
    }
}
