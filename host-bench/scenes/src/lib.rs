//! Scenes, the options of a run and its outcome: what the embedded core, the reference and the peers share on the host.

pub mod base_motion;
pub mod input;
pub mod keys;
pub mod market;
pub mod method;
pub mod name;
pub mod outcome;
pub mod progress;
pub mod rainflow;
pub mod root;
pub mod scene_file;
