//! The slider held by friction: everything is in closed form, only the release is searched for.
//!
//! With frozen charge nothing changes, and the load is open: it sees no voltage. With relaxing charge
//! the voltage falls as `exp(−t/τ)`, `τ = R C(x)`, or as a bridge and its store have it, and the normal force goes
//! with it.

use std::convert::Infallible;

use super::physics::{Circuit, Motion, Physics};
use crate::reference::base::LocalBase;
use crate::reference::bridge::{Harvester, Rest, Switch};
use crate::reference::integrals::Integrals;
use crate::reference::root::{far_side, lowest_point};
use crate::scene_file::StickCharge;

/// Time constants after which a charge has relaxed.
const RELAXED: f64 = 40.0;

/// A slider held from local time zero on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stick<'a> {
    pub(super) physics: &'a Physics,
    pub(super) base: &'a LocalBase,
    /// The motion at local time zero, without velocity.
    pub(super) start: Motion,
}

impl Stick<'_> {
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
        .then(|| self.physics.time_constant(&self.start))
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

    /// Static friction in N that is left before the slider gives way, at local time `t` in s.
    fn reserve(&self, t: f64) -> f64 {
        let motion = self.motion(t);
        let needed = self.physics.holding_friction(&motion, self.base.at(t));
        self.physics.most_static_friction(&motion) - needed.abs()
    }

    /// Local time at which the friction gives way, if that is within `span` seconds.
    pub(super) fn release(&self, span: f64) -> Option<f64> {
        let crossing = |from: f64, to: f64| {
            let Ok(at) = far_side(|t| Ok::<_, Infallible>(-self.reserve(t)), from, to);
            at
        };
        let (mut last, mut left) = (None, 0.0);
        let mut from = self.reserve(left);
        if from < 0.0 {
            return Some(0.0);
        }
        while left < span {
            let right = self.instant_after(left, span);
            let to = self.reserve(right);
            if to < 0.0 {
                return Some(crossing(left, right));
            }
            // A dip between three samples may reach below zero unseen.
            if let Some((begin, before)) = last
                && from < before
                && from < to
            {
                let dip = lowest_point(|t| self.reserve(t), begin, right);
                if self.reserve(dip) < 0.0 {
                    return Some(crossing(begin, dip));
                }
            }
            last = Some((left, from));
            (left, from) = (right, to);
        }
        None
    }

    /// The next instant at which the reserve is looked at: near enough that one interval holds one dip
    /// at most.
    fn instant_after(&self, t: f64, span: f64) -> f64 {
        let frequency = self.base.highest_frequency();
        let mut spacing = if frequency > 0.0 { 1.0 / (64.0 * frequency) } else { span / 16.0 };
        if let Some(tau) = self.time_constant()
            && t < RELAXED * tau
        {
            spacing = spacing.min(tau / 8.0);
        }
        let next = t + spacing;
        // What does not move the time any more must not hold it up.
        if next >= span || next <= t { span } else { next }
    }
}
