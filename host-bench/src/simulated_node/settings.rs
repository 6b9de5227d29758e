//! How a node is built, and the stated values of its parts.

use harvester_scene::market::{
    Accelerometer, Battery, Code, CostModel, Instructions, Processor, Reservoir, node_instructions,
};
use model_core::energy::{Capacitor, ResponseMap, StorageParameters};
use model_core::excitation::LineBank;
use model_core::node::{
    BatteryElement, Bursts, CapacitorElement, Converter, Element, MapNode, MapParameters, MapState,
    NodeError, Regular, Sensor, Tolerances, VoltageNode, VoltageParameters, VoltageState,
};

use super::Tiered;
use super::harvester::Kind;

/// A node with a map: sections of at most 20 samples, 32 of them in a block; one action.
pub type OneNode = MapOn<CapacitorElement>;
/// The same on an element.
pub(super) type MapOn<E> = MapNode<&'static [u8], 20, 32, 1, E>;
pub type OneState = MapState<32, 1>;

/// Sensor: m/s² of a count.
pub(super) const UNIT: f64 = 9.806_65 / 1024.0;
/// Converter: 12 bits over 5 V, half a cell of noise in V.
pub(super) const CELL: f64 = 5.0 / 4096.0;
pub(super) const CONVERTER_NOISE: f64 = 0.6e-3;
/// Blocks of samples in a burst.
const BLOCKS: u32 = 1;
/// Lock-out, turn-on and highest voltage of a capacitor in V.
const VOLTAGES: [f64; 3] = [1.8, 2.2, 4.5];
/// Mean income in W, unless a storage has another one.
pub(super) const INCOME: f64 = 2.9e-6;

/// Voltage in V at which a run begins: 3 V, or that of a half-charged battery.
pub(super) fn begin_v(battery: Option<Battery>) -> f64 {
    battery.map_or(3.0, |battery| battery.half_v.0)
}

/// How a node is built: its storage, what its parts cost, how far they may be off. Energies are in J; the harvester is scaled to the income.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    pub kind: Kind,
    pub processor: Processor,
    /// Of the storage in F, and its leakage resistance in Ω.
    pub capacitance: f64,
    pub leakage: f64,
    /// Beside the capacitor.
    pub battery: Option<Battery>,
    /// Lock-out, turn-on and highest voltage in V.
    pub voltages: [f64; 3],
    /// Mean income in W that the harvester is scaled to, and the income in W of the harvester as it is over that.
    pub income: f64,
    pub scale: f64,
    /// Standing power in W, and energy of an action in J, with the shortest time in s from one to the next.
    pub standing: f64,
    pub action: f64,
    pub every: u32,
    /// Energy in J that actions leave above the lock-out.
    pub reserve: f64,
    /// Relative deviations of the standing power, of the energy of an action, and of the capacitance: the last two 1σ.
    pub spread: f64,
    pub of_action: f64,
    pub of_capacitance: f64,
    /// How far the highest voltage of the storage may be below the stated one, relative.
    pub of_highest: f64,
    /// Standard deviation of the gain of the map: 1 of a harvester of which nothing was measured.
    pub gain: f64,
    /// Seconds between bursts where the voltage shows the income.
    pub check: u32,
}

impl Settings {
    /// A node with an income of 2.9 µW, an action of 0.3 mJ as often as that allows, and a third of its storage as reserve.
    pub fn new(kind: Kind, processor: Processor, capacitance: f64, spread: f64) -> Self {
        let [lock_out, _, highest] = VOLTAGES;
        Self {
            kind,
            processor,
            capacitance,
            leakage: f64::INFINITY,
            battery: None,
            voltages: VOLTAGES,
            income: INCOME,
            scale: 1.0,
            standing: 0.3e-6,
            action: 0.3e-3,
            every: 40,
            reserve: 0.3 * 0.5 * capacitance * (highest * highest - lock_out * lock_out),
            spread,
            of_action: 0.0,
            of_capacitance: 0.0,
            of_highest: 0.0,
            gain: 1.0,
            check: 80_000,
        }
    }

