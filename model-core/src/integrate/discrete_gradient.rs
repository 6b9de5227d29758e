//! The contact force of one step as a discrete gradient of the contact potential.
//!
//! A unilateral spring of stiffness `k` has the potential `V(g) = k g²/2` for a gap coordinate `g > 0`, and 0
//! for an open gap, `g ≤ 0`. The force over a step is linear, `F + T P(c)` with `P(c) = 2c − 1` for `c` from 0 to 1. It
//! acts on the gap at the end, `g⁺`, and on the first moment `m = ∫ P ġ dt` of its rate:
//!
//! ```text
//! g⁺ = g* − a F − b T        m = m* + b F − d T
//! ```
//!
//! `a`, `b` and `d` belong to the rest of the system ([`Flexibility`]), which is propagated exactly for this force. A
//! step of any length conserves the total energy if the force does the work `F (g⁺ − g) + T m = V(g) − V(g⁺)` on the
//! rest, with the sign of a compressive force. There are three cases, each in closed form:
//!
//! * **Closed at both ends.** The spring follows the gap with the rate that is linear and has the same two moments,
//!   `w = g + (g⁺ − g) c + 3 m (c² − c)`. `F` and `T` are the moments of `k w`, so `F = k (g + (g⁺ − g)/2 − m/2)`,
//!   `T = k (g⁺ − g)/2`. A spring that follows the projected rate stores the work of its projected force.
//! * **Touch-down and lift-off.** The force is a ramp from touch-down, or to lift-off, on the part `p` of the step: its
//!   projection has `T = ±(3 − 2p) F`. `F` follows from the energy, a quadratic equation.
//! * **Where neither has a solution** the force is constant, `T = 0`: the discrete gradient `F = [V(g⁺) − V(g)]/(g⁺ −
//!   g)`. `V` is piecewise quadratic, so it has a closed form in all cases.
//!
//! No case needs event location or iteration. Discrete gradients: Gonzalez (1996); McLachlan, Quispel and Robidoux
//! (1999). Energy-preserving methods with more moments: Hairer (2010). The closed forms are derived here.

use crate::integrate::modal::ModalStep;
use crate::scalar::Scalar;

/// The contact force and the gap of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactStep<S> {
    /// Mean force over the step in N, compressive, never negative.
    pub(crate) force: S,
    /// Half the rise of the force over the step in N.
    pub(crate) tilt: S,
    /// Gap coordinate at the end of the step in m, above zero in contact.
    pub(crate) gap: S,
}

/// The response of the gap coordinate to the force of a step, in m/N; of another coordinate in its unit, or to another cause.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Flexibility<S> {
    /// `a > 0`: fall of the gap at the end per mean force.
    pub(crate) constant: S,
    /// `b`: fall of the gap at the end per tilt, and rise of the moment per mean force.
    pub(crate) tilted: S,
    /// `d ≥ 0`: fall of the moment per tilt.
    pub(crate) moment: S,
}

impl<S: Scalar> Flexibility<S> {
    /// Adds that of a mode, with the product of the weights of effect and cause.
    pub(crate) fn add(&mut self, modal: &ModalStep<S>, weight: S) {
        self.constant += weight * modal.response;
        self.tilted += weight * modal.tilt[0];
        self.moment += weight * modal.tilt[2];
    }

    /// Fall of the coordinate at the end under a force, `[mean, tilt]`.
    #[inline]
    pub(crate) fn fall(&self, [mean, tilt]: [S; 2]) -> S {
        self.constant * mean + self.tilted * tilt
    }

    /// Fall of the first moment of the coordinate's rate under a force, `[mean, tilt]`.
    #[inline]
    pub(crate) fn fall_of_moment(&self, [mean, tilt]: [S; 2]) -> S {
        self.moment * tilt - self.tilted * mean
    }
}

/// A step without contact force: gap coordinates in m at the start and at the end, and the first moment in m of the rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Approach<S> {
    pub(crate) gap: S,
    pub(crate) predicted: S,
    pub(crate) moment: S,
}

