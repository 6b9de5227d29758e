//! Parts between a harvester and its node, and of the node, as data: `market/parts.toml`. A firmware gets numbers.

mod battery;
pub mod cost;

use std::sync::LazyLock;

use serde::{Deserialize, Deserializer};

pub use battery::Reservoir;
pub use cost::{Code, Core, Cost, CostModel, Instructions, node_instructions};

/// How far a figure is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Evidence {
    /// Read in the source.
    Confirmed,
    /// Read in a text that quotes the source.
    Secondary,
    /// Remembered from the source, not read again.
    Unconfirmed,
    /// Estimated by the authors of this library; there is no source.
    Estimated,
}

/// A figure of a part: its value in the unit of the field, how far it is known, and the document or the assumption.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Figure(pub f64, pub Evidence, #[serde(deserialize_with = "text")] pub Text);

/// A text of the file. Under this name `serde` does not borrow it.
type Text = &'static str;

/// Kinds of parts, each with the list of all.
macro_rules! parts {
    ($($(#[$meta:meta])* $kind:ident = $list:ident { $($(#[$of_field:meta])* $field:ident: $type:ty,)* })*) => {
        $(
            $(#[$meta])*
            #[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
            #[serde(deny_unknown_fields)]
            pub struct $kind {
                /// Its word in a scene file.
                #[serde(deserialize_with = "text")]
                pub word: Text,
                $($(#[$of_field])* pub $field: $type,)*
            }

            impl $kind {
                /// All, in the order of the file.
                pub fn all() -> &'static [Self] {
                    &MARKET.$list
                }

                /// The part with this word.
                pub fn named(word: &str) -> Option<Self> {
                    Self::all().iter().find(|part| part.word == word).copied()
                }

                pub fn words() -> Vec<&'static str> {
                    Self::all().iter().map(|part| part.word).collect()
                }
            }
        )*

        #[derive(Debug, Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Market {
            bus_per_bit_j: Figure,
            adc: Adc,
            cold_start: ColdStart,
            $($list: Vec<$kind>,)*
        }
    };
}

parts! {
    /// A processor.
    Processor = processor {
        /// Name of the part.
        #[serde(deserialize_with = "text")]
        name: Text,
        /// Its core.
        core: Core,
        /// Supply voltage of the figures in V.
        supply_v: f64,
        /// Energy of a clock cycle while it runs from flash, in J.
        energy_per_cycle_j: Figure,
        /// Clock while it runs, in Hz.
        clock_hz: Figure,
        /// Time from an interrupt asleep to the first instruction, in s.
        wake_up_s: Figure,
        /// Current asleep with RAM retained and the real-time clock running, in A. `None`: no figure is known.
        sleep_a: Option<Figure>,
    }
    /// An external real-time clock. It keeps the time while the rest of a node has no supply.
    Clock = clock {
        /// Name of the part and its oscillator.
        #[serde(deserialize_with = "text")]
        name: Text,
        /// Supply voltage of the figure in V.
        supply_v: f64,
        /// Supply current in A.
        current_a: Figure,
    }
    /// An accelerometer.
    Accelerometer = accelerometer {
        /// Name of the part.
        #[serde(deserialize_with = "text")]
        name: Text,
        /// Supply voltage in V.
        supply_v: f64,
        /// The lowest and the highest known sample rate in Hz.
        rates_hz: [f64; 2],
        /// Supply current in A at the lowest.
        slow_current_a: Figure,
        /// Supply current in A at the highest.
        fast_current_a: Figure,
        /// Samples from switching on to the first valid one.
        start_up_samples: u32,
        /// Samples of all stored axes that the FIFO holds.
        fifo_samples: u32,
        /// Bits to transfer for each sample of all stored axes.
        bits_per_sample: u32,
    }
    /// A radio at one rate and power.
    ///
    /// A packet of `n` bytes takes `t_r + t_o + 8 n/R`: the ramp-up, the overhead and the bits at the rate `R`. In all of it
    /// the radio draws the current of transmission, which is an upper bound for the ramp-up. Reception is not included.
    Radio = radio {
        /// Name of the part, its modulation and power.
        #[serde(deserialize_with = "text")]
        name: Text,
        /// Supply voltage of the figures in V.
        supply_v: f64,
        /// Supply current while it transmits, in A.
        transmitting_a: Figure,
        /// Time from off to the first bit in s: its oscillator and its synthesizer.
        ramp_up_s: Figure,
        /// Time in s of what a packet has beside its payload.
        overhead_s: Figure,
        /// Bits of the payload in a second, error correction deducted.
        bit_rate_hz: Figure,
        /// Most bytes of a payload.
        most_bytes: u32,
    }
    /// A battery, with a capacitor beside it.
    Battery = battery {
        /// Name of the part.
        #[serde(deserialize_with = "text")]
        name: Text,
        /// State of charge and open-circuit voltage in V, both rising.
        #[serde(deserialize_with = "curve")]
        open_circuit: &'static [[f32; 2]],
        /// Open-circuit voltage in V of a half charge, with the source of all points.
        half_v: Figure,
        /// Charge from the first to the last point in C.
        charge_c: Figure,
        /// Internal resistance in Ω.
        resistance_ohm: Figure,
        /// Part of the charge into the battery that comes out again.
        charging_efficiency: Figure,
        /// Part of the stored energy that is lost in a second, in 1/s.
        self_discharge_per_s: Figure,
        /// Relative standard deviation of the charge.
        tolerance: Figure,
        /// The lock-out of a node on it.
        #[serde(rename = "lockout_v", deserialize_with = "lockout")]
        lockout: Option<Lockout>,
        /// Voltage in V at which further income is shunted.
        highest_v: f64,
    }
    /// A part between a harvester and a node, or a diode bridge alone.
    ///
    /// The storage behind a bridge has leakage as a resistance. A quiescent current `I_q` becomes `V_on/I_q`, which is exact
    /// at the turn-on voltage, too small below and too large above. The part takes more while the node is connected: the
    /// difference at the turn-on voltage is added to the power of the node. A converter takes `P/η` from the storage for a
    /// node that consumes `P`, with one number `η` where the data sheet has a curve. No part is switched off above its highest
    /// voltage: a trajectory beyond it is outside the model, and the energy budget counts the excess as shunted. A boost
    /// charger holds its input at its own voltage, so its harvester is connected to a bus of that voltage.
    Preset = preset {
        /// Forward voltage in V of each of the two diodes that conduct at a time.
        diode_drop_v: f64,
        /// Current in A from the storage while the node is locked out.
        #[serde(default)]
        locked_out_a: f64,
        /// Current in A from the storage while the node is connected, without the current of the node.
        #[serde(default)]
        running_a: f64,
        /// The lock-out of the node; `None` for a node that decides by itself.
        #[serde(default, rename = "lockout_v", deserialize_with = "lockout")]
        lockout: Option<Lockout>,
        /// Storage voltage in V above which the part dissipates or refuses the income; `None` without such a limit.
        highest_v: Option<f64>,
        /// Part of the rectified energy that reaches the storage.
        #[serde(default = "one")]
        charging_efficiency: f64,
        /// Part of the energy from the storage that reaches the node.
        #[serde(default = "one")]
        discharging_efficiency: f64,
        /// Rectified voltage in V below which the part does not start with an empty storage; `None` without such a limit.
        cold_start_v: Option<f64>,
    }
}

/// An analogue-to-digital converter of 12 bits in a processor.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adc {
    /// Energy of a reading in J, the start of its reference included.
    pub reading_j: Figure,
    /// Time of a reading in s.
    pub duration_s: Figure,
}

/// A start of a processor from a supply that was off.
///
/// It draws `C·U² + e·f·t`: the charge of the supply's capacitors, which lose it while the supply is off, and cycles of
/// `e` J at the clock `f` for the time `t`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColdStart {
    /// Capacitance behind the switch in F.
    pub decoupling_f: Figure,
    /// Time from the supply to the first instruction of the program in s, the state read back.
    pub time_s: Figure,
}

