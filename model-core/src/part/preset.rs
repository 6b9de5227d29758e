//! Commercial parts between a harvester and a sensor node, as data.
//!
//! All are typical values at 25 °C. The constructor of each part states its source; check the values that are
//! marked *not confirmed* against the data sheet before you rely on them.
//!
//! # Representation in the models
//!
//! * The storage behind a bridge has leakage as a resistance. A quiescent current `I_q` becomes `V_on/I_q`, the
//!   resistance with the same current at the turn-on voltage. It is exact there, too small below, too large above.
//! * The part takes more while the node is connected. The difference at the turn-on voltage is added to the
//!   constant power of the node.
//! * A converter between storage and node takes `P/η` from the storage for a node that consumes `P`. The
//!   efficiency is one number here and a curve over voltage and current in the data sheet.
//! * No part is switched off above its highest voltage: a trajectory beyond it is outside the model, and the
//!   energy budget counts the excess as shunted.
//! * A boost charger holds its *input* at its own voltage and so does not load the harvester as a storage
//!   does: its harvester is connected to a bus of that voltage. For a bridge directly into the storage its
//!   data give only the thresholds and currents.

use super::draw::{Lockout, PowerDraw};
use super::rectifier::FullBridge;
use super::storage::{Capacitor, StorageCapacitor};
use crate::scalar::Scalar;

/// A part between a harvester and a node, or a diode bridge alone. Voltages in V, currents in A, efficiencies 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Preset<S> {
    /// Name in a scene file.
    pub name: &'static str,
    /// Forward voltage of each of the two diodes that conduct at a time.
    pub diode_drop: S,
    /// Current from the storage while the node is locked out.
    pub quiescent_locked_out: S,
    /// Current from the storage while the node is connected, without the current of the node.
    pub quiescent_running: S,
    /// The lock-out of the node; `None` for a node that decides by itself.
    pub lockout: Option<Lockout<S>>,
    /// Storage voltage above which the part dissipates or refuses the income; infinite without such a limit.
    pub highest_voltage: S,
    /// Part of the rectified energy that reaches the storage.
    pub charging_efficiency: S,
    /// Part of the energy from the storage that reaches the node.
    pub discharging_efficiency: S,
    /// Rectified voltage below which the part does not start with an empty storage; `None` without such a limit.
    pub cold_start: Option<S>,
}

/// Output voltages of the LTC3588-1, chosen by two pins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BuckOutput {
    /// 1.8 V.
    V1_8,
    /// 2.5 V.
    V2_5,
    /// 3.3 V.
    V3_3,
    /// 3.6 V.
    V3_6,
}

impl<S: Scalar> Preset<S> {
    /// A bridge of four BAT54 diodes and a capacitor, with the node directly on the capacitor.
    ///
    /// At most 0.24 V at 0.1 mA: ON Semiconductor, BAT54 data sheet, electrical characteristics; *not
    /// confirmed*. The reverse current of the diodes, up to 2 µA at 25 V, is omitted.
    #[must_use]
    #[inline]
    pub fn diodes() -> Self {
        Self {
            name: "diodes",
            diode_drop: S::from_f64(0.24),
            quiescent_locked_out: S::ZERO,
            quiescent_running: S::ZERO,
            lockout: None,
            highest_voltage: S::INFINITY,
            charging_efficiency: S::ONE,
            discharging_efficiency: S::ONE,
            cold_start: None,
        }
    }