/// The contact of a step that touches: the gap is closed at the start or would be at the end. `stiffness` is `k` in N/m.
#[inline]
pub(crate) fn contact_step<S: Scalar>(
    approach: &Approach<S>,
    flexibility: &Flexibility<S>,
    stiffness: S,
) -> ContactStep<S> {
    let Approach { gap, predicted, .. } = *approach;
    let (two, three) = (S::from_f64(2.0), S::from_f64(3.0));
    let by_ramp = if gap > S::ZERO {
        let closed = closed(approach, flexibility, stiffness);
        if closed.gap > S::ZERO && closed.force >= S::ZERO {
            return closed;
        }
        let opens = !(closed.gap > S::ZERO);
        let ratio = two * gap / (gap - closed.gap) - three;
        opens.then(|| lift_off_ramp(approach, flexibility, stiffness, ratio)).flatten()
    } else {
        touch_down_ramp(approach, flexibility, stiffness, three - two * predicted / (predicted - gap))
    };
    by_ramp.unwrap_or_else(|| constant_force(gap, predicted, flexibility.constant, stiffness))
}

/// Closed at both ends, if the gap that it gives is above zero: two linear equations.
#[inline]
fn closed<S: Scalar>(approach: &Approach<S>, flexibility: &Flexibility<S>, stiffness: S) -> ContactStep<S> {
    let half = S::from_f64(0.5);
    let motion = approach.predicted - approach.gap;
    let start = approach.gap - half * approach.moment;
    let firmness = stiffness * flexibility.constant;
    let skew = S::ONE + half * stiffness * flexibility.tilted;
    let bend = half * (S::ONE + half * stiffness * flexibility.moment);
    // Positive: `firmness` and `bend` are.
    let per = S::ONE / (skew * skew + firmness * bend);
    let moved = (skew * motion - firmness * start) * per;
    ContactStep {
        force: stiffness * (skew * start + bend * motion) * per,
        tilt: half * stiffness * moved,
        gap: approach.gap + moved,
    }
}

/// The coefficients of a step whose half rise of the force is `T = ratio · F`.
struct Ramp<S> {
    /// `h = a + b ratio`: the gap is `g* − h F`.
    lever: S,
    /// `e = a + d ratio²`.
    loss: S,
    /// `g* − g + ratio m*`: the work of the force on the free motion is `motion · F`.
    motion: S,
}

impl<S: Scalar> Ramp<S> {
    #[inline]
    fn new(approach: &Approach<S>, flexibility: &Flexibility<S>, ratio: S) -> Self {
        Self {
            lever: flexibility.constant + flexibility.tilted * ratio,
            loss: flexibility.constant + flexibility.moment * ratio * ratio,
            motion: approach.predicted - approach.gap + ratio * approach.moment,
        }
    }
}

/// From open to closed with `T = ratio · F`. With `h = a + b ratio` and `e = a + d ratio²`, the gap is `u = g* − h F`,
/// and `k u²/2 = F (g* − g + ratio m* − e F)`: the smaller root.
#[inline]
fn touch_down_ramp<S: Scalar>(
    approach: &Approach<S>,
    flexibility: &Flexibility<S>,
    stiffness: S,
    ratio: S,
) -> Option<ContactStep<S>> {
    let predicted = approach.predicted;
    let Ramp { lever, loss, motion } = Ramp::new(approach, flexibility, ratio);
    let pull = stiffness * predicted;
    let square = motion * motion + (pull + pull) * (lever * motion - loss * predicted);
    let sum = pull * lever + motion;
    if !(square >= S::ZERO && sum > S::ZERO) {
        return None;
    }
    let force = pull * predicted / (sum + square.sqrt());
    let gap = predicted - lever * force;
    (gap >= S::ZERO).then(|| ContactStep { force, tilt: ratio * force, gap })
}

