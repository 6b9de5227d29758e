//! What of a node has a supply between its wake-ups.

use super::Evidence::Estimated;
use super::{Clock, Figure, Processor};
use crate::scalar::Scalar;

/// What has a supply between wake-ups.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Asleep<S> {
    /// The processor in its sleep, with RAM and its own clock.
    Processor,
    /// An external clock only, which switches the supply of all else and keeps the state of the node.
    Gated(Clock<S>, ColdStart<S>),
}

/// A start of the processor from a supply that was off.
///
/// It draws `C·U² + e·f·t`: the charge of the supply's capacitors, which lose it while the supply is off, and cycles of
/// `e` J at the clock `f` for the time `t`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ColdStart<S> {
    /// Capacitance behind the switch in F.
    pub decoupling: Figure<S>,
    /// Time from the supply to the first instruction of the program in s, the state read back.
    pub time: Figure<S>,
}

impl<S: Scalar> ColdStart<S> {
    /// 1 µF behind the switch and 2 ms.
    #[must_use]
    pub fn typical() -> Self {
        Self {
            decoupling: Figure::new(1e-6, Estimated, "decoupling of a processor and a sensor"),
            time: Figure::new(2e-3, Estimated, "reset, clocks, 256 bytes of state over the bus"),
        }
    }

    /// Energy of a start of `processor` in J.
    #[must_use]
    pub fn energy(&self, processor: &Processor<S>) -> S {
        let charge = self.decoupling.value * processor.supply;
        let running = processor.energy_per_cycle.value * processor.clock.value;
        charge * processor.supply + running * self.time.value
    }
}
