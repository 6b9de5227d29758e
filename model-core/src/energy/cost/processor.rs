//! Energy of a processor's cycles, wake-ups and sleep.

use super::Evidence::{Confirmed, Estimated, Secondary, Unconfirmed};
use super::Figure;
use crate::scalar::Scalar;

/// The core of a processor, as far as its cycles for each instruction differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Core {
    /// Cortex-M0 and M0+: no division, no floating point.
    M0Plus,
    /// Cortex-M4 with single-precision floating point.
    M4F,
    /// Cortex-M33 with single-precision floating point.
    M33,
}

/// A kind of code, as far as its cycles for each instruction differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Code {
    /// A trajectory: multiplications and additions of numbers with divisions and roots between them.
    Trajectory,
    /// A filter over samples: loads, multiplications and additions.
    Filter,
}

/// A processor as data: energy of a cycle, clock, wake-up, sleep.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Processor<S> {
    /// Name of the part.
    pub name: &'static str,
    /// Its core.
    pub core: Core,
    /// Supply voltage of the figures in V.
    pub supply: S,
    /// Energy of a clock cycle while running from flash, in J.
    pub energy_per_cycle: Figure<S>,
    /// Clock while running, in Hz.
    pub clock: Figure<S>,
    /// Time from an interrupt in the sleep of `sleep` to the first instruction, in s.
    pub wake_up: Figure<S>,
    /// Current asleep with RAM retained and the real-time clock running, in A. `None`: no figure is known.
    pub sleep: Option<Figure<S>>,
}

impl<S: Scalar> Processor<S> {
    /// Energy of `instructions` of the kind `code` in J.
    #[must_use]
    pub fn computing(&self, instructions: S, code: Code) -> S {
        instructions * self.cycles_per_instruction(code).value * self.energy_per_cycle.value
    }

    /// Energy of a wake-up in J: the processor draws the current of running code for the time of a wake-up.
    #[must_use]
    pub fn wake_up_energy(&self) -> S {
        self.energy_per_cycle.value * self.clock.value * self.wake_up.value
    }

    /// Mean cycles of an instruction of the kind `code`, without wait states of the flash.
    ///
    /// From instruction traces under QEMU, weighed with the documented cycles of each instruction (ARM DDI 0439,
    /// DDI 0484). On the M4F, divisions and roots are 2.5 % of the instructions of a trajectory and 20 % of its cycles.
    #[must_use]
    pub fn cycles_per_instruction(&self, code: Code) -> Figure<S> {
        let traces = "instruction traces weighed with documented cycles, no wait states";
        match (self.core, code) {
            (Core::M4F, Code::Trajectory) => Figure::new(1.8, Secondary, traces),
            (Core::M4F | Core::M0Plus, _) => Figure::new(1.5, Secondary, traces),
            (Core::M33, Code::Trajectory) => Figure::new(1.8, Estimated, "as the M4F"),
            (Core::M33, Code::Filter) => Figure::new(1.5, Estimated, "as the M4F"),
        }
    }

    /// All processors.
    #[must_use]
    pub fn all() -> [Self; 9] {
        [
            Self::nrf52832(),
            Self::nrf52840(),
            Self::apollo3(),
            Self::nrf54l15(),
            Self::efr32xg22(),
            Self::stm32l051(),
            Self::sam_l21(),
            Self::sam_d21(),
            Self::cc2340(),
        ]
    }

    /// Nordic nRF52832.
    #[must_use]
    pub fn nrf52832() -> Self {
        let specification = "nRF52832 product specification";
        Self {
            name: "nRF52832",
            core: Core::M4F,
            supply: S::from_f64(3.0),
            energy_per_cycle: Figure::new(174e-12, Unconfirmed, specification),
            clock: Figure::new(64e6, Unconfirmed, specification),
            wake_up: Figure::new(3e-6, Unconfirmed, specification),
            sleep: Some(Figure::new(1.9e-6, Unconfirmed, specification)),
        }
    }

    /// Nordic nRF52840.
    #[must_use]
    pub fn nrf52840() -> Self {
        let specification = "nRF52840 product specification";
        Self {
            name: "nRF52840",
            core: Core::M4F,
            supply: S::from_f64(3.0),
            energy_per_cycle: Figure::new(156e-12, Confirmed, "Nordic, comparison of nRF52 and nRF54L"),
            clock: Figure::new(64e6, Unconfirmed, specification),
            wake_up: Figure::new(3e-6, Unconfirmed, specification),
            sleep: Some(Figure::new(1.5e-6, Unconfirmed, specification)),
        }
    }

