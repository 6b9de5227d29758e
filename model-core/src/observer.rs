//! Observes every run: accepted steps, events, and the outputs at their ends, alike for all harvesters.
//!
//! A harvester fills one [`AcceptedStep`] for each accepted step and one [`Event`] for each jump. Meters, the energy ledger and the
//! estimator are [`Observer`]s of these and independent of the scene. What an observer declares that it does not read is not computed.

use crate::clock::Instant;
use crate::scalar::Scalar;

/// Index of a power in the list that is integrated along with a step: the first entry alone, which a sensor node needs, or all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PowerIndex {
    /// Power delivered to the load in W; behind a rectifier, power into the storage.
    Load,
    /// Square of the terminal voltage in V².
    VoltageSquared,
    /// Terminal voltage in V.
    Voltage,
    /// Magnitude of the load current in A.
    CurrentMagnitude,
    /// Power of the moving base in W; positive into the harvester.
    Base,
    /// Magnitude of the power of the base in W.
    BaseMagnitude,
    /// Power lost to damping and friction in W.
    Dissipation,
    /// Power in W that the motion loses to the electrostatic or piezoelectric force of the model.
    ElectrostaticWork,
    /// Power in W that the electric field gains from the motion: [`PowerIndex::ElectrostaticWork`] if the force law is derived from the
    /// field. With an inferred force law, or one-way coupling, the difference is energy that the model creates.
    FieldWork,
    /// Power lost in the diodes of a rectifier in W.
    Diodes,
    /// Power that leaks from the storage in W.
    Leakage,
    /// Power that the node draws from the storage in W.
    Draw,
    /// Contact force in N.
    ContactForce,
}

/// Number of entries of [`PowerIndex`]; it grows with the list.
pub const ALL_POWERS: usize = 13;

/// The first `P` of all powers. The compiler drops the computation of the others.
#[inline]
pub(crate) fn first_powers<S: Scalar, const P: usize>(all: &[S; ALL_POWERS]) -> [S; P] {
    core::array::from_fn(|i| all.get(i).copied().unwrap_or(S::ZERO))
}

/// A quantity and its rate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion<S> {
    /// The quantity.
    pub value: S,
    /// Its time derivative.
    pub rate: S,
}

/// Energy stored in a harvester, in J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StoredEnergy<S> {
    /// Kinetic and elastic energy, the spring of a contact included.
    pub mechanical: S,
    /// Energy of the electric field and of the capacitances.
    pub electrical: S,
}

impl<S: Scalar> StoredEnergy<S> {
    /// Mechanical and electrical energy together, in J.
    #[must_use]
    pub fn total(&self) -> S {
        self.mechanical + self.electrical
    }
}

/// The storage behind a rectifier at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct StorageOutput<S> {
    /// Voltage in V.
    pub voltage: S,
    /// Rounding error of the voltage in V: the voltage is `voltage + remainder`.
    pub remainder: S,
    /// Capacitance in F; infinite for a DC bus, which has no energy balance.
    pub capacitance: S,
    /// Magnitude of the terminal voltage in V at which the bridge conducts, and above which it is not.
    pub threshold: S,
    /// Whether the draw of the node is connected.
    pub connected: bool,
}

impl<S: Scalar> StorageOutput<S> {
    /// Stored energy in J; 0 for a DC bus, which has no energy balance.
    #[must_use]
    pub fn energy(&self) -> S {
        let half = S::from_f64(0.5) * self.capacitance;
        if half.is_finite() { half * self.voltage * self.voltage } else { S::ZERO }
    }

    /// Energy in J that the storage gained since `earlier`, `C (V² − V₀²)/2`; `None` for a DC bus.
    #[must_use]
    pub fn gained_since(&self, earlier: &Self) -> Option<S> {
        let rise = (self.voltage - earlier.voltage) + (self.remainder - earlier.remainder);
        let half = S::from_f64(0.5) * self.capacitance;
        half.is_finite().then(|| half * rise * (self.voltage + earlier.voltage))
    }
}

/// The outputs of a harvester at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Outputs<'a, S> {
    /// Coordinates in m and their rates in m/s. The first is the gap of contact-separation, the displacement
    /// of sliding, or the tip displacement of bump-stop. Bump-stop has two more: the beam at the stop, and
    /// the face of the rod. Absent coordinates are zero.
    pub motions: [Motion<S>; 3],
    /// Charge in C that has left the harvester, that on a parasitic capacitance included, and its rate in A.
    pub charge: Motion<S>,
    /// Terminal voltage in V.
    pub voltage: S,
    /// Stored energy, without that of a storage behind a rectifier.
    pub stored: StoredEnergy<S>,
    /// The storage behind a rectifier; `None` without one.
    pub storage: Option<StorageOutput<S>>,
    /// Penetration of the contact of bump-stop in m: above zero in contact, minus the gap in flight.
    pub penetration: S,
    /// Whether the moving part sticks.
    pub stick: bool,
    /// Whether a contact of bump-stop is closed.
    pub in_contact: bool,
    /// Number of the mode, as stored in the snapshot of the state.
    pub mode: u8,
    /// The state variables of the scene; for bump-stop, displacement and velocity of each beam mode in turn.
    pub state: &'a [S],
}

impl<'a, S: Scalar> Outputs<'a, S> {
    /// Zeros, with the state variables `state`.
    #[must_use]
    #[inline]
    pub fn of_state(state: &'a [S]) -> Self {
        let zero = Motion { value: S::ZERO, rate: S::ZERO };
        Self {
            motions: [zero; 3],
            charge: zero,
            voltage: S::ZERO,
            stored: StoredEnergy { mechanical: S::ZERO, electrical: S::ZERO },
            storage: None,
            penetration: S::ZERO,
            stick: false,
            in_contact: false,
            mode: 0,
            state,
        }
    }

