//! The cores, and a board with each that QEMU emulates.

use clap::ValueEnum;
use std::fmt;

/// A core that the firmware is built for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Core {
    /// Cortex-M0: no division, no floating point.
    M0,
    /// Cortex-M3: no floating point.
    M3,
    /// Cortex-M4 with single-precision floating point.
    M4f,
    /// Cortex-M7, with its single-precision instructions only.
    M7,
    /// Cortex-M33 with single-precision floating point.
    M33,
}

/// What building and running for a core takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hardware {
    /// The compiler's name for the core.
    pub target: &'static str,
    /// The board's name, in the firmware's build script and in QEMU alike.
    pub board: &'static str,
    /// Where its flash starts: the vector table is there.
    pub flash_origin: u64,
    /// Where its RAM ends, as far as the firmware uses it: the stack starts there.
    pub stack_top: u32,
    /// The frequency with which QEMU drives its SysTick.
    pub tick_hz: u32,
}

impl Hardware {
    /// With a nanosecond of virtual time for each instruction.
    #[must_use]
    pub fn instructions_per_tick(&self) -> f64 {
        1e9 / f64::from(self.tick_hz)
    }
}

impl Core {
    /// The board with this core.
    ///
    /// The addresses stand in the firmware's build script as well. Here they are what is checked:
    /// a link with another board's memory map would run on some of them all the same.
    #[must_use]
    pub const fn hardware(self) -> Hardware {
        match self {
            Self::M0 => Hardware {
                target: "thumbv6m-none-eabi",
                board: "microbit",
                flash_origin: 0,
                stack_top: 0x2000_4000,
                tick_hz: 16_000_000,
            },
            Self::M3 => Hardware {
                target: "thumbv7m-none-eabi",
                board: "stm32vldiscovery",
                flash_origin: 0x0800_0000,
                stack_top: 0x2000_2000,
                tick_hz: 24_000_000,
            },
            Self::M4f => Hardware {
                target: "thumbv7em-none-eabihf",
                board: "netduinoplus2",
                flash_origin: 0x0800_0000,
                stack_top: 0x2002_0000,
                tick_hz: 168_000_000,
            },
            Self::M7 => Hardware {
                target: "thumbv7em-none-eabihf",
                board: "mps2-an500",
                flash_origin: 0,
                stack_top: 0x2002_0000,
                tick_hz: 25_000_000,
            },
            Self::M33 => Hardware {
                target: "thumbv8m.main-none-eabihf",
                board: "mps2-an505",
                flash_origin: 0x1000_0000,
                stack_top: 0x3802_0000,
                tick_hz: 20_000_000,
            },
        }
    }
}

impl fmt::Display for Core {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::M0 => "Cortex-M0",
            Self::M3 => "Cortex-M3",
            Self::M4f => "Cortex-M4F",
            Self::M7 => "Cortex-M7",
            Self::M33 => "Cortex-M33",
        })
    }
}
