//! Stick: everything is in closed form, and only the release is searched for.
//!
//! A frozen charge stays as it is, and the load is open: its voltage counts as 0. The voltage of a relaxing charge falls as `exp(−t/τ)`
//! with `τ = R C(x)`, or as a bridge and its storage have it. The surface forces fall with it.

use std::convert::Infallible;

use super::bridge::{Bridge, Switch};
use super::harvester::{CircuitKind, Harvester, Motion};
use crate::ledger::{Integrals, add, integral};
use crate::storage::Storage;
use harvester_scene::base_motion::LocalBase;
use harvester_scene::root::{far_side, lowest_point};
use harvester_scene::scene_file::{Draw, StickCharge};

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
        let crossing = |from: f64, to: f64| Some(far_side(|t| -reserve(t), from, to));
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

// A storage in stick: the motion drives no current, and only the leakage and the draw go on.
//
// `V_s' = −k V_s − e i` at a constant current `i`, and `(V_s²)' = −2k V_s² − 2 e P` at a constant power `P`,
// have closed forms; `e` is one over the capacitance, `k` the rate of the resistances. Their integrals are
// taken by Gauss's rule of five points on parts of a time constant.

/// Time constants after which a voltage has decayed below rounding.
const DECAYED: f64 = 40.0;

/// Parts of a time constant in which the integrals are taken.
const PARTS: f64 = 8.0;

/// Places and weights of Gauss's rule on [−1, 1]: the middle, and two pairs.
const MIDDLE: f64 = 128.0 / 225.0;
const PAIRS: [[f64; 2]; 2] =
    [[0.538_469_310_105_683_1, 0.478_628_670_499_366_47], [0.906_179_845_938_664, 0.236_926_885_056_189_08]];

/// A bridge and its storage from local time zero on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StorageInStick<'a> {
    pub(crate) storage: &'a Storage,
    /// The bridge at local time zero; it blocks if the charge is frozen, because the terminals are open.
    pub(crate) start: Bridge,
    /// Terminal voltage in V at local time zero.
    pub(crate) terminal: f64,
    pub(crate) stick_charge: StickCharge,
    /// Capacitance in F of the harvester.
    pub(crate) capacitance: f64,
}

/// `(1 − exp(−k t))/k`.
fn decayed(rate: f64, t: f64) -> f64 {
    if rate == 0.0 { t } else { -(-rate * t).exp_m1() / rate }
}

