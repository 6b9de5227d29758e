//! Computes the motion of a slider that never sticks: Den Hartog's solution with a friction that depends on position
//! and charge.
//!
//! The displacement is approximated by `x = X cos θ`, `θ = Ω t`. Along it the charge equation is linear and periodic
//! with the period `π`; with `P = σS − q`
//!
//! ```text
//! τ s1 dP/dθ + P = σS s1              τ = Ω R ε0 ε_r S / d
//! ```
//!
//! The Lobatto IIIC method of order 4 integrates it over half a turn. Its stages are symmetric about the centre, so
//! the overlap is computed once for both directions; the rate at the stages is the current. The force on the slider
//! in this half turn, `f = μ N + F_lat` per modal mass, is replaced by the constant `f̄ = ½ ∫ f sin θ dθ` of equal
//! work, and by the stiffness `−(2/π) ∫ f cos θ dθ / X` due to its lag behind the motion. With both, the motion
//! between two turning points is exactly that of J. P. Den Hartog (1931) with viscous damping:
//!
//! ```text
//! κ A = |D| √((X − G_u f̄/ω²)² + (G_w f̄/ω²Ω)²)         D = ω² − Ω² + 2jζ ωΩ
//! ```
//!
//! where `G_u`, `G_w` follow from the free motion over half a period. The equation is explicit in the base
//! acceleration `A`, so the amplitude `X` is found as a root.

mod charge;

use self::charge::{Increments, STAGES, WEIGHTS, sum};
use super::circuit::Circuit;
use super::{Friction, Mode, Parts, Sliding};
use crate::integrate::modal::ModalStep;
use crate::part::disc_overlap::DiscOverlap;
use crate::part::load::{Load, Resistance};
use crate::scalar::Scalar;
use crate::scene::closed_form::{ClosedForm, Reason, Validity, ratio};
use crate::scene::rectified::{Needs, RegularMotion};

/// Number of steps in a quarter of a turn.
const STEPS: usize = 4;
/// Number of points for the overlap: ends and middles of the steps, from the turning point to the centre.
const PLACES: usize = 2 * STEPS + 1;
/// Cosines of the points; in reverse order, their sines.
const COSINES: [f64; PLACES] = [
    1.0,
    0.980_785_280_403_230_4,
    0.923_879_532_511_286_7,
    0.831_469_612_302_545_2,
    core::f64::consts::FRAC_1_SQRT_2,
    0.555_570_233_019_602_2,
    0.382_683_432_365_089_8,
    0.195_090_322_016_128_27,
    0.0,
];
/// Length of a step in radians.
const STEP: f64 = core::f64::consts::FRAC_PI_2 / STEPS as f64;
/// Largest valid amplitude, as a part of the diameter.
const REACH: f64 = 0.9;
/// Largest valid third harmonic, as a part of the first.
const THIRD: f64 = 0.03;
/// Largest valid damping ratio.
const DAMPING: f64 = 0.9;
/// Most iterations for the amplitude.
const MOST_ATTEMPTS: u32 = 12;
/// Tolerance of the balance relative to the acceleration.
const TOLERANCE: f64 = 1e-4;

/// Friction and current from one turning point to the other.
struct HalfTurn<S> {
    /// `f̄` in m/s².
    friction: S,
    /// Stiffness per modal mass due to the lag of the friction, in 1/s².
    stiffness: S,
    /// Mean of `(dq/dθ)²` in charge units squared.
    current_square: S,
    /// Charge at the turning point, in charge units.
    charge: S,
}

/// Den Hartog's motion between two turning points.
struct Orbit<S> {
    /// `X − p_c`, with the forced motion `p_c cos θ + p_s sin θ`, in m.
    drop: S,
    /// `p_s` in m.
    lagging: S,
    /// `Re D`, `Im D` and `|D|²`.
    detuning: S,
    across: S,
    norm: S,
    /// Stiffness per mass in 1/s².
    stiffness: S,
}

/// The base acceleration that an amplitude requires, times `κ` in m/s², and the requirements of its regime.
struct Demand<S> {
    acceleration: S,
    /// Derivative of the acceleration by the amplitude at constant friction, in 1/s².
    rise: S,
    /// Static friction at the turning point over the force on the slider.
    hold: S,
    /// Third harmonic over the first.
    third: S,
    current_square: S,
}

