//! Computes the motion of a beam that does not reach its stop: the exact linear response to one sine.
//!
//! With `a = B sin ωt` and `D_i = ω_i² − ω² + 2jζ ω_i ω` the modal amplitudes are `r_i = −(γ_i B + χ θ_i v)/D_i`. The
//! charge that strain moves, `Q = Σ θ_i r_i`, is linear in base acceleration and voltage, `Q = Q_a B + χ Q_v v`. The
//! part of it that does not pass the load charges the capacitance:
//!
//! ```text
//! v (C_p + 1/jωR) = Q              v = Q_a B / (C_p − χ Q_v + 1/jωR)
//! ```
//!
//! The same sums with `φ_i(X_c)` in place of `θ_i`, less those of the rod, give the gap coordinate, whose amplitude
//! must stay below the gap `Δ`. Derived here.

use core::ops::{Add, Mul, Neg, Sub};

use super::choices::Coupling;
use super::contact_law::{ContactKind, ContactLaw};
use super::validity::ratio;
use super::{BumpStop, ClosedForm, Parts, Reason, Validity};
use crate::part::load::{Load, Resistance};
use crate::scalar::Scalar;

/// Halvings of the interval of an open-circuit frequency.
const HALVINGS: u32 = 55;

/// The response of the modes at one frequency, per base acceleration and per voltage.
pub(super) struct Response<S> {
    /// `ω` in rad/s.
    pub(super) angular_frequency: S,
    /// `Q_a` in C per m/s²: charge moved by strain per base acceleration.
    pub(super) charge_by_base: Complex<S>,
    /// `χ Q_v` in F: charge moved by strain per voltage; zero in the one-way model.
    pub(super) charge_by_voltage: Complex<S>,
    tip: [Complex<S>; 2],
    gap: [Complex<S>; 2],
}