    /// With another income, and a standing power and actions in proportion.
    pub(super) fn with_income(self, income: f64) -> Self {
        let factor = income / self.income;
        Self { income, standing: factor * self.standing, action: factor * self.action, ..self }
    }

    /// Energy in J between the lock-out and a full storage.
    pub(super) fn room(&self) -> f64 {
        let [lock_out, _, full] = self.voltages.map(|voltage| self.reservoir(1.0).energy_j(voltage));
        full - lock_out
    }

    /// On a buffer of intermittent nodes, which work from the turn-on to the lock-out: actions of 15 µJ each 2 s, the power of the usual ones.
    pub(super) fn with_buffer(self) -> Self {
        let with = Self { voltages: [2.4, 3.0, 4.5], action: 15e-6, every: 2, ..self };
        Self { reserve: 0.3 * with.room(), ..with }
    }

    /// On a battery beside the capacitor, a third of which is the reserve.
    pub(super) fn with_battery(self, battery: Battery) -> Self {
        let lockout = battery.lockout.expect("a test reads the file");
        let voltages = [lockout.turn_off_v, lockout.turn_on_v, battery.highest_v];
        let with = Self { battery: Some(battery), voltages, ..self };
        Self { reserve: 0.3 * with.room(), ..with }
    }

    /// What holds the energy, with so many times the stated capacitance and charge, in the energies of the harvester as it is.
    pub(super) fn reservoir(&self, factor: f64) -> Reservoir {
        let small = |number: f64| f64::from(number as f32);
        Reservoir {
            capacitance_f: factor * small(self.capacitance / self.scale),
            leakage_ohm: small(self.leakage * self.scale),
            battery: self.battery.map(|battery| battery.scaled(factor / self.scale)),
        }
    }

    /// For a harvester that gives these energies in J, minute by minute.
    pub fn scaled(self, minutes: &[f64]) -> Self {
        Self { scale: self.income / (minutes.iter().sum::<f64>() / (60.0 * minutes.len() as f64)), ..self }
    }

    fn cost(&self) -> CostModel {
        let sensor = if self.rate() > 100.0 { "bma400" } else { "adxl367" };
        CostModel::new(self.processor, Accelerometer::named(sensor).expect("a part"))
    }

    /// Samples of a burst in a second.
    pub(super) fn rate(&self) -> f64 {
        self.kind.rate()
    }

    /// What the node by the voltage alone knows, in the energies of the harvester as it is.
    pub(super) fn parameters(&self) -> VoltageParameters<1> {
        let small = |energy: f64| (energy / self.scale) as f32;
        let shortest = if self.every < 40 { self.every } else { 60 };
        let reading = self.cost().reading(node_instructions(self.processor.core).reading);
        let [lock_out_voltage, turn_on_voltage, highest_voltage] =
            self.voltages.map(|voltage| voltage as f32);
        VoltageParameters {
            storage: StorageParameters {
                capacitor: Capacitor {
                    capacitance: small(self.capacitance),
                    leakage_resistance: (self.leakage * self.scale) as f32,
                },
                charging_efficiency: 1.0,
                discharging_efficiency: 1.0,
                highest_voltage,
                lock_out_voltage,
                turn_on_voltage,
            },
            converter: Converter { bits: 12, full_scale: 5.0, noise: CONVERTER_NOISE as f32 },
            standing_power: small(self.standing),
            reading: small(reading),
            // A burst is taken after a reading.
            intervals: [shortest, if self.battery.is_some() { 60 } else { 300 }],
            tolerances: Tolerances {
                standing: self.spread as f32,
                action: self.of_action as f32,
                capacitance: self.of_capacitance as f32,
                leakage: if self.leakage.is_finite() || self.battery.is_some() {
                    LEAKAGE_TOLERANCE
                } else {
                    0.0
                },
                highest_voltage: self.of_highest as f32,
                ..Tolerances::EXACT
            },
            largest_power: small(10.0 * self.income),
            reserve: small(self.reserve),
            actions: [Regular { energy: small(self.action), every: self.every }],
        }
    }

