//! A full bridge at a harvester whose voltage is a state: the three regimes, what ends them, and a store at rest.
//!
//! At its terminals a harvester with a voltage `V`, linear in its charge, is a capacitance `C(x)` (what is parallel
//! to it included) and the current `j(x, v)` that the motion drives into a short circuit, so `C V' = j − I`. With
//! `C_s V_s' = |I| − i_out` behind the diodes, `V_D` over each of the two that conduct:
//!
//! ```text
//! blocked      I = 0,  V' = j/C                                  while |V| < V_s + 2 V_D
//! conducting   V = s (V_s + 2 V_D), so V' = s V_s' and
//!              I = (j + s (C/C_s) i_out) / (1 + C/C_s)           while s I > 0
//! ```
//!
//! The voltages are continuous, except that a bridge which finds more than its threshold (the terminals were open
//! before) shares the charge at once. A bus is a store with `1/C_s = 0`. The store's voltage is kept as its gain
//! since the start, so that what one cycle brings to a large store is not lost in rounding.

mod harvester;
mod rest;

use diffsol::error::DiffsolError;

pub(super) use self::harvester::Harvester;
pub(super) use self::rest::Rest;
use super::integrals::Integrals;
use super::root::far_side;
use super::store::Store;
use crate::scene_file::Draw;

/// State of a bridge and what is behind it; not used without one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Bridge {
    /// What the store has gained since the start, in V.
    pub(super) gain: f64,
    /// Sign of the terminal voltage while the bridge conducts; 0 while it blocks.
    pub(super) sign: f64,
    /// Whether the draw is connected.
    pub(super) connected: bool,
}

/// A harvester as its terminals show it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Terminals {
    /// Voltage in V.
    pub(super) voltage: f64,
    /// Current in A that the motion drives into a short circuit.
    pub(super) driven: f64,
    /// Capacitance in F.
    pub(super) capacitance: f64,
}

/// What ends a regime.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Switch {
    /// The bridge begins to conduct, the voltage of this sign.
    Conducts { sign: f64 },
    /// It begins to block.
    Blocks,
    /// The draw is connected or disconnected.
    Draw { connected: bool },
}

/// Part of the threshold, or of the voltages that there are, within which a voltage is not told from the
/// threshold: above the noise of the integrator.
const MARGIN: f64 = 1e-11;

impl Store {
    /// Before the first instant.
    pub(super) fn start(&self) -> Bridge {
        Bridge { gain: 0.0, sign: 0.0, connected: self.starts_connected() }
    }

    /// Voltage of the store in V.
    pub(super) fn voltage(&self, bridge: &Bridge) -> f64 {
        self.initial + bridge.gain
    }

    /// What the store has gained since the start, in J; a bus has no end.
    pub(super) fn gained(&self, bridge: &Bridge) -> f64 {
        if self.capacitance.is_infinite() {
            return 0.0;
        }
        self.capacitance * bridge.gain * (self.initial + 0.5 * bridge.gain)
    }

    /// Magnitude in V of the terminal voltage from which the bridge conducts.
    pub(super) fn threshold(&self, bridge: &Bridge) -> f64 {
        self.voltage(bridge) + self.drop
    }

    /// Difference in V that is not told from none.
    fn margin(&self, bridge: &Bridge) -> f64 {
        MARGIN * self.threshold(bridge).max(self.scale)
    }

    /// Current in A that the node draws at a voltage in V, and its derivative by the voltage.
    fn drawn(&self, voltage: f64, connected: bool) -> [f64; 2] {
        match self.draw {
            Draw::Resistor { resistance_ohm, .. } if connected => {
                [voltage / resistance_ohm, resistance_ohm.recip()]
            }
            Draw::Current { current_a, .. } if connected => [current_a, 0.0],
            Draw::Power { power_w, .. } if connected => [power_w / voltage, -power_w / (voltage * voltage)],
            _ => [0.0; 2],
        }
    }

    /// Current in A that leaves the store, and its derivative by the voltage.
    fn outflow(&self, bridge: &Bridge) -> [f64; 2] {
        let voltage = self.voltage(bridge);
        let [current, slope] = self.drawn(voltage, bridge.connected);
        [current + self.leakage * voltage, slope + self.leakage]
    }

    /// Current in A out of the harvester, positive where its voltage is.
    pub(super) fn current(&self, terminals: &Terminals, bridge: &Bridge) -> f64 {
        if bridge.sign == 0.0 {
            return 0.0;
        }
        let ratio = terminals.capacitance * self.elastance();
        let [out, _] = self.outflow(bridge);
        (terminals.driven + bridge.sign * ratio * out) / (1.0 + ratio)
    }

