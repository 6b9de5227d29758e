//! What a bridge asks of a harvester, and what it does to its motion.

use super::{Bridge, Store, Switch, Terminals};
use crate::reference::integrals::Integrals;
use crate::scene_file::StickCharge;

/// A harvester whose motion carries a terminal voltage and the state of a bridge.
pub(in crate::reference) trait Harvester {
    /// Its motion.
    type Motion;

    /// What stands behind a bridge, if there is one.
    fn store(&self) -> Option<&Store>;

    /// What the charge does while the motion is held.
    fn stick_charge(&self) -> StickCharge;

    /// The harvester as a bridge sees it.
    fn terminals(&self, motion: &Self::Motion) -> Terminals;

    /// Terminal voltage in V, and the bridge.
    fn electrical(motion: &mut Self::Motion) -> (&mut f64, &mut Bridge);

    /// Lets a bridge find its regime after the motion has changed at once; the energies of that.
    fn settle(&self, motion: &mut Self::Motion) -> Integrals {
        let Some(store) = self.store() else { return Integrals::default() };
        let terminals = self.terminals(motion);
        let (voltage, bridge) = Self::electrical(motion);
        let (settled, shared) = store.settle(terminals, bridge, 0.0);
        *voltage = settled;
        shared
    }

    /// The same where the motion has come to rest: while the charge is frozen the terminals are open.
    fn come_to_rest(&self, motion: &mut Self::Motion) -> Integrals {
        match self.stick_charge() {
            StickCharge::Frozen => {
                let (_, bridge) = Self::electrical(motion);
                bridge.sign = 0.0;
                Integrals::default()
            }
            StickCharge::Relaxing => self.settle(motion),
        }
    }

    /// Switches the bridge or the draw behind it; the energies of that.
    fn switch(&self, switch: Switch, motion: &mut Self::Motion) -> Integrals {
        let Some(store) = self.store() else { return Integrals::default() };
        let terminals = self.terminals(motion);
        let (voltage, bridge) = Self::electrical(motion);
        let (switched, shared) = store.switch(switch, terminals, bridge);
        *voltage = switched;
        shared
    }

    /// The same at rest: behind open terminals there is the draw only.
    fn switch_at_rest(&self, switch: Switch, motion: &mut Self::Motion) -> Integrals {
        match (self.stick_charge(), switch) {
            (StickCharge::Frozen, Switch::Draw { connected }) => {
                let (_, bridge) = Self::electrical(motion);
                bridge.connected = connected;
                Integrals::default()
            }
            _ => self.switch(switch, motion),
        }
    }
}
