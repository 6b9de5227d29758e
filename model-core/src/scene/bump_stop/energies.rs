//! Computes the energies of a step: work of the base, damping, contact and circuit.
//!
//! Over a step each mode moves under a force that is linear in time, so its velocity `w` is known in closed form: it
//! obeys the equation of the same oscillator, driven by the constant rate of the force. The integrals of `w²`
//! (damping) and of `w` times the base acceleration (work) are quadratic and linear in the state. Their coefficients
//! are computed once for each step length by Gauss quadrature. Contact and circuit do exactly the work that they store
//! and dissipate, so the energy ledger closes up to rounding:
//!
//! ```text
//! Δ(½ Σ (ṙ² + ω² r²) + ½ Σ (q̇² + Ω² q²) + ½ k g₊² + χ ½ C v²)
//!     = −∫ a (Σ γ ṙ + Σ g q̇) dt − ∫ 2ζ (Σ ω ṙ² + Σ Ω q̇²) dt − χ ∫ v²/R dt − losses in contact
//! ```

use super::choices::{ContactOf, Coupling};
use super::contact_law::{ContactKind, ContactLaw};
use super::state::StateOf;
use super::trial::Trial;
use super::{BumpStop, Parts, State};
use crate::clock::seconds_of_ticks;
use crate::integrate::modal::ModalStep;
use crate::observer::{ALL_POWERS, Contact, PowerIndex, StoredEnergy};
use crate::scalar::{CompensatedSum, Scalar, zip_with};

/// Integrals over a step of the free responses `A` (to a displacement) and `B` (to a velocity), and of the response `s`
/// to a unit force.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gramian<S> {
    /// `∫A², ∫B², ∫s²`.
    squares: [S; 3],
    /// `2 ∫AB, 2 ∫Bs, 2 ∫sA`.
    products: [S; 3],
    /// `∫A, ∫B, ∫s`.
    means: [S; 3],
    /// `∫tA, ∫tB, ∫ts`.
    moments: [S; 3],
}

/// Non-negative nodes on −1 to 1, and weights, of the Gauss rule of five points.
const NODES: [f64; 3] = [0.0, 0.538_469_310_105_683_1, 0.906_179_845_938_664];
const WEIGHTS: [f64; 3] = [0.568_888_888_888_888_9, 0.478_628_670_499_366_47, 0.236_926_885_056_189_08];
/// Phase of a mode in one panel of the rule, in rad.
const PANEL: f64 = 0.25;
/// Most panels: the damping of a mode with more panels per step is not resolved.
const MOST_PANELS: u32 = 4096;

impl<S: Scalar> Gramian<S> {
    fn new(angular_frequency: S, damping_ratio: S, step: S) -> Self {
        let radians = angular_frequency * step;
        let panels = (radians / S::from_f64(PANEL)).to_u32().saturating_add(1).min(MOST_PANELS);
        let half = S::from_f64(0.5) * step / S::from_u32(panels);
        let mut sums = [CompensatedSum::ZERO; 12];
        for panel in 0..panels {
            let middle = half * S::from_u32(2 * panel + 1);
            for (place, weight) in NODES.into_iter().zip(WEIGHTS) {
                for sign in [-1.0, 1.0] {
                    if place == 0.0 && sign < 0.0 {
                        continue;
                    }
                    let at = middle + half * S::from_f64(place * sign);
                    let modal = ModalStep::new(angular_frequency, damping_ratio, at);
                    let a = S::ONE + modal.displacement_by_displacement;
                    let (b, s) = (modal.displacement_by_velocity, modal.response);
                    let weight = half * S::from_f64(weight);
                    let twice = weight + weight;
                    let squares = [weight * a * a, weight * b * b, weight * s * s];
                    let products = [twice * a * b, twice * b * s, twice * s * a];
                    let means = [a, b, s].map(|response| weight * response);
                    let terms = [squares, products, means, means.map(|term| at * term)];
                    for (sum, term) in sums.iter_mut().zip(terms.as_flattened()) {
                        sum.add(*term);
                    }
                }
            }
        }
        let [aa, bb, ss, ab, bs, sa, a, b, s, ta, tb, ts] = sums.map(|sum| sum.value());
        Self { squares: [aa, bb, ss], products: [ab, bs, sa], means: [a, b, s], moments: [ta, tb, ts] }
    }

