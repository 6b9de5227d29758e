//! The mass held on the dielectric: everything is in closed form, only the release is searched for.
//!
//! With frozen charge nothing changes, and the load is open: it sees no voltage. With relaxing charge
//! the voltage falls as `exp(−t/τ)`, `τ = R (C(0) + C_p)`, or as a bridge and its store have it.

use std::convert::Infallible;

use super::physics::{Circuit, Motion, Physics};
use crate::reference::base::LocalBase;
use crate::reference::bridge::{Harvester, Rest, Switch};
use crate::reference::integrals::Integrals;
use crate::reference::root::{far_side, lowest_point};
use crate::scene_file::StickCharge;

/// A mass held from local time zero on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold<'a> {
    pub(super) physics: &'a Physics,
    pub(super) base: &'a LocalBase,
    /// The motion at local time zero, gap and velocity zero.
    pub(super) start: Motion,
}

impl Hold<'_> {
    /// A bridge and its store.
    fn rest(&self) -> Option<Rest<'_>> {
        let Motion { voltage, bridge, .. } = self.start;
        let capacitance = self.physics.terminals(&self.start).capacitance;
        let store = self.physics.store.as_ref()?;
        Some(Rest::new(store, bridge, voltage, capacitance, self.physics.stick_charge))
    }

    /// The first switch behind the terminals within `span` seconds.
    pub(super) fn switch(&self, span: f64) -> Option<(f64, Switch)> {
        self.rest()?.switch(span)
    }

    /// Whether the voltage relaxes through a resistor; if not it stays as it is.
    fn time_constant(&self) -> Option<f64> {
        (self.physics.stick_charge == StickCharge::Relaxing
            && self.physics.circuit == Circuit::Dynamic
            && self.physics.store.is_none())
        .then(|| self.physics.closed_time_constant())
    }

    /// The motion at local time `t` in s.
    pub(super) fn motion(&self, t: f64) -> Motion {
        if let Some(rest) = self.rest() {
            return Motion { voltage: rest.terminal(t), bridge: rest.bridge(t), ..self.start };
        }
        let voltage = match self.time_constant() {
            Some(tau) => self.start.voltage * (-t / tau).exp(),
            None => self.start.voltage,
        };
        Motion { voltage, ..self.start }
    }

    /// The voltage at the terminals of the load in V at local time `t` in s.
    pub(super) fn load_voltage(&self, t: f64) -> f64 {
        match self.physics.stick_charge {
            StickCharge::Frozen => 0.0,
            StickCharge::Relaxing => self.physics.voltage(&self.motion(t)),
        }
    }

    /// Integrals over the first `elapsed` seconds.
    pub(super) fn integrals(&self, elapsed: f64) -> Integrals {
        if let Some(rest) = self.rest() {
            return rest.integrals(elapsed);
        }
        let start = self.load_voltage(0.0);
        let (once, twice) = match self.time_constant() {
            // ∫ exp(−t/τ) and ∫ exp(−2t/τ), without cancellation for short times.
            Some(tau) => (-tau * (-elapsed / tau).exp_m1(), -0.5 * tau * (-2.0 * elapsed / tau).exp_m1()),
            None => (elapsed, elapsed),
        };
        Integrals { voltage_squared: start * start * twice, voltage: start * once, ..Integrals::default() }
    }

    /// Local time at which the contact force falls through zero, if that is within `span` seconds.
    pub(super) fn release(&self, span: f64) -> Option<f64> {
        let force = |t: f64| self.physics.contact_force(&self.motion(t), self.base.at(t));
        // Fine enough that one interval holds one dip at most.
        let frequency = self.base.highest_frequency();
        let spacing = if frequency > 0.0 { 1.0 / (64.0 * frequency) } else { span / 16.0 };
        let crossing = |from: f64, to: f64| {
            let Ok(at) = far_side(|t| Ok::<_, Infallible>(force(t)), from, to);
            at
        };
        if force(0.0) <= 0.0 {
            return Some(0.0);
        }
        let count = (span / spacing).ceil();
        let instant = |index: f64| if index >= count { span } else { index * spacing };
        let (mut before, mut from) = (f64::INFINITY, force(0.0));
        let mut index = 0.0;
        while index < count {
            let (left, right) = (instant(index), instant(index + 1.0));
            let to = force(right);
            if to <= 0.0 {
                return Some(crossing(left, right));
            }
            // A dip between three samples may reach zero unseen.
            if from < before && from < to && index > 0.0 {
                let dip = lowest_point(force, instant(index - 1.0), right);
                if force(dip) <= 0.0 {
                    return Some(crossing(instant(index - 1.0), dip));
                }
            }
            (before, from) = (from, to);
            index += 1.0;
        }
        None
    }
}
