//! A store while the harvester is held: nothing drives a current, only what leaves the store goes on.
//!
//! `V_s' = −k V_s − e i` with a constant current, and `(V_s²)' = −2k V_s² − 2 e P` with a constant power, have
//! closed forms (`e` one over the capacitance, `k` the rate of what is a resistance); their integrals are taken
//! by Gauss's rule in parts of a time constant.

use std::convert::Infallible;

use super::{Bridge, Store, Switch};
use crate::reference::integrals::Integrals;
use crate::reference::root::far_side;
use crate::scene_file::{Draw, StickCharge};

/// Time constants after which a voltage is gone.
const GONE: f64 = 40.0;

/// Parts of a time constant in which the integrals are taken.
const PARTS: f64 = 8.0;

/// Places and weights of Gauss's rule of five on [−1, 1]: the middle, and two that count twice.
const MIDDLE: f64 = 128.0 / 225.0;
const PAIRS: [[f64; 2]; 2] =
    [[0.538_469_310_105_683_1, 0.478_628_670_499_366_47], [0.906_179_845_938_664, 0.236_926_885_056_189_08]];

/// A bridge and its store from a local time zero on, at which a harvester is held.
#[derive(Debug, Clone, Copy)]
pub(in crate::reference) struct Rest<'a> {
    store: &'a Store,
    start: Bridge,
    /// Terminal voltage in V at local time zero.
    terminal: f64,
    /// What the terminals see.
    stick_charge: StickCharge,
    /// Capacitance in F of the harvester.
    capacitance: f64,
}

/// `(1 − exp(−k t))/k`.
fn decayed(rate: f64, t: f64) -> f64 {
    if rate == 0.0 { t } else { -(-rate * t).exp_m1() / rate }
}

impl<'a> Rest<'a> {
    /// While the charge is frozen the terminals are open: `start` blocks.
    pub(in crate::reference) fn new(
        store: &'a Store,
        start: Bridge,
        terminal: f64,
        capacitance: f64,
        stick_charge: StickCharge,
    ) -> Self {
        Self { store, start, terminal, stick_charge, capacitance }
    }

    /// One over what is discharged in 1/F: the store, and while the bridge conducts the harvester with it.
    fn elastance(&self) -> f64 {
        let own = self.store.elastance();
        if self.start.sign == 0.0 { own } else { own / (1.0 + self.capacitance * own) }
    }

    /// Conductance in S, constant current in A and constant power in W of what leaves the store.
    fn leaving(&self) -> [f64; 3] {
        let leakage = self.store.leakage;
        match self.store.draw {
            Draw::Resistor { resistance_ohm, .. } if self.start.connected => {
                [leakage + resistance_ohm.recip(), 0.0, 0.0]
            }
            Draw::Current { current_a, .. } if self.start.connected => [leakage, current_a, 0.0],
            Draw::Power { power_w, .. } if self.start.connected => [leakage, 0.0, power_w],
            _ => [leakage, 0.0, 0.0],
        }
    }

    /// The bridge and its store at local time `t` in s.
    pub(in crate::reference) fn bridge(&self, t: f64) -> Bridge {
        let ([conductance, current, power], elastance) = (self.leaving(), self.elastance());
        let (before, rate) = (self.store.voltage(&self.start), conductance * elastance);
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

    /// Terminal voltage in V at local time `t` in s, behind which the charge is.
    pub(in crate::reference) fn terminal(&self, t: f64) -> f64 {
        if self.start.sign == 0.0 {
            return self.terminal;
        }
        self.start.sign * self.store.threshold(&self.bridge(t))
    }

    /// What the load sees of it: nothing while the charge is frozen.
    pub(in crate::reference) fn load_voltage(&self, t: f64) -> f64 {
        match self.stick_charge {
            StickCharge::Frozen => 0.0,
            StickCharge::Relaxing => self.terminal(t),
        }
    }

    /// The integrands at local time `t`; there is no motion.
    fn rates(&self, t: f64) -> Integrals {
        let bridge = self.bridge(t);
        let voltage = self.store.voltage(&bridge);
        let [drawn, _] = self.store.drawn(voltage, bridge.connected);
        let out = drawn + self.store.leakage * voltage;
        // Of what leaves the store the harvester gives its part.
        let ratio = self.capacitance * self.store.elastance();
        let through = if bridge.sign == 0.0 { 0.0 } else { out * ratio / (1.0 + ratio) };
        let seen = self.load_voltage(t);
        Integrals {
            voltage_squared: seen * seen,
            voltage: seen,
            into_store: voltage * through,
            diode_loss: self.store.drop * through,
            leaked: self.store.leakage * voltage * voltage,
            drawn: voltage * drawn,
            ..Integrals::default()
        }
    }

    /// Integrals over the first `elapsed` seconds.
    pub(in crate::reference) fn integrals(&self, elapsed: f64) -> Integrals {
        let mut sum = Integrals::default();
        let ([conductance, current, power], elastance) = (self.leaving(), self.elastance());
        let lowest = self.store.voltage(&self.bridge(elapsed));
        let of_power = if power > 0.0 { power / (lowest * lowest) } else { 0.0 };
        let rate = elastance * (conductance + of_power);
        // Of a voltage that decays to nothing, the end adds nothing but what the terminals see.
        let busy =
            if current == 0.0 && power == 0.0 && rate > 0.0 { elapsed.min(GONE / rate) } else { elapsed };
        let parts = (PARTS * rate * busy).ceil().max(1.0);
        let half = 0.5 * busy / parts;
        for part in 0..parts as u64 {
            let middle = (2 * part + 1) as f64 * half;
            sum.add_scaled(half * MIDDLE, &self.rates(middle));
            for [place, weight] in PAIRS {
                sum.add_scaled(half * weight, &self.rates(middle - place * half));
                sum.add_scaled(half * weight, &self.rates(middle + place * half));
            }
        }
        sum.add_scaled(elapsed - busy, &self.rates(elapsed));
        sum
    }

    /// The first switch within `span` seconds; the voltage of the store only falls.
    pub(in crate::reference) fn switch(&self, span: f64) -> Option<(f64, Switch)> {
        let crossing = |lowest: f64| {
            let above = |t: f64| self.store.voltage(&self.bridge(t)) - lowest;
            if above(span) > 0.0 {
                return None;
            }
            let Ok(at) = far_side(|t| Ok::<_, Infallible>(above(t)), 0.0, span);
            Some(at)
        };
        let off = (self.store.lockout().filter(|_| self.start.connected))
            .and_then(|lockout| crossing(lockout.turn_off_v))
            .map(|at| (at, Switch::Draw { connected: false }));
        let waits = self.stick_charge == StickCharge::Relaxing && self.start.sign == 0.0;
        let on = (waits && self.elastance() > 0.0 && self.leaving() != [0.0; 3])
            .then(|| crossing(self.terminal.abs() - self.store.drop))
            .flatten()
            .map(|at| (at, Switch::Conducts { sign: self.terminal.signum() }));
        match (off, on) {
            (Some(off), Some(on)) if on.0 < off.0 => Some(on),
            (off, on) => off.or(on),
        }
    }
}