    /// `∫ 2ζω w² dt`, and `∫ w dt` and `∫ t w dt`, of the velocity `w` of a mode of the angular frequency `omega` from
    /// its displacement and velocity at the start, under a modal force at the start with its rise over the step.
    fn integrals(
        &self,
        [omega, damping_ratio]: [S; 2],
        [displacement, velocity]: [S; 2],
        force: [S; 2],
        step: S,
    ) -> (S, [S; 2]) {
        let damping = S::from_f64(2.0) * damping_ratio * omega;
        // w'' + 2ζω w' + ω² w = p' from w(0) and w'(0): w = A w(0) + B w'(0) + s p'.
        let rate = force[0] - damping * velocity - omega * omega * displacement;
        let by = [velocity, rate, force[1] / step];
        let [w, r, p] = by;
        let sum = |weights: [S; 3], [x, y, z]: [S; 3]| weights[0] * x + weights[1] * y + weights[2] * z;
        let square = sum(self.squares, [w * w, r * r, p * p]) + sum(self.products, [w * r, r * p, p * w]);
        (damping * square, [sum(self.means, by), sum(self.moments, by)])
    }
}

/// The Gramians of all modes for one step length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GramianSet<S, const B: usize, const R: usize> {
    /// Length of the step.
    pub(super) ticks: u32,
    beam: [Gramian<S>; B],
    rod: [Gramian<S>; R],
}

impl<S: Scalar, const B: usize, const R: usize> GramianSet<S, B, R> {
    /// The Gramians of all modes of `scene` for a step of `ticks`.
    pub(super) fn new<P: Parts<S>>(scene: &BumpStop<S, P, B, R>, ticks: u32) -> Self {
        let of = |omega| Gramian::new(omega, scene.damping_ratio, seconds_of_ticks(ticks));
        Self {
            ticks,
            beam: scene.beam.map(|mode| of(mode.angular_frequency)),
            rod: scene.rod.map(|mode| of(mode.angular_frequency)),
        }
    }
}

impl<S: Scalar, P: Parts<S>, const B: usize, const R: usize> BumpStop<S, P, B, R> {
    /// Integrals of all powers over a step of `step` in s, in the order of [`PowerIndex`].
    pub(super) fn energies(
        &self,
        gramians: &GramianSet<S, B, R>,
        [start, end]: [&StateOf<S, P, B, R>; 2],
        trial: &Trial<S>,
        step: S,
    ) -> [S; ALL_POWERS] {
        let [base, damping] = self.works(gramians, start, trial, step);
        let field = trial.mean_voltage * (end.strain_charge - start.strain_charge)
            + trial.voltage_tilt * trial.charge_moment;
        let account = &trial.account;
        let mut energies = [S::ZERO; ALL_POWERS];
        energies[PowerIndex::Load as usize] = trial.delivered;
        energies[PowerIndex::VoltageSquared as usize] = trial.mean_square_voltage * step;
        energies[PowerIndex::Voltage as usize] = trial.mean_voltage * step;
        energies[PowerIndex::CurrentMagnitude as usize] = (end.moved_charge - start.moved_charge).abs();
        energies[PowerIndex::Base as usize] = base;
        energies[PowerIndex::BaseMagnitude as usize] = base.abs();
        energies[PowerIndex::Dissipation as usize] = damping;
        energies[PowerIndex::ElectrostaticWork as usize] =
            if self.coupling.is_two_way() { field } else { S::ZERO };
        energies[PowerIndex::FieldWork as usize] = field;
        energies[PowerIndex::Diodes as usize] = account.diodes;
        energies[PowerIndex::Leakage as usize] = account.leaked;
        energies[PowerIndex::Draw as usize] = account.drawn;
        energies[PowerIndex::ContactForce as usize] = trial.force * step;
        energies
    }

