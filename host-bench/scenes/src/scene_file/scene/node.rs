//! `[node]`: what a sensor node does with what is harvested.

use crate::market::{Battery, Reservoir};

/// Hours of a day.
pub const HOURS: usize = 24;

/// A node and its day.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Seconds between two updates of the energy budget; a whole number that divides a day.
    pub update_s: u32,
    /// Seconds between two decisions; a whole number of updates, and of them in a day.
    pub decision_s: u32,
    /// Slots of the day in which income is remembered.
    pub slots_per_day: usize,
    /// Power in W that the node takes whatever it does, upper bound: its named parts asleep, and what is stated beside.
    pub standing_power_w: f64,
    /// Power in W of the named parts asleep; `None` without named parts.
    pub asleep_power_w: Option<f64>,
    /// Time constant in s of the exponentially weighted mean of the income.
    pub time_constant_s: f64,
    /// Weight of the newest day in the mean of a slot.
    pub day_weight: f64,
    /// What it lives on.
    pub storage: Storage,
    /// What it can do, the most important first; at least one, each with a name of its own.
    pub actions: Vec<Action>,
    /// What it does to know its income, before all else.
    pub estimation: Vec<EstimationCost>,
    /// The figures of its named parts.
    pub figures: Vec<PartFigure>,
    /// What the amplitude of the excitation is multiplied with, hour by hour from midnight.
    pub hours: [f64; HOURS],
}

/// The store of a node with its converters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Storage {
    /// A battery beside the capacitor.
    pub battery: Option<Battery>,
    /// Capacitance in F.
    pub capacitance_f: f64,
    /// Leakage resistance in Ω; infinity is no leakage.
    pub leakage_ohm: f64,
    /// Voltage in V at the start.
    pub initial_v: f64,
    /// Part of the harvested energy that reaches the store, without that of a battery.
    pub charging_efficiency: f64,
    /// Part of the energy from the store that reaches the node.
    pub discharging_efficiency: f64,
    /// Voltage in V at which further income is shunted.
    pub highest_v: f64,
    /// Voltage in V at which the node is switched off.
    pub turn_off_v: f64,
    /// Voltage in V at which it is switched on again.
    pub turn_on_v: f64,
    /// Power in W that the part takes from the store for itself while the node is connected, beside leakage.
    pub own_power_w: f64,
}

/// Something that a node does.
#[derive(Debug, Clone, PartialEq)]
pub struct Action {
    pub name: String,
    /// What it takes at the node in J, upper bound.
    pub energy_j: f64,
    /// How long it takes in s, upper bound.
    pub duration_s: f64,
    /// How often it is wished for: seconds from one to the next.
    pub every_s: f64,
}

/// Something that a node does to know its income.
#[derive(Debug, Clone, PartialEq)]
pub struct EstimationCost {
    /// What is done.
    pub action: Action,
    /// Its energy in J by what takes it.
    pub costs: Vec<(&'static str, f64)>,
}

/// A figure of a named part.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PartFigure {
    pub part: String,
    /// The quantity with its unit.
    pub quantity: &'static str,
    /// The value in that unit.
    pub value: f64,
    /// How far it is known.
    pub evidence: crate::market::Evidence,
    /// The document, or the assumption.
    pub source: &'static str,
}

impl Storage {
    /// What holds its energy.
    pub fn reservoir(&self) -> Reservoir {
        let Self { battery, capacitance_f, leakage_ohm, .. } = *self;
        Reservoir { capacitance_f, leakage_ohm, battery }
    }
}

impl Node {
    /// What it does to know its income, and its other actions, the most important first.
    pub fn all_actions(&self) -> impl Iterator<Item = &Action> {
        self.estimation.iter().map(|estimation| &estimation.action).chain(&self.actions)
    }
}
