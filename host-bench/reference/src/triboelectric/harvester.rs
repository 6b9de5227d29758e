//! What a scene supplies to the marching loop: its equations, its events, and what it reports.

use super::bridge::{Bridge, ElectricalPort, Switch};
use crate::ledger::{Integrals, integral};
use crate::storage::Storage;
use harvester_scene::outcome::Particular;
use harvester_scene::scene_file::{Load, StickCharge};

pub(crate) const VACUUM_PERMITTIVITY: f64 = 8.854_187_812_8e-12;

/// Fastest rate in 1/s at which the motion changes the capacitance: a gap of a dielectric thickness crossed at
/// the impact speeds of these devices, and far above the frequency of the fastest beam that a scene may have.
const FASTEST_RATE: f64 = 1e5;

/// How the voltage follows the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CircuitKind {
    /// The voltage is a state; behind a bridge also while the terminals are open.
    Dynamic,
    /// The circuit is so fast that `V = R dq/dt` with the charge of the short circuit, to 1e-11.
    QuasiStatic,
    /// No current flows: the charge is constant, and the voltage follows from the position.
    Open,
}

impl CircuitKind {
    /// The voltage that sets the charges, or a derivative of it: the one of the state, that of an open circuit, or none.
    pub(crate) fn voltage(self, state: f64, open: impl FnOnce() -> f64) -> f64 {
        match self {
            Self::Dynamic => state,
            Self::QuasiStatic => 0.0,
            Self::Open => open(),
        }
    }
}

/// The circuit at the terminals, and what the charge does in stick.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LoadCircuit {
    pub(crate) kind: CircuitKind,
    /// Resistance in Ω; infinite with a bridge.
    pub(crate) resistance: f64,
    /// `1 / R` in S; 0 for an open circuit. Not used where `R` is 0.
    pub(crate) conductance: f64,
    /// The storage behind a bridge.
    pub(crate) storage: Option<Storage>,
    pub(crate) stick_charge: StickCharge,
}

impl LoadCircuit {
    /// The circuit of a load at a harvester of at most this capacitance in F; with a charge at the start the voltage is a
    /// state, however fast.
    pub(crate) fn new(load: Load, stick_charge: StickCharge, capacitance: f64, charge: Option<f64>) -> Self {
        let (resistance, storage) = (load.resistance_ohm(), Storage::of(load));
        let kind = if storage.is_some() {
            CircuitKind::Dynamic
        } else if resistance.is_infinite() {
            CircuitKind::Open
        } else if resistance == 0.0 || charge.is_none() && resistance * capacitance * FASTEST_RATE < 1e-11 {
            CircuitKind::QuasiStatic
        } else {
            CircuitKind::Dynamic
        };
        Self { kind, resistance, conductance: 1.0 / resistance, storage, stick_charge }
    }

    pub(crate) fn bridge(&self) -> Bridge {
        self.storage.map_or(Bridge::default(), |storage| storage.start())
    }

    /// Energy in J delivered to the load: to the resistor, or to the storage or bus behind its diodes.
    pub(crate) fn delivered(&self, integrals: &Integrals) -> f64 {
        match self.storage {
            Some(_) => integrals[integral::INTO_LOAD],
            None if self.resistance > 0.0 => integrals[integral::VOLTAGE_SQUARED] * self.conductance,
            None => 0.0,
        }
    }
}

/// Sizes that the tolerances of the integrator are relative to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scales {
    /// Position in m.
    pub(crate) position: f64,
    /// Velocity in m/s.
    pub(crate) velocity: f64,
    /// Voltage in V.
    pub(crate) voltage: f64,
    /// Time in s over which the motion changes.
    pub(crate) time: f64,
    /// Energy of the motion in J.
    pub(crate) energy: f64,
    /// Work in J of the forces between the surfaces.
    pub(crate) surface_energy: f64,
    /// Charge in C that passes the terminals.
    pub(crate) charge: f64,
}

/// A function of local time on the polynomial of a step.
pub(crate) type Dense<'a, T> = dyn Fn(f64) -> T + 'a;

/// A motion at a local time in s.
pub(crate) type Sample = (f64, Motion);

/// The search for the events of a scene along one stretch of flow.
pub(crate) trait Guards: Copy {
    type Event: Copy;

    /// Local times at which pieces of a step end; in each piece the velocity changes sign at most once.
    fn cuts(&self, _acceleration: &Dense<'_, f64>, from: f64, to: f64) -> Vec<f64> {
        vec![from + 0.5 * (to - from), to]
    }

