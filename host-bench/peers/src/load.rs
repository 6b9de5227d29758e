//! The two kinds of load at a harvester's terminals: a resistor, and a full bridge into a storage capacitor.
//!
//! At its terminals a harvester is a capacitance `C` and the current `j` that the motion drives into a short circuit, so the voltage
//! obeys `C V' = j − I`. Through a resistor `I = V/R`. A bridge blocks while `|V| < V_s + 2 V_D`; while it conducts, `V = s (V_s + 2
//! V_D)` and `C_s V_s' = |I| − i_out`, which gives `I = (j + s (C/C_s) i_out) / (1 + C/C_s)`.

use harvester_scene::scene_file::{Draw, RectifiedStore};

use super::scene::{Base, GUARDS, Harvester, Mode, NEVER};
use crate::Stop;

/// A harvester at its terminals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Port {
    /// `j` in A.
    pub(crate) driven: f64,
    /// `C` in F.
    pub(crate) capacitance: f64,
}

pub(crate) enum After<B> {
    /// It goes on, on this branch.
    On(B),
    /// It sticks.
    Stuck,
}

/// The motion of a harvester and its electrostatics.
pub(crate) trait Transducer {
    type Branch: Copy;
    /// Number of guards of the motion, the first ones.
    const GUARDS: usize;

    fn base(&self) -> &Base;

    /// What the motion does at time zero, with its state written to `motion`.
    fn start(&self, motion: &mut [f64]) -> After<Self::Branch>;

    /// The branch of a motion that leaves stick.
    fn released(&self, time: f64, motion: &[f64], voltage: f64) -> Self::Branch;

    /// Sizes of the states of the motion, and in C of the charge that passes the terminals in one stroke and in F of the
    /// capacitance at rest.
    fn sizes(&self, motion: &mut [f64]) -> [f64; 2];

    /// Rates of the motion, and the port, at a base acceleration in m/s² and a voltage in V.
    fn flow(&self, branch: Self::Branch, base: f64, motion: &[f64], voltage: f64, rates: &mut [f64]) -> Port;

    fn port(&self, branch: Self::Branch, motion: &[f64], voltage: f64) -> Port;

    /// Derivative of [`Self::flow`] in the direction of a change of motion and voltage, after the port itself.
    fn flow_along(
        &self,
        branch: Self::Branch,
        at: (&[f64], f64),
        change: (&[f64], f64),
        rates: &mut [f64],
    ) -> [Port; 2];

    fn guards(&self, branch: Self::Branch, motion: &[f64]) -> [f64; 2];

    fn jump(
        &self,
        guard: usize,
        time: f64,
        branch: Self::Branch,
        motion: &mut [f64],
        voltage: f64,
    ) -> After<Self::Branch>;

    /// Force in N that is left before a stick ends.
    fn reserve(&self, time: f64, motion: &[f64], voltage: f64) -> f64;

    /// Refuses a motion out of the range of the model.
    fn check(&self, motion: &[f64]) -> Result<(), Stop>;
}

/// The mode in which a flow begins.
fn mode<T: Transducer>(after: After<T::Branch>, stand_in: T::Branch, connected: bool) -> Mode<T::Branch> {
    match after {
        After::On(branch) => Mode { branch, stuck: false, sign: 0.0, connected },
        After::Stuck => Mode { branch: stand_in, stuck: true, sign: 0.0, connected },
    }
}

/// What a load leaves to the motion, whose states are those before the last `$others`; the first of these is the voltage.
macro_rules! of_motion {
    ($others:literal) => {
        fn base(&self) -> &Base {
            self.transducer.base()
        }

        fn motion_states(&self) -> usize {
            N - $others
        }

        fn reserve(&self, _: &Mode<T::Branch>, time: f64, state: &[f64; N]) -> f64 {
            self.transducer.reserve(time, &state[..N - $others], state[N - $others])
        }

        fn release(&self, mode: &mut Mode<T::Branch>, time: f64, state: &[f64; N]) {
            mode.branch = self.transducer.released(time, &state[..N - $others], state[N - $others]);
            mode.stuck = false;
        }

        fn check(&self, state: &[f64; N]) -> Result<(), Stop> {
            self.transducer.check(&state[..N - $others])
        }
    };
}

/// A harvester with a resistor: its motion, the voltage, the energy.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WithResistor<T> {
    pub(crate) transducer: T,
    /// Conductance in S.
    pub(crate) conductance: f64,
}

impl<T: Transducer, const N: usize> Harvester<N> for WithResistor<T> {
    type Branch = T::Branch;

    of_motion!(2);

    fn start(&self) -> (Mode<T::Branch>, [f64; N]) {
        let mut state = [0.0; N];
        let after = self.transducer.start(&mut state[..N - 2]);
        let stand_in = self.transducer.released(0.0, &state[..N - 2], 0.0);
        (mode::<T>(after, stand_in, false), state)
    }

