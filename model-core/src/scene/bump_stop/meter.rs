//! Meters of a run by modal steps.

use super::circuit::{Circuit, Memory};
use super::contact_law::{ContactKind, ContactLaw};
use super::observer::{ModalImpact, ModalObserver, ModalSpan};
use super::state::StateOf;
use super::{BumpStop, Parts};
use crate::clock::Instant;
use crate::energy::{Integrals, Peak, PowerMeter};
use crate::integrate::cubic::Cubic;
use crate::part::storage_step::StorageAccount;
use crate::scalar::{CompensatedSum, Scalar};

impl<S, C, const P: usize, const B: usize, const R: usize> ModalObserver<S, B, R, C> for PowerMeter<S, P>
where
    S: Scalar,
    C: Memory,
{
    #[inline(always)]
    fn step(&mut self, span: &ModalSpan<'_, S, B, R, C>) {
        self.add_delivered(span.delivered, span.ticks);
    }
}

/// Everything that a report of a run shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModalMeter<'a, S: Scalar, P: Parts<S>, const B: usize, const R: usize> {
    scene: &'a BumpStop<S, P, B, R>,
    /// Delivered energy, ∫v², ∫v, ∫F.
    integrals: Integrals<S, 4>,
    tip: Peak<S>,
    stop_point: Peak<S>,
    voltage: Peak<S>,
    /// Behind a bridge: lost in the diodes, leaked, drawn.
    losses: [CompensatedSum<S>; 3],
    contacts: u32,
    in_contact: CompensatedSum<S>,
    first_contact: Option<Instant>,
    peak_force: S,
    /// Whether the last step ended in contact.
    touching: bool,
}

/// Places in the integrals.
const DELIVERED: usize = 0;
const SQUARE: usize = 1;
const VOLTAGE: usize = 2;
const FORCE: usize = 3;

impl<'a, S: Scalar, P: Parts<S>, const B: usize, const R: usize> ModalMeter<'a, S, P, B, R> {
    /// A meter at zero, for runs of `scene`.
    #[must_use]
    pub fn new(scene: &'a BumpStop<S, P, B, R>) -> Self {
        Self {
            scene,
            integrals: Integrals::new(),
            tip: Peak::new(),
            stop_point: Peak::new(),
            voltage: Peak::new(),
            losses: [CompensatedSum::ZERO; 3],
            contacts: 0,
            in_contact: CompensatedSum::ZERO,
            first_contact: None,
            peak_force: S::ZERO,
            touching: false,
        }
    }

    /// The same from `state` on: a contact that is then closed is not counted.
    #[must_use]
    pub fn from(scene: &'a BumpStop<S, P, B, R>, state: &StateOf<S, P, B, R>) -> Self {
        Self { touching: state.gap > S::ZERO || state.closed, ..Self::new(scene) }
    }

    /// Energy delivered to the load, in joules.
    #[must_use]
    pub fn delivered_energy(&self) -> S {
        self.integrals.integral(DELIVERED)
    }

    /// Mean power delivered to the load, in watts.
    #[must_use]
    pub fn mean_power(&self) -> S {
        self.integrals.mean(DELIVERED)
    }

    /// Energies behind a bridge; without one, zeros and what the load took.
    #[must_use]
    pub fn storage_account(&self) -> StorageAccount<S> {
        let [diodes, leaked, drawn] = self.losses.map(|sum| sum.value());
        StorageAccount { delivered: self.delivered_energy(), diodes, leaked, drawn }
    }

    /// Root mean square of the terminal voltage, in volts.
    #[must_use]
    pub fn rms_voltage(&self) -> S {
        self.integrals.mean(SQUARE).sqrt()
    }

    /// Mean terminal voltage, in volts.
    #[must_use]
    pub fn mean_voltage(&self) -> S {
        self.integrals.mean(VOLTAGE)
    }

    /// Mean contact force, in newtons; impulses of impacts included.
    #[must_use]
    pub fn mean_force(&self) -> S {
        self.integrals.mean(FORCE)
    }

    /// Largest contact force, in newtons; an impact has none.
    #[must_use]
    pub fn peak_force(&self) -> S {
        self.peak_force
    }

