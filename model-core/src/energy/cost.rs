//! The energy that a node spends to know its income.
//!
//! A listen switches an accelerometer on, takes samples into its FIFO, transfers and processes them, and switches it
//! off. Its energy is
//!
//! `E = N·c·e + I·U·t + b·e_b + n·(e·f·t_w)`
//!
//! with `N` instructions of `c` cycles at `e` J, a sensor current `I` at `U` volts for the time `t` of the samples and
//! the start-up, `b` bits at `e_b` J, and `n` wake-ups of the processor, each for `t_w` at its clock `f`. The standing
//! power of the node, asleep with its clock running, is not part of a listen: [`CostModel::standing_power`]. Where an
//! external clock switches the supply off between listens ([`CostModel::gated_by`]), a listen has a cold start in place of
//! its first wake-up, and the sleep of the processor while it waits for samples.
//!
//! The figures of the parts are data with a source and a mark ([`Evidence`]). Check a figure that is not marked
//! [`Evidence::Confirmed`] against the data sheet before you rely on it.

mod accelerometer;
mod adc;
mod asleep;
mod clock;
mod instructions;
mod processor;
mod radio;

pub use accelerometer::{Accelerometer, RatedCurrent};
pub use adc::Adc;
pub use asleep::{Asleep, ColdStart};
pub use clock::Clock;
pub use instructions::{Instructions, node_instructions};
pub use processor::{Code, Core, Processor};
pub use radio::Radio;

use crate::scalar::Scalar;

/// How far a figure is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

/// A figure of a part, its source and how far it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Figure<S> {
    /// The value in the unit of the field.
    pub value: S,
    /// The document, or the assumption.
    pub source: &'static str,
    /// How far the value is known.
    pub evidence: Evidence,
}

impl<S: Scalar> Figure<S> {
    #[inline(always)] // the compiler converts the figure, not firmware in double precision
    fn new(value: f64, evidence: Evidence, source: &'static str) -> Self {
        Self { value: S::from_f64(value), source, evidence }
    }
}

/// The parts of a node that an estimate of the income uses.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CostModel<S> {
    /// The processor.
    pub processor: Processor<S>,
    /// The accelerometer. Its supply is switched off between listens.
    pub accelerometer: Accelerometer<S>,
    /// Energy of a bit on the bus between them, in J, without instructions of the processor.
    pub transfer_per_bit: Figure<S>,
    /// Energy of a reading of the store's voltage by the ADC, in J.
    pub voltage_reading: Figure<S>,
    /// What has a supply between wake-ups.
    pub asleep: Asleep<S>,
}

impl<S: Scalar> CostModel<S> {
    /// `processor` and `accelerometer` with estimated energies of the bus and the ADC: 0.5 nJ a bit (30 pF at 3 V,
    /// one edge a bit on each of two lines) and 0.15 µJ a reading.
    #[must_use]
    pub fn new(processor: Processor<S>, accelerometer: Accelerometer<S>) -> Self {
        Self {
            processor,
            accelerometer,
            transfer_per_bit: Figure::new(0.5e-9, Evidence::Estimated, "30 pF at 3 V, two lines"),
            voltage_reading: Adc::twelve_bits().reading,
            asleep: Asleep::Processor,
        }
    }

    /// The same parts behind a supply that `clock` switches, with the cold start [`ColdStart::typical`].
    #[must_use]
    pub fn gated_by(self, clock: Clock<S>) -> Self {
        Self { asleep: Asleep::Gated(clock, ColdStart::typical()), ..self }
    }

    /// Power between wake-ups in W: of the sleeping processor with its clock running, or of the external clock. `None`
    /// where the processor's figure is unknown. The leakage of the switch of a gated supply is not known and not in it.
    #[must_use]
    pub fn standing_power(&self) -> Option<S> {
        match &self.asleep {
            Asleep::Processor => self.sleeping(),
            Asleep::Gated(clock, _) => Some(clock.power()),
        }
    }