impl<S: Scalar, P: Parts<S, Load: Load<S>>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Mean power under the base acceleration `amplitude · sin(2π · frequency · t)`, in m/s² and Hz, of the motion
    /// that does not reach the stop: exact, for any resistance, with one-way and two-way coupling.
    ///
    /// Some 50 multiplications and one division per beam mode, 10 and one per rod mode. The amplitude is that of the
    /// tip. Above the first mode a motion with contact may coexist with this one; if the transient from rest, of up
    /// to twice the amplitude, reaches the stop, the result is not claimed to hold.
    #[must_use]
    pub fn closed_form(&self, amplitude: S, frequency: S) -> ClosedForm<S> {
        let response = self.response(frequency);
        let by_base = response.charge_by_base.scaled(amplitude * self.elastance);
        let unloaded = Complex::new(S::ONE, S::ZERO) - response.charge_by_voltage.scaled(self.elastance);
        let (voltage, conductance) = match Load::resistance(&self.load) {
            Resistance::Short => (Complex::ZERO, S::ZERO),
            Resistance::Open => (by_base * unloaded.inverse(), S::ZERO),
            Resistance::Finite(resistance) => {
                let ratio = response.angular_frequency * resistance * self.capacitance;
                // Divided by the larger of the two admittances, so that neither limit overflows.
                let voltage = if ratio < S::ONE {
                    let loaded = Complex::new(S::ONE, S::ZERO) + times_j(unloaded.scaled(ratio));
                    times_j(by_base.scaled(ratio)) * loaded.inverse()
                } else {
                    by_base * (unloaded - Complex::new(S::ZERO, S::ONE / ratio)).inverse()
                };
                (voltage, S::ONE / resistance)
            }
        };
        let mean_square = S::from_f64(0.5) * voltage.square();
        ClosedForm {
            mean_power: mean_square * conductance,
            rms_voltage: mean_square.sqrt(),
            amplitude: response.tip_amplitude(amplitude, voltage),
            validity: Validity::of(self.clearance(&response, amplitude, voltage)),
        }
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// The requirements of the gap for a motion with the terminal voltage `voltage`.
    pub(super) fn clearance(
        &self,
        response: &Response<S>,
        amplitude: S,
        voltage: Complex<S>,
    ) -> [(Reason, S); 2] {
        let reach = match self.contact.kind() {
            ContactKind::None => S::ZERO,
            ContactKind::Compliant | ContactKind::Constrained | ContactKind::Impulsive { .. } => {
                let [by_base, by_voltage] = response.gap;
                ratio((by_base.scaled(amplitude) + by_voltage * voltage).magnitude(), self.gap)
            }
        };
        let first = self.beam.first().map_or(S::ZERO, |mode| mode.angular_frequency);
        let above = response.angular_frequency > first;
        let in_transient = if above { reach + reach } else { S::ZERO };
        [(Reason::ReachesStop, reach), (Reason::ImpactsInTransient, in_transient)]
    }

    /// Undamped open-circuit angular frequency of beam mode `index`, from 0, in rad/s: that of the short circuit, raised by
    /// the voltage. The same with one-way coupling. `None` from `B` on; a mode
    /// beyond the number that [`build_first`](super::Parameters::build_first) was given has the frequency of the last one.
    ///
    /// Of the modes with open terminals and without damping, the charge of the strain is that of the capacitance, `C_p =
    /// Σ θ_i²/(ω² − ω_i²)`. The right-hand side falls from infinity above each `ω_i`, so the frequency is found by
    /// bisection. With one mode it is `√(ω_1² + θ_1²/C_p)`. With `k² = 1 − ω_i²/ω²` it gives the coupling factor of the mode.
    #[must_use]
    pub fn open_circuit_angular_frequency(&self, index: usize) -> Option<S> {
        let own = self.beam.get(index)?.angular_frequency;
        if !self.coupling.is_two_way() {
            return Some(own);
        }
        // Relative to the square of the mode's frequency.
        let per_square = S::ONE / (own * own);
        let rise = |voltage: S| self.elastance * voltage * voltage * per_square;
        let place = |omega: S| (omega - own) * (omega + own) * per_square;
        let (mut low, mut high) = (S::ZERO, S::ZERO);
        for mode in &self.beam {
            high += rise(mode.voltage);
        }
        for mode in &self.beam {
            let above = place(mode.angular_frequency);
            if above > S::ZERO && mode.voltage != S::ZERO {
                high = high.min(above);
            }
        }
        for _ in 0..HALVINGS {
            let middle = S::from_f64(0.5) * (low + high);
            let mut charge = S::ZERO;
            for mode in &self.beam {
                if mode.voltage != S::ZERO {
                    charge += rise(mode.voltage) / (middle - place(mode.angular_frequency));
                }
            }
            if charge > S::ONE {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(own * (S::ONE + high).sqrt())
    }

    /// The sums over the modes at a frequency in Hz.
    pub(super) fn response(&self, frequency: S) -> Response<S> {
        let angular_frequency = frequency * S::from_f64(core::f64::consts::TAU);
        let back = if self.coupling.is_two_way() { S::ONE } else { S::ZERO };
        let zero = Complex::ZERO;
        let mut response = Response {
            angular_frequency,
            charge_by_base: zero,
            charge_by_voltage: zero,
            tip: [zero; 2],
            gap: [zero; 2],
        };
        for mode in &self.beam {
            let flexibility = self.flexibility(mode.angular_frequency, angular_frequency);
            let by_base = flexibility.scaled(-mode.base);
            let by_voltage = flexibility.scaled(-back * mode.voltage);
            response.charge_by_base = response.charge_by_base + by_base.scaled(mode.voltage);
            response.charge_by_voltage = response.charge_by_voltage + by_voltage.scaled(mode.voltage);
            response.tip = added(response.tip, [by_base, by_voltage], mode.tip);
            response.gap = added(response.gap, [by_base, by_voltage], mode.contact);
        }
        for mode in &self.rod {
            let by_base = self.flexibility(mode.angular_frequency, angular_frequency).scaled(-mode.base);
            response.gap = added(response.gap, [by_base, zero], -mode.contact);
        }
        response
    }

    /// `1/D = 1/(ω_i² − ω² + 2jζ ω_i ω)`, in s², relative to the static value: the fourth power of a high frequency
    /// would overflow in `f32`.
    fn flexibility(&self, mode: S, angular_frequency: S) -> Complex<S> {
        let per_mode = S::ONE / mode;
        let beta = angular_frequency * per_mode;
        let twice_damping = self.damping_ratio + self.damping_ratio;
        let relative = Complex::new((S::ONE - beta) * (S::ONE + beta), twice_damping * beta);
        relative.inverse().scaled(per_mode * per_mode)
    }
}

impl<S: Scalar> Response<S> {
    /// Amplitude of the tip in m, under a base acceleration and a voltage.
    pub(super) fn tip_amplitude(&self, amplitude: S, voltage: Complex<S>) -> S {
        let [by_base, by_voltage] = self.tip;
        (by_base.scaled(amplitude) + by_voltage * voltage).magnitude()
    }
}

fn times_j<S: Scalar>(z: Complex<S>) -> Complex<S> {
    Complex::new(-z.im, z.re)
}

fn added<S: Scalar>(sums: [Complex<S>; 2], terms: [Complex<S>; 2], weight: S) -> [Complex<S>; 2] {
    [sums[0] + terms[0].scaled(weight), sums[1] + terms[1].scaled(weight)]
}

#[cfg(test)]
mod tests;

/// `re + j im`. A quantity `Im(z e^{jωt})` has the amplitude `|z|` and the phase `arg z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Complex<S> {
    pub(crate) re: S,
    pub(crate) im: S,
}

impl<S: Scalar> Complex<S> {
    pub(crate) const ZERO: Self = Self { re: S::ZERO, im: S::ZERO };

    pub(crate) fn new(re: S, im: S) -> Self {
        Self { re, im }
    }

    pub(crate) fn scaled(self, factor: S) -> Self {
        Self { re: factor * self.re, im: factor * self.im }
    }

    /// `|z|²`.
    pub(crate) fn square(self) -> S {
        self.re * self.re + self.im * self.im
    }

    /// `|z|`.
    pub(crate) fn magnitude(self) -> S {
        self.square().sqrt()
    }

    /// `1/z`; `|z|²` must neither overflow nor underflow.
    pub(crate) fn inverse(self) -> Self {
        let per_square = S::ONE / self.square();
        Self { re: self.re * per_square, im: -self.im * per_square }
    }
}

impl<S: Scalar> Add for Complex<S> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl<S: Scalar> Sub for Complex<S> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

impl<S: Scalar> Neg for Complex<S> {
    type Output = Self;

    fn neg(self) -> Self {
        Self { re: -self.re, im: -self.im }
    }
}

impl<S: Scalar> Mul for Complex<S> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}