impl<S: Scalar, P: Parts<S>> Sliding<S, P> {
    /// Mean power under the base acceleration `amplitude · sin(2π · frequency · t)`, in m/s² and Hz, of the motion
    /// without stick that stays on the active patch; exactly 0 if static friction holds the slider from the start.
    ///
    /// Up to a dozen iterations for the amplitude, most often two or three, of some 1700 additions and
    /// multiplications and 60 divisions each. With an open load the charge is that of the slider at the centre.
    #[must_use]
    pub fn closed_form(&self, amplitude: S, frequency: S) -> ClosedForm<S> {
        let omega = frequency * S::from_f64(core::f64::consts::TAU);
        let drive = self.base_coupling * amplitude.abs();
        let at_rest = self.circuit(true, S::ZERO, S::ZERO);
        let held = ratio(drive, self.static_friction(&at_rest)[0]);
        if held <= S::ONE {
            return ClosedForm {
                mean_power: S::ZERO,
                rms_voltage: S::ZERO,
                amplitude: S::ZERO,
                validity: Validity::Holds { margin: held },
            };
        }
        let twice = S::from_f64(2.0 * DAMPING) * self.angular_frequency;
        let damping = self.damping_per_mass / twice;
        let (reached, demand, left) = self.reached(drive, omega);
        let (mean_power, rms_voltage) = self.electrical(reached, demand.current_square, omega);
        ClosedForm {
            mean_power,
            rms_voltage,
            amplitude: reached,
            validity: Validity::of([
                (Reason::NotBalanced, left * S::from_f64(1.0 / TOLERANCE)),
                (Reason::LeavesOverlap, reached * self.per_diameter * S::from_f64(1.0 / REACH)),
                (Reason::Sticks, demand.hold),
                (Reason::HigherHarmonics, demand.third * S::from_f64(1.0 / THIRD)),
                (Reason::Overdamped, damping),
            ]),
        }
    }

    /// The amplitude for a drive in m/s², its demand, and the residual of the balance relative to the drive. For a
    /// drive above that of the largest amplitude, the largest amplitude; for a drive below that of the smallest
    /// amplitude, the smallest, as a motion that sticks.
    fn reached(&self, drive: S, omega: S) -> (S, Demand<S>, S) {
        let half = S::from_f64(0.5);
        // The bracket of the amplitude, and whether each end has been tried.
        let (mut low, mut high) = (S::from_f64(1e-3) * self.diameter, S::from_f64(0.99) * self.diameter);
        let (mut low_tried, mut high_tried) = (false, false);
        // The first guess uses the friction at the centre, the first iteration that of the guess.
        let at_centre = self.circuit(true, S::ZERO, S::ZERO);
        let [normal, ..] = self.normal(&at_centre);
        let friction = self.friction.kinetic_coefficient(S::ONE) * normal;
        let orbit = self.between_turns(friction, S::ZERO, omega);
        let least = (drive * drive / orbit.norm - orbit.lagging * orbit.lagging).sqrt() + orbit.drop;
        let mut at = least.max(low).min(half * high);
        let mut before: Option<(S, S)> = None;
        let mut attempt = 0;
        loop {
            let mut demand = self.demand(at, omega);
            let over = demand.acceleration - drive;
            let left = over.abs() / drive;
            attempt += 1;
            if left <= S::from_f64(TOLERANCE) || attempt >= MOST_ATTEMPTS {
                return (at, demand, left);
            }
            let above = over > S::ZERO;
            if above && at <= low {
                demand.hold = S::INFINITY;
                return (at, demand, S::ZERO);
            }
            if !above && at >= high {
                return (at, demand, S::ZERO);
            }
            if above {
                (high, high_tried) = (at, true);
            } else {
                (low, low_tried) = (at, true);
            }
            let rise = before.map_or(demand.rise, |(place, over_there)| (over - over_there) / (at - place));
            before = Some((at, over));
            let next = at - over / rise;
            // A secant beyond an untried end leads to that end; beyond a tried end, to bisection.
            at = if rise > S::ZERO && next > low && next < high {
                next
            } else if above {
                if low_tried { half * (low + high) } else { low }
            } else if high_tried {
                half * (low + high)
            } else {
                high
            };
        }
    }

