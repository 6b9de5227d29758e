//! The state of a bump-stop harvester, its start and snapshot, and the fingerprint of the harvester.

use super::choices::{ContactOf, Coupling};
use super::circuit::Circuit;
use super::contact_law::{ContactKind, ContactLaw};
use super::{BumpStop, Parts};
use crate::bounds::{Bounds, ParameterError};
use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::scalar::Scalar;
use crate::snapshot::{Fingerprint, Snapshot, snapshot_fields};

/// The complete state of a simulation. A copy, or a state restored from a snapshot, resumes with the same bits.
///
/// `C` is the state of the load: empty for a resistance, [`crate::part::storage_step::StorageState`] for a bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<S, const B: usize, const R: usize, C = ()> {
    /// Simulated time.
    pub clock: Instant,
    /// Displacement in √kg·m and velocity in √kg·m/s of each beam mode.
    pub beam: [[S; 2]; B],
    /// Displacement in √kg·m and velocity in √kg·m/s of each rod mode.
    pub rod: [[S; 2]; R],
    /// Charge in C that strain has moved to the electrodes, `Σ θ r`.
    pub(super) strain_charge: S,
    /// Charge in C that has left the electrodes through the load.
    pub(super) moved_charge: S,
    /// The part of `moved_charge` that rounding removed.
    pub(super) charge_remainder: S,
    /// Gap coordinate `g` in m: positive in contact.
    pub(super) gap: S,
    /// Increase of `Δ` in m since an impact, for the rounding of its time.
    pub(super) drift: S,
    /// Base acceleration at `clock` in m/s².
    pub(super) acceleration: S,
    /// Whether a slow impact has closed the contact.
    pub(super) closed: bool,
    /// The state of the load.
    pub circuit: C,
}

/// The state of a harvester with the components `P`.
pub type StateOf<S, P, const B: usize, const R: usize> =
    State<S, B, R, <<P as Parts<S>>::Load as Circuit<S>>::State>;

impl<S: Scalar, const B: usize, const R: usize, C> State<S, B, R, C> {
    /// The gap coordinate `g = y(X_c) − z(L_r) − Δ` in m: negative while the gap is open.
    #[must_use]
    pub fn gap(&self) -> S {
        self.gap
    }
}

/// Initial values; by default at rest with zero voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start<S, const B: usize, const R: usize> {
    /// Displacement in √kg·m and velocity in √kg·m/s of each beam mode.
    pub beam: [[S; 2]; B],
    /// Displacement in √kg·m and velocity in √kg·m/s of each rod mode.
    pub rod: [[S; 2]; R],
    /// Voltage in V; ignored for a short circuit.
    pub voltage: S,
}

impl<S: Scalar, const B: usize, const R: usize> Default for Start<S, B, R> {
    fn default() -> Self {
        Self { beam: [[S::ZERO; 2]; B], rod: [[S::ZERO; 2]; R], voltage: S::ZERO }
    }
}

