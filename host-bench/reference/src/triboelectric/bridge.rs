//! A full bridge at a harvester whose voltage is a state: its three regimes and the search for their ends.
//!
//! At its terminals a harvester with a voltage `V`, linear in its charge, is a capacitance `C(x)`, any parallel
//! capacitance included, and the current `j(x, v)` that the motion drives into a short circuit:
//! `C V' = j − I`. Behind the diodes, with `V_D` over each of the two that conduct, `C_s V_s' = |I| − i_out`:
//!
//! ```text
//! blocked      I = 0,  V' = j/C                                  while |V| < V_s + 2 V_D
//! conducting   V = s (V_s + 2 V_D), so V' = s V_s' and
//!              I = (j + s (C/C_s) i_out) / (1 + C/C_s)           while s I > 0
//! ```
//!
//! The voltages are continuous with one exception: where `|V|` is above the threshold, because the terminals were open before, the
//! bridge shares the charge at once. A bus is a storage with `1/C_s = 0`. The state of the storage is the voltage gained since the
//! start, so that a large storage does not lose the charge of one cycle in rounding.

use crate::ledger::{Integrals, integral};
use crate::storage::Storage;
use harvester_scene::root::far_side;
use harvester_scene::scene_file::Draw;

/// State of a bridge and of the storage; not used without a bridge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Bridge {
    /// Voltage in V that the storage has gained since the start.
    pub(crate) gain: f64,
    /// Sign of the terminal voltage while the bridge conducts; 0 while it blocks.
    pub(crate) sign: f64,
    pub(crate) connected: bool,
}

/// A harvester at its terminals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ElectricalPort {
    /// Voltage in V.
    pub(crate) voltage: f64,
    /// Current in A that the motion drives into a short circuit.
    pub(crate) driven: f64,
    /// Capacitance in F.
    pub(crate) capacitance: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Switch {
    /// The bridge begins to conduct at a voltage of this sign.
    Conducts { sign: f64 },
    /// The bridge begins to block.
    Blocks,
    /// The draw is connected or disconnected.
    Draw { connected: bool },
}

/// Part of the threshold, or of the scale of the voltages, within which a voltage counts as the threshold:
/// above the noise of the integrator.
const MARGIN: f64 = 1e-11;

impl Storage {
    /// State at the start, before the bridge has found its regime.
    pub(crate) fn start(&self) -> Bridge {
        Bridge { gain: 0.0, sign: 0.0, connected: self.starts_connected(self.initial) }
    }

    /// Voltage of the storage in V.
    pub(crate) fn voltage(&self, bridge: &Bridge) -> f64 {
        self.initial + bridge.gain
    }

    /// Energy in J that the storage has gained since the start; 0 for a bus.
    pub(crate) fn gained(&self, bridge: &Bridge) -> f64 {
        if self.is_bus() {
            return 0.0;
        }
        self.capacitance * bridge.gain * (self.initial + 0.5 * bridge.gain)
    }

    /// Magnitude in V of the terminal voltage from which the bridge conducts.
    pub(crate) fn threshold(&self, bridge: &Bridge) -> f64 {
        self.voltage(bridge) + self.drop
    }

    /// Difference in V that counts as none.
    fn margin(&self, bridge: &Bridge) -> f64 {
        MARGIN * self.threshold(bridge).max(self.scale)
    }

    /// Current in A that the node draws at a voltage in V, and its derivative by the voltage.
    pub(crate) fn drawn(&self, voltage: f64, connected: bool) -> [f64; 2] {
        match self.draw {
            Draw::Resistor { resistance_ohm, .. } if connected => {
                [voltage / resistance_ohm, resistance_ohm.recip()]
            }
            Draw::Current { current_a, .. } if connected => [current_a, 0.0],
            Draw::Power { power_w, .. } if connected => [power_w / voltage, -power_w / (voltage * voltage)],
            _ => [0.0; 2],
        }
    }

    /// Current in A out of the storage, and its derivative by the voltage.
    fn outflow(&self, bridge: &Bridge) -> [f64; 2] {
        let voltage = self.voltage(bridge);
        let [current, slope] = self.drawn(voltage, bridge.connected);
        [current + self.leakage * voltage, slope + self.leakage]
    }

    /// Current in A out of the harvester, of the sign of its voltage.
    pub(crate) fn current(&self, port: &ElectricalPort, bridge: &Bridge) -> f64 {
        if bridge.sign == 0.0 {
            return 0.0;
        }
        let ratio = port.capacitance * self.elastance();
        let [out, _] = self.outflow(bridge);
        (port.driven + bridge.sign * ratio * out) / (1.0 + ratio)
    }

