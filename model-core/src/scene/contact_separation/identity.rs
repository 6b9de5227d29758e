//! The scene interface of contact-separation: start at rest, fingerprint, and the mode as a byte.

use super::force_law::ForceLaw;
use super::{ContactSeparation, Mode, Parts, STATES, Start, Sticking};
use crate::excitation::Excitation;
use crate::hybrid::HybridState;
use crate::integrate::StepControl;
use crate::part::load::Load;
use crate::part::restitution::Restitution;
use crate::scalar::Scalar;
use crate::scene::{ParameterError, Scene};
use crate::snapshot::{Fingerprint, snapshot_variants};

impl<S: Scalar, P: Parts<S>, const POWERS: usize> Scene<S, STATES, POWERS> for ContactSeparation<S, P> {
    type Start = Start<S>;

    fn start<E: Excitation<S>, C: StepControl<S>>(
        &self,
        start: &Start<S>,
        excitation: &E,
        control: &C,
    ) -> Result<HybridState<S, Mode, STATES, POWERS>, ParameterError<S>> {
        self.start(start, excitation, control)
    }

    fn identify(&self, fingerprint: &mut Fingerprint) {
        fingerprint.name("contact-separation");
        // Every other coefficient follows from these.
        fingerprint.numbers(&[
            self.mass,
            self.stiffness,
            self.initial_gap,
            self.damping_per_mass,
            self.dielectric,
            self.permittivity_area,
            self.tribo_charge,
            self.parasitic,
        ]);
        self.load.resistance().identify(fingerprint);
        // A law is identified by its values.
        for charge in [S::ZERO, S::ONE] {
            let circuit = self.circuit(self.initial_gap, charge);
            fingerprint.numbers(&[self.force_law.attraction(&circuit, self.tribo_charge)]);
        }
        self.restitution.identify(fingerprint);
        fingerprint.count(u32::from(P::Sticking::POSSIBLE));
        fingerprint.count(u32::from(self.sticking.relaxes()));
    }
}

snapshot_variants!(Mode { Free, Stick });