impl<S, const B: usize, const R: usize> Start<S, B, R> {
    /// Name, as in [`ParameterError::field`], and bounds of a displacement, of a velocity and of the voltage.
    pub const BOUNDS: &'static [(&'static str, Bounds<f64>); 3] = &[
        ("modal displacement", Bounds { lowest: -1e3, highest: 1e3 }),
        ("modal velocity", Bounds { lowest: -1e6, highest: 1e6 }),
        ("voltage", Bounds { lowest: -1e6, highest: 1e6 }),
    ];
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// The state of this harvester at time zero.
    ///
    /// # Errors
    /// A start in penetration, or a value outside its bounds.
    pub fn start<E: Excitation<S>>(
        &self,
        start: &Start<S, B, R>,
        excitation: &E,
    ) -> Result<StateOf<S, P, B, R>, ParameterError<S>> {
        let [displacement_bounds, velocity_bounds, voltage_bounds] = *Start::<S, B, R>::BOUNDS;
        let refuse = |(name, bounds), value| Bounds::<S>::of(bounds).check(name, value);
        for [displacement, velocity] in start.beam.iter().chain(&start.rod) {
            refuse(displacement_bounds, *displacement)?;
            refuse(velocity_bounds, *velocity)?;
        }
        refuse(voltage_bounds, start.voltage)?;
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
            circuit: self.load.start(),
        };
        for (mode, [displacement, _]) in self.beam.iter().zip(&start.beam) {
            state.strain_charge += mode.voltage * *displacement;
        }
        let voltage = if self.load.is_short() { S::ZERO } else { start.voltage };
        state.moved_charge = state.strain_charge - self.capacitance * voltage;
        if ContactOf::<S, P>::POSSIBLE {
            state.gap = self.stop_point(&state)[0] - self.rod_tip(&state)[0] - self.gap;
            let highest =
                if matches!(self.contact.kind(), ContactKind::None) { S::INFINITY } else { S::ZERO };
            Bounds { lowest: -S::INFINITY, highest }.check("penetration at the start", state.gap)?;
        }
        Ok(state)
    }

    /// `state` at other coordinates, with its clock, its circuit and its memory of contact: for a search of periodic
    /// motions. `None` if the state would be in penetration, which only a compliant contact can have, or no stop.
    ///
    /// `beam` and `rod` are as in [`State`], `moved_charge` is the charge in C that has left the electrodes through the
    /// load (ignored for a short circuit), `acceleration` the base acceleration in m/s² at the clock.
    #[must_use]
    pub fn moved(
        &self,
        state: &StateOf<S, P, B, R>,
        beam: [[S; 2]; B],
        rod: [[S; 2]; R],
        moved_charge: S,
        acceleration: S,
    ) -> Option<StateOf<S, P, B, R>> {
        let mut moved = State { beam, rod, acceleration, charge_remainder: S::ZERO, ..*state };
        moved.strain_charge = S::ZERO;
        for (mode, [displacement, _]) in self.beam.iter().zip(&beam) {
            moved.strain_charge += mode.voltage * *displacement;
        }
        moved.moved_charge = if self.load.is_short() { moved.strain_charge } else { moved_charge };
        if ContactOf::<S, P>::POSSIBLE {
            let [[stop, _], [face, _]] = [self.stop_point(&moved), self.rod_tip(&moved)];
            moved.gap = stop - face - self.gap - state.drift;
        }
        let is_compliant = matches!(self.contact.kind(), ContactKind::Compliant | ContactKind::None);
        // `!(gap > 0)` would take not-a-number for an open gap.
        (moved.gap <= S::ZERO || is_compliant && moved.gap.is_finite()).then_some(moved)
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Includes all coefficients of this harvester in a fingerprint.
    pub(super) fn identify(&self, fingerprint: &mut Fingerprint) {
        self.identify_first([B, R], fingerprint);
    }

    /// Includes all coefficients of a harvester with so many modes of beam and rod, which are the first of this one.
    pub fn identify_first(&self, [beam, rod]: [usize; 2], fingerprint: &mut Fingerprint) {
        fingerprint.name("bump-stop");
        fingerprint.count(beam as u32);
        fingerprint.count(rod as u32);
        for mode in self.beam.iter().take(beam) {
            fingerprint.numbers(&[mode.angular_frequency, mode.base, mode.contact, mode.tip, mode.voltage]);
        }
        for mode in self.rod.iter().take(rod) {
            fingerprint.numbers(&[mode.angular_frequency, mode.base, mode.contact]);
        }
        fingerprint.numbers(&[self.damping_ratio, self.capacitance, self.gap, self.stiffness]);
        self.load.identify(fingerprint);
        fingerprint.count(u32::from(self.coupling.is_two_way()));
        match self.contact.kind() {
            ContactKind::None => fingerprint.count(0),
            ContactKind::Compliant => fingerprint.count(1),
            ContactKind::Constrained => fingerprint.count(2),
            ContactKind::Impulsive { restitution } => fingerprint.numbers(&[restitution]),
        }
    }
}

snapshot_fields!(impl [S: Scalar, const B: usize, const R: usize, C: Snapshot] State<S, B, R, C> {
    clock, beam, rod, strain_charge, moved_charge, charge_remainder, gap, drift, acceleration, closed, circuit,
});
