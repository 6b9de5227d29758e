//! The energy of a storage under a given income, in double precision.
//!
//! Over each second the powers in and out are constant and the leakage resistance takes `2 E / (R C)`:
//!
//! ```text
//! E' = P − 2 E / (R C)
//! ```
//!
//! is solved exactly. Thresholds are checked every second.

use super::{Plant, StorageAccount, energy_at, standing_power};
use crate::budget::income::Income;
use crate::method::Failure;
use crate::scene_file::Storage;

/// A storage charged by a given income, and whether the node at it is switched on.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::budget) struct ChargedStorage<'a> {
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
    pub(in crate::budget) fn new(storage: &Storage, standing_power_w: f64, income: &'a Income) -> Self {
        Self {
            storage: *storage,
            income,
            standing_w: standing_power(storage, standing_power_w),
            energy: 0.5 * storage.capacitance_f * storage.initial_v.powi(2),
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

    fn spend(&mut self, energy: f64) {
        let drawn = energy / self.storage.discharging_efficiency;
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
            // The leakage of the energy at the start, and of the constant power in, each in closed form.
            account.leaked += -(-rate).exp_m1() * self.energy + (1.0 - mean_kept) * (stored - standing);
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