    /// Its derivative for changes of `j`, `C` and the gain.
    fn current_along(
        &self,
        terminals: &Terminals,
        bridge: &Bridge,
        [driven, capacitance, gain]: [f64; 3],
    ) -> f64 {
        if bridge.sign == 0.0 {
            return 0.0;
        }
        let elastance = self.elastance();
        let ratio = terminals.capacitance * elastance;
        let [out, slope] = self.outflow(bridge);
        let shared = capacitance * elastance * (bridge.sign * out - self.current(terminals, bridge));
        (driven + shared + bridge.sign * ratio * slope * gain) / (1.0 + ratio)
    }

    /// Rate of the gain in V/s.
    pub(super) fn gain_rate(&self, terminals: &Terminals, bridge: &Bridge) -> f64 {
        let [out, _] = self.outflow(bridge);
        self.elastance() * (bridge.sign * self.current(terminals, bridge) - out)
    }

    /// Its derivative for changes of `j`, `C` and the gain.
    pub(super) fn gain_rate_along(&self, terminals: &Terminals, bridge: &Bridge, changes: [f64; 3]) -> f64 {
        let [_, slope] = self.outflow(bridge);
        let current = self.current_along(terminals, bridge, changes);
        self.elastance() * (bridge.sign * current - slope * changes[2])
    }

    /// Powers in W: into the store, into the diodes, leaked, drawn.
    pub(super) fn powers(&self, terminals: &Terminals, bridge: &Bridge) -> [f64; 4] {
        let voltage = self.voltage(bridge);
        let current = bridge.sign * self.current(terminals, bridge);
        let [drawn, _] = self.drawn(voltage, bridge.connected);
        [voltage * current, self.drop * current, self.leakage * voltage * voltage, drawn * voltage]
    }

    /// A voltage in V of the size that the terminals see, for tolerances: `driven` in V with the terminals open, with
    /// a charge in C that passes in one stroke.
    pub(super) fn voltage_scale(&self, driven: f64, charge: f64) -> f64 {
        let threshold = self.initial + self.drop + 10.0 * charge * self.elastance();
        if threshold > 0.0 { driven.min(threshold) } else { driven }
    }

    /// Sizes for tolerances: of the gain in V, and in J of the energies in [`Integrals`] that only a bridge has.
    pub(super) fn scales(&self, charge: f64, energy: f64) -> (f64, [f64; 4]) {
        let gain = charge * self.elastance();
        let stroke = (charge * (self.initial + self.drop + gain)).max(1e-12 * energy);
        (if gain > 0.0 { gain } else { 1.0 }, [stroke; 4])
    }

    /// What may end the regime.
    fn switches(&self, bridge: &Bridge) -> impl Iterator<Item = Switch> {
        let conduction = if bridge.sign == 0.0 {
            [Some(Switch::Conducts { sign: 1.0 }), Some(Switch::Conducts { sign: -1.0 })]
        } else {
            [Some(Switch::Blocks), None]
        };
        let draw = self.lockout().map(|_| Switch::Draw { connected: !bridge.connected });
        conduction.into_iter().chain([draw]).flatten()
    }

    /// What rises through zero where the regime ends so.
    fn guard(&self, switch: Switch, terminals: &Terminals, bridge: &Bridge) -> f64 {
        match switch {
            Switch::Conducts { sign } => sign * terminals.voltage - self.threshold(bridge),
            Switch::Blocks => -bridge.sign * self.current(terminals, bridge),
            Switch::Draw { connected } => self.lockout().map_or(-1.0, |lockout| {
                let voltage = self.voltage(bridge);
                if connected { voltage - lockout.turn_on_v } else { lockout.turn_off_v - voltage }
            }),
        }
    }

    /// Changes the regime, and gives the terminal voltage in V from there on, and the energies of a charge that is
    /// shared at once.
    pub(super) fn switch(
        &self,
        switch: Switch,
        terminals: Terminals,
        bridge: &mut Bridge,
    ) -> (f64, Integrals) {
        match switch {
            Switch::Conducts { .. } => self.settle(terminals, bridge, 0.0),
            Switch::Blocks => {
                let sign = std::mem::take(&mut bridge.sign);
                let voltage = sign * self.threshold(bridge);
                self.settle(Terminals { voltage, ..terminals }, bridge, sign)
            }
            Switch::Draw { connected } => {
                bridge.connected = connected;
                self.settle(terminals, bridge, 0.0)
            }
        }
    }

