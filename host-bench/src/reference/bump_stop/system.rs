//! The harvester as a linear system for each state of contact, the base acceleration made part of it.
//!
//! Equations (1) to (4) and (10) of Mak, McWilliam, Popov and Fox in modal coordinates `r`, `q`, with the
//! back-coupling that conserves energy:
//!
//! ```text
//! r_i'' + 2ζω_i r_i' + ω_i² r_i = −γ_i a − φ_i F − θ_i v
//! q_j'' + 2ζΩ_j q_j' + Ω_j² q_j = −g_j a + ψ_j F
//! C v' = Σ θ_i r_i' − v / R
//! ```
//!
//! The coordinates are scaled so that half their square is energy: `ω r`, `r'`, `Ω q`, `q'`, `√C v`, and
//! `√C_s V_s` of a store. Behind them stand a constant 1, the generators of the base acceleration (sine and cosine
//! of each tone, and a straight line) and that of a constant power. In each state of contact the force is a row
//! times the whole vector, and in each of the circuit so is every current, so the vector obeys `y' = A y` and is
//! propagated exactly.

use nalgebra::DMatrix;

use super::modes::BumpStopModes;
use crate::reference::base::LocalBase;
use crate::reference::store::Store;
use crate::scene_file::{BumpStop, BumpStopStart, Contact, Coupling, Draw, Load};

/// Places of the quantities in the vector.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    beam: usize,
    rod: usize,
    tones: usize,
    has_power: bool,
}

impl Layout {
    /// Scaled displacement of a mode of the beam.
    fn beam(&self, mode: usize) -> usize {
        mode
    }

    /// Velocity of a mode of the beam.
    fn beam_rate(&self, mode: usize) -> usize {
        self.beam + mode
    }

    /// Scaled displacement of a mode of the rod.
    fn rod(&self, mode: usize) -> usize {
        2 * self.beam + mode
    }

    /// Velocity of a mode of the rod.
    fn rod_rate(&self, mode: usize) -> usize {
        2 * self.beam + self.rod + mode
    }

    /// Scaled voltage; all before it is mechanical.
    pub(super) fn voltage(&self) -> usize {
        2 * (self.beam + self.rod)
    }

    /// Scaled voltage of the store.
    pub(super) fn store(&self) -> usize {
        self.voltage() + 1
    }

    /// The constant 1.
    pub(super) fn one(&self) -> usize {
        self.store() + 1
    }

    /// The straight line of the base acceleration and its slope.
    fn line(&self) -> [usize; 2] {
        [self.one() + 1, self.one() + 2]
    }

    /// Sine and cosine of a tone.
    fn tone(&self, tone: usize) -> [usize; 2] {
        [self.one() + 3 + 2 * tone, self.one() + 4 + 2 * tone]
    }

    /// Current in A of a draw of constant power, as a straight line, and its slope.
    pub(super) fn draw(&self) -> [usize; 2] {
        let after = self.one() + 3 + 2 * self.tones;
        [after, after + 1]
    }

    /// Scaled displacement and velocity of each mode, the beam's first, and the scaled voltage.
    pub(super) fn by_mode(&self, vector: &[f64]) -> Vec<f64> {
        let beam = (0..self.beam).map(|mode| [self.beam(mode), self.beam_rate(mode)]);
        let rod = (0..self.rod).map(|mode| [self.rod(mode), self.rod_rate(mode)]);
        beam.chain(rod).flatten().chain([self.voltage()]).map(|place| vector[place]).collect()
    }

    /// Length of the vector.
    pub(super) fn size(&self) -> usize {
        let [draw, _] = self.draw();
        draw + if self.has_power { 2 } else { 0 }
    }
}

/// A linear quantity: its value is this row times the vector.
pub(super) type Row = Vec<f64>;

