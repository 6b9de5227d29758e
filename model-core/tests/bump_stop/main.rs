//! The bump-stop scene: its numbers, and what holds of it at any step.

mod invariants;
mod numbers;
mod setup;
