//! Stick: everything is in closed form, and only the release is searched for.
//!
//! A frozen charge stays as it is, and the load is open: its voltage counts as 0. The voltage of a relaxing
//! charge falls as `exp(−t/τ)` with `τ = R C(x)`, or as a bridge and its storage have it. The surface forces
//! fall with it.

use std::convert::Infallible;

use super::bridge::Switch;
use super::harvester::{CircuitKind, Harvester};
use super::motion::Motion;
use super::storage_in_stick::StorageInStick;
use crate::ledger::{Integrals, integral};
use harvester_scene::base_motion::LocalBase;
use harvester_scene::root::{far_side, lowest_point};
use harvester_scene::scene_file::StickCharge;

/// Time constants after which a charge has relaxed.
const RELAXED: f64 = 40.0;

/// A stick from local time zero on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stick<'a, H> {
    pub(crate) harvester: &'a H,
    pub(crate) base: &'a LocalBase,
    /// The motion at local time zero, without velocity.
    pub(crate) start: Motion,
}

impl<H: Harvester> Stick<'_, H> {
    /// The bridge and its storage, if there is a bridge.
    fn storage(&self) -> Option<StorageInStick<'_>> {
        let load = self.harvester.load();
        Some(StorageInStick {
            storage: load.storage.as_ref()?,
            start: self.start.bridge,
            terminal: self.start.voltage,
            stick_charge: load.stick_charge,
            capacitance: self.harvester.port(&self.start).capacitance,
        })
    }

    /// The first switch of bridge or draw within `span` seconds.
    pub(crate) fn switch(&self, span: f64) -> Option<(f64, Switch)> {
        self.storage()?.switch(span)
    }

    /// The time constant in s with which the voltage relaxes through a resistor, if it does.
    fn time_constant(&self) -> Option<f64> {
        let load = self.harvester.load();
        let relaxes = load.stick_charge == StickCharge::Relaxing
            && load.storage.is_none()
            && load.kind == CircuitKind::Dynamic;
        relaxes.then(|| self.harvester.time_constant(&self.start))
    }

    /// The motion at local time `t` in s.
    pub(crate) fn motion(&self, t: f64) -> Motion {
        if let Some(storage) = self.storage() {
            return Motion { voltage: storage.terminal(t), bridge: storage.bridge(t), ..self.start };
        }
        let decay = self.time_constant().map_or(1.0, |tau| (-t / tau).exp());
        Motion { voltage: self.start.voltage * decay, ..self.start }
    }

    /// Load voltage in V at local time `t` in s.
    pub(crate) fn load_voltage(&self, t: f64) -> f64 {
        match self.harvester.load().stick_charge {
            StickCharge::Frozen => 0.0,
            StickCharge::Relaxing => self.harvester.voltage(&self.motion(t)),
        }
    }

    /// Integrals over the first `elapsed` seconds.
    pub(crate) fn integrals(&self, elapsed: f64) -> Integrals {
        if let Some(storage) = self.storage() {
            return storage.integrals(elapsed);
        }
        let start = self.load_voltage(0.0);
        let (once, twice) = match self.time_constant() {
            // ∫ exp(−t/τ) and ∫ exp(−2t/τ), without cancellation for short times.
            Some(tau) => (-tau * (-elapsed / tau).exp_m1(), -0.5 * tau * (-2.0 * elapsed / tau).exp_m1()),
            None => (elapsed, elapsed),
        };
        let mut integrals = Integrals::default();
        integrals[integral::VOLTAGE_SQUARED] = start * start * twice;
        integrals[integral::VOLTAGE] = start * once;
        integrals
    }

    /// Local time of the release, if it is within `span` seconds.
    pub(crate) fn release(&self, span: f64) -> Option<f64> {
        let reserve = |t: f64| self.harvester.reserve(&self.motion(t), self.base.at(t));
        let crossing = |from: f64, to: f64| {
            let Ok(at) = far_side(|t| Ok::<_, Infallible>(-reserve(t)), from, to);
            Some(at)
        };
        let (mut before, mut left) = (None, 0.0);
        let mut from = reserve(left);
        if from < 0.0 {
            return Some(0.0);
        }
        while left < span {
            let right = self.instant_after(left, span);
            let to = reserve(right);
            if to < 0.0 {
                return crossing(left, right);
            }
            // A dip between three samples may reach below zero unseen.
            if let Some((begin, before)) = before
                && from < before
                && from < to
            {
                let Ok(dip) = lowest_point(|t| Ok::<_, Infallible>(reserve(t)), [begin, right], 1e-9);
                if reserve(dip) < 0.0 {
                    return crossing(begin, dip);
                }
            }
            before = Some((left, from));
            (left, from) = (right, to);
        }
        None
    }

    /// The next local time at which the reserve is sampled: the interval holds at most one dip.
    fn instant_after(&self, t: f64, span: f64) -> f64 {
        let frequency = self.base.highest_frequency();
        let mut spacing = if frequency > 0.0 { 1.0 / (64.0 * frequency) } else { span / 16.0 };
        if let Some(tau) = self.time_constant()
            && t < RELAXED * tau
        {
            spacing = spacing.min(tau / 8.0);
        }
        let next = t + spacing;
        // A spacing lost in the rounding of the time ends the search.
        if next >= span || next <= t { span } else { next }
    }
}
