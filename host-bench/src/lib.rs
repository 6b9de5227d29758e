//! The host side of `model-core`: scene files, the independent reference, and the command line.

mod base_motion;
mod budget;
pub mod closed_form;
pub mod command;
pub mod embedded;
pub mod figures;
pub mod method;
pub mod on_target;
pub mod outcome;
mod peer;
pub mod reference;
mod report;
mod root;
pub mod run;
pub mod scene_file;
mod stability;
pub mod steady_state;
#[cfg(test)]
mod test_support;
mod work_precision;