    /// Finds the regime where the motion or the circuit has changed at once: through a bridge no current flows back,
    /// and one that finds its threshold conducts, except in the sense `ended`. Gives what [`Self::switch`] does.
    pub(super) fn settle(
        &self,
        mut terminals: Terminals,
        bridge: &mut Bridge,
        mut ended: f64,
    ) -> (f64, Integrals) {
        let mut shared = Integrals::default();
        if bridge.sign != 0.0 && bridge.sign * self.current(&terminals, bridge) <= 0.0 {
            ended = std::mem::take(&mut bridge.sign);
        }
        if bridge.sign != 0.0 {
            return (terminals.voltage, shared);
        }
        for sign in [1.0, -1.0] {
            let threshold = self.threshold(bridge);
            let excess = sign * terminals.voltage - threshold;
            if excess < -self.margin(bridge) || sign == ended {
                continue;
            }
            let ratio = terminals.capacitance * self.elastance();
            let charge = excess.max(0.0) * terminals.capacitance / (1.0 + ratio);
            let rise = charge * self.elastance();
            shared.into_store += charge * (self.voltage(bridge) + 0.5 * rise);
            shared.diode_loss += charge * (self.drop + 0.5 * excess.max(0.0));
            bridge.gain += rise;
            terminals.voltage = sign * self.threshold(bridge);
            let conducting = Bridge { sign, ..*bridge };
            if sign * self.current(&terminals, &conducting) > 0.0 {
                *bridge = conducting;
            }
        }
        (terminals.voltage, shared)
    }
}

/// Looks for the end of a regime on the dense output of an integrator.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lookout<'a> {
    store: &'a Store,
    /// The regime that is looked through.
    bridge: Bridge,
    /// Voltages in V below which a guard that began at zero must fall before it counts from zero: of either sign.
    latched: [Option<f64>; 2],
}

impl<'a> Lookout<'a> {
    /// From a terminal voltage in V on.
    pub(super) fn new(store: &'a Store, bridge: Bridge, voltage: f64) -> Self {
        let threshold = store.threshold(&bridge);
        let margin = store.margin(&bridge);
        let latched = [1.0, -1.0].map(|sign: f64| {
            ((sign * voltage - threshold).abs() <= margin && bridge.sign == 0.0).then_some(margin)
        });
        Self { store, bridge, latched }
    }

    /// The first switch between the instants given, in which the terminals and the bridge are as `at` tells.
    pub(super) fn first(
        &mut self,
        instants: &[f64],
        at: &dyn Fn(f64) -> Result<(Terminals, Bridge), DiffsolError>,
    ) -> Result<Option<(f64, Switch)>, DiffsolError> {
        for pair in instants.windows(2) {
            let [from, to] = *pair else { continue };
            let mut first: Option<(f64, Switch)> = None;
            for switch in self.store.switches(&self.bridge) {
                let latch = match switch {
                    Switch::Conducts { sign } => Some(usize::from(sign < 0.0)),
                    _ => None,
                };
                let floor = latch.and_then(|latch| self.latched[latch]).unwrap_or(0.0);
                let guard = |t: f64| -> Result<f64, DiffsolError> {
                    let (terminals, bridge) = at(t)?;
                    Ok(self.store.guard(switch, &terminals, &bridge) - floor)
                };
                let end = guard(to)?;
                if end > 0.0 {
                    let crossing = far_side(guard, from, to)?;
                    if first.is_none_or(|(earlier, _)| crossing < earlier) {
                        first = Some((crossing, switch));
                    }
                } else if end < -2.0 * floor
                    && let Some(latch) = latch
                {
                    self.latched[latch] = None;
                }
            }
            if first.is_some() {
                return Ok(first);
            }
        }
        Ok(None)
    }
}

/// The ends and the middle of a step, and what is between them, in order.
pub(super) fn instants(from: f64, to: f64, turns: &[f64]) -> Vec<f64> {
    let mut instants = vec![from, from + 0.5 * (to - from), to];
    instants.extend(turns.iter().copied().filter(|turn| *turn > from && *turn < to));
    instants.sort_by(f64::total_cmp);
    instants
}

/// The event of the motion, unless the bridge switches clearly before it. Where the motion stops so does the
/// current: of two events that only rounding tells apart, the motion's counts.
pub(super) fn earlier<E>(motion: Option<(f64, E)>, switch: Option<(f64, E)>, step: f64) -> Option<(f64, E)> {
    const TOGETHER: f64 = 1e-9;
    match (motion, switch) {
        (Some(motion), Some(switch)) if motion.0 - switch.0 <= TOGETHER * step => Some(motion),
        (motion, switch) => switch.or(motion),
    }
}

#[cfg(test)]
mod tests;