/// From closed to open with `T = ratio · F`: `e F² − (g* − g + ratio m*) F − k g²/2 = 0`, the positive root.
#[inline]
fn lift_off_ramp<S: Scalar>(
    approach: &Approach<S>,
    flexibility: &Flexibility<S>,
    stiffness: S,
    ratio: S,
) -> Option<ContactStep<S>> {
    let Approach { gap, predicted, .. } = *approach;
    let Ramp { lever, loss, motion } = Ramp::new(approach, flexibility, ratio);
    let stored = stiffness * gap * gap;
    let root = (motion * motion + (loss + loss) * stored).sqrt();
    if !(motion < S::ZERO) {
        return None;
    }
    let force = stored / (root - motion);
    let end = predicted - lever * force;
    (end <= S::ZERO).then(|| ContactStep { force, tilt: ratio * force, gap: end })
}

/// As [`contact_step`] with a constant force, which is continuous in the gap that is predicted. `flexibility` is `a > 0` in m/N.
#[cold]
pub(crate) fn constant_force<S: Scalar>(
    gap: S,
    predicted: S,
    flexibility: S,
    stiffness: S,
) -> ContactStep<S> {
    if gap <= S::ZERO {
        return touch_down(gap, predicted, flexibility, stiffness);
    }
    let firmness = stiffness * flexibility;
    let per = S::ONE / (S::from_f64(2.0) + firmness);
    let closed = (predicted + predicted - firmness * gap) * per;
    if closed > S::ZERO {
        return ContactStep { force: stiffness * (gap + predicted) * per, tilt: S::ZERO, gap: closed };
    }
    lift_off(gap, predicted, flexibility, stiffness)
}

/// From open to closed: `A u² − (g* + g) u + g g* = 0` with `A = 1 + kH/2`, the positive root.
fn touch_down<S: Scalar>(gap: S, predicted: S, flexibility: S, stiffness: S) -> ContactStep<S> {
    let (half, four) = (S::from_f64(0.5), S::from_f64(4.0));
    let leading = S::ONE + half * stiffness * flexibility;
    let sum = predicted + gap;
    let product = -gap * predicted;
    let root = (sum * sum + four * leading * product).sqrt();
    // The form of the root without cancellation.
    let reached =
        if sum >= S::ZERO { half * (sum + root) / leading } else { (product + product) / (root - sum) };
    // V(u)/(u − g), because (g* − u)/H cancels. Without motion the force is zero.
    let apart = reached - gap;
    let force = if apart > S::ZERO { half * stiffness * reached * (reached / apart) } else { S::ZERO };
    ContactStep { force, tilt: S::ZERO, gap: reached }
}

