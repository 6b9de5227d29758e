//! The energy that a node spends to know its income.
//!
//! A burst switches an accelerometer on, takes samples into its FIFO, transfers and processes them, and switches it off. Its energy is
//!
//! `E = N·c·e + I·U·t + b·e_b + n·(e·f·t_w)`
//!
//! with `N` instructions of `c` cycles at `e` J, a sensor current `I` at `U` volts for the time `t` of the samples and
//! the start-up, `b` bits at `e_b` J, and `n` wake-ups of the processor, each for `t_w` at its clock `f`. The standing
//! power of the node, asleep with its clock running, is not part of a burst: [`CostModel::standing_power`]. Where an
//! external clock switches the supply off between bursts (`CostModel::gated_by`), a burst has a cold start in place of
//! its first wake-up, and the sleep of the processor while it waits for samples.

use serde::Deserialize;

use super::Evidence::{Estimated, Secondary};
use super::{Accelerometer, Adc, Clock, ColdStart, Figure, MARKET, Processor};

/// The core of a processor, as far as its cycles for each instruction differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Core {
    /// Cortex-M0 and M0+: no division, no floating point.
    M0Plus,
    /// Cortex-M4 with single-precision floating point.
    M4f,
    /// Cortex-M33 with single-precision floating point.
    M33,
}

/// A kind of code, as far as its cycles for each instruction differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// A trajectory: multiplications and additions of numbers with divisions and roots between them.
    Trajectory,
    /// A filter over samples: loads, multiplications and additions.
    Filter,
}

/// Instructions of a [`VoltageNode`](model_core::node::VoltageNode), and of the bursts of a [`MapNode`](model_core::node::MapNode).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instructions {
    /// Of a wake with a reading, and the decision after it, of a `VoltageNode`.
    pub reading: f64,
    /// Of a sample in a burst.
    pub sample: f64,
    /// Of the three parts of the evaluation of a burst of one block, and of the wake after it.
    pub block: f64,
}

/// Mean instructions under QEMU of the calls of `on-target --node`, with decisions on two actions: it fails where one is off by more than
/// 5 %. Those of the M0 are with the arithmetic of `firmware-example`.
pub const fn node_instructions(core: Core) -> Instructions {
    match core {
        Core::M0Plus => Instructions { reading: 4_610.0, sample: 38.3, block: 31_400.0 },
        Core::M4f | Core::M33 => Instructions { reading: 419.0, sample: 21.3, block: 7_500.0 },
    }
}

impl Processor {
    /// Energy of `instructions` of the kind `code` in J.
    pub fn computing(&self, instructions: f64, code: Code) -> f64 {
        instructions * self.cycles_per_instruction(code).0 * self.energy_per_cycle_j.0
    }

    /// Time of `instructions` of the kind `code` in s.
    pub(crate) fn computing_time(&self, instructions: f64, code: Code) -> f64 {
        instructions * self.cycles_per_instruction(code).0 / self.clock_hz.0
    }

    /// Energy of a wake-up in J: the processor draws the current of running code for the time of a wake-up.
    pub(crate) fn wake_up_energy(&self) -> f64 {
        self.energy_per_cycle_j.0 * self.clock_hz.0 * self.wake_up_s.0
    }

    /// Mean cycles of an instruction of the kind `code`, without wait states of the flash.
    ///
    /// From instruction traces under QEMU, weighed with the documented cycles of each instruction (ARM DDI 0439,
    /// DDI 0484). On the M4F, divisions and roots are 2.5 % of the instructions of a trajectory and 20 % of its cycles.
    pub fn cycles_per_instruction(&self, code: Code) -> Figure {
        let cycles = if code == Code::Trajectory && self.core != Core::M0Plus { 1.8 } else { 1.5 };
        match self.core {
            Core::M33 => Figure(cycles, Estimated, "as the M4F"),
            _ => {
                Figure(cycles, Secondary, "instruction traces weighed with documented cycles, no wait states")
            }
        }
    }

    /// Power asleep in W; `None` where it is not known.
    fn sleeping(&self) -> Option<f64> {
        self.sleep_a.map(|current| current.0 * self.supply_v)
    }
}

