//! The events of a slip: the stop, the middle, and the end of the overlap.

use diffsol::error::DiffsolError;

use crate::triboelectric::{Branch, Dense, Guards, Motion, Sample};
use harvester_scene::root::far_side;

/// Part of two patch radii that a displacement must not reach. A ten-millionth before its end the overlap is
/// 4e-11 of a disc, and with it the time constant of the circuit: no device is left there, and no integrator
/// can follow the rates.
pub(super) const REACH: f64 = 1.0 - 1e-7;

/// The end of a slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum SlipEvent {
    /// The velocity is zero.
    Stop,
    /// The slider passes the middle.
    Middle,
    /// The overlap ends, to [`REACH`].
    End,
}

/// The search for the end of a slip.
///
/// A slip begins without velocity after a stop, and in the middle after passing it: the search ignores an event
/// at the place where the slip began until the slider has left that place.
#[derive(Debug)]
pub(crate) struct SlipGuards {
    branch: Branch,
    /// Displacement in m at which the overlap ends.
    reach: f64,
    /// Displacement in m and velocity in m/s that count as zero at the start.
    clearance: [f64; 2],
    has_left_middle: bool,
    has_left_rest: bool,
}

impl SlipGuards {
    pub(super) fn new(start: &Motion, radius: f64, clearance: [f64; 2]) -> Self {
        let reach = REACH * 2.0 * radius;
        let branch = start.branch;
        let mut guards = Self { branch, reach, clearance, has_left_middle: false, has_left_rest: false };
        guards.arm(start);
        guards
    }

    fn arm(&mut self, motion: &Motion) {
        let [displacement, velocity] = self.clearance;
        self.has_left_middle |= self.branch.side * motion.position > displacement;
        self.has_left_rest |= self.branch.direction * motion.velocity > velocity;
    }
}

impl Guards for SlipGuards {
    type Event = SlipEvent;

    /// Cuts at the changes of sign of the acceleration: the velocity is monotone in every piece.
    fn cuts(&self, acceleration: &Dense<'_, f64>, from: f64, to: f64) -> Result<Vec<f64>, DiffsolError> {
        let middle = from + 0.5 * (to - from);
        let mut cuts = Vec::new();
        for [left, right] in [[from, middle], [middle, to]] {
            if (acceleration(left)? > 0.0) != (acceleration(right)? > 0.0) {
                cuts.push(far_side(acceleration, left, right)?);
            }
            cuts.push(right);
        }
        Ok(cuts)
    }

    fn event(
        &mut self,
        motion: &Dense<'_, Motion>,
        (begin, _): Sample,
        (end, after): Sample,
    ) -> Result<Option<(f64, SlipEvent)>, DiffsolError> {
        let ([displacement, velocity], reach) = (self.clearance, self.reach);
        let Branch { direction, side } = self.branch;
        let crossing = |value: &dyn Fn(&Motion) -> f64| {
            far_side(|t| Ok::<_, DiffsolError>(value(&motion(t)?)), begin, end)
        };
        let away = side * after.position;
        let place = if away >= reach {
            Some((crossing(&|motion| side * motion.position - reach)?, SlipEvent::End))
        } else if self.has_left_middle && away <= 0.0 {
            Some((crossing(&|motion| side * motion.position)?, SlipEvent::Middle))
        } else {
            // A slider that left to the other side has passed the middle.
            (!self.has_left_middle && away < -displacement).then_some((end, SlipEvent::Middle))
        };
        let onward = direction * after.velocity;
        let rest = if self.has_left_rest && onward <= 0.0 {
            Some((crossing(&|motion| direction * motion.velocity)?, SlipEvent::Stop))
        } else {
            // A slider that is driven back before it has begun to move has stopped.
            (!self.has_left_rest && onward < -velocity).then_some((end, SlipEvent::Stop))
        };
        self.arm(&after);
        Ok(match (place, rest) {
            (Some(place), Some(rest)) if rest.0 < place.0 => Some(rest),
            (place, rest) => place.or(rest),
        })
    }
}
