//! The energy ledger of a run by modal steps.
//!
//! ```text
//! Δ(½ Σ (ṙ² + ω² r²) + ½ Σ (q̇² + Ω² q²) + ½ k g₊² + χ ½ C v²)
//!     = −∫ a (Σ γ ṙ + Σ g q̇) dt − ∫ 2ζ (Σ ω ṙ² + Σ Ω q̇²) dt − χ ∫ v²/R dt − losses in contact
//! ```
//!
//! Behind a bridge `v²/R` is what enters the storage and what the diodes take, and the storage has a ledger of its
//! own,
//!
//! ```text
//! Δ(½ C V²) = ∫ V i dt − ∫ leaked − ∫ drawn
//! ```
//!
//! which a bus, that has no end, has not. The storage is left out of the energy that a residual is compared with:
//! a large one would hide any error.
//!
//! Over a step each mode moves under a force that is linear in time, so its velocity is known in closed
//! form: `ẇ` of the same oscillator, driven by the constant rate of the force. The integrals of the
//! velocity's square (damping) and of its product with the base's acceleration (work) are then
//! quadratic and linear in the state, with coefficients that are made once for each length of step by
//! Gauss's rule. What is left over is what the contact and the circuit did wrong.

use super::circuit::Circuit;
use super::contact_law::ContactKind;
use super::contact_law::ContactLaw;
use super::observer::{ModalImpact, ModalObserver, ModalSpan};
use super::parameters::Coupling;
use super::state::StateOf;
use super::{BumpStop, Parts, State};
use crate::energy::Residual;
use crate::integrate::modal::ModalStep;
use crate::scalar::{CompensatedSum, Scalar};

/// Integrals over a step of the free responses `A` (to a displacement) and `B` (to a velocity).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gramian<S> {
    /// `∫A², ∫AB, ∫B²`.
    squares: [S; 3],
    /// `∫A, ∫B`.
    means: [S; 2],
    /// `∫tA, ∫tB`.
    moments: [S; 2],
}

/// Nodes and weights of Gauss's rule of five points on −1 to 1, those above zero.
const NODES: [f64; 3] = [0.0, 0.538_469_310_105_683_1, 0.906_179_845_938_664];
const WEIGHTS: [f64; 3] = [0.568_888_888_888_888_9, 0.478_628_670_499_366_47, 0.236_926_885_056_189_08];
/// Radians of a mode in one panel of the rule.
const PANEL: f64 = 0.25;
/// Panels at most: beyond, a mode turns so often in a step that its damping is not resolved.
const MOST_PANELS: u32 = 4096;

impl<S: Scalar> Gramian<S> {
    fn new(angular_frequency: S, damping_ratio: S, step: S) -> Self {
        let radians = angular_frequency * step;
        let panels = (radians / S::from_f64(PANEL)).to_u32().saturating_add(1).min(MOST_PANELS);
        let half = S::from_f64(0.5) * step / S::from_u32(panels);
        let mut sums = [CompensatedSum::ZERO; 7];
        for panel in 0..panels {
            let middle = half * S::from_u32(2 * panel + 1);
            for (place, weight) in NODES.into_iter().zip(WEIGHTS) {
                for sign in [-1.0, 1.0] {
                    if place == 0.0 && sign < 0.0 {
                        continue;
                    }
                    let at = middle + half * S::from_f64(place * sign);
                    let modal = ModalStep::new(angular_frequency, damping_ratio, at);
                    let (a, b) =
                        (S::ONE + modal.displacement_by_displacement, modal.displacement_by_velocity);
                    let weight = half * S::from_f64(weight);
                    let terms = [a * a, a * b, b * b, a, b, at * a, at * b];
                    for (sum, term) in sums.iter_mut().zip(terms) {
                        sum.add(weight * term);
                    }
                }
            }
        }
        let [aa, ab, bb, a, b, ta, tb] = sums.map(|sum| sum.value());
        Self { squares: [aa, ab, bb], means: [a, b], moments: [ta, tb] }
    }
}

/// The Gramians of all modes for one length of step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct GramianSet<S, const B: usize, const R: usize> {
    ticks: u32,
    beam: [Gramian<S>; B],
    rod: [Gramian<S>; R],
}

/// What one oscillator did in one step.
struct Oscillator<S> {
    angular_frequency: S,
    damping_ratio: S,
    /// Displacement and velocity at the start.
    start: [S; 2],
    /// Modal force at the start and its rise over the step.
    force: [S; 2],
}