    /// The demand of an amplitude.
    fn demand(&self, amplitude: S, omega: S) -> Demand<S> {
        let turn = self.half_turn(amplitude, omega);
        let orbit = self.between_turns(turn.friction, turn.stiffness, omega);
        let forced = amplitude - orbit.drop;
        let square = orbit.norm * (forced * forced + orbit.lagging * orbit.lagging);
        let acceleration = square.sqrt();
        // At the turning point: spring and base against static friction.
        let pull = orbit.stiffness * amplitude - orbit.detuning * forced - orbit.across * orbit.lagging;
        let circuit = self.circuit(true, amplitude, turn.charge);
        let [holding, _] = self.static_friction(&circuit);
        // The third harmonic of a square wave is a third of its first harmonic.
        let third = S::from_f64(2.0 / 3.0 * core::f64::consts::FRAC_2_PI) * turn.friction
            / ((orbit.stiffness - S::from_f64(9.0) * omega * omega).abs() * amplitude);
        Demand {
            acceleration,
            rise: orbit.norm * forced / acceleration,
            hold: if pull > S::ZERO { holding / pull } else { S::INFINITY },
            third,
            current_square: turn.current_square,
        }
    }

    /// The motion between two turning points under a constant friction, with a stiffness in addition to that of the
    /// beam.
    fn between_turns(&self, friction: S, stiffness: S, omega: S) -> Orbit<S> {
        let two = S::from_f64(2.0);
        let stiffness = (self.stiffness_per_mass + stiffness).max(S::TINY);
        let natural = stiffness.sqrt();
        let damping = self.damping_per_mass / (natural + natural);
        // The free motion over half a period: a11 − 1, a12, a21, a22 − 1.
        let free = ModalStep::new(natural, damping, S::from_f64(core::f64::consts::PI) / omega);
        let [a, b, c, d] = [
            two + free.displacement_by_displacement,
            free.displacement_by_velocity,
            free.velocity_by_displacement,
            two + free.velocity_by_velocity,
        ];
        // (1 + a11) u + a12 w = (a11 − 1) f, a21 u + (1 + a22) w = a21 f: u = X − p_c, w = −Ω p_s of the forced part
        // p_c cos Ωt + p_s sin Ωt.
        let per_determinant = friction / (stiffness * (a * d - b * c));
        let drop = ((a - two) * d - b * c) * per_determinant;
        let lagging = -two * c * per_determinant / omega;
        let detuning = (natural - omega) * (natural + omega);
        let across = self.damping_per_mass * omega;
        Orbit { drop, lagging, detuning, across, stiffness, norm: detuning * detuning + across * across }
    }

    /// Friction, its lag and the current from `x = X` to `x = −X`.
    fn half_turn(&self, amplitude: S, omega: S) -> HalfTurn<S> {
        let tribo = self.surface.tribo_charge;
        let overlaps = COSINES.map(S::from_f64).map(|cosine| self.overlap(true, amplitude * cosine));
        let active = |step: usize, stage: usize| {
            let place = if step < STEPS { 2 * step + stage } else { 4 * STEPS - 2 * step - stage };
            overlaps.get(place).copied().unwrap_or(DiscOverlap { active: S::ONE, inert: S::ZERO })
        };
        let lag = match self.load.resistance() {
            Resistance::Short => Some(S::ZERO),
            Resistance::Finite(_) => Some(omega / self.circuit_rate),
            Resistance::Open => None,
        };
        let step_map = |step: usize| {
            let overlap = [0, 1, 2].map(|stage| active(step, stage));
            lag.map_or(Increments::NONE, |lag| {
                Increments::new(&overlap.map(|one| one.active), lag * S::from_f64(1.0 / STEP), tribo)
            })
        };
        // The charge after half a turn is affine in the charge before, with the slope 1 − e: the fixed point is
        // periodic.
        let (mut forgotten, mut gained) = (S::ZERO, S::ZERO);
        let maps: [Increments<S>; 2 * STEPS] = core::array::from_fn(step_map);
        for map in &maps {
            let [constant, by_charge] = map.over_step();
            gained = gained + constant + by_charge * gained;
            forgotten = forgotten - by_charge * (S::ONE - forgotten);
        }
        let mut charge = if forgotten > S::ZERO { gained / forgotten } else { tribo };
        let at_turn = tribo - charge;
        let (weights, stages) = (WEIGHTS.map(S::from_f64), STAGES.map(|row| row.map(S::from_f64)));
        let (mut work, mut lagging, mut square) = (S::ZERO, S::ZERO, S::ZERO);
        for (step, map) in maps.iter().enumerate() {
            let rates = map.at(charge);
            for (stage, (weight, row)) in weights.into_iter().zip(&stages).enumerate() {
                let of_stage = sum(row, &rates);
                let transferred = tribo - charge - of_stage;
                let place = 2 * step + stage;
                let (cosine, sine) = cosine_and_sine::<S>(place);
                let acting =
                    self.acting(active(step, stage), place < PLACES - 1, amplitude * cosine, transferred);
                let weighted = weight * acting;
                work += weighted * sine;
                lagging += weighted * cosine;
                let rate = rates.get(stage).copied().unwrap_or(S::ZERO);
                square += weight * rate * rate;
            }
            charge += sum(&weights, &rates);
        }
        HalfTurn {
            friction: S::from_f64(0.5 * STEP) * work,
            stiffness: S::from_f64(-STEP * core::f64::consts::FRAC_2_PI) * lagging / amplitude,
            // The rates are per step.
            current_square: square * S::from_f64(core::f64::consts::FRAC_1_PI / STEP),
            charge: at_turn,
        }
    }