/// Value of a linear quantity.
pub(super) fn value(row: &[f64], vector: &[f64]) -> f64 {
    // Four sums side by side, for speed.
    let (rows, vectors) = (row.chunks_exact(4), vector.chunks_exact(4));
    let rest: f64 = rows.remainder().iter().zip(vectors.remainder()).map(|(one, other)| one * other).sum();
    let mut sums = [0.0; 4];
    for (row, vector) in rows.zip(vectors) {
        for ((sum, one), other) in sums.iter_mut().zip(row).zip(vector) {
            *sum += one * other;
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Everything about the harvester that does not depend on the state of contact.
#[derive(Debug)]
pub(super) struct System {
    pub(super) modes: BumpStopModes,
    pub(super) layout: Layout,
    /// Without contact, the terminals on a resistor or open behind a bridge that blocks; nothing of a store.
    pub(super) free: DMatrix<f64>,
    /// How a force of 1 N in the contact moves the vector.
    pub(super) push: Row,
    /// Penetration in m: negative while the contact is open. Zero weights without a stop.
    pub(super) gap: Row,
    /// Displacement of the tip in m.
    pub(super) tip: Row,
    /// Displacement in m of the beam at the point of contact.
    pub(super) stop_point: Row,
    /// Displacement in m of the rod's face.
    pub(super) face: Row,
    /// Rate of the penetration in m/s.
    pub(super) gap_rate: Row,
    /// Voltage in V.
    pub(super) voltage: Row,
    /// What stands behind a bridge.
    pub(super) store: Option<Store>,
    /// Voltage of the store in V; zero weights without one.
    pub(super) store_voltage: Row,
    /// Base acceleration in m/s².
    pub(super) base: Row,
    /// `−(Σ γ r' + Σ g q')`: base power over base acceleration, in N·s.
    pub(super) base_lever: Row,
    /// Loss factors `2ζω` of the velocities, zero elsewhere.
    pub(super) damping: Row,
    /// Current into the circuit in A.
    pub(super) current: Row,
    /// `1/R` in 1/Ω; 0 also behind a short circuit, where there is no voltage.
    pub(super) conductance: f64,
    /// Whether the voltage acts on the beam.
    pub(super) two_way: bool,
    /// `Σ φ² + Σ ψ²` in 1/kg: acceleration of the gap over the force.
    pub(super) mobility: f64,
}

impl System {
    pub(super) fn new(model: &BumpStop, load: Load, base: &LocalBase) -> Self {
        let parameters = &model.parameters;
        let modes = BumpStopModes::new(parameters, model.stop.as_ref());
        let tones: Vec<[f64; 3]> = base.sines().collect();
        let store = Store::of(load);
        let has_power = store.is_some_and(|store| matches!(store.draw, Draw::Power { .. }));
        let layout = Layout { beam: modes.beam.len(), rod: modes.rod.len(), tones: tones.len(), has_power };
        let size = layout.size();
        let row = || vec![0.0; size];
        let damping_ratio = parameters.damping_ratio;
        let resistance_ohm = load.resistance_ohm();
        let short = resistance_ohm == 0.0;
        let conductance = if short { 0.0 } else { resistance_ohm.recip() };
        let two_way = parameters.coupling == Coupling::TwoWay;
        let root_capacitance = modes.capacitance.sqrt();

        let mut acceleration = row();
        let [line, slope] = layout.line();
        acceleration[line] = 1.0;
        for tone in 0..layout.tones {
            acceleration[layout.tone(tone)[0]] = 1.0;
        }

        let mut free = DMatrix::zeros(size, size);
        let (mut push, mut gap, mut tip, mut stop_point, mut face) = (row(), row(), row(), row(), row());
        let (mut base_lever, mut damping, mut current, mut voltage) = (row(), row(), row(), row());
        let mut oscillator = |at: usize, rate: usize, angular_frequency: f64, participation: f64| {
            free[(at, rate)] = angular_frequency;
            free[(rate, at)] = -angular_frequency;
            free[(rate, rate)] = -2.0 * damping_ratio * angular_frequency;
            damping[rate] = 2.0 * damping_ratio * angular_frequency;
            base_lever[rate] = -participation;
            for (column, weight) in acceleration.iter().enumerate() {
                free[(rate, column)] -= participation * weight;
            }
        };
        for (index, mode) in modes.beam.iter().enumerate() {
            let (at, rate) = (layout.beam(index), layout.beam_rate(index));
            oscillator(at, rate, mode.angular_frequency, mode.participation);
            tip[at] = mode.at_tip / mode.angular_frequency;
            stop_point[at] = mode.at_stop / mode.angular_frequency;
            gap[at] = stop_point[at];
            push[rate] = -mode.at_stop;
            current[rate] = mode.coupling;
        }
        for (index, mode) in modes.rod.iter().enumerate() {
            let (at, rate) = (layout.rod(index), layout.rod_rate(index));
            oscillator(at, rate, mode.angular_frequency, mode.participation);
            face[at] = mode.at_face / mode.angular_frequency;
            gap[at] = -face[at];
            push[rate] = mode.at_face;
        }
        for (tone, [_, angular_frequency, _]) in tones.iter().enumerate() {
            let [sine, cosine] = layout.tone(tone);
            free[(sine, cosine)] = *angular_frequency;
            free[(cosine, sine)] = -*angular_frequency;
        }
        free[(line, slope)] = 1.0;
        let electric = layout.voltage();
        if !short {
            voltage[electric] = root_capacitance.recip();
            for rate in (0..layout.beam).map(|mode| layout.beam_rate(mode)) {
                free[(electric, rate)] = current[rate] / root_capacitance;
                if two_way {
                    free[(rate, electric)] = -current[rate] / root_capacitance;
                }
            }
            free[(electric, electric)] = -conductance / modes.capacitance;
        }
        let mut store_voltage = row();
        if let Some(store) = &store {
            let is_bus = store.capacitance.is_infinite();
            store_voltage[layout.store()] = if is_bus { 1.0 } else { store.capacitance.sqrt().recip() };
        }
        if has_power {
            let [draw, slope] = layout.draw();
            free[(draw, slope)] = 1.0;
        }
        gap[layout.one()] = model.stop.as_ref().map_or(0.0, |stop| -stop.gap_m);
        let mobility = push.iter().map(|weight| weight * weight).sum();
        Self {
            modes,
            layout,
            push,
            gap_rate: Self::rate(&gap, &free),
            free,
            gap,
            tip,
            stop_point,
            face,
            voltage,
            store,
            store_voltage,
            base: acceleration,
            base_lever,
            damping,
            current,
            conductance,
            two_way,
            mobility,
        }
    }

    /// The vector at the start, without the generators.
    pub(super) fn start(&self, from: &BumpStopStart) -> Vec<f64> {
        let Self { layout, modes, .. } = self;
        let mut vector = vec![0.0; layout.size()];
        for (index, mode) in modes.beam.iter().enumerate() {
            vector[layout.beam(index)] = mode.angular_frequency * from.modal_displacement[index];
            vector[layout.beam_rate(index)] = from.modal_velocity[index];
        }
        for (index, mode) in modes.rod.iter().enumerate() {
            vector[layout.rod(index)] = mode.angular_frequency * from.rod_modal_displacement[index];
            vector[layout.rod_rate(index)] = from.rod_modal_velocity[index];
        }
        let electric = layout.voltage();
        if self.voltage[electric] != 0.0 {
            vector[electric] = from.voltage_v / self.voltage[electric];
        }
        vector[layout.one()] = 1.0;
        if let Some(store) = &self.store {
            // A bridge that finds more than its threshold conducts at once, and nothing holds the charge up.
            let excess = (from.voltage_v.abs() - store.initial - store.drop).max(0.0);
            let rise = excess * modes.capacitance / (modes.capacitance + store.capacitance);
            let voltage = if excess > 0.0 {
                (store.initial + store.drop + rise).copysign(from.voltage_v)
            } else {
                from.voltage_v
            };
            vector[electric] = voltage / self.voltage[electric];
            let place = layout.store();
            vector[place] = (store.initial + rise) / self.store_voltage[place];
        }
        vector
    }

    /// Sets the generator of a constant power to the tangent to `P/V_s`, in a regime in which the voltage of the
    /// store has this row of rates.
    pub(super) fn set_draw(&self, vector: &mut [f64], power: f64, store_rate: &[f64]) {
        let [draw, slope] = self.layout.draw();
        let voltage = value(&self.store_voltage, vector);
        vector[draw] = power / voltage;
        vector[slope] = 0.0;
        vector[slope] = -power / (voltage * voltage) * value(store_rate, vector);
    }

    /// Sets the generators to the base acceleration from its local origin on.
    pub(super) fn set_base(&self, vector: &mut [f64], base: &LocalBase) {
        for (place, entry) in self.layout.line().into_iter().zip(base.line()) {
            vector[place] = entry;
        }
        for (tone, [amplitude, _, phase]) in base.sines().enumerate() {
            let [sine, cosine] = self.layout.tone(tone);
            vector[sine] = amplitude * phase.sin();
            vector[cosine] = amplitude * phase.cos();
        }
    }

    /// Row of the rate of a linear quantity in a system of this matrix.
    pub(super) fn rate(row: &[f64], matrix: &DMatrix<f64>) -> Row {
        matrix.column_iter().map(|column| value(row, column.as_slice())).collect()
    }

    /// Force in N while the contact is closed, as a row: the penetration on the static compliance of the
    /// modes left out (MacNeal's residual flexibility) and what is in series with it, or the force that
    /// keeps the gap from accelerating.
    pub(super) fn closed_force(&self, model: &BumpStop) -> Row {
        let Some(stop) = &model.stop else { return vec![0.0; self.layout.size()] };
        match stop.contact {
            Contact::ResidualFlexibility => {
                let compliance =
                    self.modes.beam_residual + self.modes.rod_residual + stop.contact_compliance_m_per_n;
                self.gap.iter().map(|weight| weight / compliance).collect()
            }
            Contact::Restitution | Contact::DisplacementConstraint => {
                let velocity = Self::rate(&self.gap, &self.free);
                let acceleration = Self::rate(&velocity, &self.free);
                acceleration.iter().map(|weight| weight / self.mobility).collect()
            }
        }
    }

    /// Energy in J of the store.
    pub(super) fn stored(&self, vector: &[f64]) -> f64 {
        self.store.map_or(0.0, |store| store.energy(value(&self.store_voltage, vector)))
    }

    /// Energy in J of beam and rod, and that of the charge.
    pub(super) fn energies(&self, vector: &[f64]) -> [f64; 2] {
        let electric = self.layout.voltage();
        let half_squares = |part: &[f64]| 0.5 * part.iter().map(|entry| entry * entry).sum::<f64>();
        [half_squares(&vector[..electric]), half_squares(&vector[electric..=electric])]
    }

    /// Highest frequency in Hz of the modes, free or closed on a spring of `stiffness` N/m.
    ///
    /// The closed one is the last root of `1 = Σ k b² / (λ − ω²)` over all modes, `b` their shapes at the
    /// contact; it lies within `k Σ b²` above the highest free one.
    pub(super) fn highest_frequency(&self, stiffness: f64) -> f64 {
        let beam = self.modes.beam.iter().map(|mode| (mode.angular_frequency, mode.at_stop));
        let rod = self.modes.rod.iter().map(|mode| (mode.angular_frequency, mode.at_face));
        let modes: Vec<(f64, f64)> = beam.chain(rod).collect();
        let highest = modes.iter().fold(0.0, |highest, (frequency, _)| f64::max(highest, *frequency));
        let (mut below, mut above) = (highest * highest, highest * highest + stiffness * self.mobility);
        for _ in 0..60 {
            let middle = 0.5 * (below + above);
            let sum: f64 = modes
                .iter()
                .map(|(frequency, shape)| stiffness * shape * shape / (middle - frequency * frequency))
                .sum();
            if sum > 1.0 {
                below = middle;
            } else {
                above = middle;
            }
        }
        above.sqrt() / std::f64::consts::TAU
    }
}