impl StorageInStick<'_> {
    /// One over the discharged capacitance in 1/F: the storage, and with it the harvester while the bridge conducts.
    fn elastance(&self) -> f64 {
        let own = self.storage.elastance();
        if self.start.sign == 0.0 { own } else { own / (1.0 + self.capacitance * own) }
    }

    /// Outflow of the storage as a conductance in S, a constant current in A and a constant power in W.
    fn outflow(&self) -> [f64; 3] {
        let leakage = self.storage.leakage;
        match self.storage.draw {
            Draw::Resistor { resistance_ohm, .. } if self.start.connected => {
                [leakage + resistance_ohm.recip(), 0.0, 0.0]
            }
            Draw::Current { current_a, .. } if self.start.connected => [leakage, current_a, 0.0],
            Draw::Power { power_w, .. } if self.start.connected => [leakage, 0.0, power_w],
            _ => [leakage, 0.0, 0.0],
        }
    }

    /// The bridge and its storage at local time `t` in s.
    pub(crate) fn bridge(&self, t: f64) -> Bridge {
        let ([conductance, current, power], elastance) = (self.outflow(), self.elastance());
        let (before, rate) = (self.storage.voltage(&self.start), conductance * elastance);
        let change = if power > 0.0 {
            let squares = (before * before) * (-2.0 * rate * t).exp_m1()
                - 2.0 * elastance * power * decayed(2.0 * rate, t);
            let after = (before * before + squares).max(0.0).sqrt();
            squares / (before + after)
        } else {
            before * (-rate * t).exp_m1() - elastance * current * decayed(rate, t)
        };
        Bridge { gain: self.start.gain + change, ..self.start }
    }

    /// Voltage in V of the harvester at local time `t` in s.
    pub(crate) fn terminal(&self, t: f64) -> f64 {
        if self.start.sign == 0.0 {
            return self.terminal;
        }
        self.start.sign * self.storage.threshold(&self.bridge(t))
    }

    /// Load voltage in V at local time `t` in s: 0 while the charge is frozen.
    fn load_voltage(&self, t: f64) -> f64 {
        match self.stick_charge {
            StickCharge::Frozen => 0.0,
            StickCharge::Relaxing => self.terminal(t),
        }
    }

    /// The integrands at local time `t`; there is no motion.
    fn rates(&self, t: f64) -> Integrals {
        let bridge = self.bridge(t);
        let voltage = self.storage.voltage(&bridge);
        let [drawn, _] = self.storage.drawn(voltage, bridge.connected);
        let out = drawn + self.storage.leakage * voltage;
        // The harvester supplies its part of the outflow.
        let ratio = self.capacitance * self.storage.elastance();
        let through = if bridge.sign == 0.0 { 0.0 } else { out * ratio / (1.0 + ratio) };
        let seen = self.load_voltage(t);
        let (into, diodes) = (voltage * through, self.storage.drop * through);
        let leaked = self.storage.leakage * voltage * voltage;
        [seen * seen, seen, 0.0, 0.0, 0.0, 0.0, into, diodes, leaked, voltage * drawn]
    }

    /// Integrals over the first `elapsed` seconds.
    pub(crate) fn integrals(&self, elapsed: f64) -> Integrals {
        let mut sum = Integrals::default();
        let ([conductance, current, power], elastance) = (self.outflow(), self.elastance());
        let lowest = self.storage.voltage(&self.bridge(elapsed));
        let of_power = if power > 0.0 { power / (lowest * lowest) } else { 0.0 };
        let rate = elastance * (conductance + of_power);
        // After the decay only the terminal voltage is left, which is constant.
        let busy =
            if current == 0.0 && power == 0.0 && rate > 0.0 { elapsed.min(DECAYED / rate) } else { elapsed };
        let parts = (PARTS * rate * busy).ceil().max(1.0);
        let half = 0.5 * busy / parts;
        for part in 0..parts as u64 {
            let middle = (2 * part + 1) as f64 * half;
            add(&mut sum, half * MIDDLE, &self.rates(middle));
            for [place, weight] in PAIRS {
                add(&mut sum, half * weight, &self.rates(middle - place * half));
                add(&mut sum, half * weight, &self.rates(middle + place * half));
            }
        }
        add(&mut sum, elapsed - busy, &self.rates(elapsed));
        sum
    }

    /// The first switch within `span` seconds. The voltage of the storage only falls.
    pub(crate) fn switch(&self, span: f64) -> Option<(f64, Switch)> {
        let crossing = |lowest: f64| {
            let above = |t: f64| self.storage.voltage(&self.bridge(t)) - lowest;
            if above(span) > 0.0 {
                return None;
            }
            Some(far_side(above, 0.0, span))
        };
        let off = (self.storage.lockout().filter(|_| self.start.connected))
            .and_then(|lockout| crossing(lockout.turn_off_v))
            .map(|at| (at, Switch::Draw { connected: false }));
        let waits = self.stick_charge == StickCharge::Relaxing && self.start.sign == 0.0;
        let on = (waits && self.elastance() > 0.0 && self.outflow() != [0.0; 3])
            .then(|| crossing(self.terminal.abs() - self.storage.drop))
            .flatten()
            .map(|at| (at, Switch::Conducts { sign: self.terminal.signum() }));
        match (off, on) {
            (Some(off), Some(on)) if on.0 < off.0 => Some(on),
            (off, on) => off.or(on),
        }
    }
}
