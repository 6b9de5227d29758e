//! What a node that follows an accelerometer needs beside the steps: a fingerprint and the state as bytes.

use super::circuit::Circuit;
use super::contact_law::{ContactKind, ContactLaw};
use super::parameters::Coupling;
use super::{BumpStop, Parts, State};
use crate::scalar::Scalar;
use crate::snapshot::{Fingerprint, Reader, Snapshot, SnapshotError, Writer};

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Takes everything that tells this harvester from another into a fingerprint.
    pub(super) fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("bump-stop");
        fingerprint.count(self.beam.len() as u32);
        fingerprint.count(self.rod.len() as u32);
        for mode in &self.beam {
            fingerprint.numbers(&[mode.angular_frequency, mode.base, mode.contact, mode.tip, mode.voltage]);
        }
        for mode in &self.rod {
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

impl<S: Scalar, const B: usize, const R: usize, C: Snapshot> Snapshot for State<S, B, R, C> {
    const BYTES: usize = u64::BYTES + (2 * (B + R) + 6) * S::BYTES + bool::BYTES + u16::BYTES + C::BYTES;

    fn write(&self, out: &mut Writer<'_>) {
        self.clock.write(out);
        self.beam.write(out);
        self.rod.write(out);
        self.strain_charge.write(out);
        self.moved_charge.write(out);
        self.charge_remainder.write(out);
        self.gap.write(out);
        self.drift.write(out);
        self.acceleration.write(out);
        self.closed.write(out);
        self.short_steps.write(out);
        self.circuit.write(out);
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        Ok(Self {
            clock: Snapshot::read(from)?,
            beam: Snapshot::read(from)?,
            rod: Snapshot::read(from)?,
            strain_charge: Snapshot::read(from)?,
            moved_charge: Snapshot::read(from)?,
            charge_remainder: Snapshot::read(from)?,
            gap: Snapshot::read(from)?,
            drift: Snapshot::read(from)?,
            acceleration: Snapshot::read(from)?,
            closed: Snapshot::read(from)?,
            short_steps: Snapshot::read(from)?,
            circuit: Snapshot::read(from)?,
        })
    }
}