    /// The first event in a piece in which the velocity keeps its sign. Pieces come in the order of time.
    fn event(&mut self, motion: &Dense<'_, Motion>, begin: Sample, end: Sample)
    -> Option<(f64, Self::Event)>;
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Jump {
    /// Mode after the event.
    pub(crate) mode: Mode,
    /// Speed of an impact in m/s, and energy in J lost in it.
    pub(crate) impact: Option<[f64; 2]>,
    /// Whether the event counts as one in the outcome.
    pub(crate) counts: bool,
}

/// Extremes and counts over the measuring window.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Counts {
    /// Largest position in m.
    pub(crate) highest: f64,
    /// Smallest position in m.
    pub(crate) lowest: f64,
    pub(crate) impacts: u64,
    /// Largest impact speed in m/s.
    pub(crate) impact_speed: f64,
    /// Time in s of the first impact of the whole run.
    pub(crate) first_impact: Option<f64>,
    /// Entries into stick.
    pub(crate) sticks: u64,
    /// Part of the window in stick.
    pub(crate) stick_fraction: f64,
    /// Periods of the base in the window, if the base moves in one sine.
    pub(crate) periods: Option<f64>,
}

pub(crate) type SceneEvent<H> = <<H as Harvester>::Guards as Guards>::Event;

pub(crate) trait Harvester: Sized {
    /// The search for the events of the scene.
    type Guards: Guards;

    /// Name of the position.
    const POSITION: &'static str;
    const COLUMNS: &'static [&'static str; 8];
    /// Part of the time scale by which a flow must get on in many steps.
    const LEAST_PROGRESS: f64;

    fn load(&self) -> &LoadCircuit;

    /// Sizes for the tolerances of a run that starts so.
    fn scales(&self, start: &Motion) -> Scales;

    /// Acceleration in m/s² under a base acceleration in m/s².
    fn acceleration(&self, motion: &Motion, base: f64) -> f64;

    /// Derivative of [`Self::acceleration`] in the direction of `change`.
    fn acceleration_along(&self, motion: &Motion, change: &Motion) -> f64;

    /// Rate in V/s of the load voltage while the bridge blocks.
    fn voltage_rate(&self, motion: &Motion, base: f64) -> f64;

    /// Derivative of [`Self::voltage_rate`] in the direction of `change`, if the voltage is a state.
    fn voltage_rate_along(&self, motion: &Motion, change: &Motion) -> f64;

    /// Powers in W: [`integral::BASE_WORK`] to [`integral::FIELD_WORK`] have their integrals.
    fn powers(&self, motion: &Motion, base: f64) -> [f64; 4];

    /// Energy in J of mass and spring, and that of the electric field.
    fn energies(&self, motion: &Motion) -> [f64; 2];

    /// Work in J on mass and spring of the given integrals, impacts aside.
    fn mechanical_work(&self, total: &Integrals) -> f64 {
        total[integral::BASE_WORK] - total[integral::DAMPING] - total[integral::SURFACE_WORK]
    }

    /// Energy in J that the field gains from the motion beyond what the motion loses to its force.
    fn created_energy(&self, total: &Integrals) -> f64 {
        -total[integral::FIELD_WORK] - total[integral::SURFACE_WORK]
    }

    /// Whether the energies of motion and field are conserved together.
    fn conserves_energy(&self) -> bool;

    /// Whether the motion is within the range of the model.
    fn is_in_range(&self, motion: &Motion) -> bool;

    /// Load voltage in V.
    fn voltage(&self, motion: &Motion) -> f64;

    /// Transferred charge in C.
    fn charge(&self, motion: &Motion) -> f64;

    /// The harvester at its terminals.
    fn port(&self, motion: &Motion) -> ElectricalPort;

    /// Derivative of the driven current in A and of the capacitance in F in the direction of `change`.
    fn port_along(&self, motion: &Motion, change: &Motion) -> [f64; 2];

    /// Time constant in s of the load circuit at this position.
    fn time_constant(&self, motion: &Motion) -> f64;

    /// Finds the mode at the start of a run.
    fn start(&self, motion: &mut Motion, base: f64) -> Mode;

    /// The search for events from the start of a flow.
    fn guards(&self, start: &Motion) -> Self::Guards;

    /// Carries out an event.
    ///
    /// # Errors
    /// If the model ends there.
    fn jump(&self, event: SceneEvent<Self>, motion: &mut Motion, base: f64) -> Result<Jump, String>;

    /// Force in N that is left before stick ends.
    fn reserve(&self, motion: &Motion, base: f64) -> f64;

    /// Sets the branch of a motion that leaves stick.
    fn release(&self, _motion: &mut Motion, _base: f64) {}

    /// What only this kind of scene reports.
    fn particular(&self, counts: &Counts) -> Particular;

    /// Rate in V/s of the voltage that the storage has gained.
    fn gain_rate(&self, motion: &Motion) -> f64 {
        let storage = self.load().storage;
        storage.map_or(0.0, |storage| storage.gain_rate(&self.port(motion), &motion.bridge))
    }

    /// Rate in V/s of the load voltage; through a conducting bridge the voltage follows that of the storage.
    fn voltage_slope(&self, motion: &Motion, base: f64) -> f64 {
        let sign = motion.bridge.sign;
        if sign == 0.0 { self.voltage_rate(motion, base) } else { sign * self.gain_rate(motion) }
    }

