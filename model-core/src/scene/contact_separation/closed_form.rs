//! The plate that never touches: harmonic balance of the motion, all harmonics of the charge.
//!
//! The gap is taken as `g = g0 + Y cos θ`, `θ = Ω t`, the distance as `D = g + d_e`. In terms of the charge
//! that faces the dielectric, `P = σS − Q`, the circuit's equation loses its varying right-hand side:
//!
//! ```text
//! κ (1 + c D) dP/dθ + D P = σS d_e            κ = Ω ε0 S R,  c = C_p/(ε0 S)
//! ```
//!
//! and, `D` being of one harmonic, those of `P = Σ p_n e^{jnθ}` couple to their neighbours only. A continued
//! fraction from the highest down solves them for any resistance; the power is `R Ω² Σ n² |p_n|²`.
//!
//! The attraction `F` along that orbit, in mean and first harmonic, balances the motion:
//!
//! ```text
//! ω0² (g0 − d0) + F_0 = 0
//! A² = ((ω0² − Ω²) Y + F_c)² + (2 ζ ω0 Ω Y − F_s)²
//! ```
//!
//! The second is explicit in `A`, so the amplitude `Y` is found as a root, from the small ones up.

use super::{ContactSeparation, Parts};
use crate::part::load::{Load, Resistance};
use crate::scalar::{Complex, Scalar};
use crate::scene::closed_form::{ClosedForm, Reason, Validity};

/// Harmonics of the charge for the power: with the plate at 0.95 of the way to the dielectric the sixteenth
/// is 10⁻² of the first.
const HARMONICS: usize = 16;
/// Harmonics of the charge for the force, whose first alone counts.
const FORCE_HARMONICS: usize = 4;
/// Points of a period at which the force is taken, with cosines and sines of twelfths of a turn.
const POINTS: usize = 12;
const SINES: [f64; POINTS] = [0.0, 0.5, ROOT, 1.0, ROOT, 0.5, 0.0, -0.5, -ROOT, -1.0, -ROOT, -0.5];
/// `√3/2`.
const ROOT: f64 = 0.866_025_403_784_438_6;
/// Largest part of the way to the dielectric that is claimed not to touch: with the harmonics that the
/// balance leaves out, and those of the charge beyond the sixteenth.
const CLEAR: f64 = 0.95;
/// Attempts at the amplitude, after which a balance is given up.
const MOST_ATTEMPTS: u32 = 12;
/// What may be left of the balance, as a part of the acceleration.
const TOLERANCE: f64 = 1e-4;

/// Mean and first harmonic of the attraction per mass, in m/s².
struct Attraction<S> {
    mean: S,
    cosine: S,
    sine: S,
}

/// What the balance of the first harmonic needs and which way it points.
struct Demand<S> {
    /// Amplitude of the base acceleration, in m/s².
    acceleration: S,
    /// Whether the motion follows the base, as below resonance.
    follows: bool,
}

/// A motion `g0 + Y cos θ`.
#[derive(Clone, Copy)]
struct Motion<S> {
    mean: S,
    amplitude: S,
}

impl<S: Scalar, P: Parts<S>> ContactSeparation<S, P> {
    /// Mean power under the base acceleration `amplitude · sin(2π · hertz · t)`, in m/s² and Hz, of the motion
    /// that does not reach the dielectric.
    ///
    /// Up to a dozen attempts at the amplitude, most often four, of some 500 multiplications each, and a last
    /// pass of 400. Above resonance a motion with impacts exists beside this one; where the transient from
    /// rest, of up to twice the amplitude, reaches the dielectric, it is not claimed to hold.
    #[must_use]
    pub fn closed_form(&self, amplitude: S, hertz: S) -> ClosedForm<S> {
        let omega = hertz * S::literal(core::f64::consts::TAU);
        let (motion, follows, rest) = self.motion(amplitude, omega);
        let reach = motion.amplitude / motion.mean.larger(S::TINY);
        let in_transient = if follows { S::ZERO } else { reach + reach };
        let validity = Validity::of([
            (Reason::NotBalanced, rest * S::literal(1.0 / TOLERANCE)),
            (Reason::Impacts, reach * S::literal(1.0 / CLEAR)),
            (Reason::ImpactsInTransient, in_transient),
        ]);
        let (mean_power, rms_voltage) = self.electrical(&motion, omega);
        ClosedForm { mean_power, rms_voltage, amplitude: motion.amplitude, validity }
    }