    fn sizes(&self) -> [f64; N] {
        let mut sizes = [0.0; N];
        let [charge, capacitance] = self.transducer.sizes(&mut sizes[..N - 2]);
        let current = self.transducer.base().angular_frequency * charge;
        sizes[N - 2] = (charge / capacitance).min(current / self.conductance);
        sizes[N - 1] = sizes[N - 2] * charge;
        sizes
    }

    #[inline]
    fn rates(&self, mode: &Mode<T::Branch>, time: f64, state: &[f64; N]) -> [f64; N] {
        let mut rates = [0.0; N];
        let voltage = state[N - 2];
        let base = self.transducer.base().at(time);
        let port = self.transducer.flow(mode.branch, base, &state[..N - 2], voltage, &mut rates[..N - 2]);
        let current = voltage * self.conductance;
        rates[N - 2] = (port.driven - current) / port.capacitance;
        rates[N - 1] = voltage * current;
        rates
    }

    #[inline]
    fn rates_along(&self, mode: &Mode<T::Branch>, _: f64, state: &[f64; N], change: &[f64; N]) -> [f64; N] {
        let mut rates = [0.0; N];
        let (voltage, d_voltage) = (state[N - 2], change[N - 2]);
        let (at, along) = ((&state[..N - 2], voltage), (&change[..N - 2], d_voltage));
        let [port, d_port] = self.transducer.flow_along(mode.branch, at, along, &mut rates[..N - 2]);
        let rate = (port.driven - voltage * self.conductance) / port.capacitance;
        let d_current = d_voltage * self.conductance;
        rates[N - 2] = (d_port.driven - d_current - rate * d_port.capacitance) / port.capacitance;
        rates[N - 1] = 2.0 * voltage * d_current;
        rates
    }

    #[inline]
    fn guards(&self, mode: &Mode<T::Branch>, state: &[f64; N]) -> [f64; GUARDS] {
        let [first, second] = self.transducer.guards(mode.branch, &state[..N - 2]);
        [first, second, NEVER, NEVER, NEVER]
    }

    fn jump(&self, guard: usize, time: f64, mode: &mut Mode<T::Branch>, state: &mut [f64; N]) {
        let voltage = state[N - 2];
        match self.transducer.jump(guard, time, mode.branch, &mut state[..N - 2], voltage) {
            After::On(branch) => mode.branch = branch,
            After::Stuck => mode.stuck = true,
        }
    }

    /// The charge is frozen and the load open.
    fn stand(&self, _: &mut [f64; N], _: f64) {}
}

/// A harvester behind a bridge with a storage: its motion, the voltage, that of the storage, the energy.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WithBridge<T> {
    pub(crate) transducer: T,
    pub(crate) store: RectifiedStore,
}

/// Current in A out of a storage, and its derivative by the voltage.
type Outflow = [f64; 2];

impl<T: Transducer> WithBridge<T> {
    #[inline]
    fn outflow(&self, stored: f64, connected: bool) -> Outflow {
        let leakage = self.store.leakage_ohm.recip();
        let [drawn, slope] = match self.store.draw {
            Draw::Power { power_w, .. } if connected => {
                let current = power_w / stored;
                [current, -current / stored]
            }
            _ => [0.0; 2],
        };
        [drawn + leakage * stored, slope + leakage]
    }

    /// Current in A through a conducting bridge.
    #[inline]
    fn current(&self, port: Port, sign: f64, [out, _]: Outflow) -> f64 {
        let ratio = port.capacitance / self.store.capacitance_f;
        (port.driven + sign * ratio * out) / (1.0 + ratio)
    }

    /// Magnitude in V of the voltage from which the bridge conducts.
    #[inline]
    fn threshold(&self, stored: f64) -> f64 {
        stored + 2.0 * self.store.diode_drop_v
    }

    /// Ends a conduction whose current has stopped.
    fn settle<const N: usize>(&self, mode: &mut Mode<T::Branch>, state: &[f64; N]) {
        if mode.sign == 0.0 {
            return;
        }
        let port = self.transducer.port(mode.branch, &state[..N - 3], state[N - 3]);
        let out = self.outflow(state[N - 2], mode.connected);
        if mode.sign * self.current(port, mode.sign, out) <= 0.0 {
            mode.sign = 0.0;
        }
    }
}

impl<T: Transducer, const N: usize> Harvester<N> for WithBridge<T> {
    type Branch = T::Branch;

    of_motion!(3);

    fn start(&self) -> (Mode<T::Branch>, [f64; N]) {
        let mut state = [0.0; N];
        let after = self.transducer.start(&mut state[..N - 3]);
        state[N - 2] = self.store.initial_v;
        let connected =
            self.store.draw.lockout().is_some_and(|lockout| self.store.initial_v >= lockout.turn_on_v);
        let stand_in = self.transducer.released(0.0, &state[..N - 3], 0.0);
        (mode::<T>(after, stand_in, connected), state)
    }