    fn rates(&self, motion: &Motion, base: f64) -> [f64; Motion::STATES] {
        let is_state = self.load().kind == CircuitKind::Dynamic;
        let voltage = if is_state { self.voltage_slope(motion, base) } else { 0.0 };
        [motion.velocity, self.acceleration(motion, base), voltage, self.gain_rate(motion)]
    }

    /// Derivative of [`Self::rates`] in the direction of `change`.
    fn rates_along(&self, motion: &Motion, change: &Motion) -> [f64; Motion::STATES] {
        let LoadCircuit { kind, storage, .. } = *self.load();
        let gain = storage.map_or(0.0, |storage| {
            let [driven, capacitance] = self.port_along(motion, change);
            let changes = [driven, capacitance, change.bridge.gain];
            storage.gain_rate_along(&self.port(motion), &motion.bridge, changes)
        });
        let sign = motion.bridge.sign;
        let voltage = match kind {
            CircuitKind::Dynamic if sign != 0.0 => sign * gain,
            CircuitKind::Dynamic => self.voltage_rate_along(motion, change),
            CircuitKind::QuasiStatic | CircuitKind::Open => 0.0,
        };
        [change.velocity, self.acceleration_along(motion, change), voltage, gain]
    }

    fn integrands(&self, motion: &Motion, base: f64) -> Integrals {
        let voltage = self.voltage(motion);
        let [base_work, damping, surface, field] = self.powers(motion, base);
        let storage = self.load().storage;
        let [into, diodes, leaked, drawn] =
            storage.map_or([0.0; 4], |storage| storage.powers(&self.port(motion), &motion.bridge));
        [voltage * voltage, voltage, base_work, damping, surface, field, into, diodes, leaked, drawn]
    }

    /// Lets the bridge find its regime after a jump; gives the energies of a charge that is shared at once.
    fn find_bridge_regime(&self, motion: &mut Motion) -> Integrals {
        let Some(storage) = &self.load().storage else { return Integrals::default() };
        let (voltage, shared) = storage.find_regime(self.port(motion), &mut motion.bridge, 0.0);
        motion.voltage = voltage;
        shared
    }

    /// Enters stick: a frozen charge opens the terminals. Gives what [`Self::find_bridge_regime`] does.
    fn enter_stick(&self, motion: &mut Motion) -> Integrals {
        match self.load().stick_charge {
            StickCharge::Frozen => {
                motion.bridge.sign = 0.0;
                Integrals::default()
            }
            StickCharge::Relaxing => self.find_bridge_regime(motion),
        }
    }

    /// Switches the bridge or the draw; gives what [`Self::find_bridge_regime`] does.
    fn switch(&self, switch: Switch, mode: Mode, motion: &mut Motion) -> Integrals {
        let Some(storage) = &self.load().storage else { return Integrals::default() };
        if let (Mode::Stick, StickCharge::Frozen, Switch::Draw { connected }) =
            (mode, self.load().stick_charge, switch)
        {
            motion.bridge.connected = connected;
            return Integrals::default();
        }
        let (voltage, shared) = storage.switch(switch, self.port(motion), &mut motion.bridge);
        motion.voltage = voltage;
        shared
    }
}

/// Position, velocity, voltage, and the state of the bridge.
///
/// The voltage is a state only where it follows the motion by a rate. Otherwise it is zero here, and the
/// physics computes it from position and velocity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Motion {
    /// Gap or displacement in m.
    pub(crate) position: f64,
    /// Velocity in m/s.
    pub(crate) velocity: f64,
    /// Load voltage in V.
    pub(crate) voltage: f64,
    /// Branch of the sliding equations; contact-separation has one branch and does not use it.
    pub(crate) branch: Branch,
    pub(crate) bridge: Bridge,
}

/// Branch on which friction and overlap are smooth functions of the motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Branch {
    /// Direction of slip, 1 or −1; 0 without friction.
    pub(crate) direction: f64,
    /// Side of the middle on which the overlap is taken, 1 or −1.
    pub(crate) side: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    /// The mass flies, or the slider slips.
    Flow,
    /// The mass sticks to the dielectric, or the slider to the patches.
    Stick,
}

impl Motion {
    /// Number of states: position, velocity, voltage and, with a storage, its gain.
    pub(crate) const STATES: usize = 4;

    pub(crate) fn states(&self) -> [f64; Self::STATES] {
        [self.position, self.velocity, self.voltage, self.bridge.gain]
    }

    /// A motion with these states, or the first three of them, in the same regime.
    pub(crate) fn with(&self, states: &[f64]) -> Self {
        let gain = states.get(3).copied().unwrap_or(self.bridge.gain);
        let bridge = Bridge { gain, ..self.bridge };
        Self { position: states[0], velocity: states[1], voltage: states[2], bridge, ..*self }
    }
}
