//! The modes of the hybrid automaton, the start of a run, the fingerprint, and the mode as a byte.

use super::force_law::ForceLaw;
use super::{CHARGE, Friction, LateralForce, Parts, STATES, Sliding, Sticking};
use crate::bounds::{Bounds, ParameterError, bounded};
use crate::clock::Instant;
use crate::excitation::Excitation;
use crate::hybrid::HybridState;
use crate::integrate::{Point, StepControl};
use crate::part::load::Load;
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::snapshot::{Fingerprint, Reader, Snapshot, Writer};

/// The modes of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// The slider slides.
    Sliding {
        /// Whether the velocity is positive; friction acts against it.
        forward: bool,
        /// Whether the displacement is positive: the side of the overlap's corner.
        ahead: bool,
    },
    /// The slider sticks by friction.
    Stick,
}

impl Mode {
    /// The sliding mode at `displacement`; at the corner itself, on the side of the motion.
    #[inline]
    pub(super) fn sliding<S: Scalar>(forward: bool, displacement: S) -> Self {
        let ahead = if displacement == S::ZERO { forward } else { displacement > S::ZERO };
        Self::Sliding { forward, ahead }
    }

    /// The side of the overlap's corner: in a slide that of the mode, since a step may end slightly beyond the corner.
    #[inline]
    pub(super) fn is_ahead<S: Scalar>(self, displacement: S) -> bool {
        match self {
            Self::Sliding { ahead, .. } => ahead,
            Self::Stick => displacement >= S::ZERO,
        }
    }
}

/// Initial values; a `None` is at rest at the centre, electrically relaxed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Start<S> {
    /// Displacement of the tip in m, less than `2r` in magnitude; by default 0.
    pub displacement: Option<S>,
    /// Velocity of the tip relative to the base in m/s, at most 10³ in magnitude; by default 0.
    pub velocity: Option<S>,
    /// Transferred charge `q` in C, at most 1 in magnitude; by default the charge at zero voltage.
    pub charge: Option<S>,
}

bounded! { Start<S>:
    "velocity" = velocity: -1e3, 1e3;
    "charge" = charge: -1.0, 1.0;
}

impl<S: Scalar, P: Parts<S>> Sliding<S, P> {
    /// The state of this harvester at time zero.
    ///
    /// With zero speed the slider sticks if static friction suffices.
    ///
    /// # Errors
    /// A displacement at which slider and active patch are separate, or another value outside its bounds.
    pub fn start<E: Excitation<S>, C: StepControl<S>, const POWERS: usize>(
        &self,
        start: &Start<S>,
        excitation: &E,
        control: &C,
    ) -> Result<HybridState<S, Mode, STATES, POWERS>, ParameterError<S>> {
        start.check_numbers()?;
        let displacement = start.displacement.unwrap_or(S::ZERO);
        let velocity = start.velocity.unwrap_or(S::ZERO);
        // The largest number below 2r.
        let highest = self.diameter * (S::ONE - S::EPSILON);
        Bounds { lowest: -highest, highest }.check("displacement", displacement)?;
        let charge = match start.charge {
            None => self.relaxed_charge(displacement),
            Some(coulombs) => coulombs / self.charge_unit,
        };
        let state = [displacement, velocity, charge];
        let acceleration = excitation.acceleration(Instant::START);
        let mode = if velocity == S::ZERO {
            self.mode_from_rest(&state, acceleration)
        } else {
            Mode::sliding(velocity > S::ZERO, displacement)
        };
        let mut start_state = HybridState::start(self, mode, state, excitation, control);
        if start.charge.is_none() {
            // The voltage is exactly zero. Computed as a difference it would be a rounding error, which a small
            // resistance turns into a current.
            let mut derivative = start_state.point.derivative;
            derivative[CHARGE] = S::ZERO;
            let flow = crate::hybrid::Automaton::<S, STATES, POWERS>::flow(self, mode);
            start_state.point = Point::with_derivative(&flow, state, derivative, acceleration);
        }
        Ok(if mode == Mode::Stick { start_state } else { start_state.disarmed() })
    }
}

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