/// From closed to open: `u² − (g* + g) u + g g* − kHg²/2 = 0`, the root at or below zero.
fn lift_off<S: Scalar>(gap: S, predicted: S, flexibility: S, stiffness: S) -> ContactStep<S> {
    let (half, two) = (S::from_f64(0.5), S::from_f64(2.0));
    let firmness = stiffness * flexibility;
    let sum = predicted + gap;
    let difference = predicted - gap;
    let root = (difference * difference + two * firmness * gap * gap).sqrt();
    let reached = if sum > S::ZERO {
        gap * (two * predicted - firmness * gap) / (sum + root)
    } else {
        half * (sum - root)
    };
    ContactStep { force: half * stiffness * gap * (gap / (gap - reached)), tilt: S::ZERO, gap: reached }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn potential(gap: f64, stiffness: f64) -> f64 {
        0.5 * stiffness * gap.max(0.0).powi(2)
    }

    /// A step that touches; `None` if it stays open.
    fn step<S: Scalar>(
        [gap, predicted, moment]: [S; 3],
        flexibility: Flexibility<S>,
        stiffness: S,
    ) -> Option<ContactStep<S>> {
        let touches = gap > S::ZERO || predicted > S::ZERO;
        touches.then(|| contact_step(&Approach { gap, predicted, moment }, &flexibility, stiffness))
    }

    #[test]
    fn the_force_does_the_work_of_the_potential_and_moves_the_gap_by_the_flexibility() {
        let gaps = [-1e-5_f64, -1e-7, -1e-9, 0.0, 1e-9, 1e-8, 1e-7, 1e-6];
        let mut tilted = [0; 3];
        for stiffness in [1e3, 1e6, 5e7, 1e12] {
            for a in [1e-14, 1e-11, 1e-9, 1e-6] {
                for (b, d) in [(0.0, 0.0), (-0.3 * a, 0.01 * a), (-0.05 * a, 0.3 * a), (0.4 * a, 0.1 * a)] {
                    for (gap, predicted, bent) in gaps
                        .iter()
                        .flat_map(|&gap| gaps.map(|predicted| (gap, predicted)))
                        .flat_map(|(gap, predicted)| [-0.2, 0.0, 0.2].map(|bent| (gap, predicted, bent)))
                    {
                        let moment = bent * (predicted - gap);
                        let flexibility = Flexibility { constant: a, tilted: b, moment: d };
                        let Some(step) = step([gap, predicted, moment], flexibility, stiffness) else {
                            continue;
                        };
                        let ContactStep { force, tilt, gap: reached } = step;
                        assert!(force >= 0.0 && force.is_finite());
                        let moved = predicted - a * force - b * tilt;
                        let size = gap.abs().max(predicted.abs()).max(a * force);
                        assert!(
                            (reached - moved).abs() <= 1e-12 * size,
                            "{gap} {predicted} {reached} {moved}"
                        );
                        let work = force * (reached - gap) + tilt * (moment + b * force - d * tilt);
                        let stored = potential(reached, stiffness) - potential(gap, stiffness);
                        let size = potential(size, stiffness).max(force * size).max(tilt.abs() * size);
                        assert!((work - stored).abs() <= 1e-12 * size, "{gap} {predicted} {work} {stored}");
                        let case = usize::from(gap > 0.0) + usize::from(gap > 0.0 && reached > 0.0);
                        tilted[case] += u32::from(tilt != 0.0);
                    }
                }
            }
        }
        assert!(tilted.iter().all(|&count| count > 500), "{tilted:?}");
    }

    /// A mass on the spring, which it reaches and leaves within a few steps: the error of the impact falls with the
    /// fourth power of the step while the contact is closed.
    #[test]
    fn closed_steps_are_of_fourth_order() {
        let (mass, stiffness, speed) = (1e-4, 1e6, 0.05_f64);
        let omega = (stiffness / mass).sqrt();
        let error = |count: u32| {
            let h = 2.0 / omega / f64::from(count);
            // A free mass: s = h²/2, ρ = h³/6.
            let flexibility =
                Flexibility { constant: 0.5 * h * h / mass, tilted: -h * h / (6.0 * mass), moment: 0.0 };
            let (mut gap, mut rate) = (0.2 * speed / omega, speed);
            let phase = 0.2_f64.atan();
            let amplitude = (0.2_f64.powi(2) + 1.0).sqrt() * speed / omega;
            for _ in 0..count {
                let approach = Approach { gap, predicted: gap + rate * h, moment: 0.0 };
                let step = contact_step(&approach, &flexibility, stiffness);
                (gap, rate) = (step.gap, rate - step.force * h / mass);
            }
            (gap - amplitude * (phase + 2.0).sin()).abs() / amplitude
        };
        let ratio = error(8) / error(16);
        assert!((14.0..18.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn single_precision_keeps_the_force_of_a_light_touch() {
        for [gap, predicted] in [[-1e-9, 1e-9], [-1e-12, 1e-7], [1e-8, -1e-8], [1e-10, 2e-10]] {
            for a in [1e-14, 1e-11, 1e-9] {
                let flexibility = Flexibility { constant: a, tilted: -0.04 * a, moment: 0.3 * a };
                let single = Flexibility {
                    constant: flexibility.constant as f32,
                    tilted: flexibility.tilted as f32,
                    moment: flexibility.moment as f32,
                };
                let fine = step([gap, predicted, 0.0], flexibility, 5e7).expect("it touches");
                let coarse = step([gap as f32, predicted as f32, 0.0], single, 5e7_f32).expect("it touches");
                assert!((f64::from(coarse.force) / fine.force - 1.0).abs() < 3e-5, "{gap} {predicted}");
            }
        }
    }
}
