//! The modal equations with a spring for the contact.
//!
//! ```text
//! r_i'' + 2ζω_i r_i' + ω_i² r_i = −γ_i a − l_i F − χ θ_i v       g = Σ l_i r_i − Δ
//! C v' = Σ θ_i r_i' − v / R                                       F = k max(0, g)
//! ```
//!
//! The modes of beam and rod stand in one list: `l` is the shape at the stop for the beam, minus that at
//! the face for the rod, whose `θ` is zero. Equations (1) to (4) and (10) of Mak, McWilliam, Popov and Fox.

use crate::base_motion::{Base, LocalBase};
use crate::scene_file::modes::BumpStopModes;
use crate::scene_file::{BumpStop, BumpStopStart, Coupling, Excitation, Load};

/// A mode of beam or rod, with a modal mass of one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mode {
    /// `ω²` in 1/s².
    pub(super) stiffness: f64,
    /// `2ζω` in 1/s.
    pub(super) damping: f64,
    /// `γ` in √kg.
    pub(super) base: f64,
    /// `l` in 1/√kg.
    pub(super) lever: f64,
    /// `θ` in N/(V √kg).
    pub(super) coupling: f64,
    tip: f64,
}

/// Modal displacements and velocities, and the voltage.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct State {
    pub(super) motion: Vec<[f64; 2]>,
    pub(super) voltage: f64,
}

impl State {
    pub(super) fn zero(modes: usize) -> Self {
        Self { motion: vec![[0.0; 2]; modes], voltage: 0.0 }
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        self.motion.copy_from_slice(&other.motion);
        self.voltage = other.voltage;
    }

    pub(super) fn is_finite(&self) -> bool {
        self.voltage.is_finite() && self.motion.iter().all(|[at, rate]| at.is_finite() && rate.is_finite())
    }
}

pub(super) struct System {
    pub(super) modes: Vec<Mode>,
    beam_modes: usize,
    /// `Δ` in m.
    pub(super) gap: f64,
    /// `k` in N/m: one over the compliance of the modes left out and that of the contact.
    pub(super) stiffness: f64,
    pub(super) capacitance: f64,
    /// `1/R`; 0 for a short circuit, whose voltage is 0.
    pub(super) conductance: f64,
    pub(super) is_short: bool,
    /// `χ`: 1 if the voltage acts back on the beam, else 0.
    pub(super) back_coupling: f64,
}

impl System {
    pub(super) fn new(model: &BumpStop, load: Load) -> Self {
        let from = BumpStopModes::new(&model.parameters, model.stop.as_ref());
        let damping_ratio = model.parameters.damping_ratio;
        let resistance_ohm = load.resistance_ohm();
        let is_short = resistance_ohm == 0.0;
        let mode = |angular_frequency: f64, base, lever, coupling, tip| Mode {
            stiffness: angular_frequency * angular_frequency,
            damping: 2.0 * damping_ratio * angular_frequency,
            base,
            lever,
            coupling,
            tip,
        };
        let beam = from.beam.iter().map(|beam| {
            mode(beam.angular_frequency, beam.participation, beam.at_stop, beam.coupling, beam.at_tip)
        });
        let rod = from.rod.iter().map(|rod| {
            let lever = -rod.at_face;
            mode(rod.angular_frequency, rod.participation, lever, 0.0, 0.0)
        });
        Self {
            modes: beam.chain(rod).collect(),
            beam_modes: from.beam.len(),
            gap: model.stop.map_or(0.0, |stop| stop.gap_m),
            stiffness: model.stop.map_or(0.0, |stop| {
                (from.beam_residual + from.rod_residual + stop.contact_compliance_m_per_n).recip()
            }),
            capacitance: from.capacitance,
            conductance: if is_short { 0.0 } else { resistance_ohm.recip() },
            is_short,
            back_coupling: if model.parameters.coupling == Coupling::TwoWay { 1.0 } else { 0.0 },
        }
    }

    pub(super) fn start(&self, from: &BumpStopStart) -> State {
        let beam = from.modal_displacement.iter().zip(&from.modal_velocity);
        let rod = from.rod_modal_displacement.iter().zip(&from.rod_modal_velocity);
        State {
            motion: beam.chain(rod).map(|(at, rate)| [*at, *rate]).collect(),
            voltage: if self.is_short { 0.0 } else { from.voltage_v },
        }
    }