    /// Boost charger with cold start and a power-good output with hysteresis: Texas Instruments BQ25504, data
    /// sheet SLUSAH0, 7.5 *Electrical Characteristics*, behind a bridge of BAT54 diodes.
    ///
    /// * Quiescent current of VSTOR 330 nA with the charger off for under-voltage, 570 nA for over-voltage:
    ///   all revisions from 2011 to G (August 2023). The larger value is used while running.
    /// * Cold start at 600 mV (revision G); 330 mV up to revision C (June 2015).
    /// * Resistors set the thresholds. Those of the solar application, for two NiMH cells: power-good from
    ///   2.80 V rising to 2.44 V falling, charging up to 3.15 V, as quoted in designs that use them.
    /// * Charging efficiency 0.80 for some tens of microwatts at 0.5 to 1 V, read from the efficiency curves;
    ///   *not confirmed*. The storage feeds the node directly.
    #[must_use]
    #[inline]
    pub fn bq25504() -> Self {
        Self {
            name: "bq25504",
            diode_drop: S::from_f64(0.24),
            quiescent_locked_out: S::from_f64(330e-9),
            quiescent_running: S::from_f64(570e-9),
            lockout: Some(Lockout { turn_on: S::from_f64(2.80), turn_off: S::from_f64(2.44) }),
            highest_voltage: S::from_f64(3.15),
            charging_efficiency: S::from_f64(0.80),
            discharging_efficiency: S::ONE,
            cold_start: Some(S::from_f64(0.6)),
        }
    }

    /// Piezo supply with bridge, under-voltage lock-out and buck converter: Linear Technology (Analog
    /// Devices) LTC3588-1, by its data sheet, with the capacitor at its input as the storage.
    ///
    /// * Input current 450 nA in lock-out, 950 nA in regulation without load; shunt at 20 V, up to 25 mA:
    ///   first page, from copies of it.
    /// * Lock-out rising/falling: 4.04/2.87 V for 1.8 V and 2.5 V out, 5.05/3.67 V for 3.3 V, 5.05/4.02 V for
    ///   3.6 V: *Electrical Characteristics*, typical; *not confirmed*.
    /// * Bridge: 400 mV at 10 µA over both diodes: *Electrical Characteristics*; *not confirmed*.
    /// * Efficiency of the buck 0.85, between 10 µA and 10 mA out, read from the curves; *not confirmed*.
    #[must_use]
    #[inline]
    pub fn ltc3588_1(output: BuckOutput) -> Self {
        let (name, turn_on, turn_off) = match output {
            BuckOutput::V1_8 => ("ltc3588-1-1v8", S::from_f64(4.04), S::from_f64(2.87)),
            BuckOutput::V2_5 => ("ltc3588-1-2v5", S::from_f64(4.04), S::from_f64(2.87)),
            BuckOutput::V3_3 => ("ltc3588-1-3v3", S::from_f64(5.05), S::from_f64(3.67)),
            BuckOutput::V3_6 => ("ltc3588-1-3v6", S::from_f64(5.05), S::from_f64(4.02)),
        };
        Self {
            name,
            diode_drop: S::from_f64(0.2),
            quiescent_locked_out: S::from_f64(450e-9),
            quiescent_running: S::from_f64(950e-9),
            lockout: Some(Lockout { turn_on, turn_off }),
            highest_voltage: S::from_f64(20.0),
            charging_efficiency: S::ONE,
            discharging_efficiency: S::from_f64(0.85),
            cold_start: None,
        }
    }

    /// The LTC3588-1 for sources of high voltage, with 3.45 to 5 V out: Linear Technology (Analog Devices)
    /// LTC3588-2, by its data sheet.
    ///
    /// * Lock-out rising/falling 16/14 V; input current 830 nA in lock-out at 12 V, 1500 nA in regulation at 18 V;
    ///   shunt at 20 V: first page, from copies of it. The falling threshold is its lowest input voltage.
    /// * Bridge and efficiency as the LTC3588-1; *not confirmed*.
    #[must_use]
    #[inline]
    pub fn ltc3588_2() -> Self {
        Self {
            name: "ltc3588-2",
            quiescent_locked_out: S::from_f64(830e-9),
            quiescent_running: S::from_f64(1500e-9),
            lockout: Some(Lockout { turn_on: S::from_f64(16.0), turn_off: S::from_f64(14.0) }),
            ..Self::ltc3588_1(BuckOutput::V3_3)
        }
    }