    /// Work in J of the base on all modes, and of all modes on the damping.
    fn works(
        &self,
        gramians: &GramianSet<S, B, R>,
        start: &StateOf<S, P, B, R>,
        trial: &Trial<S>,
        step: S,
    ) -> [S; 2] {
        // At the start, and rise over the step.
        let line = |mean: S, tilt: S| [mean - tilt, tilt + tilt];
        let two_way = self.coupling.is_two_way();
        let voltage = if two_way { line(trial.mean_voltage, trial.voltage_tilt) } else { [S::ZERO; 2] };
        let push = line(trial.force, trial.force_tilt);
        let [acceleration, rise] = line(trial.base[0], trial.base[1]);
        let damping_ratio = self.damping_ratio;
        let (mut of_base, mut of_damping) = (S::ZERO, S::ZERO);
        let mut add = |angular_frequency, gramian: &Gramian<S>, start, base: S, own: [S; 2]| {
            let force = [own[0] - base * acceleration, own[1] - base * rise];
            let (loss, [moved, moment]) =
                gramian.integrals([angular_frequency, damping_ratio], start, force, step);
            of_damping += loss;
            of_base -= base * (acceleration * moved + rise * moment / step);
        };
        for ((mode, gramian), start) in self.beam.iter().zip(&gramians.beam).zip(&start.beam) {
            let own =
                zip_with(push, &voltage, |push, voltage| -mode.contact * push - mode.voltage * *voltage);
            add(mode.angular_frequency, gramian, *start, mode.base, own);
        }
        for ((mode, gramian), start) in self.rod.iter().zip(&gramians.rod).zip(&start.rod) {
            add(mode.angular_frequency, gramian, *start, mode.base, push.map(|push| mode.contact * push));
        }
        [of_base, of_damping]
    }

    /// The contact within a step.
    #[inline]
    pub(super) fn contact_within(
        &self,
        [start, end]: [&StateOf<S, P, B, R>; 2],
        trial: &Trial<S>,
    ) -> Contact<S> {
        if !ContactOf::<S, P>::POSSIBLE || !(trial.force > S::ZERO) {
            return Contact::NONE;
        }
        let (from, to) = (start.gap, end.gap);
        // The contact is open before touch-down and after lift-off.
        let begins = if from < S::ZERO && to > S::ZERO { crossing(from, to) } else { S::ZERO };
        let ends = if to < S::ZERO && from > S::ZERO { crossing(from, to) } else { S::ONE };
        let compliant = self.contact.kind() == ContactKind::Compliant;
        let at_end = if compliant { self.stiffness * to } else { S::ZERO };
        Contact {
            force: trial.force,
            peak_force: trial.force.max(at_end),
            begins,
            ends,
            loss: if compliant { S::ZERO } else { self.contact_loss([start, end], trial.force) },
        }
    }

    /// Energy in J that a rigid contact takes from the modes in a step.
    fn contact_loss(&self, [start, end]: [&StateOf<S, P, B, R>; 2], force: S) -> S {
        let mut closed = S::ZERO;
        for ((mode, start), end) in self.beam.iter().zip(&start.beam).zip(&end.beam) {
            closed += mode.contact * (end[0] - start[0]);
        }
        for ((mode, start), end) in self.rod.iter().zip(&start.rod).zip(&end.rod) {
            closed -= mode.contact * (end[0] - start[0]);
        }
        force * closed
    }

    /// Stored energy: mechanical (modes and contact), and electrical (capacitance).
    #[inline]
    pub(super) fn stored_energy<C>(&self, state: &State<S, B, R, C>) -> StoredEnergy<S> {
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
        StoredEnergy { mechanical, electrical: half * self.capacitance * voltage * voltage }
    }

    /// Energy of the contact spring in J; 0 for a rigid contact.
    fn contact_energy<C>(&self, state: &State<S, B, R, C>) -> S {
        if ContactOf::<S, P>::POSSIBLE && self.contact.kind() == ContactKind::Compliant {
            let pressed = state.gap.max(S::ZERO);
            S::from_f64(0.5) * self.stiffness * pressed * pressed
        } else {
            S::ZERO
        }
    }
}

/// The fraction of a step at which a gap coordinate reaches zero, by linear interpolation.
fn crossing<S: Scalar>(from: S, to: S) -> S {
    let apart = (to - from).abs();
    if apart > S::ZERO { from.abs() / apart } else { S::ZERO }
}
