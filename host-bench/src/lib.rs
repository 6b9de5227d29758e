//! The host side of `model-core`: scene files, the independent reference, and the command line.

pub mod accuracy;
mod attractors;
mod budget;
pub mod closed_form;
pub mod command;
mod export;
pub mod figures;
pub mod findings;
mod fit;
pub mod map;
mod motion;
mod needs;
pub mod on_target;
mod optimise;
mod peer;
mod report;
mod resolution;
mod rows;
pub mod run;
pub mod seeds;
mod shift;
pub mod simulated_node;
pub mod stability;
pub mod validation;
mod work_precision;

pub use harvester_engine::{embedded, steady_state};
pub use harvester_reference as reference;
use harvester_scene::{base_motion, input, name};
pub use harvester_scene::{method, outcome, scene_file};