    /// Derivative of [`Self::current`] for changes of `j`, `C` and the gain.
    fn current_along(
        &self,
        port: &ElectricalPort,
        bridge: &Bridge,
        [driven, capacitance, gain]: [f64; 3],
    ) -> f64 {
        if bridge.sign == 0.0 {
            return 0.0;
        }
        let elastance = self.elastance();
        let ratio = port.capacitance * elastance;
        let [out, slope] = self.outflow(bridge);
        let shared = capacitance * elastance * (bridge.sign * out - self.current(port, bridge));
        (driven + shared + bridge.sign * ratio * slope * gain) / (1.0 + ratio)
    }

    /// Rate of the gain in V/s.
    pub(crate) fn gain_rate(&self, port: &ElectricalPort, bridge: &Bridge) -> f64 {
        let [out, _] = self.outflow(bridge);
        self.elastance() * (bridge.sign * self.current(port, bridge) - out)
    }

    /// Derivative of [`Self::gain_rate`] for changes of `j`, `C` and the gain.
    pub(crate) fn gain_rate_along(&self, port: &ElectricalPort, bridge: &Bridge, changes: [f64; 3]) -> f64 {
        let [_, slope] = self.outflow(bridge);
        let current = self.current_along(port, bridge, changes);
        self.elastance() * (bridge.sign * current - slope * changes[2])
    }

    /// Powers in W: into the storage, into the diodes, leaked, drawn.
    pub(crate) fn powers(&self, port: &ElectricalPort, bridge: &Bridge) -> [f64; 4] {
        let voltage = self.voltage(bridge);
        let current = bridge.sign * self.current(port, bridge);
        let [drawn, _] = self.drawn(voltage, bridge.connected);
        [voltage * current, self.drop * current, self.leakage * voltage * voltage, drawn * voltage]
    }

    /// Size in V of the terminal voltage for tolerances, from the open-circuit voltage in V and the charge in C of one stroke.
    pub(crate) fn voltage_scale(&self, open: f64, charge: f64) -> f64 {
        let threshold = self.initial + self.drop + 10.0 * charge * self.elastance();
        if threshold > 0.0 { open.min(threshold) } else { open }
    }

    /// Sizes for tolerances: of the gain in V, and in J of the four integrals that only a bridge has.
    pub(crate) fn scales(&self, charge: f64, energy: f64) -> (f64, [f64; 4]) {
        let gain = charge * self.elastance();
        let stroke = (charge * (self.initial + self.drop + gain)).max(1e-12 * energy);
        (if gain > 0.0 { gain } else { 1.0 }, [stroke; 4])
    }

    /// The switches that may end the regime.
    fn switches(&self, bridge: &Bridge) -> impl Iterator<Item = Switch> {
        let conduction = if bridge.sign == 0.0 {
            [Some(Switch::Conducts { sign: 1.0 }), Some(Switch::Conducts { sign: -1.0 })]
        } else {
            [Some(Switch::Blocks), None]
        };
        let draw = self.lockout().map(|_| Switch::Draw { connected: !bridge.connected });
        conduction.into_iter().chain([draw]).flatten()
    }

    /// A quantity that rises through zero at the switch.
    fn guard(&self, switch: Switch, port: &ElectricalPort, bridge: &Bridge) -> f64 {
        match switch {
            Switch::Conducts { sign } => sign * port.voltage - self.threshold(bridge),
            Switch::Blocks => -bridge.sign * self.current(port, bridge),
            Switch::Draw { connected } => self.lockout().map_or(-1.0, |lockout| {
                let voltage = self.voltage(bridge);
                if connected { voltage - lockout.turn_on_v } else { lockout.turn_off_v - voltage }
            }),
        }
    }

    /// Changes the regime. Gives the terminal voltage in V after the switch, and the energies of a charge that is shared at once.
    pub(crate) fn switch(
        &self,
        switch: Switch,
        port: ElectricalPort,
        bridge: &mut Bridge,
    ) -> (f64, Integrals) {
        match switch {
            Switch::Conducts { .. } => self.find_regime(port, bridge, 0.0),
            Switch::Blocks => {
                let sign = std::mem::take(&mut bridge.sign);
                let voltage = sign * self.threshold(bridge);
                self.find_regime(ElectricalPort { voltage, ..port }, bridge, sign)
            }
            Switch::Draw { connected } => {
                bridge.connected = connected;
                self.find_regime(port, bridge, 0.0)
            }
        }
    }

