//! The fingerprint of bump-stop and the snapshot of its state.

use super::choices::Coupling;
use super::circuit::Circuit;
use super::contact_law::{ContactKind, ContactLaw};
use super::{BumpStop, Parts, State};
use crate::scalar::Scalar;
use crate::snapshot::{Fingerprint, Snapshot, snapshot_fields};

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
