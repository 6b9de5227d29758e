//! The impacts of a flight.

use diffsol::error::DiffsolError;

use crate::triboelectric::{Dense, Guards, Motion, Sample};
use harvester_scene::root::far_side;

/// The mass hits the dielectric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Impact;

/// The search for an impact.
///
/// A flight that starts at closed gap without velocity is a release: gap, velocity and acceleration are all
/// zero, so no impact is looked for until the mass has left.
#[derive(Debug)]
pub(crate) struct ImpactSearch {
    /// Gap in m that counts as closed at a release.
    clearance: f64,
    /// Whether the mass has left the dielectric.
    has_left: bool,
}

impl ImpactSearch {
    pub(super) fn new(start: &Motion, clearance: f64) -> Self {
        Self { clearance, has_left: start.position > 0.0 || start.velocity != 0.0 }
    }
}

impl Guards for ImpactSearch {
    type Event = Impact;

    fn event(
        &mut self,
        motion: &Dense<'_, Motion>,
        (begin, before): Sample,
        (end, after): Sample,
    ) -> Result<Option<(f64, Impact)>, DiffsolError> {
        if !self.has_left {
            self.has_left = after.velocity > 0.0 && after.position > self.clearance;
            let pressed_back = after.position < -self.clearance;
            return Ok(pressed_back.then_some((end, Impact)));
        }
        if after.position > 0.0 || after.position >= before.position {
            return Ok(None);
        }
        if before.position <= 0.0 {
            return Ok(Some((begin, Impact)));
        }
        let hit = far_side(|t| Ok::<_, DiffsolError>(motion(t)?.position), begin, end)?;
        Ok(Some((hit, Impact)))
    }
}
