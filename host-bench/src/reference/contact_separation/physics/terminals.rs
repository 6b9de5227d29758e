//! The contact-separation harvester at the terminals of a bridge: `C = c / (g + d_e) + C_p` and
//! `j = (σS − q) v / (g + d_e)`.

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
        let spacing = motion.gap + self.dielectric;
        Terminals {
            voltage: motion.voltage,
            driven: self.top_charge(motion.gap, motion.voltage) * motion.velocity / spacing,
            capacitance: self.total_capacitance_length(motion.gap) / spacing,
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
        let spacing = motion.gap + self.dielectric;
        let terminals = self.terminals(motion);
        let top = self.top_charge(motion.gap, motion.voltage);
        let top_change = (self.permittivity_area * change.voltage - top * change.gap) / spacing;
        let driven =
            (top_change * motion.velocity + top * change.velocity - terminals.driven * change.gap) / spacing;
        let capacitance = (self.parasitic - terminals.capacitance) * change.gap / spacing;
        store.gain_rate_along(&terminals, &motion.bridge, [driven, capacitance, change.bridge.gain])
    }

    /// Powers in W behind a bridge: into the store, into the diodes, leaked, drawn.
    pub(in super::super) fn store_powers(&self, motion: &Motion) -> [f64; 4] {
        self.store.map_or([0.0; 4], |store| store.powers(&self.terminals(motion), &motion.bridge))
    }
}
