//! The bump-stop scene: its numbers, and its properties at any step.

mod invariants;
mod numbers;
mod setup;
mod tip_mass;