/// Under-voltage lock-out with hysteresis. A store that starts between the two starts disconnected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lockout {
    /// The draw is connected where the store rises to this voltage, in V.
    pub turn_on_v: f64,
    /// It is disconnected where the store falls to this voltage, in V.
    pub turn_off_v: f64,
}

static MARKET: LazyLock<Market> =
    LazyLock::new(|| toml::from_str(include_str!("market/parts.toml")).expect("a test reads the file"));

fn text<'de, D: Deserializer<'de>>(source: D) -> Result<Text, D::Error> {
    Ok(String::deserialize(source)?.leak())
}

fn lockout<'de, D: Deserializer<'de>>(source: D) -> Result<Option<Lockout>, D::Error> {
    let [turn_on_v, turn_off_v] = Deserialize::deserialize(source)?;
    Ok(Some(Lockout { turn_on_v, turn_off_v }))
}

fn curve<'de, D: Deserializer<'de>>(source: D) -> Result<&'static [[f32; 2]], D::Error> {
    Ok(Vec::deserialize(source)?.leak())
}

fn one() -> f64 {
    1.0
}

impl Preset {
    /// Resistance in Ω with the quiescent current of the locked-out part at its turn-on voltage; infinite if
    /// there is no quiescent current or no lock-out.
    pub fn leakage_ohm(&self) -> f64 {
        match self.lockout {
            Some(lockout) if self.locked_out_a > 0.0 => lockout.turn_on_v / self.locked_out_a,
            _ => f64::INFINITY,
        }
    }