/// The parts of a node that an estimate of the income uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CostModel {
    pub processor: Processor,
    /// The accelerometer. Between bursts it takes nothing: a standby current belongs to the node's standing power.
    pub accelerometer: Accelerometer,
    /// Energy of a bit on the bus between them, in J, without instructions of the processor.
    pub transfer_per_bit: Figure,
    /// The converter that reads the voltage of the storage.
    pub adc: Adc,
    /// The external clock that switches the supply of all else between wake-ups and keeps the state of the node, and the
    /// start from it. `None`: the processor sleeps with RAM and its own clock.
    pub gate: Option<(Clock, ColdStart)>,
}

impl CostModel {
    /// `processor` and `accelerometer` with the bus and the ADC of the file of parts.
    pub fn new(processor: Processor, accelerometer: Accelerometer) -> Self {
        Self { processor, accelerometer, transfer_per_bit: MARKET.bus_per_bit_j, adc: MARKET.adc, gate: None }
    }

    /// The same parts behind a supply that `clock` switches, with the cold start [`ColdStart::typical`].
    pub(crate) fn gated_by(self, clock: Clock) -> Self {
        Self { gate: Some((clock, ColdStart::typical())), ..self }
    }

    /// Power between wake-ups in W: of the sleeping processor with its clock running, or of the external clock. `None`
    /// where the processor's figure is unknown. The leakage of the switch of a gated supply is not known and not in it.
    pub fn standing_power(&self) -> Option<f64> {
        match &self.gate {
            None => self.processor.sleeping(),
            Some((clock, _)) => Some(clock.current_a.0 * clock.supply_v),
        }
    }

    /// Energy in J from the sleep of the node to the first instruction of its program.
    pub fn start_energy(&self) -> f64 {
        match &self.gate {
            None => self.processor.wake_up_energy(),
            Some((_, start)) => start.energy(&self.processor),
        }
    }

    /// Energy in J of a wake-up with a reading of the store's voltage and `instructions` of a filter.
    pub fn reading(&self, instructions: f64) -> f64 {
        self.adc.reading_j.0 + self.start_energy() + self.processor.computing(instructions, Code::Filter)
    }

    /// Energy of a burst of `samples` at `rate` in Hz that executes `instructions` of the kind `code`.
    ///
    /// The accelerometer runs for the samples and for its start-up. The processor wakes up once for each filling of
    /// the FIFO, and sleeps in between. `None` above the highest known rate of the accelerometer, or where the sleep of a
    /// processor with a gated supply is unknown.
    pub fn burst(&self, samples: u32, rate: f64, instructions: f64, code: Code) -> Option<Cost> {
        let Self { processor, accelerometer, .. } = self;
        let running = self.burst_time(samples, rate);
        let bits = f64::from(samples) * f64::from(accelerometer.bits_per_sample);
        let fillings = f64::from(samples.div_ceil(accelerometer.fifo_samples.max(1)));
        let cost = Cost {
            computing: processor.computing(instructions, code),
            sensor: accelerometer.power(rate)? * running,
            transfer: bits * self.transfer_per_bit.0,
            wake_up: fillings * processor.wake_up_energy(),
            waiting: 0.0,
        };
        if self.gate.is_none() {
            return Some(cost);
        }
        Some(Cost {
            wake_up: cost.wake_up - self.processor.wake_up_energy() + self.start_energy(),
            waiting: self.processor.sleeping()? * running,
            ..cost
        })
    }

    /// Time of such a burst in s, without that of its instructions.
    pub(crate) fn burst_time(&self, samples: u32, rate: f64) -> f64 {
        f64::from(samples.saturating_add(self.accelerometer.start_up_samples)) / rate
    }
}

/// The energy of a burst by its parts, in J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Instructions of the processor.
    pub computing: f64,
    /// The accelerometer.
    pub sensor: f64,
    /// The bus between accelerometer and processor.
    pub transfer: f64,
    /// Wake-ups of the processor, a cold start included.
    pub wake_up: f64,
    /// The sleep of a processor with a gated supply while it waits for samples.
    pub waiting: f64,
}

impl Cost {
    /// The sum, in J.
    pub fn total(&self) -> f64 {
        self.computing + self.sensor + self.transfer + self.wake_up + self.waiting
    }
}