    /// The gap at rest with the load's charge at rest too: where spring and attraction balance, with the
    /// derivative of the attraction per mass along the relaxed charge.
    fn equilibrium(&self) -> (S, S) {
        let mut gap = self.initial_gap;
        let mut slope = S::ZERO;
        let step = S::literal(1.0 / 1024.0) * self.initial_gap;
        for _ in 0..3 {
            let here = self.attraction(&self.circuit(gap, self.relaxed_charge(gap)));
            let beyond = gap + step;
            slope = (self.attraction(&self.circuit(beyond, self.relaxed_charge(beyond))) - here) / step;
            let residual = self.stiffness_per_mass * (gap - self.initial_gap) + here;
            gap = gap - residual / (self.stiffness_per_mass + slope);
        }
        (gap, slope)
    }

    /// The motion under a base acceleration, whether it follows the base, and what is left of its balance as
    /// a part of the acceleration. A motion that would touch is given as the one that just does.
    fn motion(&self, acceleration: S, omega: S) -> (Motion<S>, bool, S) {
        let (rest, slope) = self.equilibrium();
        let per_stiffness = S::ONE / (self.stiffness_per_mass + slope);
        let highest = S::literal(0.999) * rest;
        let small = S::literal(1e-3) * rest;
        let mut motion = Motion { mean: rest, amplitude: small };
        let mut before = (S::ZERO, S::ZERO);
        let mut follows = true;
        let mut left = S::INFINITY;
        let mut high = (highest, S::ZERO);
        for _ in 0..MOST_ATTEMPTS {
            let force = self.force(&motion, omega);
            let demand = self.demand(&motion, &force, omega);
            follows = demand.follows;
            let residual = self.stiffness_per_mass * (motion.mean - self.initial_gap) + force.mean;
            motion.mean = motion.mean - residual * per_stiffness;
            let short = demand.acceleration - acceleration;
            left = short.absolute() / acceleration.larger(S::TINY)
                + residual.absolute() / (self.stiffness_per_mass * rest);
            if left <= S::literal(TOLERANCE) {
                break;
            }
            // At the reach of the gap and still more asked for: it touches.
            if motion.amplitude >= highest && short < S::ZERO {
                left = S::ZERO;
                break;
            }
            let now = (motion.amplitude, demand.acceleration);
            if short > S::ZERO && motion.amplitude < high.0 {
                high = (motion.amplitude, S::ZERO);
            }
            let rise = (now.1 - before.1) / (now.0 - before.0);
            let next = now.0 - short / rise;
            before = now;
            // A demand that falls is left behind; written so that not-a-number is too.
            motion.amplitude = if rise > S::ZERO && next > S::ZERO { next } else { now.0 + now.0 };
            motion.amplitude = motion.amplitude.smaller(high.0);
        }
        (motion, follows, left)
    }

    /// The base acceleration that a motion takes.
    fn demand(&self, motion: &Motion<S>, force: &Attraction<S>, omega: S) -> Demand<S> {
        let detuning = (self.angular_frequency - omega) * (self.angular_frequency + omega);
        let along = detuning * motion.amplitude + force.cosine;
        let across = self.damping_per_mass * omega * motion.amplitude - force.sine;
        let acceleration = Complex::new(along, across).magnitude();
        Demand { acceleration, follows: along >= S::ZERO }
    }

    /// The attraction along an orbit.
    fn force(&self, motion: &Motion<S>, omega: S) -> Attraction<S> {
        let opposite = self.opposite_charge::<FORCE_HARMONICS>(motion, omega);
        let (mut mean, mut cosine, mut sine) = (S::ZERO, S::ZERO, S::ZERO);
        for point in 0..POINTS {
            let table = |place: usize| S::literal(SINES.get(place).copied().unwrap_or(0.0));
            let (at_sine, at_cosine) =
                (table(point), table(if point < POINTS - 3 { point + 3 } else { point + 3 - POINTS }));
            let gap = motion.mean + motion.amplitude * at_cosine;
            let charge = self.tribo_charge - series(&opposite, at_cosine, at_sine);
            let force = self.attraction(&self.circuit(gap, charge));
            mean += force;
            cosine += force * at_cosine;
            sine += force * at_sine;
        }
        let part = S::literal(1.0 / POINTS as f64);
        Attraction { mean: part * mean, cosine: (part + part) * cosine, sine: (part + part) * sine }
    }