impl<S: Scalar> Oscillator<S> {
    /// `∫ 2ζω ẇ² dt`, and `∫ ẇ dt` and `∫ t ẇ dt`, of the velocity `w`.
    fn integrals(&self, gramian: &Gramian<S>, step: S) -> (S, [S; 2]) {
        let omega = self.angular_frequency;
        let damping = S::from_f64(2.0) * self.damping_ratio * omega;
        let [displacement, velocity] = self.start;
        // w'' + 2ζω w' + ω² w = p' : towards w∞ from w(0) and w'(0).
        let settled = self.force[1] / (step * omega * omega);
        let start = velocity - settled;
        let rate = self.force[0] - damping * velocity - omega * omega * displacement;
        let two = S::from_f64(2.0);
        let [aa, ab, bb] = gramian.squares;
        let mean = gramian.means[0] * start + gramian.means[1] * rate;
        let moment = gramian.moments[0] * start + gramian.moments[1] * rate;
        let square = settled * (settled * step + two * mean)
            + aa * start * start
            + two * ab * start * rate
            + bb * rate * rate;
        let half_square = S::from_f64(0.5) * step * step;
        (damping * square, [settled * step + mean, settled * half_square + moment])
    }
}

/// Draws up the ledger of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModalLedger<'a, S: Scalar, P: Parts<S>, const B: usize, const R: usize> {
    scene: &'a BumpStop<S, P, B, R>,
    /// The Gramians of the first two lengths of step that came, and of the last other one.
    sets: [Option<GramianSet<S, B, R>>; 3],
    base: CompensatedSum<S>,
    base_magnitude: CompensatedSum<S>,
    damped: CompensatedSum<S>,
    /// Electrical energy that the modes brought, and what the load took, lost in diodes included.
    brought: CompensatedSum<S>,
    delivered: CompensatedSum<S>,
    /// What is left over of a storage's gain.
    storage: CompensatedSum<S>,
    lost: CompensatedSum<S>,
    start: [S; 2],
    now: [S; 2],
    peak: S,
}

impl<'a, S: Scalar, P: Parts<S>, const B: usize, const R: usize> ModalLedger<'a, S, P, B, R> {
    /// A ledger that opens at `state`.
    #[must_use]
    pub fn open(scene: &'a BumpStop<S, P, B, R>, state: &StateOf<S, P, B, R>) -> Self {
        let start = scene.stored_energy(state);
        Self {
            scene,
            sets: [None; 3],
            base: CompensatedSum::ZERO,
            base_magnitude: CompensatedSum::ZERO,
            damped: CompensatedSum::ZERO,
            brought: CompensatedSum::ZERO,
            delivered: CompensatedSum::ZERO,
            storage: CompensatedSum::ZERO,
            lost: CompensatedSum::ZERO,
            start,
            now: start,
            peak: start[0] + start[1],
        }
    }

    /// What is left over so far. In the electrical ledger the modes are the source; in the mechanical one
    /// they pay for it where the coupling is two-way.
    #[must_use]
    pub fn residual(&self) -> Residual<S> {
        let brought = self.brought.value();
        let paid = if self.scene.coupling.is_two_way() { brought } else { S::ZERO };
        let income = self.base.value() - self.damped.value() - paid - self.lost.value();
        Residual {
            mechanical: (self.now[0] - self.start[0]) - income,
            electrical: (self.now[1] - self.start[1]) - (brought - self.delivered.value()),
            storage: self.storage.value(),
            scale: self.base_magnitude.value().max(self.peak),
        }
    }

    /// Work of the base so far, in joules.
    #[must_use]
    pub fn base_work(&self) -> S {
        self.base.value()
    }

    /// Energy lost to the damping of beam and rod so far, in joules.
    #[must_use]
    pub fn damped(&self) -> S {
        self.damped.value()
    }

    /// Energy lost in contact so far, in joules; below zero where a contact law has made energy.
    #[must_use]
    pub fn lost_in_contact(&self) -> S {
        self.lost.value()
    }

    /// The Gramians of a length of step, made where they are not at hand.
    fn prepared(&mut self, ticks: u32, step: S) -> GramianSet<S, B, R> {
        if let Some(known) = self.sets.iter().flatten().find(|set| set.ticks == ticks) {
            return *known;
        }
        let scene = self.scene;
        let of = |omega| Gramian::new(omega, scene.damping_ratio, step);
        let made = GramianSet {
            ticks,
            beam: scene.beam.map(|mode| of(mode.angular_frequency)),
            rod: scene.rod.map(|mode| of(mode.angular_frequency)),
        };
        let [first, second, other] = &mut self.sets;
        // A run has two lengths of step, and others only where one is cut.
        let place = if first.is_none() {
            first
        } else if second.is_none() {
            second
        } else {
            other
        };
        *place = Some(made);
        made
    }

