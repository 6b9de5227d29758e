//! The beam that stays clear of its stop, behind a full bridge: mean power into a bus and into a storage.
//!
//! Between two turns of the motion the strain moves the charge `2 |Q|`. First it takes the voltage from one
//! end, `∓V_b`, to the other, which takes `2 C_p V_b`; what is left goes through the bridge, at
//! `V_b = V_dc + 2 V_D` with two diodes on its way.

use super::{BumpStop, Parts};
use crate::scalar::{Complex, Scalar, arcsine};
use crate::scene::closed_form::{ClosedForm, Reason, Validity, ratio};

/// Largest part of the power of a bus by which the voltage may bend the motion.
const WEAK: f64 = 0.05;
/// Largest `|Q_v|/C_p`, at resonance the figure of merit `k² Q`, up to which a motion behind a bridge is
/// harmonic enough.
const HARMONIC: f64 = 1.0;
/// Largest change of the voltage in the last of them, relative.
const UNBALANCED: f64 = 1e-3;
/// Turns of the iteration by which the voltage and the motion of a storage agree.
const TURNS: u32 = 8;

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Mean power into a bus of constant voltage behind a full bridge, under the base acceleration
    /// `amplitude · sin(2π · frequency · t)`: the motion is that of the short circuit, which is exact in the
    /// one-way model and an approximation for weak coupling in the other,
    /// `P = 4 f C_p V_dc (V_oc − V_dc − 2 V_D)` with `V_oc = |Q|/C_p`, and nothing where the bridge blocks.
    ///
    /// In m/s² (its magnitude), Hz, V and V for each diode; the load of the scene itself has no part in it. The power is what
    /// enters the bus.
    #[must_use]
    pub fn closed_form_into_bus(
        &self,
        amplitude: S,
        frequency: S,
        bus_voltage: S,
        diode_drop: S,
    ) -> ClosedForm<S> {
        let response = self.response(frequency);
        let amplitude = amplitude.abs();
        let open = response.charge_by_base.magnitude() * amplitude * self.elastance;
        let bridge = bus_voltage + diode_drop + diode_drop;
        // Where the bridge blocks, the terminals are open and the voltage is bent back by the motion.
        let swing = open - bridge;
        let coupling = response.charge_by_voltage.magnitude() * self.elastance;
        let bend = if swing > S::ZERO {
            S::from_f64(2.0 * core::f64::consts::FRAC_2_PI / WEAK) * coupling * bridge / swing
        } else {
            coupling * S::from_f64(1.0 / WEAK)
        };
        let power = S::from_f64(4.0) * frequency * self.capacitance * bus_voltage * swing.max(S::ZERO);
        let [reaches, in_transient] = self.clearance(&response, amplitude, Complex::ZERO);
        ClosedForm {
            mean_power: power,
            rms_voltage: rms_behind_bridge(open, bridge),
            amplitude: response.tip_amplitude(amplitude, Complex::ZERO),
            validity: Validity::of([(Reason::StrongCoupling, bend), reaches, in_transient]),
        }
    }

    /// Mean power in a resistance across a large storage behind a full bridge, in its steady state, under the
    /// base acceleration `amplitude · sin(2π · frequency · t)`: Shu and Lien 2006 for a motion of one harmonic
    /// with the voltage acting back on it, all modes of the beam and the diodes' drop taken along.
    ///
    /// `V_dc = ω R (|Q| − 2 C_p V_D)/(ω C_p R + π/2)`. Where the beam turns round the voltage is `V_b`, and over
    /// a period the bridge takes `P_b = V_b V_dc/R`; so to the modes the terminals are a voltage of
    /// `V_b/|Q|` per charge in phase with the charge and of `2 P_b/(ω |Q|²)` ahead of it. With one mode and
    /// ideal diodes `|Q|` follows in closed form; else by a few turns of an iteration.
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
        for _ in 0..TURNS {
            let magnitude = charge.magnitude().max(S::TINY);
            let before = steady;
            steady = per_charge * (magnitude - blocked).max(S::ZERO);
            change = (steady - before).abs();
            let bridge = steady + two * diode_drop;
            let power = bridge * steady / resistance;
            let of_charge = Complex::new(bridge / magnitude, two * power / (omega * magnitude * magnitude));
            // Where the diodes block, the voltage is all of the charge's.
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
                (Reason::NotBalanced, ratio(change, S::from_f64(UNBALANCED) * steady)),
                reaches,
                in_transient,
            ]),
        }
    }
}

/// Root mean square of a voltage that would swing by `±open` and is held within `±bridge`: from a turn on
/// `−V_b + V_oc (1 − cos φ)`, until it is `V_b`, and `V_b` until the next turn.
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
    let held = (S::from_f64(core::f64::consts::PI) - blocked) * bridge * bridge;
    ((rising + held) * S::from_f64(core::f64::consts::FRAC_1_PI)).sqrt()
}