    /// Power in W from the storage for a connected node that consumes `power` in W: `power` over the
    /// efficiency of the converter, and the part's own consumption above that in lock-out.
    pub(crate) fn power_at_store(&self, power: f64) -> f64 {
        let more = self.running_a - self.locked_out_a;
        let own = self.lockout.map_or(0.0, |lockout| lockout.turn_on_v * more);
        power / self.discharging_efficiency + own
    }
}

impl Accelerometer {
    /// Power at a sample rate in Hz, in W: the known currents, linear between their rates, the lower below.
    ///
    /// `None` for a rate that is not positive or above the highest known one.
    pub fn power(&self, rate: f64) -> Option<f64> {
        let ([slow, fast], Figure(least, ..), Figure(most, ..)) =
            (self.rates_hz, self.slow_current_a, self.fast_current_a);
        if !(rate > 0.0 && rate <= fast) {
            return None;
        }
        let current =
            if rate <= slow { least } else { least + (rate - slow) / (fast - slow) * (most - least) };
        Some(current * self.supply_v)
    }
}

impl Radio {
    /// Time of a packet of `bytes` in s, ramp-up included. `None` above the most bytes of a payload.
    pub(crate) fn packet_time(&self, bytes: u32) -> Option<f64> {
        (bytes <= self.most_bytes)
            .then(|| self.ramp_up_s.0 + self.overhead_s.0 + f64::from(8 * bytes) / self.bit_rate_hz.0)
    }

    /// Energy of a packet of `bytes` in J. `None` above the most bytes of a payload.
    pub fn packet(&self, bytes: u32) -> Option<f64> {
        Some(self.transmitting_a.0 * self.supply_v * self.packet_time(bytes)?)
    }
}

impl ColdStart {
    /// That of the file.
    pub fn typical() -> Self {
        MARKET.cold_start
    }

    /// Energy of a start of `processor` in J.
    pub fn energy(&self, processor: &Processor) -> f64 {
        let running = processor.energy_per_cycle_j.0 * processor.clock_hz.0;
        self.decoupling_f.0 * processor.supply_v * processor.supply_v + running * self.time_s.0
    }
}

#[cfg(test)]
mod tests;
