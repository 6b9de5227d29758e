//! The bump-stop scene.

pub mod building;
pub mod modal_run;
pub mod parts;
pub mod scenes;
