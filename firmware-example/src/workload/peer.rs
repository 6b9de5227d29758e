//! The smooth contact-separation scene by model-core and by the crate numeris.

#[cfg(all(target_os = "none", feature = "peer"))]
mod rodas4;

use super::{Visit, contact_separation};

/// Tolerances of numeris, relative and absolute.
pub const TOLERANCES: [f32; 4] = [1e-3, 1e-4, 1e-5, 1e-6];

/// The runs of model-core and then, in a firmware with the feature `peer`, those of numeris.
pub fn smooth(visit: Visit<'_>) -> Option<()> {
    contact_separation::smooth(visit)?;
    #[cfg(all(target_os = "none", feature = "peer"))]
    for tolerance in TOLERANCES {
        visit(&mut rodas4::Rodas4::new(tolerance));
    }
    Some(())
}
