//! Computes the motion of a plate that never touches: harmonic balance of the motion, all harmonics of the charge.
//!
//! The gap is approximated by `g = g0 + Y cos θ`, `θ = Ω t`, with the distance `D = g + d_e`. In terms of the charge
//! that faces the dielectric, `P = σS − Q`, the circuit equation has a constant right-hand side:
//!
//! ```text
//! τ (1 + c D) dP/dθ + D P = σS d_e            τ = Ω ε0 S R,  c = C_p/(ε0 S)
//! ```
//!
//! `D` has one harmonic, so the harmonics of `P = Σ p_n e^{jnθ}` couple only to their neighbours. A continued
//! fraction from the highest harmonic down solves for them at any resistance; the power is `R Ω² Σ n² |p_n|²`.
//!
//! The mean `F_0` and the first harmonic `F_c`, `F_s` of the attraction along that orbit balance the motion:
//!
//! ```text
//! ω0² (g0 − d0) + F_0 = 0
//! A² = ((ω0² − Ω²) Y + F_c)² + (2 ζ ω0 Ω Y − F_s)²
//! ```
//!
//! The second equation is explicit in the base acceleration `A`, so the amplitude `Y` is found as a root, from small
//! amplitudes upwards.
//!
//! Near the dielectric the power depends on the least distance, and so on the second harmonic of the motion, `y_2 =
//! −F_2/(ω0² − 4 Ω² + 4jζ ω0 Ω)`. The charge includes it to first order, by the same fraction with the product of
//! `y_2` and the charge without `y_2` on the right-hand side. Derived here.

use super::{ContactSeparation, Mode, Parts};
use crate::part::load::{Load, Resistance};
use crate::scalar::{Complex, Scalar};
use crate::scene::closed_form::{ClosedForm, Reason, Validity};
use crate::scene::rectified::{Needs, RegularMotion};

/// Harmonics of the charge for the power. At an amplitude of 0.9 of the mean gap the last is 10⁻³ of the first.
const HARMONICS: usize = 16;
/// Harmonics of the charge for the force, of which the first two matter.
const FORCE_HARMONICS: usize = 8;
/// Number of points of a period for the force, twelfths of a turn; their sines follow.
const POINTS: usize = 12;
const SINES: [f64; POINTS] = [0.0, 0.5, ROOT, 1.0, ROOT, 0.5, 0.0, -0.5, -ROOT, -1.0, -ROOT, -0.5];
/// `√3/2`.
const ROOT: f64 = 0.866_025_403_784_438_6;
/// Largest amplitude over the mean gap that counts as free of impacts, in view of the omitted harmonics of the motion
/// and of the charge beyond the sixteenth.
const CLEAR: f64 = 0.9;
/// Most iterations for the amplitude.
const MOST_ATTEMPTS: u32 = 12;
/// Tolerance of the balance relative to the acceleration.
const TOLERANCE: f64 = 1e-4;

/// Mean and first two harmonics of the attraction per mass, in m/s².
struct Attraction<S> {
    mean: S,
    /// `Re(z e^{jθ})` and `Re(z e^{2jθ})`.
    first: Complex<S>,
    second: Complex<S>,
}

/// The plate at rest, and its motion at small amplitudes.
struct Equilibrium<S> {
    /// Gap in m.
    gap: S,
    /// Stiffness per mass with a relaxed charge, in 1/s².
    stiffness: S,
    /// Change of the mean gap over the square of a small amplitude, in 1/m.
    drift: S,
}

/// A motion `g0 + Y cos θ + Re(y_2 e^{2jθ})`.
#[derive(Clone, Copy)]
struct Motion<S> {
    mean: S,
    amplitude: S,
    second: Complex<S>,
}