    /// No less than the highest angular frequency in rad/s, in contact.
    pub(super) fn highest_angular_frequency(&self) -> f64 {
        let free = self.modes.iter().fold(0.0, |highest, mode| f64::max(highest, mode.stiffness));
        let mobility: f64 = self.modes.iter().map(|mode| mode.lever * mode.lever).sum();
        (free + self.stiffness * mobility).sqrt()
    }

    /// Natural frequencies in Hz of the beam and of the rod.
    pub(super) fn natural_frequencies_hz(&self) -> [Vec<f64>; 2] {
        let hertz = |mode: &Mode| mode.stiffness.sqrt() / std::f64::consts::TAU;
        let (beam, rod) = self.modes.split_at(self.beam_modes);
        [beam, rod].map(|modes| modes.iter().map(hertz).collect())
    }

    /// The state with half the sum of its squares the energy in J of motion and charge.
    pub(super) fn scaled(&self, state: &State) -> Vec<f64> {
        let motion = self.modes.iter().zip(&state.motion);
        motion
            .flat_map(|(mode, [at, rate])| [mode.stiffness.sqrt() * at, *rate])
            .chain([self.capacitance.sqrt() * state.voltage])
            .collect()
    }

    /// Sum over the modes of beam and rod of a weight times displacement, and times velocity.
    fn sums(state: &State, weighted: impl Iterator<Item = f64>) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for (weight, [at, rate]) in weighted.zip(&state.motion) {
            sums[0] += weight * at;
            sums[1] += weight * rate;
        }
        sums
    }

    /// Displacement of the tip in m, and its rate.
    pub(super) fn tip(&self, state: &State) -> [f64; 2] {
        Self::sums(state, self.modes.iter().map(|mode| mode.tip))
    }

    /// Displacement in m of the beam at the stop, and its rate.
    pub(super) fn stop_point(&self, state: &State) -> [f64; 2] {
        Self::sums(state, self.modes[..self.beam_modes].iter().map(|mode| mode.lever))
    }

    /// `g` in m: negative while the contact is open.
    pub(super) fn penetration(&self, state: &State) -> f64 {
        let levers: f64 = self.modes.iter().zip(&state.motion).map(|(mode, [at, _])| mode.lever * at).sum();
        levers - self.gap
    }

    /// Contact force in N at a penetration.
    pub(super) fn force(&self, penetration: f64) -> f64 {
        self.stiffness * penetration.max(0.0)
    }

    /// Rate of the voltage in V/s.
    pub(super) fn voltage_rate(&self, state: &State) -> f64 {
        if self.is_short {
            return 0.0;
        }
        let current: f64 =
            self.modes.iter().zip(&state.motion).map(|(mode, [_, rate])| mode.coupling * rate).sum();
        (current - self.conductance * state.voltage) / self.capacitance
    }

    /// Rate of the whole state at a base acceleration in m/s².
    pub(super) fn rate(&self, state: &State, acceleration: f64, rate: &mut State) {
        let force = self.force(self.penetration(state));
        let back = self.back_coupling * state.voltage;
        for ((mode, [at, speed]), rate) in self.modes.iter().zip(&state.motion).zip(&mut rate.motion) {
            let pull = mode.stiffness * at + mode.damping * speed;
            *rate = [*speed, -pull - mode.base * acceleration - mode.lever * force - mode.coupling * back];
        }
        rate.voltage = self.voltage_rate(state);
    }
}

/// Base acceleration at any time, in order of time.
pub(super) struct BaseAcceleration<'a> {
    base: Base<'a>,
    here: LocalBase,
    from: f64,
    to: f64,
}

impl<'a> BaseAcceleration<'a> {
    /// Seconds after which the phase of the sines is set anew from the time, so that it does not drift.
    const STRETCH: f64 = 1.0;

    pub(super) fn new(excitation: &'a Excitation) -> Self {
        let base = Base(excitation);
        Self { base, here: base.pieces_from(0.0), from: 0.0, to: 0.0 }
    }

    /// Acceleration in m/s² at a time in s.
    pub(super) fn at(&mut self, time: f64) -> f64 {
        if !(self.from..self.to).contains(&time) {
            self.here = self.base.pieces_from(time);
            (self.from, self.to) = (time, time + self.here.smooth_for().min(Self::STRETCH));
        }
        self.here.at(time - self.from)
    }
}