    /// Ambiq Apollo3. The energy of a cycle is the upper end of 20 to 34 pJ.
    #[must_use]
    pub fn apollo3() -> Self {
        let quoted = "Apollo3 data sheet, as quoted";
        Self {
            name: "Apollo3",
            core: Core::M4F,
            supply: S::from_f64(3.3),
            energy_per_cycle: Figure::new(34e-12, Secondary, quoted),
            clock: Figure::new(48e6, Secondary, quoted),
            wake_up: Figure::new(20e-6, Estimated, "no source"),
            sleep: Some(Figure::new(2.5e-6, Secondary, quoted)),
        }
    }

    /// Nordic nRF54L15.
    #[must_use]
    pub fn nrf54l15() -> Self {
        let comparison = "Nordic, comparison of nRF52 and nRF54L";
        Self {
            name: "nRF54L15",
            core: Core::M33,
            supply: S::from_f64(3.0),
            energy_per_cycle: Figure::new(61e-12, Confirmed, comparison),
            clock: Figure::new(128e6, Confirmed, comparison),
            wake_up: Figure::new(5e-6, Estimated, "no source"),
            sleep: Some(Figure::new(1.5e-6, Confirmed, comparison)),
        }
    }

    /// Silicon Labs EFR32xG22.
    #[must_use]
    pub fn efr32xg22() -> Self {
        let sheet = "EFR32xG22 data sheet";
        Self {
            name: "EFR32xG22",
            core: Core::M33,
            supply: S::from_f64(3.0),
            energy_per_cycle: Figure::new(81e-12, Unconfirmed, sheet),
            clock: Figure::new(76.8e6, Unconfirmed, sheet),
            wake_up: Figure::new(10e-6, Estimated, "no source"),
            sleep: Some(Figure::new(1.40e-6, Confirmed, sheet)),
        }
    }

    /// ST STM32L051.
    #[must_use]
    pub fn stm32l051() -> Self {
        let sheet = "STM32L051 data sheet DocID025938, features";
        Self {
            name: "STM32L051",
            core: Core::M0Plus,
            supply: S::from_f64(3.0),
            energy_per_cycle: Figure::new(264e-12, Confirmed, sheet),
            clock: Figure::new(32e6, Confirmed, sheet),
            wake_up: Figure::new(5e-6, Unconfirmed, sheet),
            sleep: Some(Figure::new(0.8e-6, Confirmed, sheet)),
        }
    }

    /// Microchip SAM L21. The supply voltage of its figures is estimated.
    #[must_use]
    pub fn sam_l21() -> Self {
        let note = "Atmel, application note on SAM L21, 2015";
        Self {
            name: "SAM L21",
            core: Core::M0Plus,
            supply: S::from_f64(3.3),
            energy_per_cycle: Figure::new(116e-12, Confirmed, note),
            clock: Figure::new(12e6, Unconfirmed, note),
            wake_up: Figure::new(5e-6, Estimated, "no source"),
            sleep: Some(Figure::new(0.94e-6, Confirmed, note)),
        }
    }

    /// Microchip SAM D21.
    #[must_use]
    pub fn sam_d21() -> Self {
        Self {
            name: "SAM D21",
            core: Core::M0Plus,
            supply: S::from_f64(3.3),
            energy_per_cycle: Figure::new(232e-12, Confirmed, "SAM D21 data sheet, 37.7"),
            clock: Figure::new(48e6, Unconfirmed, "SAM D21 data sheet"),
            wake_up: Figure::new(5e-6, Estimated, "no source"),
            sleep: None,
        }
    }

    /// Texas Instruments CC2340.
    #[must_use]
    pub fn cc2340() -> Self {
        let sheet = "CC2340R5 data sheet SWRS282";
        Self {
            name: "CC2340",
            core: Core::M0Plus,
            supply: S::from_f64(3.0),
            energy_per_cycle: Figure::new(159e-12, Confirmed, sheet),
            clock: Figure::new(48e6, Confirmed, sheet),
            wake_up: Figure::new(15e-6, Estimated, "no source"),
            sleep: Some(Figure::new(0.71e-6, Confirmed, sheet)),
        }
    }
}