impl<S: Scalar, P: Parts<S>> ContactSeparation<S, P> {
    /// Mean power under the base acceleration `amplitude · sin(2π · frequency · t)`, in m/s² and Hz, of the motion
    /// that does not reach the dielectric.
    ///
    /// Up to a dozen iterations for the amplitude, most often two or three, of some 750 additions and multiplications
    /// and 20 divisions each, and a last pass of 1400 and 20. Above resonance a motion with impacts coexists with
    /// this one; if the transient from rest, of up to twice the amplitude, reaches the dielectric, the result is not
    /// claimed to hold.
    #[must_use]
    pub fn closed_form(&self, amplitude: S, frequency: S) -> ClosedForm<S> {
        let omega = frequency * S::from_f64(core::f64::consts::TAU);
        let (motion, follows, rest) = self.motion(amplitude.abs(), omega);
        let reach = motion.amplitude / motion.mean.max(S::TINY);
        let in_transient = if follows { S::ZERO } else { reach + reach };
        let validity = Validity::of([
            (Reason::NotBalanced, rest * S::from_f64(1.0 / TOLERANCE)),
            (Reason::Impacts, reach * S::from_f64(1.0 / CLEAR)),
            (Reason::ImpactsInTransient, in_transient),
        ]);
        let (mean_power, rms_voltage) = self.electrical(&motion, omega);
        ClosedForm { mean_power, rms_voltage, amplitude: motion.amplitude, validity }
    }

    /// The gap at rest with a relaxed charge: spring force and attraction balance.
    fn equilibrium(&self) -> Equilibrium<S> {
        let (two, quarter) = (S::from_f64(2.0), S::from_f64(0.25));
        let force = |gap: S| self.attraction(&self.circuit(gap, self.relaxed_charge(gap)));
        let step = quarter * self.initial_gap;
        let mut gap = self.initial_gap;
        let (mut slope, mut curvature) = (S::ZERO, S::ZERO);
        for _ in 0..3 {
            let [below, here, beyond] = [gap - step, gap, gap + step].map(force);
            slope = (beyond - below) / (step + step);
            curvature = (beyond - two * here + below) / (step * step);
            let residual = self.stiffness_per_mass * (gap - self.initial_gap) + here;
            gap -= residual / (self.stiffness_per_mass + slope);
        }
        let stiffness = self.stiffness_per_mass + slope;
        Equilibrium { gap, stiffness, drift: -quarter * curvature / stiffness }
    }

    /// The motion under a base acceleration in m/s², whether it is in phase with the base, and the residual of its
    /// balance relative to the acceleration. A motion that would touch is replaced by the one that just touches.
    fn motion(&self, acceleration: S, omega: S) -> (Motion<S>, bool, S) {
        let rest = self.equilibrium();
        let twice = omega + omega;
        let flexibility = Complex::new(
            (self.angular_frequency - twice) * (self.angular_frequency + twice),
            self.damping_per_mass * twice,
        )
        .inverse();
        let highest = S::from_f64(0.999) * rest.gap;
        let across = self.damping_per_mass * omega;
        let first = Complex::new(rest.stiffness - omega * omega, across).magnitude();
        let mut motion = Motion { mean: rest.gap, amplitude: S::ZERO, second: Complex::ZERO };
        let (mut drift, mut before) = (rest.drift, (S::ZERO, S::ZERO));
        let (mut follows, mut left) = (true, S::INFINITY);
        if acceleration == S::ZERO {
            return (motion, true, S::ZERO);
        }
        let mut next = acceleration / first;
        for _ in 0..MOST_ATTEMPTS {
            // The mean gap drifts approximately with the square of the amplitude.
            motion.amplitude = next.min(highest).max(S::from_f64(1e-6) * highest);
            let square = motion.amplitude * motion.amplitude;
            motion.mean = rest.gap + drift * square;
            let force = self.force(&motion, omega);
            let demanded;
            (demanded, follows) = self.demand(&motion, &force, omega);
            motion.second = -(force.second * flexibility);
            let residual = self.stiffness_per_mass * (motion.mean - self.initial_gap) + force.mean;
            drift -= residual / (rest.stiffness * square);
            let short = demanded - acceleration;
            left = short.abs() / acceleration.max(S::TINY)
                + residual.abs() / (self.stiffness_per_mass * rest.gap);
            // At the largest amplitude the required acceleration is still too small: the plate touches.
            let touches = motion.amplitude >= highest && short < S::ZERO;
            if touches {
                // The mean gap is at most the gap at rest, for any estimated drift.
                motion.mean = motion.mean.min(rest.gap);
                left = S::ZERO;
            }
            if left <= S::from_f64(TOLERANCE) {
                break;
            }
            let rise = (demanded - before.1) / (motion.amplitude - before.0);
            before = (motion.amplitude, demanded);
            // A falling demand doubles the amplitude, and so does not-a-number.
            let secant = motion.amplitude - short / rise;
            next = if rise > S::ZERO { secant } else { motion.amplitude + motion.amplitude };
        }
        (motion, follows, left)
    }

