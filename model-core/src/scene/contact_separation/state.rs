//! The modes of the hybrid automaton, the start of a run, the fingerprint, and the mode as a byte.

use super::force_law::ForceLaw;
use super::{CHARGE, ContactSeparation, Parts, STATES, Sticking};
use crate::bounds::{ParameterError, bounded};
use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::hybrid::HybridState;
use crate::integrate::{Point, StepControl};
use crate::part::load::Load;
use crate::part::restitution::Restitution;
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::snapshot::{Fingerprint, snapshot_variants};

/// The modes of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// The mass moves freely above the dielectric.
    Free,
    /// The mass sticks to the dielectric: gap and velocity are zero.
    Stick,
}

/// Initial values; a `None` is at rest at the initial gap, electrically relaxed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Start<S> {
    /// Gap in m, 0 to 1; by default the initial gap `d0`.
    pub gap: Option<S>,
    /// Velocity in m/s, at most 10³ in magnitude, positive: opening; by default 0.
    pub velocity: Option<S>,
    /// Transferred charge `q` in C, at most 1 in magnitude; by default the charge at zero voltage.
    pub charge: Option<S>,
}

bounded! { Start<S>:
    "gap" = gap: 0.0, 1.0;
    "velocity" = velocity: -1e3, 1e3;
    "charge" = charge: -1.0, 1.0;
}

impl<S: Scalar, P: Parts<S>> ContactSeparation<S, P> {
    /// The state of this harvester at time zero.
    ///
    /// At contact with zero speed, the mass sticks if the contact force is positive.
    ///
    /// # Errors
    /// A gap below zero, or another value outside its bounds.
    pub fn start<E: Excitation<S>, C: StepControl<S>, const POWERS: usize>(
        &self,
        start: &Start<S>,
        excitation: &E,
        control: &C,
    ) -> Result<HybridState<S, Mode, STATES, POWERS>, ParameterError<S>> {
        start.check_numbers()?;
        let gap = start.gap.unwrap_or(self.initial_gap);
        let velocity = start.velocity.unwrap_or(S::ZERO);
        let charge = match start.charge {
            None => self.relaxed_charge(gap),
            Some(coulombs) => {
                // Q = q − C_p V with V at the charge q.
                let transferred = coulombs / self.charge_unit;
                let voltage = self.tribo_charge * gap - transferred * (gap + self.dielectric);
                transferred - self.parasitic * voltage
            }
        };
        let acceleration = excitation.acceleration(Instant::START);
        let at_contact = gap == S::ZERO && velocity == S::ZERO;
        let sticks = P::Sticking::POSSIBLE
            && at_contact
            && self.contact_force_per_mass(charge, acceleration) > S::ZERO;
        let mode = if sticks { Mode::Stick } else { Mode::Free };
        let mut state = HybridState::start(self, mode, [gap, velocity, charge], excitation, control);
        if start.charge.is_none() {
            // The voltage is exactly zero. Computed as a difference it would be a rounding error, which a small
            // resistance turns into a current.
            state.point.derivative[CHARGE] = S::ZERO;
            let Point { state: at, derivative, .. } = state.point;
            let flow = crate::hybrid::Automaton::<S, STATES, POWERS>::flow(self, mode);
            state.point = Point::with_derivative(&flow, at, derivative, acceleration);
        }
        Ok(if at_contact && !sticks { state.disarmed() } else { state })
    }
}

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
