//! The contact force of one step as a discrete gradient of the contact potential.
//!
//! A unilateral spring of stiffness `k` has the potential `V(g) = k g²/2` for a gap coordinate `g > 0`, and 0
//! for an open gap, `g ≤ 0`. A constant force `F` over a step moves `g` to `g⁺ = g* − H F`. The force
//!
//! ```text
//! F = [V(g⁺) − V(g)] / (g⁺ − g)
//! ```
//!
//! does the work `−[V(g⁺) − V(g)]` exactly. If the rest of the system is propagated exactly for a constant
//! force, a step of any length conserves the total energy. `V` is piecewise quadratic, so the implicit
//! equation has a closed form, without event location or iteration. Discrete gradients: Gonzalez (1996);
//! McLachlan, Quispel and Robidoux (1999). The closed form is derived here.

use crate::scalar::Scalar;

/// The contact force and the gap of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactStep<S> {
    /// Constant force over the step in N, compressive, never negative.
    pub(crate) force: S,
    /// Gap coordinate at the end of the step in m, above zero in contact.
    pub(crate) gap: S,
}

/// The step from the gap coordinate `gap` in m, which would end at `predicted` in m without a force.
///
/// `flexibility` is `H > 0` in m/N, and `stiffness` is `k` in N/m.
#[inline(always)]
pub(crate) fn contact_step<S: Scalar>(gap: S, predicted: S, flexibility: S, stiffness: S) -> ContactStep<S> {
    if gap <= S::ZERO {
        if predicted <= S::ZERO {
            return ContactStep { force: S::ZERO, gap: predicted };
        }
        return touch_down(gap, predicted, flexibility, stiffness);
    }
    let firmness = stiffness * flexibility;
    let per = S::ONE / (S::from_f64(2.0) + firmness);
    let closed = (predicted + predicted - firmness * gap) * per;
    if closed > S::ZERO {
        return ContactStep { force: stiffness * (gap + predicted) * per, gap: closed };
    }
    lift_off(gap, predicted, flexibility, stiffness)
}

/// From open to closed: `A u² − (g* + g) u + g g* = 0` with `A = 1 + kH/2`, the positive root.
#[cold]
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
    ContactStep { force, gap: reached }
}

/// From closed to open: `u² − (g* + g) u + g g* − kHg²/2 = 0`, the root at or below zero.
#[cold]
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
    ContactStep { force: half * stiffness * gap * (gap / (gap - reached)), gap: reached }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn potential(gap: f64, stiffness: f64) -> f64 {
        0.5 * stiffness * gap.max(0.0).powi(2)
    }

    #[test]
    fn the_force_is_the_discrete_gradient_and_moves_the_gap_by_the_flexibility() {
        let gaps = [-1e-5_f64, -1e-7, -1e-9, 0.0, 1e-9, 1e-8, 1e-7, 1e-6];
        for stiffness in [1e3, 1e6, 5e7, 1e12] {
            for flexibility in [1e-14, 1e-11, 1e-9, 1e-6] {
                for gap in gaps {
                    for predicted in gaps {
                        let step = contact_step(gap, predicted, flexibility, stiffness);
                        assert!(step.force >= 0.0 && step.force.is_finite());
                        let scale = gap.abs().max(predicted.abs());
                        let moved = predicted - flexibility * step.force;
                        let size = scale.max(flexibility * step.force);
                        assert!((step.gap - moved).abs() <= 1e-13 * size, "{gap} {predicted} {moved}");
                        let work = step.force * (step.gap - gap);
                        let stored = potential(step.gap, stiffness) - potential(gap, stiffness);
                        let size = potential(scale, stiffness).max(work.abs());
                        assert!((work - stored).abs() <= 1e-13 * size, "{gap} {predicted} {work} {stored}");
                        if gap <= 0.0 && predicted <= 0.0 {
                            assert_eq!(step.force, 0.0);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn single_precision_keeps_the_force_of_a_light_touch() {
        for (gap, predicted) in [(-1e-9, 1e-9), (-1e-12, 1e-7), (1e-8, -1e-8), (1e-10, 2e-10)] {
            for flexibility in [1e-14, 1e-11, 1e-9] {
                let fine = contact_step::<f64>(gap, predicted, flexibility, 5e7);
                let coarse = contact_step::<f32>(gap as f32, predicted as f32, flexibility as f32, 5e7);
                assert!((f64::from(coarse.force) / fine.force - 1.0).abs() < 3e-5, "{gap} {predicted}");
            }
        }
        assert_eq!(contact_step(0.0_f32, 0.0, 1e-9, 1e7).force, 0.0);
    }
}
