//! The scene interface of sliding: start at rest, fingerprint, and the mode as a byte.

use super::force_law::ForceLaw;
use super::{Friction, LateralForce, Mode, Parts, STATES, Sliding, Start, Sticking};
use crate::excitation::Excitation;
use crate::hybrid::HybridState;
use crate::integrate::StepControl;
use crate::part::load::Load;
use crate::scalar::Scalar;
use crate::scene::{ParameterError, Scene};
use crate::snapshot::{Fingerprint, Reader, Snapshot, Writer};

impl<S: Scalar, P: Parts<S>, const POWERS: usize> Scene<S, STATES, POWERS> for Sliding<S, P> {
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
        fingerprint.name("sliding");
        // Every other coefficient follows from these.
        fingerprint.numbers(&[
            self.modal_mass,
            self.base_coupling,
            self.angular_frequency,
            self.damping_per_mass,
            self.weight_per_mass,
            self.diameter,
            self.dielectric,
            self.charge_unit,
            self.surface.tribo_charge,
            self.surface.root_permittivity,
        ]);
        self.load.resistance().identify(fingerprint);
        // A law is identified by its values.
        fingerprint.numbers(&self.force_law.acting_charge(S::ZERO, &self.surface));
        fingerprint.count(u32::from(P::Friction::PRESENT));
        for active in [S::ZERO, S::ONE] {
            let friction = &self.friction;
            fingerprint.numbers(&[friction.static_coefficient(active), friction.kinetic_coefficient(active)]);
        }
        fingerprint.count(u32::from(P::Sticking::POSSIBLE));
        fingerprint.count(u32::from(self.sticking.relaxes()));
        fingerprint.count(u32::from(self.lateral_force.acts()));
    }
}

impl Mode {
    /// Number of the mode in outputs and snapshots.
    pub(super) fn number(self) -> u8 {
        match self {
            Self::Sliding { forward, ahead } => u8::from(forward) + 2 * u8::from(ahead),
            Self::Stick => 4,
        }
    }
}

/// A byte: 0 to 3 in a slide, the sum of 1 for forward and 2 for ahead; 4 in stick.
impl Snapshot for Mode {
    const BYTES: usize = 1;

    fn write(&self, out: &mut Writer<'_>) {
        self.number().write(out);
    }

    fn read(from: &mut Reader<'_>) -> Self {
        match u8::read(from) {
            sliding @ 0..=3 => Self::Sliding { forward: sliding & 1 != 0, ahead: sliding & 2 != 0 },
            number => {
                from.require(number == 4);
                Self::Stick
            }
        }
    }
}
