//! The reference for the bump-stop harvester.

mod modes;

pub(crate) use self::modes::BumpStopModes;
