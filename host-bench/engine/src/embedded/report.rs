//! What the report of a run takes from the scene.

use super::bump_stop::Clamp;
use super::excitation::{HostExcitation, Setting};
use super::limits::Gauge;
use harvester_scene::outcome::Particular;
use model_core::clock::Instant;
use model_core::energy::{Residual, RunMeter};
use model_core::observer::{AcceptedStep, Outputs};
use model_core::scalar::Scalar;
use model_core::scene::Harvester;

/// What the report of one kind of scene adds to the numbers that every run has.
pub(super) trait Report<S: Scalar, H: Harvester<S>> {
    /// Columns of a trace: time first, the voltage of a storage last.
    fn columns(&self, with_storage: bool) -> &'static [&'static str];

    /// The columns between these two at a fraction of a step, under a base acceleration in m/s².
    fn row(&self, step: &AcceptedStep<'_, S>, fraction: S, acceleration: S) -> [S; 6];

    /// The relative residual of the energy ledger that holds for this scene.
    fn residual(&self, residual: &Residual<S>) -> Option<S>;

    /// Energy in J that an inferred force law created in the window; `None` for a bump-stop scene, and for a
    /// run that does not integrate all powers.
    fn created_energy(&self, _window: &RunMeter<S>) -> Option<S> {
        None
    }

    /// What meters the bending at the clamp over the window; `None` for a scene without a clamped beam's stress.
    fn clamp<'a>(&self, _excitation: HostExcitation<'a, S>) -> Option<Clamp<'a, S>> {
        None
    }

    /// What compares the steps of a run with the limits of the model.
    fn gauge<'a>(&'a self, setting: Setting<'a, S>) -> Gauge<'a, S>;

    /// The numbers that only this kind of scene has.
    fn particular(&self, harvester: &H, found: &Found<'_, S>, end: &H::State) -> Particular;

    fn describe(&self, outputs: &Outputs<'_, S>) -> String;
}

/// What a run found, for the scene to make its own numbers of.
pub(super) struct Found<'a, S: Scalar> {
    /// The measuring window.
    pub(super) window: &'a RunMeter<S>,
    /// Time of the first contact or impact of the whole run.
    pub(super) first_contact: Option<Instant>,
    /// Periods of the base in the window, where it moves in one sine.
    pub(super) periods: Option<f64>,
    /// The bending at the clamp in the window.
    pub(super) clamp: Option<&'a Clamp<'a, S>>,
}