    /// Finds the regime after a jump of the motion or of the circuit: no current flows back through the bridge,
    /// and a bridge at its threshold conducts, except in the sense `ended`. Gives what [`Self::switch`] does.
    pub(crate) fn find_regime(
        &self,
        mut port: ElectricalPort,
        bridge: &mut Bridge,
        mut ended: f64,
    ) -> (f64, Integrals) {
        let mut shared = Integrals::default();
        if bridge.sign != 0.0 && bridge.sign * self.current(&port, bridge) <= 0.0 {
            ended = std::mem::take(&mut bridge.sign);
        }
        if bridge.sign != 0.0 {
            return (port.voltage, shared);
        }
        for sign in [1.0, -1.0] {
            let threshold = self.threshold(bridge);
            let excess = sign * port.voltage - threshold;
            if excess < -self.margin(bridge) || sign == ended {
                continue;
            }
            let ratio = port.capacitance * self.elastance();
            let charge = excess.max(0.0) * port.capacitance / (1.0 + ratio);
            let rise = charge * self.elastance();
            shared[integral::INTO_LOAD] += charge * (self.voltage(bridge) + 0.5 * rise);
            shared[integral::DIODES] += charge * (self.drop + 0.5 * excess.max(0.0));
            bridge.gain += rise;
            // A charge that the storage takes at once may lift it over the turn-on voltage.
            bridge.connected |= rise > 0.0 && self.starts_connected(self.voltage(bridge));
            port.voltage = sign * self.threshold(bridge);
            let conducting = Bridge { sign, ..*bridge };
            if sign * self.current(&port, &conducting) > 0.0 {
                *bridge = conducting;
            }
        }
        (port.voltage, shared)
    }
}

/// The search for the end of a regime on the polynomials of the integrator.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SwitchSearch<'a> {
    storage: &'a Storage,
    /// The regime at the start of the search.
    bridge: Bridge,
    /// For each sign of the voltage, the margin in V of a guard that began at zero: the guard must fall below
    /// the margin before it counts from zero.
    latched: [Option<f64>; 2],
}

impl<'a> SwitchSearch<'a> {
    /// Starts in this regime at a terminal voltage in V.
    pub(crate) fn new(storage: &'a Storage, bridge: Bridge, voltage: f64) -> Self {
        let threshold = storage.threshold(&bridge);
        let margin = storage.margin(&bridge);
        let latched = [1.0, -1.0].map(|sign: f64| {
            ((sign * voltage - threshold).abs() <= margin && bridge.sign == 0.0).then_some(margin)
        });
        Self { storage, bridge, latched }
    }

    /// The first switch between two local times, with the turns of the motion between them; `at` gives the port
    /// and the bridge at a local time.
    pub(crate) fn first(
        &mut self,
        from: f64,
        to: f64,
        turns: &[f64],
        at: &dyn Fn(f64) -> (ElectricalPort, Bridge),
    ) -> Option<(f64, Switch)> {
        let mut instants = vec![from, from + 0.5 * (to - from), to];
        instants.extend(turns.iter().copied().filter(|turn| *turn > from && *turn < to));
        instants.sort_by(f64::total_cmp);
        let (storage, bridge) = (self.storage, self.bridge);
        for pair in instants.windows(2) {
            let mut first: Option<(f64, Switch)> = None;
            for switch in storage.switches(&bridge) {
                let crossing = self.crossing(switch, pair[0], pair[1], at);
                if let Some(crossing) = crossing
                    && first.is_none_or(|(earlier, _)| crossing < earlier)
                {
                    first = Some((crossing, switch));
                }
            }
            if first.is_some() {
                return first;
            }
        }
        None
    }

    /// The local time at which the guard of a switch has risen through zero between two instants.
    fn crossing(
        &mut self,
        switch: Switch,
        from: f64,
        to: f64,
        at: &dyn Fn(f64) -> (ElectricalPort, Bridge),
    ) -> Option<f64> {
        let latch = match switch {
            Switch::Conducts { sign } => Some(usize::from(sign < 0.0)),
            _ => None,
        };
        let floor = latch.and_then(|latch| self.latched[latch]).unwrap_or(0.0);
        let guard = |t: f64| {
            let (port, bridge) = at(t);
            self.storage.guard(switch, &port, &bridge) - floor
        };
        let end = guard(to);
        if end > 0.0 {
            return Some(far_side(guard, from, to));
        }
        if end < -2.0 * floor
            && let Some(latch) = latch
        {
            self.latched[latch] = None;
        }
        None
    }
}

/// The event of the motion, unless the bridge switches clearly before it. The current stops with the motion: of
/// two events that differ by rounding only, the one of the motion counts.
pub(crate) fn earlier<E>(motion: Option<(f64, E)>, switch: Option<(f64, E)>, step: f64) -> Option<(f64, E)> {
    const TOGETHER: f64 = 1e-9;
    match (motion, switch) {
        (Some(motion), Some(switch)) if motion.0 - switch.0 <= TOGETHER * step => Some(motion),
        (motion, switch) => switch.or(motion),
    }
}

#[cfg(test)]
mod tests;