    /// Harmonics 0 to `N − 1` of the charge that faces the dielectric, `P = p_0 + 2 Re Σ p_n e^{jnθ}`, in
    /// charge units. With the load open the charge stays that of the gap at rest.
    fn opposite_charge<const N: usize>(&self, motion: &Motion<S>, omega: S) -> [Complex<S>; N] {
        let mut harmonics = [Complex::ZERO; N];
        let lag = match self.load.resistance() {
            Resistance::Short => S::ZERO,
            Resistance::Finite(_) => omega / self.circuit_rate,
            Resistance::Open => {
                if let Some(constant) = harmonics.first_mut() {
                    constant.re = self.tribo_charge - self.relaxed_charge(self.initial_gap);
                }
                return harmonics;
            }
        };
        let distance = motion.mean + self.dielectric;
        let half = S::literal(0.5) * motion.amplitude;
        let own = lag * (S::ONE + self.parasitic * distance);
        let shared = lag * self.parasitic * half;
        // r_n = p_n / p_{n−1} = −b_{n−1} / (a_n + b_{n+1} r_{n+1}).
        let mut ratio = Complex::ZERO;
        for (number, place) in harmonics.iter_mut().enumerate().skip(1).rev() {
            let n = S::from_u32(number as u32);
            let above = Complex::new(half, (n + S::ONE) * shared);
            let below = Complex::new(half, (n - S::ONE) * shared);
            let denominator = Complex::new(distance, n * own) + above * ratio;
            ratio = -(below * denominator.inverse());
            *place = ratio;
        }
        let pull = Complex::new(half, shared) * ratio;
        let mut before =
            Complex::new(self.tribo_charge * self.dielectric / (distance + pull.re + pull.re), S::ZERO);
        for (number, place) in harmonics.iter_mut().enumerate() {
            if number > 0 {
                before = before * *place;
            }
            *place = before;
        }
        harmonics
    }

    /// Mean power in W and root mean square of the voltage in V along an orbit.
    fn electrical(&self, motion: &Motion<S>, omega: S) -> (S, S) {
        match self.load.resistance() {
            Resistance::Short => (S::ZERO, S::ZERO),
            Resistance::Open => (S::ZERO, self.open_voltage(motion, omega)),
            Resistance::Finite(ohms) => {
                let harmonics = self.opposite_charge::<HARMONICS>(motion, omega);
                let mut sum = S::ZERO;
                for (number, harmonic) in harmonics.iter().enumerate() {
                    let n = S::from_u32(number as u32);
                    sum += n * n * harmonic.square();
                }
                let current = omega * self.charge_unit;
                let square = (sum + sum) * current * current;
                (square * ohms, square.square_root() * ohms)
            }
        }
    }

    /// Root mean square of the voltage in V with the load open, from points of the period.
    fn open_voltage(&self, motion: &Motion<S>, omega: S) -> S {
        let [constant] = self.opposite_charge::<1>(motion, omega);
        let mut sum = S::ZERO;
        for sine in SINES {
            let gap = motion.mean + motion.amplitude * S::literal(sine);
            let voltage = self.circuit(gap, self.tribo_charge - constant.re).voltage;
            sum += voltage * voltage;
        }
        self.field * (sum * S::literal(1.0 / POINTS as f64)).square_root()
    }
}

/// `p_0 + 2 Re Σ p_n e^{jnθ}`, by Horner's rule in `e^{jθ}`.
fn series<S: Scalar, const N: usize>(harmonics: &[Complex<S>; N], cosine: S, sine: S) -> S {
    let turn = Complex::new(cosine, sine);
    let mut sum = Complex::ZERO;
    for harmonic in harmonics.iter().skip(1).rev() {
        sum = (sum + *harmonic) * turn;
    }
    let constant = harmonics.first().map_or(S::ZERO, |constant| constant.re);
    constant + sum.re + sum.re
}

#[cfg(test)]
mod tests;