    /// The node of the voltage alone. Panics outside the bounds of a node.
    pub(super) fn voltage(&self) -> Tiered<VoltageNode<1>> {
        by_voltage(self.parameters().build().unwrap_or_else(|error| panic!("{error}")))
    }

    /// The same on a battery. Panics outside the bounds of a node.
    pub(super) fn voltage_on(&self, battery: Battery) -> Tiered<VoltageNode<1, BatteryElement>> {
        let node = self.parameters().build_with_battery(self.stated(battery));
        by_voltage(node.unwrap_or_else(|error| panic!("{error}")))
    }

    fn stated(&self, battery: Battery) -> model_core::energy::Battery {
        let tolerance = self.of_capacitance as f32;
        model_core::energy::Battery { tolerance, ..battery.scaled(1.0 / self.scale).of_core() }
    }

    /// The node with the map of the harvester. Panics outside the bounds of a node.
    pub fn map(&self) -> Tiered<OneNode> {
        self.try_map().unwrap_or_else(|error| panic!("{error}"))
    }

    /// The same, or why the settings are outside the bounds of a node.
    pub(super) fn try_map(&self) -> Result<Tiered<OneNode>, String> {
        self.map_node(self.kind.map(), MapNode::new)
    }

    /// The same on a battery. Panics outside the bounds of a node.
    pub(super) fn map_on(&self, battery: Battery) -> Tiered<MapOn<BatteryElement>> {
        let battery = self.stated(battery);
        let node =
            self.map_node(self.kind.map(), |map, bank, with| MapNode::with_battery(map, bank, with, battery));
        node.unwrap_or_else(|error| panic!("{error}"))
    }

    fn map_node<E: Element>(
        &self,
        map: &'static [u8],
        build: impl FnOnce(
            ResponseMap<&'static [u8]>,
            LineBank<20, 32>,
            MapParameters<1>,
        ) -> Result<MapOn<E>, NodeError>,
    ) -> Result<Tiered<MapOn<E>>, String> {
        let fail = |error: &dyn std::fmt::Debug| format!("{error:?}");
        let fingerprint = u32::from_le_bytes([map[6], map[7], map[8], map[9]]);
        let map = ResponseMap::new(map, fingerprint).map_err(|error| fail(&error))?;
        let [resonance, half] = self.kind.resonance();
        let rate = self.rate();
        let bank = LineBank::new(rate as f32, resonance as f32, half as f32, UNIT as f32);
        let bank = bank.map_err(|error| fail(&error))?;
        let cost = self.cost();
        let Instructions { sample, block, .. } = node_instructions(self.processor.core);
        let samples = bank.block() as u32 * BLOCKS;
        let instructions = f64::from(samples) * sample + f64::from(BLOCKS) * block;
        let energy = cost.burst(samples, rate, instructions, Code::Filter).ok_or("no rate")?.total();
        let parameters = MapParameters {
            voltage: self.parameters(),
            sensor: Sensor {
                rate: rate as f32,
                start_up: cost.accelerometer.start_up_samples,
                blocks: BLOCKS,
                clipped: 32_000,
            },
            bursts: Bursts {
                energy: (energy / self.scale) as f32,
                worth: 10.0,
                shortest: 60,
                check: self.check,
            },
            gain: self.gain as f32,
            gain_drift: 0.02,
        };
        let node = build(map, bank, parameters).map_err(|error| error.to_string())?;
        Ok(Tiered::new(node, OneState::last_hour, MapOn::<E>::overall, |node, state| {
            node.spent_on_estimation(state).into()
        }))
    }
}

fn by_voltage<E: Element>(node: VoltageNode<1, E>) -> Tiered<VoltageNode<1, E>> {
    Tiered::new(node, VoltageState::last_hour, VoltageNode::<1, E>::overall, |node, state| {
        f64::from(state.readings()) * f64::from(node.parameters().reading)
    })
}

/// Relative 1σ of a leakage.
const LEAKAGE_TOLERANCE: f32 = 0.3;