    /// Amplitude in m/s² of the base acceleration that a motion requires, and whether the motion is in phase with the
    /// base, as below resonance.
    fn demand(&self, motion: &Motion<S>, force: &Attraction<S>, omega: S) -> (S, bool) {
        let detuning = (self.angular_frequency - omega) * (self.angular_frequency + omega);
        let along = detuning * motion.amplitude + force.first.re;
        let across = self.damping_per_mass * omega * motion.amplitude + force.first.im;
        (Complex::new(along, across).magnitude(), along >= S::ZERO)
    }

    /// The attraction along an orbit.
    fn force(&self, motion: &Motion<S>, omega: S) -> Attraction<S> {
        let single = Motion { second: Complex::ZERO, ..*motion };
        let opposite = self.opposite_charge::<FORCE_HARMONICS>(&single, omega);
        let (mut mean, mut first, mut second) = (S::ZERO, Complex::ZERO, Complex::ZERO);
        for point in 0..=POINTS / 2 {
            let turn = turn::<S>(point);
            let gap = motion.mean + motion.amplitude * turn.re;
            // The harmonics at ±θ share their products.
            let [even, odd] = series(&opposite, point);
            let ends = point == 0 || point == POINTS / 2;
            let charge = self.tribo_charge - even;
            let mut add = |charge: S, sine: S| {
                let force = self.attraction(&self.circuit(gap, charge));
                let back = Complex::new(force * turn.re, -force * sine);
                mean += force;
                first = first + back;
                second = second + back * Complex::new(turn.re, -sine);
            };
            add(charge + odd, turn.im);
            if !ends {
                add(charge - odd, -turn.im);
            }
        }
        let part = S::from_f64(1.0 / POINTS as f64);
        Attraction { mean: part * mean, first: first.scaled(part + part), second: second.scaled(part + part) }
    }

    /// Harmonics 0 to `N − 1` of the charge that faces the dielectric, `P = p_0 + 2 Re Σ p_n e^{jnθ}`, in charge
    /// units. With an open load the charge is that of the gap at rest.
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
        let half = S::from_f64(0.5) * motion.amplitude;
        let shared = lag * self.parasitic;
        let coupling = |n: S| Complex::new(half, n * shared * half);
        let own = lag * (S::ONE + self.parasitic * distance);
        // p_n = s_n + r_n p_{n−1}, with r_n = −b_{n−1} / (a_n + b_{n+1} r_{n+1}).
        let mut rows = [Row { ratio: Complex::ZERO, inverse: Complex::ZERO }; N];
        let mut ratio = Complex::ZERO;
        for (number, row) in rows.iter_mut().enumerate().skip(1).rev() {
            let n = S::from_u32(number as u32);
            let inverse = (Complex::new(distance, n * own) + coupling(n + S::ONE) * ratio).inverse();
            ratio = -(coupling(n - S::ONE) * inverse);
            *row = Row { ratio, inverse };
        }
        let first = coupling(S::ONE);
        let pull = first * ratio;
        let per_constant = S::ONE / (distance + pull.re + pull.re);
        let mut before = Complex::new(self.tribo_charge * self.dielectric * per_constant, S::ZERO);
        for (number, (place, row)) in harmonics.iter_mut().zip(&rows).enumerate() {
            before = if number > 0 { before * row.ratio } else { before };
            *place = before;
        }
        if motion.second == Complex::ZERO {
            return harmonics;
        }
        // The right-hand side due to the second harmonic of the motion, negated; p_{−n} is the conjugate of p_n.
        let product = |n: i32| {
            let at = |m: i32| {
                let place = harmonics.get(m.unsigned_abs() as usize).copied().unwrap_or(Complex::ZERO);
                let place = if m < 0 { place.conjugate() } else { place };
                place * Complex::new(S::ONE, S::from_i32(m) * shared)
            };
            let second = motion.second.scaled(S::from_f64(-0.5));
            second * at(n - 2) + second.conjugate() * at(n + 2)
        };
        let mut forced = [Complex::ZERO; N];
        let mut above = Complex::ZERO;
        for (number, (place, row)) in forced.iter_mut().zip(&rows).enumerate().skip(1).rev() {
            let n = S::from_u32(number as u32);
            above = (product(number as i32) - coupling(n + S::ONE) * above) * row.inverse;
            *place = above;
        }
        let pull = first * above;
        let mut before = Complex::new((product(0).re - pull.re - pull.re) * per_constant, S::ZERO);
        for (number, ((place, forced), row)) in harmonics.iter_mut().zip(&forced).zip(&rows).enumerate() {
            before = if number > 0 { *forced + before * row.ratio } else { before };
            *place = *place + before;
        }
        harmonics
    }

    /// Mean power in W and root mean square of the voltage in V along an orbit.
    fn electrical(&self, motion: &Motion<S>, omega: S) -> (S, S) {
        match self.load.resistance() {
            Resistance::Short => (S::ZERO, S::ZERO),
            Resistance::Open => (S::ZERO, self.open_voltage(motion, omega)),
            Resistance::Finite(resistance) => {
                let harmonics = self.opposite_charge::<HARMONICS>(motion, omega);
                let mut sum = S::ZERO;
                for (number, harmonic) in harmonics.iter().enumerate() {
                    let n = S::from_u32(number as u32);
                    sum += n * n * harmonic.square();
                }
                let current = omega * self.charge_unit;
                let square = (sum + sum) * current * current;
                (square * resistance, square.sqrt() * resistance)
            }
        }
    }

    /// Root mean square of the voltage in V with an open load, from points of the period.
    fn open_voltage(&self, motion: &Motion<S>, omega: S) -> S {
        let [constant] = self.opposite_charge::<1>(motion, omega);
        let mut sum = S::ZERO;
        for sine in SINES.map(S::from_f64) {
            let gap = motion.mean + motion.amplitude * sine;
            let voltage = self.circuit(gap, self.tribo_charge - constant.re).voltage;
            sum += voltage * voltage;
        }
        self.field * (sum * S::from_f64(1.0 / POINTS as f64)).sqrt()
    }
}