    fn look<C>(&mut self, state: &State<S, B, R, C>) {
        self.now = self.scene.stored_energy(state);
        self.peak = self.peak.max(self.now[0] + self.now[1]);
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Stored energy in joules: mechanical (modes and contact), and in the capacitance.
    #[must_use]
    pub fn stored_energy<C>(&self, state: &State<S, B, R, C>) -> [S; 2] {
        let half = S::from_f64(0.5);
        let mut mechanical = self.contact_energy(state);
        let of = |omega: S, [displacement, velocity]: [S; 2]| {
            let scaled = omega * displacement;
            half * (velocity * velocity + scaled * scaled)
        };
        for (mode, coordinate) in self.beam.iter().zip(&state.beam) {
            mechanical += of(mode.angular_frequency, *coordinate);
        }
        for (mode, coordinate) in self.rod.iter().zip(&state.rod) {
            mechanical += of(mode.angular_frequency, *coordinate);
        }
        let voltage = self.voltage(state);
        [mechanical, half * self.capacitance * voltage * voltage]
    }

    /// Energy of the contact's spring; a rigid contact has none.
    fn contact_energy<C>(&self, state: &State<S, B, R, C>) -> S {
        if P::Contact::POSSIBLE && self.contact.kind() == ContactKind::Compliant {
            let pressed = state.gap.max(S::ZERO);
            S::from_f64(0.5) * self.stiffness * pressed * pressed
        } else {
            S::ZERO
        }
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize>
    ModalObserver<S, B, R, <P::Load as Circuit<S>>::State> for ModalLedger<'_, S, P, B, R>
{
    fn step(&mut self, span: &ModalSpan<'_, S, B, R, <P::Load as Circuit<S>>::State>) {
        let gramians = self.prepared(span.ticks, span.step);
        let scene = self.scene;
        let voltage = if scene.coupling.is_two_way() { span.mean_voltage } else { S::ZERO };
        let acceleration = span.start.acceleration;
        let rise = span.end.acceleration - acceleration;
        let (mut worked, mut damped, mut contact) = (S::ZERO, S::ZERO, S::ZERO);
        let damping_ratio = scene.damping_ratio;
        let mut add = |angular_frequency, gramian: &Gramian<S>, start, base: S, constant: S| {
            let force = [constant - base * acceleration, -base * rise];
            let oscillator = Oscillator { angular_frequency, damping_ratio, start, force };
            let (loss, [moved, moment]) = oscillator.integrals(gramian, span.step);
            damped += loss;
            worked -= base * (acceleration * moved + rise * moment / span.step);
        };
        for (((mode, gramian), start), end) in
            scene.beam.iter().zip(&gramians.beam).zip(&span.start.beam).zip(&span.end.beam)
        {
            let constant = -mode.contact * span.force - mode.voltage * voltage;
            add(mode.angular_frequency, gramian, *start, mode.base, constant);
            contact += mode.contact * (end[0] - start[0]);
        }
        for (((mode, gramian), start), end) in
            scene.rod.iter().zip(&gramians.rod).zip(&span.start.rod).zip(&span.end.rod)
        {
            add(mode.angular_frequency, gramian, *start, mode.base, mode.contact * span.force);
            contact -= mode.contact * (end[0] - start[0]);
        }
        self.base.add(worked);
        self.base_magnitude.add(worked.abs());
        self.damped.add(damped);
        self.brought.add(span.mean_voltage * (span.end.strain_charge - span.start.strain_charge));
        self.delivered.add(span.delivered);
        if P::Load::SWITCHES {
            let account = P::Load::account(&span.account);
            self.delivered.add(account.diodes);
            if let Some(gain) = scene.load.gained(&span.start.circuit, &span.end.circuit) {
                self.storage.add(gain - (account.delivered - account.leaked - account.drawn));
            }
        }
        // The force took F Δg from the modes and left it in the spring, where there is one.
        let stored = scene.contact_energy(span.end) - scene.contact_energy(span.start);
        if scene.contact.kind() != ContactKind::Compliant {
            self.lost.add(span.force * contact - stored);
        }
        self.look(span.end);
    }

    fn impact(&mut self, impact: &ModalImpact<S>) {
        self.lost.add(impact.loss);
        self.now[0] -= impact.loss;
    }
}
