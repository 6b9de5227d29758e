//! Computes the mean power of a beam that does not reach its stop, behind a full bridge, into a DC bus and into a
//! storage.
//!
//! Between two turning points the strain moves the charge `2 |Q|`. First the voltage changes from `∓V_b` to `±V_b`,
//! which takes `2 C_p V_b`; the remaining charge passes the bridge at `V_b = V_dc + 2 V_D`, with two diodes
//! conducting.

use super::closed_form::Complex;
use super::validity::ratio;
use super::{BumpStop, ClosedForm, Parts, Reason, Validity};
use crate::scalar::{Scalar, arcsine};

/// Largest `|Q_v|/C_p`, at resonance the figure of merit `k² Q`, for a nearly harmonic motion behind a bridge.
const HARMONIC: f64 = 1.0;
/// Largest relative change of the voltage in the last iteration.
const TOLERANCE: f64 = 1e-3;
/// Halvings of the interval of the charge with a bus.
const HALVINGS: u32 = 50;
/// Number of iterations for the voltage and the motion with a storage.
const ITERATIONS: u32 = 8;

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Mean power in W into a DC bus behind a full bridge, with the effect of the voltage on the motion: Guyomar's and Shu
    /// and Lien's standard interface at a fixed voltage, for a harmonic motion with two-way coupling, all beam modes and
    /// the drop of the diodes. With one-way coupling exact, `P = 4 f C_p V_dc (V_oc − V_dc − 2 V_D)` with `V_oc = |Q|/C_p`;
    /// 0 if the bridge blocks.
    ///
    /// The base acceleration is `amplitude · sin(2π · frequency · t)` in m/s² and Hz; `bus_voltage` and `diode_drop`,
    /// per diode, are in V. The load of the scene is ignored.
    ///
    /// Over a period the bridge takes `P_b = 4 f V_b (|Q| − C_p V_b)` at `V_b = V_dc + 2 V_D`, so the modes see a voltage
    /// per charge of `V_b/|Q|` in phase with the charge and of `2 P_b/(ω |Q|²)` ahead of it. `|Q|` is found by bisection
    /// above `C_p V_b`. If the voltage of the open terminals stays below `V_b`, the bridge blocks and the terminals are open.
    #[must_use]
    pub fn closed_form_into_bus(
        &self,
        amplitude: S,
        frequency: S,
        bus_voltage: S,
        diode_drop: S,
    ) -> ClosedForm<S> {
        let response = self.response(frequency);
        let by_base = response.charge_by_base.scaled(amplitude.abs());
        let by_voltage = response.charge_by_voltage;
        let one = Complex::new(S::ONE, S::ZERO);
        let bridge = bus_voltage + diode_drop + diode_drop;
        let blocked = self.capacitance * bridge;
        let power_part = S::from_f64(2.0 * core::f64::consts::FRAC_2_PI);
        // Voltage per charge at the magnitude of the charge, times the magnitude.
        let voltage_at =
            |magnitude: S| Complex::new(bridge, power_part * bridge * (S::ONE - blocked / magnitude));
        let short = |magnitude: S| {
            let needed = Complex::new(magnitude, S::ZERO) - by_voltage * voltage_at(magnitude);
            by_base.magnitude() - needed.magnitude()
        };
        let open = one - by_voltage.scaled(self.elastance);
        let conducts = by_base.magnitude() > blocked * open.magnitude();
        let (charge, of_charge) = if conducts {
            let most = bridge * (S::ONE + power_part);
            let (mut low, mut high) = (blocked, by_base.magnitude() + by_voltage.magnitude() * most);
            low = low.max(S::TINY);
            for _ in 0..HALVINGS {
                let middle = S::from_f64(0.5) * (low + high);
                if short(middle) > S::ZERO {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let of_charge = voltage_at(high).scaled(S::ONE / high);
            (by_base * (one - by_voltage * of_charge).inverse(), of_charge)
        } else {
            (by_base * open.inverse(), one.scaled(self.elastance))
        };
        let swing = charge.magnitude() - blocked;
        let transferred = if conducts { S::from_f64(4.0) * frequency * swing.max(S::ZERO) } else { S::ZERO };
        let voltage = charge * of_charge;
        let coupling = if conducts { by_voltage.magnitude() * self.elastance } else { S::ZERO };
        let [reaches, in_transient] = self.clearance(&response, amplitude.abs(), voltage);
        ClosedForm {
            mean_power: bus_voltage * transferred,
            rms_voltage: rms_behind_bridge(charge.magnitude() * self.elastance, bridge),
            amplitude: response.tip_amplitude(amplitude.abs(), voltage),
            validity: Validity::of([
                (Reason::StrongCoupling, coupling * S::from_f64(1.0 / HARMONIC)),
                reaches,
                in_transient,
            ]),
        }
    }

    /// Mean power in W in a `resistance` in Ω across a large storage behind a full bridge, in the steady state. Shu
    /// and Lien (2006) for a harmonic motion with two-way coupling, extended to all beam modes and to the drop of the
    /// diodes.
    ///
    /// The base acceleration is `amplitude · sin(2π · frequency · t)` in m/s² and Hz; `diode_drop` is in V per diode.
    ///
    /// `V_dc = ω R (|Q| − 2 C_p V_D)/(ω C_p R + π/2)`. At the turning point of the beam the voltage is `V_b`, and
    /// over a period the bridge takes the mean power `P_b = V_b V_dc/R`. So the modes see a voltage per charge of
    /// `V_b/|Q|` in phase with the charge and of `2 P_b/(ω |Q|²)` ahead of it. With one mode and ideal diodes `|Q|`
    /// has a closed form; otherwise it is found by a few iterations.
    #[must_use]
    pub fn closed_form_into_store(
        &self,
        amplitude: S,
        frequency: S,
        resistance: S,
        diode_drop: S,
    ) -> ClosedForm<S> {
        let response = self.response(frequency);
        let two = S::from_f64(2.0);
        let omega = response.angular_frequency;
        let by_base = response.charge_by_base.scaled(amplitude);
        let per_charge = omega * resistance
            / (omega * resistance * self.capacitance + S::from_f64(core::f64::consts::FRAC_PI_2));
        let blocked = two * self.capacitance * diode_drop;
        let one = Complex::new(S::ONE, S::ZERO);
        let (mut charge, mut voltage, mut steady) = (by_base, Complex::ZERO, S::ZERO);
        let mut change = S::ZERO;
        for _ in 0..ITERATIONS {
            let magnitude = charge.magnitude().max(S::TINY);
            let before = steady;
            steady = per_charge * (magnitude - blocked).max(S::ZERO);
            change = (steady - before).abs();
            let bridge = steady + two * diode_drop;
            let power = bridge * steady / resistance;
            let of_charge = Complex::new(bridge / magnitude, two * power / (omega * magnitude * magnitude));
            // If the diodes block, the whole charge is on the capacitance.
            let of_charge = if magnitude > blocked { of_charge } else { one.scaled(self.elastance) };
            charge = by_base * (one - response.charge_by_voltage * of_charge).inverse();
            voltage = charge * of_charge;
        }
        let coupling = response.charge_by_voltage.magnitude() * self.elastance;
        let [reaches, in_transient] = self.clearance(&response, amplitude, voltage);
        ClosedForm {
            mean_power: steady * steady / resistance,
            rms_voltage: rms_behind_bridge(
                charge.magnitude() * self.elastance,
                steady + diode_drop + diode_drop,
            ),
            amplitude: response.tip_amplitude(amplitude, voltage),
            validity: Validity::of([
                (Reason::StrongCoupling, coupling * S::from_f64(1.0 / HARMONIC)),
                (Reason::NotBalanced, ratio(change, S::from_f64(TOLERANCE) * steady)),
                reaches,
                in_transient,
            ]),
        }
    }
}

/// Root mean square of a voltage with the open-circuit swing `±open`, clamped to `±bridge`: from a turning point
/// `−V_b + V_oc (1 − cos φ)`, until it is `V_b`, and `V_b` until the next turning point.
fn rms_behind_bridge<S: Scalar>(open: S, bridge: S) -> S {
    let half = S::from_f64(0.5);
    if !(bridge < open) {
        return open * half.sqrt();
    }
    let middle = open - bridge;
    let cosine = S::ONE - (bridge + bridge) / open;
    let sine = ((S::ONE - cosine) * (S::ONE + cosine)).sqrt();
    let blocked = S::from_f64(core::f64::consts::FRAC_PI_2) - arcsine(cosine);
    let rising = (middle * middle + half * open * open) * blocked - (middle + middle) * open * sine
        + half * open * open * sine * cosine;
    let conducting = (S::from_f64(core::f64::consts::PI) - blocked) * bridge * bridge;
    ((rising + conducting) * S::from_f64(core::f64::consts::FRAC_1_PI)).sqrt()
}