    fn sizes(&self) -> [f64; N] {
        let mut sizes = [0.0; N];
        let [charge, capacitance] = self.transducer.sizes(&mut sizes[..N - 3]);
        let threshold = self.threshold(self.store.initial_v);
        sizes[N - 3] = (charge / capacitance).min(threshold);
        sizes[N - 2] = charge / self.store.capacitance_f;
        sizes[N - 1] = charge * threshold;
        sizes
    }

    #[inline]
    fn rates(&self, mode: &Mode<T::Branch>, time: f64, state: &[f64; N]) -> [f64; N] {
        let mut rates = [0.0; N];
        let (voltage, stored) = (state[N - 3], state[N - 2]);
        let base = self.transducer.base().at(time);
        let port = self.transducer.flow(mode.branch, base, &state[..N - 3], voltage, &mut rates[..N - 3]);
        let out = self.outflow(stored, mode.connected);
        if mode.sign == 0.0 {
            rates[N - 3] = port.driven / port.capacitance;
            rates[N - 2] = -out[0] / self.store.capacitance_f;
        } else {
            let current = mode.sign * self.current(port, mode.sign, out);
            rates[N - 2] = (current - out[0]) / self.store.capacitance_f;
            rates[N - 3] = mode.sign * rates[N - 2];
            rates[N - 1] = stored * current;
        }
        rates
    }

    #[inline]
    fn rates_along(&self, mode: &Mode<T::Branch>, _: f64, state: &[f64; N], change: &[f64; N]) -> [f64; N] {
        let mut rates = [0.0; N];
        let [stored, d_stored] = [state[N - 2], change[N - 2]];
        let (at, along) = ((&state[..N - 3], state[N - 3]), (&change[..N - 3], change[N - 3]));
        let [port, d_port] = self.transducer.flow_along(mode.branch, at, along, &mut rates[..N - 3]);
        let out = self.outflow(stored, mode.connected);
        let d_out = out[1] * d_stored;
        let capacitance = self.store.capacitance_f;
        if mode.sign == 0.0 {
            let rate = port.driven / port.capacitance;
            rates[N - 3] = (d_port.driven - rate * d_port.capacitance) / port.capacitance;
            rates[N - 2] = -d_out / capacitance;
        } else {
            let ratio = port.capacitance / capacitance;
            let current = self.current(port, mode.sign, out);
            let shared = d_port.capacitance / capacitance * (mode.sign * out[0] - current);
            let d_current = (d_port.driven + shared + mode.sign * ratio * d_out) / (1.0 + ratio);
            rates[N - 2] = (mode.sign * d_current - d_out) / capacitance;
            rates[N - 3] = mode.sign * rates[N - 2];
            rates[N - 1] = mode.sign * (d_stored * current + stored * d_current);
        }
        rates
    }

    #[inline]
    fn guards(&self, mode: &Mode<T::Branch>, state: &[f64; N]) -> [f64; GUARDS] {
        let [first, second] = self.transducer.guards(mode.branch, &state[..N - 3]);
        let (voltage, stored) = (state[N - 3], state[N - 2]);
        let [third, fourth] = if mode.sign == 0.0 {
            let threshold = self.threshold(stored);
            [threshold - voltage, threshold + voltage]
        } else {
            let port = self.transducer.port(mode.branch, &state[..N - 3], voltage);
            let out = self.outflow(stored, mode.connected);
            [mode.sign * self.current(port, mode.sign, out), NEVER]
        };
        let draw = self.store.draw.lockout().map_or(NEVER, |lockout| {
            if mode.connected { stored - lockout.turn_off_v } else { lockout.turn_on_v - stored }
        });
        [first, second, third, fourth, draw]
    }

    fn jump(&self, guard: usize, time: f64, mode: &mut Mode<T::Branch>, state: &mut [f64; N]) {
        let voltage = state[N - 3];
        match guard {
            _ if guard < T::GUARDS => {
                match self.transducer.jump(guard, time, mode.branch, &mut state[..N - 3], voltage) {
                    After::On(branch) => mode.branch = branch,
                    // The terminals are open: the charge is frozen.
                    After::Stuck => (mode.stuck, mode.sign) = (true, 0.0),
                }
            }
            4 => mode.connected = !mode.connected,
            _ if mode.sign != 0.0 => mode.sign = 0.0,
            _ => {
                mode.sign = if guard == 2 { 1.0 } else { -1.0 };
                state[N - 3] = mode.sign * self.threshold(state[N - 2]);
            }
        }
        self.settle(mode, state);
    }

    /// The terminals are open; only the leakage goes on.
    fn stand(&self, state: &mut [f64; N], elapsed: f64) {
        state[N - 2] *= (-elapsed / (self.store.leakage_ohm * self.store.capacitance_f)).exp();
    }
}