    /// The same outputs with other state variables.
    #[inline]
    pub(crate) fn with_state<'b>(&self, state: &'b [S]) -> Outputs<'b, S> {
        let Self { motions, charge, voltage, stored, storage, penetration, stick, in_contact, mode, .. } =
            *self;
        Outputs { motions, charge, voltage, stored, storage, penetration, stick, in_contact, mode, state }
    }

    /// The first coordinate, of which the extremes are reported.
    #[must_use]
    pub fn coordinate(&self) -> Motion<S> {
        let [first, ..] = self.motions;
        first
    }
}

/// The contact of bump-stop within one step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Contact<S> {
    /// Contact force in N, constant over the step; 0 without contact.
    pub force: S,
    /// Largest contact force within the step in N.
    pub peak_force: S,
    /// Fraction of the step at which contact begins, 0 to 1.
    pub begins: S,
    /// Fraction of the step at which contact ends, 0 to 1.
    pub ends: S,
    /// Energy in J that the contact lost; negative if a contact law creates energy.
    pub loss: S,
}

impl<S: Scalar> Contact<S> {
    /// No contact in the step.
    pub(crate) const NONE: Self =
        Self { force: S::ZERO, peak_force: S::ZERO, begins: S::ZERO, ends: S::ZERO, loss: S::ZERO };
}

/// One accepted step.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct AcceptedStep<'a, S> {
    /// Time at the start of the step.
    pub from: Instant,
    /// Length in ticks.
    pub ticks: u32,
    /// Length in s.
    pub step: S,
    /// Outputs at the start.
    pub start: Outputs<'a, S>,
    /// Outputs at the end, in the mode of the step.
    pub end: Outputs<'a, S>,
    /// Integral of each power over the step, in the order of [`PowerIndex`]; the first alone, or all.
    pub energies: &'a [S],
    /// Mean terminal voltage in V, for the parabola that interpolates the voltage.
    pub mean_voltage: S,
    /// Contact within the step.
    pub contact: Contact<S>,
    /// Estimated local error of the delivered energy in J: the embedded formula's value less the delivered
    /// energy; 0 for a method without an estimate.
    pub energy_error: S,
    /// Estimated local error of the state, relative, in the error norm of the scene; 0 without an estimate.
    pub state_error: S,
}

impl<S: Scalar> AcceptedStep<'_, S> {
    /// Time at the end of the step.
    #[must_use]
    pub fn until(&self) -> Instant {
        self.from.after(self.ticks)
    }

    /// Integral of one power over the step; 0 if it was not integrated.
    #[must_use]
    #[inline]
    pub fn energy(&self, power: PowerIndex) -> S {
        self.energies.get(power as usize).copied().unwrap_or(S::ZERO)
    }
}

/// One event: an impact, a stick, a release, a switch of the bridge or of the draw.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Event<'a, S> {
    /// Time of the event.
    pub at: Instant,
    /// Number of the guard that fell through zero.
    pub guard: usize,
    /// Impact speed in m/s; `None` for an event other than an impact.
    pub impact_speed: Option<S>,
    /// Outputs before the event.
    pub before: Outputs<'a, S>,
    /// Outputs after the event.
    pub after: Outputs<'a, S>,
    /// Energy in J that the contact lost.
    pub loss: S,
    /// Part of each integral that the event transfers instantaneously; 0 for most events.
    pub energies: &'a [S],
}

/// Receives every accepted step and every event of a run, in order of time.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not observe runs in `{S}`",
    note = "pass `&mut ()` to observe nothing, a meter of the same scalar type, or a tuple of two `&mut` observers"
)]
pub trait Observer<S: Scalar> {
    /// Whether [`Observer::step`] reads [`AcceptedStep::start`], [`AcceptedStep::end`], [`AcceptedStep::mean_voltage`] or
    /// [`AcceptedStep::contact`]. If `false`, these are not computed and must not be read. Events always have their outputs.
    const READS_OUTPUTS: bool = true;
    /// Whether [`Observer::step`] reads more than the first of [`AcceptedStep::energies`]. If `false`, a bump-stop has no others.
    const READS_POWERS: bool = true;

    /// Receives an accepted step.
    fn step(&mut self, step: &AcceptedStep<'_, S>);

    /// Receives an event.
    #[inline]
    fn event(&mut self, _event: &Event<'_, S>) {}
}

/// The observer that ignores everything.
impl<S: Scalar> Observer<S> for () {
    const READS_OUTPUTS: bool = false;
    const READS_POWERS: bool = false;

    #[inline]
    fn step(&mut self, _step: &AcceptedStep<'_, S>) {}
}

/// An observer, or none.
impl<S: Scalar, A: Observer<S>> Observer<S> for Option<&mut A> {
    const READS_OUTPUTS: bool = A::READS_OUTPUTS;
    const READS_POWERS: bool = A::READS_POWERS;

    #[inline]
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        if let Some(observer) = self {
            observer.step(step);
        }
    }

    #[inline]
    fn event(&mut self, event: &Event<'_, S>) {
        if let Some(observer) = self {
            observer.event(event);
        }
    }
}

/// Two observers of the same run.
impl<S: Scalar, A: Observer<S>, B: Observer<S>> Observer<S> for (&mut A, &mut B) {
    const READS_OUTPUTS: bool = A::READS_OUTPUTS || B::READS_OUTPUTS;
    const READS_POWERS: bool = A::READS_POWERS || B::READS_POWERS;

    #[inline]
    fn step(&mut self, step: &AcceptedStep<'_, S>) {
        self.0.step(step);
        self.1.step(step);
    }

    #[inline]
    fn event(&mut self, event: &Event<'_, S>) {
        self.0.event(event);
        self.1.event(event);
    }
}