impl<S: Scalar, P: Parts<S>> RegularMotion<S> for ContactSeparation<S, P> {
    const BEYOND: Reason = Reason::Impacts;
    const COEXISTS: bool = true;

    fn rest(&self) -> [S; 2] {
        [self.initial_gap, self.relaxed_charge(self.initial_gap)]
    }

    fn room(&self, mean: S) -> S {
        S::from_f64(CLEAR) * mean
    }

    fn moving(&self, _forward: bool, _position: S) -> Mode {
        Mode::Free
    }

    /// Nothing holds a plate that does not touch.
    fn grip(&self, _position: S, _charge: S, acceleration: S) -> [S; 2] {
        [acceleration, S::ZERO]
    }

    fn needs(&self, amplitude: S, angular_frequency: S, [along, across]: [S; 2]) -> Needs<S> {
        let along = angular_frequency * angular_frequency * amplitude + along;
        Needs { drive: Complex::new(along, across).magnitude(), is_above: along > S::ZERO, pull: S::INFINITY }
    }
}

/// A row of the eliminated system.
#[derive(Clone, Copy)]
struct Row<S> {
    /// Harmonic over the next lower harmonic.
    ratio: Complex<S>,
    inverse: Complex<S>,
}

/// `e^{jθ}` at a point of the period.
fn turn<S: Scalar>(point: usize) -> Complex<S> {
    let sines = SINES.map(S::from_f64);
    let sine = |place: usize| sines.get(place).copied().unwrap_or(S::ZERO);
    let quarter = POINTS / 4;
    let ahead = if point < POINTS - quarter { point + quarter } else { point + quarter - POINTS };
    Complex::new(sine(ahead), sine(point))
}

/// `p_0 + 2 Σ Re p_n cos nθ` and `2 Σ Im p_n sin nθ` at a point of the first half of the period. Their difference is
/// the series at `θ`, and their sum that at `−θ`.
fn series<S: Scalar, const N: usize>(harmonics: &[Complex<S>; N], point: usize) -> [S; 2] {
    let (mut even, mut odd, mut place) = (S::ZERO, S::ZERO, 0);
    for harmonic in harmonics.iter().skip(1) {
        place += point;
        if place >= POINTS {
            place -= POINTS;
        }
        let turn = turn::<S>(place);
        even += harmonic.re * turn.re;
        odd += harmonic.im * turn.im;
    }
    let constant = harmonics.first().map_or(S::ZERO, |constant| constant.re);
    [constant + even + even, odd + odd]
}

#[cfg(test)]
mod tests;