    /// Power of the sleeping processor in W.
    fn sleeping(&self) -> Option<S> {
        self.processor.sleep.map(|sleep| sleep.value * self.processor.supply)
    }

    /// Energy in J from the sleep of the node to the first instruction of its program.
    #[must_use]
    pub fn start_energy(&self) -> S {
        match &self.asleep {
            Asleep::Processor => self.processor.wake_up_energy(),
            Asleep::Gated(_, start) => start.energy(&self.processor),
        }
    }

    /// Energy of a listen of `samples` at `rate` in Hz that executes `instructions` of the kind `code`.
    ///
    /// The accelerometer runs for the samples and for its start-up. The processor wakes up once for each filling of
    /// the FIFO, and sleeps in between. `None` above the highest known rate of the accelerometer, or where the sleep of a
    /// processor with a gated supply is unknown.
    #[must_use]
    pub fn listen(&self, samples: u32, rate: S, instructions: S, code: Code) -> Option<Cost<S>> {
        let sensor = &self.accelerometer;
        let running = self.listen_time(samples, rate);
        let cost = Cost {
            sensor: sensor.power(rate)? * running,
            ..self.following(samples, instructions, code, sensor.fifo_samples)
        };
        Some(match &self.asleep {
            Asleep::Processor => cost,
            Asleep::Gated(..) => Cost {
                wake_up: cost.wake_up - self.processor.wake_up_energy() + self.start_energy(),
                waiting: self.sleeping()? * running,
                ..cost
            },
        })
    }

    /// Time of such a listen in s, without that of its instructions.
    #[must_use]
    pub fn listen_time(&self, samples: u32, rate: S) -> S {
        S::from_u32(samples.saturating_add(self.accelerometer.start_up_samples)) / rate
    }

    /// Energy of `samples` at `rate` in Hz of an accelerometer that always runs, with `instructions` of the kind
    /// `code` and a wake-up for each sample; the supply is never switched off. `None` above its highest known rate.
    #[must_use]
    pub fn follow(&self, samples: u32, rate: S, instructions: S, code: Code) -> Option<Cost<S>> {
        let running = S::from_u32(samples) / rate;
        Some(Cost {
            sensor: self.accelerometer.power(rate)? * running,
            ..self.following(samples, instructions, code, 1)
        })
    }

    /// Everything but the sensor, with a wake-up for each `block` of samples.
    fn following(&self, samples: u32, instructions: S, code: Code, block: u32) -> Cost<S> {
        let bits = S::from_u32(samples) * S::from_u32(self.accelerometer.bits_per_sample);
        let wake_ups = samples.div_ceil(block.max(1));
        Cost {
            computing: self.processor.computing(instructions, code),
            sensor: S::ZERO,
            transfer: bits * self.transfer_per_bit.value,
            wake_up: S::from_u32(wake_ups) * self.processor.wake_up_energy(),
            waiting: S::ZERO,
        }
    }
}

/// The energy of a listen by its parts, in J.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cost<S> {
    /// Instructions of the processor.
    pub computing: S,
    /// The accelerometer.
    pub sensor: S,
    /// The bus between accelerometer and processor.
    pub transfer: S,
    /// Wake-ups of the processor, a cold start included.
    pub wake_up: S,
    /// The sleep of a processor with a gated supply while it waits for samples.
    pub waiting: S,
}

impl<S: Scalar> Cost<S> {
    /// The sum, in J.
    #[must_use]
    pub fn total(&self) -> S {
        self.computing + self.sensor + self.transfer + self.wake_up + self.waiting
    }

    /// The sum over the energy `income` in J that is harvested from one estimate to the next. Infinite without income.
    #[must_use]
    pub fn share_of(&self, income: S) -> S {
        if income > S::ZERO { self.total() / income } else { S::INFINITY }
    }

    /// The time between estimates in s at which they cost `share` of a mean `income` in W. Infinite without income.
    #[must_use]
    pub fn interval_for(&self, share: S, income: S) -> S {
        let spendable = share * income;
        if spendable > S::ZERO { self.total() / spendable } else { S::INFINITY }
    }
}
