//! What changes while a bump-stop harvester runs, and where it starts.

use super::choices::ContactOf;
use super::circuit::Circuit;
use super::contact_law::ContactLaw;
use super::{BumpStop, Parts};
use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::part::bounds::{Bounds, ParameterError};
use crate::scalar::Scalar;

/// The state: a plain value that can be copied, saved, compared and restored, and resumes with the
/// same bits.
///
/// `C` is what the load remembers: nothing if it is a resistance, a [`crate::part::storage_step::StorageState`]
/// if it is a bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<S, const B: usize, const R: usize, C = ()> {
    /// Simulated time.
    pub clock: Instant,
    /// Displacement in √kg·m and velocity in √kg·m/s of each beam mode.
    pub beam: [[S; 2]; B],
    /// The same of each rod mode.
    pub rod: [[S; 2]; R],
    /// Charge in C that strain has brought to the electrodes, `Σ θ r`.
    pub(super) strain_charge: S,
    /// Charge in C that has left them through the load.
    pub(super) moved_charge: S,
    /// What rounding took from it.
    pub(super) charge_remainder: S,
    /// Gap coordinate `g` in m: above zero in contact.
    pub(super) gap: S,
    /// How much further than at `Δ` the rod's face is taken to stand, in m, since an impact.
    pub(super) drift: S,
    /// Base acceleration at `clock`.
    pub(super) acceleration: S,
    /// Whether an impact has closed the contact for a while.
    pub(super) closed: bool,
    /// Short steps still to take before a long one is tried again.
    pub(super) short_steps: u16,
    /// What the load remembers.
    pub circuit: C,
}

/// The state of a harvester made of the parts `P`.
pub type StateOf<S, P, const B: usize, const R: usize> =
    State<S, B, R, <<P as Parts<S>>::Load as Circuit<S>>::State>;

impl<S: Scalar, const B: usize, const R: usize, C> State<S, B, R, C> {
    /// The gap coordinate `g = y(X_c) − z(L_r) − Δ` in m: below zero where the gap is open.
    #[must_use]
    pub fn gap(&self) -> S {
        self.gap
    }
}

/// Initial values; at rest, without voltage, by default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start<S, const B: usize, const R: usize> {
    /// Displacement in √kg·m and velocity in √kg·m/s of each beam mode.
    pub beam: [[S; 2]; B],
    /// The same of each rod mode.
    pub rod: [[S; 2]; R],
    /// Voltage in V; across a short circuit there is none.
    pub voltage: S,
}

impl<S: Scalar, const B: usize, const R: usize> Default for Start<S, B, R> {
    fn default() -> Self {
        Self { beam: [[S::ZERO; 2]; B], rod: [[S::ZERO; 2]; R], voltage: S::ZERO }
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// The state of this harvester at time zero.
    ///
    /// # Errors
    /// A start in penetration, or a value that is out of bounds.
    pub fn start<E: Excitation<S>>(
        &self,
        start: &Start<S, B, R>,
        excitation: &E,
    ) -> Result<StateOf<S, P, B, R>, ParameterError<S>> {
        for [displacement, velocity] in start.beam.iter().chain(&start.rod) {
            Bounds::new(-1e3, 1e3).check("modal displacement", *displacement)?;
            Bounds::new(-1e6, 1e6).check("modal velocity", *velocity)?;
        }
        Bounds::new(-1e6, 1e6).check("voltage", start.voltage)?;
        let mut state = State {
            clock: Instant::START,
            beam: start.beam,
            rod: start.rod,
            strain_charge: S::ZERO,
            moved_charge: S::ZERO,
            charge_remainder: S::ZERO,
            gap: S::ZERO,
            drift: S::ZERO,
            acceleration: excitation.acceleration(Instant::START),
            closed: false,
            short_steps: 0,
            circuit: self.load.start(),
        };
        for (mode, [displacement, _]) in self.beam.iter().zip(&start.beam) {
            state.strain_charge += mode.voltage * *displacement;
        }
        let voltage = if self.load.is_short() { S::ZERO } else { start.voltage };
        state.moved_charge = state.strain_charge - self.capacitance * voltage;
        if ContactOf::<S, P>::POSSIBLE {
            state.gap = self.stop_point(&state)[0] - self.rod_tip(&state)[0] - self.gap;
            Bounds { lowest: -S::INFINITY, highest: S::ZERO }.check("penetration at the start", state.gap)?;
        }
        Ok(state)
    }
}