    /// Extremes of the tip's displacement, in metres.
    #[must_use]
    pub fn tip(&self) -> Peak<S> {
        self.tip
    }

    /// Extremes of the beam's displacement at the stop, in metres.
    #[must_use]
    pub fn stop_point(&self) -> Peak<S> {
        self.stop_point
    }

    /// Extremes of the terminal voltage, in volts.
    #[must_use]
    pub fn voltage(&self) -> Peak<S> {
        self.voltage
    }

    /// Number of contacts: intervals with a force, and impacts.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contacts
    }

    /// Part of the time in contact, 0 to 1.
    #[must_use]
    pub fn contact_fraction(&self) -> S {
        let seconds = self.integrals.seconds();
        if seconds > S::ZERO { self.in_contact.value() / seconds } else { S::ZERO }
    }

    /// Time of the first contact that the meter saw.
    #[must_use]
    pub fn first_contact(&self) -> Option<Instant> {
        self.first_contact
    }

    /// The fraction of the step at which the gap closes or opens, by a straight line.
    fn crossing(from: S, to: S) -> S {
        let apart = (to - from).abs();
        if apart > S::ZERO { from.abs() / apart } else { S::ZERO }
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize>
    ModalObserver<S, B, R, <P::Load as Circuit<S>>::State> for ModalMeter<'_, S, P, B, R>
{
    fn step(&mut self, span: &ModalSpan<'_, S, B, R, <P::Load as Circuit<S>>::State>) {
        let step = span.step;
        let energies =
            [span.delivered, span.mean_square_voltage * step, span.mean_voltage * step, span.force * step];
        self.integrals.add(&energies, span.ticks);
        let include = |peak: &mut Peak<S>, [start, end]: [[S; 2]; 2]| {
            peak.include(&Cubic::new(start[0], start[1], end[0], end[1], step));
        };
        include(&mut self.tip, [span.start, span.end].map(|state| self.scene.tip(state)));
        include(&mut self.stop_point, [span.start, span.end].map(|state| self.scene.stop_point(state)));
        let [start, end] = [span.start, span.end].map(|state| self.scene.voltage(state));
        // Behind a bridge a step has its extremes at its ends, or at the corner of a polyline, which is level
        // with the end or below it.
        let mean = if P::Load::SWITCHES { S::from_f64(0.5) * (start + end) } else { span.mean_voltage };
        self.voltage.include(&Cubic::with_mean(start, end, mean));
        if P::Load::SWITCHES {
            let account = P::Load::account(&span.account);
            for (sum, energy) in self.losses.iter_mut().zip([account.diodes, account.leaked, account.drawn]) {
                sum.add(energy);
            }
        }
        if !(span.force > S::ZERO) {
            self.touching = false;
            return;
        }
        let (from, to) = (span.start.gap, span.end.gap);
        self.peak_force = self.peak_force.max(span.force);
        let kind = self.scene.contact.kind();
        if kind == ContactKind::Compliant {
            self.peak_force = self.peak_force.max(self.scene.stiffness * to);
        }
        // Before touch-down and after lift-off the step is open.
        let before = if from < S::ZERO && to > S::ZERO { Self::crossing(from, to) } else { S::ZERO };
        let after = if to < S::ZERO && from > S::ZERO { S::ONE - Self::crossing(from, to) } else { S::ZERO };
        self.in_contact.add(step * (S::ONE - before - after));
        if !self.touching {
            self.contacts = self.contacts.saturating_add(1);
            let ticks = (before * S::from_u32(span.ticks)).to_u32();
            self.first_contact = self.first_contact.or(Some(span.start.clock.after(ticks)));
        }
        self.touching = to > S::ZERO || span.end.closed || kind == ContactKind::Constrained;
    }

    fn impact(&mut self, impact: &ModalImpact<S>) {
        self.contacts = self.contacts.saturating_add(1);
        self.first_contact = self.first_contact.or(Some(impact.at));
        let mut energies = [S::ZERO; 4];
        energies[FORCE] = impact.impulse;
        self.integrals.add(&energies, 0);
        // A contact that this impact closes is this contact.
        self.touching = true;
    }
}
