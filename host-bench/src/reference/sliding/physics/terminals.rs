//! The sliding harvester at the terminals of a bridge: `C = c s1` and `j = −(ds1/dx) v (σS + c V)`.

use super::{Motion, Physics};
use crate::reference::bridge::{Bridge, Harvester, Terminals};
use crate::reference::store::Store;
use crate::scene_file::StickCharge;

impl Harvester for Physics {
    type Motion = Motion;

    fn store(&self) -> Option<&Store> {
        self.store.as_ref()
    }

    fn stick_charge(&self) -> StickCharge {
        self.stick_charge
    }

    fn terminals(&self, motion: &Motion) -> Terminals {
        let overlap = self.overlap(motion);
        Terminals {
            voltage: motion.voltage,
            driven: -overlap.slope * motion.velocity * self.tribo_charge_and(motion.voltage),
            capacitance: self.capacitance * overlap.active,
        }
    }

    fn electrical(motion: &mut Motion) -> (&mut f64, &mut Bridge) {
        (&mut motion.voltage, &mut motion.bridge)
    }
}

impl Physics {
    /// Rate in V/s of the gain of the store.
    pub(in super::super) fn gain_rate(&self, motion: &Motion) -> f64 {
        self.store.map_or(0.0, |store| store.gain_rate(&self.terminals(motion), &motion.bridge))
    }

    /// Derivative of [`Self::gain_rate`] in the direction of `change`.
    pub(in super::super) fn gain_rate_along(&self, motion: &Motion, change: &Motion) -> f64 {
        let Some(store) = &self.store else { return 0.0 };
        let (overlap, c) = (self.overlap(motion), self.capacitance);
        let total = self.tribo_charge_and(motion.voltage);
        let driven = -(overlap.curvature * change.displacement * motion.velocity * total
            + overlap.slope * change.velocity * total
            + overlap.slope * motion.velocity * c * change.voltage);
        let capacitance = c * overlap.slope * change.displacement;
        let changes = [driven, capacitance, change.bridge.gain];
        store.gain_rate_along(&self.terminals(motion), &motion.bridge, changes)
    }

    /// Powers in W behind a bridge: into the store, into the diodes, leaked, drawn.
    pub(in super::super) fn store_powers(&self, motion: &Motion) -> [f64; 4] {
        self.store.map_or([0.0; 4], |store| store.powers(&self.terminals(motion), &motion.bridge))
    }
}