    /// All presets.
    #[must_use]
    pub fn all() -> [Self; 7] {
        [
            Self::diodes(),
            Self::bq25504(),
            Self::ltc3588_1(BuckOutput::V1_8),
            Self::ltc3588_1(BuckOutput::V2_5),
            Self::ltc3588_1(BuckOutput::V3_3),
            Self::ltc3588_1(BuckOutput::V3_6),
            Self::ltc3588_2(),
        ]
    }

    /// Resistance in Ω with the quiescent current of the locked-out part at its turn-on voltage; infinite if
    /// there is no quiescent current or no lock-out.
    #[must_use]
    pub fn leakage_resistance(&self) -> S {
        match self.lockout {
            Some(lockout) if self.quiescent_locked_out > S::ZERO => {
                lockout.turn_on / self.quiescent_locked_out
            }
            _ => S::INFINITY,
        }
    }

    /// Power in W from the storage for a connected node that consumes `power` in W: `power` over the
    /// efficiency of the converter, and the part's own consumption above that in lock-out.
    #[must_use]
    pub fn power_at_store(&self, power: S) -> S {
        let more = self.quiescent_running - self.quiescent_locked_out;
        let own = self.lockout.map_or(S::ZERO, |lockout| lockout.turn_on * more);
        power / self.discharging_efficiency + own
    }

    /// The part's bridge into a storage of `capacitance` in F at `initial_voltage` in V, with `draw` at the storage.
    #[must_use]
    pub fn bridge<D>(
        &self,
        capacitance: S,
        initial_voltage: S,
        draw: D,
    ) -> FullBridge<S, StorageCapacitor<S, D>> {
        let storage = StorageCapacitor {
            capacitor: Capacitor { capacitance, leakage_resistance: self.leakage_resistance() },
            initial_voltage,
            draw,
        };
        FullBridge { diode_drop: self.diode_drop, storage }
    }

    /// The draw from the storage of a node that consumes `power` in W; `None` for a part without lock-out.
    #[must_use]
    pub fn node(&self, power: S) -> Option<PowerDraw<S>> {
        self.lockout.map(|lockout| PowerDraw { power: self.power_at_store(power), lockout })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::draw::{Draw, NoDraw};
    use crate::part::storage::StorageElement;

    #[test]
    fn each_has_a_name_of_its_own_and_makes_a_load_within_bounds() {
        for preset in Preset::<f32>::all() {
            assert_eq!(Preset::<f32>::all().iter().filter(|other| other.name == preset.name).count(), 1);
            assert_eq!(preset.bridge(1e-4, 0.0, NoDraw).check(), Ok(()), "{}", preset.name);
            if let Some(draw) = preset.node(1e-5) {
                assert_eq!(preset.bridge(1e-4, 0.0, draw).check(), Ok(()), "{}", preset.name);
                let Some(lockout) = Draw::lockout(&draw) else { panic!("{} has a lock-out", preset.name) };
                assert!(lockout.turn_on < preset.highest_voltage, "{}", preset.name);
            }
            assert!(preset.quiescent_running >= preset.quiescent_locked_out);
        }
    }

    #[test]
    fn quiescent_currents_are_the_parts_own_at_the_turn_on_voltage() {
        for preset in Preset::<f64>::all() {
            let Some(lockout) = preset.lockout else { continue };
            let Some(idle) = preset.node(0.0) else { continue };
            let storage = preset.bridge(1e-4, 0.0, idle).storage;
            let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{}: {a} {b}", preset.name);
            close(storage.outflow(lockout.turn_on, false), preset.quiescent_locked_out);
            close(storage.outflow(lockout.turn_on, true), preset.quiescent_running);
        }
        assert_eq!(Preset::<f64>::diodes().leakage_resistance(), f64::INFINITY);
    }

    #[test]
    fn a_node_behind_a_converter_takes_more_from_the_store() {
        let preset = Preset::<f64>::ltc3588_1(BuckOutput::V3_3);
        // 100 µW through 0.85, and 500 nA at 5.05 V.
        assert!((preset.power_at_store(100e-6) - (100e-6 / 0.85 + 2.525e-6)).abs() < 1e-18);
        assert_eq!(Preset::<f64>::diodes().power_at_store(3e-6), 3e-6);
    }
}
