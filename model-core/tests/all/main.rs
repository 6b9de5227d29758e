//! The tests of the public interface, in one binary: a scene and a method that several tests use are compiled once.

mod arbitrary_images;
mod bouncing_ball;
mod bridge;
mod bridged;
mod bridged_estimator;
mod bump_stop;
mod bump_stop_rectifier;
mod bump_stop_store;
mod common;
mod dry_friction;
mod energy_budget;
mod energy_correction;
mod estimator;
mod exponential_radau;
mod hidden_crossings;
mod node_image;
mod prothero_robinson;
mod rectified;
mod rectified_limits;
mod resuming;
mod rounding_of_the_charge;
mod smooth_problems;
mod snapshots;
mod spring_stop;
mod step_failures;