    /// Friction on a slider moving backward, and the lateral force of the field, per modal mass.
    fn acting(&self, overlap: DiscOverlap<S>, ahead: bool, displacement: S, transferred: S) -> S {
        let circuit: Circuit<S> = self.circuit_of(overlap, transferred);
        let [lateral, _] = self.lateral(ahead, displacement, &circuit);
        let [normal, ..] = self.normal(&circuit);
        self.friction.kinetic_coefficient(overlap.active) * normal + lateral
    }

    /// Mean power in W and root mean square of the voltage in V.
    fn electrical(&self, amplitude: S, current_square: S, omega: S) -> (S, S) {
        match self.load.resistance() {
            Resistance::Short => (S::ZERO, S::ZERO),
            Resistance::Finite(resistance) => {
                let current = omega * self.charge_unit;
                let square = current_square * current * current;
                (square * resistance, square.sqrt() * resistance)
            }
            Resistance::Open => {
                // Mean of the square by Simpson's rule over a quarter of a turn, step by step.
                let square = |place: usize| {
                    let (cosine, _) = cosine_and_sine::<S>(place);
                    let voltage = self.circuit(true, amplitude * cosine, S::ZERO).voltage;
                    voltage * voltage
                };
                let mut sum = S::ZERO;
                for step in 0..STEPS {
                    let ends = square(2 * step) + square(2 * step + 2);
                    sum += S::from_f64(1.0 / (6.0 * STEPS as f64))
                        * (ends + S::from_f64(4.0) * square(2 * step + 1));
                }
                (S::ZERO, self.field * sum.sqrt())
            }
        }
    }
}

impl<S: Scalar, P: Parts<S>> RegularMotion<S> for Sliding<S, P> {
    const BEYOND: Reason = Reason::LeavesOverlap;
    const COEXISTS: bool = false;

    fn rest(&self) -> [S; 2] {
        [S::ZERO, S::ZERO]
    }

    fn room(&self, _mean: S) -> S {
        S::from_f64(REACH) * self.diameter
    }

    fn moving(&self, forward: bool, position: S) -> Mode {
        Mode::sliding(forward, position)
    }

    fn grip(&self, position: S, charge: S, acceleration: S) -> [S; 2] {
        let [[pull, _], [hold, _]] = self.balance(position, charge, acceleration);
        [pull, hold]
    }

    /// Den Hartog's motion under the constant friction that does the work of the forces other than spring and damping,
    /// and the stiffness of their lag.
    fn needs(&self, amplitude: S, angular_frequency: S, [along, across]: [S; 2]) -> Needs<S> {
        let viscous = self.damping_per_mass * angular_frequency * amplitude;
        let friction = S::from_f64(0.5 * core::f64::consts::FRAC_PI_2) * (across - viscous);
        let stiffness = -(along / amplitude + self.stiffness_per_mass);
        let orbit = self.between_turns(friction, stiffness, angular_frequency);
        let forced = amplitude - orbit.drop;
        let drive = (orbit.norm * (forced * forced + orbit.lagging * orbit.lagging)).sqrt();
        let pull = orbit.stiffness * amplitude - orbit.detuning * forced - orbit.across * orbit.lagging;
        Needs { drive, is_above: orbit.detuning < S::ZERO, pull: pull.max(S::ZERO) }
    }
}

/// Cosine and sine at a point between the two turning points.
fn cosine_and_sine<S: Scalar>(place: usize) -> (S, S) {
    let cosines = COSINES.map(S::from_f64);
    let entry = |index: usize| cosines.get(index).copied().unwrap_or(S::ZERO);
    let last = PLACES - 1;
    if place <= last {
        (entry(place), entry(last - place))
    } else {
        (-entry(2 * last - place), entry(place - last))
    }
}

#[cfg(test)]
mod tests;
